/* Polygons of an OBJ file as triangles. SPDX-License-Identifier: MIT */
#pragma once

#include <stddef.h>
#include <stdint.h>

#define CML_OBJ_MAX_CORNERS 1000

/* Splits the polygon corner[size] of vertex[] into size - 2 triangles, all meeting in one corner, which is
 * chosen so that the smallest triangle is as large as possible (corners on a straight side need that).
 * size is 4 to CML_OBJ_MAX_CORNERS. Returns NULL, or why it cannot be done: the polygon must be convex, seen
 * along its normal. *bend: the largest distance of a corner from the mean plane, in the vertices' unit, 0
 * within 1e-9 of the polygon's size; another way of splitting differs by so much. */
const char *cml_obj_split(const double (*vertex)[3], const uint32_t *corner, size_t size,
                          uint32_t (*triangle)[3], double *bend);
