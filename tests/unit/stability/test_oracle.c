/* Tests of the spatial index of the oracle of tests/stability: it gives the same answers as the list of
 * all triangles. SPDX-License-Identifier: MIT */
#include "stability/oracle.c"
#include "stability/oracle_grid.c"

#include "lib/mesh_shapes.h"

#define POINTS repeats(20000)

static struct patch patch;

struct pair {
    struct cml_surface_def def;
    struct oracle indexed, listed;
};

/* Makes a patch of triangles, with the index and without. `power` draws vertices to the middle of the
 * patch: 1 leaves them in place, more makes cells with many triangles. */
static void make_pair(struct pair *pair, double power, double height, double shear)
{
    patch_make(&patch, 7, height, shear, 0, 0);
    for (int i = 0; i < COUNT(patch.vertex); i++)
        for (int axis = 0; axis < 2; axis++) {
            double *x = &patch.vertex[i][axis];
            *x = copysign(pow(fabs(*x), power), *x);
        }
    struct cml_mesh mesh = patch_mesh(&patch);
    struct cml_error err = {CML_OK, ""};
    *pair = (struct pair){.def = {.kind = CML_SURFACE_MESH}};
    assert_int_equal(cml_mesh_surface_create(&mesh, 0, 0, CML_SEARCH_AUTO, &pair->def.mesh, &err), CML_OK);
    oracle_create(&pair->def, &pair->indexed);
    oracle_create(&pair->def, &pair->listed);
    oracle_grid_free(&pair->listed.grid);
    oracle_grid_create(pair->indexed.grid.mesh, UINT32_MAX, &pair->listed.grid);
    assert_int_equal(pair->listed.grid.size, 1);
}

static void free_pair(struct pair *pair)
{
    oracle_free(&pair->indexed);
    oracle_free(&pair->listed);
    cml_mesh_surface_free(pair->def.mesh);
}

/* Draws a point on the surface and moves it by 1e-17 to 1; in half of the cases along one axis only. */
static void choose_point(const struct oracle *oracle, struct dice *dice, double q[3])
{
    const struct place place = oracle_place(oracle, (enum place_kind)dice_below(dice, 3), dice);
    const double away = pow(10, dice_between(dice, -17, 0));
    double u[3];
    dice_direction(dice, u);
    const int axis = dice_below(dice, 6);
    for (int k = 0; k < 3; k++) q[k] = place.point[k] + (axis < 3 && k != axis ? 0 : away * u[k]);
}

static void compare(double power, double height, double shear)
{
    struct pair pair;
    make_pair(&pair, power, height, shear);
    struct dice dice = dice_new(11);
    int below = 0, near = 0;
    for (int i = 0; i < POINTS; i++) {
        const double distance = pow(10, dice_between(&dice, -17, 0));
        double q[3];
        choose_point(&pair.indexed, &dice, q);
        const bool is_below = oracle_below(&pair.listed, q), is_near = oracle_near(&pair.listed, q, distance);
        if (oracle_below(&pair.indexed, q) != is_below || oracle_near(&pair.indexed, q, distance) != is_near)
            fail_msg("(%.17g %.17g %.17g) within %g: below %d, near %d from all triangles", q[0], q[1], q[2],
                     distance, is_below, is_near);
        below += is_below;
        near += is_near;
    }
    assert_in_range(below, POINTS / 10, POINTS - POINTS / 10);
    assert_in_range(near, POINTS / 10, POINTS - POINTS / 10);
    const struct oracle_grid *grid = &pair.indexed.grid;
    if (power > 1) assert_true(grid->tree[grid->size * grid->size] > 0);
    free_pair(&pair);
}

static void cells_answer_like_all_triangles(void **state)
{
    (void)state;
    compare(1, 0.05, 0);
    compare(1, 0.5, 0.9);
}

static void trees_answer_like_all_triangles(void **state)
{
    (void)state;
    compare(3, 0.01, 0);
    compare(9, 1e-4, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cells_answer_like_all_triangles),
        cmocka_unit_test(trees_answer_like_all_triangles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
