/* Tests of heightmaps as meshes: every claim of heightmap.h, against brute force. SPDX-License-Identifier:
 * MIT */
#include "lib/dice.h"
#include "scene/heightmap/heightmap.h"

#include <math.h>

static void make(int nx, int ny, double (*height)(double x, double y), struct cml_heightmap *map)
{
    struct cml_error err;
    assert_int_equal(cml_heightmap_allocate("x", nx, ny, map, &err), CML_OK);
    map->dx = 0.5;
    map->dy = 0.25;
    cml_heightmap_centre(map);
    for (int j = 0; j < ny; j++)
        for (int i = 0; i < nx; i++)
            map->h[j * nx + i] = height(map->x0 + i * map->dx, map->y0 + j * map->dy);
}

static void build(const struct cml_heightmap *map, double tolerance, struct cml_mesh *mesh,
                  struct cml_heightmap_notes *notes)
{
    struct cml_error err = {0};
    const cml_status status = cml_heightmap_mesh(map, tolerance, CML_NORMALS_FACET, NULL, mesh, notes, &err);
    assert_string_equal(err.text, "");
    assert_int_equal(status, CML_OK);
}

static double level(double x, double y)
{
    (void)x, (void)y;
    return 0.125;
}

static double tilted(double x, double y)
{
    return 0.5 * x - 0.25 * y + 1;
}

static double waves(double x, double y)
{
    return 0.2 * sin(1.7 * x + 0.3) * cos(2.1 * y) + 0.05 * sin(7 * x + 5 * y);
}

static struct dice noise_dice;

static double noise(double x, double y)
{
    (void)x, (void)y;
    return dice_between(&noise_dice, -1, 1);
}

/* Returns twice the area of a triangle's projection. The area is positive if the triangle is seen from
 * above, in a frame with z down. */
static double double_area(const struct cml_mesh *mesh, size_t t)
{
    const double *a = mesh->vertex[mesh->triangle[t][0]], *b = mesh->vertex[mesh->triangle[t][1]],
                 *c = mesh->vertex[mesh->triangle[t][2]];
    return (b[1] - a[1]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[1] - a[1]);
}

/* Returns the height of the mesh above (x, y), by looking at all triangles. */
static double height_at(const struct cml_mesh *mesh, double x, double y)
{
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        const double *v[3] = {mesh->vertex[mesh->triangle[t][0]], mesh->vertex[mesh->triangle[t][1]],
                              mesh->vertex[mesh->triangle[t][2]]};
        const double area = double_area(mesh, t);
        double share[3], sum = 0;
        for (int k = 0; k < 3; k++) {
            const double *p = v[(k + 1) % 3], *q = v[(k + 2) % 3];
            share[k] = ((q[1] - p[1]) * (x - p[0]) - (q[0] - p[0]) * (y - p[1])) / area;
        }
        if (share[0] < -1e-12 || share[1] < -1e-12 || share[2] < -1e-12) continue;
        for (int k = 0; k < 3; k++) sum -= share[k] * v[k][2];
        return sum;
    }
    fail_msg("no triangle over %g, %g", x, y);
    return NAN;
}

static const int sizes[][2] = {{2, 2}, {3, 2}, {2, 9}, {5, 5}, {6, 7}, {17, 33}, {40, 23}, {300, 4}};
enum { NUM_SIZES = sizeof sizes / sizeof *sizes };

/* Checks that the triangles, seen from above, cover the map and its skirt exactly once, and that the
 * border is the skirt's rectangle. */
static void assert_covers(const struct cml_heightmap *map, const struct cml_mesh *mesh,
                          const struct cml_heightmap_notes *notes)
{
    const double width = 0.5 * (map->nx - 1) * map->dx + notes->skirt[0];
    const double height = 0.5 * (map->ny - 1) * map->dy + notes->skirt[1];
    double area = 0;
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        assert_true(double_area(mesh, t) > 0);
        area += double_area(mesh, t) / 2;
    }
    assert_near("value", area, 4 * width * height, 1e-9 * area);
    assert_near("value", mesh->z_border, -notes->rim_mean, 1e-12);
    for (int k = 0; k < 2; k++) assert_near("value", mesh->lower[k], -mesh->upper[k], 1e-12);
    assert_near("value", mesh->upper[0], width, 1e-12);
    assert_near("value", mesh->upper[1], height, 1e-12);
}

static void every_sample_is_on_the_exact_mesh(void **state)
{
    (void)state;
    for (int s = 0; s < NUM_SIZES; s++) {
        struct cml_heightmap map;
        struct cml_mesh mesh;
        struct cml_heightmap_notes notes;
        make(sizes[s][0], sizes[s][1], waves, &map);
        build(&map, 0, &mesh, &notes);
        assert_covers(&map, &mesh, &notes);
        assert_true(notes.height_error <= 1e-15);
        for (int k = 0; k < 200; k++) {
            const int i = (k * 37) % map.nx, j = (k * 53) % map.ny;
            assert_near("value", height_at(&mesh, map.x0 + i * map.dx, map.y0 + j * map.dy),
                        map.h[j * map.nx + i], 1e-12);
        }
        cml_mesh_clear(&mesh);
        cml_heightmap_clear(&map);
    }
}

/* Merged triangles keep the tolerance at random points, not only at samples. */
static void merging_keeps_the_tolerance(void **state)
{
    (void)state;
    struct dice dice = dice_new(7);
    for (int s = 0; s < NUM_SIZES; s++)
        for (int wild = 0; wild < 2; wild++) {
            struct cml_heightmap map;
            struct cml_mesh exact, merged;
            struct cml_heightmap_notes notes, last = {0};
            noise_dice = dice_new(3);
            make(sizes[s][0], sizes[s][1], wild ? noise : waves, &map);
            build(&map, 0, &exact, &notes);
            for (double tolerance = 1e-3; tolerance < 1; tolerance *= 4) {
                build(&map, tolerance, &merged, &notes);
                assert_covers(&map, &merged, &notes);
                assert_near("value", notes.tolerance,
                            tolerance * (notes.relief.highest - notes.relief.lowest), 1e-15);
                assert_true(notes.height_error <= notes.tolerance && notes.height_error >= last.height_error);
                assert_true(last.triangles == 0 || notes.triangles <= last.triangles);
                for (int k = 0; k < 50; k++) {
                    const double x = dice_between(&dice, map.x0, -map.x0),
                                 y = dice_between(&dice, map.y0, -map.y0);
                    assert_near("value", height_at(&merged, x, y), height_at(&exact, x, y),
                                notes.height_error + 1e-12);
                }
                cml_mesh_clear(&merged);
                last = notes;
            }
            cml_mesh_clear(&exact);
            cml_heightmap_clear(&map);
        }
}

/* Flat parts cost few triangles. A plane of 256 x 256 cells, tilted or not, has inner triangles of the
 * largest size and smaller ones towards the rim. A single bump refines only its neighbourhood. */
static void flat_parts_cost_nothing(void **state)
{
    (void)state;
    double (*const shapes[])(double, double) = {level, tilted};
    for (int s = 0; s < 2; s++) {
        struct cml_heightmap map;
        struct cml_mesh mesh;
        struct cml_heightmap_notes notes;
        double z;
        make(257, 257, shapes[s], &map);
        build(&map, 0, &mesh, &notes);
        assert_true(notes.triangles < 1500); /* 256 rim sides of 4 cells; a full grid has 131072 triangles */
        assert_true(cml_mesh_is_flat(&mesh, &z) == (s == 0));
        const size_t plain = notes.triangles;
        cml_mesh_clear(&mesh);
        map.h[100 * 257 + 77] += 0.01;
        build(&map, 0, &mesh, &notes);
        assert_true(notes.triangles > plain && notes.triangles < plain + 200);
        cml_mesh_clear(&mesh);
        cml_heightmap_clear(&map);
    }
}

/* No triangle is thinner than the rule allows: inside they have right angles, in the skirt four cells over
 * one. */
static void there_are_no_needles(void **state)
{
    (void)state;
    double (*const shapes[])(double, double) = {waves, level};
    for (int s = 0; s < 2; s++) {
        struct cml_heightmap map;
        struct cml_mesh mesh;
        struct cml_heightmap_notes notes;
        make(201, 150, shapes[s], &map);
        map.dy = map.dx;
        build(&map, 0.05, &mesh, &notes);
        for (size_t t = 0; t < mesh.num_triangles; t++) {
            double longest = 0;
            for (int k = 0; k < 3; k++) {
                const double *p = mesh.vertex[mesh.triangle[t][k]],
                             *q = mesh.vertex[mesh.triangle[t][(k + 1) % 3]];
                longest = fmax(longest, hypot(p[0] - q[0], p[1] - q[1]));
            }
            const double height = double_area(&mesh, t) / longest; /* height of the projected triangle */
            assert_true(longest / height <
                        4.3); /* sqrt(17) / (4 / sqrt(17)) = 4.25; a right-angled one has 2 */
        }
        cml_mesh_clear(&mesh);
        cml_heightmap_clear(&map);
    }
}

static void relief_is_measured(void **state)
{
    (void)state;
    struct cml_heightmap map;
    struct cml_relief relief;
    make(41, 31, tilted, &map);
    cml_heightmap_measure(&map, map.h, &relief);
    assert_near("value", relief.mean, 1, 1e-12);
    assert_near("value", relief.slope_rms, hypot(0.5, 0.25), 1e-12);
    assert_near("value", relief.highest - relief.lowest, 0.5 * 20 + 0.25 * 7.5, 1e-12);
    /* variance of 41 or 31 equally spaced values: step^2 (n^2 - 1) / 12 */
    const double vx = 0.0625 * (41 * 41 - 1) / 12.0, vy = 0.0625 * 0.0625 * (31 * 31 - 1) / 12.0;
    assert_near("value", relief.rms, sqrt(vx + vy), 1e-12);
    cml_heightmap_clear(&map);
}

/* The skirt lies at the mean of the rim along its length: here 3/4 of the rim lie at 0, and the last side
 * lies at 1 but for its corners. */
static void the_skirt_meets_the_mean_of_the_rim(void **state)
{
    (void)state;
    struct cml_heightmap map;
    struct cml_mesh mesh;
    struct cml_heightmap_notes notes;
    make(3, 5, level, &map);
    for (int i = 0; i < 15; i++) map.h[i] = i == 1 ? 1 : 0;
    build(&map, 0, &mesh, &notes);
    const double length = 2 * (2 * 0.5 + 4 * 0.25), mean = 0.5 / length;
    assert_near("value", notes.rim_mean, mean, 1e-12);
    assert_near("value", notes.rim_step, 1 - mean, 1e-12);
    assert_near("value", notes.skirt[0], 1 - mean, 1e-12); /* the skirt is higher than a cell is wide */
    assert_near("value", notes.skirt[1], 1 - mean, 1e-12);
    cml_mesh_clear(&mesh);
    cml_heightmap_clear(&map);
}

static void a_map_is_scaled_turned_and_shifted(void **state)
{
    (void)state;
    const double shift[3] = {10, 20, 30};
    struct cml_heightmap map;
    make(3, 2, level, &map);
    for (int i = 0; i < 6; i++) map.h[i] = i;
    cml_heightmap_place(&map, 2, shift, true); /* turned about the x axis: y and height change their signs */
    assert_near("value", map.dx, 1, 0);
    assert_near("value", map.dy, 0.5, 0);
    assert_near("value", map.x0, 9, 0);
    assert_near("value", map.y0, 19.75, 0);
    const double expected[6] = {30 - 6, 30 - 8, 30 - 10, 30, 30 - 2, 30 - 4};
    for (int i = 0; i < 6; i++) assert_near("value", map.h[i], expected[i], 0);
    cml_heightmap_clear(&map);
}

static void holes_are_counted(void **state)
{
    (void)state;
    struct cml_heightmap map;
    struct cml_error err = {0};
    make(4, 3, level, &map);
    assert_int_equal(cml_heightmap_check("m.gsf", &map, &err), CML_OK);
    map.h[6] = NAN;
    map.h[11] = -INFINITY;
    assert_int_equal(cml_heightmap_check("m.gsf", &map, &err), CML_E_INPUT);
    assert_string_equal(err.text,
                        "m.gsf: 2 of 12 heights are missing, the first in row 2, column 3 (expected a "
                        "height in every cell: fill the holes first)");
    cml_heightmap_clear(&map);
    assert_int_equal(cml_heightmap_allocate("m.gsf", 1e6, 1e6, &map, &err), CML_E_INPUT);
    assert_string_equal(err.text, "m.gsf: 1000000 x 1000000 heights (expected at most 2^26)");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_sample_is_on_the_exact_mesh),
        cmocka_unit_test(merging_keeps_the_tolerance),
        cmocka_unit_test(flat_parts_cost_nothing),
        cmocka_unit_test(there_are_no_needles),
        cmocka_unit_test(relief_is_measured),
        cmocka_unit_test(the_skirt_meets_the_mean_of_the_rim),
        cmocka_unit_test(a_map_is_scaled_turned_and_shifted),
        cmocka_unit_test(holes_are_counted),
    };
    return cmocka_run_group_tests_name("heightmap", tests, NULL, NULL);
}
