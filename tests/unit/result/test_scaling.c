/* Tests of scaling tallies to densities: a density multiplied by its divisors gives the tally again.
 * SPDX-License-Identifier: MIT */
#include "unit/tally/tally_cases.h"

#include "base/constants.h"
#include "result/mco.h"
#include "result/scaling.h"

static void rings_make_up_the_disk(void **state)
{
    (void)state;
    double sum = 0;
    for (int i = 0; i < 50; i++) sum += cml_ring_area(0.02, i);
    assert_near("area", sum, CML_PI, 1e-13);
}

/* The solid angles of all bins add up to 2 pi (projected: pi), once the known error of midpoint values is
 * divided out. */
static void angles_make_up_the_hemisphere(void **state)
{
    (void)state;
    static const int counts[] = {1, 2, 30};
    for (int n = 0; n < COUNT(counts); n++) {
        const double da = cml_angle_width(counts[n]);
        double sum = 0, projected = 0;
        for (int i = 0; i < counts[n]; i++) {
            sum += cml_solid_angle(da, i);
            projected += cml_projected_solid_angle(da, i);
        }
        assert_near("solid angle", sum * sin(da / 2) / (da / 2), 2 * CML_PI, 1e-13);
        assert_near("projected", projected * cos(da / 2), CML_PI, 1e-13);
    }
}

/* 64 packets, one per batch: half of the weight is absorbed in one cell, and half leaves upwards in
 * another. Densities integrate to these totals. */
static void densities_integrate_to_totals(void **state)
{
    (void)state;
    struct cml_error err;
    struct cml_result result = make_result(&grid, 64);
    struct cml_tally tally = make_tally(&grid);
    struct cml_outcome mco = {
        .dr = 0.1, .dz = 0.5, .nr = 3, .nz = 4, .na = 2, .num_layers = 2, .photons = 64};
    assert_int_equal(cml_outcome_allocate(&mco, &err), CML_OK);
    score(&tally, 1, 1, 2, true);
    for (int b = 0; b < CML_NUM_BATCHES; b++) {
        memset(tally.last_sums, 0, cml_tally_profile_bins(&tally.grid) * sizeof *tally.last_sums);
        cml_tally_sum_batch(&tally, b);
        cml_result_add_batch(&result, b, &tally);
        cml_result_add(&result, &tally);
    }
    assert_int_equal(cml_outcome_take(&mco, &result, &err), CML_OK);
    const double da = CML_PI / 4, ring = 2 * CML_PI * 0.15 * 0.1;
    assert_true(mco.value[CML_QUANTITY_Rd][0] == 0.5 && mco.value[CML_QUANTITY_A][0] == 0.5 &&
                mco.value[CML_QUANTITY_Tt][0] == 0 && mco.value[CML_QUANTITY_Rsp][0] == 0);
    assert_near("Rd_r", mco.value[CML_QUANTITY_Rd_r][1] * ring, 0.5, 1e-15);
    assert_near("Rd_a", mco.value[CML_QUANTITY_Rd_a][1] * 2 * CML_PI * sin(1.5 * da) * da, 0.5, 1e-15);
    assert_near("Rd_ra",
                mco.value[CML_QUANTITY_Rd_ra][1 * 2 + 1] * ring * 2 * CML_PI * sin(da / 2) * sin(3 * da), 0.5,
                1e-15);
    assert_near("A_z", mco.value[CML_QUANTITY_A_z][2] * 0.5, 0.5, 1e-15);
    assert_near("A_rz", mco.value[CML_QUANTITY_A_rz][1 * 4 + 2] * ring * 0.5, 0.5, 1e-15);
    assert_near("A_l", mco.value[CML_QUANTITY_A_l][0], 0.5, 1e-15);
    assert_true(mco.value[CML_QUANTITY_Rd_r][0] == 0 && mco.value[CML_QUANTITY_Rd_ra][1 * 2] == 0 &&
                mco.value[CML_QUANTITY_A_rz][1 * 4 + 1] == 0 && mco.value[CML_QUANTITY_Tt_r][1] == 0);
    cml_outcome_clear(&mco);
    cml_tally_free(&tally);
    cml_result_free(&result);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rings_make_up_the_disk),
        cmocka_unit_test(angles_make_up_the_hemisphere),
        cmocka_unit_test(densities_integrate_to_totals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
