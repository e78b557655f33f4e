/* The grid of a tally or a result: which arrays exist, and how many bins they have. SPDX-License-Identifier:
 * MIT */
#pragma once

#include "balance.h"
#include "boundary.h"
#include "tally/saved.h"

#include <stdbool.h>
#include <stddef.h>

/* The sizes of all arrays of a tally or result. */
struct cml_tally_grid {
    int nr, nz, na;
    int num_layers, num_bodies;
    /* The tally of one thread of several: shared arrays belong to another tally (CML_IF_OWNER). */
    bool of_thread;
    bool absorption;  /* A_rz is tallied; false: its cells do not exist */
    bool depths;      /* A_z is tallied, by a thread that scores into a shared A_rz */
    bool cell_errors; /* each group of packets has its own A_rz, Rd_ra and Tt_ra */
    bool gate_errors; /* each group of packets has its own Rd_rt and Tt_rt */
    /* Distance in cells from one group's copy of A_xyz, or of the facets, to the next group's copy. 0: all
     * groups share one copy. */
    size_t voxel_step, facet_step;
    /* Distances between the parts of Rd_xya and Tt_xya, of detectors that are maps, and of Rd_dir to
     * Rsp_dir. */
    struct cml_once map_once, pixel_once, direction_once;
    /* Number of gates of Rd_t, Tt_t and, with either of these, A_t; 0: these arrays do not exist. */
    int gates;
    bool radii; /* Rd_rt and Tt_rt are tallied; only with gates */
    /* Arrays that exist only on request; 0 or false: not requested. Maps have nx * ny pixels and one more for
     * all outside, so that their sums are the totals. */
    int nx, ny;      /* number of pixels of Rd_xya, Tt_xya and of a layer of A_xyz */
    int map_na;      /* number of angle bins of a pixel: na or 1 */
    bool volume;     /* A_xyz is tallied, nz bins deep */
    bool phi_volume; /* phi_xyz is tallied, nz bins deep */
    bool phi_times;  /* phi_rzt is tallied */
    /* Distance between the marks on paths that tally fluence, cm (rule P14); 0: no fluence. */
    double marks;
    int nt, np;             /* number of bins of Rd_dir, Tt_dir and Rsp_dir */
    int detectors;          /* number of detectors; each has sums by gate, and means of its light */
    double path_unit;       /* unit in which lengths and depths are summed, cm */
    double path_top;        /* depths of packets are summed as distances below this depth, cm */
    size_t detector_pixels; /* number of pixels of all detectors that are maps */
    struct cml_saved_kind saved;
    size_t facets;    /* number of facets of all boundaries and bodies */
    int rows;         /* number of rows of a sweep that come from one flight, or of scores */
    bool derivatives; /* the rows are scores of derivatives */
    bool row_depths;  /* rows have A_z and A_rz from samples, which do not add up to A exactly */
    bool row_times;   /* the rows, or the row that this result is made for, have A_t if there are gates */
    bool row_means;   /* rows have means of detectors */
    size_t row_cells; /* number of cells of all rows together (row_cells.h) */
    bool backed;      /* some facets lie on a backing, which keeps the light that does not leave them */
    bool faced;       /* some facets lie below faces */
    int scores;       /* number of expected values below the last shape (rule P15); 0: none */
    /* [scores] exponents; a tally counts score i in units of 2^-31 2^6 2^-exponent[i] of a packet;
     * borrowed */
    const int *exponent;
};

/* Returns the number of media of a grid: layers, the two outer ones, bodies. */
static inline size_t cml_tally_media(const struct cml_tally_grid *grid)
{
    return (size_t)grid->num_layers + 2 + (size_t)grid->num_bodies;
}

/* The parts of a moment. A weight of 31 bits times a number of 48 bits is kept in three parts of 27 bits, the
 * lowest first, so that 2^30 moments fit into 64 bits per part. */
#define CML_MOMENT_CELLS 3
#define CML_MOMENT_BITS 27
#define CML_MOMENT_MOST 281474976710656.0 /* 2^48: a packet adds at most this number to a moment */

/* Number of parts of a moment of rows of a sweep (row_cells.h). */
#define CML_ROW_MOMENT_CELLS 2

/* The moments of a detector: sums of weight times one of these numbers, by medium, kind after kind. Behind
 * them comes the sum of weight times largest depth. */
enum cml_moment { CML_MOMENT_PATH, CML_MOMENT_INTERACTIONS, CML_MOMENT_MOMENTUM, CML_MEDIUM_MOMENTS };
#define CML_MOMENTUM_UNIT 1.52587890625e-5 /* unit of sums of 1 - cosine: 2^-16 */

/* Returns the number of moments of a detector. */
static inline size_t cml_tally_moments(const struct cml_tally_grid *grid)
{
    return CML_MEDIUM_MOMENTS * cml_tally_media(grid) + 1;
}

/* Largest size, in cells or facets, of an array that is kept by group, so that the spread over groups gives
 * standard errors. Cells of rows that come from one flight count towards this size. Up to this size each
 * thread also has its own A_rz, Rd_ra and Tt_ra (CML_THREAD_CELLS). A larger array has sums of squares
 * instead if a packet adds to each cell at most once. Any other larger array has no errors. */
#define CML_CELLS_WITH_ERRORS 65536
#define CML_FACETS_WITH_ERRORS 16384

/* Largest number of cells of absorption by medium and gate; with more cells the array does not exist. */
#define CML_MEDIUM_TIMES 65536
/* True if absorption is kept for each medium and time gate: only with gates, and only while the array stays
 * small. + 1 is the gate for late light. */
static inline bool cml_has_medium_times(const struct cml_tally_grid *grid)
{
    return grid->gates > 0 && (grid->absorption || grid->depths) && !grid->row_times && !grid->row_depths &&
           cml_tally_media(grid) * ((size_t)grid->gates + 1) <= CML_MEDIUM_TIMES;
}

/* Returns how far apart the parts of the facets' array of escaped weight lie, in cells. */
static inline struct cml_once cml_facet_once(const struct cml_tally_grid *grid)
{
    return (struct cml_once){grid->facet_step, CML_FACET_ESCAPED_SQUARES - CML_FACET_ESCAPED};
}

/* Return the number of copies of an array, one behind the other, and the numbers of cells of one A_rz, Rd_ra
 * (or Tt_ra), and Rd_rt (or Tt_rt). */
static inline size_t cml_groups_of(size_t step)
{
    return step ? CML_NUM_GROUPS : 1;
}
/* Returns how many copies of the cell arrays are kept: one for each group of batches, or one. */
static inline int cml_cell_groups(const struct cml_tally_grid *grid)
{
    return grid->cell_errors ? CML_NUM_GROUPS : 1;
}
