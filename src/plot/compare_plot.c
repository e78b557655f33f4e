/* The picture of a comparison: z of every test over its profile's axis, one panel below the other, with the
 * limit that the level sets. SPDX-License-Identifier: MIT */
#include "plot/compare_report.h"

#include "base/significance.h"

#include <math.h>

/* Points of the SVG. */
enum { WIDTH = 900, PANEL = 130, GAP = 56, HEAD = 66, FOOT = 20 };

/* Beyond this a deviate is drawn at the frame, with its number. */
static const double most = 8;

struct drawing {
    FILE *out;
    const struct cml_compare_report *report;
    int height;   /* points */
    double limit; /* |z| at the level */
};

/* Profiles without a single test get none. */
static int count_panels(const struct cml_comparison *c)
{
    int panels = 0;
    for (int q = 0; q < CML_NUM_QUANTITIES; q++) panels += cml_quantities[q].axis && c->bins[q] > 0;
    return panels;
}

/* Names of files go through quoting; the second line is ours alone and needs none. */
static void write_head(const struct drawing *d)
{
    const struct cml_compare_report *report = d->report;
    char text[160];
    cml_gnuplot_begin(d->out, report->picture, WIDTH, d->height);
    fputs("set multiplot\nset lmargin at screen 0.09\nset rmargin at screen 0.97\nunset key\n"
          "set yrange [-9:9]\nset ytics -8,4,8\nset style fill solid noborder\nset label 1 ",
          d->out);
    cml_gnuplot_quote(d->out, report->names[0]);
    fprintf(d->out, ".' (a) against '.");
    cml_gnuplot_quote(d->out, report->names[1]);
    fprintf(d->out, ".' (b)' at screen 0.5,%.6f center\n", 1 - 20.0 / d->height);
    snprintf(text, sizeof text, "p = %.3g over %d tests; dashed: |z| = %.2f, the level %g",
             report->comparison->p, report->comparison->count, d->limit, report->alpha);
    fprintf(d->out, "set label 2 '%s' at screen 0.5,%.6f center\n", text, 1 - 44.0 / d->height);
}

/* Middle and half width of every test, z; a last column tells those that left the frame. */
static void write_data(const struct drawing *d, int q)
{
    const struct cml_comparison *c = d->report->comparison;
    fprintf(d->out, "$z%d << EOD\n", q);
    for (int i = 0; i < c->count; i++) {
        const struct cml_compare_test *t = &c->test[i];
        if ((int)t->quantity != q) continue;
        fprintf(d->out, "%.7g %.7g %.4g\n", (t->lower + t->upper) / 2, (t->upper - t->lower) / 2,
                fmin(fmax(t->z, -most), most));
    }
    fputs("EOD\n", d->out);
}

/* Error bars along the axis show which bins were taken together. The two labels are drawn with the first
 * panel and then forgotten, as gnuplot would repeat them in each. */
static void write_panel(const struct drawing *d, int q, int place)
{
    const struct cml_comparison *c = d->report->comparison;
    const double top = d->height - HEAD - place * (PANEL + GAP);
    double end = 0;
    for (int i = 0; i < c->count; i++)
        if ((int)c->test[i].quantity == q) end = c->test[i].upper;
    write_data(d, q);
    fprintf(d->out, "set tmargin at screen %.6f\nset bmargin at screen %.6f\nset xrange [0:%.7g]\n",
            top / d->height, (top - PANEL) / d->height, end);
    fprintf(d->out, "set ylabel 'z of %s'\nset xlabel '%s' offset 0,0.6\n", cml_quantities[q].name,
            cml_quantities[q].axis);
    fprintf(
        d->out,
        "plot %.4g with lines dt 2 lw 1.2 lc rgb '#D55E00', %.4g with lines dt 2 lw 1.2 lc rgb '#D55E00', "
        "0 with lines lw 0.8 lc rgb '#808080', $z%d using 1:3:2 with xerrorbars pt 7 ps 0.4 lw 1.2 "
        "lc rgb '#0072B2'\nunset label 1\nunset label 2\n",
        fmin(d->limit, most), fmax(-d->limit, -most), q);
}

/* The limit is that of |z| in one of so many tests at which all together keep the level (Sidak 1967). */
cml_status cml_compare_script(FILE *out, const void *report, struct cml_error *err)
{
    struct drawing d = {.out = out, .report = report};
    const struct cml_comparison *c = d.report->comparison;
    const int panels = count_panels(c);
    if (panels == 0)
        return cml_fail(err, CML_E_INPUT, "%s: too few packets for a picture (expected a profile to show)",
                        d.report->names[0]);
    d.height = HEAD + panels * (PANEL + GAP) + FOOT;
    d.limit = cml_two_sided_limit(cml_sidak_level(d.report->alpha, c->count));
    write_head(&d);
    for (int q = 0, place = 0; q < CML_NUM_QUANTITIES; q++)
        if (cml_quantities[q].axis && c->bins[q] > 0) write_panel(&d, q, place++);
    fputs("unset multiplot\n", out);
    return CML_OK;
}
