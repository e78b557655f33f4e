/* What light at a depth is worth: which share of it, were it the same in all directions, comes out below, by
 * adding-doubling. By reciprocity that is the fluence which diffuse light from below makes there, over 4 and
 * the squared ratio of indices [Bell, Glasstone: Nuclear Reactor Theory, 1970, section 6.1].
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/scene.h"

/* The importance of light that comes out of the first `layers` layers into medium layers + 1, which has no
 * end here. value: [cells], in the middles of as many equal parts of those layers' depth. media: [layers +
 * 2]. Good to some per cent, as weights want it. CML_E_INPUT: out of memory; CML_E_NUMERIC: too many
 * directions. */
CML_NODISCARD cml_status cml_importance_of_depth(const struct cml_medium_def *media, int layers, int cells,
                                                 double *value, struct cml_error *err);
