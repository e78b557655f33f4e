/* clustermcml plot: reads results and lets gnuplot draw them.
 * SPDX-License-Identifier: MIT */
#include "command.h"

#include "plot.h"

#include <stdlib.h>

static cml_status write_script(FILE *out, const void *what, struct cml_error *err)
{
    return cml_plot_script(out, what, err);
}

static cml_status read_results(const struct cml_options *options, struct cml_mco *results, int *count,
                               struct cml_error *err)
{
    for (*count = 0; *count < options->num_operands; (*count)++) {
        struct cml_mco *mco = &results[*count];
        CML_TRY(cml_mco_read(options->operands[*count], mco, err));
        if (mco->nr >= 3) continue;
        const int nr = mco->nr;
        cml_mco_clear(mco);
        return cml_fail(err, CML_E_INPUT, "%s: nr = %d (expected 3 or more bins for a curve over r)",
                        options->operands[*count], nr);
    }
    return CML_OK;
}

cml_status cml_command_plot(const struct cml_options *options, struct cml_error *err)
{
    const char *path = options->output ? options->output : "plot.svg";
    struct cml_plot plot = {.names = (const char *const *)options->operands};
    CML_TRY(cml_picture_of(path, &plot.picture, err));
    struct cml_mco *results = calloc((size_t)options->num_operands, sizeof *results);
    if (!results) return cml_fail_memory(err, (double)sizeof *results * options->num_operands, "the results");
    cml_status status = read_results(options, results, &plot.count, err);
    plot.results = results;
    if (status == CML_OK) status = cml_gnuplot_draw(write_script, &plot, path, err);
    if (status == CML_OK && !options->quiet) printf("%s\n", path);
    for (int i = 0; i < plot.count; i++) cml_mco_clear(&results[i]);
    free(results);
    return status;
}
