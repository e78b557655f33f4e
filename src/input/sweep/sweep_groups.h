/* Which rows of a sweep may come of one flight: those that differ in nothing but absorption.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "input/sweep/sweep_table.h"

/* Whether a column is of absorption coefficients. */
bool cml_sweep_is_absorption(const char *name);

/* The medium of which a column sets a number. */
struct cml_sweep_medium {
    bool is_first_layer;
    int scattering; /* column of its mus; -1: the table has none */
    double mus;     /* then this, 1/cm */
};

/* Numbers the groups from 0 by their first rows: *group, [num_rows], is the caller's to free. media:
 * [num_columns]. Two kinds of rows with mua = 0 are never together with rows of mua > 0. The first is of
 * media that do not scatter: the flight would give up packets there as trapped (P9), with all that the other
 * rows would absorb of them. The second is of layer 1, below which beams start where it is clear (P1). */
CML_NODISCARD cml_status cml_sweep_group(const struct cml_sweep_table *table,
                                         const struct cml_sweep_medium *media, int **group, int *num_groups,
                                         struct cml_error *err);
