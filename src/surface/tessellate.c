/* Turns a radial heightfield into a triangle mesh, ring by ring. SPDX-License-Identifier: MIT */
#include "surface/tessellate.h"

#include "base/constants.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FEWEST_SEGMENTS 8.0  /* a multiple of 8, because one eighth of a turn is mirrored bit for bit */
#define MOST_SEGMENTS 0x1p40 /* ends the search for absurd tolerances; far above CML_MESH_MOST */
#define NEEDLE_BUDGET 4e6    /* triangles; above this number the rule against needles is relaxed */
#define NEEDLE 16.0          /* an arc longer than this many ring widths makes needles */

/* A tessellation in progress. Counts are whole numbers stored as doubles, so that absurd requests cannot
 * overflow. */
struct rings {
    const struct cml_radial *radial;
    const struct cml_tessellation *options;
    double *segments; /* [n] vertices of each ring; 1 for the tip */
    size_t *first;    /* [n] index of each ring's vertex at azimuth 0 */
};

/* Returns the radius of a ring's vertices divided by the radius of its circle. */
static double vertex_factor(const struct cml_tessellation *options, double segments)
{
    const double step = 2.0 * CML_PI / segments;
    return options->inscribed ? 1.0 : sqrt(step / sin(step));
}

/* Returns the largest radial distance between a circle of radius 1 and its polygon. The area-preserving
 * polygon deviates most at its vertices. For small steps a series is used, because the closed form would
 * cancel. */
static double deviation(const struct cml_tessellation *options, double segments)
{
    const double step = 2.0 * CML_PI / segments;
    if (options->inscribed) return 2.0 * pow(sin(0.25 * step), 2.0);
    if (step < 0.01) return step * step / 12.0 * (1.0 + 0.075 * step * step);
    return vertex_factor(options, segments) - 1.0;
}

/* Returns the length of the profile between rings i and i + 1, cm. */
static double slant(const struct cml_radial *radial, int i)
{
    return hypot(radial->r[i + 1] - radial->r[i], radial->h[i + 1] - radial->h[i]);
}

/* Returns the longest arc, cm, that a side of ring i may have without making needles. A needle is a triangle
 * whose arc is longer than `needle` times the width of its strip. Where one strip is far narrower than its
 * neighbour, this rule alone would make the wide strip's triangles needles in the other direction. The
 * geometric mean of both widths is therefore always allowed. */
static double longest_arc(const struct cml_radial *radial, int i, double needle)
{
    const double inner = slant(radial, i - 1);
    const double outer = i + 1 < radial->n ? slant(radial, i) : inner;
    return fmax(needle * fmin(inner, outer), sqrt(inner * outer));
}

/* Returns the number of vertices of ring i: the smallest that keeps the tolerance, raised until no arc makes
 * needles. */
static double segments_of_ring(const struct rings *rings, int i, double needle)
{
    const struct cml_radial *radial = rings->radial;
    const double allowed = rings->options->tolerance * radial->r[radial->n - 1];
    double segments = FEWEST_SEGMENTS;
    while (segments < MOST_SEGMENTS && radial->r[i] * deviation(rings->options, segments) > allowed)
        segments *= 2.0;
    const double arc = longest_arc(radial, i, needle);
    while (segments < MOST_SEGMENTS && 2.0 * CML_PI * radial->r[i] > arc * segments) segments *= 2.0;
    return segments;
}

/* True if the strip between rings i and i + 1 is open: seen from above, their polygons keep at least half of
 * the distance between their circles. Polygons with different numbers of vertices bulge differently, so the
 * strip between close rings could otherwise fold over. */
static bool strip_is_open(const struct rings *rings, int i)
{
    const double *r = rings->radial->r, *n = rings->segments;
    if (n[i] == n[i + 1]) return true;
    const double inner = r[i] * vertex_factor(rings->options, n[i]);
    double outer = r[i + 1] * vertex_factor(rings->options, n[i + 1]);
    if (n[i] > n[i + 1]) outer *= cos(CML_PI / n[i + 1]);
    return outer - inner >= 0.5 * (r[i + 1] - r[i]);
}

/* Doubles the number of vertices of the coarser ring of a strip until the strip does not fold over
 * (strip_is_open). Returns true if a ring changed. */
static bool open_strip(const struct rings *rings, int i)
{
    bool changed = false;
    double *n = rings->segments;
    while (!strip_is_open(rings, i)) {
        n[n[i] < n[i + 1] ? i : i + 1] *= 2.0;
        changed = true;
    }
    return changed;
}

/* Opens all strips, from the outside in and back, until no ring changes. */
static void open_strips(const struct rings *rings)
{
    bool changed = true;
    while (changed) {
        changed = false;
        for (int i = rings->radial->n - 2; i >= 1; i--) changed |= open_strip(rings, i);
        for (int i = 1; i <= rings->radial->n - 2; i++) changed |= open_strip(rings, i);
    }
}

/* Chooses the vertices of every ring so that no arc is longer than `needle` times the width of its ring's
 * strips (longest_arc). Returns the number of triangles. */
static double choose_segments(const struct rings *rings, double needle)
{
    const int n = rings->radial->n;
    rings->segments[0] = 1.0;
    for (int i = 1; i < n; i++) rings->segments[i] = segments_of_ring(rings, i, needle);
    open_strips(rings);
    double triangles = rings->segments[1];
    for (int i = 1; i + 1 < n; i++) triangles += rings->segments[i] + rings->segments[i + 1];
    return triangles;
}

/* Chooses the vertices of every ring within the budget. The tolerance is always kept. Beyond NEEDLE_BUDGET
 * triangles, needles (triangles with an arc far longer than their ring's width) are allowed. NEEDLE_BUDGET is
 * the same on every machine, so that the same tolerance gives the same mesh everywhere, or none. */
static cml_status plan(const struct rings *rings, const struct cml_mesh_budget *budget, double *triangles,
                       struct cml_error *err)
{
    const double without = choose_segments(rings, INFINITY);
    double needle = NEEDLE;
    *triangles = choose_segments(rings, needle);
    while (*triangles > NEEDLE_BUDGET && *triangles > without) {
        needle *= 2.0;
        *triangles = choose_segments(rings, needle);
    }
    return cml_mesh_budget_check(budget, *triangles,
                                 "a larger --tolerance or --mesh-budget, or --boundaries cone", err);
}

/* Computes vertex k of `segments` on the unit circle. All vertices are mirrored from one eighth of the
 * circle, so that symmetric vertices have symmetric bits. */
static void unit_point(size_t k, size_t segments, double point[2])
{
    const size_t quarter = segments / 4, turn = k / quarter, rest = k % quarter;
    const bool mirror = rest > quarter / 2;
    const double angle = 2.0 * CML_PI * (double)(mirror ? quarter - rest : rest) / (double)segments;
    const bool diagonal = 2 * rest == quarter;
    const double cosine = diagonal ? sqrt(0.5) : cos(angle);
    const double sine = diagonal ? sqrt(0.5) : sin(angle);
    const double x = mirror ? sine : cosine, y = mirror ? cosine : sine;
    point[0] = turn == 0 ? x : turn == 1 ? -y : turn == 2 ? -x : y;
    point[1] = turn == 0 ? y : turn == 1 ? x : turn == 2 ? -y : -x;
}

/* Places the vertices of ring i: a regular polygon with the area of the ring's circle or, if `inscribed`,
 * inside the circle (vertex_factor). */
static void put_ring(const struct rings *rings, int i, struct cml_mesh *mesh)
{
    const size_t segments = (size_t)rings->segments[i];
    const double radius = rings->radial->r[i] * vertex_factor(rings->options, rings->segments[i]);
    for (size_t k = 0; k < segments; k++) {
        double *vertex = mesh->vertex[rings->first[i] + k];
        unit_point(k, segments, vertex);
        vertex[0] *= radius;
        vertex[1] *= radius;
        vertex[2] = 0.0 - rings->radial->h[i];
    }
}

/* Appends a triangle to the strip that ends at ring `ring`. Vertices a, b, c run counter-clockwise in x, y.
 * The mesh lists them clockwise, as a, c, b, so that the triangle faces up: z points down. */
static void put_triangle(const struct rings *rings, int ring, size_t a, size_t b, size_t c,
                         struct cml_mesh *mesh)
{
    const struct cml_radial *radial = rings->radial;
    if (mesh->slope)
        mesh->slope[mesh->num_triangles] =
            (radial->h[ring - 1] - radial->h[ring]) / (radial->r[ring] - radial->r[ring - 1]);
    cml_mesh_add_triangle(mesh, a, c, b);
}

/* Fills the disk between the tip and the first ring. */
static void put_tip(const struct rings *rings, struct cml_mesh *mesh)
{
    const size_t segments = (size_t)rings->segments[1], first = rings->first[1];
    const double tip[3] = {0, 0, 0.0 - rings->radial->h[0]};
    memcpy(mesh->vertex[0], tip, sizeof tip);
    for (size_t k = 0; k < segments; k++)
        put_triangle(rings, 1, 0, first + k, first + (k + 1) % segments, mesh);
}

/* Fills the strip between rings i and i + 1. Each edge of the coarse ring spans `many` edges of the fine
 * ring. One half of these edges is joined to the one end of the coarse edge, the other half to the other end:
 *
 *     fine      a-----b-----c
 *                \   / \   /       many = 2
 *                 \ /   \ /
 *     coarse     here---next */
static void put_strip(const struct rings *rings, int i, struct cml_mesh *mesh)
{
    const bool outward = rings->segments[i] <= rings->segments[i + 1];
    const int coarse_ring = outward ? i : i + 1, fine_ring = outward ? i + 1 : i;
    const size_t coarse = (size_t)rings->segments[coarse_ring], fine = (size_t)rings->segments[fine_ring];
    const size_t many = fine / coarse, at_coarse = rings->first[coarse_ring],
                 at_fine = rings->first[fine_ring];
    for (size_t k = 0; k < fine; k++) {
        const size_t edge = k / many, part = k % many;
        const size_t here = at_coarse + edge, next = at_coarse + (edge + 1) % coarse;
        const size_t a = at_fine + k, b = at_fine + (k + 1) % fine;
        const size_t apex = 2 * part < many ? here : next;
        put_triangle(rings, i + 1, apex, outward ? a : b, outward ? b : a, mesh);
        if (part == (many - 1) / 2)
            put_triangle(rings, i + 1, here, outward ? b : next, outward ? next : b, mesh);
    }
}

/* Numbers the vertices ring by ring and counts them. */
static void number_vertices(const struct rings *rings, struct cml_mesh *mesh)
{
    for (int i = 0; i < rings->radial->n; i++) {
        rings->first[i] = mesh->num_vertices;
        mesh->num_vertices += (size_t)rings->segments[i];
    }
}

/* Allocates the mesh's arrays for the given number of triangles. Returns CML_E_INPUT if memory runs out. */
static cml_status allocate(struct cml_mesh *mesh, size_t triangles, struct cml_error *err)
{
    const char what[] = "the mesh of a radial heightfield";
    CML_TRY(cml_mesh_allocate(mesh, mesh->num_vertices, triangles, what, err));
    if (mesh->normals != CML_NORMALS_ANALYTIC) return CML_OK;
    mesh->slope = malloc(triangles * sizeof *mesh->slope);
    return mesh->slope ? CML_OK : cml_fail_memory(err, (double)(triangles * sizeof *mesh->slope), what);
}

/* Fills the mesh with the vertices of all rings and the triangles of all strips. */
static void put_all(const struct rings *rings, struct cml_mesh *mesh)
{
    for (int i = 1; i < rings->radial->n; i++) put_ring(rings, i, mesh);
    put_tip(rings, mesh);
    for (int i = 1; i + 1 < rings->radial->n; i++) put_strip(rings, i, mesh);
}

/* Tessellates a heightfield: chooses the vertices of rings, fills the mesh and prepares it. */
static cml_status make(struct rings *rings, const struct cml_mesh_budget *budget, struct cml_mesh *mesh,
                       struct cml_error *err)
{
    const size_t n = (size_t)rings->radial->n;
    double triangles = 0.0;
    rings->segments = malloc(n * sizeof *rings->segments);
    rings->first = malloc(n * sizeof *rings->first);
    if (!rings->segments || !rings->first)
        return cml_fail_memory(err, (double)n * 16.0, "the rings of a radial heightfield");
    CML_TRY(plan(rings, budget, &triangles, err));
    number_vertices(rings, mesh);
    mesh->normals = rings->options->normals;
    CML_TRY(allocate(mesh, (size_t)triangles, err));
    put_all(rings, mesh);
    const struct cml_mesh_source source = {.path = "radial heightfield"};
    struct cml_mesh_notes notes;
    return cml_mesh_prepare(mesh, &source, &notes, err); /* keeps each slope with its triangle */
}

/* Refuses a heightfield of one sample and a tolerance that is not positive. */
static cml_status check_options(const struct cml_radial *radial, const struct cml_tessellation *options,
                                struct cml_error *err)
{
    if (radial->n < 2)
        return cml_fail(err, CML_E_INPUT, "a radial heightfield needs at least 2 samples to become a mesh");
    if (!(options->tolerance > 0.0))
        return cml_fail(err, CML_E_INPUT, "tolerance = %g (expected a number above 0)", options->tolerance);
    return CML_OK;
}

cml_status cml_tessellate(const struct cml_radial *radial, const struct cml_tessellation *options,
                          const struct cml_mesh_budget *budget, struct cml_mesh *mesh, struct cml_error *err)
{
    memset(mesh, 0, sizeof *mesh);
    CML_TRY(check_options(radial, options, err));
    struct rings rings = {radial, options, NULL, NULL};
    const cml_status status = make(&rings, budget, mesh, err);
    free(rings.segments);
    free(rings.first);
    if (status != CML_OK) cml_mesh_clear(mesh);
    return status;
}
