/* Code, included by bundle_walk_inl.h and bundle_marks_inl.h: the vector loops of an interaction, which are
 * flight, absorption and scattering (MCML's hop, drop and spin).
 * It is compiled once for each level of the processor (engine_cpu_level.c says why).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/cpu/bundle_loops_inl.h"

/* Moves all lanes that interact to their interaction (P2) and absorbs a part of their weight there (P3).
 * tally: 1 fills each lane's cell (P7) and deposit dw, 0 in lanes that do not interact, so that all can be
 * added without a branch. trails: 1 updates the packets' records of their paths (P13). Both are constant, so
 * that each case has its own loop. Returns 1 if a packet is below the roulette's threshold. */
__attribute__((always_inline)) static inline int cml_bundle_move_and_absorb(const struct cml_setup *shared,
                                                                            struct cml_bundle *b,
                                                                            const int tally, const int trails)
{
    const int lanes = b->lanes;
    const struct cml_setup setup = *shared; /* a copy, which stores into the bundle cannot change */
    const real *restrict const absorb = CML_OF_MEDIUM(b, absorb), *restrict const bins =
                                                                      CML_OF_MEDIUM(b, bins);
    int low = 0;
#pragma omp simd reduction(| : low)
    for (int i = 0; i < lanes; i++) {
        const int active = b->task[i] == CML_LANE_INTERACT;
        const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]}, from = {b->x[i], b->y[i], b->z[i]};
        const struct cml_vec p = cml_along(from, b->s[i], u);
        const cml_u32 w = b->w[i], part = cml_absorbed_part(w, absorb[i], b->draw1[i], b->draw2[i]);
        const cml_u32 dw = cml_pick_word(active, part, 0), left = w - dw;
        if (tally) {
            const int ir = cml_radial_bin(&setup, p.x, p.y), iz = cml_depth_bin(&setup, p.z, bins[i]);
            b->cell[i] = ir * (setup.nz + 2) + iz;
            b->dw[i] = dw;
        }
        b->x[i] = cml_pick(active, p.x, from.x);
        b->y[i] = cml_pick(active, p.y, from.y);
        b->z[i] = cml_pick(active, p.z, from.z);
        b->w[i] = left;
        if (trails) {
            const real z = b->z[i], deepest = b->low[i];
            b->here[i] += cml_pick(active, b->s[i], (real)0);
            b->low[i] = z > deepest ? z : deepest;
        }
        low |= left < setup.roulette.below;
    }
    return low;
}

/* Counts the optical paths of lanes that interact (P11). gate: [CML_LANES] gate of each lane; changed:
 * [CML_LANES] 1 if it is another gate than before. */
CML_LOOP void cml_bundle_count_paths(const struct cml_setup *setup, struct cml_bundle *b, int *gate,
                                     int *changed)
{
    const int lanes = b->lanes;
    const struct cml_gates gates = setup->gates;
    const real *restrict const n = CML_OF_MEDIUM(b, n);
#pragma omp simd
    for (int i = 0; i < lanes; i++) {
        const int active = b->task[i] == CML_LANE_INTERACT;
        const real path = cml_pick(active, CML_FMA(b->s[i], n[i], b->path[i]), b->path[i]);
        b->path[i] = path;
        gate[i] = cml_gate(gates, path);
        changed[i] = gate[i] != b->gate[i];
    }
}

/* Finds lanes that interact in another gate than that of `since`, the time when their rows were last booked
 * (P16): later[CML_LANES] 1. */
CML_LOOP void cml_bundle_find_later(const struct cml_setup *setup, const struct cml_bundle *b,
                                    const real *since, int *later)
{
    const struct cml_gates gates = setup->gates;
#pragma omp simd
    for (int i = 0; i < CML_LANES; i++)
        later[i] = (b->task[i] == CML_LANE_INTERACT) &
                   (cml_gate(gates, since[i] + b->path[i]) != cml_gate(gates, since[i]));
}

/* Finds the cells of phase tables for all lanes. They are fetched one by one, because gather instructions
 * take longer, and before the lanes move, because those vectors need not wait for them. Both members of a
 * cell that has parts are negative. */
CML_LOOP void cml_bundle_find_phases(const struct cml_phase_cell *cells, const struct cml_bundle *b,
                                     struct cml_phase_cell *cell)
{
    const int lanes = b->lanes;
    const real *restrict const g = CML_OF_MEDIUM(b, g);
    _Alignas(64) cml_u32 number[CML_LANES];
#pragma omp simd
    for (int i = 0; i < lanes; i++) number[i] = cml_phase_cell_number(g[i], b->draw1[i]);
#pragma GCC unroll 8
    for (int i = 0; i < lanes; i++) {
        int64_t both;
        memcpy(&both, &cells[number[i]], sizeof both);
        memcpy(&cell[i], &both, sizeof both);
        if (__builtin_expect(both < 0, 0)) cell[i] = cml_phase_cell_at(cells, number[i], b->draw1[i]);
    }
}

/* Scatters the lanes that interact (P4): by cells of tables, as cml_scatter_in does, or by Henyey and
 * Greenstein's function if cell is NULL. only_tables: as in cml_world; trails: as in
 * cml_bundle_move_and_absorb. All are constant. */
__attribute__((always_inline)) static inline void cml_bundle_turn(const struct cml_phase_cell *cell,
                                                                  struct cml_bundle *b, const int only_tables,
                                                                  const int trails)
{
    const int lanes = b->lanes;
    const real *restrict const g = CML_OF_MEDIUM(b, g);
#pragma omp simd
    for (int i = 0; i < lanes; i++) {
        const int active = b->task[i] == CML_LANE_INTERACT;
        const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
        const real drawn = cell ? cml_phase_one_minus(cell[i], b->draw1[i]) : (real)0;
        const struct cml_vec v = !cell         ? cml_scatter(u, g[i], b->draw1[i], b->draw2[i])
                                 : only_tables ? cml_scatter_drawn(u, g[i], drawn, b->draw2[i])
                                               : cml_scatter_either(u, g[i], drawn, b->draw1[i], b->draw2[i]);
        if (trails) b->momentum[i] += cml_pick(active, cml_one_minus_dot(u, v), (real)0);
        b->ux[i] = cml_pick(active, v.x, u.x);
        b->uy[i] = cml_pick(active, v.y, u.y);
        b->uz[i] = cml_pick(active, v.z, u.z);
    }
}

/* Scatters lanes by cells of phase tables, with the loop for only_tables and trails. */
CML_LOOP void cml_bundle_turn_by_tables(const struct cml_phase_cell *cell, struct cml_bundle *b,
                                        int only_tables)
{
    const int trails = b->stay != NULL;
    if (only_tables)
        trails ? cml_bundle_turn(cell, b, 1, 1) : cml_bundle_turn(cell, b, 1, 0);
    else
        trails ? cml_bundle_turn(cell, b, 0, 1) : cml_bundle_turn(cell, b, 0, 0);
}

/* Finds lanes that have interacted and whose weight lies outside of the weight window at their place (P19):
 * outside[i] = 1. Returns 1 if there is any. */
CML_LOOP int cml_bundle_find_outside(const struct cml_world *world, const struct cml_bundle *b, int *outside)
{
    const struct cml_weight_windows windows = world->windows;
    const real per_dz = world->setup.per_dz;
    const real *restrict const bins = CML_OF_MEDIUM(b, bins);
    _Alignas(64) int cell[CML_LANES];
    _Alignas(64) cml_u32 low[CML_LANES];
    _Alignas(64) real square[CML_LANES];
    int any = 0;
    for (int i = 0; i < CML_LANES; i++) square[i] = CML_FAR_FROM_WINDOWS;
    for (int k = 0; k < windows.places; k++) {
#pragma omp simd
        for (int i = 0; i < CML_LANES; i++) square[i] = cml_nearer(windows, k, b->x[i], b->y[i], square[i]);
    }
#pragma omp simd
    for (int i = 0; i < CML_LANES; i++)
        cell[i] = cml_window_cell_of(windows, per_dz, b->z[i], bins[i], square[i]);
#pragma GCC unroll 8
    for (int i = 0; i < CML_LANES; i++) low[i] = windows.low[cell[i]];
#pragma omp simd reduction(| : any)
    for (int i = 0; i < CML_LANES; i++) {
        const cml_u32 w = b->w[i];
        const int out = (b->task[i] == CML_LANE_INTERACT) & ((w < low[i]) | cml_is_heavy(w, low[i]));
        outside[i] = out;
        any |= out;
    }
    return any;
}

/* Finds lanes that have had an interaction which makes up A(r,z) of rows (P16): sampled[CML_LANES] 1. */
CML_LOOP void cml_bundle_find_sampled(const struct cml_setup *setup, const struct cml_bundle *b, int *sampled)
{
    const struct cml_setup copy = *setup;
#pragma omp simd
    for (int i = 0; i < CML_LANES; i++) {
        const cml_u32 hash = cml_row_hash_of(&copy, b->index_low[i], b->index_high[i]);
        sampled[i] = (b->task[i] == CML_LANE_INTERACT) & cml_row_samples(hash, b->interactions[i] + 1);
    }
}

/* Moves lanes to their interactions, absorbs and scatters them; absorption is tallied. Returns 1 if a packet
 * is below the roulette threshold. */
CML_LOOP int cml_bundle_interact(const struct cml_setup *setup, struct cml_bundle *b)
{
    const int low = cml_bundle_move_and_absorb(setup, b, 1, 0);
    cml_bundle_turn(NULL, b, 0, 0);
    return low;
}

/* Moves lanes to their interactions, absorbs and scatters them, without adding to arrays of absorption.
 * cml_flush_deposits finds the absorbed total from the loss of weight. */
CML_LOOP int cml_bundle_scatter(const struct cml_setup *setup, struct cml_bundle *b)
{
    const int low = cml_bundle_move_and_absorb(setup, b, 0, 0);
    cml_bundle_turn(NULL, b, 0, 0);
    return low;
}

/* Does what cml_bundle_interact does, for lanes whose packets record the depths and lengths of their paths
 * (trails, P13). */
CML_LOOP int cml_bundle_interact_along_trails(const struct cml_setup *setup, struct cml_bundle *b)
{
    const int low = cml_bundle_move_and_absorb(setup, b, 1, 1);
    cml_bundle_turn(NULL, b, 0, 1);
    return low;
}

/* Does what cml_bundle_scatter does, for lanes whose packets record their paths (trails, P13). */
CML_LOOP int cml_bundle_scatter_along_trails(const struct cml_setup *setup, struct cml_bundle *b)
{
    const int low = cml_bundle_move_and_absorb(setup, b, 0, 1);
    cml_bundle_turn(NULL, b, 0, 1);
    return low;
}

/* Moves, absorbs and scatters lanes in a scene with phase tables. tally: 1 if absorption is tallied. Returns
 * 1 if a packet is below the roulette threshold. */
CML_LOOP int cml_bundle_interact_by_tables(const struct cml_world *world, struct cml_bundle *b, int tally)
{
    _Alignas(64) struct cml_phase_cell cell[CML_LANES];
    cml_bundle_find_phases(world->phase_cells, b, cell);
    const struct cml_setup *setup = &world->setup;
    const int trails = b->stay != NULL;
    const int low = tally    ? trails ? cml_bundle_move_and_absorb(setup, b, 1, 1)
                                      : cml_bundle_move_and_absorb(setup, b, 1, 0)
                       : trails ? cml_bundle_move_and_absorb(setup, b, 0, 1)
                             : cml_bundle_move_and_absorb(setup, b, 0, 0);
    cml_bundle_turn_by_tables(cell, b, world->only_tables);
    return low;
}
