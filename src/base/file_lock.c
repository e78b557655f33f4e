/* Takes and releases lock files. SPDX-License-Identifier: MIT */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* makes fcntl.h declare F_OFD_SETLK: a lock that, unlike POSIX's own, does not end when \
                       another descriptor of the file is closed */
#endif
#include "base/file_lock.h"

#include "base/text.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* True if the file system has no locks. 524 is ENOTSUPP, which only the kernel defines; some NFS servers
 * return it. */
static bool knows_no_locks(int reason)
{
    return reason == ENOLCK || reason == ENOSYS || reason == EINVAL || reason == EOPNOTSUPP || reason == 524;
}

/* Locks the whole file. Returns 0 or errno; EAGAIN if another process holds the lock. */
static int lock_file(int file)
{
    struct flock all = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
    if (fcntl(file, F_OFD_SETLK, &all) == 0) return 0;
    return errno == EACCES ? EAGAIN : errno;
}

/* True if the path still names the locked file. The process that held the lock before removes the file, so
 * the path may name another file or none. */
static bool still_stands(int file, const char *path)
{
    struct stat mine, there;
    return fstat(file, &mine) == 0 && stat(path, &there) == 0 && mine.st_dev == there.st_dev &&
           mine.st_ino == there.st_ino;
}

/* Closes the file, if it is open, and reports why the lock cannot be taken. Returns CML_E_IO. */
static cml_status refuse(const char *path, int file, const char *reason, struct cml_error *err)
{
    if (file >= 0) close(file);
    return cml_fail(err, CML_E_IO, "%s: %s", path, reason);
}

/* Opens and locks the file at `path`, creating it. Sets *file to its descriptor, or to -1 where the file
 * system has no locks. */
static cml_status open_locked(const char *path, int *file, struct cml_error *err)
{
    struct stat about;
    for (;;) {
        *file = open(path, O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
        if (*file < 0) return refuse(path, -1, strerror(errno), err);
        if (fstat(*file, &about) != 0 || !S_ISREG(about.st_mode) || about.st_size > 0)
            return refuse(path, *file,
                          "is no lock of this program (expected an empty file or none; move this file away)",
                          err);
        const int reason = lock_file(*file);
        if (reason == EAGAIN)
            return refuse(path, *file,
                          "locked by another process, which writes the same files (expected another name or "
                          "folder, or that process to end first)",
                          err);
        if (reason == 0 && still_stands(*file, path)) return CML_OK;
        close(*file);
        *file = -1;
        if (knows_no_locks(reason)) return CML_OK;
        if (reason != 0) return refuse(path, -1, strerror(reason), err);
    }
}

cml_status cml_file_lock_take(const char *path, struct cml_file_lock *lock, struct cml_error *err)
{
    *lock = (struct cml_file_lock){.file = -1};
    CML_TRY(cml_text_copy(path, &lock->path, err));
    const cml_status status = open_locked(path, &lock->file, err);
    if (status == CML_OK) return CML_OK;
    free(lock->path);
    *lock = (struct cml_file_lock){0};
    return status;
}

void cml_file_lock_release(struct cml_file_lock *lock)
{
    if (!lock->path) return;
    unlink(lock->path); /* remove the file before unlocking it: another process that opens the path next then
                           makes a new file */
    if (lock->file >= 0) close(lock->file);
    free(lock->path);
    *lock = (struct cml_file_lock){0};
}
