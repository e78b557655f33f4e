/* The cluster (cluster.h) as a table for a single rank, without MPI. Sharing, gathering and summing have
 * nothing to do; a synchronisation is over as soon as it is requested. SPDX-License-Identifier: MIT */
#include "run/cluster/cluster_calls.h"

#include <string.h>

#pragma GCC diagnostic ignored "-Wunused-parameter"

#define RETURN_NOTHING(type, name, parameters, arguments)                                                    \
    static type single_##name parameters                                                                     \
    {                                                                                                        \
        return 0;                                                                                            \
    }
#define DO_NOTHING(name, parameters, arguments)                                                              \
    static void single_##name parameters                                                                     \
    {                                                                                                        \
    }
CML_CLUSTER_IDLE(RETURN_NOTHING, DO_NOTHING)

/* Has nothing to start; cluster_load.c refuses to be one of several copies. */
static cml_status single_begin(int *argc, char ***argv, struct cml_error *err)
{
    return CML_OK;
}

static int single_size(void)
{
    return 1;
}

static int single_local_size(void)
{
    return 1;
}

static cml_status single_agree(cml_status mine, struct cml_error *err)
{
    return mine;
}

static cml_status single_gather(const void *mine, size_t size, void *all, struct cml_error *err)
{
    memcpy(all, mine, size);
    return CML_OK;
}

/* Bits of *own: 1, a synchronisation is requested; 2, and then a stop. */
static void single_request_sync(atomic_int *own)
{
    atomic_fetch_or(own, 1);
}

static bool single_sync_requested(atomic_int *own)
{
    return atomic_load(own) != 0;
}

static void single_request_stop(atomic_int *own)
{
    atomic_fetch_or(own, 2);
}

static bool single_stop_requested(atomic_int *own)
{
    return atomic_load(own) & 2;
}

static cml_status single_synchronise(atomic_int *own, struct cml_error *err)
{
    atomic_store(own, 0);
    return CML_OK;
}

static cml_status single_request(const struct cml_work_request *request, struct cml_work_reply *reply,
                                 struct cml_error *err)
{
    *reply = (struct cml_work_reply){0};
    return CML_OK;
}

#define CALL_ENTRY(type, name, parameters, arguments) .name = single_##name,
#define TELL_ENTRY(name, parameters, arguments) .name = single_##name,

const struct cml_cluster_calls cml_cluster_single = {
    .build = CML_CLUSTER_BUILD, .begin = single_begin, CML_CLUSTER_CALLS(CALL_ENTRY, TELL_ENTRY)};
