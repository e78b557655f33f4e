/* Tests of a flight that takes longer than its time limit. SPDX-License-Identifier: MIT */
#include "lib/mci_case.h"
#include "lib/require.h"

#include "engine/engines.h"
#include "run/run.h"

/* A scene with light inside a layer without absorption, 1e5 mean free paths from either side: a packet
 * takes 1e10 steps. */
static const char *const deep =
    "1.0\n1\nx.mco A\nbeam pencil z=1e3\n1000\n.01 .01\n10 10 1\n1\n1.0\n1.0 0 100 0 2e3\n1.0\n";
static const char *const thin = "1.0\n1\nx.mco A\n1000\n.01 .01\n10 10 1\n1\n1.0\n1.0 1 10 0 .1\n1.0\n";

static cml_status fly(void **state, const char *text, const char *engine, struct cml_error *err)
{
    struct cml_scene_list list;
    struct cml_surface_set surfaces;
    struct cml_run_result out;
    case_read_ok(state, text, &list);
    require_ok(cml_surfaces_create(&list.scenes[0], &(struct cml_surface_options){0}, &surfaces, err), err);
    const struct cml_run_setup setup = {.scene = &list.scenes[0],
                                        .surfaces = &surfaces,
                                        .engine = cml_engine_find(engine),
                                        .options = {.seed = 1},
                                        .photons = 1000,
                                        .most_seconds = text == deep ? .05 : 1e6};
    const cml_status status = cml_run(&setup, &out, err);
    if (status == CML_OK) assert_int_equal(out.result.summary.count[CML_COUNT_PHOTONS], 1000);
    cml_run_result_free(&out);
    cml_surfaces_free(&surfaces);
    cml_scene_list_clear(&list);
    return status;
}

static void packets_that_hardly_end_are_given_up(void **state)
{
    const char *const engines[] = {"cpu", "reference"};
    struct cml_error err;
    for (int i = 0; i < 2; i++) {
        assert_int_equal(fly(state, deep, engines[i], &err), CML_E_STOPPED);
        assert_string_equal(err.text,
                            "x.mco: packets hardly end: 1000 were not flown in 0.05 s (plan --photons "
                            "waits for them)");
        assert_int_equal(fly(state, thin, engines[i], &err),
                         CML_OK); /* a later flight of another scene is not affected */
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(packets_that_hardly_end_are_given_up, case_setup, case_teardown)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
