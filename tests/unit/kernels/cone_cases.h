/* Cases of kernels/cone.h (rays against rings, which are parts of cones) whose answers are known by hand,
 * compiled once in float and once in double. z points down: a hill has a negative depth.
 * SPDX-License-Identifier: MIT */
#include "lib/cone_oracle.h"

#define ABOVE (-1.0)
#define BELOW 1.0
static const double eps = (double)CML_EPSILON;

static const double hill_r[] = {0, 1}, hill_z[] = {-1, 0};    /* hill: z = r - 1 */
static const double crater_r[] = {0, 1}, crater_z[] = {1, 0}; /* crater: z = 1 - r */

struct found {
    int hit, ring;
    double t;
};

static struct found shoot_from(const struct field *field, double px, double py, double pz, double ux,
                               double uy, double uz, double side, double t_max, int on_ring)
{
    const double k = 1 / sqrt(ux * ux + uy * uy + uz * uz);
    const struct cml_vec p = {(real)px, (real)py, (real)pz};
    const struct cml_vec u = {(real)(k * ux), (real)(k * uy), (real)(k * uz)};
    struct found found = {0, -1, -1};
    real t = -1;
    found.hit = cml_cone_hit(rings_of(field), p, u, (real)side, 0, (real)t_max, on_ring, &t, &found.ring);
    found.t = (double)t;
    return found;
}

static struct found shoot(const struct field *field, double px, double py, double pz, double ux, double uy,
                          double uz, double side)
{
    return shoot_from(field, px, py, pz, ux, uy, uz, side, INFINITY, -1);
}

static void expect(struct found found, double t, int ring, double tolerance)
{
    assert_int_equal(found.hit, 1);
    assert_near("distance", found.t, t, tolerance);
    assert_int_equal(found.ring, ring);
}

static void an_axial_ray_hits_the_tip_exactly(void **state)
{
    (void)state;
    const struct field hill = field_of(2, hill_r, hill_z), crater = field_of(2, crater_r, crater_z);
    expect(shoot(&hill, 0, 0, -3, 0, 0, 1, ABOVE), 2, 0, 0);
    expect(shoot(&hill, 0, 0, 3, 0, 0, -1, BELOW), 4, 0, 0);
    expect(shoot(&crater, 0, 0, -3, 0, 0, 1, ABOVE), 4, 0, 0);
    assert_false(shoot(&hill, 0, 0, -3, 0, 0, -1, ABOVE).hit);
    assert_false(shoot(&crater, 0, 0, 3, 0, 0, 1, BELOW).hit);
}

static void a_ray_a_hair_off_the_axis_hits_the_tip_too(void **state)
{
    (void)state;
    const struct field hill = field_of(2, hill_r, hill_z);
    static const double hairs[] = {1e-30, 1e-20, 1e-12, 1e-8};
    for (int i = 0; i < COUNT(hairs); i++) {
        expect(shoot(&hill, 0, 0, -3, hairs[i], 0, 1, ABOVE), 2, 0, 1e-7 + 4 * eps);
        expect(shoot(&hill, hairs[i], 0, -3, 0, hairs[i], 1, ABOVE), 2, 0, 1e-7 + 4 * eps);
        expect(shoot(&hill, hairs[i], -hairs[i], 3, hairs[i], 0, -1, BELOW), 4, 0, 1e-7 + 4 * eps);
    }
}

static void a_vertical_ray_off_the_axis_hits_the_flank(void **state)
{
    (void)state;
    const struct field hill = field_of(2, hill_r, hill_z);
    expect(shoot(&hill, 0.5, 0, -3, 0, 0, 1, ABOVE), 2.5, 0, 0);
    expect(shoot(&hill, 0, -0.25, 2, 0, 0, -1, BELOW), 2.75, 0, 0);
    expect(shoot(&hill, 3, 4, -1, 0, 0, 1, ABOVE), 1, 1, 0);
}

static void a_ray_through_the_axis_meets_the_far_flank(void **state)
{
    (void)state;
    const struct field hill = field_of(2, hill_r, hill_z), crater = field_of(2, crater_r, crater_z);
    expect(shoot(&hill, -0.5, 0, -0.25, 1, 0, -0.25, BELOW), sqrt(1.0625), 0, 8 * eps);
    expect(shoot(&crater, 0, 0.5, 0.25, 0, -1, 0.25, ABOVE), sqrt(1.0625), 0, 8 * eps);
    expect(shoot(&hill, -2, 0, -2, 1, 0, 1, ABOVE), 1.5 * sqrt(2), 0, 8 * eps);
}

/* The discriminant of this ray is 0 but for rounding. If its sign says "no root", the ray must still not
 * enter the hill. */
static void an_oblique_ray_at_the_tip_of_a_pit_comes_out_there(void **state)
{
    (void)state;
    struct dice dice = dice_new(42);
    const struct field crater = field_of(2, crater_r, crater_z), hill = field_of(2, hill_r, hill_z);
    for (int n = 0; n < 20000; n++) {
        const double x = dice_between(&dice, -3, 3), y = dice_between(&dice, -3, 3), r = hypot(x, y);
        const double z = dice_between(&dice, 1.1, 3) * r;
        const struct found out = shoot(&crater, x, y, 1 + z, -x, -y, -z, BELOW);
        const struct found in = shoot(&hill, x, y, -1 - z, -x, -y, z, ABOVE);
        assert_true(out.hit && in.hit);
        assert_near("from below", out.t, hypot(r, z), 1e-4 * (sizeof(real) == 4) + 1e-9);
        assert_near("from above", in.t, hypot(r, z), 1e-4 * (sizeof(real) == 4) + 1e-9);
    }
}

/* The ray ends on the axis, where r^2(t) loses its digits by cancellation. A negative r^2 once let the ray
 * pass into the hill. */
static void a_ray_that_ends_on_the_axis_under_the_tip_has_hit(void **state)
{
    (void)state;
    static const double r[] = {0, 0.553242147, 2}, z[] = {-0.266359299, 0.020391467, 0.02};
    const struct field field = field_of(3, r, z);
    for (int n = -200; n <= 200; n++) {
        const struct found found = shoot_from(&field, -0.820910573, -0.609645128, -0.592558384, 0.63829422,
                                              0.474026024, 0.606530964, ABOVE, 1.28586 + n * 1e-6, -1);
        expect(found, 0.84058, 0, 1e-4);
    }
}

static void a_horizontal_ray_enters_and_leaves_a_hill(void **state)
{
    (void)state;
    const struct field hill = field_of(2, hill_r, hill_z);
    expect(shoot(&hill, -3, 0, -0.5, 1, 0, 0, ABOVE), 2.5, 0, 8 * eps);
    expect(shoot(&hill, 0.125, 0, -0.5, 1, 0, 0, BELOW), 0.375, 0, 8 * eps);
    assert_false(shoot(&hill, -3, 0, -1.5, 1, 0, 0, ABOVE).hit);
    assert_false(shoot(&hill, -3, 0, 0.5, 1, 0, 0, BELOW).hit);
}

/* A horizontal ray at half the hill's height passes the axis at distance y. */
static void a_ray_dips_into_a_flank_misses_it_or_touches_it(void **state)
{
    (void)state;
    const struct field hill = field_of(2, hill_r, hill_z), crater = field_of(2, crater_r, crater_z);
    const double hairs[] = {0.2, 0.01, 1e-4, 64 * eps};
    for (int i = 0; i < COUNT(hairs); i++) {
        const double inside = 0.5 - hairs[i], outside = 0.5 + hairs[i];
        const double t = 3 - sqrt(hairs[i] * (1 - hairs[i])), tolerance = 8 * eps / sqrt(hairs[i]);
        expect(shoot(&hill, -3, inside, -0.5, 1, 0, 0, ABOVE), t, 0, tolerance);
        expect(shoot(&crater, -3, inside, 0.5, 1, 0, 0, BELOW), t, 0, tolerance);
        assert_false(shoot(&hill, -3, outside, -0.5, 1, 0, 0, ABOVE).hit);
        assert_false(shoot(&crater, -3, outside, 0.5, 1, 0, 0, BELOW).hit);
    }
    const struct found touch = shoot(&hill, -3, 0.5, -0.5, 1, 0, 0, ABOVE);
    if (touch.hit) assert_near("touching point", touch.t, 3, 8 * sqrt(eps));
}

/* A ray dips below the flank by a rounding or two. Near the point of contact its height hardly changes,
 * and a Newton step from there once ended 0.04 cm off. */
static void a_ray_that_just_touches_a_flank_hits_it_there(void **state)
{
    (void)state;
    static const double r[] = {0, 0.05}, z[] = {0.5, 0};
    const struct field pit = field_of(2, r, z);
    const struct cml_vec u = {(real)0.762428045, (real)-0.0645453781, (real)0.643845797};
    int hits = 0;
    for (int n = -2000; n < 2000; n++) {
        const struct cml_vec p = {(real)-0.0107101016, (real)0.0128574641, (real)(0.371447951 + n * 3e-8)};
        real t;
        int ring;
        if (!cml_cone_hit(rings_of(&pit), p, u, (real)BELOW, 0, CML_INFINITY, -1, &t, &ring)) continue;
        const double x = (double)p.x + (double)t * (double)u.x, y = (double)p.y + (double)t * (double)u.y;
        const double depth = (double)p.z + (double)t * (double)u.z;
        assert_near("height", depth, 0.5 - 10 * hypot(x, y), 1e-5);
        hits++;
    }
    assert_true(hits > 0 && hits < 4000);
}

static void a_root_on_a_shared_ring_is_found_once(void **state)
{
    (void)state;
    static const double r[] = {0, 0.5, 1, 2}, z[] = {-1, -0.5, 0, 0.25};
    const struct field field = field_of(4, r, z);
    const struct found across = shoot(&field, -3, 0, -0.5, 1, 0, 0, ABOVE);
    assert_true(across.hit && (across.ring == 0 || across.ring == 1));
    assert_near("distance", across.t, 2.5, 8 * eps);
    const struct found down = shoot(&field, 1, 0, -2, 0, 0, 1, ABOVE);
    assert_true(down.hit && down.t == 2);
    const struct found oblique = shoot(&field, 1, -1, -1, 0, 1, 1, ABOVE);
    assert_true(oblique.hit && (oblique.ring == 1 || oblique.ring == 2));
    assert_near("distance", oblique.t, sqrt(2), 8 * eps);
}

/* A ray runs along the tangent of a ridge at radius 1, and 0.01 below its top. The surface comes down to
 * the ray at radius 1.01. Rounding decides if the ray begins inside or outside the ridge. */
static void a_ray_along_a_ridge_leaves_it_at_once(void **state)
{
    (void)state;
    static const double r[] = {0, 1, 2}, z[] = {0.5, 0, 1};
    const struct field field = field_of(3, r, z);
    for (int n = 0; n < 20000; n++) {
        const double phi = n * 6.283185307179586 / 20000, c = cos(phi), d = sin(phi);
        expect(shoot(&field, c, d, 0.01, -d, c, 0, BELOW), sqrt(1.01 * 1.01 - 1), 1, 1e-4);
    }
}

static void a_packet_that_stands_on_a_ring_leaves_it(void **state)
{
    (void)state;
    const struct field hill = field_of(2, hill_r, hill_z);
    static const double away[][3] = {{0, 0, -1}, {1, 0, 0}, {0, 1, 0}, {0.1, 0.2, -1}, {-1, 0, -1.001}};
    for (int i = 0; i < COUNT(away); i++)
        assert_false(
            shoot_from(&hill, 0.5, 0, -0.5, away[i][0], away[i][1], away[i][2], ABOVE, INFINITY, 0).hit);
    /* down the flank, a little less steep than the flank, to the outer plane */
    expect(shoot_from(&hill, 0.5, 0, -0.5, 1, 0, 0.5, ABOVE, INFINITY, 0), sqrt(1.25), 1, 16 * eps);
    assert_false(shoot_from(&hill, 0.5, 0, -0.5, 0, 0, 1, BELOW, INFINITY, 0).hit);
    assert_false(shoot_from(&hill, 0, 0, -1, 0, 0, 1, BELOW, INFINITY, 0).hit);
    assert_false(shoot_from(&hill, 0, 0, -1, 1, 0, -1, ABOVE, INFINITY, 0).hit);
    assert_false(shoot_from(&hill, 2, 0, 0, 1, 0, -1, ABOVE, INFINITY, 1).hit);
}

static void a_packet_that_stands_in_a_hollow_hits_the_same_ring_again(void **state)
{
    (void)state;
    const struct field hill = field_of(2, hill_r, hill_z), crater = field_of(2, crater_r, crater_z);
    expect(shoot_from(&hill, 0.5, 0, -0.5, -1, 0, 0, BELOW, INFINITY, 0), 1, 0, 8 * eps);
    expect(shoot_from(&crater, 0.5, 0, 0.5, -1, 0, 0, ABOVE, INFINITY, 0), 1, 0, 8 * eps);
    const double chord = 2 * 0.5 * cos(1.0);
    expect(shoot_from(&crater, 0.5, 0, 0.5, -cos(1.0), sin(1.0), 0, ABOVE, INFINITY, 0), chord, 0, 8 * eps);
}

/* Near the tip of a pit, rounding may put the packet below either flank. A packet that heads down, almost
 * along the other nappe of the cone (off by one part in a thousand), leaves at once: the second root of
 * the quadratic is no crossing. */
static void a_packet_that_stands_in_a_tip_leaves_it_there(void **state)
{
    (void)state;
    const struct field crater = field_of(2, crater_r, crater_z);
    struct dice dice = dice_new(5);
    int elsewhere = 0;
    for (int n = 0; n < 100000; n++) {
        const double phi = dice_between(&dice, 0, 6.283185307179586), c = cos(phi), d = sin(phi);
        const double r = dice_between(&dice, 0, 8) * eps, down = 1 + dice_between(&dice, -1e-3, 1e-3);
        const double z = 1 - r + (dice_below(&dice, 5) - 2) * eps;
        const struct found found = shoot_from(&crater, r * c, r * d, z, c, d, down, ABOVE, INFINITY, 0);
        elsewhere += !(found.hit && found.ring == 0 && found.t <= 64 * eps);
    }
    assert_int_equal(elsewhere, 0);
}

static void a_packet_that_stands_on_a_ring_hits_the_next_one(void **state)
{
    (void)state;
    static const double r[] = {0, 1, 2}, z[] = {0, 1, 0};
    const struct field trough = field_of(3, r, z);
    expect(shoot_from(&trough, 0.5, 0, 0.5, 1, 0, 0, ABOVE, INFINITY, 0), 1, 1, 8 * eps);
    expect(shoot_from(&trough, 1.5, 0, 0.5, -1, 0, 0, ABOVE, INFINITY, 1), 1, 0, 8 * eps);
    /* from below the outer plane: x = 4 - s, z = s / 8 meets the flank z = 2 - x at s = 16 / 7 */
    expect(shoot_from(&trough, 4, 0, 0, -1, 0, 0.125, BELOW, INFINITY, 2), 16.0 / 7 * sqrt(65.0 / 64), 1,
           16 * eps);
}

static void an_annulus_is_hit_like_a_plane(void **state)
{
    (void)state;
    static const double r[] = {0, 1, 2, 3}, z[] = {0, -0.5, -0.5, 0};
    const struct field field = field_of(4, r, z);
    expect(shoot(&field, 1.5, 0, -2, 0, 0, 1, ABOVE), 1.5, 1, 0);
    expect(shoot(&field, 0, 0, -2, 1, 0, 1, ABOVE), 1.5 * sqrt(2), 1, 8 * eps);
    expect(shoot(&field, 1.5, 0.5, 1, 0, 0, -1, BELOW), 1.5, 1, 0);
    assert_false(shoot_from(&field, 1.5, 0, -0.5, 0, 0, -1, ABOVE, INFINITY, 1).hit);
    assert_false(shoot_from(&field, 1.5, 0, -0.5, 1, 0, -1, ABOVE, INFINITY, 1).hit);
    assert_false(shoot_from(&field, 1.5, 0, -0.5, 1, 0, 1, BELOW, INFINITY, 1).hit);
}

static void the_outer_plane_has_no_end(void **state)
{
    (void)state;
    const struct field hill = field_of(2, hill_r, hill_z);
    expect(shoot(&hill, 100, 0, -1, 0, 0, 1, ABOVE), 1, 1, 0);
    expect(shoot(&hill, 1024, 0, -1, 1, 0, 1, ABOVE), sqrt(2), 1, 8 * eps);
    expect(shoot(&hill, -1024, 0, 1, 3, 0, -1, BELOW), sqrt(10), 1, 8 * eps);
    expect(shoot(&hill, 0, 0, -2, 1, 0, 0.5, ABOVE), 2 * sqrt(5), 1, 16 * eps);
}

static void steep_walls_stop_a_ray(void **state)
{
    (void)state;
    static const double widths[] = {1.0 / 1024, 1.0 / 1048576};
    for (int i = 0; i < COUNT(widths); i++) {
        const double r[] = {0, 1, 1 + widths[i]}, z[] = {-1, -1, 0}, tolerance = 0.01 * widths[i] + 16 * eps;
        const struct field plateau = field_of(3, r, z);
        expect(shoot(&plateau, -3, 0, -0.5, 1, 0, 0, ABOVE), 2 - widths[i] / 2, 1, tolerance);
        expect(shoot(&plateau, 0, 0, -0.5, 0, 1, 0, BELOW), 1 + widths[i] / 2, 1, tolerance);
        expect(shoot(&plateau, 0, 0.5, -2, 0, 0, 1, ABOVE), 1, 0, 0);
        expect(shoot(&plateau, 2, 0, 2, 0, 0, -1, BELOW), 2, 2, 0);
    }
}

static void a_ring_a_millionth_wide_is_no_gap(void **state)
{
    (void)state;
    static const double r[] = {0, 1, 1.000001, 2}, z[] = {0, -1, -1.000001, 0};
    const struct field field = field_of(4, r, z);
    for (int n = -40; n <= 40; n++) {
        const double x = 1 + n * 1e-7;
        const struct found down = shoot(&field, x, 0, -3, 0, 0, 1, ABOVE);
        assert_true(down.hit);
        assert_near("distance down", down.t, 2, 6e-6);
        const struct found slant = shoot(&field, x - 1, 0, -3, 1, 0, 2, ABOVE);
        assert_true(slant.hit);
        assert_near("distance aslant", slant.t, sqrt(5), 2e-5);
    }
}

static void a_hit_counts_only_before_t_max(void **state)
{
    (void)state;
    const struct field hill = field_of(2, hill_r, hill_z);
    assert_false(shoot_from(&hill, -3, 0, -0.5, 1, 0, 0, ABOVE, 2.49, -1).hit);
    assert_false(shoot_from(&hill, -3, 0, -0.5, 1, 0, 0, ABOVE, 1, -1).hit);
    expect(shoot_from(&hill, -3, 0, -0.5, 1, 0, 0, ABOVE, 2.51, -1), 2.5, 0, 8 * eps);
    expect(shoot_from(&hill, -3, 0, -0.5, 1, 0, 0, ABOVE, 1e30, -1), 2.5, 0, 8 * eps);
    assert_false(shoot_from(&hill, 0, 0, -3, 0, 0, 1, ABOVE, 1.99, -1).hit);
    assert_false(shoot_from(&hill, 0, 0, -3, 0, 0, 1, ABOVE, 2, -1).hit);
    expect(shoot_from(&hill, 0, 0, -3, 0, 0, 1, ABOVE, 2.01, -1), 2, 0, 0);
    assert_false(shoot_from(&hill, 1024, 0, -1, 1, 0, 1, ABOVE, 1.41, -1).hit);
}

/* Compares normals with slopes along x and y by central differences. */
static void normals_are_those_of_finite_differences(void **state)
{
    (void)state;
    struct dice dice = dice_new(41);
    for (int n = 0; n < 20000; n++) {
        const struct field field = field_random(&dice, 10);
        const double reach = 1.2 * (double)field.r[field.n - 1];
        const real x = (real)dice_between(&dice, -reach, reach), y = (real)dice_between(&dice, -reach, reach);
        const long double r = hypotl(x, y), h = 1e-9L * (1 + r);
        const int i = field_ring(&field, r);
        if (i != field_ring(&field, r + 2 * h) || i != field_ring(&field, r - 2 * h)) continue;
        const long double zx =
            (field_depth(&field, hypotl(x + h, y)) - field_depth(&field, hypotl(x - h, y))) / (2 * h);
        const long double zy =
            (field_depth(&field, hypotl(x, y + h)) - field_depth(&field, hypotl(x, y - h))) / (2 * h);
        const long double k = 1 / sqrtl(1 + zx * zx + zy * zy);
        const struct cml_vec up = cml_cone_normal(rings_of(&field), i, x, y);
        const double tolerance = 1e-8 + 8 * eps;
        assert_near("x", (double)up.x, (double)(k * zx), tolerance);
        assert_near("y", (double)up.y, (double)(k * zy), tolerance);
        assert_near("z", (double)up.z, (double)-k, tolerance);
    }
}

static void the_tip_and_a_ridge_have_mean_normals(void **state)
{
    (void)state;
    static const double r[] = {0, 1, 2}, z[] = {0, -1, 0};
    const struct field field = field_of(3, r, z);
    const struct cml_rings rings = rings_of(&field);
    const struct cml_vec tip = cml_cone_normal(rings, 0, 0, 0);
    assert_true(tip.x == 0 && tip.y == 0 && tip.z == -1);
    for (int ring = 0; ring < 2; ring++) {
        const struct cml_vec ridge = cml_cone_normal(rings, ring, 0, 1);
        assert_near("x", (double)ridge.x, 0, 2 * eps);
        assert_near("y", (double)ridge.y, 0, 2 * eps);
        assert_near("z", (double)ridge.z, -1, 2 * eps);
    }
    const double kink = atan(1.0) / 2; /* half the angle between 45 degrees and flat */
    for (int ring = 1; ring < 3; ring++) {
        const struct cml_vec foot = cml_cone_normal(rings, ring, 2, 0);
        assert_near("foot x", (double)foot.x, sin(kink), 4 * eps);
        assert_near("foot z", (double)foot.z, -cos(kink), 4 * eps);
    }
}

/* Near a ridge a direction may leave the side of the mean normal and still enter the facet. The normal of
 * the facet must decide. */
static void even_on_a_ridge_the_facet_is_that_of_one_ring(void **state)
{
    (void)state;
    static const double r[] = {0, 1, 2}, z[] = {0, -1, 0};
    const struct field field = field_of(3, r, z);
    for (int ring = 0; ring < 3; ring++) {
        const double x = ring < 2 ? 1 : 2, m = (double)field.slope[ring];
        const struct cml_vec facet = cml_cone_facet(rings_of(&field), ring, (real)x, 0);
        assert_near("facet x", (double)facet.x, m / sqrt(1 + m * m), 2 * eps);
        assert_near("facet z", (double)facet.z, -1 / sqrt(1 + m * m), 2 * eps);
    }
    const struct cml_vec tip = cml_cone_facet(rings_of(&field), 0, 0, 0);
    assert_true(tip.x == 0 && tip.y == 0 && tip.z == -1);
}

static void every_radius_finds_its_ring(void **state)
{
    (void)state;
    struct dice dice = dice_new(54);
    for (int n = 0; n < 2000; n++) {
        struct field field = field_random(&dice, 1);
        for (int i = 0; n % 2 && i < field.n; i++) field.r[i] = (real)(i * 0.01);
        field_finish(&field);
        const double last = (double)field.r[field.n - 1];
        for (int k = 0; k < 200; k++) {
            const real on = field.r[dice_below(&dice, field.n)];
            const real r = dice_below(&dice, 2) ? on : (real)dice_between(&dice, 0, 1.2 * last);
            assert_int_equal(cml_ring_of(rings_of(&field), r), field_ring(&field, r));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_axial_ray_hits_the_tip_exactly),
        cmocka_unit_test(a_ray_a_hair_off_the_axis_hits_the_tip_too),
        cmocka_unit_test(a_vertical_ray_off_the_axis_hits_the_flank),
        cmocka_unit_test(a_ray_through_the_axis_meets_the_far_flank),
        cmocka_unit_test(an_oblique_ray_at_the_tip_of_a_pit_comes_out_there),
        cmocka_unit_test(a_ray_that_ends_on_the_axis_under_the_tip_has_hit),
        cmocka_unit_test(a_horizontal_ray_enters_and_leaves_a_hill),
        cmocka_unit_test(a_ray_dips_into_a_flank_misses_it_or_touches_it),
        cmocka_unit_test(a_ray_that_just_touches_a_flank_hits_it_there),
        cmocka_unit_test(a_root_on_a_shared_ring_is_found_once),
        cmocka_unit_test(a_ray_along_a_ridge_leaves_it_at_once),
        cmocka_unit_test(a_packet_that_stands_on_a_ring_leaves_it),
        cmocka_unit_test(a_packet_that_stands_in_a_hollow_hits_the_same_ring_again),
        cmocka_unit_test(a_packet_that_stands_in_a_tip_leaves_it_there),
        cmocka_unit_test(a_packet_that_stands_on_a_ring_hits_the_next_one),
        cmocka_unit_test(an_annulus_is_hit_like_a_plane),
        cmocka_unit_test(the_outer_plane_has_no_end),
        cmocka_unit_test(steep_walls_stop_a_ray),
        cmocka_unit_test(a_ring_a_millionth_wide_is_no_gap),
        cmocka_unit_test(a_hit_counts_only_before_t_max),
        cmocka_unit_test(normals_are_those_of_finite_differences),
        cmocka_unit_test(the_tip_and_a_ridge_have_mean_normals),
        cmocka_unit_test(even_on_a_ridge_the_facet_is_that_of_one_ring),
        cmocka_unit_test(every_radius_finds_its_ring),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
