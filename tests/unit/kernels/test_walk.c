/* Tests of kernels/walk.h: events that keep a mean (roulette, rounding of absorbed weight), steps that end
 * on a plane, and facets near the tip of a cone. SPDX-License-Identifier: MIT */
#include "lib/dice.h"
#include "detector.h"
#include "walk.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static const struct cml_stream stream = {.key = {7, 0, 0, 0}};

/* Plays roulette with 1e6 packets of weight w, whose survivors weigh `after`. Their mean weight must be w,
 * with z below 4.9. */
static void play(struct cml_roulette_rule rule, cml_u32 w, cml_u32 after)
{
    const double n = 1e6, p = (double)w / after;
    double sum = 0;
    for (cml_u64 i = 0; i < (cml_u64)n; i++) {
        struct cml_packet packet = {.w = w, .draw = cml_draw(stream, i, CML_PURPOSE_INTERACTION, 0)};
        cml_roulette(rule, &packet);
        assert_int_equal(packet.w, packet.fate == CML_FATE_ALIVE ? after : 0);
        assert_int_equal(w + packet.gained, packet.w + packet.roulette);
        sum += packet.w;
    }
    assert_true(fabs(sum / n / w - 1) < 4.9 * sqrt((1 - p) / p / n));
}

static void roulette_keeps_the_mean_weight(void **state)
{
    (void)state;
    const struct cml_roulette_rule mcml = {214748, 0}, window = {1u << 24, 3u << 24};
    play(mcml, 214747, 2147470);
    play(window, 1u << 23, 3u << 24);
    play(window, 1, 3u << 24);
}

static void heavy_packets_play_no_roulette(void **state)
{
    (void)state;
    const struct cml_roulette_rule rules[] = {{214748, 0}, {1u << 24, 3u << 24}};
    for (int i = 0; i < 2; i++) {
        struct cml_packet packet = {.w = rules[i].below, .draw.w[3] = 0xffffffffu};
        cml_roulette(rules[i], &packet);
        assert_int_equal(packet.w, rules[i].below);
        assert_int_equal(packet.fate, CML_FATE_ALIVE);
    }
}

/* The roulette of original MCML lets exactly a tenth survive, 429496730 words of 2^32. */
static void the_rule_of_mcml_lets_a_tenth_survive(void **state)
{
    (void)state;
    const struct cml_roulette_rule mcml = {214748, 0};
    for (cml_u32 word = 429496728; word <= 429496731; word++) {
        struct cml_packet packet = {.w = 77, .draw.w[3] = word};
        cml_roulette(mcml, &packet);
        assert_int_equal(packet.fate == CML_FATE_ALIVE, word < 429496730);
    }
}

/* Returns how many branches come of a packet if each of its parts asks to be split into `parts` again. */
static double family(struct cml_branches *to, struct cml_packet packet, cml_u32 parts)
{
    const cml_u32 now = cml_parts_of(to, &packet, packet.w / parts);
    return now > 1 ? now - 1 + now * family(to, packet, parts) : 0;
}

/* Splitting ends. Up to half of the allowed branches may stay unused if they cannot be shared evenly.
 * Roulette returns branches of dead packets to the survivors. */
static void a_family_ends(void **state)
{
    (void)state;
    for (cml_u32 parts = 2; parts < 1000; parts++) {
        struct cml_branches to = {.most = CML_MOST_OF_FAMILY};
        const double all = family(&to, (struct cml_packet){.w = CML_WEIGHT_ONE}, parts);
        if (!(all <= CML_MOST_OF_FAMILY && all > 0.4 * CML_MOST_OF_FAMILY)) fail_msg("%u: %g", parts, all);
        assert_int_equal(to.clipped > 0, parts > CML_MOST_PARTS);
        assert_true(to.spent > 0);
    }
    assert_int_equal(cml_spent_after(CML_MOST_OF_FAMILY - 1000, 10, 25), CML_MOST_OF_FAMILY - 2500);
    assert_int_equal(cml_spent_after(1000, 10, 25), 0);
}

/* A packet that finds no room stays as it is, with all of its budget, and only `whole` counts it. */
static void a_packet_without_room_stays_whole(void **state)
{
    (void)state;
    static const struct cml_world world;
    const struct cml_packet before = {.w = CML_WEIGHT_ONE, .spent = 7};
    struct cml_packet packet = before;
    struct cml_branches to = {.count = 5, .most = 67};
    cml_split(&world, &to, &packet, CML_WEIGHT_ONE / 1000);
    assert_memory_equal(&packet, &before, sizeof packet);
    assert_int_equal(to.whole, 1);
    assert_int_equal(to.clipped + to.spent + (cml_u64)to.count, 5);
}

/* Returns the mean absorbed weight over all values of the 16 random bits. */
static double mean_absorbed(cml_u32 w, real absorb)
{
    double sum = 0;
    for (cml_u32 bits = 0; bits < 65536; bits++) sum += cml_absorbed_part(w, absorb, bits & 255, bits >> 8);
    return sum / 65536;
}

/* An interaction may absorb far less than one unit of weight. The mean is still right to 2^-17 units,
 * which is 4e-4 of the smallest allowed absorption. */
static void absorbed_weight_is_rounded_without_bias(void **state)
{
    (void)state;
    static const real absorb[] = {(real)1e-11, (real)2.7e-11, (real)1e-7, (real)3e-6, (real)0.01, (real)0.37};
    for (int k = 0; k < 6; k++) {
        const cml_u32 w = k < 2 ? CML_WEIGHT_ONE : 214748;
        const double exact = (double)w * absorb[k];
        assert_true(fabs(mean_absorbed(w, absorb[k]) - exact) < 1.0001 / 131072 + 1e-7 * exact);
    }
    assert_true(fabs(mean_absorbed(CML_WEIGHT_ONE, (real)1e-11) / (1e-11 * CML_WEIGHT_ONE) - 1) < 4e-4);
    assert_int_equal(cml_absorbed_part(12345, 1, 0, 0), 12345);
    assert_int_equal(cml_absorbed_part(12345, 0, 255, 255), 0);
}

static struct cml_vec random_direction(struct dice *dice)
{
    double u[3];
    dice_direction(dice, u);
    return (struct cml_vec){(real)u[0], (real)u[1], (real)u[2]};
}

/* A step ends exactly at a plane or one rounding off it. The packet is below the plane (side +1) or above
 * it (side -1).
 * It either crosses and stands on z = 0, or interacts. A packet that interacts has not crossed, wherever
 * rounding put it: it crosses at once if it then heads outwards, and never if it heads back. */
static void a_step_that_ends_on_a_plane_crosses_it_once(void **state)
{
    (void)state;
    struct dice dice = dice_new(71);
    long crossed = 0, stayed = 0;
    for (int n = 0; n < 300000; n++) {
        const real side = dice_below(&dice, 2) ? (real)1 : (real)-1;
        const struct cml_vec p = {0, 0, side * (real)exp(dice_between(&dice, -12, 3))};
        struct cml_vec u = random_direction(&dice);
        u.z = -side * CML_FABS(u.z);
        if (CML_FABS(u.z) < (real)1e-3) continue;
        const real t = -p.z / u.z;
        const float around[3] = {nextafterf(t, 0), t, nextafterf(t, INFINITY)};
        struct cml_hit hit = {0};
        const real t_max = around[n % 3];
        if (cml_intersect_plane(p, u, side, t_max, &hit)) {
            assert_true(n % 3 == 2 && hit.t == t && hit.point.z == 0);
            crossed++;
            continue;
        }
        const struct cml_vec q = cml_along(p, t_max, u), v = random_direction(&dice);
        const int outwards = side * v.z < 0;
        assert_true(fabs((double)q.z) <= 4 * 0x1p-24 * fabs((double)p.z));
        assert_int_equal(cml_intersect_plane(q, v, side, CML_INFINITY, &hit), outwards);
        if (outwards)
            assert_true(hit.t >= 0 && hit.point.z == 0 &&
                        hit.t * CML_FABS(v.z) <= CML_FABS(q.z) * (real)1.000001);
        stayed++;
    }
    assert_true(crossed > 90000 && stayed > 180000);
}

/* A packet leaves every facet on its new side. Near the tip of a cone, rounding may give a packet that
 * already leads away from the facet; it goes on in its direction. */
static void no_packet_is_reflected_into_its_facet(void **state)
{
    (void)state;
    static const struct cml_surface surface = {.kind = CML_SURFACE_CONE};
    const struct cml_world world = {.setup.stream = stream, .surfaces = &surface};
    struct dice dice = dice_new(72);
    long went_on = 0, crossed = 0;
    for (cml_u64 i = 0; i < 300000; i++) {
        const struct cml_vec facet = random_direction(&dice), u = random_direction(&dice);
        const struct cml_hit hit = {.normal = facet, .facet = facet};
        const real side = dice_below(&dice, 2) ? (real)1 : (real)-1, n = (real)dice_between(&dice, 0.5, 2);
        struct cml_packet packet = {.index = i, .u = u};
        const int transmitted = cml_reflect_or_refract(&world, &packet, &hit, side, 1, n);
        const real leaving = side * cml_dot(packet.u, facet), came = side * cml_dot(u, facet);
        assert_true(transmitted ? leaving > (real)-1e-6 : leaving < (real)1e-6);
        crossed += transmitted;
        if (!(came < 0) || transmitted) continue;
        assert_true(packet.u.x == u.x && packet.u.y == u.y && packet.u.z == u.z);
        went_on++;
    }
    assert_true(went_on > 100000 && crossed > 50000);
}

static struct cml_vec unit(struct cml_vec v)
{
    const double size = sqrt((double)cml_dot(v, v));
    return (struct cml_vec){(real)(v.x / size), (real)(v.y / size), (real)(v.z / size)};
}

/* Returns a direction perpendicular to a unit vector. */
static struct cml_vec random_direction_in_plane(struct dice *dice, struct cml_vec normal)
{
    const struct cml_vec v = random_direction(dice);
    return unit(cml_along(v, -cml_dot(v, normal), normal));
}

/* Shading normals may turn light into the plane of its facet, but for rounding, where it would meet
 * neighbouring facets for ever. The direction is therefore turned clearly away from the facet, and the
 * event is counted. */
static void no_shading_normal_turns_light_into_a_facets_plane(void **state)
{
    (void)state;
    static const struct cml_surface surface = {.kind = CML_SURFACE_MESH};
    const struct cml_world world = {.setup.stream = stream, .surfaces = &surface};
    struct dice dice = dice_new(73);
    long reflected = 0, crossed = 0;
    for (cml_u64 i = 0; i < 300000; i++) {
        const struct cml_vec facet = random_direction(&dice), along = random_direction_in_plane(&dice, facet);
        const real side = dice_below(&dice, 2) ? (real)1 : (real)-1;
        const real n1 = 1, n2 = dice_below(&dice, 2) ? (real)0.5 : (real)1.5, ratio = i % 2 ? 1 : n2 / n1;
        struct cml_packet packet = {.index = i, .u = random_direction(&dice)};
        struct cml_hit hit = {.facet = facet};
        if (side * cml_dot(packet.u, facet) < (real)0.1) continue;
        hit.normal = unit(cml_along(packet.u, -ratio, along));
        if (side * cml_dot(packet.u, hit.normal) < 0)
            hit.normal = cml_along((struct cml_vec){0, 0, 0}, -1, hit.normal);
        const int transmitted = cml_reflect_or_refract(&world, &packet, &hit, side, n1, n2);
        const real leaving = side * cml_dot(packet.u, facet);
        assert_true(transmitted ? leaving > 4 * CML_EPSILON : leaving < -4 * CML_EPSILON);
        reflected += packet.shading_overruled && !transmitted;
        crossed += packet.shading_overruled && transmitted;
    }
    assert_true(reflected > 10000 && crossed > 10000);
}

/* The share of a circle that a detector sees agrees with counting points on the circle. */
static void a_detector_sees_its_arc_of_a_circle(void **state)
{
    enum { POINTS = 20000 };
    static const float cases[][4] = {{1, 1, 0, 0.01f},      {0.3f, 1, 0, 0.8f},        {1.2f, 1, 0.5f, 0.9f},
                                     {0.1f, 0.2f, 0, 0.5f}, {0.5f, 0.2f, 0.1f, 0.31f}, {2, 1, 0, 0.5f},
                                     {0, 0.2f, 0, 0.3f},    {0, 0.2f, 0, 0.1f}};
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const float r = cases[k][0], away = cases[k][1], inner = cases[k][2], outer = cases[k][3];
        int inside = 0;
        for (int i = 0; i < POINTS; i++) {
            const double turn = 2 * 3.141592653589793 * (i + 0.5) / POINTS,
                         from = hypot(r * cos(turn) - away, r * sin(turn));
            inside += from >= inner && from < outer;
        }
        const struct cml_arc arc = {.detector = 1, .away = away, .inner = inner, .outer = outer};
        const double share = cml_arc_share(arc, r);
        if (fabs(share - (double)inside / POINTS) > 2.1 / POINTS)
            fail_msg("case %zu: %g, not %g", k, share, (double)inside / POINTS);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_detector_sees_its_arc_of_a_circle),
        cmocka_unit_test(roulette_keeps_the_mean_weight),
        cmocka_unit_test(heavy_packets_play_no_roulette),
        cmocka_unit_test(the_rule_of_mcml_lets_a_tenth_survive),
        cmocka_unit_test(a_family_ends),
        cmocka_unit_test(a_packet_without_room_stays_whole),
        cmocka_unit_test(absorbed_weight_is_rounded_without_bias),
        cmocka_unit_test(a_step_that_ends_on_a_plane_crosses_it_once),
        cmocka_unit_test(no_packet_is_reflected_into_its_facet),
        cmocka_unit_test(no_shading_normal_turns_light_into_a_facets_plane),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
