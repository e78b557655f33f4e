/* SPDX-License-Identifier: MIT */
#include "tally/groups.h"

#include "tally/row_cells.h"
#include "tally/tally_cells.h"

static struct cml_once once_of(size_t cells, bool by_group)
{
    return (struct cml_once){by_group ? cells : 0, cells};
}

void cml_tally_set_groups(struct cml_tally_grid *grid)
{
    const size_t most = CML_CELLS_WITH_ERRORS,
                 voxels = (size_t)grid->nx * (size_t)grid->ny * (size_t)grid->nz, map = cml_cells_map(grid),
                 directions = cml_cells_directions(grid),
                 rows = grid->rows && !grid->derivatives ? cml_row_stride(grid) : 1;
    grid->cell_errors = cml_ra_cells(grid) <= most && (!grid->absorption || cml_rz_cells(grid) <= most);
    grid->voxel_step = grid->volume && voxels <= most ? voxels + 1 : 0;
    grid->facet_step = grid->facets <= CML_FACETS_WITH_ERRORS ? grid->facets * CML_FACET_SCORES : 0;
    grid->map_once = once_of(2 * map, map <= most + (size_t)grid->map_na);
    grid->pixel_once = once_of(grid->detector_pixels, grid->detector_pixels <= most);
    grid->direction_once = once_of(3 * directions, rows * directions <= most);
}
