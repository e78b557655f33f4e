/* A heightmap that is repeated over the whole plane: it has no rim, no skirt, and nothing lies around it.
 * One period is kept, as a struct cml_heightmap whose sample behind the last one along an axis is the first
 * again: nx x ny samples, and as many cells. Between samples the surface is that of heightmap.h, but nothing
 * is merged, so that all copies are alike. SPDX-License-Identifier: MIT */
#pragma once

#include "scene/heightmap/heightmap.h"

/* What was drawn, measured over the whole period; zero for a tile that was read from a file. */
struct cml_drawn_relief {
    double rms;    /* height, cm */
    double slope;  /* rms gradient of the facets */
    double length; /* cm: where the autocorrelation along x and y has fallen to 1/e; 0: nowhere */
};

/* What became of a heightmap; printed by `check`. */
struct cml_tile_notes {
    int nx, ny; /* samples of the file; 0: this is no tile */
    bool mirrored;
    struct cml_relief relief;  /* of one period; slopes without those across its end */
    double seam[2], inside[2]; /* cm: largest step from sample to sample along x and y, across the seam and
                                * inside the file's map */
    struct cml_drawn_relief drawn;
};

/* A part of the plane: cells first .. first + count - 1 along x and y, counted from the period's first
 * sample; any whole numbers. */
struct cml_tile_cells {
    int first[2], count[2];
};

/* Makes a map as it was read one period. mirrored: the map is followed by its mirror image, which shares its
 * first and last samples, so that the period is 2 (nx - 1) and 2 (ny - 1) cells and there is no seam. Else it
 * is left as it is: the period is nx and ny cells. CML_E_INPUT for memory, and beyond 2^26 samples; `path` is
 * for messages. */
CML_NODISCARD cml_status cml_tile_make(const char *path, bool mirrored, struct cml_heightmap *map,
                                       struct cml_tile_notes *notes, struct cml_error *err);

/* Length of the period along an axis, cm. */
double cml_tile_period(const struct cml_heightmap *tile, int axis);

/* Height of sample i, j of the plane, cm; any whole numbers. */
double cml_tile_height(const struct cml_heightmap *tile, int64_t i, int64_t j);

/* Whether the diagonal of cell i, j of the plane runs from its corner (0, 0) to (1, 1), else from (1, 0) to
 * (0, 1). */
bool cml_tile_rises(const struct cml_heightmap *tile, int64_t i, int64_t j);

/* Mean height of the triangles over a period, cm. */
double cml_tile_mean(const struct cml_heightmap *tile);

/* True when all heights are the same: the boundary is then the plane of that height. */
bool cml_tile_is_flat(const struct cml_heightmap *tile);

/* The triangles over some cells, row by row, two to a cell, that at its lower y first, in the boundary's
 * frame. They are wound as cml_mesh_prepare wants them, which has not run. CML_E_INPUT for memory; then there
 * is nothing to clear. */
CML_NODISCARD cml_status cml_tile_sheet(const struct cml_heightmap *tile, const struct cml_tile_cells *cells,
                                        enum cml_normals normals, struct cml_mesh *mesh,
                                        struct cml_error *err);

/* The triangles over some cells as a prepared mesh, whose border a skirt of one cell makes level; the skirt's
 * triangles are the last. CML_E_INPUT for memory, or when cells are so small that rounding makes vertices
 * one. */
CML_NODISCARD cml_status cml_tile_patch(const struct cml_heightmap *tile, const struct cml_tile_cells *cells,
                                        enum cml_normals normals, struct cml_mesh *mesh,
                                        struct cml_error *err);

/* Cells of a patch that has at least `margin` cells around a period on each side, and more where the period
 * is short. */
struct cml_tile_cells cml_tile_patch_cells(const struct cml_heightmap *tile);

/* The place where two tiles come closest in the vertical; gap: depth of the lower one less that of the upper
 * one, cm. z: depths from which their heights count. Exact when both have the same cells; returns false, and
 * nothing else, when they have not. */
bool cml_tile_closest(const struct cml_heightmap *upper, double z_upper, const struct cml_heightmap *lower,
                      double z_lower, double *gap, double at[3]);
