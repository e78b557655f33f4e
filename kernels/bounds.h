/* The part of a packet's path on which it can meet a surface of its medium. cml_find_intervals at the end of
 * this file answers this question before any surface is searched. Before it stand the means to answer: depth
 * bounds and horizons of boundaries, safe distances around meshes that overhang, and regions around bodies.
 * Each is proven to be free of surfaces, with a margin above rounding (samples/manual/physics/free-paths.md).
 * src/surface/bounds makes them.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "mathf.h"
#include "optics.h"
#include "types.h"

/* Returns x brought into the range from 0 to most; 0 if x is NaN. */
CML_FN real cml_clamp(real x, real most)
{
    const real least = x > 0 ? x : (real)0;
    return least < most ? least : most;
}

/* Domains of depth bounds. A mesh: level 0 divides a square of the x-y plane into size x size cells, and
 * cells at the rim also stand for everything outside. Rings: level 0 divides the radius, and the last cell
 * stands for everything outside. A repeated mesh: level 0 divides one period, or as many periods as make
 * about a square. Cells of a repeated mesh are counted on through all periods, and their numbers are brought
 * back into one period only when a bound is read. */

/* Returns the index of a cell along one axis, clamped to the rim; 0 if x is NaN. */
CML_FN int cml_depth_cell(const CML_GLOBAL struct cml_depth_bounds *map, real x, real corner)
{
    return (int)cml_clamp((x - corner) * map->per_cell, (real)(map->size - 1));
}

/* Returns the number of bits of n < 2^24, which is the level whose cells are longer than n cells of level 0.
 * Single precision reads it from the exponent of n, because every vector unit can do that. */
CML_FN int cml_depth_level(int n)
{
#ifdef CML_DOUBLE
    return n > 0 ? 32 - CML_CLZ(n) : 0;
#else
    return n > 0 ? (int)(cml_bits_of((float)n) >> 23) - 126 : 0;
#endif
}

/* Returns the bound on depth for a path from p to p + d over a mesh: side times the least or greatest depth
 * of the cells under the path. A path whose side * z stays above this value meets nothing. map: the pyramid;
 * bounds: its depths; side: +1 below the mesh, -1 above. */
CML_FN real cml_depth_over_box(const CML_GLOBAL struct cml_depth_bounds *map, const CML_GLOBAL real *bounds,
                               struct cml_vec p, struct cml_vec d, real side)
{
    const real far_x = p.x + d.x, far_y = p.y + d.y;
    const int x0 = cml_depth_cell(map, far_x < p.x ? far_x : p.x, map->corner_x);
    const int x1 = cml_depth_cell(map, far_x > p.x ? far_x : p.x, map->corner_x);
    const int y0 = cml_depth_cell(map, far_y < p.y ? far_y : p.y, map->corner_y);
    const int y1 = cml_depth_cell(map, far_y > p.y ? far_y : p.y, map->corner_y);
    /* Has as many bits as the larger number of cells. */
    const int level = cml_depth_level((x1 - x0) | (y1 - y0));
    const int size = map->size >> level, offset = map->first + map->level_offset[level];
    const int row0 = offset + (y0 >> level) * size, row1 = offset + (y1 >> level) * size;
    const real a = side * bounds[row0 + (x0 >> level)], b = side * bounds[row0 + (x1 >> level)];
    const real c = side * bounds[row1 + (x0 >> level)], e = side * bounds[row1 + (x1 >> level)];
    const real ab = a > b ? a : b, ce = c > e ? c : e;
    return ab > ce ? ab : ce;
}

/* A range of cells along an axis of a period, counted on through all periods. more: the number of cells
 * behind the first, at most as many as a period has. */
struct cml_cell_range {
    int first, more;
};

/* Returns the range of cells from x to x + d along one axis of a period. Rounding of a position grows with
 * its distance from the corner, so the range is widened by at least 16 times that rounding. A position beyond
 * 2^30 cells is widened by more than a period. NaN gives any range. */
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

/* Returns the bound of cml_depth_over_box for a repeated mesh. It takes the level of the pyramid whose cells
 * are longer than the path's range of cells. There two neighbouring cells along each axis cover the range;
 * the last and the first cell of a period are neighbours, too. */
CML_FN real cml_depth_over_period(const CML_GLOBAL struct cml_depth_bounds *map,
                                  const CML_GLOBAL real *bounds, struct cml_vec p, struct cml_vec d,
                                  real side)
{
    const int size = map->size;
    const struct cml_cell_range x = cml_cells_of_period(p.x, d.x, map->corner_x, map->per_cell, size),
                                y = cml_cells_of_period(p.y, d.y, map->corner_y, map->per_cell_y, size);
    const int wanted = cml_depth_level(x.more | y.more), last = cml_depth_level(size) - 1;
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

/* Returns the horizon at a point of a repeated mesh: the slope above which a path that leads away from the
 * mesh meets it no more. It is the highest among the cells in which rounding may have put the point, or
 * infinite if rounding leaves more than two cells along an axis. A cell of horizons holds 2^horizon_level
 * cells of the map along each axis. */
CML_FN real cml_horizon_in_period(const CML_GLOBAL struct cml_depth_bounds *map,
                                  const CML_GLOBAL real *horizon, struct cml_vec p)
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

/* Slope by which all horizons are raised. Rounding in single precision turns a direction by only 1e-7. */
#define CML_HORIZON_RAISED 0.001

/* Returns the horizon of the cell below or above a point of a mesh: a slope. A packet in this cell, on its
 * side of the mesh, that leads away from the mesh at least as steeply never meets the mesh again
 * (src/surface/bounds/cell_horizon.h). */
CML_FN real cml_cell_horizon(const CML_GLOBAL struct cml_depth_bounds *map, const CML_GLOBAL real *horizon,
                             struct cml_vec p, const int form)
{
    if (form == CML_BOUNDS_PERIOD) return cml_horizon_in_period(map, horizon, p);
    const int x = cml_depth_cell(map, p.x, map->corner_x) >> map->horizon_level;
    const int y = cml_depth_cell(map, p.y, map->corner_y) >> map->horizon_level;
    return horizon[map->first_horizon + y * (map->size >> map->horizon_level) + x];
}

/* Returns the bound of cml_depth_over_box for rings. A path comes closest to the axis at one of its ends, or,
 * if it turns outwards between them, where it passes the axis. */
CML_FN real cml_depth_over_radii(const CML_GLOBAL struct cml_depth_bounds *map, const CML_GLOBAL real *bounds,
                                 struct cml_vec p, struct cml_vec d, real side)
{
    const real x = p.x + d.x, y = p.y + d.y;
    const real from = CML_SQRT(p.x * p.x + p.y * p.y), to = CML_SQRT(x * x + y * y);
    const real err_radius = 4 * CML_EPSILON * (from + to), most = from < to ? to : from;
    real least = from < to ? from : to;
    if ((p.x * d.x + p.y * d.y < 0) & (x * d.x + y * d.y > 0))
        least = CML_FABS(p.x * d.y - p.y * d.x) / CML_SQRT(d.x * d.x + d.y * d.y);
    const int r0 = cml_depth_cell(map, least - err_radius, 0), r1 = cml_depth_cell(map, most + err_radius, 0);
    const int level = cml_depth_level(r1 - r0);
    const int offset = map->first + map->level_offset[level];
    const real a = side * bounds[offset + (r0 >> level)], b = side * bounds[offset + (r1 >> level)];
    return a > b ? a : b;
}

/* The part of a path on which a packet can meet a surface, from and to in cm from the path's start. meets: 0
 * if there is no such part. */
struct cml_interval {
    int meets;
    real from, to;
};

/* Returns the interval `s` without the parts that keep clear of the surface by its depth bounds. p: the
 * packet at the start of the interval, in the boundary's frame, x and y from the scene's axis. side: +1 the
 * packet is below, -1 above.
 * The beginning is cut for all surfaces, the end only for rings, because a mesh has a tree to search. Cuts
 * leave a margin of 1/1024 of the distance, more than rounding. An interval that is not finite is not cut. */
CML_FN struct cml_interval cml_clip_interval(const CML_GLOBAL struct cml_depth_bounds *map,
                                             const CML_GLOBAL real *bounds, struct cml_vec p,
                                             struct cml_vec u, real side, struct cml_interval s,
                                             const int form)
{
    const int rings = form == CML_BOUNDS_RADII;
    const real length = s.to - s.from;
    const struct cml_vec d = {length * u.x, length * u.y, length * u.z};
    const real keep = rings                       ? cml_depth_over_radii(map, bounds, p, d, side)
                      : form == CML_BOUNDS_PERIOD ? cml_depth_over_period(map, bounds, p, d, side)
                                                  : cml_depth_over_box(map, bounds, p, d, side);
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
/* True if a path of length s from p is safe: the surface is further from all of it than rounding can put a
 * packet. p: in the boundary's frame, x and y from the scene's origin.
 * The cell that holds the path's middle decides, or the cell closest to it. No surface enters the ball of
 * this cell. The ball is convex, so it holds the whole path if it holds the farther of both ends. A path that
 * is not finite is not safe. */
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

/* True if a boundary is a plane; always true in kernels compiled for planes only. */
CML_FN int cml_is_plane(const struct cml_world *world, int boundary)
{
    return CML_ALL_PLANES || world->surfaces[boundary].kind == CML_SURFACE_PLANE;
}

/* Returns p with x and y counted from the scene's axis instead of the origin. */
CML_FN struct cml_vec cml_from_scene_axis(const struct cml_world *world, struct cml_vec p)
{
    const struct cml_vec moved = {p.x + world->setup.x0, p.y + world->setup.y0, p.z};
    return moved;
}

/* A region near bodies that no surface of a body passes: the part of a ball above the height `least` over the
 * middle, along `normal`. normal is 0 if the whole ball is free. The region is convex, so it holds a path
 * that begins and ends in it. Places are in the frame of the layer, lengths in cm. square: square of the
 * radius; 0: nothing is known. */
struct cml_body_region {
    struct cml_vec middle, normal;
    real square, least;
};

/* A place q on a path along u, and the cell of a body grid that is closest to q. All lengths are in cells. */
struct cml_body_view {
    const CML_GLOBAL struct cml_body_cell *cell;
    struct cml_vec q, off;      /* place from the corner of the grid; place from the middle of the cell */
    struct cml_vec beyond;      /* vector from the grid to the place; 0 inside the grid */
    real gap, distance, square; /* squares of the lengths of `beyond` and `off`, and of the ball's radius */
    /* Height of the place above the cell's middle along the planes' normal, and its rate along u. */
    real height, rate;
    int in_ball, above, below; /* flags: the place is inside the ball; above both planes; below both planes */
};

/* Returns the view from the place q on a path along u: the closest cell of the grid, and distances to its
 * ball and planes. */
CML_FN struct cml_body_view cml_view_body(const struct cml_world *world,
                                          const CML_GLOBAL struct cml_body_grid *grid, struct cml_vec q,
                                          struct cml_vec u)
{
    const real nx = (real)grid->nx, ny = (real)grid->ny, nz = (real)grid->nz;
    const int cx = (int)cml_clamp(q.x, nx - 1), cy = (int)cml_clamp(q.y, ny - 1),
              cz = (int)cml_clamp(q.z, nz - 1);
    const struct cml_vec off = {q.x - (real)cx - (real)0.5, q.y - (real)cy - (real)0.5,
                                q.z - (real)cz - (real)0.5};
    const struct cml_vec beyond = {q.x - cml_clamp(q.x, nx), q.y - cml_clamp(q.y, ny),
                                   q.z - cml_clamp(q.z, nz)};
    struct cml_body_view view;
    view.cell = &world->body_cells[grid->first + (cz * grid->ny + cy) * grid->nx + cx];
    view.q = q;
    view.off = off;
    view.beyond = beyond;
    view.gap = cml_dot(beyond, beyond);
    view.distance = cml_dot(off, off);
    view.square = view.cell->radius * view.cell->radius;
    view.height = cml_dot(view.cell->normal, off);
    view.rate = cml_dot(view.cell->normal, u);
    view.in_ball = view.distance < view.square;
    view.above = view.height > view.cell->upper;
    view.below = view.height < view.cell->lower;
    return view;
}

/* True if a path of this length (in cells) stays in the ball, and on its side of the planes. */
CML_FN int cml_stays_in_ball(const struct cml_body_view *view, struct cml_vec u, real path)
{
    const struct cml_vec end = cml_along(view->off, path, u);
    const real height = CML_FMA(path, view->rate, view->height);
    const int beside = view->above ? height > view->cell->upper : view->below & (height < view->cell->lower);
    const real distance = cml_dot(end, end);
    return view->in_ball & beside & (distance < view->square);
}

/* Fills *region with the part of the viewed ball on the packet's side of the planes. */
CML_FN void cml_region_of_ball(const CML_GLOBAL struct cml_body_grid *grid, const struct cml_body_view *view,
                               struct cml_body_region *region)
{
    const real size = grid->cell, sign = view->above ? (real)1 : (real)-1;
    const struct cml_vec normal = view->cell->normal;
    region->middle = cml_along(grid->corner, size, cml_along(view->q, -1, view->off));
    region->normal.x = sign * normal.x;
    region->normal.y = sign * normal.y;
    region->normal.z = sign * normal.z;
    region->square = view->square * size * size;
    region->least = sign * (view->above ? view->cell->upper : view->cell->lower) * size;
}

/* The share of a free way that a packet is moved along it. The rest is more than rounding in single
 * precision. */
#define CML_BODY_WAY 0.9999

/* True if a path of this length (in cells), which begins outside of the grid, ends beyond the face of the
 * grid that it begins furthest beyond. Then *region is the half-space beyond this face. */
CML_FN int cml_stays_beyond_grid(const CML_GLOBAL struct cml_body_grid *grid,
                                 const struct cml_body_view *view, struct cml_vec u, real path,
                                 struct cml_body_region *region)
{
    const struct cml_vec beyond = view->beyond;
    const real x = CML_FABS(beyond.x), y = CML_FABS(beyond.y), z = CML_FABS(beyond.z);
    const int along_x = (x >= y) & (x >= z), along_y = !along_x & (y >= z), along_z = !along_x & !along_y;
    const real gap = along_x ? beyond.x : (along_y ? beyond.y : beyond.z),
               rate = along_x ? u.x : (along_y ? u.y : u.z), sign = gap < 0 ? (real)-1 : (real)1,
               least = (real)-CML_BODY_WAY * CML_FABS(gap);
    const struct cml_vec normal = {along_x ? sign : (real)0, along_y ? sign : (real)0,
                                   along_z ? sign : (real)0};
    if (!((least < 0) & (sign * path * rate > least))) return 0;
    region->middle = cml_along(grid->corner, grid->cell, view->q);
    region->normal = normal;
    region->square = CML_INFINITY;
    region->least = least * grid->cell;
    return 1;
}

/* Returns the distance that a packet in the ball can fly before it may meet the surface there. path: the
 * length that it would fly; end: the distance at which it leaves the ball. All lengths are in cells. */
CML_FN real cml_way_in_ball(const struct cml_body_view *view, int medium, real path, real end)
{
    const CML_GLOBAL struct cml_body_cell *cell = view->cell;
    const real outwards = medium == cell->inside ? -view->rate : view->rate;
    if (path * (outwards - cell->steepest) > (real)CML_CELL_MARGIN) return end;
    if (!(view->above | view->below)) return 0;
    if (view->above ? view->rate >= 0 : view->rate <= 0) return end;
    const real way = ((view->above ? cell->upper : cell->lower) - view->height) / view->rate;
    return way < end ? way : end;
}

/* Answers to the question whether a path may meet a body. FROM_AFAR: it may, and it begins further from all
 * surfaces than rounding could put a packet. */
enum cml_bodies_ahead { CML_NO_BODIES, CML_BODIES, CML_BODIES_FROM_AFAR };

/* Returns CML_BODIES_FROM_AFAR for a place outside the grid, or beyond the planes and inside the ball by a
 * twentieth of its radius; else CML_BODIES. */
CML_FN int cml_bodies_from(const struct cml_body_view *view)
{
    const int off_planes = (view->distance < (real)0.9 * view->square) & (view->above | view->below);
    return view->gap > 0 || off_planes ? CML_BODIES_FROM_AFAR : CML_BODIES;
}

/* Limits of a search from ball to ball: the number of balls, and the distance in cells. Rounding grows with
 * the distance, and cells have only CML_CELL_MARGIN to spare for it. */
#define CML_BODY_BALLS 6
#define CML_BODY_FARTHEST 10000

/* Returns enum cml_bodies_ahead: can a packet at p meet the surface of a body within t_max along u? The path
 * is followed from ball to ball [sphere tracing, J. C. Hart, The Visual Computer 12 (1996) 527]:
 *
 *            ball of p's cell     next ball
 *                . - .         . - ~ - .
 *              .       .     .           .
 *      u ---> p---------->o-------------------->     each ball is free of surfaces, or its surface
 *              .       .     .           .           lies between two planes
 *                ' - '         ' - _ - '
 *
 * *region: if the path meets none, a free region in which it ends, if one is known. Outside of the grid, the
 * way to the grid is free. A path that is not a number may meet a body. */
CML_FN int cml_may_hit_body(const struct cml_world *world, int medium, struct cml_vec p, struct cml_vec u,
                            real t_max, struct cml_body_region *region)
{
    const int number = world->media[medium].body_grid;
    const struct cml_body_region unknown = {p, {0, 0, 0}, number < 0 ? CML_INFINITY : (real)0, -1};
    *region = unknown;
    if (number < 0) return CML_NO_BODIES;
    const CML_GLOBAL struct cml_body_grid *grid = &world->body_grids[number];
    const struct cml_vec start = {(p.x - grid->corner.x) * grid->per_cell,
                                  (p.y - grid->corner.y) * grid->per_cell,
                                  (p.z - grid->corner.z) * grid->per_cell};
    const real path = t_max * grid->per_cell;
    int ahead = CML_BODIES;
    real done = 0;
    for (int i = 0; i < CML_BODY_BALLS && done < CML_BODY_FARTHEST; i++) {
        const struct cml_body_view view = cml_view_body(world, grid, cml_along(start, done, u), u);
        const real left = path - done;
        if (i == 0) ahead = cml_bodies_from(&view);
        if (cml_stays_in_ball(&view, u, left)) {
            cml_region_of_ball(grid, &view, region);
            return CML_NO_BODIES;
        }
        if (!view.in_ball && cml_stays_beyond_grid(grid, &view, u, left, region)) return CML_NO_BODIES;
        const real b = cml_dot(view.off, u), within = CML_FMA(b, b, view.square - view.distance);
        const real end = view.in_ball ? CML_SQRT(within) - b : CML_SQRT(view.gap);
        const real way = view.in_ball ? cml_way_in_ball(&view, medium, left, end) : end;
        if (left < way) return CML_NO_BODIES;
        if (way < end || !(way > 0)) return ahead;
        done += (real)CML_BODY_WAY * way;
    }
    return ahead;
}

/* Returns the horizon at p, a slope: a packet at p that leaves the surface to its own side at least as
 * steeply never meets the surface again. On a ring it is the ring's horizon, over a mesh that of the cell at
 * p, and for a plane 0. p: in the boundary's frame. */
CML_FN real cml_horizon(const struct cml_world *world, const CML_GLOBAL struct cml_surface *surface,
                        struct cml_vec p, real side, int on_primitive)
{
    if (CML_MAY_HAVE_MESHES && surface->kind == CML_SURFACE_MESH)
        return cml_cell_horizon(&surface->depths, side > 0 ? world->horizon_below : world->horizon_above,
                                cml_from_scene_axis(world, p), surface->depths.form);
    if (surface->kind == CML_SURFACE_PLANE) return 0;
    if (on_primitive < 0) return surface->steepest;
    return (side > 0 ? world->ring_horizon_below
                     : world->ring_horizon_above)[surface->first_ring + on_primitive];
}

/* True if a packet that heads along u moves away from the surface at least as steeply as the slope `horizon`
 * (cml_horizon), so that it never meets the surface again. */
CML_FN int cml_heads_away(real horizon, struct cml_vec u, real side)
{
    return (side * u.z > 0) & (u.z * u.z >= horizon * horizon * (u.x * u.x + u.y * u.y));
}

/* True if a path is known to be free of a boundary by the boundary's safe distances. p: in the boundary's
 * frame. */
CML_FN int cml_is_safe(const struct cml_world *world, const CML_GLOBAL struct cml_surface *surface,
                       struct cml_vec p, struct cml_vec u, real t_max)
{
#ifdef __OPENCL_VERSION__
    return 0;
#else
    const struct cml_safe_cells *cells = &world->safe_cells[surface - world->surfaces];
    return cells->nx > 0 && t_max < CML_INFINITY && cml_path_is_safe(cells, p, u, t_max);
#endif
}

/* Returns the interval of a path on which a packet can meet a curved surface within t_max. p: in the
 * boundary's frame. side: +1 the packet is below the surface, -1 above. on_primitive: primitive of the
 * surface that it stands on, -1 or CML_NEAR_FACETS. */
CML_FN struct cml_interval cml_curved_interval(const struct cml_world *world,
                                               const CML_GLOBAL struct cml_surface *surface, struct cml_vec p,
                                               struct cml_vec u, real side, int on_primitive, real t_max)
{
    const real horizon = cml_horizon(world, surface, p, side, on_primitive);
    const CML_GLOBAL real *bounds = side > 0 ? world->deepest : world->highest;
    /* Depth of the part that faces the packet. */
    const real nearest = side > 0 ? surface->highest : surface->lowest;
    const real inside = side * (nearest - p.z), away = side * u.z;
    const int passes = inside < away * t_max; /* the path passes this depth */
    struct cml_interval s = {0, 0, t_max};
    if (cml_is_safe(world, surface, p, u, t_max)) return s;
    if (away < 0 ? passes : (inside < 0) | cml_heads_away(horizon, u, side)) return s;
    const real there = inside / away;
    s.meets = 1;
    if (inside < 0) s.from = there;
    if ((away >= 0) & passes) s.to = there;
    const struct cml_vec start = cml_from_scene_axis(world, cml_along(p, s.from, u));
    const int form = CML_MAY_HAVE_MESHES ? surface->depths.form : CML_BOUNDS_RADII;
    return cml_clip_interval(&surface->depths, bounds, start, u, side, s, form);
}

/* Returns the interval of a path on which a packet can meet a surface of any kind within t_max. The
 * parameters are those of cml_curved_interval. */
CML_FN struct cml_interval cml_surface_interval(const struct cml_world *world,
                                                const CML_GLOBAL struct cml_surface *surface,
                                                struct cml_vec p, struct cml_vec u, real side,
                                                int on_primitive, real t_max)
{
    if (CML_ALL_PLANES || surface->kind == CML_SURFACE_PLANE) {
        const struct cml_interval s = {side * u.z < 0 && -p.z / u.z < t_max, 0, t_max};
        return s;
    }
    return cml_curved_interval(world, surface, p, u, side, on_primitive, t_max);
}

/* The parts of a path on which a packet can meet the boundaries above and below its medium. bodies: enum
 * cml_bodies_ahead, for bodies within `reach` (cm). */
struct cml_boundary_intervals {
    struct cml_interval above, below;
    int bodies;
    real reach;
};

/* True if a medium lies above or below all layers. */
CML_FN int cml_is_outer(const struct cml_world *world, int medium)
{
    return medium == 0 || medium == world->setup.num_layers + 1;
}

/* True if a medium is the inside of a body. */
CML_FN int cml_is_body(const struct cml_world *world, int medium)
{
    return CML_MAY_HAVE_BODIES && medium > world->setup.num_layers + 1;
}

/* Returns the primitive of a boundary that the packet stands on; -1: none, or CML_NEAR_FACETS. */
CML_FN int cml_on_primitive(CML_PACKET const struct cml_packet *packet, int boundary)
{
    return packet->on_boundary == boundary ? packet->on_primitive : -1;
}

/* Returns the parts of a path on which a packet can meet the boundaries of its layer. Bodies are left out. */
CML_FN struct cml_boundary_intervals
cml_layer_intervals(const struct cml_world *world, CML_PACKET const struct cml_packet *packet, real t_max)
{
    const int medium = packet->medium;
    const struct cml_interval none = {0, 0, t_max};
    struct cml_boundary_intervals intervals = {none, none, 0, t_max};
    struct cml_vec p = packet->p;
    if (cml_is_body(world, medium)) return intervals;
    if (medium > 0)
        intervals.above = cml_surface_interval(world, &world->surfaces[medium - 1], p, packet->u, 1,
                                               cml_on_primitive(packet, medium - 1), t_max);
    if (medium <= world->setup.num_layers) {
        p.z -= world->media[medium].span;
        intervals.below = cml_surface_interval(world, &world->surfaces[medium], p, packet->u, -1,
                                               cml_on_primitive(packet, medium), t_max);
    }
    return intervals;
}

/* Returns the parts of a path on which a packet can meet the boundaries of its layer, and a body. */
CML_FN struct cml_boundary_intervals
cml_find_intervals(const struct cml_world *world, CML_PACKET const struct cml_packet *packet, real t_max)
{
    struct cml_boundary_intervals intervals = cml_layer_intervals(world, packet, t_max);
    struct cml_body_region region;
    if (CML_MAY_HAVE_BODIES && world->setup.num_bodies)
        intervals.bodies = cml_may_hit_body(world, packet->medium, packet->p, packet->u, t_max, &region);
    return intervals;
}
