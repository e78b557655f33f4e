/* SPDX-License-Identifier: MIT */
#include "simulation/simulation.h"

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

struct cml_run_setup cml_setup_of(const struct cml_options *options, const struct cml_scene *scene,
                                  uint64_t seed, uint32_t run)
{
    struct cml_run_setup setup = {.scene = scene,
                                  .engine = options->engine,
                                  .options = options->engine_options,
                                  .photons = options->photons ? options->photons : scene->photons,
                                  .target_error = options->target_error,
                                  .on_note = cml_show_note};
    setup.options.seed = seed;
    setup.options.run = run;
    return setup;
}

struct cml_options cml_all_photons(const struct cml_options *options, const struct cml_run_setup *setup)
{
    struct cml_options all = *options;
    all.photons = setup->photons;
    all.more = 0;
    return all;
}

cml_status cml_prepare(const struct cml_options *options, const struct cml_surface_set *shared,
                       struct cml_prepared *run, struct cml_error *err)
{
    struct cml_options mine = *options;
    struct cml_run_setup *setup = &run->setup;
    mine.surface.shared = shared;
    const struct cml_options all = cml_all_photons(&mine, setup);
    CML_TRY(cml_choose_surfaces(&mine, setup->scene, &run->surfaces, err));
    CML_TRY(cml_check_memory(&all, setup->scene, &run->surfaces, err));
    setup->surfaces = &run->surfaces;
    CML_TRY(cml_aim_for_run(&mine, setup->scene, setup->surfaces, &run->aim, err));
    cml_aim_use(&run->aim, &setup->options);
    return cml_find_error_of(&mine, setup->scene, &setup->error_of, err);
}

cml_status cml_prepared_identify(const struct cml_options *options, const char *inputs,
                                 struct cml_prepared *run, struct cml_error *err)
{
    free(run->identity);
    run->identity = NULL;
    run->provenance = cml_run_provenance(&run->setup, &options->surface, options->ignore_heightfields);
    run->provenance.aim = options->aim;
    run->provenance.error_of = options->error_of;
    run->setup.provenance = &run->provenance;
    CML_TRY(cml_identity_of(&run->provenance, run->setup.scene->settings, inputs, &run->identity, err));
    run->setup.identity = run->identity;
    return CML_OK;
}

struct cml_report cml_prepared_report(const struct cml_prepared *run, const struct cml_run_result *flown,
                                      const char *command)
{
    const struct cml_run_setup *setup = &run->setup;
    struct cml_report report = {.scene = setup->scene,
                                .surfaces = setup->surfaces,
                                .sums = &flown->result,
                                .timing = &flown->timing,
                                .provenance = setup->provenance,
                                .tail = setup->options.tail,
                                .flat_below = NAN,
                                .command = command};
    cml_identity_sum(run->identity, report.identity);
    return report;
}

void cml_prepared_clear(struct cml_prepared *run)
{
    cml_surfaces_free(&run->surfaces);
    cml_aim_clear(&run->aim);
    free(run->identity);
}
