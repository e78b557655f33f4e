/* SPDX-License-Identifier: MIT */
#include "cli/run/aim.h"

#include "cli/load/scenes.h"
#include "exact/importance.h"
#include "exact/tail_response.h"
#include "scene/phase.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Whatever is not flat, and where light starts: the deepest point, and the first layer that may be flat below
 * it. */
struct floor {
    int layer;
    double depth;
};

static void sink(struct floor *floor, int layer, double depth)
{
    floor->layer = layer > floor->layer ? layer : floor->layer;
    floor->depth = fmax(floor->depth, depth);
}

/* Parallel light may start below a clear first layer (P1). */
static struct floor find_floor(const struct cml_scene *scene, const struct cml_surface_set *surfaces)
{
    struct floor floor = {1, surfaces->item[0].depth};
    for (int b = 0; b < surfaces->count; b++)
        if (surfaces->item[b].kind != CML_SURFACE_PLANE)
            sink(&floor, b + 1, surfaces->item[b].depth + surfaces->item[b].highest);
    for (int k = 0; k < surfaces->bodies.count; k++)
        sink(&floor, 1, surfaces->bodies.item[k].depth + surfaces->bodies.item[k].upper[2]);
    for (int k = 0; k < scene->num_beams; k++)
        if (scene->beams[k].inside) sink(&floor, 1, scene->beams[k].z + cml_beam_height(&scene->beams[k]));
    if (scene->media[1].mua + scene->media[1].mus == 0) sink(&floor, 2, surfaces->item[1].depth);
    return floor;
}

/* In the first layer that goes on below the floor, a sixteenth of a mean free path, or of what is left of it,
 * down: so that no rounding puts a packet beyond the level that has just come through a shape. */
struct cml_aim_level cml_aim_level_of(const struct cml_scene *scene, const struct cml_surface_set *surfaces)
{
    const struct floor floor = find_floor(scene, surfaces);
    if (scene->backing.kind != CML_NO_BACKING)
        return (struct cml_aim_level){.why = "a backing lies below all layers"};
    for (int l = floor.layer; l <= scene->num_layers; l++) {
        const double top = surfaces->item[l - 1].depth, from = fmax(top, floor.depth),
                     rest = surfaces->item[l].depth - from, mut = scene->media[l].mua + scene->media[l].mus;
        if (!(rest > 1e-4 * (surfaces->item[l].depth - top))) continue;
        const double z = from - top + fmin(rest, mut > 0 ? 1 / mut : rest) / 16;
        return (struct cml_aim_level){.layer = l, .z = z, .depth = top + z};
    }
    return (struct cml_aim_level){.why = "shapes, bodies or beams reach down to the last boundary"};
}

/* A packet's counted Tt has the relative variance V; an expected one, 1 / share or less where that share of
 * the light comes down to the level: a third to a seventh of that, in four scenes that were flown both ways.
 */
double cml_aim_proposal(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                        const struct cml_result *result)
{
    const struct cml_aim_level level = cml_aim_level_of(scene, surfaces);
    if (level.layer == 0) return NAN;
    const double relative = cml_result_relative_error(result, CML_TOTAL_TRANSMITTED),
                 d = surfaces->item[level.layer].depth - surfaces->item[level.layer - 1].depth;
    double share = cml_result_total(result, CML_TOTAL_TRANSMITTED) +
                   (1 - level.z / d) * cml_result_absorbed(result, level.layer);
    for (int l = level.layer + 1; l <= scene->num_layers; l++) share += cml_result_absorbed(result, l);
    return share > 0 && relative * relative * (double)result->photons * share > 1 ? level.depth : NAN;
}

static cml_status refuse(const struct cml_scene *scene, const char *aim, int length, const char *expected,
                         struct cml_error *err)
{
    return cml_fail(err, CML_E_INPUT, "%s:%d: --aim %.*s (expected %s)", scene->file, scene->line, length,
                    aim, expected);
}

/* What names ask for: expected values, and windows for light that comes out of so many layers. */
struct wanted {
    bool tail;
    int layers;
};

/* Of one of the names that the option's reader has let pass: what the tail does not reach is for windows. */
static cml_status add_name(const char *name, const struct cml_scene *scene, int level, struct wanted *wanted,
                           struct cml_error *err)
{
    const int length = (int)strcspn(name, ","), last = scene->num_layers,
              layer = name[0] == 'A' ? atoi(name + strlen("A_l:")) : last + 1;
    const bool reached = level > 0 && layer > level && strncmp(name, "Tt_r", 4) != 0;
    char expected[64];
    snprintf(expected, sizeof expected,
             last > 2   ? "a layer from 2 to %d, with others above it"
             : last > 1 ? "layer 2, with another above it"
                        : "Tt: there is one layer",
             last);
    if (name[0] == 'A' && (layer < 2 || layer > last)) return refuse(scene, name, length, expected, err);
    if (reached)
        wanted->tail = true;
    else if (layer - 1 > wanted->layers)
        wanted->layers = layer - 1;
    return CML_OK;
}

/* Squares of packets are no squares of families, and a part of a packet is not to be told from others by its
 * photon. */
static bool wants_packets(const struct cml_scene *scene)
{
    for (int k = 0; k < scene->num_detectors; k++)
        if (scene->detectors[k].kind == CML_DETECTOR_MAP) return true;
    return scene->map.nx > 0 || scene->facets || scene->directions.nt > 0 || scene->saved.limit > 0;
}

static double mean_of(const struct cml_medium_def *medium)
{
    return medium->phase ? cml_phase_mean(medium->phase) : medium->g;
}

/* Where light that goes down from z has forgotten where it came from: after a transport mean free path. */
static double start_of(const struct cml_medium_def *media, int layers, double z)
{
    double left = 1, top = 0;
    for (int l = 1; l <= layers; top += media[l++].d) {
        const double from = fmax(top, z), rest = top + media[l].d - from,
                     mutr = media[l].mua + media[l].mus * (1 - mean_of(&media[l]));
        if (rest > 0 && mutr * rest >= left) return from + left / mutr;
        left -= fmax(rest, 0) * mutr;
    }
    return top;
}

/* Of the beam whose light is worth most. */
static double worth_of_light(const struct cml_scene *scene, const struct cml_medium_def *media, int layers,
                             double depth, const double *importance)
{
    double most = 0;
    for (int k = 0; k < scene->num_beams; k++) {
        const struct cml_beam *beam = &scene->beams[k];
        const double z = beam->inside ? beam->z : start_of(media, layers, 0),
                     at = z / depth * CML_WINDOW_CELLS;
        most = fmax(most, importance[(int)fmax(0, fmin(at, CML_WINDOW_CELLS - 1))]);
    }
    return most;
}

/* Where much light arrives windows gain little, and what is reflected pays for them. */
static double power_of(double worth)
{
    return worth > 1e-2 ? 0.5 : 0.9;
}

#define LEAST_WORTH 1e-20

static cml_status make_windows(const char *aim, const struct cml_scene *scene,
                               const struct cml_medium_def *media, int layers,
                               struct cml_depth_windows *windows, struct cml_error *err)
{
    double importance[CML_WINDOW_CELLS], depth = 0;
    if (wants_packets(scene))
        return refuse(scene, aim, (int)strlen(aim),
                      "no map, facets, directions, photons and maps of detectors beside what splits packets",
                      err);
    for (int l = 1; l <= layers; l++) depth += media[l].d;
    CML_TRY(cml_importance_of_depth(media, layers, CML_WINDOW_CELLS, importance, err));
    const double worth = worth_of_light(scene, media, layers, depth, importance);
    if (!(worth > LEAST_WORTH && worth < INFINITY))
        return refuse(scene, aim, (int)strlen(aim), "light that gets there", err);
    CML_TRY(
        cml_depth_windows_create(importance, CML_WINDOW_CELLS, depth, worth, power_of(worth), windows, err));
    windows->layers = layers;
    windows->worth = worth;
    return CML_OK;
}

/* media: of the flat twin. tail: it is wanted, too, which takes longest, and which no scene is refused for
 * but by its numbers. */
static cml_status create(const char *aim, const struct cml_scene *scene,
                         const struct cml_surface_set *surfaces, const struct cml_medium_def *media,
                         bool tail, struct cml_aim *to, struct cml_error *err)
{
    const struct cml_aim_level level = cml_aim_level_of(scene, surfaces);
    struct wanted wanted = {false, 0};
    if (scene->backing.kind != CML_NO_BACKING) return refuse(scene, aim, (int)strlen(aim), "no backing", err);
    for (const char *name = aim; *name; name += strcspn(name, ",") + (name[strcspn(name, ",")] == ','))
        CML_TRY(add_name(name, scene, level.layer, &wanted, err));
    if (wanted.layers > 0) CML_TRY(make_windows(aim, scene, media, wanted.layers, &to->windows, err));
    return wanted.tail && tail
               ? cml_tail_create(media, scene->num_layers, level.layer, level.z, &to->tail, err)
               : CML_OK;
}

static cml_status create_of(const char *aim, const struct cml_scene *scene,
                            const struct cml_surface_set *surfaces, bool tail, struct cml_aim *to,
                            struct cml_error *err)
{
    const size_t count = (size_t)scene->num_layers + 2;
    struct cml_medium_def *media = malloc(count * sizeof *media);
    *to = (struct cml_aim){0};
    if (!media) return cml_fail_memory(err, (double)(count * sizeof *media), "layers");
    memcpy(media, scene->media, count * sizeof *media);
    for (int l = 1; l <= scene->num_layers; l++)
        media[l].d = surfaces->item[l].depth - surfaces->item[l - 1].depth;
    const cml_status status = create(aim, scene, surfaces, media, tail, to, err);
    free(media);
    if (status != CML_OK) cml_aim_clear(to);
    return status;
}

cml_status cml_aim_create(const char *aim, const struct cml_scene *scene,
                          const struct cml_surface_set *surfaces, struct cml_aim *to, struct cml_error *err)
{
    return create_of(aim, scene, surfaces, true, to, err);
}

/* Without adding-doubling's answer nothing flies, so it is the scene that is refused. */
static cml_status create_for(const struct cml_options *options, const struct cml_scene *scene,
                             const struct cml_surface_set *surfaces, bool tail, struct cml_aim *to,
                             struct cml_error *err)
{
    *to = (struct cml_aim){0};
    const cml_status status = options->aim ? create_of(options->aim, scene, surfaces, tail, to, err) : CML_OK;
    if (status == CML_E_NUMERIC) {
        const struct cml_error why = *err;
        return cml_fail(err, CML_E_INPUT, "%s:%d: --aim %s: %.400s", scene->file, scene->line, options->aim,
                        why.text);
    }
    if (to->windows.cells == 0 || !(options->control || options->engine_options.derivatives)) return status;
    cml_aim_clear(to);
    return cml_fail(err, CML_E_INPUT, "--%s (expected no --aim beside it that splits packets)",
                    options->control ? "control flat" : "derivatives");
}

cml_status cml_aim_for_run(const struct cml_options *options, const struct cml_scene *scene,
                           const struct cml_surface_set *surfaces, struct cml_aim *to, struct cml_error *err)
{
    return create_for(options, scene, surfaces, true, to, err);
}

cml_status cml_aim_check(const struct cml_options *options, const struct cml_scene *scene,
                         const struct cml_surface_set *known, struct cml_error *err)
{
    struct cml_options mine = *options;
    struct cml_surface_set surfaces;
    struct cml_aim aim;
    if (!options->aim) return CML_OK;
    mine.surface.known = known;
    CML_TRY(cml_choose_surfaces(&mine, scene, &surfaces, err));
    const cml_status status = create_for(options, scene, &surfaces, false, &aim, err);
    cml_surfaces_free(&surfaces);
    if (status == CML_OK) cml_aim_clear(&aim);
    return status;
}

void cml_aim_clear(struct cml_aim *aim)
{
    cml_flat_tail_clear(&aim->tail);
    cml_depth_windows_clear(&aim->windows);
}

double cml_windows_gain(double worth)
{
    const double V = 0.008 / worth, least = 7.4; /* below that the rule turns */
    if (!(worth < 5e-3 && worth > 0)) return 0;
    return V > least ? V / pow(log(V), 2) : 2;
}
