/* SPDX-License-Identifier: MIT */
#include "scene/body/convex.h"

#include "base/constants.h"
#include "geometry/vec3.h"

#include <float.h>
#include <math.h>

/* Largest rounding error of a gap, as a share of the size of the coordinates: smaller gaps count as contact.
 * A distance passes through some 20 operations, each of which rounds by half an epsilon of that size: 10
 * epsilon, taken as 64. */
static const double err_share = 64 * DBL_EPSILON;

/* Splits p - centre into its coordinate along a cylinder's axis, which is returned, and the vector across the
 * axis. */
static double along_axis(const struct cml_convex *c, const double p[3], double across[3])
{
    double d[3];
    cml_vec3_subtract(p, c->centre, d);
    const double along = cml_vec3_dot(d, c->axis);
    cml_vec3_add_scaled(d, -along, c->axis, across);
    return along;
}

/* Finds the point of a solid sphere that is closest to p. */
static void project_on_sphere(const struct cml_convex *c, const double p[3], double closest[3])
{
    double d[3];
    cml_vec3_subtract(p, c->centre, d);
    const double size = cml_vec3_length(d);
    if (size > c->radius)
        cml_vec3_add_scaled(c->centre, c->radius / size, d, closest);
    else
        cml_vec3_copy(p, closest);
}

/* Finds the point of a solid cylinder that is closest to p, by the parts of p along the axis and across
 * it. */
static void project_on_cylinder(const struct cml_convex *c, const double p[3], double closest[3])
{
    double across[3];
    const double along = along_axis(c, p, across), size = cml_vec3_length(across);
    const double part = size > c->radius ? c->radius / size : 1;
    cml_vec3_add_scaled(c->centre, fmax(0, fmin(c->length, along)), c->axis, closest);
    cml_vec3_add_scaled(closest, part, across, closest);
}

/* Finds the closest point of a triangle from the region around the triangle that contains p [C. Ericson,
 * Real-Time Collision Detection, 2005, section 5.1.5]. */
static void project_on_triangle(const struct cml_convex *c, const double p[3], double closest[3])
{
    const double *a = c->corner[0];
    double ab[3], ac[3], ap[3], bp[3], cp[3];
    cml_vec3_subtract(c->corner[1], a, ab);
    cml_vec3_subtract(c->corner[2], a, ac);
    cml_vec3_subtract(p, a, ap);
    cml_vec3_subtract(p, c->corner[1], bp);
    cml_vec3_subtract(p, c->corner[2], cp);
    const double d1 = cml_vec3_dot(ab, ap), d2 = cml_vec3_dot(ac, ap), d3 = cml_vec3_dot(ab, bp),
                 d4 = cml_vec3_dot(ac, bp), d5 = cml_vec3_dot(ab, cp), d6 = cml_vec3_dot(ac, cp);
    const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    double v = 0, w = 0;
    if (d1 <= 0 && d2 <= 0)
        v = w = 0;
    else if (d3 >= 0 && d4 <= d3)
        v = 1;
    else if (d6 >= 0 && d5 <= d6)
        w = 1;
    else if (vc <= 0 && d1 >= 0 && d3 <= 0)
        v = d1 / (d1 - d3);
    else if (vb <= 0 && d2 >= 0 && d6 <= 0)
        w = d2 / (d2 - d6);
    else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        v = 1 - w;
    } else {
        v = vb / (va + vb + vc);
        w = vc / (va + vb + vc);
    }
    cml_vec3_add_scaled(a, v, ab, closest);
    cml_vec3_add_scaled(closest, w, ac, closest);
}

void cml_convex_project(const struct cml_convex *convex, const double p[3], double closest[3])
{
    if (convex->form == CML_CONVEX_SPHERE)
        project_on_sphere(convex, p, closest);
    else if (convex->form == CML_CONVEX_CYLINDER)
        project_on_cylinder(convex, p, closest);
    else
        project_on_triangle(convex, p, closest);
}

/* Beyond the rim of a cylinder the closest point lies on its edge, hence hypot. */
double cml_convex_distance(const struct cml_convex *convex, const double p[3])
{
    double d[3];
    cml_vec3_subtract(p, convex->centre, d);
    if (convex->form == CML_CONVEX_SPHERE) return cml_vec3_length(d) - convex->radius;
    double across[3];
    const double along = along_axis(convex, p, across);
    const double side = cml_vec3_length(across) - convex->radius, ends = fmax(-along, along - convex->length);
    return side > 0 && ends > 0 ? hypot(side, ends) : fmax(side, ends);
}

/* Returns the support function: the largest scalar product of a point of the set with the direction n. */
static double support(const struct cml_convex *c, const double n[3])
{
    if (c->form == CML_CONVEX_TRIANGLE)
        return fmax(fmax(cml_vec3_dot(c->corner[0], n), cml_vec3_dot(c->corner[1], n)),
                    cml_vec3_dot(c->corner[2], n));
    const double middle = cml_vec3_dot(c->centre, n), size = cml_vec3_length(n);
    if (c->form == CML_CONVEX_SPHERE) return middle + c->radius * size;
    const double rise = cml_vec3_dot(c->axis, n);
    return middle + fmax(0, rise * c->length) + c->radius * sqrt(fmax(0, size * size - rise * rise));
}

/* Returns the size of a set's coordinates, with which the rounding error grows. */
static double size_of(const struct cml_convex *c)
{
    const double *p = c->form == CML_CONVEX_TRIANGLE ? c->corner[0] : c->centre;
    return fabs(p[0]) + fabs(p[1]) + fabs(p[2]) + c->radius + c->length;
}

/* True if two sets are apart. Alternating projections converge to the closest points of two convex sets [J.
 * von Neumann, Functional Operators II, 1950; W. Cheney and A. A. Goldstein, Proc. AMS 10 (1959) 448]. The
 * loop ends with a plane between the sets, or with a distance within rounding. */
static bool are_apart(const struct cml_convex *a, const struct cml_convex *b, double err_distance,
                      double at[3])
{
    const int most = 20000;
    double p[3], q[3];
    cml_vec3_copy(b->form == CML_CONVEX_TRIANGLE ? b->corner[0] : b->centre, q);
    for (int i = 0; i < most; i++) {
        double n[3], back[3];
        cml_convex_project(a, q, p);
        cml_convex_project(b, p, q);
        cml_vec3_subtract(q, p, n);
        const double distance = cml_vec3_length(n);
        if (!(distance > err_distance)) break;
        for (int k = 0; k < 3; k++) {
            n[k] /= distance;
            back[k] = -n[k];
        }
        if (-support(b, back) - support(a, n) > err_distance) return true;
    }
    cml_vec3_copy(p, at);
    return false;
}

/* Returns an upper bound of the distance between the axis of cylinder `outer` and the rim, around `middle`,
 * of cylinder `inner`. The bound is the largest |v + r (q1 cos t + q2 sin t)| at 720 places of the rim, plus
 * the most by which the distance can be larger between two places. It never exceeds |v| + r, the distance for
 * parallel axes. If |v| + r already fits inside, it is returned at once. */
static double farthest_across(const struct cml_convex *outer, const struct cml_convex *inner,
                              const double middle[3])
{
    const int places = 720;
    double v[3], e1[3], e2[3], q1[3], q2[3], best = 0;
    along_axis(outer, middle, v);
    const double most = inner->radius + cml_vec3_length(v);
    if (most < outer->radius) return most;
    cml_vec3_frame(inner->axis, e1, e2);
    cml_vec3_add_scaled(e1, -cml_vec3_dot(e1, outer->axis), outer->axis, q1);
    cml_vec3_add_scaled(e2, -cml_vec3_dot(e2, outer->axis), outer->axis, q2);
    for (int i = 0; i < places; i++) {
        const double t = 2 * CML_PI * i / places;
        double w[3];
        cml_vec3_add_scaled(v, inner->radius * cos(t), q1, w);
        cml_vec3_add_scaled(w, inner->radius * sin(t), q2, w);
        best = fmax(best, cml_vec3_length(w));
    }
    /* between two places the square curves by at most 4 r (r + |v|) per radian^2 */
    const double half = CML_PI / places, r = inner->radius;
    return fmin(sqrt(best * best + 2 * r * most * half * half), most);
}

/* True if a sphere is apart from another set; closed form. at: the point of the other set closest to the
 * sphere's centre. */
static bool sphere_is_apart(const struct cml_convex *sphere, const struct cml_convex *other,
                            double err_distance, double at[3])
{
    double d[3];
    cml_convex_project(other, sphere->centre, at);
    cml_vec3_subtract(at, sphere->centre, d);
    return cml_vec3_length(d) - sphere->radius > err_distance;
}

/* Returns how far the farthest point of the inner set lies beyond the surface of a sphere or cylinder.
 * Negative: the whole inner set lies inside. A positive value is only a lower bound. */
static double reach_beyond(const struct cml_convex *outer, const struct cml_convex *inner)
{
    if (inner->form == CML_CONVEX_SPHERE) return cml_convex_distance(outer, inner->centre) + inner->radius;
    if (inner->form == CML_CONVEX_TRIANGLE)
        return fmax(
            fmax(cml_convex_distance(outer, inner->corner[0]), cml_convex_distance(outer, inner->corner[1])),
            cml_convex_distance(outer, inner->corner[2]));
    double most = -INFINITY;
    for (int end = 0; end < 2; end++) {
        double middle[3], d[3], across[3];
        cml_vec3_add_scaled(inner->centre, end * inner->length, inner->axis, middle);
        most = fmax(most, cml_convex_distance(outer, middle));
        if (most > 0) return most; /* most pairs of sets end here, before the costly search */
        cml_vec3_subtract(middle, outer->centre, d);
        if (outer->form == CML_CONVEX_SPHERE) {
            const double rise = cml_vec3_dot(d, inner->axis);
            cml_vec3_add_scaled(d, -rise, inner->axis, across);
            most = fmax(most, hypot(rise, cml_vec3_length(across) + inner->radius) - outer->radius);
            continue;
        }
        const double along = cml_vec3_dot(d, outer->axis), turn = cml_vec3_dot(inner->axis, outer->axis);
        const double wide = inner->radius * sqrt(fmax(0, 1 - turn * turn));
        most = fmax(most, fmax(wide - along, along + wide - outer->length));
        most = fmax(most, farthest_across(outer, inner, middle) - outer->radius);
    }
    return most;
}

/* Says whether two convex sets lie apart, one inside the other, or meet. err_distance is the rounding that
 * the decision allows for: a result within it counts as meeting, which is refused. A triangle has no
 * inside. */
enum cml_convex_order cml_convex_compare(const struct cml_convex *a, const struct cml_convex *b, double at[3])
{
    const double err_distance = err_share * (size_of(a) + size_of(b));
    if (b->form != CML_CONVEX_TRIANGLE && reach_beyond(b, a) < -err_distance) return CML_CONVEX_FIRST_INSIDE;
    if (a->form != CML_CONVEX_TRIANGLE && reach_beyond(a, b) < -err_distance) return CML_CONVEX_SECOND_INSIDE;
    double place[3];
    const bool apart = a->form == CML_CONVEX_SPHERE   ? sphere_is_apart(a, b, err_distance, place)
                       : b->form == CML_CONVEX_SPHERE ? sphere_is_apart(b, a, err_distance, place)
                                                      : are_apart(a, b, err_distance, place);
    if (apart) return CML_CONVEX_APART;
    cml_vec3_copy(place, at);
    return CML_CONVEX_MEET;
}
