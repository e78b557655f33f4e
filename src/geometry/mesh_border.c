/* Border and orientation of a mesh. A sheet must have a border of one simple, horizontal loop, which also
 * tells the sheet's upper side. A body must have no border; this file finds which of its parts lie inside
 * others, and turns each part outwards. SPDX-License-Identifier: MIT */
#include "geometry/box_tree.h"
#include "geometry/mesh_parts.h"
#include "geometry/polygon.h"
#include "geometry/vec3.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Makes the error that memory ran out while the border of a mesh was searched. */
static cml_status no_memory(const struct cml_mesh *mesh, struct cml_error *err)
{
    return cml_fail_memory(err, 5.0 * (double)mesh->num_vertices, "the border of a mesh");
}

/* A loop of border half-edges. */
struct loop {
    uint32_t start; /* vertex at which the loop begins */
    size_t count;
    double area; /* signed area in (x, y), cm2 */
};

/* Walks around a border from vertex `start`, and returns the number of its vertices and the area inside.
 * leaving[v] is the border half-edge that begins at v; there is only one, as the triangles around v are one
 * fan. The area is a sum of triangles with a corner at `start` (shoelace formula). `seen` and `border` may
 * be NULL. */
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

/* Refuses a mesh with holes. The message names the middle of `hole`, because a hole of three edges is hard to
 * find in 1e6 triangles. */
static cml_status refuse_hole(const struct cml_mesh_work *work, const uint32_t *leaving, struct loop hole,
                              size_t num_holes, struct cml_error *err)
{
    const struct cml_mesh *mesh = work->mesh;
    double center[3] = {0};
    uint32_t v = hole.start;
    for (size_t i = 0; i < hole.count; i++, v = cml_half_edge_to(mesh, leaving[v]))
        for (int k = 0; k < 3; k++) center[k] += mesh->vertex[v][k] / (double)hole.count;
    char place[112], others[64] = "";
    if (num_holes > 1)
        snprintf(others, sizeof others, " and %zu other%s", num_holes - 1, num_holes > 2 ? "s" : "");
    return cml_mesh_fail(work, cml_mesh_triangle_line(work, leaving[hole.start] / 3), err,
                         "the mesh has a hole of %zu edges around %s%s (expected none besides its border: "
                         "fill holes in a mesh editor)",
                         hole.count, cml_mesh_place(center, place), others);
}

/* Makes the loop with the largest area the border. Any other loop is a hole; the largest hole is named in the
 * message. A mesh without border edges encloses a body and has no side that is above everywhere, so it is
 * refused. */
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
        if (num_loops > 1 && (larger || fabs(loop.area) >= fabs(hole.area))) hole = larger ? outer : loop;
        if (larger) outer = loop;
    }
    if (num_loops == 0)
        return cml_mesh_fail(work, 0, err,
                             "the mesh is a closed body (expected an open sheet with its border on one "
                             "horizontal plane; a body inside a layer has a line i)");
    if (num_loops > 1) return refuse_hole(work, leaving, hole, num_loops - 1, err);
    mesh->border = malloc(outer.count * sizeof *mesh->border);
    if (!mesh->border) return no_memory(mesh, err);
    mesh->num_border = outer.count;
    *border = walk_loop(mesh, leaving, outer.start, NULL, mesh->border);
    return CML_OK;
}

/* Finds the mesh's border: the loop of half-edges that have no opposite half-edge. Stores the loop's vertices
 * in mesh->border and describes the loop in *border. Refuses a mesh with holes. */
static cml_status find_loop(struct cml_mesh_work *work, uint32_t *leaving, struct loop *border,
                            struct cml_error *err)
{
    struct cml_mesh *mesh = work->mesh;
    memset(leaving, 0xff, mesh->num_vertices * sizeof *leaving);
    for (uint32_t e = 0; e < 3 * mesh->num_triangles; e++)
        if (work->opposite[e] == CML_NO_OPPOSITE) leaving[cml_half_edge_from(mesh, e)] = e;
    CML_FREED uint8_t *seen = calloc(mesh->num_vertices, 1);
    return seen ? take_loop(work, leaving, seen, border, err) : no_memory(mesh, err);
}

double cml_mesh_extent(const struct cml_mesh *mesh)
{
    double extent = 0;
    for (int k = 0; k < 3; k++) extent = fmax(extent, mesh->upper[k] - mesh->lower[k]);
    return extent;
}

/* Shares of the mesh's extent. A border that is level in its file may differ by err_level through rounding.
 * Up to nearly_level a border is levelled, because scanners and modelling tools write single precision. */
static const double err_level = 1e-9, nearly_level = 1e-6;

/* Range and mean of the border's depths. */
struct depths {
    uint32_t highest; /* highest vertex of the border */
    double span, mean;
};

/* Returns the highest vertex of a mesh's border, and the span and mean of the border's depths. z points
 * down. Depths are summed relative to the first vertex, which loses fewer digits. */
static struct depths measure_border(const struct cml_mesh *mesh)
{
    const double z0 = mesh->vertex[mesh->border[0]][2];
    struct depths depths = {.highest = mesh->border[0]};
    double low = z0, sum = 0;
    for (size_t i = 0; i < mesh->num_border; i++) {
        const double z = mesh->vertex[mesh->border[i]][2];
        if (z < mesh->vertex[depths.highest][2]) depths.highest = mesh->border[i];
        low = fmax(low, z);
        sum += z - z0;
    }
    depths.span = low - mesh->vertex[depths.highest][2];
    depths.mean = z0 + sum / (double)mesh->num_border;
    return depths;
}

/* Moves all border vertices to their mean depth, so that the outer plane joins the mesh without a gap. */
static cml_status level_border(struct cml_mesh_work *work, struct depths depths, struct cml_error *err)
{
    struct cml_mesh *mesh = work->mesh;
    if (depths.span > err_level * cml_mesh_extent(mesh)) work->notes.levelled = depths.span;
    mesh->z_border = depths.mean;
    for (size_t i = 0; i < mesh->num_border; i++) mesh->vertex[mesh->border[i]][2] = mesh->z_border;
    /* Levelling moves vertices by less than the tolerance, so only a face smaller than that can lose its
     * area. */
    for (size_t t = 0; t < mesh->num_triangles && depths.span > 0; t++)
        if (cml_mesh_is_degenerate(mesh, t))
            return cml_mesh_fail(work, cml_mesh_triangle_line(work, t), err,
                                 "a face has no area once the border is level (expected faces larger than "
                                 "%g of the mesh)",
                                 nearly_level);
    return CML_OK;
}

/* Returns the axis, 'x' or 'y', along which the border is level, as in a mesh whose y points up; 0 if there
 * is none. */
static char level_axis(const struct cml_mesh *mesh)
{
    for (int axis = 0; axis < 2; axis++) {
        double low = mesh->vertex[mesh->border[0]][axis], high = low;
        for (size_t i = 1; i < mesh->num_border; i++) {
            low = fmin(low, mesh->vertex[mesh->border[i]][axis]);
            high = fmax(high, mesh->vertex[mesh->border[i]][axis]);
        }
        if (high - low <= nearly_level * cml_mesh_extent(mesh)) return (char)('x' + axis);
    }
    return 0;
}

/* Refuses a border that is not horizontal. Suggests another up= axis if the border is level along x or y. */
static cml_status refuse_slope(const struct cml_mesh_work *work, const uint32_t *leaving,
                               struct depths depths, struct cml_error *err)
{
    char place[112], hint[16] = "";
    const char axis = level_axis(work->mesh);
    if (axis) snprintf(hint, sizeof hint, "; up=%c?", axis);
    return cml_mesh_fail(work, cml_mesh_triangle_line(work, leaving[depths.highest] / 3), err,
                         "the border is not horizontal: its height spans %.6g cm, the highest point is %s "
                         "(expected a border on one horizontal plane, or skirt=WIDTH%s)",
                         depths.span, cml_mesh_place(work->mesh->vertex[depths.highest], place), hint);
}

/* Refuses a border that meets itself, and names the first vertex of the edge: an edge number would mean
 * nothing to the mesh's author. */
static cml_status refuse_crossing(const struct cml_mesh_work *work, const uint32_t *leaving, size_t edge,
                                  struct cml_error *err)
{
    const uint32_t vertex = work->mesh->border[edge];
    char place[112];
    if (work->notes.skirt > 0)
        return cml_mesh_fail(work, 0, err,
                             "the skirt's edge meets itself at %s (expected another skirt= than %g cm, or a "
                             "mesh with a smoother border)",
                             cml_mesh_place(work->mesh->vertex[vertex], place), work->mesh->skirt);
    return cml_mesh_fail(work, cml_mesh_triangle_line(work, leaving[vertex] / 3), err,
                         "the border meets itself on the edge that begins at %s (expected a simple polygon "
                         "seen from above)",
                         cml_mesh_place(work->mesh->vertex[vertex], place));
}

/* Refuses a border that crosses itself, because such a border has no inside, where the outer plane has its
 * hole. */
static cml_status check_simple(const struct cml_mesh_work *work, const uint32_t *leaving,
                               struct cml_error *err)
{
    const struct cml_mesh *mesh = work->mesh;
    CML_FREED double(*point)[2] = malloc(mesh->num_border * sizeof *point);
    CML_AT_END(cml_polygon_rows_clear) struct cml_polygon_rows rows = {0};
    size_t edge;
    if (!point) return no_memory(mesh, err);
    for (size_t i = 0; i < mesh->num_border; i++)
        memcpy(point[i], mesh->vertex[mesh->border[i]], sizeof point[i]);
    CML_TRY(cml_polygon_rows_build(point, mesh->num_border, &rows, err));
    CML_TRY(cml_polygon_find_crossing(&rows, &edge, err));
    return edge == CML_POLYGON_SIMPLE ? CML_OK : refuse_crossing(work, leaving, edge, err);
}

/* Turns a mesh that is upside down: reverses all triangles and the border. No vertex moves. Triangles that
 * had been reversed already have now their old sense again, so the number of reversed ones is the rest. */
static void flip_sheet(struct cml_mesh_work *work)
{
    struct cml_mesh *mesh = work->mesh;
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        const uint32_t second = mesh->triangle[t][1];
        mesh->triangle[t][1] = mesh->triangle[t][2];
        mesh->triangle[t][2] = second;
    }
    for (size_t i = 1, j = mesh->num_border; i + 1 < j; i++, j--) {
        const uint32_t swap = mesh->border[i];
        mesh->border[i] = mesh->border[j - 1];
        mesh->border[j - 1] = swap;
    }
    work->notes.flipped = mesh->num_triangles - work->notes.flipped;
}

/* Brings the border to one depth, by levelling it or by a skirt around it. A border that crosses itself is
 * refused before it gets a skirt, which would only hide the fault. */
static cml_status place_border(struct cml_mesh_work *work, const uint32_t *leaving, struct cml_error *err)
{
    const struct depths depths = measure_border(work->mesh);
    if (depths.span <= nearly_level * cml_mesh_extent(work->mesh)) {
        CML_TRY(level_border(work, depths, err));
    } else {
        if (work->mesh->skirt <= 0) return refuse_slope(work, leaving, depths, err);
        CML_TRY(check_simple(work, leaving, err));
        CML_TRY(cml_mesh_add_skirt(work, err));
    }
    return check_simple(work, leaving, err);
}

cml_status cml_mesh_find_border(struct cml_mesh_work *work, struct cml_error *err)
{
    CML_FREED uint32_t *leaving = malloc(work->mesh->num_vertices * sizeof *leaving);
    if (!leaving) return no_memory(work->mesh, err);
    struct loop border = {0};
    CML_TRY(find_loop(work, leaving, &border, err));
    CML_TRY(place_border(work, leaving, err));
    /* The outer plane continues the sheet beyond the border, and the plane's upper side faces -z. Therefore
     * the sheet is right side up if its loop runs around the footprint in the negative sense of (x, y),
     * whatever the sheet's slope at the border. */
    if (border.area > 0) flip_sheet(work);
    return CML_OK;
}

/* ---- bodies ---- */

/* Properties of a part of a body. */
struct part {
    double volume; /* six times the signed volume, cm3; positive if triangles run counter-clockwise seen from
                      outside */
    double size;   /* sum of the absolute sizes of the volume's terms, a bound for rounding */
    double terms;
    bool cavity;
};

/* Refuses a body whose surface is not closed: an edge that belongs to one face only has no opposite
 * half-edge. */
static cml_status refuse_open_edges(const struct cml_mesh_work *work, struct cml_error *err)
{
    const struct cml_mesh *mesh = work->mesh;
    for (uint32_t e = 0; e < 3 * mesh->num_triangles; e++) {
        char from[112], to[112];
        if (work->opposite[e] != CML_NO_OPPOSITE) continue;
        return cml_mesh_fail(work, cml_mesh_triangle_line(work, e / 3), err,
                             "the body is open: the edge from %s to %s belongs to one face only (expected a "
                             "closed surface)",
                             cml_mesh_place(mesh->vertex[cml_half_edge_from(mesh, e)], from),
                             cml_mesh_place(mesh->vertex[cml_half_edge_to(mesh, e)], to));
    }
    return CML_OK;
}

/* Returns a corner of the part, the reference point of its volume. A closed surface has the same volume about
 * any point. */
static const double *start_of(const struct cml_mesh *mesh, uint32_t part)
{
    return mesh->vertex[mesh->triangle[mesh->part_start[part]][0]];
}

/* Adds up the volume of each part, and the bound for the rounding of that sum. */
static void sum_volumes(const struct cml_mesh *mesh, struct part *parts)
{
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        struct part *part = &parts[mesh->part[t]];
        double corner[3][3], normal[3], size = 1;
        for (int k = 0; k < 3; k++) {
            cml_vec3_subtract(mesh->vertex[mesh->triangle[t][k]], start_of(mesh, mesh->part[t]), corner[k]);
            size *= cml_vec3_length(corner[k]);
        }
        cml_vec3_cross(corner[1], corner[2], normal);
        part->volume += cml_vec3_dot(corner[0], normal);
        part->size += size;
        part->terms++;
    }
}

/* Refuses parts whose volume may be 0 within rounding. The bound is (terms + 10) epsilon times the sum of
 * sizes, where a size is the product of the lengths of a triangle's three vectors. It covers two errors. A
 * sum of n terms rounds by n half epsilons. A determinant rounds by at most 7 half epsilons, times 1.2
 * because its six terms are added without signs, plus 3 half epsilons for the vectors. */
static cml_status check_volumes(const struct cml_mesh_work *work, const struct part *parts,
                                struct cml_error *err)
{
    for (uint32_t k = 0; k < work->mesh->num_parts; k++) {
        const double err_volume = DBL_EPSILON * (parts[k].terms + 10) * parts[k].size;
        char place[112];
        if (fabs(parts[k].volume) > err_volume) continue;
        return cml_mesh_fail(work, cml_mesh_triangle_line(work, work->mesh->part_start[k]), err,
                             "the body has no volume at %s: %.3g cm3, with a rounding error of up to %.3g "
                             "(expected a closed surface around a volume)",
                             cml_mesh_place(start_of(work->mesh, k), place), fabs(parts[k].volume) / 6,
                             err_volume / 6);
    }
    return CML_OK;
}

/* Finds the parts that are cavities. A part is a cavity if the other parts stand an odd number of times above
 * one of its corners. */
static cml_status find_cavities(struct cml_mesh_work *work, struct part *parts, struct cml_error *err)
{
    struct cml_mesh *mesh = work->mesh;
    struct cml_column_mesh column = {(const double(*)[3])mesh->vertex, (const uint32_t(*)[3])mesh->triangle,
                                     mesh->part, NULL};
    struct cml_boxtree *tree;
    mesh->unite = mesh->unite && mesh->num_parts > 1;
    if (mesh->num_parts == 1 || mesh->unite) return CML_OK;
    CML_TRY(cml_boxtree_create(column.vertex, column.triangle, mesh->num_triangles, &tree, err));
    column.tree = tree;
    for (uint32_t k = 0; k < mesh->num_parts; k++) {
        parts[k].cavity = cml_column_through(&column, k, start_of(mesh, k)).above % 2 == 1;
        work->notes.cavities += parts[k].cavity;
    }
    cml_boxtree_free(tree);
    return CML_OK;
}

/* Reverses the triangles of parts whose normals point the wrong way: outwards for a solid part, inwards for a
 * cavity. */
static void turn_parts(struct cml_mesh_work *work, const struct part *parts)
{
    struct cml_mesh *mesh = work->mesh;
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        const struct part *part = &parts[mesh->part[t]];
        if ((part->volume < 0) == part->cavity) continue;
        const uint32_t second = mesh->triangle[t][1];
        mesh->triangle[t][1] = mesh->triangle[t][2];
        mesh->triangle[t][2] = second;
        work->notes.flipped += work->turned[t] ? (size_t)-1 : 1;
    }
}

cml_status cml_mesh_turn_outwards(struct cml_mesh_work *work, struct cml_error *err)
{
    struct cml_mesh *mesh = work->mesh;
    CML_FREED struct part *parts = calloc(mesh->num_parts, sizeof *parts);
    if (!parts) return cml_fail_memory(err, (double)(mesh->num_parts * sizeof *parts), "the parts of a body");
    CML_TRY(refuse_open_edges(work, err));
    sum_volumes(mesh, parts);
    CML_TRY(check_volumes(work, parts, err));
    CML_TRY(find_cavities(work, parts, err));
    turn_parts(work, parts);
    mesh->z_border = mesh->lower[2];
    return CML_OK;
}
