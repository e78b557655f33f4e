/* Flies photons through a bundle until there are no more.
 * SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_WALK_H
#define CML_BUNDLE_WALK_H

#include "bundle_launch.h"
#include "bundle_pass.h"
#include "packet_ends.h"

struct cml_flight {
    const struct cml_world *world;
    struct cml_bundle *b;
    struct cml_tally *tally;
    struct cml_deposits to;              /* into the tally */
    const struct cml_lane_medium *media; /* [num_layers + 2] */
    struct cml_packet start;             /* as the beam places packets */
    int pencil;                          /* it places all of them alike */
    uint64_t live, ended;                /* masks of lanes: that hold packets; whose packet is finished */
    uint64_t loaded;                     /* mask of lanes whose columns of a medium are sound */
    uint64_t curved;                     /* mask of lanes with a boundary that is no plane */
    uint64_t absorbed[CML_LANES];        /* of the lane's packet, up to the last mark */
    struct cml_launches launches;
    struct cml_ends ends;
};

#define CML_LANE_BIT(i) ((uint64_t)1 << (i))

static void cml_for_lanes(struct cml_flight *f, uint64_t mask, void (*handle)(struct cml_flight *, int))
{
    for (; mask; mask &= mask - 1) handle(f, __builtin_ctzll(mask));
}

static int cml_is_curved(const struct cml_world *world, int boundary)
{
    return boundary >= 0 && boundary <= world->setup.num_layers &&
           world->surfaces[boundary].kind != CML_SURFACE_PLANE;
}

/* The lane's columns of the medium it is in. */
static void cml_load_medium(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    const int m = b->medium[i];
    const real *row = &f->media[m].mut;
    const uint64_t bit = CML_LANE_BIT(i);
    const int curved = cml_is_curved(f->world, m - 1) || cml_is_curved(f->world, m);
    for (size_t k = 0; k < CML_LANE_MEDIUM_MEMBERS; k++) b->of_medium[k][i] = row[k];
    f->curved = curved ? f->curved | bit : f->curved & ~bit;
}

/* Books what the lane has deposited. Deposits belong to the medium they were made in, and show as lost
 * weight: to be called before either changes. */
static void cml_mark_weight(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    const cml_u32 deposited = b->marked[i] - b->w[i];
    f->tally->A_l[b->medium[i]] += deposited;
    f->absorbed[i] += deposited;
    b->marked[i] = b->w[i];
}

static uint64_t cml_lane_index(const struct cml_bundle *b, int i)
{
    return (uint64_t)b->index_high[i] << 32 | b->index_low[i];
}

static struct cml_packet cml_lane_packet(const struct cml_bundle *b, int i)
{
    const int stands = b->touched[i] == b->interactions[i];
    const struct cml_packet packet = {
        .index = cml_lane_index(b, i),
        .p = {b->x[i], b->y[i], b->z[i]},
        .u = {b->ux[i], b->uy[i], b->uz[i]},
        .tau = b->tau[i],
        .w = b->w[i],
        .interactions = b->interactions[i],
        .crossings = b->crossings[i],
        .bounces = stands ? b->bounces[i] : 0,
        .boundary_events = b->boundary_events[i],
        .medium = b->medium[i],
        .on_boundary = stands ? b->on_boundary[i] : -1,
        .on_primitive = b->on_primitive[i],
        .straight = b->straight[i],
        .entered = b->entered[i],
        .exit_x = b->x[i],
        .exit_y = b->y[i],
    };
    return packet;
}

/* Back into the lane what boundary events can change. */
static void cml_store_packet(struct cml_flight *f, int i, const struct cml_packet *packet)
{
    struct cml_bundle *b = f->b;
    b->x[i] = packet->p.x;
    b->y[i] = packet->p.y;
    b->z[i] = packet->p.z;
    b->ux[i] = packet->u.x;
    b->uy[i] = packet->u.y;
    b->uz[i] = packet->u.z;
    b->tau[i] = packet->tau;
    b->crossings[i] = packet->crossings;
    b->touched[i] = packet->interactions;
    b->bounces[i] = packet->bounces;
    b->boundary_events[i] = packet->boundary_events;
    b->on_boundary[i] = packet->on_boundary;
    b->on_primitive[i] = packet->on_primitive;
    b->straight[i] = packet->straight;
    b->entered[i] = packet->entered;
    if (packet->medium == b->medium[i]) return;
    cml_mark_weight(f, i);
    b->medium[i] = packet->medium;
    cml_load_medium(f, i);
}

/* Inlined, so that the end goes from lane to collection without being built in memory: its members would be
 * stored one by one and loaded together, which stalls. */
__attribute__((always_inline)) static inline void cml_push_end(struct cml_flight *f, int i,
                                                               struct cml_end end)
{
    cml_mark_weight(f, i);
    end.absorbed = f->absorbed[i];
    cml_ends_push(&f->world->setup, &f->ends, &end, f->tally);
    f->b->task[i] = CML_LANE_DONE;
    f->ended |= CML_LANE_BIT(i);
}

/* The lane's packet has ended where it is; lost, if there is a cause. */
static void cml_end_lane(struct cml_flight *f, int i, enum cml_fate fate, enum cml_lost_cause cause)
{
    const struct cml_bundle *b = f->b;
    const struct cml_end end = {
        .index = cml_lane_index(b, i),
        .fate = (int)fate,
        .cause = (int)cause,
        .w = b->w[i],
        .interactions = b->interactions[i],
        .boundary_events = b->boundary_events[i],
        .exit_x = b->x[i],
        .exit_y = b->y[i],
        .uz = b->uz[i],
    };
    cml_push_end(f, i, end);
}

static void cml_lane_interacts(struct cml_flight *f, int i, real s)
{
    f->b->s[i] = s;
    f->b->task[i] = CML_LANE_INTERACT;
}

/* One boundary event by kernels/walk.h, and as many more as it takes to come back into the material. Returns
 * 0 when there was none: then the packet interacts, *t further on. */
static int cml_meet_boundary(const struct cml_world *world, const struct cml_deposits *to,
                             struct cml_packet *packet, struct cml_reach reach, real *t)
{
    for (;;) {
        struct cml_hit hit;
        const real t_max = cml_free_path(world, packet);
        if (cml_nearest(world, packet, reach, &hit)) {
            cml_meet(world, to, packet, &hit);
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

/* As in cml_interact: a packet about to interact beyond an envelope has slipped through it. */
static int cml_would_leak(const struct cml_world *world, const struct cml_packet *packet, real t)
{
    struct cml_packet moved = *packet;
    moved.p = cml_along(packet->p, t, packet->u);
    return cml_leaked(world, &moved);
}

/* The lane's packet has something ahead, or nothing and never interacts. */
static void cml_meet_or_interact(struct cml_flight *f, int i, struct cml_reach reach)
{
    real t;
    struct cml_bundle *b = f->b;
    struct cml_packet packet = cml_lane_packet(b, i);
    b->task[i] = CML_LANE_DONE;
    if (!(cml_dot(packet.u, packet.u) < 2)) {
        cml_lose(&packet, CML_LOST_NAN);
    } else if (!cml_meet_boundary(f->world, &f->to, &packet, reach, &t)) {
        if (cml_would_leak(f->world, &packet, t))
            cml_lose(&packet, CML_LOST_LEAKED);
        else
            cml_lane_interacts(f, i, t);
    }
    cml_tally_events(&packet, f->tally);
    if (packet.fate != CML_FATE_ALIVE)
        cml_push_end(f, i, cml_end_of(&packet));
    else if (b->task[i] == CML_LANE_DONE)
        cml_store_packet(f, i, &packet);
}

/* A lane that is near a curved surface, or has nothing ahead, or whose optical depth lies in the tail. */
static void cml_handle_exception(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    const struct cml_vec p = {b->x[i], b->y[i], b->z[i]}, u = {b->ux[i], b->uy[i], b->uz[i]};
    const real mfp = CML_OF_MEDIUM(b, mfp)[i];
    if (!(b->tau[i] < CML_INFINITY))
        b->tau[i] = cml_optical_depth(f->world->setup.stream, cml_lane_index(b, i), b->interactions[i], 0);
    const real s = mfp < CML_INFINITY ? b->tau[i] * mfp : CML_INFINITY;
    const struct cml_reach reach = cml_find_reach(f->world, b->medium[i], p, u, s);
    if (reach.above || reach.below || !(s < CML_INFINITY) || !(cml_dot(u, u) < 2))
        cml_meet_or_interact(f, i, reach);
    else
        cml_lane_interacts(f, i, s);
}

/* Through a plane into another layer. */
static void cml_enter_layer(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    const int upwards = b->uz[i] < 0, medium = b->medium[i] + (upwards ? -1 : 1);
    cml_mark_weight(f, i);
    b->medium[i] = medium;
    b->entered[i] = 1;
    b->z[i] = upwards ? f->media[medium].span : (real)0;
    b->task[i] = CML_LANE_DONE;
    cml_load_medium(f, i);
}

/* P6, through a plane to the outside: the packet is not moved out of its medium any more, it ends. */
static void cml_exit_lane(struct cml_flight *f, int i)
{
    const struct cml_bundle *b = f->b;
    const int upwards = b->uz[i] < 0;
    const enum cml_fate gone = upwards ? CML_FATE_REFLECTED : CML_FATE_TRANSMITTED;
    cml_end_lane(f, i, b->entered[i] ? gone : CML_FATE_SPECULAR, CML_LOST_NOT);
}

/* Nothing ahead, or the bounds of cml_count_bounce. */
static void cml_handle_odd(struct cml_flight *f, int i)
{
    const struct cml_bundle *b = f->b;
    if (b->task[i] == CML_LANE_NOWHERE) {
        cml_handle_exception(f, i);
        return;
    }
    if (b->task[i] == CML_LANE_TRANSMITTED) cml_enter_layer(f, i);
    if (!(CML_OF_MEDIUM(b, mut)[i] > 0))
        cml_end_lane(f, i, CML_FATE_TRAPPED, CML_LOST_NOT);
    else if (b->bounces[i] > CML_STUCK_LIMIT)
        cml_end_lane(f, i, CML_FATE_LOST, CML_LOST_STUCK);
}

/* P8, as cml_roulette. Before the lane's next draw. */
static void cml_lane_roulette(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    struct cml_packet packet = {.w = b->w[i]};
    packet.draw =
        cml_draw(f->world->setup.stream, cml_lane_index(b, i), CML_PURPOSE_INTERACTION, b->interactions[i]);
    cml_roulette(&packet);
    cml_tally_events(&packet, f->tally);
    cml_mark_weight(f, i);
    b->w[i] = b->marked[i] = packet.w;
    if (packet.fate == CML_FATE_ALIVE) return;
    b->interactions[i]++;
    cml_end_lane(f, i, CML_FATE_ABSORBED, CML_LOST_NOT);
}

/* A placed packet into a lane, whatever was there before. */
static void cml_start_lane(struct cml_flight *f, int i, const struct cml_packet *packet,
                           const struct cml_launch *launch)
{
    struct cml_bundle *b = f->b;
    b->x[i] = packet->p.x;
    b->y[i] = packet->p.y;
    b->z[i] = packet->p.z;
    b->ux[i] = packet->u.x;
    b->uy[i] = packet->u.y;
    b->uz[i] = packet->u.z;
    b->tau[i] = launch->tau;
    b->draw1[i] = launch->draw1;
    b->draw2[i] = launch->draw2;
    b->w[i] = b->marked[i] = packet->w;
    b->index_low[i] = (cml_u32)launch->index;
    b->index_high[i] = (cml_u32)(launch->index >> 32);
    b->interactions[i] = b->crossings[i] = b->boundary_events[i] = b->touched[i] = b->bounces[i] = 0;
    b->on_boundary[i] = b->on_primitive[i] = -1;
    b->entered[i] = packet->entered;
    f->absorbed[i] = 0;
    if (f->loaded & CML_LANE_BIT(i) && b->medium[i] == packet->medium) return;
    f->loaded |= CML_LANE_BIT(i);
    b->medium[i] = packet->medium;
    cml_load_medium(f, i);
}

/* A lane without a packet takes part in every loop, and does nothing in any. */
static void cml_park_lane(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    b->x[i] = b->y[i] = b->z[i] = b->ux[i] = b->uy[i] = b->tau[i] = 0;
    b->uz[i] = 1;
    b->w[i] = b->marked[i] = 0;
    CML_OF_MEDIUM(b, mfp)[i] = 1;
    CML_OF_MEDIUM(b, stop_above)[i] = -CML_INFINITY;
    CML_OF_MEDIUM(b, stop_below)[i] = CML_INFINITY;
    f->live &= ~CML_LANE_BIT(i);
}

/* A new packet into the lane of a finished one, as long as there are any. */
static void cml_refill_lane(struct cml_flight *f, int i)
{
    struct cml_launch launch;
    if (!cml_launches_next(&f->launches, &f->world->setup, &launch)) {
        cml_park_lane(f, i);
        return;
    }
    if (!f->pencil) cml_place(f->world, launch.index, &f->start);
    cml_start_lane(f, i, &f->start, &launch);
    if (f->to.facets) cml_score_launch(f->world, &f->to, &f->start);
}

static void cml_refill(struct cml_flight *f)
{
    const uint64_t ended = f->ended;
    f->ended = 0;
    cml_for_lanes(f, ended, cml_refill_lane);
}

/* Mask of the lanes with a task. */
static uint64_t cml_lanes_with(const struct cml_bundle *b, int task)
{
    cml_u32 low = 0, high = 0;
#pragma omp simd reduction(| : low, high)
    for (int i = 0; i < 32; i++) {
        low |= (cml_u32)(b->task[i] == task) << i;
        high |= (cml_u32)(b->task[i + 32] == task) << i;
    }
    return (uint64_t)high << 32 | low;
}

static uint64_t cml_lanes_below_threshold(const struct cml_bundle *b)
{
    cml_u32 low = 0, high = 0;
#pragma omp simd reduction(| : low, high)
    for (int i = 0; i < 32; i++) {
        low |= (cml_u32)((b->task[i] == CML_LANE_INTERACT) & (b->w[i] < CML_ROULETTE_THRESHOLD)) << i;
        high |= (cml_u32)((b->task[i + 32] == CML_LANE_INTERACT) & (b->w[i + 32] < CML_ROULETTE_THRESHOLD))
                << i;
    }
    return (uint64_t)high << 32 | low;
}

/* The lanes of a group, lane i at bit 2 i, with this code of two bits. */
static cml_u32 cml_lanes_coded(cml_u32 codes, cml_u32 code)
{
    const cml_u32 low = code & 1u ? codes : ~codes, high = code & 2u ? codes >> 1 : ~(codes >> 1);
    return low & high & 0x55555555u;
}

static void cml_for_coded(struct cml_flight *f, cml_u32 lanes, int first,
                          void (*handle)(struct cml_flight *, int))
{
    for (; lanes; lanes &= lanes - 1) handle(f, first + __builtin_ctz(lanes) / 2);
}

/* Facets of planes: what lanes first..first+15 have met, where facets are asked for. Reflection has turned
 * the direction already. */
static void cml_score_planes(const struct cml_flight *f, int first)
{
    const struct cml_bundle *b = f->b;
    for (int i = first; i < first + CML_GROUP; i++) {
        const int through = b->task[i] == CML_LANE_TRANSMITTED, upwards = b->uz[i] < 0, m = b->medium[i];
        const int boundary = through == upwards ? m - 1 : m, beyond = upwards ? m - 1 : m + 1;
        if (!through && b->task[i] != CML_LANE_REFLECTED) continue;
        cml_score_facet(f->world, &f->to, boundary, 0, b->x[i], b->y[i], m, through ? beyond : m, b->w[i]);
    }
}

/* Planes met by lanes first..first+15. Many lanes are then worth flying once more, so that they may interact
 * in this pass as well. */
static void cml_cross_group(struct cml_flight *f, int first, int lanes)
{
    const struct cml_setup *setup = &f->world->setup;
    const int many = 3;
    if (cml_bundle_reach_planes(f->b, first)) cml_bundle_turn(setup, f->b, first);
    if (f->to.facets) cml_score_planes(f, first);
    const cml_u32 codes = cml_bundle_look_behind(setup, f->b, first);
    cml_for_coded(f, cml_lanes_coded(codes, CML_BEHIND_EXIT), first, cml_exit_lane);
    cml_for_coded(f, cml_lanes_coded(codes, CML_BEHIND_LAYER), first, cml_enter_layer);
    cml_for_coded(f, cml_lanes_coded(codes, CML_BEHIND_ODD), first, cml_handle_odd);
    if (f->ended) cml_refill(f);
    if (lanes >= many) cml_bundle_fly_again(f->b, first);
}

/* Lanes near a boundary that the planes' loops cannot serve. */
static uint64_t cml_exceptions(const struct cml_flight *f, uint64_t near)
{
    uint64_t exceptions = 0;
    for (uint64_t rest = near; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        if (f->curved >> i & 1u || !(f->b->tau[i] < CML_INFINITY)) exceptions |= CML_LANE_BIT(i);
    }
    return exceptions;
}

static void cml_meet_boundaries(struct cml_flight *f, uint64_t near)
{
    const uint64_t exceptions = cml_exceptions(f, near), planes = near & ~exceptions;
    cml_for_lanes(f, exceptions, cml_handle_exception);
    if (f->ended) cml_refill(f);
    for (int first = 0; first < CML_LANES; first += CML_GROUP) {
        const int lanes = __builtin_popcount((cml_u32)(planes >> first) & 0xffffu);
        if (lanes > 0) cml_cross_group(f, first, lanes);
    }
}

/* Into the thread's own A_rz, or into one that all threads share. */
static void cml_scatter_deposits(const struct cml_bundle *b, const struct cml_tally *tally)
{
    uint64_t *A_rz = tally->A_rz;
    if (tally->grid.absorption)
        for (int i = 0; i < CML_LANES; i++) A_rz[b->cell[i]] += b->dw[i];
    else
        for (int i = 0; i < CML_LANES; i++) cml_add_shared(&A_rz[b->cell[i]], b->dw[i]);
}

/* The same into the volume, where one is asked for. */
static void cml_scatter_volume(const struct cml_flight *f)
{
    const struct cml_bundle *b = f->b;
    for (int i = 0; i < CML_LANES; i++) {
        const struct cml_vec p = {b->x[i], b->y[i], b->z[i]};
        if (b->dw[i]) cml_deposit_volume(&f->world->setup, &f->to, p, CML_OF_MEDIUM(b, bins)[i], b->dw[i]);
    }
}

static void cml_interact_lanes(struct cml_flight *f, const int all)
{
    const struct cml_setup *setup = &f->world->setup;
    int low;
    if (f->tally->A_rz) {
        low = cml_bundle_interact(setup, f->b, all, 1);
        cml_scatter_deposits(f->b, f->tally);
        if (f->to.A_xyz) cml_scatter_volume(f);
    } else {
        low = cml_bundle_interact(setup, f->b, all, 0);
    }
    if (low) cml_for_lanes(f, cml_lanes_below_threshold(f->b) & f->live, cml_lane_roulette);
    if (f->ended) cml_refill(f);
}

/* A lane without a packet draws like the others, and may well draw the tail, which is near. */
static void cml_calm_lane(struct cml_flight *f, int i)
{
    f->b->tau[i] = f->b->s[i] = 0;
    f->b->task[i] = CML_LANE_DONE;
}

static void cml_pass(struct cml_flight *f)
{
    cml_bundle_draw(&f->world->setup, f->b);
    if (cml_bundle_fly(f->b)) {
        const uint64_t near = cml_lanes_with(f->b, CML_LANE_NEAR);
        cml_for_lanes(f, near & ~f->live, cml_calm_lane);
        cml_meet_boundaries(f, near & f->live);
        cml_interact_lanes(f, 0);
    } else {
        cml_interact_lanes(f, 1);
    }
}

/* Everything goes into `tally`. media: [num_layers + 2]. */
static void cml_bundle_walk(const struct cml_world *world, const struct cml_lane_medium *media,
                            const struct cml_range_source *source, struct cml_tally *tally)
{
    struct cml_bundle bundle = {0};
    struct cml_flight f = {.world = world, .b = &bundle, .tally = tally, .media = media};
    f.to = cml_deposits_of(tally);
    f.launches.source = source;
    f.pencil = !(world->setup.disk > 0) && !(world->setup.gauss > 0);
    cml_place(world, 0, &f.start);
    f.live = f.ended = ~(uint64_t)0;
    cml_refill(&f);
    for (int i = 0; i < CML_LANES; i++) bundle.task[i] = CML_LANE_DONE;
    while (f.live) cml_pass(&f);
    cml_ends_flush(&world->setup, &f.ends, tally);
}

#endif
