/* SPDX-License-Identifier: MIT */
#include "surface/mesh/mesh_body.h"

#include "geometry/vec3.h"
#include "surface/mesh/rounding.h"

#include <math.h>
#include <stdlib.h>

/* err_line of a packet at the mesh whose numbers are floats. A body may lie deep in its layer and be small:
 * then this is more than what float does inside its box. The depths of a sheet count from the sheet. */
static double err_line_in_float(const double centre[3], double diagonal)
{
    const double size = fabs(centre[0]) + fabs(centre[1]) + fabs(centre[2]) + diagonal;
    return err_line_factor * 4 * FLT_EPSILON * size;
}

/* Coordinates of a scene may be far larger than the mesh: their rounding to float would be that of a metre.
 * Subtracted once, in double, it is that of the mesh's own size. */
static void centre_mesh(struct cml_mesh_body *body, double x0, double y0)
{
    struct cml_mesh *mesh = &body->mesh;
    double middle[3], diagonal = 0;
    for (int k = 0; k < 3; k++) {
        middle[k] = 0.5 * (mesh->lower[k] + mesh->upper[k]);
        diagonal = hypot(diagonal, mesh->upper[k] - mesh->lower[k]);
    }
    for (size_t i = 0; i < mesh->num_vertices; i++)
        for (int k = 0; k < 3; k++) mesh->vertex[i][k] -= middle[k];
    mesh->z_border -= middle[2];
    body->centre[0] = middle[0] - x0;
    body->centre[1] = middle[1] - y0;
    body->centre[2] = middle[2];
    body->err_float = body->err_margin = err_share_float * diagonal;
    if (mesh->closed) body->err_float += err_line_in_float(body->centre, diagonal);
    body->err_mesh = err_share_mesh * diagonal;
    for (int k = 0; k < 3; k++) {
        mesh->lower[k] -= middle[k];
        mesh->upper[k] -= middle[k];
        body->lower[k] = mesh->lower[k] - 2 * body->err_float;
        body->upper[k] = mesh->upper[k] + 2 * body->err_float;
    }
    body->axis[0] = -middle[0];
    body->axis[1] = -middle[1];
}

/* Kept per facet although vertices tell them: 32 bytes in one cache line, where a hit would fetch three
 * vertices from anywhere. */
static cml_status find_planes(struct cml_mesh_body *body, struct cml_error *err)
{
    const struct cml_mesh *mesh = &body->mesh;
    body->plane = malloc((mesh->num_triangles + 1) * sizeof *body->plane);
    if (!body->plane)
        return cml_fail_memory(err, (double)(mesh->num_triangles * sizeof *body->plane), "facet planes");
    for (size_t i = 0; i < mesh->num_triangles; i++) {
        const double *a = cml_body_corner(body, (int)i, 0), *b = cml_body_corner(body, (int)i, 1),
                     *c = cml_body_corner(body, (int)i, 2);
        double *normal = body->plane[i];
        cml_vec3_area(a, b, c, normal);
        cml_vec3_normalise(normal);
        normal[3] = cml_vec3_dot(normal, a);
    }
    return CML_OK;
}

cml_status cml_mesh_body_create(struct cml_mesh *mesh, double x0, double y0, struct cml_mesh_body *body,
                                struct cml_error *err)
{
    *body = (struct cml_mesh_body){.mesh = *mesh};
    *mesh = (struct cml_mesh){0};
    centre_mesh(body, x0, y0);
    CML_TRY(find_planes(body, err));
    if (body->mesh.closed) return CML_OK;
    return cml_footprint_create(&body->mesh, &body->footprint, err);
}

void cml_mesh_body_clear(struct cml_mesh_body *body)
{
    free(body->plane);
    if (body->footprint) cml_footprint_free(body->footprint);
    cml_mesh_clear(&body->mesh);
    *body = (struct cml_mesh_body){0};
}

double cml_mesh_body_bytes(const struct cml_mesh_body *body)
{
    const struct cml_mesh *mesh = &body->mesh;
    return (double)mesh->num_triangles * (sizeof *mesh->triangle + sizeof *body->plane) +
           (double)mesh->num_vertices * (sizeof *mesh->vertex + sizeof *mesh->vertex_normal);
}
