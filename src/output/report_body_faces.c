/* How bodies are drawn: all of them as triangles in one file. SPDX-License-Identifier: MIT */
#include "geometry/vec3.h"
#include "output/report_parts.h"
#include "scene/body/body_shape.h"

#include <math.h>
#include <stdlib.h>

/* So many that a sphere looks like one, fewer where there are very many bodies. */
static int segments_of(enum cml_body_form form, int bodies)
{
    const bool many = bodies > 100;
    return form == CML_BODY_SPHERE ? (many ? 3 : 12) : (many ? 16 : 64);
}

/* In scene coordinates; the caller clears it. */
static cml_status mesh_of(const struct cml_report *report, int k, struct cml_mesh *mesh,
                          struct cml_error *err)
{
    const struct cml_scene_body *body = &report->scene->bodies[k];
    const struct cml_body_surface *surface = &report->surfaces->bodies.item[k];
    double middle[3];
    if (!surface->mesh)
        return cml_body_mesh(body, segments_of(body->form, report->scene->num_bodies), false, mesh, err);
    CML_TRY(cml_mesh_copy(cml_mesh_surface_mesh(surface->mesh, middle), mesh, err));
    for (size_t i = 0; i < mesh->num_vertices; i++)
        for (int axis = 0; axis < 3; axis++)
            mesh->vertex[i][axis] += middle[axis] + (axis == 2 ? surface->depth : 0);
    return CML_OK;
}

/* Of a cylinder: 0 its side, 1 the first end, 2 the other. */
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

static size_t facet_of(const struct cml_report *report, int k, const struct cml_mesh *mesh, size_t triangle)
{
    if (report->surfaces->bodies.item[k].mesh) return triangle;
    const struct cml_scene_body *body = &report->scene->bodies[k];
    return body->form == CML_BODY_SPHERE ? 0 : part_of_cylinder(body, mesh, triangle);
}

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

/* first: of the body's facets among those of all. */
static cml_status add_body(const struct cml_report *report, int k, size_t first, const struct cml_mesh *mesh,
                           struct cml_body_faces *drawn, struct cml_error *err)
{
    struct cml_faces *to = &drawn->faces;
    CML_TRY(grow(drawn, mesh->num_vertices, mesh->num_triangles, err));
    for (size_t i = 0; i < mesh->num_triangles; i++) {
        const size_t facet = facet_of(report, k, mesh, i);
        drawn->face[to->num_faces + i] = (struct cml_body_face){
            k, first + facet,
            cml_body_facet_area(&report->surfaces->bodies.item[k], &report->scene->bodies[k], facet)};
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

cml_status cml_report_body_faces(const struct cml_report *report, struct cml_body_faces *drawn,
                                 struct cml_error *err)
{
    *drawn = (struct cml_body_faces){.faces.corners = 3};
    cml_status status = CML_OK;
    size_t first = 0;
    for (int k = 0; status == CML_OK && k < report->scene->num_bodies; k++) {
        struct cml_mesh mesh;
        status = mesh_of(report, k, &mesh, err);
        if (status != CML_OK) break;
        status = add_body(report, k, first, &mesh, drawn, err);
        first += report->surfaces->bodies.item[k].primitives;
        cml_mesh_clear(&mesh);
    }
    if (status != CML_OK) cml_report_body_faces_free(drawn);
    return status;
}

void cml_report_body_faces_free(struct cml_body_faces *drawn)
{
    free(drawn->faces.point);
    free(drawn->faces.corner);
    free(drawn->face);
    *drawn = (struct cml_body_faces){0};
}
