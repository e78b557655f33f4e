/* The cluster of a build without MPI: one rank, alone.
 * SPDX-License-Identifier: MIT */
#include "run/cluster.h"

#include "run/launcher.h"

#include <stdatomic.h>
#include <string.h>

static atomic_bool called;

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

void cml_cluster_set_patience(double seconds)
{
    (void)seconds;
}

bool cml_cluster_broken(void)
{
    return false;
}

void cml_cluster_leave_it_to_the_launcher(void)
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

void cml_cluster_call(void)
{
    atomic_store(&called, true);
}

bool cml_cluster_called(void)
{
    return atomic_load(&called);
}

cml_status cml_cluster_meet(struct cml_error *err)
{
    (void)err;
    atomic_store(&called, false);
    return CML_OK;
}

void cml_cluster_serve(cml_cluster_clerk *clerk, void *context)
{
    (void)clerk;
    (void)context;
}

cml_status cml_cluster_ask(const struct cml_question *question, struct cml_answer *answer,
                           struct cml_error *err)
{
    (void)question;
    (void)err;
    *answer = (struct cml_answer){0};
    return CML_OK;
}
