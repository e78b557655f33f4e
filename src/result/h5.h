/* Writes results as .h5 files: the quantities of the table (quantity.h), the options that decided their bits,
 * the scene in words. SPDX-License-Identifier: MIT */
#pragma once

#include "output/files/hdf5_file.h"
#include "result/outcome.h"

/* Contents of an .h5 file beside an outcome; all borrowed. */
struct cml_h5_more {
    const char *input; /* text of the .mci */
    /* [num_fields] further fields; a field that the outcome has, too, is left out */
    const struct cml_field *field;
    int num_fields;
    struct cml_hdf5_call call;
};

/* The arrays of an .h5 file, and the axes that they share. It points to itself, so it must not move. */
struct cml_h5_fields {
    struct cml_axis axis[CML_NUM_AXES];
    struct cml_field *field; /* [count] fields */
    int count;
};

/* Lists the arrays of an .h5 file: the quantities of the outcome, then those of `more`, whose values are
 * computed when they are asked for. outcome and more must outlive the list. */
CML_NODISCARD cml_status cml_h5_fields_create(const struct cml_outcome *outcome,
                                              const struct cml_h5_more *more, struct cml_h5_fields *fields,
                                              struct cml_error *err);
void cml_h5_fields_free(struct cml_h5_fields *fields);

/* Writes an .h5 file atomically. CML_E_IO on failure to write; CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_h5_write(const char *path, const struct cml_outcome *outcome,
                                      const struct cml_h5_more *more, struct cml_error *err);

/* Fills in the attributes of a run's file: the options that decided its bits, and the scene in words. Returns
 * their number, at most CML_H5_MOST_ATTRIBUTES. */
#define CML_H5_MOST_ATTRIBUTES (CML_NUM_OPTIONS_OF_BITS + 16)
int cml_h5_attributes(const struct cml_outcome *outcome, const struct cml_h5_more *more,
                      struct cml_attribute *attributes);
