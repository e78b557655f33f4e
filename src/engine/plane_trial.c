/* SPDX-License-Identifier: MIT */
#include "engine/plane_trial.h"

#include "result/quantity.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Seed of all trials. Any number would do, but it must be fixed, so that all runs of a scene have the same
 * surfaces. */
#define SEED UINT64_C(0x706c616e65)
#define BATCHES 64
#define MOST_PACKETS 1048576
#define MOST_STEPS 4e7     /* steps of both ways and all boundaries; a step takes 5 to 40 ns */
#define ALONE 16.0         /* factor by which a packet that flies alone takes longer */
#define CELLS_AS_STEPS 0.1 /* steps per cell of a tally, which is zeroed and summed in 1 to 3 ns */

/* SURE: number of standard errors added to a difference before a plane is found to do no harm.
 * SURE_OF_HARM: number of standard errors by which a difference must exceed the tolerance before a plane
 * is found to do harm. It is larger, because one of some hundred bins may be off by chance. */
#define SURE 3.0
#define SURE_OF_HARM 4.0
/* Largest expected number of packets that show an effect although no packet has shown it yet. If a share p
 * of all packets shows an effect, none of n packets shows it with the probability exp(-n p). At n p = 6.6
 * this is 0.14 %, so an effect that was not seen is smaller with 99.86 % certainty. */
#define UNSEEN 6.6

/* Neighbouring values that are judged together: a total, or the bins of a profile. */
struct series {
    const char *name;
    size_t first, count;
};
#define NUM_SERIES (CML_NUM_TOTALS + 7)

/* Sums over batches of one value, in units of weight: the score of the scene as it is, the difference that
 * the planes make, and the square of this difference. The root of the sum of squares is the standard error of
 * the difference. It is somewhat larger than the spread about the mean, and needs no batches of equal
 * length. */
struct value {
    double truth, difference, squares;
};

struct trial {
    const struct cml_engine *engine;
    void *flight[2]; /* the scene as it is; the scene with planes */
    struct cml_tally tally[2];
    struct series series[NUM_SERIES];
    struct value *value; /* [num_values] */
    size_t num_values;
    double tolerance, most_steps;
    double steps;    /* steps of both ways so far, by the time that they take */
    double overhead; /* steps of one round for zeroing and summing tallies */
    int rounds;
    uint64_t packets; /* packets flown each way */
};

struct verdict {
    const char *refused;    /* reason to refuse the trial without a packet; NULL: it was tried */
    bool harmless, harmful; /* the verdict; if both are false, more packets are needed */
    double most;            /* largest possible difference */
    const char *what;       /* the total or profile that has this difference */
};

/* Lists all values by which a trial compares shape and plane: totals, profiles over r, angle and z, and the
 * absorption of layers and bodies. A series is a name, the place of its first value and the number of
 * values. */
static void list_series(const struct cml_tally_grid *grid, struct series *series)
{
    const struct cml_layout at = cml_layout_of(grid, CML_OF_PROFILES);
    static const enum cml_array profiles[] = {CML_ARRAY_Rd_r, CML_ARRAY_Tt_r, CML_ARRAY_Rd_a, CML_ARRAY_Tt_a,
                                              CML_ARRAY_A_z};
    enum { PROFILES = sizeof profiles / sizeof *profiles };
    for (int i = 0; i < CML_NUM_TOTALS; i++)
        series[i] = (struct series){cml_quantities[cml_quantity_of_total(i)].name, (size_t)i,
                                    cml_has_total(i, grid->backed, grid->faced)};
    series += CML_NUM_TOTALS;
    for (int i = 0; i < PROFILES; i++, series++)
        *series = (struct series){cml_arrays[profiles[i]].name, at.at[profiles[i]], at.size[profiles[i]]};
    series[0] = (struct series){"A_l", at.A_l + 1, (size_t)grid->num_layers};
    series[1] = (struct series){"A_body", at.A_l + (size_t)grid->num_layers + 2, (size_t)grid->num_bodies};
}

/* ---- flying ---- */

/* Adds the cells beyond the grid to the first and last bins of profiles, as in printed results, so that a
 * trial compares what users see. */
static void fold_profiles(struct cml_tally *tally)
{
    const struct cml_layout at = tally->profile;
    const size_t nr = (size_t)tally->grid.nr, nz = (size_t)tally->grid.nz;
    uint64_t *Rd_r = tally->batch_sums + at.Rd_r, *Tt_r = tally->batch_sums + at.Tt_r,
             *A_z = tally->batch_sums + at.A_z;
    uint64_t *const ends[][2] = {
        {Rd_r + nr, Rd_r + nr - 1}, {Tt_r + nr, Tt_r + nr - 1}, {A_z, A_z + 1}, {A_z + nz + 1, A_z + nz}};
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
        *ends[i][1] += *ends[i][0];
        *ends[i][0] = 0;
    }
}

/* Adds the values of a batch for both ways (shape and plane) to the sums, and their differences, whose
 * spread gives the errors. */
static void add_values(const uint64_t *as_is, const uint64_t *level, size_t count, struct value *value)
{
    for (size_t i = 0; i < count; i++) {
        const double truth = (double)as_is[i], difference = (double)level[i] - truth;
        value[i].truth += truth;
        value[i].difference += difference;
        value[i].squares += difference * difference;
    }
}

/* Flies a batch of packets both ways with the same random numbers, so most differences are 0, and the others
 * are small. */
static cml_status fly_batch(struct trial *trial, uint64_t count, struct cml_error *err)
{
    for (int way = 0; way < 2; way++) {
        struct cml_tally *tally = &trial->tally[way];
        cml_tally_zero(tally);
        CML_TRY(cml_engine_run_range(trial->engine, trial->flight[way], trial->packets, count, tally, err));
        cml_tally_sum_batch(tally, -1);
        fold_profiles(tally);
        trial->steps += (1 + ALONE / (double)count) * (double)(tally->count[CML_COUNT_INTERACTIONS] +
                                                               tally->count[CML_COUNT_BOUNDARY_EVENTS]);
    }
    add_values(trial->tally[0].batch_sums, trial->tally[1].batch_sums, trial->num_values, trial->value);
    trial->packets += count;
    return CML_OK;
}

/* ---- judging ---- */

/* Returns the light, in units of weight, by which the differences of a series are divided. It is the light
 * that the series scored, but at least the least share of the launched light, so that dark series do not
 * count too much. */
static double light_of(const struct trial *trial, const struct series *series)
{
    double truth = 0;
    for (size_t i = 0; i < series->count; i++) truth += trial->value[series->first + i].truth;
    return fmax(truth, CML_TRIAL_LEAST_SHARE * (double)trial->packets / CML_WEIGHT_UNIT);
}

/* Returns the upper bound on the relative difference of a series: the measured difference, three standard
 * errors, and the weight of packets that may have been missed altogether (UNSEEN). A missed packet may
 * move from one bin of a profile to another, which counts twice; it changes a total once. */
static double most_of_series(const struct trial *trial, const struct series *series)
{
    double difference = 0, squares = 0;
    for (size_t i = series->first; i < series->first + series->count; i++) {
        difference += fabs(trial->value[i].difference);
        squares += trial->value[i].squares;
    }
    const double unseen = (series->count > 1 ? 2 : 1) * UNSEEN / CML_WEIGHT_UNIT;
    return (difference + SURE * sqrt(squares) + unseen) / light_of(trial, series);
}

/* Judges one total or profile, and each of its bins. A bin's difference is divided by the bin, or by the
 * average bin if that is more. */
static void judge_series(const struct trial *trial, const struct series *series, struct verdict *verdict)
{
    const double average = light_of(trial, series) / (double)series->count;
    double most = most_of_series(trial, series);
    for (size_t i = 0; i < series->count; i++) {
        const struct value *value = &trial->value[series->first + i];
        const double whole = fmax(value->truth, average), difference = fabs(value->difference);
        const double error = sqrt(value->squares);
        most = fmax(most, (difference + SURE * error) / whole);
        verdict->harmful |= difference - SURE_OF_HARM * error > trial->tolerance * whole;
    }
    if (most <= verdict->most && !verdict->harmful) return;
    verdict->most = most;
    verdict->what = series->name;
}

/* Returns the verdict on the planes from the packets flown so far: the judgement over all totals and
 * profiles. */
static struct verdict judge(const struct trial *trial)
{
    struct verdict verdict = {.most = 0};
    for (int i = 0; i < NUM_SERIES && !verdict.harmful; i++)
        if (trial->series[i].count > 0) judge_series(trial, &trial->series[i], &verdict);
    verdict.harmless = !verdict.harmful && verdict.most <= trial->tolerance;
    return verdict;
}

/* Returns the number of packets of the next round. The total grows to 64, 2048, 16 Ki, 128 Ki and 1 Mi
 * packets, because few packets are enough to see a large difference. The last round takes the steps that
 * are left. */
static uint64_t next_round(const struct trial *trial)
{
    const double left = trial->most_steps - trial->steps - (trial->rounds + 1) * trial->overhead;
    if (left <= 0) return 0;
    if (trial->packets == 0) return BATCHES;
    const double each = fmax(trial->steps / (double)trial->packets, 1);
    const uint64_t whole = trial->packets == BATCHES ? 2048 : 8 * trial->packets;
    const uint64_t wanted = (whole < MOST_PACKETS ? whole : MOST_PACKETS) - trial->packets;
    const uint64_t possible = (uint64_t)fmin(left / each, MOST_PACKETS);
    return (wanted < possible ? wanted : possible) / BATCHES * BATCHES;
}

/* Flies a round of packets. The round ends early if its packets take many more steps than those before. */
static cml_status fly_round(struct trial *trial, uint64_t packets, struct cml_error *err)
{
    trial->rounds++;
    for (int batch = 0; batch < BATCHES && trial->steps < trial->most_steps; batch++)
        CML_TRY(fly_batch(trial, packets / BATCHES, err));
    return CML_OK;
}

/* Flies rounds of packets until the verdict is certain or no steps are left. */
static cml_status fly_and_judge(struct trial *trial, struct verdict *verdict, struct cml_error *err)
{
    *verdict = (struct verdict){.refused = "too large a grid for trial packets"};
    for (uint64_t round = next_round(trial); round > 0; round = next_round(trial)) {
        CML_TRY(fly_round(trial, round, err));
        *verdict = judge(trial);
        if (verdict->harmless || verdict->harmful) return CML_OK;
    }
    return CML_OK;
}

/* ---- one boundary after the other ---- */

/* Makes an engine and a tally for each of the two ways of a trial: with the shape, and with a plane in its
 * place. overhead: the cost of handling tallies, counted in steps of packets. */
static cml_status open_trial(const struct cml_scene *scene, const struct cml_engine_options *options,
                             const struct cml_surface_set *ways[2], struct trial *trial,
                             struct cml_error *err)
{
    const struct cml_tally_grid grid = cml_engine_grid(scene, ways[0], options);
    list_series(&grid, trial->series);
    trial->num_values = cml_tally_profile_bins(&grid);
    trial->overhead = 2 * BATCHES * CELLS_AS_STEPS * (double)cml_tally_cells(&grid);
    trial->value = calloc(trial->num_values, sizeof *trial->value);
    if (!trial->value)
        return cml_fail_memory(err, (double)(trial->num_values * sizeof *trial->value), "trial packets");
    for (int way = 0; way < 2; way++) {
        CML_TRY(cml_tally_create(&grid, &trial->tally[way], err));
        CML_TRY(trial->engine->open(scene, ways[way], options, &trial->flight[way], err));
    }
    return CML_OK;
}

/* Frees a trial, which flies the same photons in two ways: with the shape of a boundary, and with a plane in
 * its place. */
static void close_trial(struct trial *trial)
{
    for (int way = 0; way < 2; way++) {
        trial->engine->close(trial->flight[way]);
        cml_tally_free(&trial->tally[way]);
    }
    free(trial->value);
}

/* The search over all boundaries of a scene. */
struct search {
    const struct cml_scene *scene; /* the scene without maps, which are not compared */
    const struct cml_engine *engine;
    struct cml_engine_options options;
    double tolerance, most_steps; /* most steps for one boundary */
    struct cml_surface_set *curved;
    /* Level rings, owned, where a plane does no harm; elsewhere the surfaces of `curved`, borrowed. */
    struct cml_surface_set level;
    struct verdict *verdict; /* [curved->count] */
};

static bool is_curved(const struct cml_surface_def *def)
{
    return def->kind != CML_SURFACE_PLANE;
}

/* True if bodies lie in the layer above or below the boundary. The depths of bodies are stored relative to
 * the boundary above their layer, and a plane in place of this boundary might cut through a body. */
static bool has_bodies_beside(const struct cml_scene *scene, int b)
{
    return cml_layer_has_bodies(scene, b) || cml_layer_has_bodies(scene, b + 1);
}

/* Flies the scene as it is and with level rings in place of its curved boundaries, and judges whether the
 * results differ. */
static cml_status try_level(const struct search *search, struct verdict *verdict, struct cml_error *err)
{
    const struct cml_surface_set *ways[2] = {search->curved, &search->level};
    CML_AT_END(close_trial)
    struct trial trial = {
        .engine = search->engine, .tolerance = search->tolerance, .most_steps = search->most_steps};
    CML_TRY(open_trial(search->scene, &search->options, ways, &trial, err));
    return fly_and_judge(&trial, verdict, err);
}

/* True if the boundary would become a face of a glass plate. As a plane it would make the program count the
 * light that goes to and fro in a clear first layer as specular (P1), which is another definition of Rsp and
 * Rd. */
static bool is_face_of_glass(const struct cml_scene *scene, int b)
{
    const struct cml_medium_def *first = &scene->media[1];
    return b <= 1 && scene->num_layers > 1 && cml_medium_mut(first) == 0 && !scene->beams[0].inside &&
           scene->beams[0].angle == 0 && scene->beams[0].light.kind == CML_LIGHT_OF_PARALLEL;
}

/* True if packets of a beam inside may start at a depth between the lowest and the highest point of the
 * boundary. A plane in place of the boundary would leave some of them on the wrong side. */
static bool starts_within(const struct cml_beam *beam, const struct cml_surface_def *def)
{
    const double height = cml_beam_height(beam);
    return beam->inside && beam->z + height >= def->depth + def->lowest &&
           beam->z - height <= def->depth + def->highest;
}

/* Returns the reason why a boundary needs no trial; NULL if it needs one. Several beams are such a reason,
 * because the few packets of a round would all belong to the first. */
static const char *why_not(const struct search *search, int b)
{
    const struct cml_scene *scene = search->scene;
    if (is_face_of_glass(scene, b)) return "as a plane it would count more light as Rsp";
    if (has_bodies_beside(scene, b)) return "beside bodies it stays as it is";
    if (scene->num_beams > 1) return "under several beams it stays as it is";
    return starts_within(&scene->beams[0], &search->curved->item[b]) ? "light starts within its depths"
                                                                     : NULL;
}

/* Tries level rings in a boundary's place. They stay in `level` if they do no harm, for the boundaries that
 * are tried next. */
static cml_status try_boundary(struct search *search, int b, struct cml_error *err)
{
    struct cml_surface_def *level = &search->level.item[b];
    struct verdict *verdict = &search->verdict[b];
    *verdict = (struct verdict){.refused = why_not(search, b)};
    if (verdict->refused) return CML_OK;
    cml_status status = cml_surface_make_level_rings(&search->scene->boundaries[b], level, err);
    if (status == CML_OK) status = try_level(search, verdict, err);
    if (status == CML_OK && verdict->harmless) return CML_OK;
    verdict->harmless = false;
    cml_surface_clear(level);
    *level = search->curved->item[b];
    return status;
}

/* Appends the outcome to the boundary's reason. For a difference that is certain, its size is left out,
 * because few packets measured it. */
static void tell(const struct verdict *verdict, double tolerance, struct cml_surface_def *def)
{
    const size_t used = strlen(def->reason), room = sizeof def->reason - used;
    char *text = def->reason + used;
    if (verdict->refused)
        snprintf(text, room, ", %s", verdict->refused);
    else if (verdict->harmless)
        snprintf(text, room, ", as a plane %s is off by at most %.2g", verdict->what, verdict->most);
    else if (verdict->harmful)
        snprintf(text, room, ", as a plane %s is off by more than %g", verdict->what, tolerance);
    else
        snprintf(text, room, ", as a plane %s may be off by %.2g", verdict->what, verdict->most);
}

/* Acts on the result of the trials of boundary b: the boundary becomes a plane if the plane does no harm.
 * The user is told in either case. */
static void adopt(const struct search *search, int b)
{
    const struct verdict *verdict = &search->verdict[b];
    struct cml_surface_def *def = &search->curved->item[b];
    if (verdict->harmless) {
        const double seconds = def->build_seconds;
        cml_surface_clear(def);
        cml_surface_make_outer_plane(&search->scene->boundaries[b], def);
        def->expectation.bias = verdict->most;
        def->build_seconds = seconds;
        cml_surface_clear(&search->level.item[b]);
    }
    tell(verdict, search->tolerance, def);
}

/* Makes the search's set of level surfaces, which begins as a copy of the curved ones. */
static cml_status allocate(struct search *search, struct cml_error *err)
{
    const size_t count = (size_t)search->curved->count;
    /* Level surfaces begin as copies of the curved ones, and share their bodies. */
    search->level = *search->curved;
    search->level.item = malloc(count * sizeof *search->level.item);
    search->verdict = calloc(count, sizeof *search->verdict);
    if (!search->level.item || !search->verdict)
        return cml_fail_memory(err, (double)(count * sizeof *search->level.item), "the boundaries");
    memcpy(search->level.item, search->curved->item, count * sizeof *search->level.item);
    return CML_OK;
}

/* Tries each curved boundary with its share of the steps. No boundary becomes a plane before the last was
 * tried. */
static cml_status search_planes(struct search *search, struct cml_error *err)
{
    const struct cml_surface_set *curved = search->curved;
    int candidates = 0;
    for (int b = 0; b < curved->count; b++) candidates += is_curved(&curved->item[b]);
    search->most_steps = MOST_STEPS / candidates;
    cml_status status = allocate(search, err);
    for (int b = 0; status == CML_OK && b < curved->count; b++)
        if (is_curved(&curved->item[b])) status = try_boundary(search, b, err);
    for (int b = 0; search->verdict && b < curved->count; b++)
        if (is_curved(&curved->item[b])) adopt(search, b);
    free(search->level.item);
    free(search->verdict);
    return status;
}

/* Trials have options of their own (seed, sampling), so that the outcome depends on the scene only. */
cml_status cml_make_harmless_planes(const struct cml_scene *scene, const struct cml_surface_options *options,
                                    const struct cml_engine *engine,
                                    const struct cml_engine_options *engine_options,
                                    struct cml_surface_set *surfaces, struct cml_error *err)
{
    struct cml_scene bare = *scene;
    bare.map = (struct cml_map_def){0};
    struct search search = {.scene = &bare,
                            .engine = engine,
                            .options = *engine_options,
                            .tolerance = options->tolerance,
                            .curved = surfaces};
    search.options.seed = SEED;
    search.options.run = 0;
    search.options.absorption = true;
    search.options.lattice = false; /* the standard errors of a trial assume independent packets */
    search.options.roulette = (struct cml_roulette_options){0, 0};
    if (!options->may_flatten || options->force != CML_SURFACE_AUTO || scene->facets) return CML_OK;
    return search_planes(&search, err);
}
