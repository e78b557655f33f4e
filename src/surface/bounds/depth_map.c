/* Builds pyramids of least and greatest depth for meshes, tiles and rings. SPDX-License-Identifier: MIT */
#include "surface/bounds/depth_map.h"

#include "base/array.h"
#include "geometry/vec3.h"
#include "surface/bounds/cell_horizon.h"

#include <math.h>
#include <stdlib.h>

enum {
    LEAST_LEVELS = 5,
    MOST_LEVELS = CML_HORIZON_MOST_LEVELS
};                                /* levels of a map of squares: 16 to 512 cells along a side */
enum { MOST_RADIAL_LEVELS = 11 }; /* levels of rows: up to 1024 cells; CML_DEPTH_LEVELS of kernels/types.h */

/* Margin by which shapes are widened before their cells are found, as a share of a cell. It exceeds rounding:
 * cell numbers up to 1024, computed in float, are off by 3e-5. */
static const double err_cell = 1e-3;

/* Share of a map's extent by which depths are widened. Positions in the map, in float, are off by 6e-8
 * each. */
static const double err_depth = 1e-5;

size_t cml_depth_map_level_cells(const struct cml_depth_map *map, int level)
{
    const size_t side = (size_t)(map->size >> level);
    return map->form == CML_BOUNDS_RADII ? side : side * side;
}

/* Allocates a map with the given number of levels. No cell has a depth yet. Returns CML_E_INPUT if memory
 * runs out. */
static cml_status allocate(int levels, enum cml_bounds_form form, struct cml_depth_map *map,
                           struct cml_error *err)
{
    *map = (struct cml_depth_map){.levels = levels, .size = 1 << (levels - 1), .form = form};
    for (int l = 0; l < levels; l++) map->cells += cml_depth_map_level_cells(map, l);
    map->deepest = malloc(2 * map->cells * sizeof *map->deepest);
    if (!map->deepest)
        return cml_fail_memory(err, (double)(2 * map->cells * sizeof *map->deepest),
                               "the bounds of a boundary");
    map->highest = map->deepest + map->cells;
    for (size_t i = 0; i < map->cells; i++) {
        map->deepest[i] = -INFINITY;
        map->highest[i] = INFINITY;
    }
    return CML_OK;
}

void cml_depth_map_clear(struct cml_depth_map *map)
{
    free(map->deepest);
    free(map->horizon[0]);
    *map = (struct cml_depth_map){0};
}

/* Extends the depth range of a cell of level 0 to include the depths least..most, cm. */
static void widen_cell(struct cml_depth_map *map, int ix, int iy, double least, double most)
{
    const size_t cell = (size_t)iy * (size_t)map->size + (size_t)ix;
    map->deepest[cell] = fmaxf(map->deepest[cell], (float)most);
    map->highest[cell] = fminf(map->highest[cell], (float)least);
}

/* Returns the cell of level 0 at position x along an axis; the nearest cell if x is outside the map. */
static int cell_index(const struct cml_depth_map *map, double x, int axis)
{
    const double cell = floor((x - map->corner[axis]) / map->cell[axis]);
    return (int)fmin(fmax(cell, 0), map->size - 1);
}

/* Completes a map: widens the bounds of level 0 by err (cm) for rounding, then computes every level from the
 * level below. The result is a min/max pyramid, like maximum mipmaps [Tevs, Ihrke and Seidel, I3D 2008]. */
static void finish(struct cml_depth_map *map, double err)
{
    const size_t base = cml_depth_map_level_cells(map, 0);
    for (size_t i = 0; i < base; i++) {
        map->deepest[i] += (float)err;
        map->highest[i] -= (float)err;
    }
    size_t from = 0, to = base;
    for (int l = 0; l + 1 < map->levels; l++) {
        const size_t below = cml_depth_map_level_cells(map, l), width = (size_t)(map->size >> l);
        for (size_t i = 0; i < below; i++) {
            const size_t x = i % width / 2, y = i / width / 2; /* cells of a row (radii) have y = 0 */
            const size_t cell = to + y * (width / 2) + x;
            map->deepest[cell] = fmaxf(map->deepest[cell], map->deepest[from + i]);
            map->highest[cell] = fminf(map->highest[cell], map->highest[from + i]);
        }
        from = to;
        to += cml_depth_map_level_cells(map, l + 1);
    }
}

/* Allocates a square map over x, y .. x + width, y + width. One more cell on each side stands for everything
 * outside. Each further level doubles the cells along each axis; there is about one cell per two
 * triangles. */
static cml_status allocate_square(double triangles, double x, double y, double width,
                                  struct cml_depth_map *map, struct cml_error *err)
{
    int levels = LEAST_LEVELS;
    while (levels < MOST_LEVELS && pow(4, levels - 1) < 0.5 * triangles) levels++;
    CML_TRY(allocate(levels, CML_BOUNDS_SQUARE, map, err));
    map->cell[0] = map->cell[1] = width / (map->size - 2);
    map->corner[0] = x - map->cell[0];
    map->corner[1] = y - map->cell[1];
    return CML_OK;
}

struct triangle_plane {
    double lower[3], upper[3]; /* corners of the triangle's box, cm */
    double a, b, c;            /* plane z = a x + b y + c; not set if `steep`: the triangle is upright or
                                  nearly so */
    bool steep;
    float slope; /* infinite if the triangle is upright or faces down */
};

/* Returns the plane of a triangle. Nearly upright triangles have none, because the plane's slopes would
 * magnify the rounding of the corners; their box bounds them. */
static struct triangle_plane plane_of(const double p[3], const double q[3], const double r[3])
{
    struct triangle_plane t = {.steep = false};
    for (int k = 0; k < 3; k++) {
        t.lower[k] = fmin(p[k], fmin(q[k], r[k]));
        t.upper[k] = fmax(p[k], fmax(q[k], r[k]));
    }
    double n[3];
    cml_vec3_area(p, q, r, n);
    t.steep = fabs(n[2]) < 1e-3 * (fabs(n[0]) + fabs(n[1]));
    t.slope = n[2] < 0 ? (float)(hypot(n[0], n[1]) / -n[2]) : INFINITY; /* z points down */
    if (t.steep) return t;
    t.a = -n[0] / n[2];
    t.b = -n[1] / n[2];
    t.c = p[2] - t.a * p[0] - t.b * p[1];
    return t;
}

/* Extends the depth range of a cell by the depths of a triangle's plane over the cell, limited to the
 * triangle's own depths. Notes the triangle's slope, too. */
static void cover_cell(struct cml_depth_map *map, const struct triangle_plane *t, int ix, int iy,
                       float *steepest)
{
    double least = t->lower[2], most = t->upper[2];
    if (!t->steep) {
        const double *cell = map->cell;
        const double x = map->corner[0] + (ix + 0.5) * cell[0], y = map->corner[1] + (iy + 0.5) * cell[1];
        const double z = t->a * x + t->b * y + t->c;
        const double rise = (0.5 + 2 * err_cell) * (cell[0] * fabs(t->a) + cell[1] * fabs(t->b));
        least = fmax(least, fmin(z - rise, most));
        most = fmin(most, fmax(z + rise, least));
    }
    widen_cell(map, ix, iy, least, most);
    const size_t width = (size_t)(map->size >> CML_HORIZON_LEVEL);
    float *slope = &steepest[(size_t)(iy >> CML_HORIZON_LEVEL) * width + (size_t)(ix >> CML_HORIZON_LEVEL)];
    *slope = fmaxf(*slope, t->slope);
}

/* Extends *lower..*upper to include the range of x of the edge from p to q where from <= y <= to. */
static void clip_edge(const double *p, const double *q, double from, double to, double *lower, double *upper)
{
    const double *low = p[1] < q[1] ? p : q, *high = low == p ? q : p, ends[2] = {from, to};
    if (low[1] > to || high[1] < from) return;
    for (int i = 0; i < 2; i++) {
        const double y = fmin(fmax(ends[i], low[1]), high[1]), rise = high[1] - low[1];
        const double x = low[0] + (rise > 0 ? (y - low[1]) / rise : i) * (high[0] - low[0]);
        *lower = fmin(*lower, x);
        *upper = fmax(*upper, x);
    }
}

/* Extends the depth ranges of all cells that a triangle reaches, row by row. An oblique, thin triangle
 * reaches a thousandth of the cells of its box. */
static void cover_triangle(struct cml_depth_map *map, const struct triangle_plane *t, const double *corner[3],
                           float *steepest)
{
    const double err_x = err_cell * map->cell[0], err_y = err_cell * map->cell[1];
    const int y0 = cell_index(map, t->lower[1] - err_y, 1), y1 = cell_index(map, t->upper[1] + err_y, 1);
    for (int iy = y0; iy <= y1; iy++) {
        const double from = map->corner[1] + iy * map->cell[1] - err_y, to = from + map->cell[1] + 2 * err_y;
        double lower = INFINITY, upper = -INFINITY;
        for (int k = 0; k < 3; k++) clip_edge(corner[k], corner[(k + 1) % 3], from, to, &lower, &upper);
        const int x1 = cell_index(map, upper + err_x, 0);
        for (int ix = cell_index(map, lower - err_x, 0); ix <= x1; ix++) cover_cell(map, t, ix, iy, steepest);
    }
}

/* Extends the depth range of each cell that is not entirely inside the rectangle to include the outer plane
 * at z. NULL for `lower`: extends all cells. */
static void cover_outside(struct cml_depth_map *map, double z, const double lower[2], const double upper[2])
{
    for (int iy = 0; iy < map->size; iy++)
        for (int ix = 0; ix < map->size; ix++) {
            const double x = map->corner[0] + ix * map->cell[0], y = map->corner[1] + iy * map->cell[1];
            const double err = err_cell * map->cell[0], end = map->cell[0] + err;
            const bool inside = lower && x - err >= lower[0] && y - err >= lower[1] && x + end <= upper[0] &&
                                y + end <= upper[1];
            if (!inside) widen_cell(map, ix, iy, z, z);
        }
}

/* True if the footprint is its own bounding rectangle, so that nothing of the outer plane lies inside that
 * rectangle. The area comes from the shoelace formula. */
static bool fills_its_box(const struct cml_mesh *mesh)
{
    double area = 0;
    for (size_t i = 0; i < mesh->num_border; i++) {
        const double *a = mesh->vertex[mesh->border[i]],
                     *b = mesh->vertex[mesh->border[(i + 1) % mesh->num_border]];
        area += 0.5 * (a[0] * b[1] - a[1] * b[0]);
    }
    const double box = (mesh->upper[0] - mesh->lower[0]) * (mesh->upper[1] - mesh->lower[1]);
    return fabs(fabs(area) - box) <= 1e-9 * box;
}

/* Bounds the depths of a mesh, and of the plane outside it, in the cells of the map. steepest: zeros on
 * entry; becomes the slope of the steepest facet above each cell of the horizons' level. */
static void cover_mesh(const struct cml_mesh *mesh, struct cml_depth_map *map, float *steepest)
{
    for (size_t i = 0; i < mesh->num_triangles; i++) {
        const uint32_t *v = mesh->triangle[i];
        const double *corner[3] = {mesh->vertex[v[0]], mesh->vertex[v[1]], mesh->vertex[v[2]]};
        const struct triangle_plane t = plane_of(corner[0], corner[1], corner[2]);
        cover_triangle(map, &t, corner, steepest);
    }
    cover_outside(map, mesh->z_border, fills_its_box(mesh) ? mesh->lower : NULL, mesh->upper);
}

/* Allocates the horizons on both sides, and slopes of 0, for the cells of the horizons' level. */
static cml_status allocate_horizons(struct cml_depth_map *map, float **steepest, struct cml_error *err)
{
    const size_t cells = cml_depth_map_level_cells(map, CML_HORIZON_LEVEL);
    map->horizon[0] = malloc(2 * cells * sizeof **map->horizon);
    *steepest = calloc(cells, sizeof **steepest);
    if (!map->horizon[0] || !*steepest)
        return cml_fail_memory(err, (double)(3 * cells * sizeof **steepest), "the bounds of a boundary");
    map->horizon[1] = map->horizon[0] + cells;
    map->horizon_cells = cells;
    return CML_OK;
}

/* Computes the map's horizons from its depths and the steepest facet above each cell. */
static cml_status find_horizons(struct cml_depth_map *map, const float *steepest, struct cml_error *err)
{
    const struct cml_depth_pyramid pyramid = {.levels = map->levels,
                                              .size = map->size,
                                              .cell = fmin(map->cell[0], map->cell[1]),
                                              .repeats = map->form == CML_BOUNDS_PERIOD,
                                              .deepest = map->deepest,
                                              .highest = map->highest};
    return cml_find_horizons(&pyramid, steepest, map->horizon[0], map->horizon[1], err);
}

cml_status cml_depth_map_of_mesh(const struct cml_mesh *mesh, struct cml_depth_map *map,
                                 struct cml_error *err)
{
    const double width = fmax(mesh->upper[0] - mesh->lower[0], mesh->upper[1] - mesh->lower[1]);
    CML_FREED float *steepest = NULL;
    CML_TRY(allocate_square((double)mesh->num_triangles, mesh->lower[0], mesh->lower[1], width, map, err));
    CML_TRY(allocate_horizons(map, &steepest, err));
    cover_mesh(mesh, map, steepest);
    finish(map, err_depth *
                    (width + fabs(mesh->lower[0]) + fabs(mesh->lower[1]) + mesh->upper[2] - mesh->lower[2]));
    return find_horizons(map, steepest, err);
}

/* ---- tiles ---- */

/* Returns how many periods of a tile along `axis` the map covers: so many that they are about as long as a
 * period along the other axis, but fewer if the map would cover too many cells of the tile. */
static int periods_along(const struct cml_heightmap *tile, int axis)
{
    const double most_cells = 4194304, ratio = cml_tile_period(tile, 1 - axis) / cml_tile_period(tile, axis);
    const double most = fmax(1, most_cells / ((double)tile->nx * (double)tile->ny));
    return (int)fmax(1, fmin(rint(ratio), most));
}

/* Allocates the map of a tile. It has as many levels as the map of a mesh with as many triangles, but it
 * covers only whole periods, without cells around them. */
static cml_status allocate_period(const struct cml_heightmap *tile, const int periods[2],
                                  struct cml_depth_map *map, struct cml_error *err)
{
    const double triangles = 2.0 * tile->nx * tile->ny * periods[0] * periods[1];
    CML_TRY(allocate_square(triangles, 0, 0, 1, map, err));
    map->form = CML_BOUNDS_PERIOD;
    map->corner[0] = tile->x0;
    map->corner[1] = tile->y0;
    for (int k = 0; k < 2; k++) map->cell[k] = periods[k] * cml_tile_period(tile, k) / map->size;
    return CML_OK;
}

/* Extends the depth ranges of the map's cells to include a triangle. Skips a triangle that lies beside the
 * map by more than rounding. */
static void cover_if_inside(struct cml_depth_map *map, const double *corner[3], float *steepest)
{
    const struct triangle_plane t = plane_of(corner[0], corner[1], corner[2]);
    for (int k = 0; k < 2; k++) {
        const double err = err_cell * map->cell[k], end = map->corner[k] + map->size * map->cell[k];
        if (t.upper[k] + err < map->corner[k] || t.lower[k] - err > end) return;
    }
    cover_triangle(map, &t, corner, steepest);
}

/* Extends the depth ranges of the map by all cells of the tile that lie over the map, and by one more cell on
 * each side. Only one row of cells at a time is made into triangles, to save memory. */
static cml_status cover_tile(const struct cml_heightmap *tile, const int periods[2],
                             struct cml_depth_map *map, float *steepest, struct cml_error *err)
{
    for (int j = -1; j <= periods[1] * tile->ny; j++) {
        const struct cml_tile_cells row = {{-1, j}, {periods[0] * tile->nx + 2, 1}};
        CML_AT_END(cml_mesh_clear) struct cml_mesh mesh = {0};
        CML_TRY(cml_tile_sheet(tile, &row, CML_NORMALS_FACET, &mesh, err));
        for (size_t i = 0; i < mesh.num_triangles; i++) {
            const uint32_t *v = mesh.triangle[i];
            const double *corner[3] = {mesh.vertex[v[0]], mesh.vertex[v[1]], mesh.vertex[v[2]]};
            cover_if_inside(map, corner, steepest);
        }
    }
    return CML_OK;
}

cml_status cml_depth_map_of_tile(const struct cml_heightmap *tile, struct cml_depth_map *map,
                                 struct cml_error *err)
{
    const int periods[2] = {periods_along(tile, 0), periods_along(tile, 1)};
    struct cml_relief relief;
    CML_FREED float *steepest = NULL;
    cml_heightmap_measure(tile, tile->h, &relief);
    CML_TRY(allocate_period(tile, periods, map, err));
    CML_TRY(allocate_horizons(map, &steepest, err));
    CML_TRY(cover_tile(tile, periods, map, steepest, err));
    const double width = map->size * fmax(map->cell[0], map->cell[1]);
    finish(map, err_depth * (width + relief.highest - relief.lowest));
    return find_horizons(map, steepest, err);
}

/* ---- rings ---- */

/* Returns the depth of the profile at radius `at`, which lies between rings i and i + 1, or behind the last
 * ring. */
static double profile_depth(const double *r, const double *z, int n, int i, double at)
{
    if (i + 1 >= n) return z[n - 1];
    return z[i] + (z[i + 1] - z[i]) * ((at - r[i]) / (r[i + 1] - r[i]));
}

/* Extends the depth range of a cell to include the profile between two radii: the profile's depths at both
 * radii and at the samples between them. */
static void cover_radii(struct cml_depth_map *map, const double *r, const double *z, int n, double from,
                        double to, int cell)
{
    int i = (int)cml_last_not_above(r, (size_t)n, from);
    const double first = profile_depth(r, z, n, i, from);
    widen_cell(map, cell, 0, first, first);
    for (; i + 1 < n && r[i + 1] < to; i++) widen_cell(map, cell, 0, z[i + 1], z[i + 1]);
    const double last = profile_depth(r, z, n, i, to);
    widen_cell(map, cell, 0, last, last);
}

/* The last cell extends to infinity. */
cml_status cml_depth_map_of_rings(const double *r, const double *z, int n, struct cml_depth_map *map,
                                  struct cml_error *err)
{
    const double last = r[n - 1];
    double least = z[0], most = z[0];
    int levels = LEAST_LEVELS;
    for (int i = 1; i < n; i++) {
        least = fmin(least, z[i]);
        most = fmax(most, z[i]);
    }
    /* Levels for about four cells per ring. */
    while (levels < MOST_RADIAL_LEVELS && 1 << (levels - 1) < 4 * n) levels++;
    CML_TRY(allocate(levels, CML_BOUNDS_RADII, map, err));
    map->cell[0] = map->cell[1] = last / (map->size - 1);
    for (int i = 0; i < map->size; i++) {
        const double from = (i - err_cell) * map->cell[0], to = (i + 1 + err_cell) * map->cell[0];
        cover_radii(map, r, z, n, fmax(from, 0), i + 1 < map->size ? to : INFINITY, i);
    }
    finish(map, err_depth * (last + most - least));
    return CML_OK;
}
