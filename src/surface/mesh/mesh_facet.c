/* SPDX-License-Identifier: MIT */
#include "surface/mesh/mesh_facet.h"

#include "geometry/vec3.h"

#include <float.h>
#include <math.h>

/* Edges that a line passes at smaller angles, rad, do not tell where it is inside a triangle. */
static const double parallel = 1e-6;

/* A part of a line, by distances. */
struct chord {
    double first, last;
};

/* What is between the corners, seen along the line. */
static struct chord between_corners(const struct cml_mesh *mesh, const uint32_t v[3], const double from[3],
                                    const double direction[3])
{
    struct chord chord = {INFINITY, -INFINITY};
    for (int k = 0; k < 3; k++) {
        double to_corner[3];
        cml_vec3_subtract(mesh->vertex[v[k]], from, to_corner);
        const double reach = cml_vec3_dot(to_corner, direction);
        chord.first = fmin(chord.first, reach);
        chord.last = fmax(chord.last, reach);
    }
    return chord;
}

/* What is inside the edges, seen along the normal. Only edges that the line passes more steeply than the
 * facet itself know more than the facet's plane; along: the sine of the angle to that. */
static struct chord between_edges(const struct cml_mesh_body *body, int primitive, const double from[3],
                                  const double direction[3], double along)
{
    const struct cml_mesh *mesh = &body->mesh;
    const uint32_t *v = mesh->triangle[primitive];
    struct chord chord = between_corners(mesh, v, from, direction);
    for (int k = 0; k < 3; k++) {
        double edge[3], inwards[3], to_edge[3];
        cml_vec3_subtract(mesh->vertex[v[(k + 1) % 3]], mesh->vertex[v[k]], edge);
        cml_vec3_cross(body->plane[primitive], edge, inwards);
        cml_vec3_subtract(mesh->vertex[v[k]], from, to_edge);
        const double speed = cml_vec3_dot(direction, inwards), t = cml_vec3_dot(to_edge, inwards) / speed;
        const double least = fmax(parallel, fabs(along)) * sqrt(cml_vec3_dot(edge, edge));
        if (speed > least) chord.first = fmax(chord.first, t);
        if (speed < -least) chord.last = fmin(chord.last, t);
    }
    return chord;
}

/* Where the line passes a corner, rounding may leave its chord with less than no length. A crossing that
 * rounding has put before `least` is taken as late as rounding, and the facet, allow: one that is met at once
 * would be met again and again. */
double cml_facet_crossing(const struct cml_mesh_body *body, int primitive, const double from[3],
                          const double direction[3], double least)
{
    const double *normal = body->plane[primitive], along = cml_vec3_dot(direction, normal);
    double to_corner[3];
    cml_vec3_subtract(body->mesh.vertex[body->mesh.triangle[primitive][0]], from, to_corner);
    const struct chord chord = between_edges(body, primitive, from, direction, along);
    const double low = fmin(chord.first, chord.last), high = fmax(chord.first, chord.last);
    const double t = fmax(low, fmin(cml_vec3_dot(to_corner, normal) / along, high));
    if (t >= least) return t;
    double rounding = 0;
    for (int k = 0; k < 3; k++) rounding += 4 * DBL_EPSILON * fabs(to_corner[k] * normal[k]);
    return fmax(least, fmin(t + rounding / fabs(along), high));
}

static double distance_to_segment(const double a[3], const double b[3], const double p[3])
{
    double edge[3], off[3];
    cml_vec3_subtract(b, a, edge);
    cml_vec3_subtract(p, a, off);
    const double s = cml_vec3_dot(edge, off) / cml_vec3_dot(edge, edge);
    for (int k = 0; k < 3; k++) off[k] -= (s > 0 ? (s < 1 ? s : 1) : 0) * edge[k];
    return sqrt(cml_vec3_dot(off, off));
}

double cml_facet_distance(const struct cml_mesh_body *body, int primitive, const double p[3])
{
    const struct cml_mesh *mesh = &body->mesh;
    const double *normal = body->plane[primitive];
    double nearest = INFINITY;
    bool above = true;
    for (int k = 0; k < 3; k++) {
        const double *a = mesh->vertex[mesh->triangle[primitive][k]],
                     *b = mesh->vertex[mesh->triangle[primitive][(k + 1) % 3]];
        double edge[3], inwards[3], off[3];
        cml_vec3_subtract(b, a, edge);
        cml_vec3_subtract(p, a, off);
        cml_vec3_cross(normal, edge, inwards);
        above = above && cml_vec3_dot(off, inwards) >= 0;
        nearest = fmin(nearest, distance_to_segment(a, b, p));
    }
    return above ? fabs(normal[3] - cml_vec3_dot(p, normal)) : nearest;
}

double cml_ray_closest_to_edge(const double from[3], const double direction[3], const double a[3],
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
