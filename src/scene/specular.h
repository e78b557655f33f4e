/* What original MCML takes as specular reflection of a pencil at normal incidence (P1).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/scene.h"

/* Shares of the light. Of a clear first layer between planes, `glass`, both faces count, and `between` is
 * what goes up in it, summed over all ways to and fro; else it is 0. */
struct cml_specular {
    bool glass;
    double reflected, between;
};

/* media: [num_layers + 2]. Boundary 0 is a plane; planes: so is boundary 1. [MCML manual,
 * equations 3.2a to 3.4] */
struct cml_specular cml_specular_split(const struct cml_medium_def *media, int num_layers, bool planes);
