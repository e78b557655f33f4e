/* Pictures of sweeps: columns of their tables over each other; names of what is drawn.
 * SPDX-License-Identifier: MIT */
#include "cli/command.h"

#include "base/settings.h"
#include "plot/plot.h"
#include "plot/plot_map.h"
#include "plot/swept.h"
#include "result/quantity.h"

#include <stdlib.h>
#include <string.h>

enum { NAME = 512 };

const char *cml_plot_label(const struct cml_options *options, int i)
{
    if (i < options->num_labels) return options->labels[i];
    return cml_plot_name((const char *const *)options->operands, options->num_operands, i);
}

/* The name of an axis, with its unit where it has one. */
static void write_axis(const char *column, char text[CML_SWEPT_NAME])
{
    const char *unit = cml_setting_unit(column);
    if (strcmp(unit, "1") == 0)
        snprintf(text, CML_SWEPT_NAME, "%s", column);
    else
        snprintf(text, CML_SWEPT_NAME, "%.120s  [%s]", column, unit);
}

/* What a column of results is; "" of another. */
static const char *meaning_of(const char *column)
{
    for (int i = 0; i < CML_NUM_QUANTITIES; i++)
        if (strcmp(cml_quantities[i].name, column) == 0) return cml_quantities[i].long_name;
    return "";
}

/* ---- curves ---- */

/* All that the picture borrows. */
struct curves {
    struct cml_swept swept;
    struct cml_curve (*curve)[2]; /* [swept.count] */
    char (*name)[NAME];           /* [swept.count] */
    const char **names;           /* [swept.count] */
};

/* Which table it is of stands before its value, where there are several. */
static cml_status name_curves(const struct cml_options *options, const int *of_table, struct curves *c,
                              struct cml_error *err)
{
    const size_t count = (size_t)c->swept.count;
    c->curve = calloc(count, sizeof *c->curve);
    c->name = calloc(count, sizeof *c->name);
    c->names = calloc(count, sizeof *c->names);
    if (!c->curve || !c->name || !c->names) return cml_fail_memory(err, (double)(count * NAME), "the curves");
    for (int i = 0; i < c->swept.count; i++) {
        const char *value = c->swept.name[i], *table = cml_plot_label(options, of_table[i]);
        const bool several = options->num_operands > 1 || options->num_labels > 0 || !*value;
        c->curve[i][0] = c->swept.curve[i];
        snprintf(c->name[i], NAME, "%.300s%s%s", several ? table : "", several && *value ? ": " : "", value);
        c->names[i] = c->name[i];
    }
    return CML_OK;
}

static cml_status draw(const struct cml_options *options, const struct curves *c, enum cml_picture picture,
                       const char *path, struct cml_error *err)
{
    char over[CML_SWEPT_NAME], of[CML_SWEPT_NAME];
    const bool total = *meaning_of(c->swept.of);
    write_axis(c->swept.over, over);
    snprintf(of, sizeof of, "%.120s%s", c->swept.of, total ? "  [-]" : "");
    const struct cml_shown shown = {
        .num_panels = 1, .panel = {{CML_QUANTITY_Rd, CML_SHOWN_PLAIN, meaning_of(c->swept.of), of, NULL}}};
    const struct cml_plot plot = {.shown = &shown,
                                  .num_curves = c->swept.count,
                                  .curves = c->curve,
                                  .names = c->names,
                                  .over = over,
                                  .picture = picture,
                                  .style = options->style};
    return cml_gnuplot_draw(cml_plot_script, &plot, path, err);
}

/* All tables have the columns that the first one has chosen. */
static cml_status draw_curves(const struct cml_options *options, enum cml_picture picture, const char *path,
                              struct cml_error *err)
{
    struct curves c = {0};
    struct cml_swept_names names = {options->of, options->over, options->by};
    int of_table[CML_SWEPT_CURVES] = {0};
    cml_status status = CML_OK;
    for (int i = 0; i < options->num_operands && status == CML_OK; i++) {
        const int before = c.swept.count;
        status = cml_swept_add(options->operands[i], &names, &c.swept, err);
        names.of = c.swept.of;
        names.over = c.swept.over;
        for (int k = before; k < c.swept.count; k++) of_table[k] = i;
    }
    if (status == CML_OK) status = name_curves(options, of_table, &c, err);
    if (status == CML_OK) status = draw(options, &c, picture, path, err);
    cml_swept_clear(&c.swept);
    free(c.curve);
    free(c.name);
    free(c.names);
    return status;
}

/* ---- maps ---- */

/* One of each table, side by side: they must have the same values along both axes. */
static cml_status read_maps(const struct cml_options *options, const char *const over[2],
                            struct cml_pixels *maps, char ticks[2][CML_SWEPT_TICKS], struct cml_error *err)
{
    const struct cml_swept_names names = {options->of, NULL, NULL};
    char more[2][CML_SWEPT_TICKS];
    for (int i = 0; i < options->num_operands; i++) {
        CML_TRY(cml_swept_map(options->operands[i], &names, over, &maps[i], i ? more : ticks, err));
        for (int a = 0; i > 0 && a < 2; a++)
            if (strcmp(ticks[a], more[a]) != 0)
                return cml_fail(err, CML_E_INPUT, "%.200s: values of %s (expected those of %.200s)",
                                options->operands[i], over[a], options->operands[0]);
    }
    return CML_OK;
}

static cml_status draw_maps(const struct cml_options *options, const char *const over[2],
                            enum cml_picture picture, const char *path, struct cml_error *err)
{
    const int count = options->num_operands;
    const char *of = options->of ? options->of : "Rd";
    char ticks[2][CML_SWEPT_TICKS], axis[2][CML_SWEPT_NAME], quantity[CML_SWEPT_NAME];
    struct cml_pixels *maps = calloc((size_t)count, sizeof *maps);
    const char **names = calloc((size_t)count, sizeof *names);
    cml_status status = maps && names ? CML_OK : cml_fail_memory(err, 1, "the maps");
    for (int a = 0; a < 2; a++) write_axis(over[a], axis[a]);
    snprintf(quantity, sizeof quantity, "%.120s%s", of, *meaning_of(of) ? "  [-]" : "");
    const struct cml_map_axes axes = {{axis[0], axis[1]}, false, true, false, {ticks[0], ticks[1]}};
    const struct cml_map_plot plot = {.count = count,
                                      .maps = maps,
                                      .names = names,
                                      .quantity = quantity,
                                      .grey = "no row",
                                      .axes = &axes,
                                      .picture = picture,
                                      .style = options->style};
    for (int i = 0; i < count && status == CML_OK; i++) names[i] = cml_plot_label(options, i);
    if (status == CML_OK) status = read_maps(options, over, maps, ticks, err);
    if (status == CML_OK) status = cml_gnuplot_draw(cml_map_script, &plot, path, err);
    for (int i = 0; i < count && maps; i++) cml_pixels_clear(&maps[i]);
    free(maps);
    free(names);
    return status;
}

cml_status cml_plot_sweeps(const struct cml_options *options, enum cml_picture picture, const char *path,
                           struct cml_error *err)
{
    char over[CML_SWEPT_NAME] = "";
    const char *comma = options->over ? strchr(options->over, ',') : NULL;
    if (!comma) return draw_curves(options, picture, path, err);
    snprintf(over, sizeof over, "%.*s", (int)(comma - options->over), options->over);
    if (options->by) return cml_fail(err, CML_E_INPUT, "--by (expected without two columns of --over)");
    return draw_maps(options, (const char *const[]){over, comma + 1}, picture, path, err);
}
