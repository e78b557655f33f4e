/* What one plane layer does with light from either side: reflection, transmission and absorption in discrete
 * ordinates, by doubling. SPDX-License-Identifier: MIT */
#ifndef CML_LAYER_RESPONSE_H
#define CML_LAYER_RESPONSE_H

#include "exact/directions.h"

/* For `count` directions. Light is given by the power that each direction carries through a unit of area, so
 * columns add up to shares: of a unit of power that comes in direction j, R[i][j] goes back in direction i,
 * T[i][j] goes through, and a[j] is absorbed. T = 1 + U; U and a are kept so that thin layers lose no digits.
 */
struct cml_layer_response {
    int count;
    double *R, *U; /* [count][count] */
    double *a;     /* [count] */
};

/* terms: of the phase function's Legendre series. CML_E_INPUT: out of memory. On failure *to is empty; else
 * the caller clears it. */
CML_NODISCARD cml_status cml_layer_response_create(const struct cml_medium_def *medium,
                                                   const struct cml_directions *directions, int count,
                                                   int terms, struct cml_layer_response *to,
                                                   struct cml_error *err);

void cml_layer_response_clear(struct cml_layer_response *response);

#endif
