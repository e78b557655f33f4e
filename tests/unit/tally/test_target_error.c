/* Tests of when --target-error ends a run, on results made up here. SPDX-License-Identifier: MIT */
#include "lib/require.h"

#include "tally/target_error.h"

#include <math.h>

static const struct cml_tally_grid grid = {.nr = 1, .nz = 1, .na = 1, .num_layers = 1};
static const enum cml_total totals[] = {CML_TOTAL_REFLECTED, CML_TOTAL_ABSORBED, CML_TOTAL_TRANSMITTED};

/* Sets a total. Batches lie alternately above and below the share, so that it has this relative error. */
static void set_total(struct cml_result *result, enum cml_total total, double share, double relative)
{
    const double off = relative * sqrt(CML_NUM_BATCHES - 1);
    const double weight = share * (double)result->photons / CML_NUM_BATCHES / CML_WEIGHT_UNIT;
    result->summary.balance[cml_balance_term_of_total(total)] = 0;
    for (int b = 0; b < CML_NUM_BATCHES; b++) {
        const cml_u128 units = (cml_u128)(weight * (b % 2 ? 1 + off : 1 - off));
        result->totals[b * CML_NUM_TOTALS + (int)total] = units;
        result->summary.balance[cml_balance_term_of_total(total)] += units;
    }
}

/* Returns a result in which Rd, A and Tt are 0.3 each, with a relative error of 0.01. */
static struct cml_result flown(uint64_t photons)
{
    struct cml_result result;
    struct cml_error err;
    require_ok(cml_result_create(&grid, photons, &result, &err), &err);
    result.summary.balance[CML_BALANCE_LAUNCHED] = (cml_u128)photons << 31;
    for (int i = 0; i < 3; i++) set_total(&result, totals[i], 0.3, 0.01);
    return result;
}

static void every_total_counts(void **state)
{
    (void)state;
    struct cml_result result = flown(64000);
    assert_true(cml_target_met(&result, 0.0101, 0));
    assert_false(cml_target_met(&result, 0.0099, 0));
    for (int i = 0; i < 3; i++) {
        set_total(&result, totals[i], 0.3, 0.02);
        assert_false(cml_target_met(&result, 0.0101, 0));
        set_total(&result, totals[i], 0.3, 0.01);
    }
    cml_result_free(&result);
}

/* A total of 8.3e-4 is below the limit 1e-3 by two standard errors if its error is 10 %, and by more than
 * three if it is 6 %. Only the latter is surely small and left out. */
static void a_small_total_is_left_out_when_it_surely_is_small(void **state)
{
    (void)state;
    struct cml_result result = flown(64000);
    for (int i = 0; i < 3; i++) {
        set_total(&result, totals[i], 8.3e-4, 0.1);
        assert_false(cml_target_met(&result, 0.0101, 0));
        set_total(&result, totals[i], 8.3e-4, 0.06);
        assert_true(cml_target_met(&result, 0.0101, 0));
        set_total(&result, totals[i], 8.3e-4, 0);
        assert_true(cml_target_met(&result, 0.0101, 0));
        set_total(&result, totals[i], 0, 0);
        assert_true(cml_target_met(&result, 0.0101, 0));
        set_total(&result, totals[i], 0.3, 0.01);
    }
    cml_result_free(&result);
}

/* Expected values count instead of Tt, even small ones. Batches have 1000 photons, so a mean of 1e-9 is
 * 2^48 1e-6 units. */
static void expected_values_count_however_small(void **state)
{
    (void)state;
    const int exponent[] = {0, 0};
    struct cml_tally_grid aimed = grid;
    struct cml_result result;
    struct cml_error err;
    aimed.scores = 2;
    aimed.exponent = exponent;
    require_ok(cml_result_create(&aimed, 64000, &result, &err), &err);
    result.summary.balance[CML_BALANCE_LAUNCHED] = (cml_u128)64000 << 31;
    for (int i = 0; i < 3; i++) set_total(&result, totals[i], 0.3, 0.01);
    set_total(&result, CML_TOTAL_TRANSMITTED, 0.3, 0.1);
    for (int rough = -1; rough < 2; rough++) {
        for (int b = 0; b < CML_NUM_BATCHES; b++)
            for (int i = 0; i < 2; i++) {
                const double off = (i == rough ? 0.02 : 0.01) * sqrt(CML_NUM_BATCHES - 1) * (b % 2 ? 1 : -1);
                result.expected[b * 2 + i] =
                    (cml_u128)(1e-6 / CML_EXPECTED_UNIT / CML_WEIGHT_UNIT * (1 + off));
            }
        assert_true(cml_target_met(&result, 0.0101, 0) == (rough < 0));
    }
    cml_result_free(&result);
}

/* Sets a cell. Batches lie alternately above and below a mean of 1e-6, so that it has this relative error. */
static void set_cell(cml_u128 *cell, size_t step, double relative)
{
    const double off = relative * sqrt(CML_NUM_BATCHES - 1);
    for (int b = 0; b < CML_NUM_BATCHES; b++)
        cell[(size_t)b * step] = (cml_u128)(1e-3 / CML_WEIGHT_UNIT * (1 + (b % 2 ? off : -off)));
}

/* Quantities that the option names are the only ones that count, however small, whatever errors the totals
 * have. */
static void what_is_named_counts_alone(void **state)
{
    (void)state;
    struct cml_tally_grid seen = grid;
    struct cml_result result;
    struct cml_error err;
    seen.detectors = 2;
    require_ok(cml_result_create(&seen, 64000, &result, &err), &err);
    result.summary.balance[CML_BALANCE_LAUNCHED] = (cml_u128)64000 << 31;
    for (int i = 0; i < 3; i++) set_total(&result, totals[i], 0.3, 0.1);
    assert_false(cml_target_met(&result, 0.99, -1));
    set_cell(result.detector, 2, 0.01);
    set_cell(result.detector + 1, 2, 0.02);
    set_cell(result.A_l + 1, cml_tally_media(&seen), 0.03);
    for (int of = -2; of < 2; of++) {
        const double error = of == -1 ? 0.01 : of == -2 ? 0.02 : 0.03;
        if (of == 0) continue;
        assert_true(cml_target_met(&result, 1.01 * error, of));
        assert_false(cml_target_met(&result, 0.99 * error, of));
    }
    cml_result_free(&result);
}

static void few_photons_are_no_judges(void **state)
{
    (void)state;
    for (uint64_t photons = 64; photons <= 16384; photons *= 2) {
        struct cml_result result = flown(photons);
        assert_true(cml_target_met(&result, 0.5, 0) == (photons >= 10000));
        cml_result_free(&result);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_total_counts),
        cmocka_unit_test(a_small_total_is_left_out_when_it_surely_is_small),
        cmocka_unit_test(expected_values_count_however_small),
        cmocka_unit_test(what_is_named_counts_alone),
        cmocka_unit_test(few_photons_are_no_judges),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
