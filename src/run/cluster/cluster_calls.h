/* The functions of cluster.h as a table of pointers, for programs that find MPI at run time (cluster_load.c).
 *
 *     program  --- cluster_load.c ---> table of cluster_single.c                 started alone
 *                                 \--> table of cluster_openmpi.so  --> libmpi   started by a launcher
 *
 * An adapter is cluster.c, cluster_service.c and cluster_table.c, compiled with the mpi.h of one ABI.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "run/cluster/cluster.h"

/* One line per function of cluster.h but cml_cluster_begin. CALL: functions that return a value, with their
 * type. TELL: others. CML_CLUSTER_IDLE: a single rank does nothing in them, and returns 0. */
#define CML_CLUSTER_IDLE(CALL, TELL)                                                                         \
    TELL(end, (cml_status status), (status))                                                                 \
    TELL(await_launcher, (void), ())                                                                         \
    CALL(int, rank, (void), ())                                                                              \
    CALL(int, local_rank, (void), ())                                                                        \
    CALL(int, fair_cores, (void), ())                                                                        \
    TELL(set_timeout, (double seconds), (seconds))                                                           \
    CALL(bool, contact_lost, (void), ())                                                                     \
    CALL(cml_status, share, (void *data, size_t size, struct cml_error *err), (data, size, err))             \
    CALL(cml_status, share_block, (char **block, size_t *size, struct cml_error *err), (block, size, err))   \
    CALL(cml_status, sum, (struct cml_result * result, struct cml_error * err), (result, err))               \
    TELL(alone, (bool alone), (alone))                                                                       \
    TELL(recall, (void), ())                                                                                 \
    CALL(bool, recalled, (void), ())                                                                         \
    TELL(set_handler, (cml_cluster_handler * handler, void *context), (handler, context))
#define CML_CLUSTER_CALLS(CALL, TELL)                                                                        \
    CML_CLUSTER_IDLE(CALL, TELL)                                                                             \
    CALL(int, size, (void), ())                                                                              \
    CALL(int, local_size, (void), ())                                                                        \
    CALL(cml_status, agree, (cml_status mine, struct cml_error * err), (mine, err))                          \
    CALL(cml_status, gather, (const void *mine, size_t size, void *all, struct cml_error *err),              \
         (mine, size, all, err))                                                                             \
    TELL(request_sync, (atomic_int * own), (own))                                                            \
    CALL(bool, sync_requested, (atomic_int * own), (own))                                                    \
    TELL(request_stop, (atomic_int * own), (own))                                                            \
    CALL(bool, stop_requested, (atomic_int * own), (own))                                                    \
    CALL(cml_status, synchronise, (atomic_int * own, struct cml_error * err), (own, err))                    \
    CALL(cml_status, request,                                                                                \
         (const struct cml_work_request *request, struct cml_work_reply *reply, struct cml_error *err),      \
         (request, reply, err))

#define CML_CALL_MEMBER(type, name, parameters, arguments) type(*name) parameters;
#define CML_TELL_MEMBER(name, parameters, arguments) void(*name) parameters;
struct cml_cluster_calls {
    const char *build; /* version and commit of the source: an adapter of another build is refused */
    cml_status (*begin)(int *argc, char ***argv, struct cml_error *err);
    CML_CLUSTER_CALLS(CML_CALL_MEMBER, CML_TELL_MEMBER)
};
#undef CML_CALL_MEMBER
#undef CML_TELL_MEMBER

#define CML_CLUSTER_BUILD CML_VERSION " " CML_GIT

extern const struct cml_cluster_calls cml_cluster_table;  /* in an adapter */
extern const struct cml_cluster_calls cml_cluster_single; /* in the program: one rank */
