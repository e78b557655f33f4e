/* Finds corners that nearly meet. Small gaps between such corners separate faces that were meant to join, so
 * the message of a refused mesh mentions them. SPDX-License-Identifier: MIT */
#include "base/array.h"
#include "geometry/mesh_parts.h"
#include "geometry/vec3.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

/* Corners nearly meet if a gap of at most a third of the edges at them separates them: beyond half an edge, a
 * gap and an edge cannot be told apart. */
static const double of_edge = 1.0 / 3;

enum { MOST_TRIES = 4 };             /* distances that are tried as weld= */
#define MOST_PAIRS ((size_t)1 << 27) /* distances between two parts, 0.2 s of them */

struct gaps {
    double *limit;   /* [num_vertices] largest gap at a vertex, cm; 0: no edge of one face ends there */
    double *nearest; /* [num_vertices] distance of the nearest other vertex within the limit, cm; else 0 */
};

/* Adds a text to a refusal. */
static CML_PRINTF(2, 3) void add(struct cml_error *err, const char *format, ...)
{
    const size_t length = strlen(err->text);
    va_list args;
    va_start(args, format);
    vsnprintf(err->text + length, sizeof err->text - length, format, args);
    va_end(args);
}

/* Sets the limits: the shortest edge of one face at a vertex decides. Returns the largest limit, which is at
 * most the mean distance of the vertices of a sheet, so that a search finds few others. */
static double set_limits(const struct cml_mesh_work *work, double *limit)
{
    const struct cml_mesh *mesh = work->mesh;
    const double most = cml_mesh_extent(mesh) / sqrt((double)mesh->num_vertices);
    double largest = 0;
    for (uint32_t e = 0; e < 3 * work->num_paired; e++) {
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

/* Writes the distance to be given in weld=, which is half as large again as the gap, because `weld` joins
 * corners that are nearer. Returns the distance as it is written. */
static double write_weld(double gap, char text[16])
{
    snprintf(text, 16, "%.2g", 1.5 * gap);
    return strtod(text, NULL);
}

/* Returns the narrowest gap whose weld= makes the mesh sound, else the widest one. Tries the widest
 * gap, and those before a leap to ten times the width, which parts gaps of rounding from those of the shape.
 */
static double choose_gap(const struct cml_mesh_work *work, const double *nearest, cml_mesh_trial *try_weld,
                         bool *is_sound)
{
    const size_t n = work->mesh->num_vertices;
    const double rounding = 1e-9 * cml_mesh_extent(work->mesh);
    bool failed = false;
    char text[16];
    CML_FREED double *gap = cml_array_copy(nearest, n, sizeof *gap, &failed);
    if (failed) return 0;
    const size_t count = cml_sort_distinct(gap, n);
    int tries = 0;
    for (size_t i = 0; i < count; i++) {
        const bool is_last = i + 1 == count;
        if (gap[i] == 0 ||
            (!is_last && (tries == MOST_TRIES - 1 || gap[i + 1] < fmax(10 * gap[i], rounding))))
            continue;
        tries++;
        *is_sound = try_weld(work, write_weld(gap[i], text));
        if (*is_sound) return gap[i];
    }
    return gap[count - 1];
}

/* Adds how many corners nearly meet and which weld= joins them. False: none do, or none that a larger weld=
 * would help. */
static bool tell_near(const struct cml_mesh_work *work, const double *nearest, cml_mesh_trial *try_weld,
                      struct cml_error *err)
{
    const struct cml_mesh *mesh = work->mesh;
    bool is_sound = false;
    const double gap = choose_gap(work, nearest, try_weld, &is_sound);
    size_t near = 0, widest = 0;
    for (size_t i = mesh->num_vertices; i-- > 0;) {
        near += nearest[i] > 0 && nearest[i] <= gap;
        if (nearest[i] == gap) widest = i;
    }
    if (near == 0 || (!is_sound && work->notes.joined > 0)) return false;
    char place[112], weld[16];
    write_weld(gap, weld);
    add(err, "; %zu corners nearly meet others, up to %.3g cm away at %s", near, gap,
        cml_mesh_place(mesh->vertex[widest], place));
    add(err, is_sound ? ": weld=%s joins them" : ", but weld=%s leaves faults", weld);
    return true;
}

/* Adds how near the second part of a sheet comes to the others, by the corners of edges of one face. */
static void tell_far(const struct cml_mesh_work *work, const double *limit, struct cml_error *err)
{
    const struct cml_mesh *mesh = work->mesh;
    size_t count = 0;
    double least = INFINITY;
    CML_FREED uint8_t *side = calloc(mesh->num_vertices, 1); /* 1: of the second part; 2: of another */
    if (!side) return;
    for (size_t t = 0; t < mesh->num_triangles; t++)
        for (int k = 0; k < 3; k++) side[mesh->triangle[t][k]] |= mesh->part[t] == 1 ? 1 : 2;
    for (size_t i = 0; i < mesh->num_vertices; i++) count += side[i] & 1;
    if (count > MOST_PAIRS / mesh->num_vertices) return;
    for (size_t i = 0; i < mesh->num_vertices; i++)
        for (size_t j = 0; (side[i] & 1) && limit[i] > 0 && j < mesh->num_vertices; j++) {
            double way[3];
            cml_vec3_subtract(mesh->vertex[i], mesh->vertex[j], way);
            if ((side[j] & 2) && limit[j] > 0) least = fmin(least, cml_vec3_length(way));
        }
    if (least > 0 && isfinite(least))
        add(err, "; its corners are %.3g cm or more from those of others, too far for weld=", least);
}

/* weld= joins corners that are nearer, so a refused mesh whose corners it has joined may want a smaller one.
 */
void cml_mesh_tell_of_corners(const struct cml_mesh_work *work, cml_mesh_trial *try_weld,
                              struct cml_error *err)
{
    const struct cml_mesh *mesh = work->mesh;
    struct cml_error no_memory;
    CML_FREED double *limit = calloc(mesh->num_vertices + 1, sizeof *limit);
    CML_FREED double *nearest = calloc(mesh->num_vertices + 1, sizeof *nearest);
    struct gaps gaps = {limit, nearest};
    if (!limit || !nearest) return;
    const double width = work->num_paired > 0 ? set_limits(work, limit) : 0;
    if (width > 0 && find_gaps(mesh, 1.001 * width, &gaps, &no_memory) == CML_OK &&
        tell_near(work, nearest, try_weld, err))
        return;
    if (work->notes.joined > 0)
        add(err, "; weld=%g has joined %zu corners, up to %.3g cm away: it may be too large", mesh->weld,
            work->notes.joined, work->notes.join_distance);
    else if (width > 0 && mesh->part && !mesh->closed)
        tell_far(work, limit, err);
}
