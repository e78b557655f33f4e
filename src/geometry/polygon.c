/* Sorts a polygon's edges into rows of y, and searches for crossings by a sweep along each row. Two edges can
 * meet only in a row that lists both. SPDX-License-Identifier: MIT */
#include "geometry/polygon.h"

#include "geometry/predicate.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Rounding may put y into the row beside its own, but does so for edges and points alike. Each edge is
 * therefore listed in the rows of all its points. */
size_t cml_polygon_row(const struct cml_polygon_rows *rows, double y)
{
    const double row = (y - rows->y_low) * rows->rows_per_length;
    if (!(row > 0)) return 0;
    return row < (double)(rows->num_rows - 1) ? (size_t)row : rows->num_rows - 1;
}

/* Finds the lowest and the highest row that an edge overlaps, both ends included. */
static void edge_rows(const struct cml_polygon_rows *rows, size_t edge, size_t *low, size_t *high)
{
    const size_t next = edge + 1 < rows->num_points ? edge + 1 : 0;
    const double y0 = rows->point[edge][1], y1 = rows->point[next][1];
    *low = cml_polygon_row(rows, fmin(y0, y1));
    *high = cml_polygon_row(rows, fmax(y0, y1));
}

/* Chooses the number of rows: at most the number of points, and so few that cutting the edges into rows at
 * most doubles their number. */
static void choose_rows(struct cml_polygon_rows *rows)
{
    double sum = 0;
    rows->y_low = rows->y_high = rows->point[0][1];
    for (size_t i = 0; i < rows->num_points; i++) {
        const size_t next = i + 1 < rows->num_points ? i + 1 : 0;
        sum += fabs(rows->point[next][1] - rows->point[i][1]);
        rows->y_low = fmin(rows->y_low, rows->point[i][1]);
        rows->y_high = fmax(rows->y_high, rows->point[i][1]);
    }
    const double height = rows->y_high - rows->y_low;
    const double count = sum > 0 ? ceil((double)rows->num_points * (height / sum)) : 1;
    rows->num_rows = count >= 1 ? (size_t)count : 1;
    rows->rows_per_length = height > 0 ? (double)rows->num_rows / height : 0;
    if (!isfinite(rows->rows_per_length)) rows->rows_per_length = 0;
}

/* Lists the edges of each row by a counting sort. While row r is filled from its end, first[r] is the begin
 * of its filled part. */
static cml_status fill_rows(struct cml_polygon_rows *rows, struct cml_error *err)
{
    size_t low, high;
    for (size_t i = 0; i < rows->num_points; i++) {
        edge_rows(rows, i, &low, &high);
        for (size_t r = low; r <= high; r++) rows->first[r]++;
    }
    for (size_t r = 0; r < rows->num_rows; r++) rows->first[r + 1] += rows->first[r];
    const size_t total = rows->first[rows->num_rows];
    rows->edge = malloc(total * sizeof *rows->edge);
    if (!rows->edge) return cml_fail_memory(err, 4.0 * (double)total, "the border of a mesh");
    for (size_t i = rows->num_points; i-- > 0;) {
        edge_rows(rows, i, &low, &high);
        for (size_t r = low; r <= high; r++) rows->edge[--rows->first[r]] = (uint32_t)i;
    }
    return CML_OK;
}

cml_status cml_polygon_rows_build(const double (*point)[2], size_t num_points, struct cml_polygon_rows *rows,
                                  struct cml_error *err)
{
    *rows = (struct cml_polygon_rows){.num_points = num_points};
    rows->point = malloc(num_points * sizeof *rows->point);
    if (rows->point) {
        memcpy(rows->point, point, num_points * sizeof *rows->point);
        choose_rows(rows);
        rows->first = calloc(rows->num_rows + 1, sizeof *rows->first);
    }
    const cml_status status = rows->first
                                  ? fill_rows(rows, err)
                                  : cml_fail_memory(err, 24.0 * (double)num_points, "the border of a mesh");
    if (status != CML_OK) cml_polygon_rows_clear(rows);
    return status;
}

void cml_polygon_rows_clear(struct cml_polygon_rows *rows)
{
    free(rows->point);
    free(rows->first);
    free(rows->edge);
    *rows = (struct cml_polygon_rows){0};
}

/* True if p, which must lie on the line through a and b, lies between them. */
static bool in_box(const double a[2], const double b[2], const double p[2])
{
    return p[0] >= fmin(a[0], b[0]) && p[0] <= fmax(a[0], b[0]) && p[1] >= fmin(a[1], b[1]) &&
           p[1] <= fmax(a[1], b[1]);
}

/* True if the segments a b and c d have a common point. */
static bool segments_intersect(const double a[2], const double b[2], const double c[2], const double d[2])
{
    const int abc = cml_orient2d(a, b, c), abd = cml_orient2d(a, b, d), cda = cml_orient2d(c, d, a),
              cdb = cml_orient2d(c, d, b);
    if (abc * abd < 0 && cda * cdb < 0) return true;
    return (abc == 0 && in_box(a, b, c)) || (abd == 0 && in_box(a, b, d)) || (cda == 0 && in_box(c, d, a)) ||
           (cdb == 0 && in_box(c, d, b));
}

/* True if neighbouring edges a b and b c fold back onto each other. Otherwise they meet only in their common
 * point b. */
static bool neighbours_fold(const double a[2], const double b[2], const double c[2])
{
    if (cml_orient2d(a, b, c) != 0) return false;
    return (a[0] - b[0]) * (c[0] - b[0]) + (a[1] - b[1]) * (c[1] - b[1]) >= 0;
}

/* True if edges i and j meet where they should not. In a simple polygon only neighbours meet, and only in
 * their common point. */
static bool edges_cross(const struct cml_polygon_rows *rows, size_t i, size_t j)
{
    const size_t n = rows->num_points, i_next = i + 1 < n ? i + 1 : 0, j_next = j + 1 < n ? j + 1 : 0;
    if (i_next == j) return neighbours_fold(rows->point[i], rows->point[j], rows->point[j_next]);
    if (j_next == i) return neighbours_fold(rows->point[j], rows->point[i], rows->point[i_next]);
    return segments_intersect(rows->point[i], rows->point[i_next], rows->point[j], rows->point[j_next]);
}

struct span {
    double x_low, x_high;
    uint32_t edge;
};

/* Orders two spans by their left ends, for qsort. */
static int compare_spans(const void *left, const void *right)
{
    const struct span *a = left, *b = right;
    return (a->x_low > b->x_low) - (a->x_low < b->x_low);
}

/* Compares the edges of one row, sorted by their left ends; only edges whose ranges of x overlap are
 * compared. Returns an edge that meets another one, or CML_POLYGON_SIMPLE. */
static size_t sweep_row(const struct cml_polygon_rows *rows, size_t row, struct span *spans)
{
    const size_t count = rows->first[row + 1] - rows->first[row];
    for (size_t i = 0; i < count; i++) {
        const uint32_t edge = rows->edge[rows->first[row] + i];
        const double x0 = rows->point[edge][0];
        const double x1 = rows->point[edge + 1 < rows->num_points ? edge + 1 : 0][0];
        spans[i] = (struct span){.x_low = fmin(x0, x1), .x_high = fmax(x0, x1), .edge = edge};
    }
    qsort(spans, count, sizeof *spans, compare_spans);
    for (size_t i = 0; i < count; i++)
        for (size_t j = i + 1; j < count && spans[j].x_low <= spans[i].x_high; j++)
            if (edges_cross(rows, spans[i].edge, spans[j].edge)) return spans[i].edge;
    return CML_POLYGON_SIMPLE;
}

/* Only edges that share a row of the y axis are compared. */
cml_status cml_polygon_find_crossing(const struct cml_polygon_rows *rows, size_t *edge, struct cml_error *err)
{
    size_t longest = 1;
    for (size_t r = 0; r < rows->num_rows; r++)
        if (rows->first[r + 1] - rows->first[r] > longest) longest = rows->first[r + 1] - rows->first[r];
    CML_FREED struct span *spans = malloc(longest * sizeof *spans);
    if (!spans) return cml_fail_memory(err, 24.0 * (double)longest, "the border of a mesh");
    *edge = CML_POLYGON_SIMPLE;
    for (size_t r = 0; r < rows->num_rows && *edge == CML_POLYGON_SIMPLE; r++)
        *edge = sweep_row(rows, r, spans);
    return CML_OK;
}
