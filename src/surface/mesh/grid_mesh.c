/* Allocates the cells under a sheet, and builds the pyramid of blocks above them. SPDX-License-Identifier:
 * MIT */
#include "surface/mesh/grid_mesh.h"

#include <math.h>
#include <stdlib.h>

/* The mesh itself lies within the range of 16 bits. */
void cml_grid_mesh_widen_depths(const struct cml_grid_mesh *grid, double least, double most,
                                struct cml_grid_mesh_depths *depths)
{
    const double low = fmax(floor((least - grid->z) * grid->steps_per_cm), 0),
                 high = fmin(ceil((most - grid->z) * grid->steps_per_cm), UINT16_MAX);
    if (low < depths->least) depths->least = (uint16_t)low;
    if (high > depths->most) depths->most = (uint16_t)high;
}

/* Returns the number of slots of all levels together. */
static size_t all_slots(const struct cml_grid_mesh *grid)
{
    size_t slots = 0;
    for (int l = 0; l < grid->levels; l++) slots += cml_grid_mesh_slots(&grid->level[l]);
    return slots;
}

/* Each level has a quarter of the cells along an axis, until one tile remains. */
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

/* Sets the depths of a level's blocks: the least and greatest depths of their children. */
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

/* Computes the mean depth of all cells that have facets, in depth steps. */
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

/* The depths of all levels are one block, which begins with level 0. */
void cml_grid_mesh_clear(struct cml_grid_mesh *grid)
{
    free(grid->level[0].depths);
    free(grid->first);
    free(grid->listed);
    free(grid->facet);
    *grid = (struct cml_grid_mesh){.levels = 0};
}

double cml_grid_mesh_bytes(const struct cml_grid_mesh *grid)
{
    if (grid->levels == 0) return 0;
    const size_t cells = cml_grid_mesh_slots(&grid->level[0]), slots = all_slots(grid);
    const double depths = (double)slots * sizeof(struct cml_grid_mesh_depths);
    return depths + (double)(cells + 1) * sizeof *grid->first +
           (double)grid->first[cells] * sizeof *grid->listed + (double)grid->facets * sizeof *grid->facet;
}
