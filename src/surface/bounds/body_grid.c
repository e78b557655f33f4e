/* Fills the grids of cubes around bodies: distances, patches and balls. SPDX-License-Identifier: MIT */
#include "surface/bounds/body_grid.h"

#include "base/array.h"
#include "geometry/vec3.h"
#include "scene/body/body_shape.h"
#include "types.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST_CELLS 8192                /* cells of a layer: 256 KiB, for a core's cache beside all else */
#define MOST_OF_ALL (512 * MOST_CELLS) /* cells of all layers: 128 MiB */
#define CELLS_PER_MFP 8
#define BAND 1 /* whole cells around the box of a body or triangle whose distances are computed */
/* A distance in cells: the middle of a cell outside the band of a body or triangle is at least so far away
 * from it. */
#define BEYOND 1.5f
#define PAD 2 /* cells around the box of all bodies */
/* Smallest size of a cell, in roundings of the largest coordinate. CML_CELL_MARGIN of a cell is then eight
 * roundings. A packet's place, its path and the grid's corner need one or two of these each. */
#define LEAST_ROUNDINGS (8 / CML_CELL_MARGIN)

/* A layer whose cells are being filled. Lengths are in cells unless stated otherwise. */
struct filling {
    const struct cml_scene *scene;
    double depth; /* depth of the layer's frame, cm */
    const struct cml_body_cells *cells;
    float *closest; /* distance of each cell's middle from the closest surface, INFINITY if none has the cell
                       in its band; at last a lower bound of the distance */
    float *far;     /* lower bound of each middle's distance from all surfaces, from the cells that
                       surfaces pass; squared at first */
    struct cml_body_patch *patch;
    int *next;                /* next occupied cell in the row of each cell, from cml_patch_rows */
    struct cell_facet *facet; /* [num_facets] facets near the cells */
    size_t num_facets;
    cml_status status; /* status of storing facets; a failure ends it */
    struct cml_error *err;
};

/* Frees the arrays of a layer whose cells have been filled. */
static void clear_filling(struct filling *f)
{
    free(f->closest);
    free(f->far);
    free(f->patch);
    free(f->next);
    free(f->facet);
}

/* A facet that comes within CML_CELL_REACH of a cell's middle. */
struct cell_facet {
    size_t cell, triangle;
    int body;
};

/* Returns the number of cells of a layer. */
static size_t cells_of(const struct cml_body_cells *cells)
{
    return (size_t)cells->n[0] * (size_t)cells->n[1] * (size_t)cells->n[2];
}

/* Finds the range of cells in and around a box given in scene coordinates. */
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

/* Returns the number of a cell in its layer, x fastest. */
static size_t cell_at(const struct filling *f, int x, int y, int z)
{
    return ((size_t)z * (size_t)f->cells->n[1] + (size_t)y) * (size_t)f->cells->n[0] + (size_t)x;
}

/* Computes the middle of a cell in scene coordinates, cm. */
static void cell_middle(const struct filling *f, int x, int y, int z, double middle[3])
{
    const int at[3] = {x, y, z};
    for (int k = 0; k < 3; k++) middle[k] = f->cells->corner[k] + (at[k] + 0.5) * f->cells->cell;
    middle[2] += f->depth;
}

/* Keeps a facet for later, because a patch of several facets needs their mean normal before it can measure
 * heights along this normal. */
static void add_facet(struct filling *f, size_t cell, int body, size_t triangle)
{
    if (f->status == CML_OK)
        f->status =
            cml_array_grow(&f->facet, f->num_facets, sizeof *f->facet, "the bounds of bodies", f->err);
    if (f->status == CML_OK) f->facet[f->num_facets++] = (struct cell_facet){cell, triangle, body};
}

/* A body, or a triangle of its mesh. */
struct part {
    struct cml_convex convex;
    double lower[3], upper[3];
    int body;
    size_t triangle;
};

/* Returns the distance of p from the surface of a part (sphere, cylinder or triangle), cm. */
static double distance_to(const struct part *part, const double p[3])
{
    double closest[3];
    if (part->convex.form != CML_CONVEX_TRIANGLE) return fabs(cml_convex_distance(&part->convex, p));
    cml_convex_project(&part->convex, p, closest);
    cml_vec3_subtract(closest, p, closest);
    return cml_vec3_length(closest);
}

/* Lowers the distance of a cell's middle from the closest surface to that of a part (a body or a facet). Adds
 * the part to the cell's patch if the part may pass the cell. */
static void fill_cell(struct filling *f, const struct part *part, int x, int y, int z)
{
    double middle[3];
    const size_t cell = cell_at(f, x, y, z);
    cell_middle(f, x, y, z, middle);
    const double distance = distance_to(part, middle) / f->cells->cell;
    f->closest[cell] = fminf(f->closest[cell], (float)distance);
    if (distance > CML_CELL_REACH) return;
    if (part->convex.form == CML_CONVEX_TRIANGLE)
        add_facet(f, cell, part->body, part->triangle);
    else
        cml_patch_add_convex(part->body, &part->convex, middle, f->cells->cell, &f->patch[cell]);
}

/* Updates the cells that a part (sphere, cylinder or triangle) touches, and BAND more cells around it: the
 * distance to the nearest surface. */
static void fill_band(struct filling *f, const struct part *part)
{
    int from[3], to[3];
    cell_range(f, part->lower, part->upper, from, to);
    for (int z = from[2]; z <= to[2]; z++)
        for (int y = from[1]; y <= to[1]; y++)
            for (int x = from[0]; x <= to[0]; x++) fill_cell(f, part, x, y, z);
}

/* Adds the triangles of a body's mesh to the parts that surround cells, each with its bounding box. */
static void add_mesh(struct filling *f, int body)
{
    const struct cml_mesh *mesh = &f->scene->bodies[body].mesh;
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        struct part part = {.convex.form = CML_CONVEX_TRIANGLE, .body = body, .triangle = t};
        for (int k = 0; k < 3; k++) part.convex.corner[k] = mesh->vertex[mesh->triangle[t][k]];
        for (int k = 0; k < 3; k++) {
            const double a = part.convex.corner[0][k], b = part.convex.corner[1][k],
                         c = part.convex.corner[2][k];
            part.lower[k] = fmin(a, fmin(b, c));
            part.upper[k] = fmax(a, fmax(b, c));
        }
        fill_band(f, &part);
    }
}

/* Adds a body to the cells near its surface: a sphere or cylinder as a whole, a mesh triangle by triangle. */
static void add_body(struct filling *f, int body)
{
    const struct cml_scene_body *from = &f->scene->bodies[body];
    struct part part = {.body = body};
    if (from->form == CML_BODY_MESH) {
        add_mesh(f, body);
        return;
    }
    part.convex = cml_body_convex(from);
    cml_body_box(from, part.lower, part.upper);
    fill_band(f, &part);
}

/* Computes the corners of a facet relative to the middle of its cell, in cells. */
static void facet_corners(const struct filling *f, const struct cell_facet *facet, double corner[3][3])
{
    const struct cml_mesh *mesh = &f->scene->bodies[facet->body].mesh;
    const size_t nx = (size_t)f->cells->n[0], ny = (size_t)f->cells->n[1];
    double middle[3];
    cell_middle(f, (int)(facet->cell % nx), (int)(facet->cell / nx % ny), (int)(facet->cell / nx / ny),
                middle);
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++)
            corner[k][i] = (mesh->vertex[mesh->triangle[facet->triangle][k]][i] - middle[i]) / f->cells->cell;
}

/* Bounds the facets of meshes in each cell by a patch, two parallel planes: first the mean normals, then the
 * heights along them, then unit normals. A patch of several facets is normalised several times, which
 * changes nothing. */
static void make_mesh_patches(const struct filling *f)
{
    double corner[3][3];
    for (size_t i = 0; i < f->num_facets; i++) {
        facet_corners(f, &f->facet[i], corner);
        cml_patch_add_normal(f->facet[i].body, (const double(*)[3])corner, &f->patch[f->facet[i].cell]);
    }
    for (size_t i = 0; i < f->num_facets; i++) {
        facet_corners(f, &f->facet[i], corner);
        cml_patch_add_heights((const double(*)[3])corner, &f->patch[f->facet[i].cell]);
    }
    for (size_t i = 0; i < f->num_facets; i++) cml_vec3_normalise(f->patch[f->facet[i].cell].normal);
}

/* Sets each element of a row to the least square of the distance from its middle to another cell, plus that
 * cell's value, along one axis. Done for all three axes in turn, this gives the least squared distance over
 * all cells, because squares add up [P. F. Felzenszwalb, D. P. Huttenlocher, Theory of Computing 8 (2012)
 * 415, without its envelope: rows are short]. row: [n], step elements apart. */
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

/* Computes each cell's distance to the nearest marked cell from distances along x, then y, then z. scratch:
 * as long as the longest row. */
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

/* Finds the distance of every middle from all surfaces. A surface passes only cells whose middle is within
 * half a diagonal of it. Distances up to BEYOND are exact, because a surface without the middle in its band
 * is further away. */
static void find_distances(struct filling *f)
{
    const size_t count = cells_of(f->cells);
    for (size_t i = 0; i < count; i++)
        f->far[i] = f->closest[i] < (float)(CML_CELL_REACH + CML_CELL_MARGIN) ? 0 : INFINITY;
    spread(f, f->far + count);
    for (size_t i = 0; i < count; i++)
        f->closest[i] =
            fmaxf(0, fmaxf(fminf(f->closest[i], BEYOND), sqrtf(f->far[i])) - (float)CML_CELL_MARGIN);
}

/* Finds for each cell a ball around it that is free of surfaces, or in which two planes bound them. This is
 * the last step, because a ball includes the patches of many cells. */
static void make_balls(const struct filling *f, struct cml_body_ball *ball)
{
    const int *n = f->cells->n;
    cml_patch_rows(n, f->patch, f->closest, f->next);
    for (int z = 0; z < n[2]; z++)
        for (int y = 0; y < n[1]; y++)
            for (int x = 0; x < n[0]; x++) {
                const size_t cell = cell_at(f, x, y, z);
                const int at[3] = {x, y, z};
                ball[cell] = cml_body_ball_of(f->cells->n, f->patch, f->closest, f->next, at);
            }
}

/* Marks all cells as empty and far from any surface. */
static void prepare_cells(struct filling *f)
{
    for (size_t i = 0; i < cells_of(f->cells); i++) {
        f->closest[i] = INFINITY;
        f->patch[i].body = CML_PATCH_NONE;
    }
}

/* Fills the cells of layer `layer`: how far each cell is from any body, and what passes near. From that
 * follows for each cell a ball that is free of surfaces. Bodies are entered first, then distances, then
 * balls. */
static cml_status fill(struct filling *f, int layer, struct cml_body_ball *ball, struct cml_error *err)
{
    const int *n = f->cells->n;
    const size_t longest = (size_t)n[0] + (size_t)n[1] + (size_t)n[2], count = cells_of(f->cells);
    const struct cml_body_range bodies = cml_layer_bodies(f->scene, layer);
    f->closest = malloc(count * sizeof *f->closest);
    f->far = malloc((count + longest) * sizeof *f->far);
    f->patch = malloc(count * sizeof *f->patch);
    f->next = malloc(count * sizeof *f->next);
    if (!f->closest || !f->far || !f->patch || !f->next)
        return cml_fail_memory(err, (double)(count * sizeof *f->patch), "the bounds of bodies");
    prepare_cells(f);
    for (int k = bodies.first; k < bodies.end; k++) add_body(f, k);
    CML_TRY(f->status);
    make_mesh_patches(f);
    find_distances(f);
    make_balls(f, ball);
    return CML_OK;
}

/* Returns the shortest mean free path in a layer and its bodies, cm. */
static double shortest_path(const struct cml_scene *scene, int layer)
{
    double mut = cml_medium_mut(&scene->media[layer]);
    const struct cml_body_range bodies = cml_layer_bodies(scene, layer);
    for (int k = bodies.first; k < bodies.end; k++) {
        const struct cml_medium_def *medium = &scene->media[cml_body_medium(scene, k)];
        mut = fmax(mut, cml_medium_mut(medium));
    }
    return 1 / mut;
}

/* Computes the box around all bodies of a layer, in scene coordinates, cm. */
static void box_of_bodies(const struct cml_scene *scene, int layer, double lower[3], double upper[3])
{
    for (int i = 0; i < 3; i++) {
        lower[i] = INFINITY;
        upper[i] = -INFINITY;
    }
    const struct cml_body_range bodies = cml_layer_bodies(scene, layer);
    for (int k = bodies.first; k < bodies.end; k++) {
        double a[3], b[3];
        cml_body_box(&scene->bodies[k], a, b);
        for (int i = 0; i < 3; i++) {
            lower[i] = fmin(lower[i], a[i]);
            upper[i] = fmax(upper[i], b[i]);
        }
    }
}

/* Chooses the grid of a layer: cubic cells over the box around all bodies of the layer, and PAD more cells on
 * each side. The grid has about `most` cells or fewer. */
static void lay_out(const struct cml_scene *scene, const double origin[2], int layer, double depth,
                    double most, struct cml_body_cells *cells)
{
    const double from[3] = {origin[0], origin[1], depth};
    double lower[3], upper[3], volume = 1, widest = 0, farthest = 0;
    box_of_bodies(scene, layer, lower, upper);
    for (int i = 0; i < 3; i++) {
        volume *= upper[i] - lower[i];
        widest = fmax(widest, upper[i] - lower[i]);
        farthest = fmax(farthest, fmax(fabs(lower[i] - from[i]), fabs(upper[i] - from[i])));
    }
    const double least = fmax(cbrt(volume / most), widest / 1000);
    cells->cell = fmin(widest, fmax(least, shortest_path(scene, layer) / CELLS_PER_MFP));
    cells->cell = fmax(cells->cell, LEAST_ROUNDINGS * FLT_EPSILON * farthest);
    for (int i = 0; i < 3; i++) {
        cells->n[i] = (int)ceil((upper[i] - lower[i]) / cells->cell * (1 + 1e-6)) + 2 * PAD;
        cells->corner[i] = 0.5 * (lower[i] + upper[i]) - 0.5 * cells->n[i] * cells->cell;
    }
    cells->corner[2] -= depth;
}

/* Finds the layers that hold bodies; each of them gets a grid. A body's medium uses the grid of its layer,
 * because light inside the body meets the same surfaces. */
static cml_status find_media(const struct cml_scene *scene, struct cml_body_grids *grids,
                             struct cml_error *err)
{
    const int media = scene->num_layers + 2 + scene->num_bodies;
    int *of_medium = malloc((size_t)media * sizeof *of_medium);
    if (!of_medium) return cml_fail_memory(err, media * (double)sizeof(int), "the bounds of bodies");
    grids->of_medium = of_medium;
    for (int m = 0; m < media; m++) of_medium[m] = -1;
    for (int k = 0; k < scene->num_bodies; k++) of_medium[scene->bodies[k].layer] = 0;
    for (int m = 0; m < media; m++)
        if (of_medium[m] == 0) of_medium[m] = grids->count++;
    for (int k = 0; k < scene->num_bodies; k++)
        of_medium[cml_body_medium(scene, k)] = of_medium[scene->bodies[k].layer];
    grids->item = calloc((size_t)grids->count + 1, sizeof *grids->item);
    if (grids->item) return CML_OK;
    return cml_fail_memory(err, grids->count * (double)sizeof *grids->item, "the bounds of bodies");
}

cml_status cml_body_grids_create(const struct cml_scene *scene, const double origin[2], const double *depths,
                                 struct cml_body_grids *grids, struct cml_error *err)
{
    *grids = (struct cml_body_grids){0};
    CML_TRY(find_media(scene, grids, err));
    const double most = fmin(MOST_CELLS, MOST_OF_ALL / fmax(1, grids->count));
    for (int l = 1; l <= scene->num_layers; l++) {
        if (grids->of_medium[l] < 0) continue;
        struct cml_body_cells *cells = &grids->item[grids->of_medium[l]];
        lay_out(scene, origin, l, depths[l], most, cells);
        cells->first = grids->num_cells;
        grids->num_cells += cells_of(cells);
    }
    grids->ball = malloc((grids->num_cells + 1) * sizeof *grids->ball);
    if (!grids->ball)
        return cml_fail_memory(err, (double)(grids->num_cells * sizeof *grids->ball), "the bounds of bodies");
    for (int l = 1; l <= scene->num_layers; l++) {
        if (grids->of_medium[l] < 0) continue;
        const struct cml_body_cells *cells = &grids->item[grids->of_medium[l]];
        CML_AT_END(clear_filling)
        struct filling f = {.scene = scene, .depth = depths[l], .cells = cells, .err = err};
        CML_TRY(fill(&f, l, grids->ball + cells->first, err));
    }
    return CML_OK;
}

void cml_body_grids_clear(struct cml_body_grids *grids)
{
    free(grids->item);
    free(grids->of_medium);
    free(grids->ball);
    *grids = (struct cml_body_grids){0};
}
