/* Tests of finding the body or layer that directly contains each body. Compares it with testing every
 * pair, and with counts of bodies and boundaries for which testing pairs would take hours.
 * SPDX-License-Identifier: MIT */
#include "scene/body/body_place.h"
#include "scene/body/body_shape.h"

#include "lib/dice.h"
#include "lib/sanitized.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static char file[] = "a.mci";
static struct dice dice;

static struct cml_scene_body sphere(double x, double y, double z, double r)
{
    return (struct cml_scene_body){
        .form = CML_BODY_SPHERE, .layer = 1, .host = 1, .centre = {x, y, z}, .radius = r, .line = 1};
}

static cml_status place(struct cml_scene_body *bodies, int count, struct cml_error *err)
{
    struct cml_scene scene = {.file = file, .num_layers = 1, .num_bodies = count, .bodies = bodies};
    return cml_scene_place_bodies(&scene, err);
}

/* Returns the medium that contains body k, by testing all pairs. Body k is medium 3 + k of a scene with
 * one layer. */
static int host_by_all_pairs(const struct cml_scene_body *bodies, int count, int k)
{
    int host = 1;
    double least = INFINITY, at[3];
    const struct cml_convex inner = cml_body_convex(&bodies[k]);
    for (int i = 0; i < count; i++) {
        const struct cml_convex outer = cml_body_convex(&bodies[i]);
        if (i == k || cml_convex_compare(&inner, &outer, at) != CML_CONVEX_FIRST_INSIDE) continue;
        if (cml_body_volume(&bodies[i]) < least) host = 3 + i;
        least = fmin(least, cml_body_volume(&bodies[i]));
    }
    return host;
}

static bool meets_any(const struct cml_scene_body *bodies, int count, const struct cml_scene_body *body)
{
    double at[3];
    const struct cml_convex one = cml_body_convex(body);
    for (int i = 0; i < count; i++) {
        const struct cml_convex other = cml_body_convex(&bodies[i]);
        if (cml_convex_compare(&one, &other, at) == CML_CONVEX_MEET) return true;
    }
    return false;
}

static struct cml_scene_body any_body(void)
{
    struct cml_scene_body body = sphere(dice_uniform(&dice), dice_uniform(&dice), dice_uniform(&dice), 0);
    body.radius = 1e-3 + 0.5 * pow(dice_uniform(&dice), 4);
    if (dice_uniform(&dice) < 0.5) return body;
    body.form = CML_BODY_CYLINDER;
    for (int k = 0; k < 3; k++) body.end[k] = body.centre[k] + 4 * body.radius * (dice_uniform(&dice) - 0.5);
    return body;
}

static void hosts_are_those_of_all_pairs(void **state)
{
    enum { MOST = 300, SCENES = SANITIZED ? 4 : 20 };
    static struct cml_scene_body bodies[MOST];
    struct cml_error err;
    int nested = 0;
    (void)state;
    dice = dice_new(1);
    for (int scene = 0; scene < SCENES; scene++) {
        int count = 0;
        for (int tries = 0; tries < 4 * MOST && count < MOST; tries++) {
            bodies[count] = any_body();
            count += !meets_any(bodies, count, &bodies[count]);
        }
        assert_int_equal(place(bodies, count, &err), CML_OK);
        for (int k = 0; k < count; k++) {
            assert_int_equal(bodies[k].host, host_by_all_pairs(bodies, count, k));
            nested += bodies[k].host > 1;
        }
        struct cml_scene_body meets = bodies[count / 2];
        meets.centre[0] += meets.radius;
        if (meets.form == CML_BODY_CYLINDER) meets.end[0] += meets.radius;
        bodies[count - 1] = meets;
        assert_int_equal(place(bodies, count, &err), CML_E_INPUT);
    }
    assert_true(nested > 25 * SCENES);
}

/* All pairs of so many bodies would be 5e10. */
enum { MANY = SANITIZED ? 40000 : 320000 };

static struct cml_scene_body *make_many(void)
{
    struct cml_scene_body *bodies = calloc(MANY, sizeof *bodies);
    assert_non_null(bodies);
    return bodies;
}

/* Nested bodies are listed in an order in which neither position in the file nor size helps to find the
 * host. */
static void bodies_nested_by_the_hundred_thousand_find_their_hosts(void **state)
{
    struct cml_scene_body *bodies = make_many();
    struct cml_error err;
    (void)state;
    for (uint64_t i = 0; i < MANY; i++)
        bodies[i * 197 % MANY] = sphere(0, 0, 0.5, 0.4 * (double)(i + 1) / MANY);
    assert_int_equal(place(bodies, MANY, &err), CML_OK);
    for (uint64_t i = 0; i + 1 < MANY; i++)
        assert_int_equal(bodies[i * 197 % MANY].host, 3 + (int)((i + 1) * 197 % MANY));
    bodies[MANY / 2].centre[0] += 1e-5;
    assert_int_equal(place(bodies, MANY, &err), CML_E_INPUT);
    free(bodies);
}

/* Bodies on a cubic grid, each with another body inside, and one body around all of them. */
static void bodies_side_by_side_by_the_hundred_thousand_find_their_hosts(void **state)
{
    enum { EDGE = SANITIZED ? 27 : 54 };
    struct cml_scene_body *bodies = make_many();
    struct cml_error err;
    int count = 0;
    (void)state;
    bodies[count++] = sphere(0, 0, 0, 100);
    for (int i = 0; i < EDGE * EDGE * EDGE; i++)
        for (int inner = 0; inner < 2; inner++)
            bodies[count++] = sphere(i % EDGE - 0.5 * EDGE, i / EDGE % EDGE - 0.5 * EDGE,
                                     i / EDGE / EDGE - 0.5 * EDGE, inner ? 0.1 : 0.49);
    assert_true(count <= MANY);
    assert_int_equal(place(bodies, count, &err), CML_OK);
    for (int k = 1; k < count; k++) assert_int_equal(bodies[k].host, k % 2 ? 3 : 3 + k - 1);
    bodies[count / 2].radius = 0.6;
    assert_int_equal(place(bodies, count, &err), CML_E_INPUT);
    free(bodies);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hosts_are_those_of_all_pairs),
        cmocka_unit_test(bodies_nested_by_the_hundred_thousand_find_their_hosts),
        cmocka_unit_test(bodies_side_by_side_by_the_hundred_thousand_find_their_hosts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
