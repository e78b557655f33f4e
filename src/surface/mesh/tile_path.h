/* The path of a ray over a mesh that is repeated over the whole plane, cut into segments that each lie over
 * one copy.
 *
 *     |<-- margin -->|<---- period ---->|<-- margin -->|    the mesh: one copy
 *                         o===================>             a segment ends one cell before the mesh
 *                                           o=====> ...     the next one, moved back by one period
 *
 * The mesh is one period with a margin of further cells around it; all copies consist of cells of the period
 * (scene/heightmap/tile.h). A skirt and an outer plane close the mesh, but no segment reaches them. Therefore
 * each segment is a query like any other (mesh_query.h), for a packet moved by whole periods to the mesh, and
 * the bounds of rounding there hold here, too.
 *
 * Segments overlap by half a cell, many times the effect of rounding: a crossing near the end of one segment
 * lies well inside the next.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>
#include <stdint.h>

/* Number of segments after which a ray is given up. Such a ray runs between the highest and the lowest point
 * of the mesh over more than half as many periods, and meets nothing. */
#define CML_TILE_MOST_SEGMENTS 65536

/* The period of a tile. The first triangles of the mesh are those of its cells, two per cell, row by row from
 * the lowest x and y on. The triangles of the period alone, in the same order, are the primitives that
 * queries take and give. */
struct cml_mesh_period {
    int n[2];         /* cells of the period along x and y, at least 2; 0: the mesh is not repeated */
    int margin[2];    /* cells of the mesh around the period on each side, at least 3 */
    double corner[2]; /* corner of the period's first cell, in query coordinates, cm */
    double cell[2];   /* size of a cell along x and y, cm */
};

/* A ray on its way from segment to segment. Distances are along the ray, cm. */
struct cml_tile_path {
    const struct cml_mesh_period *period; /* the tile's period; the caller owns *period, p and u */
    const double *p, *u;                  /* position and direction as in cml_mesh_surface_hit */
    double end;                           /* end of the path, or where it leaves the depths of the mesh */
    double from, to;                      /* begin and end of the segment */
    int leaving;                          /* axis along which the segment leaves the mesh at `to`; -1: the
                                             path ends before */
    double origin[3];                     /* where the segment begins, moved by whole periods */
    int exclude;  /* triangle of the mesh on which the packet stands at `origin`, or -1 or CML_NEAR_FACETS */
    int segments; /* number of segments so far, including this one */
};

/* Finds the first segment of a path. Returns false if the ray stays outside the depths from low to high,
 * which enclose the mesh by more than rounding. exclude: primitive on which the packet stands, or -1 or
 * CML_NEAR_FACETS. */
bool cml_tile_begin(const struct cml_mesh_period *period, const double p[3], const double u[3], double t_max,
                    int exclude, double low, double high, struct cml_tile_path *path);

/* Finds the next segment. Returns false at the path's end and after CML_TILE_MOST_SEGMENTS. */
bool cml_tile_next(struct cml_tile_path *path);

/* True if the path was given up before its end. */
bool cml_tile_is_too_long(const struct cml_tile_path *path);

/* Returns the number of primitives: two for each cell of the period. */
uint64_t cml_tile_primitives(const struct cml_mesh_period *period);

/* Returns the primitive of which a triangle of the mesh is a copy; -1 for a triangle of the skirt. */
int cml_tile_primitive(const struct cml_mesh_period *period, int triangle);

/* Returns the mesh's triangle that is the primitive itself, not a copy. */
int cml_tile_triangle(const struct cml_mesh_period *period, int primitive);
