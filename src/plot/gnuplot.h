/* Drawing by gnuplot: the parts of a script that all pictures share, and the process that draws.
 * Script on gnuplot's standard input, picture from its standard output, so that no name of a file is ever
 * part of a command. SPDX-License-Identifier: MIT */
#ifndef CML_GNUPLOT_H
#define CML_GNUPLOT_H

#include "base/status.h"

#include <stdbool.h>
#include <stdio.h>

enum cml_picture { CML_PICTURE_SVG, CML_PICTURE_PNG };

/* What the end of the name asks for; CML_E_INPUT when it is neither .svg nor .png. */
CML_NODISCARD cml_status cml_picture_of(const char *path, enum cml_picture *picture, struct cml_error *err);

/* Terminal, frame and grid of a picture of width x height points; a PNG has twice as many pixels. */
void cml_gnuplot_begin(FILE *out, enum cml_picture picture, int width, int height);

/* The text as a string of gnuplot, in double quotes. A backslash stands before quotes and backslashes; what
 * stands in backquotes, gnuplot would run as a command, so these are written by their octal number. Control
 * characters and what is not UTF-8 become '?'. */
void cml_gnuplot_quote(FILE *out, const char *text);

/* Lets write(out, what, err) write a script that leaves the picture on gnuplot's standard output, and draws
 * it to `path`, which appears only when it is complete. CML_E_IO with gnuplot's own last line when it fails.
 */
CML_NODISCARD cml_status cml_gnuplot_draw(cml_status (*write)(FILE *out, const void *what,
                                                              struct cml_error *err),
                                          const void *what, const char *path, struct cml_error *err);

#endif
