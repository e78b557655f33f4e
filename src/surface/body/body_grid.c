/* SPDX-License-Identifier: MIT */
#include "surface/body/body_grid.h"

#include "geometry/vec3.h"
#include "scene/body/body_shape.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST_CELLS 32768 /* of a layer: 128 KiB, which a core's cache holds beside all else */
#define CELLS_PER_MFP 8
#define MARGIN 0.01f /* cells: more than rounding can move a packet, or a body */
#define BAND 1       /* whole cells around the box of a triangle or a body that know their distance from it */
#define BEYOND 1.5f  /* cells: so far at least are the middles of all others */
#define HALF_DIAGONAL 0.8661f /* cells */

/* One layer whose cells are being filled. In cells: */
struct filling {
    const struct cml_scene *scene;
    double depth; /* of its frame, cm */
    const struct cml_body_cells *cells;
    float *near; /* distance of the middle from the closest surface whose band it is in */
    float *far;  /* a lower bound of it from all: between cells that surfaces pass; squared at first */
};

static size_t cells_of(const struct cml_body_cells *cells)
{
    return (size_t)cells->n[0] * (size_t)cells->n[1] * (size_t)cells->n[2];
}

/* The cells in and around a box, scene coordinates, as ranges. */
static void cell_range(const struct filling *f, const double lower[3], const double upper[3], int from[3],
                       int to[3])
{
    for (int k = 0; k < 3; k++) {
        const double origin = f->cells->corner[k] + (k == 2 ? f->depth : 0);
        const double a = (lower[k] - origin) / f->cells->cell - BAND,
                     b = (upper[k] - origin) / f->cells->cell + BAND;
        from[k] = (int)fmax(0, fmin(floor(a), f->cells->n[k] - 1));
        to[k] = (int)fmax(0, fmin(floor(b), f->cells->n[k] - 1));
    }
}

static size_t cell_at(const struct filling *f, int x, int y, int z)
{
    return ((size_t)z * (size_t)f->cells->n[1] + (size_t)y) * (size_t)f->cells->n[0] + (size_t)x;
}

/* Scene coordinates. */
static void cell_middle(const struct filling *f, int x, int y, int z, double middle[3])
{
    const int at[3] = {x, y, z};
    for (int k = 0; k < 3; k++) middle[k] = f->cells->corner[k] + (at[k] + 0.5) * f->cells->cell;
    middle[2] += f->depth;
}

/* From a place to a surface, cm; below 0 inside. */
typedef double distance_function(const struct cml_convex *convex, const double p[3]);

static double distance_to_triangle(const struct cml_convex *triangle, const double p[3])
{
    double closest[3];
    cml_convex_project(triangle, p, closest);
    cml_vec3_subtract(closest, p, closest);
    return cml_vec3_length(closest);
}

static void fill_band(const struct filling *f, const double lower[3], const double upper[3],
                      distance_function *distance, const struct cml_convex *convex)
{
    int from[3], to[3];
    cell_range(f, lower, upper, from, to);
    for (int z = from[2]; z <= to[2]; z++)
        for (int y = from[1]; y <= to[1]; y++)
            for (int x = from[0]; x <= to[0]; x++) {
                double middle[3];
                cell_middle(f, x, y, z, middle);
                float *cell = &f->near[cell_at(f, x, y, z)];
                *cell = fminf(*cell, (float)(fabs(distance(convex, middle)) / f->cells->cell));
            }
}

static void add_mesh(const struct filling *f, const struct cml_mesh *mesh)
{
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        struct cml_convex triangle = {.form = CML_CONVEX_TRIANGLE};
        double lower[3], upper[3];
        for (int k = 0; k < 3; k++) triangle.corner[k] = mesh->vertex[mesh->triangle[t][k]];
        for (int k = 0; k < 3; k++) {
            const double a = triangle.corner[0][k], b = triangle.corner[1][k], c = triangle.corner[2][k];
            lower[k] = fmin(a, fmin(b, c));
            upper[k] = fmax(a, fmax(b, c));
        }
        fill_band(f, lower, upper, distance_to_triangle, &triangle);
    }
}

static void add_body(const struct filling *f, const struct cml_scene_body *body)
{
    double lower[3], upper[3];
    if (body->form == CML_BODY_MESH) {
        add_mesh(f, &body->mesh);
        return;
    }
    const struct cml_convex convex = cml_body_convex(body);
    cml_body_box(body, lower, upper);
    fill_band(f, lower, upper, cml_convex_distance, &convex);
}

/* Least square of the distance along one axis from every middle of a row to another cell, and on from there.
 * Axis after axis this is the least over all cells, as squares add up [P. F. Felzenszwalb, D. P.
 * Huttenlocher, Theory of Computing 8 (2012) 415, without its envelope: rows are short]. row: [n], step
 * elements apart. */
static void spread_row(float *row, size_t step, int n, float *scratch)
{
    for (int i = 0; i < n; i++) {
        float best = row[(size_t)i * step];
        for (int j = 0; j < n; j++) {
            const float way = i == j ? 0 : (float)(i < j ? j - i : i - j) - 0.5f;
            const float there = row[(size_t)j * step] + way * way;
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
        for (int y = 0; y < n[1]; y++) spread_row(f->far + cell_at(f, 0, y, z), 1, n[0], scratch);
    for (int z = 0; z < n[2]; z++)
        for (int x = 0; x < n[0]; x++) spread_row(f->far + cell_at(f, x, 0, z), (size_t)n[0], n[1], scratch);
    for (int y = 0; y < n[1]; y++)
        for (int x = 0; x < n[0]; x++)
            spread_row(f->far + cell_at(f, x, y, 0), (size_t)n[0] * (size_t)n[1], n[2], scratch);
}

/* A surface passes only cells whose middle is within half a diagonal of it. Near ones are exact up to BEYOND:
 * what does not have a middle in its band is further away. */
static cml_status fill(struct filling *f, int layer, struct cml_error *err)
{
    const int *n = f->cells->n;
    const size_t longest = (size_t)n[0] + (size_t)n[1] + (size_t)n[2], count = cells_of(f->cells);
    f->far = malloc((count + longest) * sizeof *f->far);
    if (!f->far) return cml_fail_memory(err, (double)(count * sizeof *f->far), "the clearance of bodies");
    for (size_t i = 0; i < count; i++) f->near[i] = INFINITY;
    for (int k = 0; k < f->scene->num_bodies; k++)
        if (f->scene->bodies[k].layer == layer) add_body(f, &f->scene->bodies[k]);
    for (size_t i = 0; i < count; i++) f->far[i] = f->near[i] < HALF_DIAGONAL + MARGIN ? 0 : INFINITY;
    spread(f, f->far + count);
    for (size_t i = 0; i < count; i++)
        f->near[i] = fmaxf(0, fmaxf(fminf(f->near[i], BEYOND), sqrtf(f->far[i])) - MARGIN);
    free(f->far);
    return CML_OK;
}

/* The mean free path of the thickest medium of a layer, its bodies among them. */
static double shortest_path(const struct cml_scene *scene, int layer)
{
    double mut = scene->media[layer].mua + scene->media[layer].mus;
    for (int k = 0; k < scene->num_bodies; k++) {
        const struct cml_medium_def *medium = &scene->media[cml_body_medium(scene, k)];
        if (scene->bodies[k].layer == layer) mut = fmax(mut, medium->mua + medium->mus);
    }
    return 1 / mut;
}

static void box_of_bodies(const struct cml_scene *scene, int layer, double lower[3], double upper[3])
{
    for (int i = 0; i < 3; i++) {
        lower[i] = INFINITY;
        upper[i] = -INFINITY;
    }
    for (int k = 0; k < scene->num_bodies; k++) {
        double a[3], b[3];
        if (scene->bodies[k].layer != layer) continue;
        cml_body_box(&scene->bodies[k], a, b);
        for (int i = 0; i < 3; i++) {
            lower[i] = fmin(lower[i], a[i]);
            upper[i] = fmax(upper[i], b[i]);
        }
    }
}

/* The box around all bodies of the layer; cubes, about MOST_CELLS of them at most. */
static void lay_out(const struct cml_scene *scene, int layer, double depth, struct cml_body_cells *cells)
{
    double lower[3], upper[3], volume = 1, widest = 0;
    box_of_bodies(scene, layer, lower, upper);
    for (int i = 0; i < 3; i++) {
        volume *= upper[i] - lower[i];
        widest = fmax(widest, upper[i] - lower[i]);
    }
    const double least = fmax(cbrt(volume / MOST_CELLS), widest / 1000);
    cells->cell = fmin(widest, fmax(least, shortest_path(scene, layer) / CELLS_PER_MFP));
    for (int i = 0; i < 3; i++) {
        cells->n[i] = (int)ceil((upper[i] - lower[i]) / cells->cell * (1 + 1e-6));
        cells->corner[i] = 0.5 * (lower[i] + upper[i]) - 0.5 * cells->n[i] * cells->cell;
    }
    cells->corner[2] -= depth;
}

/* Which layers have a grid; their bodies have the same. */
static cml_status find_media(const struct cml_scene *scene, struct cml_body_grids *grids,
                             struct cml_error *err)
{
    const int media = scene->num_layers + 2 + scene->num_bodies;
    int *of_medium = malloc((size_t)media * sizeof *of_medium);
    if (!of_medium) return cml_fail_memory(err, media * (double)sizeof(int), "the clearance of bodies");
    grids->of_medium = of_medium;
    for (int m = 0; m < media; m++) of_medium[m] = -1;
    for (int k = 0; k < scene->num_bodies; k++) of_medium[scene->bodies[k].layer] = 0;
    for (int m = 0; m < media; m++)
        if (of_medium[m] == 0) of_medium[m] = grids->count++;
    for (int k = 0; k < scene->num_bodies; k++)
        of_medium[cml_body_medium(scene, k)] = of_medium[scene->bodies[k].layer];
    grids->item = calloc((size_t)grids->count + 1, sizeof *grids->item);
    if (grids->item) return CML_OK;
    return cml_fail_memory(err, grids->count * (double)sizeof *grids->item, "the clearance of bodies");
}

cml_status cml_body_grids_create(const struct cml_scene *scene, const double *depths,
                                 struct cml_body_grids *grids, struct cml_error *err)
{
    *grids = (struct cml_body_grids){0};
    CML_TRY(find_media(scene, grids, err));
    for (int l = 1; l <= scene->num_layers; l++) {
        if (grids->of_medium[l] < 0) continue;
        struct cml_body_cells *cells = &grids->item[grids->of_medium[l]];
        lay_out(scene, l, depths[l], cells);
        cells->first = grids->num_cells;
        grids->num_cells += cells_of(cells);
    }
    grids->clearance = malloc((grids->num_cells + 1) * sizeof *grids->clearance);
    if (!grids->clearance)
        return cml_fail_memory(err, (double)(grids->num_cells * sizeof(float)), "the clearance of bodies");
    for (int l = 1; l <= scene->num_layers; l++) {
        if (grids->of_medium[l] < 0) continue;
        const struct cml_body_cells *cells = &grids->item[grids->of_medium[l]];
        struct filling f = {scene, depths[l], cells, grids->clearance + cells->first, NULL};
        CML_TRY(fill(&f, l, err));
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
