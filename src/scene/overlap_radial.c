/* Finds the least vertical gap between two surfaces of which one depends on the radius only. The gap is
 * piecewise smooth, so it suffices to look where pieces meet and where its derivative is 0.
 * SPDX-License-Identifier: MIT */
#include "scene/overlap_radial.h"

#include "base/array.h"
#include "geometry/vec3.h"

#include <float.h>
#include <math.h>

void cml_depth_range(const double *height, size_t count, double z, double *top, double *bottom)
{
    *top = INFINITY;
    *bottom = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        *top = fmin(*top, z - height[i]);
        *bottom = fmax(*bottom, z - height[i]);
    }
}

/* Compares the two surfaces over (x, y), where they lie at z = upper and z = lower, and keeps the place if
 * the gap is smaller than before. The rounding error of the gap grows with `size`. */
static void keep_closest(struct cml_closest *closest, double x, double y, double upper, double lower,
                         double size)
{
    const double gap = lower - upper;
    if (!(gap < closest->gap)) return;
    closest->gap = gap;
    closest->at[0] = x;
    closest->at[1] = y;
    closest->at[2] = upper;
    closest->err_gap = 8.0 * DBL_EPSILON * size;
}

/* Updates *closest with the gap between two radial surfaces at radius r: it keeps the place with the
 * smallest gap. size: how large the numbers are, for a bound of rounding. */
static void compare_at_radius(const struct cml_radial_surface *upper, const struct cml_radial_surface *lower,
                              double r, struct cml_closest *closest)
{
    const double above = cml_radial_height(upper->radial, r), below = cml_radial_height(lower->radial, r);
    const double size = fabs(upper->z) + fabs(above) + fabs(lower->z) + fabs(below);
    keep_closest(closest, r, 0.0, upper->z - above, lower->z - below, size);
}

void cml_radial_against_radial(const struct cml_radial_surface *upper, const struct cml_radial_surface *lower,
                               struct cml_closest *closest)
{
    for (int i = 0; i < upper->radial->n; i++) compare_at_radius(upper, lower, upper->radial->r[i], closest);
    for (int i = 0; i < lower->radial->n; i++) compare_at_radius(upper, lower, lower->radial->r[i], closest);
}

/* The comparison of a mesh with a radial heightfield; lengths in the mesh's frame. */
struct comparison {
    const struct cml_radial *radial;
    double z_mesh, z_field; /* nominal depths of mesh and heightfield, cm */
    bool mesh_is_upper;
    struct cml_closest *closest;
};

/* Updates *closest with the gap between a point of a mesh (x, y, z in the mesh's frame) and the radial
 * heightfield above or below it. */
static void compare_at_point(const struct comparison *c, double x, double y, double z)
{
    const double height = cml_radial_height(c->radial, hypot(x, y));
    const double mesh = c->z_mesh + z, field = c->z_field - height;
    const double size = fabs(c->z_mesh) + fabs(z) + fabs(c->z_field) + fabs(height);
    if (c->mesh_is_upper)
        keep_closest(c->closest, x, y, mesh, field, size);
    else
        keep_closest(c->closest, x, y, field, mesh, size);
}

int cml_radial_sample_from(const struct cml_radial *radial, double r)
{
    const int i = (int)cml_last_not_above(radial->r, (size_t)radial->n, r);
    return radial->r[i] < r ? i + 1 : i;
}

/* A mesh edge from a to b, seen from above. `along` is its length. The line through the edge passes the axis
 * at `distance`, at share `foot` of the edge (0: a, 1: b). The point at share t of the edge has the radius r
 * with r^2 = along^2 (t - foot)^2 + distance^2. */
struct edge {
    const double *a, *b;
    double along, foot, distance;
};

/* Returns an edge with the numbers by which gaps along it are found. A vertical edge is a point when seen
 * from above: `along` is then 0, and the other numbers mean nothing. */
static struct edge make_edge(const double *a, const double *b)
{
    struct edge edge = {a, b, hypot(b[0] - a[0], b[1] - a[1]), 0.0, hypot(a[0], a[1])};
    if (edge.along == 0.0) return edge;
    const double ux = (b[0] - a[0]) / edge.along, uy = (b[1] - a[1]) / edge.along;
    edge.foot = -(a[0] * ux + a[1] * uy) / edge.along;
    edge.distance = fabs(a[0] * uy - a[1] * ux);
    return edge;
}

/* Compares the mesh with the heightfield at share t of an edge (0: corner a, 1: corner b). Skips both ends,
 * because the vertices are compared by themselves. */
static void compare_on_edge(const struct comparison *c, const struct edge *edge, double t)
{
    if (!(t > 0.0 && t < 1.0)) return;
    const double *a = edge->a, *b = edge->b;
    compare_at_point(c, a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2]));
}

/* Compares where the edge, seen from above, crosses the circle of radius r. (r - d) (r + d) avoids the
 * cancellation of r^2 - d^2. */
static void compare_at_ring(const struct comparison *c, const struct edge *edge, double r)
{
    if (r < edge->distance) return;
    const double half = sqrt((r - edge->distance) * (r + edge->distance)) / edge->along;
    compare_on_edge(c, edge, edge->foot - half);
    compare_on_edge(c, edge, edge->foot + half);
}

/* Compares where an edge of slope s = dz/d(horizontal distance) runs parallel to a cone of slope k. At the
 * distance w from the foot the condition is k w / sqrt(w^2 + distance^2) = s. */
static void compare_where_parallel(const struct comparison *c, const struct edge *edge, int i)
{
    const struct cml_radial *radial = c->radial;
    const double k = -(radial->h[i + 1] - radial->h[i]) / (radial->r[i + 1] - radial->r[i]);
    const double s = (edge->b[2] - edge->a[2]) / edge->along;
    if (!(fabs(s) < fabs(k))) return;
    const double way = edge->distance * s / sqrt((fabs(k) - fabs(s)) * (fabs(k) + fabs(s)));
    compare_on_edge(c, edge, edge->foot + copysign(1.0, k) * way / edge->along);
}

/* Compares along an edge. The gap has kinks at the rings that the edge crosses. Between two rings it is least
 * at an end or where the edge runs parallel to the cone. */
static void compare_edge(const struct comparison *c, const double *a, const double *b)
{
    const struct edge edge = make_edge(a, b);
    if (edge.along == 0.0) return; /* the ends of a vertical edge, its vertices, have been compared already */
    const double r_a = hypot(a[0], a[1]), r_b = hypot(b[0], b[1]), to = fmax(r_a, r_b);
    const double from = edge.foot > 0.0 && edge.foot < 1.0 ? edge.distance : fmin(r_a, r_b);
    const int n = c->radial->n;
    const int first = cml_radial_sample_from(c->radial, from);
    for (int i = first > 0 ? first - 1 : 0; i < n && c->radial->r[i] <= to; i++) {
        compare_at_ring(c, &edge, c->radial->r[i]);
        if (i + 1 < n) compare_where_parallel(c, &edge, i);
    }
}

/* The cut through a triangle by the vertical plane that contains the z axis and is parallel to the triangle's
 * direction of steepest descent. */
struct section {
    double direction[2];
    double s[2], z[2]; /* the two ends of the cut: distance from the axis along `direction`, and depth, cm */
};

/* Splits a vertex's horizontal position into its distance along the section's line and its distance from that
 * line. */
static void place_vertex(const struct section *section, const double *v, double *along, double *across)
{
    *along = v[0] * section->direction[0] + v[1] * section->direction[1];
    *across = v[0] * section->direction[1] - v[1] * section->direction[0];
}

/* Finds the line in a triangle over which a radial surface comes closest: where the cone's radial gradient
 * can equal the triangle's. Returns false if the triangle is upright or the line misses it. */
static bool find_section(const double *const v[3], struct section *section)
{
    double normal[3];
    cml_vec3_area(v[0], v[1], v[2], normal);
    if (normal[2] == 0.0) return false;
    /* 0 for a level triangle, for which every direction serves */
    const double length = hypot(normal[0], normal[1]);
    section->direction[0] = length > 0.0 ? normal[0] / length : 1.0;
    section->direction[1] = length > 0.0 ? normal[1] / length : 0.0;
    int ends = 0;
    for (int i = 0; i < 3; i++) {
        const double *a = v[i], *b = v[(i + 1) % 3];
        double s_a, s_b, off_a, off_b;
        place_vertex(section, a, &s_a, &off_a);
        place_vertex(section, b, &s_b, &off_b);
        if ((off_a > 0.0) == (off_b > 0.0)) continue;
        const double t = off_a / (off_a - off_b);
        section->s[ends] = s_a + t * (s_b - s_a);
        section->z[ends++] = a[2] + t * (b[2] - a[2]);
    }
    return ends == 2 && section->s[0] != section->s[1];
}

/* Compares the mesh with the heightfield along the half of a section on one side of the axis; `side` is 1 or
 * -1. Both surfaces are piecewise linear along a line through the axis. Their gap is therefore least at a
 * ring or at an end of the section. The ends lie on edges, which are compared separately. */
static void compare_section(const struct comparison *c, const struct section *section, double side)
{
    const double s_0 = side * section->s[0], s_1 = side * section->s[1];
    const double from = fmin(s_0, s_1), to = fmax(s_0, s_1);
    const struct cml_radial *radial = c->radial;
    for (int i = cml_radial_sample_from(radial, from); i < radial->n && radial->r[i] <= to; i++) {
        const double s = side * radial->r[i], t = (radial->r[i] - s_0) / (s_1 - s_0);
        compare_at_point(c, s * section->direction[0], s * section->direction[1],
                         section->z[0] + t * (section->z[1] - section->z[0]));
    }
}

/* Compares a triangle with the heightfield at all places where the gap can be least (see
 * cml_radial_against_mesh). */
static void compare_triangle(const struct comparison *c, const double *const v[3])
{
    struct section section;
    for (int i = 0; i < 3; i++) {
        compare_at_point(c, v[i][0], v[i][1], v[i][2]);
        compare_edge(c, v[i], v[(i + 1) % 3]);
    }
    if (!find_section(v, &section)) return;
    compare_section(c, &section, 1.0);
    compare_section(c, &section, -1.0);
}

/* Compares the mesh's outer plane with the heightfield at the rings. One point per ring is enough: a ring
 * that is partly inside the footprint crosses border edges, where the triangles have been compared. */
static void compare_outer_plane(const struct comparison *c, const struct cml_footprint *footprint,
                                double z_border)
{
    for (int i = 0; i < c->radial->n; i++)
        if (!cml_footprint_contains(footprint, c->radial->r[i], 0.0))
            compare_at_point(c, c->radial->r[i], 0.0, z_border);
}

/* Returns a lower bound of the gap over a triangle. It excludes nearly all triangles of distant surfaces at
 * once. */
static double least_gap(const struct comparison *c, const double *const v[3], double field_top,
                        double field_bottom)
{
    const double top = fmin(fmin(v[0][2], v[1][2]), v[2][2]), bottom = fmax(fmax(v[0][2], v[1][2]), v[2][2]);
    return c->mesh_is_upper ? field_top - (c->z_mesh + bottom) : c->z_mesh + top - field_bottom;
}

/* The heightfield's range of depths is computed once, so that whole triangles can be excluded by it. */
void cml_radial_against_mesh(const struct cml_radial_surface *field, const struct cml_mesh *mesh,
                             const struct cml_footprint *footprint, double z, bool mesh_is_upper,
                             struct cml_closest *closest)
{
    const struct comparison c = {field->radial, z, field->z, mesh_is_upper, closest};
    double top, bottom;
    cml_depth_range(field->radial->h, (size_t)field->radial->n, field->z, &top, &bottom);
    if (footprint) compare_outer_plane(&c, footprint, mesh->z_border);
    for (size_t i = 0; i < mesh->num_triangles; i++) {
        const uint32_t *t = mesh->triangle[i];
        const double *const v[3] = {mesh->vertex[t[0]], mesh->vertex[t[1]], mesh->vertex[t[2]]};
        if (least_gap(&c, v, top, bottom) < closest->gap) compare_triangle(&c, v);
    }
}
