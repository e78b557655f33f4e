/* Which rows of a sweep may come of one flight: those that differ in nothing but absorption.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "input/sweep/sweep_table.h"

/* Whether a column is of absorption coefficients. */
bool cml_sweep_is_absorption(const char *name);

/* Numbers the groups from 0 by their first rows: *group, [num_rows], is the caller's to free. Where the first
 * layer is clear, beams start below it (P1): rows in which its mua is 0 are never together with others.
 * first_layer: the column of that number; -1: there is none. */
CML_NODISCARD cml_status cml_sweep_group(const struct cml_sweep_table *table, int first_layer, int **group,
                                         int *num_groups, struct cml_error *err);
