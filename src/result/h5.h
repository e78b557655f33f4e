/* Results as .h5 files: the quantities of the table, what decided their bits, the scene in words.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "output/files/hdf5_file.h"
#include "output/files/hdf5_read.h"
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

/* Quantities, provenance and the scene in words, of a run. A_z and A_rz are 0 where absorption was
 * not tallied, n outside of all layers is 0. A program without HDF5 refuses every file. CML_E_INPUT with file
 * and data set; then *outcome is cleared. The caller clears it otherwise. */
CML_NODISCARD cml_status cml_h5_read(const char *path, struct cml_outcome *outcome, struct cml_error *err);

/* Of that all but the grid and the quantities: of a file of saved packets, too. */
CML_NODISCARD cml_status cml_h5_read_head(const char *path, struct cml_outcome *outcome,
                                          struct cml_error *err);

/* All numbers of a data set, finite unless they are errors: `count` of them, or with count 0 any number, as
 * many as *size. *values is the caller's to free, NULL where the file has none of this name. CML_E_INPUT. */
CML_NODISCARD cml_status cml_h5_numbers(const struct cml_hdf5 *file, const char *name, size_t count,
                                        double **values, struct cml_hdf5_dataset *shape,
                                        struct cml_error *err);

/* A result from whatever file holds one: an .h5 file, or else an .mco file. CML_E_INPUT, also where sections
 * of ours are damaged or cut off; the caller clears it otherwise. */
CML_NODISCARD cml_status cml_result_read(const char *path, struct cml_outcome *outcome,
                                         struct cml_error *err);
