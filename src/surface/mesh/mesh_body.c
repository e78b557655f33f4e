/* SPDX-License-Identifier: MIT */
#include "surface/mesh/mesh_body.h"

#include "geometry/vec3.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

/* Vertices relative to the middle of the box; queries subtract it once, in double. */
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
    body->inflation = 1e-6 * diagonal;
    body->digits = 16 * DBL_EPSILON * diagonal;
    for (int k = 0; k < 3; k++) {
        mesh->lower[k] -= middle[k];
        mesh->upper[k] -= middle[k];
        body->lower[k] = mesh->lower[k] - 2 * body->inflation;
        body->upper[k] = mesh->upper[k] + 2 * body->inflation;
    }
    body->centre[0] = middle[0] - x0;
    body->centre[1] = middle[1] - y0;
    body->centre[2] = middle[2];
    body->axis[0] = -middle[0];
    body->axis[1] = -middle[1];
}

static void facet_normal(const struct cml_mesh *mesh, int primitive, double normal[3])
{
    const uint32_t *v = mesh->triangle[primitive];
    double ab[3], ac[3];
    cml_vec3_subtract(mesh->vertex[v[1]], mesh->vertex[v[0]], ab);
    cml_vec3_subtract(mesh->vertex[v[2]], mesh->vertex[v[0]], ac);
    cml_vec3_cross(ab, ac, normal);
}

/* Unit normals, up, and distances of all facets' planes: one cache line where a hit would fetch three
 * vertices. */
static cml_status find_planes(struct cml_mesh_body *body, struct cml_error *err)
{
    const struct cml_mesh *mesh = &body->mesh;
    body->plane = malloc((mesh->num_triangles + 1) * sizeof *body->plane);
    if (!body->plane)
        return cml_fail_memory(err, (double)(mesh->num_triangles * sizeof *body->plane), "facet planes");
    for (size_t i = 0; i < mesh->num_triangles; i++) {
        double normal[3];
        facet_normal(mesh, (int)i, normal);
        const double k = 1 / sqrt(cml_vec3_dot(normal, normal));
        for (int axis = 0; axis < 3; axis++) body->plane[i][axis] = k * normal[axis];
        body->plane[i][3] = cml_vec3_dot(body->plane[i], mesh->vertex[mesh->triangle[i][0]]);
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
    return cml_footprint_create(&body->mesh, &body->footprint, err);
}

void cml_mesh_body_clear(struct cml_mesh_body *body)
{
    free(body->plane);
    cml_footprint_free(body->footprint);
    cml_mesh_clear(&body->mesh);
    *body = (struct cml_mesh_body){0};
}
