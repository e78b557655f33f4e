/* Distributes photon indices over ranks, in ranges that ranks ask for. Rank 0 keeps the indices that nobody
 * has flown. Every rank, rank 0 too, takes the next range when it has flown its last, so ranks may be of any
 * speed. A range lasts about half a second on its rank, judged by the rank's last ranges. When few photons
 * are left, a range is half of the rank's share of them, by speed, so that all ranks finish together (after
 * guided self-scheduling, Polychronopoulos and Kuck 1987). A rank that becomes slow costs the others at most
 * this one range:
 *
 *     indices:   |  rank 0   | rank 1 |  rank 0   |  rank 1  | rank 0 | rank 1 | 0 | 1 |0|1|
 *     range:        0.5 s ... of each rank's own time ...      shorter towards the end
 *
 * All ranks synchronise (cluster.h) when no photon is left, when a checkpoint is due, on a signal and on an
 * error. Photons that a rank has not flown of its range then go back to rank 0. The calls of one rank must
 * not overlap (run.c locks). SPDX-License-Identifier: MIT */
#pragma once

#include "tally/ranges.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>

struct cml_work_ranges {
    atomic_int sync;         /* requested synchronisations of this run (cluster.h) */
    struct cml_ranges *open; /* on rank 0: photons not flown yet; borrowed */
    /* held around members that the service thread and the flying thread of rank 0 both use */
    pthread_mutex_t lock;
    uint64_t flown; /* packets flown by all ranks since the beginning, as far as rank 0 was told */
    /* Seconds that a piece costs whatever its size, for clearing and adding tallies; 0: not known yet. */
    double overhead;
    uint64_t want;      /* packets of this rank's next range */
    uint64_t *wants;    /* [ranks], on rank 0: `want` of all ranks, in proportion to their speeds */
    uint64_t all_wants; /* sum of `wants` */
};

/* Makes rank 0 answer requests until cml_work_close. open: used on rank 0 only; it may be changed only
 * between cml_work_return and the next cml_work_take of any rank. CML_E_INPUT when memory runs out;
 * cml_work_close is safe even then. */
CML_NODISCARD cml_status cml_work_open(struct cml_work_ranges *work, struct cml_ranges *open,
                                       struct cml_error *err);
void cml_work_close(struct cml_work_ranges *work);

/* Takes the next range for this rank, which flew `flown` packets since it last asked. range->count 0: a
 * synchronisation is requested, because no photon is left or for another reason. CML_E_IO when rank 0 is
 * lost. Not collective. */
CML_NODISCARD cml_status cml_work_take(struct cml_work_ranges *work, uint64_t flown, struct cml_range *range,
                                       struct cml_error *err);

/* Returns how many packets to fly between two tests for a requested synchronisation: about a quarter of a
 * range, but at least a fixed number, and more if large tallies make pieces expensive. */
uint64_t cml_work_piece(const struct cml_work_ranges *work);

/* Records the seconds it took to add the tally of a batch to the result. */
void cml_work_batch_ended(struct cml_work_ranges *work, double seconds);

/* Returns how many packets this rank is sure to get after its current range; 0 if there are several ranks. */
uint64_t cml_work_open_count(const struct cml_work_ranges *work);

/* Returns the packets flown by all ranks since the beginning, as far as rank 0 was told; meaningful on rank
 * 0. */
uint64_t cml_work_flown(struct cml_work_ranges *work);

/* Records the seconds that the last whole range took; sets the size of the next range. */
void cml_work_timed(struct cml_work_ranges *work, struct cml_range range, double seconds);

/* Gives back the part of a range that a rank did not fly (may be empty), and reports `flown` packets that
 * rank 0 was not told of. *stop, in: this rank was asked to stop; out, on rank 0: any rank was. Collective,
 * after all ranks have synchronised. */
CML_NODISCARD cml_status cml_work_return(struct cml_work_ranges *work, struct cml_range left, uint64_t flown,
                                         bool *stop, struct cml_error *err);
