/* The merging of a heightmap's triangles: see heightmap.h. Private to heightmap_*.c.
 * Triangles are halved at the middle of their longest side, from squares of 2^k cells down to half cells
 * [Evans, Kirkpatrick and Townsend, Right-Triangulated Irregular Networks, Algorithmica 30 (2001) 264]. Every
 * middle keeps the largest error of the triangles that it would halve and of all triangles below; a middle
 * beyond the tolerance is split. Both triangles at a side have the same middle, so that they are split
 * together. SPDX-License-Identifier: MIT */
#pragma once

#include "scene/heightmap/heightmap.h"

struct cml_split {
    const struct cml_heightmap *map; /* borrowed */
    double *error;                   /* [ny][nx] cm, at the middles */
    int size, depths;                /* cells of a square, halvings down to half cells */
};

/* Measures all errors. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_split_create(const struct cml_heightmap *map, struct cml_split *split,
                                          struct cml_error *err);
void cml_split_free(struct cml_split *split);

/* A triangle by its samples j * nx + i, counter-clockwise seen from above. */
typedef void cml_split_visit(void *context, const size_t corner[3]);

/* Calls visit for every triangle that is left at the tolerance [cm], and fills surface[ny][nx] with its
 * heights at all samples. */
void cml_split_walk(const struct cml_split *split, double tolerance, double *surface, cml_split_visit *visit,
                    void *context);
