/* What a flight in weight windows (P19 of kernels/README.md) costs that which it is not aimed at.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "cli/options/options.h"
#include "run/run.h"

/* Where the run that `setup` describes was flown in windows, and people read of it: says, on rank 0, how many
 * times the steps of a flight without them Rd, A and Tt take to the same error. Flies one, of few photons and
 * without results by place. Collective. */
void cml_unaimed_show(const struct cml_options *options, const struct cml_run_setup *setup,
                      const struct cml_run_result *run);
