/* Makes the prepared mesh of a heightmap: the merged triangles and the skirt around them.
 * SPDX-License-Identifier: MIT */
#include "scene/heightmap/heightmap.h"

#include "base/array.h"
#include "scene/heightmap/heightmap_split.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The state of making a mesh from a heightmap. */
struct builder {
    const struct cml_heightmap *map;
    size_t (*corner)[3]; /* [count] samples at the corners of the triangles, stored up to `most` triangles */
    size_t count, most;
    uint32_t *vertex; /* [ny][nx] number of the mesh vertex at each sample, from 1; 0: none */
    size_t *rim;      /* [num_rim] samples of the rim that are vertices, counter-clockwise from sample 0, 0 */
    size_t num_rim;
    cml_status status; /* status of storing triangles; a failure ends it */
    struct cml_error *err;
};

/* Adds a triangle to the mesh of a heightmap, and marks the samples that it uses as vertices. cml_split_walk
 * calls it for each triangle. */
static void add_triangle(void *context, const size_t corner[3])
{
    struct builder *b = context;
    for (int k = 0; k < 3; k++) b->vertex[corner[k]] = 1;
    if (b->count < b->most && b->status == CML_OK) /* those beyond the budget are counted, but not stored */
        b->status =
            cml_array_grow(&b->corner, b->count, sizeof *b->corner, "the triangles of a heightmap", b->err);
    if (b->count < b->most && b->status == CML_OK) memcpy(b->corner[b->count], corner, sizeof *b->corner);
    b->count++;
}

/* ---- the rim ---- */

/* Returns the number of samples on the rim. */
static size_t rim_length(const struct cml_heightmap *map)
{
    return 2 * ((size_t)map->nx - 1) + 2 * ((size_t)map->ny - 1);
}

/* Returns sample k of the rim, 0 <= k < rim_length, counter-clockwise. *side: 0 low y, 1 high x, 2 high y, 3
 * low x. */
static size_t rim_sample(const struct cml_heightmap *map, size_t k, int *side)
{
    const size_t nx = (size_t)map->nx, x = nx - 1, y = (size_t)map->ny - 1;
    *side = k < x ? 0 : k < x + y ? 1 : k < 2 * x + y ? 2 : 3;
    if (*side == 0) return k;
    if (*side == 1) return (k - x) * nx + x;
    if (*side == 2) return y * nx + (2 * x + y - k);
    return (2 * x + 2 * y - k) * nx;
}

/* Returns the mean height along the rim, by the trapezoidal rule, because spacings along x and y may
 * differ. */
static double rim_mean(const struct cml_heightmap *map)
{
    const size_t length = rim_length(map);
    double sum = 0, weight = 0;
    int side = 0, next_side = 0;
    for (size_t k = 0; k < length; k++) {
        const size_t here = rim_sample(map, k, &side), next = rim_sample(map, (k + 1) % length, &next_side);
        const double step = side % 2 == 0 ? map->dx : map->dy;
        sum += step * (map->h[here] + map->h[next]) / 2;
        weight += step;
    }
    return sum / weight;
}

/* Lists the samples of the rim that merged triangles still use. The skirt's inner vertices are exactly these
 * samples; otherwise slits would open between map and skirt. */
static void list_rim(struct builder *b)
{
    const size_t length = rim_length(b->map);
    int side = 0;
    for (size_t k = 0; k < length; k++) {
        const size_t sample = rim_sample(b->map, k, &side);
        if (b->vertex[sample]) b->rim[b->num_rim++] = sample;
    }
}

/* ---- the mesh ---- */

/* Returns the place of a sample as a vertex. z points down, hence the sign of the height. */
static void position_of(const struct cml_heightmap *map, size_t sample, double out[3])
{
    const size_t nx = (size_t)map->nx;
    out[0] = map->x0 + (double)(sample % nx) * map->dx;
    out[1] = map->y0 + (double)(sample / nx) * map->dy;
    out[2] = -map->h[sample];
}

static size_t add_vertex(struct cml_mesh *mesh, double x, double y, double z)
{
    double *v = mesh->vertex[mesh->num_vertices];
    v[0] = x;
    v[1] = y;
    v[2] = z;
    return mesh->num_vertices++;
}

/* Adds the outer vertex of the skirt beyond the rim vertex `from`, in the direction of the signs sx and
 * sy. */
static size_t add_outside(const struct cml_heightmap_notes *notes, struct cml_mesh *mesh, size_t from, int sx,
                          int sy)
{
    const double *v = mesh->vertex[from];
    return add_vertex(mesh, v[0] + sx * notes->skirt[0], v[1] + sy * notes->skirt[1], -notes->rim_mean);
}

/* Adds the skirt, the strip of triangles between the scan and the outer plane, along the whole rim of the
 * map. At a corner of the map the skirt gets three outer vertices: one straight out of either side, and one
 * in the corner between them. */
static void add_skirt(const struct builder *b, const struct cml_heightmap_notes *notes, struct cml_mesh *mesh)
{
    static const int sx[4] = {0, 1, 0, -1}, sy[4] = {-1, 0, 1, 0};
    const size_t nx = (size_t)b->map->nx, last = nx * (size_t)b->map->ny - 1;
    /* Side s of the rim runs from corner s to corner s + 1. */
    const size_t corners[4] = {0, nx - 1, last, last - (nx - 1)};
    size_t first_outer = 0, outer = 0;
    int side = 3;
    for (size_t i = 0; i <= b->num_rim; i++) {
        const size_t sample = b->rim[i % b->num_rim], here = b->vertex[sample] - 1;
        if (i > 0) {
            const size_t before = b->vertex[b->rim[i - 1]] - 1, old = outer;
            outer = add_outside(notes, mesh, here, sx[side], sy[side]);
            cml_mesh_add_triangle(mesh, before, old, outer);
            cml_mesh_add_triangle(mesh, before, outer, here);
        }
        if (i == b->num_rim || sample != corners[(side + 1) % 4]) continue;
        const int next = (side + 1) % 4;
        const size_t diagonal = add_outside(notes, mesh, here, sx[side] + sx[next], sy[side] + sy[next]);
        const size_t onward = add_outside(notes, mesh, here, sx[next], sy[next]);
        if (i > 0) cml_mesh_add_triangle(mesh, here, outer, diagonal);
        if (i == 0) first_outer = diagonal;
        cml_mesh_add_triangle(mesh, here, diagonal, onward);
        outer = onward;
        side = next;
    }
    cml_mesh_add_triangle(mesh, b->vertex[b->rim[0]] - 1, outer, first_outer);
}

/* Builds the mesh. Vertices are numbered in the order of the samples, so that a map where no triangles were
 * merged stays a regular grid, row by row. */
static cml_status build(struct builder *b, const struct cml_heightmap_notes *notes, struct cml_mesh *mesh,
                        struct cml_error *err)
{
    const size_t samples = (size_t)b->map->nx * (size_t)b->map->ny;
    size_t vertices = b->num_rim + 8;
    for (size_t i = 0; i < samples; i++) vertices += b->vertex[i];
    const size_t triangles = b->count + 2 * b->num_rim + 8;
    CML_TRY(cml_mesh_allocate(mesh, vertices, triangles, "a mesh", err));
    for (size_t i = 0; i < samples; i++) {
        if (!b->vertex[i]) continue;
        position_of(b->map, i, mesh->vertex[mesh->num_vertices++]);
        b->vertex[i] = (uint32_t)mesh->num_vertices;
    }
    for (size_t t = 0; t < b->count; t++)
        cml_mesh_add_triangle(mesh, b->vertex[b->corner[t][0]] - 1, b->vertex[b->corner[t][1]] - 1,
                              b->vertex[b->corner[t][2]] - 1);
    add_skirt(b, notes, mesh);
    return CML_OK;
}

/* ---- the notes ---- */

/* Measures the rim of a heightmap: its mean height, and its largest distance from the mean. Sets the skirt's
 * width to this distance or to one cell, whichever is larger, so that the skirt is nowhere steeper than 45
 * degrees. */
static void note_rim(const struct cml_heightmap *map, struct cml_heightmap_notes *notes)
{
    const size_t length = rim_length(map);
    int side = 0;
    notes->rim_mean = rim_mean(map);
    for (size_t k = 0; k < length; k++) {
        const double step = fabs(map->h[rim_sample(map, k, &side)] - notes->rim_mean);
        notes->rim_step = fmax(notes->rim_step, step);
    }
    notes->skirt[0] = fmax(map->dx, notes->rim_step);
    notes->skirt[1] = fmax(map->dy, notes->rim_step);
}

/* Fills the notes of a heightmap. The tolerance is relative to the range of heights, so that it depends
 * neither on units nor on the height's origin. */
static void note_map(const struct cml_heightmap *map, double tolerance, struct cml_heightmap_notes *notes)
{
    *notes = (struct cml_heightmap_notes){.nx = map->nx, .ny = map->ny, .dx = map->dx, .dy = map->dy};
    cml_heightmap_measure(map, map->h, &notes->relief);
    notes->tolerance = tolerance * (notes->relief.highest - notes->relief.lowest);
    notes->cells = ((size_t)map->nx - 1) * ((size_t)map->ny - 1);
    note_rim(map, notes);
}

/* Measures height and slope errors at the samples. Both surfaces are linear over the same finest triangles,
 * so their difference is largest at a sample. */
static void note_errors(const struct cml_heightmap *map, double *surface, struct cml_heightmap_notes *notes)
{
    struct cml_relief difference;
    for (size_t i = 0; i < (size_t)map->nx * (size_t)map->ny; i++) surface[i] -= map->h[i];
    cml_heightmap_measure(map, surface, &difference);
    notes->height_error = fmax(difference.highest, -difference.lowest);
    notes->slope_error = difference.slope_rms;
}

/* Joins small triangles of a heightmap to larger ones as far as the tolerance allows, and checks their
 * number against the budget. */
static cml_status merge(struct builder *b, double tolerance, const struct cml_mesh_budget *budget,
                        double *surface, struct cml_error *err)
{
    struct cml_split split;
    CML_TRY(cml_split_create(b->map, &split, err));
    cml_split_walk(&split, tolerance, surface, add_triangle, b);
    cml_split_free(&split);
    CML_TRY(b->status);
    list_rim(b);
    const size_t with_skirt = b->count + 2 * b->num_rim + 8;
    return cml_mesh_budget_check(budget, (double)with_skirt, "a larger --tolerance or --mesh-budget", err);
}

/* Frees what the builder of a mesh has used. */
static void clear(struct builder *b, double *surface)
{
    free(surface);
    free(b->corner);
    free(b->vertex);
    free(b->rim);
}

/* Samples are merged first, and only the merged triangles and their corners are stored. A large map therefore
 * never has all its triangles in memory. */
cml_status cml_heightmap_mesh(const struct cml_heightmap *map, double tolerance, enum cml_normals normals,
                              const struct cml_mesh_budget *budget, struct cml_mesh *mesh,
                              struct cml_heightmap_notes *notes, struct cml_error *err)
{
    const size_t samples = (size_t)map->nx * (size_t)map->ny;
    struct builder b = {.map = map,
                        .most = (size_t)(budget && budget->most > 0 ? budget->most : CML_MESH_MOST),
                        .vertex = calloc(samples, sizeof *b.vertex),
                        .rim = malloc(rim_length(map) * sizeof *b.rim),
                        .err = err};
    double *surface = malloc(samples * sizeof *surface);
    *mesh = (struct cml_mesh){.normals = normals};
    note_map(map, tolerance, notes);
    cml_status status = CML_OK;
    if (!b.vertex || !b.rim || !surface) status = cml_fail_memory(err, 12 * (double)samples, "a heightmap");
    if (status == CML_OK) status = merge(&b, notes->tolerance, budget, surface, err);
    if (status == CML_OK) {
        notes->triangles = b.count;
        note_errors(map, surface, notes);
        status = build(&b, notes, mesh, err);
    }
    clear(&b, surface);
    if (status == CML_OK) status = cml_mesh_prepare(mesh, NULL, NULL, err);
    if (status != CML_OK) cml_mesh_clear(mesh);
    return status;
}
