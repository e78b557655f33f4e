/* Writer of HDF5 files: fields on named axes, as h5py, xarray, MATLAB and Octave read them unaided.
 * Axes are datasets and dimension scales of their own; units, long names and the names of error fields
 * (`ancillary_variables`) are attributes as in the CF conventions; data are shuffled and deflated in chunks,
 * but for plain ones. No times are stored: the same fields give the same bytes. hdf5_head.h reads the
 * head. SPDX-License-Identifier: MIT */
#pragma once

#include "output/files/field.h"
#include "base/status.h"

/* An attribute of the whole file; value NULL: `number` counts. */
struct cml_attribute {
    const char *name, *value;
    double number;
};

/* What differs from call to call of the same run. Each becomes a data set of CML_HDF5_CALL bytes in the group
 * `call`, filled up with zeros or cut: two files of one run differ there and nowhere else, not even in size.
 */
#define CML_HDF5_CALL 4096
struct cml_hdf5_call {
    const char *command, *input_file;
};

/* False when the program was built without HDF5. */
bool cml_hdf5_available(void);

/* Writes to `path` atomically (atomic_file.h): whatever happens, it holds the old or the complete new file.
 * Axes are those that the fields name; two axes of one name are one, and a field with the name of its one
 * axis is that axis. CML_E_IO when it cannot be written. */
CML_NODISCARD cml_status cml_hdf5_write(const char *path, const struct cml_attribute *attributes,
                                        int num_attributes, const struct cml_hdf5_call *call,
                                        const struct cml_field *fields, int num_fields,
                                        struct cml_error *err);
