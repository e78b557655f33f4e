/* Vectors of three doubles: what the files about triangles share. Results do not depend on who inlines them:
 * every sum is taken from left to right. SPDX-License-Identifier: MIT */
#ifndef CML_VEC3_H
#define CML_VEC3_H

#include <math.h>

/* out = a - b; out may be a or b */
static inline void cml_vec3_subtract(const double a[3], const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++) out[k] = a[k] - b[k];
}

/* out = a + s b; out may be a or b */
static inline void cml_vec3_add_scaled(const double a[3], double s, const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++) out[k] = a[k] + s * b[k];
}

/* out must be neither a nor b */
static inline void cml_vec3_cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static inline double cml_vec3_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double cml_vec3_length(const double a[3])
{
    return sqrt(cml_vec3_dot(a, a));
}

/* a may not be 0 */
static inline void cml_vec3_normalise(double a[3])
{
    const double k = 1 / cml_vec3_length(a);
    for (int i = 0; i < 3; i++) a[i] *= k;
}

static inline void cml_vec3_copy(const double from[3], double to[3])
{
    for (int k = 0; k < 3; k++) to[k] = from[k];
}

/* (b - a) x (c - a): normal of a triangle, twice its area long */
static inline void cml_vec3_normal(const double a[3], const double b[3], const double c[3], double out[3])
{
    double ab[3], ac[3];
    cml_vec3_subtract(b, a, ab);
    cml_vec3_subtract(c, a, ac);
    cml_vec3_cross(ab, ac, out);
}

#endif
