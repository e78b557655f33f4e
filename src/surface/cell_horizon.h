/* The horizon of every cell over a mesh, as a slope: how steeply a packet there must rise, or fall, to meet
 * the mesh never again. Exists because one steep facet anywhere would else decide for all packets.
 * SPDX-License-Identifier: MIT */
#ifndef CML_CELL_HORIZON_H
#define CML_CELL_HORIZON_H

#include "surface/clearance_map.h"

/* Level of the pyramid whose cells have a horizon. */
#define CML_HORIZON_LEVEL 1

/* Horizons of a mesh's map, whose pyramid is complete. steepest [cells of that level]: at least the slope of
 * every facet above the cell, infinite where one is upright or faces down. Fills map->horizon. CML_E_INPUT
 * when memory runs out. */
CML_NODISCARD cml_status cml_find_horizons(const float *steepest, struct cml_clearance_map *map,
                                           struct cml_error *err);

#endif
