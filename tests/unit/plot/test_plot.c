/* Scripts of curves over r: heights below them, whatever the numbers; of maps: ticks of colours.
 * SPDX-License-Identifier: MIT */
#include "plot/plot.h"
#include "plot/plot_map.h"
#include "lib/require.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The script for a result with a boundary of these n pairs of r and h; the caller frees it. */
static char *script_of(int boundary, int n, double *pair)
{
    static const char *const names[1] = {"a.mco"};
    struct cml_heights heights = {boundary, n, pair};
    struct cml_outcome o = {.dz = 1, .dr = 0.1, .nz = 1, .nr = 4, .na = 1, .num_layers = 1};
    struct cml_error err = {CML_OK, ""};
    struct cml_plot plot = {.num_results = 1,
                            .results = &o,
                            .names = names,
                            .paths = names,
                            .style = {.x = cml_axis_range_any, .y = cml_axis_range_any}};
    require_ok(cml_shown_find(NULL, &plot.shown, &err), &err);
    char *script = NULL;
    size_t size = 0;
    require_ok(cml_outcome_allocate(&o, &err), &err);
    o.heights = &heights;
    o.num_heights = 1;
    for (int i = 0; i < o.nr; i++) o.value[CML_QUANTITY_Rd_r][i] = o.value[CML_QUANTITY_Tt_r][i] = 4 - i;
    FILE *stream = open_memstream(&script, &size);
    assert_non_null(stream);
    alarm(20); /* ends a script that does not end */
    require_ok(cml_plot_script(stream, &plot, &err), &err);
    alarm(0);
    assert_int_equal(fclose(stream), 0);
    o.heights = NULL;
    o.num_heights = 0;
    cml_outcome_clear(&o);
    return script;
}

/* Of heights at r = 0 and 0.1. */
static void assert_writes(int boundary, int n, double first, double second, const char *expected)
{
    char *script = script_of(boundary, n, (double[]){0, first, 0.1, second});
    if (!strstr(script, expected)) print_error("%s\n", script);
    assert_non_null(strstr(script, expected));
    free(script);
}

static void heights_have_ticks(void **state)
{
    (void)state;
    assert_writes(0, 2, 0, 0.4, "set y2tics (0, 0.2, 0.4)");
    assert_writes(0, 2, -3, -3, "set y2tics (-3)");
    assert_writes(0, 0, 0, 0, "unset y2tics");
}

/* A step that is small beside the heights leads no further. */
static void heights_far_from_zero(void **state)
{
    (void)state;
    assert_writes(0, 2, 1e20, 1e20, "set y2tics (1e+20");
    assert_writes(1, 2, -1e30, -1e30, "set y2tics (-1e+30");
    assert_writes(0, 2, 0, 5e-324, "set y2tics (0, 0.05)");
}

/* The script for a map of two pixels; the caller frees it. */
static char *script_of_map(float first, float second, enum cml_scale scale)
{
    static const char *const names[1] = {"a.h5"};
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
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
