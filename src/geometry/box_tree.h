/* A tree of boxes, over a mesh's triangles or any boxes: which may meet, which stand in a vertical column,
 * and which lies around another. Exists because the overlap check must stay near linear whatever the
 * triangles' sizes and shapes (walls, needles, local refinement), and whatever bodies lie in each other.
 * Knows no scene. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct cml_boxtree;

/* The arrays must outlive the tree. num_triangles >= 1. CML_E_INPUT only when memory runs out. */
CML_NODISCARD cml_status cml_boxtree_create(const double (*vertex)[3], const uint32_t (*triangle)[3],
                                            size_t num_triangles, struct cml_boxtree **tree,
                                            struct cml_error *err);

/* Over boxes, given by their lower and upper corners, which must outlive the tree. n >= 1. CML_E_INPUT only
 * when memory runs out. */
CML_NODISCARD cml_status cml_boxtree_create_boxes(const double (*box)[2][3], size_t n,
                                                  struct cml_boxtree **tree, struct cml_error *err);

void cml_boxtree_free(struct cml_boxtree *tree);

/* Called with triangles whose boxes touch; true ends the search. */
typedef bool cml_boxtree_pair(void *context, uint32_t i, uint32_t j);

/* Every pair (i of a, j of b) whose boxes touch. True when `pair` ended the search. */
bool cml_boxtree_pairs(const struct cml_boxtree *a, const struct cml_boxtree *b, cml_boxtree_pair *pair,
                       void *context);

/* Every pair (i, j), i != j, within one tree, once. */
bool cml_boxtree_own_pairs(const struct cml_boxtree *tree, cml_boxtree_pair *pair, void *context);

/* A mesh in a tree; all borrowed. part: of each triangle, NULL where all count. */
struct cml_column_mesh {
    const double (*vertex)[3];
    const uint32_t (*triangle)[3];
    const uint32_t *part;
    const struct cml_boxtree *tree;
};

struct cml_column {
    int crossings, above; /* triangles in the column, and those above the point */
    int winding;          /* of those above: facing up (mesh.h) less facing down */
    bool touches;         /* the point lies on one */
    double nearest;       /* cm to the next in the vertical, rounded; INFINITY: there is none */
};

/* What of a mesh stands over and under a point in the vertical, by exact signs (predicate.h): on which side
 * of a sheet, or in which part of a body it lies. Of all triangles but those of part `without`. A column
 * through an edge or a vertex counts one of the triangles on each of its sides. */
struct cml_column cml_column_through(const struct cml_column_mesh *mesh, uint32_t without,
                                     const double point[3]);
#define CML_WITHOUT_NONE UINT32_MAX

/* Every triangle whose box touches this one. */
typedef void cml_boxtree_visit(void *context, uint32_t i);
void cml_boxtree_touching(const struct cml_boxtree *tree, const double lower[3], const double upper[3],
                          cml_boxtree_visit *visit, void *context);

/* Square of the distance of a triangle from p. */
typedef double cml_boxtree_square(const void *context, uint32_t i, const double p[3]);

/* The square of the distance to the closest triangle, *i; who has a guess which it is puts that there, else
 * 0. */
double cml_boxtree_closest(const struct cml_boxtree *tree, const double p[3], cml_boxtree_square *square,
                           const void *context, uint32_t *i);

/* In a tree over boxes that are sorted by size: the first box behind number i that holds the box i and that
 * `accept` takes; n where there is none. Called with i and few of the boxes that hold it, in any order. */
typedef bool cml_boxtree_accept(void *context, uint32_t i, uint32_t j);
uint32_t cml_boxtree_first_around(const struct cml_boxtree *tree, uint32_t i, cml_boxtree_accept *accept,
                                  void *context);
