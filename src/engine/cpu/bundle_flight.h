/* What one thread holds while it flies packets through its bundle. Types only.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "engine/cpu/bundle.h"
#include "engine/cpu/bundle_hooks.h"
#include "engine/row_weights_inl.h"
#include "engine/terminated_packets_inl.h"

/* next hands out the next photons *first, *first + 64, *first + 128 and so on, *count of them, all of one
 * batch (tally/piece.h); 0 when there are no more. end_batch is told when the tally has all that came since
 * it was last called: of this batch, and of late packets. gives_up: whether the packets under way are not to
 * be flown to their ends (cml_engine_gives_up); the tally is worth nothing then. */
struct cml_range_source {
    int (*next)(void *context, uint64_t *first, uint64_t *count);
    void (*end_batch)(void *context, int batch, struct cml_tally *tally);
    int (*gives_up)(void *context);
    void *context;
};

/* Ballistic packets: those of a pencil beam that do not interact in their first medium, and leave the
 * material for good behind it. All end alike, so they are counted and never take a lane. */
struct cml_ballistic {
    int possible;      /* there can be such packets */
    real path, mfp;    /* cm: through that medium; mean free path in it */
    cml_u32 crossings; /* boundary events with unequal indices before the last: the number of its draw */
    real reflectance;  /* at the boundary behind that medium */
    struct cml_termination end; /* of each of them */
    uint64_t count;             /* so far */
};

/* One thread's flight. world to source, and factors, are given, the rest is worked out (cml_flight_begin) or
 * is the flight's state. */
struct cml_flight {
    const struct cml_world *world;
    struct cml_bundle *b;
    struct cml_gathered *gathered; /* scratch of bundle_curved_reach_inl.h */
    struct cml_rough_lanes *rough; /* scratch of bundle_rough_inl.h */
    struct cml_regions *regions;   /* of lanes, for bundle_bodies_inl.h */
    struct cml_tally *tally;
    const struct cml_lane_medium *media; /* [num_layers + 2 + num_bodies] */
    const struct cml_range_source *source;
    struct cml_deposits to; /* into the tally */
    /* the beam */
    struct cml_packet start;  /* a packet as the beam places it */
    int pencil;               /* it places all of them alike */
    int elsewhere;            /* they may differ in weight or medium */
    int queue_places;         /* they differ in place and direction, which the queue has */
    int first_hit_known;      /* then all of them hit first_hit, above the material */
    struct cml_hit first_hit; /* in the frame of boundary 0 */
    int enters; /* those that are transmitted there are `inside` but for their indices and draws, and for what
                   the queue has */
    struct cml_packet inside;
    struct cml_known_path known; /* their way on; the world then has it */
    struct cml_world aware;
    real reflectance; /* there */
    struct cml_ballistic ballistic;
    /* the scene */
    int curves;       /* not all boundaries are planes */
    real steepest;    /* slope of those that are none */
    int rough_planes; /* some planes are rough */
    int safe_cells;   /* some of these have safe distances */
    int books_more;   /* deposits go into gates or rows, too */
    /* lanes */
    uint64_t live, ended;     /* masks: lanes that hold packets; those of them whose packet has ended */
    uint64_t past_bodies;     /* mask: lanes that meet no body any more before they interact in this pass */
    struct cml_row_sums rows; /* P16 */
    real *factors;            /* [CML_LANES][cml_row_factors] of the lanes' packets; NULL without rows */
    uint64_t absorbed[CML_LANES]; /* by the lane's packet, up to when its deposits were last booked */
    int wait_at_planes;           /* passes that lanes at planes have waited, summed over lanes */
    int wait_at_curved;           /* the same of lanes at curved boundaries */
    cml_u32 rounds;               /* passes, and rounds over boundaries within them */
    int given_up;
    /* batches */
    int batch;                          /* under way: packets of it are launched; -1 before the first */
    cml_u32 first_cell;                 /* of A_rz of that batch's group */
    uint64_t late;                      /* mask: lanes whose packets are of batches before it */
    uint64_t *late_profiles[CML_LANES]; /* of such a lane: its batch's row (cml_tally_late) */
    /* photons on their way in and out */
    uint64_t next, left; /* photons in hand, beyond the queue: first index, and number */
    struct cml_launch_queue queue;
    struct cml_terminated terminated;
};

/* Masks have one bit per lane. */
#define CML_LANE_BIT(i) ((uint64_t)1 << (i))
