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

/* Of the distance from p, in a layer with bodies or in one of them, to the surface of any body there: what it
 * surely is, cm. The middle of the cell knows its own, of which no more than the way there can be lacking.
 * Outside of the grid the way to it comes on top, at an angle of at least 90 degrees to any way from there to
 * a body. */
CML_FN real cml_body_clearance(const CML_GLOBAL struct cml_body_grid *grid, const CML_GLOBAL real *clearance,
                               struct cml_vec p)
{
    const real x = (p.x - grid->corner.x) * grid->per_cell, y = (p.y - grid->corner.y) * grid->per_cell,
               z = (p.z - grid->corner.z) * grid->per_cell;
    const real nx = (real)grid->nx, ny = (real)grid->ny, nz = (real)grid->nz;
    const real ix = x > 0 ? (x < nx ? x : nx) : (real)0, iy = y > 0 ? (y < ny ? y : ny) : (real)0,
               iz = z > 0 ? (z < nz ? z : nz) : (real)0;
    const int cx = (int)(ix < nx - 1 ? ix : nx - 1), cy = (int)(iy < ny - 1 ? iy : ny - 1),
              cz = (int)(iz < nz - 1 ? iz : nz - 1);
    const struct cml_vec off = {ix - (real)cx - (real)0.5, iy - (real)cy - (real)0.5,
                                iz - (real)cz - (real)0.5};
    const struct cml_vec out = {x - ix, y - iy, z - iz};
    const real least =
        clearance[grid->first + (cz * grid->ny + cy) * grid->nx + cx] - CML_SQRT(cml_dot(off, off));
    const real here = least > 0 ? least : (real)0;
    return (real)0.9999 * grid->cell * CML_SQRT(CML_FMA(here, here, cml_dot(out, out)));
}

/* Whether a packet at p can meet the surface of a body within t_max along u: from clearance to clearance
 * along its path [sphere tracing, J. C. Hart, The Visual Computer 12 (1996) 527], which most packets that
 * head away from a body need not go on with for long. */
CML_FN int cml_may_meet_body(const struct cml_world *world, int medium, struct cml_vec p, struct cml_vec u,
                             real t_max)
{
    const int number = world->media[medium].body_grid, most = 4;
    real t = 0, clear = CML_INFINITY;
    for (int i = 0; number >= 0 && i < most && clear > 0; i++) {
        clear = cml_body_clearance(&world->body_grids[number], world->body_clearance, cml_along(p, t, u)) -
                4 * CML_EPSILON * t;
        if (t_max - t < clear) return 0;
        t += clear;
    }
    return number >= 0;
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
