/* Searches a tree of facets for a ray (facet_tree.h). Compiled once for each level of the processor.
 * SPDX-License-Identifier: MIT */
#include "surface/tree/facet_tree.h"
#include "vector/processor.h"

#include <math.h>

/* The ray, prepared for the test of boxes: for each axis, the side through which it enters and the side
 * through which it leaves. Boxes are enlarged by twice the margin: once because the margin demands it, once
 * for the rounding of the test. */
struct slabs {
    int enter[3], leave[3];
    float enter_from[3], leave_from[3], inverse[3];
};

struct search {
    const struct cml_facet_tree *tree;
    const struct cml_tree_ray *ray;
    struct cml_tree_answer *answer;
    struct slabs slabs;
    float to;     /* nothing beyond this distance matters: the path's length, or the distance of a sure
                     crossing */
    float t, err; /* t: distance of the nearest sure crossing; err: rounding error of t; `answer` names the
                     crossing's facet */
    float least[CML_TREE_DOUBTS]; /* smallest possible distance of each facet in doubt */
    float entering;               /* distance of the nearest sure crossing that enters */
};

/* The rest of a node that is still to be searched. */
struct pending {
    const struct cml_tree_node *node;
    uint32_t inner;                      /* mask of children that are nodes */
    _Alignas(64) float enter[CML_GROUP]; /* distance at which the ray enters each child */
};

/* The results of testing the facets of a leaf. */
struct tested {
    _Alignas(64) float along[CML_GROUP], height[CML_GROUP]; /* sine of the angle to the path; distance of
                                                               the plane along its normal */
    float t[CML_GROUP], err[CML_GROUP];
    int inside[CML_GROUP], exits[CML_GROUP], passed[CML_GROUP];
};

/* Prepares a ray for the test of boxes: the inverse direction, which side of a box it enters on each axis,
 * and its origin moved by the margin. */
static void find_slabs(const struct cml_tree_ray *ray, struct slabs *s)
{
    for (int k = 0; k < 3; k++) {
        s->inverse[k] = 1 / ray->direction[k];
        const int backwards = s->inverse[k] < 0; /* 1 / -0 counts as backwards, too */
        const float more = 2 * (backwards ? -ray->margin : ray->margin);
        s->enter[k] = k + 3 * backwards;
        s->leave[k] = k + 3 - 3 * backwards;
        s->enter_from[k] = ray->origin[k] + more;
        s->leave_from[k] = ray->origin[k] - more;
    }
}

/* Tests the boxes of a node's children. Returns a mask of the children that the ray enters. A ray in the
 * plane of a box's side gives NaN from 0 / 0; the comparisons then count it as inside. */
static inline uint32_t enter_node(const struct search *s, const struct cml_tree_node *node, struct pending *p)
{
    const struct slabs *a = &s->slabs;
    const float *x0 = node->box[a->enter[0]], *y0 = node->box[a->enter[1]], *z0 = node->box[a->enter[2]],
                *x1 = node->box[a->leave[0]], *y1 = node->box[a->leave[1]], *z1 = node->box[a->leave[2]];
    const float fx = a->enter_from[0], fy = a->enter_from[1], fz = a->enter_from[2], lx = a->leave_from[0],
                ly = a->leave_from[1], lz = a->leave_from[2], ix = a->inverse[0], iy = a->inverse[1],
                iz = a->inverse[2], to = s->to;
    _Alignas(64) float room[CML_GROUP];
#pragma omp simd
    for (int i = 0; i < CML_GROUP; i++) {
        const float ax = (x0[i] - fx) * ix, ay = (y0[i] - fy) * iy, az = (z0[i] - fz) * iz;
        const float bx = (x1[i] - lx) * ix, by = (y1[i] - ly) * iy, bz = (z1[i] - lz) * iz;
        float first = ax > 0 ? ax : 0, last = bx < to ? bx : to;
        first = ay > first ? ay : first;
        last = by < last ? by : last;
        first = az > first ? az : first;
        last = bz < last ? bz : last;
        p->enter[i] = first;
        room[i] = last - first;
    }
    return ~cml_group_negative(room) & CML_GROUP_MASK;
}

/* Returns the mask of a leaf's facets whose plane the path meets; mostly there are none. The test compares
 * the distances of the path's two ends from the plane, because a ray along the plane has no crossing
 * distance t. */
static inline uint32_t test_planes(const struct search *s, const struct cml_tree_leaf *leaf,
                                   struct tested *tested)
{
    const struct cml_tree_ray *ray = s->ray;
    const float x = ray->origin[0], y = ray->origin[1], z = ray->origin[2], u = ray->direction[0],
                v = ray->direction[1], w = ray->direction[2], margin = ray->margin, to = s->to;
#pragma omp simd
    for (int i = 0; i < CML_GROUP; i++) {
        const float nx = leaf->normal[0][i], ny = leaf->normal[1][i], nz = leaf->normal[2][i];
        const float along = nx * u + ny * v + nz * w, height = leaf->offset[i] - (nx * x + ny * y + nz * z);
        const float ahead = along < 0 ? -height : height;
        tested->along[i] = along;
        tested->height[i] = height;
        tested->passed[i] =
            (ahead < -margin) | (ahead > fabsf(along) * to + margin) | (leaf->facet[i] == CML_TREE_NO_FACET);
    }
    return cml_group_equal(tested->passed, 0);
}

/* Tests the facets of a leaf in one vector loop and returns a mask of those that the ray may cross.
 * `inside`: surely crossed; `exits`: crossed towards the packet's far side. A NaN makes a candidate that is
 * not a sure hit. */
static inline uint32_t test_leaf(const struct search *s, const struct cml_tree_leaf *leaf,
                                 struct tested *tested)
{
    const struct cml_tree_ray *ray = s->ray;
    const float x = ray->origin[0], y = ray->origin[1], z = ray->origin[2], u = ray->direction[0],
                v = ray->direction[1], w = ray->direction[2], margin = ray->margin, length = ray->length,
                side = ray->below ? 1.f : -1.f;
    if (!test_planes(s, leaf, tested)) return 0;
#pragma omp simd
    for (int i = 0; i < CML_GROUP; i++) {
        const float along = tested->along[i], height = tested->height[i];
        const float sine = fabsf(along), ahead = along < 0 ? -height : height;
        const float inverse = 1 / along, t = height * inverse, err = margin * fabsf(inverse);
        const float px = x + t * u, py = y + t * v, pz = z + t * w;
        const float a = leaf->slope[0][0][i] * px + leaf->slope[0][1][i] * py + leaf->slope[0][2][i] * pz +
                        leaf->weight[0][i];
        const float b = leaf->slope[1][0][i] * px + leaf->slope[1][1][i] * py + leaf->slope[1][2][i] * pz +
                        leaf->weight[1][i];
        const float c = 1 - a - b, aside = (margin + err) * leaf->steepest[i];
        tested->t[i] = t;
        tested->err[i] = err;
        tested->exits[i] = side * along > 0;
        tested->inside[i] =
            (a > aside) & (b > aside) & (c > aside) & (ahead > margin) & (ahead < sine * length - margin);
        tested->passed[i] |= (a < -aside) | (b < -aside) | (c < -aside);
    }
    return cml_group_equal(tested->passed, 0);
}

/* Adds a facet to the list of facets in doubt, which must be tested in double. least: its smallest possible
 * distance. If the list is full, the answer becomes blurred: all facets must be tested. */
static void add_doubt(struct search *s, int facet, float least)
{
    struct cml_tree_answer *answer = s->answer;
    if (answer->doubts == CML_TREE_DOUBTS) {
        answer->blurred = true;
        return;
    }
    s->least[answer->doubts] = least;
    answer->doubt[answer->doubts++] = facet;
}

/* Compares a sure crossing with the nearest one so far. The nearer of the two remains the nearest; the other
 * one becomes a doubt. */
static void add_sure(struct search *s, int facet, float t, float err)
{
    if (!(t < s->t)) {
        add_doubt(s, facet, t - err);
        return;
    }
    if (s->answer->facet >= 0) add_doubt(s, s->answer->facet, s->t - s->err);
    s->t = t;
    s->err = err;
    s->answer->facet = facet;
    if (t + err < s->to) s->to = t + err;
}

/* Tests all facets of a leaf at once, and adds those that the ray surely crosses, and those where rounding
 * leaves a doubt. `entering` is the nearest facet crossed from outside in. */
static inline void search_leaf(struct search *s, uint32_t number)
{
    const struct cml_tree_leaf *leaf = &s->tree->leaf[number];
    struct tested tested;
    for (uint32_t mask = test_leaf(s, leaf, &tested); mask; mask &= mask - 1) {
        const int i = __builtin_ctz(mask), facet = (int)leaf->facet[i];
        const float t = tested.t[i], err = tested.err[i];
        if (facet == s->ray->exclude) continue;
        if (!(err < INFINITY))
            s->answer->blurred = true;
        else if (tested.inside[i] && tested.exits[i])
            add_sure(s, facet, t, err);
        else
            add_doubt(s, facet, t - err);
        if (tested.inside[i] && !tested.exits[i] && t < s->entering) s->entering = t;
    }
}

/* Searches the leaves of a node that the ray enters, and leaves the child nodes that it enters in *p for
 * later. */
static inline void search_node(struct search *s, const struct cml_tree_node *node, struct pending *p)
{
    const uint32_t entered = enter_node(s, node, p);
    p->node = node;
    p->inner = entered >> node->leaves << node->leaves;
    for (uint32_t mask = entered ^ p->inner; mask; mask &= mask - 1) {
        const int i = __builtin_ctz(mask);
        if (p->enter[i] <= s->to) search_leaf(s, node->child[i]);
    }
}

/* Searches the tree depth first. Stops early if the answer is blurred. */
static void search_tree(struct search *s)
{
    struct pending stack[CML_TREE_DEPTH], *p = stack;
    find_slabs(s->ray, &s->slabs);
    search_node(s, s->tree->node, p);
    while (!s->answer->blurred) {
        if (p->inner) {
            const int i = __builtin_ctz(p->inner);
            p->inner &= p->inner - 1;
            if (!(p->enter[i] <= s->to)) continue;
            search_node(s, &s->tree->node[p->node->child[i]], p + 1);
            p++;
        } else if (p-- == stack) {
            return;
        }
    }
}

/* Prepares a search of the tree for one ray: no crossing yet, and an answer without facets. */
static void begin(const struct cml_facet_tree *tree, const struct cml_tree_ray *ray, struct search *s,
                  struct cml_tree_answer *answer)
{
    s->tree = tree;
    s->ray = ray;
    s->answer = answer;
    s->to = ray->length;
    s->t = s->entering = INFINITY;
    s->err = 0;
    answer->facet = -1;
    answer->doubts = 0;
    answer->blurred = false;
}

/* Ends a search: drops doubts that lie behind the nearest sure crossing. */
static void end(struct search *s)
{
    struct cml_tree_answer *answer = s->answer;
    int doubts = 0;
    for (int i = 0; i < answer->doubts; i++)
        if (!(s->least[i] > s->t + s->err)) answer->doubt[doubts++] = answer->doubt[i];
    answer->doubts = doubts;
    answer->re_enters = s->entering < s->t;
}

/* Finds the first facet that a ray meets. The answer names facets in doubt where single precision cannot
 * decide. */
static void ask(const struct cml_facet_tree *tree, const struct cml_tree_ray *ray,
                struct cml_tree_answer *answer)
{
    struct search s;
    begin(tree, ray, &s, answer);
    search_tree(&s);
    end(&s);
}

/* declared in facet_tree.c only, which chooses one */
extern const struct cml_tree_level CML_LEVELED(cml_tree_, CML_LEVEL);
const struct cml_tree_level CML_LEVELED(cml_tree_, CML_LEVEL) = {ask};
