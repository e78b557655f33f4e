/* Cases of kernels/mathf.h (logarithm, exponential, sine, arc cosine), compiled once in float and once in
 * double. SPDX-License-Identifier: MIT */
#include "lib/dice.h"
#include "mathf.h"

#include <float.h>

#ifdef CML_DOUBLE
static const double log_bound = 2.3e-16, circle_bound = 2e-16, acos_bound = 2.3e-16, exp_bound = 2.3e-16;
#define SMALLEST DBL_MIN
#define LARGEST DBL_MAX
#else
static const double log_bound = 1.2e-7, circle_bound = 1.2e-7, acos_bound = 1.4e-7, exp_bound = 1.2e-7;
#define SMALLEST FLT_MIN
#define LARGEST FLT_MAX
#endif

static double log_error(real x)
{
    const long double exact = logl((long double)x);
    return (double)fabsl(((long double)cml_log(x) - exact) / exact);
}

static void the_logarithm_of_one_is_zero(void **state)
{
    (void)state;
    assert_true(cml_log(1) == 0);
}

/* Arguments on both sides of 1, where the relative error is largest, and a dense sample of the range of
 * uniforms. */
static void the_logarithm_keeps_its_bound_near_one(void **state)
{
    (void)state;
    double worst = 0;
    real x = (real)0.25;
    for (; x < 4; x *= (real)(1 + 1e-6))
        if (x != 1) worst = fmax(worst, log_error(x));
    for (int n = 1; n < 200000; n++) {
        worst = fmax(worst, log_error((real)1 + (real)n * CML_EPSILON));
        worst = fmax(worst, log_error((real)1 - (real)n * CML_EPSILON / 2));
    }
    assert_near("largest relative error", worst, 0, log_bound);
}

static void the_logarithm_keeps_its_bound_everywhere(void **state)
{
    (void)state;
    struct dice dice = dice_new(11);
    const real edges[] = {SMALLEST,        LARGEST,          (real)0x1p-33,
                          (real)0x1.8p-32, (real)0.70710678, (real)1.41421357};
    double worst = 0;
    for (int i = 0; i < COUNT(edges); i++) worst = fmax(worst, log_error(edges[i]));
    for (int n = 0; n < 300000; n++) {
        worst = fmax(worst, log_error((real)exp(dice_between(&dice, log(SMALLEST), log(LARGEST)))));
        worst = fmax(worst, log_error(cml_uniform(dice_word(&dice) & ~0x80000000u)));
    }
    assert_near("largest relative error", worst, 0, log_bound);
}

static double circle_error(uint32_t word)
{
    const long double turn = 6.283185307179586476925286766559L;
    /* the lower 30 bits, signed, are a part of a quadrant; the upper bits are its number */
    const long double angle = (word >> 30) * turn / 4 + (long double)(int32_t)(word << 2) * 0x1p-34L * turn;
    real c, s;
    cml_circle_point(word, &c, &s);
    return (double)fmaxl(fabsl((long double)c - cosl(angle)), fabsl((long double)s - sinl(angle)));
}

static void circle_points_keep_their_bound(void **state)
{
    (void)state;
    double worst = 0;
    for (uint64_t word = 0; word < 0x100000000u; word += 256 * 61)
        worst = fmax(worst, circle_error((uint32_t)word));
    for (uint32_t quadrant = 0; quadrant < 4; quadrant++)
        for (uint32_t n = 0; n < 1000; n++) {
            worst = fmax(worst, circle_error((quadrant << 30) + (n << 8)));
            worst = fmax(worst, circle_error((quadrant << 30) + 0x3fffffffu - (n << 8)));
            worst = fmax(worst, circle_error((quadrant << 30) + 0x20000000u - 500 * 256 + (n << 8)));
        }
    assert_near("largest error", worst, 0, circle_bound);
}

/* Rotations by quadrants map the points onto each other, so the mean of all points is exactly 0. */
static void opposite_words_give_opposite_points(void **state)
{
    (void)state;
    struct dice dice = dice_new(12);
    for (int n = 0; n < 100000; n++) {
        const uint32_t word = dice_word(&dice);
        real c, s, c2, s2;
        cml_circle_point(word, &c, &s);
        cml_circle_point(word + 0x80000000u, &c2, &s2);
        assert_true(c == -c2 && s == -s2);
        cml_circle_point(word + 0x40000000u, &c2, &s2);
        assert_true(c2 == -s && s2 == c);
    }
}

static double acos_error(real c)
{
    return (double)fabsl((long double)cml_acos(c) - acosl((long double)c));
}

/* Arguments: evenly spaced, from both ends in steps of one rounding, near 1/2 (where two formulas meet),
 * and over all exponents. */
static void the_arc_cosine_keeps_its_bound(void **state)
{
    (void)state;
    double worst = fmax(acos_error(0), acos_error(SMALLEST));
    for (int n = 1; n <= 1000000; n++) worst = fmax(worst, acos_error((real)(n * 1e-6)));
    for (int n = 0; n < 200000; n++) {
        const real steps = (real)n * CML_EPSILON / 2;
        worst = fmax(worst, acos_error(1 - steps));
        worst = fmax(worst, acos_error((real)0.5 + steps));
        worst = fmax(worst, acos_error((real)0.5 - steps / 2));
    }
    struct dice dice = dice_new(13);
    for (int n = 0; n < 300000; n++)
        worst = fmax(worst, acos_error((real)exp(dice_between(&dice, log(SMALLEST), 0))));
    assert_near("largest error", worst, 0, acos_bound);
}

/* Packets that leave along the normal are in the first angle bin; those along the surface are in the last
 * one. */
static void the_ends_of_the_arc_cosine_are_right(void **state)
{
    (void)state;
    assert_true(cml_acos(1) == 0);
    assert_true(cml_acos(0) == (real)1.5707963267948966);
    for (real c = SMALLEST; c < 1; c *= (real)1.01)
        assert_true(cml_acos(c) > 0 && cml_acos(c) <= cml_acos(0));
}

static double exp_error(real x)
{
    const long double exact = expl(-(long double)x);
    return (double)fabsl(((long double)cml_exp_minus(x) - exact) / exact);
}

/* Arguments: evenly spaced, and over all exponents. exp(0) is exactly 1, so that a medium without
 * absorption absorbs nothing. */
static void the_exponential_keeps_its_bound(void **state)
{
    (void)state;
    double worst = 0;
    struct dice dice = dice_new(14);
    for (int n = 0; n < 1000000; n++) worst = fmax(worst, exp_error((real)(n * 69e-6)));
    for (int n = 0; n < 300000; n++)
        worst = fmax(worst, exp_error((real)exp(dice_between(&dice, log(SMALLEST), log(60)))));
    assert_near("largest error", worst, 0, exp_bound);
    assert_true(cml_exp_minus(0) == 1);
    assert_true(cml_exp_minus(70) >= 0 && cml_exp_minus(70) < (real)1e-29);
    assert_true(cml_exp_minus(LARGEST) == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_logarithm_of_one_is_zero),
        cmocka_unit_test(the_logarithm_keeps_its_bound_near_one),
        cmocka_unit_test(the_logarithm_keeps_its_bound_everywhere),
        cmocka_unit_test(circle_points_keep_their_bound),
        cmocka_unit_test(opposite_words_give_opposite_points),
        cmocka_unit_test(the_arc_cosine_keeps_its_bound),
        cmocka_unit_test(the_ends_of_the_arc_cosine_are_right),
        cmocka_unit_test(the_exponential_keeps_its_bound),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
