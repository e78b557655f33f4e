/* SPDX-License-Identifier: MIT */
#include "simulation/aim.h"

#include "aim/windows.h"
#include "base/text.h"
#include "simulation/scenes.h"
#include "exact/tail_response.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The names of an aim, taken together: expected values (tail); windows for light that passes `layers` layers,
 * or that a detector sees. */
struct wanted {
    bool tail;
    /* detector: the last one named, from 1; detectors: how many different ones */
    int layers, detector, detectors;
};

/* Returns the number, from 1, of the detector with this name; 0: none. */
static int find_detector(const struct cml_scene *scene, const char *name, int length)
{
    for (int k = 0; k < scene->num_detectors; k++)
        if ((int)strlen(scene->detectors[k].name) == length &&
            strncmp(scene->detectors[k].name, name, (size_t)length) == 0)
            return k + 1;
    return 0;
}

/* Adds a detector to the quantities that --aim names. name: `length` letters of the option's text. */
static cml_status add_detector(const char *name, int length, const struct cml_scene *scene,
                               struct wanted *wanted, struct cml_error *err)
{
    const int detector = find_detector(scene, name, length);
    if (detector == 0)
        return cml_aim_refuse(scene, name, length, "Tt, Tt_r, A_l:N of layer N or the name of a detector",
                              err);
    wanted->detectors += detector != wanted->detector;
    wanted->detector = detector;
    return CML_OK;
}

/* Adds a layer in which, or above which, light is wanted. reached: the tail gives its expected value;
 * otherwise windows are needed. */
static void add_layer(int layer, bool reached, struct wanted *wanted)
{
    if (reached)
        wanted->tail = true;
    else if (layer - 1 > wanted->layers)
        wanted->layers = layer - 1;
}

/* Adds the absorption of the layer in "A_l:N" to the quantities that --aim names. Layer 1 is refused,
 * because packets reach the first layer anyway. level: all layers below layer `level` are flat, 0 if
 * unknown. */
static cml_status add_absorption(const char *name, int length, const struct cml_scene *scene, int level,
                                 struct wanted *wanted, struct cml_error *err)
{
    const int last = scene->num_layers, layer = atoi(name + strlen("A_l:"));
    if (layer < 2 || layer > last)
        return cml_aim_refuse(scene, name, length,
                              last > 2   ? CML_TEXT("a layer from 2 to %d, with others above it", last)
                              : last > 1 ? "layer 2, with another above it"
                                         : "Tt: there is one layer",
                              err);
    add_layer(layer, level > 0 && layer > level, wanted);
    return CML_OK;
}

/* Adds one of the names that the reader of the option has accepted. */
static cml_status add_name(const char *name, const struct cml_scene *scene, int level, struct wanted *wanted,
                           struct cml_error *err)
{
    const int length = (int)strcspn(name, ",");
    if (strncmp(name, "A_l:", 4) == 0) return add_absorption(name, length, scene, level, wanted, err);
    if (!(length == 2 && strncmp(name, "Tt", 2) == 0) && !(length == 4 && strncmp(name, "Tt_r", 4) == 0))
        return add_detector(name, length, scene, wanted, err);
    if (find_detector(scene, name, length))
        return cml_aim_refuse(scene, name, length,
                              "another name for the detector: Tt and Tt_r mean light that leaves below", err);
    add_layer(scene->num_layers + 1, length == 2 && level > 0, wanted);
    return CML_OK;
}

/* True if the scene asks for results that parts of packets would spoil: errors from squares per packet, and
 * saved packets, which are known by their photon alone. */
static bool wants_packets(const struct cml_scene *scene)
{
    for (int k = 0; k < scene->num_detectors; k++)
        if (scene->detectors[k].shape == CML_DETECTOR_MAP) return true;
    return scene->map.nx > 0 || scene->facets || scene->directions.nt > 0 || scene->saved.limit > 0;
}

/* Makes the weight windows of an aim, for one detector or for light below some layers. Windows split
 * packets, so results that need whole packets are refused. */
static cml_status aim_windows(const char *aim, const struct cml_scene *scene,
                              const struct cml_surface_set *surfaces, const struct cml_medium_def *media,
                              struct wanted wanted, struct cml_window_table *windows, struct cml_error *err)
{
    const int length = (int)strlen(aim);
    if (wants_packets(scene))
        return cml_aim_refuse(
            scene, aim, length,
            "no line map, facets, directions, photons or detector map: this aim splits packets", err);
    if (wanted.detectors > 1 || (wanted.detectors > 0 && wanted.layers > 0))
        return cml_aim_refuse(scene, aim, length,
                              "one detector, and beside it only Tt and A_l:N of flat layers below all shapes",
                              err);
    return wanted.detectors > 0 ? cml_windows_at(aim, scene, surfaces, media, wanted.detector, windows, err)
                                : cml_windows_below(aim, scene, media, wanted.layers, windows, err);
}

/* Returns the next of the names, which commas separate. */
static const char *after(const char *name)
{
    name += strcspn(name, ",");
    return name + (*name == ',');
}

/* Refuses a name whose share of the light is too small for the tail's numbers. */
static cml_status check_worth(const char *name, const struct cml_scene *scene, int level,
                              const struct cml_flat_tail *tail, struct cml_error *err)
{
    const int length = (int)strcspn(name, ","), layer = strncmp(name, "A_l:", 4) == 0 ? atoi(name + 4) : 0;
    const int score = layer ? layer - level : length == 2 && strncmp(name, "Tt", 2) == 0 ? 0 : -1;
    if (score < (layer ? 1 : 0) || cml_flat_tail_has(tail, score)) return CML_OK;
    return cml_aim_refuse(scene, name, length,
                          CML_TEXT("an aim that at least %g of the light reaches", CML_TAIL_LEAST), err);
}

/* Makes what an aim needs: weight windows, and a table of the flat tail if `tail` (takes longest). All names
 * in `aim` are checked in any case. media: those of the flat scene. */
static cml_status create(const char *aim, const struct cml_scene *scene,
                         const struct cml_surface_set *surfaces, const struct cml_medium_def *media,
                         bool tail, struct cml_aim *to, struct cml_error *err)
{
    const struct cml_aim_level level = cml_aim_level_of(scene, surfaces);
    struct wanted wanted = {0};
    if (scene->backing.kind != CML_BACKING_NONE)
        return cml_aim_refuse(scene, aim, (int)strlen(aim), "no backing", err);
    for (const char *name = aim; *name; name = after(name))
        CML_TRY(add_name(name, scene, level.layer, &wanted, err));
    if (wanted.layers > 0 || wanted.detectors > 0)
        CML_TRY(aim_windows(aim, scene, surfaces, media, wanted, &to->windows, err));
    if (!(wanted.tail && tail)) return CML_OK;
    CML_TRY(cml_tail_create(media, scene->num_layers, level.layer, level.z, &to->tail, err));
    for (const char *name = aim; *name; name = after(name))
        CML_TRY(check_worth(name, scene, level.layer, &to->tail, err));
    return CML_OK;
}

/* Layers are taken as thick as they are between the mean depths of their surfaces. */
cml_status cml_aim_create(const char *aim, const struct cml_scene *scene,
                          const struct cml_surface_set *surfaces, bool tail, struct cml_aim *to,
                          struct cml_error *err)
{
    const size_t count = (size_t)scene->num_layers + 2;
    CML_FREED struct cml_medium_def *media = NULL;
    *to = (struct cml_aim){0};
    CML_TRY(cml_zeros(&media, count, sizeof *media, "layers", err));
    memcpy(media, scene->media, count * sizeof *media);
    for (int l = 1; l <= scene->num_layers; l++)
        media[l].d = surfaces->item[l].depth - surfaces->item[l - 1].depth;
    const cml_status status = create(aim, scene, surfaces, media, tail, to, err);
    if (status != CML_OK) cml_aim_clear(to);
    return status;
}

cml_status cml_aim_for_run(const struct cml_options *options, const struct cml_scene *scene,
                           const struct cml_surface_set *surfaces, bool tail, struct cml_aim *to,
                           struct cml_error *err)
{
    *to = (struct cml_aim){0};
    const cml_status status =
        options->aim ? cml_aim_create(options->aim, scene, surfaces, tail, to, err) : CML_OK;
    if (status == CML_E_NUMERIC) {
        const struct cml_error why = *err;
        return cml_fail(err, CML_E_INPUT, "%s:%d: --aim %s: %.400s", scene->file, scene->line, options->aim,
                        why.text);
    }
    if (to->windows.cells == 0 || !options->engine_options.derivatives) return status;
    cml_aim_clear(to);
    return cml_fail(err, CML_E_INPUT, "--derivatives (expected no --aim beside it that splits packets)");
}

void cml_aim_use(const struct cml_aim *aim, struct cml_engine_options *options)
{
    if (aim->tail.scores > 0) options->tail = &aim->tail;
    if (aim->windows.cells > 0) options->windows = &aim->windows;
}

/* Finds the number for what --error-of names: a layer as its number, a detector as its negative number
 * counted from 1. 0 without the option. */
cml_status cml_find_error_of(const struct cml_options *options, const struct cml_scene *scene, int *of,
                             struct cml_error *err)
{
    const char *name = options->error_of;
    *of = 0;
    if (!name) return CML_OK;
    *of = strncmp(name, "A_l:", 4) == 0 ? atoi(name + 4) : -find_detector(scene, name, (int)strlen(name));
    if (*of != 0 && *of <= scene->num_layers) return CML_OK;
    return cml_fail(err, CML_E_INPUT,
                    "%s:%d: --error-of %s (expected A_l:N of layer 1 to %d, or the name of a detector)",
                    scene->file, scene->line, name, scene->num_layers);
}

cml_status cml_aim_check(const struct cml_options *options, const struct cml_scene *scene,
                         const struct cml_surface_set *shared, struct cml_error *err)
{
    struct cml_options mine = *options;
    CML_AT_END(cml_surfaces_free) struct cml_surface_set surfaces = {0};
    CML_AT_END(cml_aim_clear) struct cml_aim aim = {0};
    if (!options->aim) return CML_OK;
    mine.surface.shared = shared;
    CML_TRY(cml_choose_surfaces(&mine, scene, &surfaces, err));
    return cml_aim_for_run(options, scene, &surfaces, false, &aim, err);
}

void cml_aim_clear(struct cml_aim *aim)
{
    cml_flat_tail_clear(&aim->tail);
    cml_window_table_clear(&aim->windows);
}

/* True if --aim at detector k would make its error smaller in the same time. An aim that is refused gains
 * nothing. */
static bool would_gain(const struct cml_scene *scene, const struct cml_surface_set *surfaces, int k)
{
    struct cml_error refusal;
    CML_AT_END(cml_aim_clear) struct cml_aim aim = {0};
    if (cml_aim_create(scene->detectors[k].name, scene, surfaces, true, &aim, &refusal) != CML_OK)
        return false;
    return aim.windows.detector && aim.windows.gain > 0;
}

int cml_aim_unseen(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                   const struct cml_result *result)
{
    const int detectors = scene->num_detectors;
    for (int k = 0; k < detectors; k++)
        if (cml_result_bin_sum(result->detector, detectors, k) == 0)
            return would_gain(scene, surfaces, k) ? k + 1 : 0;
    return 0;
}
