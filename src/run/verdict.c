/* Questions about a run beside its flight: may its result be trusted, which sums does it have, and how much
 * memory do they take?
 * SPDX-License-Identifier: MIT */
#include "run/run.h"

/* Tests the imbalance first, because it is a fault of the program. Lost packets are a numerical failure that
 * is allowed while it is rarer than the noise of any run. */
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

struct cml_tally_grid cml_run_grid(const struct cml_run_setup *setup)
{
    struct cml_tally_grid grid = cml_engine_grid(setup->scene, setup->surfaces, &setup->options);
    if (!(setup->target_error > 0)) grid.saved.limit = cml_most_saved(setup->scene, setup->photons);
    return grid;
}

/* Counts the result, the tally that threads share, and the tally of each thread. Memory of the engine itself
 * is counted where its surfaces are made. */
double cml_run_bytes(const struct cml_tally_grid *grid, int threads)
{
    const struct cml_tally_grid of_thread = cml_tally_grid_of_thread(grid);
    return cml_result_bytes(grid) + cml_tally_bytes(grid) + threads * cml_tally_bytes(&of_thread);
}
