/* The directions of discrete ordinates in a stack of plane layers. A direction is a bundle of rays that
 * Snell's law takes from medium to medium: s = n sin(angle to the z axis) is the same in all of them, and so
 * is the etendue s ds. So one set of values of s serves all media, and boundaries mix no directions. Between
 * two neighbouring indices of the stack, all that light does is a smooth function of s; at s = n_m a medium m
 * reflects totally. Therefore each such interval has Gauss-Legendre nodes of its own, in the cosine that they
 * have in the medium whose index ends the interval. Double-Gauss quadrature (Sykes 1951) is the case of one
 * index. SPDX-License-Identifier: MIT */
#pragma once

#include "base/array.h"
#include "exact/dense.h"
#include "exact/light.h"

/* Directions stand in the order of s. A beam's is one of them, with no weight: light is scattered out of it,
 * none into it. So are those to which light with spread directions is gathered. Medium m of the stack has the
 * first live[m] of them: those with s < n_m that light can reach.
 */
struct cml_directions {
    struct cml_arrays arrays;
    int count, num_media;
    double *index;   /* [count] n of a medium in which the direction has the cosine */
    double *cosine;  /* [count] */
    double *etendue; /* [count] quadrature weight: of integrals over s ds */
    double *light;   /* [count] share of the incident light, sums to 1; of gathered light also below 0 */
    int *live;       /* [num_media] */
    int num_weighted, *weighted; /* [num_weighted] directions that light is scattered into, rising */
};

/* order: nodes over a quarter of a circle, had all media one index. CML_E_INPUT: out of memory. On failure
 * *to is empty; else the caller clears it. media: [num_layers + 2]; spreads: [num_layers + 1], whether a
 * boundary or the backing in its place sends light into all directions of the media beside it; NULL: none
 * does.
 */
CML_NODISCARD cml_status cml_directions_create(const struct cml_medium_def *media, int num_layers,
                                               const bool *spreads, const struct cml_exact_light *light,
                                               int order, struct cml_directions *to, struct cml_error *err);

void cml_directions_clear(struct cml_directions *directions);

/* The cosine of direction i in a medium of index n, 0 where the medium does not have it. */
double cml_directions_cosine(const struct cml_directions *directions, int i, double n);

/* The kind of matrices from direction to direction, of the first n: light goes into those without weight only
 * from themselves. */
struct cml_dense_kind cml_directions_kind(const struct cml_directions *directions, int n);

/* Gauss-Legendre node i of n >= 2 on (-1, 1), from the largest down. */
double cml_gauss_node(int n, int i, double *weight);
