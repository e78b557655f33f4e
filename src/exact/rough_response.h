/* The reflection and transmission of a rough plane from both sides (rule P20): matrices between discrete
 * directions, estimated by random walks on its facets. SPDX-License-Identifier: MIT */
#pragma once

#include "exact/directions.h"

/* Number of parts of the walks, each with random numbers of its own. The spread of totals over the parts
 * gives the standard error of the totals from all walks. */
#define CML_ROUGH_PARTS 16

/* Matrices of shares of power, indexed [to][from] as in layer_response.h. */
struct cml_rough_matrices {
    double *R, *T;             /* light from above: reflected [above][above], transmitted [below][above] */
    double *R_below, *T_below; /* for light from below: R_below[below][below] is reflected,
                                  T_below[above][below] transmitted */
};

/* The matrices of one rough boundary, by all walks and by parts of them; owns its arrays. */
struct cml_rough_response {
    struct cml_arrays arrays;
    int above, below; /* number of directions on each side; `below` is 0 if the boundary is a backing */
    struct cml_rough_matrices mean; /* matrices from all walks */
    struct cml_rough_matrices part[CML_ROUGH_PARTS];
};

/* A rough boundary between media of the indices `above` and `below`. */
struct cml_rough_plane {
    struct cml_rough_def rough;
    double above, below;
    const struct cml_backing_def *backing; /* a mirror in place of the medium below, or NULL */
    bool lit;                              /* light from above also comes in directions without weight */
};

/* Estimates the matrices of a rough boundary. They obey reciprocity exactly. Each column has the power of its
 * walks: 1 without a backing. walks: least number of walks. Another `seed` gives independent walks.
 * CML_E_INPUT: out of memory. The caller clears *to, also after a failure. */
CML_NODISCARD cml_status cml_rough_response_create(const struct cml_rough_plane *plane,
                                                   const struct cml_directions *directions, int above,
                                                   int below, double walks, unsigned seed,
                                                   struct cml_rough_response *to, struct cml_error *err);

void cml_rough_response_clear(struct cml_rough_response *response);
