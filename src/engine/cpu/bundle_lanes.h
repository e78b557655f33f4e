/* The lanes of a bundle one by one: a packet's columns, what it deposits, and its end.
 * SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_LANES_H
#define CML_BUNDLE_LANES_H

#include "engine/cpu/bundle_masks.h"
#include "engine/terminated_packets.h"

#include <stddef.h>

/* m: 0..num_layers + 1. */
static struct cml_lane_medium cml_lane_medium_of(const struct cml_world *world, int m)
{
    const struct cml_medium *medium = &world->media[m];
    const struct cml_surface *top = m > 0 ? &world->surfaces[m - 1] : NULL;
    const struct cml_surface *bottom = m <= world->setup.num_layers ? &world->surfaces[m] : NULL;
    const int plane_top = top && top->kind == CML_SURFACE_PLANE;
    const int plane_bottom = bottom && bottom->kind == CML_SURFACE_PLANE;
    const real stop_above = top ? top->highest : -CML_INFINITY;
    const real stop_below = bottom ? medium->span + bottom->lowest : CML_INFINITY;
    const struct cml_lane_medium lane = {
        .mut = medium->mut,
        .mfp = medium->mfp,
        .absorb = medium->absorb,
        .g = medium->g,
        .bins = medium->bins,
        .n = medium->n,
        .n_above = top ? medium[-1].n : medium->n,
        .n_below = bottom ? medium[1].n : medium->n,
        .span = medium->span,
        .stop_above = stop_above,
        .stop_below = stop_below,
        .start_above = plane_top ? -CML_INFINITY : stop_above,
        .start_below = plane_bottom ? CML_INFINITY : stop_below,
    };
    return lane;
}

/* Hands out the next range [*first, *first + *count) of photon indices; 0 when there is none. */
struct cml_range_source {
    int (*next)(void *context, uint64_t *first, uint64_t *count);
    void *context;
};

/* Packets of a pencil beam that do not interact in their first medium, and leave the material for good behind
 * it: all end alike. */
struct cml_ballistic {
    int possible;
    real path; /* cm, in that medium */
    real mfp;
    cml_u32 crossings; /* before its end */
    real reflectance;  /* there */
    struct cml_termination end;
    uint64_t count; /* so far */
};

struct cml_flight {
    const struct cml_world *world;
    struct cml_bundle *b;
    struct cml_tally *tally;
    struct cml_deposits to;              /* into the tally */
    const struct cml_lane_medium *media; /* [num_layers + 2] */
    struct cml_packet start;             /* as the beam places packets */
    int pencil;                          /* it places all of them alike */
    int first_hit_known;                 /* then all of them meet first_hit, above the material */
    struct cml_hit first_hit;
    int enters;               /* and those that are not reflected there go on like `inside` */
    struct cml_packet inside; /* but for their indices */
    real reflectance;
    struct cml_ballistic ballistic;
    struct cml_gathered *gathered; /* bundle_curved_reach.h */
    int curves;                    /* not all surfaces are planes */
    real steepest;                 /* slope of those that are none */
    uint64_t live, ended;          /* masks of lanes: that hold packets; whose packet is finished */
    uint64_t absorbed[CML_LANES];  /* of the lane's packet, up to the last mark */
    const struct cml_range_source *source;
    int waited;          /* passes that lanes at planes have waited, summed over them */
    int waited_near;     /* the same of lanes near curved surfaces */
    uint64_t next, left; /* of the range in hand: photon indices not drawn for yet */
    struct cml_launch_queue queue;
    struct cml_terminated terminated;
};

/* Lanes that go into one vector: loops over fewer take as long. */
#if defined(__AVX512F__)
#define CML_VECTOR 16
#elif defined(__AVX2__)
#define CML_VECTOR 8
#else
#define CML_VECTOR 1 /* what gathers has no vectors */
#endif

static inline int cml_whole_vectors(int count)
{
    return (count + CML_VECTOR - 1) / CML_VECTOR * CML_VECTOR;
}

#define CML_LANE_BIT(i) ((uint64_t)1 << (i))

static void cml_for_lanes(struct cml_flight *f, uint64_t mask, void (*handle)(struct cml_flight *, int))
{
    for (; mask; mask &= mask - 1) handle(f, __builtin_ctzll(mask));
}

/* The lane's columns of the medium it is in. */
static void cml_load_medium(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    const real *restrict row = &f->media[b->medium[i]].mut;
    for (size_t k = 0; k < CML_LANE_MEDIUM_FLAT; k++) b->of_medium[k][i] = row[k];
    if (!f->curves) return;
    for (size_t k = CML_LANE_MEDIUM_FLAT; k < CML_LANE_MEDIUM_MEMBERS; k++) b->of_medium[k][i] = row[k];
}

/* Counts what the lane has deposited as absorbed. Deposits belong to the medium they were made in, and show
 * as lost weight: to be called before either changes. */
static void cml_flush_deposits(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    const cml_u32 deposited = b->flushed_w[i] - b->w[i];
    f->tally->A_l[b->medium[i]] += deposited;
    f->absorbed[i] += deposited;
    b->flushed_w[i] = b->w[i];
}

static uint64_t cml_lane_index(const struct cml_bundle *b, int i)
{
    return (uint64_t)b->index_high[i] << 32 | b->index_low[i];
}

/* Member by member: a packet that is built and then copied would be stored in parts and loaded whole, which
 * stalls. */
static inline void cml_lane_packet(const struct cml_bundle *b, int i, struct cml_packet *packet)
{
    const int stands = b->touched[i] == b->interactions[i];
    packet->index = cml_lane_index(b, i);
    packet->p.x = packet->exit_x = b->x[i];
    packet->p.y = packet->exit_y = b->y[i];
    packet->p.z = b->z[i];
    packet->u.x = b->ux[i];
    packet->u.y = b->uy[i];
    packet->u.z = b->uz[i];
    packet->tau = b->tau[i];
    packet->w = b->w[i];
    packet->interactions = b->interactions[i];
    packet->crossings = b->crossings[i];
    packet->bounces = stands ? b->bounces[i] : 0;
    packet->boundary_events = b->boundary_events[i];
    packet->medium = b->medium[i];
    packet->on_boundary = stands ? b->on_boundary[i] : -1;
    packet->on_primitive = b->on_primitive[i];
    packet->undeflected = b->undeflected[i];
    packet->beside = 0;
    packet->entered = b->entered[i];
    packet->fate = CML_FATE_ALIVE;
    packet->cause = CML_LOST_NOT;
    packet->queries = packet->shading_overruled = 0;
    packet->absorbed = packet->gained = packet->roulette = 0;
}

static void cml_store_ray(struct cml_bundle *b, int i, struct cml_vec p, struct cml_vec u)
{
    b->x[i] = p.x;
    b->y[i] = p.y;
    b->z[i] = p.z;
    b->ux[i] = u.x;
    b->uy[i] = u.y;
    b->uz[i] = u.z;
}

/* Back into the lane what boundary events can change. */
static void cml_store_packet(struct cml_flight *f, int i, const struct cml_packet *packet)
{
    struct cml_bundle *b = f->b;
    cml_store_ray(b, i, packet->p, packet->u);
    b->tau[i] = packet->tau;
    b->crossings[i] = packet->crossings;
    b->touched[i] = packet->interactions;
    b->bounces[i] = packet->bounces;
    b->boundary_events[i] = packet->boundary_events;
    b->on_boundary[i] = packet->on_boundary;
    b->on_primitive[i] = packet->on_primitive;
    b->undeflected[i] = packet->undeflected;
    b->entered[i] = packet->entered;
    if (packet->medium == b->medium[i]) return;
    cml_flush_deposits(f, i);
    b->medium[i] = packet->medium;
    cml_load_medium(f, i);
}

/* The lane's packet, about to interact, will stand within rounding of a mesh, as cml_interact says it. */
static void cml_store_beside(struct cml_bundle *b, int i, const struct cml_packet *packet)
{
    b->touched[i] = packet->interactions + 1;
    b->bounces[i] = 0;
    b->on_boundary[i] = packet->beside - 1;
    b->on_primitive[i] = CML_BESIDE_FACETS;
}

/* Inlined, so that the end goes from lane to collection without being built in memory: its members would be
 * stored one by one and loaded together, which stalls. */
__attribute__((always_inline)) static inline void cml_push_termination(struct cml_flight *f, int i,
                                                                       struct cml_termination end)
{
    cml_flush_deposits(f, i);
    end.absorbed = f->absorbed[i];
    cml_terminated_push(&f->world->setup, &f->terminated, &end, f->tally);
    f->b->task[i] = CML_LANE_ENDED;
    f->ended |= CML_LANE_BIT(i);
}

/* The lane's packet has ended where it is; lost, if there is a cause. */
static void cml_end_lane(struct cml_flight *f, int i, enum cml_fate fate, enum cml_lost_cause cause)
{
    const struct cml_bundle *b = f->b;
    const struct cml_termination end = {
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
    cml_push_termination(f, i, end);
}

/* Mask of the lanes with a task. */
static uint64_t cml_lanes_with(const struct cml_bundle *b, int task)
{
    uint64_t mask = 0;
    for (int first = 0; first < CML_LANES; first += CML_GROUP)
        mask |= (uint64_t)cml_group_equal(b->task + first, task) << first;
    return mask;
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

#endif
