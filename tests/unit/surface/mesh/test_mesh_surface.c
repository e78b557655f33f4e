/* Tests of the mesh query against every triangle in long double. SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "surface/mesh/sheet_mesh.h"
#include "lib/mesh_shapes.h"
#include "scene/scene.h"
#include "surface_hit.h"
#include "surface/mesh/mesh_surface.h"
#include "surface/tessellate.h"

static struct patch patch;

static struct cml_mesh_surface *searched(const struct patch *from, double x0, double y0,
                                         enum cml_mesh_search search)
{
    struct cml_mesh mesh = patch_mesh(from);
    struct cml_mesh_surface *surface = NULL;
    struct cml_error err = {CML_OK, ""};
    const cml_status status = cml_mesh_surface_create(&mesh, x0, y0, search, &surface, &err);
    assert_string_equal(err.text, "");
    assert_int_equal(status, CML_OK);
    return surface;
}

static struct cml_mesh_surface *surface_of(const struct patch *from, double x0, double y0)
{
    return searched(from, x0, y0, CML_SEARCH_AUTO);
}

static int query(const struct cml_mesh_surface *surface, const double p[3], const double u[3], int below,
                 int exclude, struct cml_mesh_crossing *crossing)
{
    return cml_mesh_surface_hit(surface, p, u, below, INFINITY, exclude, 0, 1, 1e-15, crossing);
}

/* ---- the oracle ---- */

static long double volume(const double u[3], const double p[3], const double a[3], const double b[3])
{
    long double v[3], w[3];
    for (int k = 0; k < 3; k++) {
        v[k] = (long double)a[k] - p[k];
        w[k] = (long double)b[k] - p[k];
    }
    return u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) +
           u[2] * (v[0] * w[1] - v[1] * w[0]);
}

struct first {
    long double t; /* distance of the crossing; INFINITY: none */
    int below;     /* true if the ray comes from below the surface */
};

/* Returns the first crossing of the patch or of the plane around it, in either direction. */
static struct first first_of_all(const double p[3], const double u[3], double dx, double dy)
{
    struct first first = {INFINITY, u[2] < 0};
    const long double t = u[2] != 0 ? -(long double)p[2] / u[2] : -1;
    if (t > 0 && (fabsl(p[0] + t * u[0] - dx) > 1 || fabsl(p[1] + t * u[1] - dy) > 1)) first.t = t;
    for (int i = 0; i < COUNT(patch.triangle); i++) {
        const double *a = patch.vertex[patch.triangle[i][0]], *b = patch.vertex[patch.triangle[i][1]],
                     *c = patch.vertex[patch.triangle[i][2]];
        const long double x = volume(u, p, b, c), y = volume(u, p, c, a), z = volume(u, p, a, b);
        if (!((x > 0 && y > 0 && z > 0) || (x < 0 && y < 0 && z < 0))) continue;
        const long double sum = x + y + z;
        long double s = 0;
        for (int k = 0; k < 3; k++) s += ((x * a[k] + y * b[k] + z * c[k]) / sum - p[k]) * u[k];
        if (!(s > 0) || s >= first.t) continue;
        first.t = s;
        first.below = sum > 0;
    }
    return first;
}

static void random_ray(struct dice *dice, double reach, double p[3], double u[3])
{
    for (int k = 0; k < 2; k++) p[k] = dice_between(dice, -reach, reach);
    p[2] = dice_between(dice, -0.3, 0.3) * reach;
    dice_direction(dice, u);
    if (dice_below(dice, 4) == 0) u[2] *= 0.05;
    const double k = 1 / sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    for (int i = 0; i < 3; i++) u[i] *= k;
}

static void compare_random_rays(double shear, double dx, double dy, double x0, double y0, double tolerance)
{
    struct dice dice = dice_new(61);
    patch_make(&patch, 7, 0.1, shear, dx, dy);
    struct cml_mesh_surface *surface = surface_of(&patch, x0, y0);
    long hits = 0;
    for (int n = 0; n < 3000; n++) {
        double p[3], u[3];
        random_ray(&dice, 1.2, p, u);
        p[0] += dx;
        p[1] += dy;
        const struct first first = first_of_all(p, u, dx, dy);
        const double q[3] = {p[0] - x0, p[1] - y0, p[2]};
        struct cml_mesh_crossing c = {.t = -1};
        struct cml_mesh_crossing fast = {.t = -1};
        const int hit = query(surface, q, u, first.below, -1, &c);
        assert_int_equal(hit, first.t < INFINITY);
        assert_int_equal(hit,
                         cml_mesh_surface_hit(surface, q, u, first.below, INFINITY, -1, 0, 0, 1e-15, &fast));
        assert_near("distance, fast", fast.t, c.t, tolerance);
        if (!hit) continue;
        hits++;
        assert_near("distance", c.t, (double)first.t, tolerance);
        for (int k = 0; k < 3; k++) assert_near("point", c.point[k], q[k] + c.t * u[k], tolerance);
        const double along = c.facet[0] * u[0] + c.facet[1] * u[1] + c.facet[2] * u[2];
        assert_true(first.below ? along > 0 : along < 0);
    }
    assert_true(hits > 1000);
    cml_mesh_surface_free(surface);
}

static void random_rays_meet_the_triangle_that_all_triangles_say(void **state)
{
    (void)state;
    compare_random_rays(0, 0, 0, 0, 0, 1e-13);
}

static void an_overhanging_mesh_is_met_first_things_first(void **state)
{
    (void)state;
    compare_random_rays(2, 0, 0, 0, 0, 1e-13);
}

static void a_mesh_ten_metres_away_is_met_as_well(void **state)
{
    (void)state;
    compare_random_rays(0, 1000, -700, 1000, -700, 1e-11);
    compare_random_rays(2, 1000, -700, 0, 0, 1e-11);
}

static void a_ray_from_ten_thousand_sizes_away_arrives(void **state)
{
    (void)state;
    struct dice dice = dice_new(62);
    patch_make(&patch, 8, 0.1, 0, 0, 0);
    struct cml_mesh_surface *surface = surface_of(&patch, 0, 0);
    for (int n = 0; n < 2000; n++) {
        double u[3], p[3];
        dice_direction(&dice, u);
        u[2] = -fabs(u[2]) - 0.05;
        const double k = 1 / sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        for (int i = 0; i < 3; i++) u[i] *= k;
        for (int i = 0; i < 3; i++) p[i] = dice_between(&dice, -1, 1) * (i < 2) - 1e4 * u[i];
        const struct first first = first_of_all(p, u, 0, 0);
        struct cml_mesh_crossing c;
        assert_true(query(surface, p, u, 1, -1, &c));
        assert_near("distance", c.t, (double)first.t, 1e-9);
    }
    cml_mesh_surface_free(surface);
}

/* ---- rays at vertices and edges ---- */

static double nudge(struct dice *dice, double x)
{
    const int way = dice_below(dice, 3);
    return way == 0 ? x : nextafter(x, way == 1 ? INFINITY : -INFINITY);
}

/* Draws a corner (weight 1) or a point of an edge, moved by one rounding in each coordinate or not at all. */
static void random_target(struct dice *dice, double target[3])
{
    const uint32_t *v = patch.triangle[dice_below(dice, COUNT(patch.triangle))];
    const double *a = patch.vertex[v[0]], *b = patch.vertex[v[1 + dice_below(dice, 2)]];
    static const double weights[] = {0, 1, 0.5, -1};
    double w = weights[dice_below(dice, COUNT(weights))];
    if (w < 0) w = dice_uniform(dice);
    for (int k = 0; k < 3; k++) target[k] = nudge(dice, a[k] + w * (b[k] - a[k]));
}

/* Checks that the ray is not on the other side of the sheet before t. */
static void assert_on_its_side(const double p[3], const double u[3], int below, double t)
{
    for (int k = 1; k < 64; k++) {
        const double s = t * k / 64, x = p[0] + s * u[0], y = p[1] + s * u[1], z = p[2] + s * u[2];
        const double inside = (below ? 1 : -1) * (z - patch_depth(&patch, x, y));
        if (!(inside > -1e-12)) fail_msg("went through at (%.17g %.17g %.17g) by %g", x, y, z, -inside);
    }
}

static void no_ray_at_a_vertex_or_an_edge_slips_through(void **state)
{
    (void)state;
    struct dice dice = dice_new(63);
    patch_make(&patch, 9, 0.1, 0, 0, 0);
    struct cml_mesh_surface *surface = surface_of(&patch, 0, 0);
    for (int n = 0; n < repeats(100000); n++) {
        double p[3], u[3], target[3];
        const int below = dice_below(&dice, 2);
        random_target(&dice, target);
        for (int k = 0; k < 2; k++)
            p[k] = dice_below(&dice, 3) ? target[k] + dice_between(&dice, -1.5, 1.5) : target[k];
        p[2] = below ? 1 : -1;
        double distance = 0;
        for (int k = 0; k < 3; k++) distance = hypot(distance, target[k] - p[k]);
        for (int k = 0; k < 3; k++) u[k] = (target[k] - p[k]) / distance;
        struct cml_mesh_crossing c;
        assert_true(query(surface, p, u, below, -1, &c));
        assert_near("height", c.point[2], patch_depth(&patch, c.point[0], c.point[1]), 1e-11);
        assert_on_its_side(p, u, below, c.t);
        const double along = c.facet[0] * u[0] + c.facet[1] * u[1] + c.facet[2] * u[2];
        if (!(below ? along > 0 : along < 0)) fail_msg("facet turned: %g", along);
    }
    cml_mesh_surface_free(surface);
}

/* True if the exact query meets the surface at t, with this ray or with one that differs by a rounding of
 * float. */
static bool is_met_at(const struct cml_mesh_surface *surface, const double p[3], const double u[3], int below,
                      double t)
{
    for (int offset = 0; offset < 9; offset++) {
        const double q[3] = {p[0] + 3e-7 * (offset % 3 - 1), p[1] + 3e-7 * (offset / 3 - 1), p[2]};
        struct cml_mesh_crossing c;
        if (query(surface, q, u, below, -1, &c) && fabs(c.t - t) < 1e-4) return true;
    }
    return false;
}

/* Facets in single precision miss some crossings or give the neighbouring facet. A crossing that is not
 * clear must be decided in double. */
static void floats_are_not_believed_at_vertices_and_edges(void **state)
{
    (void)state;
    struct dice dice = dice_new(64);
    patch_make(&patch, 9, 0.1, 0, 0, 0);
    long wrong = 0;
    struct cml_mesh_surface *surface = searched(&patch, 0, 0, CML_SEARCH_TREE);
    assert_false(cml_mesh_surface_is_sheet(surface));
    for (int n = 0; n < repeats(100000); n++) {
        double p[3], u[3], target[3], distance = 0;
        const int below = dice_below(&dice, 2);
        random_target(&dice, target);
        for (int k = 0; k < 2; k++)
            p[k] = (float)(dice_below(&dice, 3) ? target[k] + dice_between(&dice, -1.5, 1.5) : target[k]);
        p[2] = below ? 1 : -1;
        for (int k = 0; k < 3; k++) distance = hypot(distance, target[k] - p[k]);
        for (int k = 0; k < 3; k++) u[k] = (float)((target[k] - p[k]) / distance);
        struct cml_mesh_crossing c = {0};
        wrong += !cml_mesh_surface_hit(surface, p, u, below, INFINITY, -1, 0, 0, 1e-7, &c) ||
                 !is_met_at(surface, p, u, below, c.t);
    }
    assert_int_equal(wrong, 0);
    cml_mesh_surface_free(surface);
}

/* Compares paths of many lengths, most of them about as long as the safe stretch, with the stretch's
 * answer. Returns the number of paths. */
static int compare_with_stretch(struct dice *dice, const struct cml_mesh_surface *surface, const double p[3],
                                const double u[3], int below, int on, const struct cml_mesh_stretch *stretch)
{
    const double end = stretch->from < INFINITY ? stretch->from : 3;
    struct cml_mesh_crossing endless, c;
    int compared = 0;
    cml_mesh_surface_hit(surface, p, u, below, INFINITY, on, 0, 0, 1e-7, &endless);
    for (int n = 0; n < 40; n++) {
        const double near = exp(dice_between(dice, -16, 0)), far = stretch->most < end ? stretch->most : end;
        const double length[4] = {stretch->least * (1 + near), far * (1 - near), end * (1 + near),
                                  dice_between(dice, 0, 2 * end)};
        const double t_max = (float)length[n % 4];
        const int hits = t_max > stretch->from;
        if (!(t_max > stretch->least && (t_max < stretch->most || hits))) continue;
        compared++;
        assert_int_equal(cml_mesh_surface_hit(surface, p, u, below, t_max, on, 0, 0, 1e-7, &c), hits);
        if (hits) assert_memory_equal(&c, &endless, offsetof(struct cml_mesh_crossing, ends_near_facet));
        if (!hits) assert_int_equal(c.ends_near_facet, 0);
    }
    return compared;
}

/* A stretch is asked from edges, vertices and facets near them, towards others and elsewhere. */
static void a_stretch_says_what_its_paths_meet(void **state)
{
    (void)state;
    static const double down[3] = {0, 0, 1};
    struct dice dice = dice_new(70);
    patch_make(&patch, 9, 0.1, 0.9, 0, 0);
    struct cml_mesh_surface *surface = searched(&patch, 0, 0, CML_SEARCH_TREE);
    int known = 0, to_hits = 0, compared = 0;
    for (int n = 0; n < 8000; n++) {
        double p[3], u[3], target[3];
        struct cml_mesh_crossing at;
        struct cml_mesh_stretch stretch;
        const int below = dice_below(&dice, 2);
        random_target(&dice, p);
        random_target(&dice, target);
        p[2] = -1;
        if (!query(surface, p, down, 0, -1, &at) || at.primitive == CML_OUTER_PLANE) continue;
        for (int k = 0; k < 3; k++) p[k] = (float)at.point[k];
        dice_direction(&dice, u);
        if (n % 2)
            for (int k = 0; k < 3; k++) u[k] = target[k] - p[k];
        const double size = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        for (int k = 0; k < 3; k++) u[k] = (float)(u[k] / size);
        if (!cml_mesh_surface_stretch(surface, p, u, below, at.primitive, 0, 1e-7, &stretch)) continue;
        known++;
        to_hits += stretch.from < INFINITY;
        compared += compare_with_stretch(&dice, surface, p, u, below, at.primitive, &stretch);
    }
    printf("%d stretches, %d to hits, %d paths\n", known, to_hits, compared);
    assert_true(known > 1000 && to_hits > 200);
    assert_true(compared > 10 * known);
    cml_mesh_surface_free(surface);
}

/* Rays that start in the line of an edge meet two facets in their own planes. */
static void a_ray_along_an_edge_stays_on_its_side(void **state)
{
    (void)state;
    struct dice dice = dice_new(68);
    patch_make(&patch, 13, 0.1, 0, 0, 0);
    struct cml_mesh_surface *surface = surface_of(&patch, 0, 0);
    for (int n = 0; n < repeats(100000); n++) {
        const uint32_t *v = patch.triangle[dice_below(&dice, COUNT(patch.triangle))];
        const double *a = patch.vertex[v[0]], *b = patch.vertex[v[1 + dice_below(&dice, 2)]];
        const double w = dice_between(&dice, -4, 0);
        double p[3], u[3], length = 0;
        for (int k = 0; k < 3; k++) length = hypot(length, b[k] - a[k]);
        for (int k = 0; k < 3; k++) u[k] = nudge(&dice, (b[k] - a[k]) / length);
        for (int k = 0; k < 3; k++) p[k] = nudge(&dice, a[k] + w * (b[k] - a[k]));
        const double inside = p[2] - patch_depth(&patch, p[0], p[1]);
        if (fabs(inside) < 1e-9) continue;
        struct cml_mesh_crossing c = {.t = 3};
        query(surface, p, u, inside > 0, -1, &c);
        assert_on_its_side(p, u, inside > 0, c.t);
    }
    cml_mesh_surface_free(surface);
}

static void a_packet_that_rounding_put_beyond_the_surface_crosses_at_once(void **state)
{
    (void)state;
    struct dice dice = dice_new(69);
    patch_make(&patch, 14, 0.1, 0, 0, 0);
    struct cml_mesh_surface *surface = surface_of(&patch, 0, 0);
    for (int n = 0; n < repeats(10000); n++) {
        const double x = dice_between(&dice, -1.2, 1.2), y = dice_between(&dice, -1.2, 1.2);
        const int below = dice_below(&dice, 2);
        const double beyond = (below ? -1 : 1) * 5e-8, u[3] = {0, 0, below ? -1 : 1};
        const double p[3] = {x, y, patch_depth(&patch, x, y) + beyond};
        struct cml_mesh_crossing c;
        assert_true(cml_mesh_surface_hit(surface, p, u, below, INFINITY, -1, 0, 1, 1e-7, &c));
        assert_true(c.t == 0);
        assert_false(cml_mesh_surface_hit(surface, p, u, below, INFINITY, -1, 0, 1, 1e-8, &c));
    }
    cml_mesh_surface_free(surface);
}

static void the_seam_of_the_outer_plane_has_no_gap(void **state)
{
    (void)state;
    struct dice dice = dice_new(64);
    patch_make(&patch, 10, 0.01, 0, 0, 0);
    struct cml_mesh_surface *surface = surface_of(&patch, 0, 0);
    for (int n = 0; n < repeats(100000); n++) {
        const int below = dice_below(&dice, 2), side = dice_below(&dice, 4);
        const double along =
            dice_below(&dice, 2) ? patch_coordinate(dice_below(&dice, GRID + 1)) : dice_between(&dice, -1, 1);
        double target[3] = {side & 1 ? along : side - 1, side & 1 ? side - 2 : along, 0}, p[3], u[3];
        for (int k = 0; k < 2; k++) target[k] = nudge(&dice, target[k]);
        for (int k = 0; k < 2; k++)
            p[k] = target[k] + (dice_below(&dice, 3) ? dice_between(&dice, -1, 1) : 0);
        p[2] = below ? 1 : -1;
        double distance = 0;
        for (int k = 0; k < 3; k++) distance = hypot(distance, target[k] - p[k]);
        for (int k = 0; k < 3; k++) u[k] = (target[k] - p[k]) / distance;
        struct cml_mesh_crossing c;
        assert_true(query(surface, p, u, below, -1, &c));
        assert_on_its_side(p, u, below, c.t);
    }
    cml_mesh_surface_free(surface);
}

/* ---- contents of a hit ---- */

static void the_primitive_stood_on_is_not_met_again(void **state)
{
    (void)state;
    struct dice dice = dice_new(65);
    patch_make(&patch, 11, 0.1, 0, 0, 0);
    struct cml_mesh_surface *surface = surface_of(&patch, 0, 0);
    for (int n = 0; n < repeats(50000); n++) {
        const double p[3] = {dice_between(&dice, -1.1, 1.1), dice_between(&dice, -1.1, 1.1), -1};
        const double down[3] = {0, 0, 1};
        struct cml_mesh_crossing c, again;
        assert_true(query(surface, p, down, 0, -1, &c));
        for (int below = 0; below < 2; below++) {
            if (query(surface, c.point, down, below, c.primitive, &again))
                assert_true(again.primitive != c.primitive && again.t > 1e-12);
            const double up[3] = {0, 0, -1};
            assert_false(query(surface, c.point, up, below, c.primitive, &again));
        }
    }
    cml_mesh_surface_free(surface);
}

static void a_vertex_has_the_mean_normal_weighted_by_angle(void **state)
{
    (void)state;
    struct dice dice = dice_new(66);
    patch_make(&patch, 12, 0.1, 0, 0, 0);
    struct cml_mesh mesh = patch_mesh(&patch);
    struct cml_mesh_surface *surface = surface_of(&patch, 0, 0);
    for (int n = 0; n < 1000; n++) {
        const int i = 1 + dice_below(&dice, GRID - 1), j = 1 + dice_below(&dice, GRID - 1);
        const double *v = patch.vertex[i * (GRID + 1) + j], p[3] = {v[0], v[1], -1}, u[3] = {0, 0, 1};
        struct cml_mesh_crossing c;
        assert_true(query(surface, p, u, 0, -1, &c));
        size_t k = 0;
        while (memcmp(mesh.vertex[k], v, sizeof mesh.vertex[k]) != 0) k++;
        for (int a = 0; a < 3; a++) assert_near("normal", c.normal[a], mesh.vertex_normal[k][a], 1e-12);
        assert_near("distance", c.t, v[2] + 1, 1e-15);
    }
    cml_mesh_surface_free(surface);
    cml_mesh_clear(&mesh);
}

static void a_tessellated_hill_has_the_normals_of_its_cones(void **state)
{
    (void)state;
    double r[] = {0, 0.5, 1, 2}, h[] = {1, 0.75, 0, 0.25};
    double z[] = {-1, -0.75, 0, -0.25}, slope[] = {0.5, 1.5, -0.25, 0};
    const struct cml_radial radial = {4, r, h};
    const struct cml_tessellation options = {1e-3, CML_NORMALS_ANALYTIC, false};
    int start[4];
    const double parts_per_cm = cml_ring_starts(r, 4, start);
    const struct cml_rings rings = {r, z, slope, start, parts_per_cm, 4};
    struct cml_mesh mesh;
    struct cml_mesh_surface *surface;
    struct cml_error err;
    assert_int_equal(cml_tessellate(&radial, &options, NULL, &mesh, &err), CML_OK);
    assert_int_equal(cml_mesh_surface_create(&mesh, 0.3, 0.1, CML_SEARCH_AUTO, &surface, &err), CML_OK);
    struct dice dice = dice_new(67);
    for (int n = 0; n < 8000; n++) {
        const double x = dice_between(&dice, -2, 2), y = dice_between(&dice, -2, 2), s = hypot(x, y);
        const int ring = cml_ring_of(rings, s);
        if (ring == 3 || fabs(s - r[ring]) < 0.01 || fabs(s - r[ring + 1]) < 0.01) continue;
        const double p[3] = {x - 0.3, y - 0.1, -3}, u[3] = {0, 0, 1};
        struct cml_mesh_crossing c;
        assert_true(query(surface, p, u, 0, -1, &c));
        const struct cml_vec up = cml_cone_normal(rings, ring, x, y);
        assert_near("nx", c.normal[0], up.x, 1e-9);
        assert_near("ny", c.normal[1], up.y, 1e-9);
        assert_near("nz", c.normal[2], up.z, 1e-9);
        assert_near("height", c.point[2], z[ring] + slope[ring] * (s - r[ring]), 6e-3);
    }
    const double tip[3] = {-0.3, -0.1, -3}, u[3] = {0, 0, 1};
    struct cml_mesh_crossing c;
    assert_true(query(surface, tip, u, 0, -1, &c));
    assert_near("tip", c.t, 2, 1e-15);
    assert_near("tip normal", c.normal[2], -1, 1e-9);
    cml_mesh_surface_free(surface);
}

/* Vertices are moved sideways by up to a fifth of a cell. So cells need lists of facets, and
 * may then take at most 1.5 times the memory of a tree. */
static void a_sheet_takes_no_more_memory_for_cells_than_half_again_a_tree(void **state)
{
    (void)state;
    patch_make(&patch, 67, 0.02, 0, 0, 0);
    patch_move(&patch, 68, 0.2);
    struct cml_mesh_surface *walked = surface_of(&patch, 0, 0),
                            *searched_for = searched(&patch, 0, 0, CML_SEARCH_TREE);
    const double triangles = COUNT(patch.triangle), cells = cml_mesh_surface_bytes(walked),
                 tree = cml_mesh_surface_bytes(searched_for);
    assert_true(cml_mesh_surface_is_sheet(walked));
    assert_false(cml_mesh_surface_is_sheet(searched_for));
    print_message("%.0f bytes per triangle, with a tree %.0f\n", cells / triangles, tree / triangles);
    assert_true(cells > 44 * triangles); /* corners and planes alone need 44 bytes per triangle */
    assert_true(cells < 1.5 * tree);
    cml_mesh_surface_free(walked);
    cml_mesh_surface_free(searched_for);
}

/* The memory of cells includes at least the facets, and at most lists, depths and a pyramid besides. */
static void cells_count_as_memory(void **state)
{
    (void)state;
    patch_make(&patch, 69, 0.02, 0, 0, 0);
    struct cml_mesh mesh = patch_mesh(&patch);
    struct cml_centred_mesh centred;
    struct cml_grid_mesh grid;
    struct cml_error err = {CML_OK, ""};
    assert_int_equal(cml_centred_mesh_create(&mesh, 0, 0, &centred, &err), CML_OK);
    assert_int_equal(cml_sheet_mesh_find(&centred, &grid, &err), CML_OK);
    assert_true(cml_grid_mesh_bytes(&grid) > 2 * 64.0 * GRID * GRID);
    assert_true(cml_grid_mesh_bytes(&grid) < 2 * 100.0 * GRID * GRID);
    cml_grid_mesh_clear(&grid);
    assert_true(cml_grid_mesh_bytes(&grid) == 0);
    cml_centred_mesh_clear(&centred);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_rays_meet_the_triangle_that_all_triangles_say),
        cmocka_unit_test(an_overhanging_mesh_is_met_first_things_first),
        cmocka_unit_test(a_mesh_ten_metres_away_is_met_as_well),
        cmocka_unit_test(a_ray_from_ten_thousand_sizes_away_arrives),
        cmocka_unit_test(no_ray_at_a_vertex_or_an_edge_slips_through),
        cmocka_unit_test(floats_are_not_believed_at_vertices_and_edges),
        cmocka_unit_test(a_stretch_says_what_its_paths_meet),
        cmocka_unit_test(a_ray_along_an_edge_stays_on_its_side),
        cmocka_unit_test(a_packet_that_rounding_put_beyond_the_surface_crosses_at_once),
        cmocka_unit_test(the_seam_of_the_outer_plane_has_no_gap),
        cmocka_unit_test(the_primitive_stood_on_is_not_met_again),
        cmocka_unit_test(a_vertex_has_the_mean_normal_weighted_by_angle),
        cmocka_unit_test(a_tessellated_hill_has_the_normals_of_its_cones),
        cmocka_unit_test(a_sheet_takes_no_more_memory_for_cells_than_half_again_a_tree),
        cmocka_unit_test(cells_count_as_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
