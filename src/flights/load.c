/* SPDX-License-Identifier: MIT */
#include "flights/load.h"

#include "base/text.h"
#include "input/sweep/sweep_table.h"
#include "run/cluster/cluster.h"
#include "run/cluster/launcher.h"

#include <stdio.h>
#include <stdlib.h>

/* The table is an input like others, which all ranks read again later. */
cml_status cml_read_sweep(const struct cml_options *options, const struct cml_text_source *source,
                          struct cml_error *err)
{
    struct cml_sweep_table table = {.num_rows = 0};
    if (!options->sweep) return CML_OK;
    CML_TRY(cml_sweep_table_read(source, options->sweep, &table, err));
    cml_sweep_table_clear(&table);
    return CML_OK;
}

static cml_status load(const struct cml_options *options, const struct cml_text_source *source,
                       struct cml_scene_list *list, struct cml_error *err)
{
    CML_TRY(cml_load_scenes(options, source, list, err));
    return cml_read_sweep(options, source, err);
}

/* Sends the bytes of all files that rank 0 has read to the other ranks, which then read the scene from these
 * bytes. */
static cml_status share_inputs(struct cml_inputs *inputs, struct cml_error *err)
{
    CML_FREED char *block = NULL;
    size_t size = 0;
    cml_status status = CML_OK;
    const bool first = cml_cluster_rank() == 0;
    if (first) status = cml_inputs_pack(inputs, &block, &size, err);
    status = cml_cluster_agree(status, err);
    if (status == CML_OK) status = cml_cluster_share_block(&block, &size, err);
    if (status == CML_OK && !first) status = cml_inputs_unpack(block, size, inputs, err);
    return status;
}

cml_status cml_load_shared_scenes(const struct cml_options *options, struct cml_scene_list *list,
                                  struct cml_inputs *inputs, struct cml_error *err)
{
    const bool first = cml_cluster_rank() == 0;
    cml_status status = CML_OK;
    const struct cml_text_source record = cml_inputs_recorder(inputs), replay = cml_inputs_replayer(inputs);
    if (first) status = load(options, &record, list, err);
    CML_TRY(cml_cluster_agree(status, err));
    if (cml_cluster_size() > 1) status = share_inputs(inputs, err);
    if (status == CML_OK && !first) status = load(options, &replay, list, err);
    return cml_cluster_agree(status, err);
}

cml_status cml_fly_scenes(const struct cml_options *options, cml_fly_scene *fly, struct cml_error *err)
{
    struct cml_options mine = *options;
    CML_AT_END(cml_scene_list_clear) struct cml_scene_list list = {0};
    CML_AT_END(cml_inputs_clear) struct cml_inputs inputs = {0};
    mine.engine_options.threads = cml_choose_threads(options);
    mine.engine_options.local_rank = cml_cluster_local_rank();
    CML_TRY(cml_load_shared_scenes(options, &list, &inputs, err));
    cml_inputs_clear(&inputs);
    for (int i = 0; i < list.count; i++) CML_TRY(fly(&mine, &list.scenes[i], i, err));
    return CML_OK;
}

/* Notes on rank 0 that there are more threads than cores, which slows a run: a usual mistake under mpiexec,
 * which binds processes to one core. */
static void warn_of_binding(int threads)
{
    struct cml_cores cores;
    cml_cores_mine(&cores);
    const int count = cml_cores_count(&cores);
    if (threads <= count || cml_cluster_rank() != 0) return;
    cml_note("%d threads on %d core%s (affinity of this process; under mpiexec try --bind-to none)", threads,
             count, count == 1 ? "" : "s");
}

int cml_choose_threads(const struct cml_options *options)
{
    const char *environment = getenv("OMP_NUM_THREADS");
    int threads = options->engine_options.threads;
    if (threads == 0 && environment && !cml_parse_int(environment, &threads)) return 0;
    warn_of_binding(threads);
    return threads > 0 ? threads : cml_cluster_fair_cores();
}
