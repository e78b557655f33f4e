/* Flies packets through a scene, aimed where methods fail, and asks the oracle after every flight where they
 * are. SPDX-License-Identifier: MIT */
#pragma once

#include "oracle_body.h"

enum aim_kind {
    AIM_FACE, /* at any point of a boundary or body, from anywhere */
    AIM_EDGE, /* at a point of an edge or ridge, exactly or by up to two units in the last place beside it */
    AIM_VERTEX, /* at a vertex; of rings, at a ridge or the tip; of bodies see oracle_body.h */
    AIM_DROP,   /* the same along z */
    AIM_ALONG,  /* along an edge, in the surface */
    AIM_GRAZE,  /* at any point, at `angle` to the surface */
    NUM_AIMS
};

struct atlas_flight {
    const struct cml_scene *scene;
    const struct cml_surface_set *surfaces;
    const struct oracle *oracle; /* [surfaces->count] */
    const struct oracle_bodies *bodies;
    enum aim_kind aim;
    double angle;                  /* rad */
    uint64_t crossings, max_steps; /* ends after the first that is reached; a step: one flight */
    double max_seconds;            /* 0: none */
    uint32_t seed;
};

/* What happened. A packet that is found elsewhere than its medium says is counted once and given up. */
struct atlas_count {
    uint64_t crossings, steps;
    uint64_t lost;     /* by the walk's own account */
    uint64_t wrong;    /* ended a flight in another medium than it says */
    uint64_t missed;   /* flew through another medium on the way */
    uint64_t spurious; /* crossed a boundary where none is */
    uint64_t nan;      /* position or direction no number, or the direction no unit vector */
    uint64_t trapped;
    int lost_cause; /* of the last one */
};

/* For a level of the processor: base runs on all, v3 needs x86-64-v3. CML_E_INPUT for memory. */
typedef cml_status atlas_fly(const struct atlas_flight *flight, struct atlas_count *count,
                             struct cml_error *err);
atlas_fly atlas_fly_float_base, atlas_fly_double_base, atlas_fly_float_v3, atlas_fly_double_v3;
