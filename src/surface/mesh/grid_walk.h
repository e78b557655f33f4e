/* A ray's first crossing of a sheet (sheet_mesh.h), without a tree: a traversal of the
 * cells below the ray [Amanatides and Woo, A fast voxel traversal algorithm for ray tracing, Eurographics
 * 1987], and of blocks of cells, which it enters only where it is between their least and greatest depth
 * [Tevs, Ihrke and Seidel, Maximum mipmaps for fast, accurate, and scalable dynamic height field rendering,
 * I3D 2008].
 *
 * How it goes: the ray is written in cells along x and y and in depth steps along z, and clipped to the
 * depths of the whole mesh. It starts at a level of the pyramid where it crosses few nodes, and goes from
 * node to node. A node whose depths it misses is passed over; else its 4 x 4 children are traversed in the
 * same way, down to cells, whose facets are tested.
 *
 * Everything is in double, and every test has three answers: hit, miss, and undecided where rounding could
 * change it: at edges, near the corners where four nodes meet, in a facet's own plane. The first undecided
 * test ends the traversal, and the caller asks the exact query (mesh_query.h). So facets are hit only well
 * inside, and what is said to be missed is missed by more than rounding. SPDX-License-Identifier: MIT */
#pragma once

#include "surface/mesh/grid_mesh.h"

/* True: decided; the first crossing of the mesh, if there is one before q->t, has been added to *q. False:
 * undecided and q's hit unchanged; another search must decide. Either way q->in_doubt is set where the origin
 * is within q->contact_distance of a facet that was tested. q: as cml_query_begin leaves it, of the grid's
 * mesh. */
bool cml_grid_walk(const struct cml_grid_mesh *grid, struct cml_mesh_query *q);

/* True: up to its best crossing, or its end, the ray stays well over a grid without gaps, so that it does not
 * meet the outer plane. */
bool cml_grid_walk_covers(const struct cml_grid_mesh *grid, const struct cml_mesh_query *q);
