/* Scripts of curves over r: heights below them, whatever the numbers. SPDX-License-Identifier: MIT */
#include "plot/plot.h"
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(heights_have_ticks),
        cmocka_unit_test(heights_far_from_zero),
        cmocka_unit_test(heights_that_no_scene_can_have),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
