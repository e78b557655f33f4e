/* How many photons each of several beams has, and whose turn it is, of which beam (piece.h).
 * Of N photons beam k has N share_k / sum, whole numbers by largest remainder; laid side by side in the order
 * of the beams, they are dealt out in turn to the batches. In a batch a beam has points 0, 1, 2 ... of its
 * own lattice. So who flies N photons, and then those that N + M photons have besides, has flown N + M.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"
#include "tally/piece.h"

#include <stdbool.h>

struct cml_deal {
    int count;           /* beams */
    const double *share; /* [count] > 0, borrowed */
    uint64_t begin, end; /* the round that the next two are of */
    uint64_t *before;    /* [count + 1] of `begin` photons: how many are of beams before this one; owned */
    uint64_t *after;     /* the same of `end` */
};

/* How many of `photons` are of each beam: number[count], which add up to it. Where remainders are equal the
 * first beams get more. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_deal_numbers(const double *share, int count, uint64_t photons, uint64_t *number,
                                          struct cml_error *err);

/* For a run; the caller clears it. One beam costs nothing. */
CML_NODISCARD cml_status cml_deal_create(const double *share, int count, struct cml_deal *deal,
                                         struct cml_error *err);
void cml_deal_clear(struct cml_deal *deal);

/* From here on turns are those of the round with the photons begin to end - 1. CML_E_INPUT when memory runs
 * out, and where a beam has more photons of `begin` than of `end` in a batch: then so many more cannot be
 * flown. */
CML_NODISCARD cml_status cml_deal_round(struct cml_deal *deal, uint64_t begin, uint64_t end,
                                        struct cml_error *err);

/* Whether a photon is among the round's, or those before it. */
bool cml_deal_has(const struct cml_deal *deal, uint64_t photon);

/* cml_piece_at of the round, of one beam. */
struct cml_piece cml_deal_piece_at(const struct cml_deal *deal, uint64_t turn);
