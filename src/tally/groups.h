/* Decides which arrays of a tally are kept by group of packets. The spread over groups gives their standard
 * errors. SPDX-License-Identifier: MIT */
#pragma once

#include "tally/tally.h"

/* Sets cell_errors, gate_errors, voxel_step, facet_step, map_once, pixel_once and direction_once of a grid.
 * All other members must be set, except row_cells, which depends on these. */
void cml_tally_set_groups(struct cml_tally_grid *grid);
