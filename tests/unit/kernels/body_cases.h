/* Cases of kernels/body.h, compiled once in float and once in double. Lines almost parallel to a cylinder
 * pass its axis at a great distance; their crossings are compared with the definition of the cylinder in
 * long double. SPDX-License-Identifier: MIT */
#include "geometry/vec3.h"
#include "lib/solids.h"

#include "body.h"

static const double eps = (double)CML_EPSILON;

struct lengthwise {
    struct cml_body body;
    struct cml_convex solid; /* the same cylinder, as rounded */
    struct cml_vec p, u;     /* p counts from the middle of the first end */
    double rounding; /* cm: allowed distance of a place from the surface; the way to it may be off by 8 of
                        these */
};

static void to_wide(struct cml_vec v, wide out[3])
{
    out[0] = (wide)v.x;
    out[1] = (wide)v.y;
    out[2] = (wide)v.z;
}

static void any_cylinder(struct lengthwise *line, struct dice *dice)
{
    double axis[3];
    dice_direction(dice, axis);
    line->body = (struct cml_body){.axis = {(real)axis[0], (real)axis[1], (real)axis[2]},
                                   .radius = (real)pow(10, dice_between(dice, -2, 0)),
                                   .length = (real)pow(10, dice_between(dice, -2, 0.5))};
    line->solid = (struct cml_convex){
        .form = CML_CONVEX_CYLINDER,
        .axis = {(double)line->body.axis.x, (double)line->body.axis.y, (double)line->body.axis.z},
        .radius = (double)line->body.radius,
        .length = (double)line->body.length};
}

/* Draws a line at 1e-9 to 1e-1 rad to the axis, from a place at `along` on the axis. In half of all cases
 * the place lies on the side of the cylinder, but for rounding. */
static void any_line(struct lengthwise *line, double along, struct dice *dice)
{
    double e[3], e1[3], e2[3], size, phi = dice_between(dice, 0, 6.3),
                                     angle = pow(10, dice_between(dice, -9, -1));
    const double *axis = line->solid.axis, sign = dice_below(dice, 2) ? 1 : -1;
    const double out = line->solid.radius * (dice_below(dice, 2) ? 1 : dice_between(dice, 0, 1.1));
    dice_direction(dice, e);
    cml_vec3_cross(axis, e, e1);
    size = sqrt(cml_vec3_dot(e1, e1));
    for (int k = 0; k < 3; k++) e1[k] /= size;
    cml_vec3_cross(axis, e1, e2);
    double p[3], u[3];
    for (int k = 0; k < 3; k++) {
        p[k] = along * axis[k] + out * e1[k];
        u[k] = sign * cos(angle) * axis[k] + sin(angle) * (cos(phi) * e1[k] + sin(phi) * e2[k]);
    }
    line->p = (struct cml_vec){(real)p[0], (real)p[1], (real)p[2]};
    line->u = (struct cml_vec){(real)u[0], (real)u[1], (real)u[2]};
    line->rounding = 32 * eps * (line->solid.length + line->solid.radius + fabs(along));
}

/* Returns how far (cm) the point at distance t of the line lies inside the cylinder. */
static double depth_at(const struct lengthwise *line, double t)
{
    wide p[3], u[3];
    to_wide(line->p, p);
    to_wide(line->u, u);
    for (int k = 0; k < 3; k++) p[k] += (wide)t * u[k];
    return (double)solid_depth(&line->solid, p);
}

static void assert_on_surface(const struct lengthwise *line, const struct cml_body_hit *at)
{
    struct cml_hit hit;
    wide place[3];
    cml_place_on_body(&line->body, at, &hit);
    to_wide(hit.point, place);
    assert_near("place on the surface", (double)solid_depth(&line->solid, place), 0, line->rounding);
    assert_near("place on the line", depth_at(line, (double)at->t), 0, 8 * line->rounding);
}

/* A packet inside the cylinder has a crossing ahead, and its way there lies inside. */
static void a_packet_leaves_where_its_line_does(void **state)
{
    struct dice dice = dice_new(71);
    (void)state;
    for (int i = 0; i < repeats(300000); i++) {
        struct lengthwise line;
        any_cylinder(&line, &dice);
        any_line(&line, line.solid.length * dice_uniform(&dice), &dice);
        if (depth_at(&line, 0) < -line.rounding / 8) continue;
        struct cml_body_hit at;
        const struct cml_vec off = {0, 0, 0};
        const struct cml_cylinder_line seen = cml_cylinder_line_of(&line.body, line.p, line.u, -1, off, 1);
        cml_leave_cylinder(&seen, &at);
        assert_on_surface(&line, &at);
        for (int k = 1; k < 4; k++) assert_true(depth_at(&line, (double)at.t * k / 4) > -8 * line.rounding);
    }
}

/* A packet before an end of the cylinder: a crossing that is found lies on the surface, and a line that
 * clearly passes the inside has one. */
static void a_packet_enters_where_its_line_does(void **state)
{
    struct dice dice = dice_new(72);
    int met = 0;
    (void)state;
    for (int i = 0; i < repeats(300000); i++) {
        struct lengthwise line;
        any_cylinder(&line, &dice);
        const double before = line.solid.length * pow(10, dice_between(&dice, -3, 0.5));
        any_line(&line, dice_below(&dice, 2) ? -before : line.solid.length + before, &dice);
        struct cml_body_hit at;
        const struct cml_vec off = {0, 0, 0};
        const struct cml_cylinder_line seen = cml_cylinder_line_of(&line.body, line.p, line.u, -1, off, 0);
        const int found = cml_enter_cylinder(&seen, &at);
        met += found;
        if (found) assert_on_surface(&line, &at);
        const double away = (double)cml_dot(line.p, line.body.axis),
                     rise = (double)cml_dot(line.u, line.body.axis);
        const double middle = (line.solid.length / 2 - away) / rise;
        assert_true(found || middle < 0 || depth_at(&line, middle) < line.rounding);
    }
    assert_true(met > repeats(30000));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_packet_leaves_where_its_line_does),
        cmocka_unit_test(a_packet_enters_where_its_line_does),
    };
    return cmocka_run_group_tests_name("body", tests, NULL, NULL);
}
