/* Builds the min/max pyramids of kernels/bounds.h from rings or triangles.
 * Conservative: every cell's bounds hold for the whole surface above it, and are widened by more than the
 * rounding that single precision adds to positions and cell numbers. SPDX-License-Identifier: MIT */
#pragma once

#include "boundary.h"
#include "geometry/mesh.h"
#include "scene/scene.h"

/* One surface's pyramid: all levels one behind the other, level 0 first. */
struct cml_depth_map {
    int levels, size;
    enum cml_bounds_form form; /* CML_BOUNDS_RADII: cells in a row from the axis outwards, else in a square */
    double corner[2], cell[2]; /* cm; corner from the scene's z axis; cells are squares but those of a tile */
    size_t cells;              /* of all levels */
    float *deepest, *highest;  /* [cells] greatest and least z, boundary's frame, cm */
    float *horizon[2];         /* of a mesh (cell_horizon.h): seen from below and from above; NULL of rings */
    size_t horizon_cells;
};

/* Bounds of a mesh in its boundary's frame, x and y from the scene's axis, or of a field of n rings (z =
 * depth at r). The size follows from the number of triangles or rings, at most 512 x 512 cells or 1024 in a
 * row. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_depth_map_of_mesh(const struct cml_mesh *mesh, struct cml_depth_map *map,
                                               struct cml_error *err);
CML_NODISCARD cml_status cml_depth_map_of_rings(const double *r, const double *z, int n,
                                                struct cml_depth_map *map, struct cml_error *err);

/* Bounds of a tile, whose heights count up from z = 0: over one period, or over as many along the shorter
 * axis as make the cells about square. */
CML_NODISCARD cml_status cml_depth_map_of_tile(const struct cml_heightmap *tile, struct cml_depth_map *map,
                                               struct cml_error *err);

/* The number of cells of one level. */
size_t cml_depth_map_level_cells(const struct cml_depth_map *map, int level);

void cml_depth_map_clear(struct cml_depth_map *map);
