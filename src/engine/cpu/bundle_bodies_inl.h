/* Code, included by bundle_walk_inl.h only and so compiled once for each level of the processor
 * (engine_cpu_level.c says why). Lanes in media with bodies: a vector loop finds those whose path may reach
 * one, and kernels/walk.h takes these, a lane at a time, to where they interact. SPDX-License-Identifier: MIT
 */
#ifndef CML_BUNDLE_BODIES_INL_H
#define CML_BUNDLE_BODIES_INL_H

#include "engine/cpu/bundle_lane_events_inl.h"
#include "engine/cpu/bundle_loops_inl.h"

/* The grid of each lane that has a path, -1 where there is none: [CML_LANES]. Returns 1 when a lane has one.
 */
CML_LOOP int cml_bundle_find_grids(const struct cml_world *world, const struct cml_bundle *b, int *grid)
{
    const struct cml_medium *restrict const media = world->media;
    const int lanes = b->lanes;
    int any = 0;
#pragma omp simd reduction(| : any)
    for (int i = 0; i < lanes; i++) {
        const int task = b->task[i], flies = (task == CML_LANE_INTERACT) | (task == CML_LANE_MAY_HIT);
        const int of_medium = media[b->medium[i]].body_grid;
        grid[i] = flies ? of_medium : -1;
        any |= flies & (of_medium >= 0);
    }
    return any;
}

/* Lanes of one grid that keep clear of all bodies on their path get the grid -1. */
CML_LOOP void cml_bundle_clear_grid(const struct cml_world *world, const struct cml_bundle *b, int number,
                                    int *grid)
{
    const struct cml_body_grid shared = world->body_grids[number];
    const real *restrict const clearance = world->body_clearance;
    const int lanes = b->lanes;
#pragma omp simd
    for (int i = 0; i < lanes; i++) {
        const struct cml_vec p = {b->x[i], b->y[i], b->z[i]};
        const int clear = (grid[i] == number) & (b->s[i] < cml_body_clearance(&shared, clearance, p));
        grid[i] = cml_pick_int(clear, -1, grid[i]);
    }
}

/* Those of a group of lanes that have this grid. */
static inline uint64_t cml_lanes_with_grid(const int *grid, int number)
{
    uint64_t lanes = 0;
    for (int first = 0; first < CML_LANES; first += CML_GROUP)
        lanes |= (uint64_t)cml_group_equal(grid + first, number) << first;
    return lanes;
}

/* Mask of the lanes whose path the clearance where they are does not show to be free of bodies. A grid at a
 * time: what a loop reads of its grid is then in registers. Where lanes are in bodies of many kinds, a loop
 * for each would not pay, and the rest is left to be looked at one by one. */
static uint64_t cml_lanes_near_bodies(const struct cml_world *world, const struct cml_bundle *b)
{
    const int most = 4;
    _Alignas(64) int grid[CML_LANES];
    for (int i = 0; i < CML_LANES; i++) grid[i] = -1;
    if (!cml_bundle_find_grids(world, b, grid)) return 0;
    uint64_t rest = ~cml_lanes_with_grid(grid, -1);
    for (int k = 0; rest && k < most; k++) {
        const int number = grid[__builtin_ctzll(rest)];
        rest &= ~cml_lanes_with_grid(grid, number);
        cml_bundle_clear_grid(world, b, number, grid);
    }
    return ~cml_lanes_with_grid(grid, -1);
}

/* From boundary to boundary until the lane interacts, or its packet has ended, if it can meet a body at all.
 */
static void cml_fly_lane_past_bodies(struct cml_flight *f, int i)
{
    const struct cml_bundle *b = f->b;
    const struct cml_vec p = {b->x[i], b->y[i], b->z[i]}, u = {b->ux[i], b->uy[i], b->uz[i]};
    if (!cml_may_meet_body(f->world, b->medium[i], p, u, b->s[i])) return;
    do cml_process_lane(f, i);
    while (b->task[i] == CML_LANE_TO_FLY);
    if (b->task[i] == CML_LANE_INTERACT) f->past_bodies |= CML_LANE_BIT(i);
}

/* All lanes that may meet a body before they interact. Those that have been dealt with in this pass may still
 * be close to one, and stay as they are. */
static void cml_process_bodies(struct cml_flight *f)
{
    cml_for_lanes(f, cml_lanes_near_bodies(f->world, f->b) & ~f->past_bodies, cml_fly_lane_past_bodies);
}

#endif
