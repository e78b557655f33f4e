/* Tests of the overlap check of tiles against planes, other tiles, and boundaries that they cannot be
 * compared with. SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene.h"

/* Heights of a tile, 3 x 2, 0.1 cm apart; the highest at (0.1, 0.1), the lowest at (0.2, 0). */
static double waves[] = {0, 0, -0.25, 0, 0.125, 0};
static double level[] = {0.125, 0.125, 0.125, 0.125, 0.125, 0.125};

static struct cml_boundary tile(double z, double *h, double dx)
{
    return (struct cml_boundary){.form = CML_FORM_TILE, .z = z, .line = 7, .tile = {3, 2, 0, 0, dx, 0.1, h}};
}

static struct cml_boundary plane(double z)
{
    return (struct cml_boundary){.form = CML_FORM_PLANE, .z = z, .line = 7};
}

static struct cml_boundary radial(double z, int n, double *r, double *h)
{
    return (struct cml_boundary){.form = CML_FORM_RADIAL, .z = z, .line = 7, .radial = {n, r, h}};
}

/* Expects this message for two boundaries; NULL: no overlap. */
static void expect_two(struct cml_boundary upper, struct cml_boundary lower, const char *message)
{
    char file[] = "a.mci";
    struct cml_boundary both[] = {upper, lower};
    struct cml_error err = {CML_OK, ""};
    const struct cml_scene scene = {.file = file, .num_layers = 1, .boundaries = both};
    const cml_status status = cml_scene_check_overlap(&scene, &err);
    char *expected = strstr(err.text, " (expected boundaries that neither cross nor touch)");
    if (expected) *expected = '\0';
    assert_string_equal(err.text, message ? message : "");
    assert_int_equal(status, message ? CML_E_INPUT : CML_OK);
}

/* Tiles are compared exactly with planes and with tiles of equal cells. Other boundaries must lie at other
 * depths or are refused. */
static void tiles_are_compared_exactly_or_refused(void **state)
{
    (void)state;
    double r[] = {0.0, 1.0}, h[] = {0.125, 0.0};
    expect_two(tile(0.0, waves, 0.1), plane(0.26), NULL);
    expect_two(
        tile(0.0, waves, 0.1), plane(0.125),
        "a.mci:7: boundaries 0 and 1 cross at (0.2 0 0.25) cm: boundary 0 reaches 0.125 cm below boundary 1");
    expect_two(tile(0.0, waves, 0.1), plane(0.25), "a.mci:7: boundaries 0 and 1 touch at (0.2 0 0.25) cm");
    expect_two(
        plane(0.0), tile(0.0625, waves, 0.1),
        "a.mci:7: boundaries 0 and 1 cross at (0.1 0.1 0) cm: boundary 0 reaches 0.0625 cm below boundary 1");
    expect_two(plane(0.0), tile(0.125, level, 0.1), NULL); /* a level tile is a plane, and planes may touch */
    expect_two(tile(0.0, waves, 0.1), tile(0.01, waves, 0.1), NULL);
    expect_two(tile(0.0, waves, 0.1), tile(0.0, waves, 0.1),
               "a.mci:7: boundaries 0 and 1 touch at (0 0 0) cm");
    expect_two(
        tile(0.125, waves, 0.1), tile(0.0, waves, 0.1),
        "a.mci:7: boundaries 0 and 1 cross at (0 0 0.125) cm: boundary 0 reaches 0.125 cm below boundary 1");
    expect_two(tile(0.0, waves, 0.1), tile(0.5, waves, 0.2), NULL);
    expect_two(tile(0.0, waves, 0.1), tile(0.25, waves, 0.2),
               "a.mci:7: boundaries 0 and 1, of which one is a tile, lie at depths of -0.125..0.25 and "
               "0.125..0.5 cm "
               "(expected depths that do not overlap, or two tiles of the same cells)");
    expect_two(tile(0.0, waves, 0.1), radial(0.5, 2, r, h), NULL);
    expect_two(
        tile(0.0, waves, 0.1), radial(0.25, 2, r, h),
        "a.mci:7: boundaries 0 and 1, of which one is a tile, lie at depths of -0.125..0.25 and 0.125..0.25 "
        "cm (expected depths that do not overlap, or two tiles of the same cells)");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tiles_are_compared_exactly_or_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
