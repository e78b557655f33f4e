/* Builds the wide tree over the facets of a mesh. SPDX-License-Identifier: MIT */
#include "surface/tree/facet_tree.h"

#include "geometry/vec3.h"
#include "surface/tree/facet_split.h"
#include "vector/processor.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Depth in the tree from which nodes are divided by number of facets instead of by geometry. The last 12
 * levels divide by number, so the depth of the tree has an end. */
enum { DEEP = CML_TREE_DEPTH - 12 };

extern const struct cml_tree_level cml_tree_base;
#ifdef CML_X86_LEVELS
extern const struct cml_tree_level cml_tree_v3, cml_tree_v4;
#endif

int cml_tree_levels(const struct cml_tree_level *levels[CML_TREE_LEVELS])
{
    int count = 0;
#ifdef CML_X86_LEVELS
    if (cml_processor_level() >= 4) levels[count++] = &cml_tree_v4;
    if (cml_processor_level() >= 3) levels[count++] = &cml_tree_v3;
#endif
    levels[count++] = &cml_tree_base;
    return count;
}

/* An array that grows. */
struct list {
    void *at;
    uint32_t count, room;
    size_t size; /* bytes of an entry; a multiple of 64 */
};

struct builder {
    const struct cml_mesh *mesh;
    const double (*plane)[4];
    double margin;
    struct cml_facet_box *box; /* [num_triangles] boxes of the facets */
    struct list nodes, leaves;
};

/* The facets of a child: box[first .. first + count - 1]. */
struct group {
    struct cml_facet_box box;
    size_t first, count;
};

/* Computes the barycentric weight of corner `at` as a linear function of the place, from the side opposite to
 * the corner, and stores it as weight `to` of entry i. twice: twice the facet's area. */
static void fill_weight(const double corner[3][3], const double normal[3], double twice, int at, int to,
                        int i, struct cml_tree_leaf *leaf)
{
    const double *from = corner[(at + 1) % 3];
    double side[3], slope[3];
    cml_vec3_subtract(corner[(at + 2) % 3], from, side);
    cml_vec3_cross(normal, side, slope);
    for (int k = 0; k < 3; k++) leaf->slope[to][k][i] = (float)(slope[k] / twice);
    leaf->weight[to][i] = (float)(-cml_vec3_dot(slope, from) / twice);
}

/* Returns the corner opposite to the longest side. Sets *longest to that side's length. */
static int find_longest(const double corner[3][3], double *longest)
{
    int opposite = 0;
    *longest = 0;
    for (int k = 0; k < 3; k++) {
        double side[3];
        cml_vec3_subtract(corner[(k + 2) % 3], corner[(k + 1) % 3], side);
        const double length = cml_vec3_length(side);
        if (length > *longest) opposite = k;
        *longest = fmax(*longest, length);
    }
    return opposite;
}

/* Fills entry i of a leaf with a facet. A facet whose height over its longest side is at most the margin gets
 * NaN. Every test of such a facet leaves it in doubt, so it is tested again in double. */
static void fill_facet(const struct builder *b, uint32_t facet, int i, struct cml_tree_leaf *leaf)
{
    const double *plane = b->plane[facet];
    double corner[3][3], area[3], longest;
    for (int k = 0; k < 3; k++) cml_vec3_copy(b->mesh->vertex[b->mesh->triangle[facet][k]], corner[k]);
    const int opposite = find_longest(corner, &longest);
    cml_vec3_area(corner[0], corner[1], corner[2], area);
    const double size = cml_vec3_length(area), twice = size > b->margin * longest ? size : (double)NAN;
    for (int k = 0; k < 3; k++) leaf->normal[k][i] = (float)(plane[k] * (twice / twice));
    leaf->offset[i] = (float)(plane[3] * (twice / twice));
    for (int k = 0; k < 2; k++) fill_weight(corner, plane, twice, (opposite + 1 + k) % 3, k, i, leaf);
    leaf->steepest[i] = (float)(longest / twice);
    leaf->facet[i] = facet;
}

/* Moves a list of nodes or leaves into new memory for `room` entries, aligned to 64 bytes for vector
 * loops. */
static cml_status move(struct list *list, uint32_t room, struct cml_error *err)
{
    void *moved = aligned_alloc(64, room * list->size);
    if (!moved) return cml_fail_memory(err, (double)room * (double)list->size, "a tree of facets");
    if (list->count) memcpy(moved, list->at, list->count * list->size);
    free(list->at);
    list->at = moved;
    list->room = room;
    return CML_OK;
}

/* Adds an entry of zeros to a list. Sets *number to its number. */
static cml_status add(struct list *list, uint32_t *number, struct cml_error *err)
{
    if (list->count == list->room) CML_TRY(move(list, 2 * list->room + 4, err));
    *number = list->count++;
    memset((char *)list->at + *number * list->size, 0, list->size);
    return CML_OK;
}

/* Adds a leaf with the facets of a group. Sets *number to the leaf's number. */
static cml_status add_leaf(struct builder *b, const struct group *group, uint32_t *number,
                           struct cml_error *err)
{
    CML_TRY(add(&b->leaves, number, err));
    struct cml_tree_leaf *leaf = (struct cml_tree_leaf *)b->leaves.at + *number;
    for (int i = 0; i < CML_GROUP; i++) leaf->facet[i] = CML_TREE_NO_FACET;
    for (size_t i = 0; i < group->count; i++) fill_facet(b, b->box[group->first + i].facet, (int)i, leaf);
    return CML_OK;
}

/* Sets the group's box to the box around its facets. */
static void find_box(const struct builder *b, struct group *group)
{
    group->box = cml_facet_box_none();
    for (size_t i = 0; i < group->count; i++) cml_facet_box_widen(&group->box, &b->box[group->first + i]);
}

/* Returns the number of the child to divide next: the largest that has more facets than a leaf holds; -1 if
 * there is none. The measure is the area of the child's box, and below depth DEEP its number of facets. */
static int choose(const struct group *child, int children, int depth)
{
    int largest = -1;
    double most = -1;
    for (int i = 0; i < children; i++) {
        const double size = depth < DEEP ? (double)cml_facet_box_area(&child[i].box) : (double)child[i].count;
        if (child[i].count <= CML_GROUP || size <= most) continue;
        most = size;
        largest = i;
    }
    return largest;
}

/* Divides a group of facets into up to CML_GROUP (16) children of a node and returns their number. It always
 * splits the child that `choose` names. Very deep down, groups are simply halved, so that the depth stays
 * bounded. */
static int divide(const struct builder *b, struct group child[CML_GROUP], int depth)
{
    int children = 1;
    while (children < CML_GROUP) {
        const int i = choose(child, children, depth);
        if (i < 0) break;
        struct group *rest = &child[i], *next = &child[children++];
        const size_t count =
            depth < DEEP ? cml_facet_split(&b->box[rest->first], rest->count, CML_GROUP) : rest->count / 2;
        *next = (struct group){.first = rest->first + count, .count = rest->count - count};
        rest->count = count;
        find_box(b, rest);
        find_box(b, next);
    }
    return children;
}

/* Moves children that become leaves before those that become nodes. Returns the number of leaves. */
static int sort_children(struct group child[CML_GROUP], int children)
{
    int leaves = 0;
    for (int i = 0; i < children; i++) {
        if (child[i].count > CML_GROUP) continue;
        const struct group swapped = child[leaves];
        child[leaves++] = child[i];
        child[i] = swapped;
    }
    return leaves;
}

/* Adds the node of a group, and all nodes and leaves below it. Sets *number to the node's number. */
static cml_status add_node(struct builder *b, const struct group *group, int depth, uint32_t *number,
                           struct cml_error *err)
{
    struct group child[CML_GROUP] = {*group};
    struct cml_tree_node node = {0};
    const int children = divide(b, child, depth);
    node.leaves = sort_children(child, children);
    CML_TRY(add(&b->nodes, number, err));
    for (int i = 0; i < CML_GROUP; i++)
        for (int k = 0; k < 6; k++)
            node.box[k][i] = (i < children ? child[i].box : cml_facet_box_none()).at[k];
    for (int i = 0; i < node.leaves; i++) CML_TRY(add_leaf(b, &child[i], &node.child[i], err));
    for (int i = node.leaves; i < children; i++)
        CML_TRY(add_node(b, &child[i], depth + 1, &node.child[i], err));
    ((struct cml_tree_node *)b->nodes.at)[*number] = node;
    return CML_OK;
}

/* Computes the bounding boxes of all facets in single precision, rounded outwards, so that no facet reaches
 * out of its box. at: three lower sides, then three upper ones. */
static void find_boxes(struct builder *b)
{
    for (uint32_t i = 0; i < b->mesh->num_triangles; i++) {
        b->box[i] = cml_facet_box_none();
        b->box[i].facet = i;
        for (int k = 0; k < 9; k++) {
            const double at = b->mesh->vertex[b->mesh->triangle[i][k / 3]][k % 3];
            const float rounded = (float)at;
            float *least = &b->box[i].at[k % 3], *most = least + 3;
            *least = fminf(*least, rounded > at ? nextafterf(rounded, -INFINITY) : rounded);
            *most = fmaxf(*most, rounded < at ? nextafterf(rounded, INFINITY) : rounded);
        }
    }
}

/* Builds the whole tree and shrinks its arrays to their size. */
static cml_status build(struct builder *b, struct cml_error *err)
{
    const size_t count = b->mesh->num_triangles;
    struct group all = {.count = count};
    uint32_t root;
    b->box = malloc(count * sizeof *b->box);
    if (!b->box) return cml_fail_memory(err, (double)(count * sizeof *b->box), "boxes of facets");
    find_boxes(b);
    find_box(b, &all);
    CML_TRY(add_node(b, &all, 0, &root, err));
    CML_TRY(move(&b->nodes, b->nodes.count, err));
    return move(&b->leaves, b->leaves.count, err);
}

cml_status cml_facet_tree_create(const struct cml_mesh *mesh, const double (*plane)[4], double margin,
                                 struct cml_facet_tree *tree, struct cml_error *err)
{
    struct builder b = {.mesh = mesh,
                        .plane = plane,
                        .margin = margin,
                        .nodes = {.size = sizeof *tree->node},
                        .leaves = {.size = sizeof *tree->leaf}};
    const cml_status status = build(&b, err);
    free(b.box);
    *tree = (struct cml_facet_tree){b.nodes.at, b.leaves.at, b.nodes.count, b.leaves.count};
    if (status != CML_OK) cml_facet_tree_clear(tree);
    return status;
}

void cml_facet_tree_clear(struct cml_facet_tree *tree)
{
    free(tree->node);
    free(tree->leaf);
    *tree = (struct cml_facet_tree){0};
}

double cml_facet_tree_bytes(const struct cml_facet_tree *tree)
{
    return (double)tree->nodes * sizeof *tree->node + (double)tree->leaves * sizeof *tree->leaf;
}
