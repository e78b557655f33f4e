/* The geometry of one facet of a mesh: where a line crosses it, and how far from it a point lies.
 * Points are in the centred frame (centred_mesh.h), directions of unit length, distances in cm.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "surface/tree/centred_mesh.h"

/* Distance along a line, from a point of it, to where it crosses the facet; of a line that passes beside the
 * facet, to a place near it. The more a line lies in the facet's plane, the more do the facet's edges say
 * where that is: then rounding moves the place within the facet, not beyond it. least: before that the
 * crossing is known not to come, whatever rounding says; -INFINITY when nothing is known. */
double cml_facet_crossing(const struct cml_centred_mesh *centred, int primitive, const double from[3],
                          const double direction[3], double least);

/* From a point to the closest of the facet, edges and corners with it. */
double cml_facet_distance(const struct cml_centred_mesh *centred, int primitive, const double p[3]);

/* Distance along a ray to where it is closest to the edge from a to b; 0 where it leaves the edge behind. */
double cml_facet_edge_approach(const double from[3], const double direction[3], const double a[3],
                               const double b[3]);
