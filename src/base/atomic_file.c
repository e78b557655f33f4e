/* SPDX-License-Identifier: MIT */
#include "base/atomic_file.h"

#include "base/text.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

cml_status cml_file_create(const char *path, struct cml_file *file, struct cml_error *err)
{
    *file = (struct cml_file){0};
    CML_TRY(cml_text_copy(path, &file->path, err));
    file->temporary = malloc(strlen(path) + sizeof ".tmp");
    if (file->temporary) {
        strcpy(file->temporary, path);
        strcat(file->temporary, ".tmp");
        file->stream = fopen(file->temporary, "wb");
    }
    if (file->stream) return CML_OK;
    const int reason = errno;
    if (file->temporary) file->temporary[0] = '\0'; /* not ours to remove */
    cml_file_abort(file);
    return cml_fail(err, CML_E_IO, "%s: cannot be written (%s)", path, strerror(reason));
}

/* Why an earlier write failed: the next one fails for the same reason. EIO where it does not. */
static int reason_of_error(FILE *stream)
{
    clearerr(stream);
    errno = EIO;
    return fputc('\n', stream) == EOF || fflush(stream) != 0 ? errno : EIO;
}

cml_status cml_file_commit(struct cml_file *file, struct cml_error *err)
{
    errno = EIO;
    bool good = fflush(file->stream) == 0 && !ferror(file->stream) && fsync(fileno(file->stream)) == 0;
    int reason = good || !ferror(file->stream) ? errno : reason_of_error(file->stream);
    if (fclose(file->stream) != 0 && good) {
        good = false;
        reason = errno;
    }
    file->stream = NULL;
    if (good && file->keep && rename(file->path, file->keep) != 0 && errno != ENOENT) {
        good = false;
        reason = errno;
    }
    if (good && rename(file->temporary, file->path) != 0) {
        good = false;
        reason = errno;
    }
    cml_status status = CML_OK;
    if (!good) status = cml_fail(err, CML_E_IO, "%s: cannot be written (%s)", file->path, strerror(reason));
    if (good) file->temporary[0] = '\0';
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
