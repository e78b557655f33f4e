/* Tests of boxes, volumes and meshes of bodies: the box holds the body and touches it; the mesh keeps the
 * volume and stays as close to the body as asked. SPDX-License-Identifier: MIT */
#include "scene/body/body_shape.h"

#include "lib/solids.h"

static struct cml_scene_body any_body(int form, struct dice *dice)
{
    const struct cml_convex solid = any_solid(form ? CML_CONVEX_CYLINDER : CML_CONVEX_SPHERE, dice);
    struct cml_scene_body body = {.form = form ? CML_BODY_CYLINDER : CML_BODY_SPHERE, .radius = solid.radius};
    for (int k = 0; k < 3; k++) {
        body.centre[k] = solid.centre[k];
        body.end[k] = solid.centre[k] + solid.length * solid.axis[k];
    }
    return body;
}

static void boxes_hold_the_body_and_touch_it(void **state)
{
    struct dice dice = dice_new(51);
    (void)state;
    for (int i = 0; i < 20000; i++) {
        const struct cml_scene_body body = any_body(i % 2, &dice);
        const struct cml_convex solid = cml_body_convex(&body);
        double box[2][3];
        cml_body_box(&body, box[0], box[1]);
        for (int k = 0; k < 6; k++) {
            wide n[3] = {0, 0, 0}, point[3];
            n[k % 3] = k < 3 ? -1 : 1;
            solid_furthest(&solid, n, point);
            assert_near("box", box[k / 3][k % 3], (double)point[k % 3], 1e-14);
        }
    }
}

static wide mesh_volume(const struct cml_mesh *mesh)
{
    wide volume = 0;
    for (size_t t = 0; t < mesh->num_triangles; t++) {
        wide c[3][3];
        for (int i = 0; i < 3; i++) wide_from(mesh->vertex[mesh->triangle[t][i]], c[i]);
        for (int k = 0; k < 3; k++)
            volume +=
                c[0][k] * (c[1][(k + 1) % 3] * c[2][(k + 2) % 3] - c[1][(k + 2) % 3] * c[2][(k + 1) % 3]) / 6;
    }
    return volume;
}

/* Draws a place on a facet, sometimes a corner or a point of an edge. */
static void place_on_facet(const struct cml_mesh *mesh, size_t facet, struct dice *dice, wide p[3])
{
    const int corner = dice_below(dice, 5);
    wide w[3] = {corner == 0, corner == 1, corner == 2};
    if (corner > 2) {
        w[0] = dice_uniform(dice);
        w[1] = corner == 3 ? 1 - w[0] : (1 - w[0]) * dice_uniform(dice);
        w[2] = 1 - w[0] - w[1];
    }
    for (int k = 0; k < 3; k++) {
        p[k] = 0;
        for (int i = 0; i < 3; i++) p[k] += w[i] * mesh->vertex[mesh->triangle[facet][i]][k];
    }
}

/* The mesh of a body keeps its volume and its largest distance. The distance is searched at all facet
 * middles and random places, so the largest one is found to a per cent. */
static void meshes_keep_the_volume_and_come_as_close_as_was_asked(void **state)
{
    struct dice dice = dice_new(52);
    (void)state;
    for (int i = 0; i < 40; i++) {
        const struct cml_scene_body body = any_body(i % 2, &dice);
        const struct cml_convex solid = cml_body_convex(&body);
        const double tolerance = pow(10, dice_between(&dice, -3.5, -1.5));
        const int n = cml_body_segments(body.form, tolerance);
        struct cml_mesh mesh;
        struct cml_error err;
        wide worst = 0;
        assert_int_equal(cml_body_mesh(&body, n, false, &mesh, &err), CML_OK);
        for (size_t t = 0; t < mesh.num_triangles; t++)
            for (int tries = 0; tries < 4; tries++) {
                wide p[3];
                place_on_facet(&mesh, t, &dice, p);
                worst = fmaxl(worst, fabsl(solid_depth(&solid, p)));
            }
        const wide r = body.radius, pi = 3.14159265358979323846264338327950288L,
                   volume = i % 2 ? pi * r * r * (wide)solid.length : 4 * pi / 3 * r * r * r;
        assert_near("volume", (double)(mesh_volume(&mesh) / volume), 1, 1e-12);
        assert_near("volume", cml_body_volume(&body) / (double)volume, 1, 1e-15);
        if (!(worst <= tolerance * r)) fail_msg("%d: off by %Lg of %g", i, worst / r, tolerance);
        if (n > 3 && !(worst > 0.2 * tolerance * r)) fail_msg("%d: finer than asked: %Lg", i, worst / r);
        cml_mesh_clear(&mesh);
    }
}

/* The planes of the prism around a cylinder have the whole cylinder on one side. */
static void prisms_around_a_cylinder_hold_it(void **state)
{
    struct dice dice = dice_new(53);
    (void)state;
    for (int i = 0; i < 200; i++) {
        const struct cml_scene_body body = any_body(1, &dice);
        const struct cml_convex solid = cml_body_convex(&body);
        struct cml_mesh mesh;
        struct cml_error err;
        assert_int_equal(cml_body_mesh(&body, 3 + dice_below(&dice, 60), true, &mesh, &err), CML_OK);
        for (size_t t = 0; t < mesh.num_triangles; t++) {
            wide c[3][3], a[3], b[3], n[3], point[3], from[3];
            for (int k = 0; k < 3; k++) wide_from(mesh.vertex[mesh.triangle[t][k]], c[k]);
            wide_minus(c[1], c[0], a);
            wide_minus(c[2], c[0], b);
            for (int k = 0; k < 3; k++)
                n[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
            solid_furthest(&solid, n, point);
            wide_minus(point, c[0], from);
            assert_true(wide_dot(from, n) <= 1e-14L * wide_length(n));
        }
        cml_mesh_clear(&mesh);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_hold_the_body_and_touch_it),
        cmocka_unit_test(meshes_keep_the_volume_and_come_as_close_as_was_asked),
        cmocka_unit_test(prisms_around_a_cylinder_hold_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
