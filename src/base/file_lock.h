/* A lock file that lets one process at a time write a result. The lock ends with the process, however the
 * process ends. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

/* An empty file that the kernel keeps locked, by fcntl's locks of open file descriptions, which network file
 * systems support, too. An existing file does not mean that it is locked: a killed process leaves its file
 * behind, unlocked. */
struct cml_file_lock {
    char *path;
    int file; /* descriptor; -1 if the file system has no locks, and nothing is locked */
};

/* Locks the file at `path`, creating it. Returns CML_E_IO if another process holds the lock ("PATH: locked by
 * another process"), if the file cannot be created, or if it is not empty. On success the caller releases
 * *lock. */
CML_NODISCARD cml_status cml_file_lock_take(const char *path, struct cml_file_lock *lock,
                                            struct cml_error *err);

/* Removes the lock file and unlocks it. Does nothing for a zeroed or released lock. */
void cml_file_lock_release(struct cml_file_lock *lock);
