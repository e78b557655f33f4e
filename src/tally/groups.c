/* SPDX-License-Identifier: MIT */
#include "tally/groups.h"

#include "tally/row_cells.h"

/* Returns the layout of an array of `cells` cells: one copy per group, or one of sums and one of squares. */
static struct cml_once once_of(size_t cells, bool by_group)
{
    return (struct cml_once){by_group ? cells : 0, cells};
}

/* Arrays of at most `most` cells have a copy for each group of batches; larger ones would need too much
 * memory. A step of 0 means a single copy. */
void cml_tally_set_groups(struct cml_tally_grid *grid)
{
    const struct cml_layout of = cml_layout_of(grid, CML_OF_TALLY);
    const size_t most = CML_CELLS_WITH_ERRORS, voxels = of.size[CML_ARRAY_A_xyz],
                 map = of.size[CML_ARRAY_Rd_xya], directions = of.size[CML_ARRAY_Rd_dir],
                 rows = grid->rows && !grid->derivatives ? cml_row_stride(grid) : 1;
    grid->cell_errors = of.size[CML_ARRAY_Rd_ra] <= most && of.size[CML_ARRAY_A_rz] <= most;
    grid->gate_errors = of.size[CML_ARRAY_Rd_rt] <= most;
    /* + 1 for the extra voxel, which holds all absorption outside. */
    grid->voxel_step = voxels <= most + 1 ? voxels : 0;
    grid->facet_step = grid->facets <= CML_FACETS_WITH_ERRORS ? grid->facets * CML_FACET_SCORES : 0;
    grid->map_once = once_of(2 * map, map <= most + (size_t)grid->map_na);
    grid->pixel_once = once_of(grid->detector_pixels, grid->detector_pixels <= most);
    grid->direction_once = once_of(3 * directions, rows * directions <= most);
}
