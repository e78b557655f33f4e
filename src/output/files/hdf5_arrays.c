/* SPDX-License-Identifier: MIT */
#include "output/files/hdf5_arrays.h"

#include <stdlib.h>
#include <string.h>

#ifdef CML_HDF5

static cml_status read_scale(const struct cml_hdf5_dataset *dataset, struct cml_hdf5_scale *scale,
                             struct cml_error *err)
{
    const struct cml_hdf5 *file = dataset->file;
    struct cml_axis *axis = &scale->axis;
    double *values = calloc(dataset->size, sizeof *values);
    strcpy(scale->name, dataset->name);
    axis->name = scale->name;
    axis->n = dataset->size;
    axis->values = values;
    if (!values) return cml_fail_memory(err, 8.0 * (double)dataset->size, dataset->name);
    CML_TRY(cml_hdf5_values(dataset, 0, dataset->size, values, err));
    CML_TRY(cml_hdf5_text(file, dataset, "long_name", (char **)&axis->long_name, err));
    CML_TRY(cml_hdf5_text(file, dataset, "units", (char **)&axis->units, err));
    return cml_hdf5_uses(dataset, &scale->uses, &scale->num_uses, err);
}

static const struct cml_axis *find_axis(const struct cml_hdf5_arrays *arrays, uint64_t dataset, int number,
                                        size_t n)
{
    for (int i = 0; i < arrays->num_scales; i++) {
        const struct cml_hdf5_scale *scale = &arrays->scale[i];
        for (size_t k = 0; scale->axis.n == n && k < scale->num_uses; k++)
            if (scale->uses[k].dataset == dataset && scale->uses[k].axis == number) return &scale->axis;
    }
    return NULL;
}

static cml_status read_array(const struct cml_hdf5_arrays *arrays, const struct cml_hdf5_dataset *dataset,
                             struct cml_field *field, struct cml_error *err)
{
    const struct cml_hdf5 *file = dataset->file;
    char *errors;
    strcpy(field->name, dataset->name);
    field->single = dataset->single;
    CML_TRY(cml_hdf5_text(file, dataset, "long_name", (char **)&field->long_name, err));
    CML_TRY(cml_hdf5_text(file, dataset, "units", (char **)&field->units, err));
    CML_TRY(cml_hdf5_text(file, dataset, "ancillary_variables", &errors, err));
    field->errors = errors;
    if (!errors[0]) {
        free(errors);
        field->errors = NULL;
    }
    for (int i = 0; i < dataset->num_axes; i++) {
        field->axis[i] = find_axis(arrays, cml_hdf5_address(dataset), i, dataset->n[i]);
        if (!field->axis[i])
            return cml_fail(err, CML_E_INPUT,
                            "%.400s: %s has an axis without a scale (expected one for each)", file->path,
                            field->name);
        field->num_axes++;
    }
    return CML_OK;
}

static cml_status is_scale(const struct cml_hdf5_dataset *dataset, bool *is, struct cml_error *err)
{
    char *class;
    CML_TRY(cml_hdf5_text(dataset->file, dataset, "CLASS", &class, err));
    *is = strcmp(class, "DIMENSION_SCALE") == 0;
    free(class);
    return CML_OK;
}

/* All scales, then all arrays, which point to them. */
static cml_status read_all(struct cml_hdf5_arrays *arrays, const struct cml_hdf5_dataset *list, int count,
                           struct cml_error *err)
{
    arrays->item = calloc((size_t)count + 1, sizeof *arrays->item);
    arrays->scale = calloc((size_t)count + 1, sizeof *arrays->scale);
    if (!arrays->item || !arrays->scale) return cml_fail_memory(err, 1, "a list of arrays");
    for (int scales = 1; scales >= 0; scales--)
        for (int i = 0; i < count; i++) {
            bool scale;
            CML_TRY(is_scale(&list[i], &scale, err));
            if (scale != (scales == 1)) continue;
            CML_TRY(scale ? read_scale(&list[i], &arrays->scale[arrays->num_scales++], err)
                          : read_array(arrays, &list[i], &arrays->item[arrays->count++].field, err));
        }
    return CML_OK;
}

cml_status cml_hdf5_arrays_open(const char *path, struct cml_hdf5_arrays *arrays, struct cml_error *err)
{
    struct cml_hdf5_dataset *list = NULL;
    int count = 0;
    *arrays = (struct cml_hdf5_arrays){0};
    CML_TRY(cml_hdf5_open(path, &arrays->file, err));
    cml_status status = cml_hdf5_datasets(&arrays->file, &list, &count, err);
    if (status == CML_OK) status = read_all(arrays, list, count, err);
    for (int i = 0; i < count; i++) cml_hdf5_dataset_close(&list[i]);
    free(list);
    if (status != CML_OK) cml_hdf5_arrays_close(arrays);
    return status;
}

void cml_hdf5_arrays_close(struct cml_hdf5_arrays *arrays)
{
    for (int i = 0; i < arrays->count; i++) {
        const struct cml_field *field = &arrays->item[i].field;
        free((char *)field->long_name);
        free((char *)field->units);
        free((char *)field->errors);
        cml_hdf5_dataset_close(&arrays->item[i].dataset);
    }
    for (int i = 0; i < arrays->num_scales; i++) {
        const struct cml_axis *axis = &arrays->scale[i].axis;
        free((char *)axis->long_name);
        free((char *)axis->units);
        free((double *)axis->values);
        free(arrays->scale[i].uses);
    }
    free(arrays->item);
    free(arrays->scale);
    cml_hdf5_close(&arrays->file);
    *arrays = (struct cml_hdf5_arrays){0};
}

/* Closed behind the last value: results may be many, and each array that is open holds a chunk. */
cml_status cml_hdf5_array_read(const struct cml_hdf5_arrays *arrays, struct cml_hdf5_array *array,
                               size_t begin, size_t count, double *out, struct cml_error *err)
{
    struct cml_hdf5_dataset *dataset = &array->dataset;
    if (dataset->id == 0) CML_TRY(cml_hdf5_dataset_open(&arrays->file, array->field.name, dataset, err));
    CML_TRY(cml_hdf5_values(dataset, begin, count, out, err));
    if (begin + count == dataset->size) cml_hdf5_dataset_close(dataset);
    return CML_OK;
}

#else

cml_status cml_hdf5_arrays_open(const char *path, struct cml_hdf5_arrays *arrays, struct cml_error *err)
{
    *arrays = (struct cml_hdf5_arrays){0};
    return cml_hdf5_open(path, &arrays->file, err);
}

void cml_hdf5_arrays_close(struct cml_hdf5_arrays *arrays)
{
    (void)arrays;
}

cml_status cml_hdf5_array_read(const struct cml_hdf5_arrays *arrays, struct cml_hdf5_array *array,
                               size_t begin, size_t count, double *out, struct cml_error *err)
{
    (void)array, (void)begin, (void)count, (void)out;
    return cml_hdf5_open(arrays->file.path, &(struct cml_hdf5){0}, err);
}

#endif

struct cml_hdf5_array *cml_hdf5_arrays_find(const struct cml_hdf5_arrays *arrays, const char *name)
{
    for (int i = 0; i < arrays->count; i++)
        if (strcmp(arrays->item[i].field.name, name) == 0) return &arrays->item[i];
    return NULL;
}
