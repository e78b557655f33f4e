/* What auto takes for which boundary, and how fine. SPDX-License-Identifier: MIT */
#include "input/mci.h"
#include "surface/surface.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#define STANDARD                                                                                             \
    {                                                                                                        \
        .force = CML_SURFACE_AUTO, .tessellation = {.normals = CML_NORMALS_ANALYTIC}, .tolerance = 1e-3      \
    }

/* n samples of a zigzag of this height over half a centimetre, ending at 0. */
struct zigzag {
    struct cml_radial radial;
    double *numbers;
};

static struct zigzag make_zigzag(int n, double height)
{
    struct zigzag z = {.numbers = malloc(2 * (size_t)n * sizeof(double))};
    z.radial = (struct cml_radial){n, z.numbers, z.numbers + n};
    for (int i = 0; i < n; i++) {
        z.radial.r[i] = 0.5 * i / (n - 1);
        z.radial.h[i] = (n - 1 - i) % 2 ? height : 0;
    }
    return z;
}

static enum cml_surface_kind choose(int n, double height, double mut,
                                    const struct cml_surface_options *options,
                                    struct cml_expectation *expectation)
{
    const double both[2] = {0, mut};
    struct zigzag z = make_zigzag(n, height);
    const enum cml_surface_kind kind = cml_choose_radial(&z.radial, both, options, expectation);
    free(z.numbers);
    return kind;
}

/* Measured: rings cost next to nothing, and a mesh would be biased. */
static void few_rings_and_many_are_cones_without_bias(void **state)
{
    (void)state;
    const struct cml_surface_options options = STANDARD;
    struct cml_expectation few, many;
    assert_int_equal(choose(50, 0.05, 1, &options, &few), CML_SURFACE_CONE);
    assert_true(few.bias == 0 && few.query_ns > 0 && few.deviation == 0);
    assert_int_equal(choose(10001, 0.001, 1, &options, &many), CML_SURFACE_CONE);
    assert_true(many.bias == 0 && many.query_ns > few.query_ns);
    assert_true(many.query_ns < cml_choice_expect_mesh().query_ns);
}

static void a_plane_only_when_asked_and_small(void **state)
{
    (void)state;
    struct cml_surface_options options = STANDARD;
    struct cml_expectation expectation;
    assert_int_equal(choose(50, 1e-6, 1, &options, &expectation), CML_SURFACE_CONE);
    options.may_flatten = true;
    assert_int_equal(choose(50, 1e-6, 1, &options, &expectation), CML_SURFACE_PLANE);
    assert_true(expectation.bias > 0 && expectation.bias <= options.tolerance);
    assert_int_equal(choose(50, 1e-6, 1e5, &options, &expectation), CML_SURFACE_CONE);
    assert_int_equal(choose(50, 0.05, 1, &options, &expectation), CML_SURFACE_CONE);
    options.tolerance = 1e-5;
    assert_int_equal(choose(50, 1e-6, 1, &options, &expectation), CML_SURFACE_CONE);
}

/* A forced mesh keeps the tolerance that is asked for; without one the tessellation's own counts. */
static void the_tolerance_picks_the_tessellation(void **state)
{
    (void)state;
    struct cml_surface_options options = STANDARD;
    struct zigzag z = make_zigzag(50, 0.01);
    const double mut[2] = {0, 1};
    size_t before = 0;
    for (options.tolerance = 1e-1; options.tolerance > 1e-6; options.tolerance /= 10) {
        struct cml_mesh mesh;
        struct cml_error err;
        const struct cml_tessellation fine = cml_choice_tessellation(&options);
        const struct cml_expectation mesh_of_it =
            cml_choice_expect(CML_SURFACE_MESH, &z.radial, mut, &options);
        assert_true(fine.tolerance < options.tolerance && mesh_of_it.deviation == fine.tolerance);
        assert_true(mesh_of_it.bias <= options.tolerance * (1 + 1e-12));
        assert_int_equal(cml_tessellate(&z.radial, &fine, NULL, &mesh, &err), CML_OK);
        assert_true(mesh.num_triangles > before);
        before = mesh.num_triangles;
        cml_mesh_clear(&mesh);
    }
    options.tessellation.normals = CML_NORMALS_VERTEX; /* whose bias does not shrink */
    assert_true(isinf(cml_choice_expect(CML_SURFACE_MESH, &z.radial, mut, &options).bias));
    options.tolerance = 0;
    options.tessellation.tolerance = 0.01;
    assert_true(cml_choice_tessellation(&options).tolerance == 0.01);
    free(z.numbers);
}

static void represent_again(const struct cml_scene_list *list, const struct cml_surface_options *options,
                            struct cml_surface_set *set)
{
    struct cml_error err;
    if (cml_surfaces_create(&list->scenes[0], options, set, &err) != CML_OK) fail_msg("%s", err.text);
}

static void represent(const char *text, const struct cml_surface_options *options,
                      struct cml_scene_list *list, struct cml_surface_set *set)
{
    struct cml_error err;
    char path[] = "/tmp/cml_choice_XXXXXX";
    const int file = mkstemp(path);
    assert_int_equal(write(file, text, strlen(text)), (ssize_t)strlen(text));
    close(file);
    const cml_status status = cml_mci_read(path, NULL, list, &err);
    remove(path);
    if (status != CML_OK) fail_msg("%s", err.text);
    represent_again(list, options, set);
}

/* A flat field, a ripple and a hill: every boundary for itself; a plane lies where the field ends. */
static void every_boundary_chooses_for_itself(void **state)
{
    (void)state;
    static const char *const text =
        "1.0\n1\nx.mco A\n10\n0.01 0.01\n1 1 1\n2\n1\nb 3 0.1 1 0.1 1 0.1 1\n"
        "1.4 1 10 0.5 1\nb 3 0.200001 1 0.2 1 0.2 1\n1.3 1 10 0.5 1\nb 2 0.1 1 0 1\n1\n";
    struct cml_surface_options options = STANDARD;
    struct cml_scene_list list;
    struct cml_surface_set set;
    represent(text, &options, &list, &set);
    assert_int_equal(set.item[0].kind, CML_SURFACE_PLANE);
    assert_true(set.item[0].expectation.bias == 0);
    assert_int_equal(set.item[1].kind, CML_SURFACE_CONE);
    cml_surfaces_free(&set);
    cml_scene_list_clear(&list);
    options.may_flatten = true;
    represent(text, &options, &list, &set);
    assert_int_equal(set.item[1].kind, CML_SURFACE_PLANE);
    assert_true(set.item[1].depth == 0.8);
    assert_true(set.item[1].expectation.bias > 0);
    assert_int_equal(set.item[2].kind, CML_SURFACE_CONE);
    cml_surfaces_free(&set);
    options.force = CML_SURFACE_PLANE; /* all of them at their nominal depth */
    represent_again(&list, &options, &set);
    for (int b = 0; b < 3; b++) {
        assert_int_equal(set.item[b].kind, CML_SURFACE_PLANE);
        assert_true(set.item[b].depth == b);
    }
    assert_string_equal(set.item[2].reason, "surface ignored as asked");
    cml_surfaces_free(&set);
    options.force = CML_SURFACE_AUTO;
    list.scenes[0].facets = true; /* whose rings were asked for */
    represent_again(&list, &options, &set);
    assert_int_equal(set.item[1].kind, CML_SURFACE_CONE);
    cml_surfaces_free(&set);
    cml_scene_list_clear(&list);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(few_rings_and_many_are_cones_without_bias),
        cmocka_unit_test(a_plane_only_when_asked_and_small),
        cmocka_unit_test(the_tolerance_picks_the_tessellation),
        cmocka_unit_test(every_boundary_chooses_for_itself),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
