/* SPDX-License-Identifier: MIT */
#include "plot/curve.h"

#include "base/text.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { BIN, RADIUS, REFLECTANCE, TRANSMITTANCE, NUM_COLUMNS, MOST_BINS = 1000000 };
static const char *const names[NUM_COLUMNS] = {"bin", "r_mid_cm", "Rd_r_per_cm2", "Tt_r_per_cm2"};

/* The file while it is read: which columns it has, and all rows. */
struct table {
    struct cml_text text;
    int column[NUM_COLUMNS]; /* where it stands, -1: nowhere */
    double (*row)[NUM_COLUMNS];
    size_t count, capacity;
    struct cml_error *err;
};

/* With file and line, as every reader of ours. */
static cml_status fail(const struct table *t, const char *field, const char *value, const char *expected)
{
    return cml_fail_field(t->err, t->text.path, t->text.line, field, value, expected);
}

/* The next cell of a line, NULL behind the last. */
static char *next_cell(char **cursor)
{
    char *cell = *cursor;
    if (!cell) return NULL;
    char *comma = strchr(cell, ',');
    if (comma) *comma = '\0';
    *cursor = comma ? comma + 1 : NULL;
    return cell;
}

/* Comments and empty lines may stand anywhere. */
static char *next_line(struct table *t)
{
    char *line = cml_text_next(&t->text);
    while (line && (line[0] == '#' || line[0] == '\0')) line = cml_text_next(&t->text);
    return line;
}

/* Other columns are allowed and skipped: the files of others have more than we draw. */
static cml_status read_names(struct table *t)
{
    char *cursor = next_line(t), *cell = NULL;
    for (int c = 0; c < NUM_COLUMNS; c++) t->column[c] = -1;
    for (int i = 0; (cell = next_cell(&cursor)) != NULL; i++)
        for (int c = 0; c < NUM_COLUMNS; c++)
            if (strcmp(cell, names[c]) == 0) t->column[c] = i;
    for (int c = BIN; c <= RADIUS; c++)
        if (t->column[c] < 0) return fail(t, names[c], NULL, "a column of this name");
    if (t->column[REFLECTANCE] >= 0 || t->column[TRANSMITTANCE] >= 0) return CML_OK;
    return fail(t, names[REFLECTANCE], NULL, "a column of this name, or Tt_r_per_cm2");
}

/* Densities below 0 cannot be drawn on a log scale, and are nothing that light can do. */
static cml_status read_cell(const struct table *t, int column, const char *cell, double row[NUM_COLUMNS])
{
    const double most = column == BIN ? MOST_BINS - 2 : 1e300;
    if (!cml_parse_double(cell, &row[column]) || row[column] < 0 || row[column] > most ||
        (column == BIN && row[column] != floor(row[column])))
        return fail(t, names[column], cell,
                    column == BIN ? "a whole number of 0..999998" : "a number of 0 or more");
    return CML_OK;
}

/* Bins must rise, so that each is there once, and the last row has the largest. */
static cml_status read_row(struct table *t, char *cursor)
{
    double row[NUM_COLUMNS] = {0, 0, 0, 0};
    char *cell = NULL;
    int found = 0, wanted = 0;
    for (int c = 0; c < NUM_COLUMNS; c++) wanted += t->column[c] >= 0;
    for (int i = 0; (cell = next_cell(&cursor)) != NULL; i++)
        for (int c = 0; c < NUM_COLUMNS; c++) {
            if (t->column[c] != i) continue;
            CML_TRY(read_cell(t, c, cell, row));
            found++;
        }
    if (found < wanted) return fail(t, "row", NULL, "a value in every column that the first line names");
    if (t->count > 0 && row[BIN] <= t->row[t->count - 1][BIN])
        return cml_fail(t->err, CML_E_INPUT, "%s:%d: bin = %.0f (expected more than the one before)",
                        t->text.path, t->text.line, row[BIN]);
    memcpy(t->row[t->count++], row, sizeof row);
    return CML_OK;
}

/* Two rows at least: from one no width of a bin can be told. */
static cml_status read_rows(struct table *t)
{
    for (char *line = next_line(t); line; line = next_line(t)) {
        if (t->count == t->capacity) {
            t->capacity = t->capacity ? 2 * t->capacity : 256;
            void *larger = realloc(t->row, t->capacity * sizeof *t->row);
            if (!larger) return cml_fail_memory(t->err, 32.0 * (double)t->capacity, "a curve");
            t->row = larger;
        }
        CML_TRY(read_row(t, line));
    }
    return t->count > 1 ? CML_OK : fail(t, "rows", NULL, "2 or more");
}

/* One bin width must explain all radii. */
static cml_status make_result(const struct table *t, struct cml_mco *mco)
{
    const double *last = t->row[t->count - 1];
    *mco =
        (struct cml_mco){.dr = last[RADIUS] / (last[BIN] + 0.5), .dz = 1, .nz = 1, .na = 1, .num_layers = 1};
    mco->nr = (int)last[BIN] + 2;
    for (size_t i = 0; i < t->count; i++)
        if (!(fabs(t->row[i][RADIUS] - (t->row[i][BIN] + 0.5) * mco->dr) < 0.01 * mco->dr))
            return cml_fail(
                t->err, CML_E_INPUT, "%s: r_mid_cm = %g in bin %.0f (expected %g, the middle of the bin)",
                t->text.path, t->row[i][RADIUS], t->row[i][BIN], (t->row[i][BIN] + 0.5) * mco->dr);
    CML_TRY(cml_mco_allocate(mco, t->err));
    for (size_t i = 0; i < t->count; i++) {
        mco->Rd_r[(size_t)t->row[i][BIN]] = t->row[i][REFLECTANCE];
        mco->Tt_r[(size_t)t->row[i][BIN]] = t->row[i][TRANSMITTANCE];
    }
    return CML_OK;
}

/* As a result whose other arrays are zero, so that the plot need not tell curves from results. */
cml_status cml_curve_read(const char *path, struct cml_mco *mco, struct cml_error *err)
{
    struct table t = {.err = err};
    *mco = (struct cml_mco){0};
    CML_TRY(cml_text_read(NULL, path, &t.text, err));
    cml_status status = read_names(&t);
    if (status == CML_OK) status = read_rows(&t);
    if (status == CML_OK) status = make_result(&t, mco);
    free(t.row);
    cml_text_clear(&t.text);
    if (status != CML_OK) cml_mco_clear(mco);
    return status;
}
