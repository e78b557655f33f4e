/* Cubes in and around the box of a mesh that overhangs, which know what of the surface is close. Each cell
 * knows how far from its middle no part of the surface is (kernels/bounds.h, cml_path_is_safe), and each
 * block of 2 x 2 x 2 cells which leaves of the tree of facets a path near it can meet: so most paths need no
 * query, and most queries no traversal. SPDX-License-Identifier: MIT */
#pragma once

#include "surface/tree/centred_mesh.h"
#include "surface/tree/facet_tree.h"

#include <math.h>

#define CML_NAMED_LEAVES 3
#define CML_MOST_REACH 6 /* cells from the middle of a block, up to which leaves are named */

/* The leaves that are closest to the middle of a block, the first one closest. */
struct cml_named_leaves {
    float reach[CML_NAMED_LEAVES]; /* cells from the middle, rounded down, within which lies nothing of the
                                    * surface but facets of the first 1, 2, 3 leaves; 0: not known */
    uint32_t leaf[CML_NAMED_LEAVES];
};

struct cml_safe_map {
    int n[3], blocks[3];     /* cells and blocks along an axis */
    double corner[3], cell;  /* cm, centred frame; width of a cell */
    float from[3], per_cell; /* the corner, and cells per cm */
    float *safe;             /* [n[2]][n[1]][n[0]] distance from the middle of a cell to the closest facet, or
                              * to the outer plane beyond the border, cells: rounded down; NULL: no map */
    struct cml_named_leaves
        *names; /* [blocks[2]][blocks[1]][blocks[0]]; NULL: facets are too small for any */
};

/* Makes the map of a mesh that is not repeated, its outer plane if it has one, and its tree. bytes: what may
 * be taken, about. CML_E_INPUT when memory runs out, and then there is nothing to clear. */
CML_NODISCARD cml_status cml_safe_map_create(const struct cml_centred_mesh *centred,
                                             const struct cml_facet_tree *tree, double bytes,
                                             struct cml_safe_map *map, struct cml_error *err);
void cml_safe_map_clear(struct cml_safe_map *map);

double cml_safe_map_bytes(const struct cml_safe_map *map);

/* How many leaves, *leaf, have all facets that the ray can come near; 0 where that is not known. As
 * cml_path_is_safe, in blocks of 2 cells. What is taken from a reach: of the path's margin, 32 for what a
 * query takes for contact, up to so many err_position, and some for the rounding of all this, which is less
 * than the margin (rounding.h). */
static inline int cml_safe_map_leaves(const struct cml_safe_map *map, const struct cml_tree_ray *ray,
                                      const uint32_t **leaf)
{
    const float per_cell = map->per_cell, half = 0.5f * ray->length * per_cell;
    float along = 0, square = 0;
    int at[3];
    if (!(half < CML_MOST_REACH)) return 0;
    for (int k = 0; k < 3; k++) {
        const float middle = (ray->origin[k] - map->from[k]) * per_cell + half * ray->direction[k];
        const float last = (float)(2 * map->blocks[k] - 1);
        at[k] = (int)(middle > 0 ? (middle < last ? middle : last) : 0) / 2;
        const float off = middle - (float)(2 * at[k] + 1);
        along += off * ray->direction[k];
        square += off * off;
    }
    const struct cml_named_leaves *names =
        &map->names[(at[2] * map->blocks[1] + at[1]) * map->blocks[0] + at[0]];
    const float far = square + half * (2 * fabsf(along) + half), less = 40 * ray->margin * per_cell;
    *leaf = names->leaf;
    for (int k = 0; k < CML_NAMED_LEAVES; k++) {
        const float reach = names->reach[k] - less;
        if (reach > 0 && far < reach * reach) return k + 1;
    }
    return 0;
}
