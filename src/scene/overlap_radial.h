/* Exact order of a surface that is a function of the radius (plane, radial heightfield) against another one
 * or against a mesh. Part of the overlap check. SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/footprint.h"
#include "geometry/mesh.h"
#include "scene/scene.h"

#include <stdbool.h>

/* z(r) = z - h(r), cm. A plane is a field of one sample of height 0. */
struct cml_radial_surface {
    const struct cml_radial *radial;
    double z;
};

/* The first sample with r_i >= r; n when there is none. */
int cml_radial_sample_from(const struct cml_radial *radial, double r);

/* The place where two surfaces come closest in the vertical, over all places that were looked at. */
struct cml_closest {
    double gap;     /* z of the lower surface minus z of the upper one, cm; INFINITY at first */
    double at[3];   /* on the upper surface, scene's frame, cm */
    double err_gap; /* |gap| up to this is none, cm: each of its two depths is a difference of a nominal depth
                     * and an interpolated height, some 4 roundings of half an epsilon; twice that */
};

/* Where two radial surfaces come closest: both are piecewise linear in r, so the least gap is at a radius of
 * one of them. */
void cml_radial_against_radial(const struct cml_radial_surface *upper, const struct cml_radial_surface *lower,
                               struct cml_closest *closest);

/* A mesh in its boundary's frame at depth `z`, with its outer plane unless footprint is NULL (a closed mesh).
 * Exact: over a triangle the gap is extremal at its vertices, on its edges where they cross rings or where
 * the gap is stationary, or where a ring runs along the triangle's steepest direction; on the outer plane at
 * the rings. */
void cml_radial_against_mesh(const struct cml_radial_surface *field, const struct cml_mesh *mesh,
                             const struct cml_footprint *footprint, double z, bool mesh_is_upper,
                             struct cml_closest *closest);
