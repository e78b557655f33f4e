/* Results as .h5 files: the quantities of the table, what decided their bits, the scene in words.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "output/files/hdf5_file.h"
#include "result/outcome.h"

enum { CML_H5_MORE_ATTRIBUTES = 4 };

/* What an .h5 holds beside an outcome. Borrowed. */
struct cml_h5_more {
    const char *input;             /* text of the .mci */
    const struct cml_field *field; /* [num_fields]; one that the outcome has is left out */
    int num_fields;
    struct cml_hdf5_call call;
    const struct cml_attribute *attribute; /* [num_attributes], at most CML_H5_MORE_ATTRIBUTES */
    int num_attributes;
};

/* Writes to `path` atomically. CML_E_IO; CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_h5_write(const char *path, const struct cml_outcome *outcome,
                                      const struct cml_h5_more *more, struct cml_error *err);

/* The attributes of a file of a run: what decided its bits, the scene in words. Returns their number. */
#define CML_H5_MOST_ATTRIBUTES (CML_NUM_OPTIONS_OF_BITS + 15)
int cml_h5_attributes(const struct cml_outcome *outcome, const struct cml_h5_more *more,
                      struct cml_attribute *attributes);
