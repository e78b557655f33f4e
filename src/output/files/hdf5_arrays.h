/* Reader of the arrays of .h5 files that hdf5_file.c wrote: as fields again, whose values are read piece by
 * piece. SPDX-License-Identifier: MIT */
#ifndef CML_HDF5_ARRAYS_H
#define CML_HDF5_ARRAYS_H

#include "output/files/field.h"
#include "base/status.h"

#include <stdint.h>

/* An array of numbers of the file's root. What the field and its axes point to is its own. */
struct cml_hdf5_array {
    struct cml_field field; /* `values` is NULL */
    struct cml_axis axis[CML_FIELD_AXES];
};

struct cml_hdf5_arrays {
    int64_t file; /* the library's handle */
    int count;
    struct cml_hdf5_array *item; /* [count] by name; axes are not among them */
};

/* Opens the file and lists its arrays; the caller closes it. CML_E_INPUT when it cannot be read, an array has
 * more than CML_FIELD_AXES axes or one without a name, or memory runs out; then nothing is left to close. */
CML_NODISCARD cml_status cml_hdf5_arrays_open(const char *path, struct cml_hdf5_arrays *arrays,
                                              struct cml_error *err);

void cml_hdf5_arrays_close(struct cml_hdf5_arrays *arrays);

/* NULL: the file has none of this name. */
const struct cml_hdf5_array *cml_hdf5_arrays_find(const struct cml_hdf5_arrays *arrays, const char *name);

/* Fills out[count] with values from number `begin` on, the last axis fastest; false when they cannot be
 * read. */
bool cml_hdf5_array_read(const struct cml_hdf5_arrays *arrays, const struct cml_hdf5_array *array,
                         size_t begin, size_t count, double *out);

#endif
