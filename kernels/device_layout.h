/* The data that the host and an OpenCL device hand each other. Both compile this file, and before the first
 * packet flies the host compares the device's layout of every struct with its own.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "balance.h"
#include "types.h"

#ifndef __OPENCL_VERSION__
#include <stddef.h>
#define CML_OFFSET(type, member) ((cml_u32)offsetof(type, member))
#else
#define CML_OFFSET(type, member) ((cml_u32)(size_t) & ((type *)0)->member)
#endif

/* The tallies of a device are one block of 64-bit cells: weight balance, counts, A_l, Rd_ra, Tt_ra, A_rz, in
 * this order. Weights in it are in units of 1/CML_WEIGHT_ONE of a packet. */
#define CML_CELL_BALANCE 0
#define CML_CELL_COUNT (CML_CELL_BALANCE + (cml_u32)CML_NUM_BALANCE_TERMS)
#define CML_CELL_LAYER (CML_CELL_COUNT + (cml_u32)CML_NUM_COUNTS)

/* Returns the column of A_rz in which a device stores the radial bin ir, 0..nr. A device with one packet per
 * work-item (a GPU) stores the overflow bin nr first: many packets end there, and the first cells are the
 * ones in local memory. */
CML_FN int cml_device_column(int ir, int nr, int lanes)
{
    if (lanes > 1) return ir;
    return ir < nr ? ir + 1 : 0;
}

/* A part of the block of tallies. A work-group keeps the part's first cells, which are hit most, in local
 * memory until the kernel ends. Cells count from 0. */
struct cml_local_part {
    cml_u64 first;       /* first cell in the block */
    cml_u32 first_local; /* first cell in local memory */
    cml_u32 count;       /* cells in local memory */
};

struct cml_local_parts {
    /* sums: balance to A_l. It begins both memories, and its cells below CML_CELL_LAYER are always in local
     * memory. */
    struct cml_local_part sums, reflected, transmitted, absorbed;
};

/* Parameters of one call of the kernel. */
struct cml_kernel_call {
    cml_u32 items;     /* work-items that may fly; the others of the last work-group rest */
    cml_u32 steps;     /* most events per work-item, because a watchdog ends a kernel that takes too long */
    cml_u32 record;    /* 1: write the fates, 0: do not */
    cml_u32 num_local; /* cells in local memory */
};

#define CML_LOST_KEPT 64

/* Counters that all work-items share. The call has `count` photons with the indices first, first + stride,
 * first + 2 stride and so on; `taken` of them have been taken. */
struct cml_counters {
    cml_u64 first, stride;       /* index of the first photon; step between two indices */
    cml_u32 count, taken;        /* numbers of photons */
    cml_u32 alive;               /* packets that the next call continues */
    cml_u32 num_lost;            /* lost photons; the first CML_LOST_KEPT are listed */
    cml_u64 lost[CML_LOST_KEPT]; /* indices of the first lost photons of a call */
};

/* The end of one packet, recorded on request. Weights are in units of 1/CML_WEIGHT_ONE of a whole packet. */
struct cml_device_fate {
    cml_u64 absorbed, backing;
    int fate, cause; /* enum cml_fate, cml_lost_cause */
    cml_u32 w;       /* weight at the end */
    cml_u32 interactions, boundary_events;
    real exit_x, exit_y; /* cm, from the scene's origin */
    struct cml_vec u;    /* unit direction at the end */
};

/* Size of a packet on a device. A packet on the host has extra members behind those it shares with the
 * device. */
#ifdef __OPENCL_VERSION__
#define CML_DEVICE_PACKET ((cml_u32)sizeof(struct cml_packet))
#else
#define CML_DEVICE_PACKET CML_OFFSET(struct cml_packet, here)
#endif

#define CML_LAYOUT                                                                                           \
    {                                                                                                        \
        sizeof(struct cml_setup), CML_OFFSET(struct cml_setup, nr), CML_OFFSET(struct cml_setup, specular),  \
            sizeof(struct cml_source), CML_OFFSET(struct cml_source, axis),                                  \
            CML_OFFSET(struct cml_source, num_cells), sizeof(struct cml_light_cell),                         \
            CML_OFFSET(struct cml_setup, map), CML_OFFSET(struct cml_setup, outer_facets),                   \
            sizeof(struct cml_medium), CML_OFFSET(struct cml_medium, depth),                                 \
            sizeof(struct cml_depth_bounds), CML_OFFSET(struct cml_depth_bounds, corner_x),                  \
            sizeof(struct cml_surface), CML_OFFSET(struct cml_surface, lowest),                              \
            CML_OFFSET(struct cml_surface, depths), CML_OFFSET(struct cml_surface, facets),                  \
            CML_DEVICE_PACKET, CML_OFFSET(struct cml_packet, u), CML_OFFSET(struct cml_packet, w),           \
            CML_OFFSET(struct cml_packet, medium), CML_OFFSET(struct cml_packet, fate),                      \
            CML_OFFSET(struct cml_packet, gained), CML_OFFSET(struct cml_packet, queries),                   \
            sizeof(struct cml_local_parts), CML_OFFSET(struct cml_local_parts, absorbed),                    \
            CML_OFFSET(struct cml_local_part, count), sizeof(struct cml_kernel_call),                        \
            CML_OFFSET(struct cml_kernel_call, num_local), sizeof(struct cml_counters),                      \
            CML_OFFSET(struct cml_counters, alive), CML_OFFSET(struct cml_counters, lost),                   \
            sizeof(struct cml_device_fate), CML_OFFSET(struct cml_device_fate, w),                           \
            CML_OFFSET(struct cml_device_fate, u), sizeof(struct cml_body),                                  \
            CML_OFFSET(struct cml_body, radius), sizeof(struct cml_body_node),                               \
            CML_OFFSET(struct cml_body_node, body), sizeof(struct cml_body_grid),                            \
            CML_OFFSET(struct cml_body_grid, per_cell), sizeof(struct cml_body_cell),                        \
            CML_OFFSET(struct cml_body_cell, steepest), CML_OFFSET(struct cml_medium, end_node),             \
            sizeof(struct cml_phase_cell)                                                                    \
    }
#define CML_LAYOUT_ENTRIES 45
