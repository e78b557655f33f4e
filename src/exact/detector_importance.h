/* What light at a place is worth to a detector: which share of it, were it the same in all directions, leaves
 * where the detector looks. By the diffusion equation, which is its own adjoint, in finite volumes of rings
 * and depths [Haskell and others: Boundary conditions for the diffusion equation in radiative transfer, J.
 * Opt. Soc. Am. A 11, 2727 (1994)]. SPDX-License-Identifier: MIT */
#pragma once

#include "scene/scene.h"

/* A ring on the face above or below, in cm about its middle. */
struct cml_seen_ring {
    bool below;
    double inner, outer;
};

/* Over rings about that middle, whose borders lie at reach (i / rings)^2, and `cells` equal parts of `depth`,
 * at most that of all layers: value[rings][cells]. media: [layers + 2], planes between them. It knows no
 * directions, and nothing of light within a transport mean free path: good enough for weights. CML_E_INPUT:
 * out of memory. */
CML_NODISCARD cml_status cml_importance_of_place(const struct cml_medium_def *media, int layers,
                                                 struct cml_seen_ring seen, double reach, double depth,
                                                 int rings, int cells, double *value, struct cml_error *err);
