/* Tests of queries in a concave vertex: a ring of triangles that meets at a tip below their border.
 * Lines run along the edges to the tip, past the border, near the tip, and at a corner of the border. All
 * but the last test use double precision. SPDX-License-Identifier: MIT */
#include "lib/mesh_shapes.h"
#include "surface_hit.h"
#include "surface/mesh/mesh_surface.h"
#include "geometry/vec3.h"

#include <float.h>

enum { MOST_SIDES = 50, MOST_EVENTS = 1000 };

struct concave {
    int sides;
    double rounding; /* allowed error of crossings, cm */
    double tip[3], corner[MOST_SIDES][3];
    struct cml_mesh_surface *surface;
};

static struct concave concave_make(int sides, double radius, double depth)
{
    struct concave concave = {.sides = sides, .rounding = 1e-15 + 1e-16 * radius, .tip = {0, 0, depth}};
    struct cml_mesh mesh = {.num_vertices = (size_t)sides + 1, .num_triangles = (size_t)sides};
    struct cml_error err = {CML_OK, ""};
    mesh.vertex = malloc(mesh.num_vertices * sizeof *mesh.vertex);
    mesh.triangle = malloc(mesh.num_triangles * sizeof *mesh.triangle);
    assert_true(mesh.vertex && mesh.triangle);
    for (int i = 0; i < sides; i++) {
        concave.corner[i][0] = radius * cos(6.283185307179586 * i / sides);
        concave.corner[i][1] = radius * sin(6.283185307179586 * i / sides);
        const uint32_t triangle[3] = {(uint32_t)i, (uint32_t)((i + 1) % sides), (uint32_t)sides};
        memcpy(mesh.vertex[i], concave.corner[i], sizeof concave.corner[i]);
        memcpy(mesh.triangle[i], triangle, sizeof triangle);
    }
    memcpy(mesh.vertex[sides], concave.tip, sizeof concave.tip);
    assert_int_equal(cml_mesh_prepare(&mesh, NULL, NULL, &err), CML_OK);
    assert_int_equal(cml_mesh_surface_create(&mesh, 0, 0, CML_SEARCH_TREE, &concave.surface, &err), CML_OK);
    return concave;
}

static double slack_at(const double p[3])
{
    return 4 * DBL_EPSILON * (fabs(p[0]) + fabs(p[1]) + fabs(p[2]));
}

static void mirror(const double facet[3], double u[3])
{
    const double along = cml_vec3_dot(u, facet);
    for (int k = 0; k < 3; k++) u[k] -= 2 * along * facet[k];
}

/* Returns the distance (cm) of a place from the plane of wall i; positive inside the wall. */
static double depth_in_wall(const struct concave *concave, int i, const double place[3])
{
    const double *a = concave->corner[i], *b = concave->corner[(i + 1) % concave->sides];
    double ab[3], to_tip[3], normal[3], from[3];
    cml_vec3_subtract(b, a, ab);
    cml_vec3_subtract(concave->tip, a, to_tip);
    cml_vec3_cross(ab, to_tip, normal);
    cml_vec3_subtract(place, a, from);
    return cml_vec3_dot(normal, from) / sqrt(cml_vec3_dot(normal, normal));
}

/* True if the place at distance t from p lies below the surface by more than rounding. */
static bool is_in_wall(const struct concave *concave, const double p[3], double t, const double u[3])
{
    double place[3];
    for (int k = 0; k < 3; k++) place[k] = p[k] + t * u[k];
    bool in_wall = false;
    for (int i = 0; i < concave->sides; i++) in_wall = in_wall || depth_in_wall(concave, i, place) > 1e-9;
    return place[2] > 0 && in_wall;
}

/* Returns the distance of a crossing from the plane that is crossed. */
static double off_plane(const struct concave *concave, const struct cml_mesh_crossing *crossing)
{
    const bool outside = crossing->primitive == CML_OUTER_PLANE;
    return fabs(outside ? crossing->point[2] : depth_in_wall(concave, crossing->primitive, crossing->point));
}

/* Flies a line until it meets nothing: at each crossing it passes to the other side, or it is always
 * mirrored. Returns true if the line ends on the side that its direction leads to. A line mirrored above
 * the surface must also stay above it. */
static bool ends_where_it_heads(const struct concave *concave, double p[3], double u[3], bool below,
                                bool mirrored, int on_primitive)
{
    struct cml_mesh_crossing crossing;
    for (int n = 0; n < MOST_EVENTS; n++) {
        const bool found = cml_mesh_surface_hit(concave->surface, p, u, below, INFINITY, on_primitive,
                                                n > 0 && !mirrored, true, slack_at(p), &crossing);
        if (mirrored && !below && is_in_wall(concave, p, found ? crossing.t / 2 : 0.01, u)) return false;
        if (!found) return below == (u[2] > 0);
        if (!mirrored && off_plane(concave, &crossing) > concave->rounding) return false;
        if (mirrored)
            mirror(crossing.facet, u);
        else
            below = !below;
        on_primitive = crossing.primitive;
        memcpy(p, crossing.point, sizeof crossing.point);
    }
    return false;
}

static void head_for(const double p[3], const double place[3], double u[3])
{
    cml_vec3_subtract(place, p, u);
    const double size = sqrt(cml_vec3_dot(u, u));
    for (int k = 0; k < 3; k++) u[k] /= size;
}

/* Lines go down along an edge, from one of its facets or from no facet: neither facet's plane says where
 * the line meets it. */
static void a_line_along_an_edge_ends_where_it_ends(void **state)
{
    (void)state;
    struct dice dice = dice_new(1);
    const struct concave concave = concave_make(3, 0.5, 0.5 / sqrt(2));
    int wrong = 0;
    for (int n = 0; n < repeats(200000); n++) {
        const int i = dice_below(&dice, 3), on_primitive = dice_below(&dice, 2) ? i : (i + 2) % 3;
        const double s = dice_between(&dice, 0.01, 0.99), way = dice_below(&dice, 2) ? 1 : -1;
        double p[3], u[3];
        for (int k = 0; k < 3; k++)
            p[k] = concave.corner[i][k] + s * (concave.tip[k] - concave.corner[i][k]) +
                   dice_between(&dice, -1, 1) * 1e-16;
        head_for(concave.corner[i], concave.tip, u);
        for (int k = 0; k < 3; k++) u[k] = way * (u[k] + dice_between(&dice, -1, 1) * 3e-16);
        wrong += !ends_where_it_heads(&concave, p, u, dice_below(&dice, 2), false,
                                      dice_below(&dice, 3) ? on_primitive : -1);
    }
    cml_mesh_surface_free(concave.surface);
    assert_int_equal(wrong, 0);
}

/* Tests lines at small angles to the facets of a very flat concave vertex, where small roundings of positions
 * move crossings far along the facets. */
static void a_line_that_grazes_an_edge_ends_where_it_ends(void **state)
{
    (void)state;
    struct dice dice = dice_new(5);
    const struct concave concave = concave_make(3, 100, 0.01);
    int wrong = 0;
    for (int n = 0; n < repeats(200000); n++) {
        const int i = dice_below(&dice, 3), on_primitive = dice_below(&dice, 2) ? i : (i + 2) % 3;
        const double s = dice_between(&dice, 0.9, 0.999), angle = exp(dice_between(&dice, -16, -7)),
                     way = dice_below(&dice, 2) ? 1 : -1;
        double p[3], u[3];
        for (int k = 0; k < 3; k++) p[k] = concave.corner[i][k] + s * (concave.tip[k] - concave.corner[i][k]);
        head_for(concave.corner[i], concave.tip, u);
        for (int k = 0; k < 3; k++) u[k] = way * (u[k] + dice_between(&dice, -1, 1) * angle);
        head_for(p, (double[3]){p[0] + u[0], p[1] + u[1], p[2] + u[2]}, u);
        wrong += !ends_where_it_heads(&concave, p, u, dice_below(&dice, 2), false,
                                      dice_below(&dice, 3) ? on_primitive : -1);
    }
    cml_mesh_surface_free(concave.surface);
    assert_int_equal(wrong, 0);
}

/* A packet is mirrored by a wall at a grazing angle, exactly where the wall ends in the plane. */
static void a_packet_is_mirrored_at_the_border(void **state)
{
    (void)state;
    struct dice dice = dice_new(2);
    const struct concave concave = concave_make(50, 0.05, 0.5);
    int wrong = 0;
    for (int n = 0; n < repeats(500000); n++) {
        const int i = dice_below(&dice, 50);
        const double *a = concave.corner[i], *b = concave.corner[(i + 1) % 50];
        const double s = dice_uniform(&dice), t = dice_between(&dice, -0.3, 0.3),
                     angle = exp(dice_between(&dice, -7, -6)), before = exp(dice_between(&dice, -9, -2));
        const bool below = dice_below(&dice, 2);
        double place[3], p[3], u[3];
        for (int k = 0; k < 3; k++) place[k] = a[k] + s * (b[k] - a[k]);
        for (int k = 0; k < 3; k++) u[k] = concave.tip[k] - place[k] + t * (b[k] - a[k]);
        const double size = sqrt(cml_vec3_dot(u, u));
        for (int k = 0; k < 3; k++) u[k] /= size;
        for (int k = 0; k < 2; k++) u[k] += angle * place[k] / 0.05;
        const double way = below ? -1 : 1;
        for (int k = 0; k < 3; k++) p[k] = place[k] - before * way * u[k];
        head_for(p, place, u);
        wrong += !ends_where_it_heads(&concave, p, u, below, true, -1);
    }
    cml_mesh_surface_free(concave.surface);
    assert_int_equal(wrong, 0);
}

/* A packet is mirrored near the tip: at distances from beyond the reach of rounding to where the tip's
 * mean normal holds. */
static void a_packet_is_mirrored_near_the_tip(void **state)
{
    (void)state;
    struct dice dice = dice_new(3);
    const struct concave concave = concave_make(3, 0.5, 0.5 / sqrt(2));
    int wrong = 0;
    for (int n = 0; n < repeats(200000); n++) {
        const double near = exp(dice_between(&dice, log(1e-16), log(1e-11)));
        double place[3], p[3], u[3], share[3];
        for (int i = 0; i < 3; i++) share[i] = 0.1 * dice_uniform(&dice);
        for (int k = 0; k < 3; k++) {
            place[k] = concave.tip[k] + dice_between(&dice, -1, 1) * near;
            p[k] = concave.tip[k];
            for (int i = 0; i < 3; i++) p[k] += share[i] * (concave.corner[i][k] - concave.tip[k]);
        }
        head_for(p, place, u);
        wrong += !ends_where_it_heads(&concave, p, u, false, true, -1);
    }
    cml_mesh_surface_free(concave.surface);
    assert_int_equal(wrong, 0);
}

/* Fast queries of packets that have crossed the plane near a corner of the border, on their way in. The
 * corner is so sharp that rounding around them reaches outside. */
static void a_packet_at_a_sharp_corner_enters_the_concavity(void **state)
{
    (void)state;
    struct dice dice = dice_new(4);
    const struct concave concave = concave_make(3, 0.5, 0.5 / sqrt(2));
    int missed = 0;
    for (int n = 0; n < repeats(100000); n++) {
        const double p[3] = {0.5 - dice_below(&dice, 3) * 2.98e-8, dice_between(&dice, -1, 1) * 1e-8, 0};
        const double *corner = concave.corner[0];
        double u[3] = {0, 0, 0};
        for (int i = 0; i < 3; i++) {
            const double *to = i < 2 ? concave.corner[1 + i] : concave.tip,
                         share = dice_between(&dice, 0.01, 1);
            for (int k = 0; k < 3; k++) u[k] += share * (to[k] - corner[k]);
        }
        const double size = sqrt(cml_vec3_dot(u, u));
        for (int k = 0; k < 3; k++) u[k] = (float)(u[k] / size);
        struct cml_mesh_crossing crossing;
        missed += !cml_mesh_surface_hit(concave.surface, p, u, true, INFINITY, CML_OUTER_PLANE, false, false,
                                        2.4e-7, &crossing);
    }
    cml_mesh_surface_free(concave.surface);
    assert_int_equal(missed, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_line_along_an_edge_ends_where_it_ends),
                                       cmocka_unit_test(a_line_that_grazes_an_edge_ends_where_it_ends),
                                       cmocka_unit_test(a_packet_is_mirrored_at_the_border),
                                       cmocka_unit_test(a_packet_is_mirrored_near_the_tip),
                                       cmocka_unit_test(a_packet_at_a_sharp_corner_enters_the_concavity)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
