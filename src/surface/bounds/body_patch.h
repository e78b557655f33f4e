/* What the surfaces of bodies look like around the middles of a grid's cells: in each cell that they pass,
 * two planes between which they lie there; and from those of its neighbours two for a ball that is larger
 * than a cell. SPDX-License-Identifier: MIT */
#pragma once

#include "scene/body/convex.h"

#include <stddef.h>

/* How far a cell reaches from its middle, in cells: half its diagonal, sqrt(3) / 2. */
#define CML_CELL_REACH 0.8661

/* The surfaces that come within CML_CELL_REACH of the middle of a cell. */
struct cml_body_patch {
    int body;            /* whose surface it is, or: */
    double normal[3];    /* unit, outwards: the mean of the surface's normals */
    double lower, upper; /* heights of the two planes over the middle, along `normal`, cells */
    double cosine;       /* of the greatest angle between `normal` and a normal of the surface */
};
enum { CML_PATCH_NONE = -1, CML_PATCH_MIXED = -2 /* of several bodies, or turned too much for planes */ };

/* A sphere or cylinder comes within CML_CELL_REACH of p, the middle of a cell of this width (cm), of which
 * the patch tells what other bodies are there. */
void cml_patch_add_convex(int body, const struct cml_convex *convex, const double p[3], double cell,
                          struct cml_body_patch *patch);

/* A facet of a mesh does: first all of them, then all of them again. corner: from the middle, in cells. */
void cml_patch_add_normal(int body, const double corner[3][3], struct cml_body_patch *patch);
void cml_patch_add_heights(const double corner[3][3], struct cml_body_patch *patch);

/* As struct cml_body_cell of kernels/types.h. body: whose surface alone is in the ball, -1: none is. */
struct cml_body_ball {
    float radius, normal[3], lower, upper, steepest;
    int body;
};

/* For every cell of the grid the x of the first cell in its row, from itself on, that a surface may pass;
 * n[0] where there is none. patch, distance: as below. */
void cml_patch_rows(const int n[3], const struct cml_body_patch *patch, const float *distance, int *next);

/* What is known of the ball around the middle of cell `at` (x, y, z). distance: of all middles, from all
 * surfaces, cells: a surface may be in those cells only where it is less than CML_CELL_REACH. patch: of all
 * n[0] n[1] n[2] cells of the grid, x fastest. next: as from cml_patch_rows. */
struct cml_body_ball cml_body_ball_of(const int n[3], const struct cml_body_patch *patch,
                                      const float *distance, const int *next, const int at[3]);
