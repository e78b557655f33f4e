/* Weight windows (rule P19): the weight that packets should have at each depth, or at each depth and distance
 * from a detector. The windows are made from the importance of light, and engines read them.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdint.h>

#define CML_WINDOW_CELLS 1024
#define CML_WINDOW_PLACES 32

/* A table of target weights by ring and depth. It owns its array; zeroed, it is empty. */
struct cml_window_table {
    int layers; /* number of layers, from the top, that the windows cover */
    /* Detector whose light is wanted, from 1; 0: light that comes out below the covered layers. */
    int detector;
    /* share of the ring's area that the detector covers, if the scene is symmetric about the axis x, y and
     * `worth` counts light in a whole ring about this axis; else 1 */
    double share;
    double worth; /* share of the beam's light that reaches the target, in the flat scene */
    /* Share of the light arriving at the detector that lies in its aperture; 1: no aperture. */
    double accepted;
    /* Estimated speed-up: the time in which plain packets reach an error, over the time in which packets with
     * windows do. Right within a factor of 2 or 3; 0: windows save no time. */
    double gain;
    /* Number of depth cells, all of one thickness, and of rings about the nearest place. Ring i begins at the
     * radius reach (i / rings)^2. 1 ring: only depth counts. */
    int cells, rings;
    double depth;                       /* depth where the last cell ends, cm; the first cell begins at 0 */
    double reach;                       /* outer radius of the rings, cm */
    int places;                         /* number of axes of rings; 0: only depth counts */
    double place[CML_WINDOW_PLACES][2]; /* x and y of each axis, scene coordinates, cm */
    /* [rings][cells] target weight in units of 2^-31, from CML_LEAST_TARGET to a whole packet */
    uint32_t *target;
};

/* Smallest target weight, in units of 2^-31. Lighter packets would be rounded too coarsely (rule P3 of
 * kernels/README.md). */
#define CML_LEAST_TARGET 256u

/* Computes `target` from the importance of light, [rings][cells]. Packets keep their whole weight where the
 * importance is at most `start`, and get the share (start / importance)^power elsewhere. All other members of
 * *to must be set; the caller clears *to. CML_E_INPUT: out of memory. */
CML_NODISCARD cml_status cml_window_table_create(const double *importance, double start, double power,
                                                 struct cml_window_table *to, struct cml_error *err);

void cml_window_table_clear(struct cml_window_table *windows);
