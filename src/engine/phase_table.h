/* Phase functions as tables, from which the kernels draw deflections (P4). A table is the inverse of the
 * function's distribution function.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/phase.h"

#include <stddef.h>

/* A cell of a table in double precision: struct cml_phase_cell of kernels/types.h. */
struct cml_phase_line {
    double start, slope;
};

/* Largest number of cells of all tables together. The kernels hold cell numbers in single precision, which is
 * exact for integers up to 2^24. */
#define CML_MOST_PHASE_CELLS (1 << 24)

/* The tables of all functions. The table of index i begins at cell i CML_PHASE_CELLS. The parts of cells come
 * after all tables. */
struct cml_phase_tables {
    struct cml_phase_line *item; /* [count] */
    size_t count;
};

/* Makes the tables of a scene's phase functions. phases: the scene's list, not empty; file: the scene's, for
 * messages. Deflections drawn by a table have a distribution function that nowhere differs from the phase
 * function's by more than 2^-18, but for rounding. The caller frees item. CML_E_INPUT: out of memory, or too
 * many cells. */
CML_NODISCARD cml_status cml_phase_tables_create(const char *file, const struct cml_phase *phases,
                                                 struct cml_phase_tables *tables, struct cml_error *err);
