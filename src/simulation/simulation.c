/* SPDX-License-Identifier: MIT */
#include "simulation/simulation.h"

#include "simulation/beam_notes.h"
#include "simulation/scenes.h"
#include "run/identity.h"

#include <math.h>
#include <stdlib.h>

/* Refuses --derivatives beside options that have no scores. */
static cml_status check_derivatives(const struct cml_options *options, struct cml_error *err)
{
    const char *beside = options->reweight             ? "--reweight"
                         : !options->engine->reweights ? "--engine opencl"
                                                       : NULL;
    if (!options->engine_options.derivatives || !beside) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "--derivatives (expected no %s beside it)", beside);
}

cml_status cml_check_flight_options(const struct cml_options *options, struct cml_error *err)
{
    if (options->error_of && options->target_error == 0)
        return cml_fail(err, CML_E_INPUT, "--error-of (expected --target-error beside it)");
    return check_derivatives(options, err);
}

cml_status cml_check_differentiated(const struct cml_options *options, const struct cml_scene *scene,
                                    struct cml_error *err)
{
    if (!options->engine_options.derivatives || scene->time.gates == 0) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "%s:%d: a time line and --derivatives (expected no such line)",
                    scene->file, scene->time.line);
}

cml_status cml_simulation_check(const struct cml_options *options, const struct cml_scene *scene,
                                const struct cml_surface_set *shared, struct cml_error *err)
{
    struct cml_surface_options surface = options->surface;
    int of;
    surface.shared = shared;
    CML_TRY(cml_check_memory(options, scene, NULL, err));
    CML_TRY(cml_check_starts(scene, &surface, err));
    CML_TRY(cml_find_error_of(options, scene, &of, err));
    return cml_aim_check(options, scene, shared, err);
}

void cml_simulation_begin(const struct cml_options *options, const struct cml_scene *scene, uint64_t seed,
                          uint32_t run, struct cml_simulation *sim)
{
    *sim = (struct cml_simulation){.options = options,
                                   .setup = {.scene = scene,
                                             .engine = options->engine,
                                             .options = options->engine_options,
                                             .photons = options->photons ? options->photons : scene->photons,
                                             .target_error = options->target_error,
                                             .on_note = options->engine_options.on_note}};
    sim->setup.options.seed = seed;
    sim->setup.options.run = run;
}

struct cml_options cml_all_photons(const struct cml_simulation *sim)
{
    struct cml_options all = *sim->options;
    all.photons = sim->setup.photons;
    all.more = 0;
    return all;
}

cml_status cml_simulation_prepare(struct cml_simulation *sim, const struct cml_surface_set *shared,
                                  struct cml_error *err)
{
    struct cml_options all = cml_all_photons(sim);
    struct cml_run_setup *setup = &sim->setup;
    all.surface.shared = shared;
    CML_TRY(cml_choose_surfaces(&all, setup->scene, &sim->surfaces, err));
    CML_TRY(cml_check_memory(&all, setup->scene, &sim->surfaces, err));
    setup->surfaces = &sim->surfaces;
    CML_TRY(cml_aim_for_run(&all, setup->scene, setup->surfaces, true, &sim->aim, err));
    cml_aim_use(&sim->aim, &setup->options);
    return cml_find_error_of(&all, setup->scene, &setup->error_of, err);
}

cml_status cml_simulation_identify(struct cml_simulation *sim, const char *inputs, struct cml_error *err)
{
    const struct cml_options *options = sim->options;
    free(sim->identity);
    sim->identity = NULL;
    sim->provenance = cml_run_provenance(&sim->setup, &options->surface, options->ignore_heightfields);
    sim->provenance.aim = options->aim;
    sim->provenance.error_of = options->error_of;
    sim->setup.provenance = &sim->provenance;
    CML_TRY(cml_identity_of(&sim->provenance, sim->setup.scene->settings, inputs, &sim->identity, err));
    sim->setup.identity = sim->identity;
    return CML_OK;
}

/* Adds the photons of a flight to those before. */
static void add(struct cml_run_result *flown, struct cml_run_result *before)
{
    if (before->result.photons > 0) {
        cml_run_add(&flown->result, &before->result);
        flown->timing.seconds += before->timing.seconds;
        flown->timing.rank[0].elapsed += before->timing.rank[0].elapsed;
        flown->timing.rank[0].processor += before->timing.rank[0].processor;
    }
    cml_run_result_free(before);
    *before = *flown;
}

cml_status cml_simulation_fly(struct cml_simulation *sim, uint64_t photons, struct cml_error *err)
{
    struct cml_run_setup slice = sim->setup;
    struct cml_run_result flown;
    const uint64_t before = sim->flown.result.photons;
    if (slice.target_error > 0 ? photons > 0 || before > 0 : photons == 0 && before > 0)
        return cml_fail(err, CML_E_INPUT, "%llu photons behind %llu (expected %s)",
                        (unsigned long long)photons, (unsigned long long)before,
                        slice.target_error > 0 ? "0, once, with target-error" : "1 or more");
    if (photons > ((uint64_t)1 << 48) - before)
        return cml_fail(err, CML_E_INPUT, "%llu photons behind %llu (expected at most 2^48 together)",
                        (unsigned long long)photons, (unsigned long long)before);
    if (before > 0) slice.base = before;
    if (photons > 0) slice.photons = before + photons;
    CML_TRY(cml_run(&slice, &flown, err));
    sim->setup.photons = slice.photons;
    add(&flown, &sim->flown);
    return CML_OK;
}

struct cml_report cml_simulation_report(const struct cml_simulation *sim)
{
    const struct cml_run_setup *setup = &sim->setup;
    struct cml_report report = {.scene = setup->scene,
                                .surfaces = setup->surfaces,
                                .sums = &sim->flown.result,
                                .timing = &sim->flown.timing,
                                .provenance = setup->provenance,
                                .tail = setup->options.tail,
                                .flat_below = NAN,
                                .command = sim->options->command,
                                .classic = sim->options->classic};
    cml_identity_sum(sim->identity, report.identity);
    return report;
}

void cml_simulation_clear(struct cml_simulation *sim)
{
    cml_run_result_free(&sim->flown);
    cml_surfaces_free(&sim->surfaces);
    cml_aim_clear(&sim->aim);
    free(sim->identity);
}
