/* Writer of HDF5 files: fields on named axes, which h5py, xarray, MATLAB and Octave read without help. Axes
 * are data sets and dimension scales. Units, long names and the names of error fields (`ancillary_variables`)
 * are attributes as in the CF conventions. Data are shuffled and deflated in chunks, except for plain fields.
 * No times are stored: the same fields give the same bytes. hdf5_head.h reads the head of such a file.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "output/files/field.h"
#include "base/status.h"

/* An attribute of the whole file: the text `value`, or `number` if value is NULL. */
struct cml_attribute {
    const char *name, *value;
    double number;
};

/* Texts that differ between calls of the same run. Each becomes a data set of CML_HDF5_CALL bytes in the
 * group `call`, filled up with zeros or cut off: two files of one run differ only there, and have the same
 * size. */
#define CML_HDF5_CALL 4096
struct cml_hdf5_call {
    const char *command, *input_file;
};

/* True if the program was built with HDF5. */
bool cml_hdf5_available(void);

/* Writes the file `path` atomically (atomic_file.h): at any moment it is the old or the complete new one. The
 * axes are those of the fields; axes of the same name are one, and a field with the name of its only axis is
 * that axis. CML_E_IO when the file cannot be written. */
CML_NODISCARD cml_status cml_hdf5_write(const char *path, const struct cml_attribute *attributes,
                                        int num_attributes, const struct cml_hdf5_call *call,
                                        const struct cml_field *fields, int num_fields,
                                        struct cml_error *err);
