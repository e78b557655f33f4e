/* SPDX-License-Identifier: MIT */
#include "cli/run/unaimed.h"

#include "result/quantity.h"
#include "run/cluster.h"

#include <math.h>
#include <stdio.h>

/* Errors of even spreading fall faster than by the root of the photons, so a short plain flight takes them
 * for too large: an eighth of the run's photons, within these. */
#define LEAST_PHOTONS 4096
#define MOST_PHOTONS 65536

static uint64_t plain_photons(uint64_t photons)
{
    if (photons / 8 > MOST_PHOTONS) return MOST_PHOTONS;
    if (photons < LEAST_PHOTONS) return photons;
    return photons / 8 > LEAST_PHOTONS ? photons / 8 : LEAST_PHOTONS;
}

/* Known to a quarter: 64 batches tell an error to 9 %. */
static double cost(const struct cml_result *result, enum cml_total total)
{
    return pow(cml_result_error(result, total), 2) * cml_result_steps(result);
}

static void print_costs(const struct cml_result *result, const struct cml_result *plain)
{
    const char *before = "  to the same error as without windows ";
    for (int i = 0; i < CML_NUM_GOALS; i++) {
        const double times = cost(result, cml_goals[i]) / cost(plain, cml_goals[i]);
        if (!isfinite(times) || times == 0) continue;
        printf("%s%s takes some %.1g", before, cml_quantities[cml_goals[i]].name, times);
        before = ", ";
    }
    if (before[0] == ',') printf(" times the steps (by %g photons without)\n", (double)plain->photons);
}

static void print_all(const struct cml_window_table *windows, const struct cml_result *result,
                      const struct cml_result *plain)
{
    print_costs(result, plain);
    if (windows->gain == 0)
        printf("  windows gain nothing for what %.2g of the light comes to\n", windows->worth);
}

void cml_unaimed_show(const struct cml_options *options, const struct cml_run_setup *setup,
                      const struct cml_run_result *run)
{
    if (!setup->options.windows || run->intent == CML_RUN_NOTHING_LEFT || options->quiet || options->json)
        return;
    struct cml_scene scene = *setup->scene;
    struct cml_run_setup mine = {.scene = &scene,
                                 .surfaces = setup->surfaces,
                                 .engine = setup->engine,
                                 .options = setup->options,
                                 .photons = plain_photons(run->result.photons)};
    struct cml_run_result plain;
    struct cml_error ignored;
    scene.nr = scene.nz = scene.na = 1;
    cml_scene_ask_nothing(&scene);
    mine.options.tail = NULL;
    mine.options.windows = NULL;
    if (cml_run(&mine, &plain, &ignored) != CML_OK) return; /* the results are there without it */
    if (cml_cluster_rank() == 0) print_all(setup->options.windows, &run->result, &plain.result);
    cml_run_result_free(&plain);
}
