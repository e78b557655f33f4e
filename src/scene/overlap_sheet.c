/* Checks sheets against themselves and each other: their order by vertical lines through vertices, contact by
 * pairs of triangles. SPDX-License-Identifier: MIT */
#include "scene/overlap_sheet.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Moves the vertices to the scene's frame. Depth is added only here, and all exact decisions are about these
 * rounded sums. */
static void place_vertices(struct cml_sheet *sheet, double z)
{
    const struct cml_mesh *mesh = sheet->mesh;
    for (size_t i = 0; i < mesh->num_vertices; i++) {
        double *vertex = sheet->vertex[i];
        memcpy(vertex, mesh->vertex[i], sizeof *sheet->vertex);
        vertex[2] += z;
        sheet->top = fmin(sheet->top, vertex[2]);
        sheet->bottom = fmax(sheet->bottom, vertex[2]);
    }
    for (size_t i = 0; i < mesh->num_border; i++) sheet->on_border[mesh->border[i]] = true;
}

/* Fills in a sheet, a mesh with the outer plane around it: vertices in the scene's frame, search tree, depth
 * of the outer plane. z: nominal depth of the mesh, cm. */
static cml_status fill_sheet(struct cml_sheet *sheet, double z, struct cml_error *err)
{
    const struct cml_mesh *mesh = sheet->mesh;
    sheet->vertex = malloc(mesh->num_vertices * sizeof *sheet->vertex);
    sheet->on_border = calloc(mesh->num_vertices, sizeof *sheet->on_border);
    if (!sheet->vertex || !sheet->on_border)
        return cml_fail_memory(err, (double)mesh->num_vertices * 25.0, "the overlap check of a mesh");
    sheet->z_plane = sheet->top = sheet->bottom = mesh->z_border + z;
    place_vertices(sheet, z);
    CML_TRY(cml_boxtree_create((const double(*)[3])sheet->vertex, (const uint32_t(*)[3])mesh->triangle,
                               mesh->num_triangles, &sheet->tree, err));
    if (!mesh->closed) return cml_footprint_create(mesh, &sheet->footprint, err);
    sheet->z_plane = NAN; /* NAN, which compares false: the plane meets nothing */
    return CML_OK;
}

cml_status cml_sheet_create(const struct cml_mesh *mesh, double z, struct cml_sheet *sheet,
                            struct cml_error *err)
{
    memset(sheet, 0, sizeof *sheet);
    sheet->mesh = mesh;
    const cml_status status = fill_sheet(sheet, z, err);
    if (status != CML_OK) cml_sheet_clear(sheet);
    return status;
}

void cml_sheet_clear(struct cml_sheet *sheet)
{
    free(sheet->vertex);
    free(sheet->on_border);
    cml_boxtree_free(sheet->tree);
    cml_footprint_free(sheet->footprint);
    memset(sheet, 0, sizeof *sheet);
}

/* Gives the three corners of triangle i of a sheet, in the scene's frame. */
static void corners(const struct cml_sheet *sheet, uint32_t i, const double *v[3])
{
    for (int k = 0; k < 3; k++) v[k] = sheet->vertex[sheet->mesh->triangle[i][k]];
}

/* Keeps the stronger of two contacts, and its place `at`: crossing counts more than touching. */
static void keep_stronger(struct cml_sheet_overlap *overlap, enum cml_contact contact, const double at[3],
                          uint32_t i, uint32_t j)
{
    if (contact <= overlap->contact) return;
    overlap->contact = contact;
    memcpy(overlap->at, at, sizeof overlap->at);
    overlap->triangle[0] = i;
    overlap->triangle[1] = j;
}

/* Arguments of a search for pairs of triangles that overlap. */
struct search {
    const struct cml_sheet *a, *b;
    struct cml_sheet_overlap *overlap;
};

/* Moves the corners that triangles i and j have in common to the front of a and b. Returns the number of
 * common corners. */
static int common_corners_first(const struct cml_mesh *mesh, uint32_t i, uint32_t j, const double *a[3],
                                const double *b[3])
{
    const uint32_t *s = mesh->triangle[i], *t = mesh->triangle[j];
    int shared = 0;
    int at[3] = {0, 1, 2}; /* at[l]: number of the corner of triangle j that stands at b[l] */
    for (int k = 0; k < 3; k++)
        for (int l = shared; l < 3; l++) {
            if (s[k] != t[at[l]]) continue;
            const double *const keep_a = a[shared], *const keep_b = b[shared];
            const int keep_at = at[shared];
            a[shared] = a[k], a[k] = keep_a;
            b[shared] = b[l], b[l] = keep_b;
            at[shared] = at[l], at[l] = keep_at;
            shared++;
            break;
        }
    return shared;
}

/* Compares two triangles of the search; true ends the search. Within one sheet neighbours have common
 * corners, and i and j come in any order. */
static bool compare_triangles(void *context, uint32_t i, uint32_t j)
{
    const struct search *search = context;
    const double *a[3], *b[3];
    double at[3];
    corners(search->a, i, a);
    corners(search->b, j, b);
    const bool same = search->a == search->b;
    const struct cml_mesh *mesh = search->a->mesh;
    if (same && mesh->unite && mesh->part[i] != mesh->part[j]) return false;
    const int shared = same ? common_corners_first(mesh, i, j, a, b) : 0;
    const enum cml_contact contact = cml_triangle_contact(a, b, shared, at);
    const bool swap = same && j < i;
    if (contact != CML_APART) keep_stronger(search->overlap, contact, at, swap ? j : i, swap ? i : j);
    return contact == CML_CROSS;
}

/* Finds where triangle i of `sheet` meets the outer plane of `other` (which may be the same sheet) outside
 * the border. Compares the points where its edges pass through the plane, and its vertices in the plane. A
 * line of intersection that is partly inside the border crosses it, and there the triangles themselves
 * meet. */
static enum cml_contact plane_contact(const struct cml_sheet *sheet, const struct cml_sheet *other,
                                      uint32_t i, double at[3])
{
    const double z = other->z_plane;
    enum cml_contact found = CML_APART;
    const double *v[3];
    corners(sheet, i, v);
    for (int k = 0; k < 3; k++) {
        const double *a = v[k], *b = v[(k + 1) % 3];
        const bool passes = (a[2] < z && b[2] > z) || (a[2] > z && b[2] < z);
        const bool lies = a[2] == z && !(sheet == other && sheet->on_border[sheet->mesh->triangle[i][k]]);
        if (!passes && !lies) continue;
        const double t = passes ? (z - a[2]) / (b[2] - a[2]) : 0.0;
        const double place[3] = {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), z};
        if (cml_footprint_contains(other->footprint, place[0], place[1])) continue;
        memcpy(at, place, sizeof place);
        found = CML_TOUCH;
        if (passes) return CML_CROSS;
    }
    return found;
}

/* Finds whether a triangle lies wholly in its own outer plane, outside the border; at: its middle. All its
 * corners may lie on the border, so that plane_contact does not see it. */
static enum cml_contact flat_contact(const struct cml_sheet *sheet, uint32_t i, double at[3])
{
    const double *v[3];
    corners(sheet, i, v);
    for (int k = 0; k < 3; k++)
        if (v[k][2] != sheet->z_plane) return CML_APART;
    for (int k = 0; k < 3; k++) at[k] = (v[0][k] + v[1][k] + v[2][k]) / 3.0;
    return cml_footprint_contains(sheet->footprint, at[0], at[1]) ? CML_APART : CML_TOUCH;
}

/* Pairs of triangles come first; then each triangle is compared with those in its own plane, and with the
 * outer plane. A crossing found later replaces a mere touch. */
void cml_sheet_against_itself(const struct cml_sheet *sheet, struct cml_sheet_overlap *overlap)
{
    memset(overlap, 0, sizeof *overlap);
    struct search search = {sheet, sheet, overlap};
    if (cml_boxtree_own_pairs(sheet->tree, compare_triangles, &search)) return;
    for (size_t i = 0; i < sheet->mesh->num_triangles; i++) {
        double at[3];
        const uint32_t t = (uint32_t)i;
        const enum cml_contact flat = flat_contact(sheet, t, at);
        const enum cml_contact contact = flat == CML_APART ? plane_contact(sheet, sheet, t, at) : flat;
        if (contact != CML_APART) keep_stronger(overlap, contact, at, t, CML_SHEET_OUTER_PLANE);
    }
}

/* Returns the crossings of the vertical line through a point with a sheet. The outer plane counts where the
 * triangles alone do not close the sheet, that is where their number of crossings is even. */
static struct cml_column column_through(const struct cml_sheet *sheet, const double *point)
{
    const struct cml_column_mesh mesh = {(const double(*)[3])sheet->vertex,
                                         (const uint32_t(*)[3])sheet->mesh->triangle, NULL, sheet->tree};
    struct cml_column column = cml_column_through(&mesh, CML_WITHOUT_NONE, point);
    if (column.crossings % 2 == 1 || sheet->mesh->closed) return column;
    const double distance = point[2] - sheet->z_plane;
    column.above += distance > 0.0;
    column.touches |= distance == 0.0;
    column.nearest = fmin(column.nearest, fabs(distance));
    return column;
}

/* Above a point inside, the vertical line meets an odd number of triangles; in a union, whose parts may
 * overlap, the winding number decides. */
bool cml_sheet_is_below(const struct cml_sheet *sheet, const double point[3])
{
    const struct cml_column column = column_through(sheet, point);
    return sheet->mesh->unite ? column.winding > 0 : column.above % 2 == 1;
}

/* Returns the vertical distance by which the point is on the wrong side of the sheet, 0 if it is on the right
 * side. */
static double depth_on_wrong_side(const struct cml_sheet *sheet, const double *point, bool should_be_below)
{
    const struct cml_column column = column_through(sheet, point);
    const double err_depth = 8.0 * DBL_EPSILON * fabs(point[2]);
    const bool is_below = column.above % 2 == 1;
    if (column.touches || is_below == should_be_below || column.nearest <= err_depth) return 0.0;
    return column.nearest;
}

/* Keeps the deepest place. A message names this place rather than the first one, because a user can see and
 * mend a depth. */
static void keep_deepest(struct cml_sheet_overlap *overlap, double depth, double x, double y, double z)
{
    if (!(depth > overlap->depth)) return;
    overlap->contact = CML_CROSS;
    overlap->depth = depth;
    overlap->at[0] = x;
    overlap->at[1] = y;
    overlap->at[2] = z;
}

/* Compares the vertices of each sheet with the other sheet. A vertex that pokes through the other sheet is on
 * the wrong side. Vertices beyond the whole other sheet are skipped. */
static void compare_vertices(const struct cml_sheet *upper, const struct cml_sheet *lower,
                             struct cml_sheet_overlap *overlap)
{
    for (size_t i = 0; i < upper->mesh->num_vertices; i++) {
        const double *v = upper->vertex[i];
        if (v[2] > lower->top) keep_deepest(overlap, depth_on_wrong_side(lower, v, false), v[0], v[1], v[2]);
    }
    for (size_t i = 0; i < lower->mesh->num_vertices; i++) {
        const double *v = lower->vertex[i];
        if (!(v[2] < upper->bottom)) continue;
        const double depth = depth_on_wrong_side(upper, v, true);
        keep_deepest(overlap, depth, v[0], v[1], v[2] + depth);
    }
}

/* Compares the planes in which two meshes continue outside, and keeps the overlap if the upper one is not
 * above the lower one. The reported place is a corner of the box around both meshes. */
static void compare_planes(const struct cml_sheet *upper, const struct cml_sheet *lower,
                           struct cml_sheet_overlap *overlap)
{
    const double at[3] = {fmax(upper->mesh->upper[0], lower->mesh->upper[0]),
                          fmax(upper->mesh->upper[1], lower->mesh->upper[1]), upper->z_plane};
    keep_deepest(overlap, upper->z_plane - lower->z_plane, at[0], at[1], at[2]);
    if (upper->z_plane == lower->z_plane)
        keep_stronger(overlap, CML_TOUCH, at, CML_SHEET_OUTER_PLANE, CML_SHEET_OUTER_PLANE);
}

/* Compares the triangles of one sheet with the outer plane of the other, which has no triangles of its
 * own. */
static void compare_with_plane(const struct cml_sheet *sheet, const struct cml_sheet *other, bool sheet_first,
                               struct cml_sheet_overlap *overlap)
{
    for (size_t i = 0; i < sheet->mesh->num_triangles && overlap->contact != CML_CROSS; i++) {
        double at[3];
        const uint32_t t = (uint32_t)i;
        const enum cml_contact contact = plane_contact(sheet, other, t, at);
        if (contact != CML_APART)
            keep_stronger(overlap, contact, at, sheet_first ? t : CML_SHEET_OUTER_PLANE,
                          sheet_first ? CML_SHEET_OUTER_PLANE : t);
    }
}

/* Compares the triangles of two sheets with each other, and the triangles of each sheet with the other's
 * outer plane. */
static void compare_surfaces(const struct cml_sheet *a, const struct cml_sheet *b,
                             struct cml_sheet_overlap *overlap)
{
    struct search search = {a, b, overlap};
    if (cml_boxtree_pairs(a->tree, b->tree, compare_triangles, &search)) return;
    compare_with_plane(a, b, true, overlap);
    compare_with_plane(b, a, false, overlap);
}

void cml_sheet_contact(const struct cml_sheet *a, const struct cml_sheet *b,
                       struct cml_sheet_overlap *overlap)
{
    memset(overlap, 0, sizeof *overlap);
    compare_surfaces(a, b, overlap);
}

/* Vertices come first, because they are cheap to compare and because the message then gives the depth of the
 * overlap. */
void cml_sheet_against_sheet(const struct cml_sheet *upper, const struct cml_sheet *lower,
                             struct cml_sheet_overlap *overlap)
{
    memset(overlap, 0, sizeof *overlap);
    if (upper->bottom < lower->top) return;
    compare_vertices(upper, lower, overlap);
    compare_planes(upper, lower, overlap);
    if (overlap->contact != CML_CROSS) compare_surfaces(upper, lower, overlap);
}
