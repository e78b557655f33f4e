/* Arrays that grow one by one, copies of arrays, and their order by value. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Room for one more than the `count` elements of `size` bytes that an array has; array is the address of the
 * pointer to it, NULL while it is empty. Only an array whose number is a power of two is full, and gets room
 * for twice as many. CML_E_INPUT when out of memory for `what`; the array then stays as it is. */
CML_NODISCARD static inline cml_status cml_array_grow(void *array, size_t count, size_t size,
                                                      const char *what, struct cml_error *err)
{
    if ((count & (count - 1)) != 0) return CML_OK;
    const size_t bytes = (count ? 2 * count : 1) * size;
    void *old, *larger;
    memcpy(&old, array, sizeof old);
    larger = realloc(old, bytes);
    if (!larger) return cml_fail_memory(err, (double)bytes, what);
    memcpy(array, &larger, sizeof larger);
    return CML_OK;
}

/* Arrays of zeros that end together. None before the first is made: {0}. */
struct cml_arrays {
    struct cml_arrays_block *last;
    double bytes; /* that were asked for */
    bool failed;
};

/* In front of an array: what keeps it aligned. */
struct cml_arrays_block {
    _Alignas(16) struct cml_arrays_block *before;
};

/* An array of zeros, also of none; NULL where memory does not suffice, which cml_arrays_check tells of all.
 */
static inline void *cml_arrays_add(struct cml_arrays *arrays, size_t count, size_t size)
{
    struct cml_arrays_block *block = NULL;
    if (count < PTRDIFF_MAX / 2 / size) block = calloc(1, sizeof *block + count * size);
    arrays->bytes += (double)count * (double)size;
    arrays->failed |= !block;
    if (!block) return NULL;
    block->before = arrays->last;
    arrays->last = block;
    return block + 1;
}

CML_NODISCARD static inline cml_status cml_arrays_check(const struct cml_arrays *arrays, const char *what,
                                                        struct cml_error *err)
{
    return arrays->failed ? cml_fail_memory(err, arrays->bytes, what) : CML_OK;
}

static inline void cml_arrays_free(struct cml_arrays *arrays)
{
    while (arrays->last) {
        struct cml_arrays_block *block = arrays->last;
        arrays->last = block->before;
        free(block);
    }
}

/* A copy of `count` elements; NULL stays NULL and is no failure. *failed becomes true where memory does not
 * suffice, else it stays as it is. */
static inline void *cml_array_copy(const void *from, size_t count, size_t size, bool *failed)
{
    void *to = from ? malloc(count ? count * size : 1) : NULL;
    if (to) memcpy(to, from, count * size);
    *failed |= from && !to;
    return to;
}

/* The last of values[n], which rise, that is not above x; the first where all are. By bisection. */
static inline size_t cml_last_not_above(const double *values, size_t n, double x)
{
    size_t low = 0, high = n;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        *(values[middle] <= x ? &low : &high) = middle;
    }
    return low;
}

/* For qsort and bsearch: doubles that are numbers, rising. */
static inline int cml_compare_doubles(const void *left, const void *right)
{
    const double a = *(const double *)left, b = *(const double *)right;
    return (a > b) - (a < b);
}

/* The different ones of n numbers, rising, to their beginning. Returns how many. */
static inline size_t cml_sort_distinct(double *values, size_t n)
{
    size_t distinct = 0;
    qsort(values, n, sizeof *values, cml_compare_doubles);
    for (size_t i = 0; i < n; i++)
        if (i == 0 || values[i] > values[distinct - 1]) values[distinct++] = values[i];
    return distinct;
}
