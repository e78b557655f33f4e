/* SPDX-License-Identifier: MIT */
#include "tally/ranges.h"

#include "base/array.h"

#include <stdlib.h>

/* Neighbours are not joined: ranks give back few ranges, and taking them from the end needs no order. */
cml_status cml_ranges_add(struct cml_ranges *ranges, struct cml_range range, struct cml_error *err)
{
    if (range.count == 0) return CML_OK;
    CML_TRY(cml_array_grow(&ranges->item, ranges->count, sizeof *ranges->item, "ranges of photons", err));
    ranges->item[ranges->count++] = range;
    ranges->total += range.count;
    return CML_OK;
}

/* From the last range, which then shrinks or goes: nothing has to be moved. */
struct cml_range cml_ranges_take(struct cml_ranges *ranges, uint64_t most)
{
    if (ranges->count == 0) return (struct cml_range){0};
    struct cml_range *last = &ranges->item[ranges->count - 1];
    const struct cml_range taken = {last->first, last->count < most ? last->count : most};
    last->first += taken.count;
    last->count -= taken.count;
    if (last->count == 0) ranges->count--;
    ranges->total -= taken.count;
    return taken;
}

void cml_ranges_clear(struct cml_ranges *ranges)
{
    free(ranges->item);
    *ranges = (struct cml_ranges){0};
}
