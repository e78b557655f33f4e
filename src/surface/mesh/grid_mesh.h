/* Cells under a sheet, a mesh whose facets all face up: the facets above each cell, and the depths between
 * which they lie. sheet_mesh.h fills the cells. Knows no rays.
 *
 *     level 1   [        block        ]  [   ...      least and greatest depth of 4 x 4 children
 *     level 0   [cell][cell][cell][cell]  ...         least and greatest depth, list of facets
 *     mesh      __/\/\____/\/\__/\/\____
 *
 * The levels above the cells form a min/max pyramid, as in quadtree displacement mapping and maximum mipmaps
 * [Tevs, Ihrke and Seidel, I3D 2008], with 4 x 4 children per block instead of 2 x 2. In memory, cells and
 * blocks lie in tiles of 4 x 4, so that a block's children are one tile and their depths one cache line.
 * Depths are rounded outwards to 16 bits: those of a mesh of 1e6 facets fit into a processor's second cache.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "surface/mesh/mesh_query.h"

#define CML_GRID_MESH_LEVELS 15 /* enough for 2^28 cells along an axis */

/* A facet of a sheet: all data that a walk reads of a facet, in one cache line. */
struct cml_sheet_facet {
    _Alignas(64) double plane[4]; /* copy of the facet's plane (struct cml_centred_mesh) */
    double corner[2];             /* x and y of corner 0, centred frame, cm */
    float weight[2][2]; /* derivatives of the barycentric weights of corners 1 and 2 along x and y, 1/cm;
                           NaN if the facet is too thin for float */
};

/* Range of depths of the facets above a cell, in depth steps from cml_grid_mesh.z. The range is widened by
 * the bound of rounding err_float, and by err_apart times the facets' slope. least > most if the cell has no
 * facets. */
struct cml_grid_mesh_depths {
    uint16_t least, most;
};

/* A level of the pyramid: cells (level 0), or blocks of 4 x 4 of the level below. */
struct cml_grid_mesh_level {
    struct cml_grid_mesh_depths *depths; /* ordered by cml_grid_mesh_index; a slice of one array of all
                                            levels */
    int n[2];                            /* number of cells or blocks along x and y */
    int tiles;                           /* number of tiles along x */
};

struct cml_grid_mesh {
    double corner[2];              /* smallest x and y of the grid, centred frame, cm */
    double cells_per_cm[2];        /* cells per cm along x and y */
    double z, steps_per_cm;        /* depth of step 0, centred frame, cm; depth steps per cm */
    double inner[2][2];            /* rectangle inside the mesh's border: [0] lower, [1] upper corner, centred
                                      frame, cm; NaN if there is none */
    int n[2];                      /* number of cells along x and y */
    uint32_t *first;               /* owned; where in `listed` each cell's facets begin, ordered by
                                      cml_grid_mesh_index of level 0 */
    uint32_t *listed;              /* owned; facet numbers, cell by cell */
    struct cml_sheet_facet *facet; /* owned; [facets] data of each facet */
    size_t facets;
    double mean; /* mean depth of the cells, in depth steps */
    int levels;  /* number of levels; the last level is a single tile; 0: the mesh has no cells */
    struct cml_grid_mesh_level level[CML_GRID_MESH_LEVELS];
};

/* Returns the slot in memory of a cell or block: tile by tile, and row by row in each tile. */
static inline size_t cml_grid_mesh_index(const struct cml_grid_mesh_level *level, int i, int j)
{
    const size_t tile = (size_t)(j >> 2) * (size_t)level->tiles + (size_t)(i >> 2);
    return 16 * tile + (size_t)(4 * (j & 3) + (i & 3));
}

/* Returns the number of slots of a level in memory. Tiles at the end are padded to whole tiles. */
static inline size_t cml_grid_mesh_slots(const struct cml_grid_mesh_level *level)
{
    return 16 * (size_t)level->tiles * (size_t)((level->n[1] + 3) / 4);
}

/* Allocates all levels above n[0] x n[1] cells; no cell has a depth yet. Returns CML_E_INPUT if memory runs
 * out. */
CML_NODISCARD cml_status cml_grid_mesh_lay_out(const struct cml_centred_mesh *centred,
                                               struct cml_grid_mesh *grid, struct cml_error *err);

/* Extends a cell's depth range to include the depths least..most (cm, centred frame), rounded outwards. */
void cml_grid_mesh_widen_depths(const struct cml_grid_mesh *grid, double least, double most,
                                struct cml_grid_mesh_depths *depths);

/* Fills the depths of all blocks, and the mean depth, from the depths of the cells. */
void cml_grid_mesh_build_levels(struct cml_grid_mesh *grid);

/* Frees the cells and zeroes the structure. */
void cml_grid_mesh_clear(struct cml_grid_mesh *grid);

/* Returns the bytes of memory that *grid owns; 0 without cells. */
double cml_grid_mesh_bytes(const struct cml_grid_mesh *grid);
