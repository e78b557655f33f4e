/* The cells of all rows of a sweep that come from one flight (rule P16), in a tally and in a result. Cells of
 * all rows lie side by side, because the rows are summed together:
 *
 *     batch 0: bin 0 [row 0, row 1 ...] bin 1 [row 0, row 1 ...] ...     CML_OF_ROW_BINS
 *       ...
 *     batch 63: ...
 *     grids over all batches, in the same way                            CML_OF_ROW_GRIDS
 *
 * Scores for derivatives (rule P17) have the same cells without grids. Each medium inside (layers first) has
 * two rows of scores: by mua and by mus. Three terms of a row's balance are not kept by row: the cell of
 * specular is 0, because the specular light of the flight holds for all rows; the cell of absorbed is 0,
 * because absorbed is the sum of A_l; launched has one cell for all rows. Units of weight are 2^-30 of a
 * packet, units of weight times score 2^-20, in two's complement. SPDX-License-Identifier: MIT */
#pragma once

#include "tally/tally.h"

#include <math.h>

/* Number of rows that a vector sums together. The number of rows is rounded up to a multiple of it. */
#define CML_ROW_GROUP 16

/* Number of interactions of a packet per sample for A_z and A_rz of rows. The sampled interaction stands for
 * all of them. */
#define CML_ROW_SAMPLING 8

/* Returns the number of places of a bin: one per row, rounded up. */
static inline size_t cml_row_stride(const struct cml_tally_grid *grid)
{
    return ((size_t)grid->rows + CML_ROW_GROUP - 1) / CML_ROW_GROUP * CML_ROW_GROUP;
}

/* Returns the medium of pair k of scores: layers from 0, then bodies. */
static inline int cml_medium_inside(int num_layers, int k)
{
    return k < num_layers ? k + 1 : k + 2;
}

/* Returns the factor that turns a length into a score, 1/cm. It is a power of two near the medium's mut, so
 * that scores are of the size of numbers of interactions. */
static inline double cml_score_unit(double mut)
{
    return mut > 0 ? exp2(floor(log2(mut))) : 1;
}

/* Parts of a row's moments, from which the means of detectors are made. A moment is a weight times a whole
 * number of interactions, or of 2^16 units of length or depth, up to 62 bits. It is kept in
 * CML_ROW_MOMENT_CELLS parts of 31 bits, the lower first, so that 2^30 moments fit into a tally. */
#define CML_ROW_MOMENT_SHIFT 16
#define CML_ROW_MOMENT_BITS 31

/* Returns the first cell of the bins of a batch, 0..63; for batch 64 the first cell of the grids. */
static inline size_t cml_row_batch(const struct cml_tally_grid *grid, int batch)
{
    return (size_t)batch * cml_layout_of(grid, CML_OF_ROW_BINS).cells * cml_row_stride(grid);
}

/* Returns the number of cells of all rows; 0 if there are none. */
static inline size_t cml_row_cells(const struct cml_tally_grid *grid)
{
    return grid->rows ? cml_row_batch(grid, CML_NUM_BATCHES) +
                            cml_layout_of(grid, CML_OF_ROW_GRIDS).cells * cml_row_stride(grid)
                      : 0;
}
