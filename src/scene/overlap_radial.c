/* SPDX-License-Identifier: MIT */
#include "scene/overlap_radial.h"

#include <float.h>
#include <math.h>

/* Looks at one vertical: the upper surface's z and the lower one's over (x, y). `size` is what their rounding
 * grows with. */
static void look(struct cml_closest *closest, double x, double y, double upper, double lower, double size)
{
    const double gap = lower - upper;
    if (!(gap < closest->gap)) return;
    closest->gap = gap;
    closest->at[0] = x;
    closest->at[1] = y;
    closest->at[2] = upper;
    closest->rounding = 8.0 * DBL_EPSILON * size;
}

static void look_at_radius(const struct cml_radial_surface *upper, const struct cml_radial_surface *lower,
                           double r, struct cml_closest *closest)
{
    const double above = cml_radial_height(upper->radial, r), below = cml_radial_height(lower->radial, r);
    const double size = fabs(upper->z) + fabs(above) + fabs(lower->z) + fabs(below);
    look(closest, r, 0.0, upper->z - above, lower->z - below, size);
}

void cml_radial_against_radial(const struct cml_radial_surface *upper, const struct cml_radial_surface *lower,
                               struct cml_closest *closest)
{
    for (int i = 0; i < upper->radial->n; i++) look_at_radius(upper, lower, upper->radial->r[i], closest);
    for (int i = 0; i < lower->radial->n; i++) look_at_radius(upper, lower, lower->radial->r[i], closest);
}

/* One comparison of a mesh with a field; lengths in the mesh's frame. */
struct comparison {
    const struct cml_radial *radial;
    double z_mesh, z_field; /* nominal depths */
    bool mesh_is_upper;
    struct cml_closest *closest;
};

static void look_at_point(const struct comparison *c, double x, double y, double z)
{
    const double height = cml_radial_height(c->radial, hypot(x, y));
    const double mesh = c->z_mesh + z, field = c->z_field - height;
    const double size = fabs(c->z_mesh) + fabs(z) + fabs(c->z_field) + fabs(height);
    if (c->mesh_is_upper)
        look(c->closest, x, y, mesh, field, size);
    else
        look(c->closest, x, y, field, mesh, size);
}

/* The first sample with r_i >= r; n when there is none. */
static int first_sample_from(const struct cml_radial *radial, double r)
{
    int low = 0, high = radial->n;
    while (low < high) {
        const int middle = low + (high - low) / 2;
        if (radial->r[middle] < r)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* An edge seen from above, as a line that passes the axis at `distance`: r^2 = along^2 (t - foot)^2 +
 * distance^2. */
struct edge {
    const double *a, *b;
    double along, foot, distance;
};

static struct edge make_edge(const double *a, const double *b)
{
    struct edge edge = {a, b, hypot(b[0] - a[0], b[1] - a[1]), 0.0, hypot(a[0], a[1])};
    if (edge.along == 0.0) return edge;
    const double ux = (b[0] - a[0]) / edge.along, uy = (b[1] - a[1]) / edge.along;
    edge.foot = -(a[0] * ux + a[1] * uy) / edge.along;
    edge.distance = fabs(a[0] * uy - a[1] * ux);
    return edge;
}

static void look_along_edge(const struct comparison *c, const struct edge *edge, double t)
{
    if (!(t > 0.0 && t < 1.0)) return;
    const double *a = edge->a, *b = edge->b;
    look_at_point(c, a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2]));
}

static void look_at_crossings(const struct comparison *c, const struct edge *edge, double r)
{
    if (r < edge->distance) return;
    const double half = sqrt((r - edge->distance) * (r + edge->distance)) / edge->along;
    look_along_edge(c, edge, edge->foot - half);
    look_along_edge(c, edge, edge->foot + half);
}

/* Where an edge of slope s = dz/d(way seen from above) runs parallel to a cone of slope k: with w the way
 * from the foot, k w / sqrt(w^2 + distance^2) = s. */
static void look_at_stationary(const struct comparison *c, const struct edge *edge, int i)
{
    const struct cml_radial *radial = c->radial;
    const double k = -(radial->h[i + 1] - radial->h[i]) / (radial->r[i + 1] - radial->r[i]);
    const double s = (edge->b[2] - edge->a[2]) / edge->along;
    if (!(fabs(s) < fabs(k))) return;
    const double way = edge->distance * s / sqrt((fabs(k) - fabs(s)) * (fabs(k) + fabs(s)));
    look_along_edge(c, edge, edge->foot + copysign(1.0, k) * way / edge->along);
}

static void look_at_edge(const struct comparison *c, const double *a, const double *b)
{
    const struct edge edge = make_edge(a, b);
    if (edge.along == 0.0) return; /* vertical: its ends, the vertices, have been looked at */
    const double r_a = hypot(a[0], a[1]), r_b = hypot(b[0], b[1]), to = fmax(r_a, r_b);
    const double from = edge.foot > 0.0 && edge.foot < 1.0 ? edge.distance : fmin(r_a, r_b);
    const int n = c->radial->n;
    const int first = first_sample_from(c->radial, from);
    for (int i = first > 0 ? first - 1 : 0; i < n && c->radial->r[i] <= to; i++) {
        look_at_crossings(c, &edge, c->radial->r[i]);
        if (i + 1 < n) look_at_stationary(c, &edge, i);
    }
}

/* The part of a triangle over the line through the axis along its steepest direction, seen from above. */
struct ridge {
    double direction[2];
    double s[2], z[2]; /* way from the axis, depth; at both ends */
};

/* A vertex's way along the ridge's line and its distance from it. */
static void place_vertex(const struct ridge *ridge, const double *v, double *along, double *across)
{
    *along = v[0] * ridge->direction[0] + v[1] * ridge->direction[1];
    *across = v[0] * ridge->direction[1] - v[1] * ridge->direction[0];
}

/* False when the triangle stands upright or the line misses it. */
static bool find_ridge(const double *const v[3], struct ridge *ridge)
{
    double u[3], w[3];
    for (int k = 0; k < 3; k++) {
        u[k] = v[1][k] - v[0][k];
        w[k] = v[2][k] - v[0][k];
    }
    const double nx = u[1] * w[2] - u[2] * w[1], ny = u[2] * w[0] - u[0] * w[2];
    if (u[0] * w[1] - u[1] * w[0] == 0.0) return false;
    const double length = hypot(nx, ny); /* 0 when level: then every direction is as good */
    ridge->direction[0] = length > 0.0 ? nx / length : 1.0;
    ridge->direction[1] = length > 0.0 ? ny / length : 0.0;
    int ends = 0;
    for (int i = 0; i < 3; i++) {
        const double *a = v[i], *b = v[(i + 1) % 3];
        double s_a, s_b, off_a, off_b;
        place_vertex(ridge, a, &s_a, &off_a);
        place_vertex(ridge, b, &s_b, &off_b);
        if ((off_a > 0.0) == (off_b > 0.0)) continue;
        const double t = off_a / (off_a - off_b);
        ridge->s[ends] = s_a + t * (s_b - s_a);
        ridge->z[ends++] = a[2] + t * (b[2] - a[2]);
    }
    return ends == 2 && ridge->s[0] != ridge->s[1];
}

static void look_along_ridge(const struct comparison *c, const struct ridge *ridge, double side)
{
    const double s_0 = side * ridge->s[0], s_1 = side * ridge->s[1];
    const double from = fmin(s_0, s_1), to = fmax(s_0, s_1);
    const struct cml_radial *radial = c->radial;
    for (int i = first_sample_from(radial, from); i < radial->n && radial->r[i] <= to; i++) {
        const double s = side * radial->r[i], t = (radial->r[i] - s_0) / (s_1 - s_0);
        look_at_point(c, s * ridge->direction[0], s * ridge->direction[1],
                      ridge->z[0] + t * (ridge->z[1] - ridge->z[0]));
    }
}

static void look_at_triangle(const struct comparison *c, const double *const v[3])
{
    struct ridge ridge;
    for (int i = 0; i < 3; i++) {
        look_at_point(c, v[i][0], v[i][1], v[i][2]);
        look_at_edge(c, v[i], v[(i + 1) % 3]);
    }
    if (!find_ridge(v, &ridge)) return;
    look_along_ridge(c, &ridge, 1.0);
    look_along_ridge(c, &ridge, -1.0);
}

/* The outer plane at the rings. One point per ring is enough: a ring that is partly inside the footprint
 * crosses the border's edges, where the triangles have been looked at. */
static void look_at_outer_plane(const struct comparison *c, const struct cml_footprint *footprint,
                                double z_border)
{
    for (int i = 0; i < c->radial->n; i++)
        if (!cml_footprint_contains(footprint, c->radial->r[i], 0.0))
            look_at_point(c, c->radial->r[i], 0.0, z_border);
}

/* The least gap that a triangle can have: lets nearly all triangles of distant surfaces pass at once. */
static double least_gap(const struct comparison *c, const double *const v[3], double field_top,
                        double field_bottom)
{
    const double top = fmin(fmin(v[0][2], v[1][2]), v[2][2]), bottom = fmax(fmax(v[0][2], v[1][2]), v[2][2]);
    return c->mesh_is_upper ? field_top - (c->z_mesh + bottom) : c->z_mesh + top - field_bottom;
}

void cml_radial_against_mesh(const struct cml_radial_surface *field, const struct cml_mesh *mesh,
                             const struct cml_footprint *footprint, double z, bool mesh_is_upper,
                             struct cml_closest *closest)
{
    const struct comparison c = {field->radial, z, field->z, mesh_is_upper, closest};
    double top = INFINITY, bottom = -INFINITY;
    for (int i = 0; i < field->radial->n; i++) {
        top = fmin(top, field->z - field->radial->h[i]);
        bottom = fmax(bottom, field->z - field->radial->h[i]);
    }
    look_at_outer_plane(&c, footprint, mesh->z_border);
    for (size_t i = 0; i < mesh->num_triangles; i++) {
        const uint32_t *t = mesh->triangle[i];
        const double *const v[3] = {mesh->vertex[t[0]], mesh->vertex[t[1]], mesh->vertex[t[2]]};
        if (least_gap(&c, v, top, bottom) < closest->gap) look_at_triangle(&c, v);
    }
}
