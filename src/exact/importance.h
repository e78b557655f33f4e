/* The importance of light at a depth: the share of isotropic light there that comes out below. Computed by
 * adding-doubling. By reciprocity it is the fluence that diffuse light from below makes at that depth,
 * divided by 4 and by the squared ratio of indices [Bell, Glasstone: Nuclear Reactor Theory, 1970, section
 * 6.1]. SPDX-License-Identifier: MIT */
#pragma once

#include "scene/scene.h"

/* Computes the importance of light that comes out of the first `layers` layers into medium layers + 1, which
 * has no end here. value: [cells], at the middles of equal parts of these layers' total depth. media: [layers
 * + 2]. Right to some per cent, enough for weight windows. CML_E_INPUT: out of memory; CML_E_NUMERIC: too
 * many directions. */
CML_NODISCARD cml_status cml_importance_of_depth(const struct cml_medium_def *media, int layers, int cells,
                                                 double *value, struct cml_error *err);
