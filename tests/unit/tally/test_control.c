/* Totals with a control variate, on results made up here. SPDX-License-Identifier: MIT */
#include "lib/dice.h"
#include "lib/require.h"

#include "tally/control.h"

#include <math.h>

enum { OF_BATCH = 100, PHOTONS = OF_BATCH * CML_NUM_BATCHES, TRIALS = 4000 };

static const struct cml_tally_grid grid = {.nr = 1, .nz = 1, .na = 1, .num_layers = 1};
static const enum cml_total total = CML_TOTAL_TRANSMITTED;

static struct cml_result empty(uint64_t photons)
{
    struct cml_result result;
    struct cml_error err;
    require_ok(cml_result_create(&grid, photons, &result, &err), &err);
    result.summary.balance[CML_BALANCE_LAUNCHED] = (cml_u128)photons << 31;
    return result;
}

/* share: of the packets of batch b. */
static void set_batch(struct cml_result *result, int b, double share)
{
    const cml_u128 units = (cml_u128)(share * OF_BATCH / CML_WEIGHT_UNIT);
    result->totals[b * CML_NUM_TOTALS + (int)total] = units;
    result->summary.balance[CML_BALANCE_TRANSMITTED] += units;
}

/* The twin: 0.3 +- 0.1 by turns. The run: 0.5 +- 0.05 with it, and +- 0.01 by other turns. So beta is 0.5,
 * what is left has the variance 1e-4 in every batch, and the twin is 0.02, a fifth of its deviation, off. */
static void by_hand(void **state)
{
    (void)state;
    struct cml_result run = empty(PHOTONS), twin = empty(PHOTONS);
    for (int b = 0; b < CML_NUM_BATCHES; b++) {
        const int sign = b % 2 ? 1 : -1, other = b / 2 % 2 ? 1 : -1;
        set_batch(&twin, b, 0.3 + sign * 0.1);
        set_batch(&run, b, 0.5 + sign * 0.05 + other * 0.01);
    }
    const struct cml_known known = {0.28, 0}, vague = {0.28, 1e-3};
    const struct cml_controlled found = cml_control_total(&run, &twin, total, &known);
    const double expected = sqrt(1e-4 / 62 * (1 + 0.2 * 0.2) + 1.0 / PHOTONS / PHOTONS);
    assert_true(fabs(found.beta - 0.5) < 1e-6);
    assert_true(fabs(found.value - 0.49) < 1e-7);
    assert_true(fabs(found.error / expected - 1) < 1e-5);
    const double more = cml_control_total(&run, &twin, total, &vague).error;
    assert_true(fabs(more - found.error - 0.5e-3) < 1e-9);
    cml_result_free(&run);
    cml_result_free(&twin);
}

static void without_a_slope_it_is_the_plain_total(void **state)
{
    (void)state;
    const uint64_t photons[] = {PHOTONS, 7};
    const struct cml_known known = {0.1, 0};
    for (int i = 0; i < 2; i++) {
        struct cml_result run = empty(photons[i]), twin = empty(photons[i]);
        for (int b = 0; b < CML_NUM_BATCHES; b++) {
            set_batch(&run, b, b % 3 * 0.01);
            set_batch(&twin, b, i == 0 ? 0.25 : b % 2 * 0.01);
        }
        const struct cml_controlled found = cml_control_total(&run, &twin, total, &known);
        assert_true(found.beta == 0 && found.value == cml_result_total(&run, total));
        assert_true(found.error > 0 && found.error == cml_result_error(&run, total));
        cml_result_free(&run);
        cml_result_free(&twin);
    }
}

/* Two normal deviates. [Box, Muller 1958] */
static void roll_normal(struct dice *dice, double pair[2])
{
    const double radius = sqrt(-2 * log(dice_uniform(dice))), turn = 6.283185307179586 * dice_uniform(dice);
    pair[0] = radius * cos(turn);
    pair[1] = radius * sin(turn);
}

/* Batches with a correlation of 0.9: run 0.5, twin 0.3, both +- 0.02. The variance falls by 1 - 0.81, less
 * the loss of a slope from 64 points, (64 - 2) / (64 - 3) [Lavenberg, Welch 1981]. */
static void gain_and_coverage_are_those_of_theory(void **state)
{
    (void)state;
    struct dice dice = dice_new(64);
    const struct cml_known known = {0.3, 0};
    const double expected = 0.02 / 8 * sqrt((1 - 0.81) * 62 / 61.0);
    double sum = 0, squares = 0, errors = 0, within[2] = {0, 0};
    for (int trial = 0; trial < TRIALS; trial++) {
        struct cml_result run = empty(PHOTONS), twin = empty(PHOTONS);
        for (int b = 0; b < CML_NUM_BATCHES; b++) {
            double pair[2];
            roll_normal(&dice, pair);
            set_batch(&twin, b, 0.3 + 0.02 * pair[0]);
            set_batch(&run, b, 0.5 + 0.02 * (0.9 * pair[0] + sqrt(0.19) * pair[1]));
        }
        const struct cml_controlled found = cml_control_total(&run, &twin, total, &known);
        const double off = found.value - 0.5;
        sum += off;
        squares += off * off;
        errors += found.error / TRIALS;
        for (int k = 0; k < 2; k++) within[k] += fabs(off) <= (k + 1) * found.error ? 1.0 / TRIALS : 0;
        cml_result_free(&run);
        cml_result_free(&twin);
    }
    const double spread = sqrt(squares / TRIALS);
    print_message("mean %.2f errors, spread %.4f and errors %.4f of theory, %.3f and %.3f within 1 and 2\n",
                  sum / sqrt(squares), spread / expected, errors / expected, within[0], within[1]);
    assert_true(fabs(sum) < 4 * sqrt(squares));
    assert_true(fabs(spread / expected - 1) < 4 / sqrt(2.0 * TRIALS));
    assert_true(fabs(errors / expected - 1) < 0.01);
    assert_true(fabs(within[0] - 0.679) < 0.03 && fabs(within[1] - 0.95) < 0.014); /* Student, 62 */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(by_hand),
        cmocka_unit_test(without_a_slope_it_is_the_plain_total),
        cmocka_unit_test(gain_and_coverage_are_those_of_theory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
