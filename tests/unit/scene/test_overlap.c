/* Tests of the check that boundaries do not overlap: planes, radial fields and meshes, against each other
 * and against themselves. SPDX-License-Identifier: MIT */
#include "scene/overlap_radial.h"
#include "scene/overlap_sheet.h"
#include "scene/radial.h"
#include "scene/scene.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static uint64_t random_state = 88172645463325252u;

static double draw(void)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return (double)(random_state >> 11) * 0x1p-53;
}

/* Height of a surface; positive is up, as in files. */
typedef double height_function(double x, double y);

static double flat(double x, double y)
{
    (void)x, (void)y;
    return 0.0;
}

/* Returns the height of a pyramid: 1 in the middle, 0 on the border of [-1, 1]^2. */
static double pyramid(double x, double y)
{
    return 1.0 - fmax(fabs(x), fabs(y));
}

static double hill(double x, double y)
{
    return 0.3 * pyramid(x, y);
}

static double pit(double x, double y)
{
    return -0.3 * pyramid(x, y);
}

static double rough(double x, double y)
{
    return fabs(x) < 0.999 && fabs(y) < 0.999 ? 0.2 * (draw() - 0.5) : 0.0;
}

static struct cml_mesh prepare(struct cml_mesh mesh)
{
    struct cml_mesh_notes notes;
    struct cml_error err = {CML_OK, ""};
    const cml_status status = cml_mesh_prepare(&mesh, NULL, &notes, &err);
    assert_string_equal(err.text, "");
    assert_int_equal(status, CML_OK);
    return mesh;
}

/* Returns a square [-1, 1]^2 of n x n cells with two triangles each, shifted by (x, y). */
static struct cml_mesh sheet(size_t n, double x, double y, height_function *height)
{
    struct cml_mesh mesh = {.num_vertices = (n + 1) * (n + 1), .num_triangles = 2 * n * n};
    mesh.vertex = calloc(mesh.num_vertices, sizeof *mesh.vertex);
    mesh.triangle = calloc(mesh.num_triangles, sizeof *mesh.triangle);
    for (size_t i = 0; i < mesh.num_vertices; i++) {
        const double u = 2.0 * (double)(i % (n + 1)) / (double)n - 1.0;
        const double v = 2.0 * (double)(i / (n + 1)) / (double)n - 1.0;
        mesh.vertex[i][0] = u + x;
        mesh.vertex[i][1] = v + y;
        mesh.vertex[i][2] = -height(u, v);
    }
    for (size_t c = 0; c < n * n; c++) {
        const uint32_t a = (uint32_t)(c / n * (n + 1) + c % n), b = a + 1;
        const uint32_t d = a + (uint32_t)n + 1, e = d + 1;
        memcpy(mesh.triangle[2 * c], (const uint32_t[3]){a, e, b}, sizeof *mesh.triangle);
        memcpy(mesh.triangle[2 * c + 1], (const uint32_t[3]){a, d, e}, sizeof *mesh.triangle);
    }
    return prepare(mesh);
}

/* Returns a profile in x, z that is pulled along y from -1 to 1 in `n` strips. Its ends are open, so it is
 * no boundary; it serves cml_sheet_against_itself alone, which accepts open ends. */
static struct cml_mesh pulled(size_t points, const double (*profile)[2], size_t n)
{
    struct cml_mesh mesh = {.num_vertices = points * (n + 1), .num_triangles = 2 * (points - 1) * n};
    mesh.vertex = calloc(mesh.num_vertices, sizeof *mesh.vertex);
    mesh.triangle = calloc(mesh.num_triangles, sizeof *mesh.triangle);
    for (size_t i = 0; i < mesh.num_vertices; i++) {
        mesh.vertex[i][0] = profile[i % points][0];
        mesh.vertex[i][1] = 2.0 * (double)(i / points) / (double)n - 1.0;
        mesh.vertex[i][2] = -profile[i % points][1];
    }
    size_t t = 0;
    for (size_t j = 0; j < n; j++)
        for (size_t i = 0; i + 1 < points; i++) {
            const uint32_t a = (uint32_t)(j * points + i), d = a + (uint32_t)points;
            memcpy(mesh.triangle[t++], (const uint32_t[3]){a, d + 1, a + 1}, sizeof *mesh.triangle);
            memcpy(mesh.triangle[t++], (const uint32_t[3]){a, d, d + 1}, sizeof *mesh.triangle);
        }
    mesh.num_border = 2 * (n + 1);
    mesh.border = calloc(mesh.num_border, sizeof *mesh.border);
    for (size_t j = 0; j <= n; j++) {
        mesh.border[j] = (uint32_t)((j + 1) * points - 1);
        mesh.border[n + 1 + j] = (uint32_t)((n - j) * points);
    }
    return mesh;
}

static struct cml_boundary plane(double z)
{
    return (struct cml_boundary){.form = CML_FORM_PLANE, .z = z, .line = 7};
}

static struct cml_boundary radial(double z, int n, double *r, double *h)
{
    return (struct cml_boundary){.form = CML_FORM_RADIAL, .z = z, .line = 7, .radial = {n, r, h}};
}

static struct cml_boundary mesh(double z, struct cml_mesh made)
{
    return (struct cml_boundary){.form = CML_FORM_MESH, .z = z, .mesh = made, .line = 7};
}

/* Expects this message for n boundaries; NULL: no overlap. */
static void expect(int n, struct cml_boundary *boundaries, const char *message)
{
    char file[] = "a.mci";
    struct cml_error err = {CML_OK, ""};
    const struct cml_scene scene = {.file = file, .num_layers = n - 1, .boundaries = boundaries};
    const cml_status status = cml_scene_check_overlap(&scene, &err);
    char *expected = strstr(err.text, " (expected boundaries that neither cross nor touch)");
    if (expected) *expected = '\0';
    assert_string_equal(err.text, message ? message : "");
    assert_int_equal(status, message ? CML_E_INPUT : CML_OK);
    for (int i = 0; i < n; i++) cml_mesh_clear(&boundaries[i].mesh);
}

static void expect_two(struct cml_boundary a, struct cml_boundary b, const char *message)
{
    struct cml_boundary both[] = {a, b};
    expect(2, both, message);
}

static void test_planes(void **state)
{
    (void)state;
    struct cml_boundary stack[] = {plane(0.0), plane(0.1), plane(0.1), plane(0.5)};
    expect(4, stack, NULL);
    double r[] = {0.0, 1.0}, high[] = {0.2, 0.2}, low[] = {0.1, 0.1};
    expect_two(plane(0.0), radial(0.1, 2, r, low), NULL); /* a flat field is a plane, and planes may touch */
    expect_two(plane(0.0), radial(0.1, 2, r, high),
               "a.mci:7: boundaries 0 and 1 cross at (0 0 0) cm: boundary 0 reaches 0.1 cm below boundary 1");
    expect_two(plane(0.0), mesh(0.1, sheet(3, 0.0, 0.0, flat)), NULL);
    expect_two(plane(0.1), mesh(0.1, sheet(3, 0.0, 0.0, flat)), NULL);
}

static void test_fields(void **state)
{
    (void)state;
    double r[] = {0.0, 0.1, 0.2}, h[] = {0.0, -0.07, 0.0}, up[] = {0.0, 0.05, 0.0}, tip[] = {0.05, 0.0, 0.0};
    double r_fine[] = {0.0, 0.1, 0.15, 0.2}, h_fine[] = {0.0, 0.0, 0.02, 0.0};
    expect_two(radial(0.0, 3, r, h), plane(0.08), NULL);
    expect_two(
        radial(0.0, 3, r, h), plane(0.05),
        "a.mci:7: boundaries 0 and 1 cross at (0.1 0 0.07) cm: boundary 0 reaches 0.02 cm below boundary 1");
    expect_two(plane(0.0), radial(0.05, 3, r, up), "a.mci:7: boundaries 0 and 1 touch at (0.1 0 0) cm");
    expect_two(plane(0.0), radial(0.05, 3, r, tip), "a.mci:7: boundaries 0 and 1 touch at (0 0 0) cm");
    /* a ring of the lower field between rings of the upper one decides: 0.05 against 0.035 */
    expect_two(radial(0.0, 3, r, h), radial(0.075, 4, r_fine, h_fine), NULL);
    expect_two(
        radial(0.0, 3, r, h), radial(0.05, 4, r_fine, h_fine),
        "a.mci:7: boundaries 0 and 1 cross at (0.1 0 0.07) cm: boundary 0 reaches 0.02 cm below boundary 1");
    /* parallel surfaces do not overlap */
    expect_two(radial(0.0, 3, r, h), radial(1e-3, 3, r, h), NULL);
    expect_two(radial(0.0, 3, r, h), radial(0.0, 3, r, h), "a.mci:7: boundaries 0 and 1 touch at (0 0 0) cm");
    struct cml_boundary thin[] = {radial(0.0, 3, r, h), radial(0.01, 3, r, h), plane(0.05)};
    expect(
        3, thin,
        "a.mci:7: boundaries 1 and 2 cross at (0.1 0 0.08) cm: boundary 1 reaches 0.03 cm below boundary 2");
    struct cml_boundary skip[] = {radial(0.0, 3, r, h), plane(0.08), plane(0.09), radial(0.1, 3, r, up)};
    expect(
        4, skip,
        "a.mci:7: boundaries 2 and 3 cross at (0.1 0 0.09) cm: boundary 2 reaches 0.04 cm below boundary 3");
}

static void test_mesh_and_plane(void **state)
{
    (void)state;
    expect_two(plane(0.0), mesh(0.31, sheet(4, 0.0, 0.0, hill)), NULL);
    expect_two(
        plane(0.0), mesh(0.25, sheet(4, 0.0, 0.0, hill)),
        "a.mci:7: boundaries 0 and 1 cross at (0 0 0) cm: boundary 0 reaches 0.05 cm below boundary 1");
    expect_two(
        mesh(0.0, sheet(4, 0.0, 0.0, pit)), plane(0.25),
        "a.mci:7: boundaries 0 and 1 cross at (0 0 0.3) cm: boundary 0 reaches 0.05 cm below boundary 1");
    expect_two(mesh(0.0, sheet(4, 0.0, 0.0, hill)), plane(0.0),
               "a.mci:7: boundaries 0 and 1 touch at (-1 -1 0) cm");
}

/* A field that passes between the vertices of a mesh is still found to overlap. */
static void test_mesh_and_field(void **state)
{
    (void)state;
    double r[] = {0.0, 0.3, 0.45, 0.6}, spike[] = {0.0, 0.0, 0.2, 0.0};
    expect_two(mesh(0.0, sheet(1, 0.0, 0.0, flat)), radial(0.25, 4, r, spike), NULL);
    expect_two(mesh(0.0, sheet(2, 0.0, 0.0, pit)), radial(0.25, 4, r, spike),
               "a.mci:7: boundaries 0 and 1 cross at (-0.318198 -0.318198 0.204541) cm: boundary 0 "
               "reaches 0.154541 cm below boundary 1");
    /* beyond the footprint the outer plane counts */
    double far[] = {0.0, 2.0, 2.5, 3.0};
    expect_two(
        mesh(0.1, sheet(2, 0.0, 0.0, hill)), radial(0.25, 4, far, spike),
        "a.mci:7: boundaries 0 and 1 cross at (2.5 0 0.1) cm: boundary 0 reaches 0.05 cm below boundary 1");
    expect_two(mesh(0.1, sheet(2, 2.5, 0.0, hill)), radial(0.301, 4, far, spike), NULL);
}

/* Returns the least gap between a mesh and a field, over a fine grid on every triangle and around the
 * mesh. */
static double least_gap(const struct cml_mesh *mesh, double z, const struct cml_radial_surface *field)
{
    double least = INFINITY;
    for (size_t t = 0; t < mesh->num_triangles; t++)
        for (int i = 0; i <= 60; i++)
            for (int j = 0; i + j <= 60; j++) {
                const double w[3] = {i / 60.0, j / 60.0, (60 - i - j) / 60.0};
                double p[3] = {0.0, 0.0, z};
                for (int k = 0; k < 9; k++)
                    p[k % 3] += w[k / 3] * mesh->vertex[mesh->triangle[t][k / 3]][k % 3];
                least = fmin(least, field->z - cml_radial_height(field->radial, hypot(p[0], p[1])) - p[2]);
            }
    return least;
}

static void test_field_against_dense_sampling(void **state)
{
    (void)state;
    for (int round = 0; round < 30; round++) {
        struct cml_mesh made = sheet(3, 0.3 * draw(), 0.3 * draw(), rough);
        struct cml_footprint *footprint;
        struct cml_error err;
        double r[8] = {0.0}, h[8];
        for (int i = 0; i < 8; i++) {
            if (i > 0) r[i] = r[i - 1] + 0.02 + 0.1 * draw();
            h[i] = 0.3 * draw();
        }
        const struct cml_radial rings = {8, r, h};
        const struct cml_radial_surface field = {&rings, 0.5};
        struct cml_closest closest = {.gap = INFINITY};
        assert_int_equal(cml_footprint_create(&made, &footprint, &err), CML_OK);
        cml_radial_against_mesh(&field, &made, footprint, 0.0, true, &closest);
        const double sampled = least_gap(&made, 0.0, &field);
        assert_true(closest.gap <= sampled + 1e-15);
        assert_true(closest.gap > sampled - 0.05); /* the grid misses the minimum by a little */
        const double height = cml_radial_height(&rings, hypot(closest.at[0], closest.at[1]));
        assert_true(fabs(0.5 - height - closest.at[2] - closest.gap) < 1e-15);
        cml_footprint_free(footprint);
        cml_mesh_clear(&made);
    }
}

static void test_meshes(void **state)
{
    (void)state;
    expect_two(mesh(0.0, sheet(6, 0.0, 0.0, hill)), mesh(0.01, sheet(6, 0.0, 0.0, hill)), NULL);
    expect_two(
        mesh(0.0, sheet(6, 0.0, 0.0, pit)), mesh(0.01, sheet(7, 0.1, 0.0, flat)),
        "a.mci:7: boundaries 0 and 1 cross at (0 0 0.3) cm: boundary 0 reaches 0.29 cm below boundary 1");
    /* equal grids: every crossing passes exactly through edges */
    expect_two(
        mesh(0.0, sheet(4, 0.0, 0.0, pit)), mesh(0.25, sheet(4, 0.0, 0.0, hill)),
        "a.mci:7: boundaries 0 and 1 cross at (0 0 0.3) cm: boundary 0 reaches 0.35 cm below boundary 1");
    expect_two(
        mesh(0.0, sheet(2, 0.0, 0.0, hill)), mesh(0.0, sheet(2, 3.0, 0.0, pit)),
        "a.mci:7: boundaries 0 and 1 touch at (4 1 0) cm: the outer plane of boundary 0 and the outer plane "
        "of boundary 1");
    expect_two(
        mesh(0.02, sheet(2, 0.0, 0.0, hill)), mesh(0.0, sheet(2, 3.0, 0.0, pit)),
        "a.mci:7: boundaries 0 and 1 cross at (-1 -1 0.02) cm: boundary 0 reaches 0.02 cm below boundary 1");
    /* a peak of one mesh pierces the outer plane of the other */
    expect_two(mesh(0.0, sheet(2, 0.0, 0.0, hill)), mesh(0.2, sheet(2, 5.0, 0.0, hill)),
               "a.mci:7: boundaries 0 and 1 cross at (5 0 0) cm: boundary 0 reaches 0.1 cm below boundary 1");
    /* the hills are far apart: nothing meets */
    expect_two(mesh(0.0, sheet(2, 0.0, 0.0, pit)), mesh(0.02, sheet(2, 0.0, 0.0, pit)), NULL);
}

/* Returns the depth of a sheet at (x, y); NAN outside of it. */
static double depth_at(const struct cml_mesh *made, double x, double y)
{
    for (size_t t = 0; t < made->num_triangles; t++) {
        const double *v[3];
        double w[3], sum = 0.0;
        for (int k = 0; k < 3; k++) v[k] = made->vertex[made->triangle[t][k]];
        for (int k = 0; k < 3; k++) {
            const double *a = v[(k + 1) % 3], *b = v[(k + 2) % 3];
            w[k] = (a[0] - x) * (b[1] - y) - (a[1] - y) * (b[0] - x);
            sum += w[k];
        }
        if (fmin(fmin(w[0] / sum, w[1] / sum), w[2] / sum) < -1e-12) continue;
        return (w[0] * v[0][2] + w[1] * v[1][2] + w[2] * v[2][2]) / sum;
    }
    return NAN;
}

static double gap_at(const struct cml_mesh *a, const struct cml_mesh *b, double x, double y)
{
    const double gap = depth_at(b, x, y) - depth_at(a, x, y);
    return isnan(gap) ? INFINITY : gap;
}

/* Returns the vertical gap between two edges at the point where they cross, seen from above. */
static double gap_at_edges(const struct cml_mesh *a, const struct cml_mesh *b, size_t i, size_t j)
{
    const double *p = a->vertex[a->triangle[i / 3][i % 3]], *q = a->vertex[a->triangle[i / 3][(i + 1) % 3]];
    const double *r = b->vertex[b->triangle[j / 3][j % 3]], *s = b->vertex[b->triangle[j / 3][(j + 1) % 3]];
    const double bend = (q[0] - p[0]) * (s[1] - r[1]) - (q[1] - p[1]) * (s[0] - r[0]);
    const double t = ((r[0] - p[0]) * (s[1] - r[1]) - (r[1] - p[1]) * (s[0] - r[0])) / bend;
    const double u = ((r[0] - p[0]) * (q[1] - p[1]) - (r[1] - p[1]) * (q[0] - p[0])) / bend;
    if (!(t >= 0.0 && t <= 1.0 && u >= 0.0 && u <= 1.0)) return INFINITY;
    return gap_at(a, b, p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]));
}

/* Returns the least gap between two piecewise linear sheets. It occurs at a vertex of either sheet or
 * where edges cross. */
static double least_gap_of_meshes(const struct cml_mesh *a, const struct cml_mesh *b)
{
    double least = INFINITY;
    for (size_t i = 0; i < a->num_vertices; i++)
        least = fmin(least, gap_at(a, b, a->vertex[i][0], a->vertex[i][1]));
    for (size_t i = 0; i < b->num_vertices; i++)
        least = fmin(least, gap_at(a, b, b->vertex[i][0], b->vertex[i][1]));
    for (size_t i = 0; i < 3 * a->num_triangles; i++)
        for (size_t j = 0; j < 3 * b->num_triangles; j++) least = fmin(least, gap_at_edges(a, b, i, j));
    return least;
}

/* Two rough sheets are moved together until they almost touch, and until they just cross. */
static void test_meshes_against_all_pairs(void **state)
{
    (void)state;
    for (int round = 0; round < 20; round++) {
        struct cml_boundary both[] = {mesh(0.0, sheet(4, 0.0, 0.0, rough)),
                                      mesh(0.0, sheet(round % 2 ? 4 : 5, 0.0, 0.0, rough))};
        const double least = least_gap_of_meshes(&both[0].mesh, &both[1].mesh);
        assert_true(least < 0.0);
        char file[] = "a.mci";
        struct cml_error err;
        const struct cml_scene scene = {.file = file, .num_layers = 1, .boundaries = both};
        both[1].z = -least + 1e-12;
        assert_int_equal(cml_scene_check_overlap(&scene, &err), CML_OK);
        both[1].z = -least - 1e-12;
        assert_int_equal(cml_scene_check_overlap(&scene, &err), CML_E_INPUT);
        for (int i = 0; i < 2; i++) cml_mesh_clear(&both[i].mesh);
    }
}

/* Two ridges at right angles meet where their long edges cross, between vertices. */
static void test_edges_cross_between_vertices(void **state)
{
    (void)state;
    struct cml_mesh made[2];
    for (int i = 0; i < 2; i++) {
        /* a roof over the rectangle |x| <= 3, |y| <= 1 (i = 0, upside down) or over |x| <= 1, |y| <= 3 */
        const double sign = i == 0 ? -1.0 : 1.0;
        const double corner[6][3] = {{-3, -1, 0}, {3, -1, 0},   {3, 1, 0},
                                     {-3, 1, 0},  {-2, 0, 0.5}, {2, 0, 0.5}};
        const uint32_t triangle[6][3] = {{0, 1, 5}, {0, 5, 4}, {2, 3, 4}, {2, 4, 5}, {1, 2, 5}, {3, 0, 4}};
        made[i] = (struct cml_mesh){.num_vertices = 6, .num_triangles = 6};
        made[i].vertex = calloc(6, sizeof *made[i].vertex);
        made[i].triangle = malloc(sizeof triangle);
        memcpy(made[i].triangle, triangle, sizeof triangle);
        for (int k = 0; k < 6; k++) {
            made[i].vertex[k][0] = corner[k][i];
            made[i].vertex[k][1] = corner[k][1 - i];
            made[i].vertex[k][2] = -sign * corner[k][2];
        }
        made[i] = prepare(made[i]);
    }
    struct cml_boundary both[] = {mesh(0.0, made[0]), mesh(0.9, made[1])};
    char file[] = "a.mci";
    struct cml_error err = {CML_OK, ""};
    const struct cml_scene scene = {.file = file, .num_layers = 1, .boundaries = both};
    assert_int_equal(cml_scene_check_overlap(&scene, &err), CML_E_INPUT);
    assert_non_null(strstr(err.text, "a.mci:7: boundaries 0 and 1 cross at ("));
    assert_non_null(strstr(err.text, ") cm: triangle "));
    both[1].z = 1.01;
    assert_int_equal(cml_scene_check_overlap(&scene, &err), CML_OK);
    both[1].z = 1.0;
    assert_int_equal(cml_scene_check_overlap(&scene, &err), CML_E_INPUT);
    assert_non_null(strstr(err.text, "a.mci:7: boundaries 0 and 1 touch at (0 0 0.5) cm: triangle "));
    for (int i = 0; i < 2; i++) cml_mesh_clear(&both[i].mesh);
}

static struct cml_sheet_overlap check_self(struct cml_mesh *made)
{
    struct cml_sheet sheet_made;
    struct cml_sheet_overlap meeting;
    struct cml_error err;
    assert_int_equal(cml_sheet_create(made, 0.0, &sheet_made, &err), CML_OK);
    cml_sheet_against_itself(&sheet_made, &meeting);
    cml_sheet_clear(&sheet_made);
    cml_mesh_clear(made);
    return meeting;
}

static void test_self(void **state)
{
    (void)state;
    /* a mushroom's profile, and one whose cap reaches out over the border */
    const double fine[][2] = {{-2, 0},  {-0.5, 0.01}, {-0.5, 1},   {-1, 1.2}, {0, 2},
                              {1, 1.2}, {0.5, 1},     {0.5, 0.01}, {2, 0}};
    const double loop[][2] = {{-2, 0}, {1, 0.5}, {0.5, 2}, {-0.5, 2}, {-1, 0.5}, {2, 0}};
    const double under[][2] = {{-2, 0}, {-1, 0.01}, {-1, 1}, {-3, 1}, {-3, 2}, {0, 2}, {2, 0}};
    const double poke[][2] = {{-2, 0}, {-1, 1}, {-3, 1}, {-3, -1}, {-3.5, -1}, {-3.5, 2}, {0, 2}, {2, 0}};
    struct cml_mesh made = pulled(9, fine, 3);
    assert_int_equal(check_self(&made).contact, CML_APART);
    made = pulled(7, under, 3);
    assert_int_equal(check_self(&made).contact, CML_APART);
    made = pulled(6, loop, 3);
    struct cml_sheet_overlap meeting = check_self(&made);
    assert_int_equal(meeting.contact, CML_CROSS);
    assert_true(fabs(meeting.at[0]) < 1e-15 && fabs(meeting.at[2] + 1.0 / 3.0) < 1e-15);
    made = pulled(8, poke, 3);
    meeting = check_self(&made);
    assert_int_equal(meeting.contact, CML_CROSS);
    assert_int_equal(meeting.triangle[1], CML_SHEET_OUTER_PLANE);
    assert_true(meeting.at[2] == 0.0 && meeting.at[0] <= -3.0);
}

static void test_rough_sheets_do_not_cross_themselves(void **state)
{
    (void)state;
    struct cml_mesh made = sheet(40, 0.0, 0.0, rough);
    assert_int_equal(check_self(&made).contact, CML_APART);
    made = sheet(40, 0.1, 0.3, hill); /* tilted planes: neighbours are exactly or nearly coplanar */
    assert_int_equal(check_self(&made).contact, CML_APART);
    made = sheet(40, 0.0, 0.0, flat);
    assert_int_equal(check_self(&made).contact, CML_APART);
}

/* A hill crosses itself: one vertex of its left flank is pulled through it and out of the right flank. */
static void test_message_of_a_crossing_sheet(void **state)
{
    (void)state;
    struct cml_mesh made = sheet(6, 0.0, 0.0, hill);
    made.vertex[3 * 7 + 1][0] = 0.9;
    char file[] = "a.mci";
    struct cml_error err;
    struct cml_boundary both[] = {mesh(0.0, prepare(made)), plane(1.0)};
    const struct cml_scene scene = {.file = file, .num_layers = 1, .boundaries = both};
    assert_int_equal(cml_scene_check_overlap(&scene, &err), CML_E_INPUT);
    assert_non_null(strstr(err.text, "a.mci:7: boundary 0 crosses itself at ("));
    assert_non_null(strstr(err.text, ") cm: triangles "));
    cml_mesh_clear(&both[0].mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_planes),
        cmocka_unit_test(test_fields),
        cmocka_unit_test(test_mesh_and_plane),
        cmocka_unit_test(test_mesh_and_field),
        cmocka_unit_test(test_field_against_dense_sampling),
        cmocka_unit_test(test_meshes),
        cmocka_unit_test(test_meshes_against_all_pairs),
        cmocka_unit_test(test_edges_cross_between_vertices),
        cmocka_unit_test(test_self),
        cmocka_unit_test(test_rough_sheets_do_not_cross_themselves),
        cmocka_unit_test(test_message_of_a_crossing_sheet),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
