/* What only .h5 files hold, merged: maps, volumes, facets. SPDX-License-Identifier: MIT */
#include "output/study/merge_parts.h"

#include "base/text.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Numbers that are read at a time. */
enum { PIECE = 4096 };

struct cml_merge_array {
    struct cml_merge_arrays *all;
    struct cml_hdf5_array **of_file; /* [num_files] */
    bool errors;                     /* roots of sums of squares, else means */
};

double cml_merge_error_weight(const struct cml_merge_input *inputs, int count, int k)
{
    double photons = 0, with_error = 0;
    for (int i = 0; i < count; i++) {
        photons += (double)inputs[i].outcome->photons;
        if (inputs[i].outcome->photons > 1) with_error += (double)inputs[i].outcome->photons;
    }
    const double own = (double)inputs[k].outcome->photons;
    return own > 1 ? own / photons * sqrt(photons / with_error) : 0;
}

void cml_merge_add_spread(double *squares, const double *value, const double *mean, size_t n, int count)
{
    for (size_t i = 0; i < n; i++) {
        const double deviation = value[i] - mean[i];
        squares[i] += deviation * deviation / (count - 1) / count;
    }
}

/* What no run writes: of its arrays only those of 64 bits may be negative. */
static cml_status check(const struct cml_merge_array *array, int file, size_t begin, size_t count,
                        const double *numbers, struct cml_error *err)
{
    const struct cml_hdf5_arrays *arrays = &array->all->file[file];
    const struct cml_field *field = &array->of_file[file]->field;
    const double most = CML_OUTCOME_MOST, least = array->errors || field->single ? 0 : -most;
    for (size_t i = 0; i < count; i++)
        if (!(numbers[i] >= least && numbers[i] <= most))
            return cml_fail(err, CML_E_INPUT, "%.400s: %s[%zu] = %g (expected a number from %g to %g)",
                            arrays->file.path, field->name, begin + i, numbers[i], least, most);
    return CML_OK;
}

/* Numbers of a file; false, and the first error kept, when they are not to be had. */
static bool read_piece(const struct cml_merge_array *array, int file, size_t begin, size_t count,
                       double *numbers)
{
    struct cml_merge_arrays *all = array->all;
    struct cml_error err;
    cml_status status =
        cml_hdf5_array_read(&all->file[file], array->of_file[file], begin, count, numbers, &err);
    if (status == CML_OK) status = check(array, file, begin, count, numbers, &err);
    if (status != CML_OK && !all->broken) all->err = err;
    if (status != CML_OK) all->broken = true;
    return status == CML_OK;
}

/* The means of a piece, or the sums of squares of errors, of which some inputs have none. */
static void add_pieces(const struct cml_merge_array *array, size_t begin, size_t count, double *out)
{
    double numbers[PIECE];
    const struct cml_merge_arrays *all = array->all;
    for (int k = 0; k < all->num_files; k++) {
        const double weight = array->errors ? all->error_weight[k] : all->weight[k];
        if (weight == 0 || !read_piece(array, k, begin, count, numbers)) continue;
        for (size_t i = 0; i < count; i++)
            out[i] += array->errors ? weight * numbers[i] * weight * numbers[i] : weight * numbers[i];
    }
}

/* Errors of results of one packet each, from their spread: of the array that the errors belong to, NaN where
 * there is none. */
static void add_spread(const struct cml_merge_array *errors, size_t begin, size_t count, double *out)
{
    double mean[PIECE] = {0}, numbers[PIECE];
    const struct cml_merge_arrays *all = errors->all;
    const char *name = errors->of_file[0]->field.name;
    const struct cml_merge_array *of = NULL;
    for (int i = 0; i < all->count && !of; i++) {
        const char *other = all->item[i].of_file[0]->field.name;
        if (strlen(other) + 3 == strlen(name) && strncmp(name, other, strlen(other)) == 0) of = &all->item[i];
    }
    for (size_t i = 0; !of && i < count; i++) out[i] = NAN;
    if (!of) return;
    add_pieces(of, begin, count, mean);
    for (int k = 0; k < all->num_files; k++)
        if (read_piece(of, k, begin, count, numbers))
            cml_merge_add_spread(out, numbers, mean, count, all->num_files);
}

static void values(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_merge_array *array = context;
    bool known = false;
    for (int k = 0; k < array->all->num_files; k++) known = known || array->all->error_weight[k] > 0;
    memset(out, 0, count * sizeof *out);
    for (size_t done = 0; done < count && !array->all->broken; done += PIECE) {
        const size_t left = count - done, piece = left < PIECE ? left : PIECE;
        if (array->errors && !known)
            add_spread(array, begin + done, piece, out + done);
        else
            add_pieces(array, begin + done, piece, out + done);
    }
    for (size_t i = 0; array->errors && i < count; i++) out[i] = sqrt(out[i]);
}

static bool same_size(const struct cml_hdf5_array *one, const struct cml_hdf5_array *other)
{
    if (!other || one->field.num_axes != other->field.num_axes) return false;
    for (int i = 0; i < one->field.num_axes; i++)
        if (one->field.axis[i]->n != other->field.axis[i]->n) return false;
    return true;
}

/* An array of the first file, if all others have it. */
static cml_status add_array(struct cml_merge_arrays *all, const struct cml_hdf5_array *first,
                            struct cml_error *err)
{
    struct cml_merge_array *array = &all->item[all->count];
    array->of_file = calloc((size_t)all->num_files, sizeof *array->of_file);
    if (!array->of_file) return cml_fail_memory(err, 1, "a merged result");
    all->count++;
    array->all = all;
    array->errors = cml_quantity_is_errors(first->field.name);
    for (int k = 0; k < all->num_files; k++) {
        array->of_file[k] = cml_hdf5_arrays_find(&all->file[k], first->field.name);
        if (same_size(first, array->of_file[k])) continue;
        free(array->of_file);
        all->count--;
        return CML_OK;
    }
    struct cml_field *field = &all->field[all->count - 1];
    *field = first->field;
    field->values = values;
    field->context = array;
    field->broken = &all->broken;
    return CML_OK;
}

static cml_status open_all(const struct cml_merge_input *inputs, int count, const struct cml_outcome *merged,
                           struct cml_merge_arrays *all, struct cml_error *err)
{
    all->file = calloc((size_t)count, sizeof *all->file);
    all->weight = calloc((size_t)count, sizeof *all->weight);
    all->error_weight = calloc((size_t)count, sizeof *all->error_weight);
    if (!all->file || !all->weight || !all->error_weight) return cml_fail_memory(err, 1, "a merged result");
    for (int k = 0; k < count; k++) {
        CML_TRY(cml_hdf5_arrays_open(inputs[k].name, &all->file[k], err));
        all->num_files++;
        all->weight[k] = (double)inputs[k].outcome->photons / (double)merged->photons;
        all->error_weight[k] = cml_merge_error_weight(inputs, count, k);
    }
    const struct cml_hdf5_arrays *first = &all->file[0];
    all->item = calloc((size_t)first->count + 1, sizeof *all->item);
    all->field = calloc((size_t)first->count + 1, sizeof *all->field);
    if (!all->item || !all->field) return cml_fail_memory(err, 1, "a merged result");
    for (int i = 0; i < first->count; i++) CML_TRY(add_array(all, &first->item[i], err));
    return CML_OK;
}

cml_status cml_merge_arrays_open(const struct cml_merge_input *inputs, int count,
                                 const struct cml_outcome *merged, struct cml_merge_arrays *arrays,
                                 struct cml_error *err)
{
    *arrays = (struct cml_merge_arrays){0};
    if (count < 1) return CML_OK;
    for (int k = 0; k < count; k++)
        if (!cml_file_ends_in(inputs[k].name, ".h5")) return CML_OK;
    const cml_status status = open_all(inputs, count, merged, arrays, err);
    if (status != CML_OK) cml_merge_arrays_close(arrays);
    return status;
}

void cml_merge_arrays_close(struct cml_merge_arrays *arrays)
{
    for (int i = 0; i < arrays->count; i++) free(arrays->item[i].of_file);
    for (int k = 0; k < arrays->num_files; k++) cml_hdf5_arrays_close(&arrays->file[k]);
    free(arrays->file);
    free(arrays->weight);
    free(arrays->error_weight);
    free(arrays->item);
    free(arrays->field);
    *arrays = (struct cml_merge_arrays){0};
}
