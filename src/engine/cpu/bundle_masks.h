/* Between the lanes of a group and masks with a bit for each: compare, pack (compress) and unpack (expand).
 * No vector loop in plain C compiles well to them, and AVX-512 has an instruction for each; elsewhere they
 * are loops over set bits. Columns are [CML_GROUP], of 4 bytes; bit i of a mask is lane i. Tiny inline
 * helpers, no more code than that. SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_MASKS_H
#define CML_BUNDLE_MASKS_H

#include "engine/cpu/bundle.h"

#include <string.h>

#ifdef __AVX512F__
#include <immintrin.h>
#endif

/* The lanes with this value. */
static inline cml_u32 cml_group_equal(const int *column, int value)
{
#ifdef __AVX512F__
    return _mm512_cmpeq_epi32_mask(_mm512_loadu_si512(column), _mm512_set1_epi32(value));
#else
    cml_u32 mask = 0;
#pragma omp simd reduction(| : mask)
    for (int i = 0; i < CML_GROUP; i++) mask |= (cml_u32)(column[i] == value) << i;
    return mask;
#endif
}

/* The lanes below 0. */
static inline cml_u32 cml_group_negative(const real *column)
{
#ifdef __AVX512F__
    return _mm512_cmp_ps_mask(_mm512_loadu_ps(column), _mm512_setzero_ps(), _CMP_LT_OQ);
#else
    cml_u32 mask = 0;
#pragma omp simd reduction(| : mask)
    for (int i = 0; i < CML_GROUP; i++) mask |= (cml_u32)(column[i] < 0) << i;
    return mask;
#endif
}

/* The values of the lanes in the mask, side by side; what follows them in to[CML_GROUP] is undefined. */
static inline void cml_group_pack(const void *column, cml_u32 mask, void *to)
{
#ifdef __AVX512F__
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi32((__mmask16)mask, _mm512_loadu_si512(column)));
#else
    const char *from = column;
    for (char *next = to; mask; mask &= mask - 1, next += 4)
        memcpy(next, from + 4 * (size_t)__builtin_ctz(mask), 4);
#endif
}

/* The same for values of 8 bytes. */
static inline void cml_group_pack_wide(const uint64_t *column, cml_u32 mask, uint64_t *to)
{
#ifdef __AVX512F__
    const cml_u32 half = mask & 0xffu;
    const __m512i low = _mm512_loadu_si512(column), high = _mm512_loadu_si512(column + 8);
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi64((__mmask8)half, low));
    _mm512_storeu_si512(to + __builtin_popcount(half),
                        _mm512_maskz_compress_epi64((__mmask8)(mask >> 8), high));
#else
    for (; mask; mask &= mask - 1) *to++ = column[__builtin_ctz(mask)];
#endif
}

/* Values that lie side by side, into the lanes of the mask in this order. [CML_GROUP] can be read. */
static inline void cml_group_unpack(const void *from, cml_u32 mask, void *column)
{
#ifdef __AVX512F__
    _mm512_storeu_si512(column, _mm512_mask_expand_epi32(_mm512_loadu_si512(column), (__mmask16)mask,
                                                         _mm512_loadu_si512(from)));
#else
    char *to = column;
    for (const char *next = from; mask; mask &= mask - 1, next += 4)
        memcpy(to + 4 * (size_t)__builtin_ctz(mask), next, 4);
#endif
}

#endif
