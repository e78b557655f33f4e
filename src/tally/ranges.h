/* Turns (piece.h) of photons that nobody has flown yet: a set of disjoint ranges, from which pieces are
 * taken. The order of taking never shows, because results are sums of integers. SPDX-License-Identifier:
 * MIT */
#pragma once

#include "base/status.h"

#include <stddef.h>
#include <stdint.h>

/* A range of turns. */
struct cml_range {
    uint64_t first, count; /* turns first to first + count - 1 */
};

/* A set of disjoint ranges of turns. */
struct cml_ranges {
    size_t count;
    struct cml_range *item; /* [count] disjoint ranges, none empty */
    uint64_t total;         /* number of turns in all ranges */
};

/* Adds a range that is disjoint from all others; an empty range is ignored. A zeroed cml_ranges is an empty
 * set. CML_E_INPUT when memory runs out; the set is then unchanged. */
CML_NODISCARD cml_status cml_ranges_add(struct cml_ranges *ranges, struct cml_range range,
                                        struct cml_error *err);

/* Adds all ranges of another set, which must be disjoint from those present. CML_E_INPUT when memory runs
 * out. */
CML_NODISCARD cml_status cml_ranges_add_all(struct cml_ranges *ranges, const struct cml_ranges *more,
                                            struct cml_error *err);

/* Keeps the turns within `mine`, and moves all others to `others`. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_ranges_keep(struct cml_ranges *ranges, struct cml_range mine,
                                         struct cml_ranges *others, struct cml_error *err);

/* Takes at most `most` turns off the front of the range added last; count = 0 when the set is empty. */
struct cml_range cml_ranges_take(struct cml_ranges *ranges, uint64_t most);

/* Frees the items and leaves an empty set. */
void cml_ranges_clear(struct cml_ranges *ranges);
