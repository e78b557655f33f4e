/* SPDX-License-Identifier: MIT */
#include "surface/mesh/sheet_mesh.h"

/* How many facets of a list are called: more than most lists have. Those of short lists are other cells'. */
enum { FACETS = 5 };

/* The grid and a ray in cells and steps, for guesses in float. */
struct guess {
    const struct cml_grid_mesh *grid;
    float last_x, last_y; /* cell */
    float x, y, z, ux, uy, inverse, from, to;
};

static float least(float a, float b)
{
    return a < b ? a : b;
}

static float greatest(float a, float b)
{
    return a > b ? a : b;
}

/* The cell in which the ray is at a depth; NaN gives the first. */
static size_t cell_at_depth(const struct guess *g, float depth)
{
    const float t = greatest(g->from, least((depth - g->z) * g->inverse, g->to));
    const int i = (int)greatest(0, least(g->x + t * g->ux, g->last_x)),
              j = (int)greatest(0, least(g->y + t * g->uy, g->last_y));
    return cml_grid_mesh_index(&g->grid->level[0], i, j);
}

/* Where each ray will probably meet the sheet: where it has the depth of the cell that it crosses at the mean
 * depth. Returns how many. */
static int guess_cells(const struct cml_grid_mesh *grid, const struct cml_mesh_body *body,
                       const struct cml_mesh_rays *r, size_t cell[CML_MESH_RAYS])
{
    const float x0 = (float)(body->centre[0] + grid->corner[0]),
                y0 = (float)(body->centre[1] + grid->corner[1]);
    const float z0 = (float)(body->centre[2] + grid->z) + r->depth;
    const float x_scale = (float)grid->cells_per_cm[0], y_scale = (float)grid->cells_per_cm[1];
    const float z_scale = (float)grid->steps_per_cm, mean = (float)grid->mean;
    struct guess g = {.grid = grid, .last_x = (float)(grid->n[0] - 1), .last_y = (float)(grid->n[1] - 1)};
    int count = 0;
    for (uint64_t rest = r->asked; rest; rest &= rest - 1) {
        const int k = __builtin_ctzll(rest);
        g.x = (r->x[k] - x0) * x_scale;
        g.y = (r->y[k] - y0) * y_scale;
        g.z = (r->z[k] - z0) * z_scale;
        g.ux = r->ux[k] * x_scale;
        g.uy = r->uy[k] * y_scale;
        g.inverse = 1 / (r->uz[k] * z_scale);
        g.from = r->from[k];
        g.to = r->to[k];
        const struct cml_grid_mesh_depths depths = grid->level[0].depths[cell_at_depth(&g, mean)];
        cell[count++] = cell_at_depth(&g, 0.5f * (float)(depths.least + depths.most));
    }
    return count;
}

void cml_sheet_prefetch(const struct cml_grid_mesh *grid, const struct cml_mesh_body *body,
                        const struct cml_mesh_rays *rays)
{
    size_t cell[CML_MESH_RAYS];
    const int count = guess_cells(grid, body, rays, cell);
    for (int k = 0; k < count; k++) __builtin_prefetch(&grid->first[cell[k]]);
    for (int k = 0; k < count; k++) __builtin_prefetch(&grid->listed[grid->first[cell[k]]]);
    for (int k = 0; k < count; k++)
        for (int i = 0; i < FACETS; i++)
            __builtin_prefetch(&grid->facet[grid->listed[grid->first[cell[k]] + (uint32_t)i]]);
}
