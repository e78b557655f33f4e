/* Weight windows (P19): a packet that is too heavy for its place splits, and one that is too light plays
 * roulette. For the host only.
 *
 *      weight   3 W  ---------------   heavier: splits into parts of about W
 *                 W  - - - - - - - -   survivors of roulette and parts weigh about this
 *               W/3  ---------------   lighter: roulette;  W/3 is `low` in the code
 * SPDX-License-Identifier: MIT */
#pragma once

#include "balance.h"
#include "host_deposits.h"
#include "lattice.h"
#include "types.h"

#define CML_MOST_PARTS 64u          /* most parts into which one event splits a packet */
#define CML_MOST_OF_FAMILY 1000000u /* branches that a photon may have, on average */

/* Returns the index of branch k of a packet, split at its interaction `event`. The highest bit is set, which
 * no photon's index has. The lowest bits are those of the photon, because they say in which batch it is. The
 * bits between are drawn at random, so that each branch of a run has a stream of random numbers of its
 * own. */
CML_FN cml_u64 cml_branch_index(struct cml_stream stream, cml_u64 index, cml_u32 event, cml_u32 k)
{
    const struct cml_block draw = cml_draw(stream, index, CML_PURPOSE_BRANCH, event * CML_MOST_PARTS + k);
    const cml_u64 drawn = (cml_u64)draw.w[0] << 32 | draw.w[1], batch = CML_NUM_BATCHES - 1;
    return (cml_u64)1 << 63 | (drawn & ~batch) | (index & batch);
}

/* True if the index is that of a branch. */
CML_FN int cml_is_branch(cml_u64 index)
{
    return (int)(index >> 63);
}

/* A square of distances, cm2, beyond all windows. */
#define CML_FAR_FROM_WINDOWS ((real)1e30)

/* Returns the smaller one of a square of a distance and that between x, y and place k of the windows, cm2. */
CML_FN real cml_nearer(struct cml_weight_windows windows, int k, real x, real y, real square)
{
    const real dx = x - windows.x[k], dy = y - windows.y[k], other = CML_FMA(dx, dx, dy * dy);
    return other < square ? other : square;
}

/* Returns the cell of the window table at a depth and a ring. z: in the frame of a medium that begins in
 * depth bin `bins`. square: of the distance from the nearest place. */
CML_FN int cml_window_cell_of(struct cml_weight_windows windows, real per_dz, real z, real bins, real square)
{
    const real at = CML_FMA(z, per_dz, bins) * windows.per_bin, last = (real)(windows.cells - 1);
    const real above = at > 0 ? at : (real)0, out = CML_SQRT(CML_SQRT(square)) * windows.per_root,
               outermost = (real)(windows.rings - 1);
    return (int)(out < outermost ? out : outermost) * windows.cells + (int)(above < last ? above : last);
}

/* Returns the cell of the window table for p, which lies in the frame of a medium that begins in depth bin
 * `bins`. */
CML_FN int cml_window_cell(struct cml_weight_windows windows, real per_dz, struct cml_vec p, real bins)
{
    real square = CML_FAR_FROM_WINDOWS;
    for (int k = 0; k < windows.places; k++) square = cml_nearer(windows, k, p.x, p.y, square);
    return cml_window_cell_of(windows, per_dz, p.z, bins, square);
}

/* True if a packet is heavier than 3 W, which is nine times the lower end `low` of its window. */
CML_FN int cml_is_heavy(cml_u32 w, cml_u32 low)
{
    return w >> 3 > low + (low >> 3);
}

/* Returns the target weight W, three times the lower end of the window: the weight of survivors and parts. */
CML_FN cml_u32 cml_target_weight(cml_u32 low)
{
    return 3 * low;
}

/* Puts part k of a packet, of weight w, into the stack `to`, where it waits for its flight. A branch is no
 * point of the lattice, so it draws random numbers only. It has met no boundary yet. */
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
    branch->gained = branch->roulette = branch->absorbed = branch->backing = branch->face = 0;
    for (int m = 0; packet->trail.stay && m < media; m++) to->stay[at + m] = packet->trail.stay[m];
}

/* Takes the branch that came last from the stack into *packet. The packet keeps the memory of its own
 * trail. */
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

/* Returns the number of parts of about the weight `target` into which a packet splits: 1 if the stack has no
 * room for the others. packet->spent says how much of the budget of CML_MOST_OF_FAMILY branches is used up;
 * the parts share the rest equally. */
CML_FN cml_u32 cml_parts_of(struct cml_branches *to, struct cml_packet *packet, cml_u32 target)
{
    const cml_u32 wanted = (packet->w + target / 2) / target, left = CML_MOST_OF_FAMILY - packet->spent,
                  most = wanted < CML_MOST_PARTS ? wanted : CML_MOST_PARTS,
                  parts = left < most - 1 ? left + 1 : most;
    if (to->count + (int)parts - 1 > to->most) {
        to->whole++;
        return 1;
    }
    to->clipped += most < wanted;
    to->spent += parts < most;
    packet->spent = CML_MOST_OF_FAMILY - (left - (parts - 1)) / parts;
    return parts;
}

/* Returns packet->spent after roulette, for a survivor that weighed w before and weighs `survivor` now. The
 * rest of its budget of branches grows like its weight, because it takes over the budgets of the packets
 * that do not survive. */
CML_FN cml_u32 cml_spent_after(cml_u32 spent, cml_u32 w, cml_u32 survivor)
{
    const cml_u64 left = (cml_u64)(CML_MOST_OF_FAMILY - spent) * survivor / w;
    return left < CML_MOST_OF_FAMILY ? CML_MOST_OF_FAMILY - (cml_u32)left : 0;
}

/* Splits a packet into parts of about the weight `target`. The packet itself becomes the first part. */
CML_FN void cml_split(const struct cml_world *world, struct cml_branches *to, struct cml_packet *packet,
                      cml_u32 target)
{
    const cml_u32 parts = cml_parts_of(to, packet, target), rest = packet->w % parts;
    for (cml_u32 k = 1; k < parts; k++) cml_branch_off(world, to, packet, k, packet->w / parts + (k < rest));
    packet->w = packet->w / parts + (rest > 0);
}
