/* SPDX-License-Identifier: MIT */
#include "surface/mesh/grid_mesh.h"

#include "surface/tree/rounding.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* In cells: vertices further from the grid make it none. What files round is far less. */
static const double most_deviation = 1e-3;

/* Cells per facet beyond which a grid would be a waste: of memory, and of steps, for a tree skips
 * large facets. */
static const double most_cells_per_facet = 16;

enum { SOUTH = 1, EAST = 2, NORTH = 4, WEST = 8 }; /* quarters of a cell between its diagonals */

struct rectangle {
    double lower[2], upper[2];
};

/* The rectangle of all vertices, or of those that are not to be skipped. */
static struct rectangle rectangle_of(const struct cml_mesh *mesh, const bool *skip)
{
    struct rectangle r = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    for (size_t i = 0; i < mesh->num_vertices; i++)
        for (int k = 0; k < 2 && !(skip && skip[i]); k++) {
            r.lower[k] = fmin(r.lower[k], mesh->vertex[i][k]);
            r.upper[k] = fmax(r.upper[k], mesh->vertex[i][k]);
        }
    return r;
}

static bool is_inside(const struct rectangle *r, const double v[3])
{
    return v[0] >= r->lower[0] && v[0] <= r->upper[0] && v[1] >= r->lower[1] && v[1] <= r->upper[1];
}

/* The shortest extent along an axis of the edges inside the rectangle, leaving out those that run across it:
 * theirs is the deviation of their ends. The grid is as fine as its smallest facets. */
static double find_spacing(const struct cml_mesh *mesh, const struct rectangle *r, int axis)
{
    double least = INFINITY;
    for (size_t i = 0; i < 3 * mesh->num_triangles; i++) {
        const double *a = mesh->vertex[mesh->triangle[i / 3][i % 3]],
                     *b = mesh->vertex[mesh->triangle[i / 3][(i + 1) % 3]];
        const double d = fabs(a[axis] - b[axis]), across = fabs(a[1 - axis] - b[1 - axis]);
        if (d > 4 * most_deviation * across && d < least && is_inside(r, a) && is_inside(r, b)) least = d;
    }
    return least;
}

/* The grid that the rectangle and its shortest edges suggest; false when that would be no grid, or a waste.
 */
static bool guess_grid(const struct cml_mesh *mesh, const struct rectangle *r, struct cml_grid_mesh *grid)
{
    double cells = 1;
    for (int k = 0; k < 2; k++) {
        const double n = rint((r->upper[k] - r->lower[k]) / find_spacing(mesh, r, k));
        if (!(n >= 1 && n < 1 << 28)) return false;
        grid->n[k] = (int)n;
        grid->corner[k] = r->lower[k];
        grid->cells_per_cm[k] = n / (r->upper[k] - r->lower[k]);
        cells *= n;
    }
    return cells <= most_cells_per_facet * (double)mesh->num_triangles;
}

/* A vertex in cells from the grid's corner. */
static double to_cells(const struct cml_grid_mesh *grid, const double v[3], int axis)
{
    return (v[axis] - grid->corner[axis]) * grid->cells_per_cm[axis];
}

/* Largest distance of the rectangle's vertices from the grid, in cells. */
static double find_deviation(const struct cml_mesh *mesh, const struct rectangle *r,
                             const struct cml_grid_mesh *grid)
{
    double deviation = 0;
    for (size_t i = 0; i < mesh->num_vertices; i++)
        for (int k = 0; k < 2 && is_inside(r, mesh->vertex[i]); k++) {
            const double x = to_cells(grid, mesh->vertex[i], k);
            deviation = fmax(deviation, fabs(x - rint(x)));
        }
    return deviation;
}

/* Twice the signed area of a, b and (px, py), exact in whole numbers: > 0 when the point lies on the side of
 * a facet's edge where the facet is. */
static int64_t side_of(const int64_t a[2], const int64_t b[2], int64_t px, int64_t py)
{
    return (b[1] - a[1]) * (px - a[0]) - (b[0] - a[0]) * (py - a[1]);
}

/* A facet's corners in quarters of a cell, so that the middles of a cell's quarters are whole numbers too. */
struct facet {
    int64_t corner[3][2];
};

static bool contains(const struct facet *f, int64_t x, int64_t y)
{
    for (int k = 0; k < 3; k++)
        if (side_of(f->corner[k], f->corner[(k + 1) % 3], x, y) <= 0) return false;
    return true;
}

/* Sides along grid lines or diagonals, wound as a sheet's facets are where they face up. */
static bool follows_grid(const struct facet *f)
{
    for (int k = 0; k < 3; k++) {
        const int64_t *a = f->corner[k], *b = f->corner[(k + 1) % 3];
        const int64_t dx = b[0] - a[0], dy = b[1] - a[1];
        if (dx != 0 && dy != 0 && dx != dy && dx != -dy) return false;
    }
    return side_of(f->corner[0], f->corner[1], f->corner[2][0], f->corner[2][1]) > 0;
}

/* Which quarters of a cell a facet covers, told by their middles: a facet of the grid covers all of a quarter
 * or none of it. */
static int quarters(const struct facet *f, int64_t i, int64_t j)
{
    return (contains(f, 4 * i + 2, 4 * j + 1) ? SOUTH : 0) | (contains(f, 4 * i + 3, 4 * j + 2) ? EAST : 0) |
           (contains(f, 4 * i + 2, 4 * j + 3) ? NORTH : 0) | (contains(f, 4 * i + 1, 4 * j + 2) ? WEST : 0);
}

/* Depths in steps, rounded outwards. The mesh itself lies within the range of 16 bits. */
void cml_grid_mesh_widen_depths(const struct cml_grid_mesh *grid, double least, double most,
                                struct cml_grid_mesh_depths *depths)
{
    const double low = fmax(floor((least - grid->z) * grid->steps_per_cm), 0),
                 high = fmin(ceil((most - grid->z) * grid->steps_per_cm), UINT16_MAX);
    if (low < depths->least) depths->least = (uint16_t)low;
    if (high > depths->most) depths->most = (uint16_t)high;
}

/* Widens the cell's depths by those of the facet's plane at the corners that belong to its part of the cell.
 */
static void widen_cell(const struct cml_centred_mesh *centred, const struct cml_grid_mesh *grid, size_t facet,
                       int part, int i, int j, struct cml_grid_mesh_depths *depths)
{
    static const int at[4] = {SOUTH | WEST, SOUTH | EAST, NORTH | WEST, NORTH | EAST};
    const double *plane = centred->plane[facet], dx = 1 / grid->cells_per_cm[0],
                 dy = 1 / grid->cells_per_cm[1];
    const double slope = (fabs(plane[0]) * dx + fabs(plane[1]) * dy) / fabs(plane[2]);
    const double pad = centred->err_float + grid->err_cell * slope;
    for (int k = 0; k < 4; k++) {
        const double x = grid->corner[0] + (i + k % 2) * dx, y = grid->corner[1] + (j + k / 2) * dy;
        const double z = (plane[3] - plane[0] * x - plane[1] * y) / plane[2];
        if (part & at[k]) cml_grid_mesh_widen_depths(grid, z - pad, z + pad, depths);
    }
}

/* False when another facet is there already, or the facets disagree about the diagonal. */
static bool set_cell(struct cml_grid_mesh_cell *cell, size_t facet, int part)
{
    const bool falling = part == (SOUTH | WEST) || part == (NORTH | EAST);
    const uint32_t mark = (uint32_t)facet | (falling ? CML_GRID_MESH_FALLING : 0);
    if ((part & SOUTH && cell->south != CML_GRID_MESH_NO_FACET) ||
        (part & NORTH && cell->north != CML_GRID_MESH_NO_FACET))
        return false;
    if (part & SOUTH) cell->south = mark;
    if (part & NORTH) cell->north = mark;
    return cell->south == CML_GRID_MESH_NO_FACET || cell->north == CML_GRID_MESH_NO_FACET ||
           ((cell->south ^ cell->north) & CML_GRID_MESH_FALLING) == 0;
}

/* Enters a facet into all cells that it covers; false when one of them has no place for it. */
static bool put_facet(const struct cml_centred_mesh *centred, struct cml_grid_mesh *grid, size_t facet,
                      const struct facet *f)
{
    int64_t low[2], high[2];
    for (int k = 0; k < 2; k++) {
        low[k] = high[k] = f->corner[0][k] / 4;
        for (int c = 1; c < 3; c++) {
            const int64_t at = f->corner[c][k] / 4;
            if (at < low[k]) low[k] = at;
            if (at > high[k]) high[k] = at;
        }
    }
    for (int64_t j = low[1]; j < high[1]; j++)
        for (int64_t i = low[0]; i < high[0]; i++) {
            const int part = quarters(f, i, j);
            const size_t at = cml_grid_mesh_index(&grid->level[0], (int)i, (int)j);
            if (part == 0) continue;
            if (!set_cell(&grid->cell[at], facet, part)) return false;
            widen_cell(centred, grid, facet, part, (int)i, (int)j, &grid->level[0].depths[at]);
            if (part & SOUTH)
                memcpy(grid->planes[at].south, centred->plane[facet], sizeof centred->plane[facet]);
            if (part & NORTH)
                memcpy(grid->planes[at].north, centred->plane[facet], sizeof centred->plane[facet]);
        }
    return true;
}

/* Whether a facet with a corner outside the rectangle lies outside altogether, but for rounding. */
static bool is_outside(const struct cml_grid_mesh *grid, const struct cml_mesh *mesh, const uint32_t v[3])
{
    for (int k = 0; k < 2; k++) {
        const double a = to_cells(grid, mesh->vertex[v[0]], k), b = to_cells(grid, mesh->vertex[v[1]], k),
                     c = to_cells(grid, mesh->vertex[v[2]], k);
        const double low = fmin(a, fmin(b, c)), high = fmax(a, fmax(b, c));
        if (high <= grid->err_cell || low >= grid->n[k] - grid->err_cell) return true;
    }
    return false;
}

/* Puts all facets into the cells that they cover; false when one does not fit. */
static bool put_facets(const struct cml_centred_mesh *centred, const struct rectangle *r,
                       struct cml_grid_mesh *grid)
{
    const struct cml_mesh *mesh = &centred->mesh;
    grid->is_whole = true;
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        const uint32_t *v = mesh->triangle[t];
        struct facet f;
        bool inside = true;
        for (int c = 0; c < 3; c++) {
            inside = inside && is_inside(r, mesh->vertex[v[c]]);
            for (int k = 0; k < 2; k++)
                f.corner[c][k] = inside ? 4 * llrint(to_cells(grid, mesh->vertex[v[c]], k)) : 0;
        }
        if (inside ? !follows_grid(&f) || !put_facet(centred, grid, t, &f) : !is_outside(grid, mesh, v))
            return false;
        grid->is_whole = grid->is_whole && inside;
    }
    return true;
}

/* Slots of all levels together. */
static size_t all_slots(const struct cml_grid_mesh *grid)
{
    size_t slots = 0;
    for (int l = 0; l < grid->levels; l++) slots += cml_grid_mesh_slots(&grid->level[l]);
    return slots;
}

cml_status cml_grid_mesh_lay_out(const struct cml_centred_mesh *centred, struct cml_grid_mesh *grid,
                                 struct cml_error *err)
{
    int n[2] = {grid->n[0], grid->n[1]};
    grid->z = centred->lower[2];
    grid->steps_per_cm = UINT16_MAX / (centred->upper[2] - centred->lower[2]);
    for (bool is_last = false; !is_last; grid->levels++) {
        grid->level[grid->levels] = (struct cml_grid_mesh_level){.n = {n[0], n[1]}, .tiles = (n[0] + 3) / 4};
        is_last = n[0] <= 4 && n[1] <= 4;
        for (int k = 0; k < 2; k++) n[k] = (n[k] + 3) / 4;
    }
    const size_t slots = all_slots(grid), bytes = slots * sizeof *grid->level[0].depths;
    grid->level[0].depths = aligned_alloc(64, bytes);
    if (!grid->level[0].depths) {
        cml_grid_mesh_clear(grid);
        return cml_fail_memory(err, (double)bytes, "the depths of a grid");
    }
    for (size_t i = 0; i < slots; i++)
        grid->level[0].depths[i] = (struct cml_grid_mesh_depths){UINT16_MAX, 0};
    for (int l = 1; l < grid->levels; l++)
        grid->level[l].depths = grid->level[l - 1].depths + cml_grid_mesh_slots(&grid->level[l - 1]);
    return CML_OK;
}

/* Allocates the cells, none of which has a facet yet. */
static cml_status allocate(struct cml_grid_mesh *grid, struct cml_error *err)
{
    const size_t cells = cml_grid_mesh_slots(&grid->level[0]);
    grid->cell = aligned_alloc(64, cells * sizeof *grid->cell);
    grid->planes = aligned_alloc(64, cells * sizeof *grid->planes);
    if (!grid->cell || !grid->planes) {
        cml_grid_mesh_clear(grid);
        return cml_fail_memory(err, (double)cells * (sizeof *grid->cell + sizeof *grid->planes),
                               "the cells of a grid");
    }
    for (size_t i = 0; i < cells; i++)
        grid->cell[i] = (struct cml_grid_mesh_cell){CML_GRID_MESH_NO_FACET, CML_GRID_MESH_NO_FACET};
    return CML_OK;
}

/* The depths of a level's blocks: least and most of the level below. */
static void build_level(const struct cml_grid_mesh_level *below, struct cml_grid_mesh_level *level)
{
    for (int j = 0; j < below->n[1]; j++)
        for (int i = 0; i < below->n[0]; i++) {
            const struct cml_grid_mesh_depths part = below->depths[cml_grid_mesh_index(below, i, j)];
            struct cml_grid_mesh_depths *all = &level->depths[cml_grid_mesh_index(level, i / 4, j / 4)];
            if (part.least < all->least) all->least = part.least;
            if (part.most > all->most) all->most = part.most;
        }
}

static void find_mean(struct cml_grid_mesh *grid)
{
    double sum = 0, cells = 0;
    for (size_t i = 0; i < cml_grid_mesh_slots(&grid->level[0]); i++) {
        const struct cml_grid_mesh_depths depths = grid->level[0].depths[i];
        if (depths.least > depths.most) continue;
        sum += 0.5 * (depths.least + depths.most);
        cells++;
    }
    grid->mean = sum / cells;
}

void cml_grid_mesh_build_levels(struct cml_grid_mesh *grid)
{
    for (int l = 1; l < grid->levels; l++) build_level(&grid->level[l - 1], &grid->level[l]);
    find_mean(grid);
}

/* Where a ray is over cells that all have facets, by more than rounding. */
static void find_inner(struct cml_grid_mesh *grid)
{
    bool is_full = true;
    for (int j = 0; j < grid->n[1]; j++)
        for (int i = 0; i < grid->n[0]; i++) {
            const struct cml_grid_mesh_cell cell = grid->cell[cml_grid_mesh_index(&grid->level[0], i, j)];
            is_full = is_full && cell.south != CML_GRID_MESH_NO_FACET && cell.north != CML_GRID_MESH_NO_FACET;
        }
    for (int k = 0; k < 2; k++) {
        const double last = grid->n[k] - grid->err_cell;
        grid->inner[0][k] = is_full ? grid->corner[k] + grid->err_cell / grid->cells_per_cm[k] : NAN;
        grid->inner[1][k] = grid->corner[k] + last / grid->cells_per_cm[k];
    }
}

static cml_status try_rectangle(const struct cml_centred_mesh *centred, const struct rectangle *r,
                                struct cml_grid_mesh *grid, struct cml_error *err)
{
    *grid = (struct cml_grid_mesh){.cell = NULL};
    if (!guess_grid(&centred->mesh, r, grid)) return CML_OK;
    const double deviation = find_deviation(&centred->mesh, r, grid);
    if (deviation > most_deviation) return CML_OK;
    grid->err_cell = 2 * deviation + err_cell_least;
    CML_TRY(cml_grid_mesh_lay_out(centred, grid, err));
    CML_TRY(allocate(grid, err));
    if (!put_facets(centred, r, grid)) {
        cml_grid_mesh_clear(grid);
        return CML_OK;
    }
    cml_grid_mesh_build_levels(grid);
    find_inner(grid);
    return CML_OK;
}

/* A skirt around the grid ends at the border, so its outer vertices are those of the border: if all vertices
 * are on no grid, those inside may be. */
cml_status cml_grid_mesh_find(const struct cml_centred_mesh *centred, struct cml_grid_mesh *grid,
                              struct cml_error *err)
{
    const struct cml_mesh *mesh = &centred->mesh;
    struct rectangle r = rectangle_of(mesh, NULL);
    CML_TRY(try_rectangle(centred, &r, grid, err));
    if (grid->cell) return CML_OK;
    bool *border = calloc(mesh->num_vertices, sizeof *border); /* of a skirt, perhaps */
    if (!border) return cml_fail_memory(err, (double)mesh->num_vertices, "the border of a grid");
    for (size_t i = 0; i < mesh->num_border; i++) border[mesh->border[i]] = true;
    r = rectangle_of(mesh, border);
    free(border);
    return try_rectangle(centred, &r, grid, err);
}

void cml_grid_mesh_clear(struct cml_grid_mesh *grid)
{
    free(grid->level[0].depths);
    free(grid->cell);
    free(grid->planes);
    free(grid->first);
    free(grid->listed);
    free(grid->facet);
    *grid = (struct cml_grid_mesh){.cell = NULL};
}

double cml_grid_mesh_bytes(const struct cml_grid_mesh *grid)
{
    if (grid->levels == 0) return 0;
    const size_t cells = cml_grid_mesh_slots(&grid->level[0]), slots = all_slots(grid);
    const double depths = (double)slots * sizeof(struct cml_grid_mesh_depths);
    if (grid->cell) return depths + (double)cells * (sizeof *grid->cell + sizeof *grid->planes);
    return depths + (double)(cells + 1) * sizeof *grid->first +
           (double)grid->first[cells] * sizeof *grid->listed + (double)grid->facets * sizeof *grid->facet;
}
