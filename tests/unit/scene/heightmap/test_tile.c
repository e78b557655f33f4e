/* Tests of repeated heightmaps (tiles): every claim of tile.h, against heights looked up by hand.
 * SPDX-License-Identifier: MIT */
#include "lib/dice.h"
#include "lib/require.h"
#include "scene/heightmap/tile.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Returns a map of nx x ny different heights, 0.1 x 0.2 cm apart, from (-1, 2) on. */
static struct cml_heightmap map_of(int nx, int ny)
{
    struct cml_heightmap map = {.nx = nx, .ny = ny, .x0 = -1, .y0 = 2, .dx = 0.1, .dy = 0.2};
    struct dice dice = dice_new(7);
    map.h = malloc((size_t)(nx * ny) * sizeof *map.h);
    assert_non_null(map.h);
    for (int i = 0; i < nx * ny; i++) map.h[i] = dice_between(&dice, -0.02, 0.02);
    return map;
}

static struct cml_tile_notes make(bool mirrored, struct cml_heightmap *map)
{
    struct cml_tile_notes notes;
    struct cml_error err = {CML_OK, ""};
    require_ok(cml_tile_make("map", mirrored, map, &notes, &err), &err);
    return notes;
}

static void the_sample_behind_the_last_is_the_first(void **state)
{
    (void)state;
    struct cml_heightmap map = map_of(4, 3);
    make(false, &map);
    assert_true(cml_tile_period(&map, 0) == 4 * 0.1 && cml_tile_period(&map, 1) == 3 * 0.2);
    for (int j = -7; j < 9; j++)
        for (int i = -9; i < 9; i++)
            assert_true(cml_tile_height(&map, i, j) == map.h[(j + 9) % 3 * 4 + (i + 12) % 4]);
    cml_heightmap_clear(&map);
}

/* A mirrored map has equal samples at k steps to either side of a mirror; diagonals are mirrored, too. */
static void a_mirrored_map_is_the_same_on_both_sides_of_its_ends(void **state)
{
    (void)state;
    for (int nx = 2; nx < 7; nx++) {
        struct cml_heightmap map = map_of(nx, 5), given = map_of(nx, 5);
        const struct cml_tile_notes notes = make(true, &map);
        assert_int_equal(map.nx, 2 * (nx - 1));
        assert_int_equal(map.ny, 8);
        assert_int_equal(notes.nx, nx);
        for (int j = 0; j < 5; j++)
            for (int i = 0; i < nx; i++) assert_true(cml_tile_height(&map, i, j) == given.h[j * nx + i]);
        for (int j = -9; j < 9; j++)
            for (int k = 0; k < 9; k++) {
                assert_true(cml_tile_height(&map, k, j) == cml_tile_height(&map, -k, j));
                assert_true(cml_tile_height(&map, nx - 1 + k, j) == cml_tile_height(&map, nx - 1 - k, j));
                assert_true(cml_tile_height(&map, j, 4 + k) == cml_tile_height(&map, j, 4 - k));
                assert_int_not_equal(cml_tile_rises(&map, k, j), cml_tile_rises(&map, -k - 1, j));
            }
        assert_true(notes.seam[0] <= notes.inside[0] && notes.seam[1] <= notes.inside[1]);
        cml_heightmap_clear(&map);
        cml_heightmap_clear(&given);
    }
}

static void steps_are_measured_inside_and_across_the_seam(void **state)
{
    (void)state;
    const double h[6] = {0, 1, 3, /* heights of the next row */ 0, 2, 3.5};
    struct cml_heightmap map = map_of(3, 2);
    memcpy(map.h, h, sizeof h);
    const struct cml_tile_notes notes = make(false, &map);
    assert_true(notes.inside[0] == 2 && notes.seam[0] == 3.5);
    assert_true(notes.inside[1] == 1 && notes.seam[1] == 1);
    cml_heightmap_clear(&map);
}

/* Every vertex of a sheet has the height of its sample. Every cell has two facets of half its area, which
 * face up. */
static void a_sheet_holds_all_its_cells(void **state)
{
    (void)state;
    struct cml_heightmap map = map_of(5, 4);
    const struct cml_tile_cells cells = {{-7, 3}, {13, 9}};
    struct cml_mesh mesh;
    struct cml_error err;
    require_ok(cml_tile_sheet(&map, &cells, CML_NORMALS_FACET, &mesh, &err), &err);
    assert_int_equal(mesh.num_triangles, 2 * 13 * 9);
    for (size_t t = 0; t < mesh.num_triangles; t++) {
        const double *v[3];
        const int i = -7 + (int)(t / 2) % 13, j = 3 + (int)(t / 2) / 13;
        int corners = 0;
        for (int k = 0; k < 3; k++) {
            v[k] = mesh.vertex[mesh.triangle[t][k]];
            const int x = (int)lrint((v[k][0] - map.x0) / map.dx),
                      y = (int)lrint((v[k][1] - map.y0) / map.dy);
            assert_true(x >= i && x <= i + 1 && y >= j && y <= j + 1);
            assert_true(v[k][2] == -cml_tile_height(&map, x, y));
            corners |= 1 << (2 * (y - j) + x - i);
        }
        const double area =
            (v[1][0] - v[0][0]) * (v[2][1] - v[0][1]) - (v[1][1] - v[0][1]) * (v[2][0] - v[0][0]);
        assert_true(fabs(area + map.dx * map.dy) < 1e-12);
        const int south = cml_tile_rises(&map, i, j) ? 11 : 7, north = cml_tile_rises(&map, i, j) ? 13 : 14;
        assert_int_equal(corners, t % 2 == 0 ? south : north);
    }
    cml_mesh_clear(&mesh);
    cml_heightmap_clear(&map);
}

/* The patch of a tile is wide even if the period is short, and the skirt lies behind all cells. */
static void a_patch_is_a_boundary(void **state)
{
    (void)state;
    for (int nx = 2; nx < 80; nx += 11) {
        struct cml_heightmap map = map_of(nx, 6);
        const struct cml_tile_cells cells = cml_tile_patch_cells(&map);
        struct cml_mesh mesh;
        struct cml_error err;
        require_ok(cml_tile_patch(&map, &cells, CML_NORMALS_VERTEX, &mesh, &err), &err);
        assert_true(cells.count[0] >= 64 && cells.count[1] >= 64);
        assert_true(cells.first[0] <= -4 && cells.first[0] + cells.count[0] >= nx + 4);
        const size_t of_cells = 2 * (size_t)cells.count[0] * (size_t)cells.count[1];
        assert_true(mesh.num_triangles > of_cells && mesh.num_border > 0);
        const double *first = mesh.vertex[mesh.triangle[0][0]];
        assert_true(fabs(first[0] - (map.x0 + cells.first[0] * map.dx)) < 1e-12);
        cml_mesh_clear(&mesh);
        cml_heightmap_clear(&map);
    }
}

/* Two tiles of equal cells are compared at samples and in the middles of cells for the least gap. Tiles of
 * different grids have no gap. */
static void tiles_of_the_same_cells_are_compared(void **state)
{
    (void)state;
    struct cml_heightmap upper = map_of(6, 4), lower = map_of(6, 4);
    double gap, at[3];
    assert_true(cml_tile_closest(&upper, 1, &lower, 1.5, &gap, at));
    assert_true(fabs(gap - 0.5) < 1e-12);
    lower.x0 += 3 * 6 * lower.dx; /* shift by whole periods */
    assert_true(cml_tile_closest(&upper, 1, &lower, 1.5, &gap, at) && fabs(gap - 0.5) < 1e-12);
    lower.h[2 * 6 + 3] += 0.4;
    assert_true(cml_tile_closest(&upper, 1, &lower, 1.5, &gap, at) && fabs(gap - 0.1) < 1e-12);
    assert_true(fabs(at[0] - (-1 + 3 * 0.1)) < 1e-12 && fabs(at[1] - (2 + 2 * 0.2)) < 1e-12);
    lower.x0 += lower.dx / 2;
    assert_false(cml_tile_closest(&upper, 1, &lower, 1.5, &gap, at));
    lower.x0 -= lower.dx / 2;
    lower.dy *= 1.001;
    assert_false(cml_tile_closest(&upper, 1, &lower, 1.5, &gap, at));
    cml_heightmap_clear(&upper);
    cml_heightmap_clear(&lower);
}

/* Two tiles, one moved by a cell, whose cells are cut along different diagonals. A groove along one diagonal
 * crosses a ridge along the other in the middle of a cell: the closest place is no sample of either tile. */
static void diagonals_that_differ_are_compared_in_the_middle(void **state)
{
    (void)state;
    struct cml_heightmap upper = map_of(4, 4), lower = map_of(4, 4);
    double gap, at[3];
    for (int i = 0; i < 16; i++) upper.h[i] = lower.h[i] = 0;
    lower.x0 += lower.dx;               /* its cell 0, 0 rises over the falling cell 1, 0 */
    upper.h[2] = upper.h[4 + 1] = -0.1; /* the falling diagonal of cell 1, 0 */
    lower.h[0] = lower.h[4 + 1] = 0.1;  /* the rising diagonal, at samples 1, 0 and 2, 1 of the upper tile */
    assert_true(cml_tile_closest(&upper, 0, &lower, 0.15, &gap, at));
    assert_true(fabs(gap + 0.05) < 1e-12);
    assert_true(fabs(at[0] - (-1 + 1.5 * 0.1)) < 1e-12 && fabs(at[1] - (2 + 0.5 * 0.2)) < 1e-12);
    cml_heightmap_clear(&upper);
    cml_heightmap_clear(&lower);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_sample_behind_the_last_is_the_first),
        cmocka_unit_test(a_mirrored_map_is_the_same_on_both_sides_of_its_ends),
        cmocka_unit_test(steps_are_measured_inside_and_across_the_seam),
        cmocka_unit_test(a_sheet_holds_all_its_cells),
        cmocka_unit_test(a_patch_is_a_boundary),
        cmocka_unit_test(tiles_of_the_same_cells_are_compared),
        cmocka_unit_test(diagonals_that_differ_are_compared_in_the_middle),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
