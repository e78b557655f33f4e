/* Memory of meshes, and messages about them. SPDX-License-Identifier: MIT */
#include "geometry/mesh_parts.h"

#include "base/array.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void cml_mesh_clear(struct cml_mesh *mesh)
{
    free(mesh->vertex);
    free(mesh->triangle);
    free(mesh->border);
    free(mesh->vertex_normal);
    free(mesh->slope);
    free(mesh->part);
    free(mesh->part_start);
    *mesh = (struct cml_mesh){0};
}

cml_status cml_mesh_allocate(struct cml_mesh *mesh, size_t vertices, size_t triangles, const char *what,
                             struct cml_error *err)
{
    mesh->vertex = malloc(vertices * sizeof *mesh->vertex);
    mesh->triangle = malloc(triangles * sizeof *mesh->triangle);
    if (mesh->vertex && mesh->triangle) return CML_OK;
    cml_mesh_clear(mesh);
    return cml_fail_memory(err, 24.0 * (double)vertices + 12.0 * (double)triangles, what);
}

void cml_mesh_add_triangle(struct cml_mesh *mesh, size_t a, size_t b, size_t c)
{
    const uint32_t corner[3] = {(uint32_t)a, (uint32_t)b, (uint32_t)c};
    memcpy(mesh->triangle[mesh->num_triangles++], corner, sizeof corner);
}

cml_status cml_mesh_copy(const struct cml_mesh *from, struct cml_mesh *to, struct cml_error *err)
{
    bool failed = false;
    *to = *from;
    to->vertex = cml_array_copy(from->vertex, from->num_vertices, sizeof *from->vertex, &failed);
    to->triangle = cml_array_copy(from->triangle, from->num_triangles, sizeof *from->triangle, &failed);
    to->border = cml_array_copy(from->border, from->num_border, sizeof *from->border, &failed);
    to->vertex_normal =
        cml_array_copy(from->vertex_normal, from->num_vertices, sizeof *from->vertex, &failed);
    to->slope = cml_array_copy(from->slope, from->num_triangles, sizeof *from->slope, &failed);
    to->part = cml_array_copy(from->part, from->num_triangles, sizeof *from->part, &failed);
    to->part_start = cml_array_copy(from->part_start, from->num_parts, sizeof *from->part_start, &failed);
    if (!failed) return CML_OK;
    cml_mesh_clear(to);
    return cml_fail_memory(err, 48.0 * (double)from->num_vertices + 16.0 * (double)from->num_triangles,
                           "a copy of a mesh");
}

/* The message also tells how many faces of zero area were dropped, because they can be the cause. */
cml_status cml_mesh_fail(const struct cml_mesh_work *work, int line, struct cml_error *err,
                         const char *format, ...)
{
    char message[640], where[32] = "";
    va_list args;
    va_start(args, format);
    vsnprintf(message, sizeof message, format, args);
    va_end(args);
    const size_t length = strlen(message);
    if (work->notes.degenerate > 0) /* a dropped sliver that joined two faces leaves a slit in the mesh */
        snprintf(message + length, sizeof message - length, "; %zu faces of zero area were dropped",
                 work->notes.degenerate);
    if (!work->source || !work->source->path) return cml_fail(err, CML_E_INPUT, "%s", message);
    if (line > 0) snprintf(where, sizeof where, ":%d", line);
    return cml_fail(err, CML_E_INPUT, "%s%s: %s", work->source->path, where, message);
}

/* work->origin leads back to the file's numbering, as triangles may have been dropped since. */
int cml_mesh_triangle_line(const struct cml_mesh_work *work, size_t t)
{
    if (!work->source || !work->source->triangle_line) return 0;
    return work->source->triangle_line[work->origin ? work->origin[t] : t];
}

/* A mesh file has heights instead of depths. Computes 0.0 - z, because -z would print a height of zero as -0.
 * */
const char *cml_mesh_place(const double position[3], char text[112])
{
    snprintf(text, 112, "(%.6g, %.6g, height %.6g) cm", position[0], position[1], 0.0 - position[2]);
    return text;
}

bool cml_mesh_is_flat(const struct cml_mesh *mesh, double *z)
{
    for (size_t i = 1; i < mesh->num_vertices; i++)
        if (mesh->vertex[i][2] != mesh->vertex[0][2]) return false;
    *z = mesh->vertex[0][2];
    return true;
}
