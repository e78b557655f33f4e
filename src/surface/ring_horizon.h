/* What packets that stand on a ring of a heightfield see of it: how steeply they must rise, or fall, to leave
 * it for good. Exists because light that has gone through a surface would else be followed past all its
 * rings, and a single wall in it would make that so for all of them. Included, like the kernel headers, once
 * per precision. SPDX-License-Identifier: MIT */
#ifndef CML_RING_HORIZON_H
#define CML_RING_HORIZON_H

#include "types.h"

#include <math.h>

/* How steeply packets that leave sample j to the side (+1 below the surface, -1 above) must go to pass sample
 * k. */
static inline double cml_rise(const real *r, const real *z, real side, int j, int k)
{
    const double run = fabs((double)r[k] - (double)r[j]);
    return run > 0 ? (double)side * ((double)z[k] - (double)z[j]) / run : INFINITY;
}

/* Raises rise[j] to that of the steepest sample from j on, inwards (step -1) or outwards (1). Samples that
 * are seen from j are the corners of the hull over those from there on: hull[j], int [n] for the caller to
 * provide, is the corner that follows j. */
static inline void cml_look_along(const real *r, const real *z, int n, real side, int step, int *hull,
                                  real *rise)
{
    const int last = step > 0 ? n - 1 : 0;
    hull[last] = last;
    for (int j = last - step; j >= 0 && j < n; j -= step) {
        int k = j + step;
        while (hull[k] != k && cml_rise(r, z, side, j, hull[k]) > cml_rise(r, z, side, j, k)) k = hull[k];
        hull[j] = k;
        rise[j] = (real)fmax((double)rise[j], cml_rise(r, z, side, j, k));
    }
}

/* The horizon of n rings, real [n], for packets on the side: the largest slope, at least 0, at which any
 * place of the surface is seen from any place of the ring, and more by what rounding may turn. From within a
 * ring nothing is seen more steeply than from its ends, which see each other too; across the axis nothing
 * more steeply than its radius tells. scratch: int [n]. */
static inline void cml_ring_horizons(const real *r, const real *z, int n, real side, int *scratch,
                                     real *horizon)
{
    for (int i = 0; i < n; i++) horizon[i] = 0;
    cml_look_along(r, z, n, side, 1, scratch, horizon);
    cml_look_along(r, z, n, side, -1, scratch, horizon);
    for (int i = 0; i < n; i++) {
        const double ends = fmax((double)horizon[i], (double)horizon[i + 1 < n ? i + 1 : i]);
        horizon[i] = (real)(1.001 * ends + 0.001);
    }
}

#endif
