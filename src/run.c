/* SPDX-License-Identifier: MIT */
#include "run.h"

#include <time.h>

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Ranges that take about a quarter of a second each: the next one follows from the speed of the last. */
static uint64_t next_range(uint64_t last, double seconds)
{
    const uint64_t most = CML_TALLY_MAX_PHOTONS;
    if (seconds < 0.125 && last < most / 2) return 2 * last;
    if (seconds > 0.5 && last > 1) return last / 2;
    return last;
}

struct flight {
    const struct cml_run_setup *setup;
    struct cml_run_result *out;
    struct cml_tally tally;
    void *engine;
    double begin;
    uint64_t range;
};

static cml_status run_range(struct flight *flight, int batch, uint64_t first, uint64_t count,
                            struct cml_error *err)
{
    const struct cml_run_setup *setup = flight->setup;
    const double begin = now();
    cml_tally_zero(&flight->tally);
    CML_TRY(setup->engine->run(flight->engine, first, count, &flight->tally, err));
    cml_result_add(&flight->out->result, batch, &flight->tally);
    if (count == flight->range) flight->range = next_range(flight->range, now() - begin);
    const struct cml_progress progress = {first + count, setup->photons, now() - flight->begin};
    if (setup->on_progress) setup->on_progress(setup->context, &progress);
    return CML_OK;
}

static cml_status run_batches(struct flight *flight, struct cml_error *err)
{
    const uint64_t photons = flight->setup->photons;
    for (int batch = 0; batch < CML_NUM_BATCHES; batch++) {
        const uint64_t end = cml_batch_first(photons, batch + 1);
        uint64_t first = cml_batch_first(photons, batch);
        while (first < end) {
            const uint64_t count = flight->range < end - first ? flight->range : end - first;
            CML_TRY(run_range(flight, batch, first, count, err));
            first += count;
        }
    }
    flight->out->seconds = now() - flight->begin;
    return CML_OK;
}

static cml_status run_engine(struct flight *flight, struct cml_error *err)
{
    const struct cml_run_setup *setup = flight->setup;
    CML_TRY(setup->engine->open(setup->scene, setup->surfaces, &setup->options, &flight->engine, err));
    flight->out->threads = setup->engine->threads(flight->engine);
    flight->begin = now();
    const cml_status status = run_batches(flight, err);
    setup->engine->close(flight->engine);
    return status;
}

cml_status cml_run(const struct cml_run_setup *setup, struct cml_run_result *out, struct cml_error *err)
{
    const struct cml_grid grid = cml_run_grid(setup->scene, setup->options.absorption);
    struct flight flight = {.setup = setup, .out = out, .range = 1024};
    *out = (struct cml_run_result){0};
    CML_TRY(cml_result_create(&grid, setup->photons, &out->result, err));
    cml_status status = cml_tally_create(&grid, &flight.tally, err);
    if (status == CML_OK) status = run_engine(&flight, err);
    cml_tally_free(&flight.tally);
    if (status != CML_OK) cml_run_result_free(out);
    return status;
}

void cml_run_result_free(struct cml_run_result *out)
{
    cml_result_free(&out->result);
    *out = (struct cml_run_result){0};
}

cml_status cml_run_verdict(const struct cml_scene *scene, const struct cml_result *result,
                           struct cml_error *err)
{
    const double residue = cml_result_residue(result);
    if (residue != 0)
        return cml_fail(err, CML_E_NUMERIC,
                        "%s: the energy books do not balance: residue %.17g of 2^-31 packets", scene->output,
                        residue);
    const double lost = (double)cml_result_lost(result), photons = (double)result->count[CML_COUNT_PHOTONS];
    if (lost > 1e-6 * photons)
        return cml_fail(err, CML_E_NUMERIC, "%s: %.0f of %.0f packets lost (at most 1 in 1e6 may be)",
                        scene->output, lost, photons);
    return CML_OK;
}

double cml_run_bytes(const struct cml_grid *grid, int threads)
{
    return cml_result_bytes(grid) + (threads + 1) * cml_tally_bytes(grid);
}

struct cml_grid cml_run_grid(const struct cml_scene *scene, bool absorption)
{
    const struct cml_grid grid = {.nr = scene->nr,
                                  .nz = scene->nz,
                                  .na = scene->na,
                                  .num_layers = scene->num_layers,
                                  .absorption = absorption};
    return grid;
}
