/* What comes of a sweep: all totals with their errors, as a table (.csv) and as arrays (.h5).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "output/files/hdf5_file.h"
#include "result/timing.h"

/* All rows of a sweep; nothing in it is owned. */
struct cml_sweep_results {
    const char *title;    /* the scene's output */
    const char *input;    /* the scene's text */
    const char *settings; /* what --set changed in it; NULL: nothing */
    struct cml_hdf5_call call;
    int num_columns, num_rows;
    const char *const *name;         /* [num_columns] what was swept */
    const bool *label;               /* [num_columns] not swept, but carried along */
    char *const *cell;               /* [num_rows][num_columns] its values, numbers as written */
    const uint64_t *seed;            /* [num_rows] */
    char *const *file;               /* [num_rows] main results */
    const struct cml_record *record; /* [num_rows] */
    const char *const *detector;     /* their names, as many as the rows' records have; NULL: none */
};

/* Whether a column of every table is called so. */
bool cml_sweep_is_of_results(const char *name);

/* Turns the name of a label into that of its array in the .h5: with _ for /, which parts groups there. */
void cml_sweep_h5_name(char *name);

/* A line of names, then a line for each row: row, what was swept, photons, seed, the totals each with its
 * standard error, what layers and bodies absorb likewise, expected values where rows have them, what
 * detectors have seen, lost packets, the row's file. Numbers with 17 digits. Atomic; CML_E_IO. */
CML_NODISCARD cml_status cml_sweep_write_csv(const char *path, const struct cml_sweep_results *results,
                                             struct cml_error *err);

/* One axis less than fields have: layers and bodies are one, too. */
#define CML_SWEEP_AXES (CML_FIELD_AXES - 1)

/* Where the rows are all combinations of the values in their columns, each once, and at most CML_SWEEP_AXES
 * columns have more than one value, those columns are the axes, in their order, with values rising. Else
 * there is one axis, row, and all columns are arrays over it. Labels are no axes, and are left out where they
 * are no numbers; / in their names is _. Atomic; CML_E_IO, CML_E_INPUT when memory runs
 * out. */
CML_NODISCARD cml_status cml_sweep_write_h5(const char *path, const struct cml_sweep_results *results,
                                            struct cml_error *err);
