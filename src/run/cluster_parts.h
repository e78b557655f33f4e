/* What the two files of the cluster share: cluster.c (beginning, end, collective calls) and cluster_service.c
 * (waiting, the service thread, requests). The only files that know MPI. Private to them.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "run/cluster.h"

#include <mpi.h>
#include <pthread.h>
#include <stdatomic.h>

#define CML_HOST_SIZE 64

/* A process is one rank, so its state is global. All but the atomic members is set before the service thread
 * runs, and does not change afterwards. */
struct cml_ranks {
    int rank, size;
    char (*host)[CML_HOST_SIZE]; /* [size] names, for messages */
    pthread_mutex_t lock;        /* around every call of MPI once the service thread runs */
    _Atomic double timeout;      /* s */
    atomic_bool alone;           /* this rank works by itself */
    atomic_int alone_sync;       /* and wants to synchronise with itself: 1, or to stop then: 2 */
    atomic_int lost_rank;        /* that contact was lost with; -1: none */
};
extern struct cml_ranks cml_ranks;

/* CML_E_IO: nothing was heard of cml_ranks.lost_rank for too long. */
CML_NODISCARD cml_status cml_cluster_fail_contact_lost(struct cml_error *err);

/* Starts a nonblocking call of MPI, which leaves its MPI_Request in `call`, and waits for its end. A macro,
 * because the call itself must run under the lock. CML_E_IO when MPI fails or contact is lost. */
#define CML_COMPLETE(start, call, err)                                                                       \
    (pthread_mutex_lock(&cml_ranks.lock), cml_cluster_complete(start, call, err))

/* The second half of it: `code` is what the call of MPI returned. Releases the lock. */
CML_NODISCARD cml_status cml_cluster_complete(int code, MPI_Request *call, struct cml_error *err);

/* Waits, and lets other threads have the core meanwhile. */
void cml_cluster_sleep(double seconds);

/* Starts the service thread, for a cluster of several ranks. CML_E_INPUT when memory runs out, CML_E_DEVICE
 * when no thread can be started. cml_service_stop ends it and receives what is still under way. */
CML_NODISCARD cml_status cml_service_start(struct cml_error *err);
void cml_service_stop(void);
