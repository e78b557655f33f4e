/* Code, included by bundle_walk_inl.h only: lanes that have come to a rough plane. They walk as in
 * kernels/rough.h (P20), one facet of all walks per round. Walks that have left go back into their lanes, and
 * the others close up.
 * It is compiled once for each level of the processor (engine_cpu_level.c says why).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/cpu/bundle_lanes_inl.h"
#include "engine/cpu/bundle_loops_inl.h"

/* Walks side by side, entries 0 to count - 1. Every column is 4 bytes wide. Loops go over whole vectors, so
 * entries behind the walks may hold anything. */
struct cml_rough_lanes {
    int count;
    uint64_t walking;                   /* mask: walks that have not left the surface */
    _Alignas(64) int leaves[CML_LANES]; /* 1: the walk leaves in this round, in direction ux, uy, uz */
    real ux[CML_LANES], uy[CML_LANES], uz[CML_LANES];
    cml_u32 reflection[CML_LANES]; /* word of the lattice for the first facet */
    int even[CML_LANES];           /* 1: the first facet uses this word */
    /* The columns from here on close up when walks end: */
    int lane[CML_LANES];
    real side[CML_LANES]; /* +1: the packet comes from below */
    /* Direction and depth, as in struct cml_rough_walk. */
    real vx[CML_LANES], vy[CML_LANES], vz[CML_LANES], e[CML_LANES];
    int beyond[CML_LANES];
    /* Words for the facet that the walk is at. */
    cml_u32 word1[CML_LANES], word2[CML_LANES], word3[CML_LANES];
    real alpha[CML_LANES], n1[CML_LANES], n2[CML_LANES];
    cml_u32 index_low[CML_LANES], index_high[CML_LANES];
    cml_u32 first[CML_LANES]; /* number of the walk's first block of random words */
};

/* Returns the frame of a packet that comes to a plane. side: +1 from below, -1 from above. */
static inline struct cml_frame cml_plane_frame(real side)
{
    const struct cml_vec against = {-side * 0, -side * 0, side}; /* the plane's normal is 0, 0, -1 */
    return cml_frame_about(against);
}

/* Adds lane i to the walks among facets of rough boundaries, which are made for many lanes at a time. Copies
 * what the walk needs: direction, indices on both sides, and the lane's random draws. */
static void cml_begin_rough_walk(struct cml_flight *f, int i, real alpha)
{
    struct cml_rough_lanes *w = f->rough;
    const struct cml_bundle *b = f->b;
    const int k = w->count++, upwards = b->uz[i] < 0;
    w->lane[k] = i;
    w->side[k] = upwards ? (real)1 : (real)-1;
    w->ux[k] = b->ux[i];
    w->uy[k] = b->uy[i];
    w->uz[k] = b->uz[i];
    w->beyond[k] = 0;
    w->alpha[k] = alpha;
    w->n1[k] = CML_OF_MEDIUM(b, n)[i];
    w->n2[k] = upwards ? CML_OF_MEDIUM(b, n_above)[i] : CML_OF_MEDIUM(b, n_below)[i];
    w->index_low[k] = b->index_low[i];
    w->index_high[k] = b->index_high[i];
    w->first[k] = b->rough_draws[i];
    w->even[k] = b->crossings[i] < CML_LATTICE_REFLECTIONS && f->world->setup.stream.lattice > 0u;
    w->reflection[k] = b->crossings[i] == 0u ? b->reflection[i] : b->second_reflection[i];
}

/* Takes the walks of all lanes at a rough boundary to their first facet. kind: the distribution of slopes,
 * constant so that each has a loop of its own. */
__attribute__((always_inline)) static inline void
cml_rough_lanes_come(struct cml_stream stream, struct cml_rough_lanes *w, const int kind)
{
    const int size = cml_whole_vectors(w->count);
#pragma omp simd
    for (int k = 0; k < size; k++) {
        const struct cml_rough rough = {kind, w->alpha[k]};
        const struct cml_frame frame = cml_plane_frame(w->side[k]);
        const struct cml_vec u = {w->ux[k], w->uy[k], w->uz[k]}, v = cml_in_frame(frame, u);
        const struct cml_block draw =
            cml_threefry(stream, w->index_low[k], w->index_high[k], w->first[k], CML_PURPOSE_ROUGH);
        real e = 0;
        /* A packet that comes goes down, so it does not leave. */
        (void)cml_rough_fly(rough, v, &e, draw.w[0]);
        w->vx[k] = v.x;
        w->vy[k] = v.y;
        w->vz[k] = v.z;
        w->e[k] = e;
        w->word1[k] = draw.w[1];
        w->word2[k] = draw.w[2];
        w->word3[k] = cml_even_or_random(w->even[k], w->reflection[k], draw.w[3]);
    }
}

/* Does one round of the walks over facets of rough boundaries: every walk turns at its facet number `steps`,
 * counted from 1, and then leaves or comes to another facet. kind: constant. */
__attribute__((always_inline)) static inline void
cml_rough_lanes_turn(struct cml_stream stream, struct cml_rough_lanes *w, cml_u32 steps, const int kind)
{
    const int size = cml_whole_vectors(w->count);
#pragma omp simd
    for (int k = 0; k < size; k++) {
        const struct cml_rough rough = {kind, w->alpha[k]};
        const struct cml_rough_walk at = {{w->vx[k], w->vy[k], w->vz[k]}, w->e[k], w->beyond[k], 0};
        const real n1 = w->n1[k], n2 = w->n2[k];
        const struct cml_block draw =
            cml_threefry(stream, w->index_low[k], w->index_high[k], w->first[k] + steps, CML_PURPOSE_ROUGH);
        const struct cml_vec m = cml_rough_normal(rough, at.v, w->word1[k], w->word2[k]);
        const struct cml_rough_walk walk =
            cml_rough_turn(at, m, at.beyond ? n2 : n1, at.beyond ? n1 : n2, w->word3[k]);
        real e = walk.e;
        w->leaves[k] = cml_rough_fly(rough, walk.v, &e, draw.w[0]);
        const struct cml_frame frame = cml_plane_frame(w->side[k]);
        const struct cml_vec v = {walk.v.x, walk.v.y, walk.beyond ? -walk.v.z : walk.v.z};
        const struct cml_vec u = cml_normalise(cml_from_frame(frame, v));
        w->ux[k] = u.x;
        w->uy[k] = u.y;
        w->uz[k] = u.z;
        w->vx[k] = walk.v.x;
        w->vy[k] = walk.v.y;
        w->vz[k] = walk.v.z;
        w->e[k] = e;
        w->beyond[k] = walk.beyond;
        w->word1[k] = draw.w[1];
        w->word2[k] = draw.w[2];
        w->word3[k] = draw.w[3];
    }
}

/* Compiles cml_rough_lanes_come for the GGX distribution, so that the loop has no branch for the kind. */
CML_LOOP void cml_rough_lanes_come_ggx(struct cml_stream stream, struct cml_rough_lanes *w)
{
    cml_rough_lanes_come(stream, w, CML_ROUGH_GGX);
}

/* Compiles cml_rough_lanes_come for the Beckmann distribution, so that the loop has no branch for the
 * kind. */
CML_LOOP void cml_rough_lanes_come_beckmann(struct cml_stream stream, struct cml_rough_lanes *w)
{
    cml_rough_lanes_come(stream, w, CML_ROUGH_BECKMANN);
}

/* Compiles cml_rough_lanes_turn for the GGX distribution, so that the loop has no branch for the kind. */
CML_LOOP void cml_rough_lanes_turn_ggx(struct cml_stream stream, struct cml_rough_lanes *w, cml_u32 steps)
{
    cml_rough_lanes_turn(stream, w, steps, CML_ROUGH_GGX);
}

/* Compiles cml_rough_lanes_turn for the Beckmann distribution, so that the loop has no branch for the
 * kind. */
CML_LOOP void cml_rough_lanes_turn_beckmann(struct cml_stream stream, struct cml_rough_lanes *w,
                                            cml_u32 steps)
{
    cml_rough_lanes_turn(stream, w, steps, CML_ROUGH_BECKMANN);
}

/* Puts the k-th walk, which has left after `steps` facets, back into its lane. */
static void cml_end_rough_walk(struct cml_flight *f, int k, cml_u32 steps)
{
    const struct cml_rough_lanes *w = f->rough;
    struct cml_bundle *b = f->b;
    const int i = w->lane[k];
    b->ux[i] = w->ux[k];
    b->uy[i] = w->uy[k];
    b->uz[i] = w->uz[k];
    b->crossings[i]++;
    b->rough_draws[i] += steps + 1;
    b->task[i] = w->beyond[k] ? CML_LANE_TRANSMITTED : CML_LANE_REFLECTED;
}

/* Closes up the walks if fewer vectors then hold them: every column is packed group by group. */
static void cml_close_up_rough_walks(struct cml_rough_lanes *w)
{
    const int left = __builtin_popcountll(w->walking);
    if (cml_whole_vectors(left) == cml_whole_vectors(w->count)) return;
    int at = 0;
    for (int first = 0; first < w->count; first += CML_GROUP) {
        const cml_u32 stay = (cml_u32)(w->walking >> first) & CML_GROUP_MASK;
        for (char *columns = (char *)w->lane; stay && columns < (char *)(w + 1); columns += sizeof w->lane)
            cml_group_pack(columns + sizeof(int) * (size_t)first, stay, columns + sizeof(int) * (size_t)at);
        at += __builtin_popcount(stay);
    }
    w->count = left;
    w->walking = left ? ~(uint64_t)0 >> (CML_LANES - left) : 0;
}

/* Ends the walks of the packets that leave the facets of a rough boundary in this round, and moves the walks
 * that go on to the front of the list. steps: number of facets met so far. */
static void cml_end_rough_walks(struct cml_flight *f, cml_u32 steps)
{
    struct cml_rough_lanes *w = f->rough;
    uint64_t leave = 0;
    for (int first = 0; first < w->count; first += CML_GROUP)
        leave |= (uint64_t)cml_group_equal(w->leaves + first, 1) << first;
    leave &= w->walking;
    w->walking &= ~leave;
    for (; leave; leave &= leave - 1) cml_end_rough_walk(f, __builtin_ctzll(leave), steps);
    cml_close_up_rough_walks(w);
}

/* Takes all lanes that have come to a rough plane with this distribution of slopes through the plane (P20):
 * all walk over its facets at once, round by round, until each has left. Walks that meet too many facets are
 * given up as lost. */
static void cml_cross_rough_planes_of(struct cml_flight *f, uint64_t lanes, enum cml_rough_kind kind)
{
    struct cml_rough_lanes *w = f->rough;
    const struct cml_bundle *b = f->b;
    const struct cml_stream stream = f->world->setup.stream;
    w->count = 0;
    for (; lanes; lanes &= lanes - 1) {
        const int i = __builtin_ctzll(lanes);
        const struct cml_rough rough = f->world->surfaces[b->medium[i] - (b->uz[i] < 0)].rough;
        if (rough.kind == (int)kind) cml_begin_rough_walk(f, i, rough.alpha);
    }
    if (w->count == 0) return;
    w->walking = ~(uint64_t)0 >> (CML_LANES - w->count);
    if (kind == CML_ROUGH_GGX)
        cml_rough_lanes_come_ggx(stream, w);
    else
        cml_rough_lanes_come_beckmann(stream, w);
    for (cml_u32 steps = 1; w->walking && steps <= CML_ROUGH_LIMIT; steps++) {
        if (kind == CML_ROUGH_GGX)
            cml_rough_lanes_turn_ggx(stream, w, steps);
        else
            cml_rough_lanes_turn_beckmann(stream, w, steps);
        if (steps < CML_ROUGH_LIMIT) cml_end_rough_walks(f, steps);
    }
    for (; w->walking; w->walking &= w->walking - 1)
        cml_end_lane(f, w->lane[__builtin_ctzll(w->walking)], CML_FATE_LOST, CML_LOST_ROUGH);
}

/* Takes all lanes that have come to rough planes through them (P20). Returns 1 if no lane is AT_PLANE any
 * more. */
static int cml_cross_rough_planes(struct cml_flight *f)
{
    const int *task = f->b->task;
    cml_cross_rough_planes_of(f, cml_lanes_equal(task, CML_LANE_AT_PLANE), CML_ROUGH_GGX);
    const uint64_t left = cml_lanes_equal(task, CML_LANE_AT_PLANE);
    if (left) cml_cross_rough_planes_of(f, left, CML_ROUGH_BECKMANN);
    return !left || !cml_lanes_equal(task, CML_LANE_AT_PLANE);
}
