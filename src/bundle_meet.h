/* Lanes at curved surfaces, and others that are exceptions. SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_MEET_H
#define CML_BUNDLE_MEET_H

#include "bundle_aim.h"
#include "bundle_curved.h"
#include "bundle_hits.h"

static void cml_lane_interacts(struct cml_flight *f, int i, real s)
{
    f->b->s[i] = s;
    f->b->task[i] = CML_LANE_INTERACT;
}

/* As cml_nearest. */
static int cml_find_hit(const struct cml_flight *f, struct cml_packet *packet, struct cml_reach reach,
                        struct cml_hit *hit)
{
    if (!cml_is_aimed(f, packet->medium, packet->boundary_events))
        return cml_nearest(f->world, packet, reach, hit);
    *hit = f->first;
    return 1;
}

/* One boundary event by kernels/walk.h, and as many more as it takes to come back into the material. Returns
 * 0 when there was none: then the packet interacts, *t further on. */
static int cml_meet_boundary(const struct cml_flight *f, struct cml_packet *packet, struct cml_reach reach,
                             real *t)
{
    const struct cml_world *world = f->world;
    for (;;) {
        struct cml_hit hit;
        const real t_max = cml_free_path(world, packet);
        if (cml_find_hit(f, packet, reach, &hit)) {
            cml_meet(world, &f->to, packet, &hit);
        } else if (t_max < CML_INFINITY) {
            *t = t_max;
            return 0;
        } else {
            cml_leave(world, packet);
        }
        const int outside = packet->medium == 0 || packet->medium > world->setup.num_layers;
        if (packet->fate != CML_FATE_ALIVE || !outside) return 1;
        reach = cml_find_reach(world, packet->medium, packet->p, packet->u, cml_free_path(world, packet));
    }
}

/* The packet is back in the material, or has ended. */
static void cml_put_back(struct cml_flight *f, int i, const struct cml_packet *packet)
{
    cml_tally_events(packet, f->tally);
    if (packet->fate != CML_FATE_ALIVE)
        cml_push_end(f, i, cml_end_of(packet));
    else
        cml_store_packet(f, i, packet);
}

/* A packet that is outside leaves for good, or comes back into the material. */
static void cml_come_back(const struct cml_flight *f, struct cml_packet *packet)
{
    const struct cml_world *world = f->world;
    const struct cml_reach reach =
        cml_find_reach(world, packet->medium, packet->p, packet->u, cml_free_path(world, packet));
    real t;
    cml_meet_boundary(f, packet, reach, &t);
}

/* The lane's packet meets this, the first of its boundary events. */
static void cml_meet_found(struct cml_flight *f, int i, const struct cml_hit *hit)
{
    const struct cml_world *world = f->world;
    struct cml_packet packet;
    cml_lane_packet(f->b, i, &packet);
    f->b->task[i] = CML_LANE_DONE;
    packet.queries = 1;
    cml_meet(world, &f->to, &packet, hit);
    const int outside = packet.medium == 0 || packet.medium > world->setup.num_layers;
    if (packet.fate == CML_FATE_ALIVE && outside) cml_come_back(f, &packet);
    cml_put_back(f, i, &packet);
}

/* The lane's packet has been asked for and meets nothing. */
static void cml_lane_passes(struct cml_flight *f, int i)
{
    const struct cml_bundle *b = f->b;
    const struct cml_vec p = {b->x[i], b->y[i], b->z[i]}, u = {b->ux[i], b->uy[i], b->uz[i]};
    f->tally->count[CML_COUNT_QUERIES]++;
    if (cml_leaked(f->world, b->medium[i], cml_along(p, b->s[i], u).z))
        cml_end_lane(f, i, CML_FATE_LOST, CML_LOST_LEAKED);
    else
        cml_lane_interacts(f, i, b->s[i]);
}

/* The lane's packet has something ahead, or nothing and never interacts. */
static void cml_meet_or_interact(struct cml_flight *f, int i, struct cml_reach reach)
{
    real t;
    struct cml_bundle *b = f->b;
    struct cml_packet packet;
    cml_lane_packet(b, i, &packet);
    b->task[i] = CML_LANE_DONE;
    if (!(cml_dot(packet.u, packet.u) < 2)) {
        cml_lose(&packet, CML_LOST_NAN);
    } else if (!cml_meet_boundary(f, &packet, reach, &t)) {
        /* as in cml_interact */
        if (cml_leaked(f->world, packet.medium, cml_along(packet.p, t, packet.u).z))
            cml_lose(&packet, CML_LOST_LEAKED);
        else
            cml_lane_interacts(f, i, t);
        if (packet.beside) cml_store_beside(b, i, &packet);
    }
    if (b->task[i] == CML_LANE_INTERACT && packet.fate == CML_FATE_ALIVE)
        cml_tally_events(&packet, f->tally);
    else
        cml_put_back(f, i, &packet);
}

/* The lane interacts after s unless something is within reach; so it does where nothing is, and it never
 * interacts, or is not a number. */
static void cml_go_on(struct cml_flight *f, int i, struct cml_reach reach, real s)
{
    const struct cml_bundle *b = f->b;
    const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
    if (reach.above.meets || reach.below.meets || !(s < CML_INFINITY) || !(cml_dot(u, u) < 2))
        cml_meet_or_interact(f, i, reach);
    else
        cml_lane_interacts(f, i, s);
}

/* A lane that has nothing ahead, or whose optical depth lies in the tail, or that is aimed. */
static void cml_handle_exception(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    const struct cml_vec p = {b->x[i], b->y[i], b->z[i]}, u = {b->ux[i], b->uy[i], b->uz[i]};
    if (!(b->tau[i] < CML_INFINITY))
        b->tau[i] = cml_optical_depth(f->world->setup.stream, cml_lane_index(b, i), b->interactions[i], 0);
    const real s = cml_path(b->tau[i], CML_OF_MEDIUM(b, mfp)[i]);
    const int aimed = cml_is_aimed(f, b->medium[i], b->boundary_events[i]);
    const struct cml_reach ahead = {{0, 0, s}, {1, 0, s}},
                           reach = aimed ? ahead : cml_find_reach(f->world, b->medium[i], p, u, s);
    cml_go_on(f, i, reach, s);
}

/* Whether the lane's packet is one for cml_seek_lane: in the material, about to meet no boundary but this
 * one, which is curved, and nothing rare about it. */
static int cml_is_plain(const struct cml_flight *f, int i, int boundary)
{
    const struct cml_bundle *b = f->b;
    const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
    const int medium = b->medium[i];
    return medium > 0 && medium <= f->world->setup.num_layers &&
           f->world->surfaces[boundary].kind != CML_SURFACE_PLANE && !f->to.facets &&
           b->boundary_events[i] > 0 && b->bounces[i] < CML_TRAPPED_LIMIT && b->s[i] < CML_INFINITY &&
           cml_dot(u, u) < 2;
}

/* What the lane's packet stands on of a boundary, -1: nothing. */
static int cml_lane_stands_on(const struct cml_bundle *b, int i, int boundary)
{
    const int stands = b->touched[i] == b->interactions[i] && b->on_boundary[i] == boundary;
    return stands ? b->on_primitive[i] : -1;
}

/* A packet at p among those that meet the boundary. Returns its number. */
static int cml_add_hit(const struct cml_bundle *b, int i, int primitive, struct cml_vec p, struct cml_hits *h)
{
    const int k = h->count++;
    h->lane[k] = i;
    h->primitive[k] = primitive;
    h->x[k] = p.x;
    h->y[k] = p.y;
    h->z[k] = p.z;
    h->ux[k] = b->ux[i];
    h->uy[k] = b->uy[i];
    h->uz[k] = b->uz[i];
    h->index_low[k] = b->index_low[i];
    h->index_high[k] = b->index_high[i];
    h->crossings[k] = b->crossings[i];
    return k;
}

/* The lane's packet, at p in the boundary's frame, on its way to rings: cml_field_hit up to the root. */
static void cml_march_lane(struct cml_flight *f, int i, int boundary, struct cml_vec p, real side,
                           struct cml_stretch s, struct cml_hits *h)
{
    const struct cml_world *world = f->world;
    const struct cml_bundle *b = f->b;
    const struct cml_rings rings = cml_rings_of(world, boundary);
    const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
    const int on_ring = cml_lane_stands_on(b, i, boundary);
    const real t_min = on_ring >= 0 ? (real)0 : s.from;
    struct cml_cone_march march =
        cml_cone_begin(rings, cml_from_scene_axis(world, p), u, side, t_min, on_ring);
    const enum cml_cone_verdict verdict = cml_cone_go(rings, &march, s.to, 1, &h->t[h->count]);
    if (verdict == CML_CONE_MISSED) {
        cml_lane_passes(f, i);
        return;
    }
    const int k = cml_add_hit(b, i, march.ring, p, h);
    h->known[k] = verdict == CML_CONE_HIT;
    h->ring_r[k] = rings.r[march.ring];
    h->ring_z[k] = rings.z[march.ring];
    h->ring_end[k] = cml_ring_end(rings, march.ring);
    h->slope[k] = rings.slope[march.ring];
    h->t0[k] = march.t0;
    h->t1[k] = march.t1;
    h->t_max[k] = s.to;
}

static int cml_is_shaded(const struct cml_hit *hit)
{
    return hit->normal.x != hit->facet.x || hit->normal.y != hit->facet.y;
}

/* The lane's packet on its way to a mesh. p in the boundary's frame. */
static void cml_query_lane(struct cml_flight *f, int i, int boundary, struct cml_vec p, real side, real t_max,
                           struct cml_hits *h)
{
    const struct cml_bundle *b = f->b;
    const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
    struct cml_hit hit = {.boundary = boundary};
    int beside;
    const int found = cml_mesh_hit(f->world, boundary, p, u, side, t_max, cml_lane_stands_on(b, i, boundary),
                                   b->straight[i], &hit, &beside);
    if (!found && beside) {
        cml_handle_exception(f, i);
    } else if (!found) {
        cml_lane_passes(f, i);
    } else if (cml_is_shaded(&hit)) {
        cml_meet_found(f, i, &hit);
    } else {
        const int k = cml_add_hit(b, i, hit.primitive, hit.point, h);
        h->t[k] = hit.t;
        h->doubtful[k] = 0;
        h->normal_x[k] = hit.normal.x;
        h->normal_y[k] = hit.normal.y;
        h->normal_z[k] = hit.normal.z;
    }
}

/* The lane's packet on its way to a curved boundary. */
static void cml_seek_lane(struct cml_flight *f, int i, int boundary, real side, struct cml_stretch s,
                          struct cml_hits *h)
{
    const struct cml_bundle *b = f->b;
    const real depth = side < 0 ? f->world->media[boundary].span : (real)0;
    const struct cml_vec p = {b->x[i], b->y[i], b->z[i] - depth};
    if (f->world->surfaces[boundary].kind == CML_SURFACE_CONE)
        cml_march_lane(f, i, boundary, p, side, s, h);
    else
        cml_query_lane(f, i, boundary, p, side, s.to, h);
}

/* The lane's packet has gone through a boundary into outer medium `to`, and may meet it again. */
static void cml_leave_lane(struct cml_flight *f, int i, int to)
{
    struct cml_packet packet;
    cml_lane_packet(f->b, i, &packet);
    packet.medium = to;
    cml_come_back(f, &packet);
    cml_put_back(f, i, &packet);
}

/* Whether a packet that has gone through a boundary into outer medium `to` meets it never again. */
static int cml_is_gone(const struct cml_world *world, int boundary, int to, struct cml_vec u)
{
    const real side = to > boundary ? (real)1 : (real)-1;
    return !world->setup.reentry ||
           (!(world->media[to].mfp < CML_INFINITY) && cml_heads_away(&world->surfaces[boundary], u, side));
}

/* The lane's packet, which has been in the material, has left it so, in one boundary event more. */
static void cml_lane_goes(struct cml_flight *f, int i, int to, int primitive, struct cml_vec p,
                          struct cml_vec u)
{
    const struct cml_bundle *b = f->b;
    const struct cml_end end = {
        .index = cml_lane_index(b, i),
        .fate = to == 0 ? CML_FATE_REFLECTED : CML_FATE_TRANSMITTED,
        .cause = CML_LOST_NOT,
        .w = b->w[i],
        .interactions = b->interactions[i],
        .boundary_events = b->boundary_events[i] + 1,
        .exit_x = p.x,
        .exit_y = p.y,
        .uz = u.z,
        .primitive = primitive,
    };
    cml_push_end(f, i, end);
}

/* As cml_cross, for the k-th of the packets. */
static void cml_cross_lane(struct cml_flight *f, const struct cml_hits *h, int k, int boundary, int other,
                           int straight)
{
    const struct cml_world *world = f->world;
    struct cml_bundle *b = f->b;
    const int i = h->lane[k], from = b->medium[i], through = straight || h->through[k];
    const int to = through ? other : from, stands = b->touched[i] == b->interactions[i];
    const real left = CML_FMA(-h->t[k], CML_OF_MEDIUM(b, mut)[i], b->tau[i]);
    const struct cml_vec p = {h->x[k], h->y[k], h->z[k] + (to == boundary ? world->media[to].span : (real)0)},
                         u = {h->ux[k], h->uy[k], h->uz[k]};
    const int outside = to == 0 || to > world->setup.num_layers;
    if (outside && cml_is_gone(world, boundary, to, u)) {
        cml_lane_goes(f, i, to, h->primitive[k], p, u);
        return;
    }
    cml_store_ray(b, i, p, u);
    b->tau[i] = left > 0 ? left : (real)0;
    b->bounces[i] = (stands ? b->bounces[i] : 0) + 1;
    b->touched[i] = b->interactions[i];
    b->crossings[i] += (cml_u32)!straight;
    b->boundary_events[i]++;
    b->on_boundary[i] = boundary;
    b->on_primitive[i] = h->primitive[k];
    b->straight[i] = straight;
    b->task[i] = CML_LANE_DONE;
    if (to == from) return;
    if (outside) {
        cml_leave_lane(f, i, to);
        return;
    }
    cml_mark_weight(f, i);
    b->medium[i] = to;
    cml_load_medium(f, i);
}

/* Packets of a medium that meet a boundary. */
static void cml_meet_hits(struct cml_flight *f, int medium, real side, struct cml_hits *h)
{
    const struct cml_world *world = f->world;
    const int boundary = side > 0 ? medium - 1 : medium, other = side > 0 ? medium - 1 : medium + 1;
    const real n1 = world->media[medium].n, n2 = world->media[other].n;
    uint64_t *counts = f->tally->count;
    if (h->count == 0) return;
    if (world->surfaces[boundary].kind == CML_SURFACE_CONE) cml_hits_settle_rings(world, side, h);
    if (n1 != n2)
        counts[CML_COUNT_SHADING_OVERRULED] += (uint64_t)cml_hits_turn(&world->setup, side, n1, n2, h);
    for (int k = 0; k < h->count; k++) {
        if (h->doubtful[k]) {
            cml_handle_exception(f, h->lane[k]);
        } else {
            counts[CML_COUNT_QUERIES]++;
            cml_cross_lane(f, h, k, boundary, other, n1 == n2);
        }
    }
    h->count = 0;
}

/* Lanes of one medium near a curved surface. */
static void cml_meet_crowd(struct cml_flight *f, int medium, uint64_t lanes)
{
    struct cml_crowd *crowd = f->crowd;
    int k = 0;
    cml_find_reaches(f, medium, lanes);
    for (uint64_t rest = lanes; rest; rest &= rest - 1, k++) {
        const int i = __builtin_ctzll(rest);
        const struct cml_reach reach = {cml_stretch_of(&crowd->above, k), cml_stretch_of(&crowd->below, k)};
        const int above = reach.above.meets;
        if (above == reach.below.meets || !cml_is_plain(f, i, above ? medium - 1 : medium))
            cml_go_on(f, i, reach, f->b->s[i]);
        else if (above)
            cml_seek_lane(f, i, medium - 1, 1, reach.above, &crowd->hits_above);
        else
            cml_seek_lane(f, i, medium, -1, reach.below, &crowd->hits_below);
    }
    cml_meet_hits(f, medium, 1, &crowd->hits_above);
    cml_meet_hits(f, medium, -1, &crowd->hits_below);
}

/* Lanes near curved surfaces wait for others, as those at planes do. */
static void cml_meet_curves(struct cml_flight *f)
{
    const int patience = f->b->lanes == CML_LANES ? 32 : 1;
    uint64_t lanes = cml_lanes_with(f->b, CML_LANE_CURVED);
    f->waited_near += __builtin_popcountll(lanes);
    if (f->waited_near < patience) return;
    f->waited_near = 0;
    while (lanes) {
        const int medium = f->b->medium[__builtin_ctzll(lanes)];
        const uint64_t here = cml_lanes_in(f->b, lanes, medium);
        if (f->aimed && medium == 0)
            cml_for_lanes(f, here, cml_handle_exception);
        else
            cml_meet_crowd(f, medium, here);
        lanes &= ~here;
    }
}

#endif
