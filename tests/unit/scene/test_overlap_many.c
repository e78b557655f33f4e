/* Tests of the overlap check with so many boundaries that testing every pair would take hours.
 * SPDX-License-Identifier: MIT */
#include "scene/scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

static char file[] = "a.mci";

/* Cones, one below the other; each spans the depths of thousands of others. */
static void boundaries_by_the_hundred_thousand_are_compared(void **state)
{
    enum { LAYERS = 100000, SAMPLES = 16 };
    double r[SAMPLES], h[SAMPLES];
    struct cml_boundary *boundaries = calloc(LAYERS + 1, sizeof *boundaries);
    struct cml_scene scene = {.file = file, .num_layers = LAYERS, .boundaries = boundaries};
    struct cml_error err;
    (void)state;
    assert_non_null(boundaries);
    for (int i = 0; i < SAMPLES; i++) {
        r[i] = 0.1 * i;
        h[i] = 100 * (SAMPLES - 1 - i);
    }
    for (int b = 0; b <= LAYERS; b++)
        boundaries[b] =
            (struct cml_boundary){.form = CML_FORM_RADIAL, .z = 0.01 * b, .radial = {SAMPLES, r, h}};
    assert_int_equal(cml_scene_check_overlap(&scene, &err), CML_OK);
    boundaries[LAYERS / 2].z += 0.02;
    assert_int_equal(cml_scene_check_overlap(&scene, &err), CML_E_INPUT);
    free(boundaries);
}

/* All boundaries lie at one depth. Planes may touch; a curved boundary must not touch a plane above or below
 * it. */
static void planes_without_a_layer_between_them_are_compared(void **state)
{
    enum { LAYERS = 100000 };
    double r[] = {0, 1}, h[] = {0.125, 0};
    struct cml_boundary *boundaries = calloc(LAYERS + 1, sizeof *boundaries);
    struct cml_scene scene = {.file = file, .num_layers = LAYERS, .boundaries = boundaries};
    struct cml_error err;
    (void)state;
    assert_non_null(boundaries);
    assert_int_equal(cml_scene_check_overlap(&scene, &err), CML_OK);
    boundaries[1].z = 0.5;
    boundaries[1].line = 9;
    assert_int_equal(cml_scene_check_overlap(&scene, &err), CML_E_INPUT);
    assert_string_equal(err.text,
                        "a.mci:9: boundaries 1 and 2 cross at (0 0 0.5) cm: boundary 1 reaches 0.5 cm "
                        "below boundary 2 (expected boundaries that neither cross nor touch)");
    boundaries[1].z = 0;
    boundaries[LAYERS].form = CML_FORM_RADIAL;
    boundaries[LAYERS].radial = (struct cml_radial){2, r, h};
    boundaries[LAYERS].z = 0.25;
    assert_int_equal(cml_scene_check_overlap(&scene, &err), CML_OK);
    boundaries[LAYERS].z = 0.0625;
    assert_int_equal(cml_scene_check_overlap(&scene, &err), CML_E_INPUT);
    boundaries[LAYERS].form = CML_FORM_PLANE;
    boundaries[0].form = CML_FORM_RADIAL;
    boundaries[0].radial = (struct cml_radial){2, r, h};
    assert_int_equal(cml_scene_check_overlap(&scene, &err), CML_E_INPUT);
    free(boundaries);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boundaries_by_the_hundred_thousand_are_compared),
        cmocka_unit_test(planes_without_a_layer_between_them_are_compared),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
