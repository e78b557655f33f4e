/* Arrays that grow one by one, groups of arrays with one owner, copies of arrays, and sorting of doubles.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Makes room for one more element in an array of `count` elements of `size` bytes. `array` is the address of
 * the pointer to the array; the pointer is NULL while the array is empty. Only an array of 2^n elements is
 * full and grows to twice its size. Returns CML_E_INPUT if memory for `what` runs out; the array then stays
 * as it is. */
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

/* Arrays of zeros that are freed together. {0} is a group without arrays. */
struct cml_arrays {
    struct cml_arrays_block *last;
    double bytes; /* all bytes requested so far */
    bool failed;
};

/* Header in front of each array of a group. Its alignment keeps the array aligned, too. */
struct cml_arrays_block {
    _Alignas(16) struct cml_arrays_block *before;
};

/* Adds an array of `count` zeros to the group and returns it; count may be 0. Returns NULL if memory runs
 * out; cml_arrays_check then fails for the whole group. */
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

/* Returns CML_E_INPUT if an array of the group could not be allocated. what: name of the arrays for the
 * message. */
CML_NODISCARD static inline cml_status cml_arrays_check(const struct cml_arrays *arrays, const char *what,
                                                        struct cml_error *err)
{
    return arrays->failed ? cml_fail_memory(err, arrays->bytes, what) : CML_OK;
}

/* Frees all arrays of the group. The structure must not be used afterwards. */
static inline void cml_arrays_free(struct cml_arrays *arrays)
{
    while (arrays->last) {
        struct cml_arrays_block *block = arrays->last;
        arrays->last = block->before;
        free(block);
    }
}

/* Returns a copy of `count` elements. If `from` is NULL the copy is NULL, which is no failure. Sets *failed
 * to true if memory runs out, else leaves *failed as it is. */
static inline void *cml_array_copy(const void *from, size_t count, size_t size, bool *failed)
{
    void *to = from ? malloc(count ? count * size : 1) : NULL;
    if (to) memcpy(to, from, count * size);
    *failed |= from && !to;
    return to;
}

/* Returns the index of the last of the n rising values[] that is not above x, found by bisection; 0 if all
 * are above x. */
static inline size_t cml_last_not_above(const double *values, size_t n, double x)
{
    size_t low = 0, high = n;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        *(values[middle] <= x ? &low : &high) = middle;
    }
    return low;
}

/* Compares two doubles for qsort and bsearch, in rising order. NaN is not allowed. */
static inline int cml_compare_doubles(const void *left, const void *right)
{
    const double a = *(const double *)left, b = *(const double *)right;
    return (a > b) - (a < b);
}

/* Sorts n numbers and removes duplicates; the distinct numbers then stand at the beginning, rising. Returns
 * the count of distinct numbers. */
static inline size_t cml_sort_distinct(double *values, size_t n)
{
    size_t distinct = 0;
    qsort(values, n, sizeof *values, cml_compare_doubles);
    for (size_t i = 0; i < n; i++)
        if (i == 0 || values[i] > values[distinct - 1]) values[distinct++] = values[i];
    return distinct;
}
