/* SPDX-License-Identifier: MIT */
#include "plot/plot.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Okabe and Ito's colours, which stay apart for colour-blind eyes; yellow last, it is faint on white. */
static const char *const colours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                      "#000000", "#E69F00", "#56B4E9", "#F0E442"};

/* gnuplot's marks, full for results and open for curves of others: what tells curves apart in grey. */
static const int marks[2][8] = {{7, 5, 9, 13, 11, 15, 2, 1}, {6, 4, 8, 12, 10, 14, 2, 1}};
enum { NUM_COLOURS = sizeof colours / sizeof *colours, MOST_HEIGHTS = 20000, LONGEST_NAME = 60 };

/* Share of a panel's height, at its bottom, that belongs to the heightfields alone. */
static const double strip = 0.25;

/* Lengths in points of the SVG; the PNG has twice as many pixels. */
enum { WIDTH = 900, PANEL = 340, GAP = 44, HEAD = 50, ROW = 18, FOOT = 62 };

/* One of the two pictures, one above the other, with a common axis of r. */
struct panel {
    const char *name, *title, *axis, *error_key;
    bool top;                /* R over the top surface, else T over the bottom */
    double low, high, first; /* y range of the curves; the largest first bin when it is above it, else 0 */
    double lowest, highest;  /* heights, cm; lowest > highest when no file has any */
};

struct drawing {
    FILE *out;
    const struct cml_plot *plot;
    double r_max;   /* cm */
    double *values; /* scratch for standard errors and heights */
    int capacity, columns, rows;
    int height; /* of the whole picture, points */
    int foot;   /* of that below the panels */
    struct panel panels[2];
};

/* Curves of others have both profiles, one of them perhaps zero. */
static const double *profile_of(const struct panel *panel, const struct cml_mco *mco)
{
    return panel->top ? mco->Rd_r : mco->Tt_r;
}

/* Curves span decades, so log is what they are without being asked. */
static bool linear(const struct drawing *d)
{
    return d->plot->scale == CML_SCALE_LINEAR;
}

/* Of bin i, cm: r Rd(r) is drawn at the middle of its bin, by which others' curves are told, too. */
static double centre(const struct cml_mco *mco, int i)
{
    return (i + 0.5) * mco->dr;
}

/* "Reflectance and transmittance of a, b, c and 4 more": the output names that the scenes carry. */
static void write_title(FILE *out, const struct cml_plot *plot)
{
    char title[512] = "";
    size_t used = 0;
    const int named = plot->num_results <= 4 ? plot->num_results : 3;
    for (int i = 0; i < named; i++) {
        const char *scene = cml_plot_base_name(plot->results[i].output ? plot->results[i].output : "?");
        const char *end = strstr(scene, ".mco");
        const int length = end && end != scene && end - scene < 40 ? (int)(end - scene) : 40;
        used +=
            (size_t)snprintf(title + used, sizeof title - used, "%s%.*s", i > 0 ? ", " : "", length, scene);
    }
    if (named < plot->num_results)
        snprintf(title + used, sizeof title - used, " and %d more", plot->num_results - named);
    cml_gnuplot_quote(out, title);
}

/* ---- ranges ---- */

/* The top panel shows the first boundary, the other one the last. Pairs of r and h, up to the first number
 * that no scene can have; returns how many numbers, an even one. */
static int read_heights(const struct drawing *d, const struct panel *panel, const struct cml_mco *mco)
{
    const double largest = 1e30; /* cm */
    char key[32];
    snprintf(key, sizeof key, "heightfield%d", panel->top ? 0 : mco->num_layers);
    const int count = cml_mco_extra(mco, key, d->values, MOST_HEIGHTS);
    int sound = 0;
    while (sound < count && fabs(d->values[sound]) <= largest) sound++;
    return sound & ~1;
}

/* Over all files, since they share the axis. */
static void find_heights(struct drawing *d, struct panel *panel)
{
    panel->lowest = INFINITY;
    panel->highest = -INFINITY;
    for (int k = 0; k < d->plot->count; k++) {
        const int n = read_heights(d, panel, &d->plot->results[k]);
        for (int i = 0; i < n; i += 2) {
            panel->lowest = fmin(panel->lowest, d->values[i + 1]);
            panel->highest = fmax(panel->highest, d->values[i + 1]);
        }
    }
}

static bool has_heights(const struct panel *panel)
{
    return panel->lowest <= panel->highest;
}

/* Zeros have no place on a log axis and do not lower its range. */
static void widen(struct panel *panel, double y)
{
    if (y > panel->high) panel->high = y;
    if (y > 0 && y < panel->low) panel->low = y;
}

/* The first bin holds the light that never scattered: often a thousand times the rest. It may leave the frame
 * rather than flatten every other curve. */
static void find_range(const struct drawing *d, struct panel *panel)
{
    const double headroom = 1.5, linear_headroom = 1.05, spike = 8, decades = 1e8;
    double first = 0;
    panel->low = INFINITY;
    panel->high = 0;
    for (int k = 0; k < d->plot->count; k++) {
        const struct cml_mco *mco = &d->plot->results[k];
        first = fmax(first, centre(mco, 0) * profile_of(panel, mco)[0]);
        for (int i = 1; i < mco->nr - 1; i++) widen(panel, centre(mco, i) * profile_of(panel, mco)[i]);
    }
    if (panel->high == 0 || first <= spike * panel->high) {
        widen(panel, first);
        first = 0;
    }
    panel->first = first;
    panel->low = linear(d) ? 0 : fmax(panel->low, panel->high / decades) / headroom;
    panel->high *= linear(d) ? linear_headroom : headroom;
}

/* The strip for the heights lies below the curves. */
static double bottom_of(const struct drawing *d, const struct panel *panel)
{
    if (!has_heights(panel)) return panel->low;
    if (linear(d)) return panel->low - (panel->high - panel->low) * strip / (1 - strip);
    return panel->low / pow(panel->high / panel->low, strip / (1 - strip));
}

/* The curves' last radius, cm: what lies beyond is an empty frame. */
static double lit_radius(const struct cml_mco *mco)
{
    int last = 1;
    for (int i = 0; i < mco->nr - 1; i++)
        if (mco->Rd_r[i] > 0 || mco->Tt_r[i] > 0) last = i + 2;
    return last * mco->dr;
}

/* ---- data ---- */

/* r, r*R, and the band of one standard error; bins of zero have no place on a log axis. */
static void write_profile(const struct drawing *d, const struct panel *panel, int k)
{
    const struct cml_mco *mco = &d->plot->results[k];
    const double *profile = profile_of(panel, mco);
    const bool errors = cml_mco_extra(mco, panel->error_key, d->values, mco->nr) == mco->nr;
    fprintf(d->out, "$%s%d << EOD\n", panel->name, k);
    for (int i = 0; i < mco->nr - 1; i++) {
        const double r = centre(mco, i), y = r * profile[i], e = errors ? r * d->values[i] : 0;
        if (y > 0 || linear(d))
            fprintf(d->out, "%.7g %.7g %.7g %.7g\n", r, y, fmax(y - e, panel->low), y + e);
    }
    fputs("EOD\n", d->out);
}

/* The last height goes on to the edge of the picture, as the boundary does. */
static void write_heights(const struct drawing *d, const struct panel *panel, int k)
{
    const int n = read_heights(d, panel, &d->plot->results[k]);
    if (n == 0) return;
    fprintf(d->out, "$%sheight%d << EOD\n", panel->name, k);
    for (int i = 0; i < n; i += 2) fprintf(d->out, "%.9g %.9g\n", d->values[i], d->values[i + 1]);
    fprintf(d->out, "%.9g %.9g\nEOD\n", fmax(d->r_max, d->values[n - 2]), d->values[n - 1]);
}

/* The last bin holds what lies beyond the grid and is not drawn. */
static bool lit(const struct panel *panel, const struct cml_mco *mco)
{
    const double *profile = profile_of(panel, mco);
    for (int i = 0; i < mco->nr - 1; i++)
        if (profile[i] > 0) return true;
    return false;
}

/* ---- the picture ---- */

/* All that both panels share. The legend stands above them, once. */
static void write_frame(const struct drawing *d)
{
    cml_gnuplot_begin(d->out, d->plot->picture, WIDTH, d->height);
    fputs(linear(d) ? "set multiplot\n" : "set multiplot\nset logscale y\n", d->out);
    fputs("set format y '%g'\nset format y2 '%g'\nset mxtics 2\n"
          "set lmargin at screen 0.11\nset rmargin at screen 0.88\n",
          d->out);
    fprintf(d->out, "set xrange [0:%.9g]\n", d->r_max);
    fprintf(d->out, "set label 1 at screen 0.5,%.6f center font ',%d' ", 1 - 24.0 / d->height,
            d->plot->picture == CML_PICTURE_SVG ? 18 : 13);
    write_title(d->out, d->plot);
    fprintf(d->out,
            "\nset key at screen 0.5,%.6f center top horizontal maxcols %d Left reverse samplen 2.5 "
            "noautotitle\n",
            1 - (double)HEAD / d->height, d->columns);
}

/* Of the heights, cm. What differs in its last digits only is a flat line: ticks between them would be equal
 * numbers. */
static double height_span(const struct panel *panel)
{
    const double span = panel->highest - panel->lowest, flat = 0.1;
    const double least = fmax(1e-30, 1e-6 * fmax(fabs(panel->lowest), fabs(panel->highest)));
    return span > least ? span : fmax(flat, least);
}

/* Ticks at round heights, in the strip only. */
static void write_height_ticks(FILE *out, const struct panel *panel, double span)
{
    const double step = cml_plot_round_step(span / 2);
    const char *comma = "";
    fputs("set y2tics (", out);
    for (double i = floor(panel->lowest / step); i <= ceil(panel->highest / step); i++) {
        fprintf(out, "%s%.9g", comma, i * step);
        comma = ", ";
    }
    fputs(") textcolor rgb '#606060'\n", out);
}

/* A second axis on which the heights fill the strip below the curves. */
static void write_height_axis(FILE *out, const struct panel *panel)
{
    if (!has_heights(panel)) {
        fputs("unset y2tics\nunset label 4\nset ytics mirror\n", out);
        return;
    }
    const double span = height_span(panel);
    fprintf(out, "set ytics nomirror\nset y2range [%.9g:%.9g]\n", panel->lowest - 0.15 * span,
            panel->lowest - 0.15 * span + 1.35 * span / strip);
    write_height_ticks(out, panel, span);
    fprintf(out, "set label 4 'height [cm]' at graph 1.085,%.6g center rotate textcolor rgb '#606060'\n",
            strip / 2);
}

/* r is labelled below the lower panel only. Labels with fixed numbers replace those of the panel before. */
static void write_axes(const struct drawing *d, const struct panel *panel)
{
    const int bottom = d->foot + (panel->top ? PANEL + GAP : 0);
    fprintf(d->out, "set bmargin at screen %.6f\nset tmargin at screen %.6f\n", (double)bottom / d->height,
            (double)(bottom + PANEL) / d->height);
    fprintf(d->out, "set label 2 '%s' at graph 0,1 left offset 0,0.7\nset ylabel '%s' offset 0.5,0\n",
            panel->title, panel->axis);
    fputs(panel->top ? "set format x ''\nunset xlabel\n" : "set format x '%g'\nset xlabel 'radius r [cm]'\n",
          d->out);
    if (panel->high > 0)
        fprintf(d->out, "set yrange [%.6g:%.6g]\nunset label 3\n", bottom_of(d, panel), panel->high);
    else
        fputs("set yrange [0.1:1]\nset label 3 'no light' at graph 0.5,0.5 center\n", d->out);
    if (panel->first > 0)
        fprintf(d->out, "set label 3 'first bin: %.3g' at graph 0.99,1 right offset 0,0.7\n", panel->first);
    write_height_axis(d->out, panel);
    if (linear(d) && panel->high > 0) /* none below 0, where the heights are */
        fprintf(d->out, "set ytics 0,%g\n", cml_plot_round_step(panel->high / 5));
}

/* The colours repeat after eight curves, then with another dash; curves of others have the colour of the
 * result that they belong to. A curve without light still gets its place in the legend. */
static void write_curve(const struct drawing *d, const struct panel *panel, int k)
{
    const struct cml_mco *mco = &d->plot->results[k];
    const bool others = k >= d->plot->num_results;
    const int place = others ? k - d->plot->num_results : k;
    const int dash = others ? 2 : 1 + 3 * (place / NUM_COLOURS % 2);
    const char *colour = colours[place % NUM_COLOURS];
    char name[CML_PLOT_NAME];
    cml_plot_name(d->plot->names, d->plot->count, k, LONGEST_NAME, name);
    if (lit(panel, mco) && !others)
        fprintf(d->out, "$%s%d using 1:3:4 with filledcurves lc rgb '%s' fs transparent solid 0.3 noborder, ",
                panel->name, k, colour);
    if (lit(panel, mco))
        fprintf(d->out, "$%s%d using 1:2 with linespoints lw %g dt %d pt %d ps 0.6 pi %d lc rgb '%s'",
                panel->name, k, others ? 1.3 : 2, dash, marks[others][place % NUM_COLOURS], 1 + mco->nr / 14,
                colour);
    else
        fprintf(d->out, "NaN with linespoints lw 2 dt %d pt %d ps 0.6 lc rgb '%s'", dash,
                marks[others][place % NUM_COLOURS], colour);
    if (panel->top) {
        fputs(" title ", d->out);
        cml_gnuplot_quote(d->out, name);
    }
    if (read_heights(d, panel, mco) > 0)
        fprintf(d->out, ", $%sheight%d using 1:2 axes x1y2 with lines lw 2 dt 3 lc rgb '%s'", panel->name, k,
                colour);
}

/* Data first, since gnuplot wants blocks complete before a plot names them. */
static void write_panel(const struct drawing *d, const struct panel *panel)
{
    for (int k = 0; k < d->plot->count; k++) {
        if (lit(panel, &d->plot->results[k])) write_profile(d, panel, k);
        write_heights(d, panel, k);
    }
    write_axes(d, panel);
    fputs(panel->top ? "" : "unset key\nunset label 1\n", d->out);
    for (int k = 0; k < d->plot->count; k++) {
        fputs(k == 0 ? "plot " : ", \\\n     ", d->out);
        write_curve(d, panel, k);
    }
    fputc('\n', d->out);
}

/* As many legend columns as the longest name allows; the picture grows with their rows. */
static void lay_out(struct drawing *d)
{
    size_t longest = 1;
    for (int k = 0; k < d->plot->count; k++) {
        char name[CML_PLOT_NAME];
        cml_plot_name(d->plot->names, d->plot->count, k, LONGEST_NAME, name);
        if (strlen(name) > longest) longest = strlen(name);
        const struct cml_mco *mco = &d->plot->results[k];
        d->r_max = fmax(d->r_max, lit_radius(mco));
        if (mco->nr > d->capacity) d->capacity = mco->nr;
    }
    d->columns = (int)fmax(1, floor(90.0 / ((double)longest + 8)));
    if (d->columns > d->plot->count) d->columns = d->plot->count;
    d->rows = (d->plot->count + d->columns - 1) / d->columns;
    d->foot = FOOT + cml_plot_caption(NULL, d->plot->caption, d->plot->picture, 0, 1);
    d->height = HEAD + ROW * d->rows + GAP + PANEL + GAP + PANEL + d->foot;
}

/* The caption comes with the last panel: a label that is set earlier would be drawn twice. */
cml_status cml_plot_script(FILE *out, const void *what, struct cml_error *err)
{
    const struct cml_plot *plot = what;
    struct drawing d = {
        .out = out,
        .plot = plot,
        .capacity = MOST_HEIGHTS,
        .panels = {
            {.name = "R",
             .title = "Reflectance",
             .axis = "r·Rd(r)  [1/cm]",
             .error_key = "se_Rd_r",
             .top = true},
            {.name = "T", .title = "Transmittance", .axis = "r·Tt(r)  [1/cm]", .error_key = "se_Tt_r"}}};
    lay_out(&d);
    d.values = malloc((size_t)d.capacity * sizeof *d.values);
    if (!d.values) return cml_fail_memory(err, (double)d.capacity * sizeof *d.values, "the plot");
    write_frame(&d);
    for (int p = 0; p < 2; p++) {
        find_heights(&d, &d.panels[p]);
        find_range(&d, &d.panels[p]);
        if (p == 1) (void)cml_plot_caption(out, plot->caption, plot->picture, d.foot - FOOT, d.height);
        write_panel(&d, &d.panels[p]);
    }
    fputs("unset multiplot\n", out);
    free(d.values);
    return CML_OK;
}
