/* Number and areas of the facets of a represented boundary.
 * A facet is a triangle of a mesh or a ring of cones, in the order of the boundary's primitives; the last
 * facet is the outer plane. The facets of a plane are the pixels of the map, if the scene has a map; the last
 * facet is the rest of the plane.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "surface/surface.h"

/* Returns the number of facets of a boundary, including the last one, which has no end. */
size_t cml_surface_facets(const struct cml_surface_def *def, const struct cml_map_def *map);

/* Returns the area of a facet, cm2; infinite for the last one. */
double cml_surface_facet_area(const struct cml_surface_def *def, const struct cml_map_def *map, size_t facet);
