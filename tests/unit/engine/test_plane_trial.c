/* Tests of the trial that decides which curved boundaries a run may replace by planes: scenes with a clear
 * answer, and options that must not change the answer. SPDX-License-Identifier: MIT */
#include "lib/bench.h"
#include "lib/mci_case.h"
#include "lib/sanitized.h"

#include "engine/cpu/engine_cpu.h"
#include "engine/plane_trial.h"

#include <string.h>

#define TOLERANCE 0.05

static const struct cml_surface_options asked = {.force = CML_SURFACE_AUTO,
                                                 .tessellation = {1e-2, CML_NORMALS_ANALYTIC, false},
                                                 .tolerance = TOLERANCE,
                                                 .may_flatten = true};

/* Reads a scene and runs the trial on its surfaces. Returns the bench with the surfaces chosen. */
static struct bench choose_with(void **state, const char *text, const struct cml_surface_options *options,
                                const struct cml_engine_options *engine_options)
{
    struct bench bench = {.options = *engine_options};
    struct cml_error err;
    case_read_ok(state, text, &bench.list);
    require_ok(cml_surfaces_create(bench.list.scenes, options, &bench.surfaces, &err), &err);
    require_ok(cml_make_harmless_planes(bench.list.scenes, options, cml_engine_cpu(), &bench.options,
                                        &bench.surfaces, &err),
               &err);
    return bench;
}

static struct bench choose(void **state, const char *text, const struct cml_surface_options *options)
{
    const struct cml_engine_options engine_options = {
        .seed = 1, .threads = 1, .reentry = true, .absorption = true};
    return choose_with(state, text, options, &engine_options);
}

/* Returns a scene: one layer below a radial tip of this height over 0.1 cm, which ends 0.1 cm above the
 * nominal plane. Boundary 1 is a plane. */
static const char *hill(const char *height, const char *more)
{
    static char text[512];
    snprintf(text, sizeof text,
             "1.0\n1\nx.mco A\n10\n%s\n0.02 0.02\n20 20 3\n1\n1\nb 2 %s 0.1 0.1 0.1\n1.4 1 10 0.5 1\n1\n",
             more, height);
    return text;
}

static void a_tiny_hill_becomes_the_plane_in_which_it_ends(void **state)
{
    struct cml_surface_options loose = asked;
    loose.tolerance = SANITIZED ? 4 * TOLERANCE : TOLERANCE; /* takes a sixteenth of the packets */
    struct bench bench = choose(state, hill("0.10001", ""), &loose);
    const struct cml_surface_def *top = &bench.surfaces.item[0];
    assert_int_equal(top->kind, CML_SURFACE_PLANE);
    assert_true(top->depth == -0.1);
    assert_true(top->expectation.bias > 0 && top->expectation.bias <= loose.tolerance);
    assert_non_null(strstr(top->reason, "radial heightfield, as a plane "));
    assert_non_null(strstr(top->reason, SANITIZED ? " is off by at most 0." : " is off by at most 0.0"));
    tear_down(&bench);
}

static void a_hill_that_matters_stays(void **state)
{
    struct bench bench = choose(state, hill("0.15", ""), &asked);
    const struct cml_surface_def *top = &bench.surfaces.item[0];
    assert_int_equal(top->kind, CML_SURFACE_CONE);
    assert_true(top->expectation.bias == 0);
    assert_non_null(strstr(top->reason, " is off by more than 0.05"));
    tear_down(&bench);
}

/* The bias of a very low hill is too small for 1e6 packets to show, so the boundary stays curved. */
static void what_cannot_be_shown_stays(void **state)
{
    if (SANITIZED) skip();
    struct cml_surface_options strict = asked;
    strict.tolerance = 1e-7;
    struct bench bench = choose(state, hill("0.1000000001", ""), &strict);
    assert_int_equal(bench.surfaces.item[0].kind, CML_SURFACE_CONE);
    assert_non_null(strstr(bench.surfaces.item[0].reason, " may be off by "));
    tear_down(&bench);
}

/* A boundary below a huge grid stays curved: adding up the tallies alone would take longer than the trial
 * may. */
static void below_a_huge_grid_it_stays(void **state)
{
    struct bench bench = choose(state,
                                "1.0\n1\nx.mco A\n10\n0.001 0.001\n3000 3000 1\n1\n1\nb 2 1e-6 0.1 0 0.1\n"
                                "1.4 1 10 0.5 1\n1\n",
                                &asked);
    assert_int_equal(bench.surfaces.item[0].kind, CML_SURFACE_CONE);
    assert_non_null(strstr(bench.surfaces.item[0].reason, ", too large a grid for trial packets"));
    tear_down(&bench);
}

static void nothing_is_a_plane_unasked_or_with_facets(void **state)
{
    struct cml_surface_options unasked = asked, forced = asked;
    unasked.may_flatten = false;
    forced.force = CML_SURFACE_CONE;
    struct bench all[] = {choose(state, hill("0.10001", ""), &unasked),
                          choose(state, hill("0.10001", ""), &forced),
                          choose(state, hill("0.10001", "facets"), &asked)};
    for (int i = 0; i < 3; i++) {
        assert_int_equal(all[i].surfaces.item[0].kind, CML_SURFACE_CONE);
        assert_null(strstr(all[i].surfaces.item[0].reason, "plane"));
        tear_down(&all[i]);
    }
}

/* The outcome depends on the scene and the tolerance only. Threads, seed and other options of a run, and
 * maps (which the trial does not compare), must not change it. */
static void the_outcome_depends_on_the_scene_only(void **state)
{
    static const struct cml_engine_options others[] = {
        {.seed = 7, .threads = 3, .reentry = true},
        {.seed = 1, .run = 5, .threads = 1, .chunk = 7, .reentry = true}};
    const char *const height = SANITIZED ? "0.15" : "0.1002"; /* a trial at this height takes long */
    struct bench first = choose(state, hill(height, ""), &asked);
    for (int i = SANITIZED; i < 2; i++) {
        const char *map = i ? "map 3 3 1 1" : "";
        struct bench other = choose_with(state, hill(height, map), &asked, &others[i]);
        assert_string_equal(other.surfaces.item[0].reason, first.surfaces.item[0].reason);
        assert_true(other.surfaces.item[0].expectation.bias == first.surfaces.item[0].expectation.bias);
        tear_down(&other);
    }
    tear_down(&first);
}

/* At normal incidence, MCML counts light that bounces inside a clear first layer between planes as
 * specular; between other boundaries it is reflected (P1). The faces of such a layer stay curved. */
static void faces_of_a_clear_first_layer_stay_at_normal_incidence(void **state)
{
    static const char *const text = "1.0\n1\nx.mco A\n10\nbeam pencil angle=%d\n0.02 0.02\n20 20 3\n2\n1\n"
                                    "b 2 1e-6 0.1 0 0.1\n1.5 0 0 0 1\n1.4 1 10 0.5 1\n1\n";
    char scene[256];
    for (int angle = 0; angle <= (SANITIZED ? 0 : 20); angle += 20) {
        snprintf(scene, sizeof scene, text, angle);
        struct bench bench = choose(state, scene, &asked);
        assert_int_equal(bench.surfaces.item[0].kind, angle ? CML_SURFACE_PLANE : CML_SURFACE_CONE);
        tear_down(&bench);
    }
}

/* All light is absorbed within 0.02 cm below a step of that height. A plane instead of the step moves the
 * light from the first depth bin to the second and changes nothing else. */
static void one_profile_alone_keeps_a_boundary(void **state)
{
    struct bench bench = choose(state,
                                "1.0\n1\nx.mco A\n10\n0.02 0.02\n2 20 1\n2\n1\n1 1e-6 0 0 0.02\n"
                                "b 3 0.02 0.5 0.02 0.5 0 0.5\n1 1000 0 0 1\n1\n",
                                &asked);
    const struct cml_surface_def *step = &bench.surfaces.item[1];
    assert_int_equal(step->kind, CML_SURFACE_CONE);
    assert_non_null(strstr(step->reason, "as a plane A_z is off by more than 0.05"));
    tear_down(&bench);
}

/* Two layers of one medium have a step between them. A plane instead of the step changes only how much
 * each layer absorbs. */
static void what_a_layer_absorbs_keeps_a_boundary(void **state)
{
    struct bench bench = choose(state,
                                "1.0\n1\nx.mco A\n10\n0.1 1\n2 1 1\n2\n1\n1 10 0 0 0.1\n"
                                "b 3 0.02 0.5 0.02 0.5 0 0.5\n1 10 0 0 1\n1\n",
                                &asked);
    assert_int_equal(bench.surfaces.item[1].kind, CML_SURFACE_CONE);
    assert_non_null(strstr(bench.surfaces.item[1].reason, "as a plane A_l is off by more than 0.05"));
    tear_down(&bench);
}

/* A lens focuses all light into a sphere, which absorbs 8e-4 of it. A plane instead of the lens sends 4 %
 * of the light there. The layers absorb 30 %, and no other quantity shows the difference. */
static void what_a_body_absorbs_keeps_a_boundary(void **state)
{
    struct cml_surface_options strict = asked;
    char text[2048];
    int used = snprintf(text, sizeof text, "1.0\n1\nx.mco A\n10\nbeam disk 1\n100 800\n1 1 1\n2\n1\nb 41");
    for (int i = 0; i <= 40; i++)
        used +=
            snprintf(text + used, sizeof text - (size_t)used, " %.9g 0.025", 0.00225 * (1 - i * i / 1600.0));
    snprintf(text + used, sizeof text - (size_t)used,
             "\n1.59 0.3 0 0 1\n1.59 0 0 0 700\ni sphere 0 0 599 0.2 1.59 2e-3 0 0\n1.59\n");
    strict.tolerance = 0.01;
    struct bench bench = choose(state, text, &strict);
    const struct cml_surface_def *lens = &bench.surfaces.item[0];
    if (lens->kind != CML_SURFACE_CONE || !strstr(lens->reason, "as a plane A_body is off by more than 0.01"))
        fail_msg("%s", lens->reason);
    tear_down(&bench);
}

/* Light goes straight through two absorbing layers. Either hill takes away 3.4 % of the light that leaves
 * below, which is within the tolerance, and changes the absorption of a layer by less. Both hills together
 * take away 6.8 %, which is not. */
static void planes_keep_the_tolerance_together(void **state)
{
    static const char *const text = "1.0\n1\nx.mco A\n10\n1 0.02\n1 20 1\n2\n1\n%s\n1 2 0 0 0.5\n%s\n"
                                    "1 22 0 0 0.05\n1\n";
    static const char *const level = "b 1 0 1", *const first = "b 3 0.0175 0.5 0.0175 0.5 0 0.5",
                             *const second = "b 3 0.00175 0.5 0.00175 0.5 0 0.5";
    const char *const lines[][2] = {{first, level}, {level, second}, {first, second}};
    static const enum cml_surface_kind kinds[][2] = {{CML_SURFACE_PLANE, CML_SURFACE_PLANE},
                                                     {CML_SURFACE_PLANE, CML_SURFACE_PLANE},
                                                     {CML_SURFACE_PLANE, CML_SURFACE_CONE}};
    char scene[256];
    for (int i = SANITIZED ? 2 : 0; i < 3; i++) {
        snprintf(scene, sizeof scene, text, lines[i][0], lines[i][1]);
        struct bench bench = choose(state, scene, &asked);
        for (int b = 0; b < 2; b++) {
            const struct cml_surface_def *def = &bench.surfaces.item[b];
            if (def->kind != kinds[i][b]) fail_msg("scene %d, boundary %d: %s", i, b, def->reason);
        }
        tear_down(&bench);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tiny_hill_becomes_the_plane_in_which_it_ends),
        cmocka_unit_test(a_hill_that_matters_stays),
        cmocka_unit_test(what_cannot_be_shown_stays),
        cmocka_unit_test(below_a_huge_grid_it_stays),
        cmocka_unit_test(nothing_is_a_plane_unasked_or_with_facets),
        cmocka_unit_test(the_outcome_depends_on_the_scene_only),
        cmocka_unit_test(faces_of_a_clear_first_layer_stay_at_normal_incidence),
        cmocka_unit_test(one_profile_alone_keeps_a_boundary),
        cmocka_unit_test(what_a_layer_absorbs_keeps_a_boundary),
        cmocka_unit_test(what_a_body_absorbs_keeps_a_boundary),
        cmocka_unit_test(planes_keep_the_tolerance_together),
    };
    return cmocka_run_group_tests(tests, case_setup, case_teardown);
}
