/* P19: weight windows. A packet that is too heavy where it is splits, one that is too light plays
 * roulette. Host only. SPDX-License-Identifier: MIT */
#pragma once

#include "balance.h"
#include "host_deposits.h"
#include "lattice.h"
#include "types.h"

#define CML_MOST_PARTS 64u          /* of one event */
#define CML_MOST_OF_FAMILY 1000000u /* branches of a photon, on average */

/* Index of a packet's branch. Its highest bit is set, as that of no photon's, and the lowest bits are those
 * of its photon: they say of which batch it is. What lies between is drawn, so that all branches of a run
 * have streams of their own. */
CML_FN cml_u64 cml_branch_index(struct cml_stream stream, cml_u64 index, cml_u32 event, cml_u32 k)
{
    const struct cml_block draw = cml_draw(stream, index, CML_PURPOSE_BRANCH, event * CML_MOST_PARTS + k);
    const cml_u64 drawn = (cml_u64)draw.w[0] << 32 | draw.w[1], batch = CML_NUM_BATCHES - 1;
    return (cml_u64)1 << 63 | (drawn & ~batch) | (index & batch);
}

CML_FN int cml_is_branch(cml_u64 index)
{
    return (int)(index >> 63);
}

/* The cell of the window table that p belongs to, by its depth and its ring; p in the frame of a medium,
 * which begins in depth bin `bins`. */
CML_FN int cml_window_cell(struct cml_weight_windows windows, real per_dz, struct cml_vec p, real bins)
{
    const real at = CML_FMA(p.z, per_dz, bins) * windows.per_bin, last = (real)(windows.cells - 1),
               x = p.x - windows.x, y = p.y - windows.y;
    const real above = at > 0 ? at : (real)0,
               out = CML_SQRT(CML_SQRT(CML_FMA(x, x, y * y))) * windows.per_root,
               outermost = (real)(windows.rings - 1);
    return (int)(out < outermost ? out : outermost) * windows.cells + (int)(above < last ? above : last);
}

/* Whether a packet is heavier than its window allows: than nine times the lower end, 3 w(z). */
CML_FN int cml_is_heavy(cml_u32 w, cml_u32 low)
{
    return w >> 3 > low + (low >> 3);
}

/* Three times that: what packets weigh that survive, or are split. */
CML_FN cml_u32 cml_target_weight(cml_u32 low)
{
    return 3 * low;
}

/* Part k of a packet, which weighs w, to wait for its flight. It draws no numbers of the lattice, of which it
 * is no point, and has met no boundary yet. */
CML_FN void cml_branch_off(const struct cml_world *world, struct cml_branches *to,
                           const struct cml_packet *packet, cml_u32 k, cml_u32 w)
{
    const int media = world->setup.num_layers + 2 + world->setup.num_bodies, at = to->count++ * media;
    struct cml_packet *branch = &to->item[to->count - 1];
    *branch = *packet;
    branch->index = cml_branch_index(world->setup.stream, packet->index, packet->interactions, k);
    branch->w = w;
    branch->before += CML_LATTICE_EVENTS - packet->interactions;
    branch->interactions = CML_LATTICE_EVENTS;
    branch->crossings = CML_LATTICE_REFLECTIONS;
    branch->rough_draws = branch->boundary_events = branch->queries = branch->shading_overruled = 0;
    branch->gained = branch->roulette = branch->absorbed = branch->backing = 0;
    for (int m = 0; packet->trail.stay && m < media; m++) to->stay[at + m] = packet->trail.stay[m];
}

/* The last one that waits, into `packet`, whose trail is the caller's. */
CML_FN void cml_take_branch(const struct cml_world *world, struct cml_branches *from,
                            struct cml_packet *packet)
{
    const int media = world->setup.num_layers + 2 + world->setup.num_bodies, at = --from->count * media;
    struct cml_trail trail = packet->trail;
    *packet = from->item[from->count];
    trail.deepest = packet->trail.deepest;
    packet->trail = trail;
    for (int m = 0; trail.stay && m < media; m++) trail.stay[m] = from->stay[at + m];
}

/* Into how many parts of about the weight `target` a packet may be split. Which of its photon's branches are
 * left to it its parts share. */
CML_FN cml_u32 cml_parts_of(struct cml_branches *to, struct cml_packet *packet, cml_u32 target)
{
    const cml_u32 wanted = (packet->w + target / 2) / target, left = CML_MOST_OF_FAMILY - packet->spent;
    cml_u32 parts = wanted < CML_MOST_PARTS ? wanted : CML_MOST_PARTS;
    to->clipped += parts < wanted;
    to->spent += left < parts - 1;
    if (left < parts - 1) parts = left + 1;
    packet->spent = CML_MOST_OF_FAMILY - (left - (parts - 1)) / parts;
    return parts;
}

/* A packet that has survived roulette, and weighed w, has what was left to others that have not. */
CML_FN cml_u32 cml_spent_after(cml_u32 spent, cml_u32 w, cml_u32 survivor)
{
    const cml_u64 left = (cml_u64)(CML_MOST_OF_FAMILY - spent) * survivor / w;
    return left < CML_MOST_OF_FAMILY ? CML_MOST_OF_FAMILY - (cml_u32)left : 0;
}

/* Into parts of about the weight `target`, of which the packet is the first. Where no more can wait it stays
 * whole. */
CML_FN void cml_split(const struct cml_world *world, struct cml_branches *to, struct cml_packet *packet,
                      cml_u32 target)
{
    const cml_u32 parts = cml_parts_of(to, packet, target), rest = packet->w % parts;
    if (to->count + (int)parts - 1 > to->most) {
        to->whole++;
        return;
    }
    for (cml_u32 k = 1; k < parts; k++) cml_branch_off(world, to, packet, k, packet->w / parts + (k < rest));
    packet->w = packet->w / parts + (rest > 0);
}
