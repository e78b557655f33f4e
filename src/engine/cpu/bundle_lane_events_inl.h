/* Code, included by bundle_curved_cross_inl.h only and so compiled once for each level of the processor
 * (engine_cpu_level.c says why). Lanes at boundaries one by one, by kernels/walk.h: the rare cases that
 * vector loops leave to be done. SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_LANE_EVENTS_INL_H
#define CML_BUNDLE_LANE_EVENTS_INL_H

#include "engine/cpu/bundle_lanes_inl.h"

static void cml_lane_set_interacting(struct cml_flight *f, int i, real s)
{
    f->b->s[i] = s;
    f->b->task[i] = CML_LANE_INTERACT;
}

/* Whether a lane's packet is still on its way from the source to a boundary whose hit is known
 * (bundle_prepare.h). */
static int cml_first_hit_is_known(const struct cml_flight *f, int medium, cml_u32 boundary_events)
{
    return f->first_hit_known && medium == 0 && boundary_events == 0;
}

/* As cml_nearest_hit. */
static int cml_find_hit(const struct cml_flight *f, struct cml_packet *packet,
                        struct cml_boundary_intervals intervals, struct cml_hit *hit)
{
    if (!cml_first_hit_is_known(f, packet->medium, packet->boundary_events))
        return cml_nearest_hit(f->world, packet, intervals, hit);
    *hit = f->first_hit;
    return 1;
}

/* One boundary event by kernels/walk.h, and as many more as it takes to come back into the material. Returns
 * 0 when there was none: then the packet interacts, *t further on. */
static int cml_boundary_events(const struct cml_flight *f, struct cml_packet *packet,
                               struct cml_boundary_intervals intervals, real *t)
{
    const struct cml_world *world = f->world;
    for (;;) {
        struct cml_hit hit;
        const real t_max = cml_free_path(world, packet);
        if (cml_find_hit(f, packet, intervals, &hit)) {
            cml_score_boundary_event(world, &f->to, packet, &hit);
        } else if (t_max < CML_INFINITY) {
            *t = t_max;
            return 0;
        } else {
            cml_leave_scene(world, packet);
        }
        const int outside = packet->medium == 0 || packet->medium > world->setup.num_layers;
        if (packet->fate != CML_FATE_ALIVE || !outside) return 1;
        intervals = cml_find_intervals(world, packet, cml_free_path(world, packet));
    }
}

/* The packet is back in the material, or has ended. */
static void cml_return_to_lane(struct cml_flight *f, int i, const struct cml_packet *packet)
{
    cml_tally_events(packet, f->tally);
    if (packet->fate != CML_FATE_ALIVE)
        cml_push_termination(f, i, cml_termination_of(packet));
    else
        cml_store_packet(f, i, packet);
}

/* A packet that is outside leaves for good, or comes back into the material. */
static void cml_fly_outside(const struct cml_flight *f, struct cml_packet *packet)
{
    const struct cml_world *world = f->world;
    const struct cml_boundary_intervals intervals =
        cml_find_intervals(world, packet, cml_free_path(world, packet));
    real t;
    cml_boundary_events(f, packet, intervals, &t);
}

/* The lane's packet meets this, the first of its boundary events. */
static void cml_process_found_hit(struct cml_flight *f, int i, const struct cml_hit *hit)
{
    const struct cml_world *world = f->world;
    struct cml_packet packet;
    cml_lane_packet(f->b, i, &packet);
    f->b->task[i] = CML_LANE_DONE;
    packet.queries = 1;
    cml_score_boundary_event(world, &f->to, &packet, hit);
    const int outside = packet.medium == 0 || packet.medium > world->setup.num_layers;
    if (packet.fate == CML_FATE_ALIVE && outside) cml_fly_outside(f, &packet);
    cml_return_to_lane(f, i, &packet);
}

/* The lane's packet has been asked for and meets nothing. */
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

/* The lane's packet has something ahead, or nothing and never interacts. */
static void cml_intersect_or_interact(struct cml_flight *f, int i, struct cml_boundary_intervals intervals)
{
    real t;
    struct cml_bundle *b = f->b;
    struct cml_packet packet;
    cml_lane_packet(b, i, &packet);
    b->task[i] = CML_LANE_DONE;
    if (!(cml_dot(packet.u, packet.u) < 2)) {
        cml_lose_packet(&packet, CML_LOST_NAN);
    } else if (!cml_boundary_events(f, &packet, intervals, &t)) {
        /* as in cml_interact */
        if (cml_leaked(f->world, packet.medium, cml_along(packet.p, t, packet.u).z))
            cml_lose_packet(&packet, CML_LOST_LEAKED);
        else
            cml_lane_set_interacting(f, i, t);
        if (packet.beside) cml_store_beside(b, i, &packet);
    }
    if (b->task[i] == CML_LANE_INTERACT && packet.fate == CML_FATE_ALIVE)
        cml_tally_events(&packet, f->tally);
    else
        cml_return_to_lane(f, i, &packet);
}

/* The lane interacts after s unless something is within reach; so it does where nothing is, and it never
 * interacts, or is not a number. */
static void cml_continue_lane(struct cml_flight *f, int i, struct cml_boundary_intervals intervals, real s)
{
    const struct cml_bundle *b = f->b;
    const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
    if (intervals.above.meets || intervals.below.meets || !(s < CML_INFINITY) || !(cml_dot(u, u) < 2))
        cml_intersect_or_interact(f, i, intervals);
    else
        cml_lane_set_interacting(f, i, s);
}

/* A lane that has nothing ahead, or whose optical depth lies in the tail, or that is aimed. */
static void cml_process_lane(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    struct cml_packet packet;
    if (!(b->tau[i] < CML_INFINITY))
        b->tau[i] = cml_optical_depth(f->world->setup.stream, cml_lane_index(b, i), b->interactions[i], 0);
    const real s = cml_path(b->tau[i], CML_OF_MEDIUM(b, mfp)[i]);
    const int known = cml_first_hit_is_known(f, b->medium[i], b->boundary_events[i]);
    const struct cml_boundary_intervals ahead = {{0, 0, s}, {1, 0, s}};
    cml_lane_packet(b, i, &packet);
    const struct cml_boundary_intervals intervals = known ? ahead : cml_find_intervals(f->world, &packet, s);
    cml_continue_lane(f, i, intervals, s);
}

#endif
