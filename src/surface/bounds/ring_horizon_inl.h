/* Code, included by engine/world.c in each precision: computes the horizon of every ring of a heightfield.
 * The horizon is the tangent of the angle above which a packet that rises (or falls) from the ring leaves the
 * heightfield for good.
 *
 * Without horizons, light that has passed a surface would be followed past all rings. One horizon for all
 * rings would not do, since a single wall would set it. The term comes from terrain rendering [Max, Horizon
 * mapping: shadows for bump-mapped surfaces, The Visual Computer 4 (2), 1988].
 * SPDX-License-Identifier: MIT */
#pragma once

#include "bounds.h"
#include "types.h"

#include <math.h>

/* Returns the slope at which sample k of the profile is seen from sample j, cm per cm; positive towards the
 * side (+1 below the surface, -1 above). Behind an upright step nothing is seen: infinite. */
static inline double cml_profile_slope(const real *r, const real *z, real side, int j, int k)
{
    const double run = fabs((double)r[k] - (double)r[j]);
    return run > 0 ? (double)side * ((double)z[k] - (double)z[j]) / run : INFINITY;
}

/* Raises horizon[j] to the slope of the steepest sample from j on, inwards (step -1) or outwards (step 1), in
 * time proportional to n. The steepest sample is a corner of the convex hull over the samples beyond j; the
 * hull of j is the rest of that hull [Timonen and Westerholm, Scalable height field self-shadowing, Computer
 * Graphics Forum 29 (2), 2010; Andrew's monotone chain]. hull: int [n], scratch; hull[j] becomes the corner
 * that follows j. */
static inline void cml_raise_horizon(const real *r, const real *z, int n, real side, int step, int *hull,
                                     real *horizon)
{
    const int last = step > 0 ? n - 1 : 0;
    hull[last] = last;
    for (int j = last - step; j >= 0 && j < n; j -= step) {
        int k = j + step;
        while (hull[k] != k &&
               cml_profile_slope(r, z, side, j, hull[k]) > cml_profile_slope(r, z, side, j, k))
            k = hull[k];
        hull[j] = k;
        horizon[j] = (real)fmax((double)horizon[j], cml_profile_slope(r, z, side, j, k));
    }
}

/* Computes the horizon of each of n rings for packets on one side of the surface. The horizon is the largest
 * slope, at least 0, at which any place of the surface is seen from any place of the ring; a packet that
 * leaves the ring more steeply meets no ring again. Each end of a ring sees the other end, and sees every
 * place at least as steeply as the places inside the ring do. Places across the axis are seen no more steeply
 * than places along the same radius. Horizons are raised by a thousandth and by CML_HORIZON_RAISED, more than
 * rounding can turn a direction (1e-7 in float). side: +1 below the surface, -1 above it. r, z: real [n], cm.
 * scratch: int [n]. */
static inline void cml_ring_horizons(const real *r, const real *z, int n, real side, int *scratch,
                                     real *horizon)
{
    for (int i = 0; i < n; i++) horizon[i] = 0;
    cml_raise_horizon(r, z, n, side, 1, scratch, horizon);
    cml_raise_horizon(r, z, n, side, -1, scratch, horizon);
    for (int i = 0; i < n; i++) {
        const double ends = fmax((double)horizon[i], (double)horizon[i + 1 < n ? i + 1 : i]);
        horizon[i] = (real)(1.001 * ends + CML_HORIZON_RAISED);
    }
}
