/* SPDX-License-Identifier: MIT */
#include "plot/plot_parts.h"

#include <math.h>
#include <string.h>

/* Points, and what fits across a picture. */
enum { LINE = 17, LINE_CHARACTERS = 118 };

/* A path that ends in a slash keeps it, so that the name is never empty. */
const char *cml_plot_base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

/* The middle goes, because names of one series differ at their ends. */
void cml_plot_name(const char *const *paths, int count, int i, size_t most, char name[CML_PLOT_NAME])
{
    const char *text = cml_plot_base_name(paths[i]);
    for (int j = 0; j < count; j++)
        if (j != i && strcmp(text, cml_plot_base_name(paths[j])) == 0) {
            text = paths[i];
            break;
        }
    const size_t length = strlen(text), half = (most - 3) / 2;
    if (length <= most)
        snprintf(name, CML_PLOT_NAME, "%s", text);
    else
        snprintf(name, CML_PLOT_NAME, "%.*s...%s", (int)half, text, text + length - half);
}

/* Bytes of the caption's first line. */
static size_t line_length(const char *rest)
{
    const size_t length = strlen(rest);
    if (length <= LINE_CHARACTERS) return length;
    size_t end = LINE_CHARACTERS;
    while (end > 1 && rest[end] != ' ') end--;
    return end == 1 ? LINE_CHARACTERS : end;
}

/* gnuplot breaks no lines, so each is a label of its own; labels 1 to 9 belong to the pictures. */
int cml_plot_caption(FILE *out, const char *caption, enum cml_picture picture, int top, int height)
{
    int lines = 0;
    for (const char *rest = caption ? caption : ""; *rest; lines++) {
        const size_t length = line_length(rest);
        char line[LINE_CHARACTERS + 1];
        snprintf(line, sizeof line, "%.*s", (int)length, rest);
        if (out) {
            fprintf(out, "set label %d ", 10 + lines);
            cml_gnuplot_quote(out, line);
            fprintf(out, " at screen 0.02,%.6f left font ',%d' textcolor rgb '#404040'\n",
                    (double)(top - LINE * lines) / height, picture == CML_PICTURE_SVG ? 13 : 10);
        }
        rest += length + strspn(rest + length, " ");
    }
    return LINE * lines;
}

/* Borders between 1, 2, 5 and 10 a little above their geometric means. */
double cml_plot_round_step(double length)
{
    const double power = pow(10, floor(log10(length))), digit = length / power;
    return power * (digit < 1.5 ? 1 : digit < 3.5 ? 2 : digit < 7.5 ? 5 : 10);
}
