/* SPDX-License-Identifier: MIT */
#include "tally/ranges.h"

#include "base/array.h"

#include <stdlib.h>

/* Neighbouring ranges are not joined, because ranks return few ranges, and taking turns needs no order. */
cml_status cml_ranges_add(struct cml_ranges *ranges, struct cml_range range, struct cml_error *err)
{
    if (range.count == 0) return CML_OK;
    CML_TRY(cml_array_grow(&ranges->item, ranges->count, sizeof *ranges->item, "ranges of photons", err));
    ranges->item[ranges->count++] = range;
    ranges->total += range.count;
    return CML_OK;
}

cml_status cml_ranges_add_all(struct cml_ranges *ranges, const struct cml_ranges *more, struct cml_error *err)
{
    for (size_t i = 0; i < more->count; i++) CML_TRY(cml_ranges_add(ranges, more->item[i], err));
    return CML_OK;
}

/* Adds the part of a range that lies within from ... to - 1; nothing if they do not overlap. */
static cml_status add_between(struct cml_ranges *ranges, struct cml_range range, uint64_t from, uint64_t to,
                              struct cml_error *err)
{
    const uint64_t behind = range.first + range.count;
    if (range.first > from) from = range.first;
    if (behind < to) to = behind;
    return from < to ? cml_ranges_add(ranges, (struct cml_range){from, to - from}, err) : CML_OK;
}

/* Each range is cut into what lies before, within and behind `mine`. */
cml_status cml_ranges_keep(struct cml_ranges *ranges, struct cml_range mine, struct cml_ranges *others,
                           struct cml_error *err)
{
    CML_AT_END(cml_ranges_clear) struct cml_ranges all = *ranges;
    const uint64_t behind = mine.first + mine.count;
    *ranges = (struct cml_ranges){0};
    for (size_t i = 0; i < all.count; i++) {
        CML_TRY(add_between(ranges, all.item[i], mine.first, behind, err));
        CML_TRY(add_between(others, all.item[i], 0, mine.first, err));
        CML_TRY(add_between(others, all.item[i], behind, UINT64_MAX, err));
    }
    return CML_OK;
}

/* Turns come from the last range, so that no other range has to move. */
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
