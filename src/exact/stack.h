/* Plane layers and their boundaries, added up from below.
 *
 *     incident light  |   ^  reflected
 *                     v   |
 *     ------------------------- boundary 0
 *     layer 1          absorbed[0]
 *     ------------------------- boundary 1
 *       ...
 *     ------------------------- boundary L: medium below, or a backing
 *                     |
 *                     v  transmitted (or kept by the backing)
 * SPDX-License-Identifier: MIT */
#pragma once

#include "exact/directions.h"
#include "exact/layer_response.h"
#include "exact/rough_response.h"

/* Rough boundaries of a stack. The stack is added up several times, each time with other matrices. */
struct cml_stack_rough {
    /* [num_layers + 1] matrices of rough boundaries; R NULL: a smooth boundary */
    struct cml_rough_matrices *boundary;
    /* [num_layers + 1] responses of layers, kept from one time to the next; zeroed at first */
    struct cml_layer_response *layer;
};

/* Computes the shares of the incident light that are reflected, transmitted, and absorbed in layer l:
 * absorbed[l - 1], [num_layers]. By energy they add up to 1. No step enforces this, so their sum shows the
 * size of rounding errors. media: [num_layers + 2]. backing: mirror or lambertian, whose absorption counts as
 * transmitted, or NULL. rough NULL: all boundaries are smooth. terms: number of Legendre terms of the phase
 * functions. CML_E_INPUT: out of memory. */
CML_NODISCARD cml_status cml_stack_shares(const struct cml_medium_def *media,
                                          const struct cml_backing_def *backing,
                                          const struct cml_stack_rough *rough,
                                          const struct cml_directions *directions, int terms,
                                          double *reflected, double *transmitted, double *absorbed,
                                          struct cml_error *err);

/* Computes the fate of light in each of the `count` directions without weight, in their order, without a
 * backing. response: [1 + num_layers][count], the shares transmitted, then those absorbed in each layer. */
CML_NODISCARD cml_status cml_stack_responses(const struct cml_medium_def *media,
                                             const struct cml_directions *directions, int terms, int count,
                                             double *response, struct cml_error *err);

/* Returns Fresnel's reflectance of unpolarised light, from the indices and cosines on both sides. A cosine of
 * 0 on one side means total reflection, 1. Both sides may be swapped. [Hecht, Optics, chapter 4] */
double cml_stack_fresnel(double n1, double c1, double n2, double c2);
