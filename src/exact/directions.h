/* The directions of discrete ordinates in a stack of plane layers. A direction is a bundle of rays that
 * Snell's law carries from medium to medium.
 *
 *     medium 1, n1  \   |       s = n sin(angle to the z axis) = n1 sin a1 = n2 sin a2
 *                  a1 \ |
 *     -----------------\|------
 *                       |\ a2
 *     medium 2, n2      | \
 *
 * Both s and the etendue s ds stay the same in all media. One set of values of s therefore serves the whole
 * stack, and smooth boundaries do not mix directions. Between two neighbouring indices of the stack the
 * response to light is a smooth function of s; at s = n_m medium m begins to reflect totally. Each interval
 * between indices therefore has Gauss-Legendre nodes of its own, in the cosine in the medium whose index ends
 * the interval. With one index this is double-Gauss quadrature (Sykes 1951). SPDX-License-Identifier: MIT */
#pragma once

#include "base/array.h"
#include "exact/dense.h"
#include "exact/light.h"

/* The directions of a stack of layers, in the order of s, the index times the sine of the angle to the z
 * axis. Light is scattered into directions with weight. Directions without weight carry only the light of
 * beams, or stand for light with spread directions: light is scattered out of them, but not into them. In
 * medium m the first live[m] directions contain light: those with s < n_m that light can reach. */
struct cml_directions {
    struct cml_arrays arrays;
    int count, num_media;
    double *index;   /* [count] index of the medium to which the cosine refers */
    double *cosine;  /* [count] cosine of the angle to the z axis in a medium of this index */
    double *etendue; /* [count] quadrature weight of integrals over s ds; 0: no weight */
    /* [count] share of the incident light in each direction; the sum is 1; shares that stand for light with
     * spread directions may be negative */
    double *light;
    int *live;                   /* [num_media] number of directions that contain light in each medium */
    int num_weighted, *weighted; /* [num_weighted] numbers of the directions with weight, rising */
};

/* Makes the directions of a stack. order: number of nodes over a quarter of a circle if all media had one
 * index. media: [num_layers + 2]. spreads: [num_layers + 1], true if a boundary, or the backing in its place,
 * sends light into all directions of the media beside it; NULL: none does. CML_E_INPUT: out of memory. The
 * caller clears *to, also after a failure. */
CML_NODISCARD cml_status cml_directions_create(const struct cml_medium_def *media, int num_layers,
                                               const bool *spreads, const struct cml_exact_light *light,
                                               int order, struct cml_directions *to, struct cml_error *err);

void cml_directions_clear(struct cml_directions *directions);

/* Returns the cosine of direction i in a medium of index n; 0 if the direction does not exist there. */
double cml_directions_cosine(const struct cml_directions *directions, int i, double n);

/* Returns the kind of matrices between the first n directions. Only rows of directions with weight are full,
 * because directions without weight receive light only from themselves. */
struct cml_dense_kind cml_directions_kind(const struct cml_directions *directions, int n);

/* Returns Gauss-Legendre node i of n >= 2 on (-1, 1), the largest first, and its weight. */
double cml_gauss_node(int n, int i, double *weight);
