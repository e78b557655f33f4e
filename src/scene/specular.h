/* Specular reflection as original MCML defines it, for a pencil beam at normal incidence (rule P1).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/scene.h"

/* Specular shares of the incident light. `glass`: the first layer is clear and lies between two planes. Then
 * `reflected` counts both faces of that layer, and `between` is the light that travels up inside it, summed
 * over all passages. Without glass, `between` is 0. */
struct cml_specular {
    bool glass;
    double reflected, between;
};

/* Computes the specular shares of the incident light [MCML manual, equations 3.2a to 3.4]. media: [num_layers
 * + 2]. n: index of the medium from which the light comes. Boundary 0 must be a plane. planes: true if
 * boundary 1 is a plane, too. */
struct cml_specular cml_specular_split(const struct cml_medium_def *media, double n, int num_layers,
                                       bool planes);
