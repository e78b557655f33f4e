/* SPDX-License-Identifier: MIT */
#include "tally/target_error.h"

/* A total just below the least share ends the run all the same, when its own error is small enough. */
static bool settled(const struct cml_result *result, enum cml_total total, double target)
{
    const double share = cml_result_total(result, total), error = cml_result_error(result, total);
    return error <= target * share || share + 3 * error < CML_TARGET_LEAST_SHARE;
}

/* However small they are: somebody aims at them. */
static bool expected_settled(const struct cml_result *result, double target)
{
    bool all = true;
    for (int i = 0; i < result->grid.scores; i++) {
        double value, error;
        cml_result_expected(result, i, &value, &error);
        all &= error <= target * value;
    }
    return all;
}

bool cml_target_met(const struct cml_result *result, double target)
{
    return result->photons >= CML_TARGET_LEAST_PHOTONS && settled(result, CML_TOTAL_REFLECTED, target) &&
           settled(result, CML_TOTAL_ABSORBED, target) &&
           (result->grid.scores > 0 ? expected_settled(result, target)
                                    : settled(result, CML_TOTAL_TRANSMITTED, target));
}
