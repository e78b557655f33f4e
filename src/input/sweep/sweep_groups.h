/* Groups the rows of a sweep that one flight can serve: rows that differ only in absorption.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "input/sweep/sweep_table.h"

/* True if a column holds absorption coefficients (its name ends in .mua). */
bool cml_sweep_is_absorption(const char *name);

/* The medium that a column sets a number of. */
struct cml_sweep_medium {
    bool is_first_layer;
    int scattering; /* column of the medium's mus; -1: the table has none */
    double mus;     /* mus where no column sets it, 1/cm */
};

/* Puts rows into groups, numbered from 0 by their first rows, in *group[num_rows], which the caller frees.
 * media: [num_columns]. Rows with mua = 0 are kept apart from rows with mua > 0 in two kinds of media. In a
 * medium that does not scatter, the flight would give up packets as trapped (P9), and the other rows would
 * lose what they absorb. In layer 1, beams start below it if it is clear (P1), and at its top if not. */
CML_NODISCARD cml_status cml_sweep_group(const struct cml_sweep_table *table,
                                         const struct cml_sweep_medium *media, int **group, int *num_groups,
                                         struct cml_error *err);
