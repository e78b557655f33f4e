/* The origin of x and y in single precision (P1). The resolution of single precision becomes coarser with the
 * distance from the origin. Therefore the origin lies where the scene is, and a scene with parts too far from
 * each other is refused. SPDX-License-Identifier: MIT */
#pragma once

#include "scene/scene.h"

/* The origin and its reach, in cm. Within the reach, single precision resolves every length that matters. */
struct cml_origin {
    double at[2];  /* scene position of x = y = 0 */
    double flight; /* reach for shapes, bodies and detectors: light may come to them from that distance in one
                      flight; infinite without any of them */
    double all;    /* reach for shapes, bodies, detectors and the bins of results */
};

/* Finds the origin. Returns CML_E_INPUT if parts of the scene lie too far from each other: "FILE:LINE:
 * boundary 1: mesh at (1e+06 0) cm: ...". */
CML_NODISCARD cml_status cml_surface_origin(const struct cml_scene *scene, struct cml_origin *origin,
                                            struct cml_error *err);
