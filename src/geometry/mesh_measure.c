/* Vertex normals and statistics of a mesh. SPDX-License-Identifier: MIT */
#include "geometry/mesh_parts.h"

#include "base/array.h"
#include "base/constants.h"
#include "geometry/vec3.h"

#include <math.h>
#include <stdlib.h>

/* Computes the area of triangle t as a vector that points up, twice as long as the area. */
static void area_vector(const struct cml_mesh *mesh, size_t t, double out[3])
{
    const uint32_t *corner = mesh->triangle[t];
    cml_vec3_area(mesh->vertex[corner[0]], mesh->vertex[corner[1]], mesh->vertex[corner[2]], out);
}

/* Returns the angle between u and v, rad. atan2 is used because the arc cosine loses half of the digits of
 * small angles. */
static double angle_between(const double u[3], const double v[3])
{
    double normal[3];
    cml_vec3_cross(u, v, normal);
    return atan2(cml_vec3_length(normal), cml_vec3_dot(u, v));
}

/* Adds triangle t's normal to its vertices, weighted by the angle at each corner. With these weights a vertex
 * normal does not depend on how a face is cut into triangles [G. Thuermer and C. A. Wuethrich, Computing
 * vertex normals from polygonal facets, J. Graphics Tools 3 (1998) 43]. They also put a point near a vertex
 * on the side that the normal says [J. A. Baerentzen and H. Aanaes, Signed distance computation using the
 * angle weighted pseudonormal, IEEE Trans. Vis. Comput. Graph. 11 (2005) 243]. */
static void add_triangle(struct cml_mesh *mesh, size_t t)
{
    const uint32_t *corner = mesh->triangle[t];
    double normal[3], u[3], v[3];
    area_vector(mesh, t, normal);
    const double size = cml_vec3_length(normal);
    if (!(size > 0)) return;
    for (int k = 0; k < 3; k++) {
        cml_vec3_subtract(mesh->vertex[corner[(k + 1) % 3]], mesh->vertex[corner[k]], u);
        cml_vec3_subtract(mesh->vertex[corner[(k + 2) % 3]], mesh->vertex[corner[k]], v);
        const double factor = angle_between(u, v) / size;
        for (int axis = 0; axis < 3; axis++) mesh->vertex_normal[corner[k]][axis] += factor * normal[axis];
    }
}

/* Adds the normal of the plane outside to the border's vertices, weighted by the angle that the plane fills
 * there. */
static void add_outer_plane(struct cml_mesh *mesh)
{
    const size_t n = mesh->num_border;
    for (size_t i = 0; i < n; i++) {
        const double *before = mesh->vertex[mesh->border[(i + n - 1) % n]];
        const double *here = mesh->vertex[mesh->border[i]];
        const double *after = mesh->vertex[mesh->border[(i + 1) % n]];
        const double u[2] = {here[0] - before[0], here[1] - before[1]};
        const double v[2] = {after[0] - here[0], after[1] - here[1]};
        const double turned = atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]);
        /* The loop runs in the negative sense, so a convex corner turns by a negative angle. */
        mesh->vertex_normal[mesh->border[i]][2] -= CML_PI - turned;
    }
}

cml_status cml_mesh_find_normals(struct cml_mesh *mesh, struct cml_error *err)
{
    mesh->vertex_normal = calloc(mesh->num_vertices, sizeof *mesh->vertex_normal);
    if (!mesh->vertex_normal)
        return cml_fail_memory(err, 24.0 * (double)mesh->num_vertices, "the normals of a mesh");
    for (size_t t = 0; t < mesh->num_triangles; t++) add_triangle(mesh, t);
    add_outer_plane(mesh);
    for (size_t i = 0; i < mesh->num_vertices; i++) {
        double *normal = mesh->vertex_normal[i];
        const double size = cml_vec3_length(normal);
        if (!(size > 0)) normal[2] = -1; /* the facets' normals cancel: any unit normal will do */
        for (int k = 0; k < 3 && size > 0; k++) normal[k] /= size;
    }
    return CML_OK;
}

/* Returns the distance between two vertices, cm. */
static double edge_length(const struct cml_mesh *mesh, uint32_t a, uint32_t b)
{
    double along[3];
    cml_vec3_subtract(mesh->vertex[b], mesh->vertex[a], along);
    return cml_vec3_length(along);
}

/* Lists the length of every edge once and returns their number. Inner edges occur in both directions, border
 * edges in one. */
static size_t list_lengths(const struct cml_mesh *mesh, double *lengths)
{
    size_t count = 0;
    for (uint32_t e = 0; e < 3 * mesh->num_triangles; e++) {
        const uint32_t a = cml_half_edge_from(mesh, e), b = cml_half_edge_to(mesh, e);
        if (a < b) lengths[count++] = edge_length(mesh, a, b);
    }
    for (size_t i = 0; i < mesh->num_border; i++) {
        const uint32_t a = mesh->border[i], b = mesh->border[(i + 1) % mesh->num_border];
        if (a > b) lengths[count++] = edge_length(mesh, a, b);
    }
    return count;
}

/* Finds the median and the smallest edge of a mesh. The median tells how fine a mesh is even if it has a few
 * triangles far longer than wide. */
static void summarise_edges(const struct cml_mesh *mesh, struct cml_mesh_summary *summary)
{
    CML_FREED double *lengths = malloc((3 * mesh->num_triangles + mesh->num_border) * sizeof *lengths);
    summary->edge_median = summary->edge_min = NAN;
    if (!lengths) return;
    const size_t count = list_lengths(mesh, lengths);
    qsort(lengths, count, sizeof *lengths, cml_compare_doubles);
    summary->edge_min = lengths[0];
    summary->edge_median = 0.5 * (lengths[(count - 1) / 2] + lengths[count / 2]);
}

/* Computes the means of z - reference, and of its square, over a triangle's projection: the mean of the
 * corners, and the mean of the products of all pairs of corners, equal pairs included. */
static void height_moments(const struct cml_mesh *mesh, size_t t, double reference, double moment[2])
{
    double z[3];
    for (int k = 0; k < 3; k++) z[k] = mesh->vertex[mesh->triangle[t][k]][2] - reference;
    moment[0] = (z[0] + z[1] + z[2]) / 3;
    moment[1] = (z[0] * (z[0] + z[1]) + z[1] * (z[1] + z[2]) + z[2] * (z[2] + z[0])) / 6;
}

/* Adds up four sums over the triangles, each triangle weighted by its projected area: sum[0] of 1, sum[1] of
 * z - reference, sum[2] of its square, sum[3] of the squared slope. Also raises summary->slope_max. A
 * vertical wall has no projected area, and makes sum[3] infinite. */
static void sum_heights(const struct cml_mesh *mesh, double reference, double sum[4],
                        struct cml_mesh_summary *summary)
{
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        double area[3], moment[2];
        area_vector(mesh, t, area);
        const double flat = fabs(area[2]), slope = hypot(area[0], area[1]) / flat;
        if (!(cml_vec3_length(area) > 0)) continue;
        height_moments(mesh, t, reference, moment);
        sum[0] += flat;
        sum[1] += flat * moment[0];
        sum[2] += flat * moment[1];
        sum[3] += flat > 0 ? flat * slope * slope : INFINITY;
        summary->slope_max = fmax(summary->slope_max, slope);
    }
}

/* Computes the statistics in two passes over the triangles, because squares about a distant reference would
 * lose the digits of a shallow relief. */
void cml_mesh_summarise(const struct cml_mesh *mesh, struct cml_mesh_summary *summary)
{
    *summary = (struct cml_mesh_summary){0};
    double sum[4] = {0}, centered[4] = {0};
    sum_heights(mesh, mesh->z_border, sum, summary);
    summary->z_mean = mesh->z_border + sum[1] / sum[0];
    summary->slope_rms = sqrt(sum[3] / sum[0]);
    sum_heights(mesh, summary->z_mean, centered, summary);
    summary->z_rms = sqrt(centered[2] / centered[0]);
    summary->peak_to_valley = mesh->upper[2] - mesh->lower[2];
    summarise_edges(mesh, summary);
}
