/* Where a packet meets the bodies of its medium: spheres, cylinders and closed meshes.
 * A body is a medium of its own inside a layer or inside another body. Its surface counts as a boundary whose
 * upper side is outside: normals point outwards, and a packet inside is "below" it.
 *
 * Spheres and cylinders are convex, and that, not a distance, keeps a packet from meeting again the place
 * where it stands: outside it never meets that body again before it meets something else; inside the root at
 * which it stands is divided out. A packet that rounding has put beyond a surface crosses it at once when it
 * heads on, and is back on its own side when it does not. Inside there is always a crossing ahead.
 * SPDX-License-Identifier: MIT */
#ifndef CML_BODY_H
#define CML_BODY_H

#include "clearance.h"
#include "optics.h"
#include "types.h"

/* A crossing with a sphere or a cylinder. */
struct cml_body_hit {
    real t; /* distance, cm */
    int primitive;
};

/* Roots t of |d + t v|^2 = r^2, v of any length but 0: first and last crossing of a circle, cylinder or
 * sphere about the origin. c = |d|^2 - r^2 as (|d| - r) (|d| + r), and the discriminant from the distance at
 * which the line passes the centre: neither cancels far from the centre or close to the surface [E. Haines,
 * J. Guenther, T. Akenine-Moeller, Precision Improvements for Ray/Sphere Intersection, Ray Tracing Gems,
 * chapter 7, 2019]. passes: the line does. Where it does not, both are its closest approach. */
struct cml_roots {
    int passes;
    real first, last;
};

CML_FN struct cml_roots cml_quadric_roots(struct cml_vec d, struct cml_vec v, real r)
{
    const real a = cml_dot(v, v), b = cml_dot(d, v), size = CML_SQRT(cml_dot(d, d));
    const real c = (size - r) * (size + r);
    const struct cml_vec foot = cml_along(d, -b / a, v);
    const real square = a * ((r * r) - cml_dot(foot, foot)), root = CML_SQRT(square > 0 ? square : (real)0);
    const real sum = b > 0 ? -(b + root) : root - b; /* no difference */
    struct cml_roots roots = {square > 0, -b / a, -b / a};
    if (square > 0) {
        roots.first = b > 0 ? sum / a : c / sum;
        roots.last = b > 0 ? c / sum : sum / a;
    }
    return roots;
}

/* A sphere from outside. d: the packet from its centre. */
CML_FN int cml_enter_sphere(struct cml_vec d, struct cml_vec u, real r, struct cml_body_hit *hit)
{
    if (!(cml_dot(d, u) < 0)) return 0;
    const struct cml_roots roots = cml_quadric_roots(d, u, r);
    hit->t = roots.first > 0 ? roots.first : (real)0;
    hit->primitive = 0;
    return roots.passes;
}

/* From inside. stands: on the sphere itself. */
CML_FN void cml_leave_sphere(struct cml_vec d, struct cml_vec u, real r, int stands, struct cml_body_hit *hit)
{
    const real t = stands ? -2 * cml_dot(d, u) : cml_quadric_roots(d, u, r).last;
    hit->t = t > 0 ? t : (real)0;
    hit->primitive = 0;
}

/* A line and a cylinder with flat ends, seen from the middle of its first end: where the line is within the
 * infinite cylinder, and where between the planes of both ends. Primitives: 0 the side, 1 the first end, 2
 * the other. */
struct cml_cylinder_line {
    int misses; /* one of both altogether */
    real side_in, side_out, end_in, end_out;
    int first_end, last_end; /* primitives */
};

CML_FN struct cml_cylinder_line cml_cylinder_line_of(const CML_GLOBAL struct cml_body *body, struct cml_vec d,
                                                     struct cml_vec u, int on_primitive)
{
    const real along = cml_dot(d, body->axis), rise = cml_dot(u, body->axis);
    const struct cml_vec across = cml_along(d, -along, body->axis), v = cml_along(u, -rise, body->axis);
    const real flat = cml_dot(v, v), far = body->length - along;
    struct cml_cylinder_line line = {
        0, -CML_INFINITY, CML_INFINITY, -CML_INFINITY, CML_INFINITY, rise > 0 ? 1 : 2, rise > 0 ? 2 : 1};
    if (flat > 0) {
        const struct cml_roots roots = cml_quadric_roots(across, v, body->radius);
        line.misses = !roots.passes;
        line.side_in = roots.first;
        line.side_out = on_primitive == 0 ? -2 * cml_dot(across, v) / flat : roots.last;
    } else {
        line.misses = cml_dot(across, across) >= body->radius * body->radius;
    }
    if (rise != 0) {
        const real a = -along / rise, b = far / rise;
        line.end_in = rise > 0 ? a : b;
        line.end_out = rise > 0 ? b : a;
    } else {
        line.misses |= !((along > 0) & (far > 0));
    }
    return line;
}

/* From outside. A packet that rounding has put inside crosses at once where it has come in rather than where
 * it goes out. */
CML_FN int cml_enter_cylinder(const CML_GLOBAL struct cml_body *body, struct cml_vec d, struct cml_vec u,
                              struct cml_body_hit *hit)
{
    const struct cml_cylinder_line line = cml_cylinder_line_of(body, d, u, -1);
    const int side = line.side_in > line.end_in;
    const real in = side ? line.side_in : line.end_in;
    const real out = line.side_out < line.end_out ? line.side_out : line.end_out;
    hit->t = in > 0 ? in : (real)0;
    hit->primitive = side ? 0 : line.first_end;
    return !line.misses & (in < out) & (in + out > 0);
}

CML_FN void cml_leave_cylinder(const CML_GLOBAL struct cml_body *body, struct cml_vec d, struct cml_vec u,
                               int on_primitive, struct cml_body_hit *hit)
{
    const struct cml_cylinder_line line = cml_cylinder_line_of(body, d, u, on_primitive);
    const int side = line.side_out < line.end_out;
    const real t = side ? line.side_out : line.end_out;
    hit->t = t > 0 ? t : (real)0;
    hit->primitive = side ? 0 : line.last_end;
}

/* Place and normal of a crossing, put onto the surface exactly but for rounding. p: where the packet is. */
CML_FN void cml_place_on_body(const CML_GLOBAL struct cml_body *body, int kind, struct cml_vec p,
                              struct cml_vec u, struct cml_body_hit at, struct cml_hit *hit)
{
    const struct cml_vec there = cml_along(p, at.t, u), d = cml_along(there, -1, body->centre);
    const real along = kind == CML_SURFACE_SPHERE ? (real)0 : cml_dot(d, body->axis);
    const struct cml_vec across = cml_along(d, -along, body->axis);
    const struct cml_vec outwards = kind == CML_SURFACE_SPHERE ? d : across;
    const real size = CML_SQRT(cml_dot(outwards, outwards)), per_size = size > 0 ? 1 / size : (real)0;
    const struct cml_vec radial = {per_size * outwards.x, per_size * outwards.y, per_size * outwards.z};
    hit->t = at.t;
    hit->primitive = at.primitive;
    if (at.primitive == 0) {
        hit->normal = radial;
        hit->point = cml_along(cml_along(body->centre, along, body->axis), body->radius, radial);
    } else {
        const real sign = at.primitive == 1 ? (real)-1 : (real)1;
        const struct cml_vec normal = {sign * body->axis.x, sign * body->axis.y, sign * body->axis.z};
        hit->normal = normal;
        hit->point = cml_along(there, (at.primitive == 1 ? (real)0 : body->length) - along, body->axis);
    }
    hit->facet = hit->normal;
}

/* Part of a ball that no surface of a body passes: what lies higher than `least` over its middle along
 * `normal`, which is 0 where the whole ball is free. In the frame of the layer, cm; square: of the radius, 0:
 * nothing is known. A path that begins and ends in it lies in it. */
struct cml_body_region {
    struct cml_vec middle, normal;
    real square, least;
};

CML_FN real cml_body_clamp(real x, real most)
{
    const real least = x > 0 ? x : (real)0;
    return least < most ? least : most;
}

/* A place q on a path along u, and the closest cell of a grid. All in cells: */
struct cml_body_view {
    const CML_GLOBAL struct cml_body_cell *cell;
    struct cml_vec q, off;      /* from the corner of the grid, and from the middle of the cell */
    struct cml_vec beyond;      /* from the grid itself; 0 inside */
    real gap, distance, square; /* squares: of `beyond`, of `off`, of the ball's radius */
    real height, rate;          /* over the planes' middle, and of u */
    int in_ball, above, below;  /* the ball, and both planes */
};

CML_FN struct cml_body_view cml_view_body(const struct cml_world *world,
                                          const CML_GLOBAL struct cml_body_grid *grid, struct cml_vec q,
                                          struct cml_vec u)
{
    const real nx = (real)grid->nx, ny = (real)grid->ny, nz = (real)grid->nz;
    const int cx = (int)cml_body_clamp(q.x, nx - 1), cy = (int)cml_body_clamp(q.y, ny - 1),
              cz = (int)cml_body_clamp(q.z, nz - 1);
    const struct cml_vec off = {q.x - (real)cx - (real)0.5, q.y - (real)cy - (real)0.5,
                                q.z - (real)cz - (real)0.5};
    const struct cml_vec beyond = {q.x - cml_body_clamp(q.x, nx), q.y - cml_body_clamp(q.y, ny),
                                   q.z - cml_body_clamp(q.z, nz)};
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

/* Whether a path of this length (cells) stays in the ball, and on its side of the planes. */
CML_FN int cml_stays_in_ball(const struct cml_body_view *view, struct cml_vec u, real path)
{
    const struct cml_vec end = cml_along(view->off, path, u);
    const real height = CML_FMA(path, view->rate, view->height);
    const int beside = view->above ? height > view->cell->upper : view->below & (height < view->cell->lower);
    const real distance = cml_dot(end, end);
    return view->in_ball & beside & (distance < view->square);
}

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

/* The share that is taken of a way that is free: the rest is more than single precision rounds it by. */
#define CML_BODY_WAY 0.9999

/* Whether a path of this length (cells) from outside of the grid ends beyond the same of its faces: that
 * which it begins furthest beyond. Then that half-space is the region. */
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

/* How far a packet in the ball can fly before it may meet the surface there. path: how far it would fly; end:
 * where it leaves the ball. In cells. */
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

/* Whether a path may meet a body; from afar: from a place further from all surfaces than rounding could put a
 * packet. */
enum cml_bodies_ahead { CML_NO_BODIES, CML_BODIES, CML_BODIES_FROM_AFAR };

/* Afar is outside the grid, or beyond the planes and in the ball by a twentieth of its radius. */
CML_FN int cml_bodies_from(const struct cml_body_view *view)
{
    const int off_planes = (view->distance < (real)0.9 * view->square) & (view->above | view->below);
    return view->gap > 0 || off_planes ? CML_BODIES_FROM_AFAR : CML_BODIES;
}

/* From ball to ball: through so many at most, and no further than this, cells, for rounding grows with the
 * way, and CML_CELL_MARGIN is all that cells have to spare for it. */
#define CML_BODY_BALLS 6
#define CML_BODY_FARTHEST 10000

/* Whether (enum cml_bodies_ahead) a packet at p can meet the surface of a body within t_max along u: from
 * ball to ball along its path [sphere tracing, J. C. Hart, The Visual Computer 12 (1996) 527].
 * *region: of a path that meets none, one in which it ends, if one is known. Outside of the grid the way to
 * it is free. What is not a number may meet one. */
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

/* Whether a ray from p along u passes the box of a node before t_max. Boxes are larger by more than rounding.
 * What is not a number does not shorten the ray. */
CML_FN int cml_passes_box(const CML_GLOBAL struct cml_body_node *node, struct cml_vec p, struct cml_vec per_u,
                          real t_max)
{
    real enter = 0, leave = t_max;
    const real x0 = (node->lower.x - p.x) * per_u.x, x1 = (node->upper.x - p.x) * per_u.x;
    const real y0 = (node->lower.y - p.y) * per_u.y, y1 = (node->upper.y - p.y) * per_u.y;
    const real z0 = (node->lower.z - p.z) * per_u.z, z1 = (node->upper.z - p.z) * per_u.z;
    const real xn = x0 < x1 ? x0 : x1, xf = x0 < x1 ? x1 : x0;
    const real yn = y0 < y1 ? y0 : y1, yf = y0 < y1 ? y1 : y0;
    const real zn = z0 < z1 ? z0 : z1, zf = z0 < z1 ? z1 : z0;
    enter = xn > enter ? xn : enter;
    enter = yn > enter ? yn : enter;
    enter = zn > enter ? zn : enter;
    leave = xf < leave ? xf : leave;
    leave = yf < leave ? yf : leave;
    leave = zf < leave ? zf : leave;
    return !(enter > leave);
}

#endif
