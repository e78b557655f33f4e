/* SPDX-License-Identifier: MIT */
#include "plot/plot_map.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* viridis (van der Walt and Smith, CC0) at ten places: even steps for the eye, also in grey and for the
 * colour blind. */
static const char palette[] =
    "set palette defined (0 '#440154', 1 '#482878', 2 '#3E4989', 3 '#31688E', 4 '#26828E', 5 '#1F9E89', "
    "6 '#35B779', 7 '#6ECE58', 8 '#B5DE2B', 9 '#FDE725')\n";

/* Lengths in points of the SVG; the PNG has twice as many pixels. */
enum {
    WIDTH = 900,
    LEFT = 84,
    RIGHT = 130,
    GAP = 74,
    HEAD = 40,
    FOOT = 66,
    BAR = 18,
    TALLEST = 560,
    LETTER = 8,
    TICKS = 75,
    BAR_GAP = 22,
    LABEL_GAP = 72
};

/* Numbers along a side of an image: more than the first are averaged, fewer than the second repeated, because
 * viewers blur what they magnify. */
enum { MOST_CELLS = 1000, FEWEST_CELLS = 300 };

struct drawing {
    FILE *out;
    const struct cml_map_plot *plot;
    bool log, dark;        /* dark: some pixel has no light and no place on a log scale */
    double low, high;      /* range of the colours; high = 0: no light at all */
    double from[2], to[2]; /* cm, of all panels */
    int columns, rows, width, panel_height, left, foot, height;
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
    size_t capacity = 0;
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
        }
    }
    d->dark = *count < capacity;
    qsort(*values, *count, sizeof **values, by_size);
    return CML_OK;
}

/* From the faintest hundredth of the lit cells, which single packets make, to the brightest. */
static cml_status find_colours(struct drawing *d, struct cml_error *err)
{
    const double large = 100, decades = 1e8;
    float *values = NULL;
    size_t count = 0;
    CML_TRY(lit_values(d, &values, &count, err));
    if (count > 0) {
        d->high = (double)values[count - 1];
        d->low = fmax((double)values[count / 100], d->high / decades);
    }
    free(values);
    d->log =
        d->plot->scale == CML_SCALE_LOG || (d->plot->scale == CML_SCALE_AUTO && d->high > large * d->low);
    if (!d->log)
        d->low = 0;
    else if (d->low > 0.5 * d->high)
        d->low = 0.5 * d->high;
    return CML_OK;
}

/* All panels show the same piece of the plane, so that a centimetre is as long in each. Very long ones get
 * more of it than there is map. */
static void find_extent(struct drawing *d)
{
    const double longest = 4;
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
    const double size[2] = {d->to[0] - d->from[0], d->to[1] - d->from[1]};
    for (int axis = 0; axis < 2; axis++) {
        const double more = size[1 - axis] / longest - size[axis];
        if (more <= 0) continue;
        d->from[axis] -= more / 2;
        d->to[axis] += more / 2;
    }
}

/* Panels side by side as long as they are not too narrow: three in a row, two by two for four. */
static void lay_out(struct drawing *d)
{
    const double ratio = (d->to[1] - d->from[1]) / (d->to[0] - d->from[0]);
    const int count = d->plot->count;
    d->columns = count <= 3 ? count : count == 4 ? 2 : 3;
    d->rows = (count + d->columns - 1) / d->columns;
    const int room = (WIDTH - LEFT - RIGHT - GAP * (d->columns - 1)) / d->columns;
    d->panel_height = (int)fmin(TALLEST, room * ratio);
    d->width = (int)(d->panel_height / ratio);
    d->left = LEFT + (room - d->width) * d->columns / 2;
    d->foot = FOOT + cml_plot_caption(NULL, d->plot->caption, d->plot->picture, 0, 1);
    d->height = d->rows * (HEAD + d->panel_height) + (d->rows - 1) * GAP + d->foot;
}

/* ---- data ---- */

/* Without a value gnuplot leaves the pixel empty, and the grey below shows. */
static void write_row(const struct drawing *d, const struct cml_pixels *map, const struct axis axis[2],
                      size_t y)
{
    for (size_t x = 0; x < axis[0].cells; x++) {
        const double value = cell_value(map, axis, x, y);
        char word[32] = "NaN";
        if (value > 0 || !d->log) snprintf(word, sizeof word, "%.5g", value);
        for (size_t i = 0; i < axis[0].repeat; i++) fprintf(d->out, "%s ", word);
    }
    fputc('\n', d->out);
}

/* `with image` paints cells by their middles, which therefore begin half a step from the corner. */
static void write_map(const struct drawing *d, int k)
{
    const struct cml_pixels *map = &d->plot->maps[k];
    const struct axis axis[2] = {axis_of(map, 0), axis_of(map, 1)};
    fprintf(d->out, "$map%d << EOD\n", k);
    for (size_t y = 0; y < axis[1].cells; y++)
        for (size_t i = 0; i < axis[1].repeat; i++) write_row(d, map, axis, y);
    fprintf(d->out,
            "EOD\nplot $map%d matrix using (%.9g + $1 * %.9g):(%.9g + $2 * %.9g):3 with image notitle\n", k,
            map->origin[0] + axis[0].step / 2, axis[0].step, map->origin[1] + axis[1].step / 2, axis[1].step);
}

/* ---- the picture ---- */

/* Ticks at 1, 2 and 5 times powers of ten where powers alone would be too few. */
static void write_colour_ticks(const struct drawing *d)
{
    if (!d->log || d->high > 1e3 * d->low) return;
    const char *comma = "";
    fputs("set cbtics (", d->out);
    for (int power = (int)floor(log10(d->low)); power <= (int)ceil(log10(d->high)); power++)
        for (int digit = 1; digit <= 5; digit += digit == 1 ? 1 : 3) {
            fprintf(d->out, "%s'%g' %g", comma, digit * pow(10, power), digit * pow(10, power));
            comma = ", ";
        }
    fputs(")\n", d->out);
}

/* One bar for all panels, beside them, over their whole height. */
static void write_colours(const struct drawing *d)
{
    const double bar_height = d->height - d->foot - HEAD,
                 left = d->left + d->columns * (d->width + GAP) - GAP + BAR_GAP;
    fputs(palette, d->out);
    if (d->high > 0)
        fprintf(d->out, "%sset cbrange [%.6g:%.6g]\nset format cb '%%g'\n", d->log ? "set logscale cb\n" : "",
                d->low, d->high);
    write_colour_ticks(d);
    fprintf(d->out,
            "set colorbox vertical user origin screen %.6f, screen %.6f size screen %.6f, screen %.6f\n",
            left / WIDTH, (double)d->foot / d->height, (double)BAR / WIDTH, bar_height / d->height);
    fputs("set label 4 ", d->out);
    cml_gnuplot_quote(d->out, d->plot->quantity);
    fprintf(d->out, " at screen %.6f,%.6f center rotate", (left + BAR + LABEL_GAP) / WIDTH,
            (d->foot + bar_height / 2) / d->height);
    if (d->log && d->dark)
        fprintf(d->out,
                "\nset label 2 'grey: no light' at screen %.6f,%.6f left font ',%d' textcolor rgb '#404040'",
                left / WIDTH, (d->foot - 24.0) / d->height, d->plot->picture == CML_PICTURE_SVG ? 13 : 10);
    fputc('\n', d->out);
}

/* x and y have the same ticks, some TICKS points apart. */
static void write_frame(const struct drawing *d)
{
    const double step = cml_plot_round_step((d->to[0] - d->from[0]) / d->width * TICKS);
    cml_gnuplot_begin(d->out, d->plot->picture, WIDTH, d->height);
    fprintf(
        d->out,
        "set multiplot\nunset grid\nset tics out nomirror scale 0.6\nset format x '%%g'\nset format y '%%g'\n"
        "set xrange [%.9g:%.9g]\nset yrange [%.9g:%.9g]\nset xtics %g\nset ytics %g\nset xlabel 'x [cm]' "
        "offset 0,0.4\n",
        d->from[0], d->to[0], d->from[1], d->to[1], step, step);
    write_colours(d);
    (void)cml_plot_caption(d->out, d->plot->caption, d->plot->picture, d->foot - FOOT, d->height);
}

/* Grey below the map: what has no colour shows it. */
static void write_panel(const struct drawing *d, int k)
{
    const struct cml_pixels *map = &d->plot->maps[k];
    const int column = k % d->columns, row = k / d->columns;
    const double left = d->left + column * (d->width + GAP);
    const double top = d->height - HEAD - row * (d->panel_height + HEAD + GAP);
    char name[CML_PLOT_NAME];
    cml_plot_name(d->plot->names, d->plot->count, k, (size_t)fmin(100, fmax(8, (d->width + GAP) / LETTER)),
                  name);
    fprintf(d->out, "set lmargin at screen %.6f\nset rmargin at screen %.6f\n", left / WIDTH,
            (left + d->width) / WIDTH);
    fprintf(d->out, "set tmargin at screen %.6f\nset bmargin at screen %.6f\n", top / d->height,
            (top - d->panel_height) / d->height);
    fprintf(d->out,
            "set object 1 rectangle from %.9g,%.9g to %.9g,%.9g behind fc rgb '#D4D4D4' fs solid noborder\n",
            map->origin[0], map->origin[1], map->origin[0] + (double)map->n[0] * map->spacing[0],
            map->origin[1] + (double)map->n[1] * map->spacing[1]);
    fputs(column == 0 ? "set ylabel 'y [cm]' offset 1,0\n" : "unset ylabel\n", d->out);
    fputs("set label 1 ", d->out);
    cml_gnuplot_quote(d->out, name);
    fputs(" at graph 0,1 left offset 0,0.7\n", d->out);
    if (d->high > 0)
        write_map(d, k);
    else
        fputs("set label 3 'no light' at graph 0.5,0.5 center\nplot NaN notitle\n", d->out);
    /* once is enough */
    fputs("unset colorbox\nunset label\n", d->out);
}

/* Colours and extent first: they are common to all panels. */
cml_status cml_map_script(FILE *out, const void *plot, struct cml_error *err)
{
    struct drawing d = {.out = out, .plot = plot};
    CML_TRY(find_colours(&d, err));
    find_extent(&d);
    lay_out(&d);
    write_frame(&d);
    for (int k = 0; k < d.plot->count; k++) write_panel(&d, k);
    fputs("unset multiplot\n", out);
    return CML_OK;
}
