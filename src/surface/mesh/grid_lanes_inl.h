/* Code, included by the engine's loops over lanes, and so compiled once for each level of the processor.
 * Vector loops find the first crossings of many rays with a sheet (sheet_mesh.h) or its outer plane at once.
 *
 *          o packet
 *           \
 *     .      \          .
 *      ' .    \      . '          dotted: the horizon of place x
 *     /\  ' .  \  . '   /\
 *    /  \    ' .x'     /  \
 *   /    \______|_____/    \      mesh
 *
 * Idea: a steep ray crosses a sheet only once. The horizon of a place (surface/bounds/cell_horizon.h) says
 * how steep is steep enough: packets that leave x above the dotted lines meet nothing. In reverse, a ray that
 * arrives at x from above the dotted lines has met nothing before. Therefore the loops look for a facet that
 * the ray surely meets, or that surely lies ahead of the ray's end, and compare the ray with the horizon
 * there. Where that facet lies depends on the mesh's depth, which is guessed from the cell below the last
 * guess.
 *
 * Answers equal those of the walk (grid_walk.h) to the last bit, because the same arithmetic finds the
 * crossing with the facet's plane. A ray is left to the walk if rounding could change its answer, or if the
 * ray is not steep enough.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "surface_hit.h"
#include "geometry/vec3.h"
#include "surface/mesh/grid_mesh.h"
#include "surface/tree/rounding.h"

#include <math.h>

enum { CML_GRID_LANES = 64, CML_GRID_GROUP = 16 }; /* a group of rays goes through a loop together */

enum cml_grid_answer { CML_GRID_UNDECIDED, CML_GRID_MISSED, CML_GRID_MET };

/* Rays of packets on one side of a mesh that stand on no facet, and their crossings. A structure of arrays
 * with entries 0..count-1; entries behind may hold anything. Positions are in the boundary's frame, x and y
 * from the scene's origin, cm. */
struct cml_grid_lanes {
    int count;
    int lane[CML_GRID_LANES]; /* lane number of the caller */
    _Alignas(64) real x[CML_GRID_LANES], y[CML_GRID_LANES], z[CML_GRID_LANES];
    real ux[CML_GRID_LANES], uy[CML_GRID_LANES], uz[CML_GRID_LANES]; /* direction of the ray, a unit vector */
    real s[CML_GRID_LANES];                                          /* length of the path, cm */
    /* The answers of the search: */
    int answer[CML_GRID_LANES], primitive[CML_GRID_LANES];
    real t[CML_GRID_LANES]; /* distance of the crossing, cm */
    real at_x[CML_GRID_LANES], at_y[CML_GRID_LANES],
        at_z[CML_GRID_LANES]; /* position at the crossing, or at the path's end if there is no crossing */
    real normal_x[CML_GRID_LANES], normal_y[CML_GRID_LANES], normal_z[CML_GRID_LANES];
    /* Intermediate values, in double, in the centred frame: */
    double origin[3][CML_GRID_LANES], direction[3][CML_GRID_LANES];
    double end[CML_GRID_LANES],
        err[CML_GRID_LANES];    /* end: length of the path, cm; err: err_query of rounding.h */
    double way[CML_GRID_LANES]; /* distance from the packet to the place found */
    int cell[2][CML_GRID_LANES], index[CML_GRID_LANES];
};

/* The data common to all rays. */
struct cml_grid_view {
    const struct cml_grid_mesh *grid;
    const struct cml_centred_mesh *centred;
    const struct cml_depth_bounds *depths; /* depths of the surface */
    const real *horizons;                  /* horizons of the surface's cells, on the packets' side */
    real depth;  /* depth of the mesh in the frame in which packets' depths were rounded, cm */
    real x0, y0; /* scene position where x and y of packets are 0, cm */
    real side;   /* +1 if the packets are below the mesh, else -1 */
};

#define CML_GRID_LOOP static __attribute__((noinline))

/* The least and the greatest depth of a cell, of 16 bits each, read as one word of 32 bits. */
typedef uint32_t __attribute__((may_alias)) cml_grid_depths_word;

/* Returns the index of a cell in memory, as cml_grid_mesh_index does. A grid has fewer than 2^28 cells. */
static inline int cml_grid_lane_index(int i, int j, int tiles)
{
    return 16 * ((j >> 2) * tiles + (i >> 2)) + 4 * (j & 3) + (i & 3);
}

/* Returns the cell of a position along an axis, in cells; the first or last cell if the position is outside
 * the grid. */
static inline int cml_grid_lane_cell(double position, double last)
{
    const double inner = position > 0 ? position : 0;
    return (int)(inner < last ? inner : last);
}

/* Moves rays into the centred frame. Rays beside the mesh's box can meet only the outer plane and are
 * answered here. */
CML_GRID_LOOP void cml_grid_lanes_begin(const struct cml_grid_view *view, int first, struct cml_grid_lanes *l)
{
    const struct cml_centred_mesh *centred = view->centred;
    const double cx = centred->centre[0], cy = centred->centre[1], cz = centred->centre[2];
    const double x_least = centred->lower[0], x_most = centred->upper[0], y_least = centred->lower[1],
                 y_most = centred->upper[1];
    const double span = view->depth, side = view->side, border = centred->mesh.z_border,
                 err_mesh = centred->err_mesh;
#pragma omp simd
    for (int k = first; k < first + CML_GRID_GROUP; k++) {
        const double px = l->x[k], py = l->y[k], pz = l->z[k], ux = l->ux[k], uy = l->uy[k], uz = l->uz[k];
        const double err_position = cml_err_position(px, py, pz, span);
        const double x = px - cx, y = py - cy, z = pz - cz, end = l->s[k], err = err_position + err_mesh;
        const double t = (border - z) / uz, heads = side * uz;
        const int crosses = (heads < 0) & (t < end), in_doubt = (heads < 0) & (t < err);
        const double last = crosses ? t : end, x_last = x + last * ux, y_last = y + last * uy;
        const int left = (x < x_least - err) & (x_last < x_least - err),
                  right = (x > x_most + err) & (x_last > x_most + err);
        const int before = (y < y_least - err) & (y_last < y_least - err),
                  behind = (y > y_most + err) & (y_last > y_most + err);
        const int sure = (left | right | before | behind) & !in_doubt;
        l->origin[0][k] = x;
        l->origin[1][k] = y;
        l->origin[2][k] = z;
        l->direction[0][k] = ux;
        l->direction[1][k] = uy;
        l->direction[2][k] = uz;
        l->end[k] = end;
        l->err[k] = err;
        l->answer[k] = sure ? (crosses ? CML_GRID_MET : CML_GRID_MISSED) : CML_GRID_UNDECIDED;
        l->primitive[k] = CML_OUTER_PLANE;
        l->t[k] = (real)t;
        l->at_x[k] = (real)(px + t * ux);
        l->at_y[k] = (real)(py + t * uy);
        l->at_z[k] = (real)(border + cz);
        l->normal_x[k] = l->normal_y[k] = 0;
        l->normal_z[k] = -1;
    }
}

/* Corner, scale and size of a grid, to convert positions to cells. */
struct cml_grid_scale {
    double x_corner, y_corner, x_scale, y_scale, x_last, y_last;
    int tiles;
};

/* Returns the corner, scale and size of a grid. */
static inline struct cml_grid_scale cml_grid_scale_of(const struct cml_grid_mesh *grid)
{
    const struct cml_grid_scale scale = {grid->corner[0],       grid->corner[1], grid->cells_per_cm[0],
                                         grid->cells_per_cm[1], grid->n[0] - 1,  grid->n[1] - 1,
                                         grid->level[0].tiles};
    return scale;
}

/* Guesses the cell in which each ray meets the mesh or ends. Each guess takes the depth of the cell guessed
 * before; the first guess takes the mean depth. */
CML_GRID_LOOP void cml_grid_lanes_guess(const struct cml_grid_mesh *grid, int first, struct cml_grid_lanes *l)
{
    const cml_grid_depths_word *depths = (const void *)grid->level[0].depths;
    const struct cml_grid_scale scale = cml_grid_scale_of(grid);
    const double step = 1 / grid->steps_per_cm, half_step = 0.5 * step, z_first = grid->z;
    const double mean = z_first + grid->mean * step;
#pragma omp simd
    for (int k = first; k < first + CML_GRID_GROUP; k++) {
        const double inverse = 1 / l->direction[2][k], z = l->origin[2][k], end = l->end[k];
        const double x = (l->origin[0][k] - scale.x_corner) * scale.x_scale,
                     y = (l->origin[1][k] - scale.y_corner) * scale.y_scale,
                     ux = l->direction[0][k] * scale.x_scale, uy = l->direction[1][k] * scale.y_scale;
        double depth = mean;
        int i = 0, j = 0, index = 0;
        for (int n = 0; n < 3; n++) {
            const double there = (depth - z) * inverse, ahead = there > 0 ? there : 0,
                         t = ahead < end ? ahead : end;
            i = cml_grid_lane_cell(x + t * ux, scale.x_last);
            j = cml_grid_lane_cell(y + t * uy, scale.y_last);
            index = cml_grid_lane_index(i, j, scale.tiles);
            if (n == 2) break;
            const uint32_t word = depths[index];
            depth = z_first + half_step * ((int)(word & 0xffffu) + (int)(word >> 16));
        }
        l->cell[0][k] = i;
        l->cell[1][k] = j;
        l->index[k] = index;
    }
}

/* Decides a ray that crosses a facet's plane at t, or ends before, at a place well inside the facet. Returns
 * MET, MISSED, or UNDECIDED if rounding could change the answer. */
static inline int cml_grid_lane_answer(double sign, double along, double t, double end, double err)
{
    const double beyond = (t - end) * along * sign;
    const int sure = (sign * along >= err_sine_grid) & (t > err), is_met = t<end, is_missed = beyond> err;
    const int answer = is_met ? CML_GRID_MET : (is_missed ? CML_GRID_MISSED : CML_GRID_UNDECIDED);
    return sure ? answer : CML_GRID_UNDECIDED;
}

/* Returns the smallest barycentric weight of a place (x, y) in a facet of a sheet; negative outside. */
static inline double cml_grid_lane_weight(const struct cml_sheet_facet *f, double x, double y)
{
    const double a = x - f->corner[0], b = y - f->corner[1];
    const double v = f->weight[0][0] * a + f->weight[0][1] * b, w = f->weight[1][0] * a + f->weight[1][1] * b;
    return cml_smaller(cml_smaller(v, w), 1 - v - w);
}

/* Intersects ray k with one facet listed in its cell. Returns 1 and sets the answer if the ray surely
 * crosses the facet's plane, or surely ends, inside the facet's outline; otherwise returns 0, and the next
 * facet is tried. */
static inline int cml_grid_lane_intersect_facet(const struct cml_grid_view *view, uint32_t number, int k,
                                                struct cml_grid_lanes *l)
{
    const struct cml_sheet_facet *f = &view->grid->facet[number];
    const double x = l->origin[0][k], y = l->origin[1][k], z = l->origin[2][k];
    const double ux = l->direction[0][k], uy = l->direction[1][k], uz = l->direction[2][k], end = l->end[k];
    const double along = ux * f->plane[0] + uy * f->plane[1] + uz * f->plane[2];
    const double t = (f->plane[3] - (x * f->plane[0] + y * f->plane[1] + z * f->plane[2])) / along;
    const double to = cml_smaller(t, end);
    if (!(cml_grid_lane_weight(f, x + to * ux, y + to * uy) > err_weight_sheet)) return 0;
    l->answer[k] = cml_grid_lane_answer(view->side, along, t, end, l->err[k]);
    l->primitive[k] = (int)number;
    l->t[k] = (real)t;
    l->at_x[k] = (real)((double)l->x[k] + to * ux);
    l->at_y[k] = (real)((double)l->y[k] + to * uy);
    l->at_z[k] = (real)((double)l->z[k] + to * uz);
    l->normal_x[k] = (real)f->plane[0];
    l->normal_y[k] = (real)f->plane[1];
    l->normal_z[k] = (real)f->plane[2];
    l->way[k] = to;
    return 1;
}

/* Intersects each ray with the facets that its cell lists, the likeliest facet first. A search reads cell,
 * list and facet; each read gives the address of the next, so each would wait for memory. In a mesh of 1e5
 * triangles these data exceed a processor's second cache. Therefore all rays of a group prefetch their next
 * read before the first ray continues [group prefetching: Chen, Ailamaki, Gibbons and Mowry, Improving hash
 * join performance through prefetching, ICDE 2004]. */
static void cml_grid_lanes_intersect(const struct cml_grid_view *view, int first, struct cml_grid_lanes *l)
{
    const struct cml_grid_mesh *grid = view->grid;
    int pending[CML_GRID_GROUP], count = 0;
    uint32_t next[CML_GRID_GROUP], last[CML_GRID_GROUP];
    for (int k = first; k < first + CML_GRID_GROUP && k < l->count; k++)
        if (l->answer[k] == CML_GRID_UNDECIDED) pending[count++] = k;
    for (int n = 0; n < count; n++) __builtin_prefetch(&grid->first[l->index[pending[n]]]);
    for (int n = 0; n < count; n++) {
        next[n] = grid->first[l->index[pending[n]]];
        last[n] = grid->first[l->index[pending[n]] + 1];
        __builtin_prefetch(&grid->listed[next[n]]);
    }
    for (int n = 0; n < count; n++) __builtin_prefetch(&grid->facet[grid->listed[next[n]]]);
    while (count) {
        int left = 0;
        for (int n = 0; n < count; n++) {
            const int k = pending[n];
            uint32_t i = next[n];
            if (i == last[n] || cml_grid_lane_intersect_facet(view, grid->listed[i], k, l)) continue;
            __builtin_prefetch(&grid->facet[grid->listed[++i]]);
            pending[left] = k;
            next[left] = i;
            last[left++] = last[n];
        }
        count = left;
    }
}

/* Asks for the exact query again, unless the crossing that was found is surely a ray's first one.
 *
 * A ray of length `way` arrives at a place with the horizon h: no facet rises more steeply than h towards the
 * place. excess = |uz| - h uxy says by how much the ray is steeper. So the start of the ray lies above all
 * facets by at least way (excess + CML_HORIZON_RAISED uxy), as horizons are stored a little too high. That
 * height must exceed the errors of two queries in depth, 2 err (1 + h): across a facet of slope h an error
 * err of a place is an error of depth of at most err (1 + h). */
CML_GRID_LOOP void cml_grid_lanes_check(const struct cml_grid_view *view, int first, struct cml_grid_lanes *l)
{
    const struct cml_depth_bounds map = *view->depths;
    const real *restrict const horizons = view->horizons;
    const real x0 = view->x0, y0 = view->y0;
#pragma omp simd
    for (int k = first; k < first + CML_GRID_GROUP; k++) {
        const struct cml_vec p = {l->at_x[k] + x0, l->at_y[k] + y0, 0};
        const real h = cml_cell_horizon(&map, horizons, p, CML_BOUNDS_SQUARE);
        const real uxy = CML_SQRT(l->ux[k] * l->ux[k] + l->uy[k] * l->uy[k]), uz = CML_FABS(l->uz[k]);
        const real excess = uz - h * uxy;
        const int steep = (excess > 0) & ((real)l->way[k] * (excess + (real)CML_HORIZON_RAISED * uxy) >
                                          2 * (real)l->err[k] * (1 + h));
        const int outside = l->primitive[k] == CML_OUTER_PLANE;
        l->answer[k] = (outside | steep) ? l->answer[k] : CML_GRID_UNDECIDED;
    }
}

/* Finds for many rays at once where they meet a mesh: rays in groups pass four loops, which move them to the
 * mesh, guess a cell, test its facets, and check the answer. Rays without a sure answer stay undecided. */
static void cml_grid_lanes_ask(const struct cml_grid_view *view, struct cml_grid_lanes *l)
{
    for (int first = 0; first < l->count; first += CML_GRID_GROUP) {
        cml_grid_lanes_begin(view, first, l);
        cml_grid_lanes_guess(view->grid, first, l);
        cml_grid_lanes_intersect(view, first, l);
        cml_grid_lanes_check(view, first, l);
    }
}
