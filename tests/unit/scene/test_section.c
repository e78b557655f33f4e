/* Sections at y = 0 against what is known of the shapes: heights of a rough patch without a search, a
 * heightfield's samples, a body that overhangs. SPDX-License-Identifier: MIT */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "lib/require.h"
#include "scene/section.h"

#include "lib/mesh_shapes.h"

static struct cml_cut cut_of(const struct cml_boundary *boundary, double low, double high)
{
    struct cml_cut cut;
    struct cml_error err = {CML_OK, ""};
    require_ok(cml_section_cut(boundary, low, high, &cut, &err), &err);
    return cut;
}

/* Of a surface over x, cut once everywhere: pieces side by side from low to high. */
static double covered(const struct cml_cut *cut, double low, double high)
{
    double length = 0;
    for (size_t i = 0; i < cut->count; i++) {
        const double *p = cut->piece[i];
        assert_true(fmin(p[0], p[2]) >= low && fmax(p[0], p[2]) <= high);
        length += fabs(p[2] - p[0]);
    }
    return length;
}

/* Also where the plane passes through vertices, along edges and just beside them, and past the patch. */
static void a_mesh_is_cut_where_it_is(void **state)
{
    (void)state;
    static struct patch patch;
    const double shift[] = {0.3, -0.2781, 0, 2.0 / GRID, 0.5 / GRID, 1e-13, 1, -1, 1.5};
    for (int i = 0; i < COUNT(shift); i++) {
        patch_make(&patch, 7, 0.02, 0, 0.4, shift[i]);
        struct cml_boundary boundary = {.form = CML_FORM_MESH, .z = 3, .mesh = patch_mesh(&patch)};
        struct cml_cut cut = cut_of(&boundary, -2, 5);
        assert_true(fabs(covered(&cut, -2, 5) - 7) < 1e-9);
        for (size_t k = 0; k < cut.count; k++)
            for (int end = 0; end < 4; end += 2) {
                const double *p = &cut.piece[k][end];
                assert_true(fabs(p[1] - 3 - patch_depth(&patch, p[0] - 0.4, -shift[i])) < 1e-10);
            }
        if (fabs(shift[i]) < 1) assert_true(cut.count > GRID);
        cml_cut_clear(&cut);
        cml_mesh_clear(&boundary.mesh);
    }
}

static void a_heightfield_is_cut_on_both_sides(void **state)
{
    (void)state;
    double r[] = {0, 0.5, 2}, h[] = {0.3, -0.1, 0.2};
    const struct cml_boundary boundary = {.form = CML_FORM_RADIAL, .z = 1, .radial = {3, r, h}};
    struct cml_cut cut = cut_of(&boundary, -3, 2.5);
    assert_int_equal(cut.count, 6);
    assert_true(fabs(covered(&cut, -3, 2.5) - 5.5) < 1e-15);
    for (size_t k = 0; k < cut.count; k++)
        for (int end = 0; end < 4; end += 2) {
            const double x = fabs(cut.piece[k][end]), z = cut.piece[k][end + 1];
            assert_true(z == 1 - (x == 0 ? 0.3 : x == 0.5 ? -0.1 : 0.2));
        }
    cml_cut_clear(&cut);
    assert_true(cml_outer_depth(&boundary) == 0.8);
}

static void a_plane_is_one_piece(void **state)
{
    (void)state;
    const struct cml_boundary boundary = {.form = CML_FORM_PLANE, .z = 0.5};
    const double piece[] = {-1, 0.5, 4, 0.5};
    struct cml_cut cut = cut_of(&boundary, -1, 4);
    assert_int_equal(cut.count, 1);
    assert_memory_equal(cut.piece[0], piece, sizeof piece);
    cml_cut_clear(&cut);
}

/* A lid of 2 x 2 on four walls that lean outwards, over a footprint of 1 x 1: beside it the outer plane, then
 * wall, lid and wall. */
static void an_overhanging_wall_is_cut(void **state)
{
    (void)state;
    struct cml_mesh mesh = {.num_vertices = 8, .num_triangles = 10};
    mesh.vertex = calloc(8, sizeof *mesh.vertex);
    mesh.triangle = calloc(10, sizeof *mesh.triangle);
    assert_true(mesh.vertex && mesh.triangle);
    for (uint32_t i = 0; i < 8; i++) {
        const double side = i < 4 ? 0.5 : 1;
        mesh.vertex[i][0] = i % 4 == 0 || i % 4 == 3 ? -side : side;
        mesh.vertex[i][1] = i % 4 < 2 ? -side : side;
        mesh.vertex[i][2] = i < 4 ? 0 : -1;
    }
    for (uint32_t i = 0; i < 4; i++) {
        const uint32_t next = (i + 1) % 4;
        memcpy(mesh.triangle[2 * i], (uint32_t[]){i, next, 4 + next}, sizeof *mesh.triangle);
        memcpy(mesh.triangle[2 * i + 1], (uint32_t[]){i, 4 + next, 4 + i}, sizeof *mesh.triangle);
    }
    memcpy(mesh.triangle[8], (uint32_t[]){4, 5, 6}, sizeof *mesh.triangle);
    memcpy(mesh.triangle[9], (uint32_t[]){4, 6, 7}, sizeof *mesh.triangle);
    struct cml_error err = {CML_OK, ""};
    require_ok(cml_mesh_prepare(&mesh, NULL, NULL, &err), &err);
    const struct cml_boundary boundary = {.form = CML_FORM_MESH, .z = 2, .mesh = mesh};
    struct cml_cut cut = cut_of(&boundary, -3, 3);
    double level = 0, lid = 0, walls = 0;
    for (size_t k = 0; k < cut.count; k++) {
        const double *p = cut.piece[k], length = hypot(p[2] - p[0], p[3] - p[1]);
        *(p[1] != p[3] ? &walls : p[1] == 2 ? &level : &lid) += length;
    }
    assert_true(fabs(level - 5) < 1e-15 && fabs(lid - 2) < 1e-15 && fabs(walls - 2 * sqrt(1.25)) < 1e-15);
    cml_cut_clear(&cut);
    cml_mesh_clear(&mesh);
}

/* Pieces side by side, whose ends lie on the surface: at samples on its rows, between them on the diagonals.
 */
static void a_tile_is_cut_from_end_to_end(void **state)
{
    (void)state;
    double h[] = {0, 1, 0, 0, 0, 0, 0, 2};
    struct cml_boundary boundary = {.form = CML_FORM_TILE, .z = 5, .tile = {4, 2, 0.25, 0, 0.5, 1, h}};
    struct cml_cut cut = cut_of(&boundary, -3.9, 4.1);
    double low = INFINITY, high = -INFINITY;
    for (size_t i = 0; i < cut.count; i++) {
        low = fmin(low, fmin(cut.piece[i][0], cut.piece[i][2]));
        high = fmax(high, fmax(cut.piece[i][0], cut.piece[i][2]));
        for (int end = 0; end < 4; end += 2) {
            const double x = (cut.piece[i][end] - 0.25) / 0.5, in_period = x - 4 * floor(x / 4);
            assert_true(fabs(cut.piece[i][end + 1] - (5 - fmax(0, 1 - fabs(in_period - 1)))) < 1e-12);
        }
    }
    assert_true(low <= -3.9 && high >= 4.1 && fabs(covered(&cut, low, high) - (high - low)) < 1e-12);
    cml_cut_clear(&cut);
    boundary.tile.y0 = 0.5; /* half way between the rows: cells 1 and 3 fall, from height 1 to 0 and 0 to 2 */
    cut = cut_of(&boundary, 0.25, 2.2);
    for (size_t i = 0; i < cut.count; i++) {
        const double x = (cut.piece[i][0] - 0.25) / 0.5, z = cut.piece[i][1];
        if (x == 1) assert_true(z == 5 - 0.5);
        if (x == 0.5) assert_true(z == 5);
        if (x == 3) assert_true(z == 5 - 1);
        if (x == 3.5) assert_true(z == 5 - 1);
    }
    cml_cut_clear(&cut);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tile_is_cut_from_end_to_end),      cmocka_unit_test(a_mesh_is_cut_where_it_is),
        cmocka_unit_test(a_heightfield_is_cut_on_both_sides), cmocka_unit_test(a_plane_is_one_piece),
        cmocka_unit_test(an_overhanging_wall_is_cut),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
