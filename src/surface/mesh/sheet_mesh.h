/* Cells under a mesh that is no regular grid but a single sheet: all its facets face up, so that, seen from
 * above, they lie side by side. Every cell of a square grid lists the facets above it, and has their least
 * and greatest depth there; above the cells stands the pyramid of a regular grid (grid_mesh.h), with the
 * steepest slope of each block besides. A grid of lists is the oldest way to find what a ray meets [Fujimoto,
 * Tanaka and Iwata, ARTS: accelerated ray-tracing system, IEEE Computer Graphics and Applications 6 (4),
 * 1986]. SPDX-License-Identifier: MIT */
#ifndef CML_SHEET_MESH_H
#define CML_SHEET_MESH_H

#include "surface/mesh/grid_mesh.h"

/* *grid owns its cells; none (levels 0) when facets overhang, or when their sizes or shapes differ so much
 * that lists would be long. CML_E_INPUT for memory. */
CML_NODISCARD cml_status cml_sheet_mesh_find(const struct cml_mesh_body *body, struct cml_grid_mesh *grid,
                                             struct cml_error *err);

/* ---- many rays at a time (sheet_prefetch.c) ---- */

enum { CML_MESH_RAYS = 64 };

/* Rays about to be asked for: structure of arrays, of which bit k of `asked` picks the k-th entries.
 * Borrowed. */
struct cml_mesh_rays {
    const float *x, *y, *z;    /* from the beam's axis, cm; z less `depth` in the boundary's frame */
    const float *ux, *uy, *uz; /* unit */
    const float *from, *to;    /* a crossing, if there is one, lies between: distances, cm */
    float depth;
    uint64_t asked; /* of CML_MESH_RAYS */
};

/* Calls the cells of a sheet, their lists and facets into the cache. A query reads one after the other, each
 * from the address that the one before has told, and waits for each; the facets of a mesh of 1e5 triangles
 * are too many for a processor's second cache. Asked for together, they come together [group prefetching:
 * Chen, Ailamaki, Gibbons and Mowry, Improving hash join performance through prefetching, ICDE 2004]. */
void cml_sheet_prefetch(const struct cml_grid_mesh *grid, const struct cml_mesh_body *body,
                        const struct cml_mesh_rays *rays);

#endif
