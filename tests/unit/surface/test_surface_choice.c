/* Tests of `auto`, which chooses how each boundary is represented (plane, rings, mesh), and of the
 * fineness of a tessellation. SPDX-License-Identifier: MIT */
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

/* A radial zigzag: n samples of this height over half a centimetre, ending at 0. */
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

/* Rings are chosen: measurements show that they cost next to nothing, and a mesh would have a bias. */
static void cones_cost_less_than_a_mesh_and_have_no_bias(void **state)
{
    (void)state;
    const struct cml_expectation few = cml_choice_expect_cones(50), many = cml_choice_expect_cones(10001);
    assert_true(few.bias == 0 && few.query_ns > 0 && few.deviation == 0);
    assert_true(many.bias == 0 && many.query_ns > few.query_ns);
    assert_true(many.query_ns < cml_choice_expect_mesh().query_ns);
}

/* A forced mesh keeps the tolerance asked for. Without a tolerance it has the tessellation's own counts. */
static void the_tolerance_picks_the_tessellation(void **state)
{
    (void)state;
    struct cml_surface_options options = STANDARD;
    struct zigzag z = make_zigzag(50, 0.01);
    size_t before = 0;
    for (options.tolerance = 1e-1; options.tolerance > 1e-6; options.tolerance /= 10) {
        struct cml_mesh mesh;
        struct cml_error err;
        const struct cml_tessellation fine = cml_choice_tessellation(&options);
        const struct cml_expectation mesh_of_it = cml_choice_expect_tessellation(&options);
        assert_true(fine.tolerance < options.tolerance && mesh_of_it.deviation == fine.tolerance);
        assert_true(mesh_of_it.bias <= options.tolerance * (1 + 1e-12));
        assert_int_equal(cml_tessellate(&z.radial, &fine, NULL, &mesh, &err), CML_OK);
        assert_true(mesh.num_triangles > before);
        before = mesh.num_triangles;
        cml_mesh_clear(&mesh);
    }
    options.tessellation.normals = CML_NORMALS_VERTEX; /* vertex normals: the bias does not shrink */
    assert_true(isinf(cml_choice_expect_tessellation(&options).bias));
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

/* A flat field is the plane in which it lies. A field with any height stays curved, however small, also if
 * a trial may make it a plane later. */
static void only_flat_fields_are_planes(void **state)
{
    (void)state;
    static const char *const text =
        "1.0\n1\nx.mco A\n10\n0.01 0.01\n1 1 1\n2\n1\nb 3 0.1 1 0.1 1 0.1 1\n"
        "1.4 1 10 0.5 1\nb 3 0.200001 1 0.2 1 0.2 1\n1.3 1 10 0.5 1\nb 2 0.1 1 0 1\n1\n";
    struct cml_surface_options options = STANDARD;
    for (int allowed = 0; allowed < 2; allowed++) {
        struct cml_scene_list list;
        struct cml_surface_set set;
        options.may_flatten = allowed;
        represent(text, &options, &list, &set);
        assert_int_equal(set.item[0].kind, CML_SURFACE_PLANE);
        assert_true(set.item[0].expectation.bias == 0 && set.item[0].depth == -0.1);
        assert_int_equal(set.item[1].kind, CML_SURFACE_CONE);
        assert_int_equal(set.item[2].kind, CML_SURFACE_CONE);
        cml_surfaces_free(&set);
        cml_scene_list_clear(&list);
    }
    struct cml_scene_list list;
    struct cml_surface_set set;
    options.force = CML_SURFACE_PLANE; /* all planes are at their nominal depth */
    represent(text, &options, &list, &set);
    for (int b = 0; b < 3; b++) {
        assert_int_equal(set.item[b].kind, CML_SURFACE_PLANE);
        assert_true(set.item[b].depth == b);
    }
    assert_string_equal(set.item[2].reason, "surface ignored as asked");
    cml_surfaces_free(&set);
    cml_scene_list_clear(&list);
}

/* A field goes on as its outer plane, at its last height. Level rings of the field lie at that height,
 * too. */
static void a_field_goes_on_as_its_outer_plane(void **state)
{
    (void)state;
    static const char *const text = "1.0\n1\nx.mco A\n10\n0.01 0.01\n1 1 1\n1\n1\n"
                                    "1.4 1 10 0.5 1\nb 3 0.200001 1 0.25 1 0.2 1\n1\n";
    const struct cml_surface_options options = STANDARD;
    struct cml_scene_list list;
    struct cml_surface_set set;
    struct cml_surface_def def;
    struct cml_error err;
    represent(text, &options, &list, &set);
    cml_surface_make_outer_plane(&list.scenes[0].boundaries[1], &def);
    assert_int_equal(def.kind, CML_SURFACE_PLANE);
    assert_true(def.depth == 0.8);
    assert_int_equal(cml_surface_make_level_rings(&list.scenes[0].boundaries[1], &def, &err), CML_OK);
    assert_int_equal(def.kind, CML_SURFACE_CONE);
    assert_true(def.depth == 1 && def.lowest == -0.2 && def.highest == -0.2 && def.steepest == 0);
    cml_surface_clear(&def);
    cml_surfaces_free(&set);
    cml_scene_list_clear(&list);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cones_cost_less_than_a_mesh_and_have_no_bias),
        cmocka_unit_test(the_tolerance_picks_the_tessellation),
        cmocka_unit_test(only_flat_fields_are_planes),
        cmocka_unit_test(a_field_goes_on_as_its_outer_plane),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
