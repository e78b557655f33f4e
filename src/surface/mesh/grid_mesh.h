/* Recognises a mesh whose vertices lie on a regular grid, as sampled heights do: which facets cover each
 * cell, and between which depths. Facets may be merged ones (heightmap.h): their sides run along grid lines
 * or the cells' diagonals, so that no cell has more than two. Parts outside the grid's rectangle, such as a
 * skirt, may have any shape. Knows no rays.
 *
 * Above the cells stands a min/max pyramid, as quadtree displacement mapping and maximum mipmaps have it
 * [Tevs, Ihrke and Seidel, I3D 2008], with 4 x 4 children to a block instead of 2 x 2: cells and blocks lie
 * in memory by tiles of 4 x 4, a cache line of depths each, and a block's children are one tile. Depths are
 * rounded outwards to 16 bits: those of a mesh of 1e6 facets fit into a processor's second cache. A mesh that
 * is no regular grid may get cells and a pyramid as well, but lists of facets in its cells: sheet_mesh.h.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "surface/mesh/mesh_query.h"

#define CML_GRID_MESH_NO_FACET 0x7fffffffu
#define CML_GRID_MESH_FALLING                                                                                \
    0x80000000u /* the cell's diagonal runs from (1, 0) to (0, 1), not (0, 0) to (1, 1) */

#define CML_GRID_MESH_LEVELS 15 /* enough for 2^28 cells along an axis */

/* Numbers of the facets at a cell's lower and upper side in y, often the same; both with
 * CML_GRID_MESH_FALLING or both without; CML_GRID_MESH_NO_FACET where the mesh has none. */
struct cml_grid_mesh_cell {
    uint32_t south, north;
};

/* Copies of the planes of the cell's facets (struct cml_centred_mesh), together in a cache line. */
struct cml_grid_mesh_planes {
    double south[4], north[4];
};

/* A facet of a sheet, all that a walk asks of it in one cache line. */
struct cml_sheet_facet {
    _Alignas(64) double plane[4]; /* a copy, as above */
    double corner[2];             /* x and y of corner 0, centred frame, cm */
    float weight[2][2]; /* how the barycentric weights of corners 1 and 2 rise along x and y, 1/cm; NaN where
                         * the facet is too thin for float */
};

/* Depths in steps above cml_grid_mesh.z: of the facets, widened by err_float and by what err_cell makes on
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
    double err_cell;        /* see rounding.h */
    double inner[2][2]; /* centred frame, cm: [0] lower, [1] upper corner of the grid less err_cell; NaN where
                         * a cell lacks a facet */
    int n[2];           /* cells along x and y */
    bool is_whole;      /* the mesh has no facets outside the grid */
    struct cml_grid_mesh_cell *cell;     /* owned; by cml_grid_mesh_index of level 0; NULL in a sheet */
    struct cml_grid_mesh_planes *planes; /* likewise */
    uint32_t *first;  /* owned; of a sheet: where in `listed` the facets of a cell begin, and those of the
                       * next;  NULL in a regular grid */
    uint32_t *listed; /* owned; numbers of facets */
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

/* *grid owns its cells; none (levels 0) when the mesh is no regular grid. CML_E_INPUT for memory. */
CML_NODISCARD cml_status cml_grid_mesh_find(const struct cml_centred_mesh *centred,
                                            struct cml_grid_mesh *grid, struct cml_error *err);
void cml_grid_mesh_clear(struct cml_grid_mesh *grid);

/* Bytes of all that *grid owns; 0 without cells. */
double cml_grid_mesh_bytes(const struct cml_grid_mesh *grid);
