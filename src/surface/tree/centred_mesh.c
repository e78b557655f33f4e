/* Centres a mesh and computes its planes and bounds of rounding. SPDX-License-Identifier: MIT */
#include "surface/tree/centred_mesh.h"

#include "geometry/vec3.h"
#include "surface/tree/rounding.h"

#include <math.h>
#include <stdlib.h>

/* Returns the bound err_line (rounding.h), cm, for a packet at a mesh whose coordinates are floats. A small
 * body deep in its layer has an err_line larger than the rounding of float inside the body's box. Depths at a
 * sheet are measured from the sheet, so err_line of a sheet is not raised. */
static double err_line_in_float(const double centre[3], double diagonal)
{
    const double size = fabs(centre[0]) + fabs(centre[1]) + fabs(centre[2]) + diagonal;
    return err_line_factor * 4 * FLT_EPSILON * size;
}

/* Moves the mesh to the centred frame, in double. Coordinates of a scene may be far larger than the mesh;
 * rounded to float, they could be off by as much as a metre is. After the subtraction they round like the
 * mesh's own size. */
static void centre_mesh(struct cml_centred_mesh *centred, double x0, double y0)
{
    struct cml_mesh *mesh = &centred->mesh;
    double middle[3], diagonal = 0;
    for (int k = 0; k < 3; k++) {
        middle[k] = 0.5 * (mesh->lower[k] + mesh->upper[k]);
        diagonal = hypot(diagonal, mesh->upper[k] - mesh->lower[k]);
    }
    for (size_t i = 0; i < mesh->num_vertices; i++)
        for (int k = 0; k < 3; k++) mesh->vertex[i][k] -= middle[k];
    mesh->z_border -= middle[2];
    centred->centre[0] = middle[0] - x0;
    centred->centre[1] = middle[1] - y0;
    centred->centre[2] = middle[2];
    centred->err_float = centred->err_margin = err_share_float * diagonal;
    if (mesh->closed) centred->err_float += err_line_in_float(centred->centre, diagonal);
    centred->err_mesh = err_share_mesh * diagonal;
    for (int k = 0; k < 3; k++) {
        mesh->lower[k] -= middle[k];
        mesh->upper[k] -= middle[k];
        centred->lower[k] = mesh->lower[k] - 2 * centred->err_float;
        centred->upper[k] = mesh->upper[k] + 2 * centred->err_float;
    }
    centred->axis[0] = -middle[0];
    centred->axis[1] = -middle[1];
}

/* Computes the plane of each facet. The vertices determine it, but a stored plane is 32 bytes in one cache
 * line, while three vertices may lie anywhere in memory. */
static cml_status find_planes(struct cml_centred_mesh *centred, struct cml_error *err)
{
    const struct cml_mesh *mesh = &centred->mesh;
    centred->plane = malloc((mesh->num_triangles + 1) * sizeof *centred->plane);
    if (!centred->plane)
        return cml_fail_memory(err, (double)(mesh->num_triangles * sizeof *centred->plane), "facet planes");
    for (size_t i = 0; i < mesh->num_triangles; i++) {
        const double *a = cml_centred_corner(centred, (int)i, 0), *b = cml_centred_corner(centred, (int)i, 1),
                     *c = cml_centred_corner(centred, (int)i, 2);
        double *normal = centred->plane[i];
        cml_vec3_area(a, b, c, normal);
        cml_vec3_normalise(normal);
        normal[3] = cml_vec3_dot(normal, a);
    }
    return CML_OK;
}

cml_status cml_centred_mesh_create(struct cml_mesh *mesh, double x0, double y0,
                                   struct cml_centred_mesh *centred, struct cml_error *err)
{
    *centred = (struct cml_centred_mesh){.mesh = *mesh};
    *mesh = (struct cml_mesh){0};
    centre_mesh(centred, x0, y0);
    CML_TRY(find_planes(centred, err));
    if (centred->mesh.closed) return CML_OK;
    return cml_footprint_create(&centred->mesh, &centred->footprint, err);
}

void cml_centred_mesh_clear(struct cml_centred_mesh *centred)
{
    free(centred->plane);
    cml_footprint_free(centred->footprint);
    cml_mesh_clear(&centred->mesh);
    *centred = (struct cml_centred_mesh){0};
}

double cml_centred_mesh_bytes(const struct cml_centred_mesh *centred)
{
    const struct cml_mesh *mesh = &centred->mesh;
    return (double)mesh->num_triangles * (sizeof *mesh->triangle + sizeof *centred->plane) +
           (double)mesh->num_vertices * (sizeof *mesh->vertex + sizeof *mesh->vertex_normal);
}
