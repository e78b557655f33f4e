/* clustermcml plot: reads results or maps and lets gnuplot draw them.
 * SPDX-License-Identifier: MIT */
#include "cli/command.h"
#include "cli/outputs.h"

#include "plot/curve.h"
#include "plot/plot.h"
#include "plot/plot_map.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* In capitals, too, as files come from other systems. */
static bool ends_in(const char *path, const char *extension)
{
    const char *dot = strrchr(path, '.');
    return dot && strcasecmp(dot, extension) == 0;
}

/* Operands are told apart by their ending. */
static bool is_curve(const char *path)
{
    return ends_in(path, ".csv");
}

static bool is_map(const char *path)
{
    return ends_in(path, ".vti");
}

/* For plot --output is the picture, not a folder. */
static const char *picture_path(const struct cml_options *options)
{
    return options->output ? options->output : "plot.svg";
}

/* ---- curves over r ---- */

/* Curves and results become the same structure; two bins, of which the last is not drawn, make no curve. */
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

/* plot.count is the number read so far, so that only those are cleared after a failure. */
static cml_status draw_curves(const struct cml_options *options, enum cml_picture picture,
                              struct cml_error *err)
{
    const size_t count = (size_t)options->num_operands;
    struct cml_plot plot = {.caption = options->caption, .picture = picture, .scale = options->scale};
    struct cml_mco *results = calloc(count, sizeof *results);
    const char **names = calloc(count, sizeof *names);
    cml_status status = results && names ? CML_OK : cml_fail_memory(err, 1, "the results");
    if (status == CML_OK) status = read_all(options, results, names, &plot, err);
    plot.results = results;
    plot.names = names;
    if (status == CML_OK) status = cml_gnuplot_draw(cml_plot_script, &plot, picture_path(options), err);
    for (int i = 0; i < plot.count; i++) cml_mco_clear(&results[i]);
    free(results);
    free(names);
    return status;
}

/* ---- maps ---- */

/* Reflectance and transmittance have short names here; every other array is called as in the file. */
static const char *array_of(const char *of, const char **quantity)
{
    const bool top = !of || strcmp(of, "Rd") == 0, bottom = !top && strcmp(of, "Tt") == 0;
    *quantity = top ? "Rd(x,y)  [1/cm²]" : bottom ? "Tt(x,y)  [1/cm²]" : of;
    return top ? "Rd_xy" : bottom ? "Tt_xy" : of;
}

/* Maps that were not read are zero, and clearing them does nothing. */
static cml_status draw_maps(const struct cml_options *options, enum cml_picture picture,
                            struct cml_error *err)
{
    const int count = options->num_operands;
    struct cml_pixels *maps = calloc((size_t)count, sizeof *maps);
    struct cml_map_plot plot = {.count = count,
                                .maps = maps,
                                .names = (const char *const *)options->operands,
                                .caption = options->caption,
                                .picture = picture,
                                .scale = options->scale};
    const char *array = array_of(options->of, &plot.quantity);
    cml_status status = maps ? CML_OK : cml_fail_memory(err, 1, "the maps");
    for (int i = 0; i < count && status == CML_OK; i++)
        status = cml_vti_read(options->operands[i], array, &maps[i], err);
    if (status == CML_OK) status = cml_gnuplot_draw(cml_map_script, &plot, picture_path(options), err);
    for (int i = 0; i < count && maps; i++) cml_pixels_clear(&maps[i]);
    free(maps);
    return status;
}

/* Whether the operands are maps: all or none. */
static cml_status find_kind(const struct cml_options *options, bool *maps, struct cml_error *err)
{
    *maps = is_map(options->operands[0]);
    for (int i = 1; i < options->num_operands; i++)
        if (is_map(options->operands[i]) != *maps)
            return cml_fail(err, CML_E_INPUT, "%s (expected %s, like %s)", options->operands[i],
                            *maps ? "a map" : "a result or a curve", options->operands[0]);
    if (*maps || !options->of) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "--of %s (expected with maps only: .vti files)", options->of);
}

/* Everything that can be wrong with the command line is found before a file is read. */
cml_status cml_command_plot(const struct cml_options *options, struct cml_error *err)
{
    enum cml_picture picture;
    bool maps = false;
    CML_TRY(cml_picture_of(picture_path(options), &picture, err));
    CML_TRY(
        cml_check_overwrite("plot", picture_path(options), options->operands, options->num_operands, err));
    CML_TRY(find_kind(options, &maps, err));
    CML_TRY((maps ? draw_maps : draw_curves)(options, picture, err));
    if (!options->quiet) printf("%s\n", picture_path(options));
    return CML_OK;
}
