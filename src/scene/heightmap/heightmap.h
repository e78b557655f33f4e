/* Heights on a regular grid, as scanners measure them, and the boundary mesh made from them.
 *
 *     height map (samples)  --merge triangles within the tolerance-->  triangles  --add a skirt-->  mesh
 *
 *                    scan
 *                _/\__/\/\_
 *     __________/          \___________  outer plane, at the mean height of the rim
 *               skirt      skirt
 *
 * Samples are the mesh's vertices. Between samples the surface is the grid's finest triangulation, whose
 * diagonals alternate from cell to cell. Triangles are merged in pairs while all samples stay within the
 * tolerance of the merged triangle. All triangles are right-angled, and both halves of one share the middle
 * of its longest side, so there are neither needles nor T-junctions. Merged triangles are unions of the
 * finest ones, so the largest distance is found at a sample: the tolerance holds for the whole surface.
 *
 * A boundary's border lies in one plane, but the rim of a scan does not. So a skirt outside the scan leads
 * from the rim to the rim's mean height. It is one cell wide, or as wide as it is high, so that no part of it
 * is steeper than 45 degrees. Sides of triangles on the rim are at most CML_RIM_CELLS cells long, so that the
 * skirt has no needles either. SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/mesh.h"
#include "scene/heightmap/mesh_budget.h"

#define CML_RIM_CELLS 4

#define CML_HIGHEST_SAMPLE 1e30 /* largest height, cm; the limit of all lengths in .mci files */

/* A heightmap: samples of a height on a regular grid; owns its heights. */
struct cml_heightmap {
    int nx, ny;    /* number of samples along x and y, each 2 or more */
    double x0, y0; /* position of the first sample, cm */
    double dx, dy; /* spacing of samples along x and y, cm */
    double *h;     /* [ny][nx] heights, upwards, cm; the first row has the smallest y */
};

/* Statistics of heights, and of the slopes of their finest triangulation. */
struct cml_relief {
    double mean, rms; /* mean height and rms deviation from it, cm */
    double lowest, highest;
    double slope_rms; /* rms slope [-]; both diagonals of a cell give the same value */
};

/* The properties of a heightmap and of the mesh made from it; `check` prints them. */
struct cml_heightmap_notes {
    int nx, ny;
    double dx, dy;            /* spacing of samples, cm */
    struct cml_relief relief; /* statistics of the samples */
    double tolerance;         /* requested tolerance, cm */
    double height_error; /* largest vertical distance between samples and mesh, cm, at most the tolerance */
    double slope_error;  /* rms difference of the slopes of samples and mesh [-] */
    size_t cells;        /* number of cells, (nx - 1) (ny - 1) */
    size_t triangles;    /* number of triangles without the skirt; 2 per cell when none were merged */
    double rim_mean;     /* mean height of the rim, cm: the boundary's height outside the scan */
    double rim_step;     /* largest height that the skirt bridges, cm */
    double skirt[2];     /* width of the skirt along x and y, cm */
};

/* Makes a heightmap of nx x ny samples (2 or more each), whose heights are 0. Free it with
 * cml_heightmap_clear. CML_E_INPUT beyond 2^26 samples; `path` is for messages. */
CML_NODISCARD cml_status cml_heightmap_allocate(const char *path, double nx, double ny,
                                                struct cml_heightmap *map, struct cml_error *err);

void cml_heightmap_clear(struct cml_heightmap *map);

/* Refuses heights that are not finite: "PATH: 3 of 100 heights are missing, the first in row 2, column 7
 * ...". Rows are counted from the top row of the file. To be called while `h` still
 * begins with that row. */
CML_NODISCARD cml_status cml_heightmap_check(const char *path, const struct cml_heightmap *map,
                                             struct cml_error *err);

/* Turns a heightmap from a file's order, top row first, into the order of struct cml_heightmap, and moves its
 * middle to x = y = 0. */
void cml_heightmap_centre(struct cml_heightmap *map);

/* Places a heightmap: multiplies all lengths by scale > 0; then, if `turn`, turns the map upside down about
 * the x axis; then adds the shift (x, y, height; cm). */
void cml_heightmap_place(struct cml_heightmap *map, double scale, const double shift[3], bool turn);

/* Measures the relief of ny rows of nx heights h, with the map's size and spacings. */
void cml_heightmap_measure(const struct cml_heightmap *map, const double *h, struct cml_relief *relief);

/* Makes the prepared mesh of a heightmap in the boundary's frame, z = -height. tolerance: largest height
 * error as a share of the distance from the lowest to the highest sample; 0: only triangles in one plane are
 * merged. CML_E_INPUT if memory runs out, or if more triangles are left than the budget allows (NULL:
 * CML_MESH_MOST). */
CML_NODISCARD cml_status cml_heightmap_mesh(const struct cml_heightmap *map, double tolerance,
                                            enum cml_normals normals, const struct cml_mesh_budget *budget,
                                            struct cml_mesh *mesh, struct cml_heightmap_notes *notes,
                                            struct cml_error *err);
