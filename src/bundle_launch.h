/* New packets, into the lanes of those that have ended. Their first draws are made by the next pass, which
 * draws for all lanes anyway. SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_LAUNCH_H
#define CML_BUNDLE_LAUNCH_H

#include "bundle_aim.h"
#include "bundle_lanes.h"
#include "bundle_pass.h"

#include <string.h>

/* A lane without a packet takes part in every loop, and does nothing in any. */
static void cml_park_lane(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    const struct cml_vec nowhere = {0, 0, 0}, down = {0, 0, 1};
    cml_store_ray(b, i, nowhere, down);
    b->tau[i] = 0;
    b->w[i] = b->marked[i] = 0;
    b->task[i] = CML_LANE_DONE;
    b->medium[i] = 0;
    CML_OF_MEDIUM(b, mfp)[i] = 1;
    CML_OF_MEDIUM(b, stop_above)[i] = -CML_INFINITY;
    CML_OF_MEDIUM(b, stop_below)[i] = CML_INFINITY;
    f->live &= ~CML_LANE_BIT(i);
}

static cml_u32 cml_first_bits(cml_u32 mask, uint64_t count)
{
    cml_u32 rest = mask;
    if (count >= CML_GROUP) return mask;
    for (; count > 0; count--) rest &= rest - 1;
    return mask & ~rest;
}

/* The indices of the next packets of a group's lanes; lanes for which there are none are parked. Returns the
 * others. */
static cml_u32 cml_take_indices(struct cml_flight *f, int first, cml_u32 lanes)
{
    cml_u32 rest = lanes;
    while (rest && (f->left > 0 || f->source->next(f->source->context, &f->next, &f->left))) {
        const cml_u32 fresh = cml_first_bits(rest, f->left);
        const uint64_t count = (uint64_t)__builtin_popcount(fresh);
        cml_bundle_number(f->b, f->next, first, fresh);
        f->next += count;
        f->left -= count;
        rest &= ~fresh;
    }
    cml_for_lanes(f, (uint64_t)rest << first, cml_park_lane);
    return lanes & ~rest;
}

/* P1 where every packet of the beam starts elsewhere, and where facets are asked for. */
static void cml_place_lane(struct cml_flight *f, int i)
{
    struct cml_packet *start = &f->start;
    if (!f->pencil) {
        cml_place(f->world, cml_lane_index(f->b, i), start);
        cml_store_ray(f->b, i, start->p, start->u);
    }
    if (f->to.facets) cml_score_launch(f->world, &f->to, start);
}

/* Lane `from` into lane `to`, which holds no packet. All columns are 4 bytes wide and follow one another. */
static void cml_move_lane(struct cml_flight *f, int from, int to)
{
    const size_t first = offsetof(struct cml_bundle, x), column = sizeof f->b->x;
    for (size_t k = first; k + column <= sizeof *f->b; k += column) {
        char *lanes = (char *)f->b + k;
        memcpy(lanes + sizeof(real) * (size_t)to, lanes + sizeof(real) * (size_t)from, sizeof(real));
    }
    f->absorbed[to] = f->absorbed[from];
    f->live |= CML_LANE_BIT(to);
}

/* Nothing is left to launch: the packets in flight move together, so that passes need not go over lanes
 * without one. */
static void cml_close_ranks(struct cml_flight *f)
{
    const int lanes = (__builtin_popcountll(f->live) + CML_GROUP - 1) / CML_GROUP * CML_GROUP;
    if (lanes == f->b->lanes) return;
    for (int from = lanes; from < f->b->lanes; from++) {
        if (f->live >> from & 1u) cml_move_lane(f, from, __builtin_ctzll(~f->live));
        cml_park_lane(f, from);
    }
    f->b->lanes = lanes;
}

/* Packets like `start` for lanes of a group, which mostly are in its medium already. */
static void cml_launch_like(struct cml_flight *f, const struct cml_packet *start, int first, cml_u32 fresh)
{
    struct cml_bundle *b = f->b;
    cml_u32 elsewhere = fresh & ~cml_group_equal(b->medium + first, start->medium);
    cml_bundle_launch(b, start, f->absorbed, first, fresh);
    for (; elsewhere; elsewhere &= elsewhere - 1) {
        const int i = first + __builtin_ctz(elsewhere);
        b->medium[i] = start->medium;
        cml_load_medium(f, i);
    }
}

/* New packets for lanes of a group. */
static void cml_launch_group(struct cml_flight *f, int first, cml_u32 lanes)
{
    const cml_u32 fresh = cml_take_indices(f, first, lanes);
    cml_u32 inside = f->enters ? fresh : 0;
    if (inside && f->reflectance > 0)
        inside &= cml_bundle_go_through(&f->world->setup, f->b, first, f->reflectance);
    if (inside) cml_launch_like(f, &f->inside, first, inside);
    if (fresh & ~inside) cml_launch_like(f, &f->start, first, fresh & ~inside);
    if (!f->pencil || f->to.facets) cml_for_lanes(f, (uint64_t)fresh << first, cml_place_lane);
}

/* Lanes whose packet has ended get new ones, as long as there are any. */
static void cml_refill(struct cml_flight *f)
{
    const uint64_t ended = f->ended;
    f->ended = 0;
    for (int first = 0; first < CML_LANES; first += CML_GROUP) {
        const cml_u32 lanes = (cml_u32)(ended >> first) & CML_GROUP_MASK;
        if (lanes) cml_launch_group(f, first, lanes);
    }
    if (ended & ~f->live) cml_close_ranks(f);
}

#endif
