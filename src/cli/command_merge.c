/* clustermcml merge: results of one scene, flown with different seeds, as one.
 * SPDX-License-Identifier: MIT */
#include "cli/command.h"

#include "cli/load/scenes.h"
#include "cli/run/before.h"
#include "cli/run/outputs.h"
#include "output/report.h"
#include "output/study/merge.h"
#include "base/text.h"
#include "result/h5.h"
#include "result/mco.h"

#include <stdlib.h>
#include <string.h>

static const char *name_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static void print_summary(const struct cml_outcome *merged, const char *path, int count)
{
    printf("%d results, %llu photons\n", count, (unsigned long long)merged->photons);
    for (int i = 0; i < cml_merged_totals(merged); i++) {
        const enum cml_quantity total = cml_quantity_of_total(i);
        printf("  %-4s", cml_quantities[total].name);
        cml_report_estimate(stdout, merged->value[total][0], merged->error[total][0]);
        putchar('\n');
    }
    printf("  -> %s\n", path);
}

static cml_status write_merged(const struct cml_options *options, const struct cml_merge_input *inputs,
                               int count, const struct cml_outcome *merged, struct cml_error *err)
{
    const struct cml_hdf5_call call = {options->command, options->operands[0]};
    const char *path = options->output;
    if (cml_file_ends_in(path, ".mco") && !(merged->n_above > 0))
        return cml_fail(err, CML_E_INPUT,
                        "merge: -o %.200s (expected an .h5: none of the results says n of the media outside)",
                        path);
    CML_TRY(cml_file_ends_in(path, ".h5") ? cml_merge_write_h5(path, merged, inputs, count, &call, err)
                                          : cml_mco_write(path, merged, err));
    if (options->json) return cml_merge_json(stdout, path, inputs, count, merged, err);
    if (!options->quiet) print_summary(merged, path, count);
    return CML_OK;
}

/* What a mean over all packets cannot be had of. */
static cml_status note_left_out(const struct cml_merge_input *inputs, int count,
                                const struct cml_outcome *merged, struct cml_error *err)
{
    char *names, text[1024];
    CML_TRY(cml_merge_left_out(inputs, count, merged, &names, err));
    if (!names) return CML_OK;
    snprintf(text, sizeof text, "merge: left out what not all results have: %.900s", names);
    cml_show_note(NULL, text);
    free(names);
    return CML_OK;
}

static bool is_saved(const char *path)
{
    return cml_file_ends_in(path, ".photons.h5");
}

static cml_status merge_saved(const struct cml_options *options, const struct cml_merge_input *inputs,
                              int count, struct cml_error *err)
{
    const struct cml_hdf5_call call = {options->command, options->operands[0]};
    CML_AT_END(cml_outcome_clear) struct cml_outcome merged = {0};
    struct cml_merge_saved saved;
    CML_TRY(cml_merge_saved(options->output, inputs, count, &call, &merged, &saved, err));
    if (options->json)
        return cml_merge_saved_json(stdout, options->output, inputs, count, &merged, &saved, err);
    if (!options->quiet)
        printf("%d files, %.0f saved packets, none missing of %.0f of %llu photons\n  -> %s\n", count,
               saved.rows, saved.covers, (unsigned long long)merged.photons, options->output);
    return CML_OK;
}

static cml_status merge(const struct cml_options *options, const struct cml_merge_input *inputs, int count,
                        struct cml_error *err)
{
    CML_AT_END(cml_outcome_clear) struct cml_outcome merged = {0};
    if (is_saved(options->output)) return merge_saved(options, inputs, count, err);
    CML_TRY(cml_merge(inputs, count, name_of(options->output), &merged, err));
    CML_TRY(write_merged(options, inputs, count, &merged, err));
    return note_left_out(inputs, count, &merged, err);
}

static cml_status check_output(const struct cml_options *options, struct cml_error *err)
{
    if (!options->output)
        return cml_fail(err, CML_E_INPUT,
                        "merge: -o is missing (expected the name of the result, .mco or .h5)");
    if (!cml_file_ends_in(options->output, ".mco") && !cml_file_ends_in(options->output, ".h5"))
        return cml_fail(err, CML_E_INPUT, "merge: -o %.200s (expected a name that ends in .mco or .h5)",
                        options->output);
    for (int i = 0; i < options->num_operands; i++)
        if (is_saved(options->operands[i]) != is_saved(options->output))
            return cml_fail(err, CML_E_INPUT,
                            "merge: -o %.200s: %.200s (expected files of saved packets, NAME.photons.h5, and "
                            "such a name, or results)",
                            options->output, options->operands[i]);
    return cml_check_overwrite("merge", options->output, options->operands, options->num_operands, err);
}

/* All are in memory at a time. */
static cml_status read_and_merge(const struct cml_options *options, struct cml_error *err)
{
    const int count = options->num_operands;
    struct cml_outcome *outcomes = calloc((size_t)count, sizeof *outcomes);
    struct cml_merge_input *inputs = calloc((size_t)count, sizeof *inputs);
    cml_status status =
        outcomes && inputs ? CML_OK : cml_fail_memory(err, count * (double)sizeof *outcomes, "results");
    for (int i = 0; status == CML_OK && i < count; i++) {
        inputs[i] = (struct cml_merge_input){options->operands[i], &outcomes[i]};
        status = is_saved(options->operands[i]) ? cml_h5_read_head(options->operands[i], &outcomes[i], err)
                                                : cml_result_read(options->operands[i], &outcomes[i], err);
    }
    if (status == CML_OK) status = merge(options, inputs, count, err);
    for (int i = 0; outcomes && i < count; i++) cml_outcome_clear(&outcomes[i]);
    free(outcomes);
    free(inputs);
    return status;
}

cml_status cml_command_merge(const struct cml_options *options, struct cml_error *err)
{
    CML_AT_END(cml_outputs_release) struct cml_outputs outputs = {0};
    char replaced[CML_REPLACED];
    CML_TRY(check_output(options, err));
    CML_TRY(cml_output_claim(options->output, &outputs, err));
    const bool there = cml_describe_replaced(options->output, replaced);
    CML_TRY(read_and_merge(options, err));
    if (there && !options->quiet) cml_show_note(NULL, replaced);
    return CML_OK;
}
