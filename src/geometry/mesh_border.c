/* The border of a mesh: one loop, horizontal, simple; and which side of the sheet is up.
 * SPDX-License-Identifier: MIT */
#include "geometry/mesh_parts.h"
#include "geometry/polygon.h"
#include "geometry/vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static cml_status no_memory(const struct cml_mesh *mesh, struct cml_error *err)
{
    return cml_fail_memory(err, 5.0 * (double)mesh->num_vertices, "the border of a mesh");
}

/* One loop of border half-edges. */
struct loop {
    uint32_t start; /* vertex */
    size_t count;
    double area; /* signed, in (x, y), cm^2 */
};

/* Walks the loop from `start`; leaving[v] is the border half-edge that begins at v: only one does, as the
 * triangles around v are one fan. The area is a sum of triangles from `start` on [the shoelace formula].
 * `seen` and `border` may be NULL. */
static struct loop walk_loop(const struct cml_mesh *mesh, const uint32_t *leaving, uint32_t start,
                             uint8_t *seen, uint32_t *border)
{
    struct loop loop = {.start = start};
    const double *origin = mesh->vertex[start];
    uint32_t v = start;
    do {
        const uint32_t next = cml_half_edge_to(mesh, leaving[v]);
        loop.area += 0.5 * cml_vec2_area(origin, mesh->vertex[v], mesh->vertex[next]);
        if (border) border[loop.count] = v;
        if (seen) seen[v] = 1;
        loop.count++;
        v = next;
    } while (v != start);
    return loop;
}

/* The middle of the hole says more than one of its edges: a hole of three edges is hard to find in 1e6
 * triangles. */
static cml_status refuse_hole(const struct cml_mesh_work *work, const uint32_t *leaving, struct loop hole,
                              size_t num_loops, struct cml_error *err)
{
    const struct cml_mesh *mesh = work->mesh;
    double center[3] = {0};
    uint32_t v = hole.start;
    for (size_t i = 0; i < hole.count; i++, v = cml_half_edge_to(mesh, leaving[v]))
        for (int k = 0; k < 3; k++) center[k] += mesh->vertex[v][k] / (double)hole.count;
    char place[112];
    return cml_mesh_fail(work, cml_mesh_triangle_line(work, leaving[hole.start] / 3), err,
                         "the mesh has a hole of %zu border edges around %s (expected one border loop, found "
                         "%zu)",
                         hole.count, cml_mesh_place(center, place), num_loops);
}

/* Takes the loop of the largest area for the border; any other one is a hole, and which of several is named
 * does not matter. A sheet without any border edge encloses something: it has no side to be called above
 * everywhere. */
static cml_status take_loop(struct cml_mesh_work *work, const uint32_t *leaving, uint8_t *seen,
                            struct loop *border, struct cml_error *err)
{
    struct cml_mesh *mesh = work->mesh;
    struct loop outer = {0}, hole = {0};
    size_t num_loops = 0;
    for (uint32_t v = 0; v < mesh->num_vertices; v++) {
        if (leaving[v] == CML_NO_OPPOSITE || seen[v]) continue;
        const struct loop loop = walk_loop(mesh, leaving, v, seen, NULL);
        const bool larger = num_loops++ == 0 || fabs(loop.area) > fabs(outer.area);
        if (num_loops > 1) hole = larger ? outer : loop;
        if (larger) outer = loop;
    }
    if (num_loops == 0)
        return cml_mesh_fail(work, 0, err,
                             "the mesh is a closed body (expected an open sheet with its border on one "
                             "horizontal plane)");
    if (num_loops > 1) return refuse_hole(work, leaving, hole, num_loops, err);
    mesh->border = malloc(outer.count * sizeof *mesh->border);
    if (!mesh->border) return no_memory(mesh, err);
    mesh->num_border = outer.count;
    *border = walk_loop(mesh, leaving, outer.start, NULL, mesh->border);
    return CML_OK;
}

/* Border half-edges are those without an opposite one. *border becomes the loop of mesh->border. */
static cml_status find_loop(struct cml_mesh_work *work, uint32_t *leaving, struct loop *border,
                            struct cml_error *err)
{
    struct cml_mesh *mesh = work->mesh;
    memset(leaving, 0xff, mesh->num_vertices * sizeof *leaving);
    for (uint32_t e = 0; e < 3 * mesh->num_triangles; e++)
        if (work->opposite[e] == CML_NO_OPPOSITE) leaving[cml_half_edge_from(mesh, e)] = e;
    uint8_t *seen = calloc(mesh->num_vertices, 1);
    if (!seen) return no_memory(mesh, err);
    const cml_status status = take_loop(work, leaving, seen, border, err);
    free(seen);
    return status;
}

/* What the tolerance of the border's depth is relative to. */
static double largest_extent(const struct cml_mesh *mesh)
{
    double extent = 0;
    for (int k = 0; k < 3; k++) extent = fmax(extent, mesh->upper[k] - mesh->lower[k]);
    return extent;
}

/* Files have decimals: a border that is horizontal there may not be so in binary, or in other units. It is
 * put exactly onto one depth, since the outer plane goes on there without a gap. */
static cml_status level_border(const struct cml_mesh_work *work, const uint32_t *leaving,
                               struct cml_error *err)
{
    struct cml_mesh *mesh = work->mesh;
    const double z0 = mesh->vertex[mesh->border[0]][2];
    uint32_t highest = mesh->border[0];
    double low = z0, sum = 0;
    for (size_t i = 0; i < mesh->num_border; i++) {
        const double z = mesh->vertex[mesh->border[i]][2];
        if (z < mesh->vertex[highest][2]) highest = mesh->border[i];
        low = fmax(low, z);
        sum += z - z0;
    }
    char place[112];
    const double *top = mesh->vertex[highest], top_z = top[2];
    if (low - top[2] > 1e-9 * largest_extent(mesh))
        return cml_mesh_fail(work, cml_mesh_triangle_line(work, leaving[highest] / 3), err,
                             "the border is not horizontal: its height spans %.6g cm, the highest point is "
                             "%s (expected a border on one horizontal plane)",
                             low - top[2], cml_mesh_place(top, place));
    mesh->z_border = z0 + sum / (double)mesh->num_border;
    for (size_t i = 0; i < mesh->num_border; i++) mesh->vertex[mesh->border[i]][2] = mesh->z_border;
    /* Only a mesh with faces smaller than that tolerance can lose one by it. */
    for (size_t t = 0; t < mesh->num_triangles && low > top_z; t++)
        if (cml_mesh_is_degenerate(mesh, t))
            return cml_mesh_fail(work, cml_mesh_triangle_line(work, t), err,
                                 "a face has no area once the border is level (expected faces larger than "
                                 "1e-9 of the mesh)");
    return CML_OK;
}

/* Names the edge's first vertex: an edge number would mean nothing to whoever made the mesh. */
static cml_status refuse_crossing(const struct cml_mesh_work *work, const uint32_t *leaving, size_t edge,
                                  struct cml_error *err)
{
    const uint32_t vertex = work->mesh->border[edge];
    char place[112];
    return cml_mesh_fail(work, cml_mesh_triangle_line(work, leaving[vertex] / 3), err,
                         "the border meets itself on the edge that begins at %s (expected a simple polygon "
                         "seen from above)",
                         cml_mesh_place(work->mesh->vertex[vertex], place));
}

/* A border that crosses itself has no inside in which the outer plane could end. */
static cml_status check_simple(const struct cml_mesh_work *work, const uint32_t *leaving,
                               struct cml_error *err)
{
    const struct cml_mesh *mesh = work->mesh;
    double(*point)[2] = malloc(mesh->num_border * sizeof *point);
    if (!point) return no_memory(mesh, err);
    for (size_t i = 0; i < mesh->num_border; i++)
        memcpy(point[i], mesh->vertex[mesh->border[i]], sizeof point[i]);
    struct cml_polygon_rows rows;
    cml_status status = cml_polygon_rows_build(point, mesh->num_border, &rows, err);
    free(point);
    if (status != CML_OK) return status;
    size_t edge = CML_POLYGON_SIMPLE;
    status = cml_polygon_find_crossing(&rows, &edge, err);
    cml_polygon_rows_clear(&rows);
    if (status == CML_OK && edge != CML_POLYGON_SIMPLE) status = refuse_crossing(work, leaving, edge, err);
    return status;
}

/* All triangles and the border change their sense; depths and places stay. */
static void flip_sheet(struct cml_mesh_work *work)
{
    struct cml_mesh *mesh = work->mesh;
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        const uint32_t second = mesh->triangle[t][1];
        mesh->triangle[t][1] = mesh->triangle[t][2];
        mesh->triangle[t][2] = second;
    }
    for (size_t i = 1, j = mesh->num_border - 1; i < j; i++, j--) {
        const uint32_t swap = mesh->border[i];
        mesh->border[i] = mesh->border[j];
        mesh->border[j] = swap;
    }
    work->notes.flipped = mesh->num_triangles - work->notes.flipped;
}

cml_status cml_mesh_find_border(struct cml_mesh_work *work, struct cml_error *err)
{
    uint32_t *leaving = malloc(work->mesh->num_vertices * sizeof *leaving);
    if (!leaving) return no_memory(work->mesh, err);
    struct loop border = {0};
    cml_status status = find_loop(work, leaving, &border, err);
    if (status == CML_OK) status = level_border(work, leaving, err);
    if (status == CML_OK) status = check_simple(work, leaving, err);
    /* Beyond the border the sheet goes on as the outer plane, whose up is -z. So the sheet is right side up
     * when its loop runs around the footprint in the negative sense of (x, y), however the sheet leaves the
     * plane. */
    if (status == CML_OK && border.area > 0) flip_sheet(work);
    free(leaving);
    return status;
}
