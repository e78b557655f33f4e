/* Tests of cml_mci_copy, which copies a scene with other numbers. The copy equals the file read with those
 * settings, shares large data with the original, and outlives the original. SPDX-License-Identifier: MIT */
#include "lib/mci_case.h"
#include "lib/require.h"

static const char text[] =
    "1.0\n1\na.mco A\n100\n0.1 0.2\n3 4 5\nbeam disk 0.1 at=1,2 angle=10\ndetector ring 0.1 0.2 "
    "na=0.3\n3\n1\n"
    "b 2 0.1 0.1 0 0\n1.4 1 2 0.895 1\nphase hg2 0.95 0.4 0.9\ni sphere 0 0 0.5 0.1 1.5 1 2 0.895\n"
    "phase hg2 0.95 0.4 0.9\nb 2 -0.2 0.3 0 0\n1.5 1 2 0.5 2\n1.3 3 4 0.3 1\nbacking 0.5\n1\n";

/* Settings in their ranges, together with the settings that they depend on. */
static const char *const set[] = {
    "photons=7",     "below.n=1.1",      "layer1.mua=0.3",     "layer1.d=1.5",      "layer1.phase.w=0.8",
    "layer1.g=0.84", "body1.mus=9",      "backing.r=0.25",     "boundary0.scale=2", "beam.radius=0.3",
    "beam.angle=30", "detector.r1=0.05", "detector.azimuth=45"};

static void add(struct cml_settings *settings, const char *setting)
{
    struct cml_error err;
    require_ok(cml_settings_add(settings, setting, &err), &err);
}

static void same_media(const struct cml_scene *one, const struct cml_scene *other)
{
    for (int m = 0; m < 6; m++) {
        const struct cml_medium_def *a = &one->media[m], *b = &other->media[m];
        assert_memory_equal(a, b, offsetof(struct cml_medium_def, phase));
        assert_true(!a->phase == !b->phase && (!a->phase || cml_phase_equal(a->phase, b->phase)));
        assert_true(a->line == b->line && a->phase_line == b->phase_line);
    }
}

static void same_boundaries(const struct cml_scene *one, const struct cml_scene *other)
{
    for (int b = 0; b < 4; b++) {
        const struct cml_boundary *p = &one->boundaries[b], *q = &other->boundaries[b];
        assert_true(p->form == q->form && p->z == q->z && p->line == q->line && p->radial.n == q->radial.n);
        for (int i = 0; i < p->radial.n; i++)
            assert_true(p->radial.r[i] == q->radial.r[i] && p->radial.h[i] == q->radial.h[i]);
    }
}

static void it_says_what_a_file_read_so_says(void **state)
{
    struct cml_scene_list plain, whole;
    struct cml_scene copy;
    struct cml_error err;
    struct cml_settings settings = {0};
    for (size_t i = 0; i < sizeof set / sizeof *set; i++) add(&settings, set[i]);
    const struct cml_input_options options = {.settings = &settings};
    case_read_ok_with(state, text, &options, &whole);
    case_read_ok(state, text, &plain);
    case_write(state, "x.mci", text);
    require_ok(cml_mci_copy(&plain.scenes[0], &options, &copy, &err), &err);
    case_remove(state, "x.mci");
    const struct cml_boundary *from = plain.scenes[0].boundaries;
    assert_true(!cml_boundary_same_shape(&copy.boundaries[0], &from[0]));
    assert_true(cml_boundary_same_shape(&copy.boundaries[1], &from[1]));
    assert_ptr_equal(copy.bodies, plain.scenes[0].bodies);
    assert_ptr_equal(plain.scenes[0].media[1].phase, plain.scenes[0].media[5].phase);
    assert_ptr_not_equal(copy.media[1].phase, copy.media[5].phase);
    cml_scene_list_clear(&plain);
    const struct cml_scene *read = &whole.scenes[0];
    same_media(&copy, read);
    same_boundaries(&copy, read);
    assert_true(copy.photons == 7 && copy.backing.R == 0.25 && copy.media[1].phase->number[2] == 0.8);
    assert_true(copy.beams[0].angle == read->beams[0].angle && copy.beams[0].size[0] == 0.3);
    assert_memory_equal(copy.detectors[0].size, ((double[]){0.05, 0.2}), sizeof copy.detectors[0].size);
    assert_true(copy.detectors[0].azimuth == read->detectors[0].azimuth && copy.detectors[0].z == 0);
    assert_string_equal(copy.settings, read->settings);
    assert_string_equal(copy.text, read->text);
    cml_scene_clear(&copy);
    cml_scene_list_clear(&whole);
}

/* Each setting that the reader of a file refuses is refused by the copy, in the same words. */
static void it_refuses_what_a_file_read_so_refuses(void **state)
{
    static const char *const wrong[] = {
        "layer4.mua=1",      "layer01.mua=1",    "layer1.mua=-1",   "beam1.x=0",          "beam.z=1",
        "boundary2.scale=2", "above.mua=1",      "body1.d=1",       "backing.n=1",        "detector.radius=1",
        "beam.angle=90",     "layer1.g=0.5",     "detector.r1=0.2", "layer2.phase.w=0.5", "mua=1",
        "layer1.mua=1e-12",  "boundary0.scale=0"};
    struct cml_scene_list plain, none;
    case_read_ok(state, text, &plain);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        struct cml_settings settings = {0};
        const struct cml_input_options options = {.settings = &settings};
        struct cml_error at_once, err = {CML_OK, ""};
        struct cml_scene copy;
        add(&settings, wrong[i]);
        assert_int_equal(case_read_with(state, text, &options, &none, &at_once), CML_E_INPUT);
        assert_int_equal(cml_mci_copy(&plain.scenes[0], &options, &copy, &err), CML_E_INPUT);
        case_normalise(state, err.text);
        assert_string_equal(err.text, at_once.text);
        assert_null(copy.media);
    }
    cml_scene_list_clear(&plain);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_says_what_a_file_read_so_says),
        cmocka_unit_test(it_refuses_what_a_file_read_so_refuses),
    };
    return cmocka_run_group_tests_name("mci_copy", tests, case_setup, case_teardown);
}
