/* Where a walk on the host puts what packets leave behind: one of the two sinks that walk.h may write to; the
 * other is an OpenCL device's (device_deposits.h). Both define struct cml_deposits and the same functions.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "boundary.h"
#include "port.h"
#include "types.h"

/* P19: packets that wait for their flight: one thread's. */
struct cml_branches {
    int count, most;
    cml_u64 whole, clipped, spent; /* CML_COUNT_UNSPLIT, CML_COUNT_CLIPPED, CML_COUNT_SPENT */
    struct cml_packet *item;       /* [most] */
    struct cml_stay *stay;         /* [most][media] of their trails (P13); NULL where nobody wants them */
};

/* Arrays of weight units (see src/tally/tally.h). One thread's: A_rz: [nr + 1][nz + 2] of every group, or
 * NULL, A_l: [num_layers + 2] by medium, A_t: [gates + 1] or NULL, A_lt: the same by medium. All threads',
 * too large for a copy each: A_xyz: [nz ny nx + 1] or NULL, facets: [facets of all
 * boundaries][CML_FACET_SCORES] or NULL. Of one thread again, expected: [scores of the tail] (P15) or NULL;
 * expected_late: the same once more, of the batch of a packet that is late, or NULL. */
struct cml_deposits {
    cml_u32 group_cells;            /* from A_rz of a group to that of the next; 0: they have one */
    cml_u64 voxel_step, facet_step; /* the same of A_xyz and facets */
    cml_u64 *A_rz, *A_l, *A_t, *A_lt, *A_xyz, *facets, *expected, *expected_late;
    cml_u64 *phi;      /* [64][nr + 1][nz + 2] or NULL: fluence by batch (P14) */
    int phi_is_shared; /* by all threads */
    cml_u64 *phi_xyz;  /* [nz ny nx][CML_NUM_GROUPS] or NULL, all threads' */
    cml_u64 *phi_rzt;  /* [CML_NUM_GROUPS][nr][nz][gates + 1] or NULL, all threads' */
    cml_u64 *specular; /* one thread's sum */
    cml_u64 *upright;  /* all threads' sum of it, which goes straight up (P7); or NULL */
    struct cml_once upright_once;
    struct cml_branches *branches; /* where the world has windows */
};

/* To a cell of an array that threads share. */
CML_FN void cml_add_shared(cml_u64 *cell, cml_u64 amount)
{
    __atomic_fetch_add(cell, amount, __ATOMIC_RELAXED);
}

CML_FN int cml_has_volume(const struct cml_deposits *to)
{
    return to->A_xyz != 0;
}

CML_FN int cml_has_facets(const struct cml_deposits *to)
{
    return to->facets != 0;
}

CML_FN int cml_has_marks(const struct cml_deposits *to)
{
    return to->phi != 0;
}

CML_FN void cml_add_mark(const struct cml_deposits *to, cml_u32 cell, cml_u64 w)
{
    if (to->phi_is_shared)
        cml_add_shared(&to->phi[cell], w);
    else
        to->phi[cell] += w;
}

CML_FN void cml_add_to_layer(const struct cml_deposits *to, int medium, cml_u32 dw)
{
    to->A_l[medium] += dw;
}

/* dw is absorbed in a gate: A_t, which there is, and A_lt. */
CML_FN void cml_add_to_gate(const struct cml_deposits *to, struct cml_gates gates, int medium, int gate,
                            cml_u32 dw)
{
    to->A_t[gate] += dw;
    if (to->A_lt) to->A_lt[medium * (gates.count + 1) + gate] += dw;
}

/* The square of a weight in units of 2^CML_SQUARE_SHIFT squared: 64 bits hold the sum over all packets. */
CML_FN cml_u64 cml_square_of(cml_u64 w)
{
    const cml_u64 rounded = (w + (1u << (CML_SQUARE_SHIFT - 1))) >> CML_SQUARE_SHIFT;
    return rounded * rounded;
}

/* The weight of `times` packets like packet `index`, into a cell that other threads score into, too. */
CML_FN void cml_add_once(cml_u64 *cell, struct cml_once once, cml_u64 index, cml_u32 w, cml_u64 times)
{
    cml_add_shared(cell + index % CML_NUM_GROUPS * once.step, times * w);
    if (!once.step) cml_add_shared(cell + once.squares, times * cml_square_of(w));
}

CML_FN void cml_add_specular(const struct cml_deposits *to, cml_u64 index, cml_u32 w)
{
    *to->specular += w;
    if (to->upright) cml_add_once(to->upright, to->upright_once, index, w, 1);
}

/* The first cell of A_rz of the packet's group. */
CML_FN cml_u32 cml_first_cell(const struct cml_deposits *to, cml_u64 index)
{
    return (cml_u32)index % CML_NUM_GROUPS * to->group_cells;
}

CML_FN void cml_add_to_cell(const struct cml_deposits *to, cml_u64 index, int cell, cml_u32 dw)
{
    to->A_rz[cml_first_cell(to, index) + (cml_u32)cell] += dw;
}

CML_FN void cml_add_to_voxel(const struct cml_deposits *to, cml_u64 index, cml_u64 voxel, cml_u32 dw)
{
    cml_add_shared(&to->A_xyz[index % CML_NUM_GROUPS * to->voxel_step + voxel], dw);
}

CML_FN void cml_add_to_facet(const struct cml_deposits *to, cml_u64 index, int facet,
                             enum cml_facet_score score, cml_u32 w)
{
    const cml_u64 cell = (cml_u64)facet * CML_FACET_SCORES + (cml_u64)score;
    cml_add_shared(&to->facets[index % CML_NUM_GROUPS * to->facet_step + cell], w);
}
