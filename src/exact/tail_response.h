/* Fills the table of expected values below a level of flat layers (scene/flat_tail.h), by adding-doubling in
 * directions without weight. SPDX-License-Identifier: MIT */
#pragma once

#include "exact/directions.h"
#include "scene/flat_tail.h"

/* Makes the table for the level that lies z cm below the top of `layer`, of media[num_layers + 2]. From the
 * level on, this layer and all below must be flat. The error of an expected value is below 1e-5 of the value,
 * except for grazing light that scores less than 1e-3 of the largest value. CML_E_INPUT: out of memory;
 * CML_E_NUMERIC: too much work, or the accuracy is not reached. On success the caller clears *tail. */
CML_NODISCARD cml_status cml_tail_create(const struct cml_medium_def *media, int num_layers, int layer,
                                         double z, struct cml_flat_tail *tail, struct cml_error *err);
