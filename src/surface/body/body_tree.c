/* Builds the trees of boxes over the bodies of each medium. SPDX-License-Identifier: MIT */
#include "surface/body/body_tree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct builder {
    const double (*boxes)[2][3];
    const int *host;
    int *index; /* body numbers, sorted by host */
    struct cml_body_tree *tree;
};

/* A body's sort key: twice the middle of its box along an axis. Equal keys are ordered by body number, so
 * that the tree does not depend on the C library's sort. */
struct key {
    double at;
    int body;
};

/* Orders two keys by position, then by body number, for qsort. */
static int compare_keys(const void *left, const void *right)
{
    const struct key *a = left, *b = right;
    if (a->at != b->at) return a->at < b->at ? -1 : 1;
    return a->body - b->body;
}

/* Sets the node's box to the box around the boxes of these bodies. */
static void box_of(const struct builder *b, const int *bodies, int count, struct cml_body_tree_node *node)
{
    for (int k = 0; k < 3; k++) {
        node->lower[k] = INFINITY;
        node->upper[k] = -INFINITY;
        for (int i = 0; i < count; i++) {
            node->lower[k] = fmin(node->lower[k], b->boxes[bodies[i]][0][k]);
            node->upper[k] = fmax(node->upper[k], b->boxes[bodies[i]][1][k]);
        }
    }
}

/* Sorts bodies by the middles of their boxes along the axis in which the node is widest. Returns CML_E_INPUT
 * if memory runs out. */
static cml_status sort_bodies(const struct builder *b, const struct cml_body_tree_node *node, int *bodies,
                              int count, struct cml_error *err)
{
    CML_FREED struct key *keys = malloc((size_t)count * sizeof *keys);
    int axis = 0;
    if (!keys) return cml_fail_memory(err, (double)((size_t)count * sizeof *keys), "the tree of bodies");
    for (int k = 1; k < 3; k++)
        if (node->upper[k] - node->lower[k] > node->upper[axis] - node->lower[axis]) axis = k;
    for (int i = 0; i < count; i++)
        keys[i] = (struct key){b->boxes[bodies[i]][0][axis] + b->boxes[bodies[i]][1][axis], bodies[i]};
    qsort(keys, (size_t)count, sizeof *keys, compare_keys);
    for (int i = 0; i < count; i++) bodies[i] = keys[i].body;
    return CML_OK;
}

/* Adds the node of these bodies and all nodes below it. Bodies are split at the median, so that the depth is
 * log2 of their number. Nodes are in preorder: the first half stands right behind the node, and a ray that
 * misses the node's box skips both halves. */
static cml_status build(const struct builder *b, int *bodies, int count, struct cml_error *err)
{
    struct cml_body_tree *tree = b->tree;
    const int here = tree->count++;
    struct cml_body_tree_node *node = &tree->node[here];
    box_of(b, bodies, count, node);
    node->body = count == 1 ? bodies[0] : -1;
    if (count > 1) {
        CML_TRY(sort_bodies(b, node, bodies, count, err));
        CML_TRY(build(b, bodies, count / 2, err));
        CML_TRY(build(b, bodies + count / 2, count - count / 2, err));
    }
    node->skip = tree->count;
    return CML_OK;
}

/* Sorts bodies by host (counting sort). Bodies of one host stand side by side in `index`, from first[host]
 * on. */
static void sort_by_host(const struct builder *b, int num_bodies, int num_media, int *first)
{
    memset(first, 0, ((size_t)num_media + 1) * sizeof *first);
    for (int k = 0; k < num_bodies; k++) first[b->host[k] + 1]++;
    for (int m = 0; m < num_media; m++) first[m + 1] += first[m];
    for (int k = 0; k < num_bodies; k++) b->index[first[b->host[k]]++] = k;
    for (int m = num_media; m > 0; m--) first[m] = first[m - 1];
    first[0] = 0;
}

/* Builds the trees of all media. Before, tree->first[m] is where medium m's bodies begin in b->index;
 * afterwards, it is the number of the first node of medium m's tree. */
static cml_status build_all(const struct builder *b, int num_bodies, int num_media, struct cml_error *err)
{
    struct cml_body_tree *tree = b->tree;
    sort_by_host(b, num_bodies, num_media, tree->first);
    for (int m = 0; m < num_media; m++) {
        const int begin = tree->first[m], count = tree->first[m + 1] - begin;
        tree->first[m] = tree->count;
        if (count > 0) CML_TRY(build(b, b->index + begin, count, err));
    }
    tree->first[num_media] = tree->count;
    return CML_OK;
}

cml_status cml_body_tree_create(const double (*boxes)[2][3], const int *host, int num_bodies, int num_media,
                                struct cml_body_tree *tree, struct cml_error *err)
{
    const size_t n = (size_t)num_bodies, media = (size_t)num_media;
    CML_FREED int *index = malloc((n + 1) * sizeof *index);
    const struct builder b = {boxes, host, index, tree};
    tree->count = 0;
    tree->node = malloc((2 * n + 1) * sizeof *tree->node);
    tree->first = malloc((media + 1) * sizeof *tree->first);
    if (!index || !tree->node || !tree->first)
        return cml_fail_memory(err, (double)(2 * n * sizeof *tree->node), "the tree of bodies");
    return build_all(&b, num_bodies, num_media, err);
}

void cml_body_tree_clear(struct cml_body_tree *tree)
{
    free(tree->node);
    free(tree->first);
    *tree = (struct cml_body_tree){0};
}
