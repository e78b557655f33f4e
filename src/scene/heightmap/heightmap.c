/* Measured heightmaps: memory, missing heights, placement, statistics. SPDX-License-Identifier: MIT */
#include "scene/heightmap/heightmap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* nx, ny are doubles, because the product of two ints from a file may not fit an int. */
cml_status cml_heightmap_allocate(const char *path, double nx, double ny, struct cml_heightmap *map,
                                  struct cml_error *err)
{
    const double most = 67108864;
    *map = (struct cml_heightmap){0};
    if (nx * ny > most)
        return cml_fail(err, CML_E_INPUT, "%s: %.0f x %.0f heights (expected at most 2^26)", path, nx, ny);
    map->nx = (int)nx;
    map->ny = (int)ny;
    map->h = calloc((size_t)(nx * ny), sizeof *map->h);
    return map->h ? CML_OK : cml_fail_memory(err, 8 * nx * ny, "a heightmap");
}

void cml_heightmap_clear(struct cml_heightmap *map)
{
    free(map->h);
    *map = (struct cml_heightmap){0};
}

cml_status cml_heightmap_check(const char *path, const struct cml_heightmap *map, struct cml_error *err)
{
    const size_t nx = (size_t)map->nx, count = nx * (size_t)map->ny;
    size_t missing = 0, first = 0;
    for (size_t i = 0; i < count; i++) {
        if (isfinite(map->h[i])) continue;
        if (missing++ == 0) first = i;
    }
    if (missing == 0) return CML_OK;
    return cml_fail(
        err, CML_E_INPUT,
        "%s: %zu of %zu heights are missing, the first in row %zu, column %zu (expected a height in "
        "every cell: fill the holes first)",
        path, missing, count, first / nx + 1, first % nx + 1);
}

/* Reverses the order of the rows. This turns a file's order into the order by rising y, and is also part of a
 * turn about the x axis. */
static void swap_rows(struct cml_heightmap *map)
{
    const size_t nx = (size_t)map->nx, ny = (size_t)map->ny;
    for (size_t j = 0; j < ny / 2; j++)
        for (size_t i = 0; i < nx; i++) {
            double *low = &map->h[j * nx + i], *high = &map->h[(ny - 1 - j) * nx + i];
            const double kept = *low;
            *low = *high;
            *high = kept;
        }
}

void cml_heightmap_centre(struct cml_heightmap *map)
{
    swap_rows(map);
    map->x0 = -0.5 * (map->nx - 1) * map->dx;
    map->y0 = -0.5 * (map->ny - 1) * map->dy;
}

/* The turn changes the signs of y and of the heights; y is symmetric about the map's middle, so only the
 * order of the rows changes. */
void cml_heightmap_place(struct cml_heightmap *map, double scale, const double shift[3], bool turn)
{
    const size_t count = (size_t)map->nx * (size_t)map->ny;
    const double factor = turn ? -scale : scale;
    if (turn) swap_rows(map);
    for (size_t i = 0; i < count; i++) map->h[i] = map->h[i] * factor + shift[2];
    map->dx *= scale;
    map->dy *= scale;
    map->x0 = map->x0 * scale + shift[0];
    map->y0 = map->y0 * scale + shift[1];
}

/* Returns the sum of squared slopes over one row of cells. A cell is cut along either diagonal into two
 * triangles. Each triangle has one of the cell's two edges along x and one of its two edges along y. The mean
 * square of the slope is therefore the mean over these edges. */
static double slope_squares(const struct cml_heightmap *map, const double *h, int j)
{
    const double *low = h + (size_t)j * (size_t)map->nx, *high = low + map->nx;
    double sum = 0;
    for (int i = 0; i + 1 < map->nx; i++) {
        const double along_low = (low[i + 1] - low[i]) / map->dx,
                     along_high = (high[i + 1] - high[i]) / map->dx;
        const double up_left = (high[i] - low[i]) / map->dy, up_right = (high[i + 1] - low[i + 1]) / map->dy;
        sum += along_low * along_low + along_high * along_high + up_left * up_left + up_right * up_right;
    }
    return sum / 2;
}

/* Sums squares about the mean in a second pass. A single pass would lose the digits of a shallow relief at a
 * large height. */
void cml_heightmap_measure(const struct cml_heightmap *map, const double *h, struct cml_relief *relief)
{
    const size_t count = (size_t)map->nx * (size_t)map->ny;
    double sum = 0, squares = 0, slopes = 0;
    *relief = (struct cml_relief){.lowest = h[0], .highest = h[0]};
    for (size_t i = 0; i < count; i++) {
        sum += h[i];
        relief->lowest = fmin(relief->lowest, h[i]);
        relief->highest = fmax(relief->highest, h[i]);
    }
    relief->mean = sum / (double)count;
    for (size_t i = 0; i < count; i++) squares += (h[i] - relief->mean) * (h[i] - relief->mean);
    for (int j = 0; j + 1 < map->ny; j++) slopes += slope_squares(map, h, j);
    relief->rms = sqrt(squares / (double)count);
    relief->slope_rms = sqrt(slopes / ((double)(map->nx - 1) * (double)(map->ny - 1)));
}
