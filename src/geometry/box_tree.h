/* A tree of boxes over triangles or over given boxes. It finds boxes that touch, triangles in a vertical
 * column, the closest triangle, and the smallest box around another box. With the tree, the check for
 * overlaps needs nearly linear time, whatever the sizes and shapes of triangles (walls, needles, local
 * refinement) and however bodies are nested. Knows no scene. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct cml_boxtree;

/* Builds a tree over triangles. The arrays must outlive the tree; num_triangles >= 1. Returns CML_E_INPUT if
 * memory runs out. */
CML_NODISCARD cml_status cml_boxtree_create(const double (*vertex)[3], const uint32_t (*triangle)[3],
                                            size_t num_triangles, struct cml_boxtree **tree,
                                            struct cml_error *err);

/* Builds a tree over n >= 1 boxes, given by their lower and upper corners. The boxes must outlive the tree.
 * Returns CML_E_INPUT if memory runs out. */
CML_NODISCARD cml_status cml_boxtree_create_boxes(const double (*box)[2][3], size_t n,
                                                  struct cml_boxtree **tree, struct cml_error *err);

/* Frees a tree; NULL is allowed. */
void cml_boxtree_free(struct cml_boxtree *tree);

/* A callback of cml_boxtree_pairs and cml_boxtree_own_pairs. i, j: numbers of two triangles whose boxes
 * touch. Returns true to end the search. */
typedef bool cml_boxtree_pair(void *context, uint32_t i, uint32_t j);

/* Calls `pair` for each triangle i of a and j of b whose boxes touch. Returns true if `pair` ended the
 * search. */
bool cml_boxtree_pairs(const struct cml_boxtree *a, const struct cml_boxtree *b, cml_boxtree_pair *pair,
                       void *context);

/* Calls `pair` once for each two triangles of one tree whose boxes touch. Returns true if `pair` ended the
 * search. */
bool cml_boxtree_own_pairs(const struct cml_boxtree *tree, cml_boxtree_pair *pair, void *context);

/* A mesh and its tree; all pointers are borrowed. part: the part number of each triangle, or NULL if all
 * triangles count. */
struct cml_column_mesh {
    const double (*vertex)[3];
    const uint32_t (*triangle)[3];
    const uint32_t *part;
    const struct cml_boxtree *tree;
};

struct cml_column {
    int crossings, above; /* triangles in the column, and triangles above the point */
    int winding;          /* among the triangles above: facing up (mesh.h) minus facing down */
    bool touches;         /* the point lies on a triangle */
    double nearest; /* vertical distance to the nearest triangle, cm, rounded; INFINITY if there is none */
};

/* Counts the triangles of a mesh above and below a point, in the vertical column through it. From the counts
 * follows on which side of a sheet, or in which part of a body, the point lies. Triangles of part `without`
 * are left out. Signs are exact (predicate.h); a column through an edge or vertex counts one triangle on each
 * side. */
struct cml_column cml_column_through(const struct cml_column_mesh *mesh, uint32_t without,
                                     const double point[3]);
#define CML_WITHOUT_NONE UINT32_MAX

/* A callback of cml_boxtree_touching. i: number of a triangle or box whose box touches the searched box. */
typedef void cml_boxtree_visit(void *context, uint32_t i);

/* Calls `visit` for each triangle or box whose box touches the box from `lower` to `upper`. */
void cml_boxtree_touching(const struct cml_boxtree *tree, const double lower[3], const double upper[3],
                          cml_boxtree_visit *visit, void *context);

/* A callback of cml_boxtree_closest. Returns the square of the distance of triangle i from p. */
typedef double cml_boxtree_square(const void *context, uint32_t i, const double p[3]);

/* Finds the triangle closest to p. Sets *i to the triangle's number and returns the square of its distance.
 * On entry *i is a guess of the number, or 0. */
double cml_boxtree_closest(const struct cml_boxtree *tree, const double p[3], cml_boxtree_square *square,
                           const void *context, uint32_t *i);

/* Returns true if box j is acceptable as the box around box i. */
typedef bool cml_boxtree_accept(void *context, uint32_t i, uint32_t j);

/* Returns the first box behind number i that contains box i and that `accept` accepts; n if there is none.
 * The tree's boxes must be sorted by size. `accept` is called with i and a few of the boxes that contain box
 * i, in any order. */
uint32_t cml_boxtree_first_around(const struct cml_boxtree *tree, uint32_t i, cml_boxtree_accept *accept,
                                  void *context);
