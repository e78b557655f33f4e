/* Code, included by terminated_packets_inl.h alone, which says why it is no .c file: light that has left into
 * what detectors have seen (P13). SPDX-License-Identifier: MIT */
#ifndef CML_DETECTED_LIGHT_INL_H
#define CML_DETECTED_LIGHT_INL_H

#include "detector.h"
#include "tally/tally.h"
#include "walk.h"

/* Where light goes out, how much of it, and in which gate. */
struct cml_light_out {
    struct cml_ray_out ray;
    cml_u32 w;
    uint64_t times; /* packets that go out so */
    int gate;
    const struct cml_trail *trail; /* of the packet; NULL: it went straight back at the depth 0 */
};

static inline uint64_t cml_square_of(uint64_t w)
{
    const uint64_t rounded = (w + (1u << (CML_SQUARE_SHIFT - 1))) >> CML_SQUARE_SHIFT;
    return rounded * rounded;
}

/* Weight times a number in units, into its parts. */
static inline void cml_add_moment(uint64_t *parts, const struct cml_light_out *light, double units)
{
    const uint64_t number =
        (uint64_t)(int64_t)((units < CML_MOMENT_MOST ? units : CML_MOMENT_MOST - 1) + 0.5);
    const cml_u128 product = (cml_u128)light->w * number;
    const uint64_t mask = ((uint64_t)1 << CML_MOMENT_BITS) - 1;
    for (int i = 0; i < CML_MOMENT_CELLS; i++)
        parts[i] += light->times * ((uint64_t)(product >> (i * CML_MOMENT_BITS)) & mask);
}

/* Length and interactions by medium, and the largest depth, into the moments of a detector. */
static inline void cml_add_moments(const struct cml_world *world, const struct cml_light_out *light,
                                   uint64_t *moments)
{
    const struct cml_detection *detection = &world->detection;
    const struct cml_trail *trail = light->trail;
    const size_t media = (size_t)world->setup.num_layers + 2 + (size_t)world->setup.num_bodies;
    const double deepest = (trail ? (double)trail->deepest : 0) - detection->top;
    for (size_t m = 0; trail && m < media; m++) {
        uint64_t *const parts = moments + m * CML_MOMENT_CELLS;
        if (trail->length[m] > 0) cml_add_moment(parts, light, trail->length[m] * detection->per_length);
        if (trail->count[m]) cml_add_moment(parts + media * CML_MOMENT_CELLS, light, trail->count[m]);
    }
    if (deepest > 0)
        cml_add_moment(moments + 2 * media * CML_MOMENT_CELLS, light, deepest * detection->per_length);
}

/* What a packet adds to the squares of a pixel. Where something of it has come there before, both make one
 * sum. */
static inline uint64_t cml_square_in_pixel(const struct cml_world *world, const struct cml_detector *detector,
                                           real z, cml_u64 pixel, cml_u32 w,
                                           const struct cml_light_out *before)
{
    const struct cml_setup *setup = &world->setup;
    real x, y;
    cml_u64 other;
    if (!before || !cml_crosses_level(&before->ray, z, &x, &y) ||
        !cml_detects(detector, &before->ray, x + setup->x0, y + setup->y0, &other) || other != pixel)
        return cml_square_of(w);
    return cml_square_of((uint64_t)w + before->w) - cml_square_of(before->w);
}

/* Light into all detectors that see it. before: other light of the same packet, which has been scored, or
 * NULL. sums: where `detected` begins in a tally, or in profiles; pixels: whose maps are scored, too, or
 * NULL. Returns the number of the first detector that sees it, from 1; 0: none does.
 */
static inline int cml_score_light(const struct cml_world *world, const struct cml_light_out *light,
                                  const struct cml_light_out *before, uint64_t *sums,
                                  const struct cml_tally *pixels)
{
    const struct cml_detection *detection = &world->detection;
    const struct cml_setup *setup = &world->setup;
    const size_t gates = (size_t)setup->gates.count;
    const size_t moments =
        CML_MOMENT_CELLS * (2 * ((size_t)setup->num_layers + 2 + (size_t)setup->num_bodies) + 1);
    int seen = 0;
    uint64_t *const sums_t = sums + detection->num_detectors, *const means =
                                                                  sums_t +
                                                                  (gates ? (size_t)detection->num_detectors *
                                                                               (gates + 1)
                                                                         : 0);
    for (int l = 0; l < detection->num_levels; l++) {
        const struct cml_detector_level *level = &detection->levels[l];
        real x, y;
        if (level->below != light->ray.below || !cml_crosses_level(&light->ray, level->z, &x, &y)) continue;
        x += setup->x0;
        y += setup->y0;
        const int cell = cml_detector_cell(level, x, y), at = level->first + cell;
        for (int i = cell < 0 ? 0 : detection->start[at]; cell >= 0 && i < detection->start[at + 1]; i++) {
            const int k = detection->list[i];
            const struct cml_detector *detector = &detection->detectors[k];
            cml_u64 pixel;
            if (!cml_detects(detector, &light->ray, x, y, &pixel)) continue;
            seen = seen && seen <= k ? seen : k + 1;
            sums[k] += light->times * light->w;
            if (gates) sums_t[(size_t)k * (gates + 1) + (size_t)light->gate] += light->times * light->w;
            cml_add_moments(world, light, means + (size_t)k * moments);
            if (!pixels || detector->shape != CML_DETECTS_MAP) continue;
            uint64_t *const to = pixels->detector_map + detector->first_pixel + pixel;
            cml_add_shared(to, light->times * light->w);
            cml_add_shared(to + (pixels->detector_map2 - pixels->detector_map),
                           light->times *
                               cml_square_in_pixel(world, detector, level->z, pixel, light->w, before));
        }
    }
    return seen;
}

/* What is split off packet `index` at its launch (P1); weight 0: nothing, or no detector would see it, or it
 * is a branch. */
static inline struct cml_light_out cml_light_split_off(const struct cml_world *world, cml_u64 index)
{
    const int split = world->detection.split;
    struct cml_light_out light = {.ray = {.u = {0, 0, -1}, .fresh = 1}, .times = 1};
    if (split != CML_SPLIT_UNSEEN && !cml_is_branch(index)) light.w = cml_split_off(world, index);
    if (light.w && split == CML_SPLIT_APART) {
        struct cml_packet start;
        cml_place(world, index, &start);
        light.ray.p = (struct cml_vec){start.p.x, start.p.y, 0};
    }
    return light;
}

/* Adds what is split off `times` packets like packet `index` to the scores of all detectors. */
static inline void cml_score_split_off(const struct cml_world *world, cml_u64 index, uint64_t times,
                                       uint64_t *sums, const struct cml_tally *pixels)
{
    struct cml_light_out light = cml_light_split_off(world, index);
    light.times = times;
    if (light.w) cml_score_light(world, &light, NULL, sums, pixels);
}

#endif
