/* Tests of tessellating radial profiles (cones) into meshes: volume, distance from the cones, slopes,
 * shapes of triangles. SPDX-License-Identifier: MIT */
#include "surface/tessellate.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define PI 3.14159265358979323846
#define COUNT(array) ((int)(sizeof(array) / sizeof(array)[0]))

static const struct cml_tessellation standard = {1e-3, CML_NORMALS_ANALYTIC, false};

static struct cml_mesh make(const struct cml_radial *radial, const struct cml_tessellation *options)
{
    struct cml_mesh mesh;
    struct cml_error err = {CML_OK, ""};
    const cml_status status = cml_tessellate(radial, options, NULL, &mesh, &err);
    assert_string_equal(err.text, "");
    assert_int_equal(status, CML_OK);
    return mesh;
}

static void corners(const struct cml_mesh *mesh, size_t t, const double *v[3])
{
    for (int k = 0; k < 3; k++) v[k] = mesh->vertex[mesh->triangle[t][k]];
}

/* Returns the area of a triangle seen from above; positive if it faces up. */
static double plan_area(const double *const v[3])
{
    return -0.5 * ((v[1][0] - v[0][0]) * (v[2][1] - v[0][1]) - (v[1][1] - v[0][1]) * (v[2][0] - v[0][0]));
}

/* Computes the area of the footprint and the volume between the sheet and z = 0 (heights are positive up). */
static void measure(const struct cml_mesh *mesh, double *area, double *volume)
{
    *area = *volume = 0.0;
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        const double *v[3];
        corners(mesh, t, v);
        const double a = plan_area(v);
        assert_true(a > 0.0);
        *area += a;
        *volume -= a * (v[0][2] + v[1][2] + v[2][2]) / 3.0;
    }
}

static double exact_volume(const struct cml_radial *radial)
{
    double volume = 0.0;
    for (int i = 0; i + 1 < radial->n; i++) {
        const double a = radial->r[i], b = radial->r[i + 1], ha = radial->h[i], hb = radial->h[i + 1];
        volume += PI * (b - a) * ((a + b) * 0.5 * (ha + hb) + (b - a) * (hb - ha) / 6.0);
    }
    return volume;
}

/* Returns the radius of the cones at height h; the heights of `radial` must fall strictly. */
static double cone_radius(const struct cml_radial *radial, double h)
{
    int i = 0;
    while (i + 2 < radial->n && h < radial->h[i + 1]) i++;
    const double t = (h - radial->h[i]) / (radial->h[i + 1] - radial->h[i]);
    return radial->r[i] + t * (radial->r[i + 1] - radial->r[i]);
}

/* Returns the largest radial distance between mesh and cones, over a grid of points on every triangle. */
static double largest_deviation(const struct cml_mesh *mesh, const struct cml_radial *radial)
{
    double largest = 0.0;
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        const double *v[3];
        corners(mesh, t, v);
        for (int i = 0; i <= 8; i++)
            for (int j = 0; i + j <= 8; j++) {
                const double w[3] = {i / 8.0, j / 8.0, (8 - i - j) / 8.0};
                double p[3] = {0.0, 0.0, 0.0};
                for (int k = 0; k < 9; k++) p[k % 3] += w[k / 3] * v[k / 3][k % 3];
                largest = fmax(largest, fabs(hypot(p[0], p[1]) - cone_radius(radial, -p[2])));
            }
    }
    return largest;
}

/* Returns the largest ratio of longest edge to least height over all triangles. */
static double worst_shape(const struct cml_mesh *mesh)
{
    double worst = 0.0;
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        const double *v[3];
        double longest = 0.0, u[3], w[3];
        corners(mesh, t, v);
        for (int e = 0; e < 3; e++) {
            const double *a = v[e], *b = v[(e + 1) % 3];
            longest = fmax(longest, sqrt(pow(b[0] - a[0], 2) + pow(b[1] - a[1], 2) + pow(b[2] - a[2], 2)));
        }
        for (int k = 0; k < 3; k++) {
            u[k] = v[1][k] - v[0][k];
            w[k] = v[2][k] - v[0][k];
        }
        const double twice = sqrt(pow(u[1] * w[2] - u[2] * w[1], 2) + pow(u[2] * w[0] - u[0] * w[2], 2) +
                                  pow(u[0] * w[1] - u[1] * w[0], 2));
        worst = fmax(worst, longest * longest / twice);
    }
    return worst;
}

static void test_one_cone(void **state)
{
    (void)state;
    double r[] = {0.0, 0.2}, h[] = {0.05, 0.0};
    const struct cml_radial radial = {2, r, h};
    struct cml_mesh mesh = make(&radial, &standard);
    /* pi^2 / (3 N^2) <= 1e-3 from N = 58 on */
    assert_int_equal(mesh.num_triangles, 64);
    assert_int_equal(mesh.num_vertices, 65);
    assert_int_equal(mesh.num_border, 64);
    assert_int_equal(mesh.normals, CML_NORMALS_ANALYTIC);
    assert_true(mesh.vertex[0][0] == 0.0 && mesh.vertex[0][1] == 0.0 && mesh.vertex[0][2] == -0.05);
    assert_true(mesh.z_border == 0.0);
    double area, volume;
    measure(&mesh, &area, &volume);
    assert_true(fabs(area / (PI * 0.04) - 1.0) < 1e-12);
    assert_true(fabs(volume / exact_volume(&radial) - 1.0) < 1e-12);
    for (size_t t = 0; t < mesh.num_triangles; t++) assert_true(mesh.slope[t] == 0.05 / 0.2);
    cml_mesh_clear(&mesh);
}

/* Rings with equal counts of vertices are similar polygons, so the volume is exact for any radii and
 * heights. */
static void test_volume_of_equal_counts(void **state)
{
    (void)state;
    double r[] = {0.0, 0.9, 0.95, 0.97, 1.1}, h[] = {0.3, -0.1, 0.4, 0.4, 0.2};
    const struct cml_radial radial = {COUNT(r), r, h};
    struct cml_mesh mesh = make(&radial, &standard);
    double area, volume;
    measure(&mesh, &area, &volume);
    assert_int_equal(mesh.num_triangles, 64 * 7);
    assert_true(fabs(area / (PI * 1.21) - 1.0) < 1e-12);
    assert_true(fabs(volume - exact_volume(&radial)) < 1e-12);
    cml_mesh_clear(&mesh);
}

/* Returns 12 rings, wide and narrow, that need different counts. */
static struct cml_radial irregular(double *r, double *h)
{
    const double width[] = {0.01, 0.03, 0.1, 0.02, 0.02, 0.3, 0.04, 0.2, 0.01, 0.015, 0.4, 0.1};
    r[0] = 0.0;
    h[0] = 0.5;
    for (int i = 0; i < COUNT(width); i++) {
        r[i + 1] = r[i] + width[i];
        h[i + 1] = h[i] - width[i] * (i % 3 == 0 ? 2.0 : 0.3);
    }
    return (struct cml_radial){COUNT(width) + 1, r, h};
}

static void test_deviation(void **state)
{
    (void)state;
    double r[16], h[16], last = 0.0;
    const struct cml_radial radial = irregular(r, h);
    for (int inscribed = 0; inscribed < 2; inscribed++)
        for (int i = 0; i < 4; i++) {
            const struct cml_tessellation options = {1e-2 * pow(16.0, -i), CML_NORMALS_FACET, inscribed != 0};
            struct cml_mesh mesh = make(&radial, &options);
            const double allowed = options.tolerance * radial.r[radial.n - 1];
            const double deviation = largest_deviation(&mesh, &radial);
            assert_true(deviation <= allowed * (1 + 1e-9) + 1e-15);
            assert_true(deviation >= 0.1 * allowed); /* the mesh is not finer than needed */
            assert_null(mesh.slope);
            if (i > 1) assert_true(deviation < last / 14.0); /* counts x 4: the error is of second order */
            last = deviation;
            cml_mesh_clear(&mesh);
        }
}

static void test_volume_converges(void **state)
{
    (void)state;
    double r[16], h[16], area, volume;
    const struct cml_radial radial = irregular(r, h);
    struct cml_mesh mesh = make(&radial, &standard);
    measure(&mesh, &area, &volume);
    assert_true(fabs(area / (PI * pow(radial.r[radial.n - 1], 2)) - 1.0) < 1e-12);
    assert_true(fabs(volume / exact_volume(&radial) - 1.0) < 1e-3);
    cml_mesh_clear(&mesh);
}

/* Every triangle has the slope of the interval in which it lies. */
static void test_slopes(void **state)
{
    (void)state;
    double r[16], h[16];
    const struct cml_radial radial = irregular(r, h);
    struct cml_mesh mesh = make(&radial, &standard);
    for (size_t t = 0; t < mesh.num_triangles; t++) {
        const double *v[3];
        corners(&mesh, t, v);
        const double height = -(v[0][2] + v[1][2] + v[2][2]) / 3.0;
        int i = 0;
        while (height < h[i + 1]) i++;
        assert_true(mesh.slope[t] == (h[i] - h[i + 1]) / (r[i + 1] - r[i]));
    }
    cml_mesh_clear(&mesh);
}

/* Vertices at the same azimuth, and mirrored ones, have the same bits. */
static void test_symmetry(void **state)
{
    (void)state;
    double r[] = {0.0, 0.3, 1.0}, h[] = {0.1, 0.2, 0.0};
    const struct cml_radial radial = {3, r, h};
    struct cml_mesh mesh = make(&radial, &standard);
    const size_t n = mesh.num_border, first = mesh.num_vertices - n;
    for (size_t k = 0; k < n; k++) {
        const double *p = mesh.vertex[first + k];
        const double *up = mesh.vertex[first + (n - k) % n], *left = mesh.vertex[first + (n + n / 2 - k) % n];
        const double *turned = mesh.vertex[first + (n + n / 4 - k) % n];
        assert_true(p[0] == up[0] && p[1] == -up[1]);
        assert_true(p[0] == -left[0] && p[1] == left[1]);
        assert_true(p[0] == turned[1] && p[1] == turned[0]);
    }
    assert_true(mesh.vertex[1][1] == 0.0 && mesh.vertex[first][1] == 0.0);
    assert_true(mesh.vertex[1][0] > 0.3 && mesh.vertex[first][0] > 1.0);
    cml_mesh_clear(&mesh);
}

static void test_regular_rings_make_no_needles(void **state)
{
    (void)state;
    enum { N = 101 };
    double r[N], h[N];
    for (int i = 0; i < N; i++) {
        r[i] = 0.01 * i;
        h[i] = 0.02 * cos(20.0 * r[i]);
    }
    const struct cml_radial radial = {N, r, h};
    struct cml_mesh mesh = make(&radial, &standard);
    assert_true(worst_shape(&mesh) < 20.0);
    assert_true(mesh.num_triangles < 20000);
    cml_mesh_clear(&mesh);
}

/* A ring far narrower than its neighbours gets few needle-shaped triangles, not a million triangles. */
static void test_narrow_ring(void **state)
{
    (void)state;
    double r[] = {0.0, 0.5, 0.5001, 1.0}, h[] = {0.1, 0.1, 0.0999, 0.0};
    const struct cml_radial radial = {4, r, h};
    struct cml_mesh mesh = make(&radial, &standard);
    assert_true(mesh.num_triangles > 1000 && mesh.num_triangles < 10000);
    assert_true(worst_shape(&mesh) < 200.0);
    cml_mesh_clear(&mesh);
}

static void test_thousand_rings(void **state)
{
    (void)state;
    enum { N = 1001 };
    static double r[N], h[N];
    for (int i = 1; i < N; i++) {
        r[i] = r[i - 1] + 1e-3 * (1.0 + 0.9 * sin(3.0 * i));
        h[i] = 0.01 * sin(0.1 * i);
    }
    const struct cml_radial radial = {N, r, h};
    const struct cml_tessellation fine = {1e-5, CML_NORMALS_ANALYTIC, false};
    struct cml_mesh mesh = make(&radial, &standard);
    double area, volume;
    measure(&mesh, &area, &volume); /* also: no triangle is folded over */
    assert_true(fabs(area / (PI * r[N - 1] * r[N - 1]) - 1.0) < 1e-12);
    assert_true(mesh.num_triangles < 4000000);
    cml_mesh_clear(&mesh);
    mesh = make(&radial, &fine);
    measure(&mesh, &area, &volume);
    cml_mesh_clear(&mesh);
}

/* Polygons of different counts bulge differently. Rings closer to each other than the bulge must not fold. */
static void test_close_rings_do_not_fold(void **state)
{
    (void)state;
    for (int inscribed = 0; inscribed < 2; inscribed++)
        for (double width = 0.1; width > 1e-5; width *= 0.3) {
            enum { N = 40 };
            double r[N], h[N], area, volume;
            for (int i = 0; i < N; i++) {
                r[i] = i == 0 ? 0.0 : 0.2 + width * i;
                h[i] = 0.0;
            }
            const struct cml_radial radial = {N, r, h};
            const struct cml_tessellation coarse = {0.05, CML_NORMALS_FACET, inscribed != 0};
            struct cml_mesh mesh = make(&radial, &coarse);
            measure(&mesh, &area, &volume);
            cml_mesh_clear(&mesh);
        }
}

static void expect_failure(const struct cml_radial *radial, double tolerance, const char *message)
{
    const struct cml_tessellation options = {tolerance, CML_NORMALS_ANALYTIC, false};
    struct cml_mesh mesh;
    struct cml_error err;
    assert_int_equal(cml_tessellate(radial, &options, NULL, &mesh, &err), CML_E_INPUT);
    assert_string_equal(err.text, message);
    assert_null(mesh.vertex);
}

static void test_refusals(void **state)
{
    (void)state;
    double r[] = {0.0, 0.5, 1.0}, h[] = {0.1, 0.2, 0.0};
    const struct cml_radial radial = {3, r, h}, point = {1, r, h};
    expect_failure(&point, 1e-3, "a radial heightfield needs at least 2 samples to become a mesh");
    expect_failure(&radial, 0.0, "tolerance = 0 (expected a number above 0)");
    expect_failure(&radial, 1e-16,
                   "a boundary needs 536870912 triangles, 175 GiB (expected at most 67108864, or a larger "
                   "--tolerance or "
                   "--mesh-budget, or --boundaries cone)");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_one_cone),
        cmocka_unit_test(test_volume_of_equal_counts),
        cmocka_unit_test(test_deviation),
        cmocka_unit_test(test_volume_converges),
        cmocka_unit_test(test_slopes),
        cmocka_unit_test(test_symmetry),
        cmocka_unit_test(test_regular_rings_make_no_needles),
        cmocka_unit_test(test_narrow_ring),
        cmocka_unit_test(test_thousand_rings),
        cmocka_unit_test(test_close_rings_do_not_fold),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
