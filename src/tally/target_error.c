/* SPDX-License-Identifier: MIT */
#include "tally/target_error.h"

#include <math.h>

/* True if a total meets the target, or lies below the least share by three standard errors. */
static bool settled(const struct cml_result *result, enum cml_total total, double target)
{
    const double share = cml_result_total(result, total), error = cml_result_error(result, total);
    return error <= target * share || share + 3 * error < CML_TARGET_LEAST_SHARE;
}

/* True if all expected values meet the target. Small values count, too, because the user aims at them. */
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

double cml_target_error_of(const struct cml_result *result, int of)
{
    double value, error;
    if (of > 0)
        cml_result_expected_layer(result, of, &value, &error);
    else
        cml_result_detected(result, -of - 1, &value, &error);
    return value > 0 && error > 0 ? error / value : INFINITY;
}

/* Too few photons leave the error itself unknown, so the run goes on. */
bool cml_target_met(const struct cml_result *result, double target, int of)
{
    if (result->photons < CML_TARGET_LEAST_PHOTONS) return false;
    if (of) return cml_target_error_of(result, of) <= target;
    return settled(result, CML_TOTAL_REFLECTED, target) && settled(result, CML_TOTAL_ABSORBED, target) &&
           (result->grid.scores > 0 ? expected_settled(result, target)
                                    : settled(result, CML_TOTAL_TRANSMITTED, target));
}
