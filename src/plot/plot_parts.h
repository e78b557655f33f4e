/* What all pictures of results have around them: names of files, titles, captions, ranges, round ticks.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "plot/gnuplot.h"

#include <stddef.h>
#include <stdio.h>

enum cml_scale { CML_SCALE_AUTO, CML_SCALE_LOG, CML_SCALE_LINEAR };

/* What the user wants of an axis or of colours; NAN: chosen from the data. Zeroed it is not NAN. */
struct cml_axis_range {
    double from, to;
};
extern const struct cml_axis_range cml_axis_range_any;

/* Takes what is given in place of *from and *to. CML_E_INPUT, with the option's name, where that leaves no
 * axis that can be drawn. */
CML_NODISCARD cml_status cml_axis_range_apply(const struct cml_axis_range *range, const char *option,
                                              double *from, double *to, struct cml_error *err);

/* cml_axis_range_apply of an axis whose data lie between *from and *to: CML_E_INPUT also where none of them
 * is in the range. */
CML_NODISCARD cml_status cml_axis_range_within(const struct cml_axis_range *range, const char *option,
                                               double *from, double *to, struct cml_error *err);

/* What every picture of results may be told. */
struct cml_plot_style {
    const char *title;            /* NULL: chosen */
    const char *caption;          /* text below the picture; NULL: none */
    enum cml_scale scale;         /* of values */
    bool log_x;                   /* of curves: the lower axis is logarithmic */
    struct cml_axis_range x, y;   /* of the axes, in their units */
    struct cml_axis_range colour; /* of a map's values, in their unit */
    double percentile; /* of a map's lit pixels, at which the colours end, in per cent: 0 < p <= 100 */
};

enum { CML_PLOT_NAME = 256 };

/* The name behind the last '/'; part of `path`. */
const char *cml_plot_base_name(const char *path);

/* The i-th file's name, with its folders only where another of the `count` files has the same; part of the
 * path. */
const char *cml_plot_name(const char *const *paths, int count, int i);

/* `text`, or, of more than `most` letters (5 to 120), without its middle. */
void cml_plot_cut(const char *text, size_t most, char name[CML_PLOT_NAME]);

/* Letters of UTF-8 in a text. */
size_t cml_plot_letters(const char *text);

/* Breaks a caption (NULL: none) at blanks into lines, the first `top` points above the bottom of the page;
 * returns the number of points that it takes. page NULL: only measures. */
int cml_plot_caption(const struct cml_page *page, const char *caption, int top);

/* 1, 2 or 5 times a power of ten, about `length` (> 0). */
double cml_plot_round_step(double length);

/* Sets ticks at 1, 2 and 5 times powers of ten on a log axis ("ytics", "cbtics") that spans low (> 0) to
 * high, up to three decades; beyond, gnuplot's own do. Without light (low 0) none. Exists because gnuplot 6
 * writes out all nine of a decade below two of them, gnuplot 5 only powers. */
void cml_plot_log_ticks(FILE *out, const char *axis, double low, double high);
