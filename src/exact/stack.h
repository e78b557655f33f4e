/* Plane layers and their boundaries, added up from below. SPDX-License-Identifier: MIT */
#pragma once

#include "exact/directions.h"
#include "exact/layer_response.h"
#include "exact/rough_response.h"

/* Rough boundaries of a stack that is added up several times, each time with other matrices. */
struct cml_stack_rough {
    struct cml_rough_matrices *boundary; /* [num_layers + 1], R NULL: a smooth one */
    struct cml_layer_response *layer; /* [num_layers + 1], zeroed at first: layers, kept for the next time */
};

/* Shares of the incident light: what is reflected, transmitted and absorbed[l - 1] in layer l, [num_layers].
 * By energy they add up to 1; nothing here makes them, so their sum tells how much rounding has done. media:
 * [num_layers + 2]; backing: mirror or lambertian, which keeps what else is transmitted, or NULL; rough
 * NULL: all boundaries are smooth; terms: of the phase functions. CML_E_INPUT: out of memory. */
CML_NODISCARD cml_status cml_stack_shares(const struct cml_medium_def *media,
                                          const struct cml_backing_def *backing,
                                          const struct cml_stack_rough *rough,
                                          const struct cml_directions *directions, int terms,
                                          double *reflected, double *transmitted, double *absorbed,
                                          struct cml_error *err);

/* What becomes of light in each of the `count` directions without weight, in their order, without a backing:
 * response [1 + num_layers][count] is what is transmitted, then absorbed in each layer. */
CML_NODISCARD cml_status cml_stack_responses(const struct cml_medium_def *media,
                                             const struct cml_directions *directions, int terms, int count,
                                             double *response, struct cml_error *err);

/* Fresnel's reflectance of unpolarised light, from the indices and cosines on both sides; no cosine (0) on
 * one side: total reflection, 1. Symmetric in the sides. [Hecht, Optics, chapter 4] */
double cml_stack_fresnel(double n1, double c1, double n2, double c2);
