/* The sizes and places of the arrays that a tally and a result have in common: maps, volume and facets, which
 * are kept only when asked for. They lie behind all other arrays of the block, in this order:
 * Rd_xya, Tt_xya, Rd_xya2, Tt_xya2, A_xyz, phi_xyz, facets, detector_map, detector_map2, Rd_dir, Tt_dir,
 * Rsp_dir and the squares of these. Private to tally.c and result.c. SPDX-License-Identifier: MIT */
#pragma once

#include "tally/tally.h"

/* Cells of one of the four maps, with the pixel for what lies outside; 0 without a map. */
static inline size_t cml_cells_map(const struct cml_tally_grid *grid)
{
    return grid->nx > 0 ? ((size_t)grid->nx * (size_t)grid->ny + 1) * (size_t)grid->map_na : 0;
}

/* Cells of A_xyz of all groups, with the one for what lies outside; 0 when it is not tallied. */
static inline size_t cml_cells_volume(const struct cml_tally_grid *grid)
{
    const size_t voxels = (size_t)grid->nx * (size_t)grid->ny * (size_t)grid->nz + 1;
    return grid->volume ? (grid->voxel_step ? CML_NUM_GROUPS : 1) * voxels : 0;
}

/* Scores of the facets of all groups. */
static inline size_t cml_cells_facets(const struct cml_tally_grid *grid)
{
    return (grid->facet_step ? CML_NUM_GROUPS : 1) * grid->facets * CML_FACET_SCORES;
}

/* Cells of phi_xyz; 0 when it is not tallied. */
static inline size_t cml_cells_phi_volume(const struct cml_tally_grid *grid)
{
    return grid->phi_volume ? (size_t)grid->nx * (size_t)grid->ny * (size_t)grid->nz * CML_NUM_GROUPS : 0;
}

/* Cells of one of Rd_dir, Tt_dir and Rsp_dir. */
static inline size_t cml_cells_directions(const struct cml_tally_grid *grid)
{
    return (size_t)grid->nt * (size_t)grid->np;
}

/* Cells of all arrays that this header is about. */
static inline size_t cml_cells_maps(const struct cml_tally_grid *grid)
{
    return 4 * cml_cells_map(grid) + cml_cells_volume(grid) + cml_cells_phi_volume(grid) +
           cml_cells_facets(grid) + 2 * grid->detector_pixels + 6 * cml_cells_directions(grid);
}

/* Sets these arrays of a tally or a result, which begin at `block`; those that are not kept stay as they are.
 * A macro, because the cells of a tally have 64 bits and those of a result 128. */
#define CML_SET_MAPS(to, block)                                                                              \
    do {                                                                                                     \
        const size_t pixels_ = cml_cells_map(&(to)->grid);                                                   \
        if (pixels_) {                                                                                       \
            (to)->Rd_xya = (block);                                                                          \
            (to)->Tt_xya = (block) + pixels_;                                                                \
            (to)->Rd_xya2 = (block) + 2 * pixels_;                                                           \
            (to)->Tt_xya2 = (block) + 3 * pixels_;                                                           \
        }                                                                                                    \
        if ((to)->grid.volume) (to)->A_xyz = (block) + 4 * pixels_;                                          \
        const size_t voxels_ = 4 * pixels_ + cml_cells_volume(&(to)->grid);                                  \
        if ((to)->grid.phi_volume) (to)->phi_xyz = (block) + voxels_;                                        \
        if ((to)->grid.facets) (to)->facets = (block) + voxels_ + cml_cells_phi_volume(&(to)->grid);         \
        const size_t directions_ = cml_cells_directions(&(to)->grid), seen_ = (to)->grid.detector_pixels;    \
        if (seen_) {                                                                                         \
            (to)->detector_map = (block) + cml_cells_maps(&(to)->grid) - 6 * directions_ - 2 * seen_;        \
            (to)->detector_map2 = (to)->detector_map + seen_;                                                \
        }                                                                                                    \
        if (directions_) {                                                                                   \
            (to)->Rd_dir = (block) + cml_cells_maps(&(to)->grid) - 6 * directions_;                          \
            (to)->Tt_dir = (to)->Rd_dir + directions_;                                                       \
            (to)->Rsp_dir = (to)->Rd_dir + 2 * directions_;                                                  \
            (to)->Rd_dir2 = (to)->Rd_dir + 3 * directions_;                                                  \
        }                                                                                                    \
    } while (0)

/* Where they begin in a tally; one past its last cell when it has none of them. */
uint64_t *cml_tally_maps(const struct cml_tally *tally);
