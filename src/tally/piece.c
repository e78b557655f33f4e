/* SPDX-License-Identifier: MIT */
#include "tally/piece.h"

/* Returns how many of the photons 0 to photons - 1 are in batches below this one. */
static uint64_t in_batches_below(uint64_t photons, uint64_t batch)
{
    const uint64_t rest = photons % CML_NUM_BATCHES;
    return batch * (photons / CML_NUM_BATCHES) + (batch < rest ? batch : rest);
}

/* Returns the first turn of a batch; for batch 64 this is `end`. */
static uint64_t turn_of(uint64_t begin, uint64_t end, uint64_t batch)
{
    return begin + in_batches_below(end, batch) - in_batches_below(begin, batch);
}

/* A piece ends before the next multiple of 2^32 points of the batch, where the lattice gets new shifts
 * (`sheet`: one such range of points). */
struct cml_piece cml_piece_at(uint64_t begin, uint64_t end, uint64_t turn)
{
    uint64_t batch = 0;
    while (turn_of(begin, end, batch + 1) <= turn) batch++;
    const uint64_t first =
        begin + (batch - begin) % CML_NUM_BATCHES; /* first photon of the batch in the round */
    struct cml_piece piece = {
        .first = first + CML_NUM_BATCHES * (turn - turn_of(begin, end, batch)),
        .count = turn_of(begin, end, batch + 1) - turn,
        .batch = (int)batch,
    };
    const uint64_t sheet = (uint64_t)1 << 32, left = sheet - piece.first / CML_NUM_BATCHES % sheet;
    if (piece.count > left) piece.count = left;
    return piece;
}
