/* SPDX-License-Identifier: MIT */
#include "plot/swept.h"

#include "base/array.h"
#include "base/text.h"
#include "input/sweep/sweep_table.h"
#include "result/quantity.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The most rows of a picture of curves: pairs of rows are compared. */
enum { MOST_ROWS = 5000 };

/* Where the columns stand; -1: there is none. */
struct columns {
    const struct cml_sweep_table *table;
    int of, error, over, by;
};

static const char *cell_of(const struct columns *c, int row, int column)
{
    return c->table->cell[(size_t)row * (size_t)c->table->num_columns + (size_t)column];
}

static double number_of(const struct columns *c, int row, int column)
{
    double value = NAN;
    (void)cml_parse_double(cell_of(c, row, column), &value);
    return value;
}

static int find(const struct cml_sweep_table *table, const char *name)
{
    for (int i = 0; i < table->num_columns; i++)
        if (strcmp(table->name[i], name) == 0) return i;
    return -1;
}

/* ---- the choice of columns ---- */

static bool differs(const struct columns *c, int column)
{
    for (int row = 1; row < c->table->num_rows; row++)
        if (strcmp(cell_of(c, row, column), cell_of(c, 0, column)) != 0) return true;
    return false;
}

static bool is_numeric(const struct columns *c, int column)
{
    double value;
    for (int row = 0; row < c->table->num_rows; row++)
        if (!cml_parse_double(cell_of(c, row, column), &value)) return false;
    return true;
}

/* What was swept, or carried along: behind the row, before the first total. */
static int num_parameters(const struct cml_sweep_table *table)
{
    return find(table, cml_quantities[0].name);
}

/* A label that is a number says best what a row is. Numbers of photons and seeds come last by themselves. */
static int choose_over(const struct columns *c)
{
    for (int labels = 1; labels >= 0; labels--)
        for (int i = 1; i < num_parameters(c->table); i++)
            if (c->table->label[i] == labels && differs(c, i) && is_numeric(c, i)) return i;
    return -1;
}

/* The first of two rows that a picture could not tell apart, the second in *other; -1: none. */
static int find_same(const struct columns *c, int by, int *other)
{
    for (int i = 0; i < c->table->num_rows; i++) {
        const double at = number_of(c, i, c->over);
        for (int k = i + 1; k < c->table->num_rows; k++)
            if (number_of(c, k, c->over) == at &&
                (by < 0 || strcmp(cell_of(c, i, by), cell_of(c, k, by)) == 0)) {
                *other = k;
                return i;
            }
    }
    return -1;
}

/* Whether a curve begins with the row. */
static bool begins(const struct columns *c, int by, int row)
{
    for (int before = 0; before < row; before++)
        if (by < 0 || strcmp(cell_of(c, row, by), cell_of(c, before, by)) == 0) return false;
    return true;
}

/* What makes the fewest curves. */
static int choose_by(const struct columns *c)
{
    int other, best = -1, fewest = c->table->num_rows + 1;
    if (find_same(c, -1, &other) < 0) return -1;
    for (int i = 1; i < num_parameters(c->table); i++) {
        int curves = 0;
        if (i == c->over || !differs(c, i) || find_same(c, i, &other) >= 0) continue;
        for (int row = 0; row < c->table->num_rows; row++) curves += begins(c, i, row);
        if (curves < fewest) best = i;
        if (curves < fewest) fewest = curves;
    }
    return best;
}

/* What has an axis, and means of detectors, are in no table. */
static bool is_of_rows(const char *name)
{
    int i = 0;
    while (i < CML_NUM_QUANTITIES && strcmp(cml_quantities[i].name, name) != 0) i++;
    return i < CML_NUM_QUANTITIES || strncmp(name, "detector_", 9) == 0;
}

static cml_status fail_name(const struct cml_sweep_table *table, const char *option, const char *name,
                            struct cml_error *err)
{
    char names[600] = "";
    for (int i = 0; i < table->num_columns && strlen(names) < 500; i++)
        snprintf(names + strlen(names), sizeof names - strlen(names), "%s%s", i > 0 ? ", " : "",
                 table->name[i]);
    return cml_fail(err, CML_E_INPUT, "--%s %.80s (expected a column of %.200s: %s%s)", option, name,
                    table->text.path, names,
                    is_of_rows(name) ? "; of a row it stands in the result that the column file names" : "");
}

/* A column of numbers that the user has named. */
static cml_status find_numbers(const struct columns *c, const char *option, const char *name, int *column,
                               struct cml_error *err)
{
    *column = find(c->table, name);
    if (*column < 0) return fail_name(c->table, option, name, err);
    if (is_numeric(c, *column)) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "--%s %.80s (expected a column of numbers)", option, name);
}

static cml_status find_of(struct columns *c, const char *name, struct cml_error *err)
{
    char error[CML_SETTING_NAME + 4];
    if (num_parameters(c->table) < 1 || find(c->table, "row") != 0)
        return cml_fail(err, CML_E_INPUT, "%s: row and Rsp (expected columns of a sweep's results)",
                        c->table->text.path);
    CML_TRY(find_numbers(c, "of", name ? name : "Rd", &c->of, err));
    snprintf(error, sizeof error, "%s_se", c->table->name[c->of]);
    c->error = find(c->table, error);
    return CML_OK;
}

static cml_status choose(struct columns *c, const struct cml_swept_names *names, struct cml_error *err)
{
    int other = 0;
    if (c->table->num_rows > MOST_ROWS)
        return cml_fail(err, CML_E_INPUT, "%s: %d rows (expected at most %d, for curves)",
                        c->table->text.path, c->table->num_rows, MOST_ROWS);
    CML_TRY(find_of(c, names->of, err));
    c->over = choose_over(c);
    if (names->over) CML_TRY(find_numbers(c, "over", names->over, &c->over, err));
    if (c->over < 0)
        return cml_fail(err, CML_E_INPUT, "%s: rows (expected two that differ in a number, or --over)",
                        c->table->text.path);
    c->by = names->by ? find(c->table, names->by) : choose_by(c);
    if (names->by && c->by < 0) return fail_name(c->table, "by", names->by, err);
    const int same = find_same(c, c->by, &other);
    if (same < 0) return CML_OK;
    return cml_fail(
        err, CML_E_INPUT,
        "%.200s: rows %d and %d both have %s = %.40s (expected --by, a column that tells them apart)",
        c->table->text.path, same + 1, other + 1, c->table->name[c->over], cell_of(c, same, c->over));
}

/* ---- curves ---- */

static bool of_curve(const struct columns *c, int row, int first)
{
    return c->by < 0 || strcmp(cell_of(c, row, c->by), cell_of(c, first, c->by)) == 0;
}

/* Inserts the value of a row into the curve, so that x rises. */
static void insert(const struct columns *c, int row, struct cml_curve *curve)
{
    const double x = number_of(c, row, c->over);
    int i = curve->n++;
    for (; i > 0 && curve->x[i - 1] > x; i--) {
        curve->x[i] = curve->x[i - 1];
        curve->y[i] = curve->y[i - 1];
        if (curve->error) curve->error[i] = curve->error[i - 1];
    }
    curve->x[i] = x;
    curve->y[i] = number_of(c, row, c->of);
    if (curve->error) curve->error[i] = number_of(c, row, c->error);
    curve->end = fmax(curve->end, x);
}

/* Adds the curve of all rows that share the value of the first one. */
static cml_status add_curve(const struct columns *c, int first, struct cml_swept *swept,
                            struct cml_error *err)
{
    const size_t count = (size_t)swept->count + 1;
    if (count > CML_SWEPT_CURVES)
        return cml_fail(err, CML_E_INPUT, "%s: more than %d curves (expected fewer values of %s)",
                        c->table->text.path, CML_SWEPT_CURVES,
                        c->by < 0 ? "all tables" : c->table->name[c->by]);
    CML_TRY(cml_array_grow(&swept->curve, count - 1, sizeof *swept->curve, "the curves", err));
    CML_TRY(cml_array_grow(&swept->name, count - 1, sizeof *swept->name, "the curves", err));
    struct cml_curve *curve = &swept->curve[swept->count];
    CML_TRY(cml_curve_create(c->table->num_rows, c->error >= 0, curve, err));
    curve->n = 0;
    curve->end = -INFINITY;
    for (int row = first; row < c->table->num_rows; row++)
        if (of_curve(c, row, first)) insert(c, row, curve);
    snprintf(swept->name[swept->count++], CML_SWEPT_NAME, "%s%s%.70s", c->by < 0 ? "" : c->table->name[c->by],
             c->by < 0 ? "" : " = ", c->by < 0 ? "" : cell_of(c, first, c->by));
    return CML_OK;
}

static cml_status add_curves(const struct columns *c, struct cml_swept *swept, struct cml_error *err)
{
    snprintf(swept->of, sizeof swept->of, "%s", c->table->name[c->of]);
    snprintf(swept->over, sizeof swept->over, "%s", c->table->name[c->over]);
    for (int row = 0; row < c->table->num_rows; row++)
        if (begins(c, c->by, row)) CML_TRY(add_curve(c, row, swept, err));
    return CML_OK;
}

cml_status cml_swept_add(const char *path, const struct cml_swept_names *names, struct cml_swept *swept,
                         struct cml_error *err)
{
    CML_AT_END(cml_sweep_table_clear) struct cml_sweep_table table = {0};
    struct columns c = {.table = &table};
    CML_TRY(cml_sweep_table_read(NULL, path, &table, err));
    CML_TRY(choose(&c, names, err));
    return add_curves(&c, swept, err);
}

void cml_swept_clear(struct cml_swept *swept)
{
    for (int i = 0; i < swept->count; i++) cml_curve_free(&swept->curve[i]);
    free(swept->curve);
    free(swept->name);
    *swept = (struct cml_swept){0};
}

/* ---- maps ---- */

/* The different values of a column, rising; returns how many. */
static size_t find_values(const struct columns *c, int column, double *values)
{
    const size_t rows = (size_t)c->table->num_rows;
    for (size_t i = 0; i < rows; i++) values[i] = number_of(c, (int)i, column);
    return cml_sort_distinct(values, rows);
}

/* Writes as many ticks as have room. */
static void write_ticks(const double *values, size_t n, char ticks[CML_SWEPT_TICKS])
{
    const size_t most = 12, step = (n + most - 1) / most;
    size_t used = 0;
    for (size_t i = 0; i < n; i += step)
        used += (size_t)snprintf(ticks + used, CML_SWEPT_TICKS - used, "%s'%.6g' %zu", i > 0 ? ", " : "",
                                 values[i], i);
}

/* Places of values: [2][num_rows]. */
static cml_status fill_map(const struct columns *c, const int over[2], const double *values,
                           struct cml_pixels *map, struct cml_error *err)
{
    const size_t rows = (size_t)c->table->num_rows, size = map->n[0] * map->n[1];
    map->value = malloc(size * sizeof *map->value);
    if (!map->value) return cml_fail_memory(err, (double)(size * sizeof *map->value), "the map");
    for (size_t i = 0; i < size; i++) map->value[i] = NAN;
    for (size_t row = 0; row < rows; row++) {
        size_t at[2];
        for (int a = 0; a < 2; a++) {
            const double value = number_of(c, (int)row, over[a]), *all = values + (size_t)a * rows;
            at[a] =
                (size_t)((const double *)bsearch(&value, all, map->n[a], sizeof value, cml_compare_doubles) -
                         all);
        }
        float *pixel = &map->value[at[1] * map->n[0] + at[0]];
        if (!isnan(*pixel))
            return cml_fail(
                err, CML_E_INPUT,
                "%.200s: row %zu has %s = %.40s and %s = %.40s as another (expected one row for each)",
                c->table->text.path, row + 1, c->table->name[over[0]], cell_of(c, (int)row, over[0]),
                c->table->name[over[1]], cell_of(c, (int)row, over[1]));
        *pixel = (float)number_of(c, (int)row, c->of);
    }
    return CML_OK;
}

static cml_status make_map(struct columns *c, const struct cml_swept_names *names, const char *const over[2],
                           struct cml_pixels *map, char ticks[2][CML_SWEPT_TICKS], struct cml_error *err)
{
    const size_t rows = (size_t)c->table->num_rows;
    int column[2];
    CML_TRY(find_of(c, names->of, err));
    for (int a = 0; a < 2; a++) CML_TRY(find_numbers(c, "over", over[a], &column[a], err));
    double *values = malloc(2 * rows * sizeof *values);
    if (!values) return cml_fail_memory(err, (double)(2 * rows * sizeof *values), "the map");
    for (size_t a = 0; a < 2; a++) {
        map->n[a] = find_values(c, column[a], values + a * rows);
        map->origin[a] = -0.5;
        map->spacing[a] = 1;
        write_ticks(values + a * rows, map->n[a], ticks[a]);
    }
    const cml_status status = fill_map(c, column, values, map, err);
    free(values);
    if (status != CML_OK) cml_pixels_clear(map);
    return status;
}

cml_status cml_swept_map(const char *path, const struct cml_swept_names *names, const char *const over[2],
                         struct cml_pixels *map, char ticks[2][CML_SWEPT_TICKS], struct cml_error *err)
{
    CML_AT_END(cml_sweep_table_clear) struct cml_sweep_table table = {0};
    struct columns c = {.table = &table};
    CML_TRY(cml_sweep_table_read(NULL, path, &table, err));
    return make_map(&c, names, over, map, ticks, err);
}
