/* Arrays that grow one by one, and their order by value. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

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

/* For qsort and bsearch: doubles that are numbers, rising. */
static inline int cml_compare_doubles(const void *left, const void *right)
{
    const double a = *(const double *)left, b = *(const double *)right;
    return (a > b) - (a < b);
}
