/* Code, included by engine/world.c in each precision. The horizon angle of every ring of a heightfield, as
 * its tangent: how steeply a packet on the ring must rise, or fall, to leave the heightfield for good. The
 * term is that of terrain rendering [Max, Horizon mapping: shadows for bump-mapped surfaces, The Visual
 * Computer 4 (2), 1988]. Exists because light that has gone through a surface would else be followed past all
 * its rings, and a single wall in it would make that so for all of them. SPDX-License-Identifier: MIT */
#pragma once

#include "bounds.h"
#include "types.h"

#include <math.h>

/* Slope at which sample k of the profile is seen from sample j, cm per cm; positive to the side (+1 below the
 * surface, -1 above). An upright step hides all: infinite. */
static inline double cml_profile_slope(const real *r, const real *z, real side, int j, int k)
{
    const double run = fabs((double)r[k] - (double)r[j]);
    return run > 0 ? (double)side * ((double)z[k] - (double)z[j]) / run : INFINITY;
}

/* Raises horizon[j] to the slope of the steepest sample from j on, inwards (step -1) or outwards (1), in time
 * proportional to n: from j the steepest is a corner of the convex hull over the samples beyond, and j's own
 * hull is what is left of it [Timonen and Westerholm, Scalable height field self-shadowing, Computer Graphics
 * Forum 29 (2), 2010; Andrew's monotone chain]. hull, int [n] of the caller's: hull[j] is the corner that
 * follows j. */
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

/* The horizons of n rings, real [n], for packets on the side: the largest slope, at least 0, at which any
 * place of the surface is seen from any place of the ring, and more by what rounding may turn: a thousandth,
 * where float turns a direction by 1e-7. From within a ring nothing is seen more steeply than from its ends,
 * which see each other too; across the axis nothing more steeply than its radius tells. r, z: real [n], cm.
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
