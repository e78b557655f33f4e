/* The cluster (cluster.h) of a build without MPI: one rank. Sharing, gathering and summing have nothing to
 * do; a synchronisation is over as soon as it is requested. SPDX-License-Identifier: MIT */
#include "run/cluster.h"

#include "run/launcher.h"

#include <string.h>

/* Fails if a launcher started several processes of this build: each would write the same files. */
cml_status cml_cluster_begin(int *argc, char ***argv, struct cml_error *err)
{
    (void)argc;
    (void)argv;
    return cml_launcher_check(1, err);
}

void cml_cluster_end(cml_status status)
{
    (void)status;
}

int cml_cluster_rank(void)
{
    return 0;
}

int cml_cluster_size(void)
{
    return 1;
}

int cml_cluster_local_rank(void)
{
    return 0;
}

int cml_cluster_local_size(void)
{
    return 1;
}

int cml_cluster_fair_cores(void)
{
    return 0;
}

void cml_cluster_set_timeout(double seconds)
{
    (void)seconds;
}

bool cml_cluster_contact_lost(void)
{
    return false;
}

void cml_cluster_await_launcher(void)
{
}

cml_status cml_cluster_agree(cml_status mine, struct cml_error *err)
{
    (void)err;
    return mine;
}

cml_status cml_cluster_share(void *data, size_t size, struct cml_error *err)
{
    (void)data;
    (void)size;
    (void)err;
    return CML_OK;
}

cml_status cml_cluster_share_block(char **block, size_t *size, struct cml_error *err)
{
    (void)block;
    (void)size;
    (void)err;
    return CML_OK;
}

cml_status cml_cluster_gather(const void *mine, size_t size, void *all, struct cml_error *err)
{
    (void)err;
    memcpy(all, mine, size);
    return CML_OK;
}

cml_status cml_cluster_sum(struct cml_result *result, struct cml_error *err)
{
    (void)result;
    (void)err;
    return CML_OK;
}

/* Bits of *own: 1, a synchronisation is requested; 2, and then a stop. */
void cml_cluster_request_sync(atomic_int *own)
{
    atomic_fetch_or(own, 1);
}

bool cml_cluster_sync_requested(atomic_int *own)
{
    return atomic_load(own) != 0;
}

void cml_cluster_request_stop(atomic_int *own)
{
    atomic_fetch_or(own, 2);
}

bool cml_cluster_stop_requested(atomic_int *own)
{
    return atomic_load(own) & 2;
}

cml_status cml_cluster_synchronise(atomic_int *own, struct cml_error *err)
{
    (void)err;
    atomic_store(own, 0);
    return CML_OK;
}

void cml_cluster_set_handler(cml_cluster_handler *handler, void *context)
{
    (void)handler;
    (void)context;
}

cml_status cml_cluster_request(const struct cml_work_request *request, struct cml_work_reply *reply,
                               struct cml_error *err)
{
    (void)request;
    (void)err;
    *reply = (struct cml_work_reply){0};
    return CML_OK;
}

void cml_cluster_alone(bool alone)
{
    (void)alone;
}

void cml_cluster_recall(void)
{
}

bool cml_cluster_recalled(void)
{
    return false;
}
