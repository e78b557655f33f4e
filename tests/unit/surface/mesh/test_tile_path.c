/* Tests of crossings of a tile against those of a mesh that holds many copies of it, and of the limit on
 * the number of periods that a ray is followed. Copies and tile use the same mesh query, but the mesh
 * knows nothing of periods. SPDX-License-Identifier: MIT */
#include "lib/dice.h"
#include "lib/require.h"
#include "scene/heightmap/tile.h"
#include "surface/mesh/mesh_surface.h"

#include <math.h>
#include <stdlib.h>

enum { COPIES = 5 }; /* copies on each side of the middle one */

struct subject {
    struct cml_heightmap map;
    struct cml_mesh_surface *tile, *copies;
};

static struct cml_mesh_surface *tile_surface(const struct cml_heightmap *map)
{
    const struct cml_tile_cells cells = cml_tile_patch_cells(map);
    const struct cml_mesh_period period = {.n = {map->nx, map->ny},
                                           .margin = {-cells.first[0], -cells.first[1]},
                                           .corner = {map->x0, map->y0},
                                           .cell = {map->dx, map->dy}};
    struct cml_mesh_surface *surface;
    struct cml_mesh mesh;
    struct cml_error err;
    require_ok(cml_tile_patch(map, &cells, CML_NORMALS_FACET, &mesh, &err), &err);
    require_ok(cml_mesh_surface_create_tile(&mesh, 0.01, -0.02, CML_SEARCH_AUTO, &period, &surface, &err),
               &err);
    return surface;
}

static struct cml_mesh_surface *copies_surface(const struct cml_heightmap *map)
{
    const struct cml_tile_cells cells = {{-COPIES * map->nx, -COPIES * map->ny},
                                         {(2 * COPIES + 1) * map->nx, (2 * COPIES + 1) * map->ny}};
    struct cml_mesh_surface *surface;
    struct cml_mesh mesh;
    struct cml_error err;
    require_ok(cml_tile_patch(map, &cells, CML_NORMALS_FACET, &mesh, &err), &err);
    require_ok(cml_mesh_surface_create(&mesh, 0.01, -0.02, CML_SEARCH_AUTO, &surface, &err), &err);
    return surface;
}

static struct subject subject_of(int nx, int ny, double height, uint32_t seed)
{
    struct subject s = {.map = {.nx = nx, .ny = ny, .x0 = -0.3, .y0 = 0.2, .dx = 0.02, .dy = 0.03}};
    struct dice dice = dice_new(seed);
    s.map.h = malloc((size_t)(nx * ny) * sizeof *s.map.h);
    assert_non_null(s.map.h);
    for (int i = 0; i < nx * ny; i++) s.map.h[i] = dice_between(&dice, -height, height);
    s.tile = tile_surface(&s.map);
    s.copies = copies_surface(&s.map);
    return s;
}

static void subject_free(struct subject *s)
{
    cml_mesh_surface_free(s->tile);
    cml_mesh_surface_free(s->copies);
    cml_heightmap_clear(&s->map);
}

/* Returns the triangle of the tile of which this triangle of the mesh of copies is a copy. */
static int primitive_of(const struct cml_heightmap *map, int triangle)
{
    const int row = (2 * COPIES + 1) * map->nx, cell = triangle / 2;
    return 2 * (cell / row % map->ny * map->nx + cell % row % map->nx) + triangle % 2;
}

/* Draws a ray that begins in one of the middle copies and passes several. The path ends where the copies
 * end. */
static void random_ray(const struct cml_heightmap *map, double height, struct dice *dice, double p[3],
                       double u[3], double *length)
{
    double to_end = INFINITY;
    dice_direction(dice, u);
    if (dice_below(dice, 2)) u[2] *= 0.05;
    const double size = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    for (int k = 0; k < 3; k++) u[k] /= size;
    for (int k = 0; k < 2; k++) {
        const double corner = k == 0 ? map->x0 - 0.01 : map->y0 + 0.02, period = cml_tile_period(map, k);
        p[k] = corner + dice_between(dice, -2, 3) * period;
        const double end = corner + (u[k] > 0 ? COPIES + 1 - 0.01 : -COPIES + 0.01) * period;
        to_end = fmin(to_end, (end - p[k]) / u[k]);
    }
    p[2] = dice_between(dice, -3 * height, 3 * height);
    *length = dice_below(dice, 2) ? to_end : to_end * dice_uniform(dice);
}

static void expect_same_crossings(struct subject *s, double height, int exact, int rays)
{
    struct dice dice = dice_new(11);
    int hits = 0, far = 0;
    for (int i = 0; i < rays; i++) {
        double p[3], u[3], length;
        struct cml_mesh_crossing one, other;
        random_ray(&s->map, height, &dice, p, u, &length);
        const int below = i & 1;
        const int a = cml_mesh_surface_hit(s->tile, p, u, below, length, -1, 0, exact, 1e-15, &one);
        const int b = cml_mesh_surface_hit(s->copies, p, u, below, length, -1, 0, exact, 1e-15, &other);
        assert_int_equal(a, b);
        if (!a) continue;
        hits++;
        far += one.t > cml_tile_period(&s->map, 0);
        assert_true(fabs(one.t - other.t) < 1e-10);
        assert_int_equal(one.primitive, primitive_of(&s->map, other.primitive));
        for (int k = 0; k < 3; k++) {
            assert_true(fabs(one.point[k] - other.point[k]) < 1e-10);
            assert_true(fabs(one.normal[k] - other.normal[k]) < 1e-9);
        }
    }
    print_message("%d rays: %d hits, %d of them more than a period away\n", rays, hits, far);
    assert_true(hits > rays / 10 && far > rays / 1000);
}

static void a_tile_is_crossed_where_its_copies_are(void **state)
{
    (void)state;
    static const struct {
        int nx, ny;
        double height;
    } cases[] = {{2, 2, 0.005}, {3, 5, 0.02}, {24, 18, 0.01}, {40, 2, 0.02}, {66, 70, 0.02}};
    for (int i = 0; i < COUNT(cases); i++) {
        struct subject s = subject_of(cases[i].nx, cases[i].ny, cases[i].height, 3);
        expect_same_crossings(&s, cases[i].height, 0, 20000);
        expect_same_crossings(&s, cases[i].height, 1, 5000);
        subject_free(&s);
    }
}

/* A packet that has just crossed a facet goes on from any copy of that facet, also from a seam, and does
 * not meet it again. */
static void a_packet_goes_on_from_the_facet_it_stands_on(void **state)
{
    (void)state;
    struct subject s = subject_of(6, 4, 0.01, 5);
    struct dice dice = dice_new(17);
    for (int i = 0; i < 50000; i++) {
        double p[3], u[3], length;
        struct cml_mesh_crossing first, one, other;
        random_ray(&s.map, 0.01, &dice, p, u, &length);
        const int below = i & 1;
        if (!cml_mesh_surface_hit(s.copies, p, u, below, length, -1, 0, 1, 1e-15, &first)) continue;
        const int primitive = primitive_of(&s.map, first.primitive);
        const double *from = first.point;
        const double left = length - first.t;
        const int a = cml_mesh_surface_hit(s.tile, from, u, !below, left, primitive, 1, i & 2, 1e-15, &one);
        const int b =
            cml_mesh_surface_hit(s.copies, from, u, !below, left, first.primitive, 1, i & 2, 1e-15, &other);
        assert_int_equal(a, b);
        assert_true(!a || fabs(one.t - other.t) < 1e-10);
    }
    subject_free(&s);
}

static void primitives_are_those_of_the_period(void **state)
{
    (void)state;
    const struct cml_mesh_period period = {.n = {5, 3}, .margin = {9, 4}};
    for (int i = 0; i < 2 * 15; i++)
        assert_int_equal(cml_tile_primitive(&period, cml_tile_triangle(&period, i)), i);
    for (int triangle = 0; triangle < 2 * 23 * 11; triangle++) {
        const int x = (triangle / 2 % 23 + 1) % 5,
                  y = (triangle / 2 / 23 + 2) % 3; /* the margins modulo n are 9 and 4 */
        assert_int_equal(cml_tile_primitive(&period, triangle), 2 * (5 * y + x) + triangle % 2);
    }
    assert_int_equal(cml_tile_primitive(&period, 2 * 23 * 11), -1); /* a facet of the skirt */
}

/* A ray along straight grooves, below their ridges, never meets anything and is given up. A ray that rises
 * or sinks is followed only while it is between the lowest and highest height. */
static void a_path_over_too_many_periods_is_given_up(void **state)
{
    (void)state;
    struct cml_heightmap map = {.nx = 4, .ny = 2, .x0 = 0, .y0 = 0, .dx = 0.1, .dy = 0.1};
    double h[8] = {0.05, 0, -0.05, 0, 0.05, 0, -0.05, 0};
    map.h = h;
    struct cml_mesh_surface *surface = tile_surface(&map);
    const double p[3] = {0.2, 0, 0.02}, along[3] = {0, 1, 0}, rising[3] = {0, sqrt(1 - 1e-6), -1e-3},
                 sinking[3] = {0, sqrt(1 - 1e-6), 1e-3};
    struct cml_mesh_crossing crossing;
    assert_int_equal(cml_mesh_surface_hit(surface, p, along, 0, INFINITY, -1, 0, 0, 1e-15, &crossing), 0);
    assert_int_equal(crossing.ends_near_facet, CML_PATH_TOO_LONG);
    assert_int_equal(cml_mesh_surface_hit(surface, p, along, 0, 1e3, -1, 0, 0, 1e-15, &crossing), 0);
    assert_int_equal(crossing.ends_near_facet, 0);
    assert_int_equal(cml_mesh_surface_hit(surface, p, rising, 0, INFINITY, -1, 0, 0, 1e-15, &crossing), 0);
    assert_int_equal(crossing.ends_near_facet, 0);
    assert_int_equal(cml_mesh_surface_hit(surface, p, sinking, 0, INFINITY, -1, 0, 0, 1e-15, &crossing), 1);
    assert_true(crossing.t > 10 && crossing.t < 31);
    cml_mesh_surface_free(surface);
}

/* A path may begin far below the sheet at a small angle; the part outside the sheet's depths is not cut
 * into segments. */
static void a_path_may_begin_far_away(void **state)
{
    (void)state;
    struct cml_heightmap map = {.nx = 4, .ny = 2, .x0 = 0, .y0 = 0, .dx = 1e-3, .dy = 1e-3};
    double h[8] = {5e-4, 0, -5e-4, 0, 5e-4, 0, -5e-4, 0};
    map.h = h;
    struct cml_mesh_surface *surface = tile_surface(&map);
    const double p[3] = {0, 0, 10}, up[3] = {sqrt(1 - 1e-4), 0, -1e-2};
    struct cml_mesh_crossing crossing;
    assert_int_equal(cml_mesh_surface_hit(surface, p, up, 1, INFINITY, -1, 0, 0, 1e-15, &crossing), 1);
    assert_true(fabs(crossing.t - 1000) < 0.06);
    assert_true(fabs(crossing.point[2]) <= 5e-4 && fabs(crossing.point[0] - 1000 * up[0]) < 0.06);
    cml_mesh_surface_free(surface);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tile_is_crossed_where_its_copies_are),
        cmocka_unit_test(a_packet_goes_on_from_the_facet_it_stands_on),
        cmocka_unit_test(primitives_are_those_of_the_period),
        cmocka_unit_test(a_path_over_too_many_periods_is_given_up),
        cmocka_unit_test(a_path_may_begin_far_away),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
