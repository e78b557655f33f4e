/* The reflection and transmission of a rough plane from both sides (P20): matrices
 * between discrete directions, from walks of the kernels on its facets. SPDX-License-Identifier: MIT */
#pragma once

#include "exact/directions.h"

/* Parts of the walks, each with random numbers of its own. The spread of totals from the parts tells the
 * error of totals from all walks. */
#define CML_ROUGH_PARTS 16

/* Shares of power, as in layer_response.h: [to][from]. */
struct cml_rough_matrices {
    double *R, *T;             /* light from above: [above][above], [below][above] */
    double *R_below, *T_below; /* light from below: [below][below], [above][below] */
};

struct cml_rough_response {
    struct cml_arrays arrays;
    int above, below;               /* directions on each side; 0 below: a backing */
    struct cml_rough_matrices mean; /* by all walks */
    struct cml_rough_matrices part[CML_ROUGH_PARTS];
};

/* A rough boundary between media of these indices. */
struct cml_rough_plane {
    struct cml_rough_def rough;
    double above, below;
    const struct cml_backing_def *backing; /* a mirror in place of the medium below, or NULL */
    bool lit;                              /* light comes from above in directions without weight */
};

/* Matrices obey reciprocity exactly, and each column has the power of its walks: 1 without a backing. walks:
 * the least number of them. Another `seed` makes independent walks. CML_E_INPUT: out of memory. On failure
 * *to is empty; else the caller clears it. */
CML_NODISCARD cml_status cml_rough_response_create(const struct cml_rough_plane *plane,
                                                   const struct cml_directions *directions, int above,
                                                   int below, double walks, unsigned seed,
                                                   struct cml_rough_response *to, struct cml_error *err);

void cml_rough_response_clear(struct cml_rough_response *response);
