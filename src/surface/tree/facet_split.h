/* Divides facets into two groups that rays meet seldom together, by the surface area heuristic in bins [Wald,
 * On fast construction of SAH-based bounding volume hierarchies, IEEE Symposium on Interactive Ray Tracing
 * 2007]. Knows boxes only. SPDX-License-Identifier: MIT */
#pragma once

#include <stddef.h>
#include <stdint.h>

/* Least x, y, z and most x, y, z, cm. */
struct cml_facet_box {
    float at[6];
    uint32_t facet;
};

/* The box around nothing, which joins with any other as that. */
struct cml_facet_box cml_facet_box_none(void);

/* Makes a box hold another one too. */
void cml_facet_box_widen(struct cml_facet_box *box, const struct cml_facet_box *other);

/* Half of a box's surface, cm2. */
float cml_facet_box_area(const struct cml_facet_box *box);

/* Orders boxes [count] so that the first ones, whose number it returns (at least 1, less than count), are one
 * group. Those of a group fill leaves of `leaf` facets. count >= 2. */
size_t cml_facet_split(struct cml_facet_box *box, size_t count, size_t leaf);
