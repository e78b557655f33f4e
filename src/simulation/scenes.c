/* SPDX-License-Identifier: MIT */
#include "simulation/scenes.h"

#include "engine/engines.h"
#include "engine/plane_trial.h"
#include "run/cluster/cluster.h"
#include "input/mci.h"
#include "output/report.h"
#include "scene/body/body_place.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Checks the shapes of all scenes, just as they will be flown. */
static cml_status check_all(const struct cml_scene_list *list, struct cml_error *err)
{
    for (int i = 0; i < list->count; i++) CML_TRY(cml_scene_check_shapes(&list->scenes[i], err));
    return CML_OK;
}

_Thread_local struct cml_note_receiver cml_notes;

void cml_show_note(void *context, const char *text)
{
    (void)context;
    if (cml_notes.to) cml_notes.to(cml_notes.context, text);
}

void cml_note(const char *format, ...)
{
    char text[1400];
    va_list values;
    va_start(values, format);
    vsnprintf(text, sizeof text, format, values);
    va_end(values);
    cml_show_note(NULL, text);
}

/* Shows a note of the reader on rank 0 only, because all ranks read the same files. */
static void note_input(void *context, const char *text)
{
    if (cml_cluster_rank() == 0) cml_show_note(context, text);
}

/* True if the options make planes of all boundaries. */
static bool is_flat(const struct cml_options *options)
{
    return options->ignore_heightfields || options->surface.force == CML_SURFACE_PLANE;
}

/* Refuses a setting of photons beside --photons: one of them would be ignored. */
static cml_status check_photons(const struct cml_options *options, const struct cml_settings *settings,
                                struct cml_error *err)
{
    const struct cml_setting *photons = cml_settings_find(settings, "photons");
    if (!photons || options->photons == 0) return CML_OK;
    return cml_setting_fail(photons, "no value beside that of --photons", err);
}

cml_status cml_load_scenes(const struct cml_options *options, const struct cml_text_source *source,
                           struct cml_scene_list *list, struct cml_error *err)
{
    const struct cml_input_options how = {.source = source,
                                          .tolerance = options->surface.tolerance,
                                          .budget = options->surface.budget,
                                          .settings = &options->settings,
                                          .output =
                                              options->which == CML_COMMAND_RUN ? options->output : NULL,
                                          .on_note = note_input,
                                          .flat = is_flat(options)};
    CML_TRY(check_photons(options, &options->settings, err));
    CML_TRY(cml_mci_read(options->operands[0], &how, list, err));
    const cml_status status = check_all(list, err);
    if (status != CML_OK) cml_scene_list_clear(list);
    return status;
}

/* True if all boundaries have the same shape and depth, so that those found not to cross still do not. */
static bool lies_alike(const struct cml_scene *one, const struct cml_scene *other)
{
    for (int b = 0; b <= one->num_layers; b++)
        if (one->boundaries[b].z != other->boundaries[b].z ||
            !cml_boundary_same_shape(&one->boundaries[b], &other->boundaries[b]))
            return false;
    return true;
}

cml_status cml_copy_scene(const struct cml_options *options, const struct cml_settings *settings,
                          const char *output, struct cml_inputs *inputs, const struct cml_scene *from,
                          struct cml_scene *scene, struct cml_error *err)
{
    const struct cml_text_source replay = cml_inputs_replayer(inputs);
    const struct cml_input_options how = {.source = &replay,
                                          .tolerance = options->surface.tolerance,
                                          .budget = options->surface.budget,
                                          .settings = settings,
                                          .output = output,
                                          .flat = is_flat(options)};
    CML_TRY(check_photons(options, settings, err));
    CML_TRY(cml_mci_copy(from, &how, scene, err));
    const cml_status status = lies_alike(scene, from) ? CML_OK : cml_scene_check_shapes(scene, err);
    if (status != CML_OK) cml_scene_clear(scene);
    return status;
}

cml_status cml_choose_surfaces(const struct cml_options *options, const struct cml_scene *scene,
                               struct cml_surface_set *surfaces, struct cml_error *err)
{
    CML_TRY(cml_surfaces_create(scene, &options->surface, surfaces, err));
    const cml_status status = cml_make_harmless_planes(scene, &options->surface, cml_engine_find("cpu"),
                                                       &options->engine_options, surfaces, err);
    if (status != CML_OK) cml_surfaces_free(surfaces);
    return status;
}

/* Sets the bytes that this process holds now, and the most it has held. getrusage would also count what the
 * process held that started this one. */
static void find_held(double *now, double *most)
{
    FILE *file = fopen("/proc/self/status", "r"); /* proc(5): sizes in kB */
    char line[256];
    double kibibytes;
    *now = *most = 0;
    while (file && fgets(line, sizeof line, file)) {
        if (sscanf(line, "VmHWM: %lf", &kibibytes) == 1) *most = 1024 * kibibytes;
        if (sscanf(line, "VmRSS: %lf", &kibibytes) == 1) *now = 1024 * kibibytes;
    }
    if (file) fclose(file);
}

/* Returns the most photons of a run. Photons flown before --more are not known here. */
static uint64_t most_photons(const struct cml_options *options, const struct cml_scene *scene)
{
    if (options->target_error > 0) return UINT64_MAX;
    return (options->photons ? options->photons : scene->photons) + options->more;
}

/* Reading, the flight and the writing of results follow each other, and each frees its memory before the next
 * begins. */
struct cml_memory cml_memory_of(const struct cml_options *options, const struct cml_scene *scene,
                                const struct cml_surface_set *surfaces)
{
    struct cml_tally_grid grid = cml_engine_grid(scene, surfaces, &options->engine_options);
    grid.saved.limit = cml_most_saved(scene, most_photons(options, scene));
    const int asked = options->engine_options.threads;
    const int threads = asked > 0 ? asked : options->engine->threads(NULL);
    const double ranks = cml_cluster_local_size(),
                 world = surfaces ? options->engine->bytes(scene, surfaces) : 0;
    const double mib = 1048576;
    double now, so_far;
    find_held(&now, &so_far);
    struct cml_memory memory = {.tallies = cml_run_bytes(&grid, threads) * ranks,
                                .output = cml_report_bytes(scene, &grid)};
    const double flight =
        ranks * (world + mib * (4 + threads)); /* threads' stacks and bundles of packets, libraries */
    /* the kernel does not count the last pages of each thread yet, so they are added to what it reports */
    const double counted = mib * (1 + threads);
    memory.most =
        fmax((so_far + counted) * ranks, now * ranks + memory.tallies + fmax(flight, memory.output));
    return memory;
}

cml_status cml_check_memory(const struct cml_options *options, const struct cml_scene *scene,
                            const struct cml_surface_set *surfaces, struct cml_error *err)
{
    const double bytes = cml_memory_of(options, scene, surfaces).most, gib = 1073741824.0;
    const double most = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    if (bytes < most) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "%s: %s takes %.3g GiB (expected at most this machine's %.3g GiB)",
                    scene->file, scene->output, bytes / gib, most / gib);
}
