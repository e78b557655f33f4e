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
enum { NUM_COLOURS = sizeof colours / sizeof *colours };

/* Letters of a name in the legend, and of the title. */
enum { LONGEST_NAME = 60, LONGEST_TITLE = 80 };

/* Share of a panel's height, at its bottom, that belongs to the heightfields alone. */
static const double strip = 0.25;

/* Lengths in points of the page. A panel alone is higher than one of two. TITLE_* are middles of axis titles,
 * from the page's left, the panel's bottom and the page's right: numbers of 7 letters stand between. */
enum {
    LEFT = 104,
    RIGHT = 790,
    PANEL = 340,
    SINGLE = 440,
    GAP = 44,
    HEAD = 50,
    ROW = 18,
    FOOT = 78,
    TITLE_BELOW = 48,
    TITLE_RIGHT = 882
};

/* gnuplot's labels. */
enum { LABEL_TITLE = 1, LABEL_PANEL, LABEL_NOTE, LABEL_HEIGHT, LABEL_X, LABEL_Y };

/* One of at most two pictures, one above the other, with a common axis. */
struct panel {
    const struct cml_shown_panel *shown;
    struct cml_curve *curves; /* [count of files], owned; no points where a file has none */
    double bottom, top;       /* points of the page */
    double low, high, first;  /* range of the values; the largest first one if above it, else 0 */
    double lowest, highest;   /* heights, cm; lowest > highest when no file has any */
    int row;                  /* 0: the upper one */
};

struct drawing {
    struct cml_page page;
    const struct cml_plot *plot;
    int count;         /* of files: results, then curves of others */
    double from, to;   /* of the common axis, cm or rad */
    int columns, rows; /* of the legend */
    int foot;          /* points below the panels */
    struct panel panels[2];
};

/* Curves span decades, so log is what they are without being asked; those of sweeps do not. */
static bool linear(const struct drawing *d)
{
    const enum cml_scale scale = d->plot->style.scale;
    return scale == CML_SCALE_LINEAR || (d->plot->over && scale == CML_SCALE_AUTO);
}

/* Drawn as curves of others, dashed. */
static bool of_others(const struct drawing *d, int k)
{
    return k >= d->plot->num_results && !d->plot->over;
}

/* What has no place on the axis, and is a gap. */
static bool is_gap(const struct drawing *d, double y)
{
    return !(y > 0 || (linear(d) && y == 0));
}

/* Letters of a name without the ending of a result. */
static int stem_of(const char *name)
{
    const char *dot = strrchr(name, '.');
    const bool ends = dot && dot != name && (strcmp(dot, ".mco") == 0 || strcmp(dot, ".h5") == 0);
    return ends && dot - name < 40 ? (int)(dot - name) : 40;
}

/* "a, b, c and 4 more": the output names that the scenes carry. */
static void write_title(const struct drawing *d)
{
    const struct cml_plot *plot = d->plot;
    char title[512] = "", cut[CML_PLOT_NAME];
    size_t used = 0;
    const int named = plot->num_results <= 4 ? plot->num_results : 3;
    for (int i = 0; i < named; i++) {
        const char *scene = cml_plot_base_name(plot->results[i].output ? plot->results[i].output : "?");
        used += (size_t)snprintf(title + used, sizeof title - used, "%s%.*s", i > 0 ? ", " : "",
                                 stem_of(scene), scene);
    }
    if (named < plot->num_results)
        snprintf(title + used, sizeof title - used, " and %d more", plot->num_results - named);
    cml_plot_cut(plot->style.title ? plot->style.title : title, LONGEST_TITLE, cut);
    cml_page_write(&d->page, LABEL_TITLE, CML_PAGE_WIDTH / 2.0, d->page.height - 24, CML_ALIGN_CENTER,
                   CML_PAGE_LARGE, cut);
}

/* ---- curves ---- */

/* All files become curves, so that the drawing need not tell them apart. */
static cml_status make_curves(struct drawing *d, struct panel *panel, struct cml_error *err)
{
    const struct cml_plot *plot = d->plot;
    panel->curves = calloc((size_t)d->count, sizeof *panel->curves);
    if (!panel->curves) return cml_fail_memory(err, 1, "the plot");
    for (int k = 0; k < plot->num_results; k++)
        CML_TRY(cml_shown_curve(&plot->results[k], plot->paths[k], panel->shown, &panel->curves[k], err));
    for (int k = 0; k < plot->num_curves; k++)
        CML_TRY(cml_shown_curve_of_others(&plot->curves[k][panel->row], panel->shown,
                                          &panel->curves[plot->num_results + k], err));
    return CML_OK;
}

static void free_curves(const struct drawing *d, struct panel *panel)
{
    for (int k = 0; k < d->count && panel->curves; k++) cml_curve_free(&panel->curves[k]);
    free(panel->curves);
}

/* A curve that has nothing to draw, only a place in the legend. */
static bool lit(const struct cml_curve *curve)
{
    for (int i = 0; i < curve->n; i++)
        if (curve->y[i] > 0) return true;
    return false;
}

/* ---- ranges ---- */

/* Reflectance belongs to the first boundary, transmittance to the last. NULL: the file has none. */
static const struct cml_heights *heights_of(const struct drawing *d, const struct panel *panel, int k)
{
    if (k >= d->plot->num_results || !cml_quantity_is_radial(panel->shown->quantity)) return NULL;
    const struct cml_outcome *outcome = &d->plot->results[k];
    const int boundary = panel->shown->quantity == CML_QUANTITY_Rd_r ? 0 : outcome->num_layers;
    const struct cml_heights *heights = cml_outcome_heights(outcome, boundary);
    return heights && heights->n > 0 ? heights : NULL;
}

/* Over all files, since they share the axis. */
static void find_heights(struct drawing *d, struct panel *panel)
{
    panel->lowest = INFINITY;
    panel->highest = -INFINITY;
    for (int k = 0; k < d->plot->num_results; k++) {
        const struct cml_heights *heights = heights_of(d, panel, k);
        for (int i = 0; heights && i < heights->n; i++) {
            panel->lowest = fmin(panel->lowest, heights->pair[2 * i + 1]);
            panel->highest = fmax(panel->highest, heights->pair[2 * i + 1]);
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

/* Over r the first bin holds the light that never scattered: often a thousand times the rest. It may leave
 * the frame rather than flatten every other curve. */
static cml_status find_range(const struct drawing *d, struct panel *panel, struct cml_error *err)
{
    const double headroom = 1.5, linear_headroom = 1.05, spike = 8, decades = 1e8;
    const bool radial = cml_quantity_is_radial(panel->shown->quantity);
    double first = 0;
    panel->low = INFINITY;
    panel->high = 0;
    for (int k = 0; k < d->count; k++) {
        const struct cml_curve *curve = &panel->curves[k];
        for (int i = 0; i < curve->n; i++) {
            if (curve->x[i] < d->from || curve->x[i] > d->to) continue;
            if (i == 0 && radial && k < d->plot->num_results)
                first = fmax(first, curve->y[0]);
            else
                widen(panel, curve->y[i]);
        }
    }
    if (panel->high == 0 || first <= spike * panel->high) {
        widen(panel, first);
        first = 0;
    }
    panel->first = first;
    panel->low = linear(d) ? 0 : fmax(panel->low, panel->high / decades) / headroom;
    panel->high *= linear(d) ? linear_headroom : headroom;
    if (panel->high == 0) return CML_OK;
    return cml_axis_range_apply(&d->plot->style.y, "--yrange", &panel->low, &panel->high, err);
}

/* The strip for the heights lies below the curves. */
static double bottom_of(const struct drawing *d, const struct panel *panel)
{
    if (!has_heights(panel)) return panel->low;
    if (linear(d)) return panel->low - (panel->high - panel->low) * strip / (1 - strip);
    return panel->low / pow(panel->high / panel->low, strip / (1 - strip));
}

/* The first place of all curves. */
static double first_place(const struct drawing *d, int num_panels)
{
    double first = INFINITY;
    for (int i = 0; i < num_panels; i++)
        for (int k = 0; k < d->count; k++) first = fmin(first, d->panels[i].curves[k].x[0]);
    return first;
}

/* Zero and what is below have no place on a log axis. */
static cml_status check_log_axis(const struct drawing *d, struct cml_error *err)
{
    if (!d->plot->style.log_x || d->from > 0) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "--logx (expected a lower axis above 0; it begins at %g)", d->from);
}

/* Up to the last light of any curve; of sweeps, and on a log axis, from the first place. One place alone has
 * some room. */
static cml_status find_axis(struct drawing *d, int num_panels, struct cml_error *err)
{
    if (d->plot->over || d->plot->style.log_x) d->from = first_place(d, num_panels);
    if (d->plot->over) d->to = -INFINITY;
    for (int i = 0; i < num_panels; i++)
        for (int k = 0; k < d->count; k++) d->to = fmax(d->to, d->panels[i].curves[k].end);
    if (d->plot->over && !(d->to - d->from > 1e-4 * fabs(d->to))) {
        const double room = d->to != 0 ? 0.1 * fabs(d->to) : 1;
        d->from -= room;
        d->to += room;
    }
    CML_TRY(cml_axis_range_within(&d->plot->style.x, "--xrange", &d->from, &d->to, err));
    return check_log_axis(d, err);
}

/* ---- data ---- */

/* Place, value, and one standard error to both sides. Two empty lines would begin another data set. */
static void write_curve_data(const struct drawing *d, const struct panel *panel, int k)
{
    const struct cml_curve *curve = &panel->curves[k];
    bool gap = true;
    fprintf(d->page.out, "$c%d_%d << EOD\n", panel->row, k);
    for (int i = 0; i < curve->n; i++) {
        const double y = curve->y[i], e = curve->error ? curve->error[i] : 0;
        if (!is_gap(d, y))
            fprintf(d->page.out, "%.7g %.7g %.7g %.7g\n", curve->x[i], y, fmax(y - e, panel->low), y + e);
        else if (!gap)
            fputc('\n', d->page.out);
        gap = is_gap(d, y);
    }
    fputs("EOD\n", d->page.out);
}

/* The last height goes on to the edge of the picture, as the boundary does. */
static void write_heights(const struct drawing *d, const struct panel *panel, int k)
{
    const struct cml_heights *heights = heights_of(d, panel, k);
    if (!heights) return;
    const double *pair = heights->pair, *last = pair + 2 * (heights->n - 1);
    fprintf(d->page.out, "$h%d_%d << EOD\n", panel->row, k);
    for (int i = 0; i < heights->n; i++) fprintf(d->page.out, "%.9g %.9g\n", pair[2 * i], pair[2 * i + 1]);
    fprintf(d->page.out, "%.9g %.9g\nEOD\n", fmax(d->to, last[0]), last[1]);
}

/* ---- the picture ---- */

/* All that the panels share. The legend stands above them, once. */
static void write_frame(const struct drawing *d)
{
    FILE *out = d->page.out;
    cml_page_begin(&d->page);
    fputs(linear(d) ? "set multiplot\n" : "set multiplot\nset logscale y\n", out);
    fprintf(out, "set format y '%%g'\nset format y2 '%%g'\n%s\nset xrange [%.9g:%.9g]\n",
            d->plot->style.log_x ? "set logscale x\nset format x '%g'\nset mxtics 10" : "set mxtics 2",
            d->from, d->to);
    write_title(d);
    fprintf(out,
            "set key at screen 0.5,%.6f center top horizontal maxcols %d Left reverse samplen 2.5 "
            "noautotitle\n",
            1 - (double)HEAD / d->page.height, d->columns);
}

/* The span of heights of a panel's curves, cm. What differs in its last digits only is a flat line: ticks
 * between them would be equal numbers. */
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
static void write_height_axis(const struct drawing *d, const struct panel *panel)
{
    FILE *out = d->page.out;
    if (!has_heights(panel)) {
        fprintf(out, "unset y2tics\nunset label %d\nset ytics mirror\n", LABEL_HEIGHT);
        return;
    }
    const double span = height_span(panel);
    fprintf(out, "set ytics nomirror\nset y2range [%.9g:%.9g]\n", panel->lowest - 0.15 * span,
            panel->lowest - 0.15 * span + 1.35 * span / strip);
    write_height_ticks(out, panel, span);
    cml_page_write(&d->page, LABEL_HEIGHT, TITLE_RIGHT,
                   panel->bottom + strip / 2 * (panel->top - panel->bottom) + 8, CML_ALIGN_UPRIGHT,
                   CML_PAGE_SMALL, "height [cm]");
}

/* What stands above the panel's right end. */
static void write_note(const struct drawing *d, const struct panel *panel)
{
    char note[64];
    fprintf(d->page.out, "unset label %d\n", LABEL_NOTE);
    snprintf(note, sizeof note, "%s", panel->high > 0 ? "" : "no light");
    if (panel->first > 0) snprintf(note, sizeof note, "first bin: %.3g", panel->first);
    for (int k = 0; k < d->count; k++)
        if (panel->curves[k].shared) snprintf(note, sizeof note, "gaps: bins that two media share");
    if (note[0])
        cml_page_write(&d->page, LABEL_NOTE, RIGHT, panel->top + 12, CML_ALIGN_RIGHT, CML_PAGE_NORMAL, note);
}

/* Titles stand at places of our own: gnuplot's would move with the letters of each format. The common axis is
 * labelled below the lowest panel only. */
static void write_axes(const struct drawing *d, const struct panel *panel, bool last)
{
    FILE *out = d->page.out;
    const double middle = (panel->bottom + panel->top) / 2, across = (LEFT + RIGHT) / 2.0;
    cml_page_panel(&d->page, LEFT, RIGHT, panel->bottom, panel->top);
    cml_page_write(&d->page, LABEL_PANEL, LEFT, panel->top + 12, CML_ALIGN_LEFT, CML_PAGE_NORMAL,
                   panel->shown->title);
    cml_page_write(&d->page, LABEL_Y, CML_PAGE_TITLE_LEFT, middle, CML_ALIGN_UPRIGHT, CML_PAGE_NORMAL,
                   panel->shown->axis);
    fputs(last ? "set format x '%g'\n" : "set format x ''\n", out);
    if (last)
        cml_page_write(&d->page, LABEL_X, across, panel->bottom - TITLE_BELOW, CML_ALIGN_CENTER,
                       CML_PAGE_NORMAL, d->plot->over ? d->plot->over : cml_shown_axis(panel->shown));
    const double low = panel->high > 0 ? bottom_of(d, panel) : 0.1, high = panel->high > 0 ? panel->high : 1;
    fprintf(out, "set yrange [%.6g:%.6g]\nset ytics autofreq\n", low, high);
    if (!linear(d)) cml_plot_log_ticks(out, "ytics", low, high);
    write_note(d, panel);
    write_height_axis(d, panel);
    if (linear(d) && panel->high > 0) /* none below 0, where the heights are */
        fprintf(out, "set ytics %g,%g\n", panel->low, cml_plot_round_step((panel->high - panel->low) / 5));
}

/* The colours repeat after eight curves, then with another dash; curves of others have the colour of the
 * result that they belong to. A curve without light still gets its place in the legend. */
static void write_curve(const struct drawing *d, const struct panel *panel, int k)
{
    FILE *out = d->page.out;
    const struct cml_curve *curve = &panel->curves[k];
    const bool others = of_others(d, k);
    const int number = others ? k - d->plot->num_results : k, at = panel->row;
    const int dash = others ? 2 : 1 + 3 * (number / NUM_COLOURS % 2);
    const char *colour = colours[number % NUM_COLOURS];
    if (lit(curve) && !others)
        fprintf(out, "$c%d_%d using 1:3:4 with filledcurves lc rgb '%s' fs transparent solid 0.3 noborder, ",
                at, k, colour);
    if (lit(curve) && others && curve->error)
        fprintf(out, "$c%d_%d using 1:2:3:4 with yerrorbars pt 0 lw 1 lc rgb '%s', ", at, k, colour);
    if (lit(curve))
        fprintf(out, "$c%d_%d using 1:2 with linespoints lw %g dt %d pt %d ps 0.6 pi %d lc rgb '%s'", at, k,
                others ? 1.3 : 2, dash, marks[others][number % NUM_COLOURS],
                d->plot->over ? 1 : 1 + curve->n / 14, colour);
    else
        fprintf(out, "NaN with linespoints lw 2 dt %d pt %d ps 0.6 lc rgb '%s'", dash,
                marks[others][number % NUM_COLOURS], colour);
    if (panel->row == 0) {
        char name[CML_PLOT_NAME];
        cml_plot_cut(d->plot->names[k], LONGEST_NAME, name);
        fputs(" title ", out);
        cml_gnuplot_quote(out, name);
    }
    if (heights_of(d, panel, k))
        fprintf(out, ", $h%d_%d using 1:2 axes x1y2 with lines lw 2 dt 3 lc rgb '%s'", at, k, colour);
}

/* Data first, since gnuplot wants blocks complete before a plot names them. */
static void write_panel(const struct drawing *d, const struct panel *panel, bool last)
{
    for (int k = 0; k < d->count; k++) {
        if (lit(&panel->curves[k])) write_curve_data(d, panel, k);
        write_heights(d, panel, k);
    }
    write_axes(d, panel, last);
    for (int k = 0; k < d->count; k++) {
        fputs(k == 0 ? "plot " : ", \\\n     ", d->page.out);
        write_curve(d, panel, k);
    }
    fprintf(d->page.out, "\nunset key\nunset label %d\n", LABEL_TITLE);
}

/* As many legend columns as the longest name allows; the page grows with their rows. */
static void lay_out(struct drawing *d, int num_panels)
{
    const double letter = 0.56 * CML_PAGE_NORMAL, sample = 70;
    const int panel = num_panels == 1 ? SINGLE : PANEL;
    size_t longest = 1;
    for (int k = 0; k < d->count; k++) {
        const size_t letters = cml_plot_letters(d->plot->names[k]);
        if (letters > longest) longest = letters < LONGEST_NAME ? letters : LONGEST_NAME;
    }
    d->columns = (int)fmax(1, floor((RIGHT - LEFT) / ((double)longest * letter + sample)));
    if (d->columns > d->count) d->columns = d->count;
    d->rows = (d->count + d->columns - 1) / d->columns;
    d->foot = FOOT + cml_plot_caption(NULL, d->plot->style.caption, 0);
    d->page.height = HEAD + ROW * d->rows + GAP * num_panels + panel * num_panels + d->foot;
    for (int i = 0; i < num_panels; i++) {
        d->panels[i].bottom = d->foot + (panel + GAP) * (num_panels - 1 - i);
        d->panels[i].top = d->panels[i].bottom + panel;
    }
}

/* The caption comes with the last panel: a label that is set earlier would be drawn twice. */
static cml_status write_panels(struct drawing *d, int num_panels, struct cml_error *err)
{
    lay_out(d, num_panels);
    CML_TRY(find_axis(d, num_panels, err));
    write_frame(d);
    for (int i = 0; i < num_panels; i++) {
        const bool last = i == num_panels - 1;
        find_heights(d, &d->panels[i]);
        CML_TRY(find_range(d, &d->panels[i], err));
        if (last) (void)cml_plot_caption(&d->page, d->plot->style.caption, d->foot - FOOT);
        write_panel(d, &d->panels[i], last);
    }
    fputs("unset multiplot\n", d->page.out);
    return CML_OK;
}

cml_status cml_plot_script(FILE *out, const void *what, struct cml_error *err)
{
    const struct cml_plot *plot = what;
    struct drawing d = {.page = {.out = out, .picture = plot->picture, .width = CML_PAGE_WIDTH},
                        .plot = plot,
                        .count = plot->num_results + plot->num_curves};
    cml_status status = CML_OK;
    for (int i = 0; i < plot->shown->num_panels; i++) {
        d.panels[i] = (struct panel){.shown = &plot->shown->panel[i], .row = i};
        if (status == CML_OK) status = make_curves(&d, &d.panels[i], err);
    }
    if (status == CML_OK) status = write_panels(&d, plot->shown->num_panels, err);
    for (int i = 0; i < plot->shown->num_panels; i++) free_curves(&d, &d.panels[i]);
    return status;
}
