/* A ray's first crossing of a mesh that is a regular grid (grid_mesh.h), without a tree: a walk over the
 * cells below the ray [Amanatides and Woo, A fast voxel traversal algorithm for ray tracing, Eurographics
 * 1987], and over blocks of cells, which it enters only where it is between their least and greatest depth
 * [Tevs, Ihrke and Seidel, Maximum mipmaps for fast, accurate, and scalable dynamic height field rendering,
 * I3D 2008]. Everything is computed in double. Where rounding could matter - at edges, between cells, in a
 * facet's own plane - the walk leaves the answer open. SPDX-License-Identifier: MIT */
#ifndef CML_GRID_WALK_H
#define CML_GRID_WALK_H

#include "surface/mesh/grid_mesh.h"

/* True: decided; the first crossing of the mesh, if there is one before q->t, has been taken. False: left
 * open and *q unchanged; another search must decide. q: as cml_query_begin leaves it, of the grid's body.
 */
bool cml_grid_walk(const struct cml_grid_mesh *grid, struct cml_mesh_query *q);

/* True: up to its best crossing, or its end, the ray stays clearly over a grid without gaps, so that it
 * does not meet the outer plane. */
bool cml_grid_covers(const struct cml_grid_mesh *grid, const struct cml_mesh_query *q);

#endif
