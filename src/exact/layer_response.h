/* The response of one plane layer to light from either side, in discrete directions: reflection, transmission
 * and absorption, computed by doubling.
 *
 *     light j  \   / R[i][j]
 *     ----------\-/---------
 *        layer   x   a[j] is absorbed
 *     ------------\---------
 *                  \ T[i][j]
 * SPDX-License-Identifier: MIT */
#pragma once

#include "exact/directions.h"

/* Smallest transmission of a layer that is not taken as 0. Twice as thick, the layer would transmit hardly
 * more than the smallest double. */
#define CML_LEAST_THROUGH 1e-150

/* The response of a layer to light from `count` directions. Light is given by the power that each direction
 * carries through a unit of area, so columns add up to shares. If a unit of power comes in direction j,
 * R[i][j] is reflected into direction i, T[i][j] is transmitted into it, and a[j] is absorbed. T = through +
 * U, where `through` is 1 (times the unit matrix) for a layer that transmits most light, and 0 for other
 * layers. Thin layers then lose no digits of their small effects, and thick layers none of their small
 * transmission. */
struct cml_layer_response {
    struct cml_arrays arrays;
    int count;
    double *R, *U; /* [count][count] reflection, and transmission beyond `through` */
    double *a;     /* [count] absorption */
    double through;
};

/* Computes the response of a layer for the first `count` directions. terms: number of terms of the phase
 * function's Legendre series. CML_E_INPUT: out of memory. The caller clears *to, also after a failure. */
CML_NODISCARD cml_status cml_layer_response_create(const struct cml_medium_def *medium,
                                                   const struct cml_directions *directions, int count,
                                                   int terms, struct cml_layer_response *to,
                                                   struct cml_error *err);

void cml_layer_response_clear(struct cml_layer_response *response);
