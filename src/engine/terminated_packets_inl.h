/* Code, included once by each engine on the host, in its precision (CML_DOUBLE or not) and for its level of
 * the processor: terminated packets on their way into a tally. They are collected, so that one vector loop
 * computes exit bins and sums of many packets, however rarely packets end.
 *
 *      packet ends --> push --+
 *      packet ends --> push --+--> struct cml_terminated --> flush: vector loops --> tally
 *      packet ends --> push --+        up to 128
 *
 * It is no .c file, because entries are pushed member by member from registers, and the sums are vector
 * loops.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/detected_light_inl.h"
#include "engine/row_weights_inl.h"
#include "bins.h"
#include "tally/tally.h"
#include "walk.h"

#include <math.h>

#define CML_TERMINATED 128
/* Largest number of packets that are added in one go. The collection is flushed as soon as it has no room
 * for this many more. */
#define CML_TERMINATED_TOGETHER 16

/* The collection, a structure of arrays. Entries from `count` on hold any values, but loops over all entries
 * may read them. Weights are in units of 2^-31 of a packet, positions in cm from the scene's origin. */
struct cml_terminated {
    int count;
    int branches; /* entries that are branches, which were not launched (P19) */
    uint64_t absorbed[CML_TERMINATED];
    /* Further absorbed weight, from the layer that the packet left last, which is not added to the layer's
     * sums yet. */
    cml_u32 deposit[CML_TERMINATED];
    real exit_x[CML_TERMINATED], exit_y[CML_TERMINATED], uz[CML_TERMINATED];
    /* Direction of the exit, if directions (P7) or detectors (P13) are wanted. */
    real ux[CML_TERMINATED], uy[CML_TERMINATED];
    real path[CML_TERMINATED];   /* optical path (P11), if time is wanted */
    real exit_z[CML_TERMINATED]; /* used for detectors and saved packets (P13, P18), if trails are wanted */
    /* Halves of the packet's index. The high half is filled only if trails are wanted. */
    cml_u32 index_low[CML_TERMINATED], index_high[CML_TERMINATED];
    cml_u32 w[CML_TERMINATED], interactions[CML_TERMINATED], boundary_events[CML_TERMINATED];
    int fate[CML_TERMINATED];
    int cell[CML_TERMINATED];       /* cell of Rd_ra or Tt_ra */
    cml_u32 scored[CML_TERMINATED]; /* weight scored in this cell */
};

/* Returns the exit of entry i of the collection. */
static inline struct cml_exit cml_terminated_exit(const struct cml_setup *setup,
                                                  const struct cml_terminated *terminated, int i)
{
    return cml_exit_of(setup, terminated->fate[i], terminated->exit_x[i], terminated->exit_y[i],
                       terminated->uz[i], terminated->path[i]);
}

/* Sums over the collected packets, all in 64 bits, because vectors have lanes of this width. */
struct cml_terminated_sums {
    uint64_t reflected, transmitted, specular, absorbed, interactions, boundary_events;
    uint64_t deposited, deposited_above; /* all deposits; deposits of packets that were reflected */
};

/* Fills cell and scored: the cell of Rd_ra or Tt_ra in which each packet leaves (P7), and the weight it
 * scores there, 0 for a packet that did not leave. Cells count from the first of Rd_ra; those of the packet's
 * group and of Tt_ra lie fixed distances behind, so one array of sums serves all. The loop goes over all
 * entries: a loop of constant length has no remainder. */
static inline void cml_terminated_find_cells(const struct cml_setup *shared,
                                             struct cml_terminated *terminated, const struct cml_tally *tally)
{
    const struct cml_setup setup = *shared;
    const int na = setup.na, below = (int)(tally->Tt_ra - tally->Rd_ra);
    const cml_u32 step = (cml_u32)tally->layout.once[CML_ARRAY_Rd_ra].step;
#pragma omp simd
    for (int i = 0; i < CML_TERMINATED; i++) {
        const struct cml_exit exit = cml_terminated_exit(&setup, terminated, i);
        terminated->cell[i] =
            exit.r * na + (exit.down ? below : 0) + (int)(terminated->index_low[i] % CML_NUM_GROUPS * step);
        terminated->scored[i] = exit.up | exit.down ? terminated->w[i] : 0u;
    }
    if (na == 1) return;
#pragma omp simd
    for (int i = 0; i < CML_TERMINATED; i++)
        terminated->cell[i] += cml_terminated_exit(&setup, terminated, i).alpha;
}

/* Returns a mask for `&`, all bits set if the condition is true. gcc 14.2 compiles sums of `condition ? value
 * : 0` wrongly for AVX-512 (two of those in the loop below, from 8 packets on). */
static inline uint64_t cml_all_bits_if(int condition)
{
    return 0 - (uint64_t)condition;
}

/* Returns the sums over all collected packets, in one vector loop. A packet adds 0 to a sum that it has no
 * part in. */
static inline struct cml_terminated_sums cml_terminated_sum(const struct cml_setup *setup,
                                                            const struct cml_terminated *terminated)
{
    struct cml_terminated_sums sums = {0};
    for (int i = 0; i < terminated->count; i++) {
        const struct cml_exit exit = cml_terminated_exit(setup, terminated, i);
        const uint64_t w = terminated->w[i], deposit = terminated->deposit[i];
        const uint64_t up = cml_all_bits_if(exit.up);
        sums.reflected += w & up;
        sums.transmitted += w & cml_all_bits_if(exit.down);
        sums.specular += w & cml_all_bits_if(exit.fresh);
        sums.absorbed += terminated->absorbed[i] + deposit;
        sums.deposited += deposit;
        sums.deposited_above += deposit & up;
        sums.interactions += terminated->interactions[i];
        sums.boundary_events += terminated->boundary_events[i];
    }
    return sums;
}

/* Returns the index of entry i's packet. */
static inline cml_u64 cml_terminated_index(const struct cml_terminated *terminated, int i)
{
    return (cml_u64)terminated->index_high[i] << 32 | terminated->index_low[i];
}

/* Adds the light that was split off the packets at their launch to the bins of directions and to detectors.
 * The light is alike for all packets. count: number of launched packets, without branches, each taken `times`
 * times. */
static inline void cml_terminated_add_split_off(const struct cml_world *world,
                                                const struct cml_terminated *terminated, uint64_t times,
                                                uint64_t count, struct cml_tally *tally)
{
    const cml_u32 specular = world->setup.specular;
    const int detected = tally->detector && world->detection.split == CML_SPLIT_ALIKE;
    const struct cml_seen seen = cml_seen_by(tally);
    uint64_t of_group[CML_NUM_GROUPS] = {0};
    if (detected && !tally->detector_map) cml_score_split_off(world, 0, count, &seen, tally);
    if (!(tally->Rsp_dir && specular) && !(detected && tally->detector_map)) return;
    for (int i = 0; i < terminated->count; i++) {
        const int branch = terminated->branches && cml_is_branch(cml_terminated_index(terminated, i));
        if (!branch) of_group[terminated->index_low[i] % CML_NUM_GROUPS] += times;
    }
    for (cml_u64 g = 0; g < CML_NUM_GROUPS; g++) {
        if (!of_group[g]) continue;
        if (tally->Rsp_dir && specular)
            cml_add_once(tally->Rsp_dir, tally->grid.direction_once, g, specular, of_group[g]);
        if (detected && tally->detector_map) cml_score_split_off(world, g, of_group[g], &seen, tally);
    }
}

/* Adds all sums to the tally: balance (P10), deposits by layer, and counts. times: the number of packets that
 * each entry stands for, more than 1 only for ballistic packets. */
static inline void cml_terminated_add_sums(const struct cml_world *world,
                                           const struct cml_terminated *terminated, uint64_t times,
                                           struct cml_tally *tally)
{
    const struct cml_setup *setup = &world->setup;
    const struct cml_terminated_sums sums = cml_terminated_sum(setup, terminated);
    const uint64_t branches = (uint64_t)terminated->branches,
                   count = times * ((uint64_t)terminated->count - branches), specular = setup->specular;
    tally->balance[CML_BALANCE_LAUNCHED] += count * CML_WEIGHT_ONE;
    tally->balance[CML_BALANCE_SPECULAR] += count * specular + times * sums.specular;
    tally->balance[CML_BALANCE_REFLECTED] += times * sums.reflected;
    tally->balance[CML_BALANCE_TRANSMITTED] += times * sums.transmitted;
    tally->balance[CML_BALANCE_ABSORBED] += times * sums.absorbed;
    tally->A_l[1] += times * sums.deposited_above;
    tally->A_l[setup->num_layers] += times * (sums.deposited - sums.deposited_above);
    cml_terminated_add_split_off(world, terminated, times, count, tally);
    tally->count[CML_COUNT_PHOTONS] += count;
    tally->count[CML_COUNT_INTERACTIONS] += times * (sums.interactions - branches * CML_LATTICE_EVENTS);
    tally->count[CML_COUNT_BOUNDARY_EVENTS] += times * sums.boundary_events;
    tally->count[CML_COUNT_BRANCHES] += branches;
}

/* Adds a packet that has been reflected or transmitted to its bin of radius and gate. */
static inline void cml_score_radius_and_gate(const struct cml_exit *exit, cml_u32 index, uint64_t weight,
                                             const struct cml_tally *tally)
{
    const size_t cell = (size_t)exit->r * ((size_t)tally->grid.gates + 1) + (size_t)exit->gate,
                 first = index % CML_NUM_GROUPS * tally->layout.once[CML_ARRAY_Rd_rt].step;
    cml_add_shared((exit->up ? tally->Rd_rt : tally->Tt_rt) + first + cell, weight);
}

/* Scores the gates of packets that have left (P11). Called if time is wanted. */
static inline void cml_terminated_score_gates(const struct cml_setup *setup,
                                              const struct cml_terminated *terminated, uint64_t times,
                                              struct cml_tally *tally)
{
    for (int i = 0; i < terminated->count; i++) {
        const struct cml_exit exit = cml_terminated_exit(setup, terminated, i);
        if (exit.up) tally->Rd_t[exit.gate] += times * terminated->w[i];
        if (exit.down) tally->Tt_t[exit.gate] += times * terminated->w[i];
        if (tally->Rd_rt && (exit.up | exit.down))
            cml_score_radius_and_gate(&exit, terminated->index_low[i], times * terminated->w[i], tally);
    }
}

/* Empties the collection into the tally; each entry stands for `times` packets. */
static inline void cml_terminated_flush_times(const struct cml_world *world,
                                              struct cml_terminated *terminated, uint64_t times,
                                              struct cml_tally *tally)
{
    cml_terminated_find_cells(&world->setup, terminated, tally);
    for (int i = 0; i < terminated->count; i++)
        tally->Rd_ra[terminated->cell[i]] += times * terminated->scored[i];
    cml_terminated_add_sums(world, terminated, times, tally);
    if (tally->Rd_t) cml_terminated_score_gates(&world->setup, terminated, times, tally);
    terminated->count = terminated->branches = 0;
}

/* Empties the collection into the tally. */
static inline void cml_terminated_flush(const struct cml_world *world, struct cml_terminated *terminated,
                                        struct cml_tally *tally)
{
    cml_terminated_flush_times(world, terminated, 1, tally);
}

/* Flushes the collection if it has no room for the next addition. */
static inline void cml_terminated_make_room(const struct cml_world *world, struct cml_terminated *terminated,
                                            struct cml_tally *tally)
{
    if (terminated->count > CML_TERMINATED - CML_TERMINATED_TOGETHER)
        cml_terminated_flush(world, terminated, tally);
}

/* The end of a packet. */
struct cml_termination {
    uint64_t index, absorbed;
    int fate, cause;
    cml_u32 w, interactions, boundary_events;
    /* Place (exit_z in the frame of the medium), direction and optical path at the end. */
    real exit_x, exit_y, exit_z, ux, uy, uz, path;
    int primitive; /* primitive touched last; 0 on planes */
    int face;      /* 1: what the packet has lost since its last booking, beside deposits, a face has kept */
    /* Used for detectors and saved packets (P13, P18), if trails are wanted. */
    struct cml_trail trail;
};

/* Adds the weight of entry i to its pixel of the map Rd_xya or Tt_xya. The entry must have been reflected
 * or transmitted. */
static inline void cml_tally_pixel(const struct cml_setup *setup, const struct cml_terminated *terminated,
                                   int i, const struct cml_exit *exit, const struct cml_tally *tally)
{
    const int na = setup->map.na;
    const size_t cell = cml_map_pixel(setup, terminated->exit_x[i], terminated->exit_y[i]) * (size_t)na +
                        (size_t)(na > 1 ? exit->alpha : 0);
    cml_add_once((exit->up ? tally->Rd_xya : tally->Tt_xya) + cell, tally->grid.map_once,
                 terminated->index_low[i], terminated->w[i], 1);
}

/* Adds the weight of entry i, which has been reflected or transmitted, to the facet that it touched last. */
static inline void cml_tally_escape(const struct cml_setup *setup, const struct cml_terminated *terminated,
                                    int i, const struct cml_exit *exit, int primitive,
                                    const struct cml_tally *tally)
{
    const struct cml_facet_range *range = &setup->outer_facets[exit->up ? 0 : 1];
    if (range->count == 0) return;
    uint64_t *score = tally->facets + (size_t)cml_facet_index(range, primitive) * CML_FACET_SCORES;
    cml_add_once(score + CML_FACET_ESCAPED, cml_facet_once(&tally->grid), terminated->index_low[i],
                 terminated->w[i], 1);
}

/* Adds entry i, which has left, to the bin of its direction. */
static inline void cml_tally_direction(const struct cml_setup *setup, const struct cml_terminated *terminated,
                                       int i, const struct cml_exit *exit, const struct cml_tally *tally)
{
    uint64_t *const to = exit->up ? tally->Rd_dir : exit->down ? tally->Tt_dir : tally->Rsp_dir;
    uint64_t *const cell =
        to + cml_direction_bin(&setup->directions, terminated->ux[i], terminated->uy[i], terminated->uz[i]);
    cml_add_once(cell, tally->grid.direction_once, terminated->index_low[i], terminated->w[i], 1);
}

/* Returns the random number by which a share of a packet's or branch's weight is rounded (P13); 0 if no share
 * is wanted. */
static inline real cml_lot_of(const struct cml_world *world, cml_u64 index)
{
    if (!world->detection.arc.detector) return 0;
    return cml_uniform(cml_draw(world->setup.stream, index, CML_PURPOSE_BRANCH, 0).w[0]);
}

/* Returns the light of entry i, which has left. */
static inline struct cml_light_out cml_terminated_light(const struct cml_world *world,
                                                        const struct cml_terminated *terminated, int i,
                                                        const struct cml_exit *exit,
                                                        const struct cml_trail *trail)
{
    const struct cml_vec p = {terminated->exit_x[i], terminated->exit_y[i], terminated->exit_z[i]},
                         u = {terminated->ux[i], terminated->uy[i], terminated->uz[i]};
    struct cml_light_out light = cml_light_of(exit, p, u, terminated->w[i]);
    light.lot = cml_lot_of(world, cml_terminated_index(terminated, i));
    light.index = terminated->index_low[i];
    light.trail = trail;
    if (terminated->boundary_events[i] > 0)
        cml_note_port(world, cml_terminated_index(terminated, i), &light.ray);
    return light;
}

/* Adds entry i of the collection, whatever its end, to the detectors that see it (P13). The light that was
 * split off it is scored elsewhere. to, pixels and the returned number: as in cml_score_light. */
static inline int cml_tally_detectors(const struct cml_world *world, const struct cml_terminated *terminated,
                                      int i, const struct cml_exit *exit, const struct cml_trail *trail,
                                      const struct cml_seen *to, const struct cml_tally *pixels)
{
    if (!cml_has_left(exit)) return 0;
    const struct cml_light_out split = cml_light_split_off(world, cml_terminated_index(terminated, i));
    const struct cml_light_out light = cml_terminated_light(world, terminated, i, exit, trail);
    return cml_score_light(world, &light, split.w ? &split : NULL, to, pixels);
}

/* Saves entry i of the collection (P18), if it has left and, if the scene asks for that, a detector has seen
 * it. detector: the first that has seen it, from 1. */
static inline void cml_save_packet(const struct cml_world *world, const struct cml_terminated *terminated,
                                   int i, const struct cml_exit *exit, int detector,
                                   const struct cml_trail *trail, struct cml_saved_part *part)
{
    const struct cml_setup *setup = &world->setup;
    if (!cml_has_left(exit) || (part->detected && !detector)) return;
    struct cml_saved_row *row = cml_saved_next(part);
    float *const length = (float *)(row + 1);
    uint32_t *const count = (uint32_t *)(length + part->media);
    float *const momentum = (float *)(count + part->media);
    row->index = cml_terminated_index(terminated, i);
    row->weight = terminated->w[i];
    row->touches = terminated->boundary_events[i];
    row->place[0] = (float)(terminated->exit_x[i] + setup->x0);
    row->place[1] = (float)(terminated->exit_y[i] + setup->y0);
    row->place[2] =
        (float)(terminated->exit_z[i] + world->media[exit->down ? setup->num_layers + 1 : 0].depth);
    row->direction[0] = (float)terminated->ux[i];
    row->direction[1] = (float)terminated->uy[i];
    row->direction[2] = (float)terminated->uz[i];
    row->deepest = trail->deepest > -CML_INFINITY ? (float)trail->deepest : NAN;
    row->detector = (uint32_t)detector;
    row->side = exit->fresh ? CML_SAVED_FRESH : exit->down ? CML_SAVED_BOTTOM : CML_SAVED_TOP;
    for (size_t m = 0; m < part->media; m++) {
        length[m] = (float)trail->stay[m].length;
        count[m] = trail->stay[m].interactions;
        momentum[m] = (float)trail->stay[m].momentum;
    }
    row->optical = (float)cml_trail_path(world, trail);
}

/* Books the end of entry i of the collection in all rows (P16), whatever its end. The function is not
 * inlined, because few flights have rows. */
__attribute__((noinline)) static void
cml_tally_rows(const struct cml_world *world, const struct cml_terminated *terminated, int i,
               const struct cml_exit *exit, const struct cml_trail *trail, const struct cml_row_packet *rows)
{
    if (world->detection.num_detectors)
        cml_rows_place_split_off(world, rows, cml_terminated_index(terminated, i));
    const struct cml_light_out light = cml_terminated_light(world, terminated, i, exit, trail);
    cml_rows_end(world, rows, terminated->fate[i], exit, &light);
}

/* Scores entry i by its place: detectors, rows, saved packets, directions, map and facets. primitive: touched
 * last, 0 on planes. trail: if one is wanted. rows: of the packet; NULL: none. Rows restart the clock of a
 * path whenever they are booked, so with rows the time comes from the trail. */
static inline void cml_tally_places(const struct cml_world *world, struct cml_terminated *terminated, int i,
                                    int primitive, const struct cml_trail *trail,
                                    const struct cml_row_packet *rows, const struct cml_tally *tally)
{
    const struct cml_setup *setup = &world->setup;
    if (rows && setup->gates.count && trail->stay) terminated->path[i] = (real)cml_trail_path(world, trail);
    const struct cml_exit exit = cml_terminated_exit(setup, terminated, i);
    int detector = 0;
    if (tally->detector) {
        const struct cml_seen seen = cml_seen_by(tally);
        if (world->detection.split == CML_SPLIT_APART)
            cml_score_split_off(world, cml_terminated_index(terminated, i), 1, &seen, tally);
        detector = cml_tally_detectors(world, terminated, i, &exit, trail, &seen, tally);
    }
    if (rows) cml_tally_rows(world, terminated, i, &exit, trail, rows);
    if (tally->saved) cml_save_packet(world, terminated, i, &exit, detector, trail, tally->saved);
    if (tally->Rd_dir && cml_has_left(&exit)) cml_tally_direction(setup, terminated, i, &exit, tally);
    if (!(exit.up | exit.down)) return;
    if (tally->Rd_xya) cml_tally_pixel(setup, terminated, i, &exit, tally);
    if (tally->facets) cml_tally_escape(setup, terminated, i, &exit, primitive, tally);
}

/* True if every packet that ends must be looked at by itself, because maps, facets, directions, detectors
 * or rows are scored, or packets are saved. */
static inline int cml_tallies_places(const struct cml_tally *tally)
{
    return tally->Rd_xya || tally->facets || tally->Rd_dir || tally->detector || tally->saved || tally->rows;
}

/* Adds a packet that was trapped or lost to the tally at once (P9), because such packets are rare. */
static inline void cml_tally_loss(const struct cml_termination *end, struct cml_tally *tally)
{
    if (end->fate == CML_FATE_TRAPPED) {
        tally->balance[CML_BALANCE_TRAPPED] += end->w;
        tally->count[CML_COUNT_TRAPPED]++;
    } else if (end->fate == CML_FATE_LOST) {
        tally->balance[CML_BALANCE_LOST] += end->w;
        tally->count[CML_COUNT_LOST_NO_SURFACE + end->cause - CML_LOST_NO_SURFACE]++;
        if (!cml_is_branch(end->index)) cml_lost_list_add(&tally->lost, end->index);
    }
}

/* Adds one packet to the collection. The caller has booked its deposits. rows: of the packet; NULL: none. */
static inline void cml_terminated_push(const struct cml_world *world, struct cml_terminated *terminated,
                                       const struct cml_termination *end, const struct cml_row_packet *rows,
                                       struct cml_tally *tally)
{
    const int i = terminated->count++;
    terminated->branches += cml_is_branch(end->index);
    terminated->absorbed[i] = end->absorbed;
    terminated->deposit[i] = 0;
    terminated->exit_x[i] = end->exit_x;
    terminated->exit_y[i] = end->exit_y;
    terminated->exit_z[i] = end->exit_z;
    terminated->index_low[i] = (cml_u32)end->index;
    terminated->index_high[i] = (cml_u32)(end->index >> 32);
    terminated->ux[i] = end->ux;
    terminated->uy[i] = end->uy;
    terminated->uz[i] = end->uz;
    terminated->path[i] = end->path;
    terminated->w[i] = end->w;
    terminated->interactions[i] = end->interactions;
    terminated->boundary_events[i] = end->boundary_events;
    terminated->fate[i] = end->fate;
    cml_tally_loss(end, tally);
    if (cml_tallies_places(tally))
        cml_tally_places(world, terminated, i, end->primitive, &end->trail, rows, tally);
    cml_terminated_make_room(world, terminated, tally);
}

/* Adds the counts that a packet of kernels/walk.h keeps itself, and lanes of a bundle do not: roulette,
 * backing and queries. */
static inline void cml_tally_events(const struct cml_packet *packet, struct cml_tally *tally)
{
    tally->balance[CML_BALANCE_GAINED] += packet->gained;
    tally->balance[CML_BALANCE_ROULETTE] += packet->roulette;
    tally->balance[CML_BALANCE_BACKING] += packet->backing;
    tally->balance[CML_BALANCE_FACE] += packet->face;
    tally->count[CML_COUNT_QUERIES] += packet->queries;
    tally->count[CML_COUNT_SHADING_OVERRULED] += packet->shading_overruled;
}

/* Moves three counts from `branches` to the tally: packets that stayed whole, packets split into fewer
 * parts than wanted, and packets whose budget of branches was spent. branches: may be NULL. */
static inline void cml_tally_unsplit(struct cml_branches *branches, struct cml_tally *tally)
{
    if (!branches) return;
    tally->count[CML_COUNT_UNSPLIT] += branches->whole;
    tally->count[CML_COUNT_CLIPPED] += branches->clipped;
    tally->count[CML_COUNT_SPENT] += branches->spent;
    branches->whole = branches->clipped = branches->spent = 0;
}

/* Returns the sink for deposits of kernels/walk.h: the arrays of the tally themselves. branches: NULL if the
 * world has no windows. */
static inline struct cml_deposits cml_deposits_of(struct cml_tally *tally, struct cml_branches *branches)
{
    const struct cml_deposits to = {.group_cells = (cml_u32)tally->layout.once[CML_ARRAY_A_rz].step,
                                    .voxel_step = tally->grid.voxel_step,
                                    .facet_step = tally->grid.facet_step,
                                    .A_rz = tally->A_rz,
                                    .A_l = tally->A_l,
                                    .A_t = tally->A_t,
                                    .A_lt = tally->A_lt,
                                    .A_xyz = tally->A_xyz,
                                    .expected = tally->expected,
                                    .facets = tally->facets,
                                    .phi = tally->phi_rz,
                                    .phi_is_shared = !(tally->grid.marks > 0),
                                    .phi_xyz = tally->phi_xyz,
                                    .phi_rzt = tally->phi_rzt,
                                    .specular = &tally->balance[CML_BALANCE_SPECULAR],
                                    .upright = tally->Rsp_dir,
                                    .upright_once = tally->grid.direction_once,
                                    .branches = branches};
    return to;
}

/* Returns the end of a packet of kernels/walk.h. Its fate is not CML_FATE_ALIVE. */
static inline struct cml_termination cml_termination_of(const struct cml_packet *packet)
{
    const struct cml_termination end = {
        .index = packet->index,
        .absorbed = packet->absorbed,
        .fate = packet->fate,
        .cause = packet->cause,
        .w = packet->w,
        .interactions = packet->interactions,
        .boundary_events = packet->boundary_events,
        .exit_x = packet->exit_x,
        .exit_y = packet->exit_y,
        .exit_z = packet->p.z,
        .ux = packet->u.x,
        .uy = packet->u.y,
        .uz = packet->u.z,
        .path = packet->path,
        .primitive = packet->on_primitive,
        .face = packet->face > 0,
        .trail = packet->trail,
    };
    return end;
}
