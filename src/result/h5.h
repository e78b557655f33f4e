/* Writes results as .h5 files: the quantities of the table (quantity.h), the options that decided their bits,
 * the scene in words. SPDX-License-Identifier: MIT */
#pragma once

#include "output/files/hdf5_file.h"
#include "result/outcome.h"

enum { CML_H5_MORE_ATTRIBUTES = 4 };

/* Contents of an .h5 file beside an outcome; all borrowed. */
struct cml_h5_more {
    const char *input; /* text of the .mci */
    /* [num_fields] further fields; a field that the outcome has, too, is left out */
    const struct cml_field *field;
    int num_fields;
    struct cml_hdf5_call call;
    /* [num_attributes] further attributes, at most CML_H5_MORE_ATTRIBUTES */
    const struct cml_attribute *attribute;
    int num_attributes;
};

/* Writes an .h5 file atomically. CML_E_IO on failure to write; CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_h5_write(const char *path, const struct cml_outcome *outcome,
                                      const struct cml_h5_more *more, struct cml_error *err);

/* Fills in the attributes of a run's file: the options that decided its bits, and the scene in words. Returns
 * their number, at most CML_H5_MOST_ATTRIBUTES. */
#define CML_H5_MOST_ATTRIBUTES (CML_NUM_OPTIONS_OF_BITS + 16)
int cml_h5_attributes(const struct cml_outcome *outcome, const struct cml_h5_more *more,
                      struct cml_attribute *attributes);
