/* Detected light and expected values: shares, means weighted by packets' weights, and their errors.
 * SPDX-License-Identifier: MIT */
#include "tally/result.h"

#include <math.h>

void cml_result_detected(const struct cml_result *result, int k, double *value, double *error)
{
    *value =
        cml_result_sum(result, CML_ARRAY_detector, (size_t)k) * (CML_WEIGHT_UNIT / (double)result->photons);
    *error = cml_result_sum_error(result, CML_ARRAY_detector, (size_t)k);
}

void cml_result_expected(const struct cml_result *result, int score, double *value, double *error)
{
    *value = cml_result_sum(result, CML_ARRAY_expected, (size_t)score) *
             (CML_WEIGHT_UNIT * CML_EXPECTED_UNIT) / (double)result->photons;
    *error = cml_result_sum_error(result, CML_ARRAY_expected, (size_t)score) * CML_EXPECTED_UNIT;
}

/* The last layers of a scene have scores. */
void cml_result_expected_layer(const struct cml_result *result, int layer, double *value, double *error)
{
    const int score = layer - (result->grid.num_layers + 1 - result->grid.scores);
    if (score > 0) {
        cml_result_expected(result, score, value, error);
        return;
    }
    *value = cml_result_absorbed(result, layer);
    *error = cml_result_absorbed_error(result, layer);
}

/* The mean is R = sum X / sum Y. Its standard error comes from the batches, which differ from R by (X_b - R
 * Y_b) / sum Y [Cochran, Sampling Techniques, section 6.3]. */
double cml_result_mean(const struct cml_result *result, const cml_u128 *moment, int n, int i, int k,
                       double *error)
{
    const int detectors = result->grid.detectors;
    const double bottom = cml_result_bin_sum(result->detector, detectors, k),
                 mean = cml_result_bin_sum(moment, n, i) / bottom;
    double squares = 0, batches = 0;
    /* Number of batches that saw light. The mean of a single batch is the mean itself, so it says nothing
     * about the error, which then stays NaN. */
    int seen = 0;
    *error = NAN;
    if (!(bottom > 0)) return NAN;
    for (int b = 0; b < CML_NUM_BATCHES; b++) {
        if (cml_batch_size(result->photons, b) == 0) continue;
        const double x = (double)moment[(size_t)b * (size_t)n + (size_t)i],
                     y = (double)result->detector[(size_t)b * (size_t)detectors + (size_t)k];
        squares += (x - mean * y) * (x - mean * y);
        batches += 1;
        seen += y > 0;
    }
    if (seen > 1) *error = sqrt(squares * batches / (batches - 1)) / bottom;
    return mean;
}
