/* Tests of trees of boxes of bodies: a ray that visits the tree meets every body whose box it passes, each
 * once, as when all boxes are tested in turn. SPDX-License-Identifier: MIT */
#include "surface/body/body_tree.h"

#include "lib/solids.h"

enum { MOST = 400, MEDIA = 5 };

static double boxes[MOST][2][3];
static int host[MOST];

/* Makes boxes that are hard to sort by their middles: some are flat, some equal, some at one place. */
static void make_boxes(int count, struct dice *dice)
{
    for (int b = 0; b < count; b++) {
        const int like = b > 0 && dice_below(dice, 4) == 0 ? dice_below(dice, b) : b;
        host[b] = dice_below(dice, MEDIA);
        for (int k = 0; k < 3; k++) {
            const double at = dice_between(dice, -1, 1), size = 0.6 * dice_uniform(dice);
            boxes[b][0][k] = like < b ? boxes[like][0][k] : at;
            boxes[b][1][k] = like < b ? boxes[like][1][k] : (dice_below(dice, 9) ? at + size : at);
        }
    }
}

static bool passes(const double lower[3], const double upper[3], const double p[3], const double u[3])
{
    wide enter = 0, leave = INFINITY;
    for (int k = 0; k < 3; k++) {
        if (u[k] == 0 && (p[k] < lower[k] || p[k] > upper[k])) return false;
        if (u[k] == 0) continue;
        const wide a = ((wide)lower[k] - p[k]) / u[k], b = ((wide)upper[k] - p[k]) / u[k];
        enter = fmaxl(enter, fminl(a, b));
        leave = fminl(leave, fmaxl(a, b));
    }
    return enter <= leave;
}

/* Visits the tree by its documented rule: a ray that passes a node's box goes on with the next node,
 * otherwise with node `skip`. */
static void visit(const struct cml_body_tree *tree, int medium, const double p[3], const double u[3],
                  int visits[MOST])
{
    const int end = tree->first[medium + 1];
    for (int i = tree->first[medium]; i < end;) {
        const struct cml_body_tree_node *node = &tree->node[i];
        const bool on = passes(node->lower, node->upper, p, u);
        assert_true(node->skip > i && node->skip <= end);
        if (on && node->body >= 0) visits[node->body]++;
        i = on ? i + 1 : node->skip;
    }
}

/* Draws a ray. One ray in four runs along an axis, in the face of a box. */
static void aim(int count, struct dice *dice, double p[3], double u[3])
{
    const int box = dice_below(dice, count), axis = dice_below(dice, 3);
    dice_direction(dice, u);
    for (int k = 0; k < 3; k++) p[k] = dice_between(dice, -1.2, 1.2);
    if (dice_below(dice, 4)) return;
    for (int k = 0; k < 3; k++) {
        u[k] = k == axis ? 1 : 0;
        p[k] = k == axis ? -2 : boxes[box][dice_below(dice, 2)][k];
    }
}

static void rays_visit_every_body_whose_box_they_pass_once(void **state)
{
    struct dice dice = dice_new(61);
    long passed = 0;
    (void)state;
    for (int scene = 0; scene < 60; scene++) {
        const int count = 1 + dice_below(&dice, scene % 3 ? MOST : 8);
        struct cml_body_tree tree;
        struct cml_error err;
        make_boxes(count, &dice);
        assert_int_equal(cml_body_tree_create((const double(*)[2][3])boxes, host, count, MEDIA, &tree, &err),
                         CML_OK);
        for (int ray = 0; ray < 300; ray++) {
            double p[3], u[3];
            const int medium = dice_below(&dice, MEDIA);
            int visits[MOST] = {0};
            aim(count, &dice, p, u);
            visit(&tree, medium, p, u, visits);
            for (int b = 0; b < count; b++) {
                const int wanted = host[b] == medium && passes(boxes[b][0], boxes[b][1], p, u);
                if (visits[b] != wanted) fail_msg("scene %d, ray %d, body %d: %d", scene, ray, b, visits[b]);
                passed += wanted;
            }
        }
        cml_body_tree_clear(&tree);
    }
    assert_true(passed > 5000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_visit_every_body_whose_box_they_pass_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
