/* Drawing by gnuplot: the parts of a script that all pictures share, and the process that draws.
 * Script on gnuplot's standard input, picture from its standard output, so that no name of a file is ever
 * part of a command. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>
#include <stdio.h>

enum cml_picture { CML_PICTURE_SVG, CML_PICTURE_PNG, CML_PICTURE_PDF, CML_PICTURE_EPS };

/* What the end of the name asks for; CML_E_INPUT when it is none of .svg, .png, .pdf and .eps. */
CML_NODISCARD cml_status cml_picture_of(const char *path, enum cml_picture *picture, struct cml_error *err);

/* A picture and its size in points, which are the same for all formats: places are counted from its lower
 * left corner. An SVG has a unit per point, a PNG two pixels; PDF and EPS are 7 inches wide at 900 points. */
struct cml_page {
    FILE *out;
    enum cml_picture picture;
    int width, height;
};

/* Points: the width of every page, and where the middle of a curve's upright axis title lies. */
enum { CML_PAGE_WIDTH = 900, CML_PAGE_TITLE_LEFT = 20 };

/* Sizes of letters in points: of titles, of axes, of what stands beside them. */
enum { CML_PAGE_LARGE = 18, CML_PAGE_NORMAL = 15, CML_PAGE_SMALL = 13 };

/* Terminal, frame and grid. */
void cml_page_begin(const struct cml_page *page);

/* The four sides of the panel that is plotted next. */
void cml_page_panel(const struct cml_page *page, double left, double right, double bottom, double top);

/* A text in gnuplot's label `number`, at its middle's height; it replaces the one of that number. Upright:
 * turned by 90 degrees, centred. */
enum cml_align { CML_ALIGN_LEFT, CML_ALIGN_CENTER, CML_ALIGN_RIGHT, CML_ALIGN_UPRIGHT };
void cml_page_write(const struct cml_page *page, int number, double x, double y, enum cml_align align,
                    int size, const char *text);

/* The text as a string of gnuplot, in double quotes. A backslash stands before quotes and backslashes; what
 * stands in backquotes, gnuplot would run as a command, so these are written by their octal number. What an
 * SVG may not hold becomes "?": control characters, what is not UTF-8, the first bracket of "]]>". */
void cml_gnuplot_quote(FILE *out, const char *text);

/* Lets write(out, what, err) write a script that leaves the picture on gnuplot's standard output, and draws
 * it to `path`, which appears only when it is complete. CML_E_IO with gnuplot's own last line when it fails.
 */
CML_NODISCARD cml_status cml_gnuplot_draw(cml_status (*write)(FILE *out, const void *what,
                                                              struct cml_error *err),
                                          const void *what, const char *path, struct cml_error *err);
