/* Tests of the table of responses of flat layers below a level. It is compared with adding-doubling of
 * higher order at exactly the same direction: random directions, grazing ones and those beside critical
 * angles. SPDX-License-Identifier: MIT */
#include "exact/stack.h"
#include "exact/tail_response.h"

#include <math.h>

#include "lib/dice.h"
#include "lib/require.h"

#include <stdlib.h>
#include <string.h>

enum { RAYS = 32, MOST_LAYERS = 8, ORDER = 91 };

static int compare_rays(const void *a, const void *b)
{
    const struct cml_exact_ray *x = a, *y = b;
    return (x->cosine < y->cosine) - (x->cosine > y->cosine);
}

/* Draws cosines in the level's medium, in falling order. */
static void choose_rays(const struct cml_flat_tail *tail, struct dice *dice, struct cml_exact_ray *ray)
{
    const double n = tail->index[tail->intervals - 1];
    for (int i = 0; i < RAYS; i++) {
        const double critical = sqrt(fmax(0, 1 - pow(tail->index[i % tail->intervals] / n, 2))),
                     off = pow(10, -1 - 4 * dice_uniform(dice));
        ray[i].cosine = i < RAYS / 2 ? 1 - dice_uniform(dice) : i % 2 ? critical + off : fabs(critical - off);
    }
    qsort(ray, RAYS, sizeof *ray, compare_rays);
}

/* Returns the response that the table gives for a score at a cosine in the level's medium. grazing: cosine
 * of the light in the medium whose index ends the interval. */
static double look_up(const struct cml_flat_tail *tail, double cosine, int score, double *grazing)
{
    const double n = tail->index[tail->intervals - 1];
    int k = 0;
    double square = 0;
    for (; k < tail->intervals; k++) {
        const double share = n / tail->index[k];
        square = share * share * cosine * cosine + (1 - share) * (1 + share);
        if (square > 0) break;
    }
    const double at = sqrt(sqrt(square)) / cml_flat_tail_widest(tail, k) * CML_FLAT_TAIL_CELLS;
    const int cell = at < CML_FLAT_TAIL_CELLS ? (int)at : CML_FLAT_TAIL_CELLS - 1;
    const float *low = tail->response +
                       ((size_t)k * (CML_FLAT_TAIL_CELLS + 1) + (size_t)cell) * (size_t)tail->scores + score;
    *grazing = sqrt(square);
    return ldexp(low[0] + (at - cell) * (low[tail->scores] - low[0]), -tail->exponent[score]);
}

/* Compares responses of the table with solved ones. err_share is the allowed error relative to the
 * response. Light within 2 degrees of grazing is weighted by its cosine, and responses below `least` of
 * the largest count as that. */
static void expect_responses(const struct cml_medium_def *media, int num_layers, int layer, double z,
                             double err_share, double least)
{
    struct cml_medium_def stack[MOST_LAYERS + 2];
    struct cml_flat_tail tail;
    struct cml_exact_ray ray[RAYS];
    struct cml_directions directions;
    struct cml_error err;
    struct dice dice = dice_new(11);
    const int layers = num_layers - layer + 1;
    double response[(MOST_LAYERS + 1) * RAYS];
    require_ok(cml_tail_create(media, num_layers, layer, z, &tail, &err), &err);
    assert_int_equal(tail.scores, layers);
    choose_rays(&tail, &dice, ray);
    stack[0] = media[layer];
    memcpy(stack + 1, media + layer, ((size_t)layers + 1) * sizeof *stack);
    stack[1].d -= z;
    const struct cml_exact_light light = {.num_beams = RAYS, .beam = ray};
    require_ok(cml_directions_create(stack, layers, NULL, &light, ORDER, &directions, &err), &err);
    require_ok(cml_stack_responses(stack, &directions, 2 * ORDER, RAYS, response, &err), &err);
    for (int s = 0; s < tail.scores; s++) {
        const double *direct = response + (s > 0 ? s + 1 : 0) * RAYS;
        double most = 0;
        for (int i = 0; i < RAYS; i++) most = fmax(most, direct[i]);
        for (int i = 0; i < RAYS; i++) {
            double grazing;
            const double found = look_up(&tail, ray[i].cosine, s, &grazing);
            assert_near("response", found, direct[i],
                        err_share * fmax(direct[i], least * most) / fmin(1, 30 * grazing));
        }
    }
    cml_directions_clear(&directions);
    cml_flat_tail_clear(&tail);
}

/* With sanitizers the case of many indices and the deep layer are left out, because sanitizers look for
 * other faults than wrong digits. */
static void thick_layers_respond_as_solved(void **state)
{
    (void)state;
    const struct cml_medium_def deep[] = {{.n = 1}, {1.4, 0.5, 100, 0.9, 4.95, NULL, {0}, 0, 0}, {.n = 1}},
                                even[] = {{.n = 1}, {1.5, 1, 90, 0, 0.1, NULL, {0}, 0, 0}, {.n = 1.2}},
                                steps[] = {{.n = 1},
                                           {1.53, 0.2, 300, 0.9, 0.02, NULL, {0}, 0, 0},
                                           {1.34, 0.15, 100, 0.85, 0.1, NULL, {0}, 0, 0},
                                           {1.6, 1, 20, -0.3, 0.1, NULL, {0}, 0, 0},
                                           {.n = 1}},
                                clear[] = {{.n = 1.2},
                                           {1.4, 1, 10, 0.5, 0.1, NULL, {0}, 0, 0},
                                           {1.5, 0, 0, 0, 0.1, NULL, {0}, 0, 0},
                                           {1.33, 3, 5, 0.5, 0.2, NULL, {0}, 0, 0},
                                           {.n = 1.2}};
    if (!SANITIZED) expect_responses(deep, 1, 1, 0.001, 1e-5, 1e-3);
    expect_responses(even, 1, 1, 0.01, 1e-5, 1e-3);
    expect_responses(steps, 3, 3, 0.01, 1e-5, 1e-3);
    if (SANITIZED) return;
    expect_responses(steps, 3, 1, 0.001, 1e-5, 1e-3);
    expect_responses(clear, 3, 2, 0.05, 1e-5, 1e-3);
}

/* Transmission of a thin layer has a kink at the critical angle, which the nodes of the table resolve
 * poorly. The error is therefore relative to the largest response. */
static void responses_of_thin_layers_are_close_to_their_largest(void **state)
{
    (void)state;
    for (double d = 0.01; d > 0.5e-5; d /= SANITIZED ? 10000 : 10) {
        const struct cml_medium_def thin[] = {{.n = 1}, {1.4, 0.5, 100, 0.9, d, NULL, {0}, 0, 0}, {.n = 1}};
        expect_responses(thin, 1, 1, d / 16, 2e-5, 1);
    }
}

/* More indices than the table has directions for are refused. */
static void too_many_indices_are_refused(void **state)
{
    (void)state;
    enum { LAYERS = 60 };
    struct cml_medium_def media[LAYERS + 2];
    struct cml_flat_tail tail;
    struct cml_error err;
    for (int m = 0; m < LAYERS + 2; m++)
        media[m] = (struct cml_medium_def){1.6 - 0.01 * m, 1, 10, 0.5, 0.1, NULL, {0}, 0, 0};
    assert_int_equal(cml_tail_create(media, LAYERS, 1, 0.01, &tail, &err), CML_E_NUMERIC);
    assert_null(tail.response);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(thick_layers_respond_as_solved),
        cmocka_unit_test(responses_of_thin_layers_are_close_to_their_largest),
        cmocka_unit_test(too_many_indices_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
