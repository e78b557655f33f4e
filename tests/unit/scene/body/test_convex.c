/* Tests of distances between convex sets (sphere, cylinder, triangle) and of inside, outside and crossing,
 * by definition: a point is the closest one if no other lies further in the direction of the other set;
 * sets are apart if a plane is between them. SPDX-License-Identifier: MIT */
#include "scene/body/convex.h"

#include "lib/solids.h"

static const wide err_place = 1e-14L; /* coordinates are about 1, in double */

static double corners[2][3][3];

/* Returns a convex set of this form. Triangles take their corners from static arrays: which = 0 for the
 * first set of a pair, 1 for the second. */
static struct cml_convex any_set(int form, int which, struct dice *dice)
{
    struct cml_convex set = {.form = CML_CONVEX_TRIANGLE};
    if (form != CML_CONVEX_TRIANGLE) return any_solid((enum cml_convex_form)form, dice);
    const double size = pow(10, dice_between(dice, -2, 0));
    for (int c = 0; c < 3; c++) {
        for (int k = 0; k < 3; k++) corners[which][c][k] = size * dice_between(dice, -1, 1);
        set.corner[c] = corners[which][c];
    }
    return set;
}

static void move(struct cml_convex *set, int which, const wide by[3])
{
    for (int k = 0; k < 3; k++) {
        set->centre[k] += (double)by[k];
        for (int c = 0; c < 3 && set->form == CML_CONVEX_TRIANGLE; c++) corners[which][c][k] += (double)by[k];
    }
}

/* Returns how far q lies outside of a triangle's plane or edges. */
static wide beside_triangle(const struct cml_convex *set, const wide q[3])
{
    wide corner[3][3], side[3][3], normal[3], most = 0;
    for (int c = 0; c < 3; c++) wide_from(set->corner[c], corner[c]);
    for (int c = 0; c < 3; c++) wide_minus(corner[(c + 1) % 3], corner[c], side[c]);
    for (int k = 0; k < 3; k++)
        normal[k] = side[0][(k + 1) % 3] * side[1][(k + 2) % 3] - side[0][(k + 2) % 3] * side[1][(k + 1) % 3];
    const wide size = wide_length(normal);
    for (int c = 0; c < 3; c++) {
        wide from[3], out[3];
        wide_minus(q, corner[c], from);
        for (int k = 0; k < 3; k++)
            out[k] = side[c][(k + 1) % 3] * normal[(k + 2) % 3] - side[c][(k + 2) % 3] * normal[(k + 1) % 3];
        most = fmaxl(most, wide_dot(from, out) / wide_length(out));
        most = fmaxl(most, fabsl(wide_dot(from, normal)) / size);
    }
    return most;
}

/* Draws a point far from the set, near it, over faces, rims, corners, on the axis, or inside. */
static void aim(const struct cml_convex *set, struct dice *dice, double p[3])
{
    double u[3];
    dice_direction(dice, u);
    const double far = pow(10, dice_between(dice, -6, 1)),
                 along = dice_between(dice, -0.5, 1.5) * set->length;
    for (int k = 0; k < 3; k++) {
        const double from = set->form == CML_CONVEX_TRIANGLE ? set->corner[dice_below(dice, 3)][k]
                                                             : set->centre[k] + along * set->axis[k];
        p[k] = from + far * u[k];
    }
}

static void projections_are_the_closest_points(void **state)
{
    struct dice dice = dice_new(41);
    (void)state;
    for (int i = 0; i < 60000; i++) {
        const struct cml_convex set = any_set(i % 3, 0, &dice);
        double p[3], closest[3];
        wide from[3], q[3], way[3], most[3], beyond[3];
        aim(&set, &dice, p);
        cml_convex_project(&set, p, closest);
        wide_from(p, from);
        wide_from(closest, q);
        wide_minus(from, q, way);
        solid_furthest(&set, way, most);
        wide_minus(most, q, beyond);
        const wide size = 1 + wide_length(from);
        const wide outside =
            set.form == CML_CONVEX_TRIANGLE ? beside_triangle(&set, q) : -solid_depth(&set, q);
        if (!(outside <= err_place * size)) fail_msg("%d: %Lg outside", i, outside);
        const wide distance = wide_length(way), further = wide_dot(beyond, way);
        /* The closer p is, the more the rounding of q changes the direction from p to q. */
        if (!(further <= 4 * err_place * size * (distance + wide_length(beyond))))
            fail_msg("%d: at %Lg a point is further along by %Lg", i, distance, further / distance);
    }
}

/* Outside of a set, the distance is the length to the closest point. Inside, it is the depth below the
 * nearest face. */
static void distances_are_those_of_the_definition(void **state)
{
    struct dice dice = dice_new(42);
    int inside = 0;
    (void)state;
    for (int i = 0; i < 60000; i++) {
        const struct cml_convex set = any_set(i % 2, 0, &dice);
        double p[3], closest[3];
        wide from[3], q[3], way[3];
        aim(&set, &dice, p);
        cml_convex_project(&set, p, closest);
        wide_from(p, from);
        wide_from(closest, q);
        wide_minus(from, q, way);
        const wide depth = solid_depth(&set, from), wanted = depth > 0 ? -depth : wide_length(way);
        assert_near("distance", cml_convex_distance(&set, p), (double)wanted,
                    4 * (double)(err_place * (1 + wide_length(from))));
        inside += depth > 0;
    }
    assert_true(inside > 10000);
}

/* Moves the sets: the first ends at the origin along n, the second begins `gap` behind it. */
static void place_pair(struct cml_convex *a, struct cml_convex *b, const wide n[3], wide gap)
{
    wide end[3], begin[3], back[3];
    for (int k = 0; k < 3; k++) back[k] = -n[k];
    solid_furthest(a, n, end);
    solid_furthest(b, back, begin);
    for (int k = 0; k < 3; k++) {
        end[k] = -end[k];
        begin[k] = gap * n[k] - begin[k];
    }
    move(a, 0, end);
    move(b, 1, begin);
}

/* Returns the least gap (cm) that two sets need to count as apart. Without a sphere it is documented as a
 * thousandth of the larger radius. */
static wide gap_of(const struct cml_convex *a, const struct cml_convex *b)
{
    if (a->form == CML_CONVEX_SPHERE || b->form == CML_CONVEX_SPHERE) return 1e-12L;
    return 1e-3L * fmax(a->radius, b->radius);
}

static void sets_with_a_plane_between_them_are_apart(void **state)
{
    struct dice dice = dice_new(43);
    (void)state;
    for (int i = 0; i < 9000; i++) {
        struct cml_convex a = any_set(i % 3, 0, &dice), b = any_set(i / 3 % 3, 1, &dice);
        double u[3], at[3];
        wide n[3];
        if (a.form == CML_CONVEX_TRIANGLE && b.form == CML_CONVEX_TRIANGLE) continue;
        dice_direction(&dice, u);
        wide_from(u, n);
        place_pair(&a, &b, n, gap_of(&a, &b));
        const enum cml_convex_order order = cml_convex_compare(&a, &b, at);
        if (order != CML_CONVEX_APART) fail_msg("%d: %d of forms %d, %d", i, (int)order, i % 3, i / 3 % 3);
    }
}

/* Two sets with a common point meet. Neither contains the other, because each reaches beyond the other. */
static void sets_with_a_common_point_meet(void **state)
{
    struct dice dice = dice_new(44);
    (void)state;
    for (int i = 0; i < 8000; i++) {
        struct cml_convex a = any_set(i % 2, 0, &dice), b = any_set(i / 2 % 2, 1, &dice);
        double u[3], at[3];
        wide n[3], place[3];
        dice_direction(&dice, u);
        wide_from(u, n);
        const wide depth = 1e-3L * fminl(fmin(a.radius, b.radius),
                                         fmin(a.length > 0 ? a.length : 1, b.length > 0 ? b.length : 1));
        place_pair(&a, &b, n, -depth);
        const enum cml_convex_order order = cml_convex_compare(&a, &b, at);
        if (order != CML_CONVEX_MEET) fail_msg("%d: %d", i, (int)order);
        wide_from(at, place);
        assert_true(solid_depth(&a, place) > -0.1L * a.radius && solid_depth(&b, place) > -0.1L * b.radius);
    }
}

/* Returns the largest distance of points of `inner` from the centre or axis of `outer`. Rims of a cylinder
 * are searched in ever finer steps around the best point. */
static wide farthest(const struct cml_convex *outer, const struct cml_convex *inner)
{
    wide best = 0, best_angle = 0, axis[3], e1[3], e2[3];
    if (inner->form == CML_CONVEX_SPHERE) {
        wide p[3], across[3], centre[3];
        wide_from(inner->centre, p);
        wide_from(outer->centre, centre);
        wide_minus(p, centre, across);
        if (outer->form == CML_CONVEX_CYLINDER) solid_along(outer, p, across);
        return wide_length(across) + inner->radius;
    }
    wide_from(inner->axis, axis);
    const int thin = fabs(inner->axis[0]) < 0.6 ? 0 : 1;
    for (int k = 0; k < 3; k++) e1[k] = (k == thin) - axis[thin] * axis[k];
    const wide size = wide_length(e1);
    for (int k = 0; k < 3; k++) e1[k] /= size;
    for (int k = 0; k < 3; k++)
        e2[k] = axis[(k + 1) % 3] * e1[(k + 2) % 3] - axis[(k + 2) % 3] * e1[(k + 1) % 3];
    for (wide width = 3.2L; width > 1e-9L; width *= 0.05L) {
        const wide middle = best_angle;
        for (int i = -100; i <= 100; i++)
            for (int end = 0; end < 2; end++) {
                const wide angle = middle + width * i / 100;
                wide p[3], centre[3], across[3];
                for (int k = 0; k < 3; k++)
                    p[k] = inner->centre[k] + end * inner->length * axis[k] +
                           inner->radius * (cosl(angle) * e1[k] + sinl(angle) * e2[k]);
                wide_from(outer->centre, centre);
                wide_minus(p, centre, across);
                if (outer->form == CML_CONVEX_CYLINDER) solid_along(outer, p, across);
                if (wide_length(across) <= best) continue;
                best = wide_length(across);
                best_angle = angle;
            }
    }
    return best;
}

/* The outer radius is just large enough or just too small for the inner set; the outer ends are far away. */
static void a_set_inside_another_is_told_from_one_that_reaches_out(void **state)
{
    struct dice dice = dice_new(45);
    (void)state;
    for (int i = 0; i < 2000; i++) {
        struct cml_convex outer = any_set(i % 2, 0, &dice);
        const struct cml_convex inner = any_set(i / 2 % 2, 1, &dice);
        double at[3];
        for (int k = 0; k < 3 && outer.form == CML_CONVEX_CYLINDER; k++)
            outer.centre[k] -= 10 * outer.axis[k];
        if (outer.form == CML_CONVEX_CYLINDER) outer.length = 20;
        const wide least = farthest(&outer, &inner),
                   spare = outer.form == CML_CONVEX_CYLINDER && inner.form == CML_CONVEX_CYLINDER
                               ? 1e-4L * least
                               : 1e-11L;
        outer.radius = (double)(least + spare);
        assert_int_equal(cml_convex_compare(&inner, &outer, at), CML_CONVEX_FIRST_INSIDE);
        assert_int_equal(cml_convex_compare(&outer, &inner, at), CML_CONVEX_SECOND_INSIDE);
        outer.radius = (double)(least - 1e-11L);
        assert_int_equal(cml_convex_compare(&inner, &outer, at), CML_CONVEX_MEET);
    }
}

/* The outer cylinder is just long enough or just too short for the inner set; the outer side is far away. */
static void a_set_between_two_ends_is_told_from_one_that_passes_them(void **state)
{
    struct dice dice = dice_new(46);
    (void)state;
    for (int i = 0; i < 2000; i++) {
        struct cml_convex outer = any_set(CML_CONVEX_CYLINDER, 0, &dice);
        const struct cml_convex inner = any_set(i % 2, 1, &dice);
        double at[3];
        wide axis[3], back[3], last[3], first[3], across[3];
        solid_axis(&outer, axis);
        for (int k = 0; k < 3; k++) back[k] = -axis[k];
        solid_furthest(&inner, axis, last);
        solid_furthest(&inner, back, first);
        const wide begin = solid_along(&outer, first, across), end = solid_along(&outer, last, across);
        outer.radius = 10;
        for (int sign = -1; sign <= 1; sign += 2) {
            struct cml_convex tight = outer;
            for (int k = 0; k < 3; k++) tight.centre[k] += (double)((begin - sign * 1e-11L) * axis[k]);
            tight.length = (double)(end - begin + sign * 2e-11L);
            assert_int_equal(cml_convex_compare(&inner, &tight, at),
                             sign > 0 ? CML_CONVEX_FIRST_INSIDE : CML_CONVEX_MEET);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(projections_are_the_closest_points),
        cmocka_unit_test(distances_are_those_of_the_definition),
        cmocka_unit_test(sets_with_a_plane_between_them_are_apart),
        cmocka_unit_test(sets_with_a_common_point_meet),
        cmocka_unit_test(a_set_inside_another_is_told_from_one_that_reaches_out),
        cmocka_unit_test(a_set_between_two_ends_is_told_from_one_that_passes_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
