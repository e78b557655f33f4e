/* Tests of src/base/array.h: allocation of several arrays at once, copies of arrays, and binary search in
 * rising numbers. SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/array.h"

static void arrays_begin_with_zeros_and_end_together(void **state)
{
    (void)state;
    struct cml_arrays arrays = {0};
    struct cml_error err;
    for (size_t count = 0; count < 100; count++) {
        unsigned char *bytes = cml_arrays_add(&arrays, count, 1);
        assert_non_null(bytes);
        assert_int_equal((uintptr_t)bytes % 16, 0);
        for (size_t i = 0; i < count; i++) assert_int_equal(bytes[i], 0);
        memset(bytes, 1, count);
    }
    assert_int_equal(cml_arrays_check(&arrays, "bins", &err), CML_OK);
    cml_arrays_free(&arrays);
    assert_null(arrays.last);
}

/* If one of several arrays does not fit into memory, the error names the size of all of them, and the
 * arrays already allocated are freed. */
static void an_array_that_does_not_fit_is_an_error(void **state)
{
    (void)state;
    struct cml_arrays arrays = {0};
    struct cml_error err;
    assert_non_null(cml_arrays_add(&arrays, 3, 1 << 20));
    assert_null(cml_arrays_add(&arrays, SIZE_MAX / 4, 8));
    assert_null(cml_arrays_add(&arrays, SIZE_MAX, 1));
    assert_non_null(cml_arrays_add(&arrays, 1, 1));
    assert_int_equal(cml_arrays_check(&arrays, "bins", &err), CML_E_INPUT);
    assert_memory_equal(err.text, "out of memory: ", 15);
    assert_non_null(strstr(err.text, " MiB for bins"));
    cml_arrays_free(&arrays);
}

static void copies_are_equal_and_none_stays_none(void **state)
{
    (void)state;
    const int from[] = {1, 2, 3};
    bool failed = false;
    int *to = cml_array_copy(from, 3, sizeof *from, &failed), *empty = cml_array_copy(from, 0, 4, &failed);
    assert_memory_equal(to, from, sizeof from);
    assert_non_null(empty);
    assert_null(cml_array_copy(NULL, 3, sizeof *from, &failed));
    assert_false(failed);
    free(to);
    free(empty);
}

static void the_search_finds_what_a_look_at_all_finds(void **state)
{
    (void)state;
    const double values[] = {0, 1, 1, 2, 5, 5, 5, 7};
    for (size_t n = 1; n <= sizeof values / sizeof *values; n++)
        for (double x = -0.5; x <= 8; x += 0.5) {
            size_t last = 0;
            for (size_t i = 0; i < n; i++)
                if (values[i] <= x) last = i;
            assert_int_equal(cml_last_not_above(values, n, x), last);
        }
}

static void numbers_are_sorted_and_each_is_there_once(void **state)
{
    (void)state;
    double values[] = {3, -1, 3, 0, -1, 3, 7}, one[] = {2};
    const double distinct[] = {-1, 0, 3, 7};
    assert_int_equal(cml_sort_distinct(values, 7), 4);
    assert_memory_equal(values, distinct, sizeof distinct);
    assert_int_equal(cml_sort_distinct(one, 1), 1);
    assert_int_equal(cml_sort_distinct(one, 0), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arrays_begin_with_zeros_and_end_together),
        cmocka_unit_test(an_array_that_does_not_fit_is_an_error),
        cmocka_unit_test(copies_are_equal_and_none_stays_none),
        cmocka_unit_test(the_search_finds_what_a_look_at_all_finds),
        cmocka_unit_test(numbers_are_sorted_and_each_is_there_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
