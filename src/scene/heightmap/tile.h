/* A tile: a heightmap repeated over the whole plane. It has no rim and no skirt, and nothing lies around it.
 *
 *     ... | \/\_/\ | \/\_/\ | \/\_/\ | ...
 *           period   period   period
 *
 * One period is stored as a struct cml_heightmap of nx x ny samples and as many cells: behind the last sample
 * along an axis the first one follows again. Between samples the surface is that of heightmap.h, but no
 * triangles are merged, so all copies are alike. SPDX-License-Identifier: MIT */
#pragma once

#include "scene/heightmap/heightmap.h"

/* Statistics of a random relief over its whole period; zero for a tile that was read from a file. */
struct cml_drawn_relief {
    double rms;    /* rms height, cm */
    double slope;  /* rms gradient of the facets [-] */
    double length; /* lag at which the autocorrelation along x and y falls to 1/e, cm; 0: it does not */
};

/* The properties of a tile and its heightmap; `check` prints them. */
struct cml_tile_notes {
    int nx, ny; /* number of samples in the file; 0: not a tile */
    bool mirrored;
    struct cml_relief relief; /* statistics of one period; slopes across its end are left out */
    /* Largest step between neighbouring samples along x and y, cm: across the seam, and inside the file's
     * map. */
    double seam[2], inside[2];
    struct cml_drawn_relief drawn;
};

/* A rectangle of cells in the plane: first .. first + count - 1 along x and y, counted from the period's
 * first sample. Any whole numbers are allowed. */
struct cml_tile_cells {
    int first[2], count[2];
};

/* Turns a heightmap, as read from a file, into one period. mirrored: the map is continued by its mirror
 * image, which shares its first and last samples. The period is then 2 (nx - 1) and 2 (ny - 1) cells, without
 * a seam. Else the heights stay, and the period is nx and ny cells. CML_E_INPUT if memory runs out, and
 * beyond 2^26 samples; `path` is for messages. */
CML_NODISCARD cml_status cml_tile_make(const char *path, bool mirrored, struct cml_heightmap *map,
                                       struct cml_tile_notes *notes, struct cml_error *err);

/* Returns the length of the period along an axis (0: x, 1: y), cm. */
double cml_tile_period(const struct cml_heightmap *tile, int axis);

/* Returns the height of sample i, j of the plane, cm. Any whole numbers are allowed. */
double cml_tile_height(const struct cml_heightmap *tile, int64_t i, int64_t j);

/* True if the diagonal of cell i, j of the plane runs from its corner (0, 0) to (1, 1), false if from (1, 0)
 * to (0, 1). */
bool cml_tile_rises(const struct cml_heightmap *tile, int64_t i, int64_t j);

/* Returns the mean height of the triangles over a period, cm. */
double cml_tile_mean(const struct cml_heightmap *tile);

/* True if all heights of a tile are equal. The boundary is then the plane of that height. */
bool cml_tile_is_flat(const struct cml_heightmap *tile);

/* Makes an unprepared mesh of the triangles over some cells, in the boundary's frame, wound as
 * cml_mesh_prepare wants them. Triangles come row by row, two per cell, first the one at the cell's lower y.
 * CML_E_INPUT if memory runs out; then there is nothing to clear. */
CML_NODISCARD cml_status cml_tile_sheet(const struct cml_heightmap *tile, const struct cml_tile_cells *cells,
                                        enum cml_normals normals, struct cml_mesh *mesh,
                                        struct cml_error *err);

/* Makes a prepared mesh of the triangles over some cells, with a skirt of one cell that makes its border
 * level. The skirt's triangles come last. CML_E_INPUT if memory runs out, or if the cells are so small that
 * rounding joins vertices. */
CML_NODISCARD cml_status cml_tile_patch(const struct cml_heightmap *tile, const struct cml_tile_cells *cells,
                                        enum cml_normals normals, struct cml_mesh *mesh,
                                        struct cml_error *err);

/* Returns the cells of a patch: a period with at least 4 cells around it on each side, and with more if the
 * period is short, until the patch is 64 cells wide. */
struct cml_tile_cells cml_tile_patch_cells(const struct cml_heightmap *tile);

/* Finds the place where two tiles come closest in the vertical. gap: depth of the lower tile minus that of
 * the upper one, cm. z_upper, z_lower: depths from which the heights count. The search is exact. Returns
 * false, and no place, if the tiles do not have the same cells. */
bool cml_tile_closest(const struct cml_heightmap *upper, double z_upper, const struct cml_heightmap *lower,
                      double z_lower, double *gap, double at[3]);
