/* The cluster (cluster.h) of a build without MPI: one rank. Sharing, gathering and summing have nothing to
 * do; a synchronisation is over as soon as it is requested. SPDX-License-Identifier: MIT */
#include "run/cluster.h"

#include "run/launcher.h"

#include <stdatomic.h>
#include <string.h>

static atomic_int sync_requested; /* bits: 1, a synchronisation is requested; 2, and then a stop */

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

/* Returns the status of the single rank, as no other has a say. */
cml_status cml_cluster_agree(cml_status mine, struct cml_error *err)
{
    (void)err;
    return mine;
}

/* Does nothing: a single rank has the data already. */
cml_status cml_cluster_share(void *data, size_t size, struct cml_error *err)
{
    (void)data;
    (void)size;
    (void)err;
    return CML_OK;
}

/* Does nothing: a single rank has the block already. */
cml_status cml_cluster_share_block(char **block, size_t *size, struct cml_error *err)
{
    (void)block;
    (void)size;
    (void)err;
    return CML_OK;
}

/* Gathers the data of the single rank: a copy. */
cml_status cml_cluster_gather(const void *mine, size_t size, void *all, struct cml_error *err)
{
    (void)err;
    memcpy(all, mine, size);
    return CML_OK;
}

/* Does nothing: the sums of a single rank are complete. */
cml_status cml_cluster_sum(struct cml_result *result, struct cml_error *err)
{
    (void)result;
    (void)err;
    return CML_OK;
}

void cml_cluster_request_sync(void)
{
    atomic_fetch_or(&sync_requested, 1);
}

bool cml_cluster_sync_requested(void)
{
    return atomic_load(&sync_requested) != 0;
}

/* Requests a stop by bit 1 (value 2); bit 0 (value 1) requests a synchronisation. */
void cml_cluster_request_stop(void)
{
    atomic_fetch_or(&sync_requested, 2);
}

bool cml_cluster_stop_requested(void)
{
    return atomic_load(&sync_requested) & 2;
}

/* Stands for the meeting of all ranks. A single rank need not wait, so the request is done at once. */
cml_status cml_cluster_synchronise(struct cml_error *err)
{
    (void)err;
    atomic_store(&sync_requested, 0);
    return CML_OK;
}

void cml_cluster_set_handler(cml_cluster_handler *handler, void *context)
{
    (void)handler;
    (void)context;
}

/* Stands for the request of work from rank 0 in a program without MPI, where no other rank exists. */
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
