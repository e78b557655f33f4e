/* The cells of rows of a sweep that come of one flight (P16), in a tally and in a result:
 * for each of the 64 batches bins of sums (CML_OF_ROW_BINS), each of them for all rows side by side, since
 * all rows are summed together; behind them grids of all batches (CML_OF_ROW_GRIDS), likewise. Scores for
 * derivatives (P17) have the same cells but for grids, two for each medium inside, layers first: by mua and
 * by mus. Of the terms of the balance specular and absorbed are 0: the first is that of the flight, the
 * second the sum of A_l; launched has one cell for all rows. Units of weight are 2^-30 of a packet, of weight
 * times score 2^-20, in two's complement. SPDX-License-Identifier: MIT */
#pragma once

#include "tally/tally.h"

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

/* Moments, of which a row's means of detectors are made, are weight times whole numbers of interactions, or
 * of 2^16 units of length or depth: up to 62 bits, in CML_ROW_MOMENT_CELLS parts of 31, the lower first, so
 * that 2^30 of them fit into a tally. */
#define CML_ROW_MOMENT_SHIFT 16
#define CML_ROW_MOMENT_BITS 31

/* Where the bins of a batch begin, 0..63, and behind the last of them the grids: cells. */
static inline size_t cml_row_batch(const struct cml_tally_grid *grid, int batch)
{
    return (size_t)batch * cml_layout_of(grid, CML_OF_ROW_BINS).cells * cml_row_stride(grid);
}

/* All cells; 0 where there are no rows. */
static inline size_t cml_row_cells(const struct cml_tally_grid *grid)
{
    return grid->rows ? cml_row_batch(grid, CML_NUM_BATCHES) +
                            cml_layout_of(grid, CML_OF_ROW_GRIDS).cells * cml_row_stride(grid)
                      : 0;
}
