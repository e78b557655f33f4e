/* Code, included by bundle_walk_inl.h only: fluence of lanes (P14), that is scores of interactions and marks
 * on paths, and the interactions that make up A(r,z) and A(t) of rows (P16).
 * It is compiled once for each level of the processor (engine_cpu_level.c says why).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/cpu/bundle_interact_inl.h"
#include "engine/cpu/bundle_lanes_inl.h"
#include "engine/cpu/bundle_loops_inl.h"

/* Finds the cell of the coming interaction of lanes with INTERACT, which have not moved yet, and its score: 0
 * in lanes without one. marked: 1 in lanes that interact, but score by marks. */
CML_LOOP void cml_bundle_find_scores(const struct cml_setup *shared, const struct cml_bundle *b,
                                     cml_u32 *cell, cml_u32 *score, int *marked)
{
    const struct cml_setup setup = *shared;
    const int lanes = b->lanes;
    const real *restrict const bins = CML_OF_MEDIUM(b, bins), *restrict const mfp = CML_OF_MEDIUM(b, mfp);
#pragma omp simd
    for (int i = 0; i < lanes; i++) {
        const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]}, from = {b->x[i], b->y[i], b->z[i]};
        const int active = b->task[i] == CML_LANE_INTERACT, here = active & cml_is_dense(setup.marks, mfp[i]);
        cell[i] = cml_mark_cell(&setup, b->index_low[i], cml_along(from, b->s[i], u), bins[i]);
        score[i] =
            cml_pick_word(here, cml_interaction_score(setup.marks, cml_pick(here, mfp[i], 0), b->w[i]), 0u);
        marked[i] = active ^ here;
    }
}

/* Scores the marks of a lane's flight of t (cm). */
static void cml_mark_lane(struct cml_flight *f, int i, const struct cml_stretch *stretch, real t)
{
    f->b->mark[i] = cml_mark_stretch(f->world, &f->to, stretch, f->b->mark[i], t);
}

/* Scores the marks of a lane's flight to its interaction. */
static void cml_mark_lane_flight(struct cml_flight *f, int i)
{
    const struct cml_stretch stretch = cml_lane_stretch(f->b, i);
    cml_mark_lane(f, i, &stretch, f->b->s[i]);
}

/* Adds scores of all lanes to the fluence. This is no vector loop, because two lanes may hit the same cell.
 * It goes by groups, which a compiler unrolls. */
static inline void cml_add_scores(const struct cml_deposits *to, const cml_u32 *cell, const cml_u32 *score,
                                  int lanes)
{
    uint64_t *phi = to->phi;
    if (to->phi_is_shared)
        for (int i = 0; i < lanes; i++) cml_add_mark(to, cell[i], score[i]);
    else
        for (int first = 0; first < lanes; first += CML_GROUP)
            for (int i = first; i < first + CML_GROUP; i++) phi[cell[i]] += score[i];
}

/* Adds the scores of interactions to voxels and bins of time, which threads share. */
static void cml_add_more_scores(const struct cml_flight *f, const cml_u32 *score)
{
    const struct cml_bundle *b = f->b;
    for (int i = 0; i < b->lanes; i++) {
        const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]}, from = {b->x[i], b->y[i], b->z[i]};
        if (score[i])
            cml_mark_more(&f->world->setup, &f->to, b->index_low[i], cml_along(from, b->s[i], u),
                          CML_OF_MEDIUM(b, bins)[i],
                          cml_path_after(b->path[i], b->s[i], CML_OF_MEDIUM(b, n)[i]), score[i]);
    }
}

/* Scores the fluence of all lanes that are about to interact: in dense media at the interaction, elsewhere
 * at the marks on the flight to it. */
static void cml_mark_interactions(struct cml_flight *f)
{
    _Alignas(64) cml_u32 cell[CML_LANES], score[CML_LANES];
    _Alignas(64) int marked[CML_LANES];
    const int lanes = f->b->lanes;
    cml_bundle_find_scores(&f->world->setup, f->b, cell, score, marked);
    cml_add_scores(&f->to, cell, score, lanes);
    if (cml_marks_score_more(&f->to)) cml_add_more_scores(f, score);
    for (int first = 0; first < lanes; first += CML_GROUP)
        cml_for_lanes(f, (uint64_t)cml_group_equal(marked + first, 1) << first & f->live,
                      cml_mark_lane_flight);
}

/* Moves lanes to the planes that they meet (cml_bundle_reach_planes), and scores fluence at the marks on the
 * way. */
static int cml_reach_planes_with_marks(struct cml_flight *f)
{
    struct cml_bundle *b = f->b;
    _Alignas(64) real x[CML_LANES], y[CML_LANES], z[CML_LANES], path[CML_LANES];
    memcpy(path, b->path, sizeof path);
    memcpy(x, b->x, sizeof x);
    memcpy(y, b->y, sizeof y);
    memcpy(z, b->z, sizeof z);
    const int any = cml_bundle_reach_planes(b, 1);
    const uint64_t hit =
        cml_lanes_equal(b->task, CML_LANE_AT_PLANE) | cml_lanes_equal(b->task, CML_LANE_TRANSMITTED);
    for (uint64_t rest = hit; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        if (cml_is_dense(f->world->setup.marks, f->media[b->medium[i]].mfp)) continue;
        struct cml_stretch s = cml_lane_stretch(b, i);
        s.p = (struct cml_vec){x[i], y[i], z[i]};
        s.path = path[i];
        s.events--; /* the boundary event has been counted already */
        cml_mark_lane(f, i, &s, b->s[i]);
    }
    return any;
}

/* Scores the last flights of a group's packets, which leave through a plane. */
static void cml_mark_exits(const struct cml_flight *f, int first, cml_u32 exits)
{
    const struct cml_bundle *b = f->b;
    for (; exits; exits &= exits - 1) {
        const int i = first + __builtin_ctz(exits);
        struct cml_stretch s = cml_lane_stretch(b, i);
        s.p.z = 0;
        s.medium = s.u.z < 0 ? 0 : f->world->setup.num_layers + 1;
        (void)cml_mark_far(f->world, &f->to, &s, b->mark[i], CML_INFINITY);
    }
}

/* Books the absorption of rows of a sweep (P16) for lanes whose packets interact in a later time gate than
 * at their last booking, so that each gate gets its own share. Only if rows have A_t, absorption by time. */
static void cml_keep_time_of_rows(struct cml_flight *f)
{
    _Alignas(64) real since[CML_LANES];
    _Alignas(64) int later[CML_LANES];
    for (int i = 0; i < CML_LANES; i++)
        since[i] = cml_row_booked_at(cml_lane_factors(f, i), (size_t)f->rows.count);
    cml_bundle_find_later(&f->world->setup, f->b, since, later);
    for (int first = 0; first < f->b->lanes; first += CML_GROUP)
        cml_for_lanes(f, (uint64_t)cml_group_equal(later + first, 1) << first & f->live & ~f->ended,
                      cml_flush_deposits);
}

/* Adds those interactions that are drawn as samples to A(z) of all rows of a sweep (P16). Only a share of
 * interactions is sampled, because each costs work for every row. */
static void cml_sample_rows(struct cml_flight *f)
{
    const struct cml_bundle *b = f->b;
    _Alignas(64) int sampled[CML_LANES];
    cml_bundle_find_sampled(&f->world->setup, b, sampled);
    uint64_t lanes = 0;
    for (int first = 0; first < b->lanes; first += CML_GROUP)
        lanes |= (uint64_t)cml_group_equal(sampled + first, 1) << first;
    lanes &= f->live & ~f->ended;
    struct cml_row_place at[CML_LANES];
    for (uint64_t rest = lanes; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        const struct cml_row_packet rows = cml_lane_rows(f, i);
        const struct cml_vec p = {b->x[i], b->y[i], b->z[i]};
        at[i] = cml_rows_sampled_at(f->world, &rows, b->medium[i], p);
        cml_rows_expect(&rows, at[i]);
    }
    for (; lanes; lanes &= lanes - 1) {
        const int i = __builtin_ctzll(lanes);
        const cml_u32 before = b->flushed_w[i];
        cml_flush_deposits(f, i);
        const struct cml_row_packet rows = cml_lane_rows(f, i);
        cml_rows_sample(f->world, &rows, b->medium[i], at[i], before, b->w[i]);
    }
}
