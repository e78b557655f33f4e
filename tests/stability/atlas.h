/* Flies packets through a scene, aimed where methods may fail, and asks the oracle after every flight where
 * they are.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "oracle_body.h"

enum aim_kind {
    AIM_FACE, /* aim at any point of a boundary or body, from anywhere */
    AIM_EDGE, /* aim at a point of an edge or ridge, exactly or up to two units in the last place beside it */
    AIM_VERTEX, /* aim at a vertex; for rings, at a ridge or the tip; for bodies, see oracle_body.h */
    AIM_DROP,   /* aim at a vertex, along z */
    AIM_ALONG,  /* aim along an edge, in the surface */
    AIM_GRAZE,  /* aim at any point, at `angle` to the surface */
    NUM_AIMS
};

struct atlas_flight {
    const struct cml_scene *scene;
    const struct cml_surface_set *surfaces;
    const struct oracle *oracle; /* [surfaces->count] */
    const struct oracle_bodies *bodies;
    enum aim_kind aim;
    double angle;                  /* of AIM_GRAZE [rad] */
    uint64_t crossings, max_steps; /* limits: the walk ends after the first that is reached; a step is one
                                    * flight */
    double max_seconds;            /* limit of time [s]; 0: none */
    uint32_t seed;
};

/* Counts of events. A packet that is found in another medium than its own is counted once and given up. */
struct atlas_count {
    uint64_t crossings, steps;
    uint64_t lost;     /* the walk itself reports the packet as lost */
    uint64_t wrong;    /* the flight ended in another medium than the packet's */
    uint64_t missed;   /* the flight passed through another medium */
    uint64_t spurious; /* the flight crossed a boundary where none is */
    uint64_t nan;      /* position or direction is not a number, or the direction is not a unit vector */
    uint64_t trapped;
    int lost_cause; /* cause of the last lost packet */
};

/* Flies packets as described by `flight` and counts events. Variants: level "base" of the processor runs
 * everywhere, "v3" needs x86-64-v3. Returns CML_E_INPUT if memory runs out. */
typedef cml_status atlas_fly(const struct atlas_flight *flight, struct atlas_count *count,
                             struct cml_error *err);
atlas_fly atlas_fly_float_base, atlas_fly_double_base, atlas_fly_float_v3, atlas_fly_double_v3;
