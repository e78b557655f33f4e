/* Code, included by the other bundle_*_inl.h and so compiled once for each level of the processor: these are
 * the vector loops, for which the levels exist (engine_cpu_level.c). Every loop goes over all lanes of the
 * bundle. Lanes whose task is another compute as well, and keep what they had: a select costs less than a
 * branch. Lanes without a packet may hold anything. SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_LOOPS_INL_H
#define CML_BUNDLE_LOOPS_INL_H

#include "engine/cpu/bundle_masks.h"
#include "walk.h"

#include <stddef.h>

/* a where mine is 1, b where it is 0. Of `mine ? a : b` into the place that b comes from a compiler makes a
 * store on a condition: right where vectors have masks, but slow where they have none, and bits are picked
 * instead. */
static inline cml_u32 cml_pick_word(int mine, cml_u32 a, cml_u32 b)
{
#ifdef __AVX512F__
    return mine ? a : b;
#else
    const cml_u32 mask = 0u - (cml_u32)mine;
    return (a & mask) | (b & ~mask);
#endif
}

static inline int cml_pick_int(int mine, int a, int b)
{
    return (int)cml_pick_word(mine, (cml_u32)a, (cml_u32)b);
}

static inline real cml_pick(int mine, real a, real b)
{
    return cml_float_of(cml_pick_word(mine, cml_bits_of(a), cml_bits_of(b)));
}

/* Inlining would only mix their constants with those of their callers, and hide them from a profile. */
#define CML_LOOP static __attribute__((noinline))

/* Photons from `next` on. Those that are not reflected at the first boundary go through it: P5, for unequal
 * indices. Returns 1 when an optical depth is in the tail. */
CML_LOOP int cml_queue_draw(const struct cml_setup *setup, uint64_t next, real reflectance,
                            struct cml_launch_queue *queue)
{
    const struct cml_stream stream = setup->stream;
    const cml_u32 low = (cml_u32)next, high = (cml_u32)(next >> 32);
    int tail = 0;
#pragma omp simd reduction(| : tail)
    for (int i = 0; i < CML_QUEUE; i++) {
        const cml_u32 index = low + (cml_u32)i, carried = high + (cml_u32)(index < low);
        const struct cml_block draw = cml_threefry(stream, index, carried, 0, CML_PURPOSE_INTERACTION);
        queue->index_low[i] = index;
        queue->index_high[i] = carried;
        queue->tau[i] = cml_depth_or_tail(draw.w[0]);
        queue->draw1[i] = draw.w[1];
        queue->draw2[i] = draw.w[2];
        queue->through[i] = 1;
        tail |= draw.w[0] == 0u;
    }
    if (!(reflectance > 0)) return tail;
#pragma omp simd
    for (int i = 0; i < CML_QUEUE; i++) {
        const struct cml_block draw =
            cml_threefry(stream, queue->index_low[i], queue->index_high[i], 0, CML_PURPOSE_BOUNDARY);
        queue->through[i] = !(cml_uniform(draw.w[0]) <= reflectance);
    }
    return tail;
}

/* Which of them do not end ballistically: they interact in a medium of that mean free path before `path`, or
 * are reflected at one of the boundaries before and behind it. */
CML_LOOP void cml_queue_find_not_ballistic(struct cml_stream stream, real path, real mfp, cml_u32 crossings,
                                           real reflectance, struct cml_launch_queue *queue)
{
#pragma omp simd
    for (int i = 0; i < CML_QUEUE; i++) {
        const struct cml_block draw =
            cml_threefry(stream, queue->index_low[i], queue->index_high[i], crossings, CML_PURPOSE_BOUNDARY);
        const int interacts = !(path < cml_path(queue->tau[i], mfp)), enters = queue->through[i];
        queue->stays[i] = interacts | !enters | (cml_uniform(draw.w[0]) <= reflectance);
    }
}

/* Lanes first + i with bit i of lanes: packets like `start`, but for indices, draws and media. absorbed:
 * [CML_LANES], of the lanes' packets. */
CML_LOOP void cml_bundle_launch(struct cml_bundle *b, const struct cml_packet *start, uint64_t *absorbed,
                                int first, cml_u32 lanes)
{
    const struct cml_packet like = *start;
#pragma omp simd
    for (int k = 0; k < CML_GROUP; k++) {
        const int i = first + k, mine = (int)(lanes >> k & 1u);
        b->x[i] = cml_pick(mine, like.p.x, b->x[i]);
        b->y[i] = cml_pick(mine, like.p.y, b->y[i]);
        b->z[i] = cml_pick(mine, like.p.z, b->z[i]);
        b->ux[i] = cml_pick(mine, like.u.x, b->ux[i]);
        b->uy[i] = cml_pick(mine, like.u.y, b->uy[i]);
        b->uz[i] = cml_pick(mine, like.u.z, b->uz[i]);
        b->w[i] = cml_pick_word(mine, like.w, b->w[i]);
        b->flushed_w[i] = cml_pick_word(mine, like.w, b->flushed_w[i]);
        b->interactions[i] = cml_pick_word(mine, 0u, b->interactions[i]);
        b->crossings[i] = cml_pick_word(mine, like.crossings, b->crossings[i]);
        b->boundary_events[i] = cml_pick_word(mine, like.boundary_events, b->boundary_events[i]);
        b->touched[i] = cml_pick_word(mine, 0u, b->touched[i]);
        b->bounces[i] = cml_pick_word(mine, like.bounces, b->bounces[i]);
        b->on_boundary[i] = cml_pick_int(mine, like.on_boundary, b->on_boundary[i]);
        b->on_primitive[i] = cml_pick_int(mine, like.on_primitive, b->on_primitive[i]);
        b->undeflected[i] = cml_pick_int(mine, like.undeflected, b->undeflected[i]);
        b->entered[i] = cml_pick_int(mine, like.entered, b->entered[i]);
        b->task[i] = cml_pick_int(mine, CML_LANE_DONE, b->task[i]);
        absorbed[i] = mine ? 0u : absorbed[i];
    }
}

/* Which boundaries lane i may meet on a path of length s. Conservative: one that is not
 * named here cannot be met, rounding included; what is not a number, or infinite, may meet all. A plane is
 * met at the end of the path or before, never by a packet that stands on it and leads away. */
struct cml_lane_candidates {
    int ends_above, ends_below, starts_above, starts_below; /* beyond a boundary, or within its heights */
};

static inline struct cml_lane_candidates cml_find_lane_candidates(const struct cml_bundle *b, int i, real s)
{
    const real z = b->z[i], step = s * b->uz[i], end = z + step, slack = cml_err_depth(z, step);
    const struct cml_lane_candidates ahead = {.ends_above = !(end - slack > CML_OF_MEDIUM(b, stop_above)[i]),
                                              .ends_below = !(end + slack < CML_OF_MEDIUM(b, stop_below)[i]),
                                              .starts_above = !(z - slack > CML_OF_MEDIUM(b, start_above)[i]),
                                              .starts_below =
                                                  !(z + slack < CML_OF_MEDIUM(b, start_below)[i])};
    return ahead;
}

/* Whether lane i may meet a boundary before its interaction. */
static inline int cml_lane_is_near(const struct cml_bundle *b, int i, real tau, real *distance)
{
    const real s = cml_path(tau, CML_OF_MEDIUM(b, mfp)[i]);
    const struct cml_lane_candidates ahead = cml_find_lane_candidates(b, i, s);
    *distance = s;
    return ahead.ends_above | ahead.ends_below | ahead.starts_above | ahead.starts_below;
}

/* NEAR lanes that may meet a surface that is no plane get CURVED; those that can meet nothing before they
 * interact, INTERACT. steepest: slope of any surface; a direction that leaves one more steeply cannot cross
 * it. Returns 1 when any is CURVED. */
CML_LOOP int cml_bundle_classify_near(struct cml_bundle *b, real steepest)
{
    const int lanes = b->lanes;
    int any = 0;
#pragma omp simd reduction(| : any)
    for (int i = 0; i < lanes; i++) {
        const real ux = b->ux[i], uy = b->uy[i], uz = b->uz[i], s = b->s[i];
        const int task = b->task[i];
        const int steep = uz * uz >= steepest * steepest * (ux * ux + uy * uy);
        const int plane_above = !(CML_OF_MEDIUM(b, start_above)[i] > -CML_INFINITY),
                  plane_below = !(CML_OF_MEDIUM(b, start_below)[i] < CML_INFINITY);
        const struct cml_lane_candidates ahead = cml_find_lane_candidates(b, i, s);
        const int above = (ahead.starts_above | ahead.ends_above) & !plane_above,
                  below = (ahead.starts_below | ahead.ends_below) & !plane_below;
        const int plane = (ahead.ends_above & plane_above) | (ahead.ends_below & plane_below);
        const int curved = (above & !(steep & (uz > 0))) | (below & !(steep & (uz < 0)));
        const int free = !curved & !plane & (s < CML_INFINITY);
        const int near = curved ? CML_LANE_CURVED : (free ? CML_LANE_INTERACT : CML_LANE_NEAR);
        b->task[i] = task == CML_LANE_NEAR ? near : task;
        any |= (task == CML_LANE_NEAR) & curved;
    }
    return any;
}

/* Lanes that had their event: s, and INTERACT or NEAR. */
CML_LOOP void cml_bundle_fly_again(struct cml_bundle *b)
{
    const int lanes = b->lanes;
#pragma omp simd
    for (int i = 0; i < lanes; i++) {
        real s;
        const int task = b->task[i], mine = (task == CML_LANE_DONE) | (task == CML_LANE_REFLECTED);
        const int near = cml_lane_is_near(b, i, b->tau[i], &s);
        b->s[i] = cml_pick(mine, s, b->s[i]);
        b->task[i] = mine ? (near ? CML_LANE_NEAR : CML_LANE_INTERACT) : task;
    }
}

/* All lanes: the block of the next interaction. Those with INTERACT have just had one; the others get the
 * block again that they have. */
CML_LOOP void cml_bundle_draw(const struct cml_setup *setup, struct cml_bundle *b)
{
    const int lanes = b->lanes;
    const struct cml_stream stream = setup->stream;
#pragma omp simd
    for (int i = 0; i < lanes; i++) {
        const cml_u32 interactions = b->interactions[i] + (cml_u32)(b->task[i] == CML_LANE_INTERACT);
        const struct cml_block draw =
            cml_threefry(stream, b->index_low[i], b->index_high[i], interactions, CML_PURPOSE_INTERACTION);
        b->interactions[i] = interactions;
        b->draw0[i] = draw.w[0];
        b->draw1[i] = draw.w[1];
        b->draw2[i] = draw.w[2];
    }
}

enum { CML_ANY_NEAR = 1, CML_ANY_TAIL = 2 };

/* All lanes: those with INTERACT get a new optical depth, then all s and INTERACT or NEAR.
 * Returns CML_ANY_NEAR when any lane is near, and CML_ANY_TAIL with it when the optical depth of one is in
 * the tail.
 */
CML_LOOP int cml_bundle_fly(struct cml_bundle *b)
{
    const int lanes = b->lanes;
    int any = 0;
#pragma omp simd
    for (int i = 0; i < lanes; i++) {
        const real fresh = cml_depth_or_tail(b->draw0[i]);
        const int mine = b->task[i] == CML_LANE_INTERACT;
        b->tau[i] = cml_pick(mine, fresh, b->tau[i]);
    }
#pragma omp simd reduction(| : any)
    for (int i = 0; i < lanes; i++) {
        real s;
        const int near = cml_lane_is_near(b, i, b->tau[i], &s);
        b->s[i] = s;
        b->task[i] = near ? CML_LANE_NEAR : CML_LANE_INTERACT;
        any |= near * CML_ANY_NEAR | !(b->tau[i] < CML_INFINITY) * CML_ANY_TAIL;
    }
    return any;
}

enum { CML_ANY_AT_PLANE = 1, CML_ANY_AT_LIMIT = 2 };

/* Lanes that are NEAR: moved to the plane they meet and TRANSMITTED (equal indices) or AT_PLANE,
 * or back to INTERACT, or NOWHERE. Returns CML_ANY_AT_PLANE when any is AT_PLANE, and CML_ANY_AT_LIMIT with
 * it when one may be odd, as below. */
CML_LOOP int cml_bundle_reach_planes(struct cml_bundle *b)
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
        const int task = b->task[i], mine = task == CML_LANE_NEAR, above = u.z < 0;
        const real s = b->s[i], tau = b->tau[i], below_z = stops_below[i], above_z = stops_above[i];
        const real start_above = starts_above[i], start_below = starts_below[i];
        const int plane_above = !(start_above > -CML_INFINITY), plane_below = !(start_below < CML_INFINITY);
        const int plane = (above & plane_above) | ((above ^ 1) & plane_below);
        const real na = n_above[i], nb = n_below[i], n1 = n[i], n2 = above ? na : nb;
        const real t = ((above ? above_z : below_z) - p.z) / u.z, ahead = t > 0 ? t : (real)0;
        const int hit = mine & plane & (u.z != 0) & (t < s), number = s * u.z == s * u.z;
        const real left = CML_FMA(-ahead, muts[i], tau), tau_left = left > 0 ? left : (real)0;
        const struct cml_vec q = cml_along(p, ahead, u);
        const int matched = n1 == n2, lands = (s < CML_INFINITY) & number;
        const int missed = lands ? CML_LANE_INTERACT : CML_LANE_NOWHERE;
        const int event = hit ? (matched ? CML_LANE_TRANSMITTED : CML_LANE_AT_PLANE) : missed;
        const cml_u32 interactions = b->interactions[i], touched = b->touched[i], bounces = b->bounces[i];
        const cml_u32 row = touched == interactions ? bounces : 0u;
        b->x[i] = cml_pick(hit, q.x, p.x);
        b->y[i] = cml_pick(hit, q.y, p.y);
        b->z[i] = hit ? (above ? (real)0 : below_z) : p.z;
        b->tau[i] = cml_pick(hit, tau_left, tau);
        b->task[i] = cml_pick_int(mine, event, task);
        b->touched[i] = cml_pick_word(hit, interactions, touched);
        b->bounces[i] = cml_pick_word(hit, row + 1u, bounces);
        b->boundary_events[i] += (cml_u32)hit;
        b->on_boundary[i] = cml_pick_int(hit, -1, b->on_boundary[i]);
        at_planes |= hit & !matched;
        at_limits |= (hit & (int)(bounces >= CML_TRAPPED_LIMIT)) | (mine & !hit & !lands);
    }
    return at_planes * CML_ANY_AT_PLANE + at_limits * CML_ANY_AT_LIMIT;
}

/* Lanes AT_PLANE: P5. */
CML_LOOP void cml_bundle_reflect_or_refract(const struct cml_setup *setup, struct cml_bundle *b)
{
    const struct cml_stream stream = setup->stream;
    const int lanes = b->lanes;
    const real *restrict const n = CML_OF_MEDIUM(b, n);
    const real *restrict const n_above = CML_OF_MEDIUM(b, n_above), *restrict const n_below =
                                                                        CML_OF_MEDIUM(b, n_below);
#pragma omp simd
    for (int i = 0; i < lanes; i++) {
        const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
        const int task = b->task[i], mine = task == CML_LANE_AT_PLANE;
        const real na = n_above[i], nb = n_below[i];
        const struct cml_block draw =
            cml_threefry(stream, b->index_low[i], b->index_high[i], b->crossings[i], CML_PURPOSE_BOUNDARY);
        int through;
        const struct cml_vec v =
            cml_plane_direction(u, n[i], u.z < 0 ? na : nb, cml_uniform(draw.w[0]), &through);
        const int event = through ? CML_LANE_TRANSMITTED : CML_LANE_REFLECTED;
        b->ux[i] = cml_pick(mine, v.x, u.x);
        b->uy[i] = cml_pick(mine, v.y, u.y);
        b->uz[i] = cml_pick(mine, v.z, u.z);
        b->crossings[i] += (cml_u32)mine;
        b->task[i] = cml_pick_int(mine, event, task);
    }
}

/* Lane i, after reach_planes and reflect_or_refract: it is NOWHERE, or stays and has bounced too often. */
static inline int cml_lane_is_at_limit(const struct cml_bundle *b, int i, int layers)
{
    const int task = b->task[i], from = b->medium[i], crossed = task == CML_LANE_TRANSMITTED;
    const int medium = from + (b->uz[i] < 0 ? -crossed : crossed);
    if (task == CML_LANE_NOWHERE) return 1;
    if (!crossed && task != CML_LANE_REFLECTED) return 0;
    return medium > 0 && medium <= layers && b->bounces[i] > CML_TRAPPED_LIMIT;
}

/* P6: the lanes of a group that leave, TRANSMITTED into an outer medium or REFLECTED above the first layer.
 */
static inline cml_u32 cml_group_leaves(const struct cml_bundle *b, int first, int layers)
{
    const int *task = b->task + first, *medium = b->medium + first;
    const cml_u32 upwards = cml_group_negative(b->uz + first);
    const cml_u32 ends =
        (upwards & cml_group_equal(medium, 1)) | (~upwards & cml_group_equal(medium, layers));
    return (ends & cml_group_equal(task, CML_LANE_TRANSMITTED)) |
           (cml_group_equal(medium, 0) & cml_group_equal(task, CML_LANE_REFLECTED));
}

/* Lanes with INTERACT: hop, drop, spin. Fills dw (0 in other lanes) and cell, where absorption is tallied.
 * Returns 1 when a packet is below the roulette threshold. */
__attribute__((always_inline)) static inline int
cml_bundle_hop_drop_spin(const struct cml_setup *shared, struct cml_bundle *b, const int tally)
{
    const int lanes = b->lanes;
    const struct cml_setup setup = *shared; /* a copy that stores into the bundle cannot change */
    const real *restrict const absorb = CML_OF_MEDIUM(b, absorb), *restrict const bins =
                                                                      CML_OF_MEDIUM(b, bins);
    const real *restrict const g = CML_OF_MEDIUM(b, g);
    int low = 0;
#pragma omp simd reduction(| : low)
    for (int i = 0; i < lanes; i++) {
        const int mine = b->task[i] == CML_LANE_INTERACT;
        const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]}, from = {b->x[i], b->y[i], b->z[i]};
        const struct cml_vec p = cml_along(from, b->s[i], u);
        const cml_u32 w = b->w[i], part = cml_absorbed_part(w, absorb[i], b->draw2[i]);
        const cml_u32 dw = cml_pick_word(mine, part, 0), left = w - dw;
        if (tally) {
            const int ir = cml_radial_bin(&setup, p.x, p.y), iz = cml_depth_bin(&setup, p.z, bins[i]);
            b->cell[i] = ir * (setup.nz + 2) + iz;
            b->dw[i] = dw;
        }
        b->x[i] = cml_pick(mine, p.x, from.x);
        b->y[i] = cml_pick(mine, p.y, from.y);
        b->z[i] = cml_pick(mine, p.z, from.z);
        b->w[i] = left;
        low |= left < CML_ROULETTE_THRESHOLD;
    }
#pragma omp simd
    for (int i = 0; i < lanes; i++) {
        const int mine = b->task[i] == CML_LANE_INTERACT;
        const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
        const struct cml_vec v = cml_scatter(u, g[i], b->draw1[i], b->draw2[i]);
        b->ux[i] = cml_pick(mine, v.x, u.x);
        b->uy[i] = cml_pick(mine, v.y, u.y);
        b->uz[i] = cml_pick(mine, v.z, u.z);
    }
    return low;
}

CML_LOOP int cml_bundle_interact(const struct cml_setup *setup, struct cml_bundle *b)
{
    return cml_bundle_hop_drop_spin(setup, b, 1);
}

/* Where no absorption is tallied. */
CML_LOOP int cml_bundle_scatter(const struct cml_setup *setup, struct cml_bundle *b)
{
    return cml_bundle_hop_drop_spin(setup, b, 0);
}

#endif
