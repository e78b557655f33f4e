/* A bundle of packets as structure of arrays: the fast walk of the CPU engine.
 * A pass takes packets to a plane, to several, or to a curved surface, and mostly on to their next
 * interaction. What most packets do is done in vector loops (bundle_loops_inl.h), launches and exits through
 * planes among them, and so is what lanes at curved surfaces have in common: whether they can meet them
 * (bundle_curved_reach_inl.h), and what becomes of those that do (bundle_curved_hits_inl.h). Which facet or
 * ring it is (bundle_curved_search_inl.h), what is rare there (bundle_lane_events_inl.h), roulette and other
 * ends (bundle_walk_inl.h) are exceptions, a lane at a time. The arithmetic is that of kernels/walk.h, so
 * every packet ends with the same bits as there; tests compare whole tallies. Included by engine_cpu_level.c
 * only, which is compiled once for each level of the processor. SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_H
#define CML_BUNDLE_H

#include "types.h"

#include <stddef.h>

#define CML_LANES 64 /* as many as a mask has bits: a loop's constants are set up once for all of them */
#define CML_GROUP 16 /* lanes that start or leave are handled by groups */
#define CML_GROUP_MASK 0xffffu

/* What a lane does in this pass. */
enum cml_lane_task {
    CML_LANE_INTERACT, /* flies s to its interaction */
    CML_LANE_NEAR,     /* may meet a boundary first */
    CML_LANE_CURVED,   /* may meet one that is no plane */
    CML_LANE_AT_PLANE, /* at a plane between unequal indices */
    CML_LANE_REFLECTED,
    CML_LANE_TRANSMITTED,
    CML_LANE_NOWHERE, /* meets no plane and never interacts, or is not a number */
    CML_LANE_DONE,    /* had its event, or holds a new packet: to be flown */
    CML_LANE_ENDED,   /* its packet has, until the lane is refilled */
};

/* What a lane needs to know of the medium it is in. Every member is 4 bytes wide. */
struct cml_lane_medium {
    real mut, mfp, absorb, g, bins, n, n_above, n_below;
    real stop_above, stop_below;   /* z between which there is no boundary of any kind */
    real start_above, start_below; /* the same of surfaces that are no planes; -+infinity beside a plane */
    real span;                     /* 0 for the outer media; no lane needs it */
};
/* Those before start_above: where all boundaries are planes, the others are the same in all media. */
#define CML_LANE_MEDIUM_FLAT (offsetof(struct cml_lane_medium, start_above) / sizeof(real))
#define CML_LANE_MEDIUM_MEMBERS (offsetof(struct cml_lane_medium, span) / sizeof(real))

struct cml_bundle {
    int lanes; /* that take part: whole groups, fewer than CML_LANES when there are no more packets to launch
                */
    _Alignas(64) real x[CML_LANES], y[CML_LANES], z[CML_LANES], ux[CML_LANES], uy[CML_LANES], uz[CML_LANES];
    real tau[CML_LANES]; /* optical depth left to the next interaction; infinite: yet to be drawn from the
                            tail */
    real s[CML_LANES];   /* distance to the next interaction, cm */
    cml_u32 w[CML_LANES], dw[CML_LANES]; /* weight; deposit of this pass */
    cml_u32 flushed_w[CML_LANES];        /* weight when the deposits since were last added to a book */
    cml_u32 draw0[CML_LANES], draw1[CML_LANES], draw2[CML_LANES]; /* words of the next interaction's block */
    cml_u32 index_low[CML_LANES], index_high[CML_LANES];
    cml_u32 interactions[CML_LANES], crossings[CML_LANES], boundary_events[CML_LANES];
    /* of the last boundary event: the number of interactions before it. What the packet stands on, and how
     * often it has bounced, holds only while there has been none since. */
    cml_u32 touched[CML_LANES], bounces[CML_LANES];
    int on_boundary[CML_LANES], on_primitive[CML_LANES], undeflected[CML_LANES];
    int cell[CML_LANES]; /* of A_rz, of this pass */
    int task[CML_LANES];
    int medium[CML_LANES], entered[CML_LANES];
    real of_medium[CML_LANE_MEDIUM_MEMBERS][CML_LANES]; /* columns of struct cml_lane_medium */
};

#define CML_QUEUE 64

/* The next packets of the beam, numbered and with their first draws made: entries first..end-1, in order. A
 * group may be read from any of them. */
struct cml_launch_queue {
    int first, end;
    _Alignas(64) cml_u32 index_low[CML_QUEUE + CML_GROUP], index_high[CML_QUEUE + CML_GROUP];
    cml_u32 draw1[CML_QUEUE + CML_GROUP], draw2[CML_QUEUE + CML_GROUP];
    real tau[CML_QUEUE + CML_GROUP];
    int through[CML_QUEUE + CML_GROUP]; /* the boundary that all packets of the beam meet first */
    int stays[CML_QUEUE];               /* does not end as the ballistic ones do */
};

/* Column of a member of struct cml_lane_medium. */
#define CML_OF_MEDIUM(bundle, member)                                                                        \
    ((bundle)->of_medium[offsetof(struct cml_lane_medium, member) / sizeof(real)])

#endif
