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
    real t, along;      /* cm: distance; of a cylinder, place along its axis */
    int primitive;      /* of a cylinder: 0 the side, 1 the first end, 2 the other; of a sphere 0 */
    struct cml_vec off; /* place from the centre, or from the axis, not yet on the surface but for rounding */
};

/* A line d + t v, v of any length but 0, and a circle, cylinder or sphere about the origin: it is closest to
 * it at t = middle, and inside from middle - reach to middle + reach. What is counted from there is as sharp
 * as the body is small, however long the way is. The discriminant from the distance at which the line passes
 * does not cancel far from the centre [E. Haines, J. Guenther, T. Akenine-Moeller, Precision Improvements for
 * Ray/Sphere Intersection, Ray Tracing Gems, chapter 7, 2019]. Where the line does not pass, reach is 0. */
struct cml_pass {
    int passes;
    real middle, reach;
    struct cml_vec foot; /* d + middle v */
};

CML_FN struct cml_pass cml_pass_quadric(struct cml_vec d, struct cml_vec v, real r)
{
    const real a = cml_dot(v, v), middle = -cml_dot(d, v) / a;
    const struct cml_vec foot = cml_along(d, middle, v);
    const real square = r * r - cml_dot(foot, foot);
    const struct cml_pass pass = {square > 0, middle, CML_SQRT(square > 0 ? square / a : (real)0), foot};
    return pass;
}

/* cml_pass_quadric from a place d on the surface: a chord. So stands a packet that rounding has put beyond
 * the surface that it is to leave: where its line passes beside, the closest approach would be a crossing
 * without an angle, from which no chord leads on. */
CML_FN struct cml_pass cml_pass_chord(struct cml_vec d, struct cml_vec v)
{
    const real middle = -cml_dot(d, v) / cml_dot(v, v);
    const struct cml_pass pass = {1, middle, CML_FABS(middle), cml_along(d, middle, v)};
    return pass;
}

/* A sphere from outside. d: the packet from its centre. */
CML_FN int cml_enter_sphere(struct cml_vec d, struct cml_vec u, real r, struct cml_body_hit *hit)
{
    if (!(cml_dot(d, u) < 0)) return 0;
    const struct cml_pass pass = cml_pass_quadric(d, u, r);
    const real t = pass.middle - pass.reach;
    hit->t = t > 0 ? t : (real)0;
    hit->off = t > 0 ? cml_along(pass.foot, -pass.reach, u) : d;
    return pass.passes;
}

/* Where a packet inside a sphere leaves it. d: from the centre, r: radius, cm; stands: whether it is on the
 * sphere. */
CML_FN void cml_leave_sphere(struct cml_vec d, struct cml_vec u, real r, int stands, struct cml_body_hit *hit)
{
    const int on = stands | (cml_dot(d, d) >= r * r);
    const struct cml_pass pass = on ? cml_pass_chord(d, u) : cml_pass_quadric(d, u, r);
    const real t = pass.middle + pass.reach;
    hit->t = t > 0 ? t : (real)0;
    hit->off = cml_along(pass.foot, pass.reach, u);
}

/* A packet as a cylinder with flat ends sees it: along its axis from the middle of its first end, and across
 * it; and where its line is within the infinite cylinder and where between the planes of both ends, both
 * counted from the side's middle. */
struct cml_cylinder_line {
    struct cml_vec across, v; /* place and direction across the axis */
    real rise;                /* direction along it */
    struct cml_pass side;
    real along; /* of the side's foot */
    int misses; /* one of both altogether */
    real end_in, end_out;
    int first_end, last_end; /* primitives */
};

/* d: the packet from the cylinder. on_primitive: what of the cylinder it stands on, or -1; off: then its
 * place across the axis. leaves: it is inside. */
CML_FN struct cml_cylinder_line cml_cylinder_line_of(const CML_GLOBAL struct cml_body *body, struct cml_vec d,
                                                     struct cml_vec u, int on_primitive, struct cml_vec off,
                                                     int leaves)
{
    const real seen = cml_dot(d, body->axis), rise = cml_dot(u, body->axis), r = body->radius;
    const struct cml_vec v = cml_along(u, -rise, body->axis),
                         across = on_primitive < 0 ? cml_along(d, -seen, body->axis) : off;
    const real along = on_primitive > 0 ? (on_primitive == 1 ? (real)0 : body->length) : seen;
    const int on = leaves & ((on_primitive == 0) | (cml_dot(across, across) >= r * r));
    const struct cml_pass beside = {cml_dot(across, across) < r * r, 0, CML_INFINITY, across};
    struct cml_cylinder_line line = {
        across, v, rise, beside, along, 0, -CML_INFINITY, CML_INFINITY, rise > 0 ? 1 : 2, rise > 0 ? 2 : 1};
    if (cml_dot(v, v) > 0) line.side = on ? cml_pass_chord(across, v) : cml_pass_quadric(across, v, r);
    line.along = CML_FMA(line.side.middle, rise, along);
    line.misses = !line.side.passes;
    if (rise != 0) {
        const real a = -line.along / rise, b = (body->length - line.along) / rise;
        line.end_in = rise > 0 ? a : b;
        line.end_out = rise > 0 ? b : a;
    } else {
        line.misses |= !((along > 0) & (along < body->length));
    }
    return line;
}

/* The crossing `from_middle` behind the side's middle. */
CML_FN void cml_cross_cylinder(const struct cml_cylinder_line *line, real from_middle, int primitive,
                               struct cml_body_hit *hit)
{
    const real t = line->side.middle + from_middle;
    hit->t = t > 0 ? t : (real)0;
    hit->primitive = primitive;
    hit->along = CML_FMA(from_middle, line->rise, line->along);
    hit->off = t > 0 ? cml_along(line->side.foot, from_middle, line->v) : line->across;
}

/* From outside. A packet that rounding has put inside crosses at once where it has come in rather than where
 * it goes out. */
CML_FN int cml_enter_cylinder(const struct cml_cylinder_line *line, struct cml_body_hit *hit)
{
    const real reach = line->side.reach;
    const int side = -reach > line->end_in;
    const real in = side ? -reach : line->end_in, out = reach < line->end_out ? reach : line->end_out;
    cml_cross_cylinder(line, in, side ? 0 : line->first_end, hit);
    return !line->misses & (in < out) & (2 * line->side.middle + in + out > 0);
}

CML_FN void cml_leave_cylinder(const struct cml_cylinder_line *line, struct cml_body_hit *hit)
{
    const int side = line->side.reach < line->end_out;
    cml_cross_cylinder(line, side ? line->side.reach : line->end_out, side ? 0 : line->last_end, hit);
}

/* Place and normal of a crossing, put onto the surface exactly but for rounding; and across the axis, which
 * a long way to the cylinder may have lost. */
CML_FN void cml_place_on_body(const CML_GLOBAL struct cml_body *body, const struct cml_body_hit *at,
                              struct cml_hit *hit)
{
    const struct cml_vec off = cml_along(at->off, -cml_dot(at->off, body->axis), body->axis);
    const real size = CML_SQRT(cml_dot(off, off)), per_size = size > 0 ? 1 / size : (real)0;
    const real sign = at->primitive == 1 ? (real)-1 : (real)1;
    const struct cml_vec none = {0, 0, 0}, radial = {per_size * off.x, per_size * off.y, per_size * off.z},
                         outwards = {sign * body->axis.x, sign * body->axis.y, sign * body->axis.z};
    const int side = at->primitive == 0;
    const real along = side ? at->along : (at->primitive == 1 ? (real)0 : body->length);
    hit->t = at->t;
    hit->primitive = at->primitive;
    hit->normal = side ? radial : outwards;
    hit->facet = hit->normal;
    hit->off = side ? cml_along(none, body->radius, radial) : off;
    hit->point = cml_along(cml_along(body->centre, along, body->axis), 1, hit->off);
}

/* Part of a ball that no surface of a body passes: what lies higher than `least` over its middle along
 * `normal`, which is 0 where the whole ball is free. In the frame of the layer, cm; square: of the radius, 0:
 * nothing is known. A path that begins and ends in it lies in it. */
struct cml_body_region {
    struct cml_vec middle, normal;
    real square, least;
};

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
