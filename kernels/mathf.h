/* Logarithm and circle points with stated errors: in float our own polynomials, which vectorise and give the
 * same bits with every compiler; in double the C library's functions. Coefficients: Cephes (S. Moshier),
 * logf, sinf, cosf. SPDX-License-Identifier: MIT */
#ifndef CML_MATHF_H
#define CML_MATHF_H

#include "port.h"

#if !defined(CML_DOUBLE)
CML_FN cml_u32 cml_bits_of(float x)
{
#ifdef __OPENCL_VERSION__
    return as_uint(x);
#else
    cml_u32 bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
#endif
}

CML_FN float cml_float_of(cml_u32 bits)
{
#ifdef __OPENCL_VERSION__
    return as_float(bits);
#else
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
#endif
}
#endif

/* Natural logarithm. x: normal, > 0. Relative error < 1.2e-7 in float (unit.mathf), the C library's in
 * double. */
CML_FN real cml_log(real x)
{
#ifdef CML_DOUBLE
    return log(x);
#else
    /* x = 2^e m, sqrt(1/2) <= m < sqrt(2): the constant moves the cut between two exponents to sqrt(1/2) */
    const cml_u32 shifted = cml_bits_of(x) - 0x3f3504f3u;
    const int e = (int)shifted >> 23;
    const float m = cml_float_of((shifted & 0x007fffffu) + 0x3f3504f3u) - 1.0f;
    const float z = m * m;
    float p = 7.0376836292e-2f;
    p = p * m - 1.1514610310e-1f;
    p = p * m + 1.1676998740e-1f;
    p = p * m - 1.2420140846e-1f;
    p = p * m + 1.4249322787e-1f;
    p = p * m - 1.6668057665e-1f;
    p = p * m + 2.0000714765e-1f;
    p = p * m - 2.4999993993e-1f;
    p = p * m + 3.3333331174e-1f;
    p = p * m * z - 2.12194440e-4f * (float)e - 0.5f * z;
    return m + p + 0.693359375f * (float)e;
#endif
}

/* A point of the unit circle at a uniform angle from the upper 24 bits of a word: quadrant from 2 bits, angle
 * within
 * +-pi/4 from 22. Absolute error of either coordinate < 1.2e-7 in float, 2e-16 in double. */
CML_FN void cml_circle_point(cml_u32 word, real *c, real *s)
{
    const cml_u32 quadrant = word >> 30;
    const int odd = 2 * (int)((word >> 8) & 0x3fffffu) + 1 - 4194304;
    const real x = (real)odd * (real)1.8725351414619643e-7; /* pi/4 / 2^22 */
#ifdef CML_DOUBLE
    const double cx = cos(x), sx = sin(x);
#else
    const float z = x * x;
    const float sx = ((-1.9515295891e-4f * z + 8.3321608736e-3f) * z - 1.6666654611e-1f) * z * x + x;
    const float cx =
        ((2.443315711809948e-5f * z - 1.388731625493765e-3f) * z + 4.166664568298827e-2f) * z * z - 0.5f * z +
        1.0f;
#endif
    const real a = quadrant & 1u ? sx : cx, b = quadrant & 1u ? cx : sx;
    *c = (quadrant + 1u) & 2u ? -a : a;
    *s = quadrant & 2u ? -b : b;
}

#endif
