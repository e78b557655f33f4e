/* Position of a point relative to a mesh's border, seen from above. SPDX-License-Identifier: MIT */
#include "geometry/footprint.h"
#include "geometry/polygon.h"

#include <math.h>
#include <stdlib.h>

struct cml_footprint {
    struct cml_polygon_rows rows;
};

cml_status cml_footprint_create(const struct cml_mesh *mesh, struct cml_footprint **footprint,
                                struct cml_error *err)
{
    const size_t n = mesh->num_border;
    CML_FREED double(*point)[2] = malloc(n * sizeof *point);
    CML_FREED struct cml_footprint *made = malloc(sizeof *made);
    *footprint = NULL;
    if (!made || !point) return cml_fail_memory(err, 16.0 * (double)n, "the footprint of a mesh");
    for (size_t i = 0; i < n; i++)
        for (int k = 0; k < 2; k++) point[i][k] = mesh->vertex[mesh->border[i]][k];
    CML_TRY(cml_polygon_rows_build(point, n, &made->rows, err));
    *footprint = made;
    made = NULL; /* now owned by the caller */
    return CML_OK;
}

/* True if the ray from (x, y) along +x meets the edge. Half open in y, so that a vertex between two edges
 * counts once. */
static bool edge_is_right(const double p[2], const double q[2], double x, double y)
{
    if ((p[1] > y) == (q[1] > y)) return false;
    return x < p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0]);
}

/* Jordan's curve theorem; the even-odd rule of M. Shimrat, Algorithm 112, Comm. ACM 5 (1962) 434. */
bool cml_footprint_contains(const struct cml_footprint *footprint, double x, double y)
{
    const struct cml_polygon_rows *rows = &footprint->rows;
    if (!(y >= rows->y_low && y <= rows->y_high)) return false;
    const size_t row = cml_polygon_row(rows, y);
    bool inside = false;
    for (size_t i = rows->first[row]; i < rows->first[row + 1]; i++) {
        const size_t edge = rows->edge[i], next = edge + 1 < rows->num_points ? edge + 1 : 0;
        if (edge_is_right(rows->point[edge], rows->point[next], x, y)) inside = !inside;
    }
    return inside;
}

/* Returns the distance of (x, y) from the edge: to the foot of the perpendicular, or to the nearer end if the
 * foot lies beyond that end. */
static double distance_to_edge(const double p[2], const double q[2], double x, double y)
{
    const double ex = q[0] - p[0], ey = q[1] - p[1], px = x - p[0], py = y - p[1];
    const double s = fmax(0, fmin(1, (px * ex + py * ey) / (ex * ex + ey * ey)));
    return hypot(px - s * ex, py - s * ey);
}

/* All edges that come within d in y are listed in the rows from y - d to y + d. */
bool cml_footprint_border_is_near(const struct cml_footprint *footprint, double x, double y, double d)
{
    const struct cml_polygon_rows *rows = &footprint->rows;
    if (!(y + d >= rows->y_low && y - d <= rows->y_high)) return false;
    const size_t last = cml_polygon_row(rows, y + d);
    for (size_t row = cml_polygon_row(rows, y - d); row <= last; row++)
        for (size_t i = rows->first[row]; i < rows->first[row + 1]; i++) {
            const size_t edge = rows->edge[i], next = edge + 1 < rows->num_points ? edge + 1 : 0;
            if (distance_to_edge(rows->point[edge], rows->point[next], x, y) <= d) return true;
        }
    return false;
}

/* True if an edge meets a rectangle. The edge is clipped by the bounds of one axis after the other; if
 * nothing is left, the edge passes beside the rectangle [Y.-D. Liang, B. A. Barsky, ACM Trans. Graphics 3
 * (1984) 1]. */
static bool edge_meets_box(const double p[2], const double q[2], const double box[2][2])
{
    double from = 0, to = 1;
    for (int k = 0; k < 2; k++) {
        const double d = q[k] - p[k];
        if (d == 0 && (p[k] < box[0][k] || p[k] > box[1][k])) return false;
        if (d == 0) continue;
        const double a = (box[0][k] - p[k]) / d, b = (box[1][k] - p[k]) / d;
        from = fmax(from, fmin(a, b));
        to = fmin(to, fmax(a, b));
    }
    return from <= to;
}

/* If no edge meets the rectangle, all of it lies on the same side as its middle. */
bool cml_footprint_contains_box(const struct cml_footprint *footprint, const double lower[2],
                                const double upper[2])
{
    const struct cml_polygon_rows *rows = &footprint->rows;
    double middle[2], box[2][2];
    for (int k = 0; k < 2; k++) {
        const double half = 0.5 * (upper[k] - lower[k]) * (1 - 1e-9);
        middle[k] = 0.5 * (lower[k] + upper[k]);
        box[0][k] = middle[k] - half;
        box[1][k] = middle[k] + half;
    }
    for (size_t i = 0; i < rows->num_points; i++) {
        const size_t next = i + 1 < rows->num_points ? i + 1 : 0;
        if (edge_meets_box(rows->point[i], rows->point[next], (const double(*)[2])box)) return false;
    }
    return cml_footprint_contains(footprint, middle[0], middle[1]);
}

void cml_footprint_free(struct cml_footprint *footprint)
{
    if (!footprint) return;
    cml_polygon_rows_clear(&footprint->rows);
    free(footprint);
}
