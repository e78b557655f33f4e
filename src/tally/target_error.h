/* Decides when a run with --target-error may end. SPDX-License-Identifier: MIT */
#pragma once

#include "tally/result.h"

/* Smallest share of the launched weight that is judged. Otherwise a total with hardly any light would keep a
 * run with --target-error flying for ever. */
#define CML_TARGET_LEAST_SHARE 1e-3

/* Smallest number of photons that is judged. A total of the least share then has ten packets, so it is not
 * overlooked. */
#define CML_TARGET_LEAST_PHOTONS 10000

/* True if each of Rd, A and Tt has a relative standard error of at most `target`, or lies three standard
 * errors below the least share. The result must be a complete round. If there are expected values, each of
 * these takes the place of Tt, however small it is. of: if not 0, only this number is judged, named as in
 * cml_target_error_of. */
bool cml_target_met(const struct cml_result *result, double target, int of);

/* Returns the relative standard error of the number that --error-of names. of > 0: absorption of layer `of`,
 * its expected value if known (rule P15); of < 0: detector -of, counted from 1. Returns INFINITY if the
 * number or its error is 0, because no light has arrived. */
double cml_target_error_of(const struct cml_result *result, int of);
