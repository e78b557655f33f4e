/* Splits polygons of mesh files into triangles. SPDX-License-Identifier: MIT */
#pragma once

#include <stddef.h>
#include <stdint.h>

#define CML_POLYGON_MAX_CORNERS 1000

/* Splits the polygon corner[size] of vertex[] into size - 2 triangles that share one corner. The corner is
 * chosen so that the smallest triangle is as large as possible, as polygons with corners on a straight side
 * need it. size: 4 to CML_POLYGON_MAX_CORNERS. Returns NULL, or why the polygon cannot be split: it must be
 * convex, seen along its normal. *bend: the largest distance of a corner from the mean plane, in the unit of
 * the vertices; 0 below 1e-9 of the polygon's size. Another way of splitting would differ by this distance.
 */
const char *cml_polygon_split(const double (*vertex)[3], const uint32_t *corner, size_t size,
                              uint32_t (*triangle)[3], double *bend);
