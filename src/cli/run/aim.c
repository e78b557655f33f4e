/* SPDX-License-Identifier: MIT */
#include "cli/run/aim.h"

#include "exact/tail_response.h"

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

/* Each of the names that the option's reader has let pass. */
static cml_status check_names(const char *aim, const struct cml_scene *scene, int layer,
                              struct cml_error *err)
{
    char expected[128];
    snprintf(expected, sizeof expected, "a layer from %d to %d, below the level of what is not flat",
             layer + 1, scene->num_layers);
    if (layer == scene->num_layers)
        snprintf(expected, sizeof expected, "Tt: what is not flat reaches into the last layer");
    for (const char *name = aim; *name; name += strcspn(name, ",") + (name[strcspn(name, ",")] == ',')) {
        const int length = (int)strcspn(name, ","), number = name[0] == 'A' ? atoi(name + strlen("A_l:")) : 0;
        if (name[0] == 'A' && (number <= layer || number > scene->num_layers))
            return refuse(scene, name, length, expected, err);
    }
    return CML_OK;
}

cml_status cml_aim_create(const char *aim, const struct cml_scene *scene,
                          const struct cml_surface_set *surfaces, struct cml_flat_tail *tail,
                          struct cml_error *err)
{
    const struct cml_aim_level level = cml_aim_level_of(scene, surfaces);
    char expected[128];
    snprintf(expected, sizeof expected, "flat layers below all else, but %s", level.why ? level.why : "");
    if (level.layer == 0) return refuse(scene, aim, (int)strlen(aim), expected, err);
    CML_TRY(check_names(aim, scene, level.layer, err));
    const size_t count = (size_t)scene->num_layers + 2;
    struct cml_medium_def *media = malloc(count * sizeof *media);
    if (!media) return cml_fail_memory(err, (double)(count * sizeof *media), "layers");
    memcpy(media, scene->media, count * sizeof *media);
    for (int l = 1; l <= scene->num_layers; l++)
        media[l].d = surfaces->item[l].depth - surfaces->item[l - 1].depth;
    const cml_status status = cml_tail_create(media, scene->num_layers, level.layer, level.z, tail, err);
    free(media);
    return status;
}
