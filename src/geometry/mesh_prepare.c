/* Makes a boundary mesh from loose triangles: runs the steps of mesh_parts.h in order.
 * SPDX-License-Identifier: MIT */
#include "geometry/mesh_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

/* Runs all steps. The order matters: each step relies on the refusals of the steps before it
 * (mesh_parts.h). */
static cml_status run_steps(struct cml_mesh_work *work, struct cml_error *err)
{
    struct cml_mesh *mesh = work->mesh;
    CML_TRY(cml_mesh_clean(work, err));
    find_box(mesh);
    CML_TRY(cml_mesh_pair_edges(work, err));
    work->num_paired = mesh->num_triangles;
    CML_TRY(cml_mesh_orient(work, err));
    CML_TRY(cml_mesh_check_fans(work, err));
    CML_TRY(mesh->closed ? cml_mesh_turn_outwards(work, err) : cml_mesh_find_border(work, err));
    find_box(mesh); /* the border may have moved to its plane */
    return cml_mesh_find_normals(mesh, err);
}

static void free_work(struct cml_mesh_work *work)
{
    free(work->origin);
    free(work->opposite);
    free(work->turned);
}

/* Prepares a copy of the mesh with another weld=. The edges must have been paired. */
static bool is_sound_with(const struct cml_mesh_work *work, double weld)
{
    const struct cml_mesh *mesh = work->mesh;
    struct cml_error err;
    CML_AT_END(cml_mesh_clear) struct cml_mesh copy = {0};
    CML_AT_END(free_work) struct cml_mesh_work again = {.mesh = &copy};
    if (cml_mesh_allocate(&copy, mesh->num_vertices, work->num_paired, "a mesh", &err) != CML_OK)
        return false;
    memcpy(copy.vertex, mesh->vertex, mesh->num_vertices * sizeof *copy.vertex);
    memcpy(copy.triangle, mesh->triangle, work->num_paired * sizeof *copy.triangle);
    copy.num_vertices = mesh->num_vertices;
    copy.num_triangles = work->num_paired;
    copy.normals = mesh->normals;
    copy.closed = mesh->closed;
    copy.unite = mesh->unite;
    copy.skirt = mesh->skirt > 0 ? mesh->skirt : cml_mesh_extent(mesh); /* the border need not be level */
    copy.weld = weld;
    return run_steps(&again, &err) == CML_OK;
}

cml_status cml_mesh_prepare(struct cml_mesh *mesh, const struct cml_mesh_source *source,
                            struct cml_mesh_notes *notes, struct cml_error *err)
{
    CML_AT_END(free_work) struct cml_mesh_work work = {.mesh = mesh, .source = source};
    free(mesh->border);
    free(mesh->vertex_normal);
    free(mesh->part);
    free(mesh->part_start);
    mesh->border = mesh->part = mesh->part_start = NULL;
    mesh->vertex_normal = NULL;
    mesh->num_parts = 0;
    const cml_status status = run_steps(&work, err);
    if (status != CML_OK) cml_mesh_tell_of_corners(&work, is_sound_with, err);
    if (notes) *notes = work.notes;
    return status;
}
