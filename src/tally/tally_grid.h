/* The grid of a tally and of a result: which arrays there are, and how many bins they have.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "balance.h"
#include "boundary.h"
#include "tally/saved.h"

#include <stdbool.h>
#include <stddef.h>

struct cml_tally_grid {
    int nr, nz, na;
    int num_layers, num_bodies;
    bool of_thread;                /* all threads share arrays, which another tally owns (CML_IF_OWNER) */
    bool absorption;               /* A_rz is tallied; false: its cells do not exist */
    bool depths;                   /* A_z is tallied, of a thread that scores into an A_rz of others */
    bool cell_errors;              /* each group of photons has an A_rz, an Rd_ra and a Tt_ra of its own */
    bool gate_errors;              /* and an Rd_rt and a Tt_rt */
    size_t voxel_step, facet_step; /* the same of A_xyz, and of facets: cells from those of a group to those
                                    * of the next; 0: groups share them */
    struct cml_once map_once, pixel_once, direction_once; /* of Rd_xya and Tt_xya, of detectors that are maps,
                                                           * of Rd_dir to Rsp_dir */
    int gates;  /* of Rd_t, Tt_t and, with either of those, A_t; 0: they do not exist */
    bool radii; /* Rd_rt and Tt_rt are tallied; only with gates */
    /* What is tallied only when asked for; 0 and false: it does not exist. Maps have nx * ny pixels and one
     * more for whatever lies outside, so that their sums are the totals. */
    int nx, ny;             /* pixels of Rd_xya, Tt_xya and of a layer of A_xyz */
    int map_na;             /* angle bins of a pixel: na or 1 */
    bool volume;            /* A_xyz, nz deep */
    bool phi_volume;        /* phi_xyz, nz deep */
    bool phi_times;         /* phi_rzt */
    double marks;           /* fluence is tallied, by marks so far apart on paths, cm (P14); 0: it is not */
    int nt, np;             /* bins of Rd_dir, Tt_dir and Rsp_dir */
    int detectors;          /* what each has seen, by gates, and means over that */
    double path_unit;       /* of what is summed of lengths and depths, cm */
    double path_top;        /* depth from which depths count, cm */
    size_t detector_pixels; /* of all of them that are maps */
    struct cml_saved_kind saved;
    size_t facets;       /* of all boundaries and bodies */
    int rows;            /* of a sweep, that come of one flight; or scores */
    bool derivatives;    /* they are scores */
    bool row_depths;     /* they have A_z and A_rz, by samples: these do not add up to A to the last bit */
    bool row_times;      /* they, or the row whose result it is, have A_t, where there are gates */
    bool row_means;      /* they have means of detectors */
    size_t row_cells;    /* of all of them together (row_cells.h) */
    bool backed;         /* some of them lie on a backing, which keeps what does not leave them */
    int scores;          /* of expected values below the last shape (P15); 0: they do not exist */
    const int *exponent; /* [scores]: in a tally they count in 2^-31 2^6 2^-exponent. Borrowed */
};

/* Media of a grid: layers, the two outer ones, bodies. */
static inline size_t cml_tally_media(const struct cml_tally_grid *grid)
{
    return (size_t)grid->num_layers + 2 + (size_t)grid->num_bodies;
}

/* A weight of 31 bits times a number of 48 in three parts of 27 bits, the lowest first, so that 2^30 of them
 * fit into 64 bits each. */
#define CML_MOMENT_CELLS 3
#define CML_MOMENT_BITS 27
#define CML_MOMENT_MOST 281474976710656.0 /* 2^48 */

/* Rows of a sweep have moments in two parts (row_cells.h). */
#define CML_ROW_MOMENT_CELLS 2

/* Moments of a detector: sums of weight times one of these numbers, by medium, kind after kind, and behind
 * them the sum of weight times largest depth. */
enum cml_moment { CML_MOMENT_PATH, CML_MOMENT_INTERACTIONS, CML_MOMENT_MOMENTUM, CML_MEDIUM_MOMENTS };
#define CML_MOMENTUM_UNIT 1.52587890625e-5 /* 2^-16 */

static inline size_t cml_tally_moments(const struct cml_tally_grid *grid)
{
    return CML_MEDIUM_MOMENTS * cml_tally_media(grid) + 1;
}

/* Arrays with at most so many cells are kept by group, from whose spread their errors come: a thread's A_rz,
 * Rd_ra and Tt_ra are then its own, too (CML_THREAD_CELLS). Cells of rows that come of one flight count. Of
 * larger arrays those to whose cells a packet adds at most once have squares, and all others no errors. */
#define CML_CELLS_WITH_ERRORS 65536
#define CML_FACETS_WITH_ERRORS 16384

/* Absorption by medium and gate has at most so many cells; with more there is none. */
#define CML_MEDIUM_TIMES 65536
static inline bool cml_has_medium_times(const struct cml_tally_grid *grid)
{
    return grid->gates > 0 && (grid->absorption || grid->depths) && !grid->row_times && !grid->row_depths &&
           cml_tally_media(grid) * ((size_t)grid->gates + 1) <= CML_MEDIUM_TIMES;
}

/* What escapes from facets. */
static inline struct cml_once cml_facet_once(const struct cml_tally_grid *grid)
{
    return (struct cml_once){grid->facet_step, CML_FACET_ESCAPED_SQUARES - CML_FACET_ESCAPED};
}

/* How many A_rz there are, one behind the other, and how many cells each has; so it is with Rd_ra and Tt_ra.
 */
static inline size_t cml_groups_of(size_t step)
{
    return step ? CML_NUM_GROUPS : 1;
}
static inline int cml_cell_groups(const struct cml_tally_grid *grid)
{
    return grid->cell_errors ? CML_NUM_GROUPS : 1;
}
