/* SPDX-License-Identifier: MIT */
#include "oracle_grid.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define LARGEST 2048 /* cells along an axis */
#define LEAF 4       /* most triangles of a leaf */

static void *allocate(size_t count, size_t size)
{
    void *block = calloc(count > 0 ? count : 1, size);
    if (block) return block;
    fprintf(stderr, "no memory for the oracle\n");
    exit(5);
}

static struct oracle_box box_of(const struct oracle_grid *grid, uint32_t triangle)
{
    const uint32_t *v = grid->mesh->triangle[triangle];
    struct oracle_box box;
    for (int axis = 0; axis < 2; axis++) {
        const double a = grid->mesh->vertex[v[0]][axis], b = grid->mesh->vertex[v[1]][axis],
                     c = grid->mesh->vertex[v[2]][axis];
        box.low[axis] = fmin(a, fmin(b, c)) - grid->margin;
        box.high[axis] = fmax(a, fmax(b, c)) + grid->margin;
    }
    return box;
}

static struct oracle_box box_of_all(const struct oracle_grid *grid, uint32_t begin, uint32_t end)
{
    struct oracle_box all = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    for (uint32_t i = begin; i < end; i++) {
        const struct oracle_box box = box_of(grid, grid->entry[i]);
        for (int axis = 0; axis < 2; axis++) {
            all.low[axis] = fmin(all.low[axis], box.low[axis]);
            all.high[axis] = fmax(all.high[axis], box.high[axis]);
        }
    }
    return all;
}

/* ---- cells ---- */

/* Counts the triangles of every cell in first[cell] or, if `entry` exists, writes them there. oracle_cell_of
 * never falls when x grows, so that every point of a triangle's box is in one of its cells. */
static void fill_cells(struct oracle_grid *grid)
{
    for (uint32_t t = 0; t < grid->mesh->num_triangles; t++) {
        const struct oracle_box box = box_of(grid, t);
        const int last[2] = {oracle_cell_of(grid, 0, box.high[0]), oracle_cell_of(grid, 1, box.high[1])};
        for (int i = oracle_cell_of(grid, 0, box.low[0]); i <= last[0]; i++)
            for (int j = oracle_cell_of(grid, 1, box.low[1]); j <= last[1]; j++) {
                uint32_t *next = &grid->first[(size_t)i * (size_t)grid->size + (size_t)j];
                if (grid->entry) grid->entry[*next] = t;
                (*next)++;
            }
    }
}

static void sort_into_cells(struct oracle_grid *grid)
{
    const size_t cells = (size_t)grid->size * (size_t)grid->size;
    grid->first = allocate(cells + 1, sizeof *grid->first);
    fill_cells(grid);
    uint32_t total = 0;
    for (size_t i = 0; i <= cells; i++) {
        const uint32_t count = grid->first[i];
        grid->first[i] = total;
        total += count;
    }
    grid->entry = allocate(total, sizeof *grid->entry);
    fill_cells(grid);
    for (size_t i = cells; i > 0; i--) grid->first[i] = grid->first[i - 1];
    grid->first[0] = 0;
}

/* ---- trees ---- */

struct keyed {
    double key;
    uint32_t triangle;
};

static int compare_keys(const void *a, const void *b)
{
    const double x = ((const struct keyed *)a)->key, y = ((const struct keyed *)b)->key;
    return (x > y) - (x < y);
}

/* Sorts entries by the middles of their boxes, along the longer side of the common box. */
static void sort_entries(struct oracle_grid *grid, const struct oracle_box *all, uint32_t begin, uint32_t end)
{
    const int axis = all->high[1] - all->low[1] > all->high[0] - all->low[0];
    struct keyed *keyed = allocate(end - begin, sizeof *keyed);
    for (uint32_t i = begin; i < end; i++) {
        const struct oracle_box box = box_of(grid, grid->entry[i]);
        keyed[i - begin] = (struct keyed){box.low[axis] + box.high[axis], grid->entry[i]};
    }
    qsort(keyed, end - begin, sizeof *keyed, compare_keys);
    for (uint32_t i = begin; i < end; i++) grid->entry[i] = keyed[i - begin].triangle;
    free(keyed);
}

/* Returns the number of nodes in a tree of n triangles, which is halved down to leaves. */
static uint32_t nodes_of(uint32_t n)
{
    return n <= LEAF ? 1 : 1 + nodes_of(n / 2) + nodes_of(n - n / 2);
}

static uint32_t make_tree(struct oracle_grid *grid, uint32_t at, uint32_t begin, uint32_t end)
{
    struct oracle_node *node = &grid->node[at];
    const uint32_t middle = begin + (end - begin) / 2;
    node->box = box_of_all(grid, begin, end);
    if (end - begin <= LEAF) {
        node->begin = begin;
        node->end = end;
        return node->next = at + 1;
    }
    sort_entries(grid, &node->box, begin, end);
    return node->next = make_tree(grid, make_tree(grid, at + 1, begin, middle), middle, end);
}

static void make_trees(struct oracle_grid *grid, uint32_t most)
{
    const size_t cells = (size_t)grid->size * (size_t)grid->size;
    grid->tree = allocate(cells + 1, sizeof *grid->tree);
    for (size_t i = 0; i < cells; i++) {
        const uint32_t count = grid->first[i + 1] - grid->first[i];
        grid->tree[i + 1] = grid->tree[i] + (count > most ? nodes_of(count) : 0);
    }
    grid->node = allocate(grid->tree[cells], sizeof *grid->node);
    for (size_t i = 0; i < cells; i++)
        if (grid->tree[i + 1] > grid->tree[i])
            make_tree(grid, grid->tree[i], grid->first[i], grid->first[i + 1]);
}

void oracle_grid_create(const struct cml_mesh *mesh, uint32_t most, struct oracle_grid *grid)
{
    *grid = (struct oracle_grid){.mesh = mesh, .size = 1};
    const double root = sqrt((double)mesh->num_triangles);
    if (most < UINT32_MAX && root >= 8) grid->size = root < LARGEST ? (int)root : LARGEST;
    double high[2] = {-INFINITY, -INFINITY};
    grid->corner[0] = grid->corner[1] = INFINITY;
    for (size_t i = 0; i < mesh->num_vertices; i++)
        for (int axis = 0; axis < 2; axis++) {
            grid->corner[axis] = fmin(grid->corner[axis], mesh->vertex[i][axis]);
            high[axis] = fmax(high[axis], mesh->vertex[i][axis]);
        }
    for (int axis = 0; axis < 2; axis++) {
        grid->per_cell[axis] = grid->size / (high[axis] - grid->corner[axis]);
        grid->margin = fmax(grid->margin, 1e-12 * (high[axis] - grid->corner[axis]));
    }
    sort_into_cells(grid);
    make_trees(grid, most);
}

void oracle_grid_free(struct oracle_grid *grid)
{
    free(grid->first);
    free(grid->entry);
    free(grid->tree);
    free(grid->node);
}
