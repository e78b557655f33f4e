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
    const struct cml_hdf5_array **of_file; /* [num_files] */
    bool errors;                           /* roots of sums of squares, else means */
};

static void add_piece(const struct cml_merge_array *array, int file, size_t begin, size_t count, double *out)
{
    double numbers[PIECE];
    struct cml_merge_arrays *all = array->all;
    const double weight = all->weight[file];
    if (!cml_hdf5_array_read(&all->file[file], array->of_file[file], begin, count, numbers)) {
        all->broken = true;
        return;
    }
    for (size_t i = 0; i < count; i++)
        out[i] += array->errors ? weight * numbers[i] * weight * numbers[i] : weight * numbers[i];
}

static void values(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_merge_array *array = context;
    memset(out, 0, count * sizeof *out);
    for (size_t done = 0; done < count; done += PIECE)
        for (int k = 0; k < array->all->num_files; k++)
            add_piece(array, k, begin + done, count - done < PIECE ? count - done : PIECE, out + done);
    for (size_t i = 0; array->errors && i < count; i++) out[i] = sqrt(out[i]);
}

static bool same_size(const struct cml_hdf5_array *one, const struct cml_hdf5_array *other)
{
    if (!other || one->field.num_axes != other->field.num_axes) return false;
    for (int i = 0; i < one->field.num_axes; i++)
        if (one->axis[i].n != other->axis[i].n) return false;
    return true;
}

static bool is_error(const char *name)
{
    const size_t length = strlen(name);
    return length > 3 && strcmp(name + length - 3, "_se") == 0;
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
    array->errors = is_error(first->field.name);
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

static cml_status open_all(const struct cml_merge_input *inputs, int count, const struct cml_mco *merged,
                           struct cml_merge_arrays *all, struct cml_error *err)
{
    all->file = calloc((size_t)count, sizeof *all->file);
    all->weight = calloc((size_t)count, sizeof *all->weight);
    if (!all->file || !all->weight) return cml_fail_memory(err, 1, "a merged result");
    for (int k = 0; k < count; k++) {
        CML_TRY(cml_hdf5_arrays_open(inputs[k].name, &all->file[k], err));
        all->num_files++;
        all->weight[k] = (double)inputs[k].mco->photons / (double)merged->photons;
    }
    const struct cml_hdf5_arrays *first = &all->file[0];
    all->item = calloc((size_t)first->count, sizeof *all->item);
    all->field = calloc((size_t)first->count, sizeof *all->field);
    if (!all->item || !all->field) return cml_fail_memory(err, 1, "a merged result");
    for (int i = 0; i < first->count; i++) CML_TRY(add_array(all, &first->item[i], err));
    return CML_OK;
}

cml_status cml_merge_arrays_open(const struct cml_merge_input *inputs, int count,
                                 const struct cml_mco *merged, struct cml_merge_arrays *arrays,
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
    free(arrays->item);
    free(arrays->field);
    *arrays = (struct cml_merge_arrays){0};
}
