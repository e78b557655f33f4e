/* Finds the level below which a scene is flat, and judges if --aim would pay there. SPDX-License-Identifier:
 * MIT */
#include "aim/level.h"

#include <math.h>

/* The lowest extent of everything that is not flat, including places where light starts: its depth in cm, and
 * the first layer that may be flat below it. */
struct floor {
    int layer;
    double depth;
};

/* Lowers the floor to include a part that reaches down to `depth`, cm; layers above `layer` are not flat
 * then. */
static void lower_floor(struct floor *floor, int layer, double depth)
{
    floor->layer = layer > floor->layer ? layer : floor->layer;
    floor->depth = fmax(floor->depth, depth);
}

/* Returns the depth below which a scene is flat, and the layer there. Parallel light may start below a clear
 * first layer (P1), so a clear first layer lies above that depth. */
static struct floor find_floor(const struct cml_scene *scene, const struct cml_surface_set *surfaces)
{
    struct floor floor = {1, surfaces->item[0].depth};
    for (int b = 0; b < surfaces->count; b++)
        if (surfaces->item[b].kind != CML_SURFACE_PLANE || cml_is_rough(&surfaces->item[b].rough))
            lower_floor(&floor, b + 1, surfaces->item[b].depth + surfaces->item[b].highest);
    for (int k = 0; k < surfaces->bodies.count; k++)
        lower_floor(&floor, 1, surfaces->bodies.item[k].depth + surfaces->bodies.item[k].upper[2]);
    for (int k = 0; k < scene->num_beams; k++)
        if (scene->beams[k].inside)
            lower_floor(&floor, 1, scene->beams[k].z + cml_beam_height(&scene->beams[k]));
    if (cml_medium_mut(&scene->media[1]) == 0) lower_floor(&floor, 2, surfaces->item[1].depth);
    return floor;
}

/* The level lies below the floor by a sixteenth of a mean free path, or of the rest of the layer if the rest
 * is thinner. This distance keeps rounding from putting a packet beyond the level when the packet has just
 * passed a shape. */
struct cml_aim_level cml_aim_level_of(const struct cml_scene *scene, const struct cml_surface_set *surfaces)
{
    const struct floor floor = find_floor(scene, surfaces);
    if (scene->backing.kind != CML_BACKING_NONE) return (struct cml_aim_level){0};
    for (int l = floor.layer; l <= scene->num_layers; l++) {
        const double top = surfaces->item[l - 1].depth, from = fmax(top, floor.depth),
                     rest = surfaces->item[l].depth - from, mut = cml_medium_mut(&scene->media[l]);
        if (!(rest > 1e-4 * (surfaces->item[l].depth - top))) continue;
        const double z = from - top + fmin(rest, mut > 0 ? 1 / mut : rest) / 16;
        return (struct cml_aim_level){.layer = l, .z = z, .depth = top + z};
    }
    return (struct cml_aim_level){0};
}

/* Counting exits gives Tt a relative variance V per packet. Expected values give 1 / share or less, where
 * `share` is the share of the light that reaches the level. In four scenes simulated both ways they gave a
 * third to a seventh of 1 / share. */
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
