/* A binary tree of axis-parallel boxes (a bounding volume hierarchy). The tree stores no links, because its
 * shape follows from the number of leaves alone. SPDX-License-Identifier: MIT */
#include "geometry/box_tree.h"

#include "geometry/predicate.h"
#include "geometry/vec3.h"

#include <math.h>
#include <stdlib.h>

/* A box with the memory layout of double[2][3], the form in which callers give boxes. */
struct box {
    double lower[3], upper[3];
};

/* A tree over n leaves; a leaf is one triangle or one of the given boxes. Nodes are stored in preorder, and
 * each node splits its range of `index` in the middle. Numbers of the nodes of a tree of 5 leaves:
 *
 *           0
 *         /   \
 *        1     4
 *       / \   / \
 *      2   3 5   6
 *               / \
 *              7   8 */
struct cml_boxtree {
    size_t n;
    uint32_t *index;         /* [n] numbers of triangles or boxes in the order of the leaves */
    struct box *box;         /* [2 n - 1] box of each node */
    uint32_t *least;         /* [2 n - 1] smallest index below each node; only in a tree over boxes */
    const struct box *given; /* [n] the callers' boxes; only in a tree over boxes */
};

/* A node: its number, and the range of `index` below it. */
struct node {
    size_t at, first, count;
};

/* Returns the root of a tree: the node of all boxes. Nodes are not stored; a node follows from its place and
 * count. */
static struct node root_of(const struct cml_boxtree *tree)
{
    return (struct node){0, 0, tree->n};
}

/* Returns the left child of a node. In preorder the left child follows its parent. */
static struct node left_of(struct node node)
{
    return (struct node){node.at + 1, node.first, node.count / 2};
}

/* Returns the right child of a node. The left child's 2 half - 1 nodes come before it. */
static struct node right_of(struct node node)
{
    const size_t half = node.count / 2;
    return (struct node){node.at + 2 * half, node.first + half, node.count - half};
}

/* Data that only building needs. */
struct builder {
    struct cml_boxtree *tree;
    const double (*vertex)[3];
    const uint32_t (*triangle)[3];
    int num_keys;      /* number of sort keys of a leaf */
    const double *key; /* [n][num_keys] sort keys by which nodes are split: three times the centroid of a
                          triangle, or the six sides of a box */
};

/* Returns sort key k of leaf i. */
static double key_of(const struct builder *builder, uint32_t i, int k)
{
    return builder->key[(size_t)i * (size_t)builder->num_keys + (size_t)k];
}

/* Returns the closed box of triangle i from its exact coordinates, so that triangles that touch have boxes
 * that touch. */
static struct box box_of_triangle(const struct builder *builder, uint32_t i)
{
    const double *a = builder->vertex[builder->triangle[i][0]];
    const double *b = builder->vertex[builder->triangle[i][1]];
    const double *c = builder->vertex[builder->triangle[i][2]];
    struct box box;
    for (int k = 0; k < 3; k++) {
        box.lower[k] = cml_smaller(cml_smaller(a[k], b[k]), c[k]);
        box.upper[k] = cml_larger(cml_larger(a[k], b[k]), c[k]);
    }
    return box;
}

/* Returns the box around two boxes. */
static struct box box_of_both(const struct box *a, const struct box *b)
{
    struct box box;
    for (int k = 0; k < 3; k++) {
        box.lower[k] = cml_smaller(a->lower[k], b->lower[k]);
        box.upper[k] = cml_larger(a->upper[k], b->upper[k]);
    }
    return box;
}

/* Returns the key whose values differ most below the node: splitting by this key keeps boxes compact. Boxes
 * have both of their sides as keys, so that boxes around the same place are separated by size. */
static int widest_key(const struct builder *builder, struct node node)
{
    double widest = -1;
    int key = 0;
    for (int k = 0; k < builder->num_keys; k++) {
        double lower = INFINITY, upper = -INFINITY;
        for (size_t i = node.first; i < node.first + node.count; i++) {
            const double value = key_of(builder, builder->tree->index[i], k);
            lower = cml_smaller(lower, value);
            upper = cml_larger(upper, value);
        }
        if (upper - lower > widest) key = k;
        widest = cml_larger(widest, upper - lower);
    }
    return key;
}

static void swap_index(uint32_t *a, uint32_t *b)
{
    const uint32_t keep = *a;
    *a = *b;
    *b = keep;
}

/* Reorders `index` so that no key before `middle` is above any key from `middle` on: Hoare's selection
 * [Algorithm 65: Find, Comm. ACM 4 (1961) 321]. The pivot comes from the middle of the range, so that sorted
 * input is not slow. */
static void select_middle(const struct builder *builder, size_t first, size_t count, size_t middle, int key)
{
    uint32_t *index = builder->tree->index;
    ptrdiff_t low = (ptrdiff_t)first, high = (ptrdiff_t)(first + count) - 1;
    const ptrdiff_t target = (ptrdiff_t)middle;
    while (low < high) {
        const double pivot = key_of(builder, index[low + (high - low) / 2], key);
        ptrdiff_t i = low, j = high;
        while (i <= j) {
            while (key_of(builder, index[i], key) < pivot) i++;
            while (key_of(builder, index[j], key) > pivot) j--;
            if (i <= j) swap_index(&index[i++], &index[j--]);
        }
        if (target > j && target < i) return;
        if (target <= j)
            high = j;
        else
            low = i;
    }
}

/* Builds the tree below a node by median splits, so that the depth is log2 n for any triangles. A node's box
 * is made from its children's boxes. */
static void build(const struct builder *builder, struct node node)
{
    struct cml_boxtree *tree = builder->tree;
    if (node.count == 1) {
        const uint32_t i = tree->index[node.first];
        tree->box[node.at] = tree->given ? tree->given[i] : box_of_triangle(builder, i);
        if (tree->least) tree->least[node.at] = i;
        return;
    }
    const struct node left = left_of(node), right = right_of(node);
    select_middle(builder, node.first, node.count, right.first, widest_key(builder, node));
    build(builder, left);
    build(builder, right);
    tree->box[node.at] = box_of_both(&tree->box[left.at], &tree->box[right.at]);
    if (tree->least)
        tree->least[node.at] =
            tree->least[left.at] < tree->least[right.at] ? tree->least[left.at] : tree->least[right.at];
}

/* Allocates a tree of n leaves, with `least` if it is a tree over boxes. Returns CML_E_INPUT if memory runs
 * out. */
static cml_status allocate(size_t n, bool boxes, struct cml_boxtree **tree, struct cml_error *err)
{
    struct cml_boxtree *made = calloc(1, sizeof *made);
    *tree = NULL;
    if (made) {
        made->n = n;
        made->index = malloc(n * sizeof *made->index);
        made->box = malloc((2 * n - 1) * sizeof *made->box);
        if (boxes) made->least = malloc((2 * n - 1) * sizeof *made->least);
    }
    if (!made || !made->index || !made->box || (boxes && !made->least)) {
        cml_boxtree_free(made);
        return cml_fail_memory(err, (double)n * 100.0, "the overlap check");
    }
    for (size_t i = 0; i < n; i++) made->index[i] = (uint32_t)i;
    *tree = made;
    return CML_OK;
}

/* Triangles are sorted by the sum of their corners: three times the centroid, which gives the same order. */
cml_status cml_boxtree_create(const double (*vertex)[3], const uint32_t (*triangle)[3], size_t num_triangles,
                              struct cml_boxtree **tree, struct cml_error *err)
{
    CML_FREED double(*corner_sum)[3] = malloc(num_triangles * sizeof *corner_sum);
    if (!corner_sum)
        return cml_fail_memory(err, (double)(num_triangles * sizeof *corner_sum),
                               "the overlap check of a mesh");
    for (size_t i = 0; i < num_triangles; i++) {
        const uint32_t *t = triangle[i];
        for (int k = 0; k < 3; k++) corner_sum[i][k] = vertex[t[0]][k] + vertex[t[1]][k] + vertex[t[2]][k];
    }
    CML_TRY(allocate(num_triangles, false, tree, err));
    const struct builder builder = {*tree, vertex, triangle, 3, (const double *)corner_sum};
    build(&builder, root_of(*tree));
    return CML_OK;
}

/* Sorting by all six bounds keeps large boxes out of the cells of small ones. */
cml_status cml_boxtree_create_boxes(const double (*box)[2][3], size_t n, struct cml_boxtree **tree,
                                    struct cml_error *err)
{
    CML_TRY(allocate(n, true, tree, err));
    const struct builder builder = {.tree = *tree, .num_keys = 6, .key = (const double *)box};
    (*tree)->given = (const struct box *)box;
    build(&builder, root_of(*tree));
    return CML_OK;
}

void cml_boxtree_free(struct cml_boxtree *tree)
{
    if (!tree) return;
    free(tree->index);
    free(tree->box);
    free(tree->least);
    free(tree);
}

/* True if two boxes have a common point. */
static bool boxes_touch(const struct box *a, const struct box *b)
{
    for (int k = 0; k < 3; k++)
        if (a->lower[k] > b->upper[k] || b->lower[k] > a->upper[k]) return false;
    return true;
}

/* A search for pairs of leaves whose boxes touch. */
struct search {
    const struct cml_boxtree *a, *b;
    cml_boxtree_pair *pair;
    void *context;
};

/* Searches two trees for pairs of triangles whose boxes touch; true if the callback `pair` has ended the
 * search. It goes down in the tree with more triangles first. A pair of nodes whose boxes do not touch ends
 * the search below both nodes [S. Gottschalk, M. C. Lin and D. Manocha, OBBTree, SIGGRAPH 1996, 171, with
 * oriented boxes]. */
static bool search_two(const struct search *search, struct node a, struct node b)
{
    if (!boxes_touch(&search->a->box[a.at], &search->b->box[b.at])) return false;
    if (a.count == 1 && b.count == 1)
        return search->pair(search->context, search->a->index[a.first], search->b->index[b.first]);
    if (a.count >= b.count) return search_two(search, left_of(a), b) || search_two(search, right_of(a), b);
    return search_two(search, a, left_of(b)) || search_two(search, a, right_of(b));
}

/* Searches one tree for pairs of triangles whose boxes touch; true if the callback has ended the search.
 * Each pair is separated by exactly one node, which has one triangle on its left side and the other on its
 * right side. */
static bool search_own(const struct search *search, struct node node)
{
    if (node.count == 1) return false;
    const struct node left = left_of(node), right = right_of(node);
    return search_two(search, left, right) || search_own(search, left) || search_own(search, right);
}

bool cml_boxtree_pairs(const struct cml_boxtree *a, const struct cml_boxtree *b, cml_boxtree_pair *pair,
                       void *context)
{
    const struct search search = {a, b, pair, context};
    return search_two(&search, root_of(a), root_of(b));
}

/* Neighbours share vertices, so their boxes touch and all neighbours are among the pairs. */
bool cml_boxtree_own_pairs(const struct cml_boxtree *tree, cml_boxtree_pair *pair, void *context)
{
    const struct search search = {tree, tree, pair, context};
    return search_own(&search, root_of(tree));
}

/* A search for leaves whose boxes touch a given box. */
struct touching {
    const struct cml_boxtree *tree;
    struct box box;
    cml_boxtree_visit *visit;
    void *context;
};

/* Calls `visit` for the leaves below a node whose boxes touch the searched box. */
static void search_touching(const struct touching *touching, struct node node)
{
    if (!boxes_touch(&touching->tree->box[node.at], &touching->box)) return;
    if (node.count == 1) {
        touching->visit(touching->context, touching->tree->index[node.first]);
        return;
    }
    search_touching(touching, left_of(node));
    search_touching(touching, right_of(node));
}

void cml_boxtree_touching(const struct cml_boxtree *tree, const double lower[3], const double upper[3],
                          cml_boxtree_visit *visit, void *context)
{
    const struct touching touching = {
        tree, {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}}, visit, context};
    search_touching(&touching, root_of(tree));
}

struct through {
    const struct cml_column_mesh *mesh;
    uint32_t without;
    const double *point;
    struct cml_column column;
};

/* True if the edge from a to b, seen from above, passes the point on the point's right. The test is half open
 * in y and exact, so that a column through an edge or vertex counts exactly one of the triangles that meet
 * there. */
static bool passes_right(const double *a, const double *b, const double *point)
{
    if ((a[1] > point[1]) == (b[1] > point[1])) return false;
    return (a[1] < b[1] ? cml_orient2d(a, b, point) : cml_orient2d(b, a, point)) > 0;
}

/* Returns the depth of a triangle over a point, from barycentric coordinates, cm. Only a message uses the
 * depth, so rounding does not matter. */
static double depth_in_column(const double *const v[3], const double *point)
{
    double weight[3], sum = 0.0, z = 0.0;
    for (int k = 0; k < 3; k++) {
        const double *a = v[(k + 1) % 3], *b = v[(k + 2) % 3];
        weight[k] = fabs(cml_vec2_area(point, a, b));
        sum += weight[k];
    }
    for (int k = 0; k < 3; k++) z += weight[k] * v[k][2];
    return sum > 0.0 ? z / sum : v[0][2];
}

/* Counts triangle i if the vertical through the point meets it (a cml_boxtree_visit). The triangle is above
 * the point if the point is on the triangle's lower side. The exact 3D orientation tells the side; its sign
 * is corrected by the triangle's turn as seen from above. */
static void visit_through(void *context, uint32_t i)
{
    struct through *through = context;
    const struct cml_column_mesh *mesh = through->mesh;
    struct cml_column *column = &through->column;
    const double *v[3], *point = through->point;
    bool inside = false;
    if (mesh->part && mesh->part[i] == through->without) return;
    for (int k = 0; k < 3; k++) v[k] = mesh->vertex[mesh->triangle[i][k]];
    for (int k = 0; k < 3; k++) inside ^= passes_right(v[k], v[(k + 1) % 3], point);
    if (!inside) return;
    const int turn = cml_orient2d(v[0], v[1], v[2]);
    const int side = cml_orient3d(v[0], v[1], v[2], point) * turn;
    column->crossings++;
    column->above += side < 0;
    column->winding -= side < 0 ? turn : 0;
    column->touches |= side == 0;
    column->nearest = fmin(column->nearest, fabs(depth_in_column(v, point) - point[2]));
}

/* The search box has no size in x and y, and no end in z. */
struct cml_column cml_column_through(const struct cml_column_mesh *mesh, uint32_t without,
                                     const double point[3])
{
    struct through through = {mesh, without, point, {.nearest = INFINITY}};
    cml_boxtree_touching(mesh->tree, (double[]){point[0], point[1], -INFINITY},
                         (double[]){point[0], point[1], INFINITY}, visit_through, &through);
    return through.column;
}

/* A search for the triangle closest to a point. */
struct closest {
    const struct cml_boxtree *tree;
    const double *p;
    cml_boxtree_square *square;
    const void *context;
    double least;
    uint32_t best;
};

/* Returns the square of the distance from p to the box, 0 inside. */
static double box_square(const struct box *box, const double p[3])
{
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        const double beyond = cml_larger(cml_larger(box->lower[k] - p[k], p[k] - box->upper[k]), 0);
        sum += beyond * beyond;
    }
    return sum;
}

/* Searches below a node for the triangle closest to the point. The closer child comes first; a child further
 * away than the best triangle so far is skipped. */
static void search_closest(struct closest *closest, struct node node)
{
    if (node.count == 1) {
        const uint32_t i = closest->tree->index[node.first];
        const double square = closest->square(closest->context, i, closest->p);
        if (square < closest->least) closest->best = i;
        closest->least = cml_smaller(closest->least, square);
        return;
    }
    const struct node left = left_of(node), right = right_of(node);
    const double a = box_square(&closest->tree->box[left.at], closest->p),
                 b = box_square(&closest->tree->box[right.at], closest->p);
    const bool left_first = a < b;
    if (cml_smaller(a, b) < closest->least) search_closest(closest, left_first ? left : right);
    if (cml_larger(a, b) < closest->least) search_closest(closest, left_first ? right : left);
}

/* The guess lets the search skip most boxes. */
double cml_boxtree_closest(const struct cml_boxtree *tree, const double p[3], cml_boxtree_square *square,
                           const void *context, uint32_t *i)
{
    struct closest closest = {tree, p, square, context, square(context, *i, p), *i};
    search_closest(&closest, root_of(tree));
    *i = closest.best;
    return closest.least;
}

/* A search for the smallest accepted box that contains a given box. */
struct around {
    const struct cml_boxtree *tree;
    uint32_t inner, best;
    cml_boxtree_accept *accept;
    void *context;
};

/* True if the box `outer` contains the box `inner`; equal sides count. */
static bool holds(const struct box *outer, const struct box *inner)
{
    for (int k = 0; k < 3; k++)
        if (inner->lower[k] < outer->lower[k] || inner->upper[k] > outer->upper[k]) return false;
    return true;
}

/* Searches for the smallest accepted box around box `inner` by branch and bound [A. H. Land, A. G. Doig,
 * Econometrica 28 (1960) 497]. Boxes are sorted by size, so a smaller index means a smaller box. The child
 * with the smaller box comes first; a child without a box smaller than the best so far is skipped. */
static void search_around(struct around *around, struct node node)
{
    const struct cml_boxtree *tree = around->tree;
    if (tree->least[node.at] >= around->best) return;
    if (!holds(&tree->box[node.at], &tree->given[around->inner])) return;
    if (node.count == 1) {
        const uint32_t i = tree->index[node.first];
        if (i > around->inner && around->accept(around->context, around->inner, i)) around->best = i;
        return;
    }
    const struct node left = left_of(node), right = right_of(node);
    const bool left_first = tree->least[left.at] < tree->least[right.at];
    search_around(around, left_first ? left : right);
    search_around(around, left_first ? right : left);
}

uint32_t cml_boxtree_first_around(const struct cml_boxtree *tree, uint32_t i, cml_boxtree_accept *accept,
                                  void *context)
{
    struct around around = {tree, i, (uint32_t)tree->n, accept, context};
    search_around(&around, root_of(tree));
    return around.best;
}
