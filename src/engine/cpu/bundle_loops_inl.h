/* Code, included by the other bundle_*_inl.h: the vector loops of a pass, for which the levels of the
 * processor exist. Every loop goes over all lanes of the bundle. A lane whose task is another one computes as
 * well, and keeps its old values: a select costs less than a branch. Lanes without a packet may hold
 * anything.
 * It is compiled once for each level of the processor (engine_cpu_level.c says why).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "walk.h"

#include <stddef.h>

/* Returns the select of a vector loop: a in active lanes (1), b in the others (0). A compiler turns `active ?
 * a : b`, stored where b came from, into a conditional store. That is fast if vectors have masks (AVX-512).
 * Otherwise it is slow, and the value is put together from bits instead. */
static inline cml_u32 cml_pick_word(int active, cml_u32 a, cml_u32 b)
{
#ifdef __AVX512F__
    return active ? a : b;
#else
    const cml_u32 mask = 0u - (cml_u32)active;
    return (a & mask) | (b & ~mask);
#endif
}

/* Returns a if `active` is 1, otherwise b, without a branch. */
static inline int cml_pick_int(int active, int a, int b)
{
    return (int)cml_pick_word(active, (cml_u32)a, (cml_u32)b);
}

/* Returns a if `active` is 1, otherwise b, without a branch: the bits are selected, so a NaN does no harm. */
static inline real cml_pick(int active, real a, real b)
{
    return cml_float_of(cml_pick_word(active, cml_bits_of(a), cml_bits_of(b)));
}

/* Returns a random word, or, if `even` is 1, one of the lattice in its place, as cml_lattice_word does. */
static inline cml_u32 cml_even_or_random(int even, cml_u32 lattice, cml_u32 random)
{
    return cml_pick_word(even, (lattice & ~255u) | (random & 255u), random);
}

/* A vector loop is a function of its own. If it were inlined, its constants would compete for registers with
 * those of the loops beside it, and a profile could not tell them apart. The functions that it calls are
 * inlined. */
#define CML_LOOP static __attribute__((noinline))

/* The numbers that the photons of the queue share when they draw for the reflection at a boundary event. */
struct cml_queue_crossing {
    cml_u32 crossing;         /* number of the boundary event, as in cml_draw_reflection */
    int even;                 /* 1: the reflection draws from the lattice */
    cml_u32 generator, shift; /* generator and shift of the lattice's dimension */
};

/* Returns the numbers that the photons of the queue share at boundary event `crossing`. */
static inline struct cml_queue_crossing
cml_queue_crossing_of(const struct cml_setup *setup, const struct cml_launch_queue *queue, cml_u32 crossing)
{
    const cml_u32 dimension = cml_lattice_reflection(crossing);
    const struct cml_queue_crossing at = {.crossing = crossing,
                                          .even = (crossing < CML_LATTICE_REFLECTIONS) &
                                                  (setup->stream.lattice > 0u),
                                          .generator = cml_lattice_generator(dimension),
                                          .shift = queue->shifts[dimension / 4u].w[dimension % 4u]};
    return at;
}

/* Returns the random word that decides whether photon i of the queue is reflected at the first boundary,
 * with the same bits as cml_draw_reflection. */
static inline cml_u32 cml_queue_reflection(struct cml_stream stream, const struct cml_launch_queue *queue,
                                           int i, struct cml_queue_crossing at)
{
    const cml_u32 random =
        cml_threefry(stream, queue->index_low[i], queue->index_high[i], at.crossing, CML_PURPOSE_BOUNDARY)
            .w[0];
    return cml_even_or_random(at.even, queue->reversed[i] * at.generator + at.shift, random);
}

/* Fills the launch queue with CML_QUEUE photons of a batch from index `next` on: the block of their first
 * interaction, the optical depth to it (P2), and 1 in `through` if they are transmitted at the first
 * boundary. reflectance: of that boundary, if the beam meets it at one place and angle; 0: it reflects
 * nothing, or is not known. Returns 1 if an optical depth lies in the tail (P2): this is too rare for the
 * loop, and the depth is infinite in the queue. */
CML_LOOP int cml_queue_draw(const struct cml_setup *setup, uint64_t next, real reflectance,
                            struct cml_launch_queue *queue)
{
    const struct cml_stream stream = setup->stream;
    const cml_u32 low = (cml_u32)next, high = (cml_u32)(next >> 32), lattice = setup->stream.lattice;
    const struct cml_block shifts = queue->shifts[0];
    int tail = 0;
#pragma omp simd reduction(| : tail)
    for (int i = 0; i < CML_QUEUE; i++) {
        const cml_u32 index = low + (cml_u32)(CML_NUM_BATCHES * i), carried = high + (cml_u32)(index < low);
        const struct cml_block random = cml_threefry(stream, index, carried, 0, CML_PURPOSE_INTERACTION);
        const cml_u32 reversed = cml_lattice_reversed(index, carried);
        const struct cml_block even = cml_lattice_block(reversed, 0, shifts, random);
        const struct cml_block draw = lattice ? even : random;
        queue->index_low[i] = index;
        queue->index_high[i] = carried;
        queue->reversed[i] = reversed;
        queue->tau[i] = cml_depth_or_tail(draw.w[0]);
        queue->draw1[i] = draw.w[1];
        queue->draw2[i] = draw.w[2];
        queue->through[i] = 1;
        tail |= draw.w[0] == 0u;
    }
    if (!(reflectance > 0)) return tail;
    const struct cml_queue_crossing entry = cml_queue_crossing_of(setup, queue, 0);
#pragma omp simd
    for (int i = 0; i < CML_QUEUE; i++) {
        const cml_u32 word = cml_queue_reflection(stream, queue, i, entry);
        queue->through[i] = !(cml_uniform(word) <= reflectance);
    }
    return tail;
}

/* Finds the photons of the queue that are not ballistic. They interact before they have flown `path` (cm)
 * through a medium of the mean free path mfp (cm), or are reflected at the boundary before it or at the one
 * behind it. crossings: number of the random draw for the boundary behind; reflectance: of that boundary. */
CML_LOOP void cml_queue_find_not_ballistic(const struct cml_setup *setup, real path, real mfp,
                                           cml_u32 crossings, real reflectance,
                                           struct cml_launch_queue *queue)
{
    const struct cml_stream stream = setup->stream;
    const struct cml_queue_crossing behind = cml_queue_crossing_of(setup, queue, crossings);
#pragma omp simd
    for (int i = 0; i < CML_QUEUE; i++) {
        const cml_u32 word = cml_queue_reflection(stream, queue, i, behind);
        const int interacts = !(path < cml_path(queue->tau[i], mfp)), enters = queue->through[i];
        queue->not_ballistic[i] = interacts | !enters | (cml_uniform(word) <= reflectance);
    }
}

/* Fills lanes of the group that begins at `first` with packets like `start`: lane first + k if bit k of
 * `lanes` is set. Indices, draws and optical depths have come from the queue; the caller loads media.
 * absorbed: [CML_LANES] deposits of the lanes' packets. */
CML_LOOP void cml_bundle_launch(struct cml_bundle *b, const struct cml_packet *start, uint64_t *absorbed,
                                int first, cml_u32 lanes)
{
    const struct cml_packet model = *start;
#pragma omp simd
    for (int k = 0; k < CML_GROUP; k++) {
        const int i = first + k, active = (int)(lanes >> k & 1u);
        b->x[i] = cml_pick(active, model.p.x, b->x[i]);
        b->y[i] = cml_pick(active, model.p.y, b->y[i]);
        b->z[i] = cml_pick(active, model.p.z, b->z[i]);
        b->ux[i] = cml_pick(active, model.u.x, b->ux[i]);
        b->uy[i] = cml_pick(active, model.u.y, b->uy[i]);
        b->uz[i] = cml_pick(active, model.u.z, b->uz[i]);
        b->w[i] = cml_pick_word(active, model.w, b->w[i]);
        b->flushed_w[i] = cml_pick_word(active, model.w, b->flushed_w[i]);
        b->interactions[i] = cml_pick_word(active, 0u, b->interactions[i]);
        b->crossings[i] = cml_pick_word(active, model.crossings, b->crossings[i]);
        b->rough_draws[i] = cml_pick_word(active, 0u, b->rough_draws[i]);
        b->boundary_events[i] = cml_pick_word(active, model.boundary_events, b->boundary_events[i]);
        b->interactions_at_hit[i] = cml_pick_word(active, 0u, b->interactions_at_hit[i]);
        b->bounces[i] = cml_pick_word(active, model.bounces, b->bounces[i]);
        b->on_boundary[i] = cml_pick_int(active, model.on_boundary, b->on_boundary[i]);
        b->on_primitive[i] = cml_pick_int(active, model.on_primitive, b->on_primitive[i]);
        b->undeflected[i] = cml_pick_int(active, model.undeflected, b->undeflected[i]);
        b->entered[i] = cml_pick_int(active, model.entered, b->entered[i]);
        b->task[i] = cml_pick_int(active, CML_LANE_TO_FLY, b->task[i]);
        absorbed[i] = active ? 0u : absorbed[i];
    }
}

/* Gives new packets in the lanes of a group their words of the lattice, as in cml_bundle_launch: for the
 * interactions after the first, and for the reflections. reversed: [CML_GROUP] of their photons; shifts:
 * [CML_LATTICE_BLOCKS] of their batch. */
CML_LOOP void cml_bundle_launch_lattice(struct cml_bundle *b, const cml_u32 *reversed,
                                        const struct cml_block *shifts, int first, cml_u32 lanes)
{
    const struct cml_block first_block = shifts[0], second = shifts[1], third = shifts[2], last = shifts[3];
#pragma omp simd
    for (int k = 0; k < CML_GROUP; k++) {
        const int i = first + k, active = (int)(lanes >> k & 1u);
        const cml_u32 x = reversed[k];
        b->second0[i] = cml_pick_word(active, cml_lattice_word(x, 4, second, 0), b->second0[i]);
        b->second1[i] = cml_pick_word(active, cml_lattice_word(x, 5, second, 0), b->second1[i]);
        b->second2[i] = cml_pick_word(active, cml_lattice_word(x, 6, second, 0), b->second2[i]);
        b->third0[i] = cml_pick_word(active, cml_lattice_word(x, 8, third, 0), b->third0[i]);
        b->third1[i] = cml_pick_word(active, cml_lattice_word(x, 9, third, 0), b->third1[i]);
        b->third2[i] = cml_pick_word(active, cml_lattice_word(x, 10, third, 0), b->third2[i]);
        b->reflection[i] = cml_pick_word(active, cml_lattice_word(x, CML_LATTICE_REFLECTION, first_block, 0),
                                         b->reflection[i]);
        b->second_reflection[i] = cml_pick_word(
            active, cml_lattice_word(x, CML_LATTICE_SECOND_REFLECTION, last, 0), b->second_reflection[i]);
    }
}

/* The boundaries that lane i may meet on a path of length s (cm), by depths alone: flags, 1 or 0. A boundary
 * may be met if the path ends beyond the nearest part of it, or, if it is curved, begins beyond this part. A
 * path can meet a plane only if it ends beyond it, so planes have no start flag.
 *
 *       stop_above   - - - - - - - - - - - - - -
 *                           .     nothing here          a path between these depths meets no boundary
 *                       p --'--> q
 *       stop_below   - - - - - - - - - - - - - -
 *
 * The flags are conservative: a boundary without a flag cannot be met, rounding included. Each comparison is
 * the negation of the safe case, so a path that is infinite or not a number is sent on to the code that
 * handles such packets. */
struct cml_lane_candidates {
    /* Ends or starts beyond a boundary, or within its heights. */
    int ends_above, ends_below, starts_above, starts_below;
};

/* Returns which boundaries lane i may meet on a path of length s (cm), by the depths at which the path
 * starts and ends. */
static inline struct cml_lane_candidates cml_find_lane_candidates(const struct cml_bundle *b, int i, real s)
{
    const real z = b->z[i], step = s * b->uz[i], end = z + step, err_depth = cml_err_depth(z, step);
    const struct cml_lane_candidates ahead = {
        .ends_above = !(end - err_depth > CML_OF_MEDIUM(b, stop_above)[i]),
        .ends_below = !(end + err_depth < CML_OF_MEDIUM(b, stop_below)[i]),
        .starts_above = !(z - err_depth > CML_OF_MEDIUM(b, start_above)[i]),
        .starts_below = !(z + err_depth < CML_OF_MEDIUM(b, start_below)[i])};
    return ahead;
}

/* True if lane i may meet a boundary before its interaction. *distance: to the interaction, cm. In thick
 * media hardly any lane may, and boundaries cost no more than this comparison of depths. */
static inline int cml_lane_may_hit(const struct cml_bundle *b, int i, real tau, real *distance)
{
    const real s = cml_path(tau, CML_OF_MEDIUM(b, mfp)[i]);
    const struct cml_lane_candidates ahead = cml_find_lane_candidates(b, i, s);
    *distance = s;
    return ahead.ends_above | ahead.ends_below | ahead.starts_above | ahead.starts_below;
}

/* Gives lanes that have crossed or left a plane, or hold a new packet, the path to their interaction, and the
 * task INTERACT or MAY_HIT, as cml_bundle_fly does for all lanes. */
CML_LOOP void cml_bundle_fly_again(struct cml_bundle *b)
{
    const int lanes = b->lanes;
#pragma omp simd
    for (int i = 0; i < lanes; i++) {
        real s;
        const int task = b->task[i], active = (task == CML_LANE_TO_FLY) | (task == CML_LANE_REFLECTED);
        const int may_hit = cml_lane_may_hit(b, i, b->tau[i], &s);
        b->s[i] = cml_pick(active, s, b->s[i]);
        b->task[i] = active ? (may_hit ? CML_LANE_MAY_HIT : CML_LANE_INTERACT) : task;
    }
}

/* Draws the words of the next interaction in all lanes (rng.h), for the second and third interaction from the
 * lattice (lattice.h); the first words came with the launch. Lanes with INTERACT have just had an
 * interaction, and count it here. The others keep their values, although a vector loop computes new ones as
 * well. */
CML_LOOP void cml_bundle_draw(const struct cml_setup *setup, struct cml_bundle *b)
{
    const int lanes = b->lanes;
    const struct cml_stream stream = setup->stream;
    const cml_u32 none = ~0u, second = setup->stream.lattice ? 1u : none,
                  third = setup->stream.lattice ? 2u : none;
#pragma omp simd
    for (int i = 0; i < lanes; i++) {
        const int active = b->task[i] == CML_LANE_INTERACT;
        const cml_u32 interactions = b->interactions[i] + (cml_u32)active;
        const struct cml_block draw =
            cml_threefry(stream, b->index_low[i], b->index_high[i], interactions, CML_PURPOSE_INTERACTION);
        const int is_second = interactions == second, even = is_second | (interactions == third);
        const cml_u32 even0 = cml_pick_word(is_second, b->second0[i], b->third0[i]);
        const cml_u32 even1 = cml_pick_word(is_second, b->second1[i], b->third1[i]);
        const cml_u32 even2 = cml_pick_word(is_second, b->second2[i], b->third2[i]);
        b->interactions[i] = interactions;
        b->draw0[i] = cml_even_or_random(even, even0, draw.w[0]);
        b->draw1[i] = cml_pick_word(active, cml_even_or_random(even, even1, draw.w[1]), b->draw1[i]);
        b->draw2[i] = cml_pick_word(active, cml_even_or_random(even, even2, draw.w[2]), b->draw2[i]);
    }
}

/* Findings of a loop over all lanes, as bits. */
enum { CML_ANY_MAY_HIT = 1, CML_ANY_TAIL = 2 };

/* Gives lanes with INTERACT a new optical depth (P2), and all lanes the path s to their interaction, with the
 * task INTERACT, or MAY_HIT if a boundary may come first. Returns CML_ANY_MAY_HIT if any lane may hit, and
 * CML_ANY_TAIL with it if an optical depth lies in the tail: the path of such a lane is infinite, so it may
 * hit. */
CML_LOOP int cml_bundle_fly(struct cml_bundle *b)
{
    const int lanes = b->lanes;
    int any = 0;
#pragma omp simd
    for (int i = 0; i < lanes; i++) {
        const real fresh = cml_depth_or_tail(b->draw0[i]);
        const int active = b->task[i] == CML_LANE_INTERACT;
        b->tau[i] = cml_pick(active, fresh, b->tau[i]);
    }
#pragma omp simd reduction(| : any)
    for (int i = 0; i < lanes; i++) {
        real s;
        const int may_hit = cml_lane_may_hit(b, i, b->tau[i], &s);
        b->s[i] = s;
        b->task[i] = may_hit ? CML_LANE_MAY_HIT : CML_LANE_INTERACT;
        any |= may_hit * CML_ANY_MAY_HIT | !(b->tau[i] < CML_INFINITY) * CML_ANY_TAIL;
    }
    return any;
}

enum { CML_ANY_AT_PLANE = 1, CML_ANY_AT_LIMIT = 2 };

/* Moves lanes with MAY_HIT that meet a plane before they interact to this plane. They become TRANSMITTED if
 * the indices are equal, else AT_PLANE. A packet meets the plane that it heads for, and never the one that it
 * leaves. Lanes that meet no plane go back to INTERACT, or to NO_EVENT if they never interact.
 * Returns CML_ANY_AT_PLANE if any lane is AT_PLANE, and CML_ANY_AT_LIMIT with it if one has NO_EVENT or may
 * have bounced too often (cml_lane_is_at_limit). n1, n2: indices on the near and the far side; t: distance to
 * the plane, cm, below 0 if rounding has put the packet beyond it. measured: 1 if paths are counted (P11),
 * and s becomes the distance to the plane; constant, so that each case has a loop of its own. */
__attribute__((always_inline)) static inline int cml_bundle_move_to_planes(struct cml_bundle *b,
                                                                           const int measured)
{
    const real *restrict const muts = CML_OF_MEDIUM(b, mut), *restrict const n = CML_OF_MEDIUM(b, n);
    const real *restrict const n_above = CML_OF_MEDIUM(b, n_above), *restrict const n_below =
                                                                        CML_OF_MEDIUM(b, n_below);
    const real *restrict const stops_above = CML_OF_MEDIUM(b, stop_above);
    const real *restrict const stops_below = CML_OF_MEDIUM(b, stop_below);
    const real *restrict const starts_above = CML_OF_MEDIUM(b, start_above);
    const real *restrict const starts_below = CML_OF_MEDIUM(b, start_below);
    const int lanes = b->lanes;
    int at_planes = 0, at_limits = 0;
#pragma omp simd reduction(| : at_planes, at_limits)
    for (int i = 0; i < lanes; i++) {
        const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]}, p = {b->x[i], b->y[i], b->z[i]};
        const int task = b->task[i], active = task == CML_LANE_MAY_HIT, above = u.z < 0;
        const real s = b->s[i], tau = b->tau[i], below_z = stops_below[i], above_z = stops_above[i];
        const real start_above = starts_above[i], start_below = starts_below[i];
        const int plane_above = !(start_above > -CML_INFINITY), plane_below = !(start_below < CML_INFINITY);
        const int plane = (above & plane_above) | ((above ^ 1) & plane_below);
        const real na = n_above[i], nb = n_below[i], n1 = n[i], n2 = above ? na : nb;
        const real t = ((above ? above_z : below_z) - p.z) / u.z, ahead = t > 0 ? t : (real)0;
        const int hit = active & plane & (u.z != 0) & (t < s), number = s * u.z == s * u.z;
        const real left = CML_FMA(-ahead, muts[i], tau), tau_left = left > 0 ? left : (real)0;
        const struct cml_vec q = cml_along(p, ahead, u);
        const int matched = n1 == n2, lands = (s < CML_INFINITY) & number;
        const int missed = lands ? CML_LANE_INTERACT : CML_LANE_NO_EVENT;
        const int event = hit ? (matched ? CML_LANE_TRANSMITTED : CML_LANE_AT_PLANE) : missed;
        const cml_u32 interactions = b->interactions[i], at_hit = b->interactions_at_hit[i],
                      bounces = b->bounces[i];
        const cml_u32 so_far = at_hit == interactions ? bounces : 0u;
        b->x[i] = cml_pick(hit, q.x, p.x);
        b->y[i] = cml_pick(hit, q.y, p.y);
        b->z[i] = hit ? (above ? (real)0 : below_z) : p.z;
        b->tau[i] = cml_pick(hit, tau_left, tau);
        b->task[i] = cml_pick_int(active, event, task);
        if (measured) b->s[i] = cml_pick(hit, ahead, s);
        if (measured) {
            b->here[i] = cml_pick(hit, cml_here_after(b->here[i], b->path[i], ahead), b->here[i]);
            b->path[i] = cml_pick(hit, cml_path_after(b->path[i], ahead, n1), b->path[i]);
        }
        b->interactions_at_hit[i] = cml_pick_word(hit, interactions, at_hit);
        b->bounces[i] = cml_pick_word(hit, so_far + 1u, bounces);
        b->boundary_events[i] += (cml_u32)hit;
        b->on_boundary[i] = cml_pick_int(hit, -1, b->on_boundary[i]);
        at_planes |= hit & !matched;
        at_limits |= (hit & (int)(bounces >= CML_TRAPPED_LIMIT)) | (active & !hit & !lands);
    }
    return at_planes * CML_ANY_AT_PLANE + at_limits * CML_ANY_AT_LIMIT;
}

/* Counts the depths of lanes that planes have turned back (P13). Lanes that go through come into another
 * medium's frame. */
CML_LOOP void cml_bundle_count_reflected_depths(struct cml_bundle *b)
{
    const int lanes = b->lanes;
#pragma omp simd
    for (int i = 0; i < lanes; i++) {
        const int counts = (b->task[i] == CML_LANE_REFLECTED) & (b->z[i] > b->low[i]);
        b->low[i] = cml_pick(counts, b->z[i], b->low[i]);
    }
}

/* Runs cml_bundle_move_to_planes. measured: 1 if paths are counted. */
CML_LOOP int cml_bundle_reach_planes(struct cml_bundle *b, int measured)
{
    return measured ? cml_bundle_move_to_planes(b, 1) : cml_bundle_move_to_planes(b, 0);
}

/* Gives lanes AT_PLANE their new direction (P5), and makes them REFLECTED or TRANSMITTED. Both directions are
 * computed, and one is selected: Fresnel's reflectance against a random number. The medium changes later
 * (cml_enter_layer). */
CML_LOOP void cml_bundle_reflect_or_refract(const struct cml_setup *setup, struct cml_bundle *b)
{
    const struct cml_stream stream = setup->stream;
    /* Number of first reflections that draw from the lattice. */
    const cml_u32 even = setup->stream.lattice ? CML_LATTICE_REFLECTIONS : 0u;
    const int lanes = b->lanes;
    const real *restrict const n = CML_OF_MEDIUM(b, n);
    const real *restrict const n_above = CML_OF_MEDIUM(b, n_above), *restrict const n_below =
                                                                        CML_OF_MEDIUM(b, n_below);
#pragma omp simd
    for (int i = 0; i < lanes; i++) {
        const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
        const int task = b->task[i], active = task == CML_LANE_AT_PLANE;
        const real na = n_above[i], nb = n_below[i];
        const cml_u32 crossing = b->crossings[i];
        const struct cml_block draw =
            cml_threefry(stream, b->index_low[i], b->index_high[i], crossing, CML_PURPOSE_BOUNDARY);
        const cml_u32 lattice = cml_pick_word(crossing == 0u, b->reflection[i], b->second_reflection[i]);
        const cml_u32 word = cml_even_or_random(crossing < even, lattice, draw.w[0]);
        int through;
        const struct cml_vec v = cml_plane_direction(u, n[i], u.z < 0 ? na : nb, cml_uniform(word), &through);
        const int event = through ? CML_LANE_TRANSMITTED : CML_LANE_REFLECTED;
        b->ux[i] = cml_pick(active, v.x, u.x);
        b->uy[i] = cml_pick(active, v.y, u.y);
        b->uz[i] = cml_pick(active, v.z, u.z);
        b->crossings[i] = crossing + (cml_u32)active;
        b->task[i] = cml_pick_int(active, event, task);
    }
}

/* True if lane i has reached a limit of P9, after cml_bundle_reach_planes and cml_bundle_reflect_or_refract:
 * it has no event ahead, or it is still in the material and has had more boundary events in a row than
 * CML_TRAPPED_LIMIT. */
static inline int cml_lane_is_at_limit(const struct cml_bundle *b, int i, int layers)
{
    const int task = b->task[i], from = b->medium[i], crossed = task == CML_LANE_TRANSMITTED;
    const int medium = from + (b->uz[i] < 0 ? -crossed : crossed);
    if (task == CML_LANE_NO_EVENT) return 1;
    if (!crossed && task != CML_LANE_REFLECTED) return 0;
    return medium > 0 && medium <= layers && b->bounces[i] > CML_TRAPPED_LIMIT;
}

/* Returns the mask of a group's lanes that leave through a plane (P6): TRANSMITTED into an outer medium, or
 * REFLECTED in the one where they have started. */
static inline cml_u32 cml_group_leaves(const struct cml_bundle *b, int first, int layers)
{
    const int *task = b->task + first, *medium = b->medium + first;
    const cml_u32 upwards = cml_group_negative(b->uz + first);
    const cml_u32 ends =
        (upwards & cml_group_equal(medium, 1)) | (~upwards & cml_group_equal(medium, layers));
    const cml_u32 outside = cml_group_equal(medium, 0) | cml_group_equal(medium, layers + 1);
    return (ends & cml_group_equal(task, CML_LANE_TRANSMITTED)) |
           (outside & cml_group_equal(task, CML_LANE_REFLECTED));
}
