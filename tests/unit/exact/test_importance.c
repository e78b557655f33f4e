/* Tests of the importance of light at a depth (the share that will still reach a face), where its value is
 * known without adding-doubling. Also flies packets whose weight windows are made of right and of wrong
 * importances. SPDX-License-Identifier: MIT */
#include "lib/bench.h"
#include "lib/mci_case.h"
#include "lib/sanitized.h"

#include "engine/engines.h"
#include "exact/detector_importance.h"
#include "exact/exact.h"
#include "exact/importance.h"

#include <math.h>

enum { CELLS = 50, RINGS = 40, SEEDS = SANITIZED ? 2 : 16, PACKETS = 3000 };

static const char *const slab = "1.0\n1\ns.mco A\n1000\n0.1 0.1\n1 1 1\n1\n1.0\n1.4 0.5 50 0.8 1.2\n1.0\n";

/* Returns the share of isotropic light that passes the optical depth t unscattered, E2(t) / 2, by the
 * rectangle rule. */
static double straight_share(double t)
{
    const int n = 100000;
    double sum = 0;
    for (int i = 0; i < n; i++) sum += exp(-t * n / (i + 0.5));
    return sum / n / 2;
}

static void without_scattering_it_is_what_comes_straight_through(void **state)
{
    (void)state;
    const struct cml_medium_def media[] = {
        {.n = 1.4}, {.n = 1.4, .mua = 2, .d = 1}, {.n = 1.4, .mua = 5, .d = 0.5}, {.n = 1.4}};
    double value[CELLS];
    struct cml_error err;
    require_ok(cml_importance_of_depth(media, 2, CELLS, value, &err), &err);
    for (int i = 0; i < CELLS; i++) {
        const double z = (i + 0.5) / CELLS * 1.5, t = z < 1 ? 2 * (1 - z) + 2.5 : 5 * (1.5 - z);
        if (fabs(value[i] / straight_share(t) - 1) > 0.02)
            fail_msg("z = %g: %g, not %g", z, value[i], straight_share(t));
    }
}

/* Without absorption all light leaves above or below, so both importances add up to 1. */
static void without_absorption_it_is_shared_by_both_sides(void **state)
{
    (void)state;
    const struct cml_medium_def media[] = {{.n = 1},
                                           {.n = 1.4, .mus = 40, .g = 0.5, .d = 0.4},
                                           {.n = 1.4, .mus = 10, .d = 0.2},
                                           {.n = 1.2}},
                                reversed[] = {media[3], media[2], media[1], media[0]};
    double below[CELLS], above[CELLS];
    struct cml_error err;
    require_ok(cml_importance_of_depth(media, 2, CELLS, below, &err), &err);
    require_ok(cml_importance_of_depth(reversed, 2, CELLS, above, &err), &err);
    for (int i = 0; i < CELLS; i++)
        if (fabs(below[i] + above[CELLS - 1 - i] - 1) > 0.02)
            fail_msg("cell %d: %g and %g", i, below[i], above[CELLS - 1 - i]);
}

static const struct cml_medium_def stack[] = {{.n = 1},
                                              {.n = 1.4, .mua = 0.3, .mus = 60, .g = 0.5, .d = 0.4},
                                              {.n = 1.4, .mua = 1, .mus = 40, .d = 0.3},
                                              {.n = 1.2}};

static void worth_of_ring(bool below, double inner, double outer, double value[RINGS * CELLS])
{
    struct cml_error err;
    struct cml_seen_ring ring = {below, inner, outer};
    const struct cml_seen_rings seen = {&ring, 1};
    require_ok(cml_importance_of_place(stack, 2, seen, 2, 0.7, RINGS, CELLS, value, &err), &err);
}

/* A ring over the whole face sees the importance of depth, at every radius. The diffusion approximation
 * behind rings is good to 10 %. */
static void what_a_whole_face_sees_is_what_comes_out_of_it(void **state)
{
    (void)state;
    double place[RINGS * CELLS], depth[CELLS];
    struct cml_error err;
    worth_of_ring(true, 0, 2, place);
    require_ok(cml_importance_of_depth(stack, 2, CELLS, depth, &err), &err);
    for (int i = 0; i < CELLS; i++)
        for (int r = 0; r < RINGS; r++) {
            const double value = place[r * CELLS + i];
            if (fabs(value / place[i] - 1) > 1e-9 || fabs(value / depth[i] - 1) > 0.1)
                fail_msg("ring %d, cell %d: %g, not %g", r, i, value, depth[i]);
        }
}

/* Importances of two parts of a face add up to that of the face, and a detector sees most of the light
 * right below it. */
static void what_parts_see_adds_up(void **state)
{
    (void)state;
    double all[RINGS * CELLS], inner[RINGS * CELLS], outer[RINGS * CELLS];
    worth_of_ring(false, 0, 2, all);
    worth_of_ring(false, 0, 0.33, inner);
    worth_of_ring(false, 0.33, 2, outer);
    for (int i = 0; i < RINGS * CELLS; i++) {
        const double sum = inner[i] + outer[i];
        if (!(inner[i] > 0 && outer[i] > 0 && fabs(sum / all[i] - 1) < 0.02))
            fail_msg("cell %d: %g and %g, not %g", i, inner[i], outer[i], all[i]);
        if (i >= CELLS && inner[i] > inner[i - CELLS]) fail_msg("cell %d: more farther out", i);
    }
}

/* Returns the relative standard error of Tt over all packets of all seeds. off: difference of Rd and Tt
 * from their true values, in standard errors. */
static double fly(struct bench *bench, const char *name, const double truth[2], double *off)
{
    static const enum cml_balance_term terms[2] = {CML_BALANCE_REFLECTED, CML_BALANCE_TRANSMITTED};
    const struct cml_engine *engine = cml_engine_find(name);
    double sum[2] = {0}, squares[2] = {0}, error[2];
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        struct cml_error err;
        struct cml_tally tally = empty_tally(bench);
        bench->options.seed = seed;
        void *self = open_engine(bench, engine);
        require_ok(cml_engine_run_range(engine, self, 0, PACKETS, &tally, &err), &err);
        engine->close(self);
        for (int i = 0; i < 2; i++) {
            const double share = (double)tally.balance[terms[i]] * CML_WEIGHT_UNIT / PACKETS;
            sum[i] += share / SEEDS;
            squares[i] += share * share / SEEDS;
        }
        assert_true(tally.count[CML_COUNT_BRANCHES] > 0 && tally.count[CML_COUNT_UNSPLIT] == 0);
        assert_weight_balances(&tally, PACKETS);
        cml_tally_free(&tally);
    }
    *off = 0;
    for (int i = 0; i < 2; i++) {
        error[i] = sqrt(fmax(0, squares[i] - sum[i] * sum[i]) / (SEEDS - 1));
        *off = fmax(*off, fabs(sum[i] - truth[i]) / error[i]);
    }
    return error[1] / truth[1];
}

/* Windows from a wrong importance, p = -0.3 (deep packets weigh more, not less), raise the error and leave
 * the mean right. With sanitizers there are too few packets to judge errors. */
static void windows_that_are_wrong_cost_errors_and_no_truth(void **state)
{
    const struct cml_exact_options aim = {.tolerance = 1e-7, .most_work = 1e11};
    struct bench bench = {.options = bench_options(1)};
    struct cml_exact exact;
    struct cml_error err;
    double importance[CML_WINDOW_CELLS], off[3];
    case_read_ok(state, slab, &bench.list);
    const struct cml_scene *scene = bench.list.scenes;
    require_ok(cml_surfaces_create(scene, &(struct cml_surface_options){0}, &bench.surfaces, &err), &err);
    require_ok(cml_exact_scene(scene, NULL, &aim, &exact, &err), &err);
    require_ok(cml_importance_of_depth(scene->media, 1, CML_WINDOW_CELLS, importance, &err), &err);
    const double truth[2] = {exact.value[CML_EXACT_RD], exact.value[CML_EXACT_TT]},
                 most = importance[CML_WINDOW_CELLS - 1];
    struct cml_window_table right = {.cells = CML_WINDOW_CELLS, .rings = 1, .depth = 1.2, .reach = 1},
                            wrong = right;
    require_ok(cml_window_table_create(importance, 2 * truth[1], 0.8, &right, &err), &err);
    require_ok(cml_window_table_create(importance, most, -0.3, &wrong, &err), &err);
    bench.options.windows = &right;
    const double error = fly(&bench, "cpu", truth, &off[0]), other = fly(&bench, "reference", truth, &off[1]);
    bench.options.windows = &wrong;
    const double worse = fly(&bench, "cpu", truth, &off[2]);
    if (fmax(off[0], fmax(off[1], off[2])) > 4.5 && !SANITIZED)
        fail_msg("off by %g, %g, %g errors", off[0], off[1], off[2]);
    if (!(worse > 1.2 * error && other < 1.2 * error) && !SANITIZED)
        fail_msg("errors %g, %g; wrong %g", error, other, worse);
    cml_window_table_clear(&right);
    cml_window_table_clear(&wrong);
    cml_exact_clear(&exact);
    tear_down(&bench);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_scattering_it_is_what_comes_straight_through),
        cmocka_unit_test(without_absorption_it_is_shared_by_both_sides),
        cmocka_unit_test(what_a_whole_face_sees_is_what_comes_out_of_it),
        cmocka_unit_test(what_parts_see_adds_up),
        cmocka_unit_test_setup_teardown(windows_that_are_wrong_cost_errors_and_no_truth, case_setup,
                                        case_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
