/* The ranks of an MPI run, and what they say to each other.
 * Without a launcher (mpiexec, srun) MPI is not initialised, and the process is rank 0 of 1: every call below
 * then returns at once. A build without MPI (cluster_alone.c) knows nothing else.
 *
 * On every rank one thread, the attendant, wakes up about every millisecond: on rank 0 it answers questions
 * while the other threads compute (a one-sided fetch-and-add does not do that: over TCP, Open MPI serves it
 * only when the target calls MPI), and it keeps up the pulse by which ranks know that they live. All calls of
 * MPI are nonblocking and under one lock, so that MPI_THREAD_SERIALIZED is enough, nothing waits for a dead
 * rank for ever, and waiting ranks leave the cores to others.
 *
 * Functions that return a status are collective unless they say otherwise: all ranks call them in the same
 * order. They fail with CML_E_IO when a rank has been silent for longer than the patience; then no further
 * collective call can succeed. SPDX-License-Identifier: MIT */
#ifndef CML_CLUSTER_H
#define CML_CLUSTER_H

#include "tally/result.h"

/* Starts MPI when a launcher started this process. CML_E_INPUT when the launcher started several processes
 * that do not find each other (then each would write the same files), CML_E_DEVICE when MPI cannot start. */
CML_NODISCARD cml_status cml_cluster_begin(int *argc, char ***argv, struct cml_error *err);

/* Ends MPI, by MPI_Abort when contact was lost. Not for a process that failed to begin. */
void cml_cluster_end(cml_status status);

/* When contact was lost: twice the patience, within which the launcher should find the lost host itself and
 * end this process. Local. */
void cml_cluster_leave_it_to_the_launcher(void);

int cml_cluster_rank(void);       /* 0 without a launcher */
int cml_cluster_size(void);       /* 1 without a launcher */
int cml_cluster_local_rank(void); /* among the ranks that share this machine's memory: which device to take */
int cml_cluster_local_size(void);

/* This rank's even part of the cores that its machine's ranks may run on together; 0 without other ranks.
 * Local. */
int cml_cluster_fair_cores(void);

/* Seconds of silence after which a rank is taken for lost; 60 until set. Local, the same on all ranks. */
void cml_cluster_set_patience(double seconds);

/* True when contact with a rank was lost. Local. */
bool cml_cluster_broken(void);

/* All ranks return the worst status of all, that of the lowest rank among equals, and its message. */
CML_NODISCARD cml_status cml_cluster_agree(cml_status mine, struct cml_error *err);

/* Rank 0's block becomes everyone's. cml_cluster_share_block allocates it on the others; it is theirs to
 * free. */
CML_NODISCARD cml_status cml_cluster_share(void *data, size_t size, struct cml_error *err);
CML_NODISCARD cml_status cml_cluster_share_block(char **block, size_t *size, struct cml_error *err);

/* all[size of cluster], meaningful on rank 0, receives every rank's `size` bytes. */
CML_NODISCARD cml_status cml_cluster_gather(const void *mine, size_t size, void *all, struct cml_error *err);

/* Adds the results of all ranks (same grid) to that of rank 0 and clears those of the others, cells in
 * slices. */
CML_NODISCARD cml_status cml_cluster_sum(struct cml_result *result, struct cml_error *err);

/* A meeting is where all ranks come together in the middle of a flight. Any rank may call one, at any time
 * and from any thread; all ranks then hear of it, and see cml_cluster_called until they have met. Local. */
void cml_cluster_call(void);
bool cml_cluster_called(void);

/* Waits until all ranks have come. */
CML_NODISCARD cml_status cml_cluster_meet(struct cml_error *err);

/* A question to rank 0, and its answer. */
struct cml_question {
    uint64_t want, flown;
};
struct cml_answer {
    uint64_t first, count;
};

/* On rank 0: `answer` serves the others' questions from now on, in the attendant's thread. NULL: nobody does;
 * returns when no answer is under way any more. Local. */
typedef void cml_cluster_clerk(void *context, int rank, const struct cml_question *question,
                               struct cml_answer *answer);
void cml_cluster_serve(cml_cluster_clerk *clerk, void *context);

/* On other ranks: waits for rank 0's answer. Not collective. */
CML_NODISCARD cml_status cml_cluster_ask(const struct cml_question *question, struct cml_answer *answer,
                                         struct cml_error *err);

#endif
