/* SPDX-License-Identifier: MIT */
#include "output/report_faces.h"

#include "base/constants.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static cml_status allocate_faces(struct cml_faces *faces, struct cml_error *err)
{
    const size_t point_bytes = faces->num_points * sizeof *faces->point;
    const size_t corner_bytes = faces->num_faces * (size_t)faces->corners * sizeof *faces->corner;
    faces->point = malloc(point_bytes);
    faces->corner = malloc(corner_bytes);
    if (faces->point && faces->corner) return CML_OK;
    free(faces->point);
    free(faces->corner);
    *faces = (struct cml_faces){0};
    return cml_fail_memory(err, (double)(point_bytes + corner_bytes), "the faces of a boundary");
}

/* The mesh in memory lies about its own middle, heights relative to the boundary's depth; a picture wants
 * the scene's coordinates. Of a tile one period is shown. */
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

/* Quadrangles round the axis; the innermost have two corners at the tip. So many that a circle looks like
 * one, fewer where there are very many rings. */
static size_t segments_of(size_t rings)
{
    return rings < 50000 ? 64 : 8;
}

/* Ring i lies between points i and i + 1 of the heightfield, and becomes n quadrangles. */
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

/* The caller asks for no planes: their facets are pixels, which an image shows. */
cml_status cml_report_faces(const struct cml_surface_def *def, struct cml_faces *faces, size_t *per_facet,
                            struct cml_error *err)
{
    const bool mesh = def->kind == CML_SURFACE_MESH;
    *per_facet = mesh ? 1 : segments_of((size_t)def->num_rings - 1);
    return mesh ? mesh_faces(def, faces, err) : ring_faces(def, faces, err);
}
