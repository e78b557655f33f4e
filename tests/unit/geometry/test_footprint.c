/* Tests of footprints (the polygon that a mesh covers, seen from above) against brute force, and of the
 * search for borders that cross themselves. SPDX-License-Identifier: MIT */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "geometry/footprint.h"
#include "geometry/polygon.h"

static uint64_t random_state = 1;

static double random_unit(void)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (double)(random_state >> 11) * 0x1p-53;
}

/* Makes a star-shaped polygon with random radii, which is always simple. negative: it runs clockwise. */
static void random_star(double (*point)[2], size_t n, bool negative)
{
    const double scale = exp(20 * random_unit() - 10), x = 5 * random_unit(), y = -5 * random_unit();
    for (size_t i = 0; i < n; i++) {
        const double angle = 2 * acos(-1.0) * ((double)i + 0.5 * random_unit()) / (double)n;
        const double radius = scale * (0.05 + random_unit());
        point[i][0] = x * scale + radius * cos(angle);
        point[i][1] = y * scale + radius * sin(angle) * (negative ? -1 : 1);
    }
}

/* Makes a comb of long teeth: a horizontal line at any y crosses every tooth. */
static void comb(double (*point)[2], size_t n)
{
    for (size_t i = 0; i + 2 < n; i++) {
        point[i][0] = (double)i;
        point[i][1] = i % 2 ? 1 : 0.01 * random_unit();
    }
    memcpy(point[n - 2], (double[]){(double)n, -1}, sizeof point[0]);
    memcpy(point[n - 1], (double[]){-1, -1}, sizeof point[0]);
}

static struct cml_footprint *make_footprint(const double (*point)[2], size_t n)
{
    struct cml_mesh mesh = {.num_vertices = n, .num_border = n};
    struct cml_footprint *footprint = NULL;
    struct cml_error err;
    mesh.vertex = calloc(n, sizeof *mesh.vertex);
    mesh.border = calloc(n, sizeof *mesh.border);
    assert_true(mesh.vertex && mesh.border);
    for (size_t i = 0; i < n; i++) {
        mesh.border[i] = (uint32_t)(n - 1 - i); /* index and place differ on purpose */
        memcpy(mesh.vertex[n - 1 - i], point[i], sizeof point[0]);
    }
    assert_int_equal(cml_footprint_create(&mesh, &footprint, &err), CML_OK);
    cml_mesh_clear(&mesh);
    return footprint;
}

/* True if the polygon winds around (x, y), by the winding angle. The code under test counts crossings
 * instead. */
static bool winds_around(const double (*point)[2], size_t n, double x, double y)
{
    double angle = 0;
    for (size_t i = 0; i < n; i++) {
        const double *p = point[i], *q = point[(i + 1) % n];
        const double u[2] = {p[0] - x, p[1] - y}, v[2] = {q[0] - x, q[1] - y};
        angle += atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]);
    }
    return fabs(angle) > 3;
}

static void compare_inside(const double (*point)[2], size_t n, int queries)
{
    struct cml_footprint *footprint = make_footprint(point, n);
    double low[2] = {point[0][0], point[0][1]}, high[2] = {low[0], low[1]};
    for (size_t i = 0; i < n; i++) {
        for (int k = 0; k < 2; k++) {
            low[k] = fmin(low[k], point[i][k]);
            high[k] = fmax(high[k], point[i][k]);
        }
    }
    for (int i = 0; i < queries; i++) {
        const double x = low[0] + (high[0] - low[0]) * (1.2 * random_unit() - 0.1);
        const double y = low[1] + (high[1] - low[1]) * (1.2 * random_unit() - 0.1);
        assert_int_equal(cml_footprint_contains(footprint, x, y), winds_around(point, n, x, y));
    }
    cml_footprint_free(footprint);
}

static double distance_to_border(const double (*point)[2], size_t n, double x, double y)
{
    double nearest = INFINITY;
    for (size_t i = 0; i < n; i++) {
        const double *p = point[i], *q = point[(i + 1) % n];
        const double length = hypot(q[0] - p[0], q[1] - p[1]);
        const double along = ((x - p[0]) * (q[0] - p[0]) + (y - p[1]) * (q[1] - p[1])) / length;
        const double across = ((x - p[0]) * (q[1] - p[1]) - (y - p[1]) * (q[0] - p[0])) / length;
        const double beyond = along < 0 ? along : along > length ? along - length : 0;
        nearest = fmin(nearest, hypot(across, beyond));
    }
    return nearest;
}

/* Points at various distances from the polygon, large and small against its size, find the nearest part of
 * the border. */
static void finds_the_border(void **state)
{
    (void)state;
    double point[40][2];
    for (int i = 0; i < 300; i++) {
        const size_t n = 3 + (size_t)(random_unit() * 37);
        random_star(point, n, i % 2);
        struct cml_footprint *footprint = make_footprint((const double(*)[2])point, n);
        for (int k = 0; k < 300; k++) {
            const size_t edge = (size_t)(random_unit() * (double)n), next = (edge + 1) % n;
            const double s = random_unit(),
                         size = hypot(point[0][0] - point[1][0], point[0][1] - point[1][1]);
            const double off = size * exp(-20 * random_unit());
            const double x = point[edge][0] + s * (point[next][0] - point[edge][0]) +
                             off * (random_unit() - 0.5),
                         y = point[edge][1] + s * (point[next][1] - point[edge][1]) +
                             off * (random_unit() - 0.5);
            const double distance = distance_to_border((const double(*)[2])point, n, x, y);
            assert_true(cml_footprint_border_is_near(footprint, x, y, 1.001 * distance + 1e-12 * size));
            if (distance > 1e-9 * size)
                assert_false(cml_footprint_border_is_near(footprint, x, y, 0.999 * distance));
        }
        cml_footprint_free(footprint);
    }
}

static void agrees_with_brute_force(void **state)
{
    (void)state;
    double point[500][2];
    for (int i = 0; i < 300; i++) {
        const size_t n = 3 + (size_t)(random_unit() * (i < 280 ? 20 : 497));
        random_star(point, n, i % 2);
        compare_inside((const double(*)[2])point, n, 300);
    }
    comb(point, 302);
    compare_inside((const double(*)[2])point, 302, 3000);
}

/* Points at the height of vertices: the half-open rule counts each vertex once. */
static void vertices_count_once(void **state)
{
    (void)state;
    const double diamond[][2] = {{0, -1}, {1, 0}, {0, 1}, {-1, 0}};
    const double steps[][2] = {{0, 0}, {3, 0}, {3, 1}, {2, 1}, {2, 2}, {1, 2}, {1, 1}, {0, 1}};
    struct cml_footprint *footprint = make_footprint(diamond, 4);
    assert_true(cml_footprint_contains(footprint, 0, 0));
    assert_true(cml_footprint_contains(footprint, 0.5, 0));
    assert_false(cml_footprint_contains(footprint, -2, 0));
    assert_false(cml_footprint_contains(footprint, 2, 0));
    assert_false(cml_footprint_contains(footprint, -2, 1));
    assert_false(cml_footprint_contains(footprint, 0, 1.5));
    assert_false(cml_footprint_contains(footprint, 0, NAN));
    assert_false(cml_footprint_contains(footprint, NAN, 0));
    cml_footprint_free(footprint);
    footprint = make_footprint(steps, 8);
    assert_false(cml_footprint_contains(footprint, -1, 1));
    assert_false(cml_footprint_contains(footprint, 4, 1));
    assert_true(cml_footprint_contains(footprint, 1.5, 1));
    assert_false(cml_footprint_contains(footprint, -1, 0));
    cml_footprint_free(footprint);
    cml_footprint_free(NULL);
}

static size_t crossing(const double (*point)[2], size_t n)
{
    struct cml_polygon_rows rows;
    struct cml_error err;
    size_t edge = 0;
    assert_int_equal(cml_polygon_rows_build(point, n, &rows, &err), CML_OK);
    assert_true(rows.first[rows.num_rows] <= 3 * n + rows.num_rows);
    assert_int_equal(cml_polygon_find_crossing(&rows, &edge, &err), CML_OK);
    cml_polygon_rows_clear(&rows);
    return edge;
}

/* True if two edges cross properly. Touching edges are left out, because random points are in general
 * position. */
static bool crosses_by_brute_force(const double (*point)[2], size_t n)
{
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < n; j++) {
            const double *a = point[i], *b = point[(i + 1) % n], *c = point[j], *d = point[(j + 1) % n];
            const double r[2] = {b[0] - a[0], b[1] - a[1]}, s[2] = {d[0] - c[0], d[1] - c[1]};
            const double det = r[0] * s[1] - r[1] * s[0];
            const double t = ((c[0] - a[0]) * s[1] - (c[1] - a[1]) * s[0]) / det;
            const double u = ((c[0] - a[0]) * r[1] - (c[1] - a[1]) * r[0]) / det;
            if (j != i && j != (i + 1) % n && i != (j + 1) % n && t > 0 && t < 1 && u > 0 && u < 1)
                return true;
        }
    }
    return false;
}

static void finds_crossings(void **state)
{
    (void)state;
    double point[200][2];
    int simple = 0;
    for (int i = 0; i < 3000; i++) {
        const size_t n = 4 + (size_t)(3 * random_unit());
        for (size_t k = 0; k < 2 * n; k++) point[k / 2][k % 2] = random_unit();
        const bool crosses = crosses_by_brute_force((const double(*)[2])point, n);
        assert_int_equal(crossing((const double(*)[2])point, n) != CML_POLYGON_SIMPLE, crosses);
        simple += !crosses;
    }
    assert_in_range(simple, 500, 2500);
    for (int i = 0; i < 200; i++) {
        random_star(point, 200, i % 2);
        assert_true(crossing((const double(*)[2])point, 200) == CML_POLYGON_SIMPLE);
        memcpy(point[50], point[(60 + i) % 200 == 50 ? 51 : (60 + i) % 200],
               sizeof point[0]); /* a vertex that touches another one */
        assert_true(crossing((const double(*)[2])point, 200) != CML_POLYGON_SIMPLE);
    }
    comb(point, 200);
    assert_true(crossing((const double(*)[2])point, 200) == CML_POLYGON_SIMPLE);
}

static void finds_contacts(void **state)
{
    (void)state;
    const double touch[][2] = {{0, 0}, {2, 0}, {2, 2}, {1, 0}, {0, 2}};
    const double fold[][2] = {{0, 0}, {2, 0}, {1, 0}, {1, 1}};
    const double overlap[][2] = {{0, 0}, {3, 0}, {3, 1}, {2, 1}, {2, 0}, {1, 0}, {1, 1}, {0, 1}};
    const double straight[][2] = {{0, 0}, {1, 0}, {2, 0}, {2, 2}, {0, 2}, {0, 1}};
    const double line[][2] = {{0, 0}, {0, 1}, {0, 2}};
    assert_true(crossing(touch, 5) != CML_POLYGON_SIMPLE);
    assert_true(crossing(fold, 4) != CML_POLYGON_SIMPLE);
    assert_true(crossing(overlap, 8) != CML_POLYGON_SIMPLE);
    assert_true(crossing(straight, 6) == CML_POLYGON_SIMPLE);
    assert_true(crossing(line, 3) != CML_POLYGON_SIMPLE);
}

/* Boxes against the border of an L, a 3 x 3 square without the corner from (1, 1) on. */
static void a_box_lies_inside_or_not(void **state)
{
    (void)state;
    const double vertex[][3] = {{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
    const uint32_t triangle[][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}};
    uint32_t border[] = {0, 5, 4, 3, 2, 1};
    const struct cml_mesh mesh = {.num_vertices = 6,
                                  .num_triangles = 4,
                                  .vertex = (double(*)[3])vertex,
                                  .triangle = (uint32_t(*)[3])triangle,
                                  .border = border,
                                  .num_border = 6};
    const struct {
        double lower[2], upper[2];
        bool inside;
    } boxes[] = {{{0, 0}, {3, 1}, true},      {{0, 0}, {1, 3}, true},      {{.2, .2}, {.8, 2.9}, true},
                 {{0, 0}, {3, 3}, false},     {{0, 0}, {1.1, 1.1}, false}, {{-.1, .2}, {.5, .5}, false},
                 {{1.5, 1.5}, {2, 2}, false}, {{-1, -1}, {4, 4}, false},   {{.5, -.1}, {.6, 3.1}, false},
                 {{0, 0}, {3, 1.01}, false},  {{5, 5}, {6, 6}, false}};
    struct cml_footprint *footprint = NULL;
    struct cml_error err;
    assert_int_equal(cml_footprint_create(&mesh, &footprint, &err), CML_OK);
    for (size_t i = 0; i < sizeof boxes / sizeof boxes[0]; i++)
        assert_int_equal(cml_footprint_contains_box(footprint, boxes[i].lower, boxes[i].upper),
                         boxes[i].inside);
    cml_footprint_free(footprint);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(agrees_with_brute_force), cmocka_unit_test(finds_the_border),
        cmocka_unit_test(vertices_count_once),     cmocka_unit_test(finds_crossings),
        cmocka_unit_test(finds_contacts),          cmocka_unit_test(a_box_lies_inside_or_not),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
