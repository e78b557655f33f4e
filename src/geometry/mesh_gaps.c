/* Finds corners that nearly meet. Small gaps between such corners separate faces that were meant to join, so
 * the message of a refused mesh mentions them. SPDX-License-Identifier: MIT */
#include "geometry/mesh_parts.h"
#include "geometry/vec3.h"

#include <math.h>
#include <stdlib.h>

/* Corners nearly meet if a gap of at most a tenth of the edges at them, and a thousandth of the mesh's
 * extent, separates them. */
static const double of_edge = 0.1, of_extent = 1e-3;

struct gaps {
    double *limit;   /* [num_vertices] largest gap at a vertex, cm; 0: no edge of one face ends there */
    double *nearest; /* [num_vertices] distance of the nearest other vertex within the limit, cm; else 0 */
};

/* Sets the limits: the shortest edge of one face at a vertex decides. Returns the largest limit. */
static double set_limits(const struct cml_mesh_work *work, size_t num_edges, double *limit)
{
    const struct cml_mesh *mesh = work->mesh;
    const double most = of_extent * cml_mesh_extent(mesh);
    double largest = 0;
    for (uint32_t e = 0; e < num_edges; e++) {
        if (work->opposite[e] != CML_NO_OPPOSITE) continue;
        const uint32_t end[2] = {cml_half_edge_from(mesh, e), cml_half_edge_to(mesh, e)};
        double way[3];
        cml_vec3_subtract(mesh->vertex[end[0]], mesh->vertex[end[1]], way);
        const double gap = fmin(most, of_edge * cml_vec3_length(way));
        for (int k = 0; k < 2; k++) limit[end[k]] = limit[end[k]] > 0 ? fmin(limit[end[k]], gap) : gap;
    }
    for (size_t i = 0; i < mesh->num_vertices; i++) largest = fmax(largest, limit[i]);
    return largest;
}

static void lower_nearest(void *context, uint32_t vertex, uint32_t other, double distance)
{
    struct gaps *gaps = context;
    (void)other;
    if (distance > gaps->limit[vertex]) return;
    double *nearest = &gaps->nearest[vertex];
    if (*nearest == 0 || distance < *nearest) *nearest = distance;
}

/* Finds the nearest vertex of each vertex at which edges of one face end. */
static cml_status find_gaps(const struct cml_mesh *mesh, double width, struct gaps *gaps,
                            struct cml_error *err)
{
    CML_AT_END(cml_mesh_near_end) struct cml_mesh_near near = {0};
    CML_TRY(cml_mesh_near_begin(&near, mesh, width, err));
    for (uint32_t i = 0; i < mesh->num_vertices; i++)
        if (gaps->limit[i] > 0) cml_mesh_near_add(&near, i);
    for (uint32_t i = 0; i < mesh->num_vertices; i++)
        if (gaps->limit[i] > 0) cml_mesh_near_visit(&near, i, lower_nearest, gaps);
    return CML_OK;
}

/* The distance to be given in weld= is half as large again as the widest gap, because `weld` joins corners
 * that are nearer. */
void cml_mesh_tell_near_corners(const struct cml_mesh_work *work, size_t num_triangles, struct cml_error *err)
{
    const struct cml_mesh *mesh = work->mesh;
    const struct cml_error refusal = *err;
    CML_FREED double *limit = calloc(mesh->num_vertices, sizeof *limit);
    CML_FREED double *nearest = calloc(mesh->num_vertices, sizeof *nearest);
    struct gaps gaps = {limit, nearest};
    struct cml_error no_memory;
    if (!limit || !nearest) return;
    const double width = set_limits(work, 3 * num_triangles, limit);
    if (!(width > 0) || find_gaps(mesh, 1.001 * width, &gaps, &no_memory) != CML_OK) return;
    size_t near = 0, widest = 0;
    for (size_t i = 0; i < mesh->num_vertices; i++) {
        near += nearest[i] > 0;
        if (nearest[i] > nearest[widest]) widest = i;
    }
    if (near == 0) return;
    char place[112];
    const cml_status status = cml_fail(
        err, refusal.status,
        "%s; %zu corners nearly meet others, up to %.3g cm away at %s: weld=%.2g joins them", refusal.text,
        near, nearest[widest], cml_mesh_place(mesh->vertex[widest], place), 1.5 * nearest[widest]);
    (void)status;
}
