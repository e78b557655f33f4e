/* SPDX-License-Identifier: MIT */
#include "scene/body/body_shape.h"

#include "base/constants.h"
#include "geometry/vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *cml_body_form_name(enum cml_body_form form)
{
    static const char *const names[] = {"mesh", "sphere", "cylinder"};
    return names[form];
}

struct cml_convex cml_body_convex(const struct cml_scene_body *body)
{
    struct cml_convex convex = {.form = CML_CONVEX_SPHERE, .radius = body->radius};
    cml_vec3_copy(body->centre, convex.centre);
    if (body->form == CML_BODY_SPHERE) return convex;
    convex.form = CML_CONVEX_CYLINDER;
    cml_vec3_subtract(body->end, body->centre, convex.axis);
    convex.length = cml_vec3_length(convex.axis);
    cml_vec3_normalise(convex.axis);
    return convex;
}

/* A disk of radius r across the body's axis reaches r sqrt(1 - axis_k^2) along coordinate k. The root is the
 * length of the axis' other two coordinates; so computed, it loses no digits for an axis along coordinate k.
 * */
void cml_body_box(const struct cml_scene_body *body, double lower[3], double upper[3])
{
    if (body->form == CML_BODY_MESH) {
        cml_vec3_copy(body->mesh.lower, lower);
        cml_vec3_copy(body->mesh.upper, upper);
        return;
    }
    const struct cml_convex convex = cml_body_convex(body);
    for (int k = 0; k < 3; k++) {
        const bool round = body->form == CML_BODY_SPHERE;
        const double across = hypot(convex.axis[(k + 1) % 3], convex.axis[(k + 2) % 3]);
        const double reach = round ? body->radius : body->radius * across;
        const double end = round ? body->centre[k] : body->end[k];
        lower[k] = fmin(body->centre[k], end) - reach;
        upper[k] = fmax(body->centre[k], end) + reach;
    }
}

void cml_body_point(const struct cml_scene_body *body, double point[3])
{
    cml_vec3_copy(body->form == CML_BODY_MESH ? body->mesh.vertex[0] : body->centre, point);
    if (body->form == CML_BODY_SPHERE) point[0] += body->radius;
}

/* The volume of a mesh is the sum of signed tetrahedra from vertex 0 to each facet. */
double cml_body_volume(const struct cml_scene_body *body)
{
    const double r = body->radius;
    double volume = 0;
    if (body->form == CML_BODY_SPHERE) return 4 * CML_PI / 3 * r * r * r;
    if (body->form == CML_BODY_CYLINDER) return CML_PI * r * r * cml_body_convex(body).length;
    for (size_t t = 0; t < body->mesh.num_triangles; t++) {
        double corner[3][3], normal[3];
        for (int k = 0; k < 3; k++)
            cml_vec3_subtract(body->mesh.vertex[body->mesh.triangle[t][k]], body->mesh.vertex[0], corner[k]);
        cml_vec3_cross(corner[1], corner[2], normal);
        volume += cml_vec3_dot(corner[0], normal) / 6;
    }
    return volume;
}

/* Gives the 12 corners and 20 faces of an icosahedron on the unit sphere, from which spheres are meshed. g:
 * the golden ratio, of which the corners consist. */
static void icosahedron(double corner[12][3], uint32_t face[20][3])
{
    const double g = (1 + sqrt(5)) / 2, size = sqrt(1 + g * g);
    size_t corners = 0, faces = 0;
    for (int axis = 0; axis < 3; axis++)
        for (int sign = 0; sign < 4; sign++) {
            corner[corners][axis] = 0;
            corner[corners][(axis + 1) % 3] = (sign & 1 ? -1 : 1) / size;
            corner[corners++][(axis + 2) % 3] = (sign & 2 ? -g : g) / size;
        }
    for (uint32_t a = 0; a < 12; a++)
        for (uint32_t b = a + 1; b < 12; b++)
            for (uint32_t c = b + 1; c < 12; c++) {
                /* A face joins three neighbouring corners. The directions of two neighbours have a cosine of
                 * 1 / sqrt(5), about 0.45; those of two other corners have -1 / sqrt(5) or -1. */
                const double least = 0.4;
                if (cml_vec3_dot(corner[a], corner[b]) < least ||
                    cml_vec3_dot(corner[b], corner[c]) < least || cml_vec3_dot(corner[a], corner[c]) < least)
                    continue;
                memcpy(face[faces++], (uint32_t[3]){a, b, c}, sizeof face[0]);
            }
}

/* Places a vertex of a face: i parts away from the face's first corner, j parts towards the third corner.
 * Sums run in the order of the corners' numbers, which rise in every face. Faces that share an edge therefore
 * compute the same bits on it. */
static void place_on_face(const double corner[12][3], const uint32_t face[3], int n, int i, int j,
                          const struct cml_scene_body *body, double out[3])
{
    const double weight[3] = {n - i, i - j, j};
    double direction[3];
    for (int k = 0; k < 3; k++)
        direction[k] =
            weight[0] * corner[face[0]][k] + weight[1] * corner[face[1]][k] + weight[2] * corner[face[2]][k];
    cml_vec3_normalise(direction);
    cml_vec3_add_scaled(body->centre, body->radius, direction, out);
}

/* Makes the mesh of a sphere. Each face makes the vertices on its edges anew, with the same bits, so that
 * cml_mesh_prepare joins them. */
static cml_status make_sphere(const struct cml_scene_body *body, int n, struct cml_mesh *mesh,
                              struct cml_error *err)
{
    double corner[12][3];
    uint32_t face[20][3];
    const size_t per_face = ((size_t)n + 1) * ((size_t)n + 2) / 2;
    icosahedron(corner, face);
    CML_TRY(cml_mesh_allocate(mesh, 20 * per_face, 20 * (size_t)n * (size_t)n, "the mesh of a body", err));
    for (int f = 0; f < 20; f++)
        for (int i = 0; i <= n; i++)
            for (int j = 0; j <= i; j++) {
                const size_t here = mesh->num_vertices++, above = here - (size_t)i;
                place_on_face((const double(*)[3])corner, face[f], n, i, j, body, mesh->vertex[here]);
                if (j > 0) cml_mesh_add_triangle(mesh, here, here - 1, above - 1);
                if (j > 0 && j < i) cml_mesh_add_triangle(mesh, here, above - 1, above);
            }
    return CML_OK;
}

/* Makes the prism of a cylinder. Vertices: both rims, then the middles of both ends. Triangles: the side,
 * then the ends. */
static cml_status make_cylinder(const struct cml_scene_body *body, int n, double radius,
                                struct cml_mesh *mesh, struct cml_error *err)
{
    const struct cml_convex convex = cml_body_convex(body);
    const size_t count = (size_t)n;
    double e1[3], e2[3];
    cml_vec3_frame(convex.axis, e1, e2);
    CML_TRY(cml_mesh_allocate(mesh, 2 * count + 2, 4 * count, "the mesh of a body", err));
    for (size_t i = 0; i < 2 * count; i++) {
        const double t = 2 * CML_PI * (double)(i % count) / n;
        double *v = mesh->vertex[i];
        cml_vec3_add_scaled(i < count ? body->centre : body->end, radius * cos(t), e1, v);
        cml_vec3_add_scaled(v, radius * sin(t), e2, v);
    }
    cml_vec3_copy(body->centre, mesh->vertex[2 * count]);
    cml_vec3_copy(body->end, mesh->vertex[2 * count + 1]);
    mesh->num_vertices = 2 * count + 2;
    for (size_t i = 0; i < count; i++) {
        const size_t next = (i + 1) % count;
        cml_mesh_add_triangle(mesh, i, next, count + i);
        cml_mesh_add_triangle(mesh, next, count + next, count + i);
    }
    for (size_t i = 0; i < count; i++) {
        const size_t next = (i + 1) % count;
        cml_mesh_add_triangle(mesh, i, 2 * count, next);
        cml_mesh_add_triangle(mesh, count + i, count + next, 2 * count + 1);
    }
    return CML_OK;
}

/* Scales the mesh of a body about the body's centre until it has the volume of the exact body, which a mesh
 * inside would not have. */
static void scale_to_volume(const struct cml_scene_body *body, struct cml_mesh *mesh)
{
    const struct cml_scene_body made = {.form = CML_BODY_MESH, .mesh = *mesh};
    const double factor = cbrt(cml_body_volume(body) / fabs(cml_body_volume(&made)));
    for (size_t i = 0; i < mesh->num_vertices; i++) {
        double d[3];
        cml_vec3_subtract(mesh->vertex[i], body->centre, d);
        cml_vec3_add_scaled(body->centre, factor, d, mesh->vertex[i]);
    }
}

/* On a sphere the middle of a face lies deepest, by at most 0.35 / n^2 of the radius below its corners (the
 * largest faces). On a cylinder the middle of a side does, by pi^2 / (2 n^2). Scaling to the body's volume
 * reduces both. */
int cml_body_segments(enum cml_body_form form, double tolerance)
{
    const double least = 3, most = 1000;
    const double n = form == CML_BODY_SPHERE ? sqrt(0.35 / tolerance) : CML_PI / sqrt(2 * tolerance);
    return (int)fmin(most, fmax(least, ceil(n)));
}

cml_status cml_body_mesh(const struct cml_scene_body *body, int n, bool around, struct cml_mesh *mesh,
                         struct cml_error *err)
{
    const double angle = 2 * CML_PI / n, r = body->radius;
    if (body->form == CML_BODY_MESH) return cml_mesh_copy(&body->mesh, mesh, err);
    *mesh = (struct cml_mesh){.closed = true};
    if (body->form == CML_BODY_SPHERE) {
        CML_TRY(make_sphere(body, n, mesh, err));
    } else {
        CML_TRY(
            make_cylinder(body, n, around ? r / cos(angle / 2) : r * sqrt(angle / sin(angle)), mesh, err));
    }
    cml_status status = cml_mesh_prepare(mesh, NULL, NULL, err);
    if (status == CML_OK && body->form == CML_BODY_SPHERE) {
        scale_to_volume(body, mesh);
        status = cml_mesh_prepare(mesh, NULL, NULL, err);
    }
    if (status != CML_OK) cml_mesh_clear(mesh);
    return status;
}
