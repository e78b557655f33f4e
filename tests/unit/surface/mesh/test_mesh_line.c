/* Tests of queries near vertices and edges: a straight line must end on the side where its end lies,
 * whatever rounding has done to the packet's position. SPDX-License-Identifier: MIT */
#include "lib/mesh_shapes.h"
#include "geometry/predicate.h"
#include "surface/mesh/mesh_surface.h"
#include "surface_hit.h"
#include "geometry/vec3.h"

#include <float.h>

enum { LINES = 20000, MOST_CROSSINGS = 100 };

static struct patch patch;

/* Draws a place a few roundings from a vertex, or from a point of an edge at that vertex. Returns the
 * triangle. */
static int choose_place(struct dice *dice, double p[3])
{
    const int triangle = dice_below(dice, COUNT(patch.triangle));
    const uint32_t *v = patch.triangle[triangle];
    const double *a = patch.vertex[v[0]], *b = patch.vertex[v[1]];
    const double s = dice_below(dice, 2) ? dice_uniform(dice) : 0;
    for (int k = 0; k < 3; k++) {
        const double rounding = dice_below(dice, 2) ? 6e-8 * (fabs(a[k]) + 0.1) : 0;
        p[k] = (float)(a[k] + s * (b[k] - a[k]) + dice_between(dice, -1, 1) * rounding);
    }
    return triangle;
}

/* Follows a packet between equal indices from one crossing to the next. Returns true if it ends below. */
static bool goes_straight_on(const struct cml_mesh_surface *surface, const double start[3], const double u[3],
                             bool below, int on_primitive)
{
    struct cml_mesh_crossing crossing;
    double p[3] = {start[0], start[1], start[2]};
    for (int n = 0; n < MOST_CROSSINGS; n++) {
        const double slack = 4 * (double)FLT_EPSILON * (fabs(p[0]) + fabs(p[1]) + fabs(p[2]));
        if (!cml_mesh_surface_hit(surface, p, u, below, INFINITY, on_primitive, n > 0, n % 2, slack,
                                  &crossing))
            return below;
        below = !below;
        on_primitive = crossing.primitive;
        for (int k = 0; k < 3; k++) p[k] = (float)crossing.point[k];
    }
    fail_msg("%d crossings", MOST_CROSSINGS);
    return below;
}

/* The line starts on either side, because rounding may have put it there from both. */
static void a_straight_line_ends_where_it_ends(void **state)
{
    (void)state;
    struct dice dice = dice_new(7);
    int wrong = 0;
    patch_make(&patch, 3, 0.05, 0, 0, 0);
    struct cml_mesh mesh = patch_mesh(&patch);
    struct cml_mesh_surface *surface = NULL;
    struct cml_error err;
    assert_int_equal(cml_mesh_surface_create(&mesh, 0, 0, CML_SEARCH_AUTO, &surface, &err), CML_OK);
    for (int n = 0; n < repeats(LINES); n++) {
        double p[3], u[3];
        const int triangle = choose_place(&dice, p);
        dice_direction(&dice, u);
        for (int k = 0; k < 3; k++) u[k] = (float)u[k];
        if (goes_straight_on(surface, p, u, dice_below(&dice, 2), triangle) != (u[2] > 0)) wrong++;
    }
    cml_mesh_surface_free(surface);
    assert_int_equal(wrong, 0);
}

enum { STEEPNESS = 1000, MOST_BOUNCES = 10000 };

static const double aside = 0.1; /* bottoms lie between numbers of single precision */

/* Returns grooves along y with walls of slope STEEPNESS and bottoms at depth 0. */
static struct cml_mesh_surface *grooves(void)
{
    patch_make(&patch, 3, 0, 0, aside, 0);
    for (int i = 1; i < GRID; i += 2)
        for (int j = 1; j < GRID; j++)
            patch.vertex[i * (GRID + 1) + j][2] = -STEEPNESS * patch_coordinate(GRID / 2 + 1);
    struct cml_mesh mesh = patch_mesh(&patch);
    struct cml_mesh_surface *surface = NULL;
    struct cml_error err;
    assert_int_equal(cml_mesh_surface_create(&mesh, 0, 0, CML_SEARCH_AUTO, &surface, &err), CML_OK);
    return surface;
}

/* True if a packet that heads down in a groove meets wall after wall until it heads up, however little
 * room is left between the walls. */
static bool comes_out_of_groove(const struct cml_mesh_surface *surface, double p[3], double u[3])
{
    struct cml_mesh_crossing crossing = {.primitive = -1};
    for (int n = 0; n < MOST_BOUNCES && u[2] > 0; n++) {
        const double slack = 4 * (double)FLT_EPSILON * (fabs(p[0]) + fabs(p[1]) + fabs(p[2]));
        if (!cml_mesh_surface_hit(surface, p, u, 0, INFINITY, crossing.primitive, 0, 0, slack, &crossing))
            return false;
        double along = 0;
        for (int k = 0; k < 3; k++) along += u[k] * crossing.facet[k];
        for (int k = 0; k < 3; k++) {
            u[k] = (float)(u[k] - 2 * along * crossing.facet[k]);
            p[k] = (float)crossing.point[k];
        }
    }
    return !(u[2] > 0);
}

static void a_packet_comes_out_of_a_groove(void **state)
{
    (void)state;
    struct dice dice = dice_new(9);
    struct cml_mesh_surface *surface = grooves();
    int lost = 0;
    for (int n = 0; n < repeats(1000); n++) {
        const double x = aside + patch_coordinate(2 + 2 * dice_below(&dice, GRID / 2 - 2));
        const double ulps = dice_below(&dice, 5) - 2;
        double u[3] = {0, 0, 1};
        double p[3] = {(float)(x + ulps * (double)FLT_EPSILON * fabs(x)),
                       (float)dice_between(&dice, -0.9, 0.9), -30};
        lost += !comes_out_of_groove(surface, p, u);
    }
    cml_mesh_surface_free(surface);
    assert_int_equal(lost, 0);
}

static struct cml_mesh_surface *surface_of_patch(enum cml_mesh_search search)
{
    struct cml_mesh mesh = patch_mesh(&patch);
    struct cml_mesh_surface *surface = NULL;
    struct cml_error err;
    assert_int_equal(cml_mesh_surface_create(&mesh, 0, 0, search, &surface, &err), CML_OK);
    return surface;
}

static struct cml_mesh_surface *rough(uint32_t seed, enum cml_mesh_search search)
{
    patch_make(&patch, seed, 0.1, 0, 0, 0);
    return surface_of_patch(search);
}

static double depth_below(const double p[3], const double u[3], double t)
{
    return p[2] + t * u[2] - patch_depth(&patch, p[0] + t * u[0], p[1] + t * u[1]);
}

/* True if a path from p leads beyond the patch by more than rounding. */
static bool goes_beyond(const double p[3], const double u[3], bool below, double length)
{
    int beyond = 0;
    for (int k = 1; k < 32; k++) beyond += (below ? 1 : -1) * depth_below(p, u, length * k / 32) < -1e-6;
    return beyond > 0;
}

/* Fast queries find the first crossing even if rounding leaves open on which side of an edge the packet
 * lies. */
static void a_packet_at_an_edge_leaves_by_it(void **state)
{
    (void)state;
    struct dice dice = dice_new(10);
    struct cml_mesh_surface *surface = rough(4, CML_SEARCH_TREE);
    int wrong = 0;
    for (int n = 0; n < repeats(100000); n++) {
        double p[3], u[3];
        struct cml_mesh_crossing crossing = {.t = 1};
        choose_place(&dice, p);
        dice_direction(&dice, u);
        for (int k = 0; k < 3; k++) u[k] = (float)u[k];
        const bool below = depth_below(p, u, 0) > 0;
        cml_mesh_surface_hit(surface, p, u, below, INFINITY, -1, 0, 0, 1e-7, &crossing);
        wrong += goes_beyond(p, u, below, crossing.t);
    }
    cml_mesh_surface_free(surface);
    assert_int_equal(wrong, 0);
}

/* Draws a packet that flies along an edge, from its first third, standing on one of its triangles, to an
 * interaction on the edge, which rounding puts on any side. Returns false if the path meets something. */
static bool interacts_on_edge(const struct cml_mesh_surface *surface, struct dice *dice, bool below,
                              double p[3])
{
    const int triangle = dice_below(dice, COUNT(patch.triangle));
    const double *a = patch.vertex[patch.triangle[triangle][0]],
                 *b = patch.vertex[patch.triangle[triangle][1]];
    const double s = dice_between(dice, 0.1, 0.3);
    double u[3], size = 0;
    struct cml_mesh_crossing crossing;
    for (int k = 0; k < 3; k++) size = hypot(size, b[k] - a[k]);
    for (int k = 0; k < 3; k++) {
        p[k] = (float)(a[k] + s * (b[k] - a[k]));
        u[k] = (float)((b[k] - a[k]) / size);
    }
    const double t_max = size * dice_between(dice, 0.1, 0.6);
    if (cml_mesh_surface_hit(surface, p, u, below, t_max, triangle, 1, 0, 1e-7, &crossing)) return false;
    assert_true(crossing.ends_near_facet);
    for (int k = 0; k < 3; k++) p[k] = (float)(p[k] + t_max * u[k]);
    return true;
}

/* Fast queries of packets that have interacted on an edge: a line there may miss all facets. on_primitive:
 * what the packet knows from the query before. */
static void leave_by_edges(enum cml_mesh_search search, int on_primitive)
{
    struct dice dice = dice_new(12);
    struct cml_mesh_surface *surface = rough(6, search);
    int wrong = 0, flown = 0;
    for (int n = 0; n < repeats(100000); n++) {
        double p[3], u[3];
        struct cml_mesh_crossing crossing = {.t = 0.05};
        const bool below = dice_below(&dice, 2);
        if (!interacts_on_edge(surface, &dice, below, p)) continue;
        dice_direction(&dice, u);
        for (int k = 0; k < 3; k++) u[k] = (float)u[k];
        cml_mesh_surface_hit(surface, p, u, below, 0.05, on_primitive, 0, 0, 1e-7, &crossing);
        wrong += goes_beyond(p, u, below, crossing.t);
        flown++;
    }
    cml_mesh_surface_free(surface);
    assert_true(flown > repeats(10000));
    assert_int_equal(wrong, 0);
}

static void a_packet_scattered_on_an_edge_leaves_by_it(void **state)
{
    (void)state;
    leave_by_edges(CML_SEARCH_TREE, CML_NEAR_FACETS);
    leave_by_edges(CML_SEARCH_AUTO, CML_NEAR_FACETS);
}

static void a_packet_scattered_unnoticed_on_an_edge_leaves_by_it(void **state)
{
    (void)state;
    leave_by_edges(CML_SEARCH_TREE, -1);
    leave_by_edges(CML_SEARCH_AUTO, -1);
}

/* Draws a float place near a triangle and a direction within `angle` (rad) of its plane. */
static void graze_from_facet(struct dice *dice, double angle, double p[3], double u[3])
{
    const uint32_t *v = patch.triangle[dice_below(dice, COUNT(patch.triangle))];
    const double *a = patch.vertex[v[0]], *b = patch.vertex[v[1]], *c = patch.vertex[v[2]];
    const double s = dice_uniform(dice), t = (1 - s) * dice_uniform(dice);
    const double along = dice_between(dice, -1, 1), across = dice_between(dice, -1, 1);
    double to_b[3], to_c[3], normal[3];
    for (int k = 0; k < 3; k++) {
        to_b[k] = b[k] - a[k];
        to_c[k] = c[k] - a[k];
        p[k] = (float)(a[k] + s * to_b[k] + t * to_c[k] + dice_between(dice, -3e-8, 3e-8));
        u[k] = along * to_b[k] + across * to_c[k];
    }
    cml_vec3_cross(to_b, to_c, normal);
    const double tilt =
        dice_between(dice, -angle, angle) * sqrt(cml_vec3_dot(u, u) / cml_vec3_dot(normal, normal));
    for (int k = 0; k < 3; k++) u[k] += tilt * normal[k];
    const double size = sqrt(cml_vec3_dot(u, u));
    for (int k = 0; k < 3; k++) u[k] = (float)(u[k] / size);
}

/* Fast queries of packets that interacted within rounding of a facet and fly on along it. For Embree, in
 * single precision, that facet may lie behind them. */
static void a_packet_scattered_on_a_facet_does_not_graze_its_way_through(void **state)
{
    (void)state;
    struct dice dice = dice_new(16);
    for (int search = 0; search < 2; search++) {
        struct cml_mesh_surface *surface = rough(6, search ? CML_SEARCH_AUTO : CML_SEARCH_TREE);
        int wrong = 0;
        for (int n = 0; n < repeats(300000); n++) {
            double p[3], u[3];
            struct cml_mesh_crossing crossing = {.t = 0.05};
            const bool below = dice_below(&dice, 2);
            graze_from_facet(&dice, pow(0.1, 1 + n % 6), p, u);
            cml_mesh_surface_hit(surface, p, u, below, 0.05, -1, 0, 0, 1e-7, &crossing);
            wrong += goes_beyond(p, u, below, crossing.t);
        }
        cml_mesh_surface_free(surface);
        assert_int_equal(wrong, 0);
    }
}

/* Fast queries that graze a facet, with a path that ends far beyond all facets. */
static void a_packet_does_not_graze_its_way_through(void **state)
{
    (void)state;
    struct dice dice = dice_new(11);
    struct cml_mesh_surface *surface = rough(5, CML_SEARCH_TREE);
    int missed = 0;
    for (int n = 0; n < repeats(300000); n++) {
        const uint32_t *v = patch.triangle[dice_below(&dice, COUNT(patch.triangle))];
        const double *a = patch.vertex[v[0]], *b = patch.vertex[v[1]], *c = patch.vertex[v[2]];
        const double s = dice_between(&dice, 0, 0.5), t = dice_between(&dice, 0, 0.5), angle = 3e-7;
        double p[3], u[3], size = 0;
        for (int k = 0; k < 3; k++) u[k] = dice_between(&dice, -1, 1) * (b[k] - a[k]) + (c[k] - a[k]) / 2;
        for (int k = 0; k < 3; k++) size = hypot(size, u[k]);
        for (int k = 0; k < 3; k++) u[k] = u[k] / size - (k == 2 ? angle : 0);
        for (int k = 0; k < 3; k++)
            p[k] = (float)(a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]) - 0.02 * u[k]);
        for (int k = 0; k < 3; k++) u[k] = (float)u[k];
        struct cml_mesh_crossing crossing;
        const bool below = depth_below(p, u, 0) > 0;
        if (below != (u[2] < 0) || fabs(u[2]) < 0.01) continue;
        missed += !cml_mesh_surface_hit(surface, p, u, below, 100, -1, 0, 0, 1e-7, &crossing);
    }
    cml_mesh_surface_free(surface);
    assert_int_equal(missed, 0);
}

/* Fast queries through a corner and on along an edge, but for rounding, that end within the depths of the
 * mesh. Only the corner itself shows that such packets leave there. */
static void a_packet_does_not_slip_out_along_an_edge(void **state)
{
    (void)state;
    struct dice dice = dice_new(13);
    struct cml_mesh_surface *surface = rough(7, CML_SEARCH_TREE);
    int wrong = 0, flown = 0;
    for (int n = 0; n < repeats(200000); n++) {
        const uint32_t *v = patch.triangle[dice_below(&dice, COUNT(patch.triangle))];
        const double *a = patch.vertex[v[0]], *b = patch.vertex[v[1]];
        const double before = exp(dice_between(&dice, -4, 0)), after = dice_between(&dice, 0.01, 0.3);
        double p[3], u[3], size = 0;
        struct cml_mesh_crossing crossing = {.t = before + after};
        for (int k = 0; k < 3; k++) size = hypot(size, b[k] - a[k]);
        for (int k = 0; k < 3; k++) p[k] = (float)(a[k] - before * (b[k] - a[k]) / size);
        for (int k = 0; k < 3; k++) u[k] = (float)((a[k] - p[k]) / before);
        const double depth = depth_below(p, u, 0);
        if (fabs(depth) < 1e-5) continue;
        cml_mesh_surface_hit(surface, p, u, depth > 0, crossing.t, -1, 0, 0, 1e-7, &crossing);
        int beyond = 0;
        for (int k = 1; k <= 32; k++)
            beyond += (depth > 0 ? 1 : -1) * depth_below(p, u, crossing.t * k / 32) < -1e-5;
        wrong += beyond > 0;
        flown++;
    }
    cml_mesh_surface_free(surface);
    assert_true(flown > repeats(150000));
    assert_int_equal(wrong, 0);
}

/* Draws a line towards a place of an edge, at a small angle to a facet of that edge. */
static void graze_edge(struct dice *dice, double before, double p[3], double u[3])
{
    const uint32_t *v = patch.triangle[dice_below(dice, COUNT(patch.triangle))];
    const double *a = patch.vertex[v[0]], *b = patch.vertex[v[1]], *c = patch.vertex[v[2]];
    const double angle = exp(dice_between(dice, -9, -4)), s = dice_uniform(dice);
    const double along = dice_between(dice, -1, 1), across = dice_between(dice, -1, 1);
    double size = 0;
    for (int k = 0; k < 3; k++) u[k] = along * (b[k] - a[k]) + across * (c[k] - a[k]);
    for (int k = 0; k < 3; k++) size = hypot(size, u[k]);
    for (int k = 0; k < 3; k++) u[k] = u[k] / size + (k == 2 ? angle : 0);
    for (int k = 0; k < 3; k++) p[k] = (float)(a[k] + s * (b[k] - a[k]) - before * u[k]);
    size = 0;
    for (int k = 0; k < 3; k++) u[k] = a[k] + s * (b[k] - a[k]) - p[k];
    for (int k = 0; k < 3; k++) size = hypot(size, u[k]);
    for (int k = 0; k < 3; k++) u[k] = (float)(u[k] / size);
}

/* Fast queries that graze facets along their common edge, with paths that end within the depths of the
 * mesh. */
static void a_packet_does_not_graze_its_way_between_facets(void **state)
{
    (void)state;
    struct dice dice = dice_new(14);
    struct cml_mesh_surface *surface = rough(8, CML_SEARCH_TREE);
    int wrong = 0, flown = 0;
    for (int n = 0; n < repeats(500000); n++) {
        double p[3], u[3];
        const double before = exp(dice_between(&dice, -7, -3));
        struct cml_mesh_crossing crossing = {.t = before + exp(dice_between(&dice, -7, -3))};
        graze_edge(&dice, before, p, u);
        const double depth = depth_below(p, u, 0);
        if (fabs(depth) < 1e-6) continue;
        cml_mesh_surface_hit(surface, p, u, depth > 0, crossing.t, -1, 0, 0, 1e-7, &crossing);
        wrong += (depth > 0 ? 1 : -1) * depth_below(p, u, crossing.t) < -2e-6;
        flown++;
    }
    cml_mesh_surface_free(surface);
    assert_true(flown > repeats(250000));
    assert_int_equal(wrong, 0);
}

/* Returns a mesh that is almost flat but for a spike, so that the border's depth is no round number in the
 * mesh's own frame. */
static struct cml_mesh_surface *spike(void)
{
    patch_make(&patch, 9, 1e-6, 0, 0, 0);
    patch.vertex[GRID / 2 * (GRID + 1) + GRID / 2][2] = -0.3;
    return surface_of_patch(CML_SEARCH_TREE);
}

/* Fast queries that pass at a small angle where the mesh ends in the outer plane, through one or the
 * other. */
static void a_packet_does_not_graze_its_way_through_the_border(void **state)
{
    (void)state;
    struct dice dice = dice_new(15);
    struct cml_mesh_surface *surface = spike();
    int missed = 0;
    for (int n = 0; n < repeats(100000); n++) {
        const double phi = dice_between(&dice, 0, 6.283185307179586),
                     angle = exp(dice_between(&dice, -9, -4));
        const double before = dice_between(&dice, 0.1, 0.3), after = dice_between(&dice, 0.1, 0.3);
        const double near = dice_between(&dice, -1e-3, 1e-3);
        const bool below = dice_below(&dice, 2);
        const double u[3] = {(float)cos(phi), (float)sin(phi), (float)(below ? -angle : angle)};
        const double p[3] = {(float)(1 + near - before * u[0]),
                             (float)(dice_between(&dice, -0.5, 0.5) - before * u[1]),
                             (float)(-before * u[2])};
        struct cml_mesh_crossing crossing;
        if (fabs(p[0]) < 1 || (below ? 1 : -1) * depth_below(p, u, before + after) > -3e-6) continue;
        missed += !cml_mesh_surface_hit(surface, p, u, below, before + after, -1, 0, 0, 1e-7, &crossing);
    }
    cml_mesh_surface_free(surface);
    assert_int_equal(missed, 0);
}

/* A line exactly through a vertex, or along an edge, passes the triangles there as if they were one sheet. */
static void signs_agree_at_a_vertex(void **state)
{
    (void)state;
    struct dice dice = dice_new(8);
    for (int n = 0; n < repeats(LINES); n++) {
        const double o[3] = {dice_below(&dice, 5) - 2, dice_below(&dice, 5) - 2, dice_below(&dice, 5) - 5};
        const double u[3] = {-o[0], -o[1], -o[2]}; /* through the vertex at 0 */
        double rim[6][3];
        int crossed = 0;
        for (int k = 0; k < 6; k++) {
            const double turn = 6.283185307179586 * k / 6;
            rim[k][0] = round(4 * cos(turn)) + dice_below(&dice, 2);
            rim[k][1] = round(4 * sin(turn)) + dice_below(&dice, 2);
            rim[k][2] = 0;
        }
        const double tip[3] = {0, 0, 0};
        for (int k = 0; k < 6; k++) {
            const double *a = rim[k], *b = rim[(k + 1) % 6];
            const int first = cml_line_side(tip, a, o, u), last = -cml_line_side(tip, b, o, u),
                      rest = cml_line_side(a, b, o, u);
            crossed += first == rest && last == rest;
            assert_true(first != 0 && last != 0 && rest != 0 && cml_plane_side(tip, a, b, tip) != 0);
        }
        assert_int_equal(crossed, 1);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_straight_line_ends_where_it_ends),
        cmocka_unit_test(a_packet_comes_out_of_a_groove),
        cmocka_unit_test(a_packet_at_an_edge_leaves_by_it),
        cmocka_unit_test(a_packet_scattered_on_an_edge_leaves_by_it),
        cmocka_unit_test(a_packet_scattered_unnoticed_on_an_edge_leaves_by_it),
        cmocka_unit_test(a_packet_scattered_on_a_facet_does_not_graze_its_way_through),
        cmocka_unit_test(a_packet_does_not_graze_its_way_through),
        cmocka_unit_test(a_packet_does_not_slip_out_along_an_edge),
        cmocka_unit_test(a_packet_does_not_graze_its_way_between_facets),
        cmocka_unit_test(a_packet_does_not_graze_its_way_through_the_border),
        cmocka_unit_test(signs_agree_at_a_vertex)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
