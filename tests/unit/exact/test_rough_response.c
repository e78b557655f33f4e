/* Tests of the matrices of rough boundaries against reciprocity, energy and an independent program in
 * double precision. Totals of stacks with rough boundaries are tested against theorems.
 * SPDX-License-Identifier: MIT */
#include "exact/exact.h"
#include "exact/rough_response.h"

#include <math.h>

#include "lib/dice.h"
#include "lib/require.h"
#include "lib/sanitized.h"

#include <stdio.h>

static const double pi = 3.14159265358979323846;

/* A rough boundary between two media, and the beams (one per angle) that strike it. The lower medium is a
 * layer above a half space of the same medium. */
struct face {
    struct cml_directions directions;
    struct cml_rough_response response;
};

enum { MOST_BEAMS = 4, ORDER = 16 };

/* Returns the matrices of a rough plane for beams at these angles; the caller clears both members.
 * degrees: [beams], rising. */
static struct face face_of(const struct cml_rough_plane *plane, int beams, const double *degrees,
                           double walks)
{
    const struct cml_medium_def media[] = {
        {.n = plane->above}, {.n = plane->below, .mus = 1, .d = 1}, {.n = plane->below}};
    const bool spreads[] = {true, false};
    struct cml_exact_ray beam[MOST_BEAMS];
    struct face face;
    struct cml_error err;
    for (int i = 0; i < beams; i++) beam[i] = (struct cml_exact_ray){cos(degrees[i] * pi / 180), 1.0 / beams};
    const struct cml_exact_light light = {.num_beams = beams, .beam = beam, .diffuse = beams == 0};
    require_ok(cml_directions_create(media, 1, spreads, &light, ORDER, &face.directions, &err), &err);
    const int *live = face.directions.live;
    require_ok(cml_rough_response_create(plane, &face.directions, live[0], plane->backing ? 0 : live[1],
                                         walks, 1, &face.response, &err),
               &err);
    return face;
}

static void clear(struct face *face)
{
    cml_directions_clear(&face->directions);
    cml_rough_response_clear(&face->response);
}

static void expect_balance(const struct face *face, const struct cml_rough_matrices *m)
{
    const int a = face->response.above, b = face->response.below;
    const double *e = face->directions.etendue;
    for (int j = 0; j < a; j++) {
        double sum = 0;
        for (int i = 0; i < a; i++) {
            sum += m->R[i * a + j];
            assert_near("R", e[j] * m->R[i * a + j], e[i] * m->R[j * a + i], 1e-15);
        }
        for (int i = 0; i < b; i++) {
            sum += m->T[i * a + j];
            assert_near("T", e[j] * m->T[i * a + j], e[i] * m->T_below[j * b + i], 1e-15);
        }
        assert_near("power from above", sum, 1, 1e-12);
    }
    for (int j = 0; j < b; j++) {
        double sum = 0, even = 0;
        for (int i = 0; i < b; i++) {
            sum += m->R_below[i * b + j];
            even += m->R_below[j * b + i] * e[i];
            assert_near("R below", e[j] * m->R_below[i * b + j], e[i] * m->R_below[j * b + i], 1e-15);
        }
        for (int i = 0; i < a; i++) {
            sum += m->T_below[i * b + j];
            even += m->T[j * a + i] * e[i];
        }
        assert_near("power from below", sum, 1, 1e-12);
        assert_near("even light", even, e[j], 1e-14);
    }
}

/* Reciprocity and energy conservation hold for the mean matrix and for the matrix of any part of the
 * random walks. */
static void matrices_are_reciprocal_and_lose_nothing(void **state)
{
    (void)state;
    const double alphas[] = {1e-3, 0.3, 2}, pairs[][2] = {{1, 1.5}, {1.5, 1.33}};
    for (int k = 0; k < 12; k++) {
        const struct cml_rough_plane plane = {
            {k % 2 ? CML_ROUGH_GGX : CML_ROUGH_BECKMANN, alphas[k / 2 % 3], 1},
            pairs[k / 6][0],
            pairs[k / 6][1],
            NULL,
            false};
        struct face face = face_of(&plane, 0, NULL, SANITIZED ? 1e3 : 2e4);
        expect_balance(&face, &face.response.mean);
        expect_balance(&face, &face.response.part[3]);
        clear(&face);
    }
}

/* Returns the share of beam k (beams count from the steepest) that the matrix R or T [rows][columns] sends
 * on. */
static double share_of(const struct face *face, const double *matrix, int rows, int k)
{
    const int columns = face->response.above;
    double sum = 0;
    int j = -1;
    for (k++; k > 0; k--) do
            j++;
        while (face->directions.etendue[j] > 0);
    for (int i = 0; i < rows; i++) sum += matrix[i * columns + j];
    return sum;
}

/* Reflected shares agree with those of an independent program of 300 lines in double precision, good to
 * 2e-4 and 3e-4. Without second facets a third of the light from inside would be lost. */
static void faces_reflect_as_an_independent_walk(void **state)
{
    (void)state;
    const double alpha[] = {0.2, 0.5, 1}, degrees[] = {0, 30, 60, 75},
                 R[][4] = {{0.0400, 0.0424, 0.0906, 0.1952},
                           {0.0392, 0.0417, 0.0663, 0.1088},
                           {0.0219, 0.0268, 0.0445, 0.0657}},
                 T[][3] = {{0, 0, 0}, {0.901, 0.660, 0.154}, {0.555, 0.579, 0.324}};
    for (int k = 0; k < 3 && !SANITIZED; k++) {
        const struct cml_rough_plane outside = {{CML_ROUGH_BECKMANN, alpha[k], 1}, 1, 1.5, NULL, true},
                                     inside = {{CML_ROUGH_BECKMANN, alpha[k], 1}, 1.5, 1, NULL, true};
        struct face face = face_of(&outside, 4, degrees, 2e5);
        for (int i = 0; i < 4; i++)
            assert_near("R", share_of(&face, face.response.mean.R, face.response.above, i), R[k][i],
                        5e-4 + 8e-3 * R[k][i]);
        clear(&face);
        if (k == 0) continue;
        face = face_of(&inside, 3, degrees, 2e5);
        for (int i = 0; i < 3; i++)
            assert_near("T", share_of(&face, face.response.mean.T, face.response.below, i), T[k][i], 3e-3);
        clear(&face);
    }
}

/* The mean square of n sin over a lobe lies near that of the mirror direction. The square is a polynomial
 * of the cosine in every interval, so its mean has no error but the noise of walks. A lobe of slope alpha
 * moves it by about alpha^2. */
static void lobes_lie_about_the_direction_of_the_mirror(void **state)
{
    (void)state;
    const double degrees[] = {10, 40, 80};
    const struct cml_rough_plane plane = {{CML_ROUGH_BECKMANN, 1e-3, 1}, 1.5, 1.2, NULL, true};
    struct face face = face_of(&plane, 3, degrees, 2e4);
    const struct cml_directions *d = &face.directions;
    const int a = face.response.above, b = face.response.below;
    for (int j = 0; j < a; j++) {
        if (d->etendue[j] > 0) continue;
        double back = 0, through = 0, mean_back = 0, mean_through = 0;
        const double square = pow(1.5, 2) * (1 - pow(d->cosine[j], 2));
        for (int i = 0; i < a; i++) {
            const double own = pow(d->index[i], 2) * (1 - pow(d->cosine[i], 2));
            back += face.response.mean.R[i * a + j];
            mean_back += own * face.response.mean.R[i * a + j];
            if (i >= b) continue;
            through += face.response.mean.T[i * a + j];
            mean_through += own * face.response.mean.T[i * a + j];
        }
        assert_near("mirrored", mean_back / back, square, 2e-4);
        if (through > 1e-3) assert_near("refracted", mean_through / through, square, 2e-4);
    }
    clear(&face);
}

static void mirrors_keep_their_share_at_each_facet(void **state)
{
    (void)state;
    const struct cml_backing_def perfect = {.kind = CML_BACKING_MIRROR, .R = 1},
                                 dim = {.kind = CML_BACKING_MIRROR, .R = 0.5};
    const double degrees[] = {0};
    struct cml_rough_plane plane = {{CML_ROUGH_GGX, 1, 1}, 1.4, 1, &perfect, true};
    struct face face = face_of(&plane, 1, degrees, 2e4);
    assert_near("perfect", share_of(&face, face.response.mean.R, face.response.above, 0), 1, 1e-12);
    clear(&face);
    plane.backing = &dim;
    face = face_of(&plane, 1, degrees, 2e4);
    const double rough = share_of(&face, face.response.mean.R, face.response.above, 0);
    assert_true(rough < 0.48 && rough > 0.25);
    clear(&face);
    plane.rough.alpha = 1e-3;
    face = face_of(&plane, 1, degrees, 2e4);
    assert_near("dim", share_of(&face, face.response.mean.R, face.response.above, 0), 0.5, 1e-4);
    clear(&face);
}

/* ---- stacks ---- */

enum { LAYERS = 2 };

/* Solves a stack with rough boundaries; the caller clears the totals. angle < 0: diffuse light. */
static struct cml_exact solve(const struct cml_medium_def *media, const struct cml_rough_def *rough,
                              double angle, double walks)
{
    struct cml_exact_ray beam = {cos(angle), 1};
    const struct cml_exact_light light = {.diffuse = angle < 0, .num_beams = angle >= 0, .beam = &beam};
    const struct cml_exact_options options = {
        .tolerance = 1e-7, .most_work = 1e11, .walks = SANITIZED ? walks / 16 : walks, .rough = rough};
    struct cml_exact exact;
    struct cml_error err;
    require_ok(cml_exact_solve(media, LAYERS, &light, &options, &exact, &err), &err);
    assert_true(exact.converged);
    return exact;
}

static double sum_of(const struct cml_exact *exact)
{
    return exact->value[CML_EXACT_RSP] + exact->value[CML_EXACT_RD] + exact->value[CML_EXACT_A] +
           exact->value[CML_EXACT_TT];
}

/* The medium between the two layers would trap light for ever if its boundaries were smooth. */
static const struct cml_medium_def media[] = {
    {.n = 1}, {.n = 1.5, .d = 0.1}, {.n = 1.37, .mua = 0.3, .mus = 10, .g = 0.7, .d = 0.2}, {.n = 1.2}};

static void the_finest_facets_are_smooth(void **state)
{
    (void)state;
    const struct cml_rough_def finest[] = {
        {CML_ROUGH_BECKMANN, 1e-4, 1}, {CML_ROUGH_BECKMANN, 1e-4, 1}, {CML_ROUGH_BECKMANN, 1e-4, 1}};
    for (int k = 0; k < 3; k++) {
        struct cml_exact rough = solve(media, finest, 0.5 * k, 2e4), smooth = solve(media, NULL, 0.5 * k, 0);
        /* light sent back by a clear layer counts as specular behind a smooth boundary only */
        rough.value[CML_EXACT_RD] += rough.value[CML_EXACT_RSP];
        smooth.value[CML_EXACT_RD] += smooth.value[CML_EXACT_RSP];
        for (int i = CML_EXACT_RD; i < rough.count; i++)
            assert_near("share", rough.value[i], smooth.value[i], rough.error[i] + 1e-4);
        rough.value[CML_EXACT_RSP] = 0;
        assert_near("sum", sum_of(&rough), 1, 1e-12);
        assert_true(rough.walks > 0 && smooth.walks == 0);
        cml_exact_clear(&rough);
        cml_exact_clear(&smooth);
    }
}

/* Diffuse transmission from the two sides is in the ratio of the squared indices. */
static void rough_stacks_transmit_reciprocally(void **state)
{
    (void)state;
    const struct cml_medium_def turned[] = {media[3], media[2], media[1], media[0]};
    const struct cml_rough_def rough[] = {{CML_ROUGH_GGX, 0.3, 1},
                                          {CML_ROUGH_BECKMANN, 1, 1},
                                          {CML_SMOOTH, 0, 0}},
                               rough_turned[] = {rough[2], rough[1], rough[0]};
    struct cml_exact down = solve(media, rough, -1, 5e4), up = solve(turned, rough_turned, -1, 5e4);
    assert_near("Tt", down.value[CML_EXACT_TT], 1.44 * up.value[CML_EXACT_TT],
                down.error[CML_EXACT_TT] + 1.44 * up.error[CML_EXACT_TT]);
    assert_true(down.error[CML_EXACT_TT] < 8e-3 || SANITIZED);
    assert_near("sum", sum_of(&down), 1, 1e-12);
    cml_exact_clear(&down);
    cml_exact_clear(&up);
}

/* Stated errors cover the noise of the random walks: a solution by few walks agrees with one by many
 * within its error. */
static void stated_errors_hold_the_noise_of_walks(void **state)
{
    (void)state;
    const struct cml_rough_def rough[] = {
        {CML_ROUGH_GGX, 0.5, 1}, {CML_SMOOTH, 0, 0}, {CML_ROUGH_BECKMANN, 0.5, 1}};
    struct cml_exact many = solve(media, rough, 0.6, 2e5);
    assert_true(cml_exact_worst(&many) < 1e-3 || SANITIZED);
    for (double walks = 2000; walks < 4e4; walks *= 1.7) {
        struct cml_exact few = solve(media, rough, 0.6, walks);
        for (int i = 0; i < few.count; i++)
            assert_near("share", few.value[i], many.value[i], few.error[i] + many.error[i]);
        assert_true(cml_exact_worst(&few) > cml_exact_worst(&many));
        cml_exact_clear(&few);
    }
    cml_exact_clear(&many);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(matrices_are_reciprocal_and_lose_nothing),
        cmocka_unit_test(faces_reflect_as_an_independent_walk),
        cmocka_unit_test(lobes_lie_about_the_direction_of_the_mirror),
        cmocka_unit_test(mirrors_keep_their_share_at_each_facet),
        cmocka_unit_test(the_finest_facets_are_smooth),
        cmocka_unit_test(rough_stacks_transmit_reciprocally),
        cmocka_unit_test(stated_errors_hold_the_noise_of_walks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
