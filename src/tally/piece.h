/* The order in which the photons of a round are flown: batch after batch, so that threads rarely change from
 * one batch to the next. A turn is a photon's number in this order:
 *
 *     photon   0  64 128 ...   1  65 129 ...   2  66 ...
 *     batch    0   0   0       1   1   1       2   2
 *     turn     0   1   2 ...
 *
 * Ranks share out ranges of turns (ranges.h), and checkpoints store them.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "balance.h"

#include <stdint.h>

/* The photons first, first + 64, first + 128 and so on. All are in one batch, and among the same 2^32 points
 * of the batch (lattice.h). */
struct cml_piece {
    uint64_t first, count;
    int batch; /* number of the batch, first mod 64 */
};

/* Returns the photon at a turn, begin <= turn < end, of a round with the photons begin to end - 1, and the
 * photons that follow it in its batch. */
struct cml_piece cml_piece_at(uint64_t begin, uint64_t end, uint64_t turn);
