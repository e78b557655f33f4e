/* Whether results and their errors are true: bench_unbiased SCENE.mci RUNS PHOTONS REFERENCE. Flies RUNS
 * independent runs of PHOTONS photons as the program does by default, and REFERENCE others of 1e5 with random
 * sampling and MCML's roulette, all by cml_run, and prints CSV: a row per total, and per bin of the profiles
 * or group of neighbours that hold 1000 packets in all runs. Values are weight per launched packet; packets
 * are (mean / deviation)^2 of one run; `reported` is the root mean square of the errors that runs report, and
 * `within` are the shares of runs within one and two of their own from the mean of all. `independent` is how
 * many independent numbers the rows of this quantity are worth. SPDX-License-Identifier: MIT */
#include "engine/engines.h"
#include "input/mci.h"
#include "run/run.h"
#include "scene/heightmap/mesh_budget.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define REFERENCE_PHOTONS 100000
#define PACKETS_OF_GROUP 1000

enum { NUM_QUANTITIES = 9 };

struct quantity {
    const char *name;
    int first, bins; /* in a row of samples */
};

struct bench {
    struct cml_scene_list list;
    struct cml_surface_set surfaces;
    struct quantity quantity[NUM_QUANTITIES];
    int bins; /* of all quantities */
};

/* Independent runs of one kind. */
struct runs {
    int count, bins;
    double *value, *error; /* [count][bins], as shares of a packet */
};

/* Neighbouring bins, or one. */
struct group {
    int first, count; /* in a row of samples */
    double mean, deviation;
};

/* ---- flying ---- */

static cml_status allocate(int count, int bins, struct runs *runs, struct cml_error *err)
{
    const size_t cells = (size_t)count * (size_t)bins + 1;
    *runs = (struct runs){.count = count, .bins = bins, .value = calloc(cells, 8), .error = calloc(cells, 8)};
    return runs->value && runs->error ? CML_OK : cml_fail_memory(err, 16. * (double)cells, "the runs");
}

/* Totals come first, then profiles, in the order of `quantity`. */
static void keep(const struct bench *bench, const struct cml_result *result, double *value, double *error)
{
    const cml_u128 *const batches[NUM_QUANTITIES] = {result->totals, result->totals, result->totals,
                                                     result->totals, result->Rd_r,   result->Tt_r,
                                                     result->Rd_a,   result->Tt_a,   result->A_z};
    for (int q = 0; q < NUM_QUANTITIES; q++) {
        const struct quantity *is = &bench->quantity[q];
        const int n = q < CML_TOTALS ? CML_NUM_TOTALS : is->bins;
        for (int i = 0; i < is->bins; i++) {
            const int bin = q < CML_TOTALS ? q : i;
            value[is->first + i] =
                cml_result_bin_sum(batches[q], n, bin) * CML_WEIGHT_UNIT / (double)result->photons;
            error[is->first + i] = cml_result_bin_error(result, batches[q], n, bin);
        }
    }
}

static cml_status fly(const struct bench *bench, const struct cml_engine_options *options, uint64_t photons,
                      struct runs *runs, struct cml_error *err)
{
    struct cml_run_setup setup = {.scene = bench->list.scenes,
                                  .surfaces = &bench->surfaces,
                                  .engine = cml_engine_find("cpu"),
                                  .options = *options,
                                  .photons = photons};
    double lost = 0;
    for (int i = 0; i < runs->count; i++) {
        const size_t row = (size_t)i * (size_t)runs->bins;
        struct cml_run_result out;
        setup.options.run = (uint32_t)i;
        CML_TRY(cml_run(&setup, &out, err));
        keep(bench, &out.result, runs->value + row, runs->error + row);
        lost += (double)cml_result_lost(&out.result);
        const bool balanced = cml_result_imbalance(&out.result) == 0;
        cml_run_result_free(&out);
        if (!balanced) return cml_fail(err, CML_E_NUMERIC, "the weight of run %d does not balance", i);
    }
    if (lost <= 1e-6 * runs->count * (double)photons) return CML_OK;
    return cml_fail(err, CML_E_NUMERIC, "%.0f packets lost", lost);
}

/* ---- what the runs say ---- */

static double sum_of(const struct runs *runs, int run, const struct group *group)
{
    const double *value = runs->value + (size_t)run * (size_t)runs->bins + group->first;
    double sum = 0;
    for (int i = 0; i < group->count; i++) sum += value[i];
    return sum;
}

/* Mean over all runs, and standard deviation of one. */
static void measure(const struct runs *runs, struct group *group)
{
    double sum = 0, squares = 0;
    for (int r = 0; r < runs->count; r++) sum += sum_of(runs, r, group);
    group->mean = sum / runs->count;
    for (int r = 0; r < runs->count; r++) squares += pow(sum_of(runs, r, group) - group->mean, 2);
    group->deviation = runs->count > 1 ? sqrt(squares / (runs->count - 1)) : 0;
}

static double packets_of(const struct group *group)
{
    return group->deviation > 0 ? pow(group->mean / group->deviation, 2) : 0;
}

/* Totals as they are; groups of a profile are closed when they hold enough packets, and what is left over
 * joins the last. Returns their number. */
static int make_groups(const struct runs *runs, const struct quantity *q, struct group *groups)
{
    int count = 0, first = 0;
    for (int i = 0; i < q->bins; i++) {
        struct group group = {.first = q->first + first, .count = i + 1 - first};
        measure(runs, &group);
        if (q->bins > 1 && packets_of(&group) * runs->count < PACKETS_OF_GROUP) continue;
        groups[count++] = group;
        first = i + 1;
    }
    if (count > 0) {
        groups[count - 1].count = q->first + q->bins - groups[count - 1].first;
        measure(runs, &groups[count - 1]);
    }
    return count;
}

static double correlation(const struct runs *runs, const struct group *a, const struct group *b)
{
    double sum = 0;
    for (int r = 0; r < runs->count; r++)
        sum += (sum_of(runs, r, a) - a->mean) * (sum_of(runs, r, b) - b->mean);
    const double scale = a->deviation * b->deviation;
    return scale > 0 ? sum / (runs->count - 1) / scale : 0;
}

/* Of a sum of squares of n unit deviates with these correlations: its mean is n, its variance 2 sum rho^2, as
 * for n^2 / sum rho^2 independent ones, each counted several times. What noise adds to rho^2 is taken off. */
static double independent(const struct runs *runs, const struct group *groups, int n)
{
    double squares = n;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++)
            squares += 2 * (pow(correlation(runs, groups + i, groups + j), 2) - 1.0 / runs->count);
    return n * (double)n / fmax(squares, n);
}

/* Share of the runs that lie within k of their own errors from the mean. */
static double within(const struct runs *runs, const struct group *group, double k)
{
    int near = 0;
    for (int r = 0; r < runs->count; r++) {
        const size_t at = (size_t)r * (size_t)runs->bins + (size_t)group->first;
        near += fabs(runs->value[at] - group->mean) <= k * runs->error[at];
    }
    return (double)near / runs->count;
}

static double reported(const struct runs *runs, const struct group *group)
{
    double squares = 0;
    for (int r = 0; r < runs->count; r++)
        squares += pow(runs->error[(size_t)r * (size_t)runs->bins + (size_t)group->first], 2);
    return sqrt(squares / runs->count);
}

/* Only what stands in a file has an error of its own: of several bins the last columns are empty. */
static void print_group(const struct quantity *q, const struct runs *runs, const struct runs *reference,
                        const struct group *group, double numbers)
{
    struct group other = *group;
    if (reference->count > 0) measure(reference, &other);
    printf("%s,%d,%d,%.12f,%.12f,%.12f,%.12f,%.12f,%.1f,%.1f,", q->name, group->first - q->first,
           group->first - q->first + group->count - 1, group->mean, group->deviation / sqrt(runs->count),
           reference->count > 0 ? other.mean : 0,
           reference->count > 0 ? other.deviation / sqrt(reference->count) : 0, group->deviation,
           packets_of(group), numbers);
    if (group->count == 1)
        printf("%.12f,%.4f,%.4f\n", reported(runs, group), within(runs, group, 1), within(runs, group, 2));
    else
        printf(",,\n");
}

static cml_status report(const struct bench *bench, const struct runs *runs, const struct runs *reference,
                         struct cml_error *err)
{
    struct group *groups = calloc((size_t)bench->bins, sizeof *groups);
    if (!groups) return cml_fail_memory(err, 0, "the groups");
    printf("quantity,first,last,mean,mean_error,reference,reference_error,deviation,packets,independent,"
           "reported,within_1,within_2\n");
    for (int q = 0; q < NUM_QUANTITIES; q++) {
        const int n = make_groups(runs, &bench->quantity[q], groups);
        const double numbers = independent(runs, groups, n);
        for (int i = 0; i < n; i++) print_group(&bench->quantity[q], runs, reference, &groups[i], numbers);
    }
    free(groups);
    return CML_OK;
}

/* ---- the program ---- */

static cml_status open_scene(const char *path, struct bench *bench, struct cml_error *err)
{
    const struct cml_surface_options how = {.force = CML_SURFACE_AUTO,
                                            .tolerance = 1e-3,
                                            .tessellation = {.normals = CML_NORMALS_ANALYTIC},
                                            .budget = {.most = cml_mesh_budget_default()}};
    CML_TRY(cml_mci_read(path, NULL, &bench->list, err));
    const struct cml_scene *scene = bench->list.scenes;
    const struct quantity quantities[NUM_QUANTITIES] = {
        {"Rsp", 0, 1},          {"Rd", 0, 1},           {"A", 0, 1},
        {"Tt", 0, 1}, /* as in enum cml_total */
        {"Rd_r", 0, scene->nr}, {"Tt_r", 0, scene->nr}, {"Rd_a", 0, scene->na},
        {"Tt_a", 0, scene->na}, {"A_z", 0, scene->nz}};
    memcpy(bench->quantity, quantities, sizeof quantities);
    for (int q = 0; q < NUM_QUANTITIES; q++) {
        bench->quantity[q].first = bench->bins;
        bench->bins += bench->quantity[q].bins;
    }
    return cml_surfaces_create(scene, &how, &bench->surfaces, err);
}

static cml_status run(char **arguments, struct bench *bench, struct runs runs[2], struct cml_error *err)
{
    const struct cml_engine_options usual = {.seed = 1,
                                             .threads = 1,
                                             .lattice = true,
                                             .roulette = {0.003, 0.01},
                                             .reentry = true,
                                             .absorption = true};
    struct cml_engine_options plain = usual;
    plain.seed = 2;
    plain.lattice = false;
    plain.roulette = (struct cml_roulette_options){0, 0};
    CML_TRY(open_scene(arguments[1], bench, err));
    CML_TRY(allocate(atoi(arguments[2]), bench->bins, &runs[0], err));
    CML_TRY(allocate(atoi(arguments[4]), bench->bins, &runs[1], err));
    CML_TRY(fly(bench, &usual, strtoull(arguments[3], NULL, 10), &runs[0], err));
    CML_TRY(fly(bench, &plain, REFERENCE_PHOTONS, &runs[1], err));
    return report(bench, &runs[0], &runs[1], err);
}

int main(int argc, char **argv)
{
    struct bench bench = {.bins = 0};
    struct runs runs[2] = {{0}, {0}};
    struct cml_error err = {CML_OK, "SCENE.mci RUNS PHOTONS REFERENCE"};
    cml_status status = argc == 5 ? run(argv, &bench, runs, &err) : CML_E_INPUT;
    for (int i = 0; i < 2; i++) {
        free(runs[i].value);
        free(runs[i].error);
    }
    cml_surfaces_free(&bench.surfaces);
    cml_scene_list_clear(&bench.list);
    if (status != CML_OK) fprintf(stderr, "bench_unbiased: %s\n", err.text);
    return status == CML_OK ? 0 : 2;
}
