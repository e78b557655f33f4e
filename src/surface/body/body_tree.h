/* Trees of boxes over the bodies in each medium, so that a ray visits only the bodies near it, whatever their
 * number. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

/* A node; nodes are in preorder. A ray that meets the box continues with the next node; a ray that misses it
 * continues at `skip`. */
struct cml_body_tree_node {
    double lower[3], upper[3];
    int skip, body; /* index of the node behind the whole subtree; body number of a leaf, -1: inner node */
};

/* All trees of a scene, one behind the other. */
struct cml_body_tree {
    int count;
    struct cml_body_tree_node *node; /* [count] nodes of all trees */
    int *first;                      /* [num_media + 1] nodes first[m]..first[m + 1] - 1 belong to medium m */
};

/* Makes the trees. boxes: lower and upper corner of each body; host: the medium in which each body lies.
 * Returns CML_E_INPUT if memory runs out; cml_body_tree_clear then still frees the tree. */
CML_NODISCARD cml_status cml_body_tree_create(const double (*boxes)[2][3], const int *host, int num_bodies,
                                              int num_media, struct cml_body_tree *tree,
                                              struct cml_error *err);

/* Frees the trees' memory and zeroes the structure. */
void cml_body_tree_clear(struct cml_body_tree *tree);
