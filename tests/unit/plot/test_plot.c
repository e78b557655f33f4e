/* Scripts of curves over r: heights below them, whatever the numbers; of maps: ticks of colours.
 * SPDX-License-Identifier: MIT */
#include "plot/plot.h"
#include "plot/plot_map.h"
#include "lib/require.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The script for a result with these heights; the caller frees it. */
static char *script_of(const char *heights)
{
    static const char *const names[1] = {"a.mco"};
    struct cml_mco mco = {.dz = 1, .dr = 0.1, .nz = 1, .nr = 4, .na = 1, .num_layers = 1};
    struct cml_error err = {CML_OK, ""};
    struct cml_plot plot = {.num_results = 1,
                            .results = &mco,
                            .names = names,
                            .paths = names,
                            .style = {.x = cml_axis_range_any, .y = cml_axis_range_any}};
    require_ok(cml_shown_find(NULL, &plot.shown, &err), &err);
    char *script = NULL;
    size_t size = 0;
    require_ok(cml_mco_allocate(&mco, &err), &err);
    mco.extra = strdup(heights);
    for (int i = 0; i < mco.nr; i++) mco.Rd_r[i] = mco.Tt_r[i] = 4 - i;
    FILE *stream = open_memstream(&script, &size);
    assert_non_null(stream);
    alarm(20); /* ends a script that does not end */
    require_ok(cml_plot_script(stream, &plot, &err), &err);
    alarm(0);
    assert_int_equal(fclose(stream), 0);
    cml_mco_clear(&mco);
    return script;
}

static void assert_writes(const char *heights, const char *expected)
{
    char *script = script_of(heights);
    if (!strstr(script, expected)) print_error("%s\n", script);
    assert_non_null(strstr(script, expected));
    free(script);
}

static void heights_have_ticks(void **state)
{
    (void)state;
    assert_writes("heightfield0 # r, h [cm]\n0\n0\n0.1\n0.4\n", "set y2tics (0, 0.2, 0.4)");
    assert_writes("heightfield0 # r, h [cm]\n0\n-3\n0.1\n-3\n", "set y2tics (-3)");
    assert_writes("", "unset y2tics");
}

/* A step that is small beside the heights leads no further. */
static void heights_far_from_zero(void **state)
{
    (void)state;
    assert_writes("heightfield0 # r, h [cm]\n0\n1e20\n0.1\n1e20\n", "set y2tics (1e+20");
    assert_writes("heightfield1 # r, h [cm]\n0\n-1e30\n0.1\n-1e30\n", "set y2tics (-1e+30");
    assert_writes("heightfield0 # r, h [cm]\n0\n0\n0.1\n5e-324\n", "set y2tics (0, 0.05)");
}

/* Only a damaged file has them. */
static void heights_that_no_scene_can_have(void **state)
{
    (void)state;
    assert_writes("heightfield0 # r, h [cm]\n0\n1e308\n0.1\n-1e308\n", "unset y2tics");
    assert_writes("heightfield0 # r, h [cm]\n0\n0\n0.1\n0.4\n0.2\n1e308\n", "set y2tics (0, 0.2, 0.4)");
}

/* The script for a map of two pixels; the caller frees it. */
static char *script_of_map(float first, float second, enum cml_scale scale)
{
    static const char *const names[1] = {"a.map.vti"};
    float value[2] = {first, second};
    const struct cml_pixels map = {.n = {2, 1}, .spacing = {1, 1}, .value = value};
    const struct cml_map_plot plot = {.count = 1,
                                      .maps = &map,
                                      .names = names,
                                      .quantity = "Rd",
                                      .grey = "no light",
                                      .axes = &cml_map_xy,
                                      .style = {.scale = scale,
                                                .x = cml_axis_range_any,
                                                .y = cml_axis_range_any,
                                                .colour = cml_axis_range_any,
                                                .percentile = 100}};
    struct cml_error err = {CML_OK, ""};
    char *script = NULL;
    size_t size = 0;
    FILE *stream = open_memstream(&script, &size);
    assert_non_null(stream);
    alarm(20); /* ends a script that does not end */
    require_ok(cml_map_script(stream, &plot, &err), &err);
    alarm(0);
    assert_int_equal(fclose(stream), 0);
    return script;
}

/* Powers of ten alone would be one tick or none; a map without light has no range to put ticks into. */
static void colours_have_ticks_where_there_is_light(void **state)
{
    (void)state;
    char *lit = script_of_map(2, 6, CML_SCALE_LOG), *dark = script_of_map(0, 0, CML_SCALE_LOG),
         *wide = script_of_map(1, 1e6F, CML_SCALE_LOG), *linear = script_of_map(2, 6, CML_SCALE_LINEAR);
    assert_non_null(strstr(lit, "set cbtics ('1' 1, '2' 2, '5' 5, '10' 10"));
    assert_null(strstr(dark, "cbtics"));
    assert_null(strstr(dark, "cbrange"));
    assert_null(strstr(wide, "cbtics"));
    assert_null(strstr(linear, "cbtics"));
    free(lit);
    free(dark);
    free(wide);
    free(linear);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(heights_have_ticks),
        cmocka_unit_test(heights_far_from_zero),
        cmocka_unit_test(colours_have_ticks_where_there_is_light),
        cmocka_unit_test(heights_that_no_scene_can_have),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
