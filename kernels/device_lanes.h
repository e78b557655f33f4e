/* The packets of one work-item as structure of arrays, and the loops over them: draw, fly, hop, drop, spin.
 * With several lanes, for a CPU, compilers make vector loops of them; with one, for a GPU, the arrays are
 * registers. The arithmetic is that of walk.h. What few packets do, boundaries, roulette and ends, is done a
 * lane at a time (transport.cl). OpenCL C only. SPDX-License-Identifier: MIT */
#ifndef CML_DEVICE_LANES_H
#define CML_DEVICE_LANES_H

#include "device_score.h"

#if CML_DEVICE_LANES > 32
#error "masks of lanes have 32 bits"
#endif

struct cml_device_lanes {
    cml_u32 index_low[CML_DEVICE_LANES], index_high[CML_DEVICE_LANES];
    real x[CML_DEVICE_LANES], y[CML_DEVICE_LANES], z[CML_DEVICE_LANES], ux[CML_DEVICE_LANES],
        uy[CML_DEVICE_LANES], uz[CML_DEVICE_LANES];
    real tau[CML_DEVICE_LANES]; /* below 0: to be drawn; infinite: to be drawn from the tail */
    cml_u32 w[CML_DEVICE_LANES];
    cml_u32 flushed_w[CML_DEVICE_LANES]; /* weight when the deposits since were last added to the balance */
    cml_u32 interactions[CML_DEVICE_LANES];
    cml_u32 touched[CML_DEVICE_LANES]; /* the interactions before the last boundary event */
    cml_u32 draw0[CML_DEVICE_LANES], draw1[CML_DEVICE_LANES], draw2[CML_DEVICE_LANES],
        draw3[CML_DEVICE_LANES]; /* words of the next interaction's block */
    real mfp[CML_DEVICE_LANES], absorb[CML_DEVICE_LANES], g[CML_DEVICE_LANES],
        bins[CML_DEVICE_LANES]; /* of the medium */
    real stop_above[CML_DEVICE_LANES],
        stop_below[CML_DEVICE_LANES]; /* z between which there is no boundary */
    real start_above[CML_DEVICE_LANES],
        start_below[CML_DEVICE_LANES]; /* the same for surfaces that are no planes */
    cml_u32 live[CML_DEVICE_LANES];    /* 1: holds a packet */
    /* of this pass */
    cml_u32 mine[CML_DEVICE_LANES]; /* 1: the packet flies s to its interaction */
    real s[CML_DEVICE_LANES];
    cml_u32 dw[CML_DEVICE_LANES];
    cml_u32 cell[CML_DEVICE_LANES]; /* of A_rz */
};

#if CML_DEVICE_LANES > 1
#define CML_DEVICE_LOOP static __attribute__((noinline)) /* by itself the loop is made a vector loop */
#define CML_AT_ONCE _Pragma("clang loop vectorize_width(16)")
#pragma clang diagnostic ignored "-Wpass-failed" /* PoCL makes vectors later than it looks for them */
#else
#define CML_DEVICE_LOOP CML_FN
#define CML_AT_ONCE
#endif

/* Number of the lowest bit set, which is that of a lane. */
#define CML_LOWEST(mask) (CML_DEVICE_LANES > 1 ? 31u - clz((mask) & -(mask)) : 0u)

/* Whether lane i may meet a boundary before its interaction, s away: 0 only where none can be met. What is
 * not a number, or infinite, may. A plane is met at the end of the path or before, never by a packet that
 * stands on it and leads away. */
CML_FN cml_u32 cml_device_is_near(const struct cml_device_lanes *l, cml_u32 i, real s)
{
    const real z = l->z[i], step = s * l->uz[i], end = z + step, err_depth = cml_err_depth(z, step);
    return !((end - err_depth > l->stop_above[i]) & (end + err_depth < l->stop_below[i]) &
             (z - err_depth > l->start_above[i]) & (z + err_depth < l->start_below[i]));
}

/* The random block of every lane's next interaction. A lane whose last event was no interaction draws the
 * block that it has. Returns 1 when any lane is to draw from the lattice. */
CML_DEVICE_LOOP cml_u32 cml_device_draw(struct cml_stream stream, struct cml_device_lanes *restrict l)
{
    cml_u32 any = 0;
    CML_AT_ONCE
    for (cml_u32 i = 0; i < CML_DEVICE_LANES; i++) {
        const struct cml_block draw = cml_threefry(stream, l->index_low[i], l->index_high[i],
                                                   l->interactions[i], (cml_u32)CML_PURPOSE_INTERACTION);
        l->draw0[i] = draw.w[0];
        l->draw1[i] = draw.w[1];
        l->draw2[i] = draw.w[2];
        l->draw3[i] = draw.w[3];
        any |= l->interactions[i] < stream.lattice;
    }
    return any;
}

/* Words of the lattice (lattice.h) in place of random ones, in lanes that draw from it. */
CML_DEVICE_LOOP void cml_device_draw_even(struct cml_stream stream, struct cml_device_lanes *restrict l)
{
    CML_AT_ONCE
    for (cml_u32 i = 0; i < CML_DEVICE_LANES; i++) {
        const cml_u32 low = l->index_low[i], high = l->index_high[i], e = l->interactions[i];
        const struct cml_block random = {{l->draw0[i], l->draw1[i], l->draw2[i], l->draw3[i]}};
        const struct cml_block shifts = cml_lattice_shifts(stream, (cml_u64)high << 32 | low, e);
        const struct cml_block even = cml_lattice_block(cml_lattice_reversed(low, high), e, shifts, random);
        l->draw0[i] = e < stream.lattice ? even.w[0] : random.w[0];
        l->draw1[i] = e < stream.lattice ? even.w[1] : random.w[1];
        l->draw2[i] = e < stream.lattice ? even.w[2] : random.w[2];
    }
}

/* The optical depth of every lane that has none yet, and how far all go. Returns the mask of the live lanes
 * that may meet a boundary; the other live lanes are to interact. */
CML_DEVICE_LOOP cml_u32 cml_device_fly(struct cml_device_lanes *restrict l)
{
    cml_u32 near_lanes = 0;
    CML_AT_ONCE
    for (cml_u32 i = 0; i < CML_DEVICE_LANES; i++) {
        const real fresh = cml_depth_or_tail(l->draw0[i]), old = l->tau[i], tau = old < 0 ? fresh : old;
        const real s = cml_path(tau, l->mfp[i]);
        const cml_u32 near = cml_device_is_near(l, i, s);
        const cml_u32 live = l->live[i];
        l->tau[i] = tau;
        l->s[i] = s;
        l->mine[i] = live & !near;
        near_lanes |= (live & near) << i;
    }
    return near_lanes;
}

/* P3 and P4 of the lanes that interact: fills dw and, where absorption is tallied, cell. Returns the mask of
 * those that are below the roulette's threshold. */
CML_DEVICE_LOOP cml_u32 cml_device_interact(const struct cml_setup *restrict setup,
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
        const struct cml_vec v = cml_scatter(u, l->g[i], l->draw1[i], l->draw2[i]);
        const int iz = cml_depth_bin(setup, p.z, l->bins[i]), ir = cml_radial_bin(setup, p.x, p.y);
        l->cell[i] = (cml_u32)(ir * (setup->nz + 2) + iz);
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

CML_FN void cml_device_deposit(const struct cml_deposits *to, const struct cml_device_lanes *l)
{
    for (cml_u32 i = 0; i < CML_DEVICE_LANES; i++)
        if (l->mine[i]) cml_add_to_cell(to, (int)l->cell[i], l->dw[i]);
}

#endif
