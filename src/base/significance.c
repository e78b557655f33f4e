/* SPDX-License-Identifier: MIT */
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

/* Newton's steps in log p, whose curve over z^2 is nearly straight. */
double cml_two_sided_limit(double p)
{
    double z = 1;
    for (int i = 0; i < 60; i++) {
        const double tail = cml_two_sided(z), density = sqrt(2 / acos(-1.0)) * exp(-z * z / 2);
        z += tail / density * log(tail / p);
    }
    return z;
}

double cml_sidak(double p, double tests)
{
    return tests > 0 ? -expm1(tests * log1p(-p)) : 1;
}

double cml_sidak_level(double level, double tests)
{
    return tests > 0 ? -expm1(log1p(-level) / tests) : level;
}
