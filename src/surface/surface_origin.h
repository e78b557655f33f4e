/* From where x and y count where places are in single precision. It tells places the more coarsely the
 * further they are from there, so the origin lies where the scene is, and what is asked of a place too far
 * from it is refused. P1 is the rule. SPDX-License-Identifier: MIT */
#pragma once

#include "scene/scene.h"

/* Lengths in cm. Within a distance single precision tells places to a share of every length in question. */
struct cml_origin {
    double at[2];  /* scene position */
    double flight; /* the distance from which light may come to shapes, bodies and detectors in one flight;
                    * infinite without any */
    double all;    /* the distance for all these and the bins of results */
};

/* CML_E_INPUT: "FILE:LINE: boundary 1: mesh at (1e+06 0) cm: ...": parts of the scene lie too far from each
 * other. */
CML_NODISCARD cml_status cml_surface_origin(const struct cml_scene *scene, struct cml_origin *origin,
                                            struct cml_error *err);
