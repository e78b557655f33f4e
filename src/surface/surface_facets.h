/* The facets of a represented boundary: how many and how large.
 * A facet is a triangle of a mesh or a ring of cones, in the order of the boundary's primitives, and the last
 * one is the outer plane. The facets of a plane are the pixels of the map, if there is one, and the last one
 * is what lies outside. SPDX-License-Identifier: MIT */
#pragma once

#include "surface/surface.h"

/* How many facets a boundary has, with the last one. */
size_t cml_surface_facets(const struct cml_surface_def *def, const struct cml_map_def *map);

/* The area of a facet, cm2; infinite for the last one. */
double cml_surface_facet_area(const struct cml_surface_def *def, const struct cml_map_def *map, size_t facet);
