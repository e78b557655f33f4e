/* Tests of the tree of facets against every facet in long double: sets of facets of all sizes and shapes,
 * and rays aimed at edges and corners, along facets, and from facets. SPDX-License-Identifier: MIT */
#include "surface/tree/facet_tree.h"

#include "geometry/vec3.h"
#include "lib/dice.h"
#include "surface/tree/centred_mesh.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_FACETS = 700, RAYS = 20000 };

static const struct cml_tree_level *levels[CML_TREE_LEVELS];
static int num_levels;

struct soup {
    struct cml_centred_mesh centred;
    struct cml_facet_tree tree;
};

/* A ray in double, as in queries. */
struct path {
    double p[3], u[3], length;
    int below, exclude;
};

/* ---- scenes ---- */

/* Draws corner k of a facet around `middle`. shape, from 0: an ordinary facet; a long, narrow one; one
 * narrower than any margin; one without an area. */
static void choose_corner(struct dice *dice, int shape, int k, const double along[3], const double middle[3],
                          double size, double corner[3])
{
    static const double aside[] = {1, 1e-3, 1e-9, 0};
    double direction[3];
    dice_direction(dice, direction);
    for (int i = 0; i < 3; i++)
        corner[i] = middle[i] + size * ((k - 1) * along[i] + aside[shape] * direction[i]);
}

/* Makes a set of facets. shapes: how many of the shapes of choose_corner occur. Facets are not joined, so
 * each side is an edge; some facets lie closer to the one before than floats can tell. */
static void make_soup(struct soup *soup, struct dice *dice, int facets, int shapes, double extent)
{
    struct cml_mesh mesh = {
        .num_vertices = 3 * (size_t)facets, .num_triangles = (size_t)facets, .closed = true};
    struct cml_error err;
    mesh.vertex = malloc(mesh.num_vertices * sizeof *mesh.vertex);
    mesh.triangle = malloc(mesh.num_triangles * sizeof *mesh.triangle);
    for (int k = 0; k < 3; k++) {
        mesh.lower[k] = INFINITY;
        mesh.upper[k] = -INFINITY;
    }
    for (int i = 0; i < facets; i++) {
        const int shape = dice_below(dice, shapes);
        const double size = extent * pow(10, dice_between(dice, -3, -0.5));
        double middle[3], along[3];
        for (int k = 0; k < 3; k++) middle[k] = extent * dice_between(dice, -0.5, 0.5);
        dice_direction(dice, along);
        const double nearby = extent * dice_between(dice, -1e-7, 1e-7);
        const bool doubled = i > 0 && dice_below(dice, 3) == 0;
        for (int k = 0; k < 3; k++) {
            double *corner = mesh.vertex[3 * i + k];
            choose_corner(dice, shape, k, along, middle, size, corner);
            if (doubled) cml_vec3_add_scaled(corner - 9, nearby, along, corner);
            mesh.triangle[i][k] = (uint32_t)(3 * i + k);
            for (int m = 0; m < 3; m++) {
                mesh.lower[m] = fmin(mesh.lower[m], corner[m]);
                mesh.upper[m] = fmax(mesh.upper[m], corner[m]);
            }
        }
    }
    assert_int_equal(cml_centred_mesh_create(&mesh, 0, 0, &soup->centred, &err), CML_OK);
    assert_int_equal(cml_facet_tree_create(&soup->centred.mesh, (const double(*)[4])soup->centred.plane,
                                           soup->centred.err_margin, &soup->tree, &err),
                     CML_OK);
}

static void clear_soup(struct soup *soup)
{
    cml_facet_tree_clear(&soup->tree);
    cml_centred_mesh_clear(&soup->centred);
}

/* Draws a target on a facet: inside, on an edge, or a corner. */
static void choose_target(const struct soup *soup, struct dice *dice, int facet, double target[3])
{
    double weight[3] = {dice_uniform(dice), dice_uniform(dice), dice_uniform(dice)}, sum = 0;
    const int zeros = dice_below(dice, 3), first = dice_below(dice, 3);
    for (int k = 0; k < zeros; k++) weight[(first + k) % 3] = 0;
    for (int k = 0; k < 3; k++) sum += weight[k];
    for (int k = 0; k < 3; k++) target[k] = 0;
    for (int k = 0; k < 3; k++)
        cml_vec3_add_scaled(target, weight[k] / sum, cml_centred_corner(&soup->centred, facet, k), target);
}

/* Draws a path to a target on a facet: from a point of the box, vertically, or along an axis. The path ends
 * before the target, at it, behind it, or nowhere. */
static void aim(const struct soup *soup, struct dice *dice, struct path *path)
{
    const int facet = dice_below(dice, (int)soup->centred.mesh.num_triangles), axis = dice_below(dice, 6);
    const double *lower = soup->centred.lower, *upper = soup->centred.upper,
                 off = 1e-7 * (upper[0] - lower[0]);
    double target[3];
    choose_target(soup, dice, facet, target);
    for (int k = 0; k < 3; k++) {
        path->p[k] = axis < 3 && axis != k ? target[k] : dice_between(dice, lower[k], upper[k]);
        target[k] += dice_below(dice, 2) ? dice_between(dice, -off, off) : 0;
        path->u[k] = axis < 3 && axis != k ? -0.0 : target[k] - path->p[k];
    }
    const double distance = cml_vec3_length(path->u);
    cml_vec3_normalise(path->u);
    const double lengths[] = {distance, distance * (1 - 1e-7), distance * (1 + 1e-7),
                              distance * dice_between(dice, 0, 2), INFINITY};
    path->length = lengths[dice_below(dice, 5)];
    path->below = dice_below(dice, 2);
    path->exclude = -1;
}

/* ---- the oracle ---- */

static long double volume(const struct path *path, const double *a, const double *b)
{
    long double v[3], w[3];
    const double *u = path->u;
    for (int k = 0; k < 3; k++) {
        v[k] = (long double)a[k] - path->p[k];
        w[k] = (long double)b[k] - path->p[k];
    }
    return u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) +
           u[2] * (v[0] * w[1] - v[1] * w[0]);
}

/* Returns the distance at which the path leaves its side through the facet; INFINITY: it does not. */
static long double crossing_of(const struct soup *soup, const struct path *path, int facet)
{
    const double *a = cml_centred_corner(&soup->centred, facet, 0),
                 *b = cml_centred_corner(&soup->centred, facet, 1),
                 *c = cml_centred_corner(&soup->centred, facet, 2);
    const long double sign = path->below ? 1 : -1, x = sign * volume(path, b, c),
                      y = sign * volume(path, c, a), z = sign * volume(path, a, b), sum = x + y + z;
    long double t = 0;
    if (!(x > 0 && y > 0 && z > 0)) return INFINITY;
    for (int k = 0; k < 3; k++) t += ((x * a[k] + y * b[k] + z * c[k]) / sum - path->p[k]) * path->u[k];
    return t > 0 && t < path->length ? t : INFINITY;
}

static bool is_named(const struct cml_tree_answer *answer, int facet)
{
    bool named = answer->facet == facet;
    for (int i = 0; i < answer->doubts; i++) named = named || answer->doubt[i] == facet;
    return named;
}

/* Returns the number of errors in the tree's answer: the answer must name the facets through which the
 * path leaves before the sure one, and the path must leave through the sure one. */
static int count_wrong(const struct soup *soup, const struct path *path, const struct cml_tree_answer *answer)
{
    const int facets = (int)soup->centred.mesh.num_triangles;
    const long double sure = answer->facet < 0 ? INFINITY : crossing_of(soup, path, answer->facet);
    int wrong = answer->facet >= 0 && !(sure < INFINITY);
    for (int i = 0; i < facets; i++)
        wrong += i != path->exclude && crossing_of(soup, path, i) < sure && !is_named(answer, i);
    return wrong;
}

/* ---- asking ---- */

static struct cml_tree_ray ray_of(const struct soup *soup, const struct path *path)
{
    struct cml_tree_ray ray = {.length = (float)fmin(path->length, (double)FLT_MAX),
                               .margin = (float)soup->centred.err_margin,
                               .below = path->below,
                               .exclude = path->exclude};
    for (int k = 0; k < 3; k++) {
        ray.origin[k] = (float)path->p[k];
        ray.direction[k] = (float)path->u[k];
    }
    return ray;
}

static void assert_same(const struct cml_tree_answer *a, const struct cml_tree_answer *b)
{
    assert_int_equal(a->facet, b->facet);
    assert_int_equal(a->doubts, b->doubts);
    assert_int_equal(a->blurred, b->blurred);
    assert_int_equal(a->re_enters, b->re_enters);
    assert_memory_equal(a->doubt, b->doubt, (size_t)a->doubts * sizeof a->doubt[0]);
}

/* Asks the tree with each level of the processor, whose answers must be equal. */
static struct cml_tree_answer ask(const struct soup *soup, const struct path *path)
{
    const struct cml_tree_ray ray = ray_of(soup, path);
    struct cml_tree_answer answer[CML_TREE_LEVELS];
    for (int i = 0; i < num_levels; i++) {
        memset(&answer[i], 0xff, sizeof answer[i]);
        levels[i]->ask(&soup->tree, &ray, &answer[i]);
        assert_same(&answer[i], &answer[0]);
    }
    return answer[0];
}

static void check_soup(uint32_t seed, int facets, int shapes, double extent)
{
    struct dice dice = dice_new(seed);
    struct soup soup;
    int wrong = 0, plain = 0, met = 0, doubtful = 0;
    make_soup(&soup, &dice, facets, shapes, extent);
    for (int n = 0; n < RAYS; n++) {
        struct path path;
        aim(&soup, &dice, &path);
        const struct cml_tree_answer answer = ask(&soup, &path);
        if (answer.blurred) continue;
        wrong += count_wrong(&soup, &path, &answer) > 0;
        plain += answer.doubts == 0;
        met += answer.doubts == 0 && answer.facet >= 0;
        doubtful += answer.doubts > 0;
    }
    clear_soup(&soup);
    assert_int_equal(wrong, 0);
    assert_in_range(plain, RAYS / 200, RAYS);
    if (shapes > 2) return;
    assert_in_range(met, RAYS / 200, RAYS);
    assert_in_range(doubtful, RAYS / 200, RAYS);
}

static void what_a_ray_meets_is_sure_or_named(void **state)
{
    (void)state;
    check_soup(1, 5, 1, 1);
    check_soup(2, 100, 1, 1);
    check_soup(3, MOST_FACETS, 1, 1e3);
    check_soup(4, 300, 2, 1e-3);
}

static void facets_too_thin_for_floats_blur_an_answer_and_make_none_wrong(void **state)
{
    (void)state;
    check_soup(5, 40, 4, 1);
}

/* Packets that rounding may have put on a facet or beyond it name that facet, in whatever direction they
 * head, also along it. */
static void a_facet_at_the_origin_is_named(void **state)
{
    (void)state;
    struct dice dice = dice_new(6);
    struct soup soup;
    int missing = 0;
    make_soup(&soup, &dice, 200, 1, 1);
    for (int n = 0; n < RAYS; n++) {
        const int facet = dice_below(&dice, 200);
        const double *normal = soup.centred.plane[facet], off = 1e-9 * dice_between(&dice, -1, 1);
        struct path path = {
            .length = dice_between(&dice, 0, 1), .below = dice_below(&dice, 2), .exclude = -1};
        choose_target(&soup, &dice, facet, path.p);
        cml_vec3_add_scaled(path.p, off, normal, path.p);
        dice_direction(&dice, path.u);
        if (dice_below(&dice, 2)) cml_vec3_add_scaled(path.u, -cml_vec3_dot(path.u, normal), normal, path.u);
        cml_vec3_normalise(path.u);
        const struct cml_tree_answer answer = ask(&soup, &path);
        missing += !answer.blurred && (!is_named(&answer, facet) || answer.facet == facet);
        path.exclude = facet;
        const struct cml_tree_answer standing = ask(&soup, &path);
        assert_false(is_named(&standing, facet));
    }
    clear_soup(&soup);
    assert_int_equal(missing, 0);
}

/* A path begins before a facet by more than the margin. The answer tells if the path crosses something
 * from behind first. */
static void a_path_that_comes_from_the_wrong_side_is_told(void **state)
{
    (void)state;
    struct dice dice = dice_new(7);
    struct soup soup;
    make_soup(&soup, &dice, 1, 1, 1);
    for (int below = 0; below < 2; below++) {
        const double *normal = soup.centred.plane[0];
        struct path path = {.length = 1, .below = below, .exclude = -1};
        for (int k = 0; k < 3; k++) {
            path.u[k] = normal[k];
            for (int i = 0; i < 3; i++) path.p[k] += cml_centred_corner(&soup.centred, 0, i)[k] / 3;
            path.p[k] -= 0.5 * normal[k];
        }
        const struct cml_tree_answer answer = ask(&soup, &path);
        assert_int_equal(answer.re_enters, !below);
        assert_int_equal(answer.facet, below ? 0 : -1);
    }
    clear_soup(&soup);
}

/* Every facet is in exactly one leaf. */
static void leaves_hold_every_facet_once(void **state)
{
    (void)state;
    struct dice dice = dice_new(8);
    struct soup soup;
    int seen[MOST_FACETS] = {0};
    make_soup(&soup, &dice, MOST_FACETS, 1, 1);
    for (uint32_t i = 0; i < soup.tree.leaves; i++)
        for (int k = 0; k < CML_GROUP; k++)
            if (soup.tree.leaf[i].facet[k] != CML_TREE_NO_FACET) seen[soup.tree.leaf[i].facet[k]]++;
    for (int i = 0; i < MOST_FACETS; i++) assert_int_equal(seen[i], 1);
    assert_true(soup.tree.leaves < MOST_FACETS / 8);
    clear_soup(&soup);
}

/* Facets at one place, which no cut can separate, still make a tree. */
static void facets_at_one_place_make_a_tree(void **state)
{
    (void)state;
    struct dice dice = dice_new(9);
    struct soup soup;
    make_soup(&soup, &dice, MOST_FACETS, 1, 1);
    cml_facet_tree_clear(&soup.tree);
    struct cml_error err;
    for (size_t i = 0; i < 3 * (size_t)MOST_FACETS; i++)
        cml_vec3_copy(soup.centred.mesh.vertex[i % 3], soup.centred.mesh.vertex[i]);
    assert_int_equal(cml_facet_tree_create(&soup.centred.mesh, (const double(*)[4])soup.centred.plane, 1e-6,
                                           &soup.tree, &err),
                     CML_OK);
    assert_in_range(soup.tree.leaves, MOST_FACETS / CML_GROUP, MOST_FACETS / 4);
    clear_soup(&soup);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_a_ray_meets_is_sure_or_named),
        cmocka_unit_test(facets_too_thin_for_floats_blur_an_answer_and_make_none_wrong),
        cmocka_unit_test(a_facet_at_the_origin_is_named),
        cmocka_unit_test(a_path_that_comes_from_the_wrong_side_is_told),
        cmocka_unit_test(leaves_hold_every_facet_once),
        cmocka_unit_test(facets_at_one_place_make_a_tree),
    };
    num_levels = cml_tree_levels(levels);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
