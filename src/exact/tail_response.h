/* What becomes of light that goes down through a level of flat layers (scene/flat_tail.h), by adding-doubling
 * in directions without weight. SPDX-License-Identifier: MIT */
#pragma once

#include "exact/directions.h"
#include "scene/flat_tail.h"

/* The level lies z cm below the top of `layer` of media[num_layers + 2], which is from there to its boundary
 * below as flat as all that follows. The error of a response is below 1e-5 of itself, grazing light of which
 * less than 1e-3 of the most comes through aside. CML_E_INPUT: out of memory; CML_E_NUMERIC: too much work,
 * or no such accuracy. On success the caller clears *tail. */
CML_NODISCARD cml_status cml_tail_create(const struct cml_medium_def *media, int num_layers, int layer,
                                         double z, struct cml_flat_tail *tail, struct cml_error *err);
