/* New packets, into the lanes of those that have ended. Their first draws are made by the next pass, which
 * draws for all lanes anyway. SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_LAUNCH_H
#define CML_BUNDLE_LAUNCH_H

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
    CML_OF_MEDIUM(b, mfp)[i] = 1;
    CML_OF_MEDIUM(b, stop_above)[i] = -CML_INFINITY;
    CML_OF_MEDIUM(b, stop_below)[i] = CML_INFINITY;
    f->live &= ~CML_LANE_BIT(i);
}

/* The index of the lane's next packet; a lane for which there is none is parked. */
static void cml_take_index(struct cml_flight *f, int i)
{
    while (f->left == 0) {
        if (f->source->next(f->source->context, &f->next, &f->left)) continue;
        f->left = 0;
        cml_park_lane(f, i);
        return;
    }
    f->left--;
    f->b->index_low[i] = (cml_u32)f->next;
    f->b->index_high[i] = (cml_u32)(f->next++ >> 32);
}

/* What differs between packets or lanes: where a wide beam puts them, the columns of the medium. */
static void cml_fit_lane(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    const struct cml_packet *start = &f->start;
    if (!f->pencil) {
        cml_place(f->world, cml_lane_index(b, i), &f->start);
        cml_store_ray(b, i, start->p, start->u);
    }
    if (f->to.facets) cml_score_launch(f->world, &f->to, start);
    if (f->loaded & CML_LANE_BIT(i) && b->medium[i] == start->medium) return;
    f->loaded |= CML_LANE_BIT(i);
    b->medium[i] = start->medium;
    cml_load_medium(f, i);
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
    f->curved = (f->curved & ~CML_LANE_BIT(to)) | (f->curved >> from & 1u) << to;
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

/* Lanes whose packet has ended get new ones, as long as there are any. */
static void cml_refill(struct cml_flight *f)
{
    const uint64_t ended = f->ended;
    f->ended = 0;
    cml_for_lanes(f, ended, cml_take_index);
    const uint64_t fresh = ended & f->live;
    for (int first = 0; first < CML_LANES; first += CML_GROUP) {
        const cml_u32 group = (cml_u32)(fresh >> first) & CML_GROUP_MASK;
        if (group) cml_bundle_launch(f->b, &f->start, f->absorbed, first, group);
    }
    cml_for_lanes(f, fresh, cml_fit_lane);
    if (fresh != ended) cml_close_ranks(f);
}

#endif
