/* Code, included by each engine that walks packets one at a time on the host (engine_reference.c in double,
 * each level of engine_cpu_level.c and engine_opencl.c in float): ranges of packets into a tally, or as
 * records. So the walk of kernels/walk.h is compiled in the engine's precision and for its processor.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/branches_inl.h"
#include "engine/engine.h"
#include "engine/row_weights_inl.h"
#include "engine/terminated_packets_inl.h"
#include "walk.h"

/* Number of steps of a thread between two calls of cml_engine_gives_up. */
#define CML_STEPS_PER_LOOK 256

/* Begins the trail of a packet that has been launched (P13). */
static inline void cml_leave_trail(const struct cml_world *world, const struct cml_tally *tally,
                                   struct cml_packet *packet)
{
    packet->trail = (struct cml_trail){.stay = tally->stay};
    packet->low = cml_first_low(packet->path, packet->p.z);
    cml_begin_trail(world, &packet->trail, packet->medium, packet->path);
}

/* The rows (P16) of the packets that one thread walks, one after the other. */
struct row_walk {
    struct cml_row_sums sums;
    real *factor;                            /* [cml_row_factors] */
    int medium;                              /* medium of the last booking, or of a move inside since then */
    cml_u32 w;                               /* the packet's weight at the last booking */
    cml_u64 gained, roulette, backing, face; /* the packet's terms of the balance at the last booking */
    cml_u32 interactions, now;               /* the packet's interactions and weight after the last step */
};

/* Begins a packet's weights in all rows of a sweep, and remembers the packet's state, from which later steps
 * see what has changed. */
static inline void rows_begin(const struct cml_world *world, struct row_walk *rows, struct cml_packet *packet)
{
    const struct cml_row_packet its =
        cml_row_packet_of(&world->setup, &rows->sums, packet->index, rows->factor);
    cml_rows_launch(&its, packet->w, 1, packet->path);
    /* A path above 0 is that through the layers above the start. It is set to 0, because these layers
     * absorb in no row. A path below 0 means that the clock of the trail has not started; it stays if the
     * packet has a trail. */
    if (packet->path > 0 || !packet->trail.stay) packet->path = 0;
    rows->medium = packet->medium;
    rows->w = rows->now = packet->w;
    rows->gained = rows->roulette = rows->backing = rows->face = 0;
    rows->interactions = packet->interactions;
}

/* True if interaction n of a packet is one that makes up A(r,z) of rows. */
static inline bool rows_sample(const struct cml_world *world, cml_u64 index, cml_u32 n)
{
    const cml_u32 low = (cml_u32)index, high = (cml_u32)(index >> 32);
    return world->rows.part && cml_row_samples(cml_row_hash_of(&world->setup, low, high), n);
}

/* Books the packet's losses since the last booking. left: its weight before roulette or a surface took any.
 */
static inline void rows_fly(const struct cml_world *world, struct row_walk *rows,
                            const struct cml_row_packet *its, struct cml_packet *packet, cml_u32 left)
{
    cml_rows_fly(world, its, rows->medium, packet->path, packet->interactions, rows->w, left);
    cml_rows_pass_time(world, its, &packet->trail);
    packet->path = 0;
    rows->w = left;
}

/* Updates the rows' absorption by time before an interaction that lies in a later time gate than the last
 * update (P11). */
static inline void rows_keep_time(const struct cml_world *world, struct row_walk *rows,
                                  const struct cml_row_packet *its, struct cml_packet *packet)
{
    const real since = cml_row_booked_at(its->factor, (size_t)its->sums->count);
    const struct cml_gates gates = world->setup.gates;
    if (its->sums->timed && cml_gate(gates, since + packet->path) != cml_gate(gates, since))
        rows_fly(world, rows, its, packet, rows->now);
}

/* Updates the weights of all rows of a sweep after a step of a packet, for
 * absorption, roulette and what a backing kept (P12).
 * Rows are updated at the same events as by the vector loops (cml_flush_deposits), so that both add the same
 * rounded numbers. */
static inline void rows_step(const struct cml_world *world, struct row_walk *rows, struct cml_packet *packet)
{
    const struct cml_row_packet its =
        cml_row_packet_of(&world->setup, &rows->sums, packet->index, rows->factor);
    const cml_u32 gained = (cml_u32)(packet->gained - rows->gained),
                  lost = (cml_u32)(packet->roulette - rows->roulette),
                  faced = (cml_u32)(packet->face - rows->face),
                  kept = (cml_u32)(packet->backing - rows->backing) + faced;
    const cml_u32 left = packet->w - gained + lost + kept;
    const int inside = !cml_is_outer(world, packet->medium), moved = packet->medium != rows->medium && inside,
              back = inside && cml_rows_have_returned(world, &its, &packet->trail),
              interacted = packet->interactions != rows->interactions,
              sampled = interacted && rows_sample(world, packet->index, packet->interactions);
    if (interacted) rows_keep_time(world, rows, &its, packet);
    rows->interactions = packet->interactions;
    rows->now = packet->w;
    if (!moved && !back && !sampled && !(gained | lost | kept) && packet->fate == CML_FATE_ALIVE) return;
    const cml_u32 before = rows->w;
    rows_fly(world, rows, &its, packet, left);
    if (sampled)
        cml_rows_sample(world, &its, rows->medium, cml_rows_sampled_at(world, &its, rows->medium, packet->p),
                        before, left);
    if (kept)
        cml_rows_keep(&its, left, packet->w, faced > 0);
    else
        cml_rows_roulette(&its, left, packet->w);
    if (moved) rows->medium = packet->medium;
    rows->w = packet->w;
    rows->gained = packet->gained;
    rows->roulette = packet->roulette;
    rows->backing = packet->backing;
    rows->face = packet->face;
}

/* One thread's walk of packets, one after the other. */
struct piece_walk {
    const struct cml_world *world;
    const struct cml_work *work;
    struct cml_patience *patience;
    struct cml_tally *tally;
    struct cml_deposits to;
    struct row_walk rows;
    struct cml_terminated terminated;
    uint32_t steps;
};

/* Walks a packet to its end, and adds it to the tally. Returns false if the packet was given up. */
static inline bool end_packet(struct piece_walk *walk, struct cml_packet *packet)
{
    const struct cml_world *world = walk->world;
    while (packet->fate == CML_FATE_ALIVE) {
        if (++walk->steps % CML_STEPS_PER_LOOK == 0 && cml_engine_gives_up(walk->work, walk->patience))
            return false;
        cml_step(world, &walk->to, packet);
        if (walk->rows.sums.count) rows_step(world, &walk->rows, packet);
    }
    CML_ASSERT(world->windows.cells || cml_packet_balances(world, packet));
    cml_tally_events(packet, walk->tally);
    cml_end_visit(world, packet);
    const struct cml_termination end = cml_termination_of(packet);
    struct row_walk *rows = walk->rows.sums.count ? &walk->rows : NULL;
    struct cml_row_packet its;
    if (rows) its = cml_row_packet_of(&world->setup, &rows->sums, packet->index, rows->factor);
    cml_terminated_push(world, &walk->terminated, &end, rows ? &its : NULL, walk->tally);
    return true;
}

/* Walks all branches, parts of split packets that wait, to their ends (P19). Returns false if one was given
 * up. */
static inline bool end_branches(struct piece_walk *walk)
{
    while (walk->to.branches && walk->to.branches->count > 0) {
        struct cml_packet packet = {.trail = {.stay = walk->tally->stay}};
        cml_take_branch(walk->world, walk->to.branches, &packet);
        cml_next_flight(walk->world, &packet);
        if (!end_packet(walk, &packet)) return false;
    }
    return true;
}

/* Flies the packets of a piece, one after the other, into the tally. factor: [cml_row_factors], scratch;
 * branches: empty. Returns false if a packet was given up. */
static inline bool run_piece(const struct cml_world *world, const struct cml_work *work,
                             const struct cml_piece *piece, struct cml_patience *patience, real *factor,
                             struct cml_branches *branches, struct cml_tally *tally)
{
    struct piece_walk walk = {.world = world,
                              .work = work,
                              .patience = patience,
                              .tally = tally,
                              .to = cml_deposits_of(tally, branches),
                              .rows = {.sums = cml_row_sums_of(world, tally), .factor = factor}};
    branches->count = 0; /* may hold branches of a piece that was given up */
    for (uint64_t i = 0; i < piece->count; i++) {
        struct cml_packet packet;
        cml_begin_walk(world, &walk.to, piece->first + CML_NUM_BATCHES * i, &packet);
        if (tally->stay) cml_leave_trail(world, tally, &packet);
        if (walk.rows.sums.count) rows_begin(world, &walk.rows, &packet);
        if (!end_packet(&walk, &packet) || !end_branches(&walk)) return false;
    }
    cml_terminated_flush(world, &walk.terminated, tally);
    cml_tally_unsplit(branches, tally);
    return true;
}

/* The listener of a traced packet, with the world, which scene coordinates need. */
struct tracing {
    const struct cml_world *world;
    cml_trace_function *on_event;
    void *context;
    cml_u32 rough_draws; /* the packet's rough_draws at its last event */
};

/* Tells the listener which face or port a packet has met, before the event itself. Returns true if there is
 * no further event: the packet has been stopped. */
static bool trace_contact(const struct tracing *tracing, const char *what, const struct cml_packet *packet)
{
    const struct cml_world *world = tracing->world;
    const bool stops = strcmp(what, "stop") == 0, through = strcmp(what, "transmit") == 0;
    if (!world->contacts.count || packet->on_boundary != 0 || packet->bounces == 0) return false;
    if (!stops && !through && strcmp(what, "reflect") != 0) return false;
    const struct cml_source *source = cml_source_of(world, packet->index);
    const bool first = packet->boundary_events == 1 && source->medium == 0 && !source->inside;
    const int number = first && source->port ? source->port : cml_contact_at(world, packet->p.x, packet->p.y);
    const bool port = number > 0 && world->contacts.item[number - 1].is_port;
    const struct cml_trace_event event = {.what = stops  ? what
                                                  : port ? "through"
                                                         : "face",
                                          .contact = number};
    if (number > 0 && (stops || port == through)) tracing->on_event(tracing->context, &event);
    return stops;
}

/* Passes an event of kernels/walk.h on to the listener, in the coordinates of the scene. */
static void forward_event(void *context, const char *what, const struct cml_packet *packet)
{
    struct tracing *tracing = context;
    const struct cml_setup *setup = &tracing->world->setup;
    const struct cml_trace_event event = {
        .what = what,
        .medium = packet->medium,
        .position = {packet->p.x + setup->x0, packet->p.y + setup->y0,
                     packet->p.z + tracing->world->media[packet->medium].depth},
        .direction = {packet->u.x, packet->u.y, packet->u.z},
        .weight = packet->w * CML_WEIGHT_UNIT,
    };
    const cml_u32 draws =
        packet->rough_draws - tracing->rough_draws; /* one draw for each facet, and one to leave */
    const struct cml_trace_event rough = {.what = "rough", .steps = (int)draws - 1};
    if (draws > 0) tracing->on_event(tracing->context, &rough);
    tracing->rough_draws = packet->rough_draws;
    if (trace_contact(tracing, what, packet)) return;
    tracing->on_event(tracing->context, &event);
}

/* Returns the end of a packet, in shares of a packet and coordinates of the scene. */
static inline struct cml_fate_record record_of(const struct cml_world *world, const struct cml_packet *packet)
{
    const struct cml_fate_record record = {
        .fate = packet->fate,
        .cause = packet->cause,
        .weight = packet->w,
        .interactions = packet->interactions,
        .boundary_events = packet->boundary_events,
        .specular = cml_has_split_off(world, packet) * CML_WEIGHT_UNIT,
        .absorbed = (double)packet->absorbed * CML_WEIGHT_UNIT,
        .backing = (double)packet->backing * CML_WEIGHT_UNIT,
        .face = (double)packet->face * CML_WEIGHT_UNIT,
        .exit = {packet->exit_x + world->setup.x0, packet->exit_y + world->setup.y0},
        .direction = {packet->u.x, packet->u.y, packet->u.z},
    };
    return record;
}

/* Tells the listener which detectors have seen the packet, or a part split off at its launch (P13). */
static void trace_detectors(const struct tracing *tracing, const struct cml_packet *packet,
                            const struct cml_tally *tally)
{
    const struct cml_world *world = tracing->world;
    const struct cml_seen to = cml_seen_by(tally);
    const struct cml_exit exit =
        cml_exit_of(&world->setup, packet->fate, packet->exit_x, packet->exit_y, packet->u.z, packet->path);
    const struct cml_vec place = {packet->exit_x, packet->exit_y, packet->p.z};
    struct cml_light_out light = cml_light_of(&exit, place, packet->u, packet->w);
    if (packet->boundary_events > 0) cml_note_port(world, packet->index, &light.ray);
    cml_score_split_off(world, packet->index, 1, &to, NULL);
    if (cml_has_left(&exit)) cml_score_light(world, &light, NULL, &to, NULL);
    for (int k = 0; k < world->detection.num_detectors; k++) {
        const struct cml_trace_event seen = {
            .what = "detect", .detector = k, .weight = (double)to.detector[k] * CML_WEIGHT_UNIT};
        if (to.detector[k]) tracing->on_event(tracing->context, &seen);
    }
}

/* Finds the ends of packets [first, first + count): records[count]. Deposits go into a tally that is thrown
 * away, the smallest that the walk can write to; it has detectors if there is a listener. on_event may be
 * NULL. Fails if memory for the tally runs out. */
static inline cml_status trace_packets(const struct cml_world *world, uint64_t first, uint64_t count,
                                       cml_trace_function *on_event, void *context,
                                       struct cml_fate_record *records, struct cml_error *err)
{
    const struct cml_tally_grid grid = {.nr = 1,
                                        .nz = 1,
                                        .na = 1,
                                        .num_layers = world->setup.num_layers,
                                        .num_bodies = world->setup.num_bodies,
                                        .gates = on_event ? world->setup.gates.count : 0,
                                        .detectors = on_event ? world->detection.num_detectors : 0};
    struct cml_tally tally;
    CML_TRY(cml_tally_create(&grid, &tally, err));
    struct tracing tracing = {world, on_event, context, 0};
    struct cml_world traced = *world;
    traced.setup.tally_absorption = 0;
    traced.windows.cells = 0; /* a traced packet is never split */
    traced.on_event = on_event ? forward_event : NULL;
    traced.on_event_context = &tracing;
    const struct cml_deposits to = cml_deposits_of(&tally, NULL);
    for (uint64_t i = 0; i < count; i++) {
        struct cml_packet packet;
        cml_walk(&traced, &to, first + i, &packet);
        records[i] = record_of(world, &packet);
        if (tally.detector) trace_detectors(&tracing, &packet, &tally);
    }
    cml_tally_free(&tally);
    return CML_OK;
}
