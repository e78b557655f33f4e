/* The way of a ray over a mesh that is repeated over the whole plane, cut into segments each of which lies
 * over one copy. The mesh itself is one period and a margin of further cells around it, all copies of cells
 * of the period (scene/heightmap/tile.h); it is closed by a skirt and an outer plane that no segment comes
 * to. So each segment is a query like any other (mesh_query.h), of a packet that is moved by whole periods
 * to where the mesh is, and what is said there of rounding holds here too.
 *
 * Segments overlap by half a cell, many times what rounding can move: a crossing near the end of one is
 * found well inside of the next. SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>
#include <stdint.h>

/* So many segments are looked at before a ray is given up: one that flies between the highest and the lowest
 * point of the mesh over more than half as many periods, and meets nothing. */
#define CML_TILE_MOST_SEGMENTS 65536

/* What is repeated. The first triangles of the mesh are those of its cells, row by row from the lowest x and
 * y on, two to a cell. Those of the period alone, in the same order, are the primitives that queries take
 * and give. */
struct cml_mesh_period {
    int n[2];         /* cells of the period along x and y, 2 or more; 0: the mesh is not repeated */
    int margin[2];    /* cells of the mesh around the period, on each side; 3 or more */
    double corner[2]; /* of the period's first cell, in query coordinates, cm */
    double cell[2];   /* size of a cell, cm */
};

/* A ray on its way from segment to segment. Distances along the ray, cm. */
struct cml_tile_path {
    const struct cml_mesh_period *period; /* borrowed, as p and u */
    const double *p, *u;                  /* as of cml_mesh_surface_hit */
    double end;                           /* of the path, or where it leaves the depths of the mesh */
    double from, to;                      /* of the segment */
    int leaving;                          /* axis along which the segment leaves the mesh at `to` */
    double origin[3];                     /* where the segment begins, moved by whole periods */
    int exclude;                          /* the triangle of the mesh that the packet stands on there */
    int segments;                         /* so far, with this one */
};

/* The first segment; false when there is none, for the ray does not come between the depths low and high,
 * which hold the mesh and more than rounding. exclude: primitive, -1 or CML_NEAR_FACETS. */
bool cml_tile_begin(const struct cml_mesh_period *period, const double p[3], const double u[3], double t_max,
                    int exclude, double low, double high, struct cml_tile_path *path);

/* The next one; false at the path's end, and after CML_TILE_MOST_SEGMENTS. */
bool cml_tile_next(struct cml_tile_path *path);

/* Whether the path was given up before its end. */
bool cml_tile_is_too_long(const struct cml_tile_path *path);

/* How many primitives there are: two for each cell of the period. */
uint64_t cml_tile_primitives(const struct cml_mesh_period *period);

/* The primitive whose copy a triangle of the mesh is; -1: none, it belongs to the skirt. */
int cml_tile_primitive(const struct cml_mesh_period *period, int triangle);

/* The triangle of the mesh that is a primitive itself. */
int cml_tile_triangle(const struct cml_mesh_period *period, int primitive);
