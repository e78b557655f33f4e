/* Reader of the arrays of .h5 files that hdf5_file.c wrote: as fields again, whose values are read piece by
 * piece. SPDX-License-Identifier: MIT */
#pragma once

#include "output/files/hdf5_read.h"

/* An array of numbers of the file's root. The texts of the field are its own. */
struct cml_hdf5_array {
    struct cml_field field;          /* `values` is NULL */
    struct cml_hdf5_dataset dataset; /* open from the first value that is read to the last */
};

/* A data set that is an axis of others. */
struct cml_hdf5_scale {
    char name[64];
    struct cml_axis axis;
    struct cml_hdf5_use *uses; /* [num_uses] */
    size_t num_uses;
};

/* Must stay where it is while it is open. */
struct cml_hdf5_arrays {
    struct cml_hdf5 file;
    int count, num_scales;
    struct cml_hdf5_array *item; /* [count] by name; axes are not among them */
    struct cml_hdf5_scale *scale;
};

/* Opens the file and lists its arrays; the caller closes it. CML_E_INPUT as hdf5_read.h has it, and where an
 * array has an axis without a scale; then nothing is left to close. `path` must outlive it. */
CML_NODISCARD cml_status cml_hdf5_arrays_open(const char *path, struct cml_hdf5_arrays *arrays,
                                              struct cml_error *err);

void cml_hdf5_arrays_close(struct cml_hdf5_arrays *arrays);

/* NULL: the file has none of this name. */
struct cml_hdf5_array *cml_hdf5_arrays_find(const struct cml_hdf5_arrays *arrays, const char *name);

/* Fills out[count] with values from number `begin` on, the last axis fastest. CML_E_INPUT. */
CML_NODISCARD cml_status cml_hdf5_array_read(const struct cml_hdf5_arrays *arrays,
                                             struct cml_hdf5_array *array, size_t begin, size_t count,
                                             double *out, struct cml_error *err);
