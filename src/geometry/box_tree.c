/* A binary tree of axis-parallel boxes, as of a bounding volume hierarchy, without links: its shape follows
 * from the number of triangles alone. SPDX-License-Identifier: MIT */
#include "geometry/box_tree.h"

#include <math.h>
#include <stdlib.h>

struct box {
    double lower[3], upper[3];
};

/* Nodes in preorder, split at the middle of their range of `index`; a leaf is one triangle. So neither links
 * nor ranges are stored: see left_of and right_of. */
struct cml_boxtree {
    size_t n;
    uint32_t *index; /* [n] */
    struct box *box; /* [2 n - 1] */
};

/* A node and the range of `index` below it. */
struct node {
    size_t at, first, count;
};

static struct node root_of(const struct cml_boxtree *tree)
{
    return (struct node){0, 0, tree->n};
}

/* Preorder: the left child follows its parent, and its 2 count - 1 nodes come before the right one. */
static struct node left_of(struct node node)
{
    return (struct node){node.at + 1, node.first, node.count / 2};
}

static struct node right_of(struct node node)
{
    const size_t half = node.count / 2;
    return (struct node){node.at + 2 * half, node.first + half, node.count - half};
}

/* Not fmin and fmax: those are calls, because of NaN, which never gets here. */
static double lesser(double a, double b)
{
    return a < b ? a : b;
}

static double greater(double a, double b)
{
    return a > b ? a : b;
}

/* What only building needs. */
struct builder {
    struct cml_boxtree *tree;
    const double (*vertex)[3];
    const uint32_t (*triangle)[3];
    double (*centre)[3]; /* [n], three times the centroid */
};

/* Closed boxes of the exact coordinates: triangles that touch have boxes that touch. */
static struct box box_of_triangle(const struct builder *builder, uint32_t i)
{
    const double *a = builder->vertex[builder->triangle[i][0]];
    const double *b = builder->vertex[builder->triangle[i][1]];
    const double *c = builder->vertex[builder->triangle[i][2]];
    struct box box;
    for (int k = 0; k < 3; k++) {
        box.lower[k] = lesser(lesser(a[k], b[k]), c[k]);
        box.upper[k] = greater(greater(a[k], b[k]), c[k]);
    }
    return box;
}

static struct box box_of_both(const struct box *a, const struct box *b)
{
    struct box box;
    for (int k = 0; k < 3; k++) {
        box.lower[k] = lesser(a->lower[k], b->lower[k]);
        box.upper[k] = greater(a->upper[k], b->upper[k]);
    }
    return box;
}

/* Halving along the widest axis keeps boxes compact. */
static int widest_axis(const struct builder *builder, struct node node)
{
    double width[3];
    for (int k = 0; k < 3; k++) {
        double lower = INFINITY, upper = -INFINITY;
        for (size_t i = node.first; i < node.first + node.count; i++) {
            const double centre = builder->centre[builder->tree->index[i]][k];
            lower = lesser(lower, centre);
            upper = greater(upper, centre);
        }
        width[k] = upper - lower;
    }
    const int xy = width[1] > width[0];
    return width[2] > width[xy] ? 2 : xy;
}

static void swap_index(uint32_t *a, uint32_t *b)
{
    const uint32_t keep = *a;
    *a = *b;
    *b = keep;
}

/* Hoare's selection [Algorithm 65: Find, Comm. ACM 4 (1961) 321]: afterwards no key before `middle` is above
 * any key from it on. The pivot comes from the middle of the range, so that sorted input is no bad case. */
static void select_middle(const struct builder *builder, size_t first, size_t count, size_t middle, int axis)
{
    uint32_t *index = builder->tree->index;
    ptrdiff_t low = (ptrdiff_t)first, high = (ptrdiff_t)(first + count) - 1;
    const ptrdiff_t target = (ptrdiff_t)middle;
    while (low < high) {
        const double pivot = builder->centre[index[low + (high - low) / 2]][axis];
        ptrdiff_t i = low, j = high;
        while (i <= j) {
            while (builder->centre[index[i]][axis] < pivot) i++;
            while (builder->centre[index[j]][axis] > pivot) j--;
            if (i <= j) swap_index(&index[i++], &index[j--]);
        }
        if (target > j && target < i) return;
        if (target <= j)
            high = j;
        else
            low = i;
    }
}

/* Median split: the depth is log2 n whatever the triangles are. Boxes come from the children's. */
static void build(const struct builder *builder, struct node node)
{
    struct cml_boxtree *tree = builder->tree;
    if (node.count == 1) {
        tree->box[node.at] = box_of_triangle(builder, tree->index[node.first]);
        return;
    }
    const struct node left = left_of(node), right = right_of(node);
    select_middle(builder, node.first, node.count, right.first, widest_axis(builder, node));
    build(builder, left);
    build(builder, right);
    tree->box[node.at] = box_of_both(&tree->box[left.at], &tree->box[right.at]);
}

static void fill_centres(const struct builder *builder)
{
    for (size_t i = 0; i < builder->tree->n; i++) {
        const uint32_t *t = builder->triangle[i];
        for (int k = 0; k < 3; k++)
            builder->centre[i][k] =
                builder->vertex[t[0]][k] + builder->vertex[t[1]][k] + builder->vertex[t[2]][k];
        builder->tree->index[i] = (uint32_t)i;
    }
}

cml_status cml_boxtree_create(const double (*vertex)[3], const uint32_t (*triangle)[3], size_t num_triangles,
                              struct cml_boxtree **tree, struct cml_error *err)
{
    const size_t n = num_triangles;
    struct cml_boxtree *made = calloc(1, sizeof *made);
    struct builder builder = {made, vertex, triangle, malloc(n * sizeof *builder.centre)};
    if (made) {
        made->n = n;
        made->index = malloc(n * sizeof *made->index);
        made->box = malloc((2 * n - 1) * sizeof *made->box);
    }
    if (!made || !builder.centre || !made->index || !made->box) {
        free(builder.centre);
        cml_boxtree_free(made);
        return cml_fail_memory(err, (double)n * 124.0, "the overlap check of a mesh");
    }
    fill_centres(&builder);
    build(&builder, root_of(made));
    free(builder.centre);
    *tree = made;
    return CML_OK;
}

void cml_boxtree_free(struct cml_boxtree *tree)
{
    if (!tree) return;
    free(tree->index);
    free(tree->box);
    free(tree);
}

static bool boxes_touch(const struct box *a, const struct box *b)
{
    for (int k = 0; k < 3; k++)
        if (a->lower[k] > b->upper[k] || b->lower[k] > a->upper[k]) return false;
    return true;
}

/* One search for pairs. */
struct search {
    const struct cml_boxtree *a, *b;
    cml_boxtree_pair *pair;
    void *context;
};

/* Both trees are gone down together, the one with more triangles first; pairs of nodes whose boxes are apart
 * end the search below them [S. Gottschalk, M. C. Lin and D. Manocha, OBBTree, SIGGRAPH 1996, 171, with
 * oriented boxes]. */
static bool search_two(const struct search *search, struct node a, struct node b)
{
    if (!boxes_touch(&search->a->box[a.at], &search->b->box[b.at])) return false;
    if (a.count == 1 && b.count == 1)
        return search->pair(search->context, search->a->index[a.first], search->b->index[b.first]);
    if (a.count >= b.count) return search_two(search, left_of(a), b) || search_two(search, right_of(a), b);
    return search_two(search, a, left_of(b)) || search_two(search, a, right_of(b));
}

/* Every pair of triangles of one tree is parted by exactly one node: where one is on its left, the other on
 * its right. */
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

/* Shared vertices make neighbours' boxes touch, so that all neighbours are among the pairs. */
bool cml_boxtree_own_pairs(const struct cml_boxtree *tree, cml_boxtree_pair *pair, void *context)
{
    const struct search search = {tree, tree, pair, context};
    return search_own(&search, root_of(tree));
}

/* One search for a column. */
struct column {
    const struct cml_boxtree *tree;
    double at[2];
    cml_boxtree_visit *visit;
    void *context;
};

/* A column has no upper or lower end: z does not count. */
static void search_column(const struct column *column, struct node node)
{
    const struct box *box = &column->tree->box[node.at];
    for (int k = 0; k < 2; k++)
        if (column->at[k] < box->lower[k] || column->at[k] > box->upper[k]) return;
    if (node.count == 1) {
        column->visit(column->context, column->tree->index[node.first]);
        return;
    }
    search_column(column, left_of(node));
    search_column(column, right_of(node));
}

void cml_boxtree_column(const struct cml_boxtree *tree, double x, double y, cml_boxtree_visit *visit,
                        void *context)
{
    const struct column column = {tree, {x, y}, visit, context};
    search_column(&column, root_of(tree));
}
