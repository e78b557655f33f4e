/* Safe distances around a mesh that overhangs: cubes in and around its box, and how far from the middle of
 * each no part of the surface is (kernels/clearance.h, cml_path_is_safe). SPDX-License-Identifier: MIT */
#ifndef CML_SAFE_MAP_H
#define CML_SAFE_MAP_H

#include "base/status.h"

struct cml_mesh_surface;

struct cml_safe_map {
    int n[3];
    double corner[3], cell; /* cm: boundary's frame, x and y of the scene; width of a cell */
    float *safe;            /* [n[2]][n[1]][n[0]] distance from the middle of a cell to the closest facet, or
                             * to the outer plane beyond the border, cells: rounded down; NULL: no map */
};

/* Of a mesh that is not repeated, and its outer plane if it has one. CML_E_INPUT when memory runs out, and
 * then there is nothing to clear. */
CML_NODISCARD cml_status cml_safe_map_create(const struct cml_mesh_surface *mesh, struct cml_safe_map *map,
                                             struct cml_error *err);
void cml_safe_map_clear(struct cml_safe_map *map);

double cml_safe_map_bytes(const struct cml_safe_map *map);

#endif
