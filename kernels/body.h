/* Crossings of a packet with the bodies of its medium: spheres, cylinders and closed meshes.
 * A body is a medium of its own inside a layer or inside another body. Its surface counts as a boundary whose
 * upper side is outside: normals point outwards, and a packet inside is "below" the boundary.
 * A packet must not meet again the place where it stands. For spheres and cylinders no small distance is
 * needed for that, because they are convex:
 *
 *      outside: a packet that leaves the body         inside: the root at which the packet stands
 *      never meets it again on its straight path      is known, and is divided out
 *
 *                     ^                                        . - - .
 *               . - -/- .                                    *---------> t    the other root
 *             .     *     .                                .           .
 *
 * A packet that rounding has put beyond a surface crosses it at once if it heads on, and is back on its own
 * side if it does not. A packet inside always has a crossing ahead.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "optics.h"
#include "types.h"

/* A crossing with a sphere or a cylinder. */
struct cml_body_hit {
    real t, along;      /* distance, cm; place along the axis of a cylinder, cm */
    int primitive;      /* cylinder: 0 the side, 1 the first end, 2 the other end; sphere: 0 */
    struct cml_vec off; /* place from the centre or axis; rounding may have left it beside the surface */
};

/* A line d + t v, v of any length but 0, against a circle, cylinder or sphere about the origin. The line is
 * closest to the origin at t = middle, and is inside the body from middle - reach to middle + reach. If the
 * line misses the body, reach is 0.
 * Distances from `middle` are as sharp as the body is small, however far away the packet is. The discriminant
 * is computed from the distance at which the line passes the origin, so it does not cancel far from the
 * centre [E. Haines, J. Guenther, T. Akenine-Moeller, Precision Improvements for Ray/Sphere Intersection, Ray
 * Tracing Gems, chapter 7, 2019]. */
struct cml_pass {
    int passes;
    real middle, reach;
    struct cml_vec foot; /* d + middle v */
};

/* Returns the pass of the line d + t v by a body of radius r about the origin. */
CML_FN struct cml_pass cml_pass_quadric(struct cml_vec d, struct cml_vec v, real r)
{
    const real a = cml_dot(v, v), middle = -cml_dot(d, v) / a;
    const struct cml_vec foot = cml_along(d, middle, v);
    const real square = r * r - cml_dot(foot, foot);
    const struct cml_pass pass = {square > 0, middle, CML_SQRT(square > 0 ? square / a : (real)0), foot};
    return pass;
}

/* Returns the pass of a line that begins at a place d on the surface: a chord of the body. It serves a packet
 * that rounding has put beyond the surface that it is to leave. If the line of such a packet misses the body,
 * cml_pass_quadric would give a crossing at the closest approach, where the angle of incidence is undefined
 * and from which no chord leads on. */
CML_FN struct cml_pass cml_pass_chord(struct cml_vec d, struct cml_vec v)
{
    const real middle = -cml_dot(d, v) / cml_dot(v, v);
    const struct cml_pass pass = {1, middle, CML_FABS(middle), cml_along(d, middle, v)};
    return pass;
}

/* Finds the crossing of a packet outside a sphere. Returns 0 if its path misses the sphere. d: from the
 * sphere's centre to the packet, cm; r: radius, cm. */
CML_FN int cml_enter_sphere(struct cml_vec d, struct cml_vec u, real r, struct cml_body_hit *hit)
{
    if (!(cml_dot(d, u) < 0)) return 0;
    const struct cml_pass pass = cml_pass_quadric(d, u, r);
    const real t = pass.middle - pass.reach;
    hit->t = t > 0 ? t : (real)0;
    hit->off = t > 0 ? cml_along(pass.foot, -pass.reach, u) : d;
    return pass.passes;
}

/* Finds the crossing at which a packet inside a sphere leaves it. d: from the sphere's centre to the packet,
 * cm; r: radius, cm; stands: 1 if the packet stands on the sphere. */
CML_FN void cml_leave_sphere(struct cml_vec d, struct cml_vec u, real r, int stands, struct cml_body_hit *hit)
{
    const int on = stands | (cml_dot(d, d) >= r * r);
    const struct cml_pass pass = on ? cml_pass_chord(d, u) : cml_pass_quadric(d, u, r);
    const real t = pass.middle + pass.reach;
    hit->t = t > 0 ? t : (real)0;
    hit->off = cml_along(pass.foot, pass.reach, u);
}

/* A packet's line as a cylinder with flat ends sees it. The line lies inside the infinite cylinder from
 * side_in to side_out, and between the planes of both ends from end_in to end_out. All four distances count
 * from one place of the line, its middle.
 * The middle is where the line passes the axis. A line almost along the axis does so far away, and distances
 * from there would have the rounding of that distance. For such a line the middle is half-way between the
 * ends. */
struct cml_cylinder_line {
    struct cml_vec across, v; /* place and direction of the packet across the axis */
    real rise;                /* component of the direction along the axis */
    real middle;              /* distance from the packet to the middle, cm */
    real along;               /* place of the middle along the axis */
    struct cml_vec foot;      /* place of the middle across the axis */
    int misses;               /* 1: the line misses the infinite cylinder, or the slab between the ends */
    real side_in, side_out, end_in, end_out;
    int first_end, last_end; /* primitives: the end where the line comes in, and the other */
};

/* A line closer to the axis than this counts as lengthwise: square of the sine of the angle between them.
 * Such a line passes the axis far from the ends of the cylinder. */
#define CML_LENGTHWISE ((real)1e-4)

/* Returns a packet's line as the cylinder sees it. d: the packet from the middle of the first end.
 * on_primitive: the part of the cylinder that the packet stands on, or -1. off: place of a standing packet
 * across the axis. leaves: 1 if the packet is inside. */
CML_FN struct cml_cylinder_line cml_cylinder_line_of(const CML_GLOBAL struct cml_body *body, struct cml_vec d,
                                                     struct cml_vec u, int on_primitive, struct cml_vec off,
                                                     int leaves)
{
    const real seen = cml_dot(d, body->axis), rise = cml_dot(u, body->axis), r = body->radius;
    const struct cml_vec v = cml_along(u, -rise, body->axis),
                         across = on_primitive < 0 ? cml_along(d, -seen, body->axis) : off;
    const real along = on_primitive > 0 ? (on_primitive == 1 ? (real)0 : body->length) : seen;
    const int on = leaves & ((on_primitive == 0) | (cml_dot(across, across) >= r * r));
    const real sine_squared = cml_dot(v, v);
    struct cml_pass side = {cml_dot(across, across) < r * r, 0, CML_INFINITY, across};
    if (sine_squared > 0) side = on ? cml_pass_chord(across, v) : cml_pass_quadric(across, v, r);
    const int lengthwise = (sine_squared > 0) & (sine_squared < CML_LENGTHWISE);
    const real middle = lengthwise ? (body->length / 2 - along) / rise : side.middle;
    struct cml_cylinder_line line = {.across = across, .v = v, .rise = rise, .middle = middle};
    line.along = CML_FMA(middle, rise, along);
    line.foot = lengthwise ? cml_along(across, middle, v) : side.foot;
    line.misses = !side.passes;
    line.side_in = lengthwise ? side.middle - side.reach - middle : -side.reach;
    line.side_out = lengthwise ? side.middle + side.reach - middle : side.reach;
    line.end_in = -CML_INFINITY;
    line.end_out = CML_INFINITY;
    line.first_end = rise > 0 ? 1 : 2;
    line.last_end = 3 - line.first_end;
    if (rise != 0) {
        const real a = -line.along / rise, b = (body->length - line.along) / rise;
        line.end_in = rise > 0 ? a : b;
        line.end_out = rise > 0 ? b : a;
    } else {
        line.misses |= !((along > 0) & (along < body->length));
    }
    return line;
}

/* Fills *hit with a crossing of the line. from_middle: distance of the crossing from the line's middle,
 * positive in flight direction, cm. If the crossing lies behind the packet, it is moved to the packet. */
CML_FN void cml_cross_cylinder(const struct cml_cylinder_line *line, real from_middle, int primitive,
                               struct cml_body_hit *hit)
{
    const real t = line->middle + from_middle;
    hit->t = t > 0 ? t : (real)0;
    hit->primitive = primitive;
    hit->along = CML_FMA(t > 0 ? from_middle : -line->middle, line->rise, line->along);
    hit->off = t > 0 ? cml_along(line->foot, from_middle, line->v) : line->across;
}

/* Finds the crossing of a packet outside a cylinder. Returns 0 if there is none. A packet that rounding has
 * put inside crosses at once where it came in, not where it would go out. */
CML_FN int cml_enter_cylinder(const struct cml_cylinder_line *line, struct cml_body_hit *hit)
{
    const int side = line->side_in > line->end_in;
    const real in = side ? line->side_in : line->end_in,
               out = line->side_out < line->end_out ? line->side_out : line->end_out;
    cml_cross_cylinder(line, in, side ? 0 : line->first_end, hit);
    return !line->misses & (in < out) & (2 * line->middle + in + out > 0);
}

/* Finds the crossing at which a packet inside a cylinder leaves it. */
CML_FN void cml_leave_cylinder(const struct cml_cylinder_line *line, struct cml_body_hit *hit)
{
    const int side = line->side_out < line->end_out;
    cml_cross_cylinder(line, side ? line->side_out : line->end_out, side ? 0 : line->last_end, hit);
}

/* Fills *hit with the place and normal of a crossing. The place is moved onto the surface, exact but for
 * rounding: between the ends, and at the radius, which a long way to the cylinder may have lost. */
CML_FN void cml_place_on_body(const CML_GLOBAL struct cml_body *body, const struct cml_body_hit *at,
                              struct cml_hit *hit)
{
    const struct cml_vec off = cml_along(at->off, -cml_dot(at->off, body->axis), body->axis);
    const real size = CML_SQRT(cml_dot(off, off)), per_size = size > 0 ? 1 / size : (real)0;
    const real sign = at->primitive == 1 ? (real)-1 : (real)1;
    const struct cml_vec none = {0, 0, 0}, radial = {per_size * off.x, per_size * off.y, per_size * off.z},
                         outwards = {sign * body->axis.x, sign * body->axis.y, sign * body->axis.z};
    const int side = at->primitive == 0;
    const real inside = at->along > 0 ? (at->along < body->length ? at->along : body->length) : (real)0;
    const real along = side ? inside : (at->primitive == 1 ? (real)0 : body->length);
    hit->t = at->t;
    hit->primitive = at->primitive;
    hit->normal = side ? radial : outwards;
    hit->facet = hit->normal;
    hit->off = side ? cml_along(none, body->radius, radial) : off;
    hit->point = cml_along(cml_along(body->centre, along, body->axis), 1, hit->off);
}

/* True if a ray from p passes the box of a node before t_max: it enters the slabs of all three axes before
 * it leaves one of them. per_u: inverse of the direction, by component. Boxes are larger than their bodies
 * by more than rounding. A quotient that is not a number (0 times infinity) does not shorten the ray. */
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
