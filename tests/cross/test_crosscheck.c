/* Tests that crosscheck finds differences: the cpu engine against itself with some packets changed.
 * SPDX-License-Identifier: MIT */
#include "flight.h"

#include "run/crosscheck/crosscheck.h"
#include "engine/cpu/engine_cpu.h"

static const char *const scene = "1.0\n1\nscene A\n1000\n0.01 0.02\n20 30 10\n1\n1\n1.4 1 20 0.5 0.2\n1\n";

static uint64_t period;     /* every packet whose index is a multiple of this is changed */
static uint32_t more_steps; /* interactions that are added to a changed packet */
static double more_absorbed;

static cml_status changed_fates(void *self, uint64_t first, uint64_t count, struct cml_fate_record *records,
                                struct cml_error *err)
{
    const cml_status status = cml_engine_cpu()->fates(self, first, count, records, err);
    for (uint64_t i = 0; i < count; i++) {
        if ((first + i) % period != 0) continue;
        records[i].interactions += more_steps;
        records[i].absorbed += more_absorbed;
    }
    return status;
}

static void count_packet(void *context, uint64_t photon, const struct cml_fate_record *records)
{
    assert_true(photon % period == 0);
    assert_true(records[0].interactions + more_steps == records[1].interactions);
    ++*(uint64_t *)context;
}

static struct cml_check_pair check(uint64_t photons, bool same_geometry, uint64_t *told)
{
    struct cml_engine changed = *cml_engine_cpu();
    struct cml_scene_list list;
    struct cml_surface_set surfaces;
    struct cml_check_result result;
    struct cml_error err;
    const struct cml_surface_options surface = {.force = CML_SURFACE_AUTO,
                                                .tessellation = {.tolerance = 1e-3}};
    changed.fates = changed_fates;
    read_scenes(scene, &list);
    require_ok(cml_surfaces_create(list.scenes, &surface, &surfaces, &err), &err);
    const struct cml_check_setup setup = {.scene = list.scenes,
                                          .options = {.seed = 3,
                                                      .lattice = true,
                                                      .roulette = {0.01, 0.03},
                                                      .reentry = true,
                                                      .absorption = true},
                                          .photons = photons,
                                          .num_sides = 2,
                                          .sides = {{"cpu", cml_engine_cpu(), &surfaces, true},
                                                    {"changed", &changed, &surfaces, same_geometry}},
                                          .on_difference = count_packet,
                                          .context = told};
    *told = 0;
    require_ok(cml_crosscheck(&setup, &result, &err), &err);
    const struct cml_check_pair pair = result.pairs[1];
    cml_check_clear(&result);
    cml_surfaces_free(&surfaces);
    cml_scene_list_clear(&list);
    return pair;
}

static void one_packet_in_ten_thousand_may_differ(void **state)
{
    (void)state;
    uint64_t told;
    more_steps = 1;
    more_absorbed = 0;
    period = 10000;
    struct cml_check_pair pair = check(20000, true, &told);
    assert_true(pair.agrees && pair.equal == 19998 && told == 2);
    period = 5000;
    pair = check(20000, true, &told);
    assert_true(!pair.agrees && pair.equal == 19996 && told == 4);
    pair = check(20000, false, &told);
    assert_true(pair.agrees);
}

static void a_biased_total_is_found(void **state)
{
    (void)state;
    uint64_t told;
    more_steps = 0;
    more_absorbed = 1e-3;
    period = 50;
    const struct cml_check_pair pair = check(20000, true, &told);
    assert_true(pair.equal == 20000 && told == 0 && !pair.agrees);
    const struct cml_check_total *A = &pair.total[CML_TOTAL_ABSORBED];
    assert_true(A->mean > 1.9e-5 && A->mean < 2.1e-5 && A->z > 10);
    assert_true(pair.total[CML_TOTAL_REFLECTED].z == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_packet_in_ten_thousand_may_differ),
        cmocka_unit_test(a_biased_total_is_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
