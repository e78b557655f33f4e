/* Tests of the line `phase` of a scene: the layer that it belongs to, its numbers, settings and tables,
 * and the messages of refusals. SPDX-License-Identifier: MIT */
#include "lib/dice.h"
#include "lib/require.h"
#include "lib/mci_case.h"

#include <math.h>

/* Line 9 is the layer; its g must follow. */
#define HEAD "1.0\n1\na.mco A\n100\n0.1 0.2\n3 4 5\n1\n1\n1.4 1 2 "
#define LAYER(g) HEAD #g " 1\n"

static void media_share_what_is_equal(void **state)
{
    struct cml_scene_list list;
    case_read_ok(state,
                 "1.0\n1\na A\n1\n1 1\n1 1 1\n4\n1\n"
                 "1.4 1 2 0.9 1\n#@ phase gk 0.9 0.5 # comment\n"
                 "i sphere 0 0 0.5 0.1 1.5 1 2 0\nphase rayleigh\n"
                 "i sphere 0.5 0 0.5 0.1 1.5 1 2 0.3\n"
                 "1.4 1 2 0.3 1\nphase mhg 0.5 0.6\n"
                 "b 2 0.1 0.1 0 0\n1.4 1 2 0.9 1\n"
                 "1.4 1 2 0.9 1\nphase gk 0.9 0.5\n1\n",
                 &list);
    const struct cml_scene *scene = list.scenes;
    const struct cml_medium_def *m = scene->media;
    assert_int_equal(m[1].phase->kind, CML_PHASE_GK);
    assert_true(m[1].phase->number[0] == 0.9 && m[1].phase->number[1] == 0.5);
    assert_int_equal(m[2].phase->kind, CML_PHASE_MHG);
    assert_null(m[3].phase);
    assert_ptr_equal(m[4].phase, m[1].phase);
    assert_int_equal(m[6].phase->kind, CML_PHASE_RAYLEIGH);
    assert_null(m[7].phase);
    assert_int_equal(scene->phases->index, 2);
    cml_scene_list_clear(&list);
}

static void tables_are_scaled_and_have_a_mean(void **state)
{
    struct cml_scene_list list;
    case_write(state, "p.txt",
               "# linear in c: (1 + c) / 2, twenty times\n0 20 # forward\n\n60 15\n  90\t10\n180 0\n");
    case_read_ok(state, HEAD "0.3333 1\nphase table \"p.txt\"\n1\n", &list);
    case_remove(state, "p.txt");
    const struct cml_phase *phase = list.scenes[0].media[1].phase;
    assert_int_equal(phase->rows, 4);
    for (int i = 0; i < 4; i++)
        assert_near("density", phase->density[i], (2 - phase->deflection[i]) / 2, 1e-15);
    assert_near("mean", cml_phase_mean(phase), 1.0 / 3, 1e-15);
    for (double x = 0; x <= 2; x += 0.125)
        assert_near("below", cml_phase_below(phase, x), x - x * x / 4, 1e-15);
    cml_scene_list_clear(&list);
}

static void numbers_can_be_set(void **state)
{
    struct cml_error err;
    struct cml_scene_list list;
    struct cml_settings settings = {0};
    const struct cml_input_options options = {.settings = &settings};
    require_ok(cml_settings_add(&settings, "layer1.phase.g1=0.7", &err), &err);
    require_ok(cml_settings_add(&settings, "layer1.phase.w=0.5", &err), &err);
    require_ok(cml_settings_add(&settings, "layer1.g=0.55", &err), &err);
    case_read_ok_with(state, LAYER(0.9) "phase hg2 0.95 0.4 0.9\n1\n", &options, &list);
    const double *number = list.scenes[0].media[1].phase->number;
    assert_true(number[0] == 0.7 && number[1] == 0.4 && number[2] == 0.5);
    cml_scene_list_clear(&list);
}

static void what_is_refused(void **state)
{
#define PHASE "layer 1: phase"
#define COSINE "a number of -0.9999..0.9999"
    static const struct {
        const char *text, *message;
    } table[] = {
        {LAYER(0) "phase\n1\n",
         "x.mci:10: " PHASE ": kind is missing (expected hg2, mhg, gk, rayleigh or table)"},
        {LAYER(0) "phase hg 0.9\n1\n",
         "x.mci:10: " PHASE ": kind = hg (expected hg2, mhg, gk, rayleigh or table)"},
        {LAYER(0) "phase hg2 1 0 0.5\n1\n", "x.mci:10: " PHASE ": g1 = 1 (expected " COSINE ")"},
        {LAYER(0) "phase hg2 0.5 x 0.5\n1\n", "x.mci:10: " PHASE ": g2 = x (expected " COSINE ")"},
        {LAYER(0) "phase hg2 0.5 0\n1\n", "x.mci:10: " PHASE ": w is missing (expected a share of 0..1)"},
        {LAYER(0) "phase mhg 0.5 1.1\n1\n", "x.mci:10: " PHASE ": w = 1.1 (expected a share of 0..1)"},
        {LAYER(0) "phase gk 0.5 -0.5\n1\n",
         "x.mci:10: " PHASE ": a = -0.5 (expected a number, -0.5 < a <= 100)"},
        {LAYER(0) "phase rayleigh 1\n1\n",
         "x.mci:10: " PHASE " = 1 (expected the end of the line or a comment)"},
        {LAYER(0.9) "phase rayleigh\n1\n",
         "x.mci:10: " PHASE ": mean cosine = 0 (expected the medium's g = 0.9 to 1e-3)"},
        {LAYER(0.8) "phase gk 0.8 0.51\n1\n",
         "x.mci:10: " PHASE ": mean cosine = 0.803334 (expected the medium's g = 0.8 to 1e-3)"},
        {LAYER(0) "phase rayleigh\nphase rayleigh\n1\n",
         "x.mci:11: line = phase rayleigh (expected one phase line for each layer and body)"},
        {HEAD "0 1\nb 2 0.1 0.1 0 0\nphase rayleigh\n1\n",
         "x.mci:11: line = phase rayleigh (expected n below; a phase line stands behind the line of the "
         "layer "
         "or body whose it is)"},
        {"1.0\n1\na.mco A\n100\nphase rayleigh\n", "x.mci:5: line = phase rayleigh (expected dz dr; a phase "
                                                   "line stands behind the line of the layer or "
                                                   "body whose it is)"},
        {LAYER(0) "1\nphase rayleigh\n",
         "x.mci:11: line = phase rayleigh (expected the end of the run; a phase line stands behind the line "
         "of the layer or body whose it is)"},
        {LAYER(0) "phase table\n1\n",
         "x.mci:10: " PHASE ": file is missing (expected the name of a file of angles and densities)"},
        {LAYER(0) "phase table \"none.txt\"\n1\n",
         "x.mci:10: " PHASE ": none.txt: cannot be read: No such file or directory (expected a file)"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        struct cml_error err;
        struct cml_scene_list list;
        assert_int_equal(case_read(state, table[i].text, &list, &err), CML_E_INPUT);
        assert_string_equal(err.text, table[i].message);
    }
}

static void tables_that_are_refused(void **state)
{
#define RISES "degrees up to 180 that rise from row to row, the first 0"
    static const struct {
        const char *rows, *message;
    } table[] = {
        {"", "x.mci:10: " PHASE ": p.txt: angle is missing (expected a last row at 180 degrees)"},
        {"0 1\n170 1\n",
         "x.mci:10: " PHASE ": p.txt:2: angle is missing (expected a last row at 180 degrees)"},
        {"1 1\n180 1\n", "x.mci:10: " PHASE ": p.txt:1: angle = 1 (expected " RISES ")"},
        {"0 1\n90 1\n90 1\n180 1\n", "x.mci:10: " PHASE ": p.txt:3: angle = 90 (expected " RISES ")"},
        {"0 1\n90 1\n80 1\n180 1\n", "x.mci:10: " PHASE ": p.txt:3: angle = 80 (expected " RISES ")"},
        {"0 1\n181 1\n", "x.mci:10: " PHASE ": p.txt:2: angle = 181 (expected " RISES ")"},
        {"0 1\nx 1\n", "x.mci:10: " PHASE ": p.txt:2: angle = x (expected " RISES ")"},
        {"0 1\n180 -1\n", "x.mci:10: " PHASE ": p.txt:2: p = -1 (expected a phase function of 0..1e30)"},
        {"0 1\n180\n", "x.mci:10: " PHASE ": p.txt:2: p is missing (expected a phase function of 0..1e30)"},
        {"0 1\n180 nan\n", "x.mci:10: " PHASE ": p.txt:2: p = nan (expected a phase function of 0..1e30)"},
        {"0 1 7\n180 1\n", "x.mci:10: " PHASE ": p.txt:1: row = 7 (expected two columns: angle and p)"},
        {"0 0\n180 0\n", "x.mci:10: " PHASE ": p.txt:2: p = 0 in all rows (expected light somewhere)"},
        {"0 1\n180 1\n", ""},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        struct cml_error err;
        struct cml_scene_list list;
        case_write(state, "p.txt", table[i].rows);
        const cml_status status = case_read(state, LAYER(0) "phase table \"p.txt\"\n1\n", &list, &err);
        case_remove(state, "p.txt");
        assert_string_equal(err.text, table[i].message);
        if (status == CML_OK) cml_scene_list_clear(&list);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(media_share_what_is_equal), cmocka_unit_test(tables_are_scaled_and_have_a_mean),
        cmocka_unit_test(numbers_can_be_set),        cmocka_unit_test(what_is_refused),
        cmocka_unit_test(tables_that_are_refused),
    };
    return cmocka_run_group_tests_name("mci_phase", tests, case_setup, case_teardown);
}
