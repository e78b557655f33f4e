/* The sizes and places of the arrays that a tally and a result have in common: maps, volume and facets, which
 * are kept only when asked for. They lie behind all other arrays of the block, in this order:
 * Rd_xya, Tt_xya, A_xyz, phi_xyz, facets, detector_map, Rd_dir, Tt_dir and Rsp_dir. Private to src/tally.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "tally/tally.h"

/* The parts of an array: one of each group, or sums and squares. */
static inline size_t cml_once_parts(struct cml_once once)
{
    return once.step ? CML_NUM_GROUPS : 2;
}

/* Cells of one of the two maps, with the pixel for what lies outside; 0 without a map. */
static inline size_t cml_cells_map(const struct cml_tally_grid *grid)
{
    return grid->nx > 0 ? ((size_t)grid->nx * (size_t)grid->ny + 1) * (size_t)grid->map_na : 0;
}

/* Cells of both maps, of all groups or with squares; so it is with the two below. */
static inline size_t cml_cells_maps_once(const struct cml_tally_grid *grid)
{
    return cml_once_parts(grid->map_once) * 2 * cml_cells_map(grid);
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

static inline size_t cml_cells_directions_once(const struct cml_tally_grid *grid)
{
    return cml_once_parts(grid->direction_once) * 3 * cml_cells_directions(grid);
}

static inline size_t cml_cells_pixels_once(const struct cml_tally_grid *grid)
{
    return cml_once_parts(grid->pixel_once) * grid->detector_pixels;
}

/* Cells of all arrays that this header is about. */
static inline size_t cml_cells_all_maps(const struct cml_tally_grid *grid)
{
    return cml_cells_maps_once(grid) + cml_cells_volume(grid) + cml_cells_phi_volume(grid) +
           cml_cells_facets(grid) + cml_cells_pixels_once(grid) + cml_cells_directions_once(grid);
}

/* Sets these arrays of a tally or a result, which begin at `block`; those that are not kept stay as they are.
 * A macro, because the cells of a tally have 64 bits and those of a result 128. */
#define CML_SET_MAPS(to, block)                                                                              \
    do {                                                                                                     \
        const struct cml_tally_grid *const of_ = &(to)->grid;                                                \
        const size_t volume_ = cml_cells_maps_once(of_), phi_ = volume_ + cml_cells_volume(of_),             \
                     facets_ = phi_ + cml_cells_phi_volume(of_), seen_ = facets_ + cml_cells_facets(of_),    \
                     directions_ = seen_ + cml_cells_pixels_once(of_), bins_ = cml_cells_directions(of_);    \
        if (volume_) {                                                                                       \
            (to)->Rd_xya = (block);                                                                          \
            (to)->Tt_xya = (block) + cml_cells_map(of_);                                                     \
        }                                                                                                    \
        if (of_->volume) (to)->A_xyz = (block) + volume_;                                                    \
        if (of_->phi_volume) (to)->phi_xyz = (block) + phi_;                                                 \
        if (of_->facets) (to)->facets = (block) + facets_;                                                   \
        if (of_->detector_pixels) (to)->detector_map = (block) + seen_;                                      \
        if (bins_) {                                                                                         \
            (to)->Rd_dir = (block) + directions_;                                                            \
            (to)->Tt_dir = (to)->Rd_dir + bins_;                                                             \
            (to)->Rsp_dir = (to)->Tt_dir + bins_;                                                            \
        }                                                                                                    \
    } while (0)

/* Where they begin in a tally; one past its last cell when it has none of them. */
uint64_t *cml_tally_maps(const struct cml_tally *tally);
