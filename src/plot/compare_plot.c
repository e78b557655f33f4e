/* The picture of a comparison: z of every test over its profile's axis, one panel below the other, with the
 * limit that the level sets. SPDX-License-Identifier: MIT */
#include "plot/compare_report.h"

#include "plot/plot_parts.h"
#include "base/significance.h"

#include <math.h>

/* Points of the page; TITLE_* are middles of axis titles, from the page's left and a panel's bottom. */
enum {
    LEFT = 81,
    RIGHT = 873,
    PANEL = 130,
    GAP = 74,
    HEAD = 82,
    FOOT = 4,
    TITLE_BELOW = 46,
    LONGEST_NAME = 44
};

/* gnuplot's labels. */
enum { LABEL_NAMES = 1, LABEL_VERDICT, LABEL_LEVEL, LABEL_WORST, LABEL_X, LABEL_Y };

/* Deviates beyond the first are arrows between these two, at the frame. */
static const double most = 8, arrow_foot = 6.5, arrow_head = 8.8, frame = 9;

struct drawing {
    struct cml_page page;
    const struct cml_compare_report *report;
    double limit; /* |z| at the level */
};

/* Profiles without a single test get none, nor do layers and media, which are few, detectors, of which there
 * may be hundreds, and arrays of .h5 files. */
static bool has_panel(const struct cml_comparison *c, int q)
{
    const enum cml_quantity quantity = (enum cml_quantity)q;
    const enum cml_estimator estimator = cml_quantities[q].estimator;
    const bool profile =
        estimator == CML_FROM_BATCHES || estimator == CML_FROM_ONCE || estimator == CML_FROM_GROUPS;
    return c->bins[q] > 0 && profile && cml_quantity_axes(quantity) && !cml_quantity_is_of_detector(quantity);
}

static int count_panels(const struct cml_comparison *c)
{
    int panels = 0;
    for (int q = 0; q < CML_NUM_QUANTITIES; q++) panels += has_panel(c, q);
    return panels;
}

/* The verdict as one sentence; then what the dashed lines are. */
static void write_verdict(const struct drawing *d)
{
    const struct cml_comparison *c = d->report->comparison;
    char text[200];
    const double middle = CML_PAGE_WIDTH / 2.0, top = d->page.height - 44;
    snprintf(text, sizeof text, "They %s: among %d tests chance alone makes such a difference with p = %.2g.",
             c->p < d->report->alpha ? "differ" : "agree", c->tests, c->p);
    cml_page_write(&d->page, LABEL_VERDICT, middle, top, CML_ALIGN_CENTER, CML_PAGE_NORMAL, text);
    snprintf(text, sizeof text, "dashed: |z| = %.2f, the level %g; arrows: beyond |z| = %g", d->limit,
             d->report->alpha, most);
    cml_page_write(&d->page, LABEL_LEVEL, middle, top - 20, CML_ALIGN_CENTER, CML_PAGE_SMALL, text);
}

/* Names of files may be long, and differ at their ends. */
static void write_head(const struct drawing *d)
{
    const struct cml_compare_report *report = d->report;
    char name[2][CML_PLOT_NAME], text[2 * CML_PLOT_NAME + 32];
    cml_page_begin(&d->page);
    fprintf(d->page.out,
            "set multiplot\nunset key\nset yrange [%g:%g]\nset ytics %g,4,%g\nset style fill solid "
            "noborder\n",
            -frame, frame, -most, most);
    for (int k = 0; k < 2; k++) cml_plot_cut(report->names[k], LONGEST_NAME, name[k]);
    snprintf(text, sizeof text, "%s (a) against %s (b)", name[0], name[1]);
    cml_page_write(&d->page, LABEL_NAMES, CML_PAGE_WIDTH / 2.0, d->page.height - 20, CML_ALIGN_CENTER,
                   CML_PAGE_NORMAL, text);
    write_verdict(d);
}

/* The number of a profile's data, behind the totals. */
static int block_of(int q)
{
    return q - CML_QUANTITY_A_z + CML_TOTALS;
}

/* Middle and half width of every test inside the frame, z; then those beyond it, as foot and length of an
 * arrow. Returns how many these are. */
static int write_data(const struct drawing *d, int q)
{
    const struct cml_comparison *c = d->report->comparison;
    FILE *out = d->page.out;
    int beyond = 0;
    for (int outside = 0; outside < 2; outside++) {
        fprintf(out, "$%s%d << EOD\n", outside ? "beyond" : "z", block_of(q));
        for (int i = 0; i < c->count; i++) {
            const struct cml_compare_test *t = &c->test[i];
            if ((int)t->quantity != q || (fabs(t->z) > most) != (outside == 1)) continue;
            const double middle = (t->lower + t->upper) / 2;
            beyond += outside;
            if (outside)
                fprintf(out, "%.7g %.4g 0 %.4g\n", middle, copysign(arrow_foot, t->z),
                        copysign(arrow_head - arrow_foot, t->z));
            else
                fprintf(out, "%.7g %.7g %.4g\n", middle, (t->upper - t->lower) / 2, t->z);
        }
        fputs("EOD\n", out);
    }
    return beyond;
}

/* Above the panel's right end, which arrows do not tell. */
static void write_worst(const struct drawing *d, int q, double top)
{
    const struct cml_comparison *c = d->report->comparison;
    double worst = 0;
    char text[64];
    for (int i = 0; i < c->count; i++)
        if ((int)c->test[i].quantity == q && fabs(c->test[i].z) > fabs(worst)) worst = c->test[i].z;
    snprintf(text, sizeof text, "worst z %+.1f", worst);
    cml_page_write(&d->page, LABEL_WORST, RIGHT, top + 11, CML_ALIGN_RIGHT, CML_PAGE_SMALL, text);
}

/* Bars along the axis show which bins were taken together. Labels of the head are drawn with the first panel
 * and then forgotten, as gnuplot would repeat them in each. */
static void write_panel(const struct drawing *d, int q, int row)
{
    static const char colour[] = "lc rgb '#D55E00'";
    const struct cml_comparison *c = d->report->comparison;
    const double top = d->page.height - HEAD - row * (PANEL + GAP), limit = fmin(d->limit, most);
    char name[32];
    double end = 0;
    for (int i = 0; i < c->count; i++)
        if ((int)c->test[i].quantity == q) end = c->test[i].upper;
    const int beyond = write_data(d, q);
    cml_page_panel(&d->page, LEFT, RIGHT, top - PANEL, top);
    snprintf(name, sizeof name, "z of %s", cml_quantities[q].name);
    cml_page_write(&d->page, LABEL_Y, CML_PAGE_TITLE_LEFT, top - PANEL / 2.0, CML_ALIGN_UPRIGHT,
                   CML_PAGE_NORMAL, name);
    cml_page_write(&d->page, LABEL_X, (LEFT + RIGHT) / 2.0, top - PANEL - TITLE_BELOW, CML_ALIGN_CENTER,
                   CML_PAGE_NORMAL, cml_quantity_axes((enum cml_quantity)q));
    if (beyond > 0) write_worst(d, q, top);
    fprintf(d->page.out,
            "set xrange [0:%.7g]\nplot %.4g with lines dt 2 lw 1.2 %s, %.4g with lines dt 2 lw 1.2 %s, ", end,
            limit, colour, -limit, colour);
    fprintf(d->page.out, "0 with lines lw 0.8 lc rgb '#808080'");
    fprintf(d->page.out, ", $z%d using 1:3:2 with xerrorbars pt 7 ps 0.4 lw 1.2 lc rgb '#0072B2'",
            block_of(q));
    if (beyond > 0)
        fprintf(d->page.out,
                ", $beyond%d using 1:2:3:4 with vectors head filled size screen 0.008,20 lw 1.4 %s",
                block_of(q), colour);
    fputs("\nunset label\n", d->page.out);
}

/* The limit is that of |z| in one of so many tests at which all together keep the level (Sidak 1967). */
cml_status cml_compare_script(FILE *out, const void *report, struct cml_error *err)
{
    const struct cml_compare_report *what = report;
    struct drawing d = {.page = {.out = out, .picture = what->picture, .width = CML_PAGE_WIDTH},
                        .report = what};
    const struct cml_comparison *c = d.report->comparison;
    const int panels = count_panels(c);
    if (panels == 0)
        return cml_fail(err, CML_E_INPUT, "%s: too few packets for a picture (expected a profile to show)",
                        d.report->names[0]);
    d.page.height = HEAD + panels * (PANEL + GAP) + FOOT;
    d.limit = cml_two_sided_limit(cml_sidak_level(d.report->alpha, c->tests));
    write_head(&d);
    for (int q = 0, row = 0; q < CML_NUM_QUANTITIES; q++)
        if (has_panel(c, q)) write_panel(&d, q, row++);
    fputs("unset multiplot\n", out);
    return CML_OK;
}
