/* Geometry of one facet of a mesh: where a line crosses it, and its distance from a point. Points are in the
 * centred frame (centred_mesh.h), directions are unit vectors, distances in cm. SPDX-License-Identifier:
 * MIT */
#pragma once

#include "surface/tree/centred_mesh.h"

/* Returns the distance along a line, from one of its points, to where it crosses the facet. For a line that
 * passes beside the facet, returns the distance to a place near the facet. The smaller the angle between line
 * and facet, the more the facet's edges determine the place, so that rounding moves the place within the
 * facet and not out of it. least: a distance before which the crossing cannot lie, whatever rounding says;
 * -INFINITY if there is none. */
double cml_facet_crossing(const struct cml_centred_mesh *centred, int primitive, const double from[3],
                          const double direction[3], double least);

/* Returns the distance of a point from the facet, including its edges and corners. */
double cml_facet_distance(const struct cml_centred_mesh *centred, int primitive, const double p[3]);

/* Returns the distance along a ray to the place where it is closest to the edge from a to b; 0 if the ray
 * moves away from the edge. */
double cml_facet_edge_approach(const double from[3], const double direction[3], const double a[3],
                               const double b[3]);
