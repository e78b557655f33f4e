/* SPDX-License-Identifier: MIT */
#include "bundle_walk.h"

#include "tally_packet.h"
#include "walk.h"

struct flight {
    const struct cml_world *world;
    struct cml_bundle *b;
    struct cml_tally *tally;
    const struct cml_range_source *source;
    uint64_t next, left; /* indices handed out and not launched yet */
    int lanes;           /* lanes 0..lanes-1 hold packets */
    cml_u32 interacting; /* mask of lanes that interact in this pass */
    cml_u32 loaded;      /* mask of lanes whose copies of a medium are sound */
    int pencil;
    struct cml_packet start;            /* as the beam places packets */
    cml_u32 launched;                   /* mask of lanes with a new packet */
    cml_u32 curved_above, curved_below; /* masks of lanes whose boundary above, below is no plane */
    cml_u32 ended;                      /* mask of lanes whose packet is finished in this pass */
    uint64_t absorbed[CML_LANES];       /* of the lane's packet, without what is still in `deposited` */
};

static int lowest_lane(cml_u32 mask)
{
    return __builtin_ctz(mask);
}

/* What the vector loops must know of the medium a lane is in. */
static void load_medium(struct flight *f, int i)
{
    struct cml_bundle *b = f->b;
    const int m = b->medium[i], layers = f->world->setup.num_layers;
    const struct cml_medium *medium = &f->world->media[m];
    const struct cml_surface *top = m > 0 ? &f->world->surfaces[m - 1] : NULL;
    const struct cml_surface *bottom = m <= layers ? &f->world->surfaces[m] : NULL;
    const int curved_top = top && top->kind != CML_SURFACE_PLANE;
    const int curved_bottom = bottom && bottom->kind != CML_SURFACE_PLANE;
    b->mut[i] = medium->mut;
    b->mfp[i] = medium->mfp;
    b->absorb[i] = medium->absorb;
    b->g[i] = medium->g;
    b->depth[i] = medium->depth;
    b->n[i] = medium->n;
    b->n_above[i] = top ? medium[-1].n : medium->n;
    b->n_below[i] = bottom ? medium[1].n : medium->n;
    b->plane_above[i] = top && !curved_top ? (real)0 : -CML_INFINITY;
    b->plane_below[i] = bottom && !curved_bottom ? medium->span : CML_INFINITY;
    b->stop_above[i] = curved_top ? top->highest : b->plane_above[i];
    b->stop_below[i] = curved_bottom ? medium->span + bottom->lowest : b->plane_below[i];
    const cml_u32 bit = (cml_u32)1 << i;
    f->curved_above = curved_top ? f->curved_above | bit : f->curved_above & ~bit;
    f->curved_below = curved_bottom ? f->curved_below | bit : f->curved_below & ~bit;
}

/* Deposits belong to the medium they were made in: to be called before it changes. */
static void flush_deposits(struct flight *f, int i)
{
    f->tally->A_l[f->b->medium[i]] += f->b->deposited[i];
    f->absorbed[i] += f->b->deposited[i];
    f->b->deposited[i] = 0;
}

static struct cml_packet packet_of(const struct flight *f, int i)
{
    const struct cml_bundle *b = f->b;
    const struct cml_packet packet = {
        .index = (cml_u64)b->index_high[i] << 32 | b->index_low[i],
        .p = {b->x[i], b->y[i], b->z[i]},
        .u = {b->ux[i], b->uy[i], b->uz[i]},
        .tau = b->tau[i],
        .w = b->w[i],
        .interactions = b->interactions[i],
        .crossings = b->crossings[i],
        .bounces = b->bounces[i],
        .boundary_events = b->boundary_events[i],
        .medium = b->medium[i],
        .on_boundary = b->on_boundary[i],
        .on_primitive = b->on_primitive[i],
        .straight = b->straight[i],
        .entered = b->entered[i],
        .exit_x = b->x[i],
        .exit_y = b->y[i],
    };
    return packet;
}

/* Back into the lane what a scalar event can change. */
static void store_packet(struct flight *f, int i, const struct cml_packet *packet)
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
    b->bounces[i] = packet->bounces;
    b->boundary_events[i] = packet->boundary_events;
    b->on_boundary[i] = packet->on_boundary;
    b->on_primitive[i] = packet->on_primitive;
    b->straight[i] = packet->straight;
    b->entered[i] = packet->entered;
    if (packet->medium == b->medium[i]) return;
    flush_deposits(f, i);
    b->medium[i] = packet->medium;
    load_medium(f, i);
}

static void end_lane(struct flight *f, int i, struct cml_end end)
{
    flush_deposits(f, i);
    end.absorbed = f->absorbed[i];
    cml_tally_end(&f->world->setup, &end, f->tally);
    f->b->task[i] = CML_LANE_DONE;
    f->ended |= (cml_u32)1 << i;
}

/* The lane's packet is finished where it is. */
static void finish_lane(struct flight *f, int i, enum cml_fate fate, enum cml_lost_cause cause)
{
    const struct cml_bundle *b = f->b;
    const struct cml_end end = {
        .index = (uint64_t)b->index_high[i] << 32 | b->index_low[i],
        .fate = (int)fate,
        .cause = (int)cause,
        .w = b->w[i],
        .interactions = b->interactions[i],
        .boundary_events = b->boundary_events[i],
        .exit_x = b->x[i],
        .exit_y = b->y[i],
        .uz = b->uz[i],
    };
    end_lane(f, i, end);
}

/* The lane's packet is finished as a scalar event has left it. */
static void finish_packet(struct flight *f, int i, const struct cml_packet *packet)
{
    end_lane(f, i, cml_end_of(packet));
}

/* A lane whose packet interacts after all, t further on; unless that lies beyond an envelope (as in
 * cml_interact). */
static void interact_later(struct flight *f, int i, real t, struct cml_packet *packet)
{
    f->b->s[i] = t;
    f->b->task[i] = CML_LANE_INTERACT;
    f->interacting |= (cml_u32)1 << i;
    packet->p = cml_along(packet->p, t, packet->u);
    if (!cml_leaked(f->world, packet)) return;
    cml_lose(packet, CML_LOST_LEAKED);
    f->interacting &= ~((cml_u32)1 << i);
    f->b->s[i] = 0;
}

static int misses(const struct cml_world *world, const struct cml_surface *surface, struct cml_vec p,
                  struct cml_vec d, struct cml_vec u, real side)
{
    if (surface->kind == CML_SURFACE_PLANE) return 0;
    return cml_heads_away(surface, u, side) || cml_is_clear(world, surface, p, d, side);
}

/* Whether a near lane's step stays clear of both its boundaries, planes and curved ones. */
static int is_clear(const struct flight *f, int i)
{
    const struct cml_bundle *b = f->b;
    const struct cml_world *world = f->world;
    const int m = b->medium[i];
    const real s = b->s[i], step = s * b->uz[i], end = b->z[i] + step;
    const struct cml_vec d = {s * b->ux[i], s * b->uy[i], step}, q = {b->x[i], b->y[i], b->z[i]};
    struct cml_vec p = cml_from_scene_axis(world, q);
    if (m == 0 || m > world->setup.num_layers) return 0;
    const struct cml_surface *top = &world->surfaces[m - 1], *bottom = &world->surfaces[m];
    const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
    const real slack = 4 * CML_EPSILON * (fabsf(p.z) + fabsf(step));
    if (!(fminf(p.z, end) - slack > b->stop_above[i]) && !misses(world, top, p, d, u, 1)) return 0;
    if (fmaxf(p.z, end) + slack < b->stop_below[i]) return 1;
    p.z -= world->media[m].span;
    return misses(world, bottom, p, d, u, -1);
}

/* A lane that may meet a curved surface, or has nothing ahead: one boundary event by kernels/walk.h, and as
 * many more as it takes to come back into the material. Without one the lane interacts in this pass like the
 * others. */
static void handle_exception(struct flight *f, int i)
{
    const struct cml_world *world = f->world;
    if (is_clear(f, i)) {
        f->b->task[i] = CML_LANE_INTERACT;
        f->interacting |= (cml_u32)1 << i;
        return;
    }
    struct cml_packet packet = packet_of(f, i);
    f->b->task[i] = CML_LANE_DONE;
    f->b->s[i] = 0;
    for (;;) {
        const real t_max = cml_free_path(world, &packet);
        struct cml_hit hit;
        if (cml_nearest(world, &packet, t_max, &hit))
            cml_cross(world, &packet, &hit);
        else if (t_max < CML_INFINITY)
            interact_later(f, i, t_max, &packet);
        else
            cml_leave(world, &packet);
        const int outside = packet.medium == 0 || packet.medium > world->setup.num_layers;
        if (packet.fate != CML_FATE_ALIVE || !outside) break;
    }
    cml_tally_events(&packet, f->tally);
    if (packet.fate != CML_FATE_ALIVE)
        finish_packet(f, i, &packet);
    else if (f->b->task[i] == CML_LANE_DONE)
        store_packet(f, i, &packet);
}

/* Behind a plane into another medium of the material. */
static void enter_medium(struct flight *f, int i, int medium, int upwards)
{
    struct cml_bundle *b = f->b;
    flush_deposits(f, i);
    b->medium[i] = medium;
    b->entered[i] = 1;
    b->z[i] = upwards ? f->world->media[medium].span : (real)0;
    load_medium(f, i);
}

/* The bounds of cml_count_bounce. */
static void check_bounces(struct flight *f, int i)
{
    const struct cml_bundle *b = f->b;
    if (b->bounces[i] > CML_TRAPPED_LIMIT && !(b->mut[i] > 0))
        finish_lane(f, i, CML_FATE_TRAPPED, CML_LOST_NOT);
    else if (b->bounces[i] > CML_STUCK_LIMIT)
        finish_lane(f, i, CML_FATE_LOST, CML_LOST_STUCK);
}

/* P6, behind a plane: a packet that leaves is not moved out of its medium any more, it ends. */
static void after_plane(struct flight *f, int i)
{
    struct cml_bundle *b = f->b;
    const int task = b->task[i], upwards = b->uz[i] < 0;
    if (task == CML_LANE_INTERACT) {
        f->interacting |= (cml_u32)1 << i;
        return;
    }
    if (task == CML_LANE_NOWHERE) {
        handle_exception(f, i);
        return;
    }
    const int medium = b->medium[i] + (task == CML_LANE_TRANSMITTED ? (upwards ? -1 : 1) : 0);
    const int above = medium == 0, outside = above || medium > f->world->setup.num_layers;
    b->on_boundary[i] = -1;
    if (outside && !b->entered[i])
        finish_lane(f, i, CML_FATE_SPECULAR, CML_LOST_NOT);
    else if (outside)
        finish_lane(f, i, above ? CML_FATE_REFLECTED : CML_FATE_TRANSMITTED, CML_LOST_NOT);
    else if (task == CML_LANE_TRANSMITTED)
        enter_medium(f, i, medium, upwards);
    if (!outside && b->bounces[i] > CML_TRAPPED_LIMIT) check_bounces(f, i);
}

/* P8, as cml_roulette. */
static void roulette(struct flight *f, int i)
{
    struct cml_bundle *b = f->b;
    struct cml_packet packet = {.w = b->w[i], .draw.w[3] = b->lot[i]};
    cml_roulette(&packet);
    cml_tally_events(&packet, f->tally);
    b->w[i] = packet.w;
    flush_deposits(f, i);
    if (packet.fate != CML_FATE_ALIVE) finish_lane(f, i, CML_FATE_ABSORBED, CML_LOST_NOT);
}

static void draw_tail(struct flight *f, int i)
{
    const cml_u64 index = (cml_u64)f->b->index_high[i] << 32 | f->b->index_low[i];
    f->b->tau[i] = cml_optical_depth(f->world->setup.stream, index, f->b->interactions[i], 0);
}

static void draw_first(struct flight *f, int i)
{
    struct cml_bundle *b = f->b;
    struct cml_packet packet = {.index = (cml_u64)b->index_high[i] << 32 | b->index_low[i]};
    cml_next_flight(f->world, &packet);
    b->tau[i] = packet.tau;
    b->draw1[i] = packet.draw.w[1];
    b->draw2[i] = packet.draw.w[2];
    b->draw3[i] = packet.draw.w[3];
}

/* P7: weight that was scored in a bin from beyond it. */
static void count_edge(struct flight *f, int i)
{
    const struct cml_bundle *b = f->b;
    const struct cml_setup *setup = &f->world->setup;
    const real z = (b->z[i] + b->depth[i]) * setup->per_dz;
    int overflow;
    cml_radial_bin(setup, b->x[i], b->y[i], &overflow);
    if (overflow) f->tally->book[CML_BOOK_OVERFLOW_R] += b->dw[i];
    if (!(z >= 0)) f->tally->book[CML_BOOK_ABOVE] += b->dw[i];
    if (z >= (real)setup->nz) f->tally->book[CML_BOOK_OVERFLOW_Z] += b->dw[i];
}

/* What an interaction asked to be looked at. */
static void handle_flag(struct flight *f, int i)
{
    const int flag = f->b->flag[i];
    if (flag & CML_FLAG_EDGE) count_edge(f, i);
    if (flag & CML_FLAG_TAIL) draw_tail(f, i);
    if (flag & CML_FLAG_NAN)
        finish_lane(f, i, CML_FATE_LOST, CML_LOST_NAN);
    else if (flag & CML_FLAG_ROULETTE)
        roulette(f, i);
}

static void scatter_deposits(struct flight *f, int first)
{
    const struct cml_bundle *b = f->b;
    uint64_t *A_rz = f->tally->A_rz;
    for (int i = first; i < first + CML_HALF; i++) A_rz[b->cell[i]] += b->dw[i];
}

/* The next photon index, if there is one. */
static int take_index(struct flight *f, uint64_t *index)
{
    while (f->left == 0)
        if (!f->source->next(f->source->context, &f->next, &f->left)) return 0;
    f->left--;
    *index = f->next++;
    return 1;
}

/* A placed packet into a lane, whatever was there before. */
static void start_lane(struct flight *f, int i, const struct cml_packet *packet, uint64_t index)
{
    struct cml_bundle *b = f->b;
    const cml_u32 bit = (cml_u32)1 << i;
    b->x[i] = packet->p.x;
    b->y[i] = packet->p.y;
    b->z[i] = packet->p.z;
    b->ux[i] = packet->u.x;
    b->uy[i] = packet->u.y;
    b->uz[i] = packet->u.z;
    b->w[i] = packet->w;
    b->index_low[i] = (cml_u32)index;
    b->index_high[i] = (cml_u32)(index >> 32);
    b->deposited[i] = b->interactions[i] = b->crossings[i] = b->bounces[i] = b->boundary_events[i] = 0;
    b->on_boundary[i] = b->on_primitive[i] = -1;
    b->entered[i] = packet->entered;
    b->task[i] = CML_LANE_LAUNCHED;
    f->absorbed[i] = 0;
    f->launched |= bit;
    if (f->loaded & bit && b->medium[i] == packet->medium) return;
    f->loaded |= bit;
    b->medium[i] = packet->medium;
    load_medium(f, i);
}

/* All packets of a pencil beam are placed alike. */
static int launch(struct flight *f, int i)
{
    uint64_t index;
    if (!take_index(f, &index)) return 0;
    if (!f->pencil) cml_place(f->world, index, &f->start);
    start_lane(f, i, &f->start, index);
    return 1;
}

static cml_u32 copy_bit(cml_u32 mask, int from, int to)
{
    const cml_u32 bit = (cml_u32)1 << to;
    return mask >> from & 1u ? mask | bit : mask & ~bit;
}

/* The packet of lane `from` moves to lane `to`. Every member of a bundle is CML_LANES values of 4 bytes. */
static void move_lane(struct flight *f, int from, int to)
{
    cml_u32 *columns = (cml_u32 *)(void *)f->b;
    for (size_t k = 0; k < sizeof *f->b / sizeof(cml_u32); k += CML_LANES)
        columns[k + (size_t)to] = columns[k + (size_t)from];
    f->absorbed[to] = f->absorbed[from];
    f->curved_above = copy_bit(f->curved_above, from, to);
    f->curved_below = copy_bit(f->curved_below, from, to);
    f->launched |= (f->launched >> from & 1u) << to;
}

/* New packets into the lanes of finished ones; without any left, the last lanes fill the holes. From the top
 * down, so that the last lane is always one in flight. */
static void refill(struct flight *f)
{
    while (f->ended) {
        const int i = 31 - __builtin_clz(f->ended);
        f->ended &= ~((cml_u32)1 << i);
        if (launch(f, i)) continue;
        f->lanes--;
        if (i < f->lanes) move_lane(f, f->lanes, i);
    }
}

static void for_lanes(struct flight *f, cml_u32 mask, void (*handle)(struct flight *, int))
{
    for (; mask; mask &= mask - 1) handle(f, lowest_lane(mask));
}

static cml_u32 flagged_lanes(const struct flight *f, int first, int lanes)
{
    cml_u32 mask = 0;
    for (int i = first; i < first + lanes; i++) mask |= (cml_u32)(f->b->flag[i] != 0) << i;
    return mask;
}

/* The draws of new packets: a vector pass when there are many, else one by one. */
static void draw_launched(struct flight *f)
{
    const cml_u32 few = 2, launched = f->launched;
    f->launched = 0;
    if ((cml_u32)__builtin_popcount(launched) > few) {
        if (cml_bundle_draw(&f->world->setup, f->b)) for_lanes(f, flagged_lanes(f, 0, CML_LANES), draw_tail);
    } else {
        for_lanes(f, launched, draw_first);
    }
}

/* Sixteen lanes, some of which interact. */
static void interact_half(struct flight *f, int first)
{
    const int flags = cml_bundle_interact(&f->world->setup, f->b, first);
    if (f->tally->A_rz) scatter_deposits(f, first);
    if (flags) for_lanes(f, flagged_lanes(f, first, CML_HALF), handle_flag);
}

static void pass(struct flight *f)
{
    struct cml_bundle *b = f->b;
    const struct cml_setup *setup = &f->world->setup;
    const cml_u32 live = f->lanes == CML_LANES ? ~(cml_u32)0 : ((cml_u32)1 << f->lanes) - 1;
    const cml_u64 near_lanes = cml_bundle_fly(b);
    const cml_u32 above = (cml_u32)near_lanes & live, below = (cml_u32)(near_lanes >> CML_LANES) & live;
    const cml_u32 exceptions = (above & f->curved_above) | (below & f->curved_below);
    const cml_u32 planes = (above | below) & ~exceptions;
    for (int i = f->lanes; i < CML_LANES; i++) b->task[i] = CML_LANE_DONE;
    f->interacting = live & ~(above | below);
    for_lanes(f, exceptions, handle_exception);
    if (planes & 0xffffu) cml_bundle_cross_planes(setup, b, 0);
    if (planes >> CML_HALF) cml_bundle_cross_planes(setup, b, CML_HALF);
    for_lanes(f, planes, after_plane);
    if (f->interacting & 0xffffu) interact_half(f, 0);
    if (f->interacting >> CML_HALF) interact_half(f, CML_HALF);
    if (f->ended) refill(f);
    if (f->launched) draw_launched(f);
}

void cml_bundle_walk(const struct cml_world *world, struct cml_bundle *bundle,
                     const struct cml_range_source *source, struct cml_tally *tally)
{
    struct flight f = {.world = world, .b = bundle, .tally = tally, .source = source, .lanes = CML_LANES};
    *bundle = (struct cml_bundle){0};
    f.pencil = !(world->setup.disk > 0) && !(world->setup.gauss > 0);
    cml_place(world, 0, &f.start);
    f.ended = ~(cml_u32)0;
    refill(&f);
    draw_launched(&f);
    while (f.lanes > 0) pass(&f);
}
