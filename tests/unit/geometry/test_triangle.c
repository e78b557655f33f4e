/* Tests of the triangle intersection test against separating axes in integers, and of the exact predicates
 * against 128-bit determinants. SPDX-License-Identifier: MIT */
#include "geometry/box_tree.h"
#include "geometry/predicate.h"
#include "geometry/triangle.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static uint64_t random_state = 1;

static uint64_t draw(void)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return random_state;
}

static int64_t draw_whole(int64_t limit)
{
    return (int64_t)(draw() >> 11) % (2 * limit + 1) - limit;
}

typedef int64_t point[3];

static void cross(const point a, const point b, point out)
{
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        out[k] = a[i] * b[j] - a[j] * b[i];
    }
}

static bool axis_separates(const point axis, const point a[3], const point b[3])
{
    int64_t low[2] = {INT64_MAX, INT64_MAX}, high[2] = {INT64_MIN, INT64_MIN};
    for (int i = 0; i < 6; i++) {
        const int64_t *p = i < 3 ? a[i] : b[i - 3];
        const int64_t s = p[0] * axis[0] + p[1] * axis[1] + p[2] * axis[2];
        if (s < low[i / 3]) low[i / 3] = s;
        if (s > high[i / 3]) high[i / 3] = s;
    }
    return high[0] < low[1] || high[1] < low[0];
}

/* True if two triangles meet, exact in integers and by another method than the code under test. Disjoint
 * convex bodies have a separating plane along a normal, along a product of edges, or (in one plane) across
 * an edge. */
static bool meet_by_axes(const point a[3], const point b[3])
{
    point edge[6], normal[2], axis;
    for (int i = 0; i < 6; i++) {
        const point *t = i < 3 ? a : b;
        for (int k = 0; k < 3; k++) edge[i][k] = t[(i % 3 + 1) % 3][k] - t[i % 3][k];
    }
    cross(edge[0], edge[1], normal[0]);
    cross(edge[3], edge[4], normal[1]);
    for (int n = 0; n < 2; n++) {
        if (axis_separates(normal[n], a, b)) return false;
        for (int i = 0; i < 6; i++) {
            cross(normal[n], edge[i], axis);
            if (axis_separates(axis, a, b)) return false;
        }
    }
    for (int i = 0; i < 3; i++)
        for (int j = 3; j < 6; j++) {
            cross(edge[i], edge[j], axis);
            if (axis_separates(axis, a, b)) return false;
        }
    return true;
}

static bool has_area(const point t[3])
{
    point u, v, n;
    for (int k = 0; k < 3; k++) {
        u[k] = t[1][k] - t[0][k];
        v[k] = t[2][k] - t[0][k];
    }
    cross(u, v, n);
    return n[0] || n[1] || n[2];
}

static void draw_triangle(point t[3], int64_t limit, int first)
{
    do {
        for (int i = first; i < 3; i++)
            for (int k = 0; k < 3; k++) t[i][k] = draw_whole(limit);
    } while (!has_area((const point *)t));
}

static enum cml_contact contact(const point a[3], const point b[3], int shared)
{
    double v[2][3][3], place[3];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            v[0][i][k] = (double)a[i][k];
            v[1][i][k] = (double)b[i][k];
        }
    const double *const p[3] = {v[0][0], v[0][1], v[0][2]}, *const q[3] = {v[1][0], v[1][1], v[1][2]};
    return cml_triangle_contact(p, q, shared, place);
}

static void test_strangers(void **state)
{
    (void)state;
    int meetings = 0;
    for (int i = 0; i < 200000; i++) {
        point a[3], b[3];
        const int64_t limit = i % 3 == 0 ? 2 : i % 3 == 1 ? 6 : 1000;
        draw_triangle(a, limit, 0);
        draw_triangle(b, limit, 0);
        const bool meet = meet_by_axes((const point *)a, (const point *)b);
        meetings += meet;
        if ((contact((const point *)a, (const point *)b, 0) != CML_APART) != meet) fail_msg("case %d", i);
    }
    assert_in_range(meetings, 20000, 180000);
}

static void test_at_corner(void **state)
{
    (void)state;
    for (int i = 0; i < 200000; i++) {
        point a[3], b[3];
        const int64_t limit = i % 2 ? 2 : 9;
        draw_triangle(a, limit, 0);
        memcpy(b[0], a[0], sizeof b[0]);
        draw_triangle(b, limit, 1);
        point side_a[3], side_b[3];
        for (int k = 0; k < 3; k++) {
            memcpy(side_a[k], a[k == 0 ? 1 : k], sizeof side_a[k]);
            memcpy(side_b[k], b[k == 0 ? 1 : k], sizeof side_b[k]);
        }
        const bool meet = meet_by_axes((const point *)side_a, (const point *)b) ||
                          meet_by_axes((const point *)side_b, (const point *)a);
        if ((contact((const point *)a, (const point *)b, 1) != CML_APART) != meet) fail_msg("case %d", i);
    }
}

static void test_at_edge(void **state)
{
    (void)state;
    const point a[3] = {{0, 0, 0}, {4, 0, 0}, {1, 3, 0}};
    const point flat[3] = {{0, 0, 0}, {4, 0, 0}, {2, -3, 0}};
    const point raised[3] = {{0, 0, 0}, {4, 0, 0}, {2, 3, 1}};
    const point folded[3] = {{0, 0, 0}, {4, 0, 0}, {2, 5, 0}};
    assert_int_equal(contact(a, flat, 2), CML_APART);
    assert_int_equal(contact(a, raised, 2), CML_APART);
    assert_int_equal(contact(a, folded, 2), CML_TOUCH);
    assert_int_equal(contact(a, a, 3), CML_TOUCH);
}

static void test_tells_crossing_from_touching(void **state)
{
    (void)state;
    const point floor[3] = {{-4, -4, 0}, {8, -4, 0}, {-4, 8, 0}};
    const point through[3] = {{0, 0, -1}, {0, 0, 1}, {1, 0, 1}};
    const point standing[3] = {{0, 0, 0}, {0, 0, 1}, {1, 0, 1}};
    const point lying[3] = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}};
    const point over[3] = {{0, 0, 1}, {0, 1, 1}, {1, 0, 1}};
    assert_int_equal(contact(floor, through, 0), CML_CROSS);
    assert_int_equal(contact(floor, standing, 0), CML_TOUCH);
    assert_int_equal(contact(floor, lying, 0), CML_TOUCH);
    assert_int_equal(contact(lying, floor, 0), CML_TOUCH);
    assert_int_equal(contact(floor, over, 0), CML_APART);
}

static int sign_of(__int128 x)
{
    return (x > 0) - (x < 0);
}

/* Nearly coplanar points with 40-bit coordinates, which the filter in double precision cannot decide. */
static void test_predicates_are_exact(void **state)
{
    (void)state;
    int zeros = 0;
    for (int i = 0; i < 100000; i++) {
        int64_t p[4][3], m[3][3];
        double x[4][3];
        const int64_t s = draw_whole(3), t = draw_whole(3), off = draw_whole(1);
        for (int k = 0; k < 3; k++) {
            for (int j = 0; j < 3; j++) p[j][k] = draw_whole((int64_t)1 << 36);
            p[3][k] = p[0][k] + s * (p[1][k] - p[0][k]) + t * (p[2][k] - p[0][k]) + off;
            for (int j = 0; j < 4; j++) x[j][k] = (double)p[j][k];
            for (int j = 0; j < 3; j++) m[j][k] = p[j][k] - p[3][k];
        }
        __int128 det = 0;
        for (int k = 0; k < 3; k++) {
            const int u = (k + 1) % 3, v = (k + 2) % 3;
            det += m[0][k] * ((__int128)m[1][u] * m[2][v] - (__int128)m[1][v] * m[2][u]);
        }
        zeros += det == 0;
        assert_int_equal(cml_orient3d(x[0], x[1], x[2], x[3]), sign_of(det));
        const __int128 plan = (__int128)m[0][0] * m[1][1] - (__int128)m[0][1] * m[1][0];
        assert_int_equal(cml_orient2d(x[0], x[1], x[3]), sign_of(plan));
    }
    assert_true(zeros > 1000);
}

/* Differences that do not fit into one double, such as 2^-60 beside 1. */
static void test_predicates_with_tails(void **state)
{
    (void)state;
    const double tiny = 0x1p-60;
    const double a[3] = {0, 0, 0}, b[3] = {1, tiny, 0}, c[3] = {tiny, 1, 0};
    assert_int_equal(cml_orient3d(a, b, c, (const double[3]){0.3, 0.3, 0x1p-200}), -1);
    assert_int_equal(cml_orient3d(a, b, c, (const double[3]){0.3, 0.3, 0.0}), 0);
    assert_int_equal(
        cml_orient2d((const double[2]){-1, -1}, (const double[2]){1, 1}, (const double[2]){0, tiny}), 1);
    assert_int_equal(
        cml_orient2d((const double[2]){-1, -1}, (const double[2]){1, 1}, (const double[2]){tiny, tiny}), 0);
}

/* Counters of the tree's callbacks: pairs of triangles found, and triangles found in a column. Tests
 * compare them with all pairs. */
struct count {
    int pairs;
    int column;
};

static bool count_pair(void *context, uint32_t i, uint32_t j)
{
    assert_int_not_equal(i, j);
    ((struct count *)context)->pairs++;
    return false;
}

static void count_column(void *context, uint32_t i)
{
    (void)i;
    ((struct count *)context)->column++;
}

static bool ranges_touch(const double (*v)[3], uint32_t i, uint32_t j, int k)
{
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (uint32_t c = 0; c < 6; c++) {
        const double x = v[c < 3 ? 3 * i + c : 3 * j + c - 3][k];
        low[c / 3] = fmin(low[c / 3], x);
        high[c / 3] = fmax(high[c / 3], x);
    }
    return low[0] <= high[1] && low[1] <= high[0];
}

static void test_boxtree(void **state)
{
    (void)state;
    enum { N = 301 };
    static double vertex[3 * N][3];
    static uint32_t triangle[N][3];
    for (uint32_t i = 0; i < 3 * N; i++) {
        for (int k = 0; k < 3; k++)
            vertex[i][k] = (double)(draw_whole(3) + 4 * (int64_t)(i / 3 % 7) * (k == 0));
        triangle[i / 3][i % 3] = i;
    }
    int pairs = 0, column = 0;
    for (uint32_t i = 0; i < N; i++) {
        for (uint32_t j = i + 1; j < N; j++)
            pairs += ranges_touch((const double(*)[3])vertex, i, j, 0) &&
                     ranges_touch((const double(*)[3])vertex, i, j, 1) &&
                     ranges_touch((const double(*)[3])vertex, i, j, 2);
    }
    struct cml_boxtree *tree;
    struct cml_error err;
    struct count count = {0, 0};
    assert_int_equal(
        cml_boxtree_create((const double(*)[3])vertex, (const uint32_t(*)[3])triangle, N, &tree, &err),
        CML_OK);
    assert_false(cml_boxtree_own_pairs(tree, count_pair, &count));
    assert_int_equal(count.pairs, pairs);
    for (uint32_t i = 0; i < N; i++) {
        double x[2] = {INFINITY, -INFINITY}, y[2] = {INFINITY, -INFINITY};
        for (int k = 0; k < 3; k++) {
            const double *v = vertex[triangle[i][k]];
            x[0] = fmin(x[0], v[0]), x[1] = fmax(x[1], v[0]);
            y[0] = fmin(y[0], v[1]), y[1] = fmax(y[1], v[1]);
        }
        column += x[0] <= 8.0 && 8.0 <= x[1] && y[0] <= 1.5 && 1.5 <= y[1];
    }
    cml_boxtree_touching(tree, (double[]){8.0, 1.5, -INFINITY}, (double[]){8.0, 1.5, INFINITY}, count_column,
                         &count);
    assert_int_equal(count.column, column);
    cml_boxtree_free(tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_strangers),
        cmocka_unit_test(test_at_corner),
        cmocka_unit_test(test_at_edge),
        cmocka_unit_test(test_tells_crossing_from_touching),
        cmocka_unit_test(test_predicates_are_exact),
        cmocka_unit_test(test_predicates_with_tails),
        cmocka_unit_test(test_boxtree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
