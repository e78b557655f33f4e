/* Specular reflection as original MCML defines it, for a pencil beam at normal incidence (rule P1).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/scene.h"

/* Specular shares of the light. If the first layer is clear and lies between planes (`glass`), `reflected`
 * counts both its faces, and `between` is the light that travels up inside it, summed over all passages. Else
 * `between` is 0. */
struct cml_specular {
    bool glass;
    double reflected, between;
};

/* Computes the specular shares. media: [num_layers + 2]. Boundary 0 must be a plane; planes: boundary 1 is
 * one, too. [MCML manual, equations 3.2a to 3.4] */
struct cml_specular cml_specular_split(const struct cml_medium_def *media, int num_layers, bool planes);
