/* The order in which the photons of a round are flown: batch after batch, so that threads rarely go on from
 * one batch to the next. A turn is a photon's number in that order. Ranges of turns (ranges.h) are what
 * ranks share and checkpoints hold. SPDX-License-Identifier: MIT */
#pragma once

#include "balance.h"

#include <stdint.h>

/* Photons first, first + 64, first + 128 and so on, which are all of one batch, and of the same 2^32 points
 * of it (lattice.h). */
struct cml_piece {
    uint64_t first, count;
    int batch; /* first mod 64 */
};

/* The photon whose turn it is, begin <= turn < end, of a round with the photons begin to end - 1; and after
 * it, what follows in its batch. */
struct cml_piece cml_piece_at(uint64_t begin, uint64_t end, uint64_t turn);
