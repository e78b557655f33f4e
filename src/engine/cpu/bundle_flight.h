/* The state of one thread that flies packets through its bundle. Types only.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/cpu/bundle.h"
#include "engine/cpu/bundle_hooks.h"
#include "engine/row_weights_inl.h"
#include "engine/terminated_packets_inl.h"

/* The source of a thread's photons, and the place where it reports. next: finds the next photons *first,
 * *first + 64, *first + 128 and so on, *count of them, all of one batch (tally/piece.h); returns 0 if there
 * are no more. end_batch: told that all scores in the tally since the last call belong to this batch or to
 * late packets. gives_up: true if the packets under way shall not be flown to their ends
 * (cml_engine_gives_up); the tally is then worthless. */
struct cml_range_source {
    int (*next)(void *context, uint64_t *first, uint64_t *count);
    void (*end_batch)(void *context, int batch, struct cml_tally *tally);
    int (*gives_up)(void *context);
    void *context;
};

/* Ballistic packets: packets of a pencil beam that do not interact in their first medium, and leave the
 * material for good behind it. All of them end alike, so they are counted and never take a lane. */
struct cml_ballistic {
    int possible;      /* 1: the scene can have ballistic packets */
    real path, mfp;    /* path through that medium, and mean free path in it, cm */
    cml_u32 crossings; /* boundary events with unequal indices before the last: the number of its draw */
    real reflectance;  /* reflectance of the boundary behind that medium */
    struct cml_termination end; /* the end of each ballistic packet */
    uint64_t count;             /* number of ballistic packets so far */
};

/* One thread's flight. The caller sets the members from world to source, and factors. cml_flight_begin works
 * out the others, or they are the flight's state. */
struct cml_flight {
    const struct cml_world *world;
    struct cml_bundle *b;
    struct cml_gathered *gathered; /* scratch of bundle_curved_reach_inl.h */
    struct cml_rough_lanes *rough; /* scratch of bundle_rough_inl.h */
    struct cml_regions *regions;   /* regions of lanes, for bundle_bodies_inl.h */
    struct cml_tally *tally;
    const struct cml_lane_medium *media; /* [num_layers + 2 + num_bodies] */
    const struct cml_range_source *source;
    struct cml_deposits to;   /* the sink of deposits: arrays of the tally */
    struct cml_packet start;  /* a packet as the beam places it */
    int pencil;               /* 1: the beam places all packets alike */
    int elsewhere;            /* 1: packets may start with another weight or in another medium */
    int queue_places;         /* 1: packets differ in place and direction only, and the queue places them */
    int first_hit_known;      /* 1: all packets hit first_hit, above the material */
    struct cml_hit first_hit; /* the hit of all packets, in the frame of boundary 0 */
    /* 1: packets that are transmitted at the first boundary all start like `inside`, except for their indices
     * and draws, and for the members that the queue holds. */
    int enters;
    struct cml_packet inside;
    /* Known path of packets that start inside; `aware` is the world that has it. */
    struct cml_known_path known;
    struct cml_world aware;
    real reflectance; /* reflectance of the first boundary */
    struct cml_ballistic ballistic;
    int curves;                   /* 1: some boundaries are curved, or touched (kernels/contact.h) */
    real steepest;                /* greatest slope of the curved boundaries */
    int rough_planes;             /* 1: some planes are rough */
    int safe_cells;               /* 1: some boundaries have safe distances */
    int books_more;               /* 1: deposits also go into gates or rows */
    uint64_t live, ended;         /* masks: lanes that hold packets; those of them whose packet has ended */
    uint64_t past_bodies;         /* mask: lanes that meet no body before they interact in this pass */
    struct cml_row_sums rows;     /* sums of rows (P16) */
    real *factors;                /* [CML_LANES][cml_row_factors] of the lanes' packets; NULL without rows */
    uint64_t absorbed[CML_LANES]; /* weight absorbed of the lane's packet up to its last booking */
    int wait_at_planes;           /* passes that lanes at planes have waited, summed over lanes */
    int wait_at_curved;           /* passes that lanes at curved boundaries have waited, summed over lanes */
    cml_u32 rounds;               /* passes, plus rounds over boundaries within them */
    int given_up;
    int batch;                          /* batch whose packets are launched now; -1 before the first */
    cml_u32 first_cell;                 /* first cell of A_rz for the group of this batch */
    uint64_t late;                      /* mask: lanes whose packets belong to earlier batches */
    uint64_t *late_profiles[CML_LANES]; /* by late lane: the row of its batch (cml_tally_late) */
    uint64_t next, left;                /* photons in hand, beyond the queue: first index, and number */
    struct cml_launch_queue queue;
    struct cml_terminated terminated;
};

/* The bit of a lane in a mask. */
#define CML_LANE_BIT(i) ((uint64_t)1 << (i))
