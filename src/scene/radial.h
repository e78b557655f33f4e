/* Radial heightfields as data: finds flat ones, and removes rings that do not change the surface, because a
 * ray pays for every ring. Knows no scene and no meshes. SPDX-License-Identifier: MIT */
#pragma once

#include "scene/scene.h"
#include "base/status.h"

#include <stdbool.h>

/* True if all heights are equal. The boundary is then the plane z = z_b - h_0. */
bool cml_radial_is_flat(const struct cml_radial *radial);

/* Copies `from` without samples that do not change the surface. Dropped are samples within 4 ulp (of the
 * heights and radii involved) of the straight line between the samples that stay, and trailing samples that
 * repeat the last height. A flat heightfield keeps one sample. The first sample (the tip) always stays. On
 * failure *to is cleared. */
CML_NODISCARD cml_status cml_radial_merge(const struct cml_radial *from, struct cml_radial *to,
                                          struct cml_error *err);

void cml_radial_clear(struct cml_radial *radial);
