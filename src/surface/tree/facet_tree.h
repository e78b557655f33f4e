/* A wide tree over the facets of a mesh: which facet a ray leaves its side of the mesh through first, where
 * single precision makes that plain, and whether it does. 16 boxes to a node and 16 facets to a leaf, each an
 * entry of a vector loop: boxes and facets that a ray does not need cost less than the branches and misses of
 * a deeper tree [Dammertz, Hanika and Keller, Shallow bounding volume hierarchies for fast SIMD ray tracing
 * of incoherent rays, Computer Graphics Forum 27 (4), 2008].
 *
 * A plain answer is proven: whatever a ray passes within a margin is a candidate, and the margin is more than
 * rounding. No candidate is a plain miss. A hit is plain where it lies inside its facet, ahead of the ray's
 * origin and before its end, all by the margin, and no other candidate is as near. All else is in doubt, and
 * left to the caller. Facets through which the ray comes from behind ("entering", mesh_query.h) make doubt
 * only: one that is no further than the margin from the origin too, so nobody need ask for contact.
 *
 * Numbers are floats, cm, in the mesh's centred frame (centred_mesh.h). Knows no outer plane and no period.
 * The loops are compiled once for each level of the processor (facet_tree_level.c); answers are the same to
 * the last bit on all. SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/mesh.h"
#include "vector/group_masks.h"

#define CML_TREE_NO_FACET 0x80000000u
#define CML_TREE_DEPTH 32 /* nodes from the first one to a leaf, at most */

/* Up to 16 children, leaves before nodes. Nothing is inside the box of one that is missing. */
struct cml_tree_node {
    _Alignas(64) float box[6][CML_GROUP]; /* least x, y, z, most x, y, z */
    uint32_t child[CML_GROUP];            /* number of a leaf or node */
    int leaves;                           /* how many are leaves */
};

/* Up to 16 facets. Their barycentric weights are linear functions of the place; those of two corners are
 * kept, which lie on the longest side. */
struct cml_tree_leaf {
    _Alignas(64) float normal[3][CML_GROUP]; /* unit, up */
    float offset[CML_GROUP];                 /* product of the normal and any point of the plane */
    float slope[2][3][CML_GROUP];            /* of the weights, 1/cm */
    float weight[2][CML_GROUP];              /* at the frame's origin */
    float steepest[CML_GROUP]; /* 1 / the facet's least height, 1/cm; NaN, as all else, where that is less
                                * than the margin of the tree */
    uint32_t facet[CML_GROUP]; /* number in the mesh; CML_TREE_NO_FACET behind the last */
};

/* A path. All but `below` and `exclude` in floats. */
struct cml_tree_ray {
    float origin[3], direction[3]; /* direction: unit */
    float length;                  /* at most FLT_MAX */
    float margin;                  /* err_margin of rounding.h */
    int below;                     /* the path begins on the side that the normals point away from */
    int exclude;                   /* the facet that it begins on, which does not count; -1: none */
};

#define CML_TREE_DOUBTS 16

/* A plain answer has no doubts and is not blurred. */
struct cml_tree_answer {
    int facet;  /* the nearest that the path surely leaves its side through; -1: none */
    int doubts; /* facets that it may do so through before, or that its origin may lie on */
    int doubt[CML_TREE_DOUBTS];
    bool re_enters; /* the path surely comes back through a facet before it leaves through any */
    bool blurred;   /* there are more, or one is too thin for floats, or lies along the ray: ask all facets */
};

/* Immutable; queries may run in parallel. */
struct cml_facet_tree {
    struct cml_tree_node *node; /* [nodes]; the first is the root */
    struct cml_tree_leaf *leaf; /* [leaves]; those of a node side by side */
    uint32_t nodes, leaves;
};

/* plane: [num_triangles] of struct cml_centred_mesh. margin: the least that rays have, cm. The mesh has at
 * least one triangle. CML_E_INPUT when memory runs out; then there is nothing to clear. */
CML_NODISCARD cml_status cml_facet_tree_create(const struct cml_mesh *mesh, const double (*plane)[4],
                                               double margin, struct cml_facet_tree *tree,
                                               struct cml_error *err);
void cml_facet_tree_clear(struct cml_facet_tree *tree);

/* Bytes of all that a tree owns. */
double cml_facet_tree_bytes(const struct cml_facet_tree *tree);

/* The loop of one level. */
struct cml_tree_level {
    void (*ask)(const struct cml_facet_tree *tree, const struct cml_tree_ray *ray,
                struct cml_tree_answer *answer);
};

#define CML_TREE_LEVELS 3

/* Fills in the levels that this machine can run, the best one first, and returns their number. */
int cml_tree_levels(const struct cml_tree_level *levels[CML_TREE_LEVELS]);
