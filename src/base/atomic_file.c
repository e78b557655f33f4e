/* SPDX-License-Identifier: MIT */
#include "base/atomic_file.h"

#include "base/text.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static cml_status fail_write(const char *path, const char *reason, struct cml_error *err)
{
    return cml_fail(err, CML_E_IO, "%s: cannot be written (%s)", path, reason);
}

/* The name under which the file is to stand: that of a link's target. */
static cml_status follow_links(const char *path, char **target, struct cml_error *err)
{
    struct stat about;
    *target = NULL;
    if (lstat(path, &about) != 0 || !S_ISLNK(about.st_mode)) return cml_text_copy(path, target, err);
    *target = realpath(path, NULL);
    return *target ? CML_OK : fail_write(path, "a link to nothing", err);
}

bool cml_file_is_device(const char *path)
{
    return strcmp(path, "/dev/null") == 0 || strcmp(path, "/dev/stdout") == 0;
}

static cml_status check_target(const char *path, struct cml_error *err)
{
    struct stat about;
    const bool found = stat(path, &about) == 0;
    if (!found && errno == ENAMETOOLONG)
        return fail_write(path, strerror(errno), err); /* its temporary is cut */
    if (!found || S_ISREG(about.st_mode)) return CML_OK;
    return fail_write(path, S_ISDIR(about.st_mode) ? "a directory" : "no regular file", err);
}

#define MOST_TRIES 1000 /* names left behind by killed processes that had this one's number */

/* "DIRECTORY/NAME.PID-N.tmp"; long names are cut, so that theirs is not too long. Returns its length. */
static int temporary_name(const char *path, int n, char *name, size_t size)
{
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path;
    return snprintf(name, size, "%.*s%.200s.%ld-%d.tmp", (int)(base - path), path, base, (long)getpid(), n);
}

/* A file that did not exist before: of two processes only one gets it, and a link that somebody has put there
 * is not followed. */
static int open_new(const char *path, char *name, size_t size)
{
    int file = -1;
    for (int n = 0; file < 0 && n < MOST_TRIES; n++) {
        temporary_name(path, n, name, size);
        file = open(name, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
        if (file < 0 && errno != EEXIST) return -1;
    }
    return file;
}

static cml_status create_temporary(struct cml_file *file, struct cml_error *err)
{
    const size_t size = strlen(file->path) + 32;
    char *name = malloc(size);
    if (!name) return cml_fail_memory(err, (double)size, "a name");
    const int descriptor = open_new(file->path, name, size);
    if (descriptor < 0) {
        const int reason = errno;
        free(name);
        return fail_write(file->path, strerror(reason), err);
    }
    file->temporary = name;
    file->stream = fdopen(descriptor, "wb");
    if (file->stream) return CML_OK;
    close(descriptor);
    return fail_write(file->path, strerror(ENOMEM), err);
}

static cml_status create(const char *path, struct cml_file *file, struct cml_error *err)
{
    if (cml_file_is_device(path)) {
        CML_TRY(cml_text_copy(path, &file->path, err));
        file->stream = fopen(path, "wb");
        return file->stream ? CML_OK : fail_write(path, strerror(errno), err);
    }
    CML_TRY(follow_links(path, &file->path, err));
    CML_TRY(check_target(file->path, err));
    return create_temporary(file, err);
}

cml_status cml_file_create(const char *path, struct cml_file *file, struct cml_error *err)
{
    *file = (struct cml_file){0};
    const cml_status status = create(path, file, err);
    if (status != CML_OK) cml_file_abort(file);
    return status;
}

/* Why an earlier write failed: the next one fails for the same reason. EIO where it does not. */
static int reason_of_error(FILE *stream)
{
    clearerr(stream);
    errno = EIO;
    return fputc('\n', stream) == EOF || fflush(stream) != 0 ? errno : EIO;
}

static bool sync_deferred; /* set and read by the thread that writes files */

void cml_file_defer_sync(bool deferred)
{
    sync_deferred = deferred;
}

/* Of all file systems, as nobody has noted on which of them the files are. */
void cml_file_sync_deferred(void)
{
    if (sync_deferred) sync();
}

/* All of it on the disk, or the reason why not; a device need not know what that means. 0: done. */
static int finish_stream(struct cml_file *file)
{
    FILE *stream = file->stream;
    file->stream = NULL;
    errno = EIO;
    const bool synced = fflush(stream) == 0 && !ferror(stream) &&
                        (!file->temporary || sync_deferred || fsync(fileno(stream)) == 0);
    const int reason = synced ? 0 : (ferror(stream) ? reason_of_error(stream) : errno);
    return fclose(stream) != 0 && reason == 0 ? errno : reason;
}

/* The new file takes the old one's place, which may be kept. 0: done. */
static int take_place(struct cml_file *file)
{
    if (!file->temporary) return 0;
    if (file->keep && rename(file->path, file->keep) != 0 && errno != ENOENT) return errno;
    if (rename(file->temporary, file->path) != 0) return errno;
    file->temporary[0] = '\0';
    return 0;
}

cml_status cml_file_commit(struct cml_file *file, struct cml_error *err)
{
    int reason = finish_stream(file);
    if (reason == 0) reason = take_place(file);
    cml_status status = CML_OK;
    if (reason != 0) status = fail_write(file->path, strerror(reason), err);
    cml_file_abort(file);
    return status;
}

void cml_file_abort(struct cml_file *file)
{
    if (file->stream) fclose(file->stream);
    if (file->temporary && file->temporary[0]) remove(file->temporary);
    free(file->path);
    free(file->temporary);
    *file = (struct cml_file){0};
}
