/* Comparisons of results made up here, whose deviates are known on paper. The rate of false alarms and the
 * power with real runs are stat.compare's. SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "result/scaling.h"
#include "plot/compare.h"
#include "base/significance.h"

enum { NZ = 4, NR = 6, NA = 3 };
static const char *const names[2] = {"a.mco", "b.mco"};
static const double N = 1e6;

/* Uniform profiles; errors of 1 % where they are asked for. */
static void make(struct cml_outcome *mco, double photons, bool errors)
{
    struct cml_error err;
    *mco = (struct cml_outcome){
        .photons = (uint64_t)photons, .dz = 0.1, .dr = 0.1, .nz = NZ, .nr = NR, .na = NA, .num_layers = 1};
    assert_int_equal(cml_outcome_allocate(mco, &err), CML_OK);
    mco->value[CML_QUANTITY_Rsp][0] = 0.02;
    mco->value[CML_QUANTITY_Rd][0] = 0.3;
    mco->value[CML_QUANTITY_A][0] = 0.4;
    mco->value[CML_QUANTITY_Tt][0] = 0.1;
    for (int i = 0; i < NZ; i++) mco->value[CML_QUANTITY_A_z][i] = 1;
    for (int i = 0; i < NR; i++) mco->value[CML_QUANTITY_Rd_r][i] = mco->value[CML_QUANTITY_Tt_r][i] = 0.1;
    for (int i = 0; i < NA; i++) mco->value[CML_QUANTITY_Rd_a][i] = mco->value[CML_QUANTITY_Tt_a][i] = 0.05;
    if (!errors) return;
    const double totals[CML_TOTALS] = {0, 0.003, 0.004, 0.001};
    for (int q = 0; q <= CML_QUANTITY_Tt_a; q++) {
        const enum cml_quantity quantity = (enum cml_quantity)q;
        if (!cml_compare_tests(quantity)) continue;
        assert_int_equal(cml_outcome_add(mco, quantity, true, &err), CML_OK);
        for (size_t i = 0; i < cml_outcome_size(mco, quantity); i++)
            mco->error[q][i] = cml_quantity_is_total(quantity)    ? totals[q]
                               : quantity == CML_QUANTITY_A_z     ? 0.01
                               : cml_quantity_is_radial(quantity) ? 0.001
                                                                  : 5e-4;
    }
}

struct pair {
    struct cml_outcome mco[2];
    struct cml_comparison c;
};

static void make_pair(struct pair *pair, bool errors_a, bool errors_b)
{
    make(&pair->mco[0], N, errors_a);
    make(&pair->mco[1], N, errors_b);
}

static void compare(struct pair *pair)
{
    struct cml_error err = {0};
    assert_int_equal(cml_compare(&pair->mco[0], &pair->mco[1], names, &pair->c, &err), CML_OK);
}

static void clear(struct pair *pair)
{
    cml_outcome_clear(&pair->mco[0]);
    cml_outcome_clear(&pair->mco[1]);
    cml_comparison_clear(&pair->c);
}

/* The test that holds bin i of a quantity; NULL when there is none. */
static const struct cml_compare_test *find(const struct pair *pair, enum cml_quantity q, int i)
{
    for (int t = 0; t < pair->c.count; t++)
        if (pair->c.test[t].quantity == q && pair->c.test[t].first <= i && pair->c.test[t].last >= i)
            return &pair->c.test[t];
    return NULL;
}

static void assert_near(double value, double expected, double relative)
{
    if (!(fabs(value - expected) <= relative * fabs(expected))) fail_msg("%.10g, not %.10g", value, expected);
}

static void a_result_agrees_with_itself(void **state)
{
    (void)state;
    for (int errors = 0; errors < 4; errors++) {
        struct pair pair;
        make_pair(&pair, errors & 1, errors & 2);
        compare(&pair);
        assert_true(pair.c.p == 1);
        assert_true(pair.c.measured[0] == (errors & 1) && pair.c.measured[1] == !!(errors & 2));
        assert_int_equal(pair.c.count, 4 + NZ + 2 * NR + 2 * NA);
        clear(&pair);
    }
}

static void deviates_are_differences_over_errors(void **state)
{
    (void)state;
    struct pair pair;
    make_pair(&pair, true, true);
    pair.mco[1].value[CML_QUANTITY_Rd][0] = 0.312; /* 4 errors of one, 2.83 of the difference */
    pair.mco[1].value[CML_QUANTITY_Rd_r][2] = 0.096;
    compare(&pair);
    const struct cml_compare_test *total = find(&pair, CML_QUANTITY_Rd, 0);
    assert_near(total->z, cml_normal_of_student(-0.012 / (0.003 * sqrt(2)), 126), 1e-6);
    assert_near(total->p, erfc(-total->z / sqrt(2)), 1e-12);
    const struct cml_compare_test *bin = find(&pair, CML_QUANTITY_Rd_r, 2);
    assert_near(bin->z, cml_normal_of_student(0.004 / (0.001 * sqrt(2)), 126), 1e-5);
    assert_near(bin->lower, 0.2, 1e-12);
    assert_near(bin->upper, 0.3, 1e-12);
    assert_near(bin->value[0], 0.1, 1e-12);
    assert_near(bin->value[1], 0.096, 1e-12);
    assert_near(bin->error[1], 0.001, 1e-9);
    assert_ptr_equal(&pair.c.test[pair.c.worst], total);
    assert_near(pair.c.p, cml_sidak(total->p, pair.c.count), 1e-12);
    clear(&pair);
}

/* A hundred times the packets have a tenth of the error; the smaller run's error rules. */
static void runs_may_differ_in_size(void **state)
{
    (void)state;
    struct pair pair;
    make(&pair.mco[0], N, true);
    make(&pair.mco[1], 100 * N, false);
    pair.mco[1].value[CML_QUANTITY_Rd][0] = 0.303;
    compare(&pair);
    const struct cml_compare_test *total = find(&pair, CML_QUANTITY_Rd, 0);
    assert_near(total->error[0] / total->error[1], 10, 0.05);
    /* borrowed: mean square from a, mean of both; larger than a's own error by less than the mean's ratio */
    assert_near(total->z, cml_normal_of_student(-0.003 / (0.003 * sqrt(1.01)), 63), 0.01);
    clear(&pair);
}

/* A small run with a large error of its own is believed: a common variance would hide it. */
static void the_larger_error_counts(void **state)
{
    (void)state;
    struct pair pair;
    make_pair(&pair, true, true);
    pair.mco[1].photons = 10000;
    pair.mco[1].error[CML_QUANTITY_Rd][0] = 0.3;
    pair.mco[1].value[CML_QUANTITY_Rd][0] = 0.6;
    compare(&pair);
    assert_near(find(&pair, CML_QUANTITY_Rd, 0)->z, cml_normal_of_student(-1, 63), 1e-3);
    clear(&pair);
    make_pair(&pair, true, true);
    pair.mco[1].photons = 10000;
    pair.mco[1].value[CML_QUANTITY_Rd][0] =
        0.33; /* its error says 0.003; the variance of the larger run says 0.03 */
    compare(&pair);
    assert_near(find(&pair, CML_QUANTITY_Rd, 0)->z, cml_normal_of_student(-1, 63), 0.01);
    clear(&pair);
}

/* Without any errors the bound for scores up to 1 holds: variance mean (1 - mean) per packet. */
static void without_errors_the_bound_counts(void **state)
{
    (void)state;
    struct pair pair;
    make_pair(&pair, false, false);
    pair.mco[1].value[CML_QUANTITY_Rd][0] = 0.301;
    compare(&pair);
    const double mean = 0.3005, larger = 0.301;
    const double variance = (mean - mean * mean + larger - mean * mean) / N;
    assert_near(find(&pair, CML_QUANTITY_Rd, 0)->z, -0.001 / sqrt(variance), 1e-4);
    clear(&pair);
}

/* Errors of a file whose packets were spread evenly say nothing of how those of the other scatter. */
static void an_even_spread_lends_nothing(void **state)
{
    (void)state;
    struct pair pair;
    make_pair(&pair, true, false);
    pair.mco[0].error[CML_QUANTITY_Rd][0] = 1e-4;
    pair.mco[0].provenance.value[CML_DECIDES_sampling] = 1;
    pair.mco[1].value[CML_QUANTITY_Rd][0] = 0.301;
    compare(&pair);
    assert_false(pair.c.lends[0]);
    const double mean = 0.3005, bound = (0.301 - mean * mean) / N;
    assert_near(find(&pair, CML_QUANTITY_Rd, 0)->z, cml_normal_of_student(-0.001 / sqrt(1e-8 + bound), 63),
                1e-3);
    clear(&pair);
}

/* Rsp of a file without errors is exact: a difference beyond its digits is one, a difference within is none.
 */
static void specular_reflection_is_exact(void **state)
{
    (void)state;
    for (int errors = 0; errors < 2; errors++) {
        struct pair pair;
        make_pair(&pair, errors, false);
        pair.mco[1].value[CML_QUANTITY_Rsp][0] = 0.0200001;
        compare(&pair);
        assert_true(fabs(find(&pair, CML_QUANTITY_Rsp, 0)->z) < 3);
        cml_comparison_clear(&pair.c);
        pair.mco[1].value[CML_QUANTITY_Rsp][0] = 0.020002;
        compare(&pair);
        assert_true(find(&pair, CML_QUANTITY_Rsp, 0)->z < -40);
        clear(&pair);
    }
}

/* What one run has none of and the other plenty is a difference, whoever has the errors. */
static void light_that_is_missing_is_found(void **state)
{
    (void)state;
    for (int errors = 0; errors < 4; errors++) {
        struct pair pair;
        make_pair(&pair, errors & 1, errors & 2);
        pair.mco[0].value[CML_QUANTITY_Tt][0] = 0;
        for (int i = 0; i < NR; i++) pair.mco[0].value[CML_QUANTITY_Tt_r][i] = 0;
        compare(&pair);
        assert_true(find(&pair, CML_QUANTITY_Tt, 0)->z < -10);
        assert_true(find(&pair, CML_QUANTITY_Tt_r, 3)->z < -10);
        assert_true(pair.c.p < 1e-50);
        clear(&pair);
    }
}

/* Bins too poor for a test join their neighbours; what is left at the end joins the last test. */
static void poor_bins_are_taken_together(void **state)
{
    (void)state;
    struct pair pair;
    make_pair(&pair, false, false);
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < NR; i++) /* 8 packets of weight 1 in every ring but the last, which has 1 */
            pair.mco[k].value[CML_QUANTITY_Rd_r][i] = (i == NR - 1 ? 1.0 : 8.0) / N / cml_ring_area(0.1, i);
    compare(&pair);
    assert_ptr_equal(find(&pair, CML_QUANTITY_Rd_r, 0), find(&pair, CML_QUANTITY_Rd_r, 2));
    const struct cml_compare_test *first = find(&pair, CML_QUANTITY_Rd_r, 0);
    assert_int_equal(first->first, 0);
    assert_int_equal(first->last, NR - 1); /* 17 packets are left: too few for a second test */
    assert_int_equal(pair.c.bins[CML_QUANTITY_Rd_r], NR);
    cml_comparison_clear(&pair.c);
    for (int k = 0; k < 2; k++) pair.mco[k].value[CML_QUANTITY_Rd_r][NR - 1] *= 4;
    compare(&pair);
    assert_int_equal(find(&pair, CML_QUANTITY_Rd_r, 0)->last, 2);
    assert_int_equal(find(&pair, CML_QUANTITY_Rd_r, 3)->last, NR - 1);
    cml_comparison_clear(&pair.c);
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < NR; i++) pair.mco[k].value[CML_QUANTITY_Rd_r][i] *= 0.1;
    compare(&pair);
    assert_null(find(&pair, CML_QUANTITY_Rd_r, 0));
    assert_int_equal(pair.c.bins[CML_QUANTITY_Rd_r], 0);
    clear(&pair);
}

static void untallied_absorption_is_left_out(void **state)
{
    (void)state;
    struct pair pair;
    make_pair(&pair, true, true);
    for (int i = 0; i < NZ; i++) pair.mco[1].value[CML_QUANTITY_A_z][i] = 0;
    compare(&pair);
    assert_int_equal(pair.c.no_absorption, 1 << 1); /* of run b */
    assert_null(find(&pair, CML_QUANTITY_A_z, 0));
    assert_true(pair.c.p == 1);
    cml_comparison_clear(&pair.c);
    pair.mco[1].value[CML_QUANTITY_A][0] = 0; /* nothing was absorbed: that is no excuse */
    compare(&pair);
    assert_false(pair.c.no_absorption);
    assert_true(pair.c.p < 1e-10);
    clear(&pair);
}

static void other_grids_are_refused(void **state)
{
    (void)state;
    static const char *const messages[] = {
        "b.mco: dz = 0.2 (expected 0.1, as in a.mco)", "b.mco: dr = 0.2 (expected 0.1, as in a.mco)",
        "b.mco: nz = 3 (expected 4, as in a.mco)", "b.mco: nr = 5 (expected 6, as in a.mco)",
        "b.mco: na = 2 (expected 3, as in a.mco)"};
    for (int field = 0; field < 5; field++) {
        struct pair pair;
        struct cml_error err = {0};
        make_pair(&pair, true, false);
        struct cml_outcome *b = &pair.mco[1];
        if (field < 2) *(field == 0 ? &b->dz : &b->dr) = 0.2;
        if (field >= 2) --*(field == 2 ? &b->nz : field == 3 ? &b->nr : &b->na);
        assert_int_equal(cml_compare(&pair.mco[0], b, names, &pair.c, &err), CML_E_INPUT);
        assert_string_equal(err.text, messages[field]);
        clear(&pair);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_result_agrees_with_itself),
        cmocka_unit_test(deviates_are_differences_over_errors),
        cmocka_unit_test(runs_may_differ_in_size),
        cmocka_unit_test(the_larger_error_counts),
        cmocka_unit_test(without_errors_the_bound_counts),
        cmocka_unit_test(an_even_spread_lends_nothing),
        cmocka_unit_test(specular_reflection_is_exact),
        cmocka_unit_test(light_that_is_missing_is_found),
        cmocka_unit_test(poor_bins_are_taken_together),
        cmocka_unit_test(untallied_absorption_is_left_out),
        cmocka_unit_test(other_grids_are_refused),
    };
    return cmocka_run_group_tests_name("compare", tests, NULL, NULL);
}
