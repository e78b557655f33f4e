/* Which arrays of a tally are kept by group of packets, from whose spread their errors come.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "tally/tally.h"

/* Sets cell_errors, gate_errors, voxel_step, facet_step, map_once, pixel_once and direction_once of a grid
 * from its other members but row_cells, which comes of them. */
void cml_tally_set_groups(struct cml_tally_grid *grid);
