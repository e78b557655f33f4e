/* Which steps cannot meet a curved surface: a pyramid of depth bounds, and around a mesh that overhangs cells
 * with safe distances.
 * Below a mesh, over the x-y plane: level 0 divides a square into size x size cells, each with the least and
 * the greatest depth that the surface has above it; every further level joins 2 x 2 cells. The cells at the
 * rim also stand for everything outside. A step looks at the at most four cells that cover its box on the
 * level where four are enough. Below rings, over the radius: size cells, the last one for everything outside;
 * every further level joins two, and a step looks at the at most two cells that cover its radii. Of a mesh
 * that is repeated over the whole plane, level 0 divides one period, or as many as make about a square; cells
 * are counted on through all periods, and only their numbers are brought back into the one. Bounds are
 * widened by rounding's share when they are built (src/surface/clearance_map.c), so a step found clear cannot
 * cross. SPDX-License-Identifier: MIT */
#ifndef CML_CLEARANCE_H
#define CML_CLEARANCE_H

#include "mathf.h"
#include "optics.h"
#include "types.h"

/* x brought into the range from 0 to most; NaN gives 0. */
CML_FN real cml_clamp(real x, real most)
{
    const real least = x > 0 ? x : (real)0;
    return least < most ? least : most;
}

/* Cell index along one axis, clamped to the rim; NaN gives 0. */
CML_FN int cml_clearance_index(const CML_GLOBAL struct cml_clearance *map, real x, real corner)
{
    return (int)cml_clamp((x - corner) * map->per_cell, (real)(map->size - 1));
}

/* Number of bits of n < 2^24: the level whose cells are longer than n cells of level 0. In float from its
 * exponent, which every vector unit can take. */
CML_FN int cml_clearance_level(int n)
{
#ifdef CML_DOUBLE
    return n > 0 ? 32 - CML_CLZ(n) : 0;
#else
    return n > 0 ? (int)(cml_bits_of((float)n) >> 23) - 126 : 0;
#endif
}

/* The depth, times side, that a packet must keep to on its way from p to p + d, of a mesh's pyramid. */
CML_FN real cml_clearance_of_box(const CML_GLOBAL struct cml_clearance *map, const CML_GLOBAL real *bounds,
                                 struct cml_vec p, struct cml_vec d, real side)
{
    const real far_x = p.x + d.x, far_y = p.y + d.y;
    const int x0 = cml_clearance_index(map, far_x < p.x ? far_x : p.x, map->corner_x);
    const int x1 = cml_clearance_index(map, far_x > p.x ? far_x : p.x, map->corner_x);
    const int y0 = cml_clearance_index(map, far_y < p.y ? far_y : p.y, map->corner_y);
    const int y1 = cml_clearance_index(map, far_y > p.y ? far_y : p.y, map->corner_y);
    const int level = cml_clearance_level((x1 - x0) | (y1 - y0)); /* as many bits as the larger one */
    const int size = map->size >> level, offset = map->first + map->level_offset[level];
    const int row0 = offset + (y0 >> level) * size, row1 = offset + (y1 >> level) * size;
    const real a = side * bounds[row0 + (x0 >> level)], b = side * bounds[row0 + (x1 >> level)];
    const real c = side * bounds[row1 + (x0 >> level)], e = side * bounds[row1 + (x1 >> level)];
    const real ab = a > b ? a : b, ce = c > e ? c : e;
    return ab > ce ? ab : ce;
}

/* A range of cells along an axis of a period, counted on through all periods: the first, and how many lie
 * behind it, at most as many as a period has. */
struct cml_cell_range {
    int first, more;
};

/* The cells from x to x + d. Positions count in cells here, and the further they are from the corner the
 * larger is their rounding: 16 times that, at least. Beyond 2^30 cells that is more than a period. NaN gives
 * any range. */
CML_FN struct cml_cell_range cml_cells_of_period(real x, real d, real corner, real per_cell, int size)
{
    const real from = (x - corner) * per_cell, to = (x + d - corner) * per_cell, most = 1073741824;
    const real low = from < to ? from : to, high = from < to ? to : from;
    const real err = (real)9.5367431640625e-7 * (CML_FABS(from) + CML_FABS(to) + CML_FABS(corner * per_cell));
    const real first = CML_FLOOR(low - err), more = CML_FLOOR(high + err) - first, whole = (real)size;
    const struct cml_cell_range range = {(int)(first > -most ? (first < most ? first : most) : -most),
                                         (int)(more < whole ? more : whole)};
    return range;
}

/* cml_clearance_of_box of a period. On the level whose cells are longer than the range, cells that follow one
 * another cover it, the last and the first of a period too. */
CML_FN real cml_clearance_of_period(const CML_GLOBAL struct cml_clearance *map, const CML_GLOBAL real *bounds,
                                    struct cml_vec p, struct cml_vec d, real side)
{
    const int size = map->size;
    const struct cml_cell_range x = cml_cells_of_period(p.x, d.x, map->corner_x, map->per_cell, size),
                                y = cml_cells_of_period(p.y, d.y, map->corner_y, map->per_cell_y, size);
    const int wanted = cml_clearance_level(x.more | y.more), last = cml_clearance_level(size) - 1;
    const int level = wanted < last ? wanted : last, cells = size >> level, mask = cells - 1;
    const int offset = map->first + map->level_offset[level];
    const int x0 = (x.first >> level) & mask, x1 = ((x.first + x.more) >> level) & mask;
    const int row0 = offset + ((y.first >> level) & mask) * cells,
              row1 = offset + (((y.first + y.more) >> level) & mask) * cells;
    const real a = side * bounds[row0 + x0], b = side * bounds[row0 + x1];
    const real c = side * bounds[row1 + x0], e = side * bounds[row1 + x1];
    const real ab = a > b ? a : b, ce = c > e ? c : e;
    return ab > ce ? ab : ce;
}

/* cml_cell_horizon of a period: the highest of the cells in which rounding may have put the point; infinite
 * where they are too many. */
CML_FN real cml_horizon_in_period(const CML_GLOBAL struct cml_clearance *map, const CML_GLOBAL real *horizon,
                                  struct cml_vec p)
{
    const struct cml_cell_range x = cml_cells_of_period(p.x, 0, map->corner_x, map->per_cell, map->size),
                                y = cml_cells_of_period(p.y, 0, map->corner_y, map->per_cell_y, map->size);
    const int level = map->horizon_level, cells = map->size >> level, mask = cells - 1;
    const int x0 = (x.first >> level) & mask, x1 = ((x.first + x.more) >> level) & mask;
    const int row0 = map->first_horizon + ((y.first >> level) & mask) * cells,
              row1 = map->first_horizon + (((y.first + y.more) >> level) & mask) * cells;
    const real a = horizon[row0 + x0], b = horizon[row0 + x1], c = horizon[row1 + x0], e = horizon[row1 + x1];
    const real ab = a > b ? a : b, ce = c > e ? c : e, most = ab > ce ? ab : ce;
    return (x.more | y.more) > 1 ? CML_INFINITY : most;
}

/* All horizons are raised by so much, as slopes: more than rounding turns a direction, which float does by
 * 1e-7. */
#define CML_HORIZON_RAISED 0.001

/* The horizon of the cell of a mesh's pyramid that holds the point: the slope from which on packets there, on
 * their side of the mesh, that go away from it meet it never again (src/surface/cell_horizon.h). */
CML_FN real cml_cell_horizon(const CML_GLOBAL struct cml_clearance *map, const CML_GLOBAL real *horizon,
                             struct cml_vec p, const int form)
{
    if (form == CML_CLEARANCE_PERIOD) return cml_horizon_in_period(map, horizon, p);
    const int x = cml_clearance_index(map, p.x, map->corner_x) >> map->horizon_level;
    const int y = cml_clearance_index(map, p.y, map->corner_y) >> map->horizon_level;
    return horizon[map->first_horizon + y * (map->size >> map->horizon_level) + x];
}

/* cml_clearance_of_box of the pyramid of rings. The way comes closest to the axis at an end or, where it
 * turns outwards between them, abreast of it. */
CML_FN real cml_clearance_of_radii(const CML_GLOBAL struct cml_clearance *map, const CML_GLOBAL real *bounds,
                                   struct cml_vec p, struct cml_vec d, real side)
{
    const real x = p.x + d.x, y = p.y + d.y;
    const real from = CML_SQRT(p.x * p.x + p.y * p.y), to = CML_SQRT(x * x + y * y);
    const real err_radius = 4 * CML_EPSILON * (from + to), most = from < to ? to : from;
    real least = from < to ? from : to;
    if ((p.x * d.x + p.y * d.y < 0) & (x * d.x + y * d.y > 0))
        least = CML_FABS(p.x * d.y - p.y * d.x) / CML_SQRT(d.x * d.x + d.y * d.y);
    const int r0 = cml_clearance_index(map, least - err_radius, 0),
              r1 = cml_clearance_index(map, most + err_radius, 0);
    const int level = cml_clearance_level(r1 - r0);
    const int offset = map->first + map->level_offset[level];
    const real a = side * bounds[offset + (r0 >> level)], b = side * bounds[offset + (r1 >> level)];
    return a > b ? a : b;
}

/* The part of a path on which a packet can meet a surface, if any: distances from its start. */
struct cml_interval {
    int meets;
    real from, to;
};

/* What is left of an interval without what keeps clear of the surface, for a packet on the given side (+1
 * below, -1 above) that begins it at p, in the boundary's frame, x and y from the scene's axis. Below rings
 * its ends are cut as well, but for a 1024th of the distance, which is more than rounding; a mesh has a tree
 * for that. Where an interval is not finite nothing is known to be free. */
CML_FN struct cml_interval cml_clip_interval(const CML_GLOBAL struct cml_clearance *map,
                                             const CML_GLOBAL real *bounds, struct cml_vec p,
                                             struct cml_vec u, real side, struct cml_interval s,
                                             const int form)
{
    const int rings = form == CML_CLEARANCE_RADII;
    const real length = s.to - s.from;
    const struct cml_vec d = {length * u.x, length * u.y, length * u.z};
    const real keep = rings                          ? cml_clearance_of_radii(map, bounds, p, d, side)
                      : form == CML_CLEARANCE_PERIOD ? cml_clearance_of_period(map, bounds, p, d, side)
                                                     : cml_clearance_of_box(map, bounds, p, d, side);
    const real here = side * p.z - keep, end = side * (p.z + d.z) - keep;
    const int finite = d.x * d.x + d.y * d.y + d.z * d.z < CML_INFINITY;
    const int begins_free = finite & (here > 0), ends_free = finite & (end > 0);
    const real cut = CML_FMA(length, here / (here - end), s.from), late = (real)1.0009765625 * cut;
    const real from = begins_free ? cut : s.from, to = (ends_free & (late < s.to)) ? late : s.to;
    const struct cml_interval left = {s.meets & !(begins_free & ends_free), (real)0.9990234375 * from,
                                      rings ? to : s.to};
    return left;
}

#ifndef __OPENCL_VERSION__
/* Whether a path of length s from p is safe: the surface is further from all of it than rounding can put
 * a packet. p in the boundary's frame, x and y from the beam's axis. The cell that the middle of the path
 * is in decides, or the closest one: its ball, which the surface does not enter, holds the whole path
 * where it holds the farther of both ends (kernels/README.md). A path that is not finite is not safe. */
CML_FN int cml_path_is_safe(const struct cml_safe_cells *cells, struct cml_vec p, struct cml_vec u, real s)
{
    const real per_cell = cells->per_cell, half = (real)0.5 * s * per_cell;
    const struct cml_vec start = {(p.x - cells->corner.x) * per_cell, (p.y - cells->corner.y) * per_cell,
                                  (p.z - cells->corner.z) * per_cell};
    const struct cml_vec middle = cml_along(start, half, u);
    const int x = (int)cml_clamp(middle.x, (real)(cells->nx - 1)),
              y = (int)cml_clamp(middle.y, (real)(cells->ny - 1)),
              z = (int)cml_clamp(middle.z, (real)(cells->nz - 1));
    const struct cml_vec off = {middle.x - ((real)x + (real)0.5), middle.y - ((real)y + (real)0.5),
                                middle.z - ((real)z + (real)0.5)};
    const real along = CML_FABS(cml_dot(off, u)), square = cml_dot(off, off);
    const real far = CML_FMA(half, CML_FMA((real)2, along, half), square);
    const real ball = (real)cells->safe[(z * cells->ny + y) * cells->nx + x] - cells->margin;
    return (ball > 0) & (far < ball * ball);
}
#endif

#endif
