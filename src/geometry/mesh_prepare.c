/* Makes a boundary mesh from loose triangles: runs the steps of mesh_parts.h in order.
 * SPDX-License-Identifier: MIT */
#include "geometry/mesh_parts.h"

#include <math.h>
#include <stdlib.h>

/* Computes the box of all vertices, each of which belongs to a triangle by now. */
static void find_box(struct cml_mesh *mesh)
{
    for (int k = 0; k < 3; k++) mesh->lower[k] = mesh->upper[k] = mesh->vertex[0][k];
    for (size_t i = 1; i < mesh->num_vertices; i++) {
        for (int k = 0; k < 3; k++) {
            mesh->lower[k] = fmin(mesh->lower[k], mesh->vertex[i][k]);
            mesh->upper[k] = fmax(mesh->upper[k], mesh->vertex[i][k]);
        }
    }
}

/* Runs the steps that need faces with common edges. */
static cml_status join_faces(struct cml_mesh_work *work, struct cml_error *err)
{
    CML_TRY(cml_mesh_orient(work, err));
    CML_TRY(cml_mesh_check_fans(work, err));
    return work->mesh->closed ? cml_mesh_turn_outwards(work, err) : cml_mesh_find_border(work, err);
}

/* Runs all steps. The order matters: each step relies on the refusals of the steps before it
 * (mesh_parts.h). */
static cml_status prepare_steps(struct cml_mesh_work *work, struct cml_error *err)
{
    struct cml_mesh *mesh = work->mesh;
    CML_TRY(cml_mesh_clean(work, err));
    find_box(mesh);
    CML_TRY(cml_mesh_pair_edges(work, err));
    const size_t num_triangles = mesh->num_triangles;
    const cml_status status = join_faces(work, err);
    if (status != CML_OK) cml_mesh_tell_near_corners(work, num_triangles, err);
    CML_TRY(status);
    find_box(mesh); /* the border may have moved to its plane */
    return cml_mesh_find_normals(mesh, err);
}

/* Prepares a boundary mesh, step by step. Each step is a function of mesh_parts.h. */
cml_status cml_mesh_prepare(struct cml_mesh *mesh, const struct cml_mesh_source *source,
                            struct cml_mesh_notes *notes, struct cml_error *err)
{
    struct cml_mesh_work work = {.mesh = mesh, .source = source};
    free(mesh->border);
    free(mesh->vertex_normal);
    mesh->border = NULL;
    mesh->vertex_normal = NULL;
    free(mesh->part);
    free(mesh->part_start);
    mesh->part = mesh->part_start = NULL;
    mesh->num_parts = 0;
    const cml_status status = prepare_steps(&work, err);
    free(work.origin);
    free(work.opposite);
    free(work.turned);
    if (notes) *notes = work.notes;
    return status;
}
