/* Logarithm, exponential, points of a circle and arc cosine with stated errors. In single precision they are
 * polynomials, which compilers turn into vector code and which give the same bits with every compiler. In
 * double precision they are the C library's functions. Coefficients: Cephes (S. Moshier), logf, expf, sinf,
 * cosf, asinf.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "port.h"

#if !defined(CML_DOUBLE)
/* Returns the bits of a float. */
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

/* Returns the float that has these bits. */
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

/* Returns x, or -x if the word's highest bit is set. */
CML_FN real cml_flip(real x, cml_u32 word)
{
#ifdef CML_DOUBLE
    return (int)word < 0 ? -x : x;
#else
    return cml_float_of(cml_bits_of(x) ^ (word & 0x80000000u));
#endif
}

/* Returns the natural logarithm of x > 0, which must be normal. Relative error < 1.2e-7 in float
 * (unit.mathf), the C library's in double. */
CML_FN real cml_log(real x)
{
#ifdef CML_DOUBLE
    return log(x);
#else
    /* x = 2^e m, sqrt(1/2) <= m < sqrt(2). The constant moves the cut between two exponents to sqrt(1/2). */
    const cml_u32 shifted = cml_bits_of(x) - 0x3f3504f3u;
    const int e = (int)shifted >> 23;
    const float m = cml_float_of((shifted & 0x007fffffu) + 0x3f3504f3u) - 1.0f;
    const float z = m * m;
    /* Estrin's scheme has half as many steps in sequence as Horner's. */
    const float cube = z * m;
    const float a = CML_FMA(CML_FMA(2.0000714765e-1f, m, -2.4999993993e-1f), m, 3.3333331174e-1f);
    const float b = CML_FMA(-1.2420140846e-1f, m, 1.4249322787e-1f);
    const float c = CML_FMA(b, m, -1.6668057665e-1f);
    const float d = CML_FMA(CML_FMA(7.0376836292e-2f, m, -1.1514610310e-1f), m, 1.1676998740e-1f);
    float p = CML_FMA(CML_FMA(d, cube, c), cube, a);
    p = CML_FMA((float)e, -2.12194440e-4f, p * cube);
    return CML_FMA((float)e, 0.693359375f, m + CML_FMA(-0.5f, z, p));
#endif
}

/* Returns exp(-x) for x >= 0; 0 if the result is below 1e-30. Relative error < 1.2e-7 in float (unit.mathf),
 * the C library's in double. */
CML_FN real cml_exp_minus(real x)
{
#ifdef CML_DOUBLE
    return exp(-x);
#else
    /* -x = k ln 2 + r, |r| <= ln 2 / 2. Adding 1.5 2^23 rounds to the next integer. */
    const float within = x < 69.0f ? x : 69.0f;
    const float shifted = CML_FMA(-within, 1.44269504088896341f, 12582912.0f), k = shifted - 12582912.0f;
    const float r = CML_FMA(k, 2.12194440e-4f, CML_FMA(k, -0.693359375f, -within));
    float p = CML_FMA(1.9875691500e-4f, r, 1.3981999507e-3f);
    p = CML_FMA(p, r, 8.3334519073e-3f);
    p = CML_FMA(p, r, 4.1665795894e-2f);
    p = CML_FMA(p, r, 1.6666665459e-1f);
    p = CML_FMA(p, r, 5.0000001201e-1f);
    p = CML_FMA(p, r * r, r) + 1.0f;
    const float power = cml_float_of((cml_bits_of(shifted) - 0x4b400000u + 127u) << 23);
    return x < 69.0f ? p * power : 0.0f;
#endif
}

/* Finds a point of the unit circle at a uniform angle: 2 bits of the word give the quadrant, the other 30 an
 * angle within +-pi/4. Absolute error of either coordinate < 1.2e-7 in float, 2e-16 in double. */
CML_FN void cml_circle_point(cml_u32 word, real *c, real *s)
{
    const real x = (real)(int)(word << 2) * (real)3.657295198167899e-10; /* pi/4 / 2^31 */
#ifdef CML_DOUBLE
    const double cx = cos(x), sx = sin(x);
#else
    const float z = x * x;
    const float sx =
        CML_FMA(CML_FMA(CML_FMA(-1.9515295891e-4f, z, 8.3321608736e-3f), z, -1.6666654611e-1f), z * x, x);
    const float t =
        CML_FMA(CML_FMA(2.443315711809948e-5f, z, -1.388731625493765e-3f), z, 4.166664568298827e-2f);
    const float cx = CML_FMA(CML_FMA(t, z, -0.5f), z, 1.0f);
#endif
    const int odd = (word & 0x40000000u) != 0u;
    *c = cml_flip(odd ? sx : cx, word + 0x40000000u);
    *s = cml_flip(odd ? cx : sx, word);
}

/* Returns the arc cosine of 0 <= c <= 1. Absolute error < 1.4e-7 in float (unit.mathf), the C library's in
 * double. */
CML_FN real cml_acos(real c)
{
#ifdef CML_DOUBLE
    return acos(c);
#else
    const int steep = c > 0.5f;
    const float z = steep ? CML_FMA(-0.5f, c, 0.5f) : c * c, x = steep ? CML_SQRT(z) : c;
    float p = CML_FMA(4.2163199048e-2f, z, 2.4181311049e-2f);
    p = CML_FMA(p, z, 4.5470025998e-2f);
    p = CML_FMA(p, z, 7.4953002686e-2f);
    p = CML_FMA(p, z, 1.6666752422e-1f);
    const float asine = CML_FMA(p * z, x, x);
    return steep ? 2.0f * asine : 1.5707963267948966f - asine;
#endif
}
