/* SPDX-License-Identifier: MIT */
#include "output/study/sweep_files.h"

#include "base/array.h"
#include "base/atomic_file.h"
#include "input/keys/key.h"
#include "base/text.h"
#include "base/version.h"
#include "output/files/hdf5_head.h"
#include "result/quantity.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* True if this names a number that every row of a sweep has. */
static bool is_of_every_row(const char *name)
{
    return strcmp(name, "photons") == 0 || strcmp(name, "seed") == 0;
}

/* True if the text may stand behind the name of a quantity. */
static bool is_ending(const char *rest)
{
    return !*rest || strcmp(rest, "_se") == 0 || strcmp(rest, "_expected") == 0 ||
           strcmp(rest, "_expected_se") == 0;
}

/* Names of the sides of flux_body, in the order of its axis. */
static const char *const sides[CML_BODY_SIDES] = {"arrives_outside", "arrives_inside", "leaves_outside",
                                                  "leaves_inside"};

/* True for the end of a name of a flux: ".arrives_outside", ".leaves_inside_se" ... */
static bool is_flux(const char *rest)
{
    for (int s = 0; s < CML_BODY_SIDES && *rest == '.'; s++)
        if (strncmp(rest + 1, sides[s], strlen(sides[s])) == 0) return is_ending(rest + 1 + strlen(sides[s]));
    return false;
}

/* True for a name of results of layers and bodies: absorption (layer1.A and the like, counted or expected),
 * fluxes, and the names of their axes. */
static bool is_of_media(const char *name)
{
    const size_t word = strncmp(name, "layer", 5) == 0 ? 5 : strncmp(name, "body", 4) == 0 ? 4 : 0;
    const char *rest = name + word + strspn(name + word, "0123456789");
    if (word > 0) return !*rest || (strncmp(rest, ".A", 2) == 0 && is_ending(rest + 2)) || is_flux(rest);
    return (strncmp(name, "A_l", 3) == 0 && is_ending(name + 3)) ||
           (strncmp(name, "A_body", 6) == 0 && is_ending(name + 6)) ||
           (strncmp(name, "flux_body", 9) == 0 && is_ending(name + 9)) || strcmp(name, "side") == 0;
}

bool cml_sweep_is_of_results(const char *name)
{
    for (int t = 0; t < CML_NUM_TOTALS; t++) {
        const char *total = cml_quantities[cml_quantity_of_total(t)].name;
        const size_t own = strlen(total);
        if (strncmp(name, total, own) == 0 && is_ending(name + own)) return true;
    }
    /* "call" is a group of the .h5 */
    return is_of_every_row(name) || is_of_media(name) || strncmp(name, "detector_", 9) == 0 ||
           strcmp(name, "row") == 0 || strcmp(name, "lost") == 0 || strcmp(name, "file") == 0 ||
           strcmp(name, "call") == 0;
}

void cml_sweep_h5_name(char *name)
{
    while ((name = strchr(name, '/'))) *name = '_';
}

/* ---- .csv ---- */

/* Writes a text of the table, in quotation marks if it is a label or has a comma, a quotation mark or a #
 * (RFC 4180). */
static void write_text(FILE *out, const char *name, bool label)
{
    const bool quoted = label || strpbrk(name, ",\"#") != NULL;
    if (quoted) fputc('"', out);
    for (; *name; name++) {
        if (*name == '"') fputc('"', out);
        fputc(*name, out);
    }
    if (quoted) fputc('"', out);
}

/* Returns how many numbers of a kind the tables have: the most that any row has. */
static int count_of(const struct cml_sweep_results *r, enum cml_recorded kind)
{
    int64_t most = 0;
    for (int row = 0; row < r->num_rows; row++)
        most = r->record[row].count[kind] > most ? r->record[row].count[kind] : most;
    return (int)most;
}

/* Writes the column name of number i of a kind, such as "layer2.A". Total Tt_expected is number 0 of the
 * expected values; those of layers follow. */
static void name_number(const struct cml_sweep_results *r, enum cml_recorded kind, int i, char name[64])
{
    static const char *const media[] = {
        [CML_RECORDED_LAYERS] = "layer%d.A", [CML_RECORDED_BODIES] = "body%d.A"};
    if (kind == CML_RECORDED_TOTALS)
        strcpy(name, cml_quantities[cml_quantity_of_total(i)].name);
    else if (kind == CML_RECORDED_FACE)
        strcpy(name, cml_quantities[CML_QUANTITY_A_face].name);
    else if (kind == CML_RECORDED_EXPECTED)
        snprintf(name, 64, i == 0 ? "Tt_expected" : "layer%d.A_expected", i);
    else if (kind == CML_RECORDED_DETECTORS)
        snprintf(name, 64, "detector_%s", r->detector[i]);
    else if (kind == CML_RECORDED_FLUXES)
        snprintf(name, 64, "body%d.%s", i / CML_BODY_SIDES + 1, sides[i % CML_BODY_SIDES]);
    else
        snprintf(name, 64, media[kind], i + 1);
}

/* Writes the first line of the .csv: the names of swept settings, then each result with its standard error
 * (_se). */
static void write_names(FILE *out, const struct cml_sweep_results *r)
{
    fputs("row", out);
    for (int c = 0; c < r->num_columns; c++)
        if (!is_of_every_row(r->name[c])) {
            fputc(',', out);
            write_text(out, r->name[c], r->label[c]);
        }
    fputs(",photons,seed", out);
    for (int kind = 0; kind < CML_NUM_RECORDED; kind++)
        for (int i = 0; i < count_of(r, (enum cml_recorded)kind); i++) {
            char name[64];
            name_number(r, (enum cml_recorded)kind, i, name);
            fprintf(out, ",%s,%s_se", name, name);
        }
    fputs(",lost,file\n", out);
}

/* Writes a row of the .csv. A row that lacks a number which other rows have gets 0. count: number of columns
 * of each kind. */
static void write_row(FILE *out, const struct cml_sweep_results *r, const int count[CML_NUM_RECORDED],
                      int row)
{
    const struct cml_record *record = &r->record[row];
    fprintf(out, "%d", row + 1);
    for (int c = 0; c < r->num_columns; c++)
        if (!is_of_every_row(r->name[c])) {
            fputc(',', out);
            write_text(out, r->cell[(size_t)row * (size_t)r->num_columns + (size_t)c], false);
        }
    fprintf(out, ",%" PRIu64 ",%" PRIu64, record->photons, r->seed[row]);
    for (int kind = 0; kind < CML_NUM_RECORDED; kind++)
        for (int i = 0; i < count[kind]; i++) {
            const int at = cml_record_find(record, (enum cml_recorded)kind, i);
            fprintf(out, ",%.17g,%.17g", at < 0 ? 0 : record->value[at], at < 0 ? 0 : record->error[at]);
        }
    fprintf(out, ",%" PRIu64 ",", record->lost);
    write_text(out, r->file[row], false);
    fputc('\n', out);
}

cml_status cml_sweep_write_csv(const char *path, const struct cml_sweep_results *results,
                               struct cml_error *err)
{
    struct cml_file file;
    int count[CML_NUM_RECORDED];
    for (int kind = 0; kind < CML_NUM_RECORDED; kind++)
        count[kind] = count_of(results, (enum cml_recorded)kind);
    CML_TRY(cml_file_create(path, &file, err));
    write_names(file.stream, results);
    for (int row = 0; row < results->num_rows; row++) write_row(file.stream, results, count, row);
    return cml_file_commit(&file, err);
}

/* ---- .h5 ---- */

/* The rows of a sweep, arranged as an array over axes. */
struct grid {
    const struct cml_sweep_results *results;
    double *value;                        /* [num_rows][num_columns] numbers of the cells */
    int num_axes, column[CML_SWEEP_AXES]; /* column of each axis; -1: the axis is the number of the row */
    struct cml_axis axis[CML_SWEEP_AXES];
    double *axis_values; /* [num_columns][num_rows] values of the axes */
    int *row;            /* [num_rows] the row at each place of the array */
};

/* Finds the different values of a column, in rising order. Returns how many there are. */
static size_t find_values(const struct grid *grid, int column, double *values)
{
    const size_t rows = (size_t)grid->results->num_rows, columns = (size_t)grid->results->num_columns;
    for (size_t i = 0; i < rows; i++) values[i] = grid->value[i * columns + (size_t)column];
    return cml_sort_distinct(values, rows);
}

/* Finds the columns that have more than one value, which become axes of the grid. False if there are none,
 * or too many. */
static bool find_axes(struct grid *grid)
{
    const struct cml_sweep_results *r = grid->results;
    for (int c = 0; c < r->num_columns; c++) {
        if (r->label[c]) continue;
        double *values = grid->axis_values + (size_t)c * (size_t)r->num_rows;
        const size_t n = find_values(grid, c, values);
        if (n == 1) continue;
        if (grid->num_axes == CML_SWEEP_AXES) return false;
        grid->column[grid->num_axes] = c;
        grid->axis[grid->num_axes++] =
            (struct cml_axis){r->name[c], "what was swept", cml_key_unit(r->name[c]), n, 0, 0, values};
    }
    return grid->num_axes > 0;
}

/* Finds the row of the table for each place of the grid of settings. False if a place has no row or two: the
 * rows then form no grid. */
static bool place_rows(struct grid *grid)
{
    const struct cml_sweep_results *r = grid->results;
    size_t size = 1;
    for (int a = 0; a < grid->num_axes; a++) size *= grid->axis[a].n;
    if (size != (size_t)r->num_rows) return false;
    for (size_t i = 0; i < size; i++) grid->row[i] = -1;
    for (int row = 0; row < r->num_rows; row++) {
        size_t cell_at = 0;
        for (int a = 0; a < grid->num_axes; a++) {
            const struct cml_axis *axis = &grid->axis[a];
            const double *cell = &grid->value[(size_t)row * (size_t)r->num_columns + (size_t)grid->column[a]];
            const double *at = bsearch(cell, axis->values, axis->n, sizeof *cell, cml_compare_doubles);
            cell_at = cell_at * axis->n + (size_t)(at - axis->values);
        }
        if (grid->row[cell_at] >= 0) return false;
        grid->row[cell_at] = row;
    }
    return true;
}

/* Arranges the rows over several axes if they are all combinations of their values; else over one axis, the
 * row. */
static void arrange(struct grid *grid)
{
    if (find_axes(grid) && place_rows(grid)) return;
    const size_t rows = (size_t)grid->results->num_rows;
    grid->num_axes = 1;
    grid->column[0] = -1;
    grid->axis[0] = (struct cml_axis){"row", "row of the table, from 1", "1", rows, 1, 1, NULL};
    for (size_t i = 0; i < rows; i++) grid->row[i] = (int)i;
}

/* The fields of the .h5, and their values in the order of the array. */
struct fields {
    const struct grid *grid;
    struct cml_field *field;
    /* values of all fields, field after field, each [num_rows] or [num_rows][n]; `free` is where the values
     * of the next field begin */
    double *value, *free;
    struct cml_axis layer, body, side;
    int count;
};

/* Adds a field over the axes of the grid and returns its values, in the order of the array, to be filled in.
 * axis, inner: further axes behind these, or NULL. */
static double *add_over(struct fields *list, const struct cml_axis *axis, const struct cml_axis *inner,
                        const char *name, const char *long_name, const char *units)
{
    const struct grid *grid = list->grid;
    struct cml_field *field = &list->field[list->count++];
    double *value = list->free;
    list->free += (size_t)grid->results->num_rows * (axis ? axis->n : 1) * (inner ? inner->n : 1);
    snprintf(field->name, sizeof field->name, "%s", name);
    field->long_name = long_name;
    field->units = units;
    field->num_axes = grid->num_axes;
    for (int a = 0; a < grid->num_axes; a++) field->axis[a] = &grid->axis[a];
    if (axis) field->axis[field->num_axes++] = axis;
    if (inner) field->axis[field->num_axes++] = inner;
    field->values = cml_field_array_values;
    field->context = value;
    return value;
}

/* Adds a field over the axes of the grid alone. */
static double *add(struct fields *list, const char *name, const char *long_name, const char *units)
{
    return add_over(list, NULL, NULL, name, long_name, units);
}

/* True if this column of a sweep's table has become an axis of the grid. */
static bool is_axis(const struct grid *grid, int column)
{
    for (int a = 0; a < grid->num_axes; a++)
        if (grid->column[a] == column) return true;
    return false;
}

/* True if an axis has this name, and hence a data set of its own. */
static bool has_axis(const struct grid *grid, const char *name)
{
    for (int a = 0; a < grid->num_axes; a++)
        if (strcmp(grid->axis[a].name, name) == 0) return true;
    return false;
}

/* Adds a quantity and its errors, and returns their values: errors[size of the quantity]. */
static double *add_with_errors(struct fields *list, const struct cml_axis *axis, const struct cml_axis *inner,
                               enum cml_quantity quantity, const char *name, double **errors)
{
    double *value = add_over(list, axis, inner, name, cml_quantities[quantity].long_name, "1");
    *errors = add_over(list, axis, inner, "", "", "1");
    struct cml_field *field = &list->field[list->count - 1];
    cml_quantity_name_errors(field, field - 1);
    return value;
}

/* Adds the numbers of a kind from number `first` on, with their errors, over `axis` and `inner` (NULL: no
 * such axis). name NULL: the field has the name of the quantity. */
static void fill_over(struct fields *list, enum cml_recorded kind, int first, const struct cml_axis *axis,
                      const struct cml_axis *inner, enum cml_quantity quantity, const char *name)
{
    const struct grid *grid = list->grid;
    const int n = (int)((axis ? axis->n : 1) * (inner ? inner->n : 1));
    if (n == 0 || first >= count_of(grid->results, kind)) return;
    double *error, *value = add_with_errors(list, axis, inner, quantity,
                                            name ? name : cml_quantities[quantity].name, &error);
    for (int i = 0; i < grid->results->num_rows * n; i++) {
        const struct cml_record *record = &grid->results->record[grid->row[i / n]];
        const int at = cml_record_find(record, kind, first + i % n);
        value[i] = at < 0 ? 0 : record->value[at];
        error[i] = at < 0 ? 0 : record->error[at];
    }
}

/* Adds a field for every number that results have: totals, layers, bodies, expected values, detectors. */
static void fill_all_numbers(struct fields *list)
{
    const struct cml_sweep_results *r = list->grid->results;
    const struct cml_axis *layer = &list->layer, *body = &list->body, *side = &list->side;
    for (int t = 0; t < count_of(r, CML_RECORDED_TOTALS); t++)
        fill_over(list, CML_RECORDED_TOTALS, t, NULL, NULL, cml_quantity_of_total(t), NULL);
    if (count_of(r, CML_RECORDED_FACE))
        fill_over(list, CML_RECORDED_FACE, 0, NULL, NULL, CML_QUANTITY_A_face, NULL);
    fill_over(list, CML_RECORDED_LAYERS, 0, layer, NULL, CML_QUANTITY_A_l, NULL);
    fill_over(list, CML_RECORDED_BODIES, 0, body, NULL, CML_QUANTITY_A_body, NULL);
    fill_over(list, CML_RECORDED_FLUXES, 0, body, side, CML_QUANTITY_flux_body, NULL);
    fill_over(list, CML_RECORDED_EXPECTED, 0, NULL, NULL, CML_QUANTITY_Tt_expected, NULL);
    fill_over(list, CML_RECORDED_EXPECTED, 1, layer, NULL, CML_QUANTITY_A_l_expected, NULL);
    for (int k = 0; k < count_of(r, CML_RECORDED_DETECTORS); k++) {
        char name[64];
        name_number(r, CML_RECORDED_DETECTORS, k, name);
        fill_over(list, CML_RECORDED_DETECTORS, k, NULL, NULL, CML_QUANTITY_detector, name);
    }
}

/* Whole numbers of every row. */
enum whole { PHOTONS, SEED, LOST, ROW };

/* Returns one of the whole numbers of a row. */
static double whole_of(const struct cml_sweep_results *r, int row, enum whole which)
{
    const double numbers[] = {(double)r->record[row].photons, (double)r->seed[row],
                              (double)r->record[row].lost, row + 1};
    return numbers[which];
}

/* Adds a field with one of the whole numbers of every row. */
static void fill_whole(struct fields *list, enum whole which, const char *name, const char *long_name)
{
    const struct grid *grid = list->grid;
    if (has_axis(grid, name)) return;
    double *to = add(list, name, long_name, "1");
    for (int i = 0; i < grid->results->num_rows; i++) to[i] = whole_of(grid->results, grid->row[i], which);
}

/* True if all cells of a column are numbers. */
static bool is_numeric(const struct cml_sweep_results *r, int column)
{
    double value;
    for (int row = 0; row < r->num_rows; row++)
        if (!cml_parse_double(r->cell[(size_t)row * (size_t)r->num_columns + (size_t)column], &value))
            return false;
    return true;
}

/* Adds all fields of the sweep's .h5: results, swept settings that are no axis, numeric labels, and photons,
 * seed, lost packets and row number. */
static void fill(struct fields *list)
{
    const struct grid *grid = list->grid;
    const struct cml_sweep_results *r = grid->results;
    fill_all_numbers(list);
    for (int c = 0; c < r->num_columns; c++) {
        if (is_axis(grid, c) || is_of_every_row(r->name[c]) || (r->label[c] && !is_numeric(r, c))) continue;
        double *to = r->label[c] ? add(list, r->name[c], "label", "1")
                                 : add(list, r->name[c], "what was swept", cml_key_unit(r->name[c]));
        cml_sweep_h5_name(list->field[list->count - 1].name);
        for (int i = 0; i < r->num_rows; i++)
            to[i] = grid->value[(size_t)grid->row[i] * (size_t)r->num_columns + (size_t)c];
    }
    fill_whole(list, PHOTONS, "photons", "packets");
    fill_whole(list, SEED, "seed", "of the random numbers");
    fill_whole(list, LOST, "lost", cml_quantities[CML_QUANTITY_lost].long_name);
    fill_whole(list, ROW, "row", "of the table, from 1");
}

/* Fills the fields and writes them to the .h5, with the texts that describe the sweep as attributes. */
static cml_status write_h5(const char *path, const struct grid *grid, struct fields *list,
                           struct cml_error *err)
{
    const struct cml_sweep_results *r = grid->results;
    const struct cml_attribute attributes[] = {
        {"title", r->title, 0},
        {"source", CML_HDF5_SOURCE "Monte Carlo light transport in layered turbid media", 0},
        {"version", cml_version(), 0},
        {"input", r->input, 0},
        {"settings", r->settings, 0},
    };
    const int count = (int)(sizeof attributes / sizeof *attributes) - (r->settings ? 0 : 1);
    fill(list);
    return cml_hdf5_write(path, attributes, count, &r->call, list->field, list->count, err);
}

/* `most` bounds the number of fields. */
cml_status cml_sweep_write_h5(const char *path, const struct cml_sweep_results *results,
                              struct cml_error *err)
{
    static const char what[] = "the results of a sweep";
    const size_t rows = (size_t)results->num_rows, columns = (size_t)results->num_columns;
    const size_t layers = (size_t)count_of(results, CML_RECORDED_LAYERS),
                 bodies = (size_t)count_of(results, CML_RECORDED_BODIES),
                 expected = (size_t)count_of(results, CML_RECORDED_EXPECTED),
                 detectors = (size_t)count_of(results, CML_RECORDED_DETECTORS),
                 most = 2 * (CML_NUM_TOTALS + 2 * layers + (1 + CML_BODY_SIDES) * bodies + expected +
                             detectors) +
                        columns + 4;
    CML_FREED struct cml_field *field = NULL;
    CML_FREED double *value = NULL, *cell = NULL, *axis_values = NULL;
    CML_FREED int *row = NULL;
    CML_TRY(cml_zeros(&field, most, sizeof *field, what, err));
    CML_TRY(cml_zeros(&value, most * rows, sizeof *value, what, err));
    CML_TRY(cml_zeros(&cell, rows * columns, sizeof *cell, what, err));
    CML_TRY(cml_zeros(&axis_values, rows * columns, sizeof *axis_values, what, err));
    CML_TRY(cml_zeros(&row, rows, sizeof *row, what, err));
    for (size_t i = 0; i < rows * columns; i++) cell[i] = strtod(results->cell[i], NULL);
    struct grid grid = {.results = results, .value = cell, .axis_values = axis_values, .row = row};
    struct fields list = {.grid = &grid,
                          .field = field,
                          .value = value,
                          .free = value,
                          .layer = cml_quantity_axis(CML_AXIS_layer, layers, 1, 1),
                          .body = cml_quantity_axis(CML_AXIS_body, bodies, 1, 1),
                          .side = cml_quantity_axis(CML_AXIS_side, CML_BODY_SIDES, 1, 1)};
    arrange(&grid);
    return write_h5(path, &grid, &list, err);
}
