/* SPDX-License-Identifier: MIT */
#include "plot/files/map_h5.h"

#include "result/h5.h"

#include <stdlib.h>
#include <string.h>

#ifdef CML_HDF5

enum { AXIS_NAME = 64 };

/* Corner and width of the pixels from their middles. The middle of a single one lies at 0; *width stays. */
static cml_status read_pixel_axis(const struct cml_hdf5 *file, const char *name, size_t n, double *origin,
                                  double *width, struct cml_error *err)
{
    double *middle;
    CML_TRY(cml_h5_numbers(file, name, n, &middle, NULL, err));
    if (!middle)
        return cml_fail(err, CML_E_INPUT, "%.400s: %.80s has 0 numbers (expected %zu)", file->path, name, n);
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
    snprintf(name, AXIS_NAME, "%.*s%c", end ? (int)(end - map) + 1 : 0, map, axis);
}

static cml_status fill_map(const struct cml_hdf5 *file, const char *name, const double *value,
                           const struct cml_hdf5_dataset *shape, struct cml_pixels *map,
                           struct cml_error *err)
{
    if (!value || shape->num_axes != 2)
        return cml_fail(err, CML_E_INPUT, "%.400s: no map %.80s (expected a data set over y and x)",
                        file->path, name);
    const size_t n[2] = {shape->n[1], shape->n[0]};
    char axis[2][AXIS_NAME];
    for (int i = 0; i < 2; i++) name_axis(name, "xy"[i], axis[i]);
    *map = (struct cml_pixels){.n = {n[0], n[1]}, .spacing = {1, 1}};
    CML_TRY(read_pixel_axis(file, axis[0], n[0], &map->origin[0], &map->spacing[0], err));
    if (n[1] == 1) map->spacing[1] = map->spacing[0];
    CML_TRY(read_pixel_axis(file, axis[1], n[1], &map->origin[1], &map->spacing[1], err));
    map->value = malloc(n[0] * n[1] * sizeof *map->value);
    if (!map->value) return cml_fail_memory(err, 4.0 * (double)(n[0] * n[1]), "a map");
    for (size_t i = 0; i < n[0] * n[1]; i++) {
        map->value[i] = (float)value[i];
        if (!(value[i] >= 0 && value[i] <= 1e30))
            return cml_fail(err, CML_E_INPUT,
                            "%.400s: %.80s of pixel %zu %zu = %g (expected a number of 0 or more)",
                            file->path, name, i % n[0], i / n[0], value[i]);
    }
    return CML_OK;
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

cml_status cml_hdf5_read_map(const char *path, const char *name, struct cml_pixels *map,
                             char unit[CML_HDF5_UNIT], struct cml_error *err)
{
    struct cml_hdf5 file;
    struct cml_hdf5_dataset shape;
    double *value;
    *map = (struct cml_pixels){0};
    unit[0] = '\0';
    CML_TRY(cml_hdf5_open(path, &file, err));
    cml_status status = cml_h5_numbers(&file, name, 0, &value, &shape, err);
    if (status == CML_OK) status = fill_map(&file, name, value, &shape, map, err);
    free(value);
    if (status == CML_OK) status = read_unit(&file, name, unit, err);
    cml_hdf5_close(&file);
    if (status != CML_OK) cml_pixels_clear(map);
    return status;
}

#else

cml_status cml_hdf5_read_map(const char *path, const char *name, struct cml_pixels *map,
                             char unit[CML_HDF5_UNIT], struct cml_error *err)
{
    (void)name;
    *map = (struct cml_pixels){0};
    unit[0] = '\0';
    return cml_hdf5_open(path, &(struct cml_hdf5){0}, err);
}

#endif
