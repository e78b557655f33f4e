/* Computes the horizon of every cell over a mesh: the slope above which a packet that rises (or falls) from
 * there never meets the mesh again. One horizon for the whole mesh would not do, since one steep facet
 * anywhere would then decide for all packets.
 *
 *                    . '         steeper than the horizon: meets nothing again
 *                 . '      . -   horizon of x
 *              . '  . - ' /\
 *     ______x ' - '     /  \
 *            \_________/    \____
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>

/* Level of the pyramid whose cells have a horizon. */
#define CML_HORIZON_LEVEL 1
#define CML_HORIZON_MOST_LEVELS 10 /* largest number of levels of a pyramid */

/* Depths of a mesh over squares of the x-y plane: levels of cells, each level with half as many cells along
 * an axis as the level before. */
struct cml_depth_pyramid {
    int levels, size;               /* number of levels; cells of level 0 along an axis */
    double cell;                    /* shorter side of a cell of level 0, cm */
    bool repeats;                   /* the mesh repeats: beyond one end begins the other */
    const float *deepest, *highest; /* [cells of all levels] greatest and least z above each cell, cm */
};

/* Computes the horizons of the cells of level CML_HORIZON_LEVEL, seen from below and from above the mesh.
 * below and above: [cells of that level], the caller's arrays. steepest: [same cells] a bound of the slope of
 * every facet above the cell, infinite if a facet is upright or faces down. Returns CML_E_INPUT if memory
 * runs out. */
CML_NODISCARD cml_status cml_find_horizons(const struct cml_depth_pyramid *pyramid, const float *steepest,
                                           float *below, float *above, struct cml_error *err);
