/* Code, included by bundle_curved_cross_inl.h and bundle_bodies_inl.h: lanes at boundaries one by one, by
 * kernels/walk.h. These are the rare cases that vector loops leave over.
 * It is compiled once for each level of the processor (engine_cpu_level.c says why).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/cpu/bundle_lanes_inl.h"

/* Lets the lane interact in this pass, s (cm) further on, because no boundary comes first. */
static void cml_lane_set_interacting(struct cml_flight *f, int i, real s)
{
    f->b->s[i] = s;
    f->b->task[i] = CML_LANE_INTERACT;
}

/* True if a lane's packet is still on its way from the source to a boundary whose hit is known
 * (bundle_prepare.h). */
static int cml_first_hit_is_known(const struct cml_flight *f, int medium, cml_u32 boundary_events)
{
    return f->first_hit_known && medium == 0 && boundary_events == 0;
}

/* cml_nearest_hit, but without a search if the hit is known. */
static int cml_find_hit(const struct cml_flight *f, struct cml_packet *packet,
                        struct cml_boundary_intervals intervals, struct cml_hit *hit)
{
    if (cml_first_hit_is_known(f, packet->medium, packet->boundary_events)) {
        *hit = f->first_hit;
        return 1;
    }
    const int found = cml_nearest_hit(f->world, packet, intervals, hit);
    CML_HOOK_MET(found && !cml_is_plane(f->world, hit->boundary));
    return found;
}

/* Handles boundary events of one packet by kernels/walk.h: one event, and as many more as it takes until the
 * packet is back in the material or has ended, because lanes hold packets of outer media only before they
 * have entered. intervals: the parts of its path on which it can meet boundaries. Returns 0 if there was no
 * event; then the packet interacts, *t (cm) further on. */
static int cml_boundary_events(const struct cml_flight *f, struct cml_packet *packet,
                               struct cml_boundary_intervals intervals, real *t)
{
    const struct cml_world *world = f->world;
    for (;;) {
        struct cml_hit hit;
        const real t_max = cml_free_path(world, packet);
        const int found = cml_find_hit(f, packet, intervals, &hit);
        if (packet->fate != CML_FATE_ALIVE) return 1;
        if (found) {
            cml_score_boundary_event(world, &f->to, packet, &hit);
        } else if (t_max < CML_INFINITY) {
            *t = t_max;
            return 0;
        } else {
            cml_leave_scene(world, &f->to, packet);
        }
        const int outside = cml_is_outer(world, packet->medium);
        if (packet->fate != CML_FATE_ALIVE || !outside) return 1;
        intervals = cml_find_intervals(world, packet, cml_free_path(world, packet));
    }
}

/* Makes kernels/walk.h add the expected values of the lane's packet to its batch (P15). */
static void cml_expect_of_lane(struct cml_flight *f, int i)
{
    if (f->to.expected)
        f->to.expected_late =
            f->late & CML_LANE_BIT(i) ? f->late_profiles[i] + f->tally->profile.expected : NULL;
}

/* Puts a packet that is in the material again back into the lane, or adds its end to the collection. */
static void cml_return_to_lane(struct cml_flight *f, int i, struct cml_packet *packet)
{
    cml_tally_events(packet, f->tally);
    f->b->path[i] = packet->path;
    if (f->late & CML_LANE_BIT(i)) {
        f->late_profiles[i][CML_TOTAL_BACKING] += packet->backing;
        f->late_profiles[i][CML_TOTAL_FACE] += packet->face;
    }
    if (packet->fate != CML_FATE_ALIVE) {
        cml_end_visit(f->world, packet);
        cml_push_termination(f, i, cml_termination_of(packet));
    } else {
        cml_store_packet(f, i, packet);
    }
}

/* Flies a packet in an outer medium until it leaves for good, or comes back into the material (P6). */
static void cml_fly_outside(const struct cml_flight *f, struct cml_packet *packet)
{
    const struct cml_world *world = f->world;
    const struct cml_boundary_intervals intervals =
        cml_find_intervals(world, packet, cml_free_path(world, packet));
    real t;
    cml_boundary_events(f, packet, intervals, &t);
}

/* Handles the lane's meeting with `hit`, which a search has found that was counted nowhere yet, and all that
 * follows until the packet is back in the material or has ended. */
static void cml_process_found_hit(struct cml_flight *f, int i, const struct cml_hit *hit)
{
    const struct cml_world *world = f->world;
    struct cml_packet packet;
    cml_lane_packet(f->b, i, &packet);
    cml_expect_of_lane(f, i);
    f->b->task[i] = CML_LANE_TO_FLY;
    packet.queries = 1;
    CML_HOOK_MET(1);
    cml_score_boundary_event(world, &f->to, &packet, hit);
    const int outside = cml_is_outer(world, packet.medium);
    if (packet.fate == CML_FATE_ALIVE && outside) cml_fly_outside(f, &packet);
    cml_return_to_lane(f, i, &packet);
}

/* Handles a search that has found no boundary on the lane's path: the lane interacts, unless its place is
 * then beyond a boundary that it has not crossed (P9). */
static void cml_lane_misses(struct cml_flight *f, int i)
{
    const struct cml_bundle *b = f->b;
    const struct cml_vec p = {b->x[i], b->y[i], b->z[i]}, u = {b->ux[i], b->uy[i], b->uz[i]};
    f->tally->count[CML_COUNT_QUERIES]++;
    if (cml_leaked(f->world, b->medium[i], cml_along(p, b->s[i], u).z))
        cml_end_lane(f, i, CML_FATE_LOST, CML_LOST_LEAKED);
    else
        cml_lane_set_interacting(f, i, b->s[i]);
}

/* Does one step of kernels/walk.h for the lane, but not the interaction itself, which the loops make. The
 * lane's packet may meet a boundary within `intervals`, or has no interaction ahead (P9), or is not a
 * number. */
static void cml_intersect_or_interact(struct cml_flight *f, int i, struct cml_boundary_intervals intervals)
{
    real t;
    struct cml_bundle *b = f->b;
    struct cml_packet packet;
    cml_lane_packet(b, i, &packet);
    cml_expect_of_lane(f, i);
    b->task[i] = CML_LANE_TO_FLY;
    if (!(cml_dot(packet.u, packet.u) < 2)) {
        cml_lose_packet(&packet, CML_LOST_NAN);
    } else if (!cml_boundary_events(f, &packet, intervals, &t)) {
        /* the same check for a leak as in cml_interact */
        if (cml_leaked(f->world, packet.medium, cml_along(packet.p, t, packet.u).z))
            cml_lose_packet(&packet, CML_LOST_LEAKED);
        else
            cml_lane_set_interacting(f, i, t);
        if (packet.near_boundary) cml_store_near_boundary(b, i, &packet);
    }
    if (b->task[i] == CML_LANE_INTERACT && packet.fate == CML_FATE_ALIVE)
        cml_tally_events(&packet, f->tally);
    else
        cml_return_to_lane(f, i, &packet);
}

/* Lets the lane interact after s (cm), unless a boundary may come first, there is no interaction, or the
 * direction is not a number. */
static void cml_continue_lane(struct cml_flight *f, int i, struct cml_boundary_intervals intervals, real s)
{
    const struct cml_bundle *b = f->b;
    const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
    if (intervals.above.meets || intervals.below.meets || intervals.bodies || !(s < CML_INFINITY) ||
        !(cml_dot(u, u) < 2))
        cml_intersect_or_interact(f, i, intervals);
    else
        cml_lane_set_interacting(f, i, s);
}

/* Processes lane i from the start of its path, without the vector loops. Its optical depth may still lie in
 * the tail, or it has no event ahead, or it is on its way from the source to a boundary whose hit is
 * known. */
static void cml_process_lane(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    struct cml_packet packet;
    if (!(b->tau[i] < CML_INFINITY))
        b->tau[i] = cml_optical_depth(f->world->setup.stream, cml_lane_index(b, i), b->interactions[i], 0);
    const real s = cml_path(b->tau[i], CML_OF_MEDIUM(b, mfp)[i]);
    const int known = cml_first_hit_is_known(f, b->medium[i], b->boundary_events[i]);
    const struct cml_boundary_intervals ahead = {{0, 0, s}, {1, 0, s}, 0, s};
    cml_lane_packet(b, i, &packet);
    const struct cml_boundary_intervals intervals = known ? ahead : cml_find_intervals(f->world, &packet, s);
    cml_continue_lane(f, i, intervals, s);
}

/* Processes a lane that may meet a body, and has its path s. ahead: enum cml_bodies_ahead. */
static void cml_process_lane_at_bodies(struct cml_flight *f, int i, int ahead)
{
    const struct cml_bundle *b = f->b;
    struct cml_packet packet;
    cml_lane_packet(b, i, &packet);
    struct cml_boundary_intervals intervals = cml_layer_intervals(f->world, &packet, b->s[i]);
    intervals.bodies = ahead;
    cml_intersect_or_interact(f, i, intervals);
}
