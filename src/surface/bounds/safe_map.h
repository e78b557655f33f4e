/* Cubes in and around the box of a mesh that overhangs. Each cube knows a distance from its middle within
 * which there is no surface, so that most paths need no query (kernels/bounds.h, cml_path_is_safe).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "surface/tree/centred_mesh.h"

struct cml_safe_map {
    int n[3];               /* cells along each axis */
    double corner[3], cell; /* cm, centred frame; width of a cell */
    float *safe;            /* [n[2]][n[1]][n[0]] distance from a cell's middle to the closest facet, or to
                               the outer plane beyond the border, in cells, rounded down; NULL: no map */
};

/* Makes the map of a mesh that is not repeated, and of its outer plane if it has one. bytes: memory that the
 * map may use, about. Returns CML_E_INPUT if memory runs out; there is nothing to clear then. */
CML_NODISCARD cml_status cml_safe_map_create(const struct cml_centred_mesh *centred, double bytes,
                                             struct cml_safe_map *map, struct cml_error *err);

/* Frees the map's memory and zeroes the structure. */
void cml_safe_map_clear(struct cml_safe_map *map);

/* Returns the bytes of memory that the map owns. */
double cml_safe_map_bytes(const struct cml_safe_map *map);
