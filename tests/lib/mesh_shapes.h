/* Meshes for the tests of the mesh query: a rough square patch on a regular grid, whose height is known
 * everywhere without a search, and a sheared copy that overhangs.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "lib/dice.h"
#include "geometry/mesh.h"

#include <math.h>

#define GRID 32 /* cells along a side of [-1, 1]^2 */

struct patch {
    double z[GRID + 1][GRID + 1]; /* 0 on the border */
    double vertex[(GRID + 1) * (GRID + 1)][3];
    uint32_t triangle[2 * GRID * GRID][3];
};

static inline double patch_coordinate(int i)
{
    return 2.0 * i / GRID - 1;
}

/* Makes a patch. Cells are cut along the diagonal from (i, j) to (i + 1, j + 1). shear: x += shear * z. */
static inline void patch_make(struct patch *patch, uint32_t seed, double height, double shear, double dx,
                              double dy)
{
    struct dice dice = dice_new(seed);
    for (int i = 0; i <= GRID; i++)
        for (int j = 0; j <= GRID; j++) {
            const bool border = i == 0 || j == 0 || i == GRID || j == GRID;
            const double z = border ? 0 : dice_between(&dice, -height, height);
            double *v = patch->vertex[i * (GRID + 1) + j];
            patch->z[i][j] = z;
            v[0] = patch_coordinate(i) + shear * z + dx;
            v[1] = patch_coordinate(j) + dy;
            v[2] = z;
        }
    uint32_t(*t)[3] = patch->triangle;
    for (uint32_t i = 0; i < GRID; i++)
        for (uint32_t j = 0; j < GRID; j++) {
            const uint32_t a = i * (GRID + 1) + j, b = a + GRID + 1, c = b + 1, d = a + 1;
            const uint32_t two[2][3] = {{a, c, b}, {a, d, c}};
            memcpy(t, two, sizeof two);
            t += 2;
        }
}

/* Moves the inner vertices of the patch by up to `reach` cells in x and y, at unchanged heights, so that the
 * grid is no longer regular. With 0.25 or less, no triangle turns over. */
static inline void patch_move(struct patch *patch, uint32_t seed, double reach)
{
    struct dice dice = dice_new(seed);
    const double most = reach * 2 / GRID;
    for (int i = 1; i < GRID; i++)
        for (int j = 1; j < GRID; j++) {
            double *v = patch->vertex[i * (GRID + 1) + j];
            v[0] += dice_between(&dice, -most, most);
            v[1] += dice_between(&dice, -most, most);
        }
}

/* Raises one inner vertex of the patch. z points down. */
static inline void patch_spike(struct patch *patch, int i, int j, double height)
{
    patch->z[i][j] -= height;
    patch->vertex[i * (GRID + 1) + j][2] -= height;
}

/* Writes the patch as an OBJ file. */
static inline void patch_write(const struct patch *patch, const char *path)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (int i = 0; i < COUNT(patch->vertex); i++) {
        const double *v = patch->vertex[i];
        fprintf(file, "v %.17g %.17g %.17g\n", v[0], v[1], -v[2]);
    }
    for (int i = 0; i < COUNT(patch->triangle); i++) {
        const uint32_t *t = patch->triangle[i];
        fprintf(file, "f %u %u %u\n", t[0] + 1, t[1] + 1, t[2] + 1);
    }
    assert_int_equal(fclose(file), 0);
}

/* Returns a prepared mesh of the patch, owned by the caller. */
static inline struct cml_mesh patch_mesh(const struct patch *patch)
{
    struct cml_mesh mesh = {.num_vertices = COUNT(patch->vertex), .num_triangles = COUNT(patch->triangle)};
    struct cml_error err = {CML_OK, ""};
    mesh.vertex = malloc(sizeof patch->vertex);
    mesh.triangle = malloc(sizeof patch->triangle);
    assert_true(mesh.vertex && mesh.triangle);
    memcpy(mesh.vertex, patch->vertex, sizeof patch->vertex);
    memcpy(mesh.triangle, patch->triangle, sizeof patch->triangle);
    const cml_status status = cml_mesh_prepare(&mesh, NULL, NULL, &err);
    assert_string_equal(err.text, "");
    assert_int_equal(status, CML_OK);
    return mesh;
}

/* Returns the depth of the unsheared patch, or 0 outside it. */
static inline double patch_depth(const struct patch *patch, double x, double y)
{
    const double a = (x + 1) * GRID / 2, b = (y + 1) * GRID / 2;
    if (!(a > 0 && b > 0 && a < GRID && b < GRID)) return 0;
    const int i = (int)a, j = (int)b;
    const double s = a - i, t = b - j;
    const double z00 = patch->z[i][j], z10 = patch->z[i + 1][j], z01 = patch->z[i][j + 1],
                 z11 = patch->z[i + 1][j + 1];
    return s > t ? z00 + s * (z10 - z00) + t * (z11 - z10) : z00 + t * (z01 - z00) + s * (z11 - z01);
}
