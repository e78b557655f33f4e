/* The footprint of a boundary mesh: the simple polygon of its border loop, and the position of points
 * relative to it. The outer plane around the mesh has this polygon as its hole. A circle or a rectangle as
 * the hole would leave a gap. SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/mesh.h"

struct cml_footprint; /* edges of the polygon, sorted into rows of y */

/* Builds the footprint from mesh->border. The mesh need not outlive the footprint. Returns CML_E_INPUT if
 * memory runs out. */
CML_NODISCARD cml_status cml_footprint_create(const struct cml_mesh *mesh, struct cml_footprint **footprint,
                                              struct cml_error *err);

/* True if (x, y) lies inside the polygon, by counting crossings of a ray. A point on an edge may count either
 * way. The expected time is constant, because only the edges of one row are examined. */
bool cml_footprint_contains(const struct cml_footprint *footprint, double x, double y);

/* True if the border passes (x, y) at a distance of d or less, cm. */
bool cml_footprint_border_is_near(const struct cml_footprint *footprint, double x, double y, double d);

/* True if the rectangle from `lower` to `upper` (x, y; cm) lies inside the border. The border may run along
 * the rectangle's sides, because the rectangle is shrunk by 1e-9 of its size. */
bool cml_footprint_contains_box(const struct cml_footprint *footprint, const double lower[2],
                                const double upper[2]);

/* Frees a footprint; NULL is allowed. */
void cml_footprint_free(struct cml_footprint *footprint);
