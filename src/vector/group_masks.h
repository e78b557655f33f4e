/* Helpers between a group of numbers in a vector loop and masks with a bit for each: compare, pack (compress)
 * and unpack (expand).
 *
 *      column  a b c d e f ...     mask 0b101100     pack ->  c d f        unpack: the way back
 *
 * Plain C loops do not compile well to these operations, but some processors have an instruction for each; on
 * others they are loops over set bits. A column is [CML_GROUP], of 4 bytes; bit i of a mask is entry i.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __AVX2__
#include <immintrin.h>
#endif

#define CML_GROUP 16 /* numbers in a vector of AVX-512 */
#define CML_GROUP_MASK 0xffffu

/* Returns a mask with a bit for each of the CML_GROUP entries of a column that equals `value`. Written three
 * times, for AVX-512, AVX2 and plain C, since compilers make slow code of the last. */
static inline uint32_t cml_group_equal(const int *column, int value)
{
#ifdef __AVX512F__
    return _mm512_cmpeq_epi32_mask(_mm512_loadu_si512(column), _mm512_set1_epi32(value));
#else
    uint32_t mask = 0;
#ifdef __AVX2__
    for (int i = 0; i < CML_GROUP; i += 8) {
        const __m256i part = _mm256_loadu_si256((const __m256i *)(const void *)(column + i));
        const __m256i same = _mm256_cmpeq_epi32(part, _mm256_set1_epi32(value));
        mask |= (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(same)) << i;
    }
#else
#pragma omp simd reduction(| : mask)
    for (int i = 0; i < CML_GROUP; i++) mask |= (uint32_t)(column[i] == value) << i;
#endif
    return mask;
#endif
}

/* Returns a mask with a bit for each of the CML_GROUP entries of a column that is below 0. A NaN is not. */
static inline uint32_t cml_group_negative(const float *column)
{
#ifdef __AVX512F__
    return _mm512_cmp_ps_mask(_mm512_loadu_ps(column), _mm512_setzero_ps(), _CMP_LT_OQ);
#else
    uint32_t mask = 0;
#ifdef __AVX2__
    for (int i = 0; i < CML_GROUP; i += 8) {
        const __m256 below = _mm256_cmp_ps(_mm256_loadu_ps(column + i), _mm256_setzero_ps(), _CMP_LT_OQ);
        mask |= (uint32_t)_mm256_movemask_ps(below) << i;
    }
#else
#pragma omp simd reduction(| : mask)
    for (int i = 0; i < CML_GROUP; i++) mask |= (uint32_t)(column[i] < 0) << i;
#endif
    return mask;
#endif
}

/* Writes the values of the entries in the mask side by side to `to`; the rest of to[CML_GROUP] is
 * undefined. */
static inline void cml_group_pack(const void *column, uint32_t mask, void *to)
{
#ifdef __AVX512F__
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi32((__mmask16)mask, _mm512_loadu_si512(column)));
#else
    const char *from = column;
    for (char *next = to; mask; mask &= mask - 1, next += 4)
        memcpy(next, from + 4 * (size_t)__builtin_ctz(mask), 4);
#endif
}

/* Writes the 8-byte values of the entries in the mask side by side to `to`; the rest of to[CML_GROUP] is
 * undefined. */
static inline void cml_group_pack_wide(const uint64_t *column, uint32_t mask, uint64_t *to)
{
#ifdef __AVX512F__
    const uint32_t half = mask & 0xffu;
    const __m512i low = _mm512_loadu_si512(column), high = _mm512_loadu_si512(column + 8);
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi64((__mmask8)half, low));
    _mm512_storeu_si512(to + __builtin_popcount(half),
                        _mm512_maskz_compress_epi64((__mmask8)(mask >> 8), high));
#else
    for (; mask; mask &= mask - 1) *to++ = column[__builtin_ctz(mask)];
#endif
}

/* Writes values that lie side by side into the entries of the mask, in their order. from[CML_GROUP] must be
 * readable. */
static inline void cml_group_unpack(const void *from, uint32_t mask, void *column)
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
