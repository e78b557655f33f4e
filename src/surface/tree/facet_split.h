/* Divides facets into two groups that few rays meet both of: the surface area heuristic with bins [Wald, On
 * fast construction of SAH-based bounding volume hierarchies, IEEE Symposium on Interactive Ray Tracing
 * 2007]. Knows boxes only. SPDX-License-Identifier: MIT */
#pragma once

#include <stddef.h>
#include <stdint.h>

/* The box of a facet: smallest x, y, z and largest x, y, z, cm. */
struct cml_facet_box {
    float at[6];
    uint32_t facet;
};

/* Returns an empty box; widened by another box, it becomes that box. */
struct cml_facet_box cml_facet_box_none(void);

/* Enlarges a box to include another box. */
void cml_facet_box_widen(struct cml_facet_box *box, const struct cml_facet_box *other);

/* Returns half of a box's surface, cm2. */
float cml_facet_box_area(const struct cml_facet_box *box);

/* Divides boxes [count], count >= 2, into two groups and orders them so that the first group comes first.
 * Returns the first group's number of boxes (at least 1, less than count). leaf: facets per leaf, for the
 * cost of a group. */
size_t cml_facet_split(struct cml_facet_box *box, size_t count, size_t leaf);
