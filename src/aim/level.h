/* The level below which a scene is flat. The further fate of light is known there without simulation (P15).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "surface/surface.h"
#include "tally/result.h"

/* A level below which all of the scene is flat: its layer, z cm below the layer's top, and its depth in the
 * scene, cm. layer is 0 if the scene has no such level. */
struct cml_aim_level {
    int layer;
    double z, depth;
};

/* Returns the highest level below which the scene is flat; its layer is 0 if there is none or if the scene
 * has a backing. */
struct cml_aim_level cml_aim_level_of(const struct cml_scene *scene, const struct cml_surface_set *surfaces);

/* Returns the level's depth, cm, if --aim would save photons for Tt, judged by the `result` of a run that
 * counted exits. Returns NaN if there is no level or if little would be gained. */
double cml_aim_proposal(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                        const struct cml_result *result);
