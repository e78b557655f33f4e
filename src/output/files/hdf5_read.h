/* Reads from .h5 files that may come from anybody. Every read asks type, shape and size first and refuses
 * what hdf5_file.h does not write: links to other places, values that lie in other files or are not stored at
 * all, filters but shuffle and deflate, and sizes that the file cannot hold. Of the HDF5 library only what
 * finds objects is used: their bytes are read and inflated here, because the library trusts their sizes. What
 * it does with crafted metadata is its own. Failures are CML_E_INPUT with file, object, what it is and what
 * was expected. SPDX-License-Identifier: MIT */
#pragma once

#include "output/files/field.h"
#include "base/status.h"

#include <stdint.h>

struct cml_hdf5 {
    int64_t id; /* the library's handle */
    int descriptor;
    const char *path;
    size_t bytes; /* of the file */
};

/* An array of the root. Zeroed: none. */
struct cml_hdf5_dataset {
    const struct cml_hdf5 *file;
    int64_t id; /* the library's handle, 0: none */
    char name[64];
    bool single; /* 32-bit floats, else 64-bit */
    int num_axes;
    size_t n[CML_FIELD_AXES], size; /* their product */
    struct cml_hdf5_chunks *chunks; /* NULL: its values lie in one piece */
};

/* `path` must outlive the file. The caller closes it. A program without HDF5 refuses every file, and has
 * cml_hdf5_close and cml_hdf5_number alone of the other functions. */
CML_NODISCARD cml_status cml_hdf5_open(const char *path, struct cml_hdf5 *file, struct cml_error *err);
void cml_hdf5_close(struct cml_hdf5 *file);

/* How many numbers the file can hold, deflated or not. */
size_t cml_hdf5_most_numbers(const struct cml_hdf5 *file);

/* A data set; id is 0 where the file has none of this name. It borrows the file; the caller closes it. */
CML_NODISCARD cml_status cml_hdf5_dataset_open(const struct cml_hdf5 *file, const char *name,
                                               struct cml_hdf5_dataset *dataset, struct cml_error *err);
void cml_hdf5_dataset_close(struct cml_hdf5_dataset *dataset);

/* Fills out[count] with the values from number `begin` on, the last axis fastest. */
CML_NODISCARD cml_status cml_hdf5_values(const struct cml_hdf5_dataset *dataset, size_t begin, size_t count,
                                         double *out, struct cml_error *err);

/* An attribute of the file; where it has none, *number stays as it is. */
CML_NODISCARD cml_status cml_hdf5_number(const struct cml_hdf5 *file, const char *name, double *number,
                                         struct cml_error *err);

/* An attribute of the data set, or of the file where that is NULL; "" where there is none. *text is the
 * caller's to free. */
CML_NODISCARD cml_status cml_hdf5_text(const struct cml_hdf5 *file, const struct cml_hdf5_dataset *dataset,
                                       const char *name, char **text, struct cml_error *err);
