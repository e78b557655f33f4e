/* clustermcml run --aim: below all shapes, bodies and beams a scene is flat, and what becomes of light there
 * is known (P15 of kernels/README.md). SPDX-License-Identifier: MIT */
#ifndef CML_AIM_H
#define CML_AIM_H

#include "scene/flat_tail.h"
#include "surface/surface.h"
#include "tally/result.h"

/* A level below which all is flat: in this layer, z cm below its top; `depth` in the scene. layer 0: there is
 * none, and `why` says what is in the way. */
struct cml_aim_level {
    int layer;
    double z, depth;
    const char *why;
};
struct cml_aim_level cml_aim_level_of(const struct cml_scene *scene, const struct cml_surface_set *surfaces);

/* The level's depth where --aim would save photons for Tt, as this result of counting shows it: NaN where
 * there is no level, or nothing much to be gained. */
double cml_aim_proposal(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                        const struct cml_result *result);

/* Checks what --aim asks for, and computes what is expected of light below the level. CML_E_INPUT: the scene
 * has no level, or nothing below it is aimed at, "FILE:LINE: --aim A_l:1 (expected ...)"; CML_E_NUMERIC:
 * adding-doubling has no answer. On success the caller clears *tail. */
CML_NODISCARD cml_status cml_aim_create(const char *aim, const struct cml_scene *scene,
                                        const struct cml_surface_set *surfaces, struct cml_flat_tail *tail,
                                        struct cml_error *err);

#endif
