/* When a run with --target-error may end. SPDX-License-Identifier: MIT */
#pragma once

#include "tally/result.h"

/* Shares of the launched weight below this are not looked at: a total that hardly scores would keep
 * --target-error flying for ever. */
#define CML_TARGET_LEAST_SHARE 1e-3

/* Nothing is judged before so many photons: a total of the least share then has ten packets, and is seen. */
#define CML_TARGET_LEAST_PHOTONS 10000

/* Whether each of Rd, A and Tt of a complete round has a relative standard error of at most `target`, or is
 * by three standard errors below the least share. Where there are expected values, each of them in place of
 * Tt has such an error, however small it is. of: not 0: that alone has, as of cml_target_error_of. */
bool cml_target_met(const struct cml_result *result, double target, int of);

/* The relative standard error of what --error-of names: above 0 what layer `of` absorbs, as expected where
 * that is known (P15), below 0 what detector -of sees, from 1. INFINITY where nothing
 * was. */
double cml_target_error_of(const struct cml_result *result, int of);
