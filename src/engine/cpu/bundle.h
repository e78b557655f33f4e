/* A bundle: 64 packets as a structure of arrays, one packet per lane. This is the fast walk of the CPU
 * engine.
 *
 * Scalar Monte Carlo follows one packet from launch to end. Its next event depends on that packet, so vector
 * units idle. Here all packets of a bundle do the same event at the same time, and a lane in which the event
 * is not due keeps its values: event-based, or vectorised, Monte Carlo (bundle_walk_inl.h, cml_flight_pass,
 * has the references).
 *
 *     lane       0         1         2      ...  63
 *     x         [.         .         .           . ]     a column: one member of all packets
 *     uz        [.         .         .           . ]
 *     task      [INTERACT  AT_PLANE  INTERACT    . ]     the event that is due in each lane
 *
 * To follow a packet, read in this order:
 *   engine_cpu_level.c            threads, and the photons that each takes
 *   bundle_flight.h               the state of one thread's flight
 *   bundle_prepare.h              facts about beam and media, found once before packets fly
 *   bundle_launch_inl.h           into a lane: queue of new packets, launch, compaction of lanes at the end
 *   bundle_place_inl.h            places and directions of the packets in the queue
 *   bundle_walk_inl.h             a pass over all lanes; planes; roulette; exits
 *   bundle_loops_inl.h            the vector loops of a pass: draw, fly, planes
 *   bundle_rough_inl.h            rough planes: walks on facets, all lanes together
 *   bundle_interact_inl.h         the vector loops of an interaction
 *   bundle_marks_inl.h            fluence, if it is wanted: marks on paths
 *   bundle_curved_reach_inl.h     curved boundaries, 1: the part of its path on which a lane can meet one
 *   bundle_curved_search_inl.h    2: the ring or facet that it meets
 *   bundle_curved_hits_inl.h      3: the place, and reflection or refraction there, in vector loops again
 *   bundle_curved_cross_inl.h     4: back into the lane
 *   bundle_bodies_inl.h           lanes that leave regions without bodies, and bodies that they meet
 *   bundle_lane_events_inl.h      rare events: a lane at a time, by kernels/walk.h
 *   bundle_lanes_inl.h            a lane as a packet of kernels/walk.h, its deposits, its end
 *   bundle_hooks.h                hooks through which a bench counts lanes and takes times
 *
 * The arithmetic is that of kernels/walk.h in the same order, so every packet ends with the same bits as
 * there. cross.bundle compares whole tallies.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "lattice.h"
#include "types.h"
#include "vector/group_masks.h"

#include <stddef.h>

#define CML_LANES 64 /* as many as a mask has bits: a loop's constants are set up once for all of them */

/* The event that is due in a lane in this pass. */
enum cml_lane_task {
    CML_LANE_INTERACT,       /* flies s to its interaction: nothing comes first */
    CML_LANE_MAY_HIT,        /* a boundary may come first: to be examined */
    CML_LANE_MAY_HIT_CURVED, /* a boundary that is no plane may come first */
    CML_LANE_MAY_RETURN,     /* is near a boundary that is no plane, and heads away from it */
    CML_LANE_AT_PLANE,       /* has come to a plane between unequal indices: is reflected or refracted next */
    CML_LANE_REFLECTED,      /* at a plane; the direction is new, the medium the same */
    CML_LANE_TRANSMITTED,    /* at a plane; the direction is new, the medium still the one before the plane */
    CML_LANE_NO_EVENT,       /* meets no plane and never interacts, or is not a number (P9) */
    CML_LANE_TO_FLY,         /* is past a boundary, or holds a new packet: needs a path */
    CML_LANE_ENDED,          /* its packet has ended; the lane waits for a new one */
};

/* Bits of cml_bundle.safe: the lane's path is safe for the boundary that it is below, or for the one that it
 * is above. */
enum { CML_SAFE_BELOW = 1, CML_SAFE_ABOVE = 2 };

/* The properties of a medium that lanes need, mostly as in struct cml_medium. Every member is 4 bytes wide.
 * Depths are in the frame of the medium, cm (cml_find_lane_candidates). */
struct cml_lane_medium {
    real mut;                    /* mua + mus, 1/cm */
    real mfp;                    /* mean free path, cm */
    real absorb, g, bins;        /* mua / mut; anisotropy; depth of the frame in bins of dz */
    real n, n_above, n_below;    /* indices: of the medium, and of the media beyond its boundaries */
    real stop_above, stop_below; /* depths between which there is no boundary of any kind */
    /* Depths between which there is no curved boundary; -+infinity beside a plane. */
    real start_above, start_below;
    real span; /* thickness, 0 for the outer media; not a column of lanes */
};
/* Columns before start_above. If all boundaries are planes, the other columns are the same in all media. */
#define CML_LANE_MEDIUM_FLAT (offsetof(struct cml_lane_medium, start_above) / sizeof(real))
#define CML_LANE_MEDIUM_MEMBERS (offsetof(struct cml_lane_medium, span) / sizeof(real))

/* The columns of a bundle, one entry for each lane. Lanes without a packet hold values that do no harm
 * (cml_park_lane). */
struct cml_bundle {
    /* [CML_LANES][media] stays of the lanes' trails (P13); NULL if no result needs them. */
    struct cml_stay *stay;
    int num_media;
    /* Lanes that take part in loops: whole groups, fewer than CML_LANES when there are no more packets to
     * launch. */
    int lanes;
    /* Position, cm: x and y from the scene's origin, z in the frame of the medium. Direction: a unit
     * vector. */
    _Alignas(64) real x[CML_LANES], y[CML_LANES], z[CML_LANES], ux[CML_LANES], uy[CML_LANES], uz[CML_LANES];
    /* Optical depth left to the next interaction. Infinite: it lies in the tail (P2), and is drawn later. */
    real tau[CML_LANES];
    real s[CML_LANES];    /* distance to the next interaction, cm, if no boundary comes first */
    real path[CML_LANES]; /* optical path, as in cml_packet; loops count it only if time is wanted */
    real mark[CML_LANES]; /* distance to the next mark, as in cml_packet; used if fluence is wanted */
    /* The visit of the medium under way, as in cml_packet; used if there are detectors (P13) */
    real here[CML_LANES], low[CML_LANES], deepest[CML_LANES], momentum[CML_LANES];
    /* Interactions before that visit, as in cml_packet */
    cml_u32 before[CML_LANES];
    /* Spent branches, as in cml_packet; used if there are windows (P19) */
    cml_u32 spent[CML_LANES];
    int gate[CML_LANES];                 /* gate of A_t of the deposits that are not booked yet */
    cml_u32 w[CML_LANES], dw[CML_LANES]; /* weight, and deposit of this pass, in units of 2^-31 of a packet */
    cml_u32 flushed_w[CML_LANES];        /* weight when deposits were last booked (cml_flush_deposits) */
    cml_u32 draw0[CML_LANES], draw1[CML_LANES], draw2[CML_LANES]; /* random words of the next interaction */
    cml_u32 index_low[CML_LANES], index_high[CML_LANES];          /* photon index */
    /* Words of the lattice (lattice.h), but for their lowest bits: of the second and third interaction, and
     * of the first two reflections. */
    cml_u32 second0[CML_LANES], second1[CML_LANES], second2[CML_LANES];
    cml_u32 third0[CML_LANES], third1[CML_LANES], third2[CML_LANES];
    cml_u32 reflection[CML_LANES], second_reflection[CML_LANES];
    /* Numbers of events so far, as in cml_packet. */
    cml_u32 interactions[CML_LANES], crossings[CML_LANES], boundary_events[CML_LANES];
    cml_u32 rough_draws[CML_LANES];
    /* Number of interactions before the last boundary event. While it equals `interactions`, bounces and
     * on_boundary are valid. Otherwise the packet has interacted since, stands on nothing and has not
     * bounced. So no loop needs to reset them at every interaction. */
    cml_u32 interactions_at_hit[CML_LANES], bounces[CML_LANES];
    int on_boundary[CML_LANES], on_primitive[CML_LANES], undeflected[CML_LANES];
    int cell[CML_LANES]; /* cell of A_rz to which dw is added */
    int task[CML_LANES]; /* enum cml_lane_task */
    int medium[CML_LANES], entered[CML_LANES];
    int safe[CML_LANES]; /* boundaries for which the lane's path is safe: CML_SAFE_BELOW, CML_SAFE_ABOVE */
    /* Place on a sphere or cylinder, as in cml_packet; no loop reads it. */
    real off_x[CML_LANES], off_y[CML_LANES], off_z[CML_LANES];
    /* Columns of struct cml_lane_medium, for the lane's medium. */
    real of_medium[CML_LANE_MEDIUM_MEMBERS][CML_LANES];
};

#define CML_QUEUE 64

/* Launch queue: the next photons of the beam, with their first random numbers drawn. Entries are first to end
 * - 1, in order. A group may be read from any entry on. */
struct cml_launch_queue {
    int first, end;
    /* The lattice's shifts for the photons of the batch in hand. */
    struct cml_block shifts[CML_LATTICE_BLOCKS];
    _Alignas(64) cml_u32 index_low[CML_QUEUE + CML_GROUP], index_high[CML_QUEUE + CML_GROUP];
    cml_u32 reversed[CML_QUEUE + CML_GROUP]; /* the photons' points of the lattice */
    cml_u32 draw1[CML_QUEUE + CML_GROUP], draw2[CML_QUEUE + CML_GROUP];
    real tau[CML_QUEUE + CML_GROUP]; /* optical depth to the first interaction */
    /* 1: transmitted at the boundary that all photons of the beam meet first. */
    int through[CML_QUEUE + CML_GROUP];
    /* Starting places, if the queue places the photons. */
    real x[CML_QUEUE + CML_GROUP], y[CML_QUEUE + CML_GROUP];
    real ux[CML_QUEUE + CML_GROUP], uy[CML_QUEUE + CML_GROUP], uz[CML_QUEUE + CML_GROUP];
    cml_u32 launch[4][CML_QUEUE]; /* random words of the launch */
    int not_ballistic[CML_QUEUE]; /* 1: does not end as ballistic packets do (struct cml_ballistic) */
};

/* Column of a member of struct cml_lane_medium. */
#define CML_OF_MEDIUM(bundle, member)                                                                        \
    ((bundle)->of_medium[offsetof(struct cml_lane_medium, member) / sizeof(real)])
