/* Control variates: totals of a run made sharper by those of its twin, a run of the same photons in a scene
 * whose totals are known. [Lavenberg, Welch, Management Science 27, 322 (1981)] SPDX-License-Identifier: MIT
 */
#pragma once

#include "tally/result.h"

/* A share of the launched weight; error: no less than that of the value. */
struct cml_known {
    double value, error;
};

struct cml_controlled {
    double value, error; /* share of the launched weight, its standard error */
    double beta;         /* of what the twin is off by, the part that was taken off */
};

/* X - beta (Y - known) for the total X of the run and Y of the twin, both of the same number of photons; beta
 * is the slope of the regression of X on Y over the 64 batches. Its standard error is that of the regression
 * line where Y is as known, from the residuals of B batches with B - 2 degrees of freedom, and of one packet,
 * plus |beta| known->error. Where batches follow a normal distribution the value has no bias; else the bias
 * is of the order of error / 64. The run's own total and error, and beta 0, where fewer than 8 batches have
 * photons or the twin's batches are all alike. */
struct cml_controlled cml_control_total(const struct cml_result *run, const struct cml_result *twin,
                                        enum cml_total total, const struct cml_known *known);
