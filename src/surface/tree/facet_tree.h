/* A wide tree over the facets of a mesh. It finds the facet through which a ray first leaves its side of the
 * mesh, if single precision can tell with certainty.
 *
 * A node has 16 boxes and a leaf 16 facets, one vector loop each: testing boxes and facets that a ray does
 * not need costs less than the branches and cache misses of a deeper tree [Dammertz, Hanika and Keller,
 * Shallow bounding volume hierarchies for fast SIMD ray tracing of incoherent rays, Computer Graphics Forum
 * 27 (4), 2008].
 *
 * Certain answers are proven: each facet that the ray passes within a margin is a candidate, and the margin
 * is larger than rounding. Without a candidate the ray surely misses. A hit is certain if it lies inside its
 * facet, ahead of the ray's origin and before its end, all by the margin, and no other candidate is as near.
 * In all other cases the answer lists facets in doubt for the caller. Facets through which the ray comes from
 * behind ("entering", mesh_query.h) can only be in doubt. A facet no further than the margin from the ray's
 * origin is in doubt, too, so that callers need no separate test of contact.
 *
 * Numbers are floats, cm, in the mesh's centred frame (centred_mesh.h). The tree knows no outer plane and no
 * period. The loops are compiled once for each level of the processor (facet_tree_level.c); all levels give
 * the same answers to the last bit.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "geometry/mesh.h"
#include "vector/group_masks.h"

#define CML_TREE_NO_FACET 0x80000000u
#define CML_TREE_DEPTH 32 /* most nodes on the way from the root to a leaf */

/* A node of up to 16 children, leaves before nodes. The box of a missing child is empty. */
struct cml_tree_node {
    _Alignas(64) float box[6][CML_GROUP]; /* smallest x, y, z, then largest x, y, z of each child */
    uint32_t child[CML_GROUP];            /* number of each leaf or node */
    int leaves;                           /* number of children that are leaves */
};

/* A leaf of up to 16 facets. Barycentric weights are linear functions of the place. The weights of two
 * corners are stored, the ends of the facet's longest side. */
struct cml_tree_leaf {
    _Alignas(64) float normal[3][CML_GROUP]; /* unit normal of each facet, up */
    float offset[CML_GROUP];                 /* scalar product of the normal and any point of the plane */
    float slope[2][3][CML_GROUP];            /* derivatives of the weights, 1/cm */
    float weight[2][CML_GROUP];              /* weights at the frame's origin */
    float steepest[CML_GROUP]; /* 1 / the facet's least height, 1/cm; NaN, as all other members, if that
                                  height is less than the margin of the tree */
    uint32_t facet[CML_GROUP]; /* number in the mesh; CML_TREE_NO_FACET behind the last facet */
};

/* A path, in floats except for `below` and `exclude`. */
struct cml_tree_ray {
    float origin[3], direction[3]; /* position and unit direction of the ray */
    float length;                  /* length of the path, at most FLT_MAX */
    float margin;                  /* margin around the ray: err_margin of rounding.h */
    int below;                     /* true if the path begins behind the facets, opposite to their normals */
    int exclude;                   /* facet on which the path begins, which does not count; -1: none */
};

#define CML_TREE_DOUBTS 16

/* The answer of a search. It is certain if it has no doubts and is not blurred. */
struct cml_tree_answer {
    int facet;  /* nearest facet through which the path surely leaves its side; -1: none */
    int doubts; /* number of facets through which the path may leave before, or on which its origin may lie */
    int doubt[CML_TREE_DOUBTS];
    bool re_enters; /* the path surely comes back through a facet before it leaves through one */
    bool blurred;   /* true if all facets must be tested: there are more facets in doubt than CML_TREE_DOUBTS,
                       or one is too thin for floats or lies along the ray */
};

/* A tree. Immutable, so queries may run in parallel. */
struct cml_facet_tree {
    struct cml_tree_node *node; /* [nodes]; the first node is the root */
    struct cml_tree_leaf *leaf; /* [leaves]; the leaves of a node stand side by side */
    uint32_t nodes, leaves;
};

/* Makes the tree of a mesh of at least one triangle. plane: [num_triangles] as in struct cml_centred_mesh.
 * margin: smallest margin of a ray, cm. Returns CML_E_INPUT if memory runs out; there is nothing to clear
 * then. */
CML_NODISCARD cml_status cml_facet_tree_create(const struct cml_mesh *mesh, const double (*plane)[4],
                                               double margin, struct cml_facet_tree *tree,
                                               struct cml_error *err);

/* Frees the tree's memory and zeroes the structure. */
void cml_facet_tree_clear(struct cml_facet_tree *tree);

/* Returns the bytes of memory that a tree owns. */
double cml_facet_tree_bytes(const struct cml_facet_tree *tree);

/* The search, compiled for one level of the processor. */
struct cml_tree_level {
    void (*ask)(const struct cml_facet_tree *tree, const struct cml_tree_ray *ray,
                struct cml_tree_answer *answer);
};

#define CML_TREE_LEVELS 3

/* Lists the levels that this machine can run, the best one first. Returns their number. */
int cml_tree_levels(const struct cml_tree_level *levels[CML_TREE_LEVELS]);
