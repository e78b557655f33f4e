/* The horizon of every cell over a mesh, as a slope: how steeply a packet there must rise, or fall, to meet
 * the mesh never again. Exists because one steep facet anywhere would else decide for all packets.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>

/* Level of the pyramid whose cells have a horizon. */
#define CML_HORIZON_LEVEL 1
#define CML_HORIZON_MOST_LEVELS 10 /* of a pyramid */

/* Depths of a mesh over the squares of the x-y plane, level after level, each of half as many cells along an
 * axis as the one before. */
struct cml_depth_pyramid {
    int levels, size;               /* of level 0: cells along an axis */
    double cell;                    /* of level 0, cm; the shorter side */
    bool repeats;                   /* what lies beyond one end begins again at the other */
    const float *deepest, *highest; /* [cells of all levels] greatest and least z, cm */
};

/* The horizons of the cells of level CML_HORIZON_LEVEL, seen from below and from above the mesh; below and
 * above are [cells of that level] and the caller's. steepest [the same]: at least the slope of every facet
 * above the cell, infinite where one is upright or faces down. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_find_horizons(const struct cml_depth_pyramid *pyramid, const float *steepest,
                                           float *below, float *above, struct cml_error *err);
