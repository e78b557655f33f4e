/* SPDX-License-Identifier: MIT */
#include "plot/plot_parts.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* Points, and what fits across a picture. */
enum { LINE = 17, LINE_LETTERS = 112 };

const struct cml_axis_range cml_axis_range_any = {NAN, NAN};

/* gnuplot draws axes of 1e-6 of their ends; it cannot number those that overflow. */
cml_status cml_axis_range_apply(const struct cml_axis_range *range, const char *option, double *from,
                                double *to, struct cml_error *err)
{
    if (isnan(range->from) && isnan(range->to)) return CML_OK;
    if (!isnan(range->from)) *from = range->from;
    if (!isnan(range->to)) *to = range->to;
    const double size = fmax(fabs(*from), fabs(*to));
    if (size >= 1e-30 && size <= 1e30 && *to - *from >= 1e-4 * size) return CML_OK;
    return cml_fail(err, CML_E_INPUT,
                    "%s: the axis would go from %g to %g (expected a length of 1e-4 of its ends or more, and "
                    "ends of 1e-30..1e30)",
                    option, *from, *to);
}

cml_status cml_axis_range_within(const struct cml_axis_range *range, const char *option, double *from,
                                 double *to, struct cml_error *err)
{
    if (*to > *from && (range->from >= *to || range->to <= *from))
        return cml_fail(err, CML_E_INPUT, "%s beyond all that is lit (expected some of %g:%g)", option, *from,
                        *to);
    return cml_axis_range_apply(range, option, from, to, err);
}

/* A path that ends in a slash keeps it, so that the name is never empty. */
const char *cml_plot_base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

/* Folders tell files of one name apart. */
const char *cml_plot_name(const char *const *paths, int count, int i)
{
    const char *name = cml_plot_base_name(paths[i]);
    for (int j = 0; j < count; j++)
        if (j != i && strcmp(name, cml_plot_base_name(paths[j])) == 0) return paths[i];
    return name;
}

/* Whether a byte begins a letter: in UTF-8 all others of it begin with the bits 10. */
static bool begins_letter(char byte)
{
    return ((unsigned char)byte & 0xC0) != 0x80;
}

size_t cml_plot_letters(const char *text)
{
    size_t letters = 0;
    for (; *text; text++) letters += begins_letter(*text);
    return letters;
}

/* Bytes of the first `letters` letters. */
static size_t bytes_of(const char *text, size_t letters)
{
    size_t i = 0;
    for (; text[i]; i++)
        if (begins_letter(text[i]) && letters-- == 0) break;
    return i;
}

/* The middle goes, because names of one series differ at their ends. */
void cml_plot_cut(const char *text, size_t most, char name[CML_PLOT_NAME])
{
    const size_t letters = cml_plot_letters(text), half = (most - 3) / 2;
    if (letters <= most)
        snprintf(name, CML_PLOT_NAME, "%s", text);
    else
        snprintf(name, CML_PLOT_NAME, "%.*s...%s", (int)bytes_of(text, half), text,
                 text + bytes_of(text, letters - half));
}

/* Bytes of the caption's first line. */
static size_t line_length(const char *rest)
{
    const size_t most = bytes_of(rest, LINE_LETTERS);
    size_t end = most;
    if (!rest[most]) return most;
    while (end > 1 && rest[end] != ' ') end--;
    return end == 1 ? most : end;
}

/* gnuplot breaks no lines, so each is a label of its own; labels below 30 belong to the pictures. */
int cml_plot_caption(const struct cml_page *page, const char *caption, int top)
{
    int lines = 0;
    for (const char *rest = caption ? caption : ""; *rest; lines++) {
        const size_t length = line_length(rest);
        char line[4 * LINE_LETTERS + 1];
        snprintf(line, sizeof line, "%.*s", (int)length, rest);
        if (page)
            cml_page_write(page, 30 + lines, 18, top - LINE * lines, CML_ALIGN_LEFT, CML_PAGE_SMALL, line);
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

void cml_plot_log_ticks(FILE *out, const char *axis, double low, double high)
{
    if (!(low > 0) || high > 1e3 * low) return;
    const char *comma = "";
    fprintf(out, "set %s (", axis);
    for (int power = (int)floor(log10(low)); power <= (int)ceil(log10(high)); power++)
        for (int digit = 1; digit <= 5; digit += digit == 1 ? 1 : 3) {
            fprintf(out, "%s'%g' %g", comma, digit * pow(10, power), digit * pow(10, power));
            comma = ", ";
        }
    fputs(")\n", out);
}
