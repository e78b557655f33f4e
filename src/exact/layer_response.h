/* What one plane layer does with light from either side: reflection, transmission and absorption in discrete
 * ordinates, by doubling. SPDX-License-Identifier: MIT */
#pragma once

#include "exact/directions.h"

/* Where less goes through a layer it counts as nothing: twice as thick, little of it would be a double. */
#define CML_LEAST_THROUGH 1e-150

/* For `count` directions. Light is given by the power that each direction carries through a unit of area, so
 * columns add up to shares: of a unit of power that comes in direction j, R[i][j] goes back in direction i,
 * T[i][j] goes through, and a[j] is absorbed. T = through + U, with through 1 (times the unit matrix) of a
 * layer that lets most light pass and 0 of another: so thin layers lose no digits of what they do, and thick
 * ones none of what little goes through.
 */
struct cml_layer_response {
    struct cml_arrays arrays;
    int count;
    double *R, *U; /* [count][count] */
    double *a;     /* [count] */
    double through;
};

/* terms: of the phase function's Legendre series. CML_E_INPUT: out of memory. On failure *to is empty; else
 * the caller clears it. */
CML_NODISCARD cml_status cml_layer_response_create(const struct cml_medium_def *medium,
                                                   const struct cml_directions *directions, int count,
                                                   int terms, struct cml_layer_response *to,
                                                   struct cml_error *err);

void cml_layer_response_clear(struct cml_layer_response *response);
