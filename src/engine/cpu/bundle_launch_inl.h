/* Code, included by bundle_walk_inl.h only: launches new packets into the lanes of packets that have ended.
 *
 *      source of photons --> cml_fill_queue --> launch queue, 64 photons --> cml_launch_group --> lanes
 *                                                   | ballistic packets are counted, and get no lane
 *
 * It is compiled once for each level of the processor (engine_cpu_level.c says why).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/cpu/bundle_lanes_inl.h"
#include "engine/cpu/bundle_loops_inl.h"
#include "engine/cpu/bundle_place_inl.h"

#include <string.h>

/* Makes a lane without a packet harmless. It takes part in every loop, but its weight 0 deposits nothing, and
 * in a medium without boundaries it meets none, whatever path it draws. */
static void cml_park_lane(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    const struct cml_vec nowhere = {0, 0, 0}, down = {0, 0, 1};
    cml_store_ray(b, i, nowhere, down);
    b->tau[i] = 0;
    b->w[i] = b->flushed_w[i] = 0;
    b->task[i] = CML_LANE_TO_FLY;
    b->medium[i] = 0;
    CML_OF_MEDIUM(b, mfp)[i] = 1;
    CML_OF_MEDIUM(b, stop_above)[i] = CML_OF_MEDIUM(b, start_above)[i] = -CML_INFINITY;
    CML_OF_MEDIUM(b, stop_below)[i] = CML_OF_MEDIUM(b, start_below)[i] = CML_INFINITY;
    f->live &= ~CML_LANE_BIT(i);
    f->late &= ~CML_LANE_BIT(i);
}

/* Draws the optical depths of the queue that cml_queue_draw has found in the tail of the exponential
 * law and left infinite (P2). next: index of the first photon of the queue; a batch has every
 * CML_NUM_BATCHES-th photon. */
static void cml_queue_draw_tails(struct cml_stream stream, uint64_t next, struct cml_launch_queue *queue)
{
    for (int i = 0; i < CML_QUEUE; i++)
        if (!(queue->tau[i] < CML_INFINITY))
            queue->tau[i] = cml_optical_depth(stream, next + CML_NUM_BATCHES * (uint64_t)i, 0, 0);
}

/* Counts ballistic packets (that pass the first medium without an interaction) among the first `count` of
 * the queue, and drops them: all end alike, so one end times their number is added with their batch. Returns
 * the number of packets left. */
static int cml_count_ballistic(struct cml_flight *f, int count)
{
    struct cml_launch_queue *queue = &f->queue;
    struct cml_ballistic *like = &f->ballistic;
    int at = 0;
    cml_queue_find_not_ballistic(&f->world->setup, like->path, like->mfp, like->crossings, like->reflectance,
                                 queue);
    for (int first = 0; first < count; first += CML_GROUP) {
        const cml_u32 here = count - first < CML_GROUP ? (1u << (count - first)) - 1 : CML_GROUP_MASK;
        const cml_u32 stay = cml_group_equal(queue->not_ballistic + first, 1) & here;
        cml_group_pack(queue->index_low + first, stay, queue->index_low + at);
        cml_group_pack(queue->index_high + first, stay, queue->index_high + at);
        cml_group_pack(queue->reversed + first, stay, queue->reversed + at);
        cml_group_pack(queue->tau + first, stay, queue->tau + at);
        cml_group_pack(queue->draw1 + first, stay, queue->draw1 + at);
        cml_group_pack(queue->draw2 + first, stay, queue->draw2 + at);
        cml_group_pack(queue->through + first, stay, queue->through + at);
        at += __builtin_popcount(stay);
    }
    like->count += (uint64_t)(count - at);
    return at;
}

/* Ends the batch under way: brings the collection and the ballistic packets into the tally, and tells the
 * source that the tally holds all scores of the batch so far, with those of late packets. Ballistic packets
 * have only been counted: their one end is added as often as they were. */
static void cml_end_batch(struct cml_flight *f)
{
    cml_terminated_flush(f->world, &f->terminated, f->tally);
    if (f->ballistic.count > 0) {
        /* The index of a batch's first photon: it tells the group. */
        f->ballistic.end.index = (uint64_t)f->batch;
        cml_terminated_push(f->world, &f->terminated, &f->ballistic.end, NULL, f->tally);
        cml_terminated_flush_times(f->world, &f->terminated, f->ballistic.count, f->tally);
        f->ballistic.count = 0;
    }
    if (f->batch >= 0) f->source->end_batch(f->source->context, f->batch, f->tally);
    cml_tally_drop_late(f->tally);
}

/* Begins another batch. Packets in flight are late from here on. The bundle does not wait for their ends, so
 * it stays full. Lanes whose packets have ended count as late until they are refilled. */
static void cml_begin_batch(struct cml_flight *f, int batch)
{
    const struct cml_bundle *b = f->b;
    cml_end_batch(f);
    f->late = f->batch >= 0 ? f->live : 0;
    for (uint64_t rest = f->late; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        f->late_profiles[i] = cml_tally_late(f->tally, (int)(b->index_low[i] % CML_NUM_BATCHES));
    }
    f->batch = batch;
    f->first_cell = cml_first_cell(&f->to, (cml_u64)batch);
}

/* Takes the next photons in hand, with the shifts that they share. Returns 0 if there are none. */
static int cml_take_photons(struct cml_flight *f)
{
    if (!f->source->next(f->source->context, &f->next, &f->left)) return 0;
    const cml_u32 low = (cml_u32)f->next, high = (cml_u32)(f->next >> 32);
    const int batch = (int)(low % CML_NUM_BATCHES);
    if (batch != f->batch) cml_begin_batch(f, batch);
    for (cml_u32 e = 0; e < CML_LATTICE_BLOCKS; e++)
        f->queue.shifts[e] = cml_lattice_shifts(f->world->setup.stream, low, high, e);
    return 1;
}

/* Fills the queue of photons to launch if it is empty, with draws, places and entry into the first layer.
 * Returns 0 if there are no more photons. */
static int cml_fill_queue(struct cml_flight *f)
{
    struct cml_launch_queue *queue = &f->queue;
    const struct cml_stream stream = f->world->setup.stream;
    while (queue->first >= queue->end) {
        if (f->left == 0 && !cml_take_photons(f)) return 0;
        const int count = f->left < CML_QUEUE ? (int)f->left : CML_QUEUE;
        if (cml_queue_draw(&f->world->setup, f->next, f->enters ? f->reflectance : (real)0, queue))
            cml_queue_draw_tails(stream, f->next, queue);
        if (f->queue_places) cml_queue_place(f->world, queue);
        if (f->queue_places && f->enters) cml_queue_enter(f->world, f->start.p.z, queue);
        f->next += CML_NUM_BATCHES * (uint64_t)count;
        f->left -= (uint64_t)count;
        queue->first = 0;
        queue->end = f->ballistic.possible ? cml_count_ballistic(f, count) : count;
    }
    return 1;
}

/* Returns the lowest `count` bits that are set in a mask. */
static cml_u32 cml_first_bits(cml_u32 mask, int count)
{
    cml_u32 rest = mask;
    if (__builtin_popcount(mask) <= count) return mask;
    for (; count > 0; count--) rest &= rest - 1;
    return mask & ~rest;
}

/* Sets the path that the lane's packet has behind it. Its rows begin at the packet's place, because the
 * layers above absorb in no row (P16). */
static void cml_launch_path(struct cml_flight *f, int i, real path)
{
    f->b->path[i] = f->factors && !f->b->stay ? (real)0 : path;
    if (f->factors) cml_launch_lane_rows(f, i, 1, path);
}

/* Sets weight, medium and path of a lane's packet as cml_place does, if they may differ from those of the
 * lanes beside it. */
static void cml_launch_elsewhere(struct cml_flight *f, int i, const struct cml_packet *start)
{
    struct cml_bundle *b = f->b;
    if (f->world->setup.apart) cml_add_specular(&f->to, start->index, CML_WEIGHT_ONE - start->w);
    /* Takes back the launch with the weight of the other lanes. */
    if (f->factors) cml_launch_lane_rows(f, i, -1, 0);
    b->w[i] = b->flushed_w[i] = start->w;
    b->entered[i] = start->entered;
    cml_launch_path(f, i, start->path);
    if (b->medium[i] == start->medium) return;
    b->medium[i] = start->medium;
    cml_load_medium(f, i);
}

/* Places the packet of one lane (P1), if the queue does not, and scores its launch for facets and fluence. */
static void cml_place_lane(struct cml_flight *f, int i)
{
    struct cml_packet *start = &f->start;
    if (!f->pencil) {
        cml_place(f->world, cml_lane_index(f->b, i), start);
        cml_store_ray(f->b, i, start->p, start->u);
        if (f->elsewhere) cml_launch_elsewhere(f, i, start);
    }
    start->index = cml_lane_index(f->b, i);
    if (f->to.facets) cml_score_launch(f->world, &f->to, start);
    if (!f->to.phi) return;
    cml_mark_first(f->world, &f->to, start);
    f->b->mark[i] = start->mark;
}

/* Begins the record of a new packet's path (trail, P13) in lane i: lengths and momentum 0, and the depth of
 * the start. */
static void cml_begin_lane_trail(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    struct cml_trail trail = cml_lane_trail(b, i);
    cml_begin_trail(f->world, &trail, b->medium[i], b->path[i]);
    b->deepest[i] = trail.deepest;
    b->here[i] = b->momentum[i] = 0;
    b->low[i] = cml_first_low(b->path[i], b->z[i]);
    b->before[i] = 0;
    /* With rows the path counts from here, as in cml_launch_path. */
    if (f->factors && b->path[i] > 0) b->path[i] = 0;
}

/* Copies the trail of lane `from` into that of lane `to` (P13). */
static void cml_move_trail(const struct cml_bundle *b, int from, int to)
{
    const struct cml_trail old = cml_lane_trail(b, from), new = cml_lane_trail(b, to);
    memcpy(new.stay, old.stay, (size_t)b->num_media * sizeof *old.stay);
}

/* Moves lane `from` to lane `to`, which holds no packet: every column of the structure of arrays. All columns
 * are 4 bytes wide and follow one another from x on. */
static void cml_move_lane(struct cml_flight *f, int from, int to)
{
    const size_t first = offsetof(struct cml_bundle, x), column = sizeof f->b->x;
    for (size_t k = first; k + column <= sizeof *f->b; k += column) {
        char *lanes = (char *)f->b + k;
        memcpy(lanes + sizeof(real) * (size_t)to, lanes + sizeof(real) * (size_t)from, sizeof(real));
    }
    if (f->b->stay) cml_move_trail(f->b, from, to);
    if (f->factors)
        memcpy(cml_lane_factors(f, to), cml_lane_factors(f, from),
               cml_row_factors((size_t)f->rows.count) * sizeof(real));
    f->absorbed[to] = f->absorbed[from];
    f->late_profiles[to] = f->late_profiles[from];
    f->late |= (f->late >> from & 1u) << to;
    f->live |= CML_LANE_BIT(to);
}

/* Compacts the lanes when nothing is left to launch: packets in flight move together into as few groups of
 * lanes as they fill, and passes no longer go over the others. Without it each of the last packets of a range
 * would cost as much as a whole bundle. */
static void cml_compact_lanes(struct cml_flight *f)
{
    const int lanes = (__builtin_popcountll(f->live) + CML_GROUP - 1) / CML_GROUP * CML_GROUP;
    if (lanes == f->b->lanes) return;
    for (int from = lanes; from < f->b->lanes; from++) {
        if (f->live >> from & 1u) cml_move_lane(f, from, __builtin_ctzll(~f->live));
        cml_park_lane(f, from);
    }
    f->b->lanes = lanes;
}

/* Launches packets like `start` into lanes of a group. Most lanes held packets that ended in the medium where
 * new ones start, so their columns of the medium are right already. The others load them. */
static void cml_launch_like(struct cml_flight *f, const struct cml_packet *start, int first, cml_u32 lanes)
{
    struct cml_bundle *b = f->b;
    cml_u32 elsewhere = lanes & ~cml_group_equal(b->medium + first, start->medium);
    CML_HOOK_LANES(CML_HOOK_LAUNCH, __builtin_popcount(lanes));
    cml_bundle_launch(b, start, f->absorbed, first, lanes);
    for (cml_u32 rest = f->world->setup.keeps_paths ? lanes : 0; rest; rest &= rest - 1)
        cml_launch_path(f, first + __builtin_ctz(rest), start->path);
    for (cml_u32 rest = f->to.branches ? lanes : 0; rest; rest &= rest - 1)
        b->spent[first + __builtin_ctz(rest)] = start->spent;
    for (; elsewhere; elsewhere &= elsewhere - 1) {
        const int i = first + __builtin_ctz(elsewhere);
        b->medium[i] = start->medium;
        cml_load_medium(f, i);
    }
}

/* Returns the mask of a group's lanes whose packets of the queue are transmitted at the first boundary. */
static cml_u32 cml_lanes_transmitted_first(const struct cml_launch_queue *queue, cml_u32 lanes)
{
    _Alignas(64) int through[CML_GROUP] = {0};
    cml_group_unpack(queue->through + queue->first, lanes, through);
    return cml_group_equal(through, 1);
}

/* Gives new packets in a group of lanes their evenly spread words of the lattice, which replace random
 * ones. */
static void cml_launch_lattice(struct cml_flight *f, int first, cml_u32 lanes)
{
    const struct cml_launch_queue *queue = &f->queue;
    _Alignas(64) cml_u32 reversed[CML_GROUP] = {0};
    cml_group_unpack(queue->reversed + queue->first, lanes, reversed);
    cml_bundle_launch_lattice(f->b, reversed, queue->shifts, first, lanes);
}

/* Moves the places and directions of launched packets (P1) from the queue, where entry `at` is the next one,
 * into those lanes of a group that are free: the bits of `lanes`. first: the group's first lane. All start
 * at the same depth. */
static void cml_launch_placed(struct cml_flight *f, int at, int first, cml_u32 lanes)
{
    struct cml_bundle *b = f->b;
    const struct cml_launch_queue *queue = &f->queue;
    cml_group_unpack(queue->x + at, lanes, b->x + first);
    cml_group_unpack(queue->y + at, lanes, b->y + first);
    if (f->world->sources->light == CML_LIGHT_PARALLEL) return;
    cml_group_unpack(queue->ux + at, lanes, b->ux + first);
    cml_group_unpack(queue->uy + at, lanes, b->uy + first);
    cml_group_unpack(queue->uz + at, lanes, b->uz + first);
}

/* Launches packets of the queue into lanes of a group; the queue holds enough. Columns are unpacked: values
 * that lie side by side go to the lanes of the mask, in order. Packets that are transmitted at the first
 * boundary start behind it. late: lanes whose batch is closed. Packets of other sources than a pencil get
 * their places at last; so do those of a pencil if the flight from the source is scored. */
static void cml_launch_from_queue(struct cml_flight *f, int first, cml_u32 lanes)
{
    struct cml_bundle *b = f->b;
    struct cml_launch_queue *queue = &f->queue;
    const int at = queue->first;
    cml_group_unpack(queue->index_low + at, lanes, b->index_low + first);
    cml_group_unpack(queue->index_high + at, lanes, b->index_high + first);
    cml_group_unpack(queue->draw1 + at, lanes, b->draw1 + first);
    cml_group_unpack(queue->draw2 + at, lanes, b->draw2 + first);
    cml_group_unpack(queue->tau + at, lanes, b->tau + first);
    if (f->world->setup.stream.lattice) cml_launch_lattice(f, first, lanes);
    const cml_u32 inside = f->enters ? cml_lanes_transmitted_first(queue, lanes) : 0;
    queue->first += __builtin_popcount(lanes);
    f->late &= ~((uint64_t)lanes << first);
    if (inside) cml_launch_like(f, &f->inside, first, inside);
    if (lanes & ~inside) cml_launch_like(f, &f->start, first, lanes & ~inside);
    if (f->queue_places)
        cml_launch_placed(f, at, first, lanes);
    else if (!f->pencil || f->to.facets || f->to.phi)
        cml_for_lanes(f, (uint64_t)lanes << first, cml_place_lane);
    if (b->stay) cml_for_lanes(f, (uint64_t)lanes << first, cml_begin_lane_trail);
}

/* Launches the branch that was split off last into lane i (P19). A branch of a batch that is closed counts
 * as late. */
static void cml_launch_branch(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    struct cml_packet packet = {.trail = cml_lane_trail(b, i)};
    cml_take_branch(f->world, f->to.branches, &packet);
    const int batch = (int)(packet.index % CML_NUM_BATCHES), first = i / CML_GROUP * CML_GROUP;
    cml_next_flight(f->world, &packet);
    cml_launch_like(f, &packet, first, 1u << (i - first));
    b->index_low[i] = (cml_u32)packet.index;
    b->index_high[i] = (cml_u32)(packet.index >> 32);
    b->draw1[i] = packet.draw.w[1];
    b->draw2[i] = packet.draw.w[2];
    b->tau[i] = packet.tau;
    b->interactions[i] = packet.interactions;
    b->interactions_at_hit[i] = packet.on_boundary < 0 ? ~0u : packet.interactions;
    b->off_x[i] = packet.off.x;
    b->off_y[i] = packet.off.y;
    b->off_z[i] = packet.off.z;
    b->mark[i] = packet.mark;
    b->here[i] = packet.here;
    b->low[i] = packet.low;
    b->momentum[i] = packet.momentum;
    b->before[i] = packet.before;
    b->deepest[i] = packet.trail.deepest;
    f->late &= ~CML_LANE_BIT(i);
    if (batch == f->batch) return;
    f->late |= CML_LANE_BIT(i);
    f->late_profiles[i] = cml_tally_late(f->tally, batch);
}

/* Launches new packets into lanes of a group, branches before photons, and fills the queue as often as
 * needed. Lanes for which there are no packets are parked. */
static void cml_launch_group(struct cml_flight *f, int first, cml_u32 lanes)
{
    if (f->to.branches)
        for (; f->to.branches->count > 0 && lanes; lanes &= lanes - 1)
            cml_launch_branch(f, first + __builtin_ctz(lanes));
    while (lanes && cml_fill_queue(f)) {
        const cml_u32 now = cml_first_bits(lanes, f->queue.end - f->queue.first);
        cml_launch_from_queue(f, first, now);
        lanes &= ~now;
    }
    cml_for_lanes(f, (uint64_t)lanes << first, cml_park_lane);
}

/* Refills the lanes whose packet has ended, as long as there are packets, because vectors pay only in a full
 * bundle. */
static void cml_refill(struct cml_flight *f)
{
    const uint64_t ended = f->ended;
    f->ended = 0;
    for (int first = 0; first < CML_LANES; first += CML_GROUP) {
        const cml_u32 lanes = (cml_u32)(ended >> first) & CML_GROUP_MASK;
        if (lanes) cml_launch_group(f, first, lanes);
    }
    if (ended & ~f->live) cml_compact_lanes(f);
}
