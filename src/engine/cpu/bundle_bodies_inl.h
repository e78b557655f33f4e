/* Code, included by bundle_walk_inl.h only: lanes in media with bodies. A vector loop finds lanes that leave
 * their region, which is known to be free of surfaces of bodies. kernels/walk.h takes those of them that may
 * meet a body to their interaction, a lane at a time.
 * It is compiled once for each level of the processor (engine_cpu_level.c says why).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/cpu/bundle_lane_events_inl.h"
#include "engine/cpu/bundle_loops_inl.h"

/* Regions of lanes without surfaces of bodies (kernels/bounds.h): a path that begins and ends in one meets no
 * body. medium: the medium in whose frame the region is; -1: no region, so that no lane is in it. A region
 * stays valid whatever happens to the packet. */
struct cml_regions {
    cml_u32 media; /* mask of media with bodies (cml_media_with_bodies) */
    _Alignas(64) int medium[CML_LANES];
    real x[CML_LANES], y[CML_LANES], z[CML_LANES], square[CML_LANES];
    real normal_x[CML_LANES], normal_y[CML_LANES], normal_z[CML_LANES], least[CML_LANES];
};

/* Returns the media in which bodies lie, as a mask: a bit for each of the first 31 media, and the last bit,
 * always set, for all others. */
static cml_u32 cml_media_with_bodies(const struct cml_world *world)
{
    const int media = world->setup.num_layers + 2 + world->setup.num_bodies;
    cml_u32 mask = 1u << 31;
    for (int m = 0; m < media && m < 31; m++) mask |= (cml_u32)(world->media[m].body_grid >= 0) << m;
    return mask;
}

/* Begins without any region. */
static void cml_regions_begin(const struct cml_world *world, struct cml_regions *regions)
{
    regions->media = cml_media_with_bodies(world);
    for (int i = 0; i < CML_LANES; i++) regions->medium[i] = -1;
}

/* Finds lanes whose path does not lie in the region that is known to be free of bodies: out[i] = 1. Each
 * lane has a region: the common part of a ball and a half-space. Lanes whose path is not a number count as
 * outside. */
CML_LOOP void cml_bundle_leave_regions(const struct cml_bundle *b, const struct cml_regions *r, int *out)
{
    const int lanes = b->lanes;
    const cml_u32 media = r->media;
#pragma omp simd
    for (int i = 0; i < lanes; i++) {
        const int medium = b->medium[i], bit = medium < 31 ? medium : 31;
        const int task = b->task[i], flies = (task == CML_LANE_INTERACT) | (task == CML_LANE_MAY_HIT);
        const int has_bodies = (int)(media >> bit & 1u);
        const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
        const struct cml_vec normal = {r->normal_x[i], r->normal_y[i], r->normal_z[i]};
        const struct cml_vec from = {b->x[i] - r->x[i], b->y[i] - r->y[i], b->z[i] - r->z[i]};
        const struct cml_vec to = cml_along(from, b->s[i], u);
        const real square = r->square[i], least = r->least[i];
        const real begins = cml_dot(from, from), ends = cml_dot(to, to);
        const real low = cml_dot(normal, from), high = cml_dot(normal, to);
        const int within = (begins < square) & (ends < square), beside = (low > least) & (high > least);
        out[i] = flies & has_bodies & !((r->medium[i] == medium) & within & beside);
    }
}

/* Returns the mask of lanes whose path may leave the region that is known to be free of bodies, and which
 * must therefore search. */
static uint64_t cml_lanes_out_of_regions(const struct cml_flight *f)
{
    _Alignas(64) int out[CML_LANES];
    uint64_t lanes = 0;
    cml_bundle_leave_regions(f->b, f->regions, out);
    for (int first = 0; first < f->b->lanes; first += CML_GROUP)
        lanes |= (uint64_t)cml_group_equal(out + first, 1) << first;
    return lanes;
}

/* Returns CML_NO_BODIES if the path of lane i meets no body; the lane then remembers the free region in
 * which its path ends, so that next steps need no search. Otherwise returns another enum cml_bodies_ahead. */
static int cml_lane_may_hit_body(struct cml_flight *f, int i)
{
    const struct cml_bundle *b = f->b;
    struct cml_regions *regions = f->regions;
    const int medium = b->medium[i];
    const struct cml_vec p = {b->x[i], b->y[i], b->z[i]}, u = {b->ux[i], b->uy[i], b->uz[i]};
    struct cml_body_region region;
    const int ahead = cml_may_hit_body(f->world, medium, p, u, b->s[i], &region);
    if (ahead) return ahead;
    regions->medium[i] = medium;
    regions->x[i] = region.middle.x;
    regions->y[i] = region.middle.y;
    regions->z[i] = region.middle.z;
    regions->normal_x[i] = region.normal.x;
    regions->normal_y[i] = region.normal.y;
    regions->normal_z[i] = region.normal.z;
    regions->square[i] = region.square;
    regions->least[i] = region.least;
    return CML_NO_BODIES;
}

/* Sets the lane's path and task after a boundary event, as cml_bundle_fly_again does. */
static void cml_lane_fly_again(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    b->task[i] = cml_lane_may_hit(b, i, b->tau[i], &b->s[i]) ? CML_LANE_MAY_HIT : CML_LANE_INTERACT;
}

/* Flies the lane from boundary to boundary as long as it may meet a body before it interacts. */
static void cml_fly_lane_past_bodies(struct cml_flight *f, int i)
{
    const struct cml_bundle *b = f->b;
    for (int ahead; (ahead = cml_lane_may_hit_body(f, i));) {
        cml_process_lane_at_bodies(f, i, ahead);
        if (b->task[i] == CML_LANE_INTERACT) f->past_bodies |= CML_LANE_BIT(i);
        if (b->task[i] != CML_LANE_TO_FLY) return;
        cml_lane_fly_again(f, i);
    }
}

/* Handles all lanes that may meet a body before they interact. Lanes that were handled in this pass may still
 * be close to a body, and are left as they are. */
static void cml_process_bodies(struct cml_flight *f)
{
    cml_for_lanes(f, cml_lanes_out_of_regions(f) & ~f->past_bodies, cml_fly_lane_past_bodies);
}
