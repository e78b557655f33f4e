/* SPDX-License-Identifier: MIT */
#include "run/saved_ranks.h"

#include "run/cluster/cluster.h"

#include <stdlib.h>
#include <string.h>

/* bytes of rows that a rank sends in one message; a longer row is sent alone */
#define BLOCK_BYTES ((size_t)1 << 18)

/* Head of the message with which a rank sends saved packets; the rows stand behind it. */
struct block {
    uint64_t count, left; /* rows in this message, and rows still to come */
    uint64_t unkept;      /* packets found whose rows are not kept; counted in the first message only */
};

/* Fills a block with the next rows of saved packets, from number *sent on, for sending to rank 0.
 * block->left: rows that remain. */
static void fill(struct cml_saved *saved, size_t kept, size_t most, size_t *sent, struct block *block)
{
    const size_t size = cml_saved_row_bytes(cml_saved_media(saved));
    block->count = kept - *sent < most ? kept - *sent : most;
    if (block->count) memcpy(block + 1, cml_saved_row(saved, *sent), block->count * size);
    *sent += block->count;
    block->left = kept - *sent;
}

/* Adds the blocks of all other ranks, on rank 0. Returns nonzero if any rank has more rows. */
static uint64_t take(struct cml_saved *saved, const char *blocks, size_t size)
{
    uint64_t left = 0;
    for (int rank = 1; rank < cml_cluster_size(); rank++) {
        const struct block *block = (const struct block *)(blocks + (size_t)rank * size);
        cml_saved_add(saved, block + 1, block->count);
        cml_saved_add_found(saved, block->unkept);
        left |= block->left;
    }
    return left;
}

/* Moves the saved packets of all ranks to rank 0, block by block, until no rank has any left. blocks: room
 * for one block of each rank on rank 0; mine: room for this rank's block. */
static cml_status exchange(struct cml_saved *saved, size_t most, size_t size, char *blocks, char *mine,
                           struct cml_error *err)
{
    const struct cml_saved_sums sums = cml_saved_sort(saved);
    const bool first = cml_cluster_rank() == 0;
    struct block *block = (struct block *)mine;
    size_t sent = 0;
    uint64_t left = 1;
    block->unkept = sums.found - sums.kept;
    while (left) {
        if (!first) fill(saved, sums.kept, most, &sent, block);
        CML_TRY(cml_cluster_gather(mine, size, blocks, err));
        left = first ? take(saved, blocks, size) : 0;
        CML_TRY(cml_cluster_share(&left, sizeof left, err));
        block->unkept = 0;
    }
    if (!first) cml_saved_clear(saved);
    return CML_OK;
}

/* Sends the saved packets of all ranks to rank 0, in blocks of about BLOCK_BYTES so that memory stays small.
 * Rank 0 has one block for each rank and one for itself. */
cml_status cml_gather_saved(struct cml_saved *saved, struct cml_error *err)
{
    if (!saved || cml_cluster_size() == 1) return CML_OK;
    const size_t row = cml_saved_row_bytes(cml_saved_media(saved)),
                 most = row < BLOCK_BYTES ? BLOCK_BYTES / row : 1, size = sizeof(struct block) + most * row;
    const size_t blocks = cml_cluster_rank() == 0 ? (size_t)cml_cluster_size() + 1 : 1;
    CML_FREED char *room = NULL;
    CML_TRY(cml_cluster_agree(cml_zeros(&room, blocks, size, "saved photons of all ranks", err), err));
    return exchange(saved, most, size, room, room + (blocks - 1) * size, err);
}
