/* A bundle of packets as structure of arrays: the fast walk of the CPU engine.
 * A pass takes every packet one event further: to a plane, to a curved surface, or to its next interaction.
 * What most packets do is done in vector loops; curved surfaces, roulette, ends and launches are exceptions,
 * a lane at a time. The arithmetic is that of kernels/walk.h, so every packet ends with the same bits as
 * there; tests compare whole tallies. SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_H
#define CML_BUNDLE_H

#include "types.h"

#define CML_LANES 32 /* one block of 32 beat blocks of 16, and several blocks, in the prototype */
#define CML_HALF 16  /* planes are crossed in halves: most passes have none in one of them */

/* What a lane does in this pass. */
enum cml_lane_task {
    CML_LANE_INTERACT,  /* flies s to its interaction */
    CML_LANE_NEAR,      /* may meet a boundary first */
    CML_LANE_REFLECTED, /* done: at a plane */
    CML_LANE_TRANSMITTED,
    CML_LANE_NOWHERE,  /* meets no plane and never interacts */
    CML_LANE_LAUNCHED, /* a new packet that needs its draws */
    CML_LANE_DONE,     /* had its event elsewhere */
};

/* Bits that say why a lane needs a look after its interaction. */
enum cml_lane_flag {
    CML_FLAG_ROULETTE = 1,
    CML_FLAG_NAN = 2,
    CML_FLAG_EDGE = 4, /* deposited in the first or last bin from beyond it */
    CML_FLAG_TAIL = 8, /* the optical depth lies in the tail: to be drawn by cml_optical_depth */
};

/* Every member is 4 bytes wide in every lane: a packet is moved to another lane as a column. */
struct cml_bundle {
    _Alignas(64) real x[CML_LANES], y[CML_LANES], z[CML_LANES], ux[CML_LANES], uy[CML_LANES], uz[CML_LANES];
    real tau[CML_LANES]; /* optical depth left to the next interaction */
    real s[CML_LANES];   /* distance still to fly in this pass, cm; 0 in lanes that do not interact */
    cml_u32 w[CML_LANES], dw[CML_LANES]; /* weight; deposit of this pass */
    cml_u32 deposited[CML_LANES]; /* since the last flush: at most the weight then, so it cannot overflow */
    cml_u32 draw1[CML_LANES], draw2[CML_LANES], draw3[CML_LANES]; /* words of the next interaction's block */
    cml_u32 lot[CML_LANES]; /* roulette word of this pass's interaction */
    cml_u32 index_low[CML_LANES], index_high[CML_LANES];
    cml_u32 interactions[CML_LANES], crossings[CML_LANES], bounces[CML_LANES], boundary_events[CML_LANES];
    int cell[CML_LANES]; /* of A_rz, of this pass */
    int task[CML_LANES], flag[CML_LANES];
    int medium[CML_LANES], entered[CML_LANES];
    int on_boundary[CML_LANES], on_primitive[CML_LANES], straight[CML_LANES];
    /* copies of what the medium is */
    real mut[CML_LANES], mfp[CML_LANES], absorb[CML_LANES], g[CML_LANES], depth[CML_LANES];
    real n[CML_LANES], n_above[CML_LANES], n_below[CML_LANES];
    real plane_above[CML_LANES],
        plane_below[CML_LANES]; /* z of the bounding planes, -+infinity for other kinds */
    real stop_above[CML_LANES], stop_below[CML_LANES]; /* z between which there is no boundary of any kind */
};

/* The vector passes, in order. Lanes whose task is another are left alone; lanes without a packet may hold
 * anything. Each picks the widest instruction set of the machine at load time. */

/* Sets task (INTERACT or NEAR) and s of every lane. Returns the mask of lanes that are near the boundary
 * above, and in the upper 32 bits that of lanes near the boundary below. Conservative: a lane that is not
 * near a boundary cannot meet it before its interaction, rounding included. */
cml_u64 cml_bundle_fly(struct cml_bundle *bundle);

/* Lanes first..first+15 that are NEAR, for which the boundaries they are near to must be planes: reflected,
 * transmitted, nowhere, or back to INTERACT. Medium, books and ends are the caller's. */
void cml_bundle_cross_planes(const struct cml_setup *setup, struct cml_bundle *bundle, int first);

/* Lanes first..first+15 with INTERACT: hop, drop, spin, draw. Fills dw (0 in other lanes), cell, flag.
 * Returns the union of flags. */
int cml_bundle_interact(const struct cml_setup *setup, struct cml_bundle *bundle, int first);

/* Lanes with LAUNCHED: the block of their first interaction and its optical depth; flag is CML_FLAG_TAIL or
 * 0, which is also returned as a union. */
int cml_bundle_draw(const struct cml_setup *setup, struct cml_bundle *bundle);

#endif
