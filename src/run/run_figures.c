/* What a finished run says of itself: how it spent its time, what it held, whether it may be trusted.
 * SPDX-License-Identifier: MIT */
#include "run/run.h"

double cml_run_steps(const struct cml_run_result *run)
{
    const cml_u128 *count = run->result.summary.count;
    return (double)(count[CML_COUNT_INTERACTIONS] + count[CML_COUNT_BOUNDARY_EVENTS]);
}

double cml_run_processor(const struct cml_run_result *run)
{
    double seconds = 0;
    for (int i = 0; i < run->ranks; i++) seconds += run->rank[i].processor;
    return seconds;
}

/* Weighted by time, not the mean of the ranks' shares: a rank that was there for a short time counts for
 * little. */
double cml_run_idle(const struct cml_run_result *run)
{
    double waiting = 0, elapsed = 0;
    for (int i = 0; i < run->ranks; i++) {
        waiting += run->rank[i].waiting;
        elapsed += run->rank[i].elapsed;
    }
    return elapsed > 0 ? waiting / elapsed : 0;
}

double cml_run_communication(const struct cml_run_result *run)
{
    double spent = 0, elapsed = 0;
    for (int i = 0; i < run->ranks; i++) {
        spent += run->rank[i].asking + run->rank[i].summing;
        elapsed += run->rank[i].elapsed;
    }
    return elapsed > 0 ? spent / elapsed : 0;
}

/* An imbalance is a fault of the program, and comes first. Lost packets are a numerical failure that is
 * allowed as long as it is rarer than the noise of any run. */
cml_status cml_run_verdict(const struct cml_scene *scene, const struct cml_result *result,
                           struct cml_error *err)
{
    const double imbalance = cml_result_imbalance(result);
    if (imbalance != 0)
        return cml_fail(err, CML_E_NUMERIC,
                        "%s: the energy books do not balance: residue %.17g of 2^-31 packets", scene->output,
                        imbalance);
    const double lost = (double)cml_result_lost(result),
                 photons = (double)result->summary.count[CML_COUNT_PHOTONS];
    if (lost > 1e-6 * photons)
        return cml_fail(err, CML_E_NUMERIC, "%s: %.0f of %.0f packets lost (at most 1 in 1e6 may be)",
                        scene->output, lost, photons);
    return CML_OK;
}

/* The result, the tally that has what threads share, and the tally of each thread; what the engine itself
 * takes is counted where its surfaces are made. */
double cml_run_bytes(const struct cml_grid *grid, int threads)
{
    const struct cml_grid of_thread = cml_grid_of_thread(grid);
    return cml_result_bytes(grid) + cml_tally_bytes(grid) + threads * cml_tally_bytes(&of_thread);
}
