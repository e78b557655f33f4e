/* Lists the facets above each cell of a sheet, if that pays. SPDX-License-Identifier: MIT */
#include "surface/mesh/sheet_mesh.h"

#include "base/array.h"
#include "surface/tree/rounding.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Number of cells per facet. With half as many cells the lists are longer, with twice as many cells there are
 * more lists: both are slower. */
static const double cells_per_facet = 1;

/* Largest mean length of cells' lists of facets, with each list counted as often as it has facets. If lists
 * are longer, a tree is faster than a walk over cells. */
static const double longest_list = 16;

/* Largest share of facets too thin for float. Each ray near such a facet needs the exact query. */
static const double most_thin = 1e-2;

/* Number of unused entries behind the last list, so that vector loops may read beyond the list's end. */
enum { PADDING = 8 };

static const char what[] = "the cells of a sheet"; /* name for messages that memory has run out */

/* A facet seen from above, in cells of the grid. */
struct shadow {
    double corner[3][2];
    double inward[3][2]; /* unit normals, pointing inwards, of the sides opposite to each corner */
    int first[2], last[2];
    double depth, least, most; /* depth of corner 0, and range of depths of all corners, cm */
    double slope[2];           /* slopes along x and y, cm per cell */
};

/* A facet above a cell. */
struct entry {
    uint32_t cell, facet;
    float inside; /* distance of the cell's middle from the facet's sides, positive inside, cells */
};

/* Working data for filling the cells' lists of facets. */
struct lists {
    const struct cml_centred_mesh *centred;
    struct cml_grid_mesh *grid;
    struct entry *entry; /* [count] all entries, facet by facet */
    size_t count;
    uint32_t *end; /* end of each cell's list */
    float *inside; /* [like grid->listed] `inside` of each listed facet */
};

/* Converts a coordinate along an axis from cm to cells from the grid's corner. */
static double to_cells(const struct cml_grid_mesh *grid, double x, int axis)
{
    return (x - grid->corner[axis]) * grid->cells_per_cm[axis];
}

/* Finds the cells that the box of a facet's shadow covers, widened by rounding. */
static void find_range(const struct cml_grid_mesh *grid, struct shadow *s)
{
    for (int k = 0; k < 2; k++) {
        const double a = s->corner[0][k], b = s->corner[1][k], c = s->corner[2][k];
        const double low = fmin(a, fmin(b, c)) - err_apart, high = fmax(a, fmax(b, c)) + err_apart;
        s->first[k] = low > 0 ? (int)low : 0;
        s->last[k] = high < grid->n[k] ? (int)high : grid->n[k] - 1;
    }
}

/* Returns the shadow of a facet: its outline seen along z, in cells of the grid, with the inward normals of
 * its sides, its range of depths and its slope. Seen so, facets run clockwise, because z points down. */
static struct shadow shadow_of(const struct lists *l, size_t facet)
{
    const struct cml_grid_mesh *grid = l->grid;
    const double *plane = l->centred->plane[facet];
    struct shadow s = {
        .depth = cml_centred_corner(l->centred, (int)facet, 0)[2], .least = INFINITY, .most = -INFINITY};
    for (int c = 0; c < 3; c++) {
        const double *at = cml_centred_corner(l->centred, (int)facet, c);
        for (int k = 0; k < 2; k++) s.corner[c][k] = to_cells(grid, at[k], k);
        s.least = fmin(s.least, at[2]);
        s.most = fmax(s.most, at[2]);
    }
    for (int c = 0; c < 3; c++) {
        const double *from = s.corner[(c + 1) % 3], *to = s.corner[(c + 2) % 3];
        const double x = to[1] - from[1], y = from[0] - to[0], length = sqrt(x * x + y * y);
        s.inward[c][0] = x / length;
        s.inward[c][1] = y / length;
    }
    for (int k = 0; k < 2; k++) s.slope[k] = -plane[k] / plane[2] / grid->cells_per_cm[k];
    find_range(grid, &s);
    return s;
}

/* Returns how far inside a facet's outline the middle of cell (i, j) lies, seen from above, in widths of a
 * cell; -INFINITY if cell and outline are apart because a side of the facet lies between them [separating
 * axes: Gottschalk, Lin and Manocha, 1996]. */
static float middle_inside(const struct shadow *s, int i, int j)
{
    const double half = 0.5 + err_apart;
    double inside = INFINITY;
    for (int c = 0; c < 3; c++) {
        const double *on = s->corner[(c + 1) % 3], *n = s->inward[c];
        const double middle = n[0] * (i + 0.5 - on[0]) + n[1] * (j + 0.5 - on[1]);
        if (middle + half * (fabs(n[0]) + fabs(n[1])) < 0) return -INFINITY;
        inside = fmin(inside, middle);
    }
    return (float)inside;
}

/* Widens the depth range of cell (i, j) to include a facet: the depths of the facet's plane above the cell,
 * cut off at the facet's lowest and highest corner. */
static void widen_cell(const struct lists *l, const struct shadow *s, int i, int j)
{
    struct cml_grid_mesh_level *cells = &l->grid->level[0];
    const double slope = fabs(s->slope[0]) + fabs(s->slope[1]);
    const double pad = l->centred->err_float + err_apart * slope;
    const double *at = s->corner[0];
    const double z = s->depth + s->slope[0] * (i + 0.5 - at[0]) + s->slope[1] * (j + 0.5 - at[1]);
    cml_grid_mesh_widen_depths(l->grid, fmax(z - 0.5 * slope, s->least) - pad,
                               fmin(z + 0.5 * slope, s->most) + pad,
                               &cells->depths[cml_grid_mesh_index(cells, i, j)]);
}

/* Adds an entry to its cell's list. Lists are filled from their ends, and sorted so that the facet most
 * likely above a place of the cell comes first. */
static void list_facet(const struct lists *l, const struct entry *entry)
{
    struct cml_grid_mesh *grid = l->grid;
    uint32_t k = --grid->first[entry->cell];
    for (; k + 1 < l->end[entry->cell] && l->inside[k + 1] > entry->inside; k++) {
        l->inside[k] = l->inside[k + 1];
        grid->listed[k] = grid->listed[k + 1];
    }
    l->inside[k] = entry->inside;
    grid->listed[k] = entry->facet;
}

/* Adds a facet to all cells below it: an entry, the count and the depths of each cell. */
static cml_status enter_facet(struct lists *l, size_t facet, struct cml_error *err)
{
    const struct shadow s = shadow_of(l, facet);
    for (int j = s.first[1]; j <= s.last[1]; j++)
        for (int i = s.first[0]; i <= s.last[0]; i++) {
            const size_t cell = cml_grid_mesh_index(&l->grid->level[0], i, j);
            const float inside = middle_inside(&s, i, j);
            if (!(inside > -INFINITY)) continue;
            CML_TRY(cml_array_grow(&l->entry, l->count, sizeof *l->entry, what, err));
            l->entry[l->count++] = (struct entry){(uint32_t)cell, (uint32_t)facet, inside};
            l->grid->first[cell]++;
            widen_cell(l, &s, i, j);
        }
    return CML_OK;
}

/* Lays square cells over the mesh's box in x and y, so that there are about cells_per_facet cells for each
 * facet. */
static void choose_cells(const struct cml_centred_mesh *centred, struct cml_grid_mesh *grid)
{
    const struct cml_mesh *mesh = &centred->mesh;
    double extent[2];
    for (int k = 0; k < 2; k++) {
        grid->corner[k] = centred->lower[k];
        extent[k] = centred->upper[k] - centred->lower[k];
    }
    const double size = sqrt(extent[0] * extent[1] / (cells_per_facet * (double)mesh->num_triangles));
    for (int k = 0; k < 2; k++) {
        grid->n[k] = (int)fmin(ceil(extent[k] / size), 1 << 28);
        grid->cells_per_cm[k] = grid->n[k] / extent[k];
    }
    grid->facets = mesh->num_triangles;
}

/* Computes the derivatives along x and y of the barycentric weight of corner `at`, in a triangle with the
 * corners `corner`, `at` and `other`, 1/cm. */
static void weight_of(const double corner[2], const double at[3], const double other[3], float weight[2])
{
    const double side[2] = {other[0] - corner[0], other[1] - corner[1]};
    const double height = side[0] * (at[1] - corner[1]) - side[1] * (at[0] - corner[0]);
    weight[0] = (float)(-side[1] / height);
    weight[1] = (float)(side[0] / height);
}

/* Fills in what a query needs of a facet: plane, corner, and derivatives of its barycentric weights along x
 * and y. Returns false, and NaN as derivatives, if the facet is so thin that single precision cannot hold
 * the weights. */
static bool fill_facet(const struct cml_centred_mesh *centred, const struct cml_grid_mesh *grid, size_t facet)
{
    struct cml_sheet_facet *f = &grid->facet[facet];
    const double *a = cml_centred_corner(centred, (int)facet, 0),
                 *b = cml_centred_corner(centred, (int)facet, 1),
                 *c = cml_centred_corner(centred, (int)facet, 2);
    double err = 0;
    memcpy(f->plane, centred->plane[facet], sizeof f->plane);
    memcpy(f->corner, a, sizeof f->corner);
    weight_of(a, b, c, f->weight[0]);
    weight_of(a, c, b, f->weight[1]);
    for (int k = 0; k < 2; k++) {
        const double far = fmax(fabs(b[k] - a[k]), fabs(c[k] - a[k])) + 2 / grid->cells_per_cm[k];
        err += (fabs(f->weight[0][k]) + fabs(f->weight[1][k])) *
               (FLT_EPSILON * far + centred->err_mesh / err_sine_grid);
    }
    if (err < err_weight_sheet) return true;
    for (int k = 0; k < 4; k++) f->weight[k / 2][k % 2] = NAN;
    return false;
}

/* Finds a rectangle that lies inside the mesh's border, by which most rays see that they stay over the mesh:
 * the largest one of a series of shrunken copies of the mesh's box. */
static void find_inner(const struct cml_centred_mesh *centred, struct cml_grid_mesh *grid)
{
    const double smaller = 0.95, least = 0.1, margin = 1 - 1e-6;
    double lower[2], upper[2];
    grid->inner[0][0] = NAN;
    for (double share = 1; share > least; share *= smaller) {
        for (int k = 0; k < 2; k++) {
            lower[k] = share * centred->mesh.lower[k];
            upper[k] = share * centred->mesh.upper[k];
        }
        if (!cml_footprint_contains_box(centred->footprint, lower, upper)) continue;
        for (int k = 0; k < 2; k++) {
            grid->inner[0][k] = margin * lower[k];
            grid->inner[1][k] = margin * upper[k];
        }
        return;
    }
}

/* True if every facet of the mesh faces up. */
static bool faces_up(const struct cml_centred_mesh *centred)
{
    for (size_t i = 0; i < centred->mesh.num_triangles; i++)
        if (!(centred->plane[i][2] < 0)) return false;
    return true;
}

/* Enters every facet into the lists of the cells below it. Stops when the mean length of a list exceeds
 * longest_list; the mean in which long lists count more often then exceeds it, too. */
static cml_status enter_facets(struct lists *l, bool *short_enough, struct cml_error *err)
{
    const double most = longest_list * (double)cml_grid_mesh_slots(&l->grid->level[0]);
    for (size_t i = 0; i < l->grid->facets && (double)l->count <= most; i++) CML_TRY(enter_facet(l, i, err));
    *short_enough = (double)l->count <= most && l->count < UINT32_MAX;
    return CML_OK;
}

/* Turns the number of facets in each cell into the place where the cell's list ends in one array. Returns the
 * mean length of lists, with each list counted as often as it has facets. */
static double join_lists(const struct lists *l)
{
    const size_t cells = cml_grid_mesh_slots(&l->grid->level[0]);
    uint32_t *first = l->grid->first, sum = 0;
    double squares = 0;
    for (size_t i = 0; i <= cells; i++) {
        squares += (double)first[i] * first[i];
        sum += first[i];
        first[i] = sum;
    }
    return squares / (double)l->count;
}

/* Fills the lists of facets of all cells, and the data of each facet. Adds to *thin the number of facets that
 * are too thin for float. */
static cml_status fill_lists(struct lists *l, size_t *thin, struct cml_error *err)
{
    struct cml_grid_mesh *grid = l->grid;
    const size_t cells = cml_grid_mesh_slots(&grid->level[0]), listed = grid->first[cells];
    grid->listed = calloc(listed + PADDING, sizeof *grid->listed);
    grid->facet = aligned_alloc(64, grid->facets * sizeof *grid->facet);
    l->end = malloc(cells * sizeof *l->end);
    l->inside = malloc(listed * sizeof *l->inside);
    if (!grid->listed || !grid->facet || !l->end || !l->inside)
        return cml_fail_memory(err, 8.0 * (double)listed + 64.0 * (double)grid->facets, what);
    memcpy(l->end, grid->first, cells * sizeof *l->end);
    for (size_t i = 0; i < l->count; i++) list_facet(l, &l->entry[i]);
    for (size_t i = 0; i < grid->facets; i++) *thin += !fill_facet(l->centred, grid, i);
    return CML_OK;
}

/* Makes for each cell the list of facets above or below it. Sets *pays if these lists are short
 * (longest_list facets in the mean) and hardly any facet is too thin for single precision. If the lists turn
 * out long, stops early and leaves *pays unset; the caller then drops the cells. */
static cml_status make_lists(struct lists *l, bool *pays, struct cml_error *err)
{
    size_t thin = 0;
    bool short_enough = false;
    CML_TRY(cml_grid_mesh_lay_out(l->centred, l->grid, err));
    const size_t cells = cml_grid_mesh_slots(&l->grid->level[0]);
    l->grid->first = calloc(cells + 1, sizeof *l->grid->first);
    if (!l->grid->first) return cml_fail_memory(err, 4 * (double)cells, what);
    CML_TRY(enter_facets(l, &short_enough, err));
    if (!short_enough || join_lists(l) > longest_list) return CML_OK;
    CML_TRY(fill_lists(l, &thin, err));
    *pays = (double)thin <= most_thin * (double)l->grid->facets;
    cml_grid_mesh_build_levels(l->grid);
    find_inner(l->centred, l->grid);
    return CML_OK;
}

cml_status cml_sheet_mesh_find(const struct cml_centred_mesh *centred, struct cml_grid_mesh *grid,
                               struct cml_error *err)
{
    struct lists l = {.centred = centred, .grid = grid};
    bool pays = false;
    *grid = (struct cml_grid_mesh){.levels = 0};
    if (!faces_up(centred)) return CML_OK;
    choose_cells(centred, grid);
    const cml_status status = make_lists(&l, &pays, err);
    free(l.entry);
    free(l.end);
    free(l.inside);
    if (!pays) cml_grid_mesh_clear(grid);
    return status;
}
