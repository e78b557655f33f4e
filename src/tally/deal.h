/* Deals out photons to beams: how many each beam has, and which beam and batch a turn belongs to (piece.h).
 * Of N photons beam k has N share_k / sum, made whole by largest remainder. The photons, side by side in the
 * order of the beams, are dealt out to the 64 batches in turn:
 *
 *     beam       1 1 1 1 1 2 2 2 3 ...
 *     batch      0 1 2 3 4 5 6 7 8 ... 63 0 1 ...
 *
 * Within a batch each beam has points 0, 1, 2 ... of its own lattice. So a run of N photons, followed by the
 * photons that a run of N + M has in addition, is a run of N + M. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"
#include "tally/piece.h"

#include <stdbool.h>

/* The state of dealing: the beams' shares, and the numbers of photons in the current round. */
struct cml_deal {
    int count;           /* number of beams */
    const double *share; /* [count] share of each beam, > 0, borrowed */
    uint64_t begin, end; /* the current round: photons begin to end - 1 */
    /* [count + 1] for each beam, how many of the first `begin` photons belong to the beams before it;
     * owned */
    uint64_t *before;
    /* [count + 1] for each beam, how many of the first `end` photons belong to the beams before it; owned */
    uint64_t *after;
};

/* Sets number[count] to the number of photons of each beam, which add up to `photons`. For equal remainders
 * the first beams get more. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_deal_numbers(const double *share, int count, uint64_t photons, uint64_t *number,
                                          struct cml_error *err);

/* Prepares dealing for a run; the caller clears it. With a single beam there is nothing to store. */
CML_NODISCARD cml_status cml_deal_create(const double *share, int count, struct cml_deal *deal,
                                         struct cml_error *err);
void cml_deal_clear(struct cml_deal *deal);

/* Starts a round: turns now count the photons begin to end - 1. CML_E_INPUT when memory runs out, or if a
 * beam would have fewer photons in a batch after `end` photons than after `begin`: such a round cannot be
 * flown. */
CML_NODISCARD cml_status cml_deal_round(struct cml_deal *deal, uint64_t begin, uint64_t end,
                                        struct cml_error *err);

/* True if a photon belongs to the current round or to one before it. */
bool cml_deal_has(const struct cml_deal *deal, uint64_t photon);

/* Returns the piece at a turn of the current round; all its photons belong to one beam (cml_piece_at). */
struct cml_piece cml_deal_piece_at(const struct cml_deal *deal, uint64_t turn);
