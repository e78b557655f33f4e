/* Files of saved packets (P18), joined: the rows of each behind those of the one before, and of which result
 * each is. SPDX-License-Identifier: MIT */
#include "output/study/merge_parts.h"

#include "result/h5.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What there is of every row beside what the files have: of which seed and run it is. */
#define RESULT "result"

/* A file, and where its rows come among all. */
struct part {
    const struct cml_outcome *of;
    struct cml_hdf5_arrays arrays; /* none of a file without rows */
    size_t begin, count;
    int results; /* before it: a file may have been merged itself */
};

struct joined {
    int num_parts;
    struct part *part;        /* [num_parts] */
    const struct part *model; /* the first that has rows, and so arrays */
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

/* The most that a weight of 32 bits, in units of 2^-31, can be. */
#define MOST_WEIGHT 2.0

/* A number of a row, or what no run writes. Where a packet has touched nothing there is no place. */
static bool is_sound(const char *name, double value, const struct cml_outcome *of)
{
    const struct {
        const char *names;
        double least, most;
        bool whole, none; /* none: NAN, too */
    } kinds[] = {{" x y z deepest ", -DBL_MAX, DBL_MAX, false, true},
                 {" ux uy uz ", -1 - 1e-6, 1 + 1e-6, false, false},
                 {" weight ", 0, MOST_WEIGHT, false, false},
                 {" side ", 0, 2, true, false},
                 {" detector ", 0, of->num_detectors, true, false},
                 {" touches interactions ", 0, UINT32_MAX, true, false},
                 {" " RESULT " ", 1, of->num_streams, true, false}};
    char word[72];
    size_t i = 0;
    snprintf(word, sizeof word, " %s ", name);
    while (i < sizeof kinds / sizeof *kinds && !strstr(kinds[i].names, word)) i++;
    if (i == sizeof kinds / sizeof *kinds) return value >= 0 && value < INFINITY;
    if (isnan(value)) return kinds[i].none;
    return value >= kinds[i].least && value <= kinds[i].most && !(kinds[i].whole && value != floor(value));
}

/* Photons of each beam count from a multiple of 2^48 on. */
static bool is_index(double value, const struct cml_outcome *of)
{
    return value >= 0 && value < 0x1p63 && value == floor(value) && fmod(value, 0x1p48) < (double)of->photons;
}

static cml_status read_piece(const struct column *column, struct part *part, size_t begin, size_t count,
                             double *out, struct cml_error *err)
{
    struct cml_hdf5_array *array = cml_hdf5_arrays_find(&part->arrays, column->name);
    const bool result = strcmp(column->name, RESULT) == 0;
    if (array) CML_TRY(cml_hdf5_array_read(&part->arrays, array, begin, count, out, err));
    for (size_t i = 0; array && i < count; i++)
        if (!is_sound(column->name, out[i], part->of))
            return cml_fail(err, CML_E_INPUT, "%.400s: %s[%zu] = %g (expected a number of a packet)",
                            part->arrays.file.path, column->name, begin + i, out[i]);
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
    for (int i = 0; i < all->model->arrays.count; i++) {
        const struct cml_field *field = &all->model->arrays.item[i].field;
        const struct cml_hdf5_array *array = cml_hdf5_arrays_find(&part->arrays, field->name);
        if (strcmp(field->name, RESULT) == 0) continue;
        if (!array || !same_shape(field, &array->field) || array->field.axis[0]->n != part->count)
            return cml_fail(err, CML_E_INPUT, "%.400s: %s (expected one of every row, as in %.400s)", path,
                            field->name, all->model->arrays.file.path);
    }
    if (part->of->num_streams == 1 || cml_hdf5_arrays_find(&part->arrays, RESULT)) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "%.400s: no array " RESULT " (expected that of %d merged results)",
                    path, part->of->num_streams);
}

/* A file has arrays where it has rows. */
static cml_status open_arrays(const char *name, struct part *part, struct cml_error *err)
{
    double found = -1;
    CML_TRY(cml_hdf5_open(name, &part->arrays.file, err));
    CML_TRY(cml_hdf5_number(&part->arrays.file, "found", &found, err));
    if (found == 0) return CML_OK;
    cml_hdf5_close(&part->arrays.file);
    return cml_hdf5_arrays_open(name, &part->arrays, err);
}

static cml_status open_part(const struct cml_merge_input *input, struct joined *all, struct cml_error *err)
{
    const int k = all->num_parts++;
    struct part *part = &all->part[k];
    const struct part *before = part - 1;
    part->of = input->outcome;
    CML_TRY(open_arrays(input->name, part, err));
    part->begin = all->rows;
    part->results = k > 0 ? before->results + input[-1].outcome->num_streams : 0;
    if (part->of->num_streams < 1)
        return cml_fail(err, CML_E_INPUT, "%.400s: has no seed (expected that of its run)", input->name);
    if (part->arrays.count == 0) return CML_OK;
    if (!all->model) all->model = part;
    const struct cml_hdf5_array *weight = cml_hdf5_arrays_find(&part->arrays, "weight");
    if (!weight || weight->field.num_axes != 1)
        return cml_fail(err, CML_E_INPUT, "%.400s: no array weight (expected a file of saved packets)",
                        input->name);
    part->count = weight->field.axis[0]->n;
    all->rows += part->count;
    return check_arrays(all, part, err);
}

static cml_status check_index(const struct part *part, const double *index, size_t i, struct cml_error *err)
{
    const char *path = part->arrays.file.path;
    if (!is_index(index[i], part->of))
        return cml_fail(err, CML_E_INPUT, "%.400s: index[%zu] = %.17g (expected one of its %.0f photons)",
                        path, i, index[i], (double)part->of->photons);
    if (i == 0 || part->of->num_streams > 1 || index[i] >= index[i - 1]) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "%.400s: index[%zu] = %g (expected numbers that rise)", path, i,
                    index[i]);
}

static cml_status join_indices(struct joined *all, struct cml_error *err)
{
    all->index = malloc((all->rows + 1) * sizeof *all->index);
    if (!all->index) return cml_fail_memory(err, 8.0 * (double)all->rows, "saved packets");
    for (int k = 0; k < all->num_parts; k++) {
        const struct part *part = &all->part[k];
        if (part->count == 0) continue;
        const struct cml_axis *axis = cml_hdf5_arrays_find(&part->arrays, "weight")->field.axis[0];
        for (size_t i = 0; i < part->count; i++) CML_TRY(check_index(part, axis->values, i, err));
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
    if (!all->model)
        return cml_fail(err, CML_E_INPUT, "%.400s: none of the %d files has a packet (expected one that has)",
                        inputs[0].name, count);
    return join_indices(all, err);
}

static void close_all(struct joined *all)
{
    for (int k = 0; k < all->num_parts; k++) cml_hdf5_arrays_close(&all->part[k].arrays);
    free(all->part);
    free(all->index);
}

/* ---- all of it ---- */

/* A whole number that the file says of its rows. */
static cml_status read_count(const struct part *part, const char *name, double least, double most,
                             double *number, struct cml_error *err)
{
    *number = -1;
    CML_TRY(cml_hdf5_number(&part->arrays.file, name, number, err));
    if (*number >= least && *number <= most && *number == floor(*number)) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "%.400s: %s = %.17g (expected a whole number from %g to %.17g)",
                    part->arrays.file.path, name, *number, least, most);
}

/* A file that does not say how many packets it covers can estimate nothing, nor can packets that a detector
 * has seen beside all. */
static cml_status add_counts(const struct joined *all, struct cml_merge_saved *saved, struct cml_error *err)
{
    for (int k = 0; k < all->num_parts; k++) {
        const struct part *part = &all->part[k];
        const double rows = (double)part->count, photons = (double)part->of->photons, some = fmax(rows, 1);
        double covers, found, limit, detected;
        CML_TRY(read_count(part, "covers", some, photons, &covers, err));
        CML_TRY(read_count(part, "found", rows, photons, &found, err));
        CML_TRY(read_count(part, "limit", some, 0x1p53, &limit, err));
        CML_TRY(read_count(part, "detected", 0, 1, &detected, err));
        if (k > 0 && detected != saved->detected)
            return cml_fail(err, CML_E_INPUT, "%.400s: detected = %g (expected %g, as in %.400s)",
                            part->arrays.file.path, detected, saved->detected, all->part[0].arrays.file.path);
        saved->covers += covers;
        saved->found += found;
        saved->limit += limit;
        saved->detected = detected;
    }
    saved->rows = (double)all->rows;
    return CML_OK;
}

/* column, field: [those of the first file and one more]. */
static cml_status write(const char *path, const struct cml_outcome *merged, struct joined *all,
                        const struct cml_merge_saved *saved, const struct cml_hdf5_call *call,
                        struct column *column, struct cml_field *field, struct cml_error *err)
{
    const struct cml_hdf5_arrays *first = &all->model->arrays;
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
    const struct cml_attribute attributes[] = {{"covers", NULL, saved->covers},
                                               {"found", NULL, saved->found},
                                               {"limit", NULL, saved->limit},
                                               {"detected", NULL, saved->detected}};
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
    const size_t most = (size_t)all->model->arrays.count + 1;
    CML_FREED struct column *column = calloc(most, sizeof *column);
    CML_FREED struct cml_field *field = calloc(most, sizeof *field);
    return column && field ? write(path, merged, all, saved, call, column, field, err)
                           : cml_fail_memory(err, 1, "saved packets");
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
