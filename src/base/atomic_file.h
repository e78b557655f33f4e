/* Files that are never seen half written, by whoever writes them at the same time.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/file_lock.h"
#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

/* A file that appears under its name only when it is complete: written beside it under a name of its own
 * ("NAME.PID-N.tmp", created by this process and nobody else), synced, read again and compared with what was
 * written, then renamed; then its folder is synced, so that the name lasts. What stood under the name stays
 * until the rename; the new file has its mode. The file must stay where it is in memory, as its stream knows
 * it. Where the name is a symbolic link, its target is replaced and the link stays, unless
 * cml_file_check_link refuses it. /dev/null and /dev/stdout are written to directly. */
struct cml_file {
    FILE *stream;      /* write here, without seeking; check nothing, cml_file_commit sees every error */
    char *path;        /* final name, links followed */
    char *temporary;   /* name until the commit; NULL: written to directly */
    const char *keep;  /* borrowed; the commit keeps under this name what stood under PATH; NULL: it goes */
    int descriptor;    /* the stream's, which has none of its own: for fchmod */
    int reason;        /* errno of the first write that failed; 0: none */
    uint64_t size;     /* bytes written to the stream */
    unsigned long sum; /* their CRC-32 */
    struct cml_file_lock lock; /* held until the commit; zeroed: none */
};

/* /dev/null and /dev/stdout: a rename would put a file in their place. */
bool cml_file_is_device(const char *path);

/* CML_E_IO: the name is a symbolic link that neither this user nor root has made. In a folder that others may
 * write to, such a link would have a user replace any file of his own. */
CML_NODISCARD cml_status cml_file_check_link(const char *path, struct cml_error *err);

/* CML_E_IO: cml_file_check_link; the directory cannot be written to; the name is that of a directory, of a
 * device or of a pipe, which would be lost by the rename; or of a link to nothing. */
CML_NODISCARD cml_status cml_file_create(const char *path, struct cml_file *file, struct cml_error *err);

/* cml_file_create for a file that one call of a command writes: alone, as "PATH.lock" is held until the
 * commit, and without what killed processes have left of it. CML_E_IO also where another process holds the
 * lock. */
CML_NODISCARD cml_status cml_file_create_alone(const char *path, struct cml_file *file,
                                               struct cml_error *err);

/* Makes a folder, and those that it lies in, where they are not there. CML_E_IO. */
CML_NODISCARD cml_status cml_folder_make(const char *path, struct cml_error *err);

/* Removes the temporary files of killed processes from a folder, the first `folder` bytes of `path` with the
 * slash at their end, 0: the current one. is_ours: whether nobody writes the file NAME of which the temporary
 * file LEFT was one; both begin with the folder. */
void cml_file_remove_leftovers(const char *path, size_t folder,
                               bool (*is_ours)(const void *context, const char *name, const char *left),
                               const void *context);

/* Flush, fsync, compare, close, rename, fsync of the folder. On failure (CML_E_IO) the temporary file goes,
 * and what stood under PATH still does (without hard links it may stand under `keep`); where only the folder
 * could not be synced, the new file stands there. */
CML_NODISCARD cml_status cml_file_commit(struct cml_file *file, struct cml_error *err);

/* While it is deferred, cml_file_commit does not sync: a file is complete for everyone at once, but it is
 * safe from a crash of the machine only after cml_file_sync_deferred. For many small files, by one thread. */
void cml_file_defer_sync(bool on);

/* Syncs what was committed since, and the folders. CML_E_IO: the first file that could not be synced. Such
 * files are removed, since nobody knows what they hold; all others are synced. */
CML_NODISCARD cml_status cml_file_sync_deferred(struct cml_error *err);

/* Drops the temporary file. Does nothing after a commit. */
void cml_file_abort(struct cml_file *file);
