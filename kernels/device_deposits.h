/* The tallies of an OpenCL device: 64-bit cells to which many work-items add. This is one of the two sinks
 * that walk.h may write to; the other is the host's (host_deposits.h). For OpenCL C only.
 * All cells are integers, so neither the order nor the place of the additions changes a result.
 * Cells in local memory are added to as two 32-bit words with a carry. NVIDIA's GPUs have no addition of 64
 * bits there: they would try again and again while others add to the same cell. CML_TWO_WORDS does this for
 * global memory too, on devices without cl_khr_int64_base_atomics. CML_GROUP_SIZE is the number of work-items
 * that share local memory.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "device_layout.h"

/* Adds to a 64-bit cell as to two 32-bit words with a carry. */
#define CML_ADD_WORDS(space, cell, amount)                                                                   \
    do {                                                                                                     \
        volatile space cml_u32 *words = (volatile space cml_u32 *)(cell);                                    \
        const cml_u32 low = (cml_u32)(amount), old = atomic_add(words, low);                                 \
        const cml_u32 high = (cml_u32)((amount) >> 32) + (old + low < old ? 1u : 0u);                        \
        if (high) atomic_add(words + 1, high);                                                               \
    } while (0)

struct cml_deposits {
    __local const struct cml_local_parts *parts;
    __local cml_u64 *local_cells;
    __global cml_u64 *cells;
    __global struct cml_counters *counters;
};

/* Adds to a cell in local memory. A group of one item needs no atomic addition. */
CML_FN void cml_add_local(__local cml_u64 *cell, cml_u64 amount)
{
#if CML_GROUP_SIZE == 1
    *cell += amount;
#else
    CML_ADD_WORDS(__local, cell, amount);
#endif
}

#ifndef CML_TWO_WORDS
#pragma OPENCL EXTENSION cl_khr_int64_base_atomics : enable
#endif

/* Adds an amount to a cell of a tally in global memory, which all groups share. */
CML_FN void cml_add_global(__global cml_u64 *cell, cml_u64 amount)
{
#ifdef CML_TWO_WORDS
    CML_ADD_WORDS(__global, cell, amount);
#else
    atom_add((volatile __global cml_u64 *)cell, amount);
#endif
}

/* Adds to a cell of a part of the tallies: in local memory if the part keeps the cell there, else in global
 * memory. */
CML_FN void cml_add(const struct cml_deposits *to, struct cml_local_part part, cml_u32 cell, cml_u64 amount)
{
    if (cell < part.count)
        cml_add_local(to->local_cells + part.first_local + cell, amount);
    else
        cml_add_global(to->cells + part.first + cell, amount);
}

/* Sets local cells to 0. All work-items of a group call it together, with a barrier behind it. */
CML_FN void cml_zero_local(__local cml_u64 *cells, cml_u32 count)
{
    for (cml_u32 i = (cml_u32)get_local_id(0); i < count; i += CML_GROUP_SIZE) cells[i] = 0;
}

/* Adds the local cells of a part to global memory. All work-items of a group call it together, with a barrier
 * before it. */
CML_FN void cml_flush_local_part(const struct cml_deposits *to, struct cml_local_part part)
{
    for (cml_u32 i = (cml_u32)get_local_id(0); i < part.count; i += CML_GROUP_SIZE)
        if (to->local_cells[part.first_local + i])
            cml_add_global(to->cells + part.first + i, to->local_cells[part.first_local + i]);
}

/* Adds absorbed weight to the sum of a layer. */
CML_FN void cml_add_to_layer(const struct cml_deposits *to, int medium, cml_u32 dw)
{
    cml_add(to, to->parts->sums, CML_CELL_LAYER + (cml_u32)medium, dw);
}

/* Adds absorbed weight to a cell of A_rz. The cell is the same for all groups of photons: the host knows the
 * group that a device flies. */
CML_FN void cml_add_to_cell(const struct cml_deposits *to, cml_u64 index, int cell, cml_u32 dw)
{
    (void)index;
    cml_add(to, to->parts->absorbed, (cml_u32)cell, dw);
}

/* Stubs of walk.h's other scores. A device keeps no voxels, facets or marks of fluence: the host refuses
 * scenes that ask for them. */
CML_FN int cml_has_volume(const struct cml_deposits *to)
{
    (void)to;
    return 0;
}

/* Says that devices score no facets. */
CML_FN int cml_has_facets(const struct cml_deposits *to)
{
    (void)to;
    return 0;
}

#define cml_mark_first(world, to, packet) ((void)0)
#define cml_mark_path(world, to, packet, from, path, t) ((void)(from), (void)(path), (void)(t))
#define cml_mark_interaction(world, to, packet, from, path, t) ((void)(from), (void)(path), (void)(t))
#define cml_mark_last(world, to, packet) ((void)0)

/* Does nothing: devices have no voxels. */
CML_FN void cml_add_to_voxel(const struct cml_deposits *to, cml_u64 index, cml_u64 voxel, cml_u32 dw)
{
    (void)to, (void)index, (void)voxel, (void)dw;
}

/* Does nothing: devices score no facets. */
CML_FN void cml_add_to_facet(const struct cml_deposits *to, cml_u64 index, int facet,
                             enum cml_facet_score score, cml_u32 w)
{
    (void)to, (void)index, (void)facet, (void)score, (void)w;
}

/* Adds to a term of the weight balance. */
CML_FN void cml_add_to_balance(const struct cml_deposits *to, enum cml_balance_term term, cml_u64 amount)
{
    if (amount) cml_add_local(to->local_cells + CML_CELL_BALANCE + (cml_u32)term, amount);
}

/* Adds light that was split off at a launch to the specular term. */
CML_FN void cml_add_specular(const struct cml_deposits *to, cml_u64 index, cml_u32 w)
{
    (void)index;
    cml_add_to_balance(to, CML_BALANCE_SPECULAR, w);
}

/* Adds to a count of packets or events. */
CML_FN void cml_add_count(const struct cml_deposits *to, enum cml_count count, cml_u64 amount)
{
    if (amount) cml_add_local(to->local_cells + CML_CELL_COUNT + (cml_u32)count, amount);
}

/* Adds weight to a cell of Rd_ra or Tt_ra. */
CML_FN void cml_add_exit(const struct cml_deposits *to, int reflected, int cell, cml_u32 w)
{
    cml_add(to, reflected ? to->parts->reflected : to->parts->transmitted, (cml_u32)cell, w);
}

/* Counts a lost photon, and lists its index if there is room. */
CML_FN void cml_add_lost(const struct cml_deposits *to, cml_u64 index)
{
    const cml_u32 i = atomic_inc(&to->counters->num_lost);
    if (i < CML_LOST_KEPT) to->counters->lost[i] = index;
}
