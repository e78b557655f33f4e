/* Tests of the grid of cells that bounds where surfaces of bodies are, against all surfaces in long
 * double.
 * A cell whose ball is said to hold no surface has none, with CML_CELL_MARGIN to spare. Otherwise the
 * surfaces in the ball belong to the body named by the cell, lie between its two planes, and are turned no
 * more than stated. SPDX-License-Identifier: MIT */
#include "surface/bounds/body_grid.h"

#include "lib/solids.h"
#include "scene/body/body_shape.h"
#include "types.h"

enum { MOST_BODIES = 12 };

static struct cml_scene_body bodies[MOST_BODIES];
static struct cml_medium_def media[3 + MOST_BODIES];

/* Finds the point of a triangle closest to p, in the triangle's plane or on an edge, and the normal there. */
static void closest_of_triangle(const struct cml_mesh *mesh, size_t facet, const wide p[3], wide best[3],
                                wide normal[3])
{
    wide c[3][3], side[3][3], least = INFINITY;
    int inside = 1;
    for (int i = 0; i < 3; i++) wide_from(mesh->vertex[mesh->triangle[facet][i]], c[i]);
    for (int i = 0; i < 3; i++) wide_minus(c[(i + 1) % 3], c[i], side[i]);
    for (int k = 0; k < 3; k++)
        normal[k] = side[0][(k + 1) % 3] * side[1][(k + 2) % 3] - side[0][(k + 2) % 3] * side[1][(k + 1) % 3];
    const wide size = wide_length(normal);
    for (int k = 0; k < 3; k++) normal[k] /= size;
    for (int i = 0; i < 3; i++) {
        wide from[3], at[3], off[3];
        wide_minus(p, c[i], from);
        const wide s = fmaxl(0, fminl(1, wide_dot(from, side[i]) / wide_dot(side[i], side[i])));
        const wide turn[3] = {side[i][1] * from[2] - side[i][2] * from[1],
                              side[i][2] * from[0] - side[i][0] * from[2],
                              side[i][0] * from[1] - side[i][1] * from[0]};
        inside &= wide_dot(turn, normal) >= 0;
        for (int k = 0; k < 3; k++) at[k] = c[i][k] + s * side[i][k];
        wide_minus(at, p, off);
        if (wide_length(off) >= least) continue;
        least = wide_length(off);
        memcpy(best, at, sizeof at);
    }
    if (!inside) return;
    wide from[3];
    wide_minus(p, c[0], from);
    for (int k = 0; k < 3; k++) best[k] = p[k] - wide_dot(from, normal) * normal[k];
}

/* Finds the point of a sphere or cylinder closest to p: on its nearest face, or on two faces at once if p
 * is outside of both. */
static void closest_of_solid(const struct cml_convex *solid, const wide p[3], wide best[3], wide normal[3])
{
    wide across[3], axis[3], centre[3];
    solid_axis(solid, axis);
    wide_from(solid->centre, centre);
    if (solid->form == CML_CONVEX_SPHERE) {
        wide_minus(p, centre, normal);
        normal[0] += wide_length(normal) > 0 ? 0 : 1; /* all points are equally close to the very middle */
        const wide size = wide_length(normal);
        for (int k = 0; k < 3; k++) {
            normal[k] /= size;
            best[k] = centre[k] + solid->radius * normal[k];
        }
        return;
    }
    const wide along = solid_along(solid, p, across), r = solid->radius;
    wide out = wide_length(across);
    if (!(out > 0)) {
        const int thin = fabs(solid->axis[0]) < 0.6 ? 0 : 1;
        for (int k = 0; k < 3; k++) across[k] = 1e-30L * ((k == thin) - axis[thin] * axis[k]);
        out = wide_length(across);
    }
    const wide end = along > 0.5L * solid->length ? solid->length : 0, beyond = fabsl(along - end);
    const int outside = along < 0 || along > solid->length;
    const int at_end = outside || (out < r && beyond < r - out);
    const wide height = at_end ? end : along, radius = at_end && out < r ? out : r;
    for (int k = 0; k < 3; k++) {
        best[k] = centre[k] + height * axis[k] + radius * across[k] / out;
        normal[k] = at_end ? (end > 0 ? axis[k] : -axis[k]) : across[k] / out;
    }
}

/* Finds the point of a body's surface closest to p, and the outward normal of a face there. Returns the
 * distance. */
static wide closest_of_body(const struct cml_scene_body *body, const wide p[3], wide best[3], wide normal[3])
{
    wide least = INFINITY, off[3];
    if (body->form != CML_BODY_MESH) {
        const struct cml_convex solid = cml_body_convex(body);
        closest_of_solid(&solid, p, best, normal);
        wide_minus(best, p, off);
        return wide_length(off);
    }
    for (size_t t = 0; t < body->mesh.num_triangles; t++) {
        wide at[3], n[3];
        closest_of_triangle(&body->mesh, t, p, at, n);
        wide_minus(at, p, off);
        if (wide_length(off) >= least) continue;
        least = wide_length(off);
        memcpy(best, at, sizeof at);
        memcpy(normal, n, sizeof n);
    }
    return least;
}

/* The cell of the grid under test. */
struct looked_at {
    const struct cml_body_ball *ball;
    wide middle[3], cell, radius; /* radius: of the ball with its margin, cm */
};

/* Checks a place of the surface inside the ball against the cell's planes and steepest direction. */
static void check_place(const struct looked_at *at, const wide p[3], const wide normal[3])
{
    wide plane[3], off[3];
    for (int k = 0; k < 3; k++) plane[k] = at->ball->normal[k];
    wide_minus(p, at->middle, off);
    const wide height = wide_dot(off, plane) / at->cell, margin = CML_CELL_MARGIN - 1e-5L;
    const wide turn[3] = {plane[1] * normal[2] - plane[2] * normal[1],
                          plane[2] * normal[0] - plane[0] * normal[2],
                          plane[0] * normal[1] - plane[1] * normal[0]};
    const wide cosine = wide_dot(plane, normal), sine = wide_length(turn);
    if (!(height >= at->ball->lower + margin && height <= at->ball->upper - margin))
        fail_msg("a surface at %Lg, planes %g %g", height, at->ball->lower, at->ball->upper);
    if (at->ball->steepest > 1) return;
    if (!(cosine > 0 && sine <= at->ball->steepest - 0.999e-3L))
        fail_msg("a surface turned by the sine %Lg, not %g", sine, at->ball->steepest);
}

/* Walks on the surface, from one of its places in shrinking steps, to its highest (or lowest) point in the
 * ball. */
static void climb(const struct looked_at *at, const struct cml_scene_body *body, wide sign, struct dice *dice)
{
    wide p[3], normal[3], off[3], from[3], step = 1;
    double u[3];
    dice_direction(dice, u);
    for (int k = 0; k < 3; k++) from[k] = at->middle[k] + at->radius * u[k] * cbrt(dice_uniform(dice));
    for (int tries = 0; tries < 24; tries++) {
        closest_of_body(body, from, p, normal);
        wide_minus(p, at->middle, off);
        const bool in_ball = wide_length(off) < at->radius;
        if (in_ball) check_place(at, p, normal);
        dice_direction(dice, u);
        step *= 0.8L;
        for (int k = 0; k < 3; k++)
            from[k] = (in_ball ? p[k] : 0.5L * (p[k] + at->middle[k])) +
                      step * at->cell * (sign * at->ball->normal[k] + 0.5L * u[k]);
    }
}

/* Checks one cell. Returns true if a surface comes close to the bound of the cell. */
static bool check_cell(const struct looked_at *at, int count, struct dice *dice)
{
    wide p[3], normal[3], least = INFINITY;
    for (int b = 0; b < count; b++) {
        const wide distance = closest_of_body(&bodies[b], at->middle, p, normal);
        if (b == at->ball->body) continue;
        least = fminl(least, distance);
        if (!(at->ball->radius <= 0 || distance >= at->radius * (1 - 1e-6L)))
            fail_msg("body %d is at %Lg, the ball %Lg", b, distance / at->cell, at->radius / at->cell);
    }
    for (int i = 0; i < 8 && at->ball->body >= 0; i++)
        climb(at, &bodies[at->ball->body], i % 2 ? 1 : -1, dice);
    return least < at->radius * 1.001L;
}

/* Makes spheres, cylinders and meshes of few facets, which may lie inside or across each other. */
static void make_bodies(int count, double size, struct dice *dice)
{
    for (int b = 0; b < count; b++) {
        const int form = dice_below(dice, 4);
        const struct cml_convex solid = any_solid(form % 2 ? CML_CONVEX_CYLINDER : CML_CONVEX_SPHERE, dice);
        struct cml_scene_body body = {.form = form % 2 ? CML_BODY_CYLINDER : CML_BODY_SPHERE,
                                      .layer = 1,
                                      .host = 1,
                                      .radius = size * solid.radius};
        struct cml_error err;
        for (int k = 0; k < 3; k++) {
            body.centre[k] = solid.centre[k] + (k == 2);
            body.end[k] = body.centre[k] + size * solid.length * solid.axis[k];
        }
        bodies[b] = body;
        if (form < 2) continue;
        assert_int_equal(cml_body_mesh(&body, 3 + dice_below(dice, 2), false, &bodies[b].mesh, &err), CML_OK);
        bodies[b].form = CML_BODY_MESH;
    }
}

/* Tests random grids. Frames begin at the depth given here; x and y of the grid are those of the scene. */
static void cells_say_no_more_than_is_true(void **state)
{
    struct dice dice = dice_new(71);
    struct cml_beam beam = {0};
    int with_planes = 0, tight = 0;
    (void)state;
    for (int number = 0; number < 40; number++) {
        const int count = 1 + dice_below(&dice, number % 2 ? 3 : MOST_BODIES);
        const double depths[2] = {0, number % 3 ? 0.3 : 0};
        struct cml_scene scene = {.num_layers = 1,
                                  .num_bodies = count,
                                  .bodies = bodies,
                                  .media = media,
                                  .num_beams = 1,
                                  .beams = &beam};
        struct cml_body_grids grids;
        struct cml_error err;
        make_bodies(count, pow(10, dice_between(&dice, -0.7, 0.3)), &dice);
        media[1].mus = pow(10, dice_between(&dice, 0, 3));
        assert_int_equal(cml_body_grids_create(&scene, (double[]){beam.x, beam.y}, depths, &grids, &err),
                         CML_OK);
        const struct cml_body_cells *cells = &grids.item[grids.of_medium[1]];
        for (int look = 0; look < repeats(120); look++) {
            const int x = dice_below(&dice, cells->n[0]), y = dice_below(&dice, cells->n[1]),
                      z = dice_below(&dice, cells->n[2]), place[3] = {x, y, z};
            const struct cml_body_ball *ball =
                &grids.ball[cells->first + (size_t)((z * cells->n[1] + y) * cells->n[0] + x)];
            struct looked_at at = {.ball = ball, .cell = cells->cell};
            for (int k = 0; k < 3; k++)
                at.middle[k] = (wide)cells->corner[k] + (place[k] + 0.5L) * (wide)cells->cell;
            at.middle[2] += depths[1];
            at.radius = ((wide)ball->radius + CML_CELL_MARGIN) * at.cell;
            tight += check_cell(&at, count, &dice);
            with_planes += ball->body >= 0;
        }
        cml_body_grids_clear(&grids);
        for (int b = 0; b < count; b++) cml_mesh_clear(&bodies[b].mesh);
    }
    assert_true(with_planes > repeats(250) && tight > repeats(300));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(cells_say_no_more_than_is_true)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
