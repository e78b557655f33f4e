/* Finds corners that nearly meet. Small gaps between such corners separate faces that were meant to join, so
 * the message of a refused mesh mentions them. SPDX-License-Identifier: MIT */
#include "geometry/mesh_parts.h"
#include "geometry/vec3.h"

#include <math.h>
#include <stdlib.h>

static const double nearly = 1e-5; /* share of the mesh's extent; exporters write five digits or more */

/* A corner at an edge that belongs to one face only. */
struct corner {
    uint32_t vertex, next; /* `next`: the other end of the edge */
    double along;          /* position along the line by which corners are sorted, cm */
    double nearest;        /* distance of the nearest other corner, cm; infinite if no other corner is within
                              `nearly` times the mesh's extent */
};

/* Orders two corners by their position along the line, for qsort. */
static int compare_corners(const void *left, const void *right)
{
    const struct corner *a = left, *b = right;
    return (a->along > b->along) - (a->along < b->along);
}

/* Lists the corners of edges with one face, sorted along a line, and returns their number. Points close to
 * each other are also close along any line. The line is oblique to grids, so that few points of a grid lie at
 * the same place along it. */
static size_t list_corners(const struct cml_mesh_work *work, size_t num_edges, struct corner *corner)
{
    static const double line[3] = {0.36, 0.48, 0.8}; /* a unit vector, oblique to grids */
    const struct cml_mesh *mesh = work->mesh;
    size_t count = 0;
    for (uint32_t e = 0; e < num_edges; e++) {
        if (work->opposite[e] != CML_NO_OPPOSITE) continue;
        const uint32_t vertex = cml_half_edge_from(mesh, e);
        corner[count++] = (struct corner){vertex, cml_half_edge_to(mesh, e),
                                          cml_vec3_dot(mesh->vertex[vertex], line), INFINITY};
    }
    qsort(corner, count, sizeof *corner, compare_corners);
    return count;
}

/* Lowers a->nearest and b->nearest to the distance of two corners if it is at most `most`, cm. Skips two
 * corners that are the same vertex or the ends of one edge. */
static void compare_pair(const struct cml_mesh *mesh, struct corner *a, struct corner *b, double most)
{
    double way[3];
    if (a->vertex == b->vertex || a->next == b->vertex || b->next == a->vertex) return;
    cml_vec3_subtract(mesh->vertex[a->vertex], mesh->vertex[b->vertex], way);
    const double distance = cml_vec3_length(way);
    if (distance > most) return;
    a->nearest = fmin(a->nearest, distance);
    b->nearest = fmin(b->nearest, distance);
}

/* Adds to the refusal of an open mesh how many corners of its open edges nearly meet another corner: a usual
 * fault, which a mesh editor repairs. Corners are sorted along one axis, so that few pairs are compared. */
void cml_mesh_tell_near_corners(const struct cml_mesh_work *work, size_t num_triangles, struct cml_error *err)
{
    const struct cml_mesh *mesh = work->mesh;
    const struct cml_error refusal = *err;
    const double most = nearly * cml_mesh_extent(mesh);
    CML_FREED struct corner *corner = malloc(3 * num_triangles * sizeof *corner);
    if (!corner) return;
    const size_t count = list_corners(work, 3 * num_triangles, corner);
    size_t near = 0, widest = 0;
    for (size_t i = 0; i < count; i++)
        for (size_t k = i + 1; k < count && corner[k].along - corner[i].along <= most; k++)
            compare_pair(mesh, &corner[i], &corner[k], most);
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(corner[i].nearest)) continue;
        if (near++ == 0 || corner[i].nearest > corner[widest].nearest) widest = i;
    }
    if (near == 0) return;
    char place[112];
    const cml_status status =
        cml_fail(err, refusal.status,
                 "%s; %zu corners nearly meet others, up to %.3g cm away at %s: merge vertices by distance "
                 "in a mesh editor",
                 refusal.text, near, corner[widest].nearest,
                 cml_mesh_place(mesh->vertex[corner[widest].vertex], place));
    (void)status;
}
