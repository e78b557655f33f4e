/* SPDX-License-Identifier: MIT */
#include "result/scaling.h"

#include "base/constants.h"

#include <math.h>

double cml_angle_width(int na)
{
    return CML_PI / 2 / na;
}

double cml_ring_area(double dr, int ir)
{
    return 2 * CML_PI * (ir + 0.5) * dr * dr;
}

double cml_solid_angle(double da, int ia)
{
    return 2 * CML_PI * sin((ia + 0.5) * da) * da;
}

double cml_projected_solid_angle(double da, int ia)
{
    return 2 * CML_PI * sin(da / 2) * sin(2 * (ia + 0.5) * da);
}

/* Returns the solid angle (sr) of a bin of directions. With cos differences as a product of sines no digits
 * are lost: cos(a) - cos(b) = 2 sin((a + b) / 2) sin((b - a) / 2). */
double cml_direction_solid_angle(int nt, int np, int it)
{
    const double dt = cml_angle_width(nt);
    return 2 * sin((it + 0.5) * dt) * sin(dt / 2) * (2 * CML_PI / np);
}
