/* Tests of random reliefs: every claim of random_relief.h. Slopes are judged by the normals of triangles,
 * correlations by closed forms over many seeds. SPDX-License-Identifier: MIT */
#include "lib/dice.h"
#include "lib/require.h"
#include "scene/heightmap/random_relief.h"

#include <math.h>

static struct cml_heightmap drawn(struct cml_random_relief relief)
{
    struct cml_heightmap map;
    struct cml_error err = {CML_OK, ""};
    require_ok(cml_random_relief_make(&relief, &map, &err), &err);
    return map;
}

/* Sums over the triangles of one period, weighted by area on the plane: heights, squares of gradients, and
 * the share whose gradient is above `steep`. */
struct facets {
    double mean, square, steeper;
};

static struct facets measure_facets(const struct cml_heightmap *map, double steep)
{
    struct cml_mesh mesh;
    struct cml_error err = {CML_OK, ""};
    struct facets sums = {0, 0, 0};
    double area = 0;
    const struct cml_tile_cells cells = {{0, 0}, {map->nx, map->ny}};
    require_ok(cml_tile_sheet(map, &cells, CML_NORMALS_FACET, &mesh, &err), &err);
    for (size_t t = 0; t < mesh.num_triangles; t++) {
        const double *a = mesh.vertex[mesh.triangle[t][0]], *b = mesh.vertex[mesh.triangle[t][1]],
                     *c = mesh.vertex[mesh.triangle[t][2]];
        const double u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]},
                     v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
        const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
        const double weight = fabs(n[2]), slope = hypot(n[0], n[1]) / weight;
        sums.mean -= weight * (a[2] + b[2] + c[2]) / 3;
        sums.square += weight * slope * slope;
        sums.steeper += slope > steep ? weight : 0;
        area += weight;
    }
    cml_mesh_clear(&mesh);
    return (struct facets){sums.mean / area, sums.square / area, sums.steeper / area};
}

static void facets_have_the_slope_asked_for_and_the_mean_0(void **state)
{
    (void)state;
    static const double hursts[] = {0, 0.5, 0.9};
    for (int i = 0; i < 3; i++)
        for (int points = 16; points <= 256; points *= 4) {
            struct cml_heightmap map = drawn((struct cml_random_relief){
                .slope = 0.1 * (1 + i), .length = 0.01, .hurst = hursts[i], .points = points, .seed = 5});
            const struct facets facets = measure_facets(&map, 0);
            const double height = 0.1 * (1 + i) * 0.01;
            assert_near("value", sqrt(facets.square) / (0.1 * (1 + i)), 1, 1e-12);
            assert_near("value", facets.mean / height, 0, 1e-12);
            assert_int_equal(map.nx, points);
            assert_near("value", cml_tile_period(&map, 0), points * 0.001, 1e-12);
            assert_near("value", map.x0 + cml_tile_period(&map, 0) / 2, map.dx / 2, 1e-12);
            cml_heightmap_clear(&map);
        }
}

/* Slopes of a Gaussian surface are distributed as P(t > x) = exp(-x^2 / a^2), where a is the rms gradient. */
static void slopes_are_those_of_a_gaussian_surface(void **state)
{
    (void)state;
    const double a = 0.3;
    for (int k = 1; k <= 3; k++) {
        struct cml_heightmap map =
            drawn((struct cml_random_relief){.slope = a, .length = 1, .points = 512, .seed = 11});
        const double x = 0.5 * k * a, expected = exp(-x * x / (a * a)),
                     found = measure_facets(&map, x).steeper;
        /* the area has some 51^2 correlation areas of pi / 2 L^2 */
        assert_near("value", found, expected, 4.5 * sqrt(expected * (1 - expected) / 1650));
        cml_heightmap_clear(&map);
    }
}

static double correlation_of(const struct cml_heightmap *map, int64_t dx, int64_t dy)
{
    double sum = 0;
    for (int64_t j = 0; j < map->ny; j++)
        for (int64_t i = 0; i < map->nx; i++)
            sum += cml_tile_height(map, i, j) * cml_tile_height(map, i + dx, j + dy);
    return sum / ((double)map->nx * (double)map->ny);
}

/* Expects the autocorrelation at a shift of (dx, dy) samples. It is a ratio of sums over seeds; the spread
 * of the seeds gives its error. */
static void expect_correlation(double hurst, int dx, int dy, double expected)
{
    enum { SEEDS = 24 };
    double sum[2] = {0, 0}, pair[SEEDS][2], rest = 0;
    for (int s = 0; s < SEEDS; s++) {
        struct cml_heightmap map = drawn((struct cml_random_relief){
            .slope = 0.1, .length = 1, .hurst = hurst, .points = 256, .seed = (uint64_t)s});
        pair[s][0] = correlation_of(&map, dx, dy);
        pair[s][1] = correlation_of(&map, 0, 0);
        for (int k = 0; k < 2; k++) sum[k] += pair[s][k];
        cml_heightmap_clear(&map);
    }
    const double ratio = sum[0] / sum[1];
    for (int s = 0; s < SEEDS; s++) rest += pow(pair[s][0] - ratio * pair[s][1], 2);
    const double error = sqrt(rest) / sum[1], z = (ratio - expected) / error;
    if (fabs(z) > 4)
        fail_msg("hurst %g, lag %d %d: %g +- %g, expected %g", hurst, dx, dy, ratio, error, expected);
}

static void the_autocorrelation_is_the_spectrums(void **state)
{
    (void)state;
    expect_correlation(0, 5, 0, exp(-0.25));
    expect_correlation(0, 0, 10, exp(-1));
    expect_correlation(0, 10, 10, exp(-2));
    expect_correlation(0.5, 10, 0, exp(-1));
    expect_correlation(0.5, 12, 9, exp(-1.5));
}

static void what_was_drawn_is_measured(void **state)
{
    (void)state;
    struct cml_drawn_relief measured;
    struct cml_heightmap map =
        drawn((struct cml_random_relief){.slope = 0.2, .length = 0.01, .points = 1024, .seed = 3});
    cml_random_relief_measure(&map, &measured);
    assert_near("value", measured.slope, 0.2, 1e-12);
    assert_near("value", measured.length, 0.01, 3e-4);
    /* a Gaussian spectrum has the rms gradient 2 rms / L */
    assert_near("value", measured.rms, 0.2 * 0.01 / 2, 3e-5);
    cml_heightmap_clear(&map);
}

static void a_seed_is_one_relief(void **state)
{
    (void)state;
    struct cml_random_relief relief = {.slope = 1, .length = 1, .points = 32, .seed = 1};
    struct cml_heightmap one = drawn(relief), again = drawn(relief);
    relief.seed = 2;
    struct cml_heightmap other = drawn(relief);
    assert_memory_equal(one.h, again.h, 32 * 32 * sizeof *one.h);
    assert_true(fabs(correlation_of(&one, 0, 0) / correlation_of(&other, 0, 0) - 1) > 1e-6);
    cml_heightmap_clear(&one);
    cml_heightmap_clear(&again);
    cml_heightmap_clear(&other);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(facets_have_the_slope_asked_for_and_the_mean_0),
        cmocka_unit_test(slopes_are_those_of_a_gaussian_surface),
        cmocka_unit_test(the_autocorrelation_is_the_spectrums),
        cmocka_unit_test(what_was_drawn_is_measured),
        cmocka_unit_test(a_seed_is_one_relief),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
