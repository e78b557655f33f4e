/* Reader of ESRI ASCII grids: keywords in any order, then rows of heights. SPDX-License-Identifier: MIT */
#include "input/mesh/esri.h"

#include <ctype.h>
#include <math.h>
#include <string.h>
#include <strings.h>

enum { NCOLS, NROWS, XLLCORNER, YLLCORNER, XLLCENTER, YLLCENTER, CELLSIZE, DX, DY, NODATA, NUM_KEYWORDS };
static const char *const keywords[NUM_KEYWORDS] = {"ncols",     "nrows",       "xllcorner", "yllcorner",
                                                   "xllcenter", "yllcenter",   "cellsize",  "dx",
                                                   "dy",        "NODATA_value"};

struct grid {
    struct cml_text text;
    char *cursor;
    double value[NUM_KEYWORDS];
    bool seen[NUM_KEYWORDS];
    struct cml_error *err;
};

/* Refuses a word of an ESRI grid, with file and line. */
static cml_status fail(const struct grid *g, const char *name, const char *value, const char *expected)
{
    return cml_fail_field(g->err, g->text.path, g->text.line, name, value, expected);
}

/* Returns the next word. Line ends do not matter, because some programs break rows after some numbers. */
static char *next_word(struct grid *g)
{
    for (;;) {
        char *word = g->cursor ? cml_text_word(&g->cursor) : NULL;
        if (word) return word;
        g->cursor = cml_text_next(&g->text);
        if (!g->cursor) return NULL;
    }
}

/* Parses a height or the value of NODATA_value, which some programs write as nan. False: it is no number. */
static bool parse_height(const char *word, double *value)
{
    if (strcasecmp(word, "nan") != 0) return cml_parse_double(word, value);
    *value = NAN;
    return true;
}

/* Checks the value of a keyword at once, so that the message has its line. */
static cml_status check_value(const struct grid *g, int key, const char *word)
{
    const double value = g->value[key];
    if (key == NCOLS || key == NROWS) {
        int whole = 0;
        if (cml_parse_int(word, &whole) && whole >= 2) return CML_OK;
        return fail(g, keywords[key], word, "a whole number of 2 or more");
    }
    if ((key == CELLSIZE || key == DX || key == DY) && !(value >= 1e-30 && value <= 1e30))
        return fail(g, keywords[key], word, "a length of 1e-30..1e30");
    return CML_OK;
}

/* Reads a keyword and its value. Case does not matter; each keyword may come once. */
static cml_status read_keyword(struct grid *g, const char *name)
{
    int key = 0;
    while (key < NUM_KEYWORDS && strcasecmp(name, keywords[key]) != 0) key++;
    if (key == NUM_KEYWORDS)
        return fail(g, "keyword", name,
                    "ncols, nrows, xllcorner, yllcorner, cellsize, NODATA_value or heights");
    const char *word = next_word(g);
    if (g->seen[key]) return fail(g, keywords[key], word, "this keyword only once");
    g->seen[key] = true;
    const bool number =
        word && (key == NODATA ? parse_height(word, &g->value[key]) : cml_parse_double(word, &g->value[key]));
    return number ? check_value(g, key, word) : fail(g, keywords[key], word, "a number");
}

/* Reads the header. *height becomes the first word behind it; NULL: the file ends. Comments that some
 * programs write above or in the header, from a # to the end of the line, are skipped. */
static cml_status read_header(struct grid *g, char **height)
{
    g->value[NODATA] = -9999;
    for (;;) {
        *height = next_word(g);
        if (*height && **height == '#') {
            g->cursor = NULL;
            continue;
        }
        if (!*height || !isalpha((unsigned char)**height) || strcasecmp(*height, "nan") == 0) return CML_OK;
        CML_TRY(read_keyword(g, *height));
    }
}

/* Checks that the header has ncols, nrows and either cellsize or both dx and dy, which would contradict each
 * other together; and that a unit is given. */
static cml_status check_header(const struct grid *g, double unit)
{
    const char *path = g->text.path;
    const bool spacing = g->seen[CELLSIZE] ? !g->seen[DX] && !g->seen[DY] : g->seen[DX] && g->seen[DY];
    for (int key = NCOLS; key <= NROWS; key++)
        if (!g->seen[key])
            return cml_fail_field(g->err, path, 0, keywords[key], NULL, "a whole number of 2 or more");
    if (!spacing)
        return cml_fail_field(g->err, path, 0, "cellsize", NULL, "either cellsize, or both dx and dy, once");
    if (unit > 0) return CML_OK;
    return cml_fail(g->err, CML_E_INPUT,
                    "%s: an ESRI grid has no units (expected units=cm, mm, um or m on the m line)", path);
}

/* Checks the number of heights against the size of the file, at least two bytes each, so that a header alone
 * never asks for memory. */
static cml_status check_size(const struct grid *g)
{
    const double cells = g->value[NCOLS] * g->value[NROWS], most = (double)g->text.size / 2;
    if (cells <= most) return CML_OK;
    return cml_fail(g->err, CML_E_INPUT,
                    "%s: %.0f x %.0f heights in %zu bytes (expected at least 2 for each)", g->text.path,
                    g->value[NCOLS], g->value[NROWS], g->text.size);
}

/* True if a height marks a missing one. Some programs round NODATA_value and heights to different numbers of
 * digits, so six digits must agree, as many as printf's %g writes. */
static bool is_missing(const struct grid *g, double height)
{
    const double rounding = 5e-6, nodata = g->value[NODATA];
    return fabs(height - nodata) <= rounding * fabs(nodata) || isnan(height);
}

/* Reads all heights, row by row, into map->h [cm]. A missing height (NODATA_value) becomes NaN. word: the
 * first height. */
static cml_status read_heights(struct grid *g, const char *word, double unit, struct cml_heightmap *map)
{
    const size_t cells = (size_t)map->nx * (size_t)map->ny;
    for (size_t i = 0; i < cells; i++, word = next_word(g)) {
        double height = 0;
        const bool number = word && parse_height(word, &height), missing = number && is_missing(g, height);
        if (!number || (!missing && fabs(height * unit) > CML_HIGHEST_SAMPLE))
            return fail(
                g,
                CML_TEXT("height in row %zu, column %zu", i / (size_t)map->nx + 1, i % (size_t)map->nx + 1),
                word,
                !word     ? "ncols x nrows numbers, the file ends before"
                : !number ? "a number"
                          : "-1e30..1e30 cm, or NODATA_value");
        map->h[i] = missing ? NAN : height * unit;
    }
    return word ? fail(g, "word behind the last height", word, "the end of the file") : CML_OK;
}

/* Reads header and heights of an ESRI ASCII grid. unit: cm per unit of the file. */
static cml_status read_grid(struct grid *g, double unit, struct cml_heightmap *map)
{
    char *word = NULL;
    CML_TRY(read_header(g, &word));
    CML_TRY(check_header(g, unit));
    CML_TRY(check_size(g));
    CML_TRY(cml_heightmap_allocate(g->text.path, g->value[NCOLS], g->value[NROWS], map, g->err));
    map->dx = g->value[g->seen[CELLSIZE] ? CELLSIZE : DX] * unit;
    map->dy = g->value[g->seen[CELLSIZE] ? CELLSIZE : DY] * unit;
    CML_TRY(read_heights(g, word, unit, map));
    return cml_heightmap_check(g->text.path, map, g->err);
}

cml_status cml_esri_read(const struct cml_text_source *source, const char *path, double unit,
                         struct cml_heightmap *map, struct cml_error *err)
{
    struct grid g = {.err = err};
    *map = (struct cml_heightmap){0};
    CML_TRY(cml_text_read(source, path, &g.text, err));
    const cml_status status = read_grid(&g, unit, map);
    cml_text_clear(&g.text);
    if (status == CML_OK)
        cml_heightmap_centre(map);
    else
        cml_heightmap_clear(map);
    return status;
}
