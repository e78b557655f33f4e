/* Cuts a ray over a repeated mesh into segments over one copy. SPDX-License-Identifier: MIT */
#include "surface/mesh/tile_path.h"

#include <math.h>

/* Number of cells by which a segment overlaps the next one. A segment ends one cell before the mesh does; the
 * next segment begins half a cell before that end. */
static const double overlap = 0.5;

/* Returns the number of cells in a row of the mesh: one period and both margins. */
static int width_of(const struct cml_mesh_period *period)
{
    return period->n[0] + 2 * period->margin[0];
}

/* Returns i modulo n, from 0 to n - 1, for negative i, too. */
static int wrap(int i, int n)
{
    const int rest = i % n;
    return rest < 0 ? rest + n : rest;
}

uint64_t cml_tile_primitives(const struct cml_mesh_period *period)
{
    return 2 * (uint64_t)period->n[0] * (uint64_t)period->n[1];
}

int cml_tile_primitive(const struct cml_mesh_period *period, int triangle)
{
    const int width = width_of(period), cell = triangle / 2, row = cell / width;
    if (triangle < 0 || row >= period->n[1] + 2 * period->margin[1]) return -1;
    const int i = wrap(cell % width - period->margin[0], period->n[0]),
              j = wrap(row - period->margin[1], period->n[1]);
    return 2 * (j * period->n[0] + i) + triangle % 2;
}

int cml_tile_triangle(const struct cml_mesh_period *period, int primitive)
{
    const int cell = primitive / 2, i = cell % period->n[0], j = cell / period->n[0];
    return 2 * ((j + period->margin[1]) * width_of(period) + i + period->margin[0]) + primitive % 2;
}

/* Returns by how many periods a place must be moved to lie over the period itself. Rounding may put a packet
 * on a facet beyond the seam between periods; the facet decides then. */
static double periods_to(const struct cml_mesh_period *period, int axis, double cells, int primitive)
{
    const int n = period->n[axis];
    if (primitive < 0) return floor(cells / n);
    const int cell = primitive / 2, at = axis == 0 ? cell % period->n[0] : cell / period->n[0];
    return rint((cells - at - 0.5) / n);
}

/* Sets the segment that begins at path->from. Along each axis a segment ends one cell before the mesh
 * does. */
static void set_segment(struct cml_tile_path *path, int primitive)
{
    const struct cml_mesh_period *period = path->period;
    path->segments++;
    path->exclude = primitive < 0 ? primitive : cml_tile_triangle(period, primitive);
    path->to = path->end;
    path->leaving = -1;
    for (int k = 0; k < 3; k++) path->origin[k] = path->p[k] + path->from * path->u[k];
    for (int k = 0; k < 2; k++) {
        const double cell = period->cell[k], n = period->n[k], reach = period->margin[k] - 1;
        const double cells = (path->origin[k] - period->corner[k]) / cell;
        const double periods = periods_to(period, k, cells, primitive), in_period = cells - periods * n;
        path->origin[k] -= periods * (n * cell);
        const double way = path->u[k] > 0 ? n + reach - in_period : reach + in_period;
        const double leave = path->from + way * cell / fabs(path->u[k]);
        if (!(leave < path->to)) continue;
        path->to = leave;
        path->leaving = k;
    }
}

/* Shortens the path to the part between two depths, for a path that begins outside of them. Returns false if
 * nothing is left. */
static bool clip_to_depths(struct cml_tile_path *path, double low, double high)
{
    const double z = path->p[2], uz = path->u[2];
    if (uz == 0) return z >= low && z <= high;
    const double a = (low - z) / uz, b = (high - z) / uz, first = fmin(a, b), last = fmax(a, b);
    if (first > 0) path->from = first;
    path->end = fmin(path->end, last);
    return path->from < path->end;
}

/* Most paths are short and end over the copy where they begin, so only a path that leaves its first copy is
 * clipped to the mesh's depths. */
bool cml_tile_begin(const struct cml_mesh_period *period, const double p[3], const double u[3], double t_max,
                    int exclude, double low, double high, struct cml_tile_path *path)
{
    *path = (struct cml_tile_path){.period = period, .p = p, .u = u, .end = t_max};
    set_segment(path, exclude);
    if (path->leaving < 0) return true;
    if (!clip_to_depths(path, low, high)) return false;
    path->segments = 0;
    set_segment(path, path->from > 0 ? -1 : exclude);
    return true;
}

bool cml_tile_next(struct cml_tile_path *path)
{
    if (path->leaving < 0 || path->segments >= CML_TILE_MOST_SEGMENTS) return false;
    const double back = overlap * path->period->cell[path->leaving] / fabs(path->u[path->leaving]);
    path->from = path->to - back;
    set_segment(path, -1);
    return true;
}

bool cml_tile_is_too_long(const struct cml_tile_path *path)
{
    return path->leaving >= 0 && path->segments >= CML_TILE_MOST_SEGMENTS;
}
