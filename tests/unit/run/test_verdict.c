/* Tests of the verdict on a run: too many lost packets, or energy books that do not balance, are an error.
 * SPDX-License-Identifier: MIT */
#include "lib/require.h"

#include "run/run.h"
#include "scene/scene.h"

#include <string.h>

static const struct cml_tally_grid grid = {.nr = 3, .nz = 4, .na = 2, .num_layers = 1};
static char output[] = "x.mco";
static const struct cml_scene scene = {.output = output};

/* Returns a result of 2e6 packets. `lost` packets were lost with all their weight; the others were
 * reflected. */
static struct cml_result flown(uint64_t lost)
{
    struct cml_result result;
    struct cml_error err;
    const uint64_t photons = 2000000;
    require_ok(cml_result_create(&grid, photons, &result, &err), &err);
    cml_u128 *balance = result.summary.balance;
    balance[CML_BALANCE_LAUNCHED] = (cml_u128)photons << 31;
    balance[CML_BALANCE_LOST] = (cml_u128)lost << 31;
    result.Rd_ra[0] = balance[CML_BALANCE_REFLECTED] = (cml_u128)(photons - lost) << 31;
    result.summary.count[CML_COUNT_PHOTONS] = photons;
    for (uint64_t i = 0; i < lost; i++) cml_lost_list_add(&result.summary.lost, i);
    result.summary.count[CML_COUNT_LOST_STUCK] = lost;
    return result;
}

static void expect(cml_status status, const char *text, const struct cml_result *result)
{
    struct cml_error err = {CML_OK, ""};
    assert_int_equal(cml_run_verdict(&scene, result, &err), status);
    assert_string_equal(err.text, text);
}

static void one_packet_in_a_million_may_be_lost(void **state)
{
    (void)state;
    for (uint64_t lost = 0; lost <= 3; lost++) {
        struct cml_result result = flown(lost);
        if (lost <= 2)
            expect(CML_OK, "", &result);
        else
            expect(CML_E_NUMERIC, "x.mco: 3 of 2000000 packets lost (at most 1 in 1e6 may be)", &result);
        cml_result_free(&result);
    }
}

static void one_unit_of_weight_too_many_is_no_result(void **state)
{
    (void)state;
    struct cml_result result = flown(0);
    result.summary.balance[CML_BALANCE_LAUNCHED]++;
    expect(CML_E_NUMERIC, "x.mco: the energy books do not balance: residue 1 of 2^-31 packets", &result);
    cml_result_free(&result);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_packet_in_a_million_may_be_lost),
        cmocka_unit_test(one_unit_of_weight_too_many_is_no_result),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
