/* Heights on a regular grid, as scanners measure them, and how they become a boundary mesh.
 * Samples are the mesh's vertices; between them the surface is the grid's finest triangulation, whose
 * diagonals alternate from cell to cell. Triangles are merged in pairs as long as no sample is further from
 * the merged one than the tolerance: right-angled triangles whose halves share the middle of the longest
 * side, so that neither needles nor T-junctions arise. Because the merged triangles are unions of the finest
 * ones, the largest distance is found at a sample: the bound holds for the whole surface.
 *
 * A boundary's border lies on one plane, a scan's rim does not: a skirt outside the scan, one cell wide or as
 * wide as it is high, so that no part is steeper than 45 degrees, leads from the rim to the rim's mean
 * height. Sides of triangles on the rim are at most CML_RIM_CELLS cells long, so that the skirt has no
 * needles either. SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/mesh.h"
#include "scene/heightmap/mesh_budget.h"

#define CML_RIM_CELLS 4

#define CML_HIGHEST_SAMPLE 1e30 /* cm, as for all lengths of .mci files */

struct cml_heightmap {
    int nx, ny;    /* samples, each 2 or more */
    double x0, y0; /* of the first sample, cm */
    double dx, dy; /* spacing, cm */
    double *h;     /* [ny][nx] heights up, cm; the first row has the smallest y */
};

/* Moments of heights and of the finest triangulation's slopes. */
struct cml_relief {
    double mean, rms; /* cm; rms about the mean */
    double lowest, highest;
    double slope_rms; /* [-]; the same for either diagonal of a cell */
};

/* What became of a heightmap; printed by `check`. */
struct cml_heightmap_notes {
    int nx, ny;
    double dx, dy;            /* cm */
    struct cml_relief relief; /* of the samples */
    double tolerance;         /* cm, asked for */
    double height_error; /* cm: largest distance along z between samples and mesh, at most the tolerance */
    double slope_error;  /* [-] rms of the difference of the slopes */
    size_t cells;        /* (nx - 1) (ny - 1) */
    size_t triangles;    /* that stand for them, without the skirt; 2 per cell when nothing was merged */
    double rim_mean;     /* cm: the height on which the boundary goes on outside */
    double rim_step;     /* cm: largest height that the skirt has to overcome */
    double skirt[2];     /* cm: its width along x and y */
};

/* Zeroed heights; nx, ny >= 2. CML_E_INPUT beyond 2^26 samples. */
CML_NODISCARD cml_status cml_heightmap_allocate(const char *path, double nx, double ny,
                                                struct cml_heightmap *map, struct cml_error *err);

void cml_heightmap_clear(struct cml_heightmap *map);

/* Refuses heights that are not finite: "PATH: 3 of 100 heights are missing, the first in row 2, column 7
 * ..."; rows count from the top, which is where `h` begins in a file. */
CML_NODISCARD cml_status cml_heightmap_check(const char *path, const struct cml_heightmap *map,
                                             struct cml_error *err);

/* From a file's order, top row first, to ours, and the map's middle to x = y = 0. */
void cml_heightmap_centre(struct cml_heightmap *map);

/* scale > 0 multiplies all lengths; then `turn` puts the map upside down, about the x axis; then the shift
 * (x, y, height; cm) is added. */
void cml_heightmap_place(struct cml_heightmap *map, double scale, const double shift[3], bool turn);

/* Measures the relief of ny rows of nx values h with the map's spacings. */
void cml_heightmap_measure(const struct cml_heightmap *map, const double *h, struct cml_relief *relief);

/* The prepared mesh in the boundary's frame, z = -height. tolerance: largest height error as a share of the
 * distance from the lowest to the highest sample, 0: merge only what lies in one plane. CML_E_INPUT for
 * memory, and when more triangles are left than the budget (NULL: CML_MESH_MOST) has. */
CML_NODISCARD cml_status cml_heightmap_mesh(const struct cml_heightmap *map, double tolerance,
                                            enum cml_normals normals, const struct cml_mesh_budget *budget,
                                            struct cml_mesh *mesh, struct cml_heightmap_notes *notes,
                                            struct cml_error *err);
