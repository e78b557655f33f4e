/* Writes the results of a sweep: all totals with their errors, as a table (.csv) and as arrays (.h5).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "output/files/hdf5_file.h"
#include "result/timing.h"

/* The results of all rows of a sweep; the structure owns nothing. */
struct cml_sweep_results {
    const char *title;    /* name of the scene's output */
    const char *input;    /* text of the scene */
    const char *settings; /* changes by --set; NULL: none */
    struct cml_hdf5_call call;
    int num_columns, num_rows;
    const char *const *name;         /* [num_columns] names of the swept numbers and labels */
    const bool *label;               /* [num_columns] true: a label, carried along and not swept */
    char *const *cell;               /* [num_rows][num_columns] values of the columns, as written */
    const uint64_t *seed;            /* [num_rows] seed of each row */
    char *const *file;               /* [num_rows] main result of each row */
    const struct cml_record *record; /* [num_rows] numbers of each row */
    /* names of detectors, as many as the records of rows have; NULL: none */
    const char *const *detector;
};

/* True if a table of results may have a column of its own with this name. A label must have another name. */
bool cml_sweep_is_of_results(const char *name);

/* Turns the name of a label into that of its array in the .h5, where / would make groups: / becomes _. */
void cml_sweep_h5_name(char *name);

/* Writes a line of names, then a line for each row: row, swept numbers and labels, photons, seed; then with
 * their standard errors the totals, absorption of layers and bodies, expected values where rows have them,
 * detectors and fluxes of bodies; then lost packets and the row's file. Numbers have 17 digits. Atomic;
 * CML_E_IO. */
CML_NODISCARD cml_status cml_sweep_write_csv(const char *path, const struct cml_sweep_results *results,
                                             struct cml_error *err);

/* Axes of a sweep: two less than a field may have, for the body and the side of flux_body. */
#define CML_SWEEP_AXES (CML_FIELD_AXES - 2)

/* Writes arrays over the swept numbers. If the rows are all combinations of the values in their columns, each
 * once, and at most CML_SWEEP_AXES columns have more than one value, these columns are the axes, in their
 * order, with rising values. Else the only axis is the row, and all columns are arrays over it. Labels are no
 * axes, and are left out if they are not numbers; / in their names becomes _. Atomic; CML_E_IO, or
 * CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_sweep_write_h5(const char *path, const struct cml_sweep_results *results,
                                            struct cml_error *err);
