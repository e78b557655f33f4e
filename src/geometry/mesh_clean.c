/* Turns loose vertices and triangles into a clean indexed mesh: joins equal vertices and drops triangles
 * without area and unused vertices. SPDX-License-Identifier: MIT */
#include "geometry/mesh_parts.h"
#include "geometry/vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define EMPTY UINT32_MAX
#define LARGEST 1e30 /* cm; the limit of all lengths in .mci files */

/* Refuses coordinates so large that a product of three lengths could overflow, which exact predicates rely
 * on, too (predicate.h). */
static cml_status check_vertices(const struct cml_mesh_work *work, struct cml_error *err)
{
    const struct cml_mesh *mesh = work->mesh;
    for (size_t i = 0; i < mesh->num_vertices; i++) {
        const double *p = mesh->vertex[i];
        if (fabs(p[0]) <= LARGEST && fabs(p[1]) <= LARGEST && fabs(p[2]) <= LARGEST) continue;
        const int line = work->source && work->source->vertex_line ? work->source->vertex_line[i] : 0;
        return cml_mesh_fail(work, line, err, "vertex %zu is too large (expected coordinates up to %g cm)",
                             i + 1, LARGEST);
    }
    return CML_OK;
}

/* Refuses invalid vertex numbers and more than 2^30 triangles: half-edges are numbered in 32 bits, which hold
 * 3 * 2^30. */
static cml_status check_triangles(const struct cml_mesh_work *work, struct cml_error *err)
{
    const struct cml_mesh *mesh = work->mesh;
    if (mesh->num_triangles == 0) return cml_mesh_fail(work, 0, err, "the mesh has no faces");
    if (mesh->num_triangles > (size_t)1 << 30 || mesh->num_vertices >= EMPTY)
        return cml_mesh_fail(work, 0, err, "the mesh has %zu triangles (expected at most 2^30)",
                             mesh->num_triangles);
    for (size_t t = 0; t < mesh->num_triangles; t++)
        for (int k = 0; k < 3; k++)
            if (mesh->triangle[t][k] >= mesh->num_vertices)
                return cml_mesh_fail(work, cml_mesh_triangle_line(work, t), err,
                                     "a face uses vertex %.0f (expected 1 to %zu)",
                                     (double)mesh->triangle[t][k] + 1, mesh->num_vertices);
    return CML_OK;
}

/* Sets same[i] to the first vertex that is equal to vertex i, and returns the number of vertices that repeat
 * an earlier one. The hash table has open addressing, linear probing and at least twice as many slots as
 * vertices, so that the time is linear. */
static size_t find_equal(const struct cml_mesh *mesh, uint32_t *table, size_t mask, uint32_t *same)
{
    size_t welded = 0;
    for (size_t i = 0; i < mesh->num_vertices; i++) {
        const double *p = mesh->vertex[i];
        size_t slot = cml_mesh_hash(p) & mask;
        while (table[slot] != EMPTY && memcmp(mesh->vertex[table[slot]], p, sizeof mesh->vertex[0]) != 0)
            slot = (slot + 1) & mask;
        if (table[slot] == EMPTY) table[slot] = (uint32_t)i;
        same[i] = table[slot];
        welded += same[i] != i;
    }
    return welded;
}

/* Returns the first vertex of the group to which vertex i belongs. Shortens the way for the next search. */
static uint32_t first_of(uint32_t *same, uint32_t i)
{
    while (same[i] != i) i = same[i] = same[same[i]];
    return i;
}

struct groups {
    uint32_t *same; /* [num_vertices] an earlier vertex of the group, or the vertex itself */
    size_t joined;
};

/* Joins the groups of two vertices; the first vertex of both stays. */
static void join_groups(void *context, uint32_t vertex, uint32_t other, double distance)
{
    struct groups *groups = context;
    const uint32_t a = first_of(groups->same, vertex), b = first_of(groups->same, other);
    (void)distance;
    groups->joined += a != b;
    groups->same[a > b ? a : b] = a < b ? a : b;
}

/* Joins vertices nearer than mesh->weld to the first of them. A vertex that is near two groups joins both, so
 * that no two vertices nearer than that stay apart. */
static cml_status join_near(struct cml_mesh_work *work, uint32_t *same, struct cml_error *err)
{
    const struct cml_mesh *mesh = work->mesh;
    struct groups groups = {.same = same};
    CML_AT_END(cml_mesh_near_end) struct cml_mesh_near near = {0};
    CML_TRY(cml_mesh_near_begin(&near, mesh, mesh->weld, err));
    for (uint32_t i = 0; i < mesh->num_vertices; i++) {
        if (same[i] != i) continue;
        cml_mesh_near_visit(&near, i, join_groups, &groups);
        cml_mesh_near_add(&near, i);
    }
    for (uint32_t i = 0; i < mesh->num_vertices; i++) {
        double way[3];
        const uint32_t first = first_of(same, i);
        cml_vec3_subtract(mesh->vertex[i], mesh->vertex[first], way);
        work->notes.join_distance = fmax(work->notes.join_distance, cml_vec3_length(way));
        same[i] = first;
    }
    work->notes.joined = groups.joined;
    return CML_OK;
}

/* Joins vertices with equal coordinates, since some exporters write the corners of every face anew. Vertices
 * that are merely close are joined only if mesh->weld asks for it, because that could close a thin layer. */
static cml_status weld(struct cml_mesh_work *work, struct cml_error *err)
{
    struct cml_mesh *mesh = work->mesh;
    /* -0.0 + 0.0 = 0.0: afterwards equal coordinates have equal bits. */
    for (size_t i = 0; i < mesh->num_vertices; i++)
        for (int k = 0; k < 3; k++) mesh->vertex[i][k] += 0.0;
    size_t size = 16;
    while (size < 2 * mesh->num_vertices) size *= 2;
    CML_FREED uint32_t *table = malloc(size * sizeof *table);
    CML_FREED uint32_t *same = malloc((mesh->num_vertices + 1) * sizeof *same);
    if (!table || !same) return cml_fail_memory(err, 4.0 * (double)size, "the vertices of a mesh");
    memset(table, 0xff, size * sizeof *table);
    work->notes.welded = find_equal(mesh, table, size - 1, same);
    if (mesh->weld > 0) CML_TRY(join_near(work, same, err));
    for (size_t t = 0; t < mesh->num_triangles; t++)
        for (int k = 0; k < 3; k++) mesh->triangle[t][k] = same[mesh->triangle[t][k]];
    return CML_OK;
}

/* A sliver that is merely thin is a valid surface. */
bool cml_mesh_is_degenerate(const struct cml_mesh *mesh, size_t t)
{
    const uint32_t *corner = mesh->triangle[t];
    if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) return true;
    const double *a = mesh->vertex[corner[0]], *b = mesh->vertex[corner[1]], *c = mesh->vertex[corner[2]];
    double u[3], v[3];
    cml_vec3_subtract(b, a, u);
    cml_vec3_subtract(c, a, v);
    /* Products are compared with each other. Their difference would be NaN where products overflow. */
    return u[1] * v[2] == u[2] * v[1] && u[2] * v[0] == u[0] * v[2] && u[0] * v[1] == u[1] * v[0];
}

/* Drops triangles without area, in place and in order. work->origin keeps each triangle's old number, for
 * messages with line numbers. */
static cml_status drop_degenerate(struct cml_mesh_work *work, struct cml_error *err)
{
    struct cml_mesh *mesh = work->mesh;
    work->origin = malloc(mesh->num_triangles * sizeof *work->origin);
    if (!work->origin) return cml_fail_memory(err, 4.0 * (double)mesh->num_triangles, "the faces of a mesh");
    size_t kept = 0;
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        if (cml_mesh_is_degenerate(mesh, t)) continue;
        memmove(mesh->triangle[kept], mesh->triangle[t], sizeof mesh->triangle[0]);
        if (mesh->slope) mesh->slope[kept] = mesh->slope[t];
        work->origin[kept++] = (uint32_t)t;
    }
    if (kept == 0) return cml_mesh_fail(work, 0, err, "every face of the mesh has zero area");
    work->notes.degenerate = mesh->num_triangles - kept;
    mesh->num_triangles = kept;
    return CML_OK;
}

/* Drops unused vertices and renumbers the others in their old order, so that a prepared mesh stays
 * unchanged. */
static cml_status drop_unused(struct cml_mesh_work *work, struct cml_error *err)
{
    struct cml_mesh *mesh = work->mesh;
    CML_FREED uint32_t *number = malloc(mesh->num_vertices * sizeof *number);
    if (!number) return cml_fail_memory(err, 4.0 * (double)mesh->num_vertices, "the vertices of a mesh");
    memset(number, 0xff, mesh->num_vertices * sizeof *number);
    for (size_t t = 0; t < mesh->num_triangles; t++)
        for (int k = 0; k < 3; k++) number[mesh->triangle[t][k]] = 0;
    uint32_t used = 0;
    for (size_t i = 0; i < mesh->num_vertices; i++) {
        if (number[i] == EMPTY) continue;
        memmove(mesh->vertex[used], mesh->vertex[i], sizeof mesh->vertex[0]);
        number[i] = used++;
    }
    for (size_t t = 0; t < mesh->num_triangles; t++)
        for (int k = 0; k < 3; k++) mesh->triangle[t][k] = number[mesh->triangle[t][k]];
    work->notes.unused = mesh->num_vertices - work->notes.welded - work->notes.joined - used;
    if (used < mesh->num_vertices) { /* an .stl has six times as many vertices as are used */
        double(*fewer)[3] = realloc(mesh->vertex, used * sizeof *fewer);
        if (fewer) mesh->vertex = fewer;
    }
    mesh->num_vertices = used;
    return CML_OK;
}

cml_status cml_mesh_clean(struct cml_mesh_work *work, struct cml_error *err)
{
    CML_TRY(check_vertices(work, err));
    CML_TRY(check_triangles(work, err));
    CML_TRY(weld(work, err));
    CML_TRY(drop_degenerate(work, err));
    return drop_unused(work, err);
}
