/* The merging of a heightmap's triangles (see heightmap.h). Private to heightmap_*.c.
 *
 *       a --------- c     A triangle with its right angle at c is halved at m, the middle
 *         \   1   / |     of its longest side a b. Its halves 1 and 2 are halved in turn,
 *           \   /   |     from squares of 2^k cells down to half cells.
 *             m     |
 *               \ 2 |
 *                 \ |
 *                   b
 *
 * Each middle stores the largest error of the triangles that it would halve and of all triangles below them.
 * A middle whose error exceeds the tolerance is split. The triangles on both sides of a b share the middle m,
 * so they are split together [Evans, Kirkpatrick and Townsend, Right-Triangulated Irregular Networks,
 * Algorithmica 30 (2001) 264]. SPDX-License-Identifier: MIT */
#pragma once

#include "scene/heightmap/heightmap.h"

/* The errors at all middles of triangles, which decide where triangles are split. */
struct cml_split {
    const struct cml_heightmap *map; /* borrowed heightmap */
    double *error;                   /* [ny][nx] error at each middle, cm */
    /* Cells along a square's side; number of halvings from a square down to half cells. */
    int size, depths;
};

/* Computes the errors of all middles of a heightmap. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_split_create(const struct cml_heightmap *map, struct cml_split *split,
                                          struct cml_error *err);
void cml_split_free(struct cml_split *split);

/* Receives one triangle as its samples j * nx + i, counter-clockwise seen from above. */
typedef void cml_split_visit(void *context, const size_t corner[3]);

/* Calls `visit` for every triangle that is left at the tolerance [cm], and fills surface[ny][nx] with the
 * heights of these triangles at all samples. */
void cml_split_walk(const struct cml_split *split, double tolerance, double *surface, cml_split_visit *visit,
                    void *context);
