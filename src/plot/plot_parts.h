/* What all pictures of results have around them: names of files, the caption, colours that can be told apart,
 * round ticks. SPDX-License-Identifier: MIT */
#ifndef CML_PLOT_PARTS_H
#define CML_PLOT_PARTS_H

#include "plot/gnuplot.h"

#include <stddef.h>

enum cml_scale { CML_SCALE_AUTO, CML_SCALE_LOG, CML_SCALE_LINEAR };

enum { CML_PLOT_NAME = 128 };

/* The name behind the last '/'; part of `path`. */
const char *cml_plot_base_name(const char *path);

/* The i-th file's name, with its folders only where another of the `count` files has the same; one of more
 * than `most` bytes (5 to 120) loses its middle. */
void cml_plot_name(const char *const *paths, int count, int i, size_t most, char name[CML_PLOT_NAME]);

/* Breaks a caption (NULL: none) at blanks into lines, the first `top` points above the bottom of a picture of
 * `height` points; returns the number of points that it takes. out NULL: only measures. */
int cml_plot_caption(FILE *out, const char *caption, enum cml_picture picture, int top, int height);

/* 1, 2 or 5 times a power of ten, about `length` (> 0). */
double cml_plot_round_step(double length);

#endif
