/* Files that are never seen half written. SPDX-License-Identifier: MIT */
#ifndef CML_ATOMIC_FILE_H
#define CML_ATOMIC_FILE_H

#include "base/status.h"

#include <stdio.h>

/* A file that appears under its name only when it is complete: written to "PATH.tmp", synced, then renamed.
 * What stood under PATH stays until the rename. */
struct cml_file {
    FILE *stream;     /* write here; check nothing, cml_file_commit sees every error */
    char *path;       /* final name */
    char *temporary;  /* name until the commit */
    const char *keep; /* borrowed; the commit keeps under this name what stood under PATH; NULL: it goes */
};

CML_NODISCARD cml_status cml_file_create(const char *path, struct cml_file *file, struct cml_error *err);

/* Flush, fsync, close, rename. On failure (CML_E_IO) the temporary file goes and PATH is what it was. */
CML_NODISCARD cml_status cml_file_commit(struct cml_file *file, struct cml_error *err);

/* Drops the temporary file. Does nothing after a commit. */
void cml_file_abort(struct cml_file *file);

#endif
