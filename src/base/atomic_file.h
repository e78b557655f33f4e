/* Files that no reader sees half written, even if several processes write them at the same time.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/file_lock.h"
#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

/* A file that appears under its name only when it is complete.
 * Steps: write to "NAME.PID-N.tmp" beside it, which only this process has created; fsync; read the file again
 * and compare; rename; fsync the folder, so that the name lasts.
 * An old file stays until the rename, and the new file gets its mode. If the name is a symbolic link, its
 * target is replaced and the link stays, unless cml_file_check_link refuses the link. /dev/null and
 * /dev/stdout are written to directly.
 * The structure must not move in memory, because its stream holds its address. */
struct cml_file {
    FILE *stream;              /* write here, without seeking; cml_file_commit reports every error */
    char *path;                /* final name, with links followed */
    char *temporary;           /* name until the commit; NULL: the file is written to directly */
    const char *keep;          /* borrowed; the commit keeps the old file under this name; NULL: removes it */
    int descriptor;            /* the stream's descriptor, for fchmod; fileno() has none for this stream */
    int reason;                /* errno of the first write that failed; 0: none */
    uint64_t size;             /* bytes written to the stream */
    unsigned long sum;         /* CRC-32 of the bytes written */
    struct cml_file_lock lock; /* held until the commit; zeroed: no lock */
};

/* True for /dev/null and /dev/stdout, which are written to directly: a rename would replace the device by a
 * file. */
bool cml_file_is_device(const char *path);

/* Refuses, with CML_E_IO, a symbolic link that belongs neither to this user nor to root. In a folder where
 * others may write, such a link could make a user overwrite any of the user's own files. */
CML_NODISCARD cml_status cml_file_check_link(const char *path, struct cml_error *err);

/* Creates the temporary file and its stream. Returns CML_E_IO if cml_file_check_link refuses the path, if the
 * directory is not writable, if the path names a directory, device or pipe (the rename would replace it), or
 * if the path is a link to nothing. */
CML_NODISCARD cml_status cml_file_create(const char *path, struct cml_file *file, struct cml_error *err);

/* Calls cml_file_create for a file that must have one writer at a time: "PATH.lock" is held until the commit.
 * Removes temporary files of this path that killed processes have left. Returns CML_E_IO also if another
 * process holds the lock. */
CML_NODISCARD cml_status cml_file_create_alone(const char *path, struct cml_file *file,
                                               struct cml_error *err);

/* Makes a folder and its missing parents. Returns CML_E_IO on failure. */
CML_NODISCARD cml_status cml_folder_make(const char *path, struct cml_error *err);

/* Removes temporary files of killed processes from a folder. The folder is the first `folder` bytes of
 * `path`, with the slash at their end; 0 means the current folder. is_ours: true if the temporary file LEFT
 * of the file NAME may be removed, because no process writes NAME; both names begin with the folder. */
void cml_file_remove_leftovers(const char *path, size_t folder,
                               bool (*is_ours)(const void *context, const char *name, const char *left),
                               const void *context);

/* Finishes a file: flush, fsync, compare, rename, fsync of the folder. On failure returns CML_E_IO and
 * removes the temporary file; the old file still stands under PATH, or without hard links possibly under
 * `keep`. If only the folder could not be synced, the new file stands under PATH. */
CML_NODISCARD cml_status cml_file_commit(struct cml_file *file, struct cml_error *err);

/* Defers or resumes syncing. While syncing is deferred, cml_file_commit does not sync: a file is complete for
 * every reader at once, but survives a crash of the machine only after cml_file_sync_deferred. Meant for many
 * small files, written by one thread. */
void cml_file_defer_sync(bool on);

/* Syncs the files committed since syncing was deferred, and their folders. Returns CML_E_IO for the first
 * file that could not be synced. Files that could not be synced are removed, since their content is unknown;
 * all others are synced. */
CML_NODISCARD cml_status cml_file_sync_deferred(struct cml_error *err);

/* Closes the file without a commit and removes the temporary file. Does nothing after a commit. */
void cml_file_abort(struct cml_file *file);
