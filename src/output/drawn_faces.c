/* Drawings of surfaces in .vtp files: points and corners of the facets of boundaries (surface_facets.h) and
 * of bodies. Knows no quantity; report_fields.c makes the values of these facets. SPDX-License-Identifier:
 * MIT */
#include "output/report_parts.h"

#include "base/constants.h"
#include "geometry/vec3.h"
#include "scene/body/body_shape.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Allocates the points and corners of a boundary's drawn faces; their numbers are already set. */
static cml_status allocate_faces(struct cml_faces *faces, struct cml_error *err)
{
    static const char what[] = "the faces of a boundary";
    const size_t corners = faces->num_faces * (size_t)faces->corners;
    CML_TRY(cml_zeros(&faces->point, faces->num_points, sizeof *faces->point, what, err));
    return cml_zeros(&faces->corner, corners, sizeof *faces->corner, what, err);
}

/* Makes the faces of a mesh in the scene's coordinates. The mesh in memory is about its own middle, with
 * heights relative to the boundary's depth. A tile shows one period. */
static cml_status mesh_faces(const struct cml_surface_def *def, struct cml_faces *faces,
                             struct cml_error *err)
{
    double middle[3];
    const struct cml_mesh *mesh = cml_mesh_surface_mesh(def->mesh, middle);
    *faces = (struct cml_faces){
        .num_points = mesh->num_vertices, .num_faces = (size_t)def->primitives, .corners = 3};
    CML_TRY(allocate_faces(faces, err));
    for (size_t i = 0; i < mesh->num_vertices; i++)
        for (int k = 0; k < 3; k++)
            faces->point[i][k] = mesh->vertex[i][k] + middle[k] + (k == 2 ? def->depth : 0);
    for (size_t i = 0; i < faces->num_faces; i++)
        memcpy(faces->corner + 3 * i, mesh->triangle[cml_mesh_surface_triangle(def->mesh, i)],
               sizeof *mesh->triangle);
    return CML_OK;
}

/* Returns the number of quadrangles that a ring is drawn with: enough to look round, fewer where there are
 * very many rings. Those of the innermost ring have two corners at the tip. */
static size_t segments_of(size_t rings)
{
    return rings < 50000 ? 64 : 8;
}

/* Makes the faces by which a picture (.vtp) shows a radial heightfield: ring i lies between points i and i +
 * 1 of the profile, and becomes n quadrangles around the axis. */
static cml_status ring_faces(const struct cml_surface_def *def, struct cml_faces *faces,
                             struct cml_error *err)
{
    const size_t rings = (size_t)def->num_rings - 1, n = segments_of(rings);
    *faces = (struct cml_faces){.num_points = (rings + 1) * n, .num_faces = rings * n, .corners = 4};
    CML_TRY(allocate_faces(faces, err));
    for (size_t i = 0; i <= rings; i++)
        for (size_t k = 0; k < n; k++) {
            const double angle = 2 * CML_PI * (double)k / (double)n;
            faces->point[i * n + k][0] = def->r[i] * cos(angle);
            faces->point[i * n + k][1] = def->r[i] * sin(angle);
            faces->point[i * n + k][2] = def->depth + def->z[i];
        }
    for (size_t i = 0; i < rings; i++)
        for (size_t k = 0; k < n; k++) {
            const size_t next = (k + 1) % n;
            uint32_t *corner = faces->corner + 4 * (i * n + k);
            corner[0] = (uint32_t)(i * n + k);
            corner[1] = (uint32_t)(i * n + next);
            corner[2] = (uint32_t)((i + 1) * n + next);
            corner[3] = (uint32_t)((i + 1) * n + k);
        }
    return CML_OK;
}

/* The surface must not be a plane: facets of planes are pixels, which an image shows. */
cml_status cml_drawn_faces_of_boundary(const struct cml_surface_def *def, struct cml_faces *faces,
                                       size_t *per_facet, struct cml_error *err)
{
    const bool mesh = def->kind == CML_SURFACE_MESH;
    *per_facet = mesh ? 1 : segments_of((size_t)def->num_rings - 1);
    return mesh ? mesh_faces(def, faces, err) : ring_faces(def, faces, err);
}

/* ---- bodies: all are drawn as triangles in one file ---- */

/* Returns the segments around a body, enough for a sphere to look round; fewer above 100 bodies. */
static int segments_of_body(enum cml_body_form form, int bodies)
{
    const bool many = bodies > 100;
    return form == CML_BODY_SPHERE ? (many ? 3 : 12) : (many ? 16 : 64);
}

/* Returns the mesh of body k in the scene's coordinates; the caller clears it. */
static cml_status mesh_of(const struct cml_report *report, int k, struct cml_mesh *mesh,
                          struct cml_error *err)
{
    const struct cml_scene_body *body = &report->scene->bodies[k];
    const struct cml_body_surface *surface = &report->surfaces->bodies.item[k];
    double middle[3];
    if (!surface->mesh)
        return cml_body_mesh(body, segments_of_body(body->form, report->scene->num_bodies), false, mesh, err);
    CML_TRY(cml_mesh_copy(cml_mesh_surface_mesh(surface->mesh, middle), mesh, err));
    for (size_t i = 0; i < mesh->num_vertices; i++)
        for (int axis = 0; axis < 3; axis++)
            mesh->vertex[i][axis] += middle[axis] + (axis == 2 ? surface->depth : 0);
    return CML_OK;
}

/* Returns the part of a cylinder that a triangle of its mesh stands for: 0 the side, 1 the first end, 2 the
 * other. */
static size_t part_of_cylinder(const struct cml_scene_body *body, const struct cml_mesh *mesh,
                               size_t triangle)
{
    const struct cml_convex cylinder = cml_body_convex(body);
    const uint32_t *v = mesh->triangle[triangle];
    double normal[3], from[3];
    cml_vec3_area(mesh->vertex[v[0]], mesh->vertex[v[1]], mesh->vertex[v[2]], normal);
    cml_vec3_subtract(mesh->vertex[v[0]], cylinder.centre, from);
    if (fabs(cml_vec3_dot(normal, cylinder.axis)) < 0.5 * cml_vec3_length(normal)) return 0;
    return cml_vec3_dot(from, cylinder.axis) < 0.5 * cylinder.length ? 1 : 2;
}

/* Returns the facet, from 0 within body k, that a triangle of its drawing stands for. */
static size_t facet_of(const struct cml_report *report, int k, const struct cml_mesh *mesh, size_t triangle)
{
    if (report->surfaces->bodies.item[k].mesh) return triangle;
    const struct cml_scene_body *body = &report->scene->bodies[k];
    return body->form == CML_BODY_SPHERE ? 0 : part_of_cylinder(body, mesh, triangle);
}

/* Makes room for more points and triangles of bodies in the lists that grow body by body. On failure the old
 * lists stay valid, so the caller can free them. */
static cml_status grow(struct cml_body_faces *drawn, size_t points, size_t faces, struct cml_error *err)
{
    struct cml_faces *to = &drawn->faces;
    void *point = realloc(to->point, (to->num_points + points) * sizeof *to->point);
    if (point) to->point = point;
    void *corner = realloc(to->corner, 3 * (to->num_faces + faces) * sizeof *to->corner);
    if (corner) to->corner = corner;
    void *face = realloc(drawn->face, (to->num_faces + faces) * sizeof *drawn->face);
    if (face) drawn->face = face;
    if (point && corner && face) return CML_OK;
    return cml_fail_memory(err, (double)((to->num_faces + faces) * sizeof *drawn->face), "faces of bodies");
}

/* Appends the triangles of body k to the drawing of all bodies. Each drawn face remembers its body, the
 * scored facet that it belongs to, and the facet's area: a drawn sphere has many faces, but one facet. */
static cml_status add_body(const struct cml_report *report, int k, const struct cml_mesh *mesh,
                           struct cml_body_faces *drawn, struct cml_error *err)
{
    const struct cml_body_surface *body = &report->surfaces->bodies.item[k];
    struct cml_faces *to = &drawn->faces;
    CML_TRY(grow(drawn, mesh->num_vertices, mesh->num_triangles, err));
    for (size_t i = 0; i < mesh->num_triangles; i++) {
        const size_t facet = facet_of(report, k, mesh, i);
        drawn->face[to->num_faces + i] = (struct cml_body_face){
            k, body->first + facet, cml_body_facet_area(body, &report->scene->bodies[k], facet)};
        for (int corner = 0; corner < 3; corner++)
            to->corner[3 * (to->num_faces + i) + (size_t)corner] =
                (uint32_t)to->num_points + mesh->triangle[i][corner];
    }
    for (size_t i = 0; i < mesh->num_vertices; i++)
        cml_vec3_copy(mesh->vertex[i], to->point[to->num_points + i]);
    to->num_points += mesh->num_vertices;
    to->num_faces += mesh->num_triangles;
    return CML_OK;
}

cml_status cml_drawn_faces_of_bodies(const struct cml_report *report, struct cml_body_faces *drawn,
                                     struct cml_error *err)
{
    *drawn = (struct cml_body_faces){.faces.corners = 3};
    for (int k = 0; k < report->scene->num_bodies; k++) {
        CML_AT_END(cml_mesh_clear) struct cml_mesh mesh = {0};
        CML_TRY(mesh_of(report, k, &mesh, err));
        CML_TRY(add_body(report, k, &mesh, drawn, err));
    }
    return CML_OK;
}

void cml_drawn_faces_free(struct cml_body_faces *drawn)
{
    free(drawn->faces.point);
    free(drawn->faces.corner);
    free(drawn->face);
    *drawn = (struct cml_body_faces){0};
}
