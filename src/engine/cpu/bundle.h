/* A bundle: 64 packets as a structure of arrays, one packet a lane. The fast walk of the CPU engine.
 *
 * Scalar Monte Carlo follows one packet from launch to end; what it does next depends on that packet, and
 * vector units idle. Here all packets of a bundle do the same event at the same time, and lanes in which it
 * is not due keep what they have: event-based, or vectorised, Monte Carlo (bundle_walk_inl.h,
 * cml_flight_pass, has the references).
 *
 * To follow a packet, read in this order:
 *   engine_cpu_level.c            threads, and the photons that each takes
 *   bundle_flight.h               what a thread holds while it flies them
 *   bundle_launch_inl.h           into a lane: queue of new packets, launch, compaction of lanes at the end
 *   bundle_walk_inl.h             a pass over all lanes; planes; roulette; exits
 *   bundle_loops_inl.h            the vector loops of a pass: draw, fly, planes
 *   bundle_rough_inl.h            rough planes: walks on facets, all lanes together
 *   bundle_interact_inl.h         and the interaction
 *   bundle_marks_inl.h            where fluence is asked for: marks on paths
 *   bundle_curved_reach_inl.h     curved boundaries, 1: on which part of its path a lane can meet one
 *   bundle_curved_search_inl.h    2: which ring or facet it meets
 *   bundle_curved_hits_inl.h      3: where, and reflection or refraction there, in vector loops again
 *   bundle_curved_cross_inl.h     4: back into the lane
 *   bundle_bodies_inl.h           which lanes leave what is free of bodies, and what they meet, singly
 *   bundle_lane_events_inl.h      what is rare: a lane at a time, by kernels/walk.h
 *   bundle_lanes_inl.h            a lane as a packet of kernels/walk.h, its deposits, its end
 *
 * The arithmetic is that of kernels/walk.h in the same order, so every packet ends with the same bits as
 * there; cross.bundle compares whole tallies. SPDX-License-Identifier: MIT */
#pragma once

#include "lattice.h"
#include "types.h"
#include "vector/group_masks.h"

#include <stddef.h>

#define CML_LANES 64 /* as many as a mask has bits: a loop's constants are set up once for all of them */

/* What a lane does in this pass. */
enum cml_lane_task {
    CML_LANE_INTERACT,       /* flies s to its interaction: nothing comes first */
    CML_LANE_MAY_HIT,        /* a boundary may come first: to be looked at */
    CML_LANE_MAY_HIT_CURVED, /* one that is no plane may */
    CML_LANE_MAY_RETURN,     /* is near one that is no plane, and heads away from it */
    CML_LANE_AT_PLANE,       /* has come to a plane between unequal indices: reflect or refract */
    CML_LANE_REFLECTED,      /* at a plane; direction done, medium the same */
    CML_LANE_TRANSMITTED,    /* at a plane; direction done, medium still the one before it */
    CML_LANE_NO_EVENT,       /* meets no plane and never interacts, or is not a number (P9) */
    CML_LANE_TO_FLY,         /* is past a boundary, or holds a new packet: needs a path */
    CML_LANE_ENDED,          /* its packet has, until the lane is refilled */
};

/* A lane's path is safe for the boundary that it is below, or above. */
enum { CML_SAFE_BELOW = 1, CML_SAFE_ABOVE = 2 };

/* What a lane needs to know of the medium it is in, mostly as in struct cml_medium. Every member is 4 bytes
 * wide. Depths in the frame of the medium, cm; see cml_find_lane_candidates. */
struct cml_lane_medium {
    real mut;                      /* 1/cm */
    real mfp;                      /* cm */
    real absorb, g, bins;          /* mua / mut; anisotropy; depth of the frame in bins of dz */
    real n, n_above, n_below;      /* indices: its own, and those behind its boundaries */
    real stop_above, stop_below;   /* z between which there is no boundary of any kind */
    real start_above, start_below; /* the same of boundaries that are no planes; -+infinity beside a plane */
    real span;                     /* thickness, 0 for the outer media; no lane has a column of it */
};
/* Columns before start_above: where all boundaries are planes, the others are the same in all media. */
#define CML_LANE_MEDIUM_FLAT (offsetof(struct cml_lane_medium, start_above) / sizeof(real))
#define CML_LANE_MEDIUM_MEMBERS (offsetof(struct cml_lane_medium, span) / sizeof(real))

/* Columns have an entry for each lane. Lanes without a packet hold anything that does no harm
 * (cml_park_lane). */
struct cml_bundle {
    struct cml_stay *stay; /* [CML_LANES][media] of the trails of lanes (P13); NULL: nobody wants them */
    int num_media;
    int lanes; /* that take part in loops: whole groups, fewer than CML_LANES when there are no more packets
                  to launch */
    /* Position, cm: x and y from the scene's origin, z in the frame of the medium. Direction, unit. */
    _Alignas(64) real x[CML_LANES], y[CML_LANES], z[CML_LANES], ux[CML_LANES], uy[CML_LANES], uz[CML_LANES];
    real tau[CML_LANES]; /* optical depth left to the next interaction; infinite: lies in the tail (P2), to be
                          * drawn
                          */
    real s[CML_LANES];   /* distance to the next interaction, cm, if no boundary comes first */
    real path[CML_LANES]; /* as in cml_packet; loops count it only where time is asked for */
    real mark[CML_LANES]; /* the same where fluence is asked for */
    real here[CML_LANES], low[CML_LANES], deepest[CML_LANES],
        momentum[CML_LANES];             /* P13, the same where detectors are */
    cml_u32 before[CML_LANES];           /* the same */
    cml_u32 spent[CML_LANES];            /* P19, where there are windows */
    int gate[CML_LANES];                 /* of A_t: of the deposits that are not booked yet */
    cml_u32 w[CML_LANES], dw[CML_LANES]; /* weight; deposit of this pass; units of 2^-31 of a packet */
    cml_u32 flushed_w[CML_LANES];        /* weight when deposits were last booked (cml_flush_deposits) */
    cml_u32 draw0[CML_LANES], draw1[CML_LANES], draw2[CML_LANES]; /* words of the next interaction */
    cml_u32 index_low[CML_LANES], index_high[CML_LANES];          /* photon index */
    /* words of the lattice (lattice.h), but for their lowest bits: of the second and third interaction, and
     * of the first two reflections */
    cml_u32 second0[CML_LANES], second1[CML_LANES], second2[CML_LANES];
    cml_u32 third0[CML_LANES], third1[CML_LANES], third2[CML_LANES];
    cml_u32 reflection[CML_LANES], second_reflection[CML_LANES];
    cml_u32 interactions[CML_LANES], crossings[CML_LANES], boundary_events[CML_LANES]; /* as in cml_packet */
    cml_u32 rough_draws[CML_LANES];
    /* Of the last boundary event: how many interactions came before it. While that is equal to interactions,
     * bounces and on_boundary hold; otherwise the packet has interacted since, stands on nothing and has not
     * bounced. So no loop has to reset them at every interaction. */
    cml_u32 interactions_at_hit[CML_LANES], bounces[CML_LANES];
    int on_boundary[CML_LANES], on_primitive[CML_LANES], undeflected[CML_LANES];
    int cell[CML_LANES]; /* of A_rz, for dw */
    int task[CML_LANES]; /* enum cml_lane_task */
    int medium[CML_LANES], entered[CML_LANES];
    int safe[CML_LANES]; /* boundaries for which the lane's path is safe: CML_SAFE_BELOW, CML_SAFE_ABOVE */
    real off_x[CML_LANES], off_y[CML_LANES], off_z[CML_LANES]; /* as in cml_packet; no loop reads them */
    real of_medium[CML_LANE_MEDIUM_MEMBERS]
                  [CML_LANES]; /* columns of struct cml_lane_medium, of the lane's medium */
};

#define CML_QUEUE 64

/* Launch queue: the next photons of the beam, with their first draws made. Entries first..end-1, in order. A
 * group may be read from any of them. */
struct cml_launch_queue {
    int first, end;
    struct cml_block shifts[CML_LATTICE_BLOCKS]; /* of the photons in hand */
    _Alignas(64) cml_u32 index_low[CML_QUEUE + CML_GROUP], index_high[CML_QUEUE + CML_GROUP];
    cml_u32 reversed[CML_QUEUE + CML_GROUP]; /* their points of the lattice */
    cml_u32 draw1[CML_QUEUE + CML_GROUP], draw2[CML_QUEUE + CML_GROUP];
    real tau[CML_QUEUE + CML_GROUP]; /* optical depth to the first interaction */
    int through[CML_QUEUE +
                CML_GROUP]; /* transmitted at the boundary that all photons of the beam meet first */
    real x[CML_QUEUE + CML_GROUP], y[CML_QUEUE + CML_GROUP]; /* where they start, if the queue places them */
    real ux[CML_QUEUE + CML_GROUP], uy[CML_QUEUE + CML_GROUP], uz[CML_QUEUE + CML_GROUP];
    cml_u32 launch[4][CML_QUEUE]; /* what places them */
    int not_ballistic[CML_QUEUE]; /* does not end as ballistic packets do (struct cml_ballistic) */
};

/* Column of a member of struct cml_lane_medium. */
#define CML_OF_MEDIUM(bundle, member)                                                                        \
    ((bundle)->of_medium[offsetof(struct cml_lane_medium, member) / sizeof(real)])
