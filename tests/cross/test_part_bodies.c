/* Compares bodies whose mesh has several closed parts with the same surfaces as separate bodies.
 * SPDX-License-Identifier: MIT */
#include "flight.h"

#include "body_files.h"

#include <math.h>

/* Writes the surfaces of both spheres into one file. */
static void write_both(const char *path, const struct cml_scene_body *a, const struct cml_scene_body *b,
                       int n)
{
    struct cml_error err;
    struct cml_mesh one, other;
    require_ok(cml_body_mesh(a, n, false, &one, &err), &err);
    require_ok(cml_body_mesh(b, n, false, &other, &err), &err);
    struct cml_mesh both = {.num_vertices = one.num_vertices + other.num_vertices,
                            .num_triangles = one.num_triangles + other.num_triangles,
                            .closed = true};
    both.vertex = malloc(both.num_vertices * sizeof *both.vertex);
    both.triangle = malloc(both.num_triangles * sizeof *both.triangle);
    assert_true(both.vertex && both.triangle);
    memcpy(both.vertex, one.vertex, one.num_vertices * sizeof *one.vertex);
    memcpy(both.vertex + one.num_vertices, other.vertex, other.num_vertices * sizeof *other.vertex);
    memcpy(both.triangle, one.triangle, one.num_triangles * sizeof *one.triangle);
    for (size_t t = 0; t < other.num_triangles; t++)
        for (int k = 0; k < 3; k++)
            both.triangle[one.num_triangles + t][k] = other.triangle[t][k] + (uint32_t)one.num_vertices;
    require_ok(cml_obj_write(path, &both, NULL, &err), &err);
    cml_mesh_clear(&one);
    cml_mesh_clear(&other);
    cml_mesh_clear(&both);
}

/* Returns how many of `photons` packets end differently if two spheres are one mesh (line `first`) or two
 * meshes (lines `second`). */
static int count_changed(const char *engine, const char *first, const char *second, int photons)
{
    static const char *const text = "1.0\n1\nparts A\n1000\n0.01 0.01\n10 10 1\nbeam disk 0.2\n1\n1\n"
                                    "1.37 0.5 30 0.8 0.5\n%s1\n";
    const struct flight_options with = {.engine = engine};
    struct flight one, other;
    char one_text[2048], other_text[2048];
    snprintf(one_text, sizeof one_text, text, first);
    snprintf(other_text, sizeof other_text, text, second);
    flight_open(one_text, &with, &one);
    flight_open(other_text, &with, &other);
    const int different = (int)count_different(&one, &other, (uint64_t)photons);
    flight_close(&one);
    flight_close(&other);
    return different;
}

/* Checks that both scenes give the same packets. On `cpu`, rounding may change a few, because the frame of a
 * mesh is its middle. */
static void expect_same(const char *first, const char *second)
{
    assert_int_equal(count_changed("reference", first, second, 3000), 0);
    assert_in_range(count_changed("cpu", first, second, 20000), 0, 20);
}

struct files {
    char one[32], other[32], both[32];
};

static struct files write_spheres(const struct cml_scene_body *a, const struct cml_scene_body *b)
{
    struct files files = {"/tmp/cml_parts_XXXXXX.obj", "/tmp/cml_parts_XXXXXX.obj",
                          "/tmp/cml_parts_XXXXXX.obj"};
    close(mkstemps(files.one, 4));
    close(mkstemps(files.other, 4));
    close(mkstemps(files.both, 4));
    write_body(files.one, *a, 8);
    write_body(files.other, *b, 8);
    write_both(files.both, a, b, 8);
    return files;
}

static void remove_files(const struct files *files)
{
    remove(files->one);
    remove(files->other);
    remove(files->both);
}

static struct cml_scene_body sphere(double x, double z, double r)
{
    return (struct cml_scene_body){.form = CML_BODY_SPHERE, .centre = {x, 0.01, z}, .radius = r};
}

static void two_spheres_are_one_body(void **state)
{
    (void)state;
    const struct cml_scene_body a = sphere(-0.1, 0.2, 0.09), b = sphere(0.12, 0.25, 0.1);
    const struct files files = write_spheres(&a, &b);
    char first[512], second[512];
    snprintf(first, sizeof first, "i \"%s\" 1.5 2 20 0.7\n", files.both);
    snprintf(second, sizeof second, "i \"%s\" 1.5 2 20 0.7\ni \"%s\" 1.5 2 20 0.7\n", files.one, files.other);
    expect_same(first, second);
    remove_files(&files);
}

/* A cavity has the medium of the layer. It acts like a body of the layer's medium inside another body. */
static void a_cavity_is_what_is_around(void **state)
{
    (void)state;
    const struct cml_scene_body a = sphere(0, 0.25, 0.15), b = sphere(0.01, 0.26, 0.1);
    const struct files files = write_spheres(&a, &b);
    char first[512], second[512];
    snprintf(first, sizeof first, "i \"%s\" 1.5 2 20 0.7\n", files.both);
    snprintf(second, sizeof second, "i \"%s\" 1.5 2 20 0.7\ni \"%s\" 1.37 0.5 30 0.8\n", files.one,
             files.other);
    expect_same(first, second);
    remove_files(&files);
}

/* A bead in the cavity lies in the layer; in the other scene it lies in the inner body. */
static void a_body_in_a_cavity_lies_in_what_is_around(void **state)
{
    (void)state;
    const struct cml_scene_body a = sphere(0, 0.25, 0.15), b = sphere(0.01, 0.26, 0.1);
    const struct files files = write_spheres(&a, &b);
    char first[512], second[512];
    const char *bead = "i sphere 0.03 0 0.25 0.05 1 0 0 0\n";
    snprintf(first, sizeof first, "i \"%s\" 1.5 2 20 0.7\n%s", files.both, bead);
    snprintf(second, sizeof second, "i \"%s\" 1.5 2 20 0.7\ni \"%s\" 1.37 0.5 30 0.8\n%s", files.one,
             files.other, bead);
    expect_same(first, second);
    remove_files(&files);
}

static void write_boxes(const char *path, const double (*box)[2][3], int count)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (int b = 0; b < count; b++) {
        static const int sides[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                        {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
        for (int i = 0; i < 8; i++)
            fprintf(file, "v %g %g %g\n", box[b][i >> 2 & 1][0], box[b][i >> 1 & 1][1], -box[b][i & 1][2]);
        for (int s = 0; s < 6; s++)
            fprintf(file, "f %d %d %d %d\n", 8 * b + sides[s][0] + 1, 8 * b + sides[s][1] + 1,
                    8 * b + sides[s][2] + 1, 8 * b + sides[s][3] + 1);
    }
    assert_int_equal(fclose(file), 0);
}

/* Tests a box made of boxes that overlap, lie within it, and end in its faces. */
static void a_union_of_boxes_is_a_box(void **state)
{
    (void)state;
    static const double whole[1][2][3] = {{{-0.15, -0.1, 0.1}, {0.15, 0.1, 0.3}}},
                        parts[4][2][3] = {{{-0.15, -0.1, 0.1}, {0.05, 0.1, 0.3}},
                                          {{-0.03, -0.1, 0.1}, {0.15, 0.1, 0.3}},
                                          {{-0.12, -0.05, 0.15}, {0.1, 0.07, 0.22}},
                                          {{-0.13, -0.02, 0.12}, {0.13, 0.02, 0.3}}};
    char one[] = "/tmp/cml_parts_XXXXXX.obj", many[] = "/tmp/cml_parts_XXXXXX.obj", first[256], second[256];
    close(mkstemps(one, 4));
    close(mkstemps(many, 4));
    write_boxes(one, whole, 1);
    write_boxes(many, parts, 4);
    snprintf(first, sizeof first, "i \"%s\" 1.5 2 20 0.7 union\n", many);
    snprintf(second, sizeof second, "i \"%s\" 1.5 2 20 0.7\n", one);
    expect_same(first, second);
    remove(one);
    remove(many);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_spheres_are_one_body),
        cmocka_unit_test(a_cavity_is_what_is_around),
        cmocka_unit_test(a_body_in_a_cavity_lies_in_what_is_around),
        cmocka_unit_test(a_union_of_boxes_is_a_box),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
