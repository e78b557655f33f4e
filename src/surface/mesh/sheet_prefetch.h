/* Calls the cells of a sheet, their lists and facets into the cache, for many rays at a time. A query reads
 * one after the other, each from the address that the one before has told, and waits for each; the facets of
 * a mesh of 1e5 triangles are too many for a processor's second cache. Asked for together, they come together
 * [group prefetching: Chen, Ailamaki, Gibbons and Mowry, Improving hash join performance through prefetching,
 * ICDE 2004]. SPDX-License-Identifier: MIT */
#ifndef CML_SHEET_PREFETCH_H
#define CML_SHEET_PREFETCH_H

#include "surface/mesh/grid_mesh.h"

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

void cml_sheet_prefetch(const struct cml_grid_mesh *grid, const struct cml_mesh_body *body,
                        const struct cml_mesh_rays *rays);

#endif
