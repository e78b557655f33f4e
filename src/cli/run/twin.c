/* clustermcml run --control flat: the flat twin of a scene, whose totals adding-doubling knows. Twin and
 * scene fly the same photons with the same draws, so their totals err alike. SPDX-License-Identifier: MIT */
#include "cli/run/twin.h"

#include "base/text.h"
#include "cli/load/scenes.h"
#include "run/checkpoint.h"
#include "run/cluster.h"
#include "scene/specular.h"

#include <stdlib.h>
#include <string.h>

/* Multiplications, some seconds of them. */
#define MOST_WORK 1e10

/* Planes without bodies, and a grid of one bin: only totals are wanted of it. *flat is untouched until it has
 * boundaries of its own, for its owner frees them. */
static cml_status flatten(const struct cml_scene *scene, struct cml_scene *flat, struct cml_error *err)
{
    const size_t count = (size_t)scene->num_layers + 1;
    if (cml_layer_has_bodies(scene, 1) && cml_medium_mut(&scene->media[1]) == 0)
        return cml_fail_field(err, scene->file, scene->bodies[0].line, "layer 1", "clear, with bodies",
                              "no --control flat: its twin counts other light as specular");
    struct cml_boundary *own = calloc(count, sizeof *own);
    if (!own) return cml_fail_memory(err, (double)(count * sizeof *own), "planes");
    for (size_t b = 0; b < count; b++) own[b].z = scene->boundaries[b].z;
    *flat = *scene;
    flat->boundaries = own;
    flat->nr = flat->nz = flat->na = 1;
    cml_scene_ask_nothing(flat);
    flat->bodies = NULL;
    flat->num_bodies = 0;
    return CML_OK;
}

/* The share of the light that is parallel and at normal incidence. */
static double normal_share(const struct cml_scene *scene)
{
    double normal = 0, all = 0;
    for (int k = 0; k < scene->num_beams; k++) {
        const struct cml_beam *beam = &scene->beams[k];
        all += scene->shares[k];
        if (beam->angle == 0 && beam->light.kind == CML_LIGHT_OF_PARALLEL) normal += scene->shares[k];
    }
    return normal / all;
}

/* What the twin's packets count as specular is what those of the scene do: the first reflection at boundary
 * 0, and that of a clear first layer only where the scene's packets start below it (P1). */
static double specular(const struct cml_run_setup *setup, const struct cml_exact *exact)
{
    const struct cml_scene *scene = setup->scene;
    const struct cml_surface_def *surface = setup->surfaces->item;
    const bool enters = surface[0].kind == CML_SURFACE_PLANE && !cml_is_rough(&surface[0].rough),
               planes = enters && surface[1].kind == CML_SURFACE_PLANE && !cml_is_rough(&surface[1].rough);
    const double all = cml_specular_split(scene->media, scene->num_layers, true).reflected,
                 own = cml_specular_split(scene->media, scene->num_layers, planes).reflected;
    return exact->value[CML_EXACT_RSP] - normal_share(scene) * (all - own);
}

static cml_status solve(const struct cml_run_setup *setup, struct cml_twin *twin, struct cml_error *err)
{
    const struct cml_exact_options aim = {.tolerance = 1e-7, .most_work = MOST_WORK};
    struct cml_exact exact;
    CML_TRY(cml_exact_scene(&twin->scene, NULL, &aim, &exact, err));
    const double *value = exact.value, Rsp = specular(setup, &exact);
    for (int t = 0; t < CML_NUM_TOTALS; t++) twin->known[t] = (struct cml_known){value[t], exact.error[t]};
    twin->known[CML_TOTAL_SPECULAR].value = Rsp;
    twin->known[CML_TOTAL_REFLECTED].value = value[CML_EXACT_RSP] + value[CML_EXACT_RD] - Rsp;
    cml_exact_clear(&exact);
    return CML_OK;
}

/* NAME.control.checkpoint, beside the scene's. */
static cml_status checkpoint_path(const struct cml_options *options, const struct cml_scene *scene,
                                  char **path, struct cml_error *err)
{
    CML_FREED char *output = NULL, *name = NULL;
    CML_TRY(cml_output_path(options, scene->output, &output, err));
    CML_TRY(cml_text_format(&name, "a name", err, "%s.control", output));
    return cml_checkpoint_path(name, path, err);
}

cml_status cml_twin_create(const struct cml_options *options, const struct cml_run_setup *setup,
                           struct cml_twin *twin, struct cml_error *err)
{
    struct cml_surface_options planes = options->surface;
    planes.force = CML_SURFACE_PLANE;
    CML_TRY(flatten(setup->scene, &twin->scene, err));
    CML_TRY(cml_surfaces_create(&twin->scene, &planes, &twin->surfaces, err));
    CML_TRY(cml_text_format(&twin->identity, "a name", err, "%sflat twin\n", setup->identity));
    if (setup->checkpoint) CML_TRY(checkpoint_path(options, setup->scene, &twin->checkpoint, err));
    return cml_cluster_rank() == 0 ? solve(setup, twin, err) : CML_OK;
}

void cml_twin_clear(struct cml_twin *twin)
{
    cml_surfaces_free(&twin->surfaces);
    free(twin->scene.boundaries);
    free(twin->checkpoint);
    free(twin->identity);
    *twin = (struct cml_twin){0};
}

cml_status cml_twin_fly(const struct cml_twin *twin, const struct cml_run_setup *setup,
                        const struct cml_result *result, struct cml_run_result *flight,
                        struct cml_controlled *control, struct cml_error *err)
{
    struct cml_run_setup flat = *setup;
    *flight = (struct cml_run_result){0};
    flat.scene = &twin->scene;
    flat.surfaces = &twin->surfaces;
    flat.options.start_as = setup->surfaces;
    flat.options.absorption = false;
    flat.options.tail = NULL;
    flat.photons = result->photons;
    flat.target_error = 0;
    flat.checkpoint = twin->checkpoint;
    flat.identity = twin->identity;
    flat.controlled = false;
    flat.gone = NULL;
    flat.base = 0; /* nobody has kept its tallies: all photons fly */
    CML_TRY(cml_cluster_share(&flat.photons, sizeof flat.photons, err)); /* other ranks' results are empty */
    CML_TRY(cml_run(&flat, flight, err));
    for (int t = 0; cml_cluster_rank() == 0 && t < CML_NUM_TOTALS; t++)
        control[t] = cml_control_total(result, &flight->result, (enum cml_total)t, &twin->known[t]);
    return CML_OK;
}
