/* Tests of cml_result_times_to, which estimates how many times longer a run must be to reach a given
 * error. SPDX-License-Identifier: MIT */
#include "lib/require.h"

#include "tally/result.h"

#include <math.h>

static const struct cml_tally_grid grid = {.nr = 3, .nz = 4, .na = 2, .num_layers = 1};

/* Returns a result of 6400 photons. Half of the batches reflect 30 of 100 photons, the others 10: 0.2 in
 * the mean, with a standard error of 0.1 sqrt(64 / 63) / sqrt(64). Nothing is transmitted. */
static struct cml_result flown(void)
{
    struct cml_result result;
    struct cml_error err;
    require_ok(cml_result_create(&grid, 6400, &result, &err), &err);
    result.summary.balance[CML_BALANCE_LAUNCHED] = (cml_u128)6400 << 31;
    result.summary.balance[CML_BALANCE_REFLECTED] = (cml_u128)1280 << 31;
    for (int b = 0; b < CML_NUM_BATCHES; b++)
        result.totals[b * CML_NUM_TOTALS + CML_TOTAL_REFLECTED] = (cml_u128)(b % 2 ? 30 : 10) << 31;
    return result;
}

static void time_grows_with_the_square_of_the_error(void **state)
{
    (void)state;
    struct cml_result result = flown();
    const double relative = 0.1 * sqrt(64.0 / 63) / 8 / 0.2;
    const double expected = relative * relative / 1e-4;
    const double found = cml_result_times_to(&result, CML_TOTAL_REFLECTED, 0.01);
    assert_true(fabs(found / expected - 1) < 1e-12);
    assert_true(fabs(cml_result_times_to(&result, CML_TOTAL_REFLECTED, 0.001) / found - 100) < 1e-9);
    cml_result_free(&result);
}

static void what_was_not_seen_takes_for_ever(void **state)
{
    (void)state;
    struct cml_result result = flown();
    assert_true(isinf(cml_result_times_to(&result, CML_TOTAL_TRANSMITTED, 0.01)));
    for (int b = 0; b < CML_NUM_BATCHES; b++) /* the same number from every batch: no spread */
        result.totals[b * CML_NUM_TOTALS + CML_TOTAL_REFLECTED] = (cml_u128)20 << 31;
    assert_true(isinf(cml_result_times_to(&result, CML_TOTAL_REFLECTED, 0.01)));
    cml_result_free(&result);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(time_grows_with_the_square_of_the_error),
        cmocka_unit_test(what_was_not_seen_takes_for_ever),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
