/* The host's arrays for all that packets leave behind: one of the two sinks that walk.h may write to. The
 * other is an OpenCL device's (device_deposits.h). Both files define struct cml_deposits and the same
 * functions.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "boundary.h"
#include "port.h"
#include "types.h"

/* A stack of packets that wait for their flight (P19). Each thread has its own. */
struct cml_branches {
    int count, most;
    cml_u64 whole, clipped, spent; /* for CML_COUNT_UNSPLIT, CML_COUNT_CLIPPED and CML_COUNT_SPENT */
    struct cml_packet *item;       /* [most] */
    /* [most][media] stays of their trails (P13); NULL if no result needs them. */
    struct cml_stay *stay;
};

/* Arrays of weight units into which a walk adds (src/tally/tally.h).
 * One copy for each thread: A_rz [nr + 1][nz + 2] for every group, or NULL; A_l [num_layers + 2] by medium;
 * A_t [gates + 1] or NULL; A_lt as A_t, by medium; expected [scores of the tail] (P15) or NULL;
 * expected_late: the same scores for the batch of a late packet (tally.h), or NULL.
 * One for all threads, because copies would be too large: A_xyz [nz ny nx + 1] or NULL; facets [facets of all
 * boundaries][CML_FACET_SCORES] or NULL. */
struct cml_deposits {
    cml_u32 group_cells;            /* cells from one group's A_rz to the next; 0: all groups share one */
    cml_u64 voxel_step, facet_step; /* cells from one group to the next in A_xyz and facets */
    cml_u64 *A_rz, *A_l, *A_t, *A_lt, *A_xyz, *facets, *expected, *expected_late;
    cml_u64 *phi;      /* [64][nr + 1][nz + 2] fluence by batch (P14), or NULL */
    int phi_is_shared; /* 1: all threads add to one phi */
    cml_u64 *phi_xyz;  /* [nz ny nx][CML_NUM_GROUPS] or NULL; shared by all threads */
    cml_u64 *phi_rzt;  /* [CML_NUM_GROUPS][nr][nz][gates + 1] or NULL; shared by all threads */
    cml_u64 *specular; /* this thread's sum of the light that is split off at launches */
    cml_u64 *upright;  /* all threads' sum of this light by direction: it goes straight up (P7); or NULL */
    struct cml_once upright_once;
    struct cml_branches *branches; /* stack of branches, if the world has weight windows */
};

/* Adds to a cell of an array that threads share. */
CML_FN void cml_add_shared(cml_u64 *cell, cml_u64 amount)
{
    __atomic_fetch_add(cell, amount, __ATOMIC_RELAXED);
}

/* True if absorption is scored in voxels. */
CML_FN int cml_has_volume(const struct cml_deposits *to)
{
    return to->A_xyz != 0;
}

/* True if light is scored on facets of boundaries. */
CML_FN int cml_has_facets(const struct cml_deposits *to)
{
    return to->facets != 0;
}

/* True if fluence is scored. */
CML_FN int cml_has_marks(const struct cml_deposits *to)
{
    return to->phi != 0;
}

/* Adds weight to a cell of the fluence. */
CML_FN void cml_add_mark(const struct cml_deposits *to, cml_u32 cell, cml_u64 w)
{
    if (to->phi_is_shared)
        cml_add_shared(&to->phi[cell], w);
    else
        to->phi[cell] += w;
}

/* Adds absorbed weight to the sum of a medium. */
CML_FN void cml_add_to_layer(const struct cml_deposits *to, int medium, cml_u32 dw)
{
    to->A_l[medium] += dw;
}

/* Adds absorbed weight dw to a gate of A_t, which must exist, and of A_lt. */
CML_FN void cml_add_to_gate(const struct cml_deposits *to, struct cml_gates gates, int medium, int gate,
                            cml_u32 dw)
{
    to->A_t[gate] += dw;
    if (to->A_lt) to->A_lt[medium * (gates.count + 1) + gate] += dw;
}

/* Returns the square of a weight, in units of 2^CML_SQUARE_SHIFT squared, so that 64 bits hold the sum over
 * all packets. */
CML_FN cml_u64 cml_square_of(cml_u64 w)
{
    const cml_u64 rounded = (w + (1u << (CML_SQUARE_SHIFT - 1))) >> CML_SQUARE_SHIFT;
    return rounded * rounded;
}

/* Adds the weight w of `times` packets like packet `index` to a cell that other threads add to as well. */
CML_FN void cml_add_once(cml_u64 *cell, struct cml_once once, cml_u64 index, cml_u32 w, cml_u64 times)
{
    cml_add_shared(cell + index % CML_NUM_GROUPS * once.step, times * w);
    if (!once.step) cml_add_shared(cell + once.squares, times * cml_square_of(w));
}

/* Adds light that was split off packet `index` at its launch to the specular sum, and to the direction
 * straight up. */
CML_FN void cml_add_specular(const struct cml_deposits *to, cml_u64 index, cml_u32 w)
{
    *to->specular += w;
    if (to->upright) cml_add_once(to->upright, to->upright_once, index, w, 1);
}

/* Returns the first cell of A_rz for a packet's group. */
CML_FN cml_u32 cml_first_cell(const struct cml_deposits *to, cml_u64 index)
{
    return (cml_u32)index % CML_NUM_GROUPS * to->group_cells;
}

/* Adds absorbed weight to a cell of A_rz, for the packet's group. */
CML_FN void cml_add_to_cell(const struct cml_deposits *to, cml_u64 index, int cell, cml_u32 dw)
{
    to->A_rz[cml_first_cell(to, index) + (cml_u32)cell] += dw;
}

/* Adds absorbed weight to a voxel, for the packet's group. */
CML_FN void cml_add_to_voxel(const struct cml_deposits *to, cml_u64 index, cml_u64 voxel, cml_u32 dw)
{
    cml_add_shared(&to->A_xyz[index % CML_NUM_GROUPS * to->voxel_step + voxel], dw);
}

/* Adds weight to a score of a facet, for the packet's group. */
CML_FN void cml_add_to_facet(const struct cml_deposits *to, cml_u64 index, int facet,
                             enum cml_facet_score score, cml_u32 w)
{
    const cml_u64 cell = (cml_u64)facet * CML_FACET_SCORES + (cml_u64)score;
    cml_add_shared(&to->facets[index % CML_NUM_GROUPS * to->facet_step + cell], w);
}
