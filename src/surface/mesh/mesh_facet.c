/* Geometry of one facet: crossing with a line, distance from a point. SPDX-License-Identifier: MIT */
#include "surface/mesh/mesh_facet.h"

#include "geometry/vec3.h"
#include "surface/tree/rounding.h"

#include <math.h>

/* A part of a line, as distances from a point of it, cm. */
struct chord {
    double first, last;
};

/* Returns the part of a line between the corners of a facet, as seen along the line. This bound holds however
 * small the angle between line and facet is. */
static struct chord between_corners(const struct cml_centred_mesh *centred, int primitive,
                                    const double from[3], const double direction[3])
{
    struct chord chord = {INFINITY, -INFINITY};
    for (int k = 0; k < 3; k++) {
        double to_corner[3];
        cml_vec3_subtract(cml_centred_corner(centred, primitive, k), from, to_corner);
        const double t = cml_vec3_dot(to_corner, direction);
        chord.first = fmin(chord.first, t);
        chord.last = fmax(chord.last, t);
    }
    return chord;
}

/* Returns the part of a line inside a facet's edges, as seen along the facet's normal: the line is clipped by
 * the edges [Cyrus and Beck, Computers and Graphics 3 (1), 1978]. Only edges that the line passes more
 * steeply than the facet itself improve on the facet's plane. along: sine of the angle between line and
 * facet. */
static struct chord between_edges(const struct cml_centred_mesh *centred, int primitive, const double from[3],
                                  const double direction[3], double along)
{
    struct chord chord = between_corners(centred, primitive, from, direction);
    for (int k = 0; k < 3; k++) {
        const double *a = cml_centred_corner(centred, primitive, k);
        double edge[3], inwards[3], to_edge[3];
        cml_vec3_subtract(cml_centred_corner(centred, primitive, (k + 1) % 3), a, edge);
        cml_vec3_cross(centred->plane[primitive], edge, inwards);
        cml_vec3_subtract(a, from, to_edge);
        const double speed = cml_vec3_dot(direction, inwards), t = cml_vec3_dot(to_edge, inwards) / speed;
        const double least = fmax(err_sine_edge, fabs(along)) * cml_vec3_length(edge);
        if (speed > least) chord.first = fmax(chord.first, t);
        if (speed < -least) chord.last = fmin(chord.last, t);
    }
    return chord;
}

/* At a corner, rounding may make the length of the chord negative. If rounding puts the crossing before
 * `least`, the crossing is put as late as rounding and the facet allow. Otherwise a packet could meet the
 * facet on which it stands again and again. */
double cml_facet_crossing(const struct cml_centred_mesh *centred, int primitive, const double from[3],
                          const double direction[3], double least)
{
    const double *normal = centred->plane[primitive], along = cml_vec3_dot(direction, normal);
    double to_corner[3];
    cml_vec3_subtract(cml_centred_corner(centred, primitive, 0), from, to_corner);
    const struct chord chord = between_edges(centred, primitive, from, direction, along);
    const double low = fmin(chord.first, chord.last), high = fmax(chord.first, chord.last);
    const double t = fmax(low, fmin(cml_vec3_dot(to_corner, normal) / along, high));
    if (t >= least) return t;
    double err = 0; /* rounding of the distance from the plane */
    for (int k = 0; k < 3; k++) err += err_share_product * fabs(to_corner[k] * normal[k]);
    return fmax(least, fmin(t + err / fabs(along), high));
}

/* Returns the distance of p from the segment a b [Ericson, Real-Time Collision Detection, 2005, section
 * 5.1.2]. */
static double distance_to_segment(const double a[3], const double b[3], const double p[3])
{
    double edge[3], off[3];
    cml_vec3_subtract(b, a, edge);
    cml_vec3_subtract(p, a, off);
    const double s = cml_vec3_dot(edge, off) / cml_vec3_dot(edge, edge);
    cml_vec3_add_scaled(off, -(s > 0 ? (s < 1 ? s : 1) : 0), edge, off);
    return cml_vec3_length(off);
}

/* The distance is that of the facet's plane if p projects into the facet, else of the nearest edge. */
double cml_facet_distance(const struct cml_centred_mesh *centred, int primitive, const double p[3])
{
    const double *normal = centred->plane[primitive];
    double nearest = INFINITY;
    bool above = true;
    for (int k = 0; k < 3; k++) {
        const double *a = cml_centred_corner(centred, primitive, k),
                     *b = cml_centred_corner(centred, primitive, (k + 1) % 3);
        double edge[3], inwards[3], off[3];
        cml_vec3_subtract(b, a, edge);
        cml_vec3_subtract(p, a, off);
        cml_vec3_cross(normal, edge, inwards);
        above = above && cml_vec3_dot(off, inwards) >= 0;
        nearest = fmin(nearest, distance_to_segment(a, b, p));
    }
    return above ? fabs(normal[3] - cml_vec3_dot(p, normal)) : nearest;
}

/* Computes the closest points of two lines; the point on the edge is clamped to the edge's ends [Ericson,
 * section 5.1.9]. */
double cml_facet_edge_approach(const double from[3], const double direction[3], const double a[3],
                               const double b[3])
{
    double edge[3], off[3];
    cml_vec3_subtract(b, a, edge);
    cml_vec3_subtract(from, a, off);
    const double along = cml_vec3_dot(direction, edge), square = cml_vec3_dot(edge, edge);
    const double before = cml_vec3_dot(direction, off);
    const double s = (cml_vec3_dot(edge, off) - along * before) / (square - along * along);
    return fmax(0, (s > 0 ? (s < 1 ? s : 1) : 0) * along - before);
}
