/* Code, included by bundle_walk_inl.h only and so compiled once for each level of the processor
 * (engine_cpu_level.c says why). Lanes in media with bodies: a vector loop finds those whose path may reach
 * one, and kernels/walk.h takes these, a lane at a time, to where they interact. SPDX-License-Identifier: MIT
 */
#ifndef CML_BUNDLE_BODIES_INL_H
#define CML_BUNDLE_BODIES_INL_H

#include "engine/cpu/bundle_lane_events_inl.h"
#include "engine/cpu/bundle_loops_inl.h"

/* cml_may_meet_body for all lanes that have a path: those for which it holds become MAY_HIT_BODY. Returns 1
 * when there are any. */
CML_LOOP int cml_bundle_find_bodies(const struct cml_world *world, struct cml_bundle *b)
{
    const struct cml_medium *restrict const media = world->media;
    const struct cml_body_grid *restrict const grids = world->body_grids;
    const real *restrict const clearance = world->body_clearance;
    const int lanes = b->lanes;
    int any = 0;
#pragma omp simd reduction(| : any)
    for (int i = 0; i < lanes; i++) {
        const int task = b->task[i], flies = (task == CML_LANE_INTERACT) | (task == CML_LANE_MAY_HIT);
        const int grid = media[b->medium[i]].body_grid, has = grid >= 0;
        const struct cml_vec p = {b->x[i], b->y[i], b->z[i]};
        const real least = cml_body_clearance(&grids[has ? grid : 0], clearance, p);
        const int near = flies & has & !(b->s[i] < least);
        b->task[i] = cml_pick_int(near, CML_LANE_MAY_HIT_BODY, task);
        any |= near;
    }
    return any;
}

/* From boundary to boundary until the lane interacts, or its packet has ended. */
static void cml_fly_lane_past_bodies(struct cml_flight *f, int i)
{
    do cml_process_lane(f, i);
    while (f->b->task[i] == CML_LANE_TO_FLY);
    if (f->b->task[i] == CML_LANE_INTERACT) f->past_bodies |= CML_LANE_BIT(i);
}

/* All lanes that may meet a body before they interact. Those that have been dealt with in this pass are found
 * again, as they may still be close to one. */
static void cml_process_bodies(struct cml_flight *f)
{
    if (!cml_bundle_find_bodies(f->world, f->b)) return;
    const uint64_t lanes = cml_lanes_with(f->b, CML_LANE_MAY_HIT_BODY);
    for (uint64_t rest = lanes & f->past_bodies; rest; rest &= rest - 1)
        f->b->task[__builtin_ctzll(rest)] = CML_LANE_INTERACT;
    cml_for_lanes(f, lanes & ~f->past_bodies, cml_fly_lane_past_bodies);
}

#endif
