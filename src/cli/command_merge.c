/* clustermcml merge: joins the parts of a run, or of all runs of one call. It repeats the call of the parts,
 * with the sums of the parts in place of flights. SPDX-License-Identifier: MIT */
#include "cli/command.h"

#include "base/array.h"
#include "base/text.h"
#include "cli/options/options_parse.h"
#include "run/cluster/cluster.h"
#include "run/join.h"

#include <stdlib.h>
#include <string.h>

/* Splits a call into its words, each of which ends with a line feed. The caller frees *word; the text of the
 * call is cut. */
static cml_status split(char *call, char ***word, int *count, struct cml_error *err)
{
    *word = NULL;
    for (*count = 0; *call; (*count)++) {
        char *const end = strchr(call, '\n');
        CML_TRY(cml_array_grow(word, (size_t)*count, sizeof **word, "the words of a part's call", err));
        (*word)[*count] = call;
        if (!end) break;
        *end = '\0';
        call = end + 1;
    }
    return CML_OK;
}

/* Takes options of `merge` into the call of the parts: the folder of the results, and the output on the
 * terminal. */
static void add_own(const struct cml_options *mine, const char *scene, struct cml_options *call)
{
    call->joined = mine->joined;
    call->checkpoint_interval = 0;
    call->quiet = call->quiet || mine->quiet;
    call->json = mine->json;
    call->keep = call->keep || mine->keep;
    call->no_clobber = call->no_clobber || mine->no_clobber;
    call->engine_options.on_note = mine->engine_options.on_note;
    if (mine->directory) call->directory = mine->directory;
    if (scene) call->operands[0] = (char *)scene;
}

/* Runs the parts' own command line on rank 0 alone, with their sums in place of a flight. */
static cml_status run(const struct cml_options *call, struct cml_error *err)
{
    cml_cluster_alone(true);
    const cml_status status = cml_command_run(call, err);
    cml_cluster_alone(false);
    return status;
}

/* Refuses a scene file of another name: the name is in the results, so it would change their bytes. */
static cml_status check_scene(const char *scene, const char *flown, struct cml_error *err)
{
    const char *slash = strrchr(flown, '/'), *theirs = slash ? slash + 1 : flown;
    if (!scene) return CML_OK;
    slash = strrchr(scene, '/');
    if (strcmp(slash ? slash + 1 : scene, theirs) == 0) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "merge: %s (expected the scene file of the parts, named %s)", scene,
                    theirs);
}

/* Joins parts: repeats the command line that the parts were flown with, with their sums in place of flights.
 * Options of `merge` itself, such as --output, take precedence. */
static cml_status join(const struct cml_options *options, const char *scene, struct cml_part_files *files,
                       struct cml_error *err)
{
    CML_FREED char **word = NULL;
    struct cml_options mine = *options, call;
    int count;
    CML_TRY(split(files->file[0].call, &word, &count, err));
    const cml_status status = cml_options_parse(count, word, &call, err);
    if (status != CML_OK || call.which != CML_COMMAND_RUN)
        return cml_fail(err, CML_E_INPUT,
                        "%s: the options in the part are unknown (expected a part that this version wrote)",
                        files->file[0].path);
    CML_TRY(check_scene(scene, call.operands[0], err));
    mine.joined = files;
    add_own(&mine, scene, &call);
    return run(&call, err);
}

/* Runs `merge`: joins the files of parts to one result. The first word may be the scene file of the parts,
 * for which the parts' own command line otherwise names the path. */
cml_status cml_command_merge(const struct cml_options *options, struct cml_error *err)
{
    const bool has_scene = cml_file_ends_in(options->operands[0], ".mci");
    CML_AT_END(cml_part_files_clear) struct cml_part_files files = {0};
    CML_TRY(
        cml_part_files_read(options->operands + has_scene, options->num_operands - has_scene, &files, err));
    return join(options, has_scene ? options->operands[0] : NULL, &files, err);
}
