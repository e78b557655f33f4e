/* Finds a ray's first crossing of a sheet (sheet_mesh.h) without a tree, by walking over the cells below the
 * ray [Amanatides and Woo, A fast voxel traversal algorithm for ray tracing, Eurographics 1987]. Blocks of
 * cells are entered only where the ray is between their least and greatest depth [Tevs, Ihrke and Seidel,
 * Maximum mipmaps for fast, accurate, and scalable dynamic height field rendering, I3D 2008].
 *
 *     ray     ' .
 *             |   ' .       |            |     left block: the ray stays above its depths; skipped
 *             |       ' .   |     /\     |
 *             |    /\     ' | .  /  \    |     right block: the ray comes between its depths;
 *     mesh    |___/  \______|__'/    \___|     its children are tested
 *
 * Steps: the ray is converted to cells along x and y and to depth steps along z, and clipped to the depths of
 * the whole mesh. It starts at a level of the pyramid at which it crosses few nodes, and goes from node to
 * node. A node whose depths the ray misses is skipped. Otherwise the node's 4 x 4 children are traversed in
 * the same way, down to cells, whose facets are tested.
 *
 * All arithmetic is in double. Every test has three answers: hit, miss, or undecided if rounding could change
 * the answer. Tests are undecided at edges, near corners where four nodes meet, and in a facet's own plane.
 * The first undecided test ends the traversal, and the caller asks the exact query (mesh_query.h). Therefore
 * facets are hit only well inside, and missed by more than rounding.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "surface/mesh/grid_mesh.h"

/* Searches for the first crossing of the mesh before q->t. Returns true if the search is decided, and adds
 * the crossing, if there is one, to *q. Returns false if rounding could change the answer: q's hit is then
 * unchanged, and another search must decide. In both cases sets q->in_doubt if the origin is within
 * q->contact_distance of a tested facet. q: prepared by cml_query_begin for the grid's mesh. */
bool cml_grid_walk(const struct cml_grid_mesh *grid, struct cml_mesh_query *q);

/* True if the ray, up to its best crossing or its end, stays well over the inner rectangle of the grid, so
 * that it does not meet the outer plane. */
bool cml_grid_walk_covers(const struct cml_grid_mesh *grid, const struct cml_mesh_query *q);
