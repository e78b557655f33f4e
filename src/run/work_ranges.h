/* Who flies which photons: ranges of indices from one shared counter.
 * Rank 0 keeps the indices that nobody has flown; every rank, rank 0 among them, takes the next range when it
 * has flown its last, so that ranks may be of any speed. A range lasts about half a second on the rank that
 * takes it, by the speed of its last ones. When little is left it is half of the rank's share of that, again
 * by speed, so that all finish together: a rank that is slow, or becomes slow, costs the others at most that
 * one range. When nothing is left, when a checkpoint is due, on a signal or an error, all ranks meet
 * (cluster.h); what they have not flown of their ranges goes back. SPDX-License-Identifier: MIT */
#ifndef CML_WORK_RANGES_H
#define CML_WORK_RANGES_H

#include "tally/ranges.h"

#include <pthread.h>
#include <stdbool.h>

struct cml_dispatch {
    struct cml_ranges *open; /* rank 0's; borrowed */
    pthread_mutex_t lock;    /* around what the clerk's thread and the flying thread of rank 0 both use */
    uint64_t flown;          /* since the beginning, by all ranks, as far as rank 0 was told */
    double overhead;         /* seconds that a piece costs whatever its size: clearing and adding tallies */
    uint64_t want;           /* this rank's next range, packets */
    uint64_t *wants;         /* [ranks] on rank 0: the same of all, in proportion to their speeds */
    uint64_t all_wants;      /* their sum */
};

/* `open` is meaningful on rank 0 and belongs to the dispatch until it is closed, except between
 * cml_dispatch_meet and the next cml_dispatch_take of any rank. */
CML_NODISCARD cml_status cml_dispatch_open(struct cml_dispatch *dispatch, struct cml_ranges *open,
                                           double overhead, struct cml_error *err);
void cml_dispatch_close(struct cml_dispatch *dispatch);

/* The next range for this rank, which flew `flown` packets since it last asked; count = 0: go and meet.
 * CML_E_IO when rank 0 is lost. Not collective. */
CML_NODISCARD cml_status cml_dispatch_take(struct cml_dispatch *dispatch, uint64_t flown,
                                           struct cml_range *range, struct cml_error *err);

/* Packets to fly between two looks for a reason to meet: a quarter of a range, but not few, and more where
 * large tallies make pieces dear. */
uint64_t cml_dispatch_piece(const struct cml_dispatch *dispatch);

/* Packets flown by all ranks since the dispatch was opened, as far as rank 0 was told; meaningful on rank 0.
 */
uint64_t cml_dispatch_flown(struct cml_dispatch *dispatch);

/* How long the range took, in seconds, that was last taken and flown whole. */
void cml_dispatch_timed(struct cml_dispatch *dispatch, struct cml_range range, double seconds);

/* Gives back what a rank did not fly (empty: nothing), and learns on rank 0 whether any rank was asked to
 * stop. Collective; all ranks have come to the meeting. */
CML_NODISCARD cml_status cml_dispatch_return(struct cml_dispatch *dispatch, struct cml_range left,
                                             uint64_t flown, bool *stop, struct cml_error *err);

#endif
