/* SPDX-License-Identifier: MIT */
#include "tally/control.h"

#include <math.h>

/* Sums over batches of photons times products of deviations from the mean, in shares of a packet. */
struct moments {
    double batches, xx, xy, yy;
};

static double share_of_batch(const struct cml_result *result, int batch, enum cml_total total)
{
    return (double)result->totals[batch * CML_NUM_TOTALS + (int)total] * CML_WEIGHT_UNIT /
           (double)cml_batch_size(result->photons, batch);
}

static struct moments moments_of(const struct cml_result *run, const struct cml_result *twin,
                                 enum cml_total total)
{
    const double X = cml_result_total(run, total), Y = cml_result_total(twin, total);
    struct moments sum = {0, 0, 0, 0};
    for (int b = 0; b < CML_NUM_BATCHES; b++) {
        const double size = (double)cml_batch_size(run->photons, b);
        if (!(size > 0)) continue;
        const double x = share_of_batch(run, b, total) - X, y = share_of_batch(twin, b, total) - Y;
        sum.batches += 1;
        sum.xx += size * x * x;
        sum.xy += size * x * y;
        sum.yy += size * y * y;
    }
    return sum;
}

/* Below that slope and residuals of so few points are no estimates. */
#define LEAST_BATCHES 8

/* The variance of a value on a regression line has two parts, that of the mean and that of the slope. A third
 * is for what batches cannot show: that one packet of the run would fare otherwise than its twin where all
 * others do alike. */
struct cml_controlled cml_control_total(const struct cml_result *run, const struct cml_result *twin,
                                        enum cml_total total, const struct cml_known *known)
{
    const double X = cml_result_total(run, total), off = cml_result_total(twin, total) - known->value;
    const struct moments sum = moments_of(run, twin, total);
    if (sum.batches < LEAST_BATCHES || !(sum.yy > 0))
        return (struct cml_controlled){X, cml_result_error(run, total), 0};
    const double beta = sum.xy / sum.yy, left = fmax(0, sum.xx - beta * sum.xy);
    const double n = (double)run->photons;
    const double variance = left / (sum.batches - 2) * (1 / n + off * off / sum.yy) + 1 / (n * n);
    return (struct cml_controlled){X - beta * off, sqrt(variance) + fabs(beta) * known->error, beta};
}
