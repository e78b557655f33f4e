/* Simple polygons: the edges sorted into rows of y, so that only the few near a point or near each other have
 * to be looked at. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stddef.h>
#include <stdint.h>

/* Edge i runs from point i to point i + 1, the last one back to point 0. */
struct cml_polygon_rows {
    size_t num_points, num_rows;
    double (*point)[2];     /* [num_points] x, y in any unit of length, owned */
    double y_low, y_high;   /* of all points */
    double rows_per_length; /* num_rows / (y_high - y_low); 0 for a flat polygon */
    size_t *first;          /* [num_rows + 1] where a row's list begins in edge[] */
    uint32_t
        *edge; /* every edge stands in all rows that it overlaps; at most 3 num_points + num_rows entries */
};

/* Takes a copy of `point`, num_points >= 3. CML_E_INPUT only when memory runs out, *rows is then cleared. */
CML_NODISCARD cml_status cml_polygon_rows_build(const double (*point)[2], size_t num_points,
                                                struct cml_polygon_rows *rows, struct cml_error *err);

void cml_polygon_rows_clear(struct cml_polygon_rows *rows);

/* The row of a y between y_low and y_high; never decreases with y. */
size_t cml_polygon_row(const struct cml_polygon_rows *rows, double y);

#define CML_POLYGON_SIMPLE SIZE_MAX

/* *edge becomes an edge that has a point in common with another one (neighbours: more than their shared
 * point), or CML_POLYGON_SIMPLE. CML_E_INPUT only when memory runs out. */
CML_NODISCARD cml_status cml_polygon_find_crossing(const struct cml_polygon_rows *rows, size_t *edge,
                                                   struct cml_error *err);
