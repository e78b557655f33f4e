/* Writes files under a temporary name and renames them when they are complete. SPDX-License-Identifier:
 * MIT */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* declares fopencookie */
#endif
#include "base/atomic_file.h"

#include "base/array.h"
#include "base/text.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#define OTHER_BYTES (-1) /* a reason of failure beside the values of errno */

/* Returns the text of a reason of failure: errno or OTHER_BYTES. */
static const char *text_of(int reason)
{
    return reason == OTHER_BYTES ? "what stands there is not what was written" : strerror(reason);
}

static cml_status fail_write(const char *path, const char *reason, struct cml_error *err)
{
    return cml_fail(err, CML_E_IO, "%s: cannot be written (%s)", path, reason);
}

cml_status cml_file_check_link(const char *path, struct cml_error *err)
{
    struct stat about;
    const bool foreign =
        lstat(path, &about) == 0 && S_ISLNK(about.st_mode) && about.st_uid != geteuid() && about.st_uid != 0;
    return foreign ? fail_write(path, "a link of another user", err) : CML_OK;
}

/* Sets *target to the path of the file to write: the path itself, or the target of the symbolic link that
 * stands there. */
static cml_status follow_links(const char *path, char **target, struct cml_error *err)
{
    struct stat about;
    *target = NULL;
    CML_TRY(cml_file_check_link(path, err));
    if (lstat(path, &about) != 0 || !S_ISLNK(about.st_mode)) return cml_text_copy(path, target, err);
    *target = realpath(path, NULL);
    return *target ? CML_OK : fail_write(path, "a link to nothing", err);
}

bool cml_file_is_device(const char *path)
{
    return strcmp(path, "/dev/null") == 0 || strcmp(path, "/dev/stdout") == 0;
}

/* Makes one folder, unless it exists already. Its parent must exist. */
static cml_status make_one(const char *path, struct cml_error *err)
{
    struct stat about;
    if (mkdir(path, 0777) == 0 || (stat(path, &about) == 0 && S_ISDIR(about.st_mode))) return CML_OK;
    return cml_fail(err, CML_E_IO, "%.400s: cannot be made (%s; expected a folder)", path, strerror(errno));
}

cml_status cml_folder_make(const char *path, struct cml_error *err)
{
    struct stat about;
    CML_FREED char *part = NULL;
    if (stat(path, &about) == 0 && S_ISDIR(about.st_mode)) return CML_OK;
    CML_TRY(cml_text_copy(path, &part, err));
    for (char *slash = part; (slash = strchr(slash + 1, '/'));) {
        *slash = '\0';
        CML_TRY(make_one(part, err));
        *slash = '/';
    }
    return make_one(part, err);
}

/* Refuses a path that names a directory, a device or a pipe, or that is too long. */
static cml_status check_target(const char *path, struct cml_error *err)
{
    struct stat about;
    const bool found = stat(path, &about) == 0;
    /* A name that is too long is refused here: the temporary name is cut and would not show the error. */
    if (!found && errno == ENAMETOOLONG) return fail_write(path, strerror(errno), err);
    if (!found || S_ISREG(about.st_mode)) return CML_OK;
    return fail_write(path, S_ISDIR(about.st_mode) ? "a directory" : "no regular file", err);
}

#define MOST_TRIES 1000 /* temporary names of killed processes that had this process's number */

/* Writes the temporary file's name "DIRECTORY/NAME.PID-N.tmp" and returns its length. NAME is cut at 200
 * bytes so that the name is not too long. */
static int temporary_name(const char *path, int n, char *name, size_t size)
{
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path;
    return snprintf(name, size, "%.*s%.200s.%ld-%d.tmp", (int)(base - path), path, base, (long)getpid(), n);
}

/* Creates a temporary file that did not exist before and returns its descriptor, or -1. Only one of two
 * processes gets the file, and O_NOFOLLOW ignores a link that somebody has put there. */
static int open_new(const char *path, mode_t mode, char *name, size_t size)
{
    int file = -1;
    for (int n = 0; file < 0 && n < MOST_TRIES; n++) {
        temporary_name(path, n, name, size);
        file = open(name, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
        if (file < 0 && errno != EEXIST) return -1;
    }
    return file;
}

/* Writes `size` bytes to the temporary file, for a stream of fopencookie, and updates the checksum. Returns
 * `size`, or 0 after a failure, whose reason file->reason keeps: nothing is written then any more, so that
 * no later success hides the failure. */
static ssize_t write_all(void *context, const char *data, size_t size)
{
    struct cml_file *file = context;
    for (size_t done = 0; done < size && file->reason == 0;) {
        const ssize_t wrote = write(file->descriptor, data + done, size - done);
        if (wrote <= 0)
            file->reason = wrote < 0 ? errno : EIO;
        else
            done += (size_t)wrote;
    }
    if (file->reason != 0) return 0;
    file->sum = crc32_z(file->sum, (const Bytef *)data, size);
    file->size += size;
    return (ssize_t)size;
}

static int close_descriptor(void *context)
{
    return close(((struct cml_file *)context)->descriptor);
}

/* Opens the stream that writes to file->descriptor and keeps size, CRC and errors. */
static cml_status open_stream(struct cml_file *file, struct cml_error *err)
{
    const cookie_io_functions_t calls = {.write = write_all, .close = close_descriptor};
    file->stream = fopencookie(file, "w", calls);
    if (file->stream) return CML_OK;
    close(file->descriptor);
    return fail_write(file->path, strerror(ENOMEM), err);
}

/* Creates the temporary file with the mode of the file that it will replace, whatever the umask. A failed
 * fchmod is ignored, because some file systems have no modes. */
static cml_status create_temporary(struct cml_file *file, struct cml_error *err)
{
    const size_t size = strlen(file->path) + 32;
    char *name = malloc(size);
    if (!name) return cml_fail_memory(err, (double)size, "a name");
    struct stat old;
    const bool replaces = stat(file->path, &old) == 0;
    const mode_t mode = replaces ? old.st_mode & 0777 : 0666;
    file->descriptor = open_new(file->path, mode, name, size);
    if (file->descriptor < 0) {
        const int reason = errno;
        free(name);
        return fail_write(file->path, strerror(reason), err);
    }
    if (replaces) (void)!fchmod(file->descriptor, mode);
    file->temporary = name;
    return open_stream(file, err);
}

/* Opens a file for cml_file_create. After a failure cml_file_abort frees what the file owns. */
static cml_status create(const char *path, struct cml_file *file, struct cml_error *err)
{
    if (cml_file_is_device(path)) {
        CML_TRY(cml_text_copy(path, &file->path, err));
        file->descriptor = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
        return file->descriptor >= 0 ? open_stream(file, err) : fail_write(path, strerror(errno), err);
    }
    CML_TRY(follow_links(path, &file->path, err));
    CML_TRY(check_target(file->path, err));
    return create_temporary(file, err);
}

cml_status cml_file_create(const char *path, struct cml_file *file, struct cml_error *err)
{
    *file = (struct cml_file){.sum = crc32(0, NULL, 0)};
    const cml_status status = create(path, file, err);
    if (status != CML_OK) cml_file_abort(file);
    return status;
}

/* ---- one writer at a time ---- */

/* Returns the length of NAME if the entry is a temporary file's name, "NAME.PID-N.tmp"; else 0. */
static size_t name_length(const char *entry)
{
    const size_t length = strlen(entry), end = length > 4 ? length - 4 : 0;
    size_t begin = end;
    if (end == 0 || strcmp(entry + end, ".tmp") != 0) return 0;
    while (begin > 0 && strchr("0123456789-", entry[begin - 1])) begin--;
    return begin > 1 && begin < end && entry[begin - 1] == '.' ? begin - 1 : 0;
}

void cml_file_remove_leftovers(const char *path, size_t folder,
                               bool (*is_ours)(const void *context, const char *name, const char *left),
                               const void *context)
{
    char place[PATH_MAX] = ".", name[PATH_MAX + NAME_MAX], left[PATH_MAX + NAME_MAX];
    if (folder > 0) snprintf(place, sizeof place, "%.*s", (int)folder, path);
    DIR *directory = opendir(place);
    if (!directory) return;
    for (struct dirent *entry; (entry = readdir(directory));) {
        const size_t length = name_length(entry->d_name);
        snprintf(name, sizeof name, "%.*s%.*s", (int)folder, path, (int)length, entry->d_name);
        snprintf(left, sizeof left, "%.*s%s", (int)folder, path, entry->d_name);
        if (length > 0 && is_ours(context, name, left)) remove(left);
    }
    closedir(directory);
}

/* True if the temporary file `left`, which was made for the file `name`, is a leftover: it has the path of
 * the file being written, but is not that file's own temporary file. */
static bool is_leftover(const void *context, const char *name, const char *left)
{
    const struct cml_file *file = context;
    return strcmp(name, file->path) == 0 && strcmp(left, file->temporary) != 0;
}

cml_status cml_file_create_alone(const char *path, struct cml_file *file, struct cml_error *err)
{
    char name[PATH_MAX];
    CML_TRY(cml_file_create(path, file, err));
    if (!file->temporary) return CML_OK;
    snprintf(name, sizeof name, "%s.lock", file->path);
    const cml_status status = cml_file_lock_take(name, &file->lock, err);
    const char *slash = strrchr(file->path, '/');
    if (status == CML_OK)
        cml_file_remove_leftovers(file->path, slash ? (size_t)(slash - file->path) + 1 : 0, is_leftover,
                                  file);
    else
        cml_file_abort(file);
    return status;
}

/* ---- safe from a crash of the machine ---- */

/* Files of this thread that are committed but not yet synced. */
static _Thread_local struct {
    bool on;
    size_t count;
    char **path; /* [count] final names of the files */
} deferred;

void cml_file_defer_sync(bool on)
{
    deferred.on = on;
}

/* Adds a file to those that are forced to disk later, all together. Returns false if memory runs out. */
static bool defer(const char *path)
{
    struct cml_error ignored;
    if (cml_array_grow(&deferred.path, deferred.count, sizeof *deferred.path, "names", &ignored) != CML_OK)
        return false;
    deferred.path[deferred.count] = strdup(path);
    return deferred.path[deferred.count] && ++deferred.count;
}

/* Syncs a file, or a directory with the names in it. Returns 0 on success, also if the file is gone or may
 * not be opened, or if its file system has no fsync; else errno. */
static int sync_path(const char *path)
{
    const int file = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) return errno == ENOENT || errno == EACCES ? 0 : errno;
    const int reason = fsync(file) == 0 || errno == EINVAL ? 0 : errno;
    close(file);
    return reason;
}

/* Syncs the folder of a path, so that the names in it last. Returns 0 or errno. */
static int sync_folder(const char *path)
{
    char folder[PATH_MAX];
    const char *slash = strrchr(path, '/');
    snprintf(folder, sizeof folder, "%.*s.", slash ? (int)(slash - path + 1) : 0, path);
    return sync_path(folder);
}

/* Syncs a file and removes it on failure, since its content on the disk is then unknown. Returns 0 or
 * errno. */
static int sync_file(const char *path)
{
    const int reason = sync_path(path);
    if (reason != 0) remove(path);
    return reason;
}

/* True if two paths name files in the same folder. */
static bool same_folder(const char *path, const char *other)
{
    const char *slash = strrchr(path, '/'), *others = strrchr(other, '/');
    if (!slash || !others) return slash == others;
    return slash - path == others - other && strncmp(path, other, (size_t)(slash - path)) == 0;
}

/* Keeps the reason of the first failure: sets *status and *err unless an earlier failure has set them. */
static void keep_reason(const char *path, int reason, cml_status *status, struct cml_error *err)
{
    if (reason != 0 && *status == CML_OK) *status = fail_write(path, strerror(reason), err);
}

/* Neighbours in the list usually lie in one folder, which is then synced once. */
cml_status cml_file_sync_deferred(struct cml_error *err)
{
    cml_status status = CML_OK;
    char **path = deferred.path;
    for (size_t i = 0; i < deferred.count; i++) keep_reason(path[i], sync_file(path[i]), &status, err);
    for (size_t i = 0; i < deferred.count; i++)
        if (i == 0 || !same_folder(path[i], path[i - 1]))
            keep_reason(path[i], sync_folder(path[i]), &status, err);
    for (size_t i = 0; i < deferred.count; i++) free(path[i]);
    free(path);
    deferred.path = NULL;
    deferred.count = 0;
    return status;
}

/* ---- commit ---- */

/* Reads the file again and compares size and CRC-32 with those of the bytes written. Returns 0, errno or
 * OTHER_BYTES. */
static int compare_with_written(const struct cml_file *file)
{
    unsigned char block[16384];
    unsigned long sum = crc32(0, NULL, 0);
    uint64_t size = 0;
    ssize_t got;
    while ((got = pread(file->descriptor, block, sizeof block, (off_t)size)) > 0) {
        sum = crc32_z(sum, block, (size_t)got);
        size += (uint64_t)got;
    }
    if (got < 0) return errno;
    return size == file->size && sum == file->sum ? 0 : OTHER_BYTES;
}

/* Brings all written bytes to the disk, closes the stream and compares the file with what was written.
 * Devices are neither synced nor compared. Returns 0, or the reason of the failure. */
static int finish_stream(struct cml_file *file)
{
    FILE *stream = file->stream;
    file->stream = NULL;
    const bool flushed = fflush(stream) == 0 && !ferror(stream);
    int reason = file->reason != 0 || flushed ? file->reason : EIO;
    if (reason == 0 && file->temporary && !deferred.on && fsync(file->descriptor) != 0) reason = errno;
    if (reason == 0 && file->temporary) reason = compare_with_written(file);
    return fclose(stream) != 0 && reason == 0 ? errno : reason;
}

/* Gives the old file a second name, so that the old file keeps its own name until the new file takes it.
 * Without hard links the old file is renamed, and for a moment the path names no file. Returns 0 on success
 * or if there is no old file, else errno. */
static int keep_old(const struct cml_file *file)
{
    if (access(file->path, F_OK) != 0) return 0;
    remove(file->keep);
    return link(file->path, file->keep) == 0 || rename(file->path, file->keep) == 0 ? 0 : errno;
}

/* Puts the new file in the old file's place; the old file stays under file->keep if that is set. Returns 0 or
 * errno. */
static int take_place(struct cml_file *file)
{
    const int reason = file->temporary && file->keep ? keep_old(file) : 0;
    if (!file->temporary || reason != 0) return reason;
    if (rename(file->temporary, file->path) != 0) return errno;
    file->temporary[0] = '\0';
    if (!deferred.on) return sync_folder(file->path);
    return defer(file->path) ? 0 : sync_file(file->path);
}

cml_status cml_file_commit(struct cml_file *file, struct cml_error *err)
{
    int reason = finish_stream(file);
    if (reason == 0) reason = take_place(file);
    cml_status status = CML_OK;
    if (reason != 0) status = fail_write(file->path, text_of(reason), err);
    cml_file_abort(file);
    return status;
}

void cml_file_abort(struct cml_file *file)
{
    if (file->stream) fclose(file->stream);
    if (file->temporary && file->temporary[0]) remove(file->temporary);
    cml_file_lock_release(&file->lock);
    free(file->path);
    free(file->temporary);
    *file = (struct cml_file){0};
}
