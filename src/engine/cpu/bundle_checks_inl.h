/* Code, included by bundle_walk_inl.h only (engine_cpu_level.c says why). What must hold between two passes,
 * for CML_ASSERT: in release builds nothing calls it. SPDX-License-Identifier: MIT */
#ifndef CML_BUNDLE_CHECKS_INL_H
#define CML_BUNDLE_CHECKS_INL_H

#include "engine/cpu/bundle_lanes_inl.h"

/* Weight: never above a whole packet, and never above what it was when deposits were last booked. */
static inline int cml_lane_weight_is_sound(const struct cml_bundle *b, int i)
{
    return b->w[i] <= b->flushed_w[i] && b->flushed_w[i] <= CML_WEIGHT_ONE;
}

/* Medium: one of the scene's, whose columns the lane has. */
static inline int cml_lane_medium_is_sound(const struct cml_flight *f, int i)
{
    const struct cml_bundle *b = f->b;
    const int m = b->medium[i];
    return m >= 0 && m <= f->world->setup.num_layers + 1 + f->world->setup.num_bodies &&
           memcmp(&CML_OF_MEDIUM(b, stop_below)[i], &f->media[m].stop_below, sizeof(real)) == 0 &&
           memcmp(&CML_OF_MEDIUM(b, mfp)[i], &f->media[m].mfp, sizeof(real)) == 0;
}

/* Where a lane with INTERACT is after its hop: in its layer, as in cml_interact. s: the path that it has
 * flown, of which the direction before the interaction is not known any more. */
static inline int cml_lane_place_is_sound(const struct cml_flight *f, int i)
{
    const struct cml_bundle *b = f->b;
    const struct cml_vec p = {b->x[i], b->y[i], b->z[i]};
    return b->task[i] != CML_LANE_INTERACT || cml_is_in_layer(f->world, b->medium[i], p, b->s[i]);
}

/* Lanes that hold a packet, after the interactions of a pass and before lanes are refilled. */
static inline int cml_lanes_are_sound(const struct cml_flight *f)
{
    const struct cml_bundle *b = f->b;
    for (uint64_t rest = f->live & ~f->ended; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        const struct cml_vec u = {b->ux[i], b->uy[i], b->uz[i]};
        if (i >= b->lanes || b->task[i] == CML_LANE_ENDED || !cml_is_unit(u) ||
            !cml_lane_weight_is_sound(b, i) || !cml_lane_medium_is_sound(f, i) ||
            !cml_lane_place_is_sound(f, i))
            return 0;
    }
    return 1;
}

#endif
