/* One process at a time: a lock that other processes see, and that ends with the process however it ends.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

/* An empty file that the kernel keeps locked (fcntl's locks of open file descriptions, which network file
 * systems know too). That it exists says nothing: a killed process leaves it, unlocked. */
struct cml_file_lock {
    char *path;
    int file; /* descriptor; -1: the file system knows no locks, and nothing is locked */
};

/* Locks `path`, creating it. CML_E_IO: another process holds it, or it cannot be created or holds something:
 * "PATH: locked by another process". On success *lock is the caller's to release. */
CML_NODISCARD cml_status cml_file_lock_take(const char *path, struct cml_file_lock *lock,
                                            struct cml_error *err);

/* Removes the file and unlocks it. Does nothing for a zeroed lock or a second time. */
void cml_file_lock_release(struct cml_file_lock *lock);
