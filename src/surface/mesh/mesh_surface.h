/* A boundary mesh as queries see it: the first crossing of a double-precision ray, found in three ways.
 * Exact: Embree's tree [Wald et al., Embree: a kernel framework for efficient CPU ray tracing, ACM
 * Transactions on Graphics 33 (4), 2014] finds boxes in single precision, larger by what the rounding of ray
 * and vertices can amount to; every triangle in them is tested in double, without gaps between neighbours.
 * DAGMC calls this interface between Embree and double precision "double-down". Tree: one of our own
 * (surface/tree/facet_tree.h) finds the facet in single precision where that is plain, and its distance is
 * computed in double; else it names the few facets that are in doubt, and these are tested in double. Grid:
 * where the mesh is a sheet (sheet_mesh.h), a traversal of the cells below the ray takes the tree's place
 * (grid_walk.h); where it leaves the answer open the exact way decides.
 * Whatever the way, a crossing in which rounding had a say is decided by the whole line (mesh_line.h). The
 * outer plane with the footprint as its hole belongs to the surface. A closed mesh has none: below it is
 * inside. The only place that includes Embree's headers; versions 3 and 4 differ here and nowhere else.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/mesh.h"
#include "mesh_crossing.h"
#include "surface/bounds/safe_map.h"
#include "surface/mesh/sheet_mesh.h"
#include "surface/mesh/tile_path.h"

enum cml_mesh_search {
    CML_SEARCH_AUTO,   /* a walk over the cells of a sheet, our own tree elsewhere */
    CML_SEARCH_TREE,   /* always our own tree */
    CML_SEARCH_EMBREE, /* always Embree's */
};

/* A struct cml_mesh_surface is immutable once built; queries may run in parallel.
 * Takes over *mesh (prepared; left empty). x0, y0: scene position of the origin from which queries count x
 * and y. Vertices are centred in double before anything is rounded. search: how the fast query finds facets.
 * CML_E_DEVICE when Embree fails, CML_E_INPUT for memory. */
CML_NODISCARD cml_status cml_mesh_surface_create(struct cml_mesh *mesh, double x0, double y0,
                                                 enum cml_mesh_search search,
                                                 struct cml_mesh_surface **surface, struct cml_error *err);

/* cml_mesh_surface_create of a mesh that is repeated over the whole plane. corner of *period counts in the
 * boundary's frame from the scene's axis. Primitives of queries are those of the period. */
CML_NODISCARD cml_status cml_mesh_surface_create_tile(struct cml_mesh *mesh, double x0, double y0,
                                                      enum cml_mesh_search search,
                                                      const struct cml_mesh_period *period,
                                                      struct cml_mesh_surface **surface,
                                                      struct cml_error *err);

void cml_mesh_surface_free(struct cml_mesh_surface *surface);

/* Whether the mesh is a sheet, which the fast query walks. */
bool cml_mesh_surface_is_sheet(const struct cml_mesh_surface *surface);

/* Bytes that Embree, the fast search and the mesh itself hold. */
double cml_mesh_surface_bytes(const struct cml_mesh_surface *surface);

/* Primitives that queries may give, without the outer plane: the triangles, or of a tile those of a period.
 */
uint64_t cml_mesh_surface_primitives(const struct cml_mesh_surface *surface);

/* The triangle of the mesh that is a primitive. */
size_t cml_mesh_surface_triangle(const struct cml_mesh_surface *surface, size_t primitive);

/* The area of the triangle that is a primitive, cm2. */
double cml_mesh_surface_area(const struct cml_mesh_surface *surface, size_t primitive);

/* What is repeated; n is 0 where nothing is. */
const struct cml_mesh_period *cml_mesh_surface_period(const struct cml_mesh_surface *surface);

/* The mesh, borrowed. Its vertices are relative to *middle in the boundary's frame (x and y of the scene). */
const struct cml_mesh *cml_mesh_surface_mesh(const struct cml_mesh_surface *surface, double middle[3]);

/* The query itself, as kernels/mesh_crossing.h describes it. */
int cml_mesh_surface_hit(const struct cml_mesh_surface *surface, const double p[3], const double u[3],
                         int below, double t_max, int exclude, int undeflected, int exact,
                         double err_position, struct cml_mesh_crossing *crossing);

/* Paths of any length from one place in one direction: those longer than `least` and shorter than `most`
 * meet nothing, nor do they end near a facet, and those longer than `from` all have the same crossing. cm;
 * the last two may be infinite. */
struct cml_mesh_stretch {
    double least, most, from;
};

/* The stretch before a packet that stands on a facet; arguments as of the query itself. False where that is
 * not proven: the path passes other facets too closely, or there are cells instead of a tree. */
bool cml_mesh_surface_stretch(const struct cml_mesh_surface *surface, const double p[3], const double u[3],
                              int below, int exclude, int undeflected, double err_position,
                              struct cml_mesh_stretch *stretch);

/* The cells of a surface, if rays can be answered many at a time (grid_lanes_inl.h), else NULL; *centred: its
 * mesh. Borrowed. */
const struct cml_grid_mesh *cml_mesh_surface_grid(const struct cml_mesh_surface *surface,
                                                  const struct cml_centred_mesh **centred);

/* The safe distances of a surface, or NULL. Borrowed. */
const struct cml_safe_map *cml_mesh_surface_map(const struct cml_mesh_surface *surface);

/* What finds the crossings, for people: "Embree 3.13.5", as built against. */
const char *cml_mesh_library(void);
