/* Tests of radial profiles: which points of a profile become one straight interval.
 * SPDX-License-Identifier: MIT */
#include "scene/radial.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define COUNT(array) ((int)(sizeof(array) / sizeof(array)[0]))

static struct cml_radial merge(int n, double *r, double *h)
{
    const struct cml_radial from = {n, r, h};
    struct cml_radial to;
    struct cml_error err;
    assert_int_equal(cml_radial_merge(&from, &to, &err), CML_OK);
    return to;
}

static void expect(int n, double *r, double *h, int left, const int *kept)
{
    struct cml_radial to = merge(n, r, h);
    assert_int_equal(to.n, left);
    for (int i = 0; i < left; i++) {
        assert_true(to.r[i] == r[kept[i]]);
        assert_true(to.h[i] == h[kept[i]]);
    }
    cml_radial_clear(&to);
    assert_null(to.r);
}

static void test_flat(void **state)
{
    (void)state;
    double r[] = {0.0, 1.0, 2.0}, flat[] = {0.1, 0.1, 0.1}, bent[] = {0.1, 0.1, 0.2};
    assert_true(cml_radial_is_flat(&(struct cml_radial){3, r, flat}));
    assert_true(cml_radial_is_flat(&(struct cml_radial){1, r, bent}));
    assert_false(cml_radial_is_flat(&(struct cml_radial){3, r, bent}));
    expect(3, r, flat, 1, (const int[]){0});
    expect(1, r, flat, 1, (const int[]){0});
}

static void test_keeps_what_bends(void **state)
{
    (void)state;
    double r[] = {0.0, 0.1, 0.25, 0.3, 0.9}, h[] = {1.0, 0.5, 0.5, 0.7, 0.1};
    expect(COUNT(r), r, h, 5, (const int[]){0, 1, 2, 3, 4});
}

static void test_drops_straight_runs_and_tails(void **state)
{
    (void)state;
    double r[] = {0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7};
    double h[] = {0.3, 0.3, 0.3, 0.2, 0.1, 0.0, 0.0, 0.0};
    expect(COUNT(r), r, h, 3, (const int[]){0, 2, 5});
}

/* Radii that are sums of spacings are off by roundings. A straight flank must still become one interval. */
static void test_sees_through_rounding(void **state)
{
    (void)state;
    double r[1000], h[1000];
    r[0] = 0.0;
    for (int i = 1; i < 1000; i++) r[i] = r[i - 1] + 0.001;
    for (int i = 0; i < 1000; i++) h[i] = 0.7 - 0.3 * r[i];
    struct cml_radial to = merge(1000, r, h);
    assert_int_equal(to.n, 2);
    cml_radial_clear(&to);
}

/* Bends of one rounding each must not add up to a different surface. */
static void test_small_bends_do_not_add_up(void **state)
{
    (void)state;
    enum { N = 4000 };
    static double r[N], h[N];
    for (int i = 0; i < N; i++) {
        r[i] = i;
        h[i] = 1.0 + (double)i * (double)i * 0.5 * DBL_EPSILON;
    }
    struct cml_radial from = {N, r, h}, to = merge(N, r, h);
    assert_true(to.n > 100 && to.n < N);
    for (int i = 0; i < N; i++)
        assert_true(fabs(cml_radial_height(&to, r[i]) - cml_radial_height(&from, r[i])) <= 16 * DBL_EPSILON);
    cml_radial_clear(&to);
}

static void test_scale_by_powers_of_two(void **state)
{
    (void)state;
    double r[200], h[200], r_big[200], h_big[200];
    for (int i = 0; i < 200; i++) {
        r[i] = 0.01 * i;
        h[i] = i % 20 < 10 ? 0.3 - 0.1 * r[i] : 0.2 + 0.05 * r[i];
        r_big[i] = ldexp(r[i], 40);
        h_big[i] = ldexp(h[i], 40);
    }
    struct cml_radial small = merge(200, r, h), big = merge(200, r_big, h_big);
    assert_int_equal(small.n, big.n);
    assert_true(small.n < 60);
    for (int i = 0; i < small.n; i++) assert_true(big.r[i] == ldexp(small.r[i], 40));
    cml_radial_clear(&small);
    cml_radial_clear(&big);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_flat),
        cmocka_unit_test(test_keeps_what_bends),
        cmocka_unit_test(test_drops_straight_runs_and_tails),
        cmocka_unit_test(test_sees_through_rounding),
        cmocka_unit_test(test_small_bends_do_not_add_up),
        cmocka_unit_test(test_scale_by_powers_of_two),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
