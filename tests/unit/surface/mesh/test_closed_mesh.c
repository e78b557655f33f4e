/* Tests of fast queries (single precision) from inside closed meshes: long thin facets at grazing angles,
 * compared with the exact query, and a body so small and deep that rounding of positions exceeds its size.
 * SPDX-License-Identifier: MIT */
#include "geometry/vec3.h"
#include "lib/dice.h"
#include "scene/body/body_shape.h"
#include "surface/mesh/mesh_surface.h"

#include <float.h>
#include <math.h>

/* Returns a cylinder whose ends are fans of needle-shaped facets. */
static struct cml_mesh_surface *make_cylinder(const double start[3], const double end[3], double radius)
{
    struct cml_scene_body body = {.form = CML_BODY_CYLINDER, .radius = radius};
    struct cml_mesh_surface *surface;
    struct cml_mesh mesh;
    struct cml_error err = {CML_OK, ""};
    cml_vec3_copy(start, body.centre);
    cml_vec3_copy(end, body.end);
    assert_int_equal(cml_body_mesh(&body, 140, false, &mesh, &err), CML_OK);
    mesh.normals = CML_NORMALS_VERTEX;
    assert_int_equal(cml_mesh_surface_create(&mesh, 0, 0, CML_SEARCH_TREE, &surface, &err), CML_OK);
    return surface;
}

static int leaves(const struct cml_mesh_surface *surface, const double p[3], const double u[3], int exclude,
                  double t_max, int exact)
{
    struct cml_mesh_crossing crossing;
    const double err_position = 4 * FLT_EPSILON * (fabs(p[0]) + fabs(p[1]) + fabs(p[2]));
    return cml_mesh_surface_hit(surface, p, u, 1, t_max, exclude, 0, exact, err_position, &crossing);
}

static double height_over(const double end[3], const double axis[3], const double p[3])
{
    double from[3];
    cml_vec3_subtract(p, end, from);
    return cml_vec3_dot(from, axis);
}

/* Draws a float place on a facet of the cylinder's side that has two corners at the given end. `share`:
 * position from that end towards the third corner. Returns the facet. */
static int place_on_side(const struct cml_mesh_surface *surface, const double end[3], const double axis[3],
                         struct dice *dice, double share, double p[3])
{
    double middle[3], corner[3][3];
    const struct cml_mesh *mesh = cml_mesh_surface_mesh(surface, middle);
    for (;;) {
        const int facet = dice_below(dice, (int)mesh->num_triangles), k = dice_below(dice, 3);
        for (int i = 0; i < 3; i++)
            cml_vec3_add_scaled(middle, 1, mesh->vertex[mesh->triangle[facet][(i + k) % 3]], corner[i]);
        if (height_over(end, axis, corner[0]) < -0.1 || height_over(end, axis, corner[1]) < -0.1 ||
            height_over(end, axis, corner[2]) > -0.1)
            continue;
        const double s = dice_uniform(dice);
        for (int i = 0; i < 3; i++)
            p[i] = (double)(float)((1 - share) * (s * corner[0][i] + (1 - s) * corner[1][i]) +
                                   share * corner[2][i]);
        return facet;
    }
}

/* Draws a direction at a given angle to the plane of the end, towards a point near its middle. */
static void choose_direction(const double end[3], const double axis[3], double sine, struct dice *dice,
                             const double p[3], double u[3])
{
    double to[3], aside[3];
    cml_vec3_subtract(end, p, to);
    cml_vec3_add_scaled(to, -cml_vec3_dot(to, axis), axis, to);
    cml_vec3_cross(axis, to, aside);
    cml_vec3_add_scaled(to, dice_between(dice, -1, 1), aside, to);
    cml_vec3_normalise(to);
    cml_vec3_add_scaled(to, sine, axis, u);
}

/* Flights from the side through the end of an oblique cylinder at 1e-6 to 1e-4 rad, which stop beyond the
 * end by more than rounding, meet it. */
static void a_grazed_end_is_not_missed(void **state)
{
    (void)state;
    const double start[3] = {0.1, 0.2, 0.3}, end[3] = {0.3, -0.1, 0.7}, radius = 0.2;
    struct cml_mesh_surface *surface = make_cylinder(start, end, radius);
    struct dice dice = dice_new(3);
    int crossed = 0, missed = 0;
    double axis[3];
    cml_vec3_subtract(end, start, axis);
    cml_vec3_normalise(axis);
    for (int i = 0; i < 200000; i++) {
        const double sine = pow(10, dice_between(&dice, -6, -4)), length = dice_between(&dice, 0, 2 * radius);
        double p[3], u[3], last[3];
        const int facet = place_on_side(surface, end, axis, &dice, sine * length * dice_uniform(&dice), p);
        choose_direction(end, axis, sine, &dice, p, u);
        cml_vec3_add_scaled(p, length, u, last);
        if (height_over(end, axis, last) < 1e-6 || !leaves(surface, p, u, facet, length, 1)) continue;
        crossed++;
        missed += !leaves(surface, p, u, facet, length, 0);
    }
    assert_in_range(crossed, 20000, 200000);
    if (missed) fail_msg("%d of %d crossings missed", missed, crossed);
    cml_mesh_surface_free(surface);
}

/* Packets deep in a layer that rounding has put beside the rim of a small body leave that body. */
static void a_small_body_is_left_from_beside_it(void **state)
{
    (void)state;
    const double start[3] = {0, 0, 0.5}, end[3] = {0, 0, 0.501}, radius = 1e-4;
    struct cml_mesh_surface *surface = make_cylinder(start, end, radius);
    struct dice dice = dice_new(5);
    int missed = 0;
    for (int i = 0; i < 20000; i++) {
        const double phi = dice_between(&dice, 0, 6.283185307179586);
        double u[3];
        const double p[3] = {(double)(float)(radius * cos(phi)), (double)(float)(radius * sin(phi)),
                             (double)nextafterf((float)end[2], 1)};
        dice_direction(&dice, u);
        missed += !leaves(surface, p, u, -1, INFINITY, 0);
    }
    if (missed) fail_msg("%d packets never left", missed);
    cml_mesh_surface_free(surface);
}

/* Vertex normals are interpolated over a facet: the fast search gives the normal of the crossing. */
static void normals_are_those_of_the_exact_query(void **state)
{
    (void)state;
    const double start[3] = {0.1, 0.2, 0.3}, end[3] = {0.3, -0.1, 0.7};
    struct cml_mesh_surface *surface = make_cylinder(start, end, 0.2);
    struct dice dice = dice_new(7);
    for (int i = 0; i < 20000; i++) {
        struct cml_mesh_crossing fast, exact;
        double u[3];
        const double p[3] = {0.2 + dice_between(&dice, -0.05, 0.05), 0.05, 0.5};
        dice_direction(&dice, u);
        assert_true(cml_mesh_surface_hit(surface, p, u, 1, INFINITY, -1, 0, 0, 1e-7, &fast));
        assert_true(cml_mesh_surface_hit(surface, p, u, 1, INFINITY, -1, 0, 1, 1e-7, &exact));
        for (int k = 0; k < 3; k++) assert_true(fabs(fast.normal[k] - exact.normal[k]) < 1e-6);
    }
    cml_mesh_surface_free(surface);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_grazed_end_is_not_missed),
        cmocka_unit_test(a_small_body_is_left_from_beside_it),
        cmocka_unit_test(normals_are_those_of_the_exact_query),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
