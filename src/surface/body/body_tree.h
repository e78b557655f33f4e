/* Trees of boxes over the bodies that lie in one medium: a ray visits only the bodies near it, whatever their
 * number. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

/* In preorder: who passes the box goes on with the next node, who does not, at `skip`. */
struct cml_body_tree_node {
    double lower[3], upper[3];
    int skip, body; /* body -1: an inner node */
};

/* All trees of a scene, one behind the other. */
struct cml_body_tree {
    int count;
    struct cml_body_tree_node *node; /* [count] */
    int *first; /* [num_media + 1]: nodes first[m]..first[m + 1] - 1 are those of medium m */
};

/* boxes: lower and upper corner of each body, host: the medium it lies in. CML_E_INPUT when memory runs out;
 * then the tree holds what cml_body_tree_clear frees. */
CML_NODISCARD cml_status cml_body_tree_create(const double (*boxes)[2][3], const int *host, int num_bodies,
                                              int num_media, struct cml_body_tree *tree,
                                              struct cml_error *err);
void cml_body_tree_clear(struct cml_body_tree *tree);
