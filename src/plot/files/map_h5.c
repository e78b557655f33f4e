/* SPDX-License-Identifier: MIT */
#include "plot/files/map_h5.h"

#include "result/h5.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void cml_pixels_clear(struct cml_pixels *pixels)
{
    free(pixels->value);
    *pixels = (struct cml_pixels){0};
}

bool cml_hdf5_is_volume(const char *name)
{
    return strncmp(name, "A_xyz", 5) == 0 || strncmp(name, "phi_xyz", 7) == 0;
}

#ifdef CML_HDF5

enum { AXIS_NAME = 64 };

/* Corner and width of the pixels from their middles, which are there. The middle of a single one lies at 0;
 * *width stays. */
static cml_status read_pixel_axis(const struct cml_hdf5 *file, const char *name, size_t n, double *origin,
                                  double *width, struct cml_error *err)
{
    double *middle;
    CML_TRY(cml_h5_numbers(file, name, n, &middle, NULL, err));
    if (n > 1) *width = (middle[n - 1] - middle[0]) / (double)(n - 1);
    *origin = middle[0] - *width / 2;
    free(middle);
    if (*width >= 1e-12 && *width <= 1e12) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "%.400s: %s has a step of %g (expected one of 1e-12..1e12)", file->path,
                    name, *width);
}

/* A detector's map, and its errors, have axes of their own: detector_NAME_x of detector_NAME_map. */
static void name_axis(const char *map, char axis, char name[AXIS_NAME])
{
    const char *end = NULL;
    for (const char *at = map; strncmp(map, "detector_", 9) == 0 && (at = strstr(at, "_map")); at++) end = at;
    snprintf(name, AXIS_NAME, "%.*s%c%s", end ? (int)(end - map) + 1 : 0, map, axis,
             axis == 'z' ? "_volume" : "");
}

/* Axes of a picture: the letter of each, its number in the data set, and how far its neighbours lie apart. */
struct picture_axis {
    char letter;
    int number;
    size_t stride;
};

static struct picture_axis axis_of(const struct cml_hdf5_dataset *shape, char letter)
{
    const int last = shape->num_axes - 1, number = last - (letter - 'x');
    struct picture_axis axis = {letter, number, 1};
    for (int i = number + 1; i <= last; i++) axis.stride *= shape->n[i];
    return axis;
}

/* Number of the first value of the voxels that the cut meets; those at the far face count for the last. */
static cml_status find_layer(const struct cml_hdf5 *file, const struct cml_hdf5_dataset *shape,
                             const struct cml_voxel_cut *cut, const char *name, size_t *first,
                             struct cml_error *err)
{
    const struct picture_axis axis = axis_of(shape, cut->axis);
    const size_t n = shape->n[axis.number];
    char scale[AXIS_NAME];
    double origin, width = 1;
    name_axis(name, cut->axis, scale);
    CML_TRY(read_pixel_axis(file, scale, n, &origin, &width, err));
    const double end = origin + (double)n * width, place = floor((cut->at - origin) / width);
    if (!(cut->at >= origin && cut->at <= end))
        return cml_fail(err, CML_E_INPUT,
                        "--cut %c=%g (expected a place of %g to %g cm, in the voxels of %.400s)", cut->axis,
                        cut->at, origin, end, file->path);
    *first = (place < (double)n ? (size_t)place : n - 1) * axis.stride;
    return CML_OK;
}

static cml_status read_axes(const struct cml_hdf5 *file, const char *name, const struct picture_axis axis[2],
                            struct cml_pixels *map, struct cml_error *err)
{
    char scale[AXIS_NAME];
    for (int i = 0; i < 2; i++) {
        name_axis(name, axis[i].letter, scale);
        if (map->n[i] == 1) map->spacing[i] = map->spacing[0];
        CML_TRY(read_pixel_axis(file, scale, map->n[i], &map->origin[i], &map->spacing[i], err));
    }
    return CML_OK;
}

/* What is infinite, not a number or below 0 is no light. */
static cml_status take_values(const struct cml_hdf5 *file, const char *name, const double *value,
                              const struct picture_axis axis[2], struct cml_pixels *map,
                              struct cml_error *err)
{
    const size_t n = map->n[0] * map->n[1];
    map->value = malloc(n * sizeof *map->value);
    if (!map->value) return cml_fail_memory(err, 4.0 * (double)n, "a map");
    for (size_t i = 0; i < n; i++) {
        const size_t x = i % map->n[0], y = i / map->n[0];
        const double number = value[x * axis[0].stride + y * axis[1].stride];
        map->value[i] = (float)number;
        if (!(number >= 0 && number <= 1e30))
            return cml_fail(err, CML_E_INPUT,
                            "%.400s: %.80s of pixel %zu %zu = %g (expected a number of 0 or more)",
                            file->path, name, x, y, number);
    }
    return CML_OK;
}

/* Whether the middles of pixels belong to that axis of the array, which may be a profile over others; those
 * that belong to nothing, as in a file of others, count for all. */
static cml_status belongs(const struct cml_hdf5 *file, const char *name, uint64_t array,
                          const struct picture_axis *axis, bool *yes, struct cml_error *err)
{
    struct cml_hdf5_dataset scale;
    struct cml_hdf5_use *uses = NULL;
    size_t count = 0;
    char of[AXIS_NAME];
    name_axis(name, axis->letter, of);
    *yes = false;
    CML_TRY(cml_hdf5_dataset_open(file, of, &scale, err));
    if (scale.id == 0) return CML_OK;
    const cml_status status = cml_hdf5_uses(&scale, &uses, &count, err);
    *yes = count == 0;
    for (size_t i = 0; i < count; i++)
        *yes = *yes || (uses[i].dataset == array && uses[i].axis == axis->number);
    free(uses);
    cml_hdf5_dataset_close(&scale);
    return status;
}

/* Whether an array of the right number of axes lies over x and y, or over those of voxels. */
static cml_status is_picture(const struct cml_hdf5 *file, const char *name,
                             const struct cml_hdf5_dataset *shape, bool *yes, struct cml_error *err)
{
    struct cml_hdf5_dataset array;
    CML_TRY(cml_hdf5_dataset_open(file, name, &array, err));
    const uint64_t address = cml_hdf5_address(&array);
    cml_hdf5_dataset_close(&array);
    *yes = true;
    for (int i = 0; *yes && i < shape->num_axes; i++) {
        const struct picture_axis axis = axis_of(shape, (char)('x' + i));
        CML_TRY(belongs(file, name, address, &axis, yes, err));
    }
    return CML_OK;
}

static cml_status fill_map(const struct cml_hdf5 *file, const char *name, const struct cml_voxel_cut *cut,
                           const char *else_known, const double *value, const struct cml_hdf5_dataset *shape,
                           struct cml_pixels *map, struct cml_error *err)
{
    const bool volume = cml_hdf5_is_volume(name);
    size_t first = 0;
    bool picture = value && shape->num_axes == (volume ? 3 : 2);
    if (picture) CML_TRY(is_picture(file, name, shape, &picture, err));
    if (!picture)
        return cml_fail(err, CML_E_INPUT, "%.400s: no map %.80s (expected a data set over %s, or one of %s)",
                        file->path, name, volume ? "z_volume, y and x" : "y and x", else_known);
    const struct picture_axis axis[2] = {axis_of(shape, volume && cut->axis == 'x' ? 'y' : 'x'),
                                         axis_of(shape, volume && cut->axis != 'z' ? 'z' : 'y')};
    *map = (struct cml_pixels){.n = {shape->n[axis[0].number], shape->n[axis[1].number]}, .spacing = {1, 1}};
    if (volume) CML_TRY(find_layer(file, shape, cut, name, &first, err));
    CML_TRY(read_axes(file, name, axis, map, err));
    return take_values(file, name, value + first, axis, map, err);
}

static cml_status read_unit(const struct cml_hdf5 *file, const char *name, char unit[CML_HDF5_UNIT],
                            struct cml_error *err)
{
    struct cml_hdf5_dataset dataset;
    char *text;
    CML_TRY(cml_hdf5_dataset_open(file, name, &dataset, err));
    const cml_status status = cml_hdf5_text(file, &dataset, "units", &text, err);
    cml_hdf5_dataset_close(&dataset);
    if (status != CML_OK) return status;
    snprintf(unit, CML_HDF5_UNIT, "%s", text);
    free(text);
    return CML_OK;
}

cml_status cml_hdf5_read_map(const char *path, const char *name, const struct cml_voxel_cut *cut,
                             const char *else_known, struct cml_pixels *map, char unit[CML_HDF5_UNIT],
                             struct cml_error *err)
{
    struct cml_hdf5 file;
    struct cml_hdf5_dataset shape;
    double *value;
    *map = (struct cml_pixels){0};
    unit[0] = '\0';
    CML_TRY(cml_hdf5_open(path, &file, err));
    cml_status status = cml_h5_numbers(&file, name, 0, &value, &shape, err);
    if (status == CML_OK) status = fill_map(&file, name, cut, else_known, value, &shape, map, err);
    free(value);
    if (status == CML_OK) status = read_unit(&file, name, unit, err);
    cml_hdf5_close(&file);
    if (status != CML_OK) cml_pixels_clear(map);
    return status;
}

#else

cml_status cml_hdf5_read_map(const char *path, const char *name, const struct cml_voxel_cut *cut,
                             const char *else_known, struct cml_pixels *map, char unit[CML_HDF5_UNIT],
                             struct cml_error *err)
{
    (void)name, (void)cut, (void)else_known;
    *map = (struct cml_pixels){0};
    unit[0] = '\0';
    return cml_hdf5_open(path, &(struct cml_hdf5){0}, err);
}

#endif
