/* Cells under a sheet, a mesh whose facets all face up: which facets lie above each cell, and between which
 * depths. sheet_mesh.h fills them. Knows no rays.
 *
 * Above the cells stands a min/max pyramid, as quadtree displacement mapping and maximum mipmaps have it
 * [Tevs, Ihrke and Seidel, I3D 2008], with 4 x 4 children to a block instead of 2 x 2: cells and blocks lie
 * in memory by tiles of 4 x 4, a cache line of depths each, and a block's children are one tile. Depths are
 * rounded outwards to 16 bits: those of a mesh of 1e6 facets fit into a processor's second cache.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "surface/mesh/mesh_query.h"

#define CML_GRID_MESH_LEVELS 15 /* enough for 2^28 cells along an axis */

/* A facet of a sheet, all that a walk asks of it in one cache line. */
struct cml_sheet_facet {
    _Alignas(64) double plane[4]; /* a copy (struct cml_centred_mesh) */
    double corner[2];             /* x and y of corner 0, centred frame, cm */
    float weight[2][2]; /* how the barycentric weights of corners 1 and 2 rise along x and y, 1/cm; NaN where
                         * the facet is too thin for float */
};

/* Depths in steps above cml_grid_mesh.z: of the facets, widened by err_float and by what err_apart makes on
 * their slope; least > most where there are none. */
struct cml_grid_mesh_depths {
    uint16_t least, most;
};

/* Cells (level 0), or blocks of 4 x 4 of the level below. */
struct cml_grid_mesh_level {
    struct cml_grid_mesh_depths *depths; /* by cml_grid_mesh_index; a slice of those of all levels */
    int n[2];                            /* cells or blocks along x and y */
    int tiles;                           /* along x */
};

struct cml_grid_mesh {
    double corner[2];       /* least x and y, centred frame, cm */
    double cells_per_cm[2]; /* along x and y */
    double z, steps_per_cm; /* depth of step 0, centred frame, cm; depth steps */
    double inner[2][2];     /* centred frame, cm: [0] lower, [1] upper corner of a rectangle inside the mesh's
                             * border; NaN where there is none */
    int n[2];               /* cells along x and y */
    uint32_t *first;        /* owned; where in `listed` the facets of a cell begin, and those of the next; by
                             * cml_grid_mesh_index of level 0 */
    uint32_t *listed;       /* owned; numbers of facets */
    struct cml_sheet_facet *facet; /* owned; [facets] */
    size_t facets;
    double mean; /* of the cells, depth steps */
    int levels;  /* the last one is a single tile; 0: the mesh has no cells */
    struct cml_grid_mesh_level level[CML_GRID_MESH_LEVELS];
};

/* Slot in memory of a cell or block: tile by tile, row by row in each. */
static inline size_t cml_grid_mesh_index(const struct cml_grid_mesh_level *level, int i, int j)
{
    const size_t tile = (size_t)(j >> 2) * (size_t)level->tiles + (size_t)(i >> 2);
    return 16 * tile + (size_t)(4 * (j & 3) + (i & 3));
}

/* Slots of a level in memory: whole tiles, those at the end are padded. */
static inline size_t cml_grid_mesh_slots(const struct cml_grid_mesh_level *level)
{
    return 16 * (size_t)level->tiles * (size_t)((level->n[1] + 3) / 4);
}

/* Lays out all levels above n[0] x n[1] cells, none of which has a depth yet. CML_E_INPUT for memory. */
CML_NODISCARD cml_status cml_grid_mesh_lay_out(const struct cml_centred_mesh *centred,
                                               struct cml_grid_mesh *grid, struct cml_error *err);

/* Widens a cell's depths by those from least to most, cm in the centred frame, rounded outwards. */
void cml_grid_mesh_widen_depths(const struct cml_grid_mesh *grid, double least, double most,
                                struct cml_grid_mesh_depths *depths);

/* Fills the depths of all blocks, and their mean, from those of the cells. */
void cml_grid_mesh_build_levels(struct cml_grid_mesh *grid);

void cml_grid_mesh_clear(struct cml_grid_mesh *grid);

/* Bytes of all that *grid owns; 0 without cells. */
double cml_grid_mesh_bytes(const struct cml_grid_mesh *grid);
