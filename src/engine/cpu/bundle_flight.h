/* What one thread holds while it flies packets through its bundle. Types only.
 * SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_FLIGHT_H
#define CML_BUNDLE_FLIGHT_H

#include "engine/cpu/bundle.h"
#include "engine/cpu/bundle_hooks.h"
#include "engine/terminated_packets_inl.h"

/* Hands out the next range [*first, *first + *count) of photon indices; 0 when there is none. */
struct cml_range_source {
    int (*next)(void *context, uint64_t *first, uint64_t *count);
    void *context;
};

/* Packets of a pencil beam that do not interact in their first medium, and leave the material for good behind
 * it: all end alike. */
struct cml_ballistic {
    int possible;
    real path; /* cm, in that medium */
    real mfp;
    cml_u32 crossings; /* before its end */
    real reflectance;  /* there */
    struct cml_termination end;
    uint64_t count; /* so far */
};

struct cml_flight {
    const struct cml_world *world;
    struct cml_bundle *b;
    struct cml_tally *tally;
    struct cml_deposits to;              /* into the tally */
    const struct cml_lane_medium *media; /* [num_layers + 2] */
    struct cml_packet start;             /* as the beam places packets */
    int pencil;                          /* it places all of them alike */
    int first_hit_known;                 /* then all of them meet first_hit, above the material */
    struct cml_hit first_hit;
    int enters;               /* and those that are not reflected there go on like `inside` */
    struct cml_packet inside; /* but for their indices */
    real reflectance;
    struct cml_ballistic ballistic;
    struct cml_gathered *gathered; /* bundle_curved_reach_inl.h */
    int curves;                    /* not all surfaces are planes */
    real steepest;                 /* slope of those that are none */
    uint64_t live, ended;          /* masks of lanes: that hold packets; whose packet is finished */
    uint64_t absorbed[CML_LANES];  /* of the lane's packet, up to the last mark */
    const struct cml_range_source *source;
    int waited;          /* passes that lanes at planes have waited, summed over them */
    int waited_near;     /* the same of lanes near curved surfaces */
    uint64_t next, left; /* of the range in hand: photon indices not drawn for yet */
    struct cml_launch_queue queue;
    struct cml_terminated terminated;
};

/* Masks have one bit per lane. */
#define CML_LANE_BIT(i) ((uint64_t)1 << (i))

#endif
