/* Weight windows (P19): what packets shall weigh by depth, or by their distance from a
 * detector, too, as it is made of what light is worth, and engines read it. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdint.h>

/* Owned. Zeroed: none. */
struct cml_window_table {
    int layers;   /* light is wanted that comes out of so many of the scene's */
    int detector; /* or that this one sees, from 1 */
    double share; /* below 1: the scene is the same all about x, y, and of light that leaves on a circle the
                   * detector sees the share that lies in it, on average so much */
    double worth; /* which share of the light does, of the flat scene's */
    double accepted; /* below 1: so much of what comes to the detector lies in its aperture */
    double gain; /* in how much less time it is known as well as by plain flights, within a factor of 2 or 3;
                  * 0: in no less */
    int cells, rings; /* of equal depth; about x, y, borders at reach (i / rings)^2; 1: depth alone counts */
    double depth;     /* where the last cell ends, cm; the first begins at 0 */
    double x, y, reach; /* cm, of the scene */
    uint32_t *target;   /* [rings][cells] units of weight, CML_LEAST_TARGET to a whole packet */
};

#define CML_WINDOW_CELLS 1024
#define CML_LEAST_TARGET 256u /* of 2^-31: lighter packets would be rounded too coarsely (P3) */

/* A whole packet where light is worth no more than `start`, and where it is worth more (start /
 * importance)^power. to: all but `target` is set. importance: [rings][cells]. The caller clears *to.
 * CML_E_INPUT: out of memory. */
CML_NODISCARD cml_status cml_window_table_create(const double *importance, double start, double power,
                                                 struct cml_window_table *to, struct cml_error *err);

void cml_window_table_clear(struct cml_window_table *windows);
