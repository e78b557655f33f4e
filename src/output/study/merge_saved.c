/* Files of saved packets (P18), joined: the rows of each behind those of the one before, and of which result
 * each is. SPDX-License-Identifier: MIT */
#include "output/study/merge_parts.h"

#include "result/h5.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What there is of every row beside what the files have: of which seed and run it is. */
#define RESULT "result"

/* A file, and where its rows come among all. */
struct part {
    struct cml_hdf5_arrays arrays;
    size_t begin, count;
    int results; /* before it: a file may have been merged itself */
};

struct joined {
    int num_parts;
    struct part *part; /* [num_parts] */
    size_t rows;
    double *index; /* [rows] */
    struct cml_axis axis;
    bool broken; /* an array could not be read, as err says */
    struct cml_error err;
};

/* An array of all rows, `each` numbers of a row. */
struct column {
    struct joined *all;
    const char *name;
    size_t each;
};

/* ---- values ---- */

static cml_status read_piece(const struct column *column, struct part *part, size_t begin, size_t count,
                             double *out, struct cml_error *err)
{
    struct cml_hdf5_array *array = cml_hdf5_arrays_find(&part->arrays, column->name);
    const bool result = strcmp(column->name, RESULT) == 0;
    if (array) CML_TRY(cml_hdf5_array_read(&part->arrays, array, begin, count, out, err));
    for (size_t i = 0; result && i < count; i++) out[i] = part->results + (array ? out[i] : 1);
    return CML_OK;
}

/* For cml_field_values: file after file. */
static void values(const void *context, size_t begin, size_t count, double *out)
{
    const struct column *column = context;
    struct joined *all = column->all;
    for (int k = 0; k < all->num_parts && !all->broken; k++) {
        struct part *part = &all->part[k];
        const size_t first = part->begin * column->each, end = first + part->count * column->each,
                     from = begin > first ? begin : first, to = begin + count < end ? begin + count : end;
        if (from >= to) continue;
        all->broken =
            read_piece(column, part, from - first, to - from, out + (from - begin), &all->err) != CML_OK;
    }
}

/* ---- files ---- */

static bool same_shape(const struct cml_field *one, const struct cml_field *other)
{
    return one->num_axes == other->num_axes && (one->num_axes < 2 || one->axis[1]->n == other->axis[1]->n);
}

/* All arrays of the first have the rows of this one. */
static cml_status check_arrays(const struct joined *all, const struct part *part, struct cml_error *err)
{
    const char *path = part->arrays.file.path;
    for (int i = 0; i < all->part[0].arrays.count; i++) {
        const struct cml_field *field = &all->part[0].arrays.item[i].field;
        const struct cml_hdf5_array *array = cml_hdf5_arrays_find(&part->arrays, field->name);
        if (strcmp(field->name, RESULT) == 0) continue;
        if (!array || !same_shape(field, &array->field) || array->field.axis[0]->n != part->count)
            return cml_fail(err, CML_E_INPUT, "%.400s: %s (expected one of every row, as in %.400s)", path,
                            field->name, all->part[0].arrays.file.path);
    }
    return CML_OK;
}

static cml_status open_part(const struct cml_merge_input *input, struct joined *all, struct cml_error *err)
{
    struct part *part = &all->part[all->num_parts];
    CML_TRY(cml_hdf5_arrays_open(input->name, &part->arrays, err));
    const struct part *before = part - 1;
    const int k = all->num_parts++;
    const struct cml_hdf5_array *weight = cml_hdf5_arrays_find(&part->arrays, "weight");
    if (!weight || weight->field.num_axes != 1)
        return cml_fail(err, CML_E_INPUT, "%.400s: no array weight (expected a file of saved packets)",
                        input->name);
    part->begin = all->rows;
    part->count = weight->field.axis[0]->n;
    part->results = k > 0 ? before->results + input[-1].outcome->num_streams : 0;
    all->rows += part->count;
    return check_arrays(all, part, err);
}

static cml_status join_indices(struct joined *all, struct cml_error *err)
{
    all->index = malloc((all->rows + 1) * sizeof *all->index);
    if (!all->index) return cml_fail_memory(err, 8.0 * (double)all->rows, "saved packets");
    for (int k = 0; k < all->num_parts; k++) {
        const struct part *part = &all->part[k];
        const struct cml_axis *axis = cml_hdf5_arrays_find(&part->arrays, "weight")->field.axis[0];
        memcpy(all->index + part->begin, axis->values, part->count * sizeof *all->index);
        all->axis = *axis;
    }
    all->axis.n = all->rows;
    all->axis.values = all->index;
    return CML_OK;
}

static cml_status open_all(const struct cml_merge_input *inputs, int count, struct joined *all,
                           struct cml_error *err)
{
    all->part = calloc((size_t)count, sizeof *all->part);
    if (!all->part) return cml_fail_memory(err, 1, "saved packets");
    for (int k = 0; k < count; k++) CML_TRY(open_part(&inputs[k], all, err));
    return join_indices(all, err);
}

static void close_all(struct joined *all)
{
    for (int k = 0; k < all->num_parts; k++) cml_hdf5_arrays_close(&all->part[k].arrays);
    free(all->part);
    free(all->index);
}

/* ---- all of it ---- */

/* A file that does not say how many packets it covers can estimate nothing. */
static cml_status add_counts(const struct joined *all, struct cml_merge_saved *saved, struct cml_error *err)
{
    const char *const names[] = {"covers", "found", "limit"};
    double *const to[] = {&saved->covers, &saved->found, &saved->limit};
    for (int k = 0; k < all->num_parts; k++)
        for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
            const struct cml_hdf5 *file = &all->part[k].arrays.file;
            double number = 0;
            CML_TRY(cml_hdf5_number(file, names[i], &number, err));
            if (!(number >= (i == 1 ? 0 : 1) && number <= 0x1p53 && number == floor(number)))
                return cml_fail(err, CML_E_INPUT, "%.400s: %s = %g (expected a whole number of 1 or more)",
                                file->path, names[i], number);
            *to[i] += number;
        }
    saved->rows = (double)all->rows;
    return CML_OK;
}

/* column, field: [those of the first file and one more]. */
static cml_status write(const char *path, const struct cml_outcome *merged, struct joined *all,
                        const struct cml_merge_saved *saved, const struct cml_hdf5_call *call,
                        struct column *column, struct cml_field *field, struct cml_error *err)
{
    const struct cml_hdf5_arrays *first = &all->part[0].arrays;
    double detected = 0;
    int n = 0;
    for (int i = 0; i < first->count; i++) {
        const struct cml_field *of = &first->item[i].field;
        if (strcmp(of->name, RESULT) == 0) continue;
        column[n] = (struct column){all, of->name, of->num_axes > 1 ? of->axis[1]->n : 1};
        field[n++] = *of;
    }
    column[n] = (struct column){all, RESULT, 1};
    field[n] = (struct cml_field){.name = RESULT,
                                  .long_name = "of which merged result, from 1, in the order of `merged`",
                                  .units = "1",
                                  .num_axes = 1,
                                  .single = true};
    for (int i = 0; i <= n; i++) {
        field[i].axis[0] = &all->axis;
        field[i].plain = true;
        field[i].values = values;
        field[i].context = &column[i];
        field[i].broken = &all->broken;
    }
    CML_TRY(cml_hdf5_number(&first->file, "detected", &detected, err));
    const struct cml_attribute attributes[] = {{"covers", NULL, saved->covers},
                                               {"found", NULL, saved->found},
                                               {"limit", NULL, saved->limit},
                                               {"detected", NULL, detected}};
    const struct cml_h5_more more = {.field = field,
                                     .num_fields = n + 1,
                                     .attribute = attributes,
                                     .num_attributes = sizeof attributes / sizeof *attributes,
                                     .call = *call};
    const cml_status status = cml_h5_write(path, merged, &more, err);
    if (all->broken) *err = all->err;
    return all->broken ? err->status : status;
}

static cml_status write_all(const char *path, const struct cml_outcome *merged, struct joined *all,
                            const struct cml_merge_saved *saved, const struct cml_hdf5_call *call,
                            struct cml_error *err)
{
    const size_t most = (size_t)all->part[0].arrays.count + 1;
    struct column *column = calloc(most, sizeof *column);
    struct cml_field *field = calloc(most, sizeof *field);
    const cml_status status = column && field ? write(path, merged, all, saved, call, column, field, err)
                                              : cml_fail_memory(err, 1, "saved packets");
    free(column);
    free(field);
    return status;
}

cml_status cml_merge_saved(const char *path, const struct cml_merge_input *inputs, int count,
                           const struct cml_hdf5_call *call, struct cml_outcome *merged,
                           struct cml_merge_saved *saved, struct cml_error *err)
{
    const char *slash = strrchr(path, '/');
    struct joined all = {0};
    *merged = (struct cml_outcome){0};
    *saved = (struct cml_merge_saved){0};
    CML_TRY(cml_merge_check(inputs, count, err));
    cml_status status = cml_merge_head(inputs, count, slash ? slash + 1 : path, merged, err);
    if (status == CML_OK) status = open_all(inputs, count, &all, err);
    if (status == CML_OK) status = add_counts(&all, saved, err);
    if (status == CML_OK) status = write_all(path, merged, &all, saved, call, err);
    close_all(&all);
    if (status != CML_OK) cml_outcome_clear(merged);
    return status;
}
