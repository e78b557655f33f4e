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
    CML_LANE_INTERACT,
    CML_LANE_PLANE_ABOVE, /* crosses the plane above it */
    CML_LANE_PLANE_BELOW,
    CML_LANE_EXCEPTION, /* may meet a boundary that is no plane, or nothing at all */
    CML_LANE_REFLECTED, /* done: at a plane */
    CML_LANE_TRANSMITTED,
    CML_LANE_LAUNCHED, /* a new packet, or one back from an exception, that needs its draws */
    CML_LANE_DONE,     /* had its event elsewhere */
};

/* Bits that say why a lane needs a look after its interaction. */
enum cml_lane_flag {
    CML_FLAG_ROULETTE = 1,
    CML_FLAG_NAN = 2,
    CML_FLAG_LEAKED = 4,
    CML_FLAG_OVERFLOW_R = 8,
    CML_FLAG_OVERFLOW_Z = 16,
    CML_FLAG_ABOVE = 32,
};

/* Every member is 4 bytes wide in every lane: a packet is moved to another lane as a column. */
struct cml_bundle {
    _Alignas(64) real x[CML_LANES], y[CML_LANES], z[CML_LANES], ux[CML_LANES], uy[CML_LANES], uz[CML_LANES];
    real tau[CML_LANES];                 /* optical depth left to the next interaction */
    real s[CML_LANES];                   /* distance to the event of this pass, cm */
    cml_u32 w[CML_LANES], dw[CML_LANES]; /* weight; deposit of this pass */
    cml_u32 deposited[CML_LANES]; /* since the last flush: at most the weight then, so it cannot overflow */
    cml_u32 draw[4][CML_LANES];   /* the block of the next interaction */
    cml_u32 index_low[CML_LANES], index_high[CML_LANES];
    cml_u32 interactions[CML_LANES], crossings[CML_LANES], bounces[CML_LANES], boundary_events[CML_LANES];
    int cell[CML_LANES]; /* of A_rz, of this pass */
    int task[CML_LANES], flag[CML_LANES];
    int medium[CML_LANES], entered[CML_LANES];
    int on_boundary[CML_LANES], on_primitive[CML_LANES], straight[CML_LANES];
    /* copies of what the medium is; see cml_bundle_load_medium */
    real mut[CML_LANES], absorb[CML_LANES], g[CML_LANES], depth[CML_LANES];
    real n[CML_LANES], n_above[CML_LANES], n_below[CML_LANES];
    real plane_above[CML_LANES],
        plane_below[CML_LANES]; /* z of the bounding planes, -+infinity for other kinds */
    real field_above[CML_LANES],
        field_below[CML_LANES]; /* z where another kind may begin, -+infinity for planes */
    real leak_above[CML_LANES],
        leak_below[CML_LANES]; /* beyond these the packet has slipped through a field */
};

/* The vector passes, in order. Lanes whose task is another are left alone; lanes without a packet may hold
 * anything. Each picks the widest instruction set of the machine at load time. */

/* Task and distance of every lane's next event. Returns a mask of lanes that cross a plane in the lower, of
 * those with an exception in the upper 32 bits. */
cml_u64 cml_bundle_fly(struct cml_bundle *bundle);

/* Lanes first..first+15 that cross a plane: reflected or transmitted; medium, books and ends are the
 * caller's. */
void cml_bundle_cross_planes(const struct cml_setup *setup, struct cml_bundle *bundle, int first);

/* Lanes with CML_LANE_INTERACT: hop, drop, spin. Fills dw (0 in other lanes), cell, flag. Returns the union
 * of flags. */
int cml_bundle_interact(const struct cml_setup *setup, struct cml_bundle *bundle);

/* Lanes that interacted or were launched: the block of their next interaction and its optical depth. Returns
 * a mask of lanes whose first word is 0, whose depth the caller must draw (cml_optical_depth). */
cml_u32 cml_bundle_draw(const struct cml_setup *setup, struct cml_bundle *bundle);

#endif
