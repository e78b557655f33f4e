/* SPDX-License-Identifier: MIT */
#include "scene/heightmap/tile.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* cells: least margin around a period and least width of a patch */
enum { LEAST_MARGIN = 4, LEAST_WIDTH = 64 };

/* Tolerance in cells: vertices of two tiles that differ by no more stand in one place. */
static const double err_place = 1e-9;

/* ---- one period ---- */

/* Keeps the largest step in height between neighbouring samples in *most. */
static void measure_step(const double *from, const double *to, double *most)
{
    *most = fmax(*most, fabs(*to - *from));
}

/* Measures the largest steps between neighbouring samples, inside the map and across its seam. */
static void measure_steps(const struct cml_heightmap *map, struct cml_tile_notes *notes)
{
    const size_t nx = (size_t)map->nx, ny = (size_t)map->ny;
    const double *h = map->h;
    for (size_t j = 0; j < ny; j++) {
        for (size_t i = 0; i + 1 < nx; i++)
            measure_step(&h[j * nx + i], &h[j * nx + i + 1], &notes->inside[0]);
        measure_step(&h[j * nx + nx - 1], &h[j * nx], &notes->seam[0]);
    }
    for (size_t i = 0; i < nx; i++) {
        for (size_t j = 0; j + 1 < ny; j++)
            measure_step(&h[j * nx + i], &h[(j + 1) * nx + i], &notes->inside[1]);
        measure_step(&h[(ny - 1) * nx + i], &h[i], &notes->seam[1]);
    }
}

/* Replaces a map by the map followed by its mirror image: samples 0 1 2 3 become 0 1 2 3 2 1. */
static cml_status mirror(const char *path, struct cml_heightmap *map, struct cml_error *err)
{
    struct cml_heightmap whole;
    CML_TRY(cml_heightmap_allocate(path, 2.0 * (map->nx - 1), 2.0 * (map->ny - 1), &whole, err));
    for (int j = 0; j < whole.ny; j++)
        for (int i = 0; i < whole.nx; i++) {
            const int from_x = i < map->nx ? i : whole.nx - i, from_y = j < map->ny ? j : whole.ny - j;
            whole.h[(size_t)j * (size_t)whole.nx + (size_t)i] =
                map->h[(size_t)from_y * (size_t)map->nx + (size_t)from_x];
        }
    whole.x0 = map->x0;
    whole.y0 = map->y0;
    whole.dx = map->dx;
    whole.dy = map->dy;
    cml_heightmap_clear(map);
    *map = whole;
    return CML_OK;
}

cml_status cml_tile_make(const char *path, bool mirrored, struct cml_heightmap *map,
                         struct cml_tile_notes *notes, struct cml_error *err)
{
    *notes = (struct cml_tile_notes){.nx = map->nx, .ny = map->ny, .mirrored = mirrored};
    if (mirrored) CML_TRY(mirror(path, map, err));
    measure_steps(map, notes);
    cml_heightmap_measure(map, map->h, &notes->relief);
    return CML_OK;
}

double cml_tile_period(const struct cml_heightmap *tile, int axis)
{
    return axis == 0 ? tile->nx * tile->dx : tile->ny * tile->dy;
}

/* Returns i modulo n in 0..n - 1, also for negative i: the sample of a repeated heightmap. */
static int64_t wrap(int64_t i, int n)
{
    const int64_t rest = i % n;
    return rest < 0 ? rest + n : rest;
}

double cml_tile_height(const struct cml_heightmap *tile, int64_t i, int64_t j)
{
    return tile->h[wrap(j, tile->ny) * tile->nx + wrap(i, tile->nx)];
}

/* Diagonals alternate from cell to cell, as in the finest triangulation of heightmap_split.c, but not across
 * a seam between periods with an odd number of cells. */
bool cml_tile_rises(const struct cml_heightmap *tile, int64_t i, int64_t j)
{
    return (wrap(i, tile->nx) + wrap(j, tile->ny)) % 2 == 0;
}

/* Both triangles of a cell have the two ends of its diagonal as corners, and each has one of the other
 * corners. */
double cml_tile_mean(const struct cml_heightmap *tile)
{
    double sum = 0;
    for (int64_t j = 0; j < tile->ny; j++)
        for (int64_t i = 0; i < tile->nx; i++) {
            const int one = cml_tile_rises(tile, i, j) ? 0 : 1;
            sum += cml_tile_height(tile, i + one, j) + cml_tile_height(tile, i + 1 - one, j + 1) +
                   (cml_tile_height(tile, i + 1 - one, j) + cml_tile_height(tile, i + one, j + 1)) / 2;
        }
    return sum / 3 / ((double)tile->nx * (double)tile->ny);
}

bool cml_tile_is_flat(const struct cml_heightmap *tile)
{
    for (size_t i = 1; i < (size_t)tile->nx * (size_t)tile->ny; i++)
        if (tile->h[i] != tile->h[0]) return false;
    return true;
}

/* ---- meshes ---- */

/* Places the vertices of the cells' mesh: corners of the heightmap's samples, row by row. z points down, so
 * that heights change their sign. */
static void place_vertices(const struct cml_heightmap *tile, const struct cml_tile_cells *cells,
                           struct cml_mesh *mesh)
{
    for (int j = 0; j <= cells->count[1]; j++)
        for (int i = 0; i <= cells->count[0]; i++) {
            double *v = mesh->vertex[mesh->num_vertices++];
            v[0] = tile->x0 + (cells->first[0] + i) * tile->dx;
            v[1] = tile->y0 + (cells->first[1] + j) * tile->dy;
            v[2] = -cml_tile_height(tile, cells->first[0] + i, cells->first[1] + j);
        }
}

/* Adds two triangles per cell. The cell's corners are a: low x and y, b: high x, c: high x and y, d: high
 * y. */
static void place_triangles(const struct cml_heightmap *tile, const struct cml_tile_cells *cells,
                            struct cml_mesh *mesh)
{
    const uint32_t row = (uint32_t)cells->count[0] + 1;
    for (int j = 0; j < cells->count[1]; j++)
        for (int i = 0; i < cells->count[0]; i++) {
            const uint32_t a = (uint32_t)j * row + (uint32_t)i, b = a + 1, c = b + row, d = a + row;
            const bool rises = cml_tile_rises(tile, cells->first[0] + i, cells->first[1] + j);
            const uint32_t pair[2][3] = {{a, rises ? c : d, b}, {rises ? a : b, d, c}};
            memcpy(mesh->triangle[mesh->num_triangles], pair, sizeof pair);
            mesh->num_triangles += 2;
        }
}

cml_status cml_tile_sheet(const struct cml_heightmap *tile, const struct cml_tile_cells *cells,
                          enum cml_normals normals, struct cml_mesh *mesh, struct cml_error *err)
{
    const size_t nx = (size_t)cells->count[0], ny = (size_t)cells->count[1];
    *mesh = (struct cml_mesh){.normals = normals};
    CML_TRY(cml_mesh_allocate(mesh, (nx + 1) * (ny + 1), 2 * nx * ny, "a mesh", err));
    place_vertices(tile, cells, mesh);
    place_triangles(tile, cells, mesh);
    return CML_OK;
}

/* Refuses a patch in which vertices would be joined or triangles dropped, because the numbers of all later
 * triangles would change. */
cml_status cml_tile_patch(const struct cml_heightmap *tile, const struct cml_tile_cells *cells,
                          enum cml_normals normals, struct cml_mesh *mesh, struct cml_error *err)
{
    struct cml_mesh_notes notes;
    CML_TRY(cml_tile_sheet(tile, cells, normals, mesh, err));
    mesh->skirt = fmin(tile->dx, tile->dy);
    cml_status status = cml_mesh_prepare(mesh, NULL, &notes, err);
    if (status == CML_OK && notes.welded + notes.degenerate > 0)
        status = cml_fail(err, CML_E_INPUT,
                          "cells of %g x %g cm at x = %g, y = %g cm are too small for double precision",
                          tile->dx, tile->dy, tile->x0, tile->y0);
    if (status != CML_OK) cml_mesh_clear(mesh);
    return status;
}

struct cml_tile_cells cml_tile_patch_cells(const struct cml_heightmap *tile)
{
    const int n[2] = {tile->nx, tile->ny};
    struct cml_tile_cells cells;
    for (int k = 0; k < 2; k++) {
        const int missing = (LEAST_WIDTH - n[k] + 1) / 2,
                  margin = missing > LEAST_MARGIN ? missing : LEAST_MARGIN;
        cells.first[k] = -margin;
        cells.count[k] = n[k] + 2 * margin;
    }
    return cells;
}

/* ---- two tiles ---- */

/* Sets *cells to the number of cells by which the second grid is shifted along an axis. Returns false if the
 * grids have different cells. */
static bool cells_between(const double origin[2], const double spacing[2], const int n[2], int64_t *cells)
{
    const double between = (origin[1] - origin[0]) / spacing[0], whole = rint(between);
    *cells = (int64_t)fmod(whole, n[0]);
    return n[0] == n[1] && fabs(spacing[1] - spacing[0]) * n[0] <= err_place * spacing[0] &&
           fabs(between - whole) <= err_place * fmax(1, fabs(between));
}

/* Returns the depth in the middle of cell i, j, which is the middle of the cell's diagonal. */
static double depth_at_middle(const struct cml_heightmap *tile, double z, int64_t i, int64_t j)
{
    const int64_t one = cml_tile_rises(tile, i, j) ? 0 : 1;
    return z - (cml_tile_height(tile, i + one, j) + cml_tile_height(tile, i + 1 - one, j + 1)) / 2;
}

/* Keeps the smallest gap between two boundaries found so far, and its place in at[]. upper, lower: depths of
 * the two boundaries at (x, y), cm. */
static void keep_closest(double upper, double lower, double x, double y, double *gap, double at[3])
{
    if (!(lower - upper < *gap)) return;
    *gap = lower - upper;
    at[0] = x;
    at[1] = y;
    at[2] = upper;
}

/* Corners and middles of cells are enough: both tiles are linear over the same half cells or, where their
 * diagonals differ, over the same quarters of cells. */
bool cml_tile_closest(const struct cml_heightmap *upper, double z_upper, const struct cml_heightmap *lower,
                      double z_lower, double *gap, double at[3])
{
    int64_t di, dj;
    *gap = INFINITY;
    if (!cells_between((double[]){upper->x0, lower->x0}, (double[]){upper->dx, lower->dx},
                       (int[]){upper->nx, lower->nx}, &di) ||
        !cells_between((double[]){upper->y0, lower->y0}, (double[]){upper->dy, lower->dy},
                       (int[]){upper->ny, lower->ny}, &dj))
        return false;
    for (int j = 0; j < upper->ny; j++)
        for (int i = 0; i < upper->nx; i++) {
            const double x = upper->x0 + i * upper->dx, y = upper->y0 + j * upper->dy;
            keep_closest(z_upper - cml_tile_height(upper, i, j),
                         z_lower - cml_tile_height(lower, i - di, j - dj), x, y, gap, at);
            keep_closest(depth_at_middle(upper, z_upper, i, j),
                         depth_at_middle(lower, z_lower, i - di, j - dj), x + upper->dx / 2,
                         y + upper->dy / 2, gap, at);
        }
    return true;
}
