/* Tests that bounds are conservative: a step that they call free or safe crosses nothing, by the exact
 * query. Rings are met at the same place if only the remaining part of a step is searched. The fast mesh
 * query gives the result of the exact query.
 * SPDX-License-Identifier: MIT */
#include "flight.h"
#include "lib/mesh_shapes.h"

#include "engine/world_parts.h"
#include "walk.h"

struct bench {
    struct cml_scene_list list;
    struct cml_surface_set surfaces;
    struct cml_owned_world scalar;
    struct cml_stream stream;
    uint64_t draws;
};

static void bench_open(const char *line, enum cml_surface_kind kind, struct bench *bench)
{
    struct cml_error err;
    char text[4096];
    const struct cml_surface_options surface = {.force = kind,
                                                .tessellation = {1e-3, CML_NORMALS_ANALYTIC, false}};
    const struct cml_engine_options options = {.seed = 1, .reentry = true};
    *bench = (struct bench){.stream = {.key = {1, 2, 3, 4}}};
    snprintf(text, sizeof text, "1.0\n1\nbench A\n1\n1 1\n1 1 1\n1\n1\n%s\n1.4 1 10 0 2\n1\n", line);
    read_scenes(text, &bench->list);
    require_ok(cml_surfaces_create(&bench->list.scenes[0], &surface, &bench->surfaces, &err), &err);
    require_ok(
        cml_owned_world_create(&bench->list.scenes[0], &bench->surfaces, &options, &bench->scalar, &err),
        &err);
}

static void bench_close(struct bench *bench)
{
    cml_owned_world_free(&bench->scalar);
    cml_surfaces_free(&bench->surfaces);
    cml_scene_list_clear(&bench->list);
}

/* Returns a random number, uniform in (-1, 1). */
static double dice(struct bench *bench)
{
    const cml_u32 word = cml_draw(bench->stream, bench->draws++, CML_PURPOSE_LAUNCH, 0).w[0];
    return (double)word / 2147483648.0 - 1;
}

/* Makes a step near the surface. It starts anywhere around the surface; its length is from far below a cell
 * to several cm. */
static void random_step(struct bench *bench, double reach, double height, struct cml_vec *p,
                        struct cml_vec *u, real *length)
{
    const double ux = dice(bench), uy = dice(bench), uz = dice(bench) * (dice(bench) > 0 ? 1 : 0.1);
    const double k = 1 / sqrt(ux * ux + uy * uy + uz * uz + 1e-30);
    *p = cml_vec_of(reach * dice(bench), reach * dice(bench), 2 * height * dice(bench));
    *u = cml_vec_of(k * ux, k * uy, k * uz);
    *length = (real)pow(10, -2 + 2.5 * dice(bench));
}

/* True if the exact geometry is crossed in [0, length] from the given side. */
static int crosses(const struct bench *bench, struct cml_vec p, struct cml_vec u, real side, real length)
{
    const struct cml_world *world = &bench->scalar.world;
    if (world->surfaces[0].kind == CML_SURFACE_CONE) {
        real t;
        int ring;
        return cml_cone_hit(cml_rings_of(world, 0), p, u, side, 0, length, -1, &t, &ring);
    }
    const double dp[3] = {p.x, p.y, p.z}, du[3] = {u.x, u.y, u.z};
    struct cml_mesh_crossing crossing;
    return cml_mesh_surface_hit(world->meshes[0], dp, du, side > 0, length, -1, 0, 1, 0, &crossing);
}

/* True if the search over the remaining part of a step gives the result of the search over the whole step,
 * to the last bit. */
static int meets_the_same(const struct bench *bench, struct cml_vec p, struct cml_vec u, real side,
                          real length, struct cml_interval left)
{
    const struct cml_rings rings = cml_rings_of(&bench->scalar.world, 0);
    real t[2] = {0, 0};
    int ring[2];
    const int whole = cml_cone_hit(rings, p, u, side, 0, length, -1, &t[0], &ring[0]),
              part = cml_cone_hit(rings, p, u, side, left.from, left.to, -1, &t[1], &ring[1]);
    return whole == part && (!whole || (t[0] == t[1] && ring[0] == ring[1]));
}

static long steps = 300000; /* steps per scene; the first argument of the program */

static void expect_conservative(const char *line, enum cml_surface_kind kind, double reach)
{
    struct bench bench;
    bench_open(line, kind, &bench);
    const struct cml_world *world = &bench.scalar.world;
    const struct cml_surface *surface = &world->surfaces[0];
    const double height = fmax(fabs(surface->lowest), fabs(surface->highest)) + 1e-3;
    const int rings = surface->kind == CML_SURFACE_CONE;
    long clear = 0, safe = 0, wrong = 0, cut = 0, other = 0;
    for (long i = 0; i < steps; i++) {
        struct cml_vec p, u;
        real length;
        random_step(&bench, reach, height, &p, &u, &length);
        const real side = i & 1 ? (real)1 : (real)-1;
        const struct cml_interval all = {1, 0, length};
        const struct cml_interval left =
            cml_clip_interval(&surface->depths, side > 0 ? world->deepest : world->highest, p, u, side, all,
                              surface->depths.form);
        const int is_safe = cml_is_safe(world, surface, p, u, length);
        clear += !left.meets;
        safe += is_safe;
        if (!left.meets || is_safe) wrong += crosses(&bench, p, u, side, length);
        if (!left.meets || !rings) continue;
        cut += left.from > 0 || left.to < length;
        other += !meets_the_same(&bench, p, u, side, length, left);
    }
    print_message("%.60s: of %ld steps %ld clear, %ld safe, %ld wrongly; %ld cut, %ld wrongly\n", line, steps,
                  clear, safe, wrong, cut, other);
    assert_true(clear > steps / 10);
    assert_true(world->safe_cells[0].nx == 0 || safe > steps / 20);
    assert_true(!rings || cut > steps / 30);
    assert_int_equal(wrong + other, 0);
    bench_close(&bench);
}

#define NOISE "b 9 0.02 0.05 -0.03 0.05 0.04 0.05 -0.05 0.05 0.01 0.05 0.06 0.05 -0.02 0.05 0.03 0.05 0 0"
#define MESH(name) "m \"" CML_SOURCE_DIR "/meshes/" name "\""

/* Meshes of irregular facets, or steep in one place only, in a folder that lasts as long as the tests. */
static char folder[] = "/tmp/cml_bounds_XXXXXX";
static char irregular_path[64], spiked_path[64], corner_path[64]; /* files */
static char irregular[80], spiked[80], corner[96];                /* lines of .mci files */

/* Writes a tile that is level except for one spike beside its first corner. For most of the tile, the
 * spike's copies across the seams are nearest. */
static void write_corner(void)
{
    FILE *file = fopen(corner_path, "w");
    assert_non_null(file);
    fprintf(file, "ncols 32 nrows 32 cellsize 0.03125\n");
    for (int i = 0; i < 32 * 32; i++) fprintf(file, "%s\n", i == 30 * 32 + 1 ? "0.1" : "0");
    fclose(file);
    snprintf(corner, sizeof corner, "m \"%s\" units=cm tile", corner_path);
}

static int write_meshes(void **state)
{
    (void)state;
    static struct patch patch;
    assert_non_null(mkdtemp(folder));
    snprintf(irregular_path, sizeof irregular_path, "%s/irregular.obj", folder);
    snprintf(spiked_path, sizeof spiked_path, "%s/spiked.obj", folder);
    snprintf(corner_path, sizeof corner_path, "%s/corner.asc", folder);
    write_corner();
    snprintf(irregular, sizeof irregular, "m \"%s\"", irregular_path);
    snprintf(spiked, sizeof spiked, "m \"%s\"", spiked_path);
    patch_make(&patch, 1, 0.01, 0, 0, 0);
    patch_spike(&patch, GRID / 4, GRID / 4, 0.1);
    patch_write(&patch, spiked_path);
    patch_make(&patch, 1, 0.01, 0, 0, 0);
    patch_move(&patch, 2, 0.25);
    patch_write(&patch, irregular_path);
    return 0;
}

static int remove_meshes(void **state)
{
    (void)state;
    remove(irregular_path);
    remove(spiked_path);
    remove(corner_path);
    return rmdir(folder);
}

static void a_clear_step_crosses_nothing(void **state)
{
    (void)state;
    expect_conservative(NOISE, CML_SURFACE_CONE, 0.6);
    expect_conservative(NOISE, CML_SURFACE_MESH, 0.6);
    expect_conservative("b 2 0.3 0.001 0 0", CML_SURFACE_CONE, 0.01);
    expect_conservative(MESH("ridges.obj"), CML_SURFACE_AUTO, 1.2);
    expect_conservative(MESH("overhang.obj"), CML_SURFACE_AUTO, 0.8);
    expect_conservative(MESH("wedge.obj"), CML_SURFACE_AUTO, 0.8);
    expect_conservative(MESH("spikes.obj") " shift=0.3,0,0", CML_SURFACE_AUTO, 0.8);
    expect_conservative(MESH("grooves.asc") " units=mm tile scale=3", CML_SURFACE_AUTO, 4);
    expect_conservative(MESH("skin.gsf") " tile=mirror scale=10", CML_SURFACE_AUTO, 30);
    expect_conservative(MESH("skin.gsf") " tile=mirror", CML_SURFACE_AUTO, 1000);
    expect_conservative(corner, CML_SURFACE_AUTO, 1.5);
    expect_conservative(irregular, CML_SURFACE_AUTO, 1.2);
    expect_conservative(spiked, CML_SURFACE_AUTO, 1.2);
}

/* Returns the place above or below p where a ray from far away on one side first meets the surface; it may
 * lie under an overhang. */
static struct cml_vec place_on_surface(const struct bench *bench, struct cml_vec p, real from)
{
    const double start[3] = {p.x, p.y, 10 * from}, down[3] = {0, 0, -from};
    struct cml_mesh_crossing hit;
    assert_true(cml_mesh_surface_hit(bench->scalar.world.meshes[0], start, down, from > 0, INFINITY, -1, 0, 1,
                                     0, &hit));
    return cml_vec_of(p.x, p.y, hit.point[2]);
}

/* Tests that packets that leave a surface more steeply than its horizon (a bound of the slope of all that may
 * lie ahead) meet it from nowhere on their side. Most horizons are lower than the steepest part of the
 * surface. lowered: least share, among packets found to get away, of those flatter than that part. */
static void expect_horizons(const char *line, double reach, double lowered)
{
    struct bench bench;
    bench_open(line, CML_SURFACE_AUTO, &bench);
    const struct cml_world *world = &bench.scalar.world;
    const struct cml_surface *surface = &world->surfaces[0];
    long away = 0, flat = 0, wrong = 0;
    for (long i = 0; i < steps; i++) {
        struct cml_vec p, u;
        real length;
        const real side = i & 1 ? (real)1 : (real)-1, from = i & 2 ? (real)1 : (real)-1;
        random_step(&bench, reach, 0.1, &p, &u, &length);
        const double little = i & 4 ? 1e-6 : 0.01 * fabs(dice(&bench));
        const struct cml_vec onset = place_on_surface(&bench, p, from);
        p = cml_vec_of(onset.x, onset.y, onset.z + side * little);
        if (!cml_heads_away(cml_horizon(world, surface, p, side, -1), u, side)) continue;
        if (crosses(&bench, onset, cml_vec_of(0, 0, side), side, (real)little))
            continue; /* the start is no longer on its side of the surface */
        away++;
        flat += !cml_heads_away(surface->steepest, u, side);
        wrong += crosses(&bench, p, u, side, CML_INFINITY);
    }
    print_message("%.60s: %ld of %ld get away, %ld of them flat, %ld wrongly\n", line, away, steps, flat,
                  wrong);
    assert_true(away > steps / 20);
    assert_true((double)flat >= lowered * (double)away);
    assert_int_equal(wrong, 0);
    bench_close(&bench);
}

static void above_its_horizon_a_packet_crosses_nothing(void **state)
{
    (void)state;
    expect_horizons(MESH("ridges.obj"), 0.7, 0.01);
    expect_horizons(MESH("pyramid.obj"), 0.7, 0);
    expect_horizons(MESH("wedge.obj"), 0.7, 0.05);
    expect_horizons(MESH("overhang.obj"), 2, 0.5);
    expect_horizons(MESH("prism.obj"), 3, 0.2);
    expect_horizons(MESH("grooves.asc") " units=mm tile", 3, 0.1);
    expect_horizons(MESH("skin.gsf") " tile=mirror", 3, 0.1);
    expect_horizons(corner, 1.5, 0.3);
    expect_horizons(irregular, 1.2, 0.1);
    expect_horizons(spiked, 1.2, 0.5);
}

/* True if p lies on the given side. Cones rely on the side that they are told. */
static bool is_on_side(const struct bench *bench, struct cml_vec p, real side)
{
    const struct cml_boundary *boundary = &bench->list.scenes[0].boundaries[0];
    return side * ((double)p.z + cml_radial_height(&boundary->radial, hypot((double)p.x, (double)p.y))) >
           1e-6;
}

/* Directions steeper than all rings cannot cross them. */
static void a_steep_direction_crosses_nothing(void **state)
{
    (void)state;
    struct bench bench;
    long away = 0;
    bench_open(NOISE, CML_SURFACE_AUTO, &bench);
    for (int i = 0; i < 200000; i++) {
        struct cml_vec p, u;
        real length;
        const real side = i & 1 ? (real)1 : (real)-1;
        random_step(&bench, 0.6, 0.1, &p, &u, &length);
        if (!cml_heads_away(bench.scalar.world.surfaces[0].steepest, u, side) || !is_on_side(&bench, p, side))
            continue;
        away++;
        assert_false(crosses(&bench, p, u, side, CML_INFINITY));
    }
    assert_true(away > 1000);
    bench_close(&bench);
}

/* Compares the fast query with the exact one. sheet: the fast query walks over cells; otherwise Embree's
 * triangles find the hit. */
static void expect_exact(const char *line, bool sheet)
{
    struct bench bench;
    bench_open(line, CML_SURFACE_AUTO, &bench);
    const struct cml_mesh_surface *mesh = bench.scalar.world.meshes[0];
    assert_true(cml_mesh_surface_is_sheet(mesh) == sheet);
    long hits = 0, different = 0;
    for (int i = 0; i < 300000; i++) {
        struct cml_vec p, u;
        real length;
        struct cml_mesh_crossing fast, exact;
        random_step(&bench, 1.1, 0.02, &p, &u, &length);
        const double dp[3] = {p.x, p.y, p.z}, du[3] = {u.x, u.y, u.z};
        const int a = cml_mesh_surface_hit(mesh, dp, du, i & 1, length, -1, 0, 0, 0, &fast);
        const int b = cml_mesh_surface_hit(mesh, dp, du, i & 1, length, -1, 0, 1, 0, &exact);
        hits += b;
        different += a != b || (a && (fast.primitive != exact.primitive || fabs(fast.t - exact.t) > 1e-9));
    }
    print_message("fast against exact: %ld hits, %ld different\n", hits, different);
    assert_true(hits > 10000);
    assert_true(different <= 1); /* rays within single-precision rounding of an edge */
    bench_close(&bench);
}

static void the_fast_query_is_the_exact_one(void **state)
{
    (void)state;
    expect_exact(MESH("ridges.obj"), true);
    expect_exact(MESH("overhang.obj"), false);
    expect_exact(MESH("grooves.asc") " units=mm tile", true);
    expect_exact(MESH("skin.gsf") " tile=mirror", true);
    expect_exact(irregular, true);
    expect_exact(spiked, true);
}

int main(int argc, char **argv)
{
    if (argc > 1) steps = atol(argv[1]);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_clear_step_crosses_nothing),
        cmocka_unit_test(a_steep_direction_crosses_nothing),
        cmocka_unit_test(above_its_horizon_a_packet_crosses_nothing),
        cmocka_unit_test(the_fast_query_is_the_exact_one),
    };
    return cmocka_run_group_tests(tests, write_meshes, remove_meshes);
}
