/* SPDX-License-Identifier: MIT */
#include "surface_facets.h"

#include "vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* The last ring of cones is the outer plane already. */
size_t cml_surface_facets(const struct cml_surface_def *def, const struct cml_map_def *map)
{
    if (def->kind == CML_SURFACE_PLANE) return map->nx > 0 ? (size_t)map->nx * (size_t)map->ny + 1 : 0;
    return (size_t)def->primitives + (def->kind == CML_SURFACE_MESH ? 1 : 0);
}

static double triangle_area(const struct cml_mesh *mesh, size_t i)
{
    const uint32_t *corner = mesh->triangle[i];
    double a[3], b[3], normal[3];
    cml_vec3_subtract(mesh->vertex[corner[1]], mesh->vertex[corner[0]], a);
    cml_vec3_subtract(mesh->vertex[corner[2]], mesh->vertex[corner[0]], b);
    cml_vec3_cross(a, b, normal);
    return 0.5 * sqrt(cml_vec3_dot(normal, normal));
}

double cml_surface_facet_area(const struct cml_surface_def *def, const struct cml_map_def *map, size_t facet)
{
    if (facet + 1 >= cml_surface_facets(def, map)) return INFINITY;
    double middle[3];
    if (def->kind == CML_SURFACE_PLANE) return map->dx * map->dy;
    if (def->kind == CML_SURFACE_MESH) return triangle_area(cml_mesh_surface_mesh(def->mesh, middle), facet);
    const double *r = def->r + facet, *z = def->z + facet;
    return pi * (r[0] + r[1]) * hypot(r[1] - r[0], z[1] - z[0]);
}

static cml_status allocate_faces(struct cml_faces *faces, struct cml_error *err)
{
    const size_t point_bytes = faces->num_points * sizeof *faces->point;
    const size_t corner_bytes = faces->num_faces * (size_t)faces->corners * sizeof *faces->corner;
    faces->point = malloc(point_bytes);
    faces->corner = malloc(corner_bytes);
    if (faces->point && faces->corner) return CML_OK;
    cml_surface_faces_free(faces);
    return cml_fail_memory(err, (double)(point_bytes + corner_bytes), "the faces of a boundary");
}

static cml_status mesh_faces(const struct cml_surface_def *def, struct cml_faces *faces,
                             struct cml_error *err)
{
    double middle[3];
    const struct cml_mesh *mesh = cml_mesh_surface_mesh(def->mesh, middle);
    *faces =
        (struct cml_faces){.num_points = mesh->num_vertices, .num_faces = mesh->num_triangles, .corners = 3};
    CML_TRY(allocate_faces(faces, err));
    for (size_t i = 0; i < mesh->num_vertices; i++)
        for (int k = 0; k < 3; k++)
            faces->point[i][k] = mesh->vertex[i][k] + middle[k] + (k == 2 ? def->depth : 0);
    memcpy(faces->corner, mesh->triangle, mesh->num_triangles * sizeof *mesh->triangle);
    return CML_OK;
}

/* Quadrangles round the axis; the innermost have two corners at the tip. So many that a circle looks like
 * one, fewer where there are very many rings. */
static size_t segments_of(size_t rings)
{
    return rings < 50000 ? 64 : 8;
}

static cml_status ring_faces(const struct cml_surface_def *def, struct cml_faces *faces,
                             struct cml_error *err)
{
    const size_t rings = (size_t)def->num_rings - 1, n = segments_of(rings);
    *faces = (struct cml_faces){.num_points = (rings + 1) * n, .num_faces = rings * n, .corners = 4};
    CML_TRY(allocate_faces(faces, err));
    for (size_t i = 0; i <= rings; i++)
        for (size_t k = 0; k < n; k++) {
            const double angle = 2 * pi * (double)k / (double)n;
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

cml_status cml_surface_faces(const struct cml_surface_def *def, struct cml_faces *faces, size_t *per_facet,
                             struct cml_error *err)
{
    const bool mesh = def->kind == CML_SURFACE_MESH;
    *per_facet = mesh ? 1 : segments_of((size_t)def->num_rings - 1);
    return mesh ? mesh_faces(def, faces, err) : ring_faces(def, faces, err);
}

void cml_surface_faces_free(struct cml_faces *faces)
{
    free(faces->point);
    free(faces->corner);
    *faces = (struct cml_faces){0};
}
