/* clustermcml plan: photons and time that an error takes, by engine and sampling. Flies pilots, writes no
 * file. SPDX-License-Identifier: MIT */
#include "cli/command.h"

#include "base/clock.h"
#include "base/json_name.h"
#include "base/version.h"
#include "engine/engines.h"
#include "result/quantity.h"
#include "run/cluster/cluster.h"
#include "simulation/simulation.h"
#include "tally/target_error.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Seconds of a pilot: errors need more packets than speeds. All pilots together take about one second, except
 * where kernels of OpenCL are compiled first. */
#define ERROR_PILOT 0.3
#define SPEED_PILOT 0.1
/* Factor by which each round of the speed pilot is longer than the one before. */
#define SPEED_GROWTH 8
#define MOST_SECONDS 30 /* longest round, s: packets of some scenes hardly end */
#define DEFAULT_ERROR 1e-3
#define LARGEST_ERROR 0.5 /* relative error of four packets, 1 / sqrt(4); errors of fewer say too little */
#define FIRST_ROUND 1024  /* 16 photons in a batch: fewer say little about its mean */

/* Engines whose speed is measured. Packets are the same on all, so the errors come from the fastest. */
static const char *const engine_names[] = {"cpu", "reference", "opencl"};
static const char *const sampling_names[] = {"random", "lattice"};
enum {
    ENGINES = sizeof engine_names / sizeof *engine_names,
    OPENCL = ENGINES - 1, /* the only engine that may refuse a scene or lack a device */
    SAMPLINGS = 2,
    MOST_DETECTORS = 8 /* detectors considered as aims at most; each takes 0.1 s */
};

/* Goals of pilots behind the totals (cml_goals): the expected Tt (P15), and the quantity of setup->error_of.
 */
enum { PILOT_EXPECTED = CML_NUM_GOALS, PILOT_NAMED, PILOT_GOALS };

/* One round of a pilot: its photons, and the relative standard errors of all goals; INFINITY if the round saw
 * nothing. */
struct pilot_round {
    uint64_t photons;
    double error[PILOT_GOALS];
};

#define PILOT_MOST_ROUNDS 48

/* Pilots: short runs that show how errors fall and how fast the engine is. Zeroed: none was flown. */
struct pilot {
    int num_rounds;
    struct pilot_round round[PILOT_MOST_ROUNDS]; /* [num_rounds], each longer than the one before */
    double photons_per_s;                        /* speed of the last round, all ranks together */
    int threads;                                 /* threads of a rank */
    /* goals too small for --target-error to wait for */
    bool faint[CML_NUM_GOALS];
};

struct plan {
    const struct cml_scene *scene;
    double error;
    const char *aimed, *error_of; /* values of --aim and --error-of; NULL: not given */
    /* aim of --aim, or of --aim Tt as a proposal; without scores if the scene has none */
    const struct cml_aim *aim;
    /* Windows of --aim DETECTOR as proposals, without their targets; cells 0: none. */
    struct cml_window_table of_detector[MOST_DETECTORS];
    struct pilot errors[SAMPLINGS];    /* pilots for errors: [0] random, [1] lattice sampling */
    double photons_per_s[ENGINES];     /* speed of each engine; 0: it cannot fly the scene */
    struct cml_error refusal[ENGINES]; /* reason why an engine cannot fly the scene */
    /* reason why the first of the detectors without windows has none */
    struct cml_error unaimed;
    double seconds; /* time that the pilots took */
};

/* ---- pilots ---- */

/* Returns the relative error of the expected Tt; INFINITY if there is none. */
static double expected_error(const struct cml_result *result)
{
    double value = 0, error = 0;
    if (result->grid.scores > 0) cml_result_expected(result, 0, &value, &error);
    return value > 0 && error > 0 ? error / value : INFINITY;
}

/* Returns the relative error of a total; 0 if all batches have the same sum, because all light is certain to
 * go there. */
static double error_of(const struct cml_result *result, enum cml_total total)
{
    const bool certain = cml_result_total(result, total) > 0 && cml_result_error(result, total) == 0;
    return certain ? 0 : cml_result_relative_error(result, total);
}

/* Flies one round of a pilot and adds its errors and its speed to the pilot. A total that lies below
 * CML_TARGET_LEAST_SHARE by three standard errors is marked as faint; its error is then no goal. */
static cml_status fly_round(const struct cml_run_setup *setup, struct pilot *pilot, struct cml_error *err)
{
    struct cml_run_result run;
    struct pilot_round *round = &pilot->round[pilot->num_rounds];
    CML_TRY(cml_run(setup, &run, err));
    round->photons = setup->photons;
    for (int i = 0; i < CML_NUM_GOALS && cml_cluster_rank() == 0; i++) {
        round->error[i] = error_of(&run.result, cml_goals[i]);
        pilot->faint[i] =
            cml_result_total(&run.result, cml_goals[i]) +
                3 * fmax(cml_result_error(&run.result, cml_goals[i]), 1 / (double)setup->photons) <
            CML_TARGET_LEAST_SHARE;
    }
    if (cml_cluster_rank() == 0) round->error[PILOT_EXPECTED] = expected_error(&run.result);
    if (setup->error_of && cml_cluster_rank() == 0)
        round->error[PILOT_NAMED] = cml_target_error_of(&run.result, setup->error_of);
    pilot->photons_per_s = (double)setup->photons / run.timing.seconds;
    pilot->threads = run.timing.threads;
    pilot->num_rounds++;
    cml_run_result_free(&run);
    return CML_OK;
}

static uint64_t shorter(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

/* Flies rounds from photon 0 on, each `growth` times as long as the one before. Ends at setup->photons
 * photons; or, if that is 0, when all rounds would take longer than about `seconds`, with the opening of the
 * engine. Flies at least two rounds, unless they take setup->most_seconds each. Collective; the pilot of rank
 * 0 counts. Fails as cml_run does. */
static cml_status fly_pilot(const struct cml_run_setup *setup, double seconds, int growth,
                            struct pilot *pilot, struct cml_error *err)
{
    struct cml_run_setup mine = *setup;
    const uint64_t most = setup->photons > 0 ? setup->photons : (uint64_t)1 << 48;
    const double begin = cml_now();
    bool more = true;
    *pilot = (struct pilot){0};
    mine.photons = shorter(FIRST_ROUND, most);
    while (more) {
        const double round_begin = cml_now();
        const cml_status status = fly_round(&mine, pilot, err);
        if (status == CML_E_STOPPED && pilot->num_rounds > 0) return CML_OK;
        CML_TRY(status);
        const double next = growth * (cml_now() - round_begin);
        more = mine.photons < most && pilot->num_rounds < PILOT_MOST_ROUNDS &&
               (setup->photons > 0 || pilot->num_rounds < 2 || cml_now() - begin + next < seconds);
        CML_TRY(cml_cluster_share(&more, sizeof more, err));
        mine.photons = shorter((uint64_t)growth * mine.photons, most);
    }
    return CML_OK;
}

/* Returns how many photons a relative standard error takes, between two rounds of the pilot: the logarithm of
 * the photons is linear in that of the error. The first round may have seen nothing. */
static double interpolate(const struct pilot_round rounds[2], int goal, double error)
{
    const double slope =
        log(rounds[0].error[goal] / error) / log(rounds[0].error[goal] / rounds[1].error[goal]);
    const double first = (double)rounds[0].photons, last = (double)rounds[1].photons;
    return isfinite(rounds[0].error[goal]) ? first * pow(last / first, slope) : last;
}

/* Returns the photons after which a goal has this relative standard error, at least one per batch.
 * Interpolates between rounds; beyond the pilot it takes errors to fall with the root of the photons, an
 * upper estimate where draws are evenly spread. INFINITY if the last round saw fewer than four packets.
 * Errors of rounds are known to 9 % (64 batches), so the photons to some 20 %; with n < 25 packets to 1 /
 * sqrt(n). */
static double photons_for(const struct pilot *pilot, int goal, double error)
{
    int reached = pilot->num_rounds; /* from this round on all rounds reach the error */
    while (reached > 0 && pilot->round[reached - 1].error[goal] <= error) reached--;
    if (reached > 0 && reached < pilot->num_rounds)
        return ceil(interpolate(&pilot->round[reached - 1], goal, error));
    if (reached > 0 && pilot->round[reached - 1].error[goal] > LARGEST_ERROR) return INFINITY;
    const struct pilot_round *nearest = &pilot->round[reached > 0 ? reached - 1 : 0];
    const double photons = (double)nearest->photons * pow(nearest->error[goal] / error, 2);
    return ceil(fmax(photons, CML_NUM_BATCHES));
}

/* Measures how many photons per second an engine flies, in a pilot run of SPEED_PILOT seconds. OpenCL may
 * have no device or refuse the scene: the plan then keeps the reason and goes on. */
static cml_status measure_speed(struct plan *plan, const struct cml_run_setup *setup, int engine,
                                struct cml_error *err)
{
    struct cml_run_setup mine = *setup;
    struct pilot pilot;
    mine.engine = cml_engine_find(engine_names[engine]);
    mine.photons = 0;
    const cml_status status = fly_pilot(&mine, SPEED_PILOT, SPEED_GROWTH, &pilot, err);
    if (status == CML_E_STOPPED || (engine == OPENCL && (status == CML_E_DEVICE || status == CML_E_INPUT))) {
        plan->refusal[engine] = *err;
        return CML_OK;
    }
    plan->photons_per_s[engine] = status == CML_OK ? pilot.photons_per_s : 0;
    return status;
}

/* Flies the pilots for errors, with both samplings, and those for speeds, with each engine. */
static cml_status fly_pilots(struct plan *plan, const struct cml_run_setup *setup, struct cml_error *err)
{
    struct cml_run_setup mine = *setup;
    const double begin = cml_now();
    mine.engine = cml_engine_find(engine_names[0]);
    if (plan->aim->tail.scores > 0) mine.options.tail = &plan->aim->tail;
    for (int lattice = 0; lattice < SAMPLINGS; lattice++) {
        mine.options.lattice = lattice == 1;
        CML_TRY(fly_pilot(&mine, ERROR_PILOT, 2, &plan->errors[lattice], err));
        plan->photons_per_s[0] = fmax(plan->photons_per_s[0], plan->errors[lattice].photons_per_s);
    }
    for (int engine = 1; engine < ENGINES; engine++) CML_TRY(measure_speed(plan, setup, engine, err));
    plan->seconds = cml_now() - begin;
    return CML_OK;
}

/* ---- output ---- */

/* Returns the photons that --target-error needs with lattice sampling: the most of all its goals. */
static double needed(const struct plan *plan)
{
    const struct pilot *pilot = &plan->errors[1];
    const bool expects = plan->aimed && plan->aim->tail.scores > 0;
    double most = 0;
    if (plan->error_of) return photons_for(pilot, PILOT_NAMED, plan->error);
    for (int goal = 0; goal < CML_NUM_GOALS; goal++)
        if (!pilot->faint[goal] && !(expects && cml_goals[goal] == CML_TOTAL_TRANSMITTED))
            most = fmax(most, photons_for(pilot, goal, plan->error));
    return expects ? fmax(most, photons_for(pilot, PILOT_EXPECTED, plan->error)) : most;
}

/* Returns the photons that --target-error flies, in whole rounds: N, N, 2N, 4N ... */
static double flown(const struct plan *plan)
{
    const double least = fmax(needed(plan), CML_TARGET_LEAST_PHOTONS);
    double photons = CML_NUM_BATCHES * ceil((double)plan->scene->photons / CML_NUM_BATCHES);
    while (photons < least && isfinite(least)) photons *= 2;
    return isfinite(least) ? photons : least;
}

/* Prints a time with two digits, because the error of an error is 9 %. A dash: the pilots saw nothing. */
static void print_time(double seconds)
{
    if (!isfinite(seconds)) {
        printf(" %7s %-3s", "-", "");
        return;
    }
    static const struct {
        double seconds;
        const char *name;
    } units[] = {{86400, "d"}, {3600, "h"}, {60, "min"}, {1, "s"}};
    size_t unit = 0;
    while (units[unit].seconds > 1 && seconds < 1.5 * units[unit].seconds) unit++;
    printf(" %7.2g %-3s", seconds / units[unit].seconds, units[unit].name);
}

/* True if an engine can reach the goal: OpenCL has no expected values. */
static bool has_goal(const struct plan *plan, int engine, int goal)
{
    if (goal == PILOT_EXPECTED) return plan->aim->tail.scores > 0 && engine != OPENCL;
    return goal != PILOT_NAMED || plan->error_of;
}

/* Returns the name of a goal of the plan: that of --error-of, a total, or the expected value of Tt. */
static const char *goal_name(const struct plan *plan, int goal)
{
    if (goal == PILOT_NAMED) return plan->error_of;
    return cml_quantities[goal < CML_NUM_GOALS ? (int)cml_goals[goal] : CML_QUANTITY_Tt_expected].name;
}

/* Prints a row of the table: photons and time for each goal, for one engine and sampling. */
static void print_row(const struct plan *plan, int engine, int lattice)
{
    const double speed = plan->photons_per_s[engine];
    printf("  %-10s %-9s %9.2g", engine_names[engine], sampling_names[lattice], speed);
    for (int goal = 0; goal < PILOT_GOALS; goal++) {
        if (!has_goal(plan, engine, goal)) continue;
        const double photons = photons_for(&plan->errors[lattice], goal, plan->error);
        if (isfinite(photons))
            printf("  %9.2g", photons);
        else
            printf("  %9s", "-");
        print_time(photons / speed);
    }
    putchar('\n');
}

/* Prints the name of a goal above its numbers, 20 letters wide. */
static void print_goal(const char *name)
{
    const int width = (int)fmax(9, (double)strlen(name));
    printf("  %*s %-*s", width, name, width < 20 ? 20 - width : 0, "");
}

/* Returns the photons of the longest round with lattice sampling. */
static double longest_pilot(const struct plan *plan)
{
    const struct pilot *pilot = &plan->errors[1];
    return (double)pilot->round[pilot->num_rounds - 1].photons;
}

/* Says how much time --aim would save for one of the scene's goals. A gain of 0 or below means none. */
static void print_gain(const struct cml_window_table *windows, const char *aim, const char *name)
{
    const double gain = windows->gain;
    if (gain > 0)
        printf("--aim %s would take some %.2g times less time for %s.\n", aim, gain, name);
    else
        printf("--aim %s would gain nothing.\n", aim);
}

/* Prints the gains of aims. They follow from the light that passes the scene with planes in place of shapes,
 * not from the rare light that pilots saw. */
static void print_windows(const struct plan *plan)
{
    if (plan->aim->windows.cells > 0) {
        printf("  Through planes in place of all shapes comes %.1g of the light: ", plan->aim->windows.worth);
        print_gain(&plan->aim->windows, "Tt_r", "Tt");
    }
    for (int k = 0; k < MOST_DETECTORS; k++) {
        if (plan->of_detector[k].cells == 0) continue;
        const char *name = plan->scene->detectors[k].name;
        printf("  Through planes %s sees some %.1g of the light: ", name,
               plan->of_detector[k].worth * plan->of_detector[k].share * plan->of_detector[k].accepted);
        print_gain(&plan->of_detector[k], name, "it");
    }
    if (plan->unaimed.text[0]) printf("  without aim: %s\n", plan->unaimed.text);
}

/* Prints the plan for people: photons and times for each engine and sampling, then what is known about
 * them. */
static void print_plan(const struct plan *plan)
{
    const int ranks = cml_cluster_size(), threads = plan->errors[1].threads;
    printf("%s: photons and time to a relative standard error of %g %%, on %d rank%s of %d thread%s\n",
           plan->scene->output, 100 * plan->error, ranks, ranks == 1 ? "" : "s", threads,
           threads == 1 ? "" : "s");
    printf("  %-10s %-9s %9s", "engine", "sampling", "photons/s");
    for (int goal = 0; goal < PILOT_GOALS; goal++)
        if (has_goal(plan, 0, goal)) print_goal(goal_name(plan, goal));
    putchar('\n');
    for (int engine = 0; engine < ENGINES; engine++)
        for (int lattice = SAMPLINGS - 1; lattice >= 0 && plan->photons_per_s[engine] > 0; lattice--)
            print_row(plan, engine, lattice);
    for (int engine = 0; engine < ENGINES; engine++)
        if (plan->refusal[engine].text[0])
            printf("  without %s: %s\n", engine_names[engine], plan->refusal[engine].text);
    printf(
        "  from pilots of up to %.2g photons in %.2g s; photons are known to some 20 %%, of what few packets "
        "have shown\n"
        "  worse; -: fewer than four have (--photons flies longer pilots). Beyond the pilots errors are "
        "taken\n"
        "  to fall with the root of the photons: with lattice sampling that is an upper estimate.\n",
        longest_pilot(plan), plan->seconds);
    if (isfinite(flown(plan)))
        printf(
            "  A run with --target-error needs some %.2g photons and flies %.2g: at least %d, in rounds of "
            "N, N, 2N ... of the file's N = %.6g.\n",
            needed(plan), flown(plan), CML_TARGET_LEAST_PHOTONS, (double)plan->scene->photons);
    if (plan->aimed) {
        printf("  All of this is with --aim %s.\n", plan->aimed);
        return;
    }
    if (plan->aim->tail.scores > 0) printf("  Tt_expected is for runs with --aim Tt.\n");
    print_windows(plan);
}

/* Describes one row of `plan` as JSON: the speed of an engine with one kind of sampling, and for each goal
 * the photons and seconds until the wanted error is reached. */
static json_t *row_json(const struct plan *plan, int engine, int lattice)
{
    const double speed = plan->photons_per_s[engine];
    json_t *row = json_pack("{s:s, s:s, s:f}", "engine", engine_names[engine], "sampling",
                            sampling_names[lattice], "photons_per_s", speed);
    for (int goal = 0; goal < PILOT_GOALS; goal++) {
        if (!has_goal(plan, engine, goal)) continue;
        const double photons = photons_for(&plan->errors[lattice], goal, plan->error);
        json_object_set_new(row, goal == PILOT_NAMED ? "error_of" : goal_name(plan, goal),
                            json_pack("{s:o, s:o}", "photons", cml_json_real(photons), "seconds",
                                      cml_json_real(photons / speed)));
    }
    return row;
}

/* Returns the gain of each aim that the run could have, by the word of --aim. */
static json_t *gains_json(const struct plan *plan)
{
    json_t *gains = json_object();
    if (plan->aim->windows.cells > 0 && !plan->aimed)
        json_object_set_new(gains, "Tt_r", json_real(plan->aim->windows.gain));
    for (int k = 0; k < MOST_DETECTORS; k++)
        if (plan->of_detector[k].cells > 0)
            json_object_set_new(gains, plan->scene->detectors[k].name, json_real(plan->of_detector[k].gain));
    return gains;
}

/* Prints the plan of a scene as one JSON object: a row for each engine and sampling, and what --aim would
 * gain. */
static cml_status print_json(const struct plan *plan, struct cml_error *err)
{
    json_t *object = json_pack(
        "{s:o, s:o, s:f, s:i, s:i, s:f, s:f}", "scene", cml_json_name(plan->scene->file), "output",
        cml_json_name(plan->scene->output), "error", plan->error, "ranks", cml_cluster_size(), "threads",
        plan->errors[1].threads, "pilot_photons", longest_pilot(plan), "pilot_s", plan->seconds);
    if (!object) return cml_fail_memory(err, 1, "the JSON record");
    json_t *rows = json_array();
    for (int engine = 0; engine < ENGINES; engine++)
        for (int lattice = SAMPLINGS - 1; lattice >= 0 && plan->photons_per_s[engine] > 0; lattice--)
            json_array_append_new(rows, row_json(plan, engine, lattice));
    json_object_set_new(object, "plans", rows);
    json_object_set_new(object, "gains", gains_json(plan));
    json_object_set_new(object, "run_photons", cml_json_real(flown(plan)));
    json_object_set_new(object, "version", json_string(cml_version()));
    return cml_json_print(stdout, object, err);
}

/* ---- the command ---- */

/* Prints the plan on rank 0, as JSON or for people. */
static cml_status publish(const struct cml_options *options, const struct plan *plan, struct cml_error *err)
{
    if (cml_cluster_rank() != 0) return CML_OK;
    if (options->json) return print_json(plan, err);
    print_plan(plan);
    return CML_OK;
}

/* Makes the aim of a run without --aim, to show its gain; planes have none, because `exact` knows more. Where
 * windows are refused, only the tail is made. */
static cml_status aim(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                      struct cml_aim *to, struct cml_error *err)
{
    if (cml_surfaces_are_smooth_planes(surfaces)) return CML_OK;
    const cml_status status = cml_aim_create("Tt,Tt_r", scene, surfaces, true, to, err);
    if (status == CML_OK || cml_aim_level_of(scene, surfaces).layer == 0) return CML_OK;
    return cml_aim_create("Tt", scene, surfaces, true, to, err) == CML_E_INPUT ? CML_E_INPUT : CML_OK;
}

/* Computes the weight windows that --aim would use for each detector, because the plan tells what they gain.
 * A detector that cannot be aimed at does not end the plan, which keeps the first reason. */
static void aim_at_detectors(struct plan *plan, const struct cml_surface_set *surfaces)
{
    const struct cml_scene *scene = plan->scene;
    for (int k = 0; k < scene->num_detectors && k < MOST_DETECTORS; k++) {
        struct cml_error why;
        struct cml_aim to;
        if (cml_aim_create(scene->detectors[k].name, scene, surfaces, true, &to, &why) != CML_OK) {
            if (!plan->unaimed.text[0]) plan->unaimed = why;
            continue;
        }
        if (to.windows.detector) plan->of_detector[k] = to.windows;
        plan->of_detector[k].target = NULL; /* owned by `to`, and freed with it */
        cml_aim_clear(&to);
    }
}

/* Prepares the scene as a run is, with the aim of --aim, or else with all aims whose gain is shown. */
static cml_status prepare(struct plan *plan, struct cml_simulation *sim, struct cml_error *err)
{
    plan->aim = &sim->aim;
    CML_TRY(cml_simulation_prepare(sim, NULL, err));
    if (plan->aimed) return CML_OK;
    aim_at_detectors(plan, &sim->surfaces);
    if (sim->setup.error_of > 0) return CML_OK; /* A_l is counted, not expected, as in a run without --aim */
    return aim(plan->scene, &sim->surfaces, &sim->aim, err);
}

/* Plans one scene: flies short pilot runs, then prints how many photons and how much time a wanted error
 * takes. A pilot that is stopped for its time limit counts as a fault of the scene. */
static cml_status plan_scene(const struct cml_options *options, const struct cml_scene *scene, int index,
                             struct cml_error *err)
{
    struct cml_simulation sim;
    struct plan plan = {.scene = scene,
                        .error = options->target_error > 0 ? options->target_error : DEFAULT_ERROR,
                        .aimed = options->aim,
                        .error_of = options->error_of};
    cml_simulation_begin(options, scene, options->engine_options.seed, (uint32_t)index, &sim);
    cml_status status = cml_cluster_agree(prepare(&plan, &sim, err), err);
    sim.setup.photons = options->photons;
    sim.setup.most_seconds = options->photons > 0 ? 0 : MOST_SECONDS;
    sim.setup.target_error = 0;
    sim.setup.on_note = NULL;
    if (status == CML_OK) status = fly_pilots(&plan, &sim.setup, err);
    /* the scene is at fault, no signal came */
    if (status == CML_E_STOPPED) status = err->status = CML_E_INPUT;
    if (status == CML_OK) status = publish(options, &plan, err);
    cml_simulation_clear(&sim);
    return cml_cluster_agree(status, err);
}

cml_status cml_command_plan(const struct cml_options *options, struct cml_error *err)
{
    return cml_fly_scenes(options, plan_scene, err);
}
