/* clustermcml run: flies every run of a file; each has its own result. SPDX-License-Identifier: MIT */
#include "cli/command.h"

#include "base/text.h"
#include "base/version.h"
#include "flights/one_run.h"
#include "flights/outputs.h"
#include "flights/sweep.h"
#include "flights/sweep_flights.h"
#include "run/cluster/cluster.h"
#include "run/identity.h"
#include "run/join.h"
#include "run/stop.h"
#include "simulation/simulation.h"

#include <inttypes.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* State shared by all runs of one call. */
struct session {
    const struct cml_options *options;
    const struct cml_scene_list *list;
    char *inputs;               /* lines of the identity for the input files */
    struct cml_outputs outputs; /* claimed files of all runs, on rank 0 only */
};

/* Checks all runs of a file, and that outputs can be written, before the first photon flies. Loops from 1:
 * the first run is prepared right after this, and then refuses the same faults before its first photon. */
static cml_status check_runs(struct session *session, const struct cml_inputs *inputs, struct cml_error *err)
{
    const struct cml_scene_list *list = session->list;
    cml_status status = CML_OK;
    for (int i = 1; status == CML_OK && i < list->count; i++)
        status = cml_simulation_check(session->options, &list->scenes[i], NULL, err);
    if (status == CML_OK && cml_cluster_rank() == 0)
        status = cml_outputs_claim(session->options, list, list->count, inputs, &session->outputs, err);
    return cml_cluster_agree(status, err);
}

/* Removes the checkpoints of all runs: finished runs need none. */
static void remove_checkpoints(const struct session *session)
{
    struct cml_error ignored;
    for (int i = 0; cml_cluster_rank() == 0 && i < session->list->count; i++) {
        CML_FREED char *path = NULL;
        if (cml_run_checkpoint(session->options, &session->list->scenes[i], &path, &ignored) == CML_OK)
            cml_checkpoint_remove(path);
    }
}

/* Flies one run. Its record is printed even if its weights do not balance. */
static cml_status run_scene(const struct session *session, int index, struct cml_error *err)
{
    const struct cml_options *options = session->options;
    const struct cml_run_call call = {.options = options,
                                      .scene = &session->list->scenes[index],
                                      .inputs = session->inputs,
                                      .seed = options->engine_options.seed,
                                      .run = (uint32_t)index,
                                      .only = session->list->count == 1,
                                      .stays = cml_run_leaves_checkpoints(options) ||
                                               index + 1 < session->list->count};
    struct cml_record record;
    const cml_status status = cml_run_one(&call, &record, err);
    if (record.json && options->json) fputs(record.json, stdout);
    fflush(stdout);
    cml_record_clear(&record);
    return status;
}

/* Reads the parts of all runs for `merge` before the first result is written, so that a missing part spoils
 * nothing. A single run reads all its parts first anyway. */
static cml_status look_at_parts(const struct session *session, struct cml_error *err)
{
    struct cml_part_files *files = session->options->joined;
    cml_status status = CML_OK;
    if (!files || session->list->count == 1) return CML_OK;
    files->looking = true;
    for (int i = 0; status == CML_OK && i < session->list->count; i++) status = run_scene(session, i, err);
    return cml_part_files_looked(files, status, err);
}

/* Flies all runs of a file, one after the other. Checkpoints go at the end, unless the options keep them. */
static cml_status run_all(const struct session *session, struct cml_error *err)
{
    const struct cml_options *options = session->options;
    CML_TRY(look_at_parts(session, err));
    if (cml_cluster_rank() == 0 && !options->quiet && !options->json)
        printf("clustermcml %s, %d rank%s\n", cml_version(), cml_cluster_size(),
               cml_cluster_size() == 1 ? "" : "s");
    for (int i = 0; i < session->list->count; i++) CML_TRY(run_scene(session, i, err));
    if (options->checkpoint_interval > 0 && !cml_run_leaves_checkpoints(options)) remove_checkpoints(session);
    return CML_OK;
}

/* Refuses a name of a result with an ending other than .mco or .h5, because the ending sets the format. */
static cml_status check_output(const char *name, struct cml_error *err)
{
    const char *slash = name ? strrchr(name, '/') : NULL,
               *dot = name ? strrchr(slash ? slash : name, '.') : NULL;
    if (!dot || !dot[1] || cml_file_ends_in(name, ".mco") || cml_file_ends_in(name, ".h5")) return CML_OK;
    return cml_fail(err, CML_E_INPUT,
                    "--output %.200s (expected a name that ends in .mco or .h5, or has no ending)", name);
}

/* Refuses -o with the name of a result: -o names a folder, --output a result. */
static cml_status check_folder(const char *name, struct cml_error *err)
{
    const bool result = name && (cml_file_ends_in(name, ".mco") || cml_file_ends_in(name, ".h5"));
    if (!result || access(name, F_OK) == 0) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "run: -o %.200s (expected a folder; --output names the result)", name);
}

/* Refuses options beside --part that need the whole run, and a command line that cannot be repeated. */
static cml_status check_part(const struct cml_options *options, struct cml_error *err)
{
    const char *beside = options->target_error > 0 ? "--target-error" : options->json ? "--json" : NULL;
    if (options->parts == 0) return CML_OK;
    if (beside) return cml_fail(err, CML_E_INPUT, "--part (expected no %s beside it)", beside);
    if (!options->call[0])
        return cml_fail(err, CML_E_INPUT,
                        "--part: the command line is too long or has a line break (expected at most %zu "
                        "bytes in one line)",
                        sizeof options->call - 1);
    return CML_OK;
}

/* Refuses options that contradict each other. --more implies --keep: it starts from tallies, and leaves some.
 */
static cml_status check_options(struct cml_options *options, struct cml_error *err)
{
    CML_TRY(check_output(options->output, err));
    CML_TRY(check_folder(options->directory, err));
    if (options->more > 0) options->keep = true;
    if (options->keep && options->target_error > 0)
        return cml_fail(err, CML_E_INPUT, "--%s (expected no --target-error beside it)",
                        options->more > 0 ? "more" : "keep");
    if (options->more > 0 && options->photons > 0)
        return cml_fail(err, CML_E_INPUT, "--more (expected no --photons beside it)");
    CML_TRY(cml_check_flight_options(options, err));
    CML_TRY(check_part(options, err));
    return cml_sweep_check_options(options, err);
}

/* Returns in *text, which the caller frees, all options that must be the same on all ranks. In a sweep every
 * rank writes rows, so the text includes the names of results and options about them. Files are left out:
 * rank 0 sends their bytes to all. */
static cml_status describe(const struct cml_options *options, char **text, struct cml_error *err)
{
    CML_FREED char *settings = NULL;
    const struct cml_run_setup setup = {.engine = options->engine,
                                        .options = options->engine_options,
                                        .photons = options->photons,
                                        .target_error = options->target_error};
    char rest[4 * PATH_MAX] = "";
    if (options->parts > 0)
        snprintf(rest, sizeof rest, "part %" PRIu64 " of %" PRIu64 "\n", options->part, options->parts);
    const size_t used = strlen(rest);
    if (options->sweep)
        snprintf(rest + used, sizeof rest - used,
                 "more %" PRIu64 ", keep %d, resume %d, replace %d, json %d, reweight %d\n%s\n%s\n%s\n",
                 options->more, options->keep, options->resume, options->replace, options->json,
                 options->reweight, options->sweep, options->output ? options->output : "",
                 options->directory ? options->directory : "");
    CML_TRY(cml_settings_text(&options->settings, &settings, err));
    struct cml_provenance provenance =
        cml_run_provenance(&setup, &options->surface, options->ignore_heightfields);
    provenance.aim = options->aim;
    provenance.error_of = options->error_of;
    return cml_identity_of(&provenance, settings, rest, text, err);
}

/* Refuses ranks with different options: they would mix two runs in one result, or rows of two sweeps. */
static cml_status check_same(const struct cml_options *options, struct cml_error *err)
{
    char *mine = NULL, *first = NULL;
    CML_TRY(cml_cluster_agree(describe(options, &mine, err), err));
    size_t size = strlen(mine) + 1;
    first = mine;
    cml_status status = cml_cluster_share_block(&first, &size, err);
    if (status == CML_OK && strcmp(first, mine) != 0)
        status = cml_fail(err, CML_E_INPUT,
                          "rank %d has another program or other options than rank 0 (expected the same)",
                          cml_cluster_rank());
    if (first != mine) free(first);
    free(mine);
    return cml_cluster_agree(status, err);
}

/* Flies the runs of a file. The bytes of the input are needed only for the identity, and freed before the
 * run. */
static cml_status run_file(struct session *session, struct cml_inputs *inputs, struct cml_error *err)
{
    cml_status status = cml_cluster_agree(cml_identity_inputs(inputs, &session->inputs, err), err);
    if (status == CML_OK) status = check_runs(session, inputs, err);
    cml_inputs_clear(inputs);
    if (status == CML_OK) status = run_all(session, err);
    cml_outputs_release(&session->outputs);
    free(session->inputs);
    return status;
}

/* Runs `run`: checks options on all ranks, reads the scenes, and flies the runs of the file or the rows of a
 * sweep. */
cml_status cml_command_run(const struct cml_options *options, struct cml_error *err)
{
    struct cml_options mine = *options;
    CML_AT_END(cml_scene_list_clear) struct cml_scene_list list = {0};
    CML_AT_END(cml_inputs_clear) struct cml_inputs inputs = {0};
    struct session session = {.options = &mine, .list = &list};
    CML_TRY(cml_cluster_agree(check_options(&mine, err), err));
    CML_TRY(check_same(&mine, err));
    if (options->checkpoint_interval > 0) cml_stop_before_flight();
    mine.engine_options.threads = cml_choose_threads(options);
    mine.engine_options.local_rank = cml_cluster_local_rank();
    CML_TRY(cml_load_shared_scenes(options, &list, &inputs, err));
    for (int i = 0; i < list.count; i++) CML_TRY(cml_check_differentiated(&mine, &list.scenes[i], err));
    return options->sweep ? cml_sweep(&mine, &list, &inputs, err) : run_file(&session, &inputs, err);
}
