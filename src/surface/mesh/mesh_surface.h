/* A boundary mesh for queries: finds the first crossing of a ray in double precision. This is the only room
 * that includes Embree's headers, and the only place where its versions 3 and 4 differ.
 *
 * Three searches find facets:
 * - Exact: Embree's tree [Wald et al., Embree: a kernel framework for efficient CPU ray tracing, ACM
 * Transactions on Graphics 33 (4), 2014] finds boxes in single precision, enlarged by the rounding of ray and
 * vertices. Each triangle in them is tested in double, without gaps between neighbours. DAGMC calls this
 * interface between Embree and double precision "double-down".
 * - Tree: our own tree (surface/tree/facet_tree.h) finds the facet in single precision if it is plain, and
 * its distance is computed in double. Otherwise the tree lists the few facets in doubt, which are tested in
 * double.
 * - Grid: if the mesh is a sheet (sheet_mesh.h), a walk over the cells below the ray replaces the tree
 * (grid_walk.h). If the walk cannot decide, the exact search does.
 * Whatever the search, the whole line (mesh_line.h) decides a crossing that rounding could change.
 *
 * The outer plane, with the footprint as its hole, belongs to the surface. A closed mesh has no outer plane;
 * "below" then means inside.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/mesh.h"
#include "mesh_crossing.h"
#include "surface/bounds/safe_map.h"
#include "surface/mesh/sheet_mesh.h"
#include "surface/mesh/tile_path.h"

enum cml_mesh_search {
    CML_SEARCH_AUTO,   /* walk over the cells of a sheet; our own tree for other meshes */
    CML_SEARCH_TREE,   /* always our own tree */
    CML_SEARCH_EMBREE, /* always Embree's tree */
};

/* Makes a surface. It is immutable once built, so queries may run in parallel. Takes over *mesh, which must
 * be prepared and is left empty. x0, y0: scene position where x and y of queries are 0, cm. Vertices are
 * centred in double before anything is rounded. search: how the fast query finds facets. Returns CML_E_DEVICE
 * if Embree fails, CML_E_INPUT if memory runs out. */
CML_NODISCARD cml_status cml_mesh_surface_create(struct cml_mesh *mesh, double x0, double y0,
                                                 enum cml_mesh_search search,
                                                 struct cml_mesh_surface **surface, struct cml_error *err);

/* Makes a surface from a mesh that is repeated over the whole plane. The corner of *period counts in the
 * boundary's frame from the scene's axis. Primitives of queries are those of the period. */
CML_NODISCARD cml_status cml_mesh_surface_create_tile(struct cml_mesh *mesh, double x0, double y0,
                                                      enum cml_mesh_search search,
                                                      const struct cml_mesh_period *period,
                                                      struct cml_mesh_surface **surface,
                                                      struct cml_error *err);

/* Frees a surface; NULL is allowed. */
void cml_mesh_surface_free(struct cml_mesh_surface *surface);

/* True if the mesh is a sheet with cells, over which queries walk. */
bool cml_mesh_surface_is_sheet(const struct cml_mesh_surface *surface);

/* Returns the bytes of memory in Embree, the fast search and the mesh. */
double cml_mesh_surface_bytes(const struct cml_mesh_surface *surface);

/* Returns the number of primitives that queries may give, without the outer plane: triangles of the mesh, or
 * of one period of a tile. */
uint64_t cml_mesh_surface_primitives(const struct cml_mesh_surface *surface);

/* Returns the number of the mesh's triangle for a primitive. */
size_t cml_mesh_surface_triangle(const struct cml_mesh_surface *surface, size_t primitive);

/* Returns the area of a primitive's triangle, cm2. */
double cml_mesh_surface_area(const struct cml_mesh_surface *surface, size_t primitive);

/* Returns the period of a tile; its n is 0 if the mesh is not repeated. */
const struct cml_mesh_period *cml_mesh_surface_period(const struct cml_mesh_surface *surface);

/* Returns the mesh, borrowed. Its vertices are relative to *middle in the boundary's frame (x and y of the
 * scene). */
const struct cml_mesh *cml_mesh_surface_mesh(const struct cml_mesh_surface *surface, double middle[3]);

/* Finds the first crossing of a path, as kernels/mesh_crossing.h describes. */
int cml_mesh_surface_hit(const struct cml_mesh_surface *surface, const double p[3], const double u[3],
                         int below, double t_max, int exclude, int undeflected, int exact,
                         double err_position, struct cml_mesh_crossing *crossing);

/* Ranges of path lengths from one place in one direction, cm. Paths longer than `least` and shorter than
 * `most` meet nothing and do not end near a facet. Paths longer than `from` all have the same crossing.
 * `most` and `from` may be infinite. */
struct cml_mesh_stretch {
    double least, most, from;
};

/* Finds the stretch of path lengths before a packet that stands on a facet. Takes the arguments of
 * cml_mesh_surface_hit. Returns false if nothing is proven: the path passes other facets too closely, or the
 * mesh has cells instead of a tree. */
bool cml_mesh_surface_stretch(const struct cml_mesh_surface *surface, const double p[3], const double u[3],
                              int below, int exclude, int undeflected, double err_position,
                              struct cml_mesh_stretch *stretch);

/* Returns the cells of a surface if rays can be answered many at a time (grid_lanes_inl.h), else NULL;
 * borrowed. *centred: the mesh of the cells. */
const struct cml_grid_mesh *cml_mesh_surface_grid(const struct cml_mesh_surface *surface,
                                                  const struct cml_centred_mesh **centred);

/* Returns the map of safe distances of a surface, borrowed, or NULL. */
const struct cml_safe_map *cml_mesh_surface_map(const struct cml_mesh_surface *surface);

/* Returns the name of the library that finds crossings, "Embree 3.13.5", in the version that this program was
 * built against. */
const char *cml_mesh_library(void);
