/* SPDX-License-Identifier: MIT */
#include "surface/body/body_grid.h"

#include "geometry/vec3.h"
#include "scene/body/body_shape.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST_CELLS 262144 /* of a medium: 1 MiB, which a core's cache holds */
#define ALL_CELLS 4194304 /* of all media together */
#define CELLS_PER_MFP 4
#define MARGIN 0.01 /* cells: more than rounding can move a place of a packet into another cell */

/* One medium whose cells are being filled. */
struct filling {
    const struct cml_scene *scene;
    double depth; /* of its frame */
    const struct cml_body_cells *cells;
    float *bound; /* 0 in cells that a surface passes, else infinite, then the square of the distance */
};

static size_t cells_of(const struct cml_body_cells *cells)
{
    return (size_t)cells->n[0] * (size_t)cells->n[1] * (size_t)cells->n[2];
}

/* The bodies whose surfaces are seen from medium m: its own, and those of the bodies in it. */
static bool is_seen(const struct cml_scene *scene, int m, int k)
{
    return scene->bodies[k].host == m || cml_body_medium(scene, k) == m;
}

/* The box of a body, of the frame and with a margin, as ranges of cells. */
static void cell_range(const struct filling *f, const double lower[3], const double upper[3], int from[3],
                       int to[3])
{
    for (int k = 0; k < 3; k++) {
        const double origin = f->cells->corner[k] + (k == 2 ? f->depth : 0);
        const double a = (lower[k] - origin) / f->cells->cell[k] - MARGIN,
                     b = (upper[k] - origin) / f->cells->cell[k] + MARGIN;
        from[k] = (int)fmax(0, fmin(floor(a), f->cells->n[k] - 1));
        to[k] = (int)fmax(0, fmin(floor(b), f->cells->n[k] - 1));
    }
}

static float *cell_at(const struct filling *f, int x, int y, int z)
{
    return f->bound + ((size_t)z * (size_t)f->cells->n[1] + (size_t)y) * (size_t)f->cells->n[0] + (size_t)x;
}

/* The middle of a cell, scene coordinates. */
static void cell_middle(const struct filling *f, int x, int y, int z, double middle[3])
{
    const int at[3] = {x, y, z};
    for (int k = 0; k < 3; k++) middle[k] = f->cells->corner[k] + (at[k] + 0.5) * f->cells->cell[k];
    middle[2] += f->depth;
}

static double half_diagonal(const struct cml_body_cells *cells)
{
    return (0.5 + MARGIN) * cml_vec3_length(cells->cell);
}

/* The cells of a range whose middle is no further than half a diagonal from what `distance` measures. */
typedef double distance_function(const void *context, const double p[3]);

static void mark_range(const struct filling *f, const int from[3], const int to[3],
                       distance_function *distance, const void *context)
{
    const double reach = half_diagonal(f->cells);
    for (int z = from[2]; z <= to[2]; z++)
        for (int y = from[1]; y <= to[1]; y++)
            for (int x = from[0]; x <= to[0]; x++) {
                double middle[3];
                cell_middle(f, x, y, z, middle);
                if (fabs(distance(context, middle)) <= reach) *cell_at(f, x, y, z) = 0;
            }
}

static double distance_to_convex(const void *context, const double p[3])
{
    return cml_convex_distance(context, p);
}

static double distance_to_triangle(const void *context, const double p[3])
{
    double closest[3];
    cml_convex_project(context, p, closest);
    cml_vec3_subtract(closest, p, closest);
    return cml_vec3_length(closest);
}

static void mark_mesh(const struct filling *f, const struct cml_mesh *mesh)
{
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        struct cml_convex triangle = {.form = CML_CONVEX_TRIANGLE};
        double lower[3], upper[3];
        int from[3], to[3];
        for (int k = 0; k < 3; k++) triangle.corner[k] = mesh->vertex[mesh->triangle[t][k]];
        for (int k = 0; k < 3; k++) {
            const double a = triangle.corner[0][k], b = triangle.corner[1][k], c = triangle.corner[2][k];
            lower[k] = fmin(a, fmin(b, c));
            upper[k] = fmax(a, fmax(b, c));
        }
        cell_range(f, lower, upper, from, to);
        mark_range(f, from, to, distance_to_triangle, &triangle);
    }
}

static void mark_body(const struct filling *f, const struct cml_scene_body *body)
{
    double lower[3], upper[3];
    int from[3], to[3];
    if (body->form == CML_BODY_MESH) {
        mark_mesh(f, &body->mesh);
        return;
    }
    const struct cml_convex convex = cml_body_convex(body);
    cml_body_box(body, lower, upper);
    cell_range(f, lower, upper, from, to);
    mark_range(f, from, to, distance_to_convex, &convex);
}

/* Least square of the distance along one axis from every cell of a row to another one, and on from there:
 * between cells i and j lie |i - j| - 1 whole ones. Axis after axis this is the least over all cells, as
 * squares add up [P. F. Felzenszwalb, D. P. Huttenlocher, Theory of Computing 8 (2012) 415, without its
 * envelope: rows are short]. row: [n], step elements apart. */
static void spread_row(float *row, size_t step, int n, double cell, float *scratch)
{
    for (int i = 0; i < n; i++) {
        float best = row[(size_t)i * step];
        for (int j = 0; j < n; j++) {
            const int gap = (i < j ? j - i : i - j) - 1;
            const double way = gap > 0 ? gap * cell : 0;
            const float there = row[(size_t)j * step] + (float)(way * way);
            best = there < best ? there : best;
        }
        scratch[i] = best;
    }
    for (int i = 0; i < n; i++) row[(size_t)i * step] = scratch[i];
}

static void spread(const struct filling *f, float *scratch)
{
    const int *n = f->cells->n;
    for (int z = 0; z < n[2]; z++)
        for (int y = 0; y < n[1]; y++) spread_row(cell_at(f, 0, y, z), 1, n[0], f->cells->cell[0], scratch);
    for (int z = 0; z < n[2]; z++)
        for (int x = 0; x < n[0]; x++)
            spread_row(cell_at(f, x, 0, z), (size_t)n[0], n[1], f->cells->cell[1], scratch);
    for (int y = 0; y < n[1]; y++)
        for (int x = 0; x < n[0]; x++)
            spread_row(cell_at(f, x, y, 0), (size_t)n[0] * (size_t)n[1], n[2], f->cells->cell[2], scratch);
}

/* Roots, less what rounding may take from the way. */
static void finish(const struct filling *f)
{
    const double less = MARGIN * cml_vec3_length(f->cells->cell);
    const size_t count = cells_of(f->cells);
    for (size_t i = 0; i < count; i++) f->bound[i] = (float)fmax(0, 0.999 * sqrt(f->bound[i]) - less);
}

static cml_status fill(const struct filling *f, int m, struct cml_error *err)
{
    const int *n = f->cells->n;
    const size_t longest = (size_t)(n[0] > n[1] ? n[0] : n[1]) + (size_t)n[2], count = cells_of(f->cells);
    float *scratch = malloc(longest * sizeof *scratch);
    if (!scratch) return cml_fail_memory(err, (double)(longest * sizeof *scratch), "the clearance of bodies");
    for (size_t i = 0; i < count; i++) f->bound[i] = INFINITY;
    for (int k = 0; k < f->scene->num_bodies; k++)
        if (count > 1 && is_seen(f->scene, m, k)) mark_body(f, &f->scene->bodies[k]);
    if (count == 1) f->bound[0] = 0;
    spread(f, scratch);
    finish(f);
    free(scratch);
    return CML_OK;
}

/* The box around all bodies seen from m, a little larger; cubes of at least a share of a mean free path, and
 * no more of them than `most`. */
static void lay_out(const struct cml_scene *scene, int m, double depth, double most,
                    struct cml_body_cells *cells)
{
    const struct cml_medium_def *medium = &scene->media[m];
    const double mut = medium->mua + medium->mus;
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY},
           volume = 1;
    for (int k = 0; k < scene->num_bodies; k++) {
        double a[3], b[3];
        if (!is_seen(scene, m, k)) continue;
        cml_body_box(&scene->bodies[k], a, b);
        for (int i = 0; i < 3; i++) {
            lower[i] = fmin(lower[i], a[i]);
            upper[i] = fmax(upper[i], b[i]);
        }
    }
    for (int i = 0; i < 3; i++) volume *= 1.001 * (upper[i] - lower[i]);
    const double width = mut > 0 ? fmax(cbrt(volume / most), 1 / (CELLS_PER_MFP * mut)) : INFINITY;
    for (int i = 0; i < 3; i++) {
        const double size = 1.001 * (upper[i] - lower[i]);
        cells->n[i] = (int)fmax(1, fmin(floor(size / width), most));
        cells->cell[i] = size / cells->n[i];
        cells->corner[i] = 0.5 * (lower[i] + upper[i]) - 0.5 * size;
    }
    cells->corner[2] -= depth;
}

/* Which media have a grid. */
static cml_status find_media(const struct cml_scene *scene, struct cml_body_grids *grids,
                             struct cml_error *err)
{
    const int media = scene->num_layers + 2 + scene->num_bodies;
    grids->of_medium = malloc((size_t)media * sizeof *grids->of_medium);
    if (!grids->of_medium)
        return cml_fail_memory(err, media * (double)sizeof(int), "the clearance of bodies");
    for (int m = 0; m < media; m++) grids->of_medium[m] = -1;
    for (int k = 0; k < scene->num_bodies; k++) grids->of_medium[scene->bodies[k].host] = 0;
    for (int k = 0; k < scene->num_bodies; k++) grids->of_medium[cml_body_medium(scene, k)] = 0;
    for (int m = 0; m < media; m++)
        if (grids->of_medium[m] == 0) grids->of_medium[m] = grids->count++;
    grids->item = calloc((size_t)grids->count + 1, sizeof *grids->item);
    return grids->item
               ? CML_OK
               : cml_fail_memory(err, grids->count * (double)sizeof *grids->item, "the clearance of bodies");
}

cml_status cml_body_grids_create(const struct cml_scene *scene, const double *depths,
                                 struct cml_body_grids *grids, struct cml_error *err)
{
    const int media = scene->num_layers + 2 + scene->num_bodies;
    *grids = (struct cml_body_grids){0};
    CML_TRY(find_media(scene, grids, err));
    const double most = fmax(1, fmin(MOST_CELLS, ALL_CELLS / fmax(1, grids->count)));
    for (int m = 0; m < media; m++) {
        if (grids->of_medium[m] < 0) continue;
        struct cml_body_cells *cells = &grids->item[grids->of_medium[m]];
        lay_out(scene, m, depths[m], most, cells);
        cells->first = grids->num_cells;
        grids->num_cells += cells_of(cells);
    }
    grids->clearance = malloc((grids->num_cells + 1) * sizeof *grids->clearance);
    if (!grids->clearance)
        return cml_fail_memory(err, (double)(grids->num_cells * sizeof(float)), "the clearance of bodies");
    for (int m = 0; m < media; m++) {
        if (grids->of_medium[m] < 0) continue;
        const struct cml_body_cells *cells = &grids->item[grids->of_medium[m]];
        const struct filling f = {scene, depths[m], cells, grids->clearance + cells->first};
        CML_TRY(fill(&f, m, err));
    }
    return CML_OK;
}

void cml_body_grids_clear(struct cml_body_grids *grids)
{
    free(grids->item);
    free(grids->of_medium);
    free(grids->clearance);
    *grids = (struct cml_body_grids){0};
}
