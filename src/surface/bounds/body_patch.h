/* Shapes of bodies' surfaces near the middles of a grid's cells. Each cell that surfaces pass has a patch:
 * two planes between which the surfaces lie. The patches of neighbours give two planes for a ball larger than
 * a cell.
 *
 *     - - - - - - - - - -  upper
 *        _.-~~~~~-._
 *     _.~           ~-._   surface of a body
 *     - - - - - - - - - -  lower
 *              +           middle of the cell
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/body/convex.h"

#include <stddef.h>

/* Distance from a cell's middle to its corners, in cells: half its diagonal, sqrt(3) / 2. */
#define CML_CELL_REACH 0.8661

/* The surfaces that come within CML_CELL_REACH of the middle of a cell. */
struct cml_body_patch {
    int body; /* number of the only body whose surface comes near, or CML_PATCH_NONE or CML_PATCH_MIXED */
    double normal[3];    /* unit vector, outwards: the mean of the surface's normals */
    double lower, upper; /* heights of the two planes over the middle, along `normal`, cells */
    double cosine;       /* cosine of the greatest angle between `normal` and a normal of the surface */
};
enum { CML_PATCH_NONE = -1, CML_PATCH_MIXED = -2 /* several bodies, or a surface too bent for planes */ };

/* Adds a sphere or cylinder that comes within CML_CELL_REACH of p to the patch. p: the middle of a cell of
 * width `cell`, cm. */
void cml_patch_add_convex(int body, const struct cml_convex *convex, const double p[3], double cell,
                          struct cml_body_patch *patch);

/* Adds a facet of a mesh to the patch's mean normal. The facet comes within CML_CELL_REACH of the cell's
 * middle. All facets must be added before the first call of cml_patch_add_heights. corner: relative to the
 * middle, in cells. */
void cml_patch_add_normal(int body, const double corner[3][3], struct cml_body_patch *patch);

/* Moves the two planes of a patch apart to include a facet of a mesh. The normals of all facets must have
 * been added before. corner: relative to the middle, in cells. */
void cml_patch_add_heights(const double corner[3][3], struct cml_body_patch *patch);

/* The ball of a cell, with the members of struct cml_body_cell in kernels/types.h. body: the only body whose
 * surface is in the ball; -1: no surface is. */
struct cml_body_ball {
    float radius, normal[3], lower, upper, steepest;
    int body;
};

/* Sets next[c], for every cell c of the grid, to the x of a cell in the row of c: the first cell, from c
 * itself on, that a surface may pass; n[0] if there is none. patch, distance: as for cml_body_ball_of. */
void cml_patch_rows(const int n[3], const struct cml_body_patch *patch, const float *distance, int *next);

/* Returns the best ball around the middle of cell `at` (x, y, z). patch: of all n[0] n[1] n[2] cells, x
 * fastest. distance: of every cell's middle from all surfaces, in cells; a surface can pass only cells where
 * it is below CML_CELL_REACH. next: from cml_patch_rows. */
struct cml_body_ball cml_body_ball_of(const int n[3], const struct cml_body_patch *patch,
                                      const float *distance, const int *next, const int at[3]);
