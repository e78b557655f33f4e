/* SPDX-License-Identifier: MIT */
#include "plot/plot_map.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* viridis (van der Walt and Smith, CC0) at ten places: even steps for the eye, also in grey and for the
 * colour blind. */
static const char palette[] =
    "set palette defined (0 '#440154', 1 '#482878', 2 '#3E4989', 3 '#31688E', 4 '#26828E', 5 '#1F9E89', "
    "6 '#35B779', 7 '#6ECE58', 8 '#B5DE2B', 9 '#FDE725')\n";

const struct cml_map_axes cml_map_xy = {{"x [cm]", "y [cm]"}, false, false, false, {NULL, NULL}};
const struct cml_map_axes cml_map_xz = {{"x [cm]", "depth z [cm]"}, true, false, false, {NULL, NULL}};
const struct cml_map_axes cml_map_yz = {{"y [cm]", "depth z [cm]"}, true, false, false, {NULL, NULL}};
const struct cml_map_axes cml_map_rz = {{"radius r [cm]", "depth z [cm]"}, true, true, false, {NULL, NULL}};
static const char every_30[] = "'-90' -90, '-60' -60, '-30' -30, '0' 0, '30' 30, '60' 60, '90' 90";
const struct cml_map_axes cml_map_polar = {
    {"θ cos φ [degree]", "θ sin φ [degree]"}, false, false, true, {every_30, every_30}};

/* Lengths in points of the page. TITLE_* are middles of axis titles, from a panel's left and bottom; BAR_*
 * are the colour bar's distance, width and its title's distance. */
enum {
    LEFT = 84,
    RIGHT = 134,
    GAP = 80,
    HEAD = 40,
    TITLE = 30,
    FOOT = 78,
    TALLEST = 560,
    LETTER = 9,
    TICKS = 75,
    TITLE_LEFT = 64,
    TITLE_BELOW = 48,
    BAR_GAP = 22,
    BAR = 18,
    BAR_TITLE = 92
};

/* gnuplot's labels. */
enum { LABEL_TITLE = 1, LABEL_NAME, LABEL_NOTE, LABEL_GREY, LABEL_COLOURS, LABEL_X, LABEL_Y };

/* Numbers along a side of an image: more than the first are averaged, fewer than the second repeated, because
 * viewers blur what they magnify. */
enum { MOST_CELLS = 1000, FEWEST_CELLS = 300 };

struct drawing {
    struct cml_page page;
    const struct cml_map_plot *plot;
    bool log, dark;        /* dark: some pixel has no light */
    bool unknown;          /* some pixel has no value */
    double low, high;      /* range of the colours; high = 0: no light at all */
    double from[2], to[2]; /* cm, of all panels */
    int columns, rows, width, panel_height, left, head, foot;
};

/* ---- cells ---- */

/* How an axis of pixels becomes one of numbers: `join` pixels to a cell, a cell `repeat` times. */
struct axis {
    size_t join, cells, repeat;
    double step; /* cm from number to number */
};

/* Whole pixels are joined, so a cell is a mean of pixels and never a part of one. */
static struct axis axis_of(const struct cml_pixels *map, int axis)
{
    const size_t n = map->n[axis], join = (n + MOST_CELLS - 1) / MOST_CELLS, cells = (n + join - 1) / join;
    const size_t repeat = cells < FEWEST_CELLS ? (FEWEST_CELLS + cells - 1) / cells : 1;
    return (struct axis){join, cells, repeat, map->spacing[axis] * (double)join / (double)repeat};
}

/* Mean of the pixels of a cell; the last cell of an axis may have fewer. */
static double cell_value(const struct cml_pixels *map, const struct axis axis[2], size_t x, size_t y)
{
    const size_t begin[2] = {x * axis[0].join, y * axis[1].join};
    double sum = 0;
    size_t count = 0;
    for (size_t j = begin[1]; j < begin[1] + axis[1].join && j < map->n[1]; j++)
        for (size_t i = begin[0]; i < begin[0] + axis[0].join && i < map->n[0]; i++, count++)
            sum += (double)map->value[j * map->n[0] + i];
    return sum / (double)count;
}

/* ---- ranges ---- */

/* For qsort; the values are finite. */
static int by_size(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* All cells above 0, sorted; the caller frees them. */
static cml_status lit_values(struct drawing *d, float **values, size_t *count, struct cml_error *err)
{
    size_t capacity = 0, outside = 0;
    for (int k = 0; k < d->plot->count; k++)
        capacity += axis_of(&d->plot->maps[k], 0).cells * axis_of(&d->plot->maps[k], 1).cells;
    *count = 0;
    *values = malloc(capacity * sizeof **values);
    if (!*values) return cml_fail_memory(err, (double)(capacity * sizeof **values), "the plot");
    for (int k = 0; k < d->plot->count; k++) {
        const struct cml_pixels *map = &d->plot->maps[k];
        const struct axis axis[2] = {axis_of(map, 0), axis_of(map, 1)};
        for (size_t i = 0; i < axis[0].cells * axis[1].cells; i++) {
            const float value = (float)cell_value(map, axis, i % axis[0].cells, i / axis[0].cells);
            if (value > 0) (*values)[(*count)++] = value;
            d->unknown = d->unknown || isnan(value);
            outside += value < 0;
        }
    }
    d->dark = *count + outside < capacity;
    qsort(*values, *count, sizeof **values, by_size);
    return CML_OK;
}

/* Number of the value at this percentile of `count`. */
static size_t rank_of(double percentile, size_t count)
{
    const double rank = ceil(percentile / 100 * (double)count);
    return rank > 1 ? (size_t)rank - 1 : 0;
}

/* From the faintest hundredth of the lit cells, which single packets make, to the brightest, or to the
 * percentile that leaves out hot pixels. */
static cml_status find_colours(struct drawing *d, struct cml_error *err)
{
    const struct cml_plot_style *style = &d->plot->style;
    const double large = 100, decades = 1e8;
    float *values = NULL;
    size_t count = 0;
    CML_TRY(lit_values(d, &values, &count, err));
    if (count > 0) {
        d->high = (double)values[rank_of(style->percentile, count)];
        d->low = fmax((double)values[count / 100], d->high / decades);
    }
    free(values);
    d->log = style->scale == CML_SCALE_LOG ||
             (style->scale == CML_SCALE_AUTO && d->high > large * d->low && !(style->colour.from <= 0));
    if (!d->log)
        d->low = 0;
    else if (d->low > 0.5 * d->high)
        d->low = 0.5 * d->high;
    return d->high > 0 ? cml_axis_range_apply(&style->colour, "--crange", &d->low, &d->high, err) : CML_OK;
}

/* The least piece of the plane that has all maps. */
static cml_status find_extent(struct drawing *d, struct cml_error *err)
{
    for (int axis = 0; axis < 2; axis++) {
        d->from[axis] = INFINITY;
        d->to[axis] = -INFINITY;
        for (int k = 0; k < d->plot->count; k++) {
            const struct cml_pixels *map = &d->plot->maps[k];
            const double end = map->origin[axis] + (double)map->n[axis] * map->spacing[axis];
            d->from[axis] = fmin(d->from[axis], map->origin[axis]);
            d->to[axis] = fmax(d->to[axis], end);
        }
    }
    CML_TRY(cml_axis_range_within(&d->plot->style.x, "--xrange", &d->from[0], &d->to[0], err));
    return cml_axis_range_within(&d->plot->style.y, "--yrange", &d->from[1], &d->to[1], err);
}

/* Very long panels get more of the plane than there is map. */
static void add_margins(struct drawing *d)
{
    const double longest = 4;
    const double size[2] = {d->to[0] - d->from[0], d->to[1] - d->from[1]};
    for (int axis = 0; axis < 2; axis++) {
        const double more = size[1 - axis] / longest - size[axis];
        if (more <= 0) continue;
        d->from[axis] -= more / 2;
        d->to[axis] += more / 2;
    }
}

/* Panels side by side as long as they are not too narrow: three in a row, two by two for four. A centimetre
 * is as long in each, and on both axes, where these are lengths in space. */
static void lay_out(struct drawing *d)
{
    const double free_ratio = 0.7;
    const int count = d->plot->count;
    if (!d->plot->axes->free) add_margins(d);
    const double ratio = d->plot->axes->free ? free_ratio : (d->to[1] - d->from[1]) / (d->to[0] - d->from[0]);
    d->columns = count <= 3 ? count : count == 4 ? 2 : 3;
    d->rows = (count + d->columns - 1) / d->columns;
    const int room = (CML_PAGE_WIDTH - LEFT - RIGHT - GAP * (d->columns - 1)) / d->columns;
    d->panel_height = (int)fmin(TALLEST, room * ratio);
    d->width = (int)(d->panel_height / ratio);
    d->left = LEFT + (room - d->width) * d->columns / 2;
    d->head = d->plot->style.title ? TITLE : 0;
    d->foot = FOOT + cml_plot_caption(NULL, d->plot->style.caption, 0);
    d->page.height = d->head + d->rows * (HEAD + d->panel_height) + (d->rows - 1) * GAP + d->foot;
}

/* ---- data ---- */

/* Writes a row of pixels; those without a value gnuplot leaves empty, and the grey below shows. */
static void write_row(const struct drawing *d, const struct cml_pixels *map, const struct axis axis[2],
                      size_t y)
{
    for (size_t x = 0; x < axis[0].cells; x++) {
        const double value = cell_value(map, axis, x, y);
        char word[32] = "NaN";
        if (value > 0 || (value == 0 && !d->log)) snprintf(word, sizeof word, "%.5g", value);
        for (size_t i = 0; i < axis[0].repeat; i++) fprintf(d->page.out, "%s ", word);
    }
    fputc('\n', d->page.out);
}

/* `with image` paints cells by their middles, which therefore begin half a step from the corner. */
static void write_map(const struct drawing *d, int k)
{
    const struct cml_pixels *map = &d->plot->maps[k];
    const struct axis axis[2] = {axis_of(map, 0), axis_of(map, 1)};
    fprintf(d->page.out, "$map%d << EOD\n", k);
    for (size_t y = 0; y < axis[1].cells; y++)
        for (size_t i = 0; i < axis[1].repeat; i++) write_row(d, map, axis, y);
    fprintf(d->page.out,
            "EOD\nplot $map%d matrix using (%.9g + $1 * %.9g):(%.9g + $2 * %.9g):3 with image notitle\n", k,
            map->origin[0] + axis[0].step / 2, axis[0].step, map->origin[1] + axis[1].step / 2, axis[1].step);
}

/* ---- the picture ---- */

/* One bar for all panels, beside them, over their whole height. */
static void write_colours(const struct drawing *d)
{
    const double bar_height = d->page.height - d->head - d->foot - HEAD,
                 left = d->left + d->columns * (d->width + GAP) - GAP + BAR_GAP;
    char grey[64];
    fputs(palette, d->page.out);
    if (d->high > 0)
        fprintf(d->page.out, "%sset cbrange [%.6g:%.6g]\nset format cb '%%g'\n",
                d->log ? "set logscale cb\n" : "", d->low, d->high);
    if (d->log) cml_plot_log_ticks(d->page.out, "cbtics", d->low, d->high);
    fprintf(d->page.out,
            "set colorbox vertical user origin screen %.6f, screen %.6f size screen %.6f, screen %.6f\n",
            left / CML_PAGE_WIDTH, (double)d->foot / d->page.height, (double)BAR / CML_PAGE_WIDTH,
            bar_height / d->page.height);
    cml_page_write(&d->page, LABEL_COLOURS, left + BAR_TITLE, d->foot + bar_height / 2, CML_ALIGN_UPRIGHT,
                   CML_PAGE_NORMAL, d->plot->quantity);
    snprintf(grey, sizeof grey, "grey: %s", d->plot->grey);
    if ((d->log && d->dark) || d->unknown)
        cml_page_write(&d->page, LABEL_GREY, CML_PAGE_WIDTH - 12, d->foot - TITLE_BELOW, CML_ALIGN_RIGHT,
                       CML_PAGE_SMALL, grey);
}

/* Both axes have the same ticks where they have the same lengths, some TICKS points apart. */
static void write_axes(const struct drawing *d)
{
    const bool down = d->plot->axes->down, free = d->plot->axes->free;
    const double x_step = cml_plot_round_step((d->to[0] - d->from[0]) / d->width * TICKS);
    const double y_step =
        free ? cml_plot_round_step((d->to[1] - d->from[1]) / d->panel_height * TICKS) : x_step;
    fprintf(d->page.out,
            "unset grid\nset tics out nomirror scale 0.6\nset format x '%%g'\nset format y '%%g'\n"
            "set xrange [%.9g:%.9g]\nset yrange [%.9g:%.9g]\nset xtics %g\nset ytics %g\n",
            d->from[0], d->to[0], down ? d->to[1] : d->from[1], down ? d->from[1] : d->to[1], x_step, y_step);
    for (int axis = 0; axis < 2; axis++)
        if (d->plot->axes->ticks[axis])
            fprintf(d->page.out, "set %ctics (%s)\n", "xy"[axis], d -> plot -> axes -> ticks[axis]);
}

/* What all panels share. */
static void write_frame(const struct drawing *d)
{
    cml_page_begin(&d->page);
    fputs("set multiplot\n", d->page.out);
    write_axes(d);
    write_colours(d);
    if (d->plot->style.title)
        cml_page_write(&d->page, LABEL_TITLE, CML_PAGE_WIDTH / 2.0, d->page.height - 24, CML_ALIGN_CENTER,
                       CML_PAGE_LARGE, d->plot->style.title);
    (void)cml_plot_caption(&d->page, d->plot->style.caption, d->foot - FOOT);
}

/* Grey below the map: what has no colour shows it. Of directions with rings every 30 degrees above it. */
static void write_map_frame(const struct drawing *d, const struct cml_pixels *map)
{
    double end[2];
    for (int ring = 1; d->plot->axes->round && ring <= 3; ring++)
        fprintf(d->page.out,
                "set object %d circle at 0,0 size %d front clip fs empty border rgb '#FFFFFF' lw 0.6\n",
                1 + ring, 30 * ring);
    if (d->plot->axes->round) {
        fputs("set object 1 circle at 0,0 size 90 behind clip fc rgb '#D4D4D4' fs solid noborder\n",
              d->page.out);
        return;
    }
    for (int axis = 0; axis < 2; axis++)
        end[axis] = map->origin[axis] + (double)map->n[axis] * map->spacing[axis];
    fprintf(d->page.out,
            "set object 1 rectangle from %.9g,%.9g to %.9g,%.9g behind clip fc rgb '#D4D4D4' fs solid "
            "noborder\n",
            map->origin[0], map->origin[1], end[0], end[1]);
}

/* What stands once is forgotten behind the first panel. */
static void write_panel(const struct drawing *d, int k)
{
    const int column = k % d->columns, row = k / d->columns;
    const double left = d->left + column * (d->width + GAP), right = left + d->width;
    const double top = d->page.height - d->head - HEAD - row * (d->panel_height + HEAD + GAP),
                 bottom = top - d->panel_height;
    char name[CML_PLOT_NAME];
    cml_plot_cut(d->plot->names[k], (size_t)fmin(100, fmax(8, (d->width + GAP) / LETTER)), name);
    cml_page_panel(&d->page, left, right, bottom, top);
    write_map_frame(d, &d->plot->maps[k]);
    cml_page_write(&d->page, LABEL_NAME, left, top + 14, CML_ALIGN_LEFT, CML_PAGE_NORMAL, name);
    cml_page_write(&d->page, LABEL_X, (left + right) / 2, bottom - TITLE_BELOW, CML_ALIGN_CENTER,
                   CML_PAGE_NORMAL, d->plot->axes->name[0]);
    if (column == 0)
        cml_page_write(&d->page, LABEL_Y, left - TITLE_LEFT, (bottom + top) / 2, CML_ALIGN_UPRIGHT,
                       CML_PAGE_NORMAL, d->plot->axes->name[1]);
    if (d->high > 0) {
        write_map(d, k);
    } else {
        cml_page_write(&d->page, LABEL_NOTE, (left + right) / 2, (bottom + top) / 2, CML_ALIGN_CENTER,
                       CML_PAGE_NORMAL, "no light");
        fputs("plot NaN notitle\n", d->page.out);
    }
    fputs("unset colorbox\nunset label\n", d->page.out);
}

/* Colours and extent first: they are common to all panels. */
cml_status cml_map_script(FILE *out, const void *plot, struct cml_error *err)
{
    const struct cml_map_plot *map = plot;
    struct drawing d = {.page = {.out = out, .picture = map->picture, .width = CML_PAGE_WIDTH}, .plot = map};
    CML_TRY(find_colours(&d, err));
    CML_TRY(find_extent(&d, err));
    lay_out(&d);
    write_frame(&d);
    for (int k = 0; k < d.plot->count; k++) write_panel(&d, k);
    fputs("unset multiplot\n", out);
    return CML_OK;
}
