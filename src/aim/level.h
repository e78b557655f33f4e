/* The level below which a scene is flat, so that what becomes of light there is known (P15).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "surface/surface.h"
#include "tally/result.h"

/* A level below which all is flat: in this layer, z cm below its top; `depth` in the scene. layer 0: there is
 * none. */
struct cml_aim_level {
    int layer;
    double z, depth;
};
struct cml_aim_level cml_aim_level_of(const struct cml_scene *scene, const struct cml_surface_set *surfaces);

/* The level's depth where --aim would save photons for Tt, as this result of counting shows it: NaN where
 * there is no level, or nothing much to be gained. */
double cml_aim_proposal(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                        const struct cml_result *result);
