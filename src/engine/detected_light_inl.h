/* Code, included by terminated_packets_inl.h, which says why it is no .c file, and by row_weights_inl.h: adds
 * light that has left to the sums of the detectors that see it (P13).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "bins.h"
#include "detector.h"
#include "tally/tally.h"
#include "walk.h"

/* Light that leaves the scene: its line, its weight and its gate. */
struct cml_light_out {
    struct cml_ray_out ray;
    cml_u32 w;
    real lot;       /* 0 to 1: random number by which a share of the weight is rounded */
    uint64_t times; /* number of packets that leave in this way */
    int gate;
    cml_u64 index; /* index of the packet, or of any packet of its group */
    /* Trail of the packet; NULL: the light went straight back at the depth 0. */
    const struct cml_trail *trail;
};

/* Returns the light of weight w that leaves with a finished packet from p in direction u. p: in the frame of
 * the outer medium. */
static inline struct cml_light_out cml_light_of(const struct cml_exit *exit, struct cml_vec p,
                                                struct cml_vec u, cml_u32 w)
{
    return (struct cml_light_out){.ray = {.p = p, .u = u, .below = exit->down, .fresh = exit->fresh},
                                  .w = w,
                                  .times = 1,
                                  .gate = exit->gate};
}

/* Notes the port through which light has left upwards. Light that has touched no boundary has left through
 * none, and light of a port that never came in has stayed in its own. */
static inline void cml_note_port(const struct cml_world *world, cml_u64 index, struct cml_ray_out *ray)
{
    if (!world->contacts.count || ray->below) return;
    const int own = ray->fresh ? cml_source_of(world, index)->port : 0;
    const int number = own ? own : cml_contact_at(world, ray->p.x, ray->p.y);
    const struct cml_contact *contact = cml_contact_of(world, number);
    if (!contact || !contact->is_port) return;
    ray->port = number;
    ray->n = contact->n;
}

/* Returns the optical path of a packet in all media together, cm. */
static inline double cml_trail_path(const struct cml_world *world, const struct cml_trail *trail)
{
    const int media = world->setup.num_layers + 2 + world->setup.num_bodies;
    double path = 0;
    for (int m = 0; m < media; m++) path += (double)world->media[m].n * trail->stay[m].length;
    return path;
}

/* Returns the number of media: layers, outer media and bodies. */
static inline size_t cml_num_media(const struct cml_world *world)
{
    return (size_t)world->setup.num_layers + 2 + (size_t)world->setup.num_bodies;
}

/* Returns a path length or largest depth (cm) in whole units: the factor of a packet's weight in a moment
 * (enum cml_moment). */
static inline uint64_t cml_length_in_units(const struct cml_world *world, double length)
{
    const double units = length * world->detection.per_length;
    return (uint64_t)(int64_t)((units < CML_MOMENT_MOST ? units : CML_MOMENT_MOST - 1) + 0.5);
}

/* Returns the largest depth of a packet below detection.top in whole units; 0 if the packet stayed above
 * this depth. */
static inline uint64_t cml_deepest_in_units(const struct cml_world *world, const struct cml_trail *trail)
{
    const double deepest = (trail ? (double)trail->deepest : 0) - world->detection.top;
    return deepest > 0 ? cml_length_in_units(world, deepest) : 0;
}

/* Adds weight times a number to a moment, which is stored in parts of CML_MOMENT_BITS. */
static inline void cml_add_moment(uint64_t *parts, const struct cml_light_out *light, uint64_t number)
{
    const cml_u128 product = (cml_u128)light->w * number;
    const uint64_t mask = ((uint64_t)1 << CML_MOMENT_BITS) - 1;
    for (int i = 0; i < CML_MOMENT_CELLS; i++)
        parts[i] += light->times * ((uint64_t)(product >> (i * CML_MOMENT_BITS)) & mask);
}

/* Returns the factor of a packet's weight in a moment of a medium, from the packet's stay there. */
static inline uint64_t cml_number_of_moment(const struct cml_world *world, const struct cml_stay *stay,
                                            int moment)
{
    const double momentum = stay->momentum * (1 / CML_MOMENTUM_UNIT) + 0.5;
    switch (moment) {
    case CML_MOMENT_PATH:
        return stay->length > 0 ? cml_length_in_units(world, stay->length) : 0;
    case CML_MOMENT_INTERACTIONS:
        return stay->interactions;
    default:
        return (uint64_t)(momentum < CML_MOMENT_MOST ? momentum : CML_MOMENT_MOST - 1);
    }
}

/* Adds a packet's stays in all media, and its largest depth, to the moments of a detector. */
static inline void cml_add_moments(const struct cml_world *world, const struct cml_light_out *light,
                                   uint64_t *moments)
{
    const struct cml_trail *trail = light->trail;
    const size_t media = cml_num_media(world);
    const uint64_t deepest = cml_deepest_in_units(world, trail);
    for (size_t i = 0; trail && i < CML_MEDIUM_MOMENTS * media; i++) {
        const uint64_t number = cml_number_of_moment(world, &trail->stay[i % media], (int)(i / media));
        if (number) cml_add_moment(moments + i * CML_MOMENT_CELLS, light, number);
    }
    if (deepest) cml_add_moment(moments + CML_MEDIUM_MOMENTS * media * CML_MOMENT_CELLS, light, deepest);
}

/* Returns the amount that light of weight w adds to the sum of squares of a pixel. A packet's light may
 * come in two parts; if the first, `before`, came to the same pixel, the square of the sum of both weights
 * counts, so the square of the first is subtracted. */
static inline uint64_t cml_square_in_pixel(const struct cml_detector *detector, real z, cml_u64 pixel,
                                           cml_u32 w, const struct cml_light_out *before)
{
    real x, y;
    cml_u64 other;
    if (!before || !cml_crosses_level(&before->ray, z, &x, &y) ||
        !cml_detects(detector, &before->ray, x, y, &other) || other != pixel)
        return cml_square_of(w);
    return cml_square_of((uint64_t)w + before->w) - cml_square_of(before->w);
}

/* Returns the bin of a direction (P7). A direction straight up or down has azimuth 0. */
static inline size_t cml_direction_bin(const struct cml_direction_bins *bins, real ux, real uy, real uz)
{
    const real size = CML_FABS(uz), turn = (real)6.283185307179586;
    const real azimuth = ux == 0 && uy == 0 ? (real)0 : (real)atan2((double)uy, (double)ux);
    const int it = (int)(cml_acos(size < 1 ? size : (real)1) * bins->per_dt);
    const int ip = (int)((azimuth < 0 ? azimuth + turn : azimuth) * bins->per_dp);
    return (size_t)(it < bins->nt ? it : bins->nt - 1) * (size_t)bins->np +
           (size_t)(ip < bins->np ? ip : bins->np - 1);
}

/* An iterator over the detectors that see light, level by level. */
struct cml_seeing {
    const struct cml_world *world;
    const struct cml_ray_out *ray;
    int next_level; /* level after the present one */
    int i, end;     /* range of the list that is left: the next entry and the end */
    real x, y, z;   /* place where the light crosses the level, from the origin */
    cml_u64 pixel;  /* pixel of the detector that was found */
};

/* Begins to go over the detectors that see light along a line. */
static inline struct cml_seeing cml_seeing_of(const struct cml_world *world, const struct cml_ray_out *ray)
{
    return (struct cml_seeing){.world = world, .ray = ray};
}

/* Finds the detectors of a level that may see the light: those of the cell where the light crosses the
 * level. */
static inline void cml_see_level(struct cml_seeing *s, const struct cml_detector_level *level)
{
    const struct cml_detection *detection = &s->world->detection;
    if (level->below != s->ray->below || !cml_crosses_level(s->ray, level->z, &s->x, &s->y)) return;
    s->z = level->z;
    const int cell = cml_detector_cell(level, s->x, s->y), at = level->first + cell;
    s->i = cell < 0 ? 0 : detection->start[at];
    s->end = cell < 0 ? 0 : detection->start[at + 1];
}

/* Returns the number of the next detector that sees the light, from 0; -1: no more. */
static inline int cml_next_seeing(struct cml_seeing *s)
{
    const struct cml_detection *detection = &s->world->detection;
    for (;;) {
        while (s->i < s->end) {
            const int k = detection->list[s->i++];
            if (cml_detects(&detection->detectors[k], s->ray, s->x, s->y, &s->pixel)) return k;
        }
        if (s->next_level == detection->num_levels) return -1;
        cml_see_level(s, &detection->levels[s->next_level++]);
    }
}

/* The sums of all detectors: arrays of a tally, or of a row of late profiles. */
struct cml_seen {
    uint64_t *detector, *detector_t, *moments;
};

static inline struct cml_seen cml_seen_by(const struct cml_tally *tally)
{
    return (struct cml_seen){tally->detector, tally->detector_t, tally->moments};
}

/* Adds light to the sums of detector k, but not to its pixels. */
static inline void cml_add_to_detector(const struct cml_world *world, const struct cml_light_out *light,
                                       int k, const struct cml_seen *to)
{
    const size_t gates = (size_t)world->setup.gates.count,
                 moments = CML_MOMENT_CELLS * (CML_MEDIUM_MOMENTS * cml_num_media(world) + 1);
    to->detector[k] += light->times * light->w;
    if (gates) to->detector_t[(size_t)k * (gates + 1) + (size_t)light->gate] += light->times * light->w;
    cml_add_moments(world, light, to->moments + (size_t)k * moments);
}

/* Scores light by a share of a circle (P13): light leaves alike all about the axis, and the detector of the
 * arc counts the share of the circle that it sees. */
static inline void cml_score_arc(const struct cml_world *world, const struct cml_light_out *light,
                                 const struct cml_seen *to)
{
    const struct cml_arc arc = world->detection.arc;
    const struct cml_detector *detector = &world->detection.detectors[arc.detector - 1];
    const struct cml_detector_level *level = &world->detection.levels[arc.level];
    struct cml_light_out part = *light;
    real x, y;
    if (level->below != light->ray.below || !cml_crosses_level(&light->ray, level->z, &x, &y)) return;
    x -= world->sources->middle.x;
    y -= world->sources->middle.y;
    if ((detector->diffuse && light->ray.fresh) ||
        (detector->aimed && !cml_is_in_cone(detector, &light->ray)))
        return;
    part.w = (cml_u32)CML_FMA((real)light->w, cml_arc_share(arc, CML_SQRT(CML_FMA(x, x, y * y))), light->lot);
    if (part.w) cml_add_to_detector(world, &part, arc.detector - 1, to);
}

/* Adds light to the pixel of a detector that sees it. */
static inline void cml_add_to_pixel(const struct cml_light_out *light, const struct cml_light_out *before,
                                    const struct cml_seeing *seeing, const struct cml_detector *detector,
                                    const struct cml_tally *to)
{
    const struct cml_once once = to->grid.pixel_once;
    uint64_t *const cell = to->detector_map + detector->first_pixel + seeing->pixel;
    cml_add_shared(cell + light->index % CML_NUM_GROUPS * once.step, light->times * light->w);
    if (once.step) return;
    cml_add_shared(cell + once.squares,
                   light->times * cml_square_in_pixel(detector, seeing->z, seeing->pixel, light->w, before));
}

/* Adds light to all detectors that see it. before: other light of the same packet, which has been scored, or
 * NULL. to: the sums of all detectors. pixels: the tally whose detector maps
 * are scored too, or NULL. Returns the number of the first detector that sees the light, from 1; 0: none
 * does. */
static inline int cml_score_light(const struct cml_world *world, const struct cml_light_out *light,
                                  const struct cml_light_out *before, const struct cml_seen *to,
                                  const struct cml_tally *pixels)
{
    const struct cml_detection *detection = &world->detection;
    int seen = 0;
    struct cml_seeing seeing = cml_seeing_of(world, &light->ray);
    if (detection->arc.detector) cml_score_arc(world, light, to);
    for (int k; (k = cml_next_seeing(&seeing)) >= 0;) {
        const struct cml_detector *detector = &detection->detectors[k];
        if (k + 1 == detection->arc.detector) continue;
        seen = seen && seen <= k ? seen : k + 1;
        cml_add_to_detector(world, light, k, to);
        if (!pixels || detector->shape != CML_DETECTOR_MAP) continue;
        cml_add_to_pixel(light, before, &seeing, detector, pixels);
    }
    return seen;
}

/* Returns the light that is split off packet `index` at its launch (P1). Its weight is 0 if nothing is split
 * off, no detector would see it, or the packet is a branch. */
static inline struct cml_light_out cml_light_split_off(const struct cml_world *world, cml_u64 index)
{
    const int split = world->detection.split;
    struct cml_light_out light = {
        .ray = {.u = {0, 0, -1}, .fresh = 1}, .lot = (real)0.5, .times = 1, .index = index};
    if (split != CML_SPLIT_UNSEEN && !cml_is_branch(index)) light.w = cml_split_off(world, index);
    if (light.w && split == CML_SPLIT_APART) {
        struct cml_packet start;
        cml_place(world, index, &start);
        light.ray.p = (struct cml_vec){start.p.x, start.p.y, 0};
        if (start.medium == 0) light.w = 0; /* boundary 0 stops it */
    }
    if (light.w) cml_note_port(world, index, &light.ray);
    return light;
}

/* Adds the light that is split off `times` packets like packet `index` to the scores of all detectors. */
static inline void cml_score_split_off(const struct cml_world *world, cml_u64 index, uint64_t times,
                                       const struct cml_seen *to, const struct cml_tally *pixels)
{
    struct cml_light_out light = cml_light_split_off(world, index);
    light.times = times;
    if (light.w) cml_score_light(world, &light, NULL, to, pixels);
}
