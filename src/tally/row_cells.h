/* The cells of rows of a sweep that come of one flight (kernels/README.md, P16), in a tally and in a result:
 * for each of the 64 batches bins of sums, each of them for all rows side by side, since all rows are summed
 * together; behind them Rd_ra and Tt_ra of all batches, [nr + 1][na] each, then A_rz, [nr + 1][nz + 2], then
 * Rd_dir and Tt_dir, [nt][np] each: of every group of packets, or of all and behind them squares. Scores for
 * derivatives (P17) have the same cells but for these, two for each medium inside, layers first: by mua and
 * by mus. SPDX-License-Identifier: MIT */
#pragma once

#include "tally/tally_cells.h"

#include <math.h>

/* Rows that are summed together, in vectors, are rounded up to whole ones. */
#define CML_ROW_GROUP 16

/* One of so many interactions of a packet is a sample of A_z and A_rz, and stands for all. */
#define CML_ROW_SAMPLING 8

/* Places of a bin: those of the other rows follow. */
static inline size_t cml_row_stride(const struct cml_tally_grid *grid)
{
    return ((size_t)grid->rows + CML_ROW_GROUP - 1) / CML_ROW_GROUP * CML_ROW_GROUP;
}

/* The medium of a pair of scores, layers from 0, then bodies. */
static inline int cml_medium_inside(int num_layers, int k)
{
    return k < num_layers ? k + 1 : k + 2;
}

/* By which a length is multiplied to be a score, 1/cm: a power of two near the medium's mut, so that scores
 * are as many as interactions. */
static inline double cml_score_unit(double mut)
{
    return mut > 0 ? exp2(floor(log2(mut))) : 1;
}

/* Where bins of a batch begin: first terms of the balance, [CML_NUM_BALANCE_TERMS], of which specular
 * and absorbed are 0: the first is that of the flight, the second the sum of A_l; launched has one cell for
 * all rows. Units of weight are 2^-30 of a packet, of weight times score 2^-20, in two's complement. */
struct cml_row_bins {
    size_t Rd_r, Tt_r; /* [nr + 1] */
    size_t Rd_a, Tt_a; /* [na] */
    size_t A_l;        /* [cml_tally_media] */
    size_t Rd_t, Tt_t; /* [gates + 1], the last for all that is later; or none */
    size_t detector;   /* [detectors] */
    size_t detector_t; /* [detectors][gates + 1]; or none */
    size_t moment;     /* [detectors][cml_tally_moments][2]; or none */
    size_t A_t;        /* [gates + 1]; or none */
    size_t A_z;        /* [nz + 2], from above the first depth to below the last; or none */
    size_t all;        /* of a batch */
};

/* Moments, of which a row's means of detectors are made, are weight times whole numbers of interactions, or
 * of 2^16 units of length or depth: up to 62 bits, in parts of 31, the lower first, so that 2^30 of them fit
 * into a tally. */
#define CML_ROW_MOMENT_SHIFT 16
#define CML_ROW_MOMENT_BITS 31

static inline struct cml_row_bins cml_row_bins(const struct cml_tally_grid *grid)
{
    const size_t r = (size_t)grid->nr + 1, a = (size_t)grid->na,
                 gates = grid->gates ? (size_t)grid->gates + 1 : 0;
    struct cml_row_bins at = {.Rd_r = CML_NUM_BALANCE_TERMS};
    at.Tt_r = at.Rd_r + r;
    at.Rd_a = at.Tt_r + r;
    at.Tt_a = at.Rd_a + a;
    at.A_l = at.Tt_a + a;
    at.Rd_t = at.A_l + cml_tally_media(grid);
    at.Tt_t = at.Rd_t + gates;
    at.detector = at.Tt_t + gates;
    at.detector_t = at.detector + (size_t)grid->detectors;
    at.moment = at.detector_t + (size_t)grid->detectors * gates;
    at.A_t = at.moment + (grid->row_means ? (size_t)grid->detectors * cml_tally_moments(grid) * 2 : 0);
    at.A_z = at.A_t + (grid->row_times ? gates : 0);
    at.all = at.A_z + (grid->row_depths ? (size_t)grid->nz + 2 : 0);
    return at;
}

/* Where the bins of a batch begin, 0..63, and behind the last of them Rd_ra: cells. */
static inline size_t cml_row_batch(const struct cml_tally_grid *grid, int batch)
{
    return (size_t)batch * cml_row_bins(grid).all * cml_row_stride(grid);
}

static inline size_t cml_row_cells_ra(const struct cml_tally_grid *grid)
{
    return grid->derivatives ? 0 : ((size_t)grid->nr + 1) * (size_t)grid->na * cml_row_stride(grid);
}

/* Rd_dir and Tt_dir in bins, each of which is that of all rows; kept as those of the flight are. */
static inline struct cml_once cml_row_once(const struct cml_tally_grid *grid)
{
    const size_t both = grid->direction_once.squares / 3 * 2; /* a thread's grid has no nt */
    return (struct cml_once){grid->direction_once.step ? both : 0, both};
}

/* Cells of Rd_dir and Tt_dir of all rows. */
static inline size_t cml_row_cells_dir(const struct cml_tally_grid *grid)
{
    const struct cml_once once = cml_row_once(grid);
    return grid->derivatives ? 0 : cml_once_parts(once) * once.squares * cml_row_stride(grid);
}

/* Cells of A_rz of all rows, which stand behind those of Rd_ra and Tt_ra. */
static inline size_t cml_row_cells_rz(const struct cml_tally_grid *grid)
{
    return grid->row_depths ? cml_rz_cells(grid) * cml_row_stride(grid) : 0;
}

/* All cells; 0 where there are no rows. */
static inline size_t cml_row_cells(const struct cml_tally_grid *grid)
{
    return grid->rows ? cml_row_batch(grid, CML_NUM_BATCHES) + 2 * cml_row_cells_ra(grid) +
                            cml_row_cells_rz(grid) + cml_row_cells_dir(grid)
                      : 0;
}
