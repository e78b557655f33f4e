/* Code, included by engine_cpu_level.c only: the pass over a bundle, which is the events of one thread's
 * lanes, in order, until there are no more packets.
 * It is compiled once for each level of the processor. A .c file of its own could not be inlined into, and
 * loops over lanes become vectors only if all that they call is inlined.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/cpu/bundle_bodies_inl.h"
#include "engine/cpu/bundle_launch_inl.h"
#include "engine/cpu/bundle_curved_search_inl.h"
#include "engine/cpu/bundle_interact_inl.h"
#include "engine/cpu/bundle_marks_inl.h"
#include "engine/cpu/bundle_prepare.h"
#include "engine/cpu/bundle_rough_inl.h"

/* ---- invariants between two passes, for CML_ASSERT: release builds never call these ---- */

/* True if the lane's weight is never above a whole packet, nor above its weight at the last booking of
 * deposits. */
static inline int cml_lane_weight_is_sound(const struct cml_bundle *b, int i)
{
    return b->w[i] <= b->flushed_w[i] && b->flushed_w[i] <= CML_WEIGHT_ONE;
}

/* True if the lane's medium is one of the scene's, and the lane has this medium's columns. */
static inline int cml_lane_medium_is_sound(const struct cml_flight *f, int i)
{
    const struct cml_bundle *b = f->b;
    const int m = b->medium[i];
    return m >= 0 && m <= f->world->setup.num_layers + 1 + f->world->setup.num_bodies &&
           memcmp(&CML_OF_MEDIUM(b, stop_below)[i], &f->media[m].stop_below, sizeof(real)) == 0 &&
           memcmp(&CML_OF_MEDIUM(b, mfp)[i], &f->media[m].mfp, sizeof(real)) == 0;
}

/* True if a lane with INTERACT is in its layer after its move, as in cml_interact. The check uses s, the
 * whole path that was flown, because the direction before the interaction is no longer known. */
static inline int cml_lane_place_is_sound(const struct cml_flight *f, int i)
{
    const struct cml_bundle *b = f->b;
    const struct cml_vec p = {b->x[i], b->y[i], b->z[i]};
    return b->task[i] != CML_LANE_INTERACT || cml_is_in_layer(f->world, b->medium[i], p, b->s[i]);
}

/* True if all lanes that hold a packet are sound, after the interactions of a pass and before lanes are
 * refilled. */
static inline int cml_lanes_are_sound(const struct cml_flight *f)
{
    const struct cml_bundle *b = f->b;
    for (uint64_t rest = f->live & ~f->ended; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
        if (i >= b->lanes || b->task[i] == CML_LANE_ENDED || !cml_is_unit(u) ||
            !cml_lane_weight_is_sound(b, i) || !cml_lane_medium_is_sound(f, i) ||
            !cml_lane_place_is_sound(f, i))
            return 0;
    }
    return 1;
}

/* ---- planes, roulette, exits, passes ---- */

/* Takes the lane's packet, which has gone through a plane, into the other layer. The frame of a medium is
 * that of the boundary above it: below the plane depth begins at 0, above the plane at the layer's
 * thickness. */
static void cml_enter_layer(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    const int upwards = b->uz[i] < 0, medium = b->medium[i] + 1 - 2 * upwards;
    const real span = f->media[medium].span;
    if (b->stay) cml_end_lane_visit(f, i);
    cml_flush_deposits(f, i);
    b->medium[i] = medium;
    b->entered[i] = 1;
    b->z[i] = (real)upwards * span; /* no branch, because up and down come at random */
    if (b->stay) cml_count_lane_depth(b, i, b->z[i]);
    b->task[i] = CML_LANE_TO_FLY;
    cml_load_medium(f, i);
}

/* Scores packets that leave through a plane one by one: entries of the collection from `at` on. */
static void cml_place_exits(struct cml_flight *f, int first, cml_u32 exits, int at)
{
    const struct cml_bundle *b = f->b;
    for (cml_u32 rest = exits; rest; rest &= rest - 1, at++) {
        const int i = first + __builtin_ctz(rest), up = b->uz[i] < 0;
        if (b->stay) cml_leave_lane(f, i, up ? 0 : f->world->setup.num_layers + 1, 0);
        const struct cml_trail trail = cml_lane_trail(b, i);
        struct cml_row_packet rows;
        if (f->factors) rows = cml_lane_rows(f, i);
        cml_tally_places(f->world, &f->terminated, at, 0, &trail, f->factors ? &rows : NULL, f->tally);
    }
}

/* Collects the packets of a group of lanes that leave the scene through a plane (P6), mask `exits`. Columns
 * are packed: the values of these lanes move side by side, behind the ends collected so far. Deposits not
 * yet added to the sums go along, and count for the layer that the packets leave. */
static void cml_exit_group(struct cml_flight *f, int first, cml_u32 exits)
{
    const struct cml_bundle *b = f->b;
    const struct cml_setup *setup = &f->world->setup;
    struct cml_terminated *terminated = &f->terminated;
    const int at = terminated->count;
    _Alignas(64) cml_u32 deposit[CML_GROUP];
    _Alignas(64) int fate[CML_GROUP];
    if (f->books_more) cml_for_lanes(f, (uint64_t)exits << first, cml_flush_deposits);
    if (f->to.phi) cml_mark_exits(f, first, exits);
#pragma omp simd
    for (int k = 0; k < CML_GROUP; k++) {
        deposit[k] = b->flushed_w[first + k] - b->w[first + k];
        fate[k] = cml_fate_outside(b->entered[first + k], b->uz[first + k] < 0);
    }
    cml_group_pack(deposit, exits, terminated->deposit + at);
    cml_group_pack(fate, exits, terminated->fate + at);
    cml_group_pack_wide(f->absorbed + first, exits, terminated->absorbed + at);
    cml_group_pack(b->x + first, exits, terminated->exit_x + at);
    cml_group_pack(b->y + first, exits, terminated->exit_y + at);
    cml_group_pack(b->uz + first, exits, terminated->uz + at);
    if (f->tally->Rd_dir || b->stay) {
        cml_group_pack(b->ux + first, exits, terminated->ux + at);
        cml_group_pack(b->uy + first, exits, terminated->uy + at);
    }
    cml_group_pack(b->index_low + first, exits, terminated->index_low + at);
    if (b->stay) {
        cml_group_pack(b->index_high + first, exits, terminated->index_high + at);
        memset(terminated->exit_z + at, 0, (size_t)__builtin_popcount(exits) * sizeof(real));
    }
    if (setup->keeps_paths) cml_group_pack(b->path + first, exits, terminated->path + at);
    if (f->world->windows.cells) terminated->branches += cml_count_branches(b, first, exits);
    cml_group_pack(b->w + first, exits, terminated->w + at);
    cml_group_pack(b->interactions + first, exits, terminated->interactions + at);
    cml_group_pack(b->boundary_events + first, exits, terminated->boundary_events + at);
    terminated->count = at + __builtin_popcount(exits);
    CML_ASSERT(((uint64_t)exits << first & (f->ended | ~f->live)) == 0);
    f->ended |= (uint64_t)exits << first;
    if (cml_tallies_places(f->tally)) cml_place_exits(f, first, exits, at);
    for (cml_u32 late = exits & (cml_u32)(f->late >> first); late; late &= late - 1) {
        const int k = __builtin_ctz(late);
        const struct cml_trail trail = cml_lane_trail(b, first + k);
        cml_end_late(f, first + k, at + __builtin_popcount(exits & ((1u << k) - 1)), &trail);
    }
    cml_terminated_make_room(f->world, terminated, f->tally);
}

/* Handles a lane that has reached a limit of P9 (cml_lane_is_at_limit), with the limits of
 * cml_count_bounce. */
static void cml_handle_limit(struct cml_flight *f, int i)
{
    const struct cml_bundle *b = f->b;
    if (b->task[i] == CML_LANE_NO_EVENT) {
        cml_process_lane(f, i);
        return;
    }
    if (b->task[i] == CML_LANE_TRANSMITTED) cml_enter_layer(f, i);
    if (!(CML_OF_MEDIUM(b, mut)[i] > 0))
        cml_end_lane(f, i, CML_FATE_TRAPPED, CML_LOST_NOT);
    else if (b->bounces[i] > CML_STUCK_LIMIT)
        cml_end_lane(f, i, CML_FATE_LOST, CML_LOST_STUCK);
}

/* Plays roulette by `rule` with the packet of lane i (P8, P19), and ends the lane if the packet loses. The
 * draw is the fourth random word of the packet's last interaction. The loops do not keep this word, so the
 * block is computed again. Deposits before and after the new weight are kept apart. */
static void cml_lane_roulette_by(struct cml_flight *f, int i, struct cml_roulette_rule rule)
{
    struct cml_bundle *b = f->b;
    struct cml_packet packet = {.w = b->w[i]};
    packet.draw =
        cml_draw(f->world->setup.stream, cml_lane_index(b, i), CML_PURPOSE_INTERACTION, b->interactions[i]);
    cml_roulette(rule, &packet);
    cml_tally_events(&packet, f->tally);
    /* The deposits belong to the interaction that the next pass will count. */
    b->interactions[i]++;
    cml_flush_deposits(f, i);
    b->interactions[i]--;
    if (f->factors) {
        const struct cml_row_packet rows = cml_lane_rows(f, i);
        cml_rows_roulette(&rows, b->w[i], packet.w);
    }
    b->w[i] = b->flushed_w[i] = packet.w;
    if (packet.fate == CML_FATE_ALIVE) return;
    b->interactions[i]++;
    cml_end_lane(f, i, CML_FATE_ABSORBED, CML_LOST_NOT);
}

static void cml_lane_roulette(struct cml_flight *f, int i)
{
    cml_lane_roulette_by(f, i, f->world->setup.roulette);
}

/* Plays roulette with the packet of lane i or splits it, after an interaction that left its weight outside
 * of its window (P19), as cml_weigh does. The lane has not drawn for its next interaction yet, and its
 * branches are numbered by that interaction. */
static void cml_weigh_lane(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    const struct cml_weight_windows windows = f->world->windows;
    const struct cml_vec p = {b->x[i], b->y[i], b->z[i]};
    const int cell = cml_window_cell(windows, f->world->setup.per_dz, p, CML_OF_MEDIUM(b, bins)[i]);
    const cml_u32 low = windows.low[cell], target = cml_target_weight(low);
    const struct cml_roulette_rule rule = {low, target};
    struct cml_packet packet;
    const cml_u32 w = b->w[i];
    if (w < low) {
        cml_lane_roulette_by(f, i, rule);
        if (b->w[i] > w) b->spent[i] = cml_spent_after(b->spent[i], w, b->w[i]);
        return;
    }
    cml_flush_deposits(f, i);
    b->interactions[i]++;
    cml_lane_packet(b, i, &packet);
    b->interactions[i]--;
    packet.spent = b->spent[i];
    cml_split(f->world, f->to.branches, &packet, target);
    b->spent[i] = packet.spent;
    b->w[i] = b->flushed_w[i] = packet.w;
}

/* Plays roulette or splits in lanes that have interacted and whose weight is out of its window (P19). */
static void cml_weigh_lanes(struct cml_flight *f)
{
    _Alignas(64) int outside[CML_LANES];
    uint64_t mask = 0;
    if (!cml_bundle_find_outside(f->world, f->b, outside)) return;
    for (int first = 0; first < CML_LANES; first += CML_GROUP)
        mask |= (uint64_t)cml_group_equal(outside + first, 1) << first;
    cml_for_lanes(f, mask & f->live, cml_weigh_lane);
}

/* Scores on facets what lanes have met at planes. A reflected lane already has its new direction, so the
 * plane that it has met lies behind it. A transmitted lane still heads for the plane. */
static void cml_score_planes(const struct cml_flight *f)
{
    const struct cml_bundle *b = f->b;
    for (int i = 0; i < b->lanes; i++) {
        const int through = b->task[i] == CML_LANE_TRANSMITTED, upwards = b->uz[i] < 0, m = b->medium[i];
        const int boundary = through == upwards ? m - 1 : m, beyond = upwards ? m - 1 : m + 1;
        if (!through && b->task[i] != CML_LANE_REFLECTED) continue;
        cml_score_facet(f->world, &f->to, b->index_low[i], boundary, 0, b->x[i], b->y[i], m,
                        through ? beyond : m, b->w[i], b->w[i]);
    }
}

/* Handles the limits of P9 in all lanes. Called only if a loop has seen a lane that may need it. */
static void cml_handle_limits(struct cml_flight *f)
{
    for (int i = 0; i < f->b->lanes; i++)
        if (cml_lane_is_at_limit(f->b, i, f->world->setup.num_layers)) cml_handle_limit(f, i);
}

/* Scores the lane's packet, which goes down through the tail's level (P15). */
static void cml_lane_enters_tail(struct cml_flight *f, int i)
{
    cml_expect_of_lane(f, i);
    cml_score_tail(&f->world->tail, &f->to, f->b->uz[i], f->b->w[i]);
}

/* Returns the mask of the lanes with this task that go down from above the tail's level (P15). to_z:
 * [CML_LANES] depths at which their paths end. */
static uint64_t cml_lanes_into_tail(const struct cml_flight *f, int task, const real *to_z)
{
    const struct cml_bundle *b = f->b;
    const struct cml_tail tail = f->world->tail;
    _Alignas(64) int enters[CML_LANES];
    uint64_t mask = 0;
#pragma omp simd
    for (int i = 0; i < CML_LANES; i++)
        enters[i] = (b->task[i] == task) & cml_enters_tail(&tail, b->medium[i], b->z[i], to_z[i]);
    for (int first = 0; first < CML_LANES; first += CML_GROUP)
        mask |= (uint64_t)cml_group_equal(enters + first, 1) << first;
    return mask & f->live & ~f->ended;
}

/* Scores expected values (P15) of lanes that pass the level before they interact. */
static void cml_score_tail_ahead(struct cml_flight *f)
{
    const struct cml_bundle *b = f->b;
    _Alignas(64) real z[CML_LANES];
#pragma omp simd
    for (int i = 0; i < CML_LANES; i++) {
        const struct cml_vec p = {b->x[i], b->y[i], b->z[i]}, u = {b->ux[i], b->uy[i], b->uz[i]};
        z[i] = cml_along(p, b->s[i], u).z;
    }
    cml_for_lanes(f, cml_lanes_into_tail(f, CML_LANE_INTERACT, z), cml_lane_enters_tail);
}

/* Scores expected values (P15) of lanes that were above the level, mask `above`, and have come to the plane
 * below it. */
static void cml_score_tail_at_planes(struct cml_flight *f, uint64_t above)
{
    for (; above; above &= above - 1) {
        const int i = __builtin_ctzll(above), task = f->b->task[i];
        if (f->b->uz[i] > 0 && (task == CML_LANE_AT_PLANE || task == CML_LANE_TRANSMITTED))
            cml_lane_enters_tail(f, i);
    }
}

/* Handles all lanes that meet a plane in this pass: moves them there, reflects or refracts them, and lets
 * them leave or enter a layer. Lanes of packets that have left get new packets at once, and all lanes get a
 * new path, so that they may interact in the same pass. */
static void cml_cross_planes(struct cml_flight *f)
{
    const struct cml_setup *setup = &f->world->setup;
    struct cml_bundle *b = f->b;
    CML_HOOK_LANES(CML_HOOK_PLANES, b->lanes);
    const uint64_t above =
        f->to.expected ? cml_lanes_into_tail(f, CML_LANE_MAY_HIT, CML_OF_MEDIUM(b, stop_below)) : 0;
    const int any =
        f->to.phi ? cml_reach_planes_with_marks(f) : cml_bundle_reach_planes(b, setup->keeps_paths);
    if (above) cml_score_tail_at_planes(f, above);
    const int smooth = any & CML_ANY_AT_PLANE && !(f->rough_planes && cml_cross_rough_planes(f));
    if (smooth) cml_bundle_reflect_or_refract(setup, b);
    if (b->stay) cml_bundle_count_reflected_depths(b);
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

/* Returns the subset of `lanes` whose optical depth lies in the tail (P2). tau is infinite in such a lane
 * until the tail is drawn. */
static uint64_t cml_lanes_in_tail(const struct cml_flight *f, uint64_t lanes)
{
    uint64_t tails = 0;
    for (uint64_t rest = lanes; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        if (!(f->b->tau[i] < CML_INFINITY)) tails |= CML_LANE_BIT(i);
    }
    return tails;
}

/* Processes planes if enough lanes wait. The planes' loops take as long for one lane as for all, so lanes at
 * a plane wait for others, while the rest of the bundle goes on. A waiting lane costs its share of every
 * pass. The loops run once the lanes have waited `limit` passes, summed over lanes: then, by measurement,
 * waiting has cost as much as the loops do. For arrivals at random that is close to the least cost of both
 * together. A bundle that has been compacted holds the last packets, and does not wait. Returns 1 if lanes
 * have flown on. */
static int cml_process_planes(struct cml_flight *f)
{
    const int limit = f->b->lanes == CML_LANES ? 45 : 1;
    f->wait_at_planes += __builtin_popcountll(cml_lanes_equal(f->b->task, CML_LANE_MAY_HIT));
    if (f->wait_at_planes < limit) return 0;
    f->wait_at_planes = 0;
    cml_cross_planes(f);
    return 1;
}

/* Finds the lanes that can meet a curved boundary before they interact, and processes them. A cheap vector
 * loop comes first, which sorts out most lanes of a thick medium. */
static void cml_process_curved_boundaries(struct cml_flight *f)
{
    CML_HOOK_BEGIN(CML_HOOK_CLASSIFY);
    if (f->safe_cells) cml_find_safe_lanes(f);
    const int any = cml_bundle_classify_lanes(f->b, f->steepest, f->safe_cells);
    CML_HOOK_END(CML_HOOK_CLASSIFY);
    if (!any) return;
    CML_HOOK_BEGIN(CML_HOOK_CURVED);
    cml_process_curved(f);
    CML_HOOK_END(CML_HOOK_CURVED);
}

/* Rounds between two looks at whether to give up. They take some 0.1 ms, or 20 ms with searches in all
 * lanes. */
#define CML_ROUNDS_PER_LOOK 256

/* True if the packets under way are given up. It is asked in every round, because a packet may live for many
 * passes, or go to and fro between planes within one. */
static int cml_is_given_up(struct cml_flight *f)
{
    if (++f->rounds % CML_ROUNDS_PER_LOOK == 0) f->given_up |= f->source->gives_up(f->source->context);
    return f->given_up;
}

/* Handles all that lanes meet in this pass before they interact. tails: lanes whose optical depth lies in the
 * tail; they are handled one by one. After planes, lanes may meet a curved boundary next, or a plane again:
 * so rounds go on until the planes' loops have nothing to do or wait for more lanes. */
static void cml_process_boundaries(struct cml_flight *f, uint64_t tails)
{
    cml_for_lanes(f, tails, cml_process_lane);
    f->past_bodies = 0;
    do {
        if (f->world->setup.num_bodies) cml_process_bodies(f);
        if (f->curves) cml_process_curved_boundaries(f);
    } while (cml_process_planes(f) && !cml_is_given_up(f));
}

/* Adds the deposits of the pass to the thread's own A_rz, for the group of the batch under way. If all
 * threads share one A_rz, additions are atomic, and deposits also go into the thread's own A_z, where a
 * cell's column is its depth. This is no vector loop, because two lanes may hit the same cell. All lanes take
 * part, because the others add 0. It goes by groups, which a compiler unrolls. */
static void cml_scatter_deposits(const struct cml_bundle *b, const struct cml_tally *tally,
                                 cml_u32 first_cell)
{
    uint64_t *A_rz = tally->A_rz + first_cell;
    const cml_u32 columns = (cml_u32)tally->grid.nz + 2;
    if (tally->grid.absorption)
        for (int first = 0; first < b->lanes; first += CML_GROUP)
            for (int k = first; k < first + CML_GROUP; k++) A_rz[b->cell[k]] += b->dw[k];
    else
        for (int i = 0; i < b->lanes; i++) {
            cml_add_shared(&A_rz[b->cell[i]], b->dw[i]);
            tally->A_z[(cml_u32)b->cell[i] % columns] += b->dw[i];
        }
}

/* Adds the absorption of late packets to A_z of their batches, and directs it to A_rz of their own group,
 * which lies a fixed distance from that of the batch under way. All late lanes take part, because the others
 * add 0. */
static void cml_scatter_late(struct cml_flight *f)
{
    struct cml_bundle *b = f->b;
    const cml_u32 columns = (cml_u32)f->tally->grid.nz + 2;
    for (uint64_t rest = f->late; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        f->late_profiles[i][f->tally->profile.A_z + (cml_u32)b->cell[i] % columns] += b->dw[i];
        b->cell[i] += (int)(cml_first_cell(&f->to, b->index_low[i]) - f->first_cell);
    }
}

/* Adds the absorbed weight of all lanes to the voxels of the volume, which all threads share. */
static void cml_scatter_volume(const struct cml_flight *f)
{
    const struct cml_bundle *b = f->b;
    for (int i = 0; i < b->lanes; i++) {
        const struct cml_vec p = {b->x[i], b->y[i], b->z[i]};
        if (b->dw[i])
            cml_add_to_voxel(&f->to, b->index_low[i],
                             cml_voxel(&f->world->setup, p, CML_OF_MEDIUM(b, bins)[i]), b->dw[i]);
    }
}

/* Counts the optical paths of lanes that are about to interact (P11). A lane's deposits are booked only when
 * its gate changes, so most interactions cost nothing more. */
static void cml_count_lane_paths(struct cml_flight *f)
{
    struct cml_bundle *b = f->b;
    _Alignas(64) int gate[CML_LANES], changed[CML_LANES];
    cml_bundle_count_paths(&f->world->setup, b, gate, changed);
    for (int first = 0; f->to.A_t && first < b->lanes; first += CML_GROUP)
        for (cml_u32 rest = cml_group_equal(changed + first, 1); rest; rest &= rest - 1) {
            const int i = first + __builtin_ctz(rest);
            cml_flush_deposits(f, i);
            b->gate[i] = gate[i];
        }
}

/* Moves, absorbs and scatters all lanes that have come to their interaction. Returns 1 if a packet is below
 * the roulette threshold. */
static int cml_interact_lanes(const struct cml_world *world, struct cml_bundle *b, int tally)
{
    const struct cml_setup *setup = &world->setup;
    if (world->phase_cells) return cml_bundle_interact_by_tables(world, b, tally);
    if (b->stay)
        return tally ? cml_bundle_interact_along_trails(setup, b) : cml_bundle_scatter_along_trails(setup, b);
    return tally ? cml_bundle_interact(setup, b) : cml_bundle_scatter(setup, b);
}

/* Does the interactions of all lanes that have one in this pass: absorption, scattering, deposits, and
 * roulette or weight windows for lanes of low weight. */
static void cml_flight_interact(struct cml_flight *f)
{
    const struct cml_setup *setup = &f->world->setup;
    if (f->to.phi) cml_mark_interactions(f);
    if (setup->gates.count || f->factors) cml_count_lane_paths(f);
    if (f->rows.timed) cml_keep_time_of_rows(f);
    if (f->to.expected) cml_score_tail_ahead(f);
    const int low = cml_interact_lanes(f->world, f->b, f->tally->A_rz != NULL);
    if (f->tally->A_rz) {
        if (f->to.A_xyz) cml_scatter_volume(f);
        if (f->late) cml_scatter_late(f);
        cml_scatter_deposits(f->b, f->tally, f->first_cell);
    }
    if (f->world->rows.part) cml_sample_rows(f);
    if (f->world->windows.cells)
        cml_weigh_lanes(f);
    else if (low)
        cml_for_lanes(f, cml_lanes_below(f->b, setup->roulette.below) & f->live, cml_lane_roulette);
}

/* Returns the lanes in the tail that hold a packet. A lane without a packet draws like the others, so its
 * optical depth may come to lie in the tail too; it is parked again, with a finite depth. */
static uint64_t cml_park_dead_lanes(struct cml_flight *f)
{
    const uint64_t tails = cml_lanes_in_tail(f, cml_lanes_equal(f->b->task, CML_LANE_MAY_HIT));
    cml_for_lanes(f, tails & ~f->live, cml_park_lane);
    return tails & f->live;
}

/* Does one pass. Every lane that holds a packet comes to its next interaction, or waits at a boundary:
 *
 *   draw ---> fly ---> INTERACT ------------------------------------------------+---> interact ---> refill
 *              |                                                                |
 *              +-----> MAY_HIT ---> bodies ---> curved boundaries ---> planes --+  nothing in the way
 *                         ^                                              |
 *                         +---------- past a boundary: flies again ------+
 *                                                                        |
 *                                                      next pass <-------+  too few there: they wait
 *
 *   draw        random words of the next interaction
 *   fly         the path to it, and the lanes that may hit a boundary before
 *   boundaries  for those lanes: planes in vector loops, curved ones gathered by medium, rare cases singly
 *   interact    flight, absorption, scattering and roulette of all lanes that got there
 *   refill      lanes whose packet has ended
 *
 * All lanes do the same event at the same time: event-based or vectorised Monte Carlo [Brown & Martin,
 * Progress in Nuclear Energy 14 (1984) 269], on GPUs known as wavefront path tracing [Laine, Karras & Aila,
 * High Performance Graphics 2013]. Waiting at boundaries and refills keep the loops full. */
static void cml_flight_pass(struct cml_flight *f)
{
    CML_HOOK_LANES(CML_HOOK_PASS, f->b->lanes);
    cml_bundle_draw(&f->world->setup, f->b);
    const int any = cml_bundle_fly(f->b);
    if (any | f->world->setup.num_bodies)
        cml_process_boundaries(f, any & CML_ANY_TAIL ? cml_park_dead_lanes(f) : 0);
    cml_flight_interact(f);
    CML_ASSERT(cml_lanes_are_sound(f));
    if (f->ended) cml_refill(f);
}

/* Begins the flight of a thread's lanes: finds what all packets share (such as the first hit of a pencil
 * beam), and launches the first ones. On entry f holds world, bundle (all 0), tally, media, source and
 * branches; all else is 0. */
static void cml_flight_begin(struct cml_flight *f)
{
    const struct cml_setup *setup = &f->world->setup;
    f->to = cml_deposits_of(f->tally, f->to.branches);
    f->curves = setup->backing.kind != CML_BACKING_NONE || f->world->contacts.count > 0;
    for (int i = 0; i <= setup->num_layers; i++) {
        const struct cml_surface *surface = &f->world->surfaces[i];
        if (surface->kind == CML_SURFACE_PLANE) {
            f->rough_planes |= surface->rough.kind != CML_SMOOTH;
            continue;
        }
        f->curves = 1;
        f->steepest = surface->steepest > f->steepest ? surface->steepest : f->steepest;
        f->safe_cells |= f->world->safe_cells[i].nx > 0;
    }
    f->pencil = setup->num_sources == 1 && f->world->sources->shape == CML_BEAM_PENCIL &&
                f->world->sources->light == CML_LIGHT_PARALLEL;
    f->elsewhere = setup->apart || f->world->sources->inside;
    f->queue_places = !f->to.facets && !f->to.phi && cml_queue_can_place(setup, f->world->sources);
    cml_place(f->world, 0, &f->start);
    cml_find_first_hit(f);
    cml_find_entry(f);
    cml_find_known_path(f);
    cml_find_ballistic(f);
    f->b->lanes = CML_LANES;
    f->b->stay = f->tally->stay;
    f->b->num_media = setup->num_layers + 2 + setup->num_bodies;
    f->batch = -1;
    f->rows = cml_row_sums_of(f->world, f->tally);
    f->books_more = f->to.A_t || f->factors;
    for (int i = 0; i < CML_LANES; i++) {
        f->b->medium[i] = -1; /* no medium has been loaded yet */
        CML_OF_MEDIUM(f->b, start_above)[i] = -CML_INFINITY;
        CML_OF_MEDIUM(f->b, start_below)[i] = CML_INFINITY;
    }
    f->live = f->ended = ~(uint64_t)0; /* as if a packet had ended in every lane: all are refilled */
    cml_refill(f);
}

/* Flies passes until the last packet has ended, or packets are given up. */
static void cml_flight_run(struct cml_flight *f)
{
    while (f->live && !cml_is_given_up(f)) cml_flight_pass(f);
    if (!f->given_up) cml_end_batch(f);
}

/* Flies all packets that the source gives to one thread, CML_LANES at a time, and adds them to `tally`,
 * which no other thread writes, except for arrays that threads share. media: [num_layers + 2 + num_bodies];
 * factors: as in cml_flight. */
static inline void cml_bundle_walk(const struct cml_world *world, const struct cml_lane_medium *media,
                                   const struct cml_range_source *source, real *factors,
                                   struct cml_branches *branches, struct cml_tally *tally)
{
    struct cml_bundle bundle = {0};
    struct cml_gathered gathered = {0};
    struct cml_rough_lanes rough = {0};
    struct cml_regions regions = {0};
    struct cml_flight f = {.world = world,
                           .b = &bundle,
                           .gathered = &gathered,
                           .rough = &rough,
                           .regions = &regions,
                           .tally = tally,
                           .media = media,
                           .source = source,
                           .factors = factors,
                           .to = {.branches = branches}};
    branches->count = 0; /* may hold branches of a flight that was given up */
    cml_regions_begin(world, &regions);
    cml_flight_begin(&f);
    cml_flight_run(&f);
    cml_tally_unsplit(branches, tally);
}
