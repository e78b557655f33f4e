/* Tests of rays that are answered many at a time over sheets: answers equal the program's own query bit
 * for bit, and the exact query. SPDX-License-Identifier: MIT */
#include "lib/mesh_shapes.h"
#include "port.h"
#include "surface/bounds/cell_horizon.h"
#include "surface/bounds/depth_map.h"
#include "surface/mesh/grid_lanes_inl.h"
#include "surface/mesh/mesh_surface.h"

enum { ROUNDS = 10000 };

struct subject {
    struct cml_mesh_surface *surface;
    struct cml_depth_map map;
    struct cml_depth_bounds depths;
};

static struct subject subject_of(const struct patch *patch)
{
    struct subject s;
    struct cml_error err = {CML_OK, ""};
    struct cml_mesh mesh = patch_mesh(patch);
    assert_int_equal(cml_depth_map_of_mesh(&mesh, &s.map, &err), CML_OK);
    assert_int_equal(cml_mesh_surface_create(&mesh, 0, 0, CML_SEARCH_AUTO, &s.surface, &err), CML_OK);
    s.depths = (struct cml_depth_bounds){.size = s.map.size,
                                         .corner_x = (real)s.map.corner[0],
                                         .corner_y = (real)s.map.corner[1],
                                         .per_cell = (real)(1 / s.map.cell[0]),
                                         .horizon_level = CML_HORIZON_LEVEL};
    return s;
}

static void subject_free(struct subject *s)
{
    cml_mesh_surface_free(s->surface);
    cml_depth_map_clear(&s->map);
}

static int query(const struct subject *s, const double p[3], const double u[3], double side, double t_max,
                 int exact, struct cml_mesh_crossing *crossing)
{
    const double err = 4 * (double)CML_EPSILON * (fabs(p[0]) + fabs(p[1]) + fabs(p[2]));
    return cml_mesh_surface_hit(s->surface, p, u, side > 0, t_max, -1, 0, exact, err, crossing);
}

/* Draws a place on the given side of the mesh, mostly close to it, over it or beside it. */
static void place(struct dice *dice, const struct subject *s, double side, double p[3])
{
    const double down[3] = {0, 0, -side};
    struct cml_mesh_crossing crossing;
    for (int k = 0; k < 2; k++) p[k] = (double)(real)dice_between(dice, -1.3, 1.3);
    p[2] = 10 * side;
    assert_true(query(s, p, down, side, INFINITY, 1, &crossing));
    p[2] = (double)(real)(10 * side - side * crossing.t + side * exp(dice_between(dice, -9, -1)));
}

static void fill(struct dice *dice, const struct subject *s, double side, struct cml_grid_lanes *l)
{
    l->count = 1 + (int)dice_below(dice, CML_GRID_LANES);
    for (int k = 0; k < l->count; k++) {
        double p[3], u[3];
        place(dice, s, side, p);
        dice_direction(dice, u);
        if (dice_below(dice, 4)) u[2] = -side * fabs(u[2]);
        l->x[k] = (real)p[0];
        l->y[k] = (real)p[1];
        l->z[k] = (real)p[2];
        l->ux[k] = (real)u[0];
        l->uy[k] = (real)u[1];
        l->uz[k] = (real)u[2];
        l->s[k] = (real)exp(dice_between(dice, -6, 1));
    }
}

/* True if `kept` is the rounding of `number` that the engine keeps. The program's own query leaves rays
 * near edges to the exact query, which sums distances in another order; a distance of almost 0 is then
 * only rounding. */
static bool is_kept(real kept, double number)
{
    return kept == (real)number || fabs((double)kept - number) < 1e-15;
}

static bool is_same(const struct cml_grid_lanes *l, int k, const struct cml_mesh_crossing *c)
{
    return l->primitive[k] == c->primitive && is_kept(l->t[k], c->t) && is_kept(l->at_x[k], c->point[0]) &&
           is_kept(l->at_y[k], c->point[1]) && is_kept(l->at_z[k], c->point[2]) &&
           is_kept(l->normal_x[k], c->normal[0]) && is_kept(l->normal_y[k], c->normal[1]) &&
           is_kept(l->normal_z[k], c->normal[2]);
}

static void check(const struct subject *s, double side, const struct cml_grid_lanes *l, int k)
{
    const double p[3] = {(double)l->x[k], (double)l->y[k], (double)l->z[k]},
                 u[3] = {(double)l->ux[k], (double)l->uy[k], (double)l->uz[k]};
    struct cml_mesh_crossing own, exact;
    const int met = l->answer[k] == CML_GRID_MET, found = query(s, p, u, side, (double)l->s[k], 0, &own);
    assert_int_equal(met, found);
    assert_int_equal(met, query(s, p, u, side, (double)l->s[k], 1, &exact));
    if (met && !is_same(l, k, &own))
        fail_msg("facet %d for %d, t %.9g for %.9g", l->primitive[k], own.primitive, (double)l->t[k], own.t);
    if (met && own.primitive != exact.primitive) fail_msg("facet %d for %d", own.primitive, exact.primitive);
}

/* least: least share of rays that must be answered. */
static void check_patch(const struct patch *patch, double least)
{
    static struct cml_grid_lanes l;
    struct subject s = subject_of(patch);
    struct dice dice = dice_new(3);
    long asked = 0, met = 0, missed = 0;
    assert_true(cml_mesh_surface_is_sheet(s.surface));
    for (int n = 0; n < ROUNDS; n++) {
        const double side = n & 1 ? 1 : -1;
        struct cml_grid_view view = {
            .depths = &s.depths, .horizons = s.map.horizon[side < 0], .side = (real)side};
        view.grid = cml_mesh_surface_grid(s.surface, &view.centred);
        fill(&dice, &s, side, &l);
        cml_grid_lanes_ask(&view, &l);
        for (int k = 0; k < l.count; k++) {
            asked++;
            met += l.answer[k] == CML_GRID_MET;
            missed += l.answer[k] == CML_GRID_MISSED;
            if (l.answer[k] != CML_GRID_UNDECIDED) check(&s, side, &l, k);
        }
    }
    printf("%ld rays, %ld met, %ld missed\n", asked, met, missed);
    assert_true((double)met > least * (double)asked && (double)missed > least * (double)asked);
    subject_free(&s);
}

static struct patch patch;

static void regular_sheets_answer_as_the_query_does(void **state)
{
    (void)state;
    patch_make(&patch, 5, 0.01, 0, 0, 0);
    check_patch(&patch, 0.2);
    patch_make(&patch, 6, 0.05, 0, 0, 0);
    check_patch(&patch, 0.02);
    patch_make(&patch, 7, 0.01, 0, 0, 0);
    patch_spike(&patch, GRID / 3, GRID / 3, 0.2);
    check_patch(&patch, 0.1);
}

static void irregular_sheets_answer_as_the_query_does(void **state)
{
    (void)state;
    patch_make(&patch, 5, 0.01, 0, 0, 0);
    patch_move(&patch, 8, 0.2);
    check_patch(&patch, 0.2);
    patch_make(&patch, 6, 0.05, 0, 0, 0);
    patch_move(&patch, 9, 0.2);
    check_patch(&patch, 0.02);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(regular_sheets_answer_as_the_query_does),
        cmocka_unit_test(irregular_sheets_answer_as_the_query_does),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
