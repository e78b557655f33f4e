/* Radial heightfields as data: flat ones, and the same surface with fewer rings.
 * Exists because every ring costs a ray something, wherever it came from. Knows no scene and no meshes.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "scene/scene.h"
#include "base/status.h"

#include <stdbool.h>

/* True when all heights are equal: the boundary is then the plane z = z_b - h_0. */
bool cml_radial_is_flat(const struct cml_radial *radial);

/* Copies `from` without the samples that the surface does not need: those on the straight line between the
 * samples that stay, within 4 ulp of the heights and radii involved, and those at the end that repeat the
 * last height. A flat field keeps one sample. The first sample (the tip) always stays. On failure *to is
 * cleared. */
CML_NODISCARD cml_status cml_radial_merge(const struct cml_radial *from, struct cml_radial *to,
                                          struct cml_error *err);

void cml_radial_clear(struct cml_radial *radial);
