/* Who flies which photons: ranges of indices, handed out on request.
 * Rank 0 keeps the indices that nobody has flown; every rank, rank 0 among them, takes the next range when it
 * has flown its last, so that ranks may be of any speed. A range lasts about half a second on the rank that
 * takes it, judged by its last ones. When little is left it is half of the rank's share of that, again by
 * speed, so that all finish together (after guided self-scheduling, Polychronopoulos and Kuck 1987): a rank
 * that is slow, or becomes slow, costs the others at most that one range. When nothing is left, when a
 * checkpoint is due, on a signal or an error, all ranks synchronise (cluster.h), and what they have not flown
 * of their ranges goes back. The calls of one rank must not overlap (run.c locks). SPDX-License-Identifier:
 * MIT */
#pragma once

#include "tally/ranges.h"

#include <pthread.h>
#include <stdbool.h>

struct cml_work_ranges {
    struct cml_ranges *open; /* rank 0's, not flown yet; borrowed */
    pthread_mutex_t lock;    /* around what the service thread and the flying thread of rank 0 both use */
    uint64_t flown;          /* packets, since the beginning, by all ranks, as far as rank 0 was told */
    double overhead;         /* s that a piece costs whatever its size: clearing and adding tallies; 0: not
                              * known yet */
    uint64_t want;           /* size of this rank's next range, packets */
    uint64_t *wants;         /* [ranks] on rank 0: the same of all, in proportion to their speeds */
    uint64_t all_wants;      /* their sum */
};

/* Rank 0 replies to requests from here on until cml_work_close. `open` is meaningful on rank 0. It may be
 * changed only between cml_work_return and the next cml_work_take of any rank. CML_E_INPUT when memory runs
 * out; cml_work_close is safe then, too. */
CML_NODISCARD cml_status cml_work_open(struct cml_work_ranges *work, struct cml_ranges *open,
                                       struct cml_error *err);
void cml_work_close(struct cml_work_ranges *work);

/* The next range for this rank, which flew `flown` packets since it last asked. count = 0: a synchronisation
 * is requested, because nothing is left or for another reason. CML_E_IO when rank 0 is lost. Not collective.
 */
CML_NODISCARD cml_status cml_work_take(struct cml_work_ranges *work, uint64_t flown, struct cml_range *range,
                                       struct cml_error *err);

/* Packets to fly between two looks at whether a synchronisation is requested: a quarter of a range, but not
 * few, and more where large tallies make pieces dear. */
uint64_t cml_work_piece(const struct cml_work_ranges *work);

/* Tells how many seconds it took to bring the tally of a batch into the result. */
void cml_work_batch_ended(struct cml_work_ranges *work, double seconds);

/* Packets that this rank is sure to get after those in hand. */
uint64_t cml_work_open_count(const struct cml_work_ranges *work);

/* Packets flown by all ranks since the beginning, as far as rank 0 was told; meaningful on rank 0. */
uint64_t cml_work_flown(struct cml_work_ranges *work);

/* Tells how many seconds the range took that was last taken and flown whole: sets the size of the next. */
void cml_work_timed(struct cml_work_ranges *work, struct cml_range range, double seconds);

/* Gives back what a rank did not fly (empty: nothing), and `flown` packets that rank 0 was not told of.
 * *stop: whether this rank was asked to stop; on rank 0 afterwards whether any was. Collective; all ranks
 * have synchronised. */
CML_NODISCARD cml_status cml_work_return(struct cml_work_ranges *work, struct cml_range left, uint64_t flown,
                                         bool *stop, struct cml_error *err);
