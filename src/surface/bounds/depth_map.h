/* Builds the min/max pyramids of kernels/bounds.h from rings or triangles. Every cell's bounds hold for the
 * whole surface above it. They are widened by more than the rounding that single precision adds to positions
 * and cell numbers. SPDX-License-Identifier: MIT */
#pragma once

#include "boundary.h"
#include "geometry/mesh.h"
#include "scene/scene.h"

/* The pyramid of one surface: all levels one behind the other, level 0 first. The caller clears a map that
 * the functions below have made, also after a failure. */
struct cml_depth_map {
    int levels, size;
    enum cml_bounds_form form; /* CML_BOUNDS_RADII: cells in a row from the axis outwards; else cells in a
                                  square */
    double corner[2], cell[2]; /* corner: smallest x and y of the map from the scene's z axis, cm; cell: size
                                  of a cell, cm, equal along x and y except on a tile */
    size_t cells;              /* number of cells of all levels */
    float *deepest, *highest;  /* [cells] greatest and least z, boundary's frame, cm */
    float *horizon[2];         /* horizons of a mesh (cell_horizon.h), seen from below and from above; NULL
                                  for rings */
    size_t horizon_cells;
};

/* Builds the map of a mesh in its boundary's frame, x and y from the scene's axis. The number of triangles
 * determines the size, at most 512 x 512 cells. Returns CML_E_INPUT if memory runs out. */
CML_NODISCARD cml_status cml_depth_map_of_mesh(const struct cml_mesh *mesh, struct cml_depth_map *map,
                                               struct cml_error *err);

/* Builds the map of a radial heightfield of n rings, z[i] at radius r[i]: at most 1024 cells in a row.
 * Returns CML_E_INPUT if memory runs out. */
CML_NODISCARD cml_status cml_depth_map_of_rings(const double *r, const double *z, int n,
                                                struct cml_depth_map *map, struct cml_error *err);

/* Builds the map of a tile, whose heights count up from z = 0. The map covers one period or, along the
 * shorter axis of the period, several, so that cells are about square. Returns CML_E_INPUT if memory runs
 * out. */
CML_NODISCARD cml_status cml_depth_map_of_tile(const struct cml_heightmap *tile, struct cml_depth_map *map,
                                               struct cml_error *err);

/* Returns the number of cells of one level. */
size_t cml_depth_map_level_cells(const struct cml_depth_map *map, int level);

/* Frees the map's memory and zeroes the structure. */
void cml_depth_map_clear(struct cml_depth_map *map);
