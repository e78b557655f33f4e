/* Pilots: short runs from which the photons that an error takes are estimated. SPDX-License-Identifier: MIT
 */
#include "cli/command.h"

#include "base/clock.h"
#include "run/cluster/cluster.h"
#include "tally/target_error.h"

#include <math.h>

#define LARGEST_ERROR 0.5 /* relative error of four packets, 1 / sqrt(4); errors of fewer say too little */
#define FIRST_ROUND 1024  /* 16 photons in a batch: fewer say little about its mean */

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
static cml_status fly_round(const struct cml_run_setup *setup, struct cml_pilot *pilot, struct cml_error *err)
{
    struct cml_run_result run;
    struct cml_pilot_round *round = &pilot->round[pilot->num_rounds];
    CML_TRY(cml_run(setup, &run, err));
    round->photons = setup->photons;
    for (int i = 0; i < CML_NUM_GOALS && cml_cluster_rank() == 0; i++) {
        round->error[i] = error_of(&run.result, cml_goals[i]);
        pilot->faint[i] =
            cml_result_total(&run.result, cml_goals[i]) +
                3 * fmax(cml_result_error(&run.result, cml_goals[i]), 1 / (double)setup->photons) <
            CML_TARGET_LEAST_SHARE;
    }
    if (cml_cluster_rank() == 0) round->error[CML_PILOT_EXPECTED] = expected_error(&run.result);
    if (setup->error_of && cml_cluster_rank() == 0)
        round->error[CML_PILOT_NAMED] = cml_target_error_of(&run.result, setup->error_of);
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

/* Flies a short pilot run in rounds of growing length and keeps each round's errors. Ends after a given
 * number of photons or about `seconds`. */
cml_status cml_pilot_fly(const struct cml_run_setup *setup, double seconds, int growth,
                         struct cml_pilot *pilot, struct cml_error *err)
{
    struct cml_run_setup mine = *setup;
    const uint64_t most = setup->photons > 0 ? setup->photons : (uint64_t)1 << 48;
    const double begin = cml_now();
    bool more = true;
    *pilot = (struct cml_pilot){0};
    mine.photons = shorter(FIRST_ROUND, most);
    while (more) {
        const double round_begin = cml_now();
        const cml_status status = fly_round(&mine, pilot, err);
        if (status == CML_E_STOPPED && pilot->num_rounds > 0) return CML_OK;
        CML_TRY(status);
        const double next = growth * (cml_now() - round_begin);
        more = mine.photons < most && pilot->num_rounds < CML_PILOT_MOST_ROUNDS &&
               (setup->photons > 0 || pilot->num_rounds < 2 || cml_now() - begin + next < seconds);
        CML_TRY(cml_cluster_share(&more, sizeof more, err));
        mine.photons = shorter((uint64_t)growth * mine.photons, most);
    }
    return CML_OK;
}

/* Returns how many photons a relative standard error takes, between two rounds of the pilot: the logarithm of
 * the photons is linear in that of the error. The first round may have seen nothing. */
static double interpolate(const struct cml_pilot_round rounds[2], int goal, double error)
{
    const double slope =
        log(rounds[0].error[goal] / error) / log(rounds[0].error[goal] / rounds[1].error[goal]);
    const double first = (double)rounds[0].photons, last = (double)rounds[1].photons;
    return isfinite(rounds[0].error[goal]) ? first * pow(last / first, slope) : last;
}

/* Estimates how many photons a goal needs for a relative standard error. Between two rounds of the pilot the
 * errors are interpolated; beyond the pilot they fall with the root of the photons. */
double cml_pilot_photons(const struct cml_pilot *pilot, int goal, double error)
{
    int reached = pilot->num_rounds; /* from this round on all rounds reach the error */
    while (reached > 0 && pilot->round[reached - 1].error[goal] <= error) reached--;
    if (reached > 0 && reached < pilot->num_rounds)
        return ceil(interpolate(&pilot->round[reached - 1], goal, error));
    if (reached > 0 && pilot->round[reached - 1].error[goal] > LARGEST_ERROR) return INFINITY;
    const struct cml_pilot_round *nearest = &pilot->round[reached > 0 ? reached - 1 : 0];
    const double photons = (double)nearest->photons * pow(nearest->error[goal] / error, 2);
    return ceil(fmax(photons, CML_NUM_BATCHES));
}
