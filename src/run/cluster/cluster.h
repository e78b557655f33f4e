/* The ranks of an MPI run and their communication. Without a launcher (mpiexec, srun) MPI is not initialised:
 * the process is rank 0 of 1, and every call below returns at once. A build without MPI (cluster_single.c)
 * has only this case.
 *
 * Each of several ranks has one service thread, which wakes up every few milliseconds. On rank 0 the service
 * thread answers the requests of other ranks while the other threads compute. On every rank it sends and
 * receives heartbeats, the signs by which ranks know that their peers live:
 *
 *     rank 1  --- request for photons, heartbeat --->  rank 0  <--- request, heartbeat ---  rank 2
 *             <---- reply, heartbeat -------------             ---- reply, heartbeat --->
 *
 * One-sided calls of MPI (a counter on rank 0 that others fetch and add to) would need no service thread, but
 * do not progress without one: over TCP, Open MPI 4.1.4 serves them only when the target calls MPI.
 *
 * All calls of MPI are nonblocking and under one lock. MPI_THREAD_SERIALIZED is therefore enough, no rank
 * waits for a dead rank for ever, and waiting ranks leave the cores to others.
 *
 * Functions that return a status are collective unless their comment says otherwise: all ranks call them in
 * the same order. They fail with CML_E_IO when MPI fails, or when a rank has been silent for longer than the
 * timeout; after this no collective call can succeed. "Local" functions send no message and do not wait.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "tally/result.h"

#include <stdatomic.h>

/* Starts MPI if a launcher started this process. CML_E_INPUT: the launcher started several processes that do
 * not find each other, so that each would write the same files. CML_E_DEVICE: MPI cannot start. */
CML_NODISCARD cml_status cml_cluster_begin(int *argc, char ***argv, struct cml_error *err);

/* Ends MPI. After contact was lost it calls MPI_Abort with the status as exit code, because MPI_Finalize
 * would wait for the lost rank. Do not call it after cml_cluster_begin failed. */
void cml_cluster_end(cml_status status);

/* Waits for twice the timeout after contact was lost. The launcher should find the lost host in this time and
 * end this process. Local. */
void cml_cluster_await_launcher(void);

int cml_cluster_rank(void); /* this process' number; 0 without a launcher */
int cml_cluster_size(void); /* number of ranks; 1 without a launcher */
/* number among the ranks of this machine, by which a rank chooses its device */
int cml_cluster_local_rank(void);
int cml_cluster_local_size(void); /* number of ranks on this machine */

/* Returns this rank's even share of the cores on which the ranks of its machine may run; 0 for a single rank.
 * Local. */
int cml_cluster_fair_cores(void);

/* Sets after how many seconds of silence a rank counts as lost (--patience); 60 by default. Local; all ranks
 * must set the same. */
void cml_cluster_set_timeout(double seconds);

/* True if contact with a rank was lost. Local. */
bool cml_cluster_contact_lost(void);

/* Returns the worst status of all ranks, on all ranks, with its message; among equals that of the lowest
 * rank. */
CML_NODISCARD cml_status cml_cluster_agree(cml_status mine, struct cml_error *err);

/* Copies `size` bytes of rank 0 to all ranks. cml_cluster_share_block also allocates the block on the other
 * ranks, which free it. */
CML_NODISCARD cml_status cml_cluster_share(void *data, size_t size, struct cml_error *err);
CML_NODISCARD cml_status cml_cluster_share_block(char **block, size_t *size, struct cml_error *err);

/* Gathers `size` bytes of every rank in all[number of ranks] on rank 0; elsewhere `all` is not used. */
CML_NODISCARD cml_status cml_cluster_gather(const void *mine, size_t size, void *all, struct cml_error *err);

/* Adds the results of all ranks (of one grid) to rank 0's, and clears those of the others. The sums are
 * integers: any order gives the same bits. */
CML_NODISCARD cml_status cml_cluster_sum(struct cml_result *result, struct cml_error *err);

/* Requests a synchronisation, which brings all ranks together in the middle of a flight. Any rank may request
 * one, at any time, from any thread. All ranks hear of the request by the next heartbeats, and
 * cml_cluster_sync_requested is true until they have synchronised. Local. own: the requests of this run,
 * from 0, which count if there is one rank. Several such runs may fly at once. */
void cml_cluster_request_sync(atomic_int *own);
bool cml_cluster_sync_requested(atomic_int *own);

/* Requests a synchronisation after which the run stops. cml_cluster_stop_requested: true if one was
 * requested. Local. */
void cml_cluster_request_stop(atomic_int *own);
bool cml_cluster_stop_requested(atomic_int *own);

/* Waits until all ranks have come to the synchronisation. */
CML_NODISCARD cml_status cml_cluster_synchronise(atomic_int *own, struct cml_error *err);

/* Lets a rank work by itself between cml_cluster_alone(true) and cml_cluster_alone(false). Every function
 * here then behaves as for a single rank 0, except cml_cluster_local_rank, cml_cluster_local_size,
 * cml_cluster_request, cml_cluster_recall and cml_cluster_recalled. All ranks call cml_cluster_alone at the
 * same place, and none waits. cml_cluster_recall asks all ranks to end the work they do alone; from then on
 * cml_cluster_recalled is true for ranks that work alone. All three are local. */
void cml_cluster_alone(bool alone);
void cml_cluster_recall(void);
bool cml_cluster_recalled(void);

/* The request of a rank to rank 0 for photon indices, and the reply (work_ranges.h). */
struct cml_work_request {
    uint64_t want, flown; /* indices wanted; packets flown since the last request */
};
struct cml_work_reply {
    /* indices first to first + count - 1; count 0: nothing is left, or a synchronisation was requested */
    uint64_t first, count;
};

/* Sets the function that answers requests of other ranks, in the service thread of rank 0. NULL: requests get
 * an empty reply; the call returns when no request is being handled any more. Local. */
typedef void cml_cluster_handler(void *context, int rank, const struct cml_work_request *request,
                                 struct cml_work_reply *reply);
void cml_cluster_set_handler(cml_cluster_handler *handler, void *context);

/* Sends a request from another rank to rank 0 and waits for the reply. Not collective. */
CML_NODISCARD cml_status cml_cluster_request(const struct cml_work_request *request,
                                             struct cml_work_reply *reply, struct cml_error *err);
