/* Tests of making one oriented sheet with a skirt from a list of triangles. SPDX-License-Identifier: MIT */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "geometry/mesh.h"

/* State of a random generator of this file, so that a failing case can be repeated. */
static uint32_t random_state;

static uint32_t random_below(uint32_t n)
{
    random_state = random_state * 1664525u + 1013904223u;
    return (uint32_t)(((uint64_t)random_state * n) >> 32);
}

static void *copy_of(const void *data, size_t size)
{
    void *copy = malloc(size);
    assert_non_null(copy);
    memcpy(copy, data, size);
    return copy;
}

static struct cml_mesh make_mesh(const double (*vertex)[3], size_t num_vertices,
                                 const uint32_t (*triangle)[3], size_t num_triangles)
{
    return (struct cml_mesh){
        .num_vertices = num_vertices,
        .num_triangles = num_triangles,
        .vertex = copy_of(vertex, num_vertices * sizeof(double[3])),
        .triangle = copy_of(triangle, num_triangles * sizeof(uint32_t[3])),
    };
}

#define COUNT(array) (sizeof(array) / sizeof(array)[0])
#define MAKE(vertex, triangle) make_mesh(vertex, COUNT(vertex), triangle, COUNT(triangle))

static void prepare(struct cml_mesh *mesh, struct cml_mesh_notes *notes)
{
    struct cml_error err = {0};
    const cml_status status = cml_mesh_prepare(mesh, NULL, notes, &err);
    assert_string_equal(err.text, "");
    assert_int_equal(status, CML_OK);
}

enum { N = 7 }; /* cells per side of the bumpy sheet */

/* Returns a bump over [0, N]^2, facing up, whose border lies at z = 0.25. */
static struct cml_mesh bumpy_sheet(void)
{
    double vertex[(N + 1) * (N + 1)][3];
    uint32_t triangle[2 * N * N][3];
    for (uint32_t i = 0; i < (N + 1) * (N + 1); i++) {
        const double x = i % (N + 1), y = i / (N + 1);
        vertex[i][0] = x;
        vertex[i][1] = y;
        vertex[i][2] = 0.25 - 0.01 * x * y * (N - x) * (N - y) * (1 + 0.1 * x);
    }
    for (uint32_t c = 0, t = 0; c < N * N; c++) {
        const uint32_t a = c / N * (N + 1) + c % N, b = a + N + 1;
        memcpy(triangle[t++], (uint32_t[]){a, b, a + 1}, sizeof triangle[0]);
        memcpy(triangle[t++], (uint32_t[]){a + 1, b, b + 1}, sizeof triangle[0]);
    }
    return MAKE(vertex, triangle);
}

static double cross_z(const struct cml_mesh *mesh, size_t t)
{
    const double *a = mesh->vertex[mesh->triangle[t][0]], *b = mesh->vertex[mesh->triangle[t][1]];
    const double *c = mesh->vertex[mesh->triangle[t][2]];
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static double border_area(const struct cml_mesh *mesh)
{
    double area = 0;
    for (size_t i = 0; i < mesh->num_border; i++) {
        const double *p = mesh->vertex[mesh->border[i]];
        const double *q = mesh->vertex[mesh->border[(i + 1) % mesh->num_border]];
        area += 0.5 * (p[0] * q[1] - p[1] * q[0]);
    }
    return area;
}

static void check_sheet(const struct cml_mesh *mesh)
{
    for (size_t t = 0; t < mesh->num_triangles; t++) assert_true(cross_z(mesh, t) < 0);
    for (size_t i = 0; i < mesh->num_vertices; i++) {
        const double *n = mesh->vertex_normal[i];
        assert_true(n[2] < 0);
        assert_true(fabs(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1) < 1e-15);
    }
    assert_int_equal(mesh->num_border, 4 * N);
    assert_int_equal(mesh->border[0], 0);
    assert_true(border_area(mesh) == -N * N);
    assert_true(mesh->z_border == 0.25 && mesh->upper[2] == 0.25);
    assert_true(mesh->lower[0] == 0 && mesh->upper[0] == N && mesh->upper[1] == N);
}

static void orients_any_winding(void **state)
{
    (void)state;
    for (uint32_t seed = 0; seed < 200; seed++) {
        struct cml_mesh mesh = bumpy_sheet();
        random_state = seed;
        size_t turned = 0;
        for (size_t t = 0; t < mesh.num_triangles; t++) {
            uint32_t corner[3];
            memcpy(corner, mesh.triangle[t], sizeof corner);
            const uint32_t turn = seed ? random_below(2) : 0, first = random_below(3);
            for (uint32_t k = 0; k < 3; k++) mesh.triangle[t][k] = corner[(first + (turn ? 3 - k : k)) % 3];
            turned += turn;
        }
        struct cml_mesh_notes notes;
        prepare(&mesh, &notes);
        assert_int_equal(notes.flipped, turned);
        check_sheet(&mesh);
        cml_mesh_clear(&mesh);
    }
}

/* Triangles that each have vertices of their own are welded at equal coordinates, negative zeros included. */
static void welds_a_soup(void **state)
{
    (void)state;
    struct cml_mesh sheet = bumpy_sheet();
    const size_t n = sheet.num_triangles;
    double(*vertex)[3] = malloc(3 * n * sizeof *vertex);
    uint32_t(*triangle)[3] = malloc(n * sizeof *triangle);
    assert_true(vertex && triangle);
    for (uint32_t c = 0; c < 3 * n; c++) {
        memcpy(vertex[c], sheet.vertex[sheet.triangle[c / 3][c % 3]], sizeof *vertex);
        for (int k = 0; k < 3; k++)
            if (vertex[c][k] == 0 && c % 2) vertex[c][k] = -0.0;
        triangle[c / 3][c % 3] = c;
    }
    struct cml_mesh soup = {
        .num_vertices = 3 * n, .num_triangles = n, .vertex = vertex, .triangle = triangle};
    struct cml_mesh_notes notes;
    prepare(&soup, &notes);
    assert_int_equal(soup.num_vertices, sheet.num_vertices);
    assert_int_equal(notes.welded, 3 * n - sheet.num_vertices);
    assert_int_equal(notes.unused, 0);
    check_sheet(&soup);
    cml_mesh_clear(&soup);
    cml_mesh_clear(&sheet);
}

static const double roof[][3] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {1, 1, -1}, {9, 9, 9}};
static const uint32_t roof_faces[][3] = {{0, 4, 1}, {1, 1, 2}, {1, 4, 2}, {2, 4, 3}, {3, 4, 0}};

static void drops_what_is_not_needed(void **state)
{
    (void)state;
    struct cml_mesh mesh = MAKE(roof, roof_faces);
    mesh.slope = copy_of((double[]){1, 2, 3, 4, 5}, 5 * sizeof(double));
    struct cml_mesh_notes notes;
    prepare(&mesh, &notes);
    assert_int_equal(notes.degenerate, 1);
    assert_int_equal(notes.unused, 1);
    assert_int_equal(notes.flipped, 0);
    assert_int_equal(mesh.num_vertices, 5);
    assert_int_equal(mesh.num_triangles, 4);
    const double slopes[4] = {1, 3, 4, 5};
    const uint32_t border[4] = {0, 3, 2, 1};
    assert_memory_equal(mesh.slope, slopes, sizeof slopes);
    assert_memory_equal(mesh.border, border, sizeof border);
    cml_mesh_clear(&mesh);
}

static void prepared_stays_as_it_is(void **state)
{
    (void)state;
    struct cml_mesh mesh = bumpy_sheet(), copy;
    struct cml_mesh_notes notes;
    struct cml_error err;
    prepare(&mesh, &notes);
    assert_int_equal(cml_mesh_copy(&mesh, &copy, &err), CML_OK);
    prepare(&copy, &notes);
    assert_int_equal(notes.welded + notes.degenerate + notes.unused + notes.flipped, 0);
    assert_memory_equal(mesh.vertex, copy.vertex, mesh.num_vertices * sizeof *mesh.vertex);
    assert_memory_equal(mesh.triangle, copy.triangle, mesh.num_triangles * sizeof *mesh.triangle);
    assert_memory_equal(mesh.border, copy.border, mesh.num_border * sizeof *mesh.border);
    assert_memory_equal(mesh.vertex_normal, copy.vertex_normal, mesh.num_vertices * sizeof *mesh.vertex);
    cml_mesh_clear(&mesh);
    cml_mesh_clear(&copy);
}

/* The border orients the sheet, whether the sheet leaves the border's plane by an upright wall, outwards
 * over the plane, or inwards under a lid. */
static void orients_by_the_border(void **state)
{
    (void)state;
    const double width[] = {1, 1.5, 0.5}, height[] = {0.3, -0.3};
    for (int w = 0; w < 3; w++) {
        for (int h = 0; h < 2; h++) {
            double vertex[9][3] = {{0}};
            uint32_t triangle[12][3];
            for (uint32_t i = 0; i < 4; i++) {
                const double x = i == 0 || i == 3 ? -1 : 1, y = i < 2 ? -1 : 1;
                memcpy(vertex[i], (double[]){x, y, 0}, sizeof vertex[0]);
                memcpy(vertex[4 + i], (double[]){width[w] * x, width[w] * y, height[h]}, sizeof vertex[0]);
                const uint32_t j = (i + 1) % 4;
                memcpy(triangle[3 * i], (uint32_t[]){i, j, 4 + j}, sizeof triangle[0]);
                memcpy(triangle[3 * i + 1], (uint32_t[]){i, 4 + i, 4 + j}, sizeof triangle[0]);
                memcpy(triangle[3 * i + 2], (uint32_t[]){4 + i, 8, 4 + j}, sizeof triangle[0]);
            }
            vertex[8][2] = height[h];
            struct cml_mesh mesh = MAKE(vertex, triangle);
            prepare(&mesh, NULL);
            for (size_t t = 2; t < 12; t += 3) assert_true(cross_z(&mesh, t) < 0);
            assert_true(mesh.vertex_normal[8][2] == -1);
            cml_mesh_clear(&mesh);
        }
    }
}

static void normals_are_weighted_by_angle(void **state)
{
    (void)state;
    struct cml_mesh mesh = MAKE(roof, roof_faces);
    prepare(&mesh, NULL);
    assert_true(fabs(mesh.vertex_normal[4][0]) < 1e-15 && fabs(mesh.vertex_normal[4][2] + 1) < 1e-15);
    /* corner (0, 0): two slopes of 45 degrees with the angle acos(1 / sqrt 3), the plane with 3 pi / 2 */
    const double angle = acos(sqrt(1.0 / 3)), side = -angle * sqrt(0.5);
    const double up = 2 * side - 1.5 * acos(-1.0), size = sqrt(2 * side * side + up * up);
    assert_true(fabs(mesh.vertex_normal[0][0] - side / size) < 1e-15);
    assert_true(fabs(mesh.vertex_normal[0][1] - side / size) < 1e-15);
    assert_true(fabs(mesh.vertex_normal[0][2] - up / size) < 1e-15);
    cml_mesh_clear(&mesh);
}

static void summarises(void **state)
{
    (void)state;
    struct cml_mesh mesh = MAKE(roof, roof_faces);
    struct cml_mesh_summary summary;
    prepare(&mesh, NULL);
    cml_mesh_summarise(&mesh, &summary);
    assert_true(fabs(summary.z_mean + 1.0 / 3) < 1e-15);
    assert_true(fabs(summary.z_rms - sqrt(1.0 / 6 - 1.0 / 9)) < 1e-15);
    assert_true(summary.peak_to_valley == 1 && summary.slope_rms == 1 && summary.slope_max == 1);
    assert_true(summary.edge_min == sqrt(3.0));
    assert_true(summary.edge_median == 0.5 * (sqrt(3.0) + 2)); /* four edges of each length */
    double z;
    assert_false(cml_mesh_is_flat(&mesh, &z));
    cml_mesh_clear(&mesh);
}

static void flat_and_levelled(void **state)
{
    (void)state;
    const double nearly[][3] = {{0, 0, 3e-10}, {1, 0, -3e-10}, {1, 1, 3e-10}, {0, 1, -3e-10}};
    const uint32_t faces[][3] = {{0, 1, 2}, {0, 3, 2}};
    struct cml_mesh mesh = MAKE(nearly, faces);
    double z = 1;
    prepare(&mesh, NULL);
    assert_true(cml_mesh_is_flat(&mesh, &z) && z == mesh.z_border && fabs(z) < 1e-24);
    cml_mesh_clear(&mesh);
    /* a border level to single precision is levelled, with a note */
    struct cml_mesh single = MAKE(nearly, faces);
    struct cml_mesh_notes notes;
    single.vertex[0][2] = 3e-8;
    prepare(&single, &notes);
    assert_true(cml_mesh_is_flat(&single, &z));
    assert_true(fabs(notes.levelled - 3.03e-8) < 1e-20);
    cml_mesh_clear(&single);
    struct cml_mesh tilted = MAKE(nearly, faces);
    tilted.vertex[0][2] = 3e-6;
    struct cml_error err;
    assert_int_equal(cml_mesh_prepare(&tilted, NULL, NULL, &err), CML_E_INPUT);
    cml_mesh_clear(&tilted);
    /* an upright face so small that levelling the border removes its height */
    const double tiny[][3] = {{0, 0, 0}, {1e12, 0, 0}, {1e12, 1e12, 0}, {0, 1e12, 0}, {0, 5e11, 1}};
    const uint32_t upright[][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}};
    struct cml_mesh lost = MAKE(tiny, upright);
    assert_int_equal(cml_mesh_prepare(&lost, NULL, NULL, &err), CML_E_INPUT);
    assert_string_equal(err.text, "a face has no area once the border is level (expected faces larger than "
                                  "1e-06 of the mesh)");
    cml_mesh_clear(&lost);
}

/* Returns a sheet over a polygon. Its vertices, of random heights, are joined to the first vertex, which
 * lies inside. */
static struct cml_mesh fan(const double (*outline)[2], uint32_t n, bool clockwise)
{
    double(*vertex)[3] = calloc(n + 1, sizeof *vertex);
    uint32_t(*triangle)[3] = calloc(n, sizeof *triangle);
    assert_true(vertex && triangle);
    for (uint32_t i = 0; i < n; i++) {
        memcpy(vertex[i + 1], outline[i], sizeof outline[i]);
        vertex[i + 1][2] = 0.1 * outline[i][0] + 1e-4 * (double)random_below(1000);
        triangle[i][clockwise ? 1 : 2] = i + 1;
        triangle[i][clockwise ? 2 : 1] = (i + 1) % n + 1;
    }
    return (struct cml_mesh){
        .num_vertices = n + 1, .num_triangles = n, .vertex = vertex, .triangle = triangle};
}

/* Adds a skirt and checks that the outline is covered without folds: all triangles face up, and their
 * areas add up to that of the outline. */
static void expect_skirt(struct cml_mesh *mesh, uint32_t n, double width)
{
    struct cml_mesh_notes notes;
    mesh->skirt = width;
    prepare(mesh, &notes);
    assert_int_equal(notes.skirt, 2 * n);
    assert_int_equal(mesh->num_border, n);
    double area = 0;
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        assert_true(cross_z(mesh, t) < 0);
        area += 0.5 * cross_z(mesh, t);
    }
    assert_true(fabs(area / border_area(mesh) - 1) < 1e-12);
    for (size_t i = 0; i < n; i++) {
        const double *p = mesh->vertex[mesh->border[i]];
        assert_true(p[2] == mesh->z_border);
        double nearest = INFINITY;
        for (uint32_t k = 1; k <= n; k++)
            nearest = fmin(nearest, hypot(mesh->vertex[k][0] - p[0], mesh->vertex[k][1] - p[1]));
        assert_true(nearest > 0.8 * width && nearest < 2.001 * width);
    }
}

/* Makes a rectangle of 2 x 1 with `side` edges to a side, counter-clockwise around (0, 0). */
static uint32_t rectangle(uint32_t side, double (*outline)[2])
{
    for (uint32_t i = 0; i < 4 * side; i++) {
        const double t = (double)(i % side) / side,
                     corner[5][2] = {{-1, -.5}, {1, -.5}, {1, .5}, {-1, .5}, {-1, -.5}};
        for (int k = 0; k < 2; k++)
            outline[i][k] = corner[i / side][k] + t * (corner[i / side + 1][k] - corner[i / side][k]);
    }
    return 4 * side;
}

static void a_rectangle_gets_a_skirt_of_even_width(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 12; i++) {
        const uint32_t side[] = {1, 2, 7, 100, 30, 30}, n = 4 * side[i % 6];
        const double width = (const double[]){0.1, 0.3, 0.01}[i % 3];
        double outline[400][2];
        struct cml_mesh mesh =
            (rectangle(side[i % 6], outline), fan((const double(*)[2])outline, n, i % 2 == 1));
        expect_skirt(&mesh, n, width);
        assert_true(fabs(border_area(&mesh) + (2 + 2 * width) * (1 + 2 * width)) < 1e-12);
        assert_true(fabs(mesh.upper[0] - 1 - width) < 1e-14 && fabs(mesh.lower[1] + 0.5 + width) < 1e-14);
        cml_mesh_clear(&mesh);
    }
}

/* The skirt leads to the mean height over the border's length, not over its vertices. One of four sides is
 * divided, so the two differ. */
static void a_skirt_leads_to_the_mean_height(void **state)
{
    (void)state;
    const double outline[][2] = {{-1, -1}, {1, -1}, {1, -.9}, {1, .5}, {1, 1}, {-1, 1}};
    struct cml_mesh mesh = fan(outline, 6, false);
    for (int i = 1; i <= 6; i++) mesh.vertex[i][2] = outline[i - 1][0] > 0 ? -4 : 0;
    expect_skirt(&mesh, 6, 0.25);
    assert_true(fabs(mesh.z_border + 2) < 1e-15);
    cml_mesh_clear(&mesh);
}

/* An outline gets a skirt if it has waves shorter and longer than the skirt's width, or random steps
 * between vertices. */
static void a_wavy_outline_gets_a_skirt(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 60; i++) {
        const uint32_t n = 40 + 20 * (i % 10), waves = 3 + i;
        double outline[240][2];
        random_state = i;
        for (uint32_t k = 0; k < n; k++) {
            const double angle = 2 * acos(-1) * k / n, step = 0.1 / n * (double)random_below(1000) / 1000;
            const double r = 1 + 0.2 / waves * sin(waves * angle) + step;
            outline[k][0] = r * cos(angle);
            outline[k][1] = r * sin(angle);
        }
        struct cml_mesh mesh = fan((const double(*)[2])outline, n, i % 2 == 1);
        expect_skirt(&mesh, n, 0.1);
        cml_mesh_clear(&mesh);
    }
}

/* A notch too narrow for a wide skirt makes the skirt meet itself, which is refused. */
static void a_skirt_that_meets_itself_is_refused(void **state)
{
    (void)state;
    double notch[25][2] = {{-1, 1}, {-1, -1}, {1, -1}, {1, 1}};
    for (int i = 0; i <= 20; i++) {
        notch[4 + i][0] = 0.1 - 0.01 * i;
        notch[4 + i][1] = 0.2 + 0.08 * abs(10 - i);
    }
    struct cml_mesh mesh = fan((const double(*)[2])notch, 25, false);
    struct cml_error err;
    mesh.skirt = 0.15;
    assert_int_equal(cml_mesh_prepare(&mesh, NULL, NULL, &err), CML_E_INPUT);
    assert_non_null(strstr(err.text, "the skirt's edge meets itself at ("));
    assert_non_null(
        strstr(err.text, "expected another skirt= than 0.15 cm, or a mesh with a smoother border"));
    cml_mesh_clear(&mesh);
    struct cml_mesh narrow = fan((const double(*)[2])notch, 25, false);
    expect_skirt(&narrow, 25, 0.01);
    cml_mesh_clear(&narrow);
}

static void an_upright_border_gets_no_skirt(void **state)
{
    (void)state;
    const double upright[][2] = {{-1, -1}, {1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    struct cml_mesh mesh = fan(upright, 5, false);
    struct cml_error err;
    mesh.skirt = 0.1;
    mesh.vertex[3][2] = -5;
    assert_int_equal(cml_mesh_prepare(&mesh, NULL, NULL, &err), CML_E_INPUT);
    assert_non_null(strstr(err.text, "the border meets itself on the edge that begins at (1, -1, height"));
    cml_mesh_clear(&mesh);
}

static void a_level_border_needs_no_skirt(void **state)
{
    (void)state;
    struct cml_mesh mesh = bumpy_sheet();
    struct cml_mesh_notes notes;
    mesh.skirt = 0.15;
    prepare(&mesh, &notes);
    assert_int_equal(notes.skirt, 0);
    check_sheet(&mesh);
    cml_mesh_clear(&mesh);
}

static void messages_without_a_file(void **state)
{
    (void)state;
    struct cml_error err;
    struct cml_mesh mesh = MAKE(roof, roof_faces);
    mesh.triangle[2][1] = 6;
    assert_int_equal(cml_mesh_prepare(&mesh, NULL, NULL, &err), CML_E_INPUT);
    assert_string_equal(err.text, "a face uses vertex 7 (expected 1 to 6)");
    mesh.num_triangles = 0;
    const struct cml_mesh_source source = {.path = "boundary 2"};
    assert_int_equal(cml_mesh_prepare(&mesh, &source, NULL, &err), CML_E_INPUT);
    assert_string_equal(err.text, "boundary 2: the mesh has no faces");
    mesh.vertex[3][1] = NAN;
    assert_int_equal(cml_mesh_prepare(&mesh, &source, NULL, &err), CML_E_INPUT);
    assert_string_equal(err.text, "boundary 2: vertex 4 is too large (expected coordinates up to 1e+30 cm)");
    cml_mesh_clear(&mesh);
    assert_null(mesh.vertex);
}

/* A sheet scaled by 2^40 or 2^-40 has the same topology and, bit by bit, the same normals. */
static void knows_no_absolute_length(void **state)
{
    (void)state;
    struct cml_mesh reference = bumpy_sheet();
    prepare(&reference, NULL);
    for (int power = -40; power <= 40; power += 80) {
        struct cml_mesh mesh = bumpy_sheet();
        for (size_t i = 0; i < 3 * mesh.num_vertices; i++)
            mesh.vertex[i / 3][i % 3] = ldexp(mesh.vertex[i / 3][i % 3], power);
        prepare(&mesh, NULL);
        assert_memory_equal(mesh.triangle, reference.triangle, mesh.num_triangles * sizeof *mesh.triangle);
        assert_memory_equal(mesh.vertex_normal, reference.vertex_normal,
                            mesh.num_vertices * sizeof *mesh.vertex_normal);
        cml_mesh_clear(&mesh);
    }
    cml_mesh_clear(&reference);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(orients_any_winding),
        cmocka_unit_test(welds_a_soup),
        cmocka_unit_test(drops_what_is_not_needed),
        cmocka_unit_test(prepared_stays_as_it_is),
        cmocka_unit_test(orients_by_the_border),
        cmocka_unit_test(normals_are_weighted_by_angle),
        cmocka_unit_test(summarises),
        cmocka_unit_test(flat_and_levelled),
        cmocka_unit_test(a_rectangle_gets_a_skirt_of_even_width),
        cmocka_unit_test(a_skirt_leads_to_the_mean_height),
        cmocka_unit_test(a_wavy_outline_gets_a_skirt),
        cmocka_unit_test(a_skirt_that_meets_itself_is_refused),
        cmocka_unit_test(an_upright_border_gets_no_skirt),
        cmocka_unit_test(a_level_border_needs_no_skirt),
        cmocka_unit_test(messages_without_a_file),
        cmocka_unit_test(knows_no_absolute_length),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
