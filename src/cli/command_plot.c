/* clustermcml plot: reads results, curves of others or maps and lets gnuplot draw them.
 * SPDX-License-Identifier: MIT */
#include "cli/command.h"
#include "cli/run/outputs.h"

#include "base/text.h"
#include "plot/files/map_h5.h"
#include "plot/plot.h"
#include "plot/plot_map.h"
#include "result/h5.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What the operands are drawn as. */
enum kind { CURVES, GRIDS, MAPS, SWEEPS };

/* The path of the picture: of `plot`, --output is that, not a folder. */
static const char *picture_path(const struct cml_options *options)
{
    return options->output ? options->output : "plot.svg";
}

static bool is_curve(const char *path)
{
    return cml_file_ends_in(path, ".csv");
}

static bool is_sweep(const char *path)
{
    static const char ending[] = ".sweep.csv";
    const size_t length = strlen(path);
    return length >= strlen(ending) && strcmp(path + length - strlen(ending), ending) == 0;
}

/* ---- curves ---- */

/* All that a plot of curves borrows. */
struct curves {
    struct cml_plot plot;
    struct cml_outcome *results;
    struct cml_curve (*others)[2];
    const char **paths, **names;
};

/* Two bins, of which the last is not drawn, make no curve. */
static cml_status read_result(const char *path, struct cml_outcome *outcome, struct cml_error *err)
{
    CML_TRY(cml_result_read(path, outcome, err));
    if (outcome->nr >= 3) return CML_OK;
    const int nr = outcome->nr;
    cml_outcome_clear(outcome);
    return cml_fail(err, CML_E_INPUT, "%s: nr = %d (expected 3 or more bins for a curve over r)", path, nr);
}

/* Results first, then curves of others; the numbers in the plot are those that have been read. */
static cml_status read_all(const struct cml_options *options, struct curves *c, struct cml_error *err)
{
    const struct cml_shown *shown = c->plot.shown;
    struct cml_curve_columns columns[2];
    int count = 0;
    for (int i = 0; i < shown->num_panels; i++) columns[i] = cml_shown_columns(&shown->panel[i]);
    for (int curves = 0; curves < 2; curves++)
        for (int i = 0; i < options->num_operands; i++) {
            const char *path = options->operands[i];
            if (is_curve(path) != (curves == 1)) continue;
            c->paths[count] = path;
            c->names[count++] = cml_plot_label(options, i);
            if (curves == 0) {
                CML_TRY(read_result(path, &c->results[c->plot.num_results], err));
                c->plot.num_results++;
            } else {
                CML_TRY(cml_curve_read(path, columns, shown->num_panels, c->others[c->plot.num_curves], err));
                c->plot.num_curves++;
            }
        }
    return CML_OK;
}

/* Gates of a detector, under its name: *shown is one of any; axis: [64] room for its words. */
static void name_gates(const char *of, struct cml_shown *shown, char axis[64])
{
    if (shown->panel[0].quantity != CML_QUANTITY_detector_t) return;
    snprintf(axis, 64, "%.40s  [%s]", of, shown->panel[0].axis);
    shown->panel[0].axis = axis;
    shown->panel[0].detector = of;
}

static cml_status draw_curves(const struct cml_options *options, const struct cml_shown *kind,
                              enum cml_picture picture, struct cml_error *err)
{
    const size_t count = (size_t)options->num_operands;
    char axis[64];
    struct cml_shown own = *kind;
    const struct cml_shown *shown = &own;
    name_gates(options->of, &own, axis);
    struct curves c = {.plot = {.shown = shown, .picture = picture, .style = options->style},
                       .results = calloc(count, sizeof *c.results),
                       .others = calloc(count, sizeof *c.others),
                       .paths = calloc(count, sizeof *c.paths),
                       .names = calloc(count, sizeof *c.names)};
    cml_status status =
        c.results && c.others && c.paths && c.names ? CML_OK : cml_fail_memory(err, 1, "the results");
    if (status == CML_OK) status = read_all(options, &c, err);
    c.plot.results = c.results;
    c.plot.curves = c.others;
    c.plot.paths = c.paths;
    c.plot.names = c.names;
    if (status == CML_OK) status = cml_gnuplot_draw(cml_plot_script, &c.plot, picture_path(options), err);
    for (int i = 0; i < c.plot.num_results; i++) cml_outcome_clear(&c.results[i]);
    for (int i = 0; i < 2 * c.plot.num_curves; i++) cml_curve_free(&c.others[i / 2][i % 2]);
    free(c.results);
    free(c.others);
    free(c.paths);
    free(c.names);
    return status;
}

/* ---- maps ---- */

/* Room for what stands beside the colours. */
enum { QUANTITY = 160 };

/* Reflectance and transmittance have short names here; every other array is called as in the file. */
static const char *array_of(const char *of)
{
    if (!of || strcmp(of, "Rd") == 0) return "Rd_xy";
    return strcmp(of, "Tt") == 0 ? "Tt_xy" : of;
}

static bool is_volume(const struct cml_options *options)
{
    return options->of && cml_hdf5_is_volume(options->of);
}

/* Through the axis, unless another is asked for. */
static struct cml_voxel_cut cut_of(const struct cml_options *options)
{
    const char axis = options->cut_axis;
    return axis ? (struct cml_voxel_cut){axis, options->cut_at} : (struct cml_voxel_cut){'y', 0};
}

/* How what is no result over (r, z) lies. */
static const struct cml_map_axes *axes_of(const struct cml_options *options)
{
    const char across = is_volume(options) ? cut_of(options).axis : 'z';
    return across == 'x' ? &cml_map_yz : across == 'y' ? &cml_map_xz : &cml_map_xy;
}

/* The map of one operand, and what stands beside its colours. */
static cml_status read_map(const struct cml_options *options, const char *path, const struct cml_shown *shown,
                           struct cml_pixels *map, char quantity[QUANTITY], struct cml_error *err)
{
    const char *of = options->of, *array = array_of(of);
    const struct cml_voxel_cut cut = cut_of(options);
    char unit[CML_HDF5_UNIT], names[CML_SHOWN_NAMES];
    struct cml_outcome outcome;
    if (shown) {
        snprintf(quantity, QUANTITY, "%s", shown->map);
        CML_TRY(cml_result_read(path, &outcome, err));
        const cml_status status = cml_shown_map(&outcome, path, shown, map, err);
        cml_outcome_clear(&outcome);
        return status;
    }
    cml_shown_names(names);
    CML_TRY(cml_hdf5_read_map(path, array, &cut, names, map, unit, err));
    if (array != of)
        snprintf(quantity, QUANTITY, "%.2s(x,y)  [1/cm²]", array);
    else
        snprintf(quantity, QUANTITY, "%.100s  [%s]", of, strcmp(unit, "1/cm2") == 0 ? "1/cm²" : unit);
    const size_t used = strlen(quantity);
    if (is_volume(options)) snprintf(quantity + used, QUANTITY - used, ", %c = %g cm", cut.axis, cut.at);
    return CML_OK;
}

/* shown: a grid of results over (r, z); NULL: arrays of maps. Maps that were not read are zero, and clearing
 * them does nothing. */
static cml_status draw_maps(const struct cml_options *options, const struct cml_shown *shown,
                            enum cml_picture picture, struct cml_error *err)
{
    const int count = options->num_operands;
    const bool fluence = shown && shown->panel[0].as == CML_SHOWN_OVER_MUA;
    char quantity[QUANTITY] = "";
    struct cml_pixels *maps = calloc((size_t)count, sizeof *maps);
    const char **names = calloc((size_t)count, sizeof *names);
    const struct cml_map_plot plot = {.count = count,
                                      .maps = maps,
                                      .names = names,
                                      .quantity = quantity,
                                      .grey =
                                          fluence ? "no light, nothing absorbs, or two media" : "no light",
                                      .axes = !shown         ? axes_of(options)
                                              : shown->polar ? &cml_map_polar
                                                             : &cml_map_rz,
                                      .picture = picture,
                                      .style = options->style};
    cml_status status = maps && names ? CML_OK : cml_fail_memory(err, 1, "the maps");
    for (int i = 0; i < count && status == CML_OK; i++) {
        names[i] = cml_plot_label(options, i);
        status = read_map(options, options->operands[i], shown, &maps[i], quantity, err);
    }
    if (status == CML_OK) status = cml_gnuplot_draw(cml_map_script, &plot, picture_path(options), err);
    for (int i = 0; i < count && maps; i++) cml_pixels_clear(&maps[i]);
    free(maps);
    free(names);
    return status;
}

/* ---- what is asked for ---- */

/* Whether an operand can be drawn beside the first, which says what all are. */
static cml_status check_operand(const struct cml_options *options, int i, enum kind kind,
                                struct cml_error *err)
{
    const char *path = options->operands[i], *first = options->operands[0];
    if (cml_file_ends_in(path, ".vti"))
        return cml_fail(err, CML_E_INPUT, "%s (expected the .h5 beside it, which has the same map, and --of)",
                        path);
    if (kind == SWEEPS || is_sweep(path))
        return kind == SWEEPS && is_sweep(path)
                   ? CML_OK
                   : cml_fail(err, CML_E_INPUT, "%s (expected %s, like %s)", path,
                              kind == SWEEPS ? "the table of a sweep" : "no table of a sweep", first);
    if (kind == MAPS ? cml_file_ends_in(path, ".h5") : kind == CURVES || !is_curve(path)) return CML_OK;
    if (kind == GRIDS)
        return cml_fail(err, CML_E_INPUT, "%s (expected a result, for --of %s)", path, options->of);
    return cml_fail(err, CML_E_INPUT, "%s (expected %s, like %s)", path,
                    kind == MAPS ? "a map" : "a result or a curve", first);
}

/* .sweep.csv files are sweeps, other .csv files curves; what .mco and .h5 files are, --of says: what it does
 * not know of results can only be an array of a map. */
static cml_status find_kind(const struct cml_options *options, enum kind *kind,
                            const struct cml_shown **shown, struct cml_error *err)
{
    const char *first = options->operands[0];
    const cml_status known = cml_shown_find(options->of, shown, err);
    if (is_sweep(first))
        *kind = SWEEPS;
    else if (known != CML_OK && (cml_file_ends_in(first, ".h5") || cml_file_ends_in(first, ".vti")))
        *kind = MAPS;
    else if (known != CML_OK)
        return known;
    else
        *kind = (*shown)->map ? GRIDS : CURVES;
    for (int i = 0; i < options->num_operands; i++) CML_TRY(check_operand(options, i, *kind, err));
    return CML_OK;
}

/* A range that would not be used, or cannot be, is refused. */
static cml_status check_style(const struct cml_options *options, enum kind kind, struct cml_error *err)
{
    const struct cml_plot_style *style = &options->style;
    const bool swept = kind == SWEEPS,
               curves = kind == CURVES || (swept && !(options->over && strchr(options->over, ',')));
    const struct cml_axis_range *logged = curves ? &style->y : &style->colour;
    const bool log = style->scale == CML_SCALE_LOG || (kind == CURVES && style->scale != CML_SCALE_LINEAR);
    const bool coloured = !isnan(style->colour.from) || !isnan(style->colour.to);
    if (options->num_labels > 0 && options->num_labels != options->num_operands)
        return cml_fail(err, CML_E_INPUT, "--label given %d times (expected once for each of %d files)",
                        options->num_labels, options->num_operands);
    if (!swept && (options->over || options->by))
        return cml_fail(err, CML_E_INPUT, "--%s (expected with the table of a sweep, NAME.sweep.csv)",
                        options->over ? "over" : "by");
    if (options->cut_axis && !(kind == MAPS && is_volume(options)))
        return cml_fail(err, CML_E_INPUT, "--cut (expected with --of A_xyz or phi_xyz of an .h5)");
    if (curves && (coloured || style->percentile < 100))
        return cml_fail(err, CML_E_INPUT, "--%s (expected with maps only)",
                        coloured ? "crange" : "percentile");
    if (!curves && style->log_x) return cml_fail(err, CML_E_INPUT, "--logx (expected with curves only)");
    if (coloured && style->percentile < 100)
        return cml_fail(err, CML_E_INPUT, "--percentile (expected without --crange)");
    if (log && (logged->from <= 0 || logged->to <= 0))
        return cml_fail(err, CML_E_INPUT, "--%srange (expected numbers above 0 on a log scale, or --linear)",
                        curves ? "y" : "c");
    return CML_OK;
}

/* Everything that can be wrong with the command line is found before a file is read. */
cml_status cml_command_plot(const struct cml_options *options, struct cml_error *err)
{
    enum cml_picture picture;
    enum kind kind;
    const struct cml_shown *shown = NULL;
    CML_TRY(cml_picture_of(picture_path(options), &picture, err));
    CML_TRY(
        cml_check_overwrite("plot", picture_path(options), options->operands, options->num_operands, err));
    CML_TRY(find_kind(options, &kind, &shown, err));
    CML_TRY(check_style(options, kind, err));
    CML_TRY(kind == SWEEPS   ? cml_plot_sweeps(options, picture, picture_path(options), err)
            : kind == CURVES ? draw_curves(options, shown, picture, err)
                             : draw_maps(options, kind == GRIDS ? shown : NULL, picture, err));
    if (!options->quiet) printf("%s\n", picture_path(options));
    return CML_OK;
}
