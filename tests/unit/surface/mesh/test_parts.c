/* Tests of bodies of several closed parts, which may be nested or overlap: the outside of each part, and
 * the crossings of lines aimed at vertices, edges and places where parts come close. They are compared
 * with solid angles and all triangles in long double. SPDX-License-Identifier: MIT */
#include "lib/part_shapes.h"

#include "surface/mesh/mesh_surface.h"

static struct soup soup;
static struct dice dice;

/* Adds a stone. It often contains one or two others, or one that leaves it a wall of a millionth, to a
 * depth of three. */
static void add_nested(const double centre[3], double radius, int depth)
{
    if (soup.parts > 20) return;
    soup_stone(&soup, &dice, centre, 3 + dice_below(&dice, 2), 0.8 * radius, radius);
    if (dice_below(&dice, 3) == 0) soup_repeat(&soup, centre, 1 - 1e-6);
    const double room = 0.95 * soup_distance(&soup, centre);
    const int inner = depth < 3 ? dice_below(&dice, 3) : 0;
    double u[3], at[3];
    dice_direction(&dice, u);
    for (int k = 0; k < inner; k++) {
        cml_vec3_add_scaled(centre, inner == 1 ? 0 : (k ? 0.5 : -0.5) * room, u, at);
        add_nested(at, inner == 1 ? room : 0.45 * room, depth + 1);
    }
}

static void make_nested(uint32_t seed)
{
    soup = (struct soup){0};
    dice = dice_new(seed);
    for (int i = -1; i <= 1; i++) {
        const double centre[3] = {2.01 * i, dice_between(&dice, -0.5, 0.5), dice_between(&dice, 0, 1)};
        add_nested(centre, 1, 1);
    }
}

static int parts_around(int part)
{
    const double *corner = soup.vertex[soup.triangle[soup.first[part]][0]];
    int around = 0;
    for (int k = 0; k < soup.parts; k++) around += k != part && soup_winding(&soup, k, corner) != 0;
    return around;
}

static void facets_look_out_of_what_they_bound(void **state)
{
    (void)state;
    int cavities = 0, solids_in_cavities = 0;
    for (uint32_t seed = 1; seed <= 20; seed++) {
        struct cml_mesh_notes notes = {0};
        int wrong = 0, odd = 0;
        make_nested(seed);
        struct cml_mesh mesh = soup_mesh(&soup, &dice, &notes);
        for (int k = 0; k < soup.parts; k++) odd += parts_around(k) % 2;
        for (int k = 0; k < soup.parts; k++) solids_in_cavities += parts_around(k) == 2;
        assert_int_equal(mesh.num_parts, soup.parts);
        assert_int_equal(notes.cavities, odd);
        cavities += odd;
        for (size_t t = 0; t < mesh.num_triangles; t++) {
            double normal[3], side[3], middle[3] = {0, 0, 0};
            for (int k = 0; k < 3; k++)
                cml_vec3_add_scaled(middle, 1.0 / 3, mesh.vertex[mesh.triangle[t][k]], middle);
            cml_vec3_area(mesh.vertex[mesh.triangle[t][0]], mesh.vertex[mesh.triangle[t][1]],
                          mesh.vertex[mesh.triangle[t][2]], normal);
            cml_vec3_normalise(normal);
            cml_vec3_add_scaled(middle, 1e-8, normal, side);
            wrong += soup_holds(&soup, side);
            cml_vec3_add_scaled(middle, -1e-8, normal, side);
            wrong += !soup_holds(&soup, side);
            wrong += mesh.part[t] != (uint32_t)soup.part[t];
        }
        assert_int_equal(wrong, 0);
        cml_mesh_clear(&mesh);
    }
    assert_true(cavities > 20 && solids_in_cavities > 5);
}

static struct cml_mesh_surface *surface_of_soup(void)
{
    struct cml_mesh mesh = soup_mesh(&soup, &dice, NULL);
    struct cml_mesh_surface *surface = NULL;
    struct cml_error err = {CML_OK, ""};
    assert_int_equal(cml_mesh_surface_create(&mesh, 0, 0, CML_SEARCH_EMBREE, &surface, &err), CML_OK);
    return surface;
}

/* True if a line crosses a triangle; *at: its distance. */
static bool crosses(int t, const double p[3], const double u[3], double *at)
{
    long double d[3][3], side[3], weight = 0, height = 0;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            d[i][k] = (long double)soup.vertex[soup.triangle[t][i]][k] - (long double)p[k];
    for (int i = 0; i < 3; i++) {
        const long double *a = d[(i + 1) % 3], *b = d[(i + 2) % 3];
        side[i] = (long double)u[0] * (a[1] * b[2] - a[2] * b[1]) +
                  (long double)u[1] * (a[2] * b[0] - a[0] * b[2]) +
                  (long double)u[2] * (a[0] * b[1] - a[1] * b[0]);
    }
    if (!((side[0] > 0 && side[1] > 0 && side[2] > 0) || (side[0] < 0 && side[1] < 0 && side[2] < 0)))
        return false;
    for (int i = 0; i < 3; i++) {
        weight += side[i];
        height += side[i] *
                  (d[i][0] * (long double)u[0] + d[i][1] * (long double)u[1] + d[i][2] * (long double)u[2]);
    }
    *at = (double)(height / weight);
    return true;
}

/* Crossings that lie ahead on a line. */
struct ahead {
    double at[4 * SOUP_PARTS];
    int triangle[4 * SOUP_PARTS], count;
};

/* Removes the nearest crossing and returns its triangle; -1 if none is left. */
static int take_next(struct ahead *ahead, double *at)
{
    int next = -1;
    for (int i = 0; i < ahead->count; i++)
        if (ahead->at[i] > 0 && (next < 0 || ahead->at[i] < ahead->at[next])) next = i;
    if (next < 0) return -1;
    *at = ahead->at[next];
    ahead->at[next] = 0;
    return ahead->triangle[next];
}

/* Returns the distance of the first boundary ahead of p. At a boundary of the union the number of parts
 * around a point changes from none to some or back. Crossings at one place but for rounding, of faces in
 * one plane, count as one, with triangle -1. */
static double first_boundary(const double p[3], const double u[3], int *triangle)
{
    static struct ahead ahead;
    bool around[SOUP_PARTS];
    int parts = 0;
    ahead.count = 0;
    for (int k = 0; k < soup.parts; k++) parts += around[k] = soup_winding(&soup, k, p) != 0;
    for (int t = 0; t < soup.num_triangles; t++) {
        double *ahead_at = &ahead.at[ahead.count];
        if (crosses(t, p, u, ahead_at) && *ahead_at > 0) ahead.triangle[ahead.count++] = t;
        assert_true(ahead.count < COUNT(ahead.at));
    }
    double at = 0;
    for (int next = take_next(&ahead, &at); next >= 0;) {
        const int before = parts;
        const double here = at;
        *triangle = next;
        for (;;) {
            const int part = soup.part[next];
            around[part] = !around[part];
            parts += around[part] ? 1 : -1;
            next = take_next(&ahead, &at);
            if (next < 0 || at > here + 1e-13) break;
            *triangle = -1;
        }
        if (!soup.unite || (before == 0) != (parts == 0)) return here;
    }
    return INFINITY;
}

/* Draws a point around the body, or at a vertex, on an edge or on a facet. */
static void choose_target(double p[3])
{
    const int t = dice_below(&dice, soup.num_triangles), kind = dice_below(&dice, 4);
    const double *a = soup.vertex[soup.triangle[t][0]], *b = soup.vertex[soup.triangle[t][1]],
                 *c = soup.vertex[soup.triangle[t][2]];
    const double s = kind > 0 ? dice_uniform(&dice) : 0, r = kind > 1 ? dice_uniform(&dice) * (1 - s) : 0;
    for (int k = 0; k < 3; k++) p[k] = a[k] + s * (b[k] - a[k]) + r * (c[k] - a[k]);
    if (kind < 3) return;
    dice_direction(&dice, p);
    for (int k = 0; k < 3; k++) p[k] *= k == 0 ? 3 : 1;
}

/* Random lines, none within rounding of an edge, have the same crossing in the fast and the exact query. A
 * third of them must meet something. */
static void compare_lines(int lines)
{
    const int flown = repeats(lines) < 125 ? 125 : repeats(lines);
    struct cml_mesh_surface *surface = surface_of_soup();
    int met = 0, wrong = 0;
    for (int i = 0; i < flown; i++) {
        struct cml_mesh_crossing crossing;
        double p[3], u[3];
        int triangle = -1;
        choose_target(p);
        dice_direction(&dice, u);
        for (int k = 0; k < 3; k++) p[k] += dice_between(&dice, -0.3, 0.3);
        const bool inside = soup_holds(&soup, p);
        const double t = first_boundary(p, u, &triangle);
        met += t < INFINITY;
        const double err_position = 4 * DBL_EPSILON * (fabs(p[0]) + fabs(p[1]) + fabs(p[2]));
        const int hit =
            cml_mesh_surface_hit(surface, p, u, inside, INFINITY, -1, 0, i % 2, err_position, &crossing);
        wrong += (hit != 0) != (t < INFINITY) ||
                 (hit && (fabs(crossing.t - t) > 1e-12 || (triangle >= 0 && crossing.primitive != triangle)));
    }
    cml_mesh_surface_free(surface);
    assert_true(met > flown / 3);
    if (wrong) fail_msg("%d of %d lines", wrong, flown);
}

static void lines_meet_what_long_double_says(void **state)
{
    (void)state;
    for (uint32_t seed = 1; seed <= 10; seed++) {
        make_nested(seed);
        compare_lines(1000);
    }
}

/* A walk of one packet. A place may be on the wrong side within 32 roundings of single precision, or 1024
 * of double, of its coordinates. */
struct walk {
    const struct cml_mesh_surface *surface;
    bool single;
    double p[3], u[3];
    bool inside;
    int on;
    int wrong, crossings;
};

static double rounding_at(const struct walk *walk, double steps)
{
    const double size = fabs(walk->p[0]) + fabs(walk->p[1]) + fabs(walk->p[2]);
    return steps * (walk->single ? (double)FLT_EPSILON : DBL_EPSILON) * size;
}

static void round_to(const struct walk *walk, const double from[3], double to[3])
{
    for (int k = 0; k < 3; k++) to[k] = walk->single ? (double)(float)from[k] : from[k];
}

/* Counts a place as wrong if it lies on the other side than the walk's, beyond rounding. */
static void check_side(struct walk *walk, const double at[3])
{
    if (soup_holds(&soup, at) == walk->inside) return;
    if (soup_distance(&soup, at) > rounding_at(walk, walk->single ? 32 : 1024)) walk->wrong++;
}

/* Flies a path of this length, to its end or to a crossing, where half of the packets are mirrored. */
static void take_step(struct walk *walk, double length)
{
    struct cml_mesh_crossing crossing = {.t = length, .primitive = -1};
    double middle[3], end[3];
    const int hit = cml_mesh_surface_hit(walk->surface, walk->p, walk->u, walk->inside, length, walk->on, 0,
                                         0, rounding_at(walk, 4), &crossing);
    const double t = hit ? crossing.t : length;
    cml_vec3_add_scaled(walk->p, t * dice_uniform(&dice), walk->u, middle);
    check_side(walk, middle);
    cml_vec3_add_scaled(walk->p, t, walk->u, end);
    round_to(walk, hit ? crossing.point : end, walk->p);
    walk->on = hit ? crossing.primitive : (crossing.ends_near_facet ? CML_NEAR_FACETS : -1);
    if (!hit) return;
    walk->crossings++;
    if (dice_below(&dice, 2)) {
        walk->inside = !walk->inside;
        return;
    }
    double turned[3];
    cml_vec3_add_scaled(walk->u, -2 * cml_vec3_dot(walk->u, crossing.facet), crossing.facet, turned);
    cml_vec3_normalise(turned);
    round_to(walk, turned, walk->u);
}

/* Lets a packet start somewhere, fly to a target or through it, scatter there, and so on. */
static void wander(struct walk *walk)
{
    double start[3];
    do {
        choose_target(start);
        for (int k = 0; k < 3; k++) start[k] += dice_between(&dice, -0.1, 0.1);
        round_to(walk, start, walk->p);
    } while (soup_distance(&soup, walk->p) < 1e-4);
    walk->inside = soup_holds(&soup, walk->p);
    walk->on = -1;
    for (int step = 0; step < 12 && !walk->wrong; step++) {
        double target[3], u[3], distance;
        choose_target(target);
        cml_vec3_subtract(target, walk->p, u);
        distance = cml_vec3_length(u);
        if (!(distance > 0) || dice_below(&dice, 4) == 0) dice_direction(&dice, u);
        cml_vec3_normalise(u);
        round_to(walk, u, walk->u);
        take_step(walk, distance * (dice_below(&dice, 3) ? 1 : dice_between(&dice, 0.5, 2)));
        while (walk->on >= 0) take_step(walk, dice_between(&dice, 0, 1));
        check_side(walk, walk->p);
    }
}

static void wander_often(int walks)
{
    struct cml_mesh_surface *surface = surface_of_soup();
    int wrong = 0, crossings = 0;
    for (int i = 0; i < repeats(walks); i++) {
        struct walk walk = {.surface = surface, .single = i % 2};
        wander(&walk);
        wrong += walk.wrong > 0;
        crossings += walk.crossings;
    }
    cml_mesh_surface_free(surface);
    assert_true(crossings > repeats(walks));
    if (wrong) fail_msg("%d of %d walks, %d crossings", wrong, walks, crossings);
}

static void packets_stay_on_their_side(void **state)
{
    (void)state;
    for (uint32_t seed = 1; seed <= 8; seed++) {
        make_nested(seed);
        wander_often(150);
    }
}

/* Boxes side by side and inside each other, much closer than single precision can tell apart. */
static void parts_may_be_closer_than_rounding(void **state)
{
    (void)state;
    static const double gaps[] = {1e-4, 1e-7, 1e-9, 1e-12, 1e-15};
    for (int i = 0; i < COUNT(gaps); i++) {
        const double gap = gaps[i], a[3] = {0.1, 0.2, 0.3}, b[3] = {0.7, 0.8, 0.9},
                     c[3] = {0.7 + gap, 0.1, 0.3}, d[3] = {1.4, 0.8 + gap, 1.1},
                     e[3] = {0.1 + gap, 0.2 + gap, 0.3 + gap}, f[3] = {0.5, 0.6, 0.9 - gap},
                     g[3] = {0.1, 0.8 + gap, 0.3}, h[3] = {0.7, 1.1, 1};
        soup = (struct soup){0};
        dice = dice_new((uint32_t)i);
        soup_box(&soup, a, b);
        soup_box(&soup, c, d);
        soup_box(&soup, e, f); /* a cavity of the first box that is open to all but three of its sides */
        soup_box(&soup, g, h);
        wander_often(2000);
    }
}

/* Makes the union of stones that cross and contain each other, boxes whose faces touch or lie in one plane,
 * and a long, thin body through all of them. */
static void make_union(uint32_t seed)
{
    soup = (struct soup){.unite = true};
    dice = dice_new(seed);
    for (int i = 0; i < 6; i++) {
        double centre[3];
        for (int k = 0; k < 3; k++) centre[k] = dice_between(&dice, -0.6, 0.6);
        const double radius = dice_between(&dice, 0.1, 0.7);
        soup_stone(&soup, &dice, centre, 3 + dice_below(&dice, 2), 0.7 * radius, radius);
        if (i == 0) soup_repeat(&soup, centre, 1 - 1e-6);
    }
    const double lower[3] = {0.5, -0.3, -0.3}, upper[3] = {1.1, 0.3, 0.3},
                 flush[2][3] = {{0.8, -0.1, -0.3}, {1.5, 0.2, 0.3}},
                 touching[2][3] = {{1.5, -0.05, -0.2}, {1.9, 0.1, 0.2}},
                 needle[2][3] = {{-1.2, 0.011, 0.012}, {2.2, 0.023, 0.021}};
    soup_box(&soup, lower, upper);
    soup_box(&soup, flush[0], flush[1]);
    soup_box(&soup, touching[0], touching[1]);
    soup_box(&soup, needle[0], needle[1]);
}

static void lines_meet_a_union_outside_of_all_other_parts(void **state)
{
    (void)state;
    for (uint32_t seed = 1; seed <= 10; seed++) {
        make_union(seed);
        compare_lines(1000);
    }
}

/* A line through a rod of overlapping boxes with a gap before the last ten: it has more crossings than are
 * sorted at once. */
static void lines_pass_a_hundred_parts(void **state)
{
    (void)state;
    struct cml_mesh_crossing crossing;
    int wrong = 0;
    soup = (struct soup){.unite = true};
    dice = dice_new(1);
    for (int i = 0; i < SOUP_PARTS; i++) {
        const double x = 0.1 * i + (i >= SOUP_PARTS - 10 ? 0.2 : 0), side = 0.5 + 1e-3 * (i * 37 % 20),
                     lower[3] = {x, -side, -side}, upper[3] = {x + 0.17, side, side};
        soup_box(&soup, lower, upper);
    }
    struct cml_mesh_surface *surface = surface_of_soup();
    for (int i = 0; i < 400; i++) {
        const bool inside = i % 2;
        double p[3] = {inside ? 0.05 : -1, dice_between(&dice, -0.2, 0.2), dice_between(&dice, -0.2, 0.2)},
               u[3] = {1, dice_between(&dice, -0.04, 0.04), dice_between(&dice, -0.04, 0.04)};
        int triangle = -1;
        cml_vec3_normalise(u);
        const double t = first_boundary(p, u, &triangle);
        const int hit =
            cml_mesh_surface_hit(surface, p, u, inside, INFINITY, -1, 0, i / 2 % 2, 1e-14, &crossing);
        wrong += !hit || fabs(crossing.t - t) > 1e-12 || (triangle >= 0 && crossing.primitive != triangle);
    }
    cml_mesh_surface_free(surface);
    assert_int_equal(wrong, 0);
}

/* A packet flies down inside a post, and rounding has put it beyond the post's wall, into the block that
 * the post ends in. It leaves at the block's end, not at the post's own end. */
static void a_packet_beside_a_wall_goes_on_into_the_next_part(void **state)
{
    (void)state;
    const double post[2][3] = {{0.2, 0.2, -0.5}, {0.4, 0.4, 0.5}}, block[2][3] = {{0, 0, 0}, {1, 1, 1}};
    struct cml_mesh_crossing crossing;
    int wrong = 0;
    soup = (struct soup){.unite = true};
    dice = dice_new(1);
    soup_box(&soup, post[0], post[1]);
    soup_box(&soup, block[0], block[1]);
    struct cml_mesh_surface *surface = surface_of_soup();
    for (int i = 0; i < 2000; i++) {
        const double aside = dice_below(&dice, 3) * 6e-8, tilt = i % 2 ? 0 : -dice_uniform(&dice) * 1e-8;
        const double p[3] = {(double)(0.4F) + aside, dice_between(&dice, 0.21, 0.39),
                             dice_between(&dice, -0.4, -0.1)},
                     u[3] = {tilt, 0, 1}, err_position = 4 * (double)FLT_EPSILON * (p[0] + p[1] - p[2]);
        const int hit = cml_mesh_surface_hit(surface, p, u, 1, INFINITY, i % 3 ? -1 : CML_NEAR_FACETS, 0,
                                             i / 2 % 2, err_position, &crossing);
        wrong += !hit || fabs(crossing.t - (1 - p[2])) > 1e-6;
    }
    cml_mesh_surface_free(surface);
    if (wrong) fail_msg("%d of 2000", wrong);
}

/* A packet has entered a thin wall, and rounding has put it into the cavity behind. At a small angle its
 * line passes the wall far before that place. The packet leaves the wall at once, not at the far end of
 * the cavity. */
static void a_packet_beyond_a_thin_wall_leaves_it_at_any_angle(void **state)
{
    (void)state;
    const double wall = 1e-12, box[2][3] = {{0, 0, 0.3}, {1, 1, 0.9}},
                 cavity[2][3] = {{wall, wall, 0.3 + wall}, {1 - wall, 1 - wall, 0.9 - wall}};
    const float beyond = 0.3F;
    int wrong = 0;
    soup = (struct soup){0};
    dice = dice_new(1);
    soup_box(&soup, box[0], box[1]);
    soup_box(&soup, cavity[0], cavity[1]);
    struct cml_mesh_surface *surface = surface_of_soup();
    for (int i = 0; i < 2000; i++) {
        const double rise = pow(10, dice_between(&dice, -5, -1)), p[3] = {0.2, 0.6, (double)beyond},
                     u[3] = {sqrt(1 - rise * rise), 0, rise}, up[3] = {0, 0, 1}, below[3] = {p[0], p[1], 0.2},
                     err_position = 4 * (double)FLT_EPSILON * (p[0] + p[1] + p[2]);
        struct cml_mesh_crossing crossing;
        assert_true(cml_mesh_surface_hit(surface, below, up, 0, 1, -1, 0, 1, err_position, &crossing));
        const int hit = cml_mesh_surface_hit(surface, p, u, 1, INFINITY, crossing.primitive, i % 2, i / 2 % 2,
                                             err_position, &crossing);
        wrong += !hit || crossing.t > 0;
    }
    cml_mesh_surface_free(surface);
    if (wrong) fail_msg("%d of 2000", wrong);
}

/* A line leaves one box where two faces touch, on an edge of the other box; rounding exchanges the order
 * of their crossings. */
static void a_line_leaves_at_the_edge_of_a_touching_face(void **state)
{
    (void)state;
    static const double boxes[5][4] = {{0.1, 0, 0, 0},
                                       {0.1, 0.07, 0.03, 0},
                                       {0.05, 0.22, 0.01, 0.02},
                                       {0.06, 0, 0, 0},
                                       {0.1, -0.2 - 1e-9, 0.03, 0.02}};
    const double p[3] = {0.16970238618574029, -0.039787772641721363, 0.5301743217340158},
                 u[3] = {0.73489932822570969, -0.52405411159437087, -0.4304535578833511};
    struct cml_mesh_crossing crossing;
    soup = (struct soup){.unite = true};
    dice = dice_new(1);
    for (int b = 0; b < 5; b++) {
        double lower[3], upper[3];
        for (int k = 0; k < 3; k++) {
            lower[k] = -boxes[b][0] + boxes[b][1 + k];
            upper[k] = boxes[b][0] + boxes[b][1 + k];
        }
        const double top = -(upper[2] - 0.5), bottom = -(lower[2] - 0.5);
        lower[2] = top;
        upper[2] = bottom;
        soup_box(&soup, lower, upper);
    }
    struct cml_mesh_surface *surface = surface_of_soup();
    assert_true(cml_mesh_surface_hit(surface, p, u, 1, 0.05, -1, 0, 1, 4 * DBL_EPSILON * 0.74, &crossing));
    assert_near("distance", crossing.t, 0.00040497222249237, 1e-15);
    cml_mesh_surface_free(surface);
}

static void packets_stay_on_their_side_of_a_union(void **state)
{
    (void)state;
    for (uint32_t seed = 1; seed <= 10; seed++) {
        make_union(seed);
        wander_often(250);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(facets_look_out_of_what_they_bound),
        cmocka_unit_test(lines_meet_what_long_double_says),
        cmocka_unit_test(packets_stay_on_their_side),
        cmocka_unit_test(parts_may_be_closer_than_rounding),
        cmocka_unit_test(lines_meet_a_union_outside_of_all_other_parts),
        cmocka_unit_test(lines_pass_a_hundred_parts),
        cmocka_unit_test(a_packet_beside_a_wall_goes_on_into_the_next_part),
        cmocka_unit_test(a_packet_beyond_a_thin_wall_leaves_it_at_any_angle),
        cmocka_unit_test(a_line_leaves_at_the_edge_of_a_touching_face),
        cmocka_unit_test(packets_stay_on_their_side_of_a_union),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
