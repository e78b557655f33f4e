/* Computes the horizons of cells over a mesh, level by level of a pyramid. SPDX-License-Identifier: MIT */
#include "surface/bounds/cell_horizon.h"

#include "bounds.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A level of the pyramid, as a packet on one side of the mesh sees it. The packet sees the interaction list
 * of its cell x: cells that do not touch x (t), although their parents touch its parent. far_one holds the
 * furthest reach towards the packet of those one cell away (1), far_two of those two cells away (2):
 *
 *     1 1 1 1 1 2
 *     1 t t t 1 2
 *     1 t x t 1 2        the 6 x 6 children of
 *     1 t t t 1 2        3 x 3 parents
 *     1 1 1 1 1 2
 *     2 2 2 2 2 2
 *
 * Together with the lists of all coarser levels these are all cells that do not touch x [Greengard and
 * Rokhlin, Journal of Computational Physics 73 (2), 1987]. */
struct view {
    int size;    /* cells along an axis */
    double cell; /* size of a cell, cm */
    bool repeats;
    const float *reach;       /* [size][size] how far the mesh reaches towards the packet above each cell,
                                 cm */
    float *far_one, *far_two; /* [size][size] furthest reach of cells one and two cells away, cm */
    float *steepest, *nearby; /* [size][size] steepest: slope of the steepest facet above a cell; nearby:
                                 slope of the steepest facet above the cell and the cells that touch it */
};

/* Returns the number of a cell in a level of `size` rows and columns. */
static size_t cell_at(int size, int x, int y)
{
    return (size_t)y * (size_t)size + (size_t)x;
}

/* Returns the number of a cell along an axis, -1 if there is none. size is a power of two. */
static int index_along(int x, int size, bool repeats)
{
    if (repeats) return x & (size - 1);
    return x >= 0 && x < size ? x : -1;
}

/* Finds far_one and far_two of a cell from the children of its parent's neighbours. Cells at the rim extend
 * outwards for ever, but that brings no two cells closer. In a mesh that repeats, the coarsest level has one
 * cell, and its copies one cell away stand for all copies further away. */
static void find_far(const struct view *view, int x, int y)
{
    const int size = view->size, x0 = (x / 2 - 1) * 2, y0 = (y / 2 - 1) * 2;
    float far[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (int qy = y0; qy < y0 + 6; qy++)
        for (int qx = x0; qx < x0 + 6; qx++) {
            const int dx = abs(qx - x), dy = abs(qy - y), gap = (dx > dy ? dx : dy) - 1;
            const int at_x = index_along(qx, size, view->repeats),
                      at_y = index_along(qy, size, view->repeats);
            if (gap > 0 && at_x >= 0 && at_y >= 0)
                far[gap] = fmaxf(far[gap], view->reach[cell_at(size, at_x, at_y)]);
        }
    view->far_one[cell_at(size, x, y)] = far[1];
    view->far_two[cell_at(size, x, y)] = far[2];
}

/* Finds far_one and far_two of all cells of a level. */
static void find_all_far(const struct view *view)
{
    for (int y = 0; y < view->size; y++)
        for (int x = 0; x < view->size; x++) find_far(view, x, y);
}

/* Returns the slope of the steepest facet above a cell and the cells that touch it. Between two places of
 * these cells lie only these facets, so neither place is seen more steeply from the other. */
static float steepest_nearby(const struct view *view, int x, int y)
{
    const int size = view->size;
    float most = 0;
    for (int qy = y - 1; qy <= y + 1; qy++)
        for (int qx = x - 1; qx <= x + 1; qx++) {
            const int at_x = index_along(qx, size, view->repeats),
                      at_y = index_along(qy, size, view->repeats);
            if (at_x >= 0 && at_y >= 0) most = fmaxf(most, view->steepest[cell_at(size, at_x, at_y)]);
        }
    return most;
}

/* Computes for all cells of a level the steepest slope under which cells close by are seen. */
static void find_nearby(const struct view *view)
{
    for (int y = 0; y < view->size; y++)
        for (int x = 0; x < view->size; x++)
            view->nearby[cell_at(view->size, x, y)] = steepest_nearby(view, x, y);
}

/* Returns the steepest slope (an upper bound) at which any place of the finest cell (x, y) sees another
 * place of the mesh. ground: a depth beyond which every packet in the cell lies, cm, positive towards the
 * packet's side. Each coarser level covers parts that lie further away: their furthest reach over their
 * least distance, but no more than the slope of the steepest facet near the cell's parent. */
static float steepest_view(const struct view *view, int levels, int x, int y, float ground)
{
    float most = view[0].nearby[cell_at(view[0].size, x, y)];
    for (int l = 0; l < levels; l++) {
        const size_t at = cell_at(view[l].size, x >> l, y >> l);
        const float cell = (float)view[l].cell;
        const float far =
            fmaxf((view[l].far_one[at] - ground) / cell, (view[l].far_two[at] - ground) / (2 * cell));
        const int up = l + 1 < levels ? l + 1 : l; /* the last level has a single cell */
        const float steepest = view[up].nearby[cell_at(view[up].size, x >> up, y >> up)];
        most = fmaxf(most, fminf(far, steepest));
    }
    return most;
}

/* Returns the number of cells of one level. */
static size_t level_cells(const struct cml_depth_pyramid *pyramid, int level)
{
    const size_t side = (size_t)(pyramid->size >> level);
    return side * side;
}

/* Returns the number of cells of all levels. */
static size_t all_cells(const struct cml_depth_pyramid *pyramid)
{
    size_t cells = 0;
    for (int l = 0; l < pyramid->levels; l++) cells += level_cells(pyramid, l);
    return cells;
}

/* Finds the steepest slope of each cell from the 2 x 2 cells of the level below. */
static void join_steepest(const struct view *below, const struct view *view)
{
    for (int y = 0; y < view->size; y++)
        for (int x = 0; x < view->size; x++) {
            const float *first = below->steepest + cell_at(below->size, 2 * x, 2 * y),
                        *second = first + below->size;
            view->steepest[cell_at(view->size, x, y)] =
                fmaxf(fmaxf(first[0], first[1]), fmaxf(second[0], second[1]));
        }
}

/* Makes the data for finding horizons on all levels of the pyramid, for one side: reach (the greatest depth
 * seen from below, or height seen from above), slopes and what lies around. scratch: [5][all cells]. Returns
 * the number of levels. */
static int make_views(const struct cml_depth_pyramid *pyramid, const float *steepest, int side,
                      float *scratch, struct view *view)
{
    const size_t all = all_cells(pyramid);
    size_t first = 0;
    for (size_t i = 0; i < all; i++) scratch[i] = side > 0 ? pyramid->deepest[i] : -pyramid->highest[i];
    for (int l = 0; l < pyramid->levels; l++) {
        float *reach = scratch + first;
        first += level_cells(pyramid, l);
        if (l < CML_HORIZON_LEVEL) continue;
        struct view *made = &view[l - CML_HORIZON_LEVEL];
        *made = (struct view){pyramid->size >> l, ldexp(pyramid->cell, l), pyramid->repeats, reach,
                              reach + all,        reach + 2 * all,         reach + 3 * all,  reach + 4 * all};
        if (l == CML_HORIZON_LEVEL)
            memcpy(made->steepest, steepest, level_cells(pyramid, l) * sizeof *steepest);
        else
            join_steepest(made - 1, made);
        find_nearby(made);
        find_all_far(made);
    }
    return pyramid->levels - CML_HORIZON_LEVEL;
}

/* Finds the horizons on one side. They are raised by more than rounding can turn a direction, and by the
 * share of a cell by which positions are off (depth_map.c). */
static void find_horizons(const struct cml_depth_pyramid *pyramid, const float *steepest, int side,
                          float *scratch, float *horizon)
{
    struct view view[CML_HORIZON_MOST_LEVELS];
    const int levels = make_views(pyramid, steepest, side, scratch, view), size = view[0].size;
    const float *ground = (side > 0 ? pyramid->highest : pyramid->deepest) + level_cells(pyramid, 0);
    for (int y = 0; y < size; y++)
        for (int x = 0; x < size; x++) {
            const size_t at = cell_at(size, x, y);
            const float far = steepest_view(view, levels, x, y, side > 0 ? ground[at] : -ground[at]);
            horizon[at] = 1.005F * far + (float)CML_HORIZON_RAISED;
        }
}

cml_status cml_find_horizons(const struct cml_depth_pyramid *pyramid, const float *steepest, float *below,
                             float *above, struct cml_error *err)
{
    const size_t size = 5 * all_cells(pyramid) * sizeof(float);
    CML_FREED float *scratch = malloc(size);
    if (!scratch) return cml_fail_memory(err, (double)size, "the bounds of a boundary");
    find_horizons(pyramid, steepest, 1, scratch, below);
    find_horizons(pyramid, steepest, -1, scratch, above);
    return CML_OK;
}
