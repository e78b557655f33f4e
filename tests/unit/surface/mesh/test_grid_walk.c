/* Tests of rays that walk from cell to cell of a sheet (a mesh over an even grid of cells, its vertices moved
 * or not), against the exact query of the same mesh. SPDX-License-Identifier: MIT */
#define CML_DOUBLE
#include "scene/heightmap/heightmap.h"
#include "lib/mesh_shapes.h"
#include "scene/scene.h"
#include "surface/mesh/mesh_surface.h"
#include "surface/mesh/grid_walk.h"
#include "surface/mesh/sheet_mesh.h"
#include "surface/tessellate.h"

static struct patch patch;

/* A mesh in two forms: as the program queries it, and with its grid accessible. */
struct subject {
    struct cml_mesh_surface *surface;
    struct cml_centred_mesh centred;
    struct cml_grid_mesh grid;
    double middle[3], half[3];
};

static struct subject subject_of(struct cml_mesh *mesh)
{
    struct subject s;
    struct cml_mesh copy;
    struct cml_error err = {CML_OK, ""};
    assert_int_equal(cml_mesh_copy(mesh, &copy, &err), CML_OK);
    for (int k = 0; k < 3; k++) {
        s.middle[k] = 0.5 * (mesh->lower[k] + mesh->upper[k]);
        s.half[k] = 0.5 * (mesh->upper[k] - mesh->lower[k]);
    }
    assert_int_equal(cml_mesh_surface_create(mesh, 0, 0, CML_SEARCH_AUTO, &s.surface, &err), CML_OK);
    assert_int_equal(cml_centred_mesh_create(&copy, 0, 0, &s.centred, &err), CML_OK);
    assert_int_equal(cml_sheet_mesh_find(&s.centred, &s.grid, &err), CML_OK);
    assert_true(cml_mesh_surface_is_sheet(s.surface) == (s.grid.levels > 0));
    return s;
}

static void subject_free(struct subject *s)
{
    cml_mesh_surface_free(s->surface);
    cml_grid_mesh_clear(&s->grid);
    cml_centred_mesh_clear(&s->centred);
}

/* Returns a patch whose vertices are moved by up to `jitter` cells along x and y. */
static struct subject rough_patch(uint32_t seed, double height, double jitter)
{
    patch_make(&patch, seed, height, 0, 0, 0);
    struct dice dice = dice_new(seed + 1);
    for (int i = 0; i < COUNT(patch.vertex); i++)
        for (int k = 0; k < 2; k++) patch.vertex[i][k] += dice_between(&dice, -jitter, jitter) * 2 / GRID;
    struct cml_mesh mesh = patch_mesh(&patch);
    mesh.normals = CML_NORMALS_VERTEX;
    return subject_of(&mesh);
}

/* Returns a mesh of a heightmap with a rough half and a smooth half, whose facets are merged, and with a
 * skirt. */
static struct subject scan(double tolerance)
{
    struct cml_heightmap map;
    struct cml_heightmap_notes notes;
    struct cml_mesh mesh;
    struct cml_error err = {CML_OK, ""};
    struct dice dice = dice_new(81);
    assert_int_equal(cml_heightmap_allocate("scan", 49, 33, &map, &err), CML_OK);
    map.dx = map.dy = 0.0625;
    cml_heightmap_centre(&map);
    for (int i = 0; i < map.nx * map.ny; i++) {
        const int x = i % map.nx, y = i / map.nx;
        map.h[i] = 0.05 * sin(0.2 * x) * cos(0.15 * y) + (x > 24 ? dice_between(&dice, -0.02, 0.02) : 0);
    }
    assert_int_equal(cml_heightmap_mesh(&map, tolerance, CML_NORMALS_FACET, NULL, &mesh, &notes, &err),
                     CML_OK);
    if (tolerance > 0) assert_true(notes.triangles < 2 * notes.cells);
    cml_heightmap_clear(&map);
    return subject_of(&mesh);
}

/* ---- rays ---- */

struct ray {
    double p[3], u[3], t_max, slack;
    int below, exclude, straight;
};

static void normalise(double u[3])
{
    const double k = 1 / sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    for (int i = 0; i < 3; i++) u[i] *= k;
}

static void random_ray(const struct subject *s, struct dice *dice, struct ray *ray)
{
    for (int k = 0; k < 3; k++) ray->p[k] = s->middle[k] + 1.1 * s->half[k] * dice_between(dice, -1, 1);
    dice_direction(dice, ray->u);
    if (dice_below(dice, 3) == 0) ray->u[2] *= 0.05;
    normalise(ray->u);
    ray->t_max = dice_below(dice, 4) ? exp(dice_between(dice, -6, 1)) * s->half[0] : INFINITY;
    ray->slack = dice_below(dice, 2) ? 1e-15 : 1e-7;
    ray->below = dice_below(dice, 2);
    ray->exclude = -1;
    ray->straight = dice_below(dice, 2);
}

static double nudge(struct dice *dice, double x)
{
    const int way = dice_below(dice, 3);
    return way == 0 ? x : nextafter(x, way == 1 ? INFINITY : -INFINITY);
}

/* Draws a vertex or a point of an edge, in the boundary's frame. */
static void random_target(const struct subject *s, struct dice *dice, double target[3])
{
    const struct cml_mesh *mesh = &s->centred.mesh;
    const uint32_t *v = mesh->triangle[dice_below(dice, (int)mesh->num_triangles)];
    const double *a = mesh->vertex[v[0]], *b = mesh->vertex[v[1 + dice_below(dice, 2)]];
    static const double weights[] = {0, 1, 0.5, -1};
    double w = weights[dice_below(dice, COUNT(weights))];
    if (w < 0) w = dice_uniform(dice);
    for (int k = 0; k < 3; k++) target[k] = nudge(dice, s->middle[k] + a[k] + w * (b[k] - a[k]));
}

/* Draws a ray from a random place to a vertex or edge; some rays go straight down. */
static void ray_at_an_edge(const struct subject *s, struct dice *dice, struct ray *ray)
{
    double target[3];
    random_ray(s, dice, ray);
    random_target(s, dice, target);
    for (int k = 0; k < 2; k++)
        if (dice_below(dice, 4) == 0) ray->p[k] = target[k];
    for (int k = 0; k < 3; k++) ray->u[k] = target[k] - ray->p[k];
    normalise(ray->u);
    ray->below = ray->u[2] < 0;
}

/* Draws a ray between points of two edges: in the surface, or close to it. */
static void ray_along_edges(const struct subject *s, struct dice *dice, struct ray *ray)
{
    double target[3];
    random_ray(s, dice, ray);
    random_target(s, dice, target);
    random_target(s, dice, ray->p);
    for (int k = 0; k < 3; k++) ray->u[k] = target[k] - ray->p[k];
    if (fabs(ray->u[0]) + fabs(ray->u[1]) < 1e-9) ray->u[0] = 1;
    if (dice_below(dice, 2))
        for (int k = 0; k < 3; k++) ray->p[k] -= dice_uniform(dice) * ray->u[k];
    normalise(ray->u);
}

/* Draws a ray from a facet, as of a packet that was turned there or went straight through. */
static void ray_from_a_facet(const struct subject *s, struct dice *dice, struct ray *ray)
{
    struct cml_mesh_crossing c;
    random_ray(s, dice, ray);
    if (!cml_mesh_surface_hit(s->surface, ray->p, ray->u, ray->below, INFINITY, -1, 0, 1, 1e-15, &c)) return;
    for (int k = 0; k < 3; k++) ray->p[k] = (float)c.point[k];
    ray->slack = 1e-7;
    ray->exclude = c.primitive;
    if (ray->straight)
        ray->below = !ray->below;
    else
        dice_direction(dice, ray->u);
}

/* Draws a ray that starts beyond a facet by the largest allowed rounding: the crossing just counts, or
 * just does not. */
static void ray_beyond_a_facet(const struct subject *s, struct dice *dice, struct ray *ray)
{
    struct cml_mesh_crossing c;
    random_ray(s, dice, ray);
    if (!cml_mesh_surface_hit(s->surface, ray->p, ray->u, ray->below, INFINITY, -1, 0, 1, 1e-15, &c)) return;
    for (int k = 0; k < 3; k++) ray->p[k] = nudge(dice, c.point[k] + ray->slack * ray->u[k]);
}

typedef void make_ray(const struct subject *s, struct dice *dice, struct ray *ray);

/* ---- comparison ---- */

static int hit(const struct subject *s, const struct ray *ray, int exact, struct cml_mesh_crossing *c)
{
    return cml_mesh_surface_hit(s->surface, ray->p, ray->u, ray->below, ray->t_max, ray->exclude,
                                ray->straight, exact, ray->slack, c);
}

static void begin(const struct subject *s, const struct ray *ray, struct cml_mesh_query *q)
{
    cml_query_begin(q, &s->centred, ray->p, ray->u, ray->below, ray->t_max, ray->exclude, ray->straight,
                    ray->slack);
}

/* Expects the same crossing, beyond rounding: the same facet, or one that meets the ray at the same place. */
static void expect_same(const struct ray *ray, int found, const struct cml_mesh_crossing *walked, int met,
                        const struct cml_mesh_crossing *exact)
{
    if (found != met || (found && !(fabs(walked->t - exact->t) <= 1e-11)))
        fail_msg("from (%.17g %.17g %.17g) along (%.17g %.17g %.17g): %d at %.17g, exactly %.17g", ray->p[0],
                 ray->p[1], ray->p[2], ray->u[0], ray->u[1], ray->u[2], found, walked->t, exact->t);
    if (!found || walked->primitive != exact->primitive) return;
    for (int k = 0; k < 3; k++) assert_near("normal", walked->normal[k], exact->normal[k], 1e-6);
}

/* Number of rays that the walk decides by itself, and of those with exactly the same facet. */
struct share {
    long rays, decided, found, same;
};

/* Compares one ray. A packet that stands near an edge never walks; the distance that counts as near
 * depends on its precision. */
static void compare_ray(const struct subject *s, const struct ray *ray, struct share *share)
{
    struct cml_mesh_crossing walked, exact;
    struct cml_mesh_query q;
    const int found = hit(s, ray, 0, &walked), met = hit(s, ray, 1, &exact);
    begin(s, ray, &q);
    if (!q.starts_on_edge) expect_same(ray, found, &walked, met, &exact);
    share->rays++;
    share->decided += cml_grid_walk(&s->grid, &q);
    share->found += found && met;
    share->same += found && met && walked.primitive == exact.primitive;
}

static struct share compare(const struct subject *s, make_ray *make, uint32_t seed, int rays)
{
    struct dice dice = dice_new(seed);
    struct share share = {0};
    struct ray ray;
    for (int n = 0; n < repeats(rays); n++) {
        make(s, &dice, &ray);
        compare_ray(s, &ray, &share);
    }
    return share;
}

static void compare_all(struct subject *s, double least_decided)
{
    assert_true(s->grid.levels > 0);
    struct share share = compare(s, random_ray, 82, 150000);
    print_message("random: %ld of %ld decided, %ld found\n", share.decided, share.rays, share.found);
    assert_true((double)share.decided > least_decided * (double)share.rays);
    assert_true(share.same == share.found);
    share = compare(s, ray_from_a_facet, 83, 100000);
    print_message("from facets: %ld of %ld decided, %ld found\n", share.decided, share.rays, share.found);
    share = compare(s, ray_beyond_a_facet, 86, 50000);
    print_message("beyond facets: %ld of %ld decided, %ld found\n", share.decided, share.rays, share.found);
    share = compare(s, ray_at_an_edge, 84, 100000);
    print_message("at edges: %ld of %ld decided, %ld found\n", share.decided, share.rays, share.found);
    share = compare(s, ray_along_edges, 85, 50000);
    print_message("along edges: %ld of %ld decided, %ld found\n", share.decided, share.rays, share.found);
    subject_free(s);
}

static void an_exact_grid_is_walked_as_exactly_as_searched(void **state)
{
    (void)state;
    struct subject gentle = rough_patch(71, 0.01, 0), steep = rough_patch(72, 0.2, 0);
    compare_all(&gentle, 0.8);
    compare_all(&steep, 0.8);
}

static void a_grid_rounded_in_its_file_is_walked_as_well(void **state)
{
    (void)state;
    struct subject s = rough_patch(73, 0.05, 1e-4);
    compare_all(&s, 0.8);
}

static void a_scan_is_walked_merged_or_not(void **state)
{
    (void)state;
    struct subject merged = scan(0.05), all = scan(0);
    compare_all(&merged, 0.5);
    compare_all(&all, 0.5);
}

/* Returns a patch that lacks a quarter, so the plane around it lies inside the grid's rectangle. */
static struct subject without_a_quarter(void)
{
    struct cml_error err = {CML_OK, ""};
    struct cml_mesh mesh = patch_mesh(&patch);
    const int half = GRID / 2;
    size_t left = 0;
    for (int i = 0; i <= half; i++)
        for (int j = 0; j <= half; j++) mesh.vertex[i * (GRID + 1) + j][2] = 0;
    for (int cell = 0; cell < GRID * GRID; cell++) {
        if (cell / GRID < half && cell % GRID < half) continue;
        memmove(mesh.triangle[left], mesh.triangle[2 * cell], 2 * sizeof *mesh.triangle);
        left += 2;
    }
    mesh.num_triangles = left;
    free(mesh.border);
    free(mesh.vertex_normal);
    mesh.border = NULL;
    mesh.vertex_normal = NULL;
    assert_int_equal(cml_mesh_prepare(&mesh, NULL, NULL, &err), CML_OK);
    return subject_of(&mesh);
}

static void a_grid_with_a_gap_lets_the_plane_through(void **state)
{
    (void)state;
    patch_make(&patch, 76, 0.05, 0, 0, 0);
    struct subject s = without_a_quarter();
    compare_all(&s, 0.5);
}

static void a_sheet_is_walked_as_exactly_as_searched(void **state)
{
    (void)state;
    struct subject gentle = rough_patch(77, 0.01, 0.2), steep = rough_patch(78, 0.2, 0.2);
    compare_all(&gentle, 0.8);
    compare_all(&steep, 0.8);
}

static void a_sheet_with_a_gap_lets_the_plane_through(void **state)
{
    (void)state;
    patch_make(&patch, 79, 0.05, 0, 0, 0);
    patch_move(&patch, 80, 0.25);
    patch_spike(&patch, GRID / 4, 3 * GRID / 4, 0.3);
    struct subject s = without_a_quarter();
    compare_all(&s, 0.5);
}

/* Returns a patch whose vertices are moved to x -> sign(x) |x|^power, and whose y is multiplied by
 * `stretch`. */
static struct subject warped_patch(double power, double stretch)
{
    patch_make(&patch, 74, 0.01, 0, 0, 0);
    for (int i = 0; i < COUNT(patch.vertex); i++) {
        double *v = patch.vertex[i];
        v[0] = copysign(pow(fabs(v[0]), power), v[0]);
        v[1] *= stretch;
    }
    struct cml_mesh mesh = patch_mesh(&patch);
    return subject_of(&mesh);
}

/* Meshes that do not suit cells are left to Embree: facets above one another, facets so thin that most
 * cells would hold many, facets of very different sizes. */
static void what_cells_do_not_suit_is_left_to_embree(void **state)
{
    (void)state;
    patch_make(&patch, 74, 0.1, 2, 0, 0);
    struct cml_mesh mesh = patch_mesh(&patch);
    struct subject overhang = subject_of(&mesh), thin = warped_patch(1.5, 1e4), uneven = warped_patch(12, 1);
    assert_int_equal(overhang.grid.levels, 0);
    assert_int_equal(thin.grid.levels, 0);
    assert_int_equal(uneven.grid.levels, 0);
    subject_free(&overhang);
    subject_free(&thin);
    subject_free(&uneven);
    struct subject bent = warped_patch(1.5, 1);
    assert_true(bent.grid.levels > 0);
    compare_all(&bent, 0.5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_exact_grid_is_walked_as_exactly_as_searched),
        cmocka_unit_test(a_grid_rounded_in_its_file_is_walked_as_well),
        cmocka_unit_test(a_scan_is_walked_merged_or_not),
        cmocka_unit_test(a_grid_with_a_gap_lets_the_plane_through),
        cmocka_unit_test(a_sheet_is_walked_as_exactly_as_searched),
        cmocka_unit_test(a_sheet_with_a_gap_lets_the_plane_through),
        cmocka_unit_test(what_cells_do_not_suit_is_left_to_embree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
