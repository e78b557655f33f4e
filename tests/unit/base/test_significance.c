/* Tests of the tails of distributions (normal, Student's t, chi-square) against printed tables and closed
 * forms. SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

#include "base/significance.h"

static void assert_near(double value, double expected, double relative)
{
    assert_true(fabs(value - expected) <= relative * fabs(expected));
}

/* Values from Abramowitz and Stegun, tables 26.1 and 26.2. */
static void normal_tails_are_those_of_the_tables(void **state)
{
    (void)state;
    assert_near(cml_two_sided(0), 1, 1e-15);
    assert_near(cml_two_sided(1), 0.31731050786, 1e-10);
    assert_near(cml_two_sided(-3), 0.0026997960633, 1e-10);
    assert_near(cml_two_sided(6), 1.9731752898e-9, 1e-9);
    assert_true(cml_two_sided(INFINITY) == 0);
}

/* Returns the two-sided tail of Student's t by Simpson's rule over the angle a: t = sqrt(f) tan(a), dt
 * becomes cos^(f-1) da. */
static double student_tail(double t, int freedom)
{
    const double half = acos(0.0), from = atan(t / sqrt(freedom));
    const int steps = 20000;
    double tail = 0, all = 0;
    for (int i = 0; i <= steps; i++) {
        const double weight = i == 0 || i == steps ? 1 : i % 2 ? 4 : 2, x = (double)i / steps;
        tail += weight * pow(cos(from + (half - from) * x), freedom - 1) * (half - from);
        all += weight * pow(cos(half * x), freedom - 1) * half;
    }
    return tail / all;
}

static void students_tail_becomes_the_normal_one(void **state)
{
    (void)state;
    for (int freedom = 63; freedom <= 504; freedom *= 2)
        for (double t = 0.5; t <= 10; t += 0.5) {
            const double z = cml_normal_of_student(t, freedom);
            assert_near(cml_two_sided(z), student_tail(t, freedom), 0.02);
            assert_true(cml_normal_of_student(-t, freedom) == -z);
        }
    assert_true(cml_normal_of_student(3, INFINITY) == 3);
    assert_true(cml_normal_of_student(-INFINITY, 63) == -INFINITY);
}

static void sidak_is_the_chance_of_the_smallest(void **state)
{
    (void)state;
    assert_near(cml_sidak(0.5, 2), 0.75, 1e-15);
    assert_near(cml_sidak(1e-20, 1e6), 1e-14, 1e-9); /* no digits are lost by cancellation */
    assert_true(cml_sidak(1, 10) == 1 && cml_sidak(0, 10) == 0 && cml_sidak(0.01, 0) == 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(normal_tails_are_those_of_the_tables),
        cmocka_unit_test(students_tail_becomes_the_normal_one),
        cmocka_unit_test(sidak_is_the_chance_of_the_smallest),
    };
    return cmocka_run_group_tests_name("significance", tests, NULL, NULL);
}
