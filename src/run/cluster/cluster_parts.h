/* Shared by the two files of the cluster: cluster.c (begin, end, collective calls) and cluster_service.c
 * (waiting, the service thread, requests). These are the only files that know MPI; others include cluster.h.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "run/cluster/cluster.h"

#include <mpi.h>
#include <pthread.h>
#include <stdatomic.h>

#define CML_HOST_SIZE 64

/* The state of this rank, global because a process is one rank. Members that are not atomic are set before
 * the service thread starts and never change. */
struct cml_ranks {
    int rank, size;
    char (*host)[CML_HOST_SIZE]; /* [size] names of the hosts, for messages */
    pthread_mutex_t lock;        /* held around every call of MPI once the service thread runs */
    _Atomic double timeout;      /* seconds of silence after which a rank counts as lost */
    atomic_bool alone;           /* this rank works by itself (cml_cluster_alone) */
    atomic_int lost_rank;        /* the rank that contact was lost with; -1: none */
};
extern struct cml_ranks cml_ranks;

/* Fails with CML_E_IO: nothing was heard of rank cml_ranks.lost_rank for too long. */
CML_NODISCARD cml_status cml_cluster_fail_contact_lost(struct cml_error *err);

/* Runs a nonblocking call of MPI, which leaves its MPI_Request in `call`, and waits until the request is
 * complete. A macro, because the call itself must run under the lock. CML_E_IO when MPI fails or contact is
 * lost. */
#define CML_COMPLETE(start, call, err)                                                                       \
    (pthread_mutex_lock(&cml_ranks.lock), cml_cluster_complete(start, call, err))

/* The second half of CML_COMPLETE: releases the lock and waits. code: the return value of the call of MPI. */
CML_NODISCARD cml_status cml_cluster_complete(int code, MPI_Request *call, struct cml_error *err);

/* Sleeps, so that other threads have the core meanwhile. */
void cml_cluster_sleep(double seconds);

/* Starts the service thread of a cluster of several ranks. CML_E_INPUT when memory runs out, CML_E_IO when no
 * thread can be started. cml_service_stop ends the thread and receives the messages still under way. */
CML_NODISCARD cml_status cml_service_start(struct cml_error *err);
void cml_service_stop(void);
