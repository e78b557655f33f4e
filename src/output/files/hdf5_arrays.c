/* SPDX-License-Identifier: MIT */
#include "output/files/hdf5_arrays.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef CML_HDF5
#include <hdf5.h>
#include <hdf5_hl.h>

/* A text attribute of fixed length, the caller's to free; "" where there is none, NULL without memory. */
static char *text_of(hid_t object, const char *name)
{
    const hid_t attribute = H5Aexists(object, name) > 0 ? H5Aopen(object, name, H5P_DEFAULT) : -1;
    if (attribute < 0) return strdup("");
    const hid_t type = H5Aget_type(attribute), wanted = H5Tcopy(H5T_C_S1);
    const size_t length = H5Tget_size(type);
    char *text = calloc(length + 1, 1);
    (void)H5Tset_size(wanted, length + 1);
    (void)H5Tset_cset(wanted, H5Tget_cset(type));
    if (text && (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) != 0 ||
                 H5Aread(attribute, wanted, text) < 0))
        text[0] = '\0';
    H5Tclose(wanted);
    H5Tclose(type);
    H5Aclose(attribute);
    return text;
}

/* The first scale of an axis: its name and its places. */
static herr_t read_scale(hid_t dataset, unsigned number, hid_t scale, void *context)
{
    (void)dataset, (void)number;
    struct cml_axis *axis = context;
    char name[64] = "";
    double *places = calloc(axis->n ? axis->n : 1, sizeof *places);
    const hid_t space = H5Dget_space(scale);
    const bool fits = H5Sget_simple_extent_npoints(space) == (hssize_t)axis->n;
    H5Sclose(space);
    axis->places = places;
    if (H5DSget_scale_name(scale, name, sizeof name) <= 0 || !places || !fits) return -1;
    if (H5Dread(scale, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, places) < 0) return -1;
    axis->name = strdup(name);
    axis->long_name = text_of(scale, "long_name");
    axis->units = text_of(scale, "units");
    return axis->name && axis->long_name && axis->units ? 1 : -1;
}

static bool read_axes(hid_t dataset, struct cml_hdf5_array *array)
{
    hsize_t size[CML_FIELD_AXES];
    const hid_t space = H5Dget_space(dataset);
    const int axes = H5Sget_simple_extent_ndims(space);
    const bool good =
        axes >= 0 && axes <= CML_FIELD_AXES && H5Sget_simple_extent_dims(space, size, NULL) >= 0;
    H5Sclose(space);
    for (int i = 0; good && i < axes; i++) {
        array->axis[i].n = (size_t)size[i];
        array->field.axis[array->field.num_axes++] = &array->axis[i];
        if (H5DSiterate_scales(dataset, (unsigned)i, NULL, read_scale, &array->axis[i]) <= 0) return false;
    }
    return good;
}

static bool read_array(hid_t dataset, const char *name, struct cml_hdf5_array *array)
{
    struct cml_field *field = &array->field;
    const hid_t type = H5Dget_type(dataset);
    char *errors = text_of(dataset, "ancillary_variables");
    snprintf(field->name, sizeof field->name, "%s", name);
    field->single = H5Tget_size(type) == sizeof(float);
    field->long_name = text_of(dataset, "long_name");
    field->units = text_of(dataset, "units");
    field->errors = errors;
    H5Tclose(type);
    if (errors && !errors[0]) {
        free(errors);
        field->errors = NULL;
    }
    return field->long_name && field->units && errors && read_axes(dataset, array);
}

static bool is_array(hid_t dataset)
{
    const hid_t type = H5Dget_type(dataset);
    const bool numbers = H5Tget_class(type) == H5T_FLOAT;
    H5Tclose(type);
    return numbers && H5DSis_scale(dataset) == 0;
}

/* One link of the root: an array is added to the list, whose memory grows by one at a time, as there are
 * dozens. */
static herr_t add_link(hid_t root, const char *name, const H5L_info_t *info, void *context)
{
    (void)info;
    struct cml_hdf5_arrays *arrays = context;
    const hid_t object = H5Oopen(root, name, H5P_DEFAULT);
    bool good = object >= 0;
    if (good && H5Iget_type(object) == H5I_DATASET && is_array(object)) {
        struct cml_hdf5_array *larger = realloc(arrays->item, (size_t)(arrays->count + 1) * sizeof *larger);
        good = larger != NULL;
        if (good) {
            arrays->item = larger;
            larger[arrays->count] = (struct cml_hdf5_array){0};
            good = read_array(object, name, &larger[arrays->count++]);
        }
    }
    if (object >= 0) H5Oclose(object);
    return good ? 0 : -1;
}

/* Arrays have moved while the list grew. */
static void point_to_axes(struct cml_hdf5_arrays *arrays)
{
    for (int i = 0; i < arrays->count; i++)
        for (int k = 0; k < arrays->item[i].field.num_axes; k++)
            arrays->item[i].field.axis[k] = &arrays->item[i].axis[k];
}

cml_status cml_hdf5_arrays_open(const char *path, struct cml_hdf5_arrays *arrays, struct cml_error *err)
{
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    *arrays = (struct cml_hdf5_arrays){.file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT)};
    if (arrays->file >= 0 &&
        H5Literate(arrays->file, H5_INDEX_NAME, H5_ITER_INC, NULL, add_link, arrays) >= 0) {
        point_to_axes(arrays);
        return CML_OK;
    }
    cml_hdf5_arrays_close(arrays);
    return cml_fail(err, CML_E_INPUT, "%s: its arrays cannot be read (expected the .h5 file of a run)", path);
}

static void clear(struct cml_hdf5_array *array)
{
    free((char *)array->field.long_name);
    free((char *)array->field.units);
    free((char *)array->field.errors);
    for (int k = 0; k < array->field.num_axes; k++) {
        free((char *)array->axis[k].name);
        free((char *)array->axis[k].long_name);
        free((char *)array->axis[k].units);
        free((double *)array->axis[k].places);
    }
}

void cml_hdf5_arrays_close(struct cml_hdf5_arrays *arrays)
{
    for (int i = 0; i < arrays->count; i++) clear(&arrays->item[i]);
    free(arrays->item);
    if (arrays->file >= 0) H5Fclose((hid_t)arrays->file);
    *arrays = (struct cml_hdf5_arrays){.file = -1};
}

/* The largest block of successive values from number `begin` on: part of one axis, and all later ones whole.
 */
static size_t choose_block(const struct cml_field *field, size_t begin, size_t count,
                           hsize_t start[CML_FIELD_AXES], hsize_t size[CML_FIELD_AXES])
{
    size_t values = 1; /* of a step along the axis */
    bool whole = true;
    for (int i = field->num_axes - 1; i >= 0; i--) {
        const size_t n = field->axis[i]->n, at = begin / values % n, left = count / values;
        start[i] = at;
        size[i] = !whole || left == 0 ? 1 : left < n - at ? left : n - at;
        whole = whole && at == 0 && size[i] == n;
        values *= n;
    }
    size_t block = 1;
    for (int i = 0; i < field->num_axes; i++) block *= (size_t)size[i];
    return block;
}

static bool read_block(hid_t dataset, int axes, const hsize_t *start, const hsize_t *size, double *out)
{
    const hid_t there = H5Dget_space(dataset), here = H5Screate_simple(axes, size, NULL);
    const bool good = H5Sselect_hyperslab(there, H5S_SELECT_SET, start, NULL, size, NULL) >= 0 &&
                      H5Dread(dataset, H5T_NATIVE_DOUBLE, here, there, H5P_DEFAULT, out) >= 0;
    H5Sclose(here);
    H5Sclose(there);
    return good;
}

bool cml_hdf5_array_read(const struct cml_hdf5_arrays *arrays, const struct cml_hdf5_array *array,
                         size_t begin, size_t count, double *out)
{
    const struct cml_field *field = &array->field;
    const hid_t dataset = H5Dopen2((hid_t)arrays->file, field->name, H5P_DEFAULT);
    bool good = dataset >= 0;
    if (good && field->num_axes == 0)
        good = H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, out) >= 0;
    for (size_t done = 0; good && field->num_axes > 0 && done < count;) {
        hsize_t start[CML_FIELD_AXES], size[CML_FIELD_AXES];
        const size_t block = choose_block(field, begin + done, count - done, start, size);
        good = read_block(dataset, field->num_axes, start, size, out + done);
        done += block;
    }
    if (dataset >= 0) H5Dclose(dataset);
    return good;
}

#else

cml_status cml_hdf5_arrays_open(const char *path, struct cml_hdf5_arrays *arrays, struct cml_error *err)
{
    *arrays = (struct cml_hdf5_arrays){.file = -1};
    return cml_fail(err, CML_E_INPUT, "%s: this program was built without HDF5", path);
}

void cml_hdf5_arrays_close(struct cml_hdf5_arrays *arrays)
{
    (void)arrays;
}

bool cml_hdf5_array_read(const struct cml_hdf5_arrays *arrays, const struct cml_hdf5_array *array,
                         size_t begin, size_t count, double *out)
{
    (void)arrays, (void)array, (void)begin, (void)count, (void)out;
    return false;
}

#endif

const struct cml_hdf5_array *cml_hdf5_arrays_find(const struct cml_hdf5_arrays *arrays, const char *name)
{
    for (int i = 0; i < arrays->count; i++)
        if (strcmp(arrays->item[i].field.name, name) == 0) return &arrays->item[i];
    return NULL;
}
