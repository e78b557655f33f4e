/* Code, included by engine_cpu_level.c only and so compiled once for each level of the processor: a .c file
 * of its own could not be inlined into, and loops over lanes are vectors only where all that they call is
 * inlined. The pass over a bundle: what the lanes of one thread do, in order, until there are no more
 * packets. SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_WALK_INL_H
#define CML_BUNDLE_WALK_INL_H

#include "engine/cpu/bundle_checks_inl.h"
#include "engine/cpu/bundle_launch_inl.h"
#include "engine/cpu/bundle_curved_search_inl.h"
#include "engine/cpu/bundle_prepare.h"

/* Through a plane into another layer. */
static void cml_enter_layer(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    const int upwards = b->uz[i] < 0, medium = b->medium[i] + 1 - 2 * upwards;
    const real span = f->media[medium].span;
    cml_flush_deposits(f, i);
    b->medium[i] = medium;
    b->entered[i] = 1;
    b->z[i] = (real)upwards * span; /* no branch: up and down come at random */
    b->task[i] = CML_LANE_DONE;
    cml_load_medium(f, i);
}

/* P6: packets of a group that leave through a plane, into the collection of those that have ended. They are
 * not moved out of their media any more: until the lanes are refilled they hold nothing of interest. */
static void cml_exit_group(struct cml_flight *f, int first, cml_u32 exits)
{
    const struct cml_bundle *b = f->b;
    const struct cml_setup *setup = &f->world->setup;
    struct cml_terminated *terminated = &f->terminated;
    const int at = terminated->count;
    _Alignas(64) cml_u32 deposit[CML_GROUP];
    _Alignas(64) int fate[CML_GROUP];
#pragma omp simd
    for (int k = 0; k < CML_GROUP; k++) {
        deposit[k] = b->flushed_w[first + k] - b->w[first + k];
        const int gone = b->uz[first + k] < 0 ? CML_FATE_REFLECTED : CML_FATE_TRANSMITTED;
        fate[k] = b->entered[first + k] ? gone : CML_FATE_SPECULAR;
    }
    cml_group_pack(deposit, exits, terminated->deposit + at);
    cml_group_pack(fate, exits, terminated->fate + at);
    cml_group_pack_wide(f->absorbed + first, exits, terminated->absorbed + at);
    cml_group_pack(b->x + first, exits, terminated->exit_x + at);
    cml_group_pack(b->y + first, exits, terminated->exit_y + at);
    cml_group_pack(b->uz + first, exits, terminated->uz + at);
    cml_group_pack(b->w + first, exits, terminated->w + at);
    cml_group_pack(b->interactions + first, exits, terminated->interactions + at);
    cml_group_pack(b->boundary_events + first, exits, terminated->boundary_events + at);
    terminated->count = at + __builtin_popcount(exits);
    CML_ASSERT(((uint64_t)exits << first & (f->ended | ~f->live)) == 0);
    f->ended |= (uint64_t)exits << first;
    if (cml_tallies_places(f->tally))
        for (int i = at; i < terminated->count; i++) cml_tally_places(setup, terminated, i, 0, f->tally);
    cml_terminated_make_room(setup, terminated, f->tally);
}

/* Nothing ahead, or the bounds of cml_count_bounce. */
static void cml_handle_limit(struct cml_flight *f, int i)
{
    const struct cml_bundle *b = f->b;
    if (b->task[i] == CML_LANE_NOWHERE) {
        cml_process_lane(f, i);
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
    cml_flush_deposits(f, i);
    b->w[i] = b->flushed_w[i] = packet.w;
    if (packet.fate == CML_FATE_ALIVE) return;
    b->interactions[i]++;
    cml_end_lane(f, i, CML_FATE_ABSORBED, CML_LOST_NOT);
}

/* Facets of planes: what lanes have met, where facets are asked for. Reflection has turned the direction
 * already. */
static void cml_score_planes(const struct cml_flight *f)
{
    const struct cml_bundle *b = f->b;
    for (int i = 0; i < b->lanes; i++) {
        const int through = b->task[i] == CML_LANE_TRANSMITTED, upwards = b->uz[i] < 0, m = b->medium[i];
        const int boundary = through == upwards ? m - 1 : m, beyond = upwards ? m - 1 : m + 1;
        if (!through && b->task[i] != CML_LANE_REFLECTED) continue;
        cml_score_facet(f->world, &f->to, boundary, 0, b->x[i], b->y[i], m, through ? beyond : m, b->w[i]);
    }
}

static void cml_handle_limits(struct cml_flight *f)
{
    for (int i = 0; i < f->b->lanes; i++)
        if (cml_lane_is_at_limit(f->b, i, f->world->setup.num_layers)) cml_handle_limit(f, i);
}

/* Planes met by the lanes that are NEAR. Then they fly once more, so that they may interact in this pass as
 * well. */
static void cml_cross_planes(struct cml_flight *f)
{
    const struct cml_setup *setup = &f->world->setup;
    struct cml_bundle *b = f->b;
    CML_HOOK_LANES(CML_HOOK_PLANES, b->lanes);
    const int any = cml_bundle_reach_planes(b);
    if (any & CML_ANY_AT_PLANE) cml_bundle_reflect_or_refract(setup, b);
    if (f->to.facets) cml_score_planes(f);
    if (any & CML_ANY_AT_LIMIT) cml_handle_limits(f);
    for (int first = 0; first < b->lanes; first += CML_GROUP) {
        const cml_u32 exits = cml_group_leaves(b, first, setup->num_layers);
        if (exits) cml_exit_group(f, first, exits);
        const cml_u32 enter = cml_group_equal(b->task + first, CML_LANE_TRANSMITTED) & ~exits;
        cml_for_lanes(f, (uint64_t)enter << first, cml_enter_layer);
    }
    if (f->ended) cml_refill(f);
    cml_bundle_fly_again(b);
}

/* Those of the lanes whose optical depth lies in the tail. */
static uint64_t cml_lanes_in_tail(const struct cml_flight *f, uint64_t lanes)
{
    uint64_t tails = 0;
    for (uint64_t rest = lanes; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        if (!(f->b->tau[i] < CML_INFINITY)) tails |= CML_LANE_BIT(i);
    }
    return tails;
}

/* The planes' loops take as long for one lane as for all, so lanes at a plane wait for others: until they
 * have waited as many passes, summed over lanes, as the loops take time, by measurement. For arrivals at
 * random that comes close to the least cost of waiting and loops together. Returns 1 when lanes have flown
 * on. */
static int cml_process_planes(struct cml_flight *f)
{
    const int patience = f->b->lanes == CML_LANES ? 45 : 1;
    f->waited += __builtin_popcountll(cml_lanes_with(f->b, CML_LANE_NEAR));
    if (f->waited < patience) return 0;
    f->waited = 0;
    cml_cross_planes(f);
    return 1;
}

/* Lanes that can meet a curved boundary before they interact. */
static void cml_process_curved_boundaries(struct cml_flight *f)
{
    CML_HOOK_BEGIN(CML_HOOK_CLASSIFY);
    const int any = cml_bundle_classify_near(f->b, f->steepest);
    CML_HOOK_END(CML_HOOK_CLASSIFY);
    if (!any) return;
    CML_HOOK_BEGIN(CML_HOOK_CURVED);
    cml_process_curved(f);
    CML_HOOK_END(CML_HOOK_CURVED);
}

/* tails: lanes whose optical depth lies in the tail. */
static void cml_process_boundaries(struct cml_flight *f, uint64_t tails)
{
    cml_for_lanes(f, tails, cml_process_lane);
    do {
        if (f->curves) cml_process_curved_boundaries(f);
    } while (cml_process_planes(f));
}

/* Into the thread's own A_rz, or into one that all threads share. By groups, which a compiler unrolls. */
static void cml_scatter_deposits(const struct cml_bundle *b, const struct cml_tally *tally)
{
    uint64_t *A_rz = tally->A_rz;
    if (tally->grid.absorption)
        for (int first = 0; first < b->lanes; first += CML_GROUP)
            for (int k = first; k < first + CML_GROUP; k++) A_rz[(cml_u32)b->cell[k]] += b->dw[k];
    else
        for (int i = 0; i < b->lanes; i++) cml_add_shared(&A_rz[b->cell[i]], b->dw[i]);
}

/* The same into the volume, where one is asked for. */
static void cml_scatter_volume(const struct cml_flight *f)
{
    const struct cml_bundle *b = f->b;
    for (int i = 0; i < b->lanes; i++) {
        const struct cml_vec p = {b->x[i], b->y[i], b->z[i]};
        if (b->dw[i]) cml_deposit_volume(&f->world->setup, &f->to, p, CML_OF_MEDIUM(b, bins)[i], b->dw[i]);
    }
}

static void cml_flight_interact(struct cml_flight *f)
{
    const struct cml_setup *setup = &f->world->setup;
    int low;
    if (f->tally->A_rz) {
        low = cml_bundle_interact(setup, f->b);
        cml_scatter_deposits(f->b, f->tally);
        if (f->to.A_xyz) cml_scatter_volume(f);
    } else {
        low = cml_bundle_scatter(setup, f->b);
    }
    if (low) cml_for_lanes(f, cml_lanes_below_threshold(f->b) & f->live, cml_lane_roulette);
}

/* Returns the lanes in the tail. A lane without a packet draws like the others, but meets nothing. */
static uint64_t cml_park_dead_lanes(struct cml_flight *f)
{
    const uint64_t tails = cml_lanes_in_tail(f, cml_lanes_with(f->b, CML_LANE_NEAR));
    cml_for_lanes(f, tails & ~f->live, cml_park_lane);
    return tails & f->live;
}

static void cml_flight_pass(struct cml_flight *f)
{
    CML_HOOK_LANES(CML_HOOK_PASS, f->b->lanes);
    cml_bundle_draw(&f->world->setup, f->b);
    const int any = cml_bundle_fly(f->b);
    if (any) cml_process_boundaries(f, any & CML_ANY_TAIL ? cml_park_dead_lanes(f) : 0);
    cml_flight_interact(f);
    CML_ASSERT(cml_lanes_are_sound(f));
    if (f->ended) cml_refill(f);
}

/* f holds world, bundle (all 0), tally, media and source: the first packets take their lanes.
 */
static void cml_flight_begin(struct cml_flight *f)
{
    const struct cml_setup *setup = &f->world->setup;
    f->to = cml_deposits_of(f->tally);
    for (int i = 0; i <= setup->num_layers; i++) {
        const struct cml_surface *surface = &f->world->surfaces[i];
        if (surface->kind == CML_SURFACE_PLANE) continue;
        f->curves = 1;
        f->steepest = surface->steepest > f->steepest ? surface->steepest : f->steepest;
    }
    f->pencil = !(setup->disk > 0) && !(setup->gauss > 0);
    cml_place(f->world, 0, &f->start);
    cml_find_first_hit(f);
    cml_find_ballistic(f);
    f->b->lanes = CML_LANES;
    for (int i = 0; i < CML_LANES; i++) {
        f->b->medium[i] = -1; /* no columns yet */
        CML_OF_MEDIUM(f->b, start_above)[i] = -CML_INFINITY;
        CML_OF_MEDIUM(f->b, start_below)[i] = CML_INFINITY;
    }
    f->live = f->ended = ~(uint64_t)0;
    cml_refill(f);
}

/* Until the last packet has ended. */
static void cml_flight_run(struct cml_flight *f)
{
    const struct cml_setup *setup = &f->world->setup;
    while (f->live) cml_flight_pass(f);
    cml_terminated_flush(setup, &f->terminated, f->tally);
    if (f->ballistic.count == 0) return;
    cml_terminated_push(setup, &f->terminated, &f->ballistic.end, f->tally);
    cml_terminated_flush_times(setup, &f->terminated, f->ballistic.count, f->tally);
}

/* Everything goes into `tally`. media: [num_layers + 2]. */
static inline void cml_bundle_walk(const struct cml_world *world, const struct cml_lane_medium *media,
                                   const struct cml_range_source *source, struct cml_tally *tally)
{
    struct cml_bundle bundle = {0};
    struct cml_gathered gathered = {0};
    struct cml_flight f = {.world = world,
                           .b = &bundle,
                           .gathered = &gathered,
                           .tally = tally,
                           .media = media,
                           .source = source};
    cml_flight_begin(&f);
    cml_flight_run(&f);
}

#endif
