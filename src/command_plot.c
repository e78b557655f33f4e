/* clustermcml plot: reads results and lets gnuplot draw them.
 * SPDX-License-Identifier: MIT */
#include "command.h"

#include "curve.h"
#include "plot.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

static cml_status write_script(FILE *out, const void *what, struct cml_error *err)
{
    return cml_plot_script(out, what, err);
}

static bool is_curve(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot && strcasecmp(dot, ".csv") == 0;
}

static cml_status read_one(const char *path, struct cml_mco *mco, struct cml_error *err)
{
    CML_TRY(is_curve(path) ? cml_curve_read(path, mco, err) : cml_mco_read(path, mco, err));
    if (mco->nr >= 3) return CML_OK;
    const int nr = mco->nr;
    cml_mco_clear(mco);
    return cml_fail(err, CML_E_INPUT, "%s: nr = %d (expected 3 or more bins for a curve over r)", path, nr);
}

/* Results first, then curves; names in the same order. */
static cml_status read_all(const struct cml_options *options, struct cml_mco *results, const char **names,
                           struct cml_plot *plot, struct cml_error *err)
{
    for (int curves = 0; curves < 2; curves++)
        for (int i = 0; i < options->num_operands; i++) {
            const char *path = options->operands[i];
            if (is_curve(path) != (curves == 1)) continue;
            CML_TRY(read_one(path, &results[plot->count], err));
            names[plot->count++] = path;
            plot->num_results += curves == 0;
        }
    return CML_OK;
}

cml_status cml_command_plot(const struct cml_options *options, struct cml_error *err)
{
    const char *path = options->output ? options->output : "plot.svg";
    const size_t count = (size_t)options->num_operands;
    struct cml_plot plot = {.caption = options->caption};
    CML_TRY(cml_picture_of(path, &plot.picture, err));
    struct cml_mco *results = calloc(count, sizeof *results);
    const char **names = calloc(count, sizeof *names);
    cml_status status = results && names ? CML_OK : cml_fail_memory(err, 1, "the results");
    if (status == CML_OK) status = read_all(options, results, names, &plot, err);
    plot.results = results;
    plot.names = names;
    if (status == CML_OK) status = cml_gnuplot_draw(write_script, &plot, path, err);
    if (status == CML_OK && !options->quiet) printf("%s\n", path);
    for (int i = 0; i < plot.count; i++) cml_mco_clear(&results[i]);
    free(results);
    free(names);
    return status;
}
