/* Part of the overlap check: compares a surface whose height depends only on the radius (a plane or a radial
 * heightfield) with another such surface or with a mesh. The comparison is exact. SPDX-License-Identifier:
 * MIT */
#pragma once

#include "geometry/footprint.h"
#include "geometry/mesh.h"
#include "scene/scene.h"

#include <stdbool.h>

/* A radial heightfield at nominal depth z: its surface lies at depth z - h(r), cm. A plane is a heightfield
 * of one sample of height 0. */
struct cml_radial_surface {
    const struct cml_radial *radial;
    double z;
};

/* Sets *top and *bottom to the least and the greatest depth of `count` heights, which count up from depth z,
 * while depths count down. */
void cml_depth_range(const double *height, size_t count, double z, double *top, double *bottom);

/* Returns the index of the first sample with r_i >= r, or n if there is none. */
int cml_radial_sample_from(const struct cml_radial *radial, double r);

/* The place where two surfaces come closest in the vertical, among all places compared until now. */
struct cml_closest {
    /* z of the lower surface minus z of the upper one, cm; INFINITY before the first comparison. */
    double gap;
    double at[3]; /* the place on the upper surface, scene's frame, cm */
    /* Tolerance, cm: the surfaces touch if |gap| is no larger. It is 8 epsilon times the sum of the depths
     * and heights involved, well above the rounding of two interpolated depths. */
    double err_gap;
};

/* Finds the place where two radial surfaces come closest. Both are piecewise linear in r, so the gap is least
 * at one of their samples. */
void cml_radial_against_radial(const struct cml_radial_surface *upper, const struct cml_radial_surface *lower,
                               struct cml_closest *closest);

/* Finds the place where a radial heightfield and a mesh come closest. The mesh is given in its boundary's
 * frame at depth `z`. Its outer plane is compared, too, unless footprint is NULL (a closed mesh). The search
 * is exact. Over a triangle the gap can be least at a vertex; on an edge that crosses a ring or runs parallel
 * to a cone; or where a ring crosses the line of steepest descent through the axis. Over the outer plane the
 * gap is least at a ring. */
void cml_radial_against_mesh(const struct cml_radial_surface *field, const struct cml_mesh *mesh,
                             const struct cml_footprint *footprint, double z, bool mesh_is_upper,
                             struct cml_closest *closest);
