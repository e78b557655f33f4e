/* Simple polygons whose edges are sorted into rows of y. A search near a point, or for crossing edges, then
 * examines only a few edges. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stddef.h>
#include <stdint.h>

/* A polygon's points, and its edges by rows of y. Edge i runs from point i to point i + 1, the last edge back
 * to point 0. */
struct cml_polygon_rows {
    size_t num_points, num_rows;
    double (*point)[2];     /* [num_points] x, y in any unit of length; owned */
    double y_low, y_high;   /* smallest and largest y of all points */
    double rows_per_length; /* num_rows / (y_high - y_low); 0 for a polygon without height */
    size_t *first;          /* [num_rows + 1] where each row's list begins in edge[] */
    uint32_t *edge; /* numbers of the edges in each row, row by row; an edge stands in every row that it
                       overlaps; choose_rows keeps the total at or below 3 num_points + num_rows */
};

/* Builds the rows from a copy of `point`; num_points >= 3. Returns CML_E_INPUT if memory runs out; *rows is
 * then cleared. */
CML_NODISCARD cml_status cml_polygon_rows_build(const double (*point)[2], size_t num_points,
                                                struct cml_polygon_rows *rows, struct cml_error *err);

/* Frees the rows' memory and zeroes the structure. */
void cml_polygon_rows_clear(struct cml_polygon_rows *rows);

/* Returns the row of a y between y_low and y_high. The row never decreases with y. */
size_t cml_polygon_row(const struct cml_polygon_rows *rows, double y);

#define CML_POLYGON_SIMPLE SIZE_MAX

/* Sets *edge to an edge that meets another one (neighbours: in more than their common point), or to
 * CML_POLYGON_SIMPLE. Returns CML_E_INPUT if memory runs out. */
CML_NODISCARD cml_status cml_polygon_find_crossing(const struct cml_polygon_rows *rows, size_t *edge,
                                                   struct cml_error *err);
