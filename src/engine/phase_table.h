/* Phase functions as tables of the inverse of their distribution function, for the kernels to draw from.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/phase.h"

#include <stddef.h>

/* A cell of a table: struct cml_phase_cell of kernels/types.h in double precision. */
struct cml_phase_line {
    double start, slope;
};

/* The most cells of all tables together: beyond that single precision cannot count. */
#define CML_MOST_PHASE_CELLS (1 << 24)

/* The tables of all functions, that of index i from cell i CML_PHASE_CELLS on, then the parts of cells. */
struct cml_phase_tables {
    struct cml_phase_line *item; /* [count] */
    size_t count;
};

/* phases: a scene's list, not empty; file: of the scene, for messages. Whoever draws by a table has a
 * distribution function that nowhere differs from the phase function's by more than 2^-18, but for rounding.
 * item is the caller's to free. CML_E_INPUT: out of memory, or too many cells. */
CML_NODISCARD cml_status cml_phase_tables_create(const char *file, const struct cml_phase *phases,
                                                 struct cml_phase_tables *tables, struct cml_error *err);
