/* Adds a skirt to a mesh whose border is not level: triangles that lead from the border outwards to its mean
 * height. Lengths and directions along the border are measured as seen from above. SPDX-License-Identifier:
 * MIT */
#include "base/array.h"
#include "geometry/mesh_parts.h"
#include "geometry/vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct rim {
    const struct cml_mesh *mesh;
    size_t count;
    double *along; /* [count + 1] length of the border from its first vertex to each vertex, cm; the last
                      value is the whole length */
    double sense;  /* 1 if the border runs counter-clockwise, -1 if clockwise */
    double reach;  /* length along the border, before and behind a vertex, from which the outward direction is
                      taken, cm */
};

/* Returns vertex i of the border, counted cyclically. */
static const double *vertex_of(const struct rim *rim, size_t i)
{
    return rim->mesh->vertex[rim->mesh->border[i % rim->count]];
}

/* Measures the border of a mesh before the skirt is added: length along it at each vertex, its turning
 * sense, and the reach over which outward directions are smoothed. */
static void measure(struct rim *rim)
{
    double area = 0;
    rim->along[0] = 0;
    for (size_t i = 0; i < rim->count; i++) {
        const double *p = vertex_of(rim, i), *q = vertex_of(rim, i + 1);
        rim->along[i + 1] = rim->along[i] + hypot(q[0] - p[0], q[1] - p[1]);
        area += cml_vec2_area(vertex_of(rim, 0), p, q);
    }
    rim->sense = area > 0 ? 1 : -1;
    rim->reach = fmin(2 * rim->mesh->skirt, rim->along[rim->count] / 8);
}

/* Returns the border's mean depth by the trapezoidal rule, because its vertices may be spaced unevenly. */
static double mean_depth(const struct rim *rim)
{
    double sum = 0;
    for (size_t i = 0; i < rim->count; i++)
        sum += (rim->along[i + 1] - rim->along[i]) * (vertex_of(rim, i)[2] + vertex_of(rim, i + 1)[2]) / 2;
    return sum / rim->along[rim->count];
}

/* Finds the border's point at a length from its first vertex, from -1 to 2 times the border's length. */
static void point_at(const struct rim *rim, double length, double point[2])
{
    const double whole = rim->along[rim->count];
    length = fmax(0, length < 0 ? length + whole : length >= whole ? length - whole : length);
    const size_t low = cml_last_not_above(rim->along, rim->count, length);
    const double *p = vertex_of(rim, low), *q = vertex_of(rim, low + 1);
    const double edge = rim->along[low + 1] - rim->along[low];
    const double t = edge > 0 ? (length - rim->along[low]) / edge : 0;
    for (int k = 0; k < 2; k++) point[k] = p[k] + t * (q[k] - p[k]);
}

/* Computes the unit vector perpendicular to the step from p to q that points out of the border: to the step's
 * right, or to its left if the border runs clockwise. 0 if p = q. */
static void outward_of(const struct rim *rim, const double *p, const double *q, double out[2])
{
    const double x = q[0] - p[0], y = q[1] - p[1], length = hypot(x, y);
    out[0] = length > 0 ? rim->sense * y / length : 0;
    out[1] = length > 0 ? -rim->sense * x / length : 0;
}

/* Computes the step from border vertex i to its new vertex on the skirt's edge. The step is perpendicular to
 * the chord from a little before the vertex to a little behind it. Neighbouring steps then agree where the
 * border is wavy, and open like a fan around a corner. Where the step is oblique to an edge it is longer, at
 * most twice, so that straight sides have a skirt of even width. */
static void step_out(const struct rim *rim, size_t i, double step[2])
{
    double before[2], behind[2], edge[2], least = 1;
    point_at(rim, rim->along[i] - rim->reach, before);
    point_at(rim, rim->along[i] + rim->reach, behind);
    outward_of(rim, before, behind, step);
    for (size_t side = 0; side < 2; side++) {
        const size_t from = i + rim->count - 1 + side;
        outward_of(rim, vertex_of(rim, from), vertex_of(rim, from + 1), edge);
        if (edge[0] != 0 || edge[1] != 0) least = fmin(least, edge[0] * step[0] + edge[1] * step[1]);
    }
    for (int k = 0; k < 2; k++) step[k] *= rim->mesh->skirt / fmax(least, 0.5);
}

/* Adds the skirt's vertices and triangles. The new vertices follow the mesh's vertices, in the order of the
 * border. Each border edge gets two triangles, which run along it in the direction opposite to the sheet's
 * triangle:
 *
 *     first + i    o-------o    first + next
 *                  | \     |
 *                  |   \   |
 *     border[i]    o-------o    border[next] */
static void add(const struct rim *rim, struct cml_mesh *mesh, double level)
{
    const size_t first = mesh->num_vertices, n = rim->count;
    for (size_t i = 0; i < n; i++) {
        double step[2];
        step_out(rim, i, step);
        const double *p = vertex_of(rim, i);
        const double outer[3] = {p[0] + step[0], p[1] + step[1], level};
        memcpy(mesh->vertex[first + i], outer, sizeof outer);
    }
    for (size_t i = 0; i < n; i++) {
        const size_t next = (i + 1) % n;
        cml_mesh_add_triangle(mesh, mesh->border[next], mesh->border[i], first + i);
        cml_mesh_add_triangle(mesh, mesh->border[next], first + i, first + next);
    }
    mesh->num_vertices += n;
    for (size_t i = 0; i < n; i++) mesh->border[i] = (uint32_t)(first + i);
    mesh->z_border = level;
}

/* Enlarges the mesh's arrays by `more` vertices and twice as many triangles. Returns false if memory runs
 * out. */
static bool make_room(struct cml_mesh_work *work, size_t more)
{
    struct cml_mesh *mesh = work->mesh;
    const size_t vertices = mesh->num_vertices + more, triangles = mesh->num_triangles + 2 * more;
    void *vertex = realloc(mesh->vertex, vertices * sizeof *mesh->vertex);
    if (vertex) mesh->vertex = vertex;
    void *triangle = realloc(mesh->triangle, triangles * sizeof *mesh->triangle);
    if (triangle) mesh->triangle = triangle;
    return vertex && triangle;
}

/* Refuses a skirt with a face without area, on which later steps could not rely. */
static cml_status check_faces(const struct cml_mesh_work *work, struct cml_error *err)
{
    const struct cml_mesh *mesh = work->mesh;
    char place[112];
    for (size_t t = mesh->num_triangles - work->notes.skirt; t < mesh->num_triangles; t++)
        if (cml_mesh_is_degenerate(mesh, t))
            return cml_mesh_fail(work, 0, err,
                                 "the skirt has a face without area at %s (expected another skirt= or a "
                                 "smoother border)",
                                 cml_mesh_place(mesh->vertex[mesh->triangle[t][0]], place));
    return CML_OK;
}

cml_status cml_mesh_add_skirt(struct cml_mesh_work *work, struct cml_error *err)
{
    struct cml_mesh *mesh = work->mesh;
    const size_t n = mesh->num_border;
    CML_FREED double *along = malloc((n + 1) * sizeof *along);
    struct rim rim = {.mesh = mesh, .count = n, .along = along};
    if (!along || !make_room(work, n)) return cml_fail_memory(err, 56.0 * (double)n, "the skirt of a mesh");
    measure(&rim);
    const double level = mean_depth(&rim);
    for (size_t i = 0; i < n; i++)
        work->notes.skirt_rise = fmax(work->notes.skirt_rise, fabs(vertex_of(&rim, i)[2] - level));
    add(&rim, mesh, level);
    work->notes.skirt = 2 * n;
    return check_faces(work, err);
}
