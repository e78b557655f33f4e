/* A tree of boxes over a mesh's triangles: which triangles may meet, and which stand in a vertical column.
 * Exists because the overlap check must stay near linear whatever the triangles' sizes and shapes (walls,
 * needles, local refinement). Knows no scene. SPDX-License-Identifier: MIT */
#ifndef CML_BOX_TREE_H
#define CML_BOX_TREE_H

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct cml_boxtree;

/* The arrays must outlive the tree. num_triangles >= 1. CML_E_INPUT only when memory runs out. */
CML_NODISCARD cml_status cml_boxtree_create(const double (*vertex)[3], const uint32_t (*triangle)[3],
                                            size_t num_triangles, struct cml_boxtree **tree,
                                            struct cml_error *err);

void cml_boxtree_free(struct cml_boxtree *tree);

/* Called with triangles whose boxes touch; true ends the search. */
typedef bool cml_boxtree_pair(void *context, uint32_t i, uint32_t j);

/* Every pair (i of a, j of b) whose boxes touch. True when `pair` ended the search. */
bool cml_boxtree_pairs(const struct cml_boxtree *a, const struct cml_boxtree *b, cml_boxtree_pair *pair,
                       void *context);

/* Every pair (i, j), i != j, within one tree, once. */
bool cml_boxtree_own_pairs(const struct cml_boxtree *tree, cml_boxtree_pair *pair, void *context);

/* Every triangle whose box holds the column over (x, y). */
typedef void cml_boxtree_visit(void *context, uint32_t i);
void cml_boxtree_column(const struct cml_boxtree *tree, double x, double y, cml_boxtree_visit *visit,
                        void *context);

#endif
