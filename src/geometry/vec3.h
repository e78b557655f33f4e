/* Vectors of three doubles for code on triangles. Sums are taken from left to right. `out` may be one of the
 * arguments only where the comment says so. SPDX-License-Identifier: MIT */
#pragma once

#include <math.h>

/* Returns the smaller of two numbers, the second one if one of them is NaN. Avoids a call of the library
 * (fmin). */
static inline double cml_smaller(double a, double b)
{
    return a < b ? a : b;
}

/* Returns the larger of two numbers, the second one if one of them is NaN. Avoids a call of the library
 * (fmax). */
static inline double cml_larger(double a, double b)
{
    return a > b ? a : b;
}

/* Sets out = a - b; out may be a or b. */
static inline void cml_vec3_subtract(const double a[3], const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++) out[k] = a[k] - b[k];
}

/* Sets out = a + s b; out may be a or b. */
static inline void cml_vec3_add_scaled(const double a[3], double s, const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++) out[k] = a[k] + s * b[k];
}

/* Copies a vector. */
static inline void cml_vec3_copy(const double from[3], double to[3])
{
    for (int k = 0; k < 3; k++) to[k] = from[k];
}

/* Sets out to the cross product a x b; out may be neither a nor b. */
static inline void cml_vec3_cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Returns the scalar product a . b. */
static inline double cml_vec3_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Returns the length of a vector. */
static inline double cml_vec3_length(const double a[3])
{
    return sqrt(cml_vec3_dot(a, a));
}

/* Scales a, which must not be 0, to length 1. */
static inline void cml_vec3_normalise(double a[3])
{
    const double k = 1 / cml_vec3_length(a);
    for (int i = 0; i < 3; i++) a[i] *= k;
}

/* Finds two unit vectors e1, e2 perpendicular to a unit axis and to each other. */
static inline void cml_vec3_frame(const double axis[3], double e1[3], double e2[3])
{
    const int thin = fabs(axis[0]) < 0.6 ? 0 : 1;
    const double unit[3] = {thin == 0, thin == 1, 0};
    cml_vec3_cross(axis, unit, e1);
    cml_vec3_normalise(e1);
    cml_vec3_cross(axis, e1, e2);
}

/* Sets out = cross(b - a, c - a): the normal of the triangle a b c, on the side from which a, b, c run
 * counter-clockwise, twice as long as the area. */
static inline void cml_vec3_area(const double a[3], const double b[3], const double c[3], double out[3])
{
    double u[3], v[3];
    cml_vec3_subtract(b, a, u);
    cml_vec3_subtract(c, a, v);
    cml_vec3_cross(u, v, out);
}

/* Returns twice the signed area of the triangle o p q in the plane of x and y, positive if counter-clockwise.
 * Rounded: where the sign matters, use cml_orient2d (predicate.h). */
static inline double cml_vec2_area(const double o[2], const double p[2], const double q[2])
{
    return (p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0]);
}
