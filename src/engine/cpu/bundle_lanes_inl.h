/* Code, included by the other bundle_*_inl.h: the lanes of a bundle one by one, that is a packet's columns,
 * its deposits, and its end.
 * It is compiled once for each level of the processor (engine_cpu_level.c says why).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/cpu/bundle_flight.h"

#include <stddef.h>

/* Lanes in one vector register. Loops over fewer lanes take as long. */
#if defined(__AVX512F__)
#define CML_VECTOR 16
#elif defined(__AVX2__)
#define CML_VECTOR 8
#else
#define CML_VECTOR 1 /* the baseline has no vector instructions for gathering */
#endif

/* Returns a number of lanes, rounded up to whole vectors: a loop over it needs no remainder loop. */
static inline int cml_whole_vectors(int count)
{
    return (count + CML_VECTOR - 1) / CML_VECTOR * CML_VECTOR;
}

/* Calls handle for every lane of the mask, in order: finds the lowest bit, then clears it. */
static void cml_for_lanes(struct cml_flight *f, uint64_t mask, void (*handle)(struct cml_flight *, int))
{
    for (; mask; mask &= mask - 1) handle(f, __builtin_ctzll(mask));
}

/* Copies the properties of lane i's medium into its columns. Loops read media from columns, because gathering
 * by medium number would take a load per lane and value. */
static void cml_load_medium(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    const real *restrict row = &f->media[b->medium[i]].mut;
    for (size_t k = 0; k < CML_LANE_MEDIUM_FLAT; k++) b->of_medium[k][i] = row[k];
    if (!f->curves) return;
    for (size_t k = CML_LANE_MEDIUM_FLAT; k < CML_LANE_MEDIUM_MEMBERS; k++) b->of_medium[k][i] = row[k];
}

/* Returns the photon index of the lane's packet. It is held as two words, so that all columns are 4 bytes
 * wide. */
static uint64_t cml_lane_index(const struct cml_bundle *b, int i)
{
    return (uint64_t)b->index_high[i] << 32 | b->index_low[i];
}

/* Returns the number of a group's lanes that hold branches (P19). */
static int cml_count_branches(const struct cml_bundle *b, int first, cml_u32 lanes)
{
    int count = 0;
    for (; lanes; lanes &= lanes - 1) count += cml_is_branch(cml_lane_index(b, first + __builtin_ctz(lanes)));
    return count;
}

/* Returns the factors of the rows of the lane's packet (P16). */
static real *cml_lane_factors(const struct cml_flight *f, int i)
{
    return f->factors + (size_t)i * cml_row_factors((size_t)f->rows.count);
}

/* Returns the rows of the lane's packet for a booking (P16). */
static struct cml_row_packet cml_lane_rows(const struct cml_flight *f, int i)
{
    return cml_row_packet_of(&f->world->setup, &f->rows, cml_lane_index(f->b, i), cml_lane_factors(f, i));
}

/* Launches the rows of the lane's packet; times, path: as in cml_rows_launch. */
static void cml_launch_lane_rows(const struct cml_flight *f, int i, int times, real path)
{
    const struct cml_row_packet rows = cml_lane_rows(f, i);
    cml_rows_launch(&rows, f->b->w[i], times, path);
}

/* Returns the trail of the lane's packet (P13); empty if no result needs trails. */
static inline struct cml_trail cml_lane_trail(const struct cml_bundle *b, int i)
{
    const struct cml_trail none = {0};
    const size_t row = (size_t)i * (size_t)b->num_media;
    if (!b->stay) return none;
    return (struct cml_trail){b->stay + row, b->deepest[i]};
}

/* Books the absorption of rows since the last booking of the lane; the packet itself has lost `deposited`
 * since then. This is a function of its own, because its loops become vectors only if all that they call is
 * inlined, and compilers do not inline into a rare function. */
__attribute__((noinline, hot, flatten)) static void cml_fly_lane_rows(struct cml_flight *f, int i,
                                                                      cml_u32 deposited)
{
    struct cml_bundle *b = f->b;
    const struct cml_row_packet rows = cml_lane_rows(f, i);
    const struct cml_trail trail = cml_lane_trail(b, i);
    cml_rows_fly(f->world, &rows, b->medium[i], b->path[i], b->interactions[i], b->w[i] + deposited, b->w[i]);
    cml_rows_pass_time(f->world, &rows, &trail);
    b->path[i] = 0;
}

/* Books the lane's deposits into gates (P11), rows (P16), or the sums of a late packet's batch. It is called
 * only if one of these is needed, and not inlined, because it would cost registers elsewhere. */
__attribute__((noinline, cold)) static void cml_book_rare(struct cml_flight *f, int i, cml_u32 deposited)
{
    const int gate = f->b->gate[i];
    if (f->factors) cml_fly_lane_rows(f, i, deposited);
    if (f->to.A_t) cml_add_to_gate(&f->to, f->world->setup.gates, f->b->medium[i], gate, deposited);
    if (!(f->late & CML_LANE_BIT(i))) return;
    f->late_profiles[i][f->tally->profile.A_l + (size_t)f->b->medium[i]] += deposited;
    if (!f->to.A_t) return;
    const struct cml_deposits late = {.A_t = f->late_profiles[i] + f->tally->profile.A_t,
                                      .A_lt =
                                          f->to.A_lt ? f->late_profiles[i] + f->tally->profile.A_lt : NULL};
    cml_add_to_gate(&late, f->world->setup.gates, f->b->medium[i], gate, deposited);
}

/* Books the weight that the backing, or a face, takes in the lane's rows: the packet, whose deposits have
 * been booked, keeps w. */
__attribute__((noinline, cold)) static void cml_keep_lane_rows(const struct cml_flight *f, int i, cml_u32 w,
                                                               int face)
{
    const struct cml_row_packet rows = cml_lane_rows(f, i);
    cml_rows_keep(&rows, f->b->w[i], w, face);
}

/* Books the deposits of the lane's packet since the last booking: into the sum of its layer, its gate (P11)
 * and the packet's own sum. A packet loses weight only by deposits, so their sum is the difference of two
 * weights. To be called before the medium or the gate changes, or the weight by anything else. */
static void cml_flush_deposits(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    CML_ASSERT(b->w[i] <= b->flushed_w[i]);
    const cml_u32 deposited = b->flushed_w[i] - b->w[i];
    f->tally->A_l[b->medium[i]] += deposited;
    f->absorbed[i] += deposited;
    b->flushed_w[i] = b->w[i];
    if (f->books_more || f->late & CML_LANE_BIT(i)) cml_book_rare(f, i, deposited);
}

/* Ends the visit of the lane's packet to its medium (P13): it is about to come into another medium, or has
 * ended. */
__attribute__((noinline, cold)) static void cml_end_lane_visit(struct cml_flight *f, int i)
{
    struct cml_bundle *b = f->b;
    struct cml_trail trail = cml_lane_trail(b, i);
    cml_add_visit(f->world, &trail, b->medium[i], b->here[i], b->low[i], b->momentum[i],
                  b->interactions[i] - b->before[i]);
    b->deepest[i] = trail.deepest;
    b->here[i] = b->momentum[i] = 0;
    b->low[i] = -CML_INFINITY;
    b->before[i] = b->interactions[i];
}

/* Counts a depth of the lane's packet (P13): it has come to z, in the frame of its medium. */
static inline void cml_count_lane_depth(struct cml_bundle *b, int i, real z)
{
    b->low[i] = z > b->low[i] ? z : b->low[i];
}

/* Ends the trail of the lane's packet (P13), which has gone into an outer medium for good, at depth z of that
 * medium's frame. */
static void cml_leave_lane(struct cml_flight *f, int i, int to, real z)
{
    real *deepest = &f->b->deepest[i];
    const real deep = z + f->world->media[to].depth;
    cml_end_lane_visit(f, i);
    *deepest = deep > *deepest ? deep : *deepest;
}

/* Fills *packet with the lane's packet as kernels/walk.h knows it. The place it stands on and its number of
 * bounces come from its last boundary event, and hold only if it has not interacted since (bundle.h). The
 * packet is filled member by member: if it were built and then copied, it would be stored in parts and loaded
 * whole, and such loads wait for the stores (no store forwarding). */
static inline void cml_lane_packet(const struct cml_bundle *b, int i, struct cml_packet *packet)
{
    const int on_surface = b->interactions_at_hit[i] == b->interactions[i];
    packet->index = cml_lane_index(b, i);
    packet->p.x = packet->exit_x = b->x[i];
    packet->p.y = packet->exit_y = b->y[i];
    packet->p.z = b->z[i];
    packet->u.x = b->ux[i];
    packet->u.y = b->uy[i];
    packet->u.z = b->uz[i];
    packet->tau = b->tau[i];
    packet->path = b->path[i];
    packet->mark = b->mark[i];
    packet->trail.stay = NULL;
    if (b->stay) {
        packet->trail = cml_lane_trail(b, i);
        packet->here = b->here[i];
        packet->low = b->low[i];
        packet->momentum = b->momentum[i];
        packet->before = b->before[i];
    }
    packet->w = b->w[i];
    packet->interactions = b->interactions[i];
    packet->crossings = b->crossings[i];
    packet->rough_draws = b->rough_draws[i];
    packet->bounces = on_surface ? b->bounces[i] : 0;
    packet->boundary_events = b->boundary_events[i];
    packet->medium = b->medium[i];
    packet->on_boundary = on_surface ? b->on_boundary[i] : -1;
    packet->on_primitive = b->on_primitive[i];
    packet->off.x = b->off_x[i];
    packet->off.y = b->off_y[i];
    packet->off.z = b->off_z[i];
    packet->undeflected = b->undeflected[i];
    packet->near_boundary = 0;
    packet->entered = b->entered[i];
    packet->fate = CML_FATE_ALIVE;
    packet->cause = CML_LOST_NOT;
    packet->queries = packet->shading_overruled = 0;
    packet->absorbed = packet->gained = packet->roulette = packet->backing = packet->face = 0;
}

/* Stores the position (cm, frame of the medium) and direction of a lane's packet. */
static void cml_store_ray(struct cml_bundle *b, int i, struct cml_vec p, struct cml_vec u)
{
    b->x[i] = p.x;
    b->y[i] = p.y;
    b->z[i] = p.z;
    b->ux[i] = u.x;
    b->uy[i] = u.y;
    b->uz[i] = u.z;
}

/* Returns the stretch of path that the lane is about to fly from its place (P14). */
static struct cml_stretch cml_lane_stretch(const struct cml_bundle *b, int i)
{
    const struct cml_stretch s = {cml_lane_index(b, i),
                                  {b->x[i], b->y[i], b->z[i]},
                                  {b->ux[i], b->uy[i], b->uz[i]},
                                  b->medium[i],
                                  b->interactions[i] + b->boundary_events[i],
                                  b->w[i],
                                  b->path[i]};
    return s;
}

/* True if the lane, which is in the material, has been outside since its rows were last booked (P16). */
static int cml_lane_rows_have_returned(const struct cml_flight *f, int i)
{
    if (!f->rows.timed) return 0;
    const struct cml_row_packet rows = cml_lane_rows(f, i);
    const struct cml_trail trail = cml_lane_trail(f->b, i);
    return cml_rows_have_returned(f->world, &rows, &trail);
}

/* Stores in lane i the members that boundary events of kernels/walk.h can change. If the medium changes, the
 * deposits in the old one are booked first. */
static void cml_store_packet(struct cml_flight *f, int i, const struct cml_packet *packet)
{
    struct cml_bundle *b = f->b;
    cml_store_ray(b, i, packet->p, packet->u);
    b->tau[i] = packet->tau;
    b->path[i] = packet->path;
    b->mark[i] = packet->mark;
    if (b->stay) {
        b->here[i] = packet->here;
        b->low[i] = packet->low;
        b->momentum[i] = packet->momentum;
        b->before[i] = packet->before;
        b->deepest[i] = packet->trail.deepest;
    }
    b->crossings[i] = packet->crossings;
    b->rough_draws[i] = packet->rough_draws;
    b->interactions_at_hit[i] = packet->interactions;
    b->bounces[i] = packet->bounces;
    b->boundary_events[i] = packet->boundary_events;
    b->on_boundary[i] = packet->on_boundary;
    b->on_primitive[i] = packet->on_primitive;
    b->off_x[i] = packet->off.x;
    b->off_y[i] = packet->off.y;
    b->off_z[i] = packet->off.z;
    b->undeflected[i] = packet->undeflected;
    b->entered[i] = packet->entered;
    if (packet->backing | packet->face) {
        cml_flush_deposits(f, i);
        if (f->factors) cml_keep_lane_rows(f, i, packet->w, packet->face > 0);
        b->w[i] = b->flushed_w[i] = packet->w;
    }
    if (packet->medium == b->medium[i] && !cml_lane_rows_have_returned(f, i)) return;
    cml_flush_deposits(f, i);
    b->medium[i] = packet->medium;
    cml_load_medium(f, i);
}

/* Notes that the lane's packet is about to interact within rounding of a mesh. cml_interact would write this
 * into a packet; here it is written ahead of the interaction, with the number that the interaction will have.
 * Until the next one the packet stands on no facet, and may be beyond one (CML_NEAR_FACETS). */
static void cml_store_near_boundary(struct cml_bundle *b, int i, const struct cml_packet *packet)
{
    b->interactions_at_hit[i] = packet->interactions + 1;
    b->bounces[i] = 0;
    b->on_boundary[i] = packet->near_boundary - 1;
    b->on_primitive[i] = CML_NEAR_FACETS;
}

/* Adds a late packet that has ended to the totals and profiles of its batch (tally.h). i: its lane; at: its
 * entry in the collection. */
static void cml_end_late(const struct cml_flight *f, int i, int at, const struct cml_trail *trail)
{
    const struct cml_setup *setup = &f->world->setup;
    const struct cml_terminated *terminated = &f->terminated;
    const struct cml_layout *begin = &f->tally->profile;
    const struct cml_exit exit = cml_terminated_exit(setup, terminated, at);
    const int up = exit.up;
    const cml_u32 w = terminated->w[at];
    uint64_t *row = f->late_profiles[i];
    const cml_u64 index = cml_lane_index(f->b, i);
    row[CML_TOTAL_SPECULAR] += (cml_is_branch(index) ? 0u : setup->specular) + (exit.fresh ? w : 0u);
    if (f->tally->detector) {
        const struct cml_seen seen = {row + begin->detector, row + begin->detector_t, row + begin->moments};
        cml_score_split_off(f->world, index, 1, &seen, NULL);
        cml_tally_detectors(f->world, terminated, at, &exit, trail, &seen, NULL);
    }
    row[CML_TOTAL_ABSORBED] += terminated->absorbed[at] + terminated->deposit[at];
    row[begin->A_l + (size_t)(up ? 1 : setup->num_layers)] += terminated->deposit[at];
    if (!(up | exit.down)) return;
    row[up ? CML_TOTAL_REFLECTED : CML_TOTAL_TRANSMITTED] += w;
    row[(up ? begin->Rd_r : begin->Tt_r) + (size_t)exit.r] += w;
    row[(up ? begin->Rd_a : begin->Tt_a) + (size_t)exit.alpha] += w;
    if (setup->gates.count) row[(up ? begin->Rd_t : begin->Tt_t) + (size_t)exit.gate] += w;
}

/* Ends the lane's packet. end: all about its end but the weight that it has absorbed. The function is
 * inlined, so that `end` goes from lane to collection in registers: built in memory, it would be stored in
 * parts and loaded whole, which stalls. */
__attribute__((always_inline)) static inline void cml_push_termination(struct cml_flight *f, int i,
                                                                       struct cml_termination end)
{
    cml_flush_deposits(f, i);
    struct cml_row_packet rows;
    if (f->factors) {
        rows = cml_lane_rows(f, i);
        cml_rows_keep(&rows, f->b->w[i], end.w, end.face);
    }
    end.absorbed = f->absorbed[i];
    const int at = f->terminated.count;
    cml_terminated_push(f->world, &f->terminated, &end, f->factors ? &rows : NULL, f->tally);
    if (f->late & CML_LANE_BIT(i)) cml_end_late(f, i, at, &end.trail);
    CML_ASSERT(f->live & ~f->ended & CML_LANE_BIT(i)); /* the lane held a packet, which ends only once */
    f->b->task[i] = CML_LANE_ENDED;
    f->ended |= CML_LANE_BIT(i);
}

/* Ends the lane's packet where it is; lost, if there is a cause (P9). */
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
        .exit_z = b->z[i],
        .ux = b->ux[i],
        .uy = b->uy[i],
        .uz = b->uz[i],
        .path = b->path[i],
    };
    cml_push_termination(f, i, end);
}

/* Returns the mask of the lanes that have this value in a column, of tasks or media. */
static uint64_t cml_lanes_equal(const int *column, int value)
{
    uint64_t mask = 0;
    for (int first = 0; first < CML_LANES; first += CML_GROUP)
        mask |= (uint64_t)cml_group_equal(column + first, value) << first;
    return mask;
}

/* Returns the mask of the lanes that play roulette (P8): they have just interacted, and are below the
 * threshold. It is built in two halves, because a vector's elements have 32 bits. */
static uint64_t cml_lanes_below(const struct cml_bundle *b, cml_u32 threshold)
{
    cml_u32 low = 0, high = 0;
#pragma omp simd reduction(| : low, high)
    for (int i = 0; i < 32; i++) {
        low |= (cml_u32)((b->task[i] == CML_LANE_INTERACT) & (b->w[i] < threshold)) << i;
        high |= (cml_u32)((b->task[i + 32] == CML_LANE_INTERACT) & (b->w[i + 32] < threshold)) << i;
    }
    return (uint64_t)high << 32 | low;
}
