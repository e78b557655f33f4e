/* Finds the triangles of a mesh by place, for the oracle: a grid of cells over the x-y plane, and a tree of
 * boxes in cells with many triangles.
 *
 * A search for a rectangle never leaves out a triangle whose own box has a point of the rectangle; it may
 * return others. `unit.oracle` compares with the list of all triangles.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/mesh.h"

struct oracle_box {
    double low[2], high[2];
};

/* A node of a tree. Its descendants follow it, up to `next`. */
struct oracle_node {
    struct oracle_box box;
    uint32_t begin, end; /* range of entries; empty unless the node is a leaf */
    uint32_t next;
};

struct oracle_grid {
    const struct cml_mesh *mesh;
    double corner[2], per_cell[2];
    double margin; /* margin around a triangle's box [cm]: the rounding of the test that asks if a point is
                    * inside */
    int size;
    uint32_t *first, *entry; /* [size * size + 1] and [first[size * size]]: triangles of each cell */
    uint32_t *tree;          /* [size * size + 1] first node of each cell, no nodes for a cell with few
                              * entries */
    struct oracle_node *node;
};

/* Makes the grid. Borrows the mesh. Cells with more than `most` triangles get a tree; with UINT32_MAX all
 * triangles are in one list. Ends the process if memory runs out. */
void oracle_grid_create(const struct cml_mesh *mesh, uint32_t most, struct oracle_grid *grid);
void oracle_grid_free(struct oracle_grid *grid);

/* ---- triangles in a rectangle ---- */

static inline int oracle_cell_of(const struct oracle_grid *grid, int axis, double x)
{
    const double cell = (x - grid->corner[axis]) * grid->per_cell[axis];
    return cell > 0 ? (cell < grid->size ? (int)cell : grid->size - 1) : 0;
}

/* A search over the triangles of one cell. A triangle may also be found in another cell. */
struct oracle_search {
    const struct oracle_grid *grid;
    struct oracle_box box;
    uint32_t node, last_node, entry, last_entry;
};

static inline struct oracle_search oracle_search_cell(const struct oracle_grid *grid, int i, int j,
                                                      const struct oracle_box *box)
{
    const size_t cell = (size_t)i * (size_t)grid->size + (size_t)j;
    const uint32_t node = grid->tree[cell], last_node = grid->tree[cell + 1];
    const uint32_t first = node < last_node ? 0 : grid->first[cell];
    const uint32_t last = node < last_node ? 0 : grid->first[cell + 1];
    return (struct oracle_search){grid, *box, node, last_node, first, last};
}

static inline bool oracle_boxes_meet(const struct oracle_box *a, const struct oracle_box *b)
{
    return a->low[0] <= b->high[0] && b->low[0] <= a->high[0] && a->low[1] <= b->high[1] &&
           b->low[1] <= a->high[1];
}

/* Writes the next triangle of the search. Returns false after the last one. */
static inline bool oracle_next(struct oracle_search *search, uint32_t *triangle)
{
    while (search->entry == search->last_entry) {
        if (search->node == search->last_node) return false;
        const struct oracle_node *node = &search->grid->node[search->node];
        const bool meets = oracle_boxes_meet(&node->box, &search->box);
        search->node = meets ? search->node + 1 : node->next;
        search->entry = node->begin;
        search->last_entry = meets ? node->end : node->begin;
    }
    *triangle = search->grid->entry[search->entry++];
    return true;
}
