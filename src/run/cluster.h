/* The ranks of an MPI run, and what they say to each other.
 * Without a launcher (mpiexec, srun) MPI is not initialised, and the process is rank 0 of 1: every call below
 * then returns at once. A build without MPI (cluster_alone.c) knows nothing else.
 *
 * Every rank of several has one service thread, which wakes up every few milliseconds. On rank 0 it answers
 * the requests of other ranks while the rank's other threads compute. On all ranks it sends and receives
 * heartbeats, by which ranks know that they live. MPI's one-sided calls (a counter on rank 0 that others
 * fetch and add to) would need no such thread, but do not progress without one: over TCP, Open MPI 4.1.4
 * serves them only when the target calls MPI (README.md has the measurement).
 *
 * All calls of MPI are nonblocking and under one lock. So MPI_THREAD_SERIALIZED is enough, nothing waits for
 * a dead rank for ever, and waiting ranks leave the cores to others.
 *
 * Functions that return a status are collective unless they say otherwise: all ranks call them in the same
 * order. They fail with CML_E_IO when MPI fails, or when a rank has been silent for longer than the timeout;
 * then no further collective call can succeed.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "tally/result.h"

/* Starts MPI when a launcher started this process. CML_E_INPUT when the launcher started several processes
 * that do not find each other (then each would write the same files), CML_E_DEVICE when MPI cannot start. */
CML_NODISCARD cml_status cml_cluster_begin(int *argc, char ***argv, struct cml_error *err);

/* Ends MPI; by MPI_Abort with the status as exit code when contact was lost, because MPI_Finalize would wait
 * for the lost rank. Not for a process that failed to begin. */
void cml_cluster_end(cml_status status);

/* When contact was lost: waits for twice the timeout, within which the launcher should find the lost host
 * itself and end this process. Local. */
void cml_cluster_await_launcher(void);

int cml_cluster_rank(void);       /* 0 without a launcher */
int cml_cluster_size(void);       /* number of ranks, 1 without a launcher */
int cml_cluster_local_rank(void); /* among the ranks that share this machine's memory: which device to take */
int cml_cluster_local_size(void); /* number of those */

/* This rank's even part of the cores that its machine's ranks may run on together; 0 without other ranks.
 * Local. */
int cml_cluster_fair_cores(void);

/* Seconds of silence after which a rank is taken for lost (--patience); 60 until set. Local, the same on all
 * ranks. */
void cml_cluster_set_timeout(double seconds);

/* True when contact with a rank was lost. Local. */
bool cml_cluster_contact_lost(void);

/* All ranks return the worst status of all, that of the lowest rank among equals, and its message. */
CML_NODISCARD cml_status cml_cluster_agree(cml_status mine, struct cml_error *err);

/* Rank 0's `size` bytes become everyone's. cml_cluster_share_block allocates them on the other ranks; they
 * are theirs to free. */
CML_NODISCARD cml_status cml_cluster_share(void *data, size_t size, struct cml_error *err);
CML_NODISCARD cml_status cml_cluster_share_block(char **block, size_t *size, struct cml_error *err);

/* all[size of cluster], meaningful on rank 0, receives every rank's `size` bytes. */
CML_NODISCARD cml_status cml_cluster_gather(const void *mine, size_t size, void *all, struct cml_error *err);

/* Adds the results of all ranks (same grid) to that of rank 0 and clears those of the others. Sums of
 * integers: any order gives the same bits. */
CML_NODISCARD cml_status cml_cluster_sum(struct cml_result *result, struct cml_error *err);

/* A synchronisation brings all ranks together in the middle of a flight. Any rank may request one, at any
 * time and from any thread. All ranks hear of it by the next heartbeats, and see cml_cluster_sync_requested
 * until they have synchronised. Local. */
void cml_cluster_request_sync(void);
bool cml_cluster_sync_requested(void);

/* Requests a synchronisation after which the run stops, and whether one is requested. */
void cml_cluster_request_stop(void);
bool cml_cluster_stop_requested(void);

/* Waits until all ranks have come. */
CML_NODISCARD cml_status cml_cluster_synchronise(struct cml_error *err);

/* From cml_cluster_alone(true) to (false) a rank works by itself: every function here behaves as if it were
 * the only one, and rank 0, but for cml_cluster_local_rank, cml_cluster_local_size, cml_cluster_request and
 * what follows. All ranks call it at the same place; none waits. Local. cml_cluster_recall asks all ranks to
 * come to an end soon; cml_cluster_recalled is true of those that are alone from then on. */
void cml_cluster_alone(bool alone);
void cml_cluster_recall(void);
bool cml_cluster_recalled(void);

/* A rank's request to rank 0 for photon indices, and the reply (work_ranges.h). */
struct cml_work_request {
    uint64_t want, flown; /* indices wanted; flown since the last request */
};
struct cml_work_reply {
    uint64_t first, count; /* indices [first, first + count); count 0: nothing is left, or a synchronisation
                            * was requested */
};

/* On rank 0: `handler` replies to the requests of other ranks from now on, in the service thread. NULL:
 * nobody does; returns when no request is being handled any more. Local. */
typedef void cml_cluster_handler(void *context, int rank, const struct cml_work_request *request,
                                 struct cml_work_reply *reply);
void cml_cluster_set_handler(cml_cluster_handler *handler, void *context);

/* On other ranks: sends the request and waits for rank 0's reply. Not collective. */
CML_NODISCARD cml_status cml_cluster_request(const struct cml_work_request *request,
                                             struct cml_work_reply *reply, struct cml_error *err);
