/* SPDX-License-Identifier: MIT */
#include "plot/files/curve.h"

#include "base/array.h"
#include "base/text.h"

#include <stdlib.h>
#include <string.h>

enum { PLACE, VALUE, ERROR, NUM_COLUMNS, MOST_CELLS = 64 };

/* A file as cells, and where one quantity stands in its lines. */
struct table {
    struct cml_text text;
    const struct cml_curve_columns *wanted;
    char *line;              /* that is read next, NULL: none */
    int column[NUM_COLUMNS]; /* where it stands, -1: nowhere */
    struct cml_curve *curve;
    struct cml_error *err;
};

cml_status cml_curve_create(int n, bool errors, struct cml_curve *curve, struct cml_error *err)
{
    const size_t size = (size_t)(n > 0 ? n : 1);
    *curve = (struct cml_curve){.n = n, .x = calloc(size, sizeof(double)), .y = calloc(size, sizeof(double))};
    if (errors) curve->error = calloc(size, sizeof(double));
    if (curve->x && curve->y && (curve->error || !errors)) return CML_OK;
    cml_curve_free(curve);
    return cml_fail_memory(err, 24.0 * (double)size, "a curve");
}

void cml_curve_free(struct cml_curve *curve)
{
    free(curve->x);
    free(curve->y);
    free(curve->error);
    *curve = (struct cml_curve){0};
}

/* ---- lines and cells ---- */

/* Fails with file and line, as every reader of ours does. */
static cml_status fail(const struct table *t, const char *field, const char *value, const char *expected)
{
    return cml_fail_field(t->err, t->text.path, t->text.line, field, value, expected);
}

/* Comments and empty lines may stand anywhere. */
static void next_line(struct table *t)
{
    do t->line = cml_text_next(&t->text);
    while (t->line && (t->line[0] == '#' || t->line[strspn(t->line, " \t\r")] == '\0'));
}

/* Cuts a line into its cells; returns how many, at most MOST_CELLS. Between two commas there may be nothing,
 * between two words any number of blanks. */
static int cut_cells(char *line, char *cells[MOST_CELLS])
{
    const bool commas = strchr(line, ',') != NULL;
    int count = 0;
    for (char *rest = line; rest && count < MOST_CELLS;) {
        rest += strspn(rest, " \t\r");
        if (!commas && *rest == '\0') break;
        cells[count++] = rest;
        char *end = rest + strcspn(rest, commas ? "," : " \t\r");
        char *next = *end ? end + 1 : NULL;
        while (end > rest && strchr(" \t\r", end[-1])) end--;
        *end = '\0';
        rest = next;
    }
    return count;
}

/* "Rd_r" also as "Rd_r_per_cm2". */
static bool names_value(const char *cell, const char *value)
{
    const size_t length = strlen(value);
    return strncmp(cell, value, length) == 0 &&
           (cell[length] == '\0' || strncmp(cell + length, "_per_", 5) == 0);
}

/* Whether the names are ours: then the place is among them. */
static bool find_columns(struct table *t, char *const *cells, int count)
{
    for (int c = 0; c < NUM_COLUMNS; c++) t->column[c] = -1;
    for (int i = 0; i < count; i++) {
        const size_t length = strlen(t->wanted->value);
        if (strcmp(cells[i], t->wanted->place) == 0) t->column[PLACE] = i;
        if (names_value(cells[i], t->wanted->value)) t->column[VALUE] = i;
        if (strncmp(cells[i], t->wanted->value, length) == 0 && strcmp(cells[i] + length, "_se") == 0)
            t->column[ERROR] = i;
    }
    return t->column[PLACE] >= 0;
}

/* The first line decides: names of ours, or two or three columns. *line becomes the first of numbers; *named
 * tells which form it is. */
static cml_status read_names(struct table *t, bool *named)
{
    static const char expected[] = "two or three columns of numbers: place, value, standard error";
    char *cells[MOST_CELLS], copy[1024];
    double number;
    next_line(t);
    *named = false;
    if (!t->line) return fail(t, "columns", NULL, expected);
    snprintf(copy, sizeof copy, "%s", t->line);
    const int count = cut_cells(copy, cells);
    *named = find_columns(t, cells, count);
    if (*named || !cml_parse_double(cells[0], &number)) next_line(t);
    if (*named) return CML_OK;
    if (count < 2 || count > 3) return fail(t, "columns", cells[0], expected);
    for (int c = 0; c < NUM_COLUMNS; c++) t->column[c] = c < count ? c : -1;
    return CML_OK;
}

/* ---- rows ---- */

/* No place and no density of light is below 0. */
static cml_status read_cell(const struct table *t, int column, char *const *cells, int count, double *number)
{
    const char *const names[NUM_COLUMNS] = {t->wanted->place, t->wanted->value, "standard error"};
    const int i = t->column[column];
    if (i < 0) return CML_OK;
    if (i >= count) return fail(t, "row", NULL, "as many columns as in the first line");
    if (!cml_parse_double(cells[i], number) || !(*number >= 0 && *number <= 1e300))
        return fail(t, names[column], cells[i], "a number of 0 or more");
    return CML_OK;
}

static cml_status grow(const struct table *t)
{
    struct cml_curve *curve = t->curve;
    const size_t n = (size_t)curve->n;
    CML_TRY(cml_array_grow(&curve->x, n, sizeof *curve->x, "a curve", t->err));
    CML_TRY(cml_array_grow(&curve->y, n, sizeof *curve->y, "a curve", t->err));
    if (t->column[ERROR] < 0) return CML_OK;
    return cml_array_grow(&curve->error, n, sizeof *curve->error, "a curve", t->err);
}

static cml_status read_row(struct table *t)
{
    char *cells[MOST_CELLS];
    double row[NUM_COLUMNS] = {0, 0, 0};
    const int most = 1000000, count = cut_cells(t->line, cells);
    struct cml_curve *curve = t->curve;
    for (int c = 0; c < NUM_COLUMNS; c++) CML_TRY(read_cell(t, c, cells, count, &row[c]));
    if (curve->n == most) return fail(t, "rows", NULL, "at most 1000000");
    CML_TRY(grow(t));
    if (curve->n > 0 && !(row[PLACE] > curve->x[curve->n - 1]))
        return fail(t, t->wanted->place, cells[t->column[PLACE]], "more than in the row before");
    curve->x[curve->n] = row[PLACE];
    curve->y[curve->n] = row[VALUE];
    if (curve->error) curve->error[curve->n] = row[ERROR];
    curve->n++;
    return CML_OK;
}

/* Two at least: from one no step can be told. */
static cml_status read_rows(struct table *t)
{
    struct cml_curve *curve = t->curve;
    for (; t->line; next_line(t)) CML_TRY(read_row(t));
    if (curve->n < 2) return fail(t, "rows", NULL, "2 or more");
    curve->end = 2 * curve->x[curve->n - 1] - curve->x[curve->n - 2];
    return CML_OK;
}

/* The file once for each quantity: it is small. `first` of two, to which numbers without names belong. */
static cml_status read_one(const char *path, const struct cml_curve_columns *wanted, bool first,
                           struct cml_curve *curve, struct cml_error *err)
{
    struct table t = {.wanted = wanted, .curve = curve, .err = err};
    bool named = false;
    CML_TRY(cml_text_read(NULL, path, &t.text, err));
    cml_status status = read_names(&t, &named);
    if (status == CML_OK && (named ? t.column[VALUE] >= 0 : first)) status = read_rows(&t);
    cml_text_clear(&t.text);
    return status;
}

cml_status cml_curve_read(const char *path, const struct cml_curve_columns *wanted, int count,
                          struct cml_curve *curves, struct cml_error *err)
{
    cml_status status = CML_OK;
    int points = 0;
    for (int i = 0; i < count; i++) curves[i] = (struct cml_curve){0};
    for (int i = 0; i < count && status == CML_OK; i++) {
        status = read_one(path, &wanted[i], i == 0, &curves[i], err);
        points += curves[i].n;
    }
    if (status == CML_OK && points == 0)
        status = cml_fail(err, CML_E_INPUT, "%s: %s is missing (expected a column of this name%s%s)", path,
                          wanted[0].value, count > 1 ? ", or " : "", count > 1 ? wanted[1].value : "");
    for (int i = 0; i < count && status != CML_OK; i++) cml_curve_free(&curves[i]);
    return status;
}
