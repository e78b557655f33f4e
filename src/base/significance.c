/* Formulas for the probability of deviations. SPDX-License-Identifier: MIT */
#include "base/significance.h"

#include <math.h>

double cml_normal_of_student(double t, double freedom)
{
    if (!(freedom < INFINITY) || !(fabs(t) < INFINITY)) return t;
    const double z = (8 * freedom + 1) / (8 * freedom + 3) * sqrt(freedom * log1p(t * t / freedom));
    return copysign(z, t);
}

double cml_two_sided(double z)
{
    return erfc(fabs(z) / sqrt(2.0));
}

double cml_sidak(double p, double tests)
{
    return tests > 0 ? -expm1(tests * log1p(-p)) : 1;
}
