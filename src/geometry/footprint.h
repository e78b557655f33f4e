/* The footprint of a boundary mesh: the simple polygon of its border loop, and where a point lies to it.
 * Exists because the outer plane has this polygon as its hole: a circle or a box there would leave a gap.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/mesh.h"

struct cml_footprint; /* edges sorted into rows of y */

/* Builds the look-up from mesh->border; the mesh need not outlive it. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_footprint_create(const struct cml_mesh *mesh, struct cml_footprint **footprint,
                                              struct cml_error *err);

/* True when (x, y) lies inside the polygon (crossing number; a point on an edge may count either way).
 * Expected time O(1): only the edges of one row are looked at. */
bool cml_footprint_contains(const struct cml_footprint *footprint, double x, double y);

/* Whether the border passes (x, y) at distance d, in cm, or less. */
bool cml_footprint_border_is_near(const struct cml_footprint *footprint, double x, double y, double d);

/* Whether the rectangle lower..upper (x, y; cm) lies inside the border, which may run along its sides: it is
 * made smaller by 1e-9 of itself. */
bool cml_footprint_contains_box(const struct cml_footprint *footprint, const double lower[2],
                                const double upper[2]);

void cml_footprint_free(struct cml_footprint *footprint);
