/* The packets of one work-item as a structure of arrays, and the loops over them: draw, fly, interact,
 * deposit. With several lanes, for a CPU, compilers turn these into vector loops. With one lane, for a GPU,
 * the arrays are registers. The arithmetic is that of walk.h. Rare events (boundaries, roulette, ends) are
 * handled one lane at a time in transport.cl. For OpenCL C only.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "walk.h"

#if CML_DEVICE_LANES > 32
#error "masks of lanes have 32 bits"
#endif

struct cml_device_lanes {
    cml_u32 index_low[CML_DEVICE_LANES], index_high[CML_DEVICE_LANES];
    real x[CML_DEVICE_LANES], y[CML_DEVICE_LANES], z[CML_DEVICE_LANES], ux[CML_DEVICE_LANES],
        uy[CML_DEVICE_LANES], uz[CML_DEVICE_LANES];
    /* Optical depth; below 0: not drawn yet; infinite: to be drawn from the tail. */
    real tau[CML_DEVICE_LANES];
    cml_u32 w[CML_DEVICE_LANES];
    cml_u32 flushed_w[CML_DEVICE_LANES]; /* weight when the balance last got the deposits */
    cml_u32 interactions[CML_DEVICE_LANES];
    cml_u32 touched[CML_DEVICE_LANES]; /* interactions before the last boundary event */
    cml_u32 draw1[CML_DEVICE_LANES], draw2[CML_DEVICE_LANES],
        draw3[CML_DEVICE_LANES]; /* random words of the next interaction */
    real mfp[CML_DEVICE_LANES], absorb[CML_DEVICE_LANES], g[CML_DEVICE_LANES],
        bins[CML_DEVICE_LANES]; /* properties of the packet's medium */
    real stop_above[CML_DEVICE_LANES],
        stop_below[CML_DEVICE_LANES]; /* a path that ends between these depths reaches no boundary */
    /* Depths: a path that begins between them begins within the heights of no curved boundary. Infinite
     * beside a plane. */
    real start_above[CML_DEVICE_LANES], start_below[CML_DEVICE_LANES];
    cml_u32 live[CML_DEVICE_LANES]; /* 1: holds a packet */
    /* 1: a boundary was looked for, and none lies before the interaction. */
    cml_u32 path_is_free[CML_DEVICE_LANES];
    /* Members of the present pass: */
    cml_u32 mine[CML_DEVICE_LANES]; /* 1: the packet flies s to its interaction */
    real s[CML_DEVICE_LANES];
    cml_u32 dw[CML_DEVICE_LANES];
    cml_u32 cell[CML_DEVICE_LANES]; /* cell of A_rz */
};

#if CML_DEVICE_LANES > 1
/* Makes the loop a function of its own, because the compiler then makes it a vector loop. */
#define CML_DEVICE_LOOP static __attribute__((noinline))
#define CML_AT_ONCE _Pragma("clang loop vectorize_width(16)")
#define CML_FORGET_REGISTERS ((void)0)
/* PoCL makes loops into vectors later than clang checks them, so clang's warning would be wrong. */
#pragma clang diagnostic ignored "-Wpass-failed"
#else
#define CML_DEVICE_LOOP CML_FN
#define CML_AT_ONCE
#define CML_ONE_COPY _Pragma("unroll 1")
/* Makes the compiler read stored values again from memory, so that it need not keep them in registers. */
#define CML_FORGET_REGISTERS mem_fence(CLK_LOCAL_MEM_FENCE)
/* Most interactions of a lane between two stops of its work-group for boundaries. Measured over the scenes
 * S1 to S6 of bench/README.md and a hill, 32 lanes wait least for each other with these numbers. */
#define CML_DEVICE_PASSES (CML_ALL_PLANES ? 8u : 2u)
#endif

/* Returns the number of the lowest bit that is set, which is the number of a lane. */
#define CML_LOWEST(mask) (CML_DEVICE_LANES > 1 ? 31u - clz((mask) & -(mask)) : 0u)

/* Returns 0 only if lane i can meet no boundary before its interaction, s (cm) away. A path that is infinite
 * or not a number may meet one. A plane is met at the end of a path or before, and never by a packet that
 * stands on it and leads away. */
CML_FN cml_u32 cml_device_may_hit(const struct cml_device_lanes *l, cml_u32 i, real s)
{
    const real z = l->z[i], step = s * l->uz[i], end = z + step, err_depth = cml_err_depth(z, step);
    return !((end - err_depth > l->stop_above[i]) & (end + err_depth < l->stop_below[i]) &
             (z - err_depth > l->start_above[i]) & (z + err_depth < l->start_below[i]));
}

/* Draws the block of lane i's next interaction, and its optical depth if it has none yet, and sets its path.
 * A lane whose last event was no interaction draws the same block again. even: 1 if words may come from the
 * lattice. Returns 1 if the lane is live and may meet a boundary; other live lanes are to interact. */
CML_FN cml_u32 cml_device_fly_lane(struct cml_stream stream, int even, struct cml_device_lanes *restrict l,
                                   cml_u32 i)
{
    const cml_u32 low = l->index_low[i], high = l->index_high[i], e = l->interactions[i];
    struct cml_block draw = cml_threefry(stream, low, high, e, (cml_u32)CML_PURPOSE_INTERACTION);
    if (even) {
        const struct cml_block shifts = cml_lattice_shifts(stream, low, high, e);
        const struct cml_block block = cml_lattice_block(cml_lattice_reversed(low, high), e, shifts, draw);
        const int from_lattice = e < stream.lattice;
        draw.w[0] = from_lattice ? block.w[0] : draw.w[0];
        draw.w[1] = from_lattice ? block.w[1] : draw.w[1];
        draw.w[2] = from_lattice ? block.w[2] : draw.w[2];
    }
    const real fresh = cml_depth_or_tail(draw.w[0]), old = l->tau[i], tau = old < 0 ? fresh : old;
    const real s = cml_path(tau, l->mfp[i]);
    const cml_u32 may_hit = cml_device_may_hit(l, i, s), live = l->live[i];
    l->draw1[i] = draw.w[1];
    l->draw2[i] = draw.w[2];
    l->draw3[i] = draw.w[3];
    l->tau[i] = tau;
    l->s[i] = s;
    l->mine[i] = live & !may_hit;
    return live & may_hit;
}

#if CML_DEVICE_LANES > 1
/* Runs cml_device_fly_lane on all lanes, none of which draws from the lattice. Returns the mask of lanes for
 * which it returns 1. */
CML_DEVICE_LOOP cml_u32 cml_device_fly_random(struct cml_stream stream, struct cml_device_lanes *restrict l)
{
    cml_u32 may_hit = 0;
    CML_AT_ONCE
    for (cml_u32 i = 0; i < CML_DEVICE_LANES; i++) may_hit |= cml_device_fly_lane(stream, 0, l, i) << i;
    return may_hit;
}

/* Runs cml_device_fly_lane on all lanes, some of which may draw from the lattice. Returns the mask of lanes
 * for which it returns 1. */
CML_DEVICE_LOOP cml_u32 cml_device_fly_even(struct cml_stream stream, struct cml_device_lanes *restrict l)
{
    cml_u32 may_hit = 0;
    CML_AT_ONCE
    for (cml_u32 i = 0; i < CML_DEVICE_LANES; i++) may_hit |= cml_device_fly_lane(stream, 1, l, i) << i;
    return may_hit;
}

/* Draws and flies all lanes; returns the mask of those that may hit a boundary. If no lane draws from the
 * lattice, cml_device_fly_random does it, because cml_device_fly_even takes twice as many random numbers. */
CML_FN cml_u32 cml_device_fly(struct cml_stream stream, struct cml_device_lanes *restrict l)
{
    cml_u32 even = 0;
    for (cml_u32 i = 0; i < CML_DEVICE_LANES; i++) even |= l->interactions[i] < stream.lattice;
    return even ? cml_device_fly_even(stream, l) : cml_device_fly_random(stream, l);
}
#else
/* Runs cml_device_fly_lane on the only lane. The lane does not stop for boundaries if its path is known to be
 * free. */
CML_FN cml_u32 cml_device_fly(struct cml_stream stream, struct cml_device_lanes *restrict l)
{
    const cml_u32 may_hit = cml_device_fly_lane(stream, l->interactions[0] < stream.lattice, l, 0);
    const cml_u32 stops = may_hit & !l->path_is_free[0];
    l->mine[0] = !stops;
    l->path_is_free[0] = 0;
    return stops;
}
#endif

/* Absorbs and scatters (P3, P4) the lanes that interact: fills dw and, if absorption is tallied, cell.
 * Returns the mask of lanes below the roulette's threshold. */
CML_DEVICE_LOOP cml_u32 cml_device_interact(const struct cml_setup *restrict setup,
                                            __global const struct cml_phase_cell *restrict phases,
                                            struct cml_device_lanes *restrict l)
{
    cml_u32 low_lanes = 0;
    CML_AT_ONCE
    for (cml_u32 i = 0; i < CML_DEVICE_LANES; i++) {
        const cml_u32 mine = l->mine[i], w = l->w[i];
        const struct cml_vec u = {l->ux[i], l->uy[i], l->uz[i]}, from = {l->x[i], l->y[i], l->z[i]};
        const struct cml_vec p = cml_along(from, l->s[i], u);
        const cml_u32 part = cml_absorbed_part(w, l->absorb[i], l->draw1[i], l->draw2[i]),
                      dw = mine ? part : 0u;
        const struct cml_vec v = cml_scatter_in(phases, u, l->g[i], l->draw1[i], l->draw2[i]);
        const int iz = cml_depth_bin(setup, p.z, l->bins[i]), ir = cml_radial_bin(setup, p.x, p.y);
        l->cell[i] = (cml_u32)(cml_device_column(ir, setup->nr, CML_DEVICE_LANES) * (setup->nz + 2) + iz);
        l->dw[i] = dw;
        l->w[i] = w - dw;
        l->x[i] = mine ? p.x : from.x;
        l->y[i] = mine ? p.y : from.y;
        l->z[i] = mine ? p.z : from.z;
        l->ux[i] = mine ? v.x : u.x;
        l->uy[i] = mine ? v.y : u.y;
        l->uz[i] = mine ? v.z : u.z;
        l->tau[i] = mine ? (real)-1 : l->tau[i];
        l->interactions[i] += mine;
        low_lanes |= (mine & (w - dw < setup->roulette.below)) << i;
    }
    return low_lanes;
}

/* Adds the deposits of all lanes that interact to A_rz. */
CML_FN void cml_device_deposit(const struct cml_deposits *to, const struct cml_device_lanes *l)
{
    for (cml_u32 i = 0; i < CML_DEVICE_LANES; i++)
        if (l->mine[i]) cml_add_to_cell(to, 0, (int)l->cell[i], l->dw[i]);
}
