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
    int gate;
};

static inline uint64_t cml_square_of(uint64_t w)
{
    const uint64_t rounded = (w + (1u << (CML_SQUARE_SHIFT - 1))) >> CML_SQUARE_SHIFT;
    return rounded * rounded;
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
 * NULL.
 */
static inline void cml_score_light(const struct cml_world *world, const struct cml_light_out *light,
                                   const struct cml_light_out *before, uint64_t *sums,
                                   const struct cml_tally *pixels)
{
    const struct cml_detection *detection = &world->detection;
    const struct cml_setup *setup = &world->setup;
    const size_t gates = (size_t)setup->gates.count;
    uint64_t *const sums_t = sums + detection->num_detectors;
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
            sums[k] += light->w;
            if (gates) sums_t[(size_t)k * (gates + 1) + (size_t)light->gate] += light->w;
            if (!pixels || detector->shape != CML_DETECTS_MAP) continue;
            uint64_t *const to = pixels->detector_map + detector->first_pixel + pixel;
            cml_add_shared(to, light->w);
            cml_add_shared(to + (pixels->detector_map2 - pixels->detector_map),
                           cml_square_in_pixel(world, detector, level->z, pixel, light->w, before));
        }
    }
}

#endif
