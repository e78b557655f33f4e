/* Compares the vector passes of the CPU engine with the scalar walk: whole tallies, bit for bit.
 *
 * A tally holds every deposit, balance term, count and square, so that one packet on another way is noticed.
 * Over 600 lines: one list of scenes, each for one way through the loops.
 * SPDX-License-Identifier: MIT */
#include "flight.h"
#include "same_tally.h"

#include "body_files.h"
#include "invented.h"

#include "engine/cpu/bundle_walk_inl.h"
#include "engine/cpu/engine_cpu.h"
#include "engine/scalar_walk_inl.h"
#include "engine/world.h"
#include "surface/mesh/mesh_surface.h"

#include <glob.h>

/* Levels of the processor that this machine can run. All give the same bits. */
static struct cml_cpu_level levels[CML_CPU_LEVELS];
static int num_levels;

static int entered;       /* number of expected values that got any light */
static uint64_t branched; /* number of parts of split packets */

/* Tables of --aim beside the ordinary counts. */
enum { NOTHING = 0, TAIL = 1, WINDOWS = 2 };

/* Checks that bundles at one level of the processor leave the tally of the scalar walk. */
static void compare_level(const struct cml_cpu_level *level, const struct cml_scene *scene,
                          const struct cml_surface_set *surfaces, const struct cml_engine_options *options,
                          const struct cml_tally *scalar, uint64_t photons)
{
    const struct cml_engine *engine = level->engine;
    struct cml_error err;
    struct cml_tally tally;
    char name[300];
    void *cpu = NULL;
    require_ok(cml_tally_create(&scalar->grid, &tally, &err), &err);
    require_ok(engine->open(scene, surfaces, options, &cpu, &err), &err);
    require_ok(cml_engine_run_range(engine, cpu, 1000, photons, &tally, &err), &err);
    engine->close(cpu);
    assert_int_equal(tally.count[CML_COUNT_PHOTONS], photons);
    snprintf(name, sizeof name, "%.200s, %s", scene->output, level->name);
    expect_same_tally(scalar, &tally, name);
    if (scalar->grid.derivatives) expect_balanced_scores(&tally);
    cml_tally_free(&tally);
}

static void compare_with(const struct cml_scene *scene, enum cml_surface_kind kind, uint64_t photons,
                         const struct cml_engine_options *asked, int aims)
{
    struct cml_engine_options options = *asked;
    struct cml_flat_tail tail = {0};
    struct cml_window_table windows;
    struct cml_error err;
    struct cml_surface_set surfaces;
    const struct cml_surface_options surface = {.force = kind,
                                                .tessellation = {1e-3, CML_NORMALS_ANALYTIC, false}};
    struct cml_tally scalar;
    struct cml_owned_world world;
    require_ok(cml_surfaces_create(scene, &surface, &surfaces, &err), &err);
    if (aims & TAIL) invent_tail(scene, &surfaces, &tail);
    if (tail.layer > 0) options.tail = &tail;
    invent_windows(scene, &windows);
    if (aims & WINDOWS) options.windows = &windows;
    const struct cml_tally_grid grid = cml_engine_grid(scene, &surfaces, &options);
    require_ok(cml_tally_create(&grid, &scalar, &err), &err);
    require_ok(cml_owned_world_create(scene, &surfaces, &options, &world, &err), &err);
    float *factor = calloc(cml_row_factors(cml_row_stride(&grid)), sizeof *factor); /* scratch memory */
    assert_non_null(factor);
    struct cml_branches branches;
    require_ok(cml_branches_create(&world.world, &branches, &err), &err);
    for (uint64_t place = 1000, end = 1000 + photons; place < end;) {
        const struct cml_piece piece = cml_piece_at(1000, end, place);
        struct cml_patience patience = {0};
        assert_true(
            run_piece(&world.world, &(struct cml_work){0}, &piece, &patience, factor, &branches, &scalar));
        place += piece.count;
    }
    for (int i = 0; i < num_levels; i++)
        compare_level(&levels[i], scene, &surfaces, &options, &scalar, photons);
    free(factor);
    branched += scalar.count[CML_COUNT_BRANCHES];
    for (int s = 0; s < tail.scores; s++) entered += scalar.expected[s] > 0;
    cml_branches_free(&branches);
    cml_owned_world_free(&world);
    cml_tally_free(&scalar);
    cml_surfaces_free(&surfaces);
    cml_flat_tail_clear(&tail);
}

/* Compares the tallies of a scene. With re-entry, packets are drawn from the lattice and use the default
 * roulette; without, they follow original MCML. */
static void compare(const struct cml_scene *scene, enum cml_surface_kind kind, uint64_t photons, bool reentry,
                    int aims)
{
    const struct cml_roulette_options window = {0.01, 0.03}, mcml = {0, 0};
    compare_with(scene, kind, photons,
                 &(struct cml_engine_options){.seed = 5,
                                              .threads = 2,
                                              .chunk = 37,
                                              .lattice = reentry,
                                              .roulette = reentry ? window : mcml,
                                              .reentry = reentry,
                                              .absorption = true},
                 aims);
}

/* Compares tallies with rows of one flight. The first row is the flown scene; in each other row, every other
 * medium absorbs more. A(r,z) is included if it is small. */
static void compare_rows(const struct cml_scene *scene, enum cml_surface_kind kind, uint64_t photons)
{
    enum { ROWS = 20 };
    const int media = scene->num_layers + 2 + scene->num_bodies;
    double *more = calloc((size_t)media * ROWS, sizeof *more);
    assert_non_null(more);
    for (int m = 1; m < media; m++)
        for (int i = 0; i < ROWS && m != scene->num_layers + 1; i++)
            more[m * ROWS + i] = (m + i) % 2 ? 0.7 * i * i : 0;
    const struct cml_engine_rows rows = {.count = ROWS, .more = more};
    const bool reaches = (long)scene->nr * scene->nz < 5000 && cml_engine_rows_blind_in(scene, &rows) < 0;
    compare_with(
        scene, kind, photons,
        &(struct cml_engine_options){.seed = 6, .reentry = true, .rows = {ROWS, more, reaches, true, true}},
        NOTHING);
    free(more);
}

static void compare_scores(const struct cml_scene *scene, enum cml_surface_kind kind, uint64_t photons)
{
    const struct cml_engine_options options = {
        .seed = 7, .reentry = true, .roulette = {0.01, 0.03}, .absorption = true, .derivatives = true};
    compare_with(scene, kind, photons, &options, NOTHING);
}

/* Detectors of all shapes on both sides, in a plane that cuts most reliefs, and with an axis. */
static struct cml_detector_def detectors[] = {
    {.shape = CML_DETECTOR_RING, .size = {0, 0.1}, .nx = 1, .ny = 1},
    {.shape = CML_DETECTOR_RING,
     .size = {0.05, 0.5},
     .nx = 1,
     .ny = 1,
     .z = -0.02,
     .aimed = true,
     .na = 0.8,
     .angle = 0.7,
     .azimuth = 2},
    {.shape = CML_DETECTOR_RECTANGLE, .size = {0.4, 3}, .nx = 1, .ny = 1, .x = 0.1, .diffuse = true},
    {.shape = CML_DETECTOR_MAP, .size = {0.05, 0.1}, .nx = 40, .ny = 30, .y = -0.3, .z = 0.3, .below = true},
    {.shape = CML_DETECTOR_MAP, .size = {0.1, 0.1}, .nx = 30, .ny = 30, .aimed = true, .na = 9},
};

static void set_detectors(struct cml_scene *scene, bool on)
{
    scene->detectors = on ? detectors : NULL;
    scene->num_detectors = on ? (int)(sizeof detectors / sizeof *detectors) : 0;
}

static void compare_file(const char *path, enum cml_surface_kind kind, uint64_t photons)
{
    struct cml_error err;
    struct cml_scene_list list;
    char full[4096];
    snprintf(full, sizeof full, "%s/samples/%s", CML_SOURCE_DIR, path);
    require_ok(cml_mci_read(full, NULL, &list, &err), &err);
    for (int i = 0; i < list.count; i++) {
        /* scores are counted together with rows; a part of the scenes is enough */
        const bool timeless = list.scenes[i].time.gates == 0;
        set_detectors(&list.scenes[i], true);
        if (i == 0 && timeless && !strstr(path, "shapes/"))
            compare_scores(&list.scenes[i], kind, photons / 16);
        list.scenes[i].time = (struct cml_time_def){.gates = 50, .end = 20, .radii = true};
        list.scenes[i].directions = (struct cml_directions_def){.nt = 9, .np = 12};
        compare_rows(&list.scenes[i], kind, photons / 4);
        list.scenes[i].directions = (struct cml_directions_def){0};
        list.scenes[i].fluence =
            (struct cml_fluence_def){.line = 1, .times = list.scenes[i].nr * list.scenes[i].nz < 20000};
        compare(&list.scenes[i], kind, photons, true, NOTHING);
        list.scenes[i].fluence = (struct cml_fluence_def){0};
        compare(&list.scenes[i], kind, photons / 32, true, WINDOWS);
        set_detectors(&list.scenes[i], false);
        list.scenes[i].time = (struct cml_time_def){0};
        list.scenes[i].directions = (struct cml_directions_def){.nt = 9, .np = 12};
        list.scenes[i].fluence.line = 1;
        struct cml_scene *s = &list.scenes[i];
        if (s->map.nx == 0) /* adds voxels that begin 1.5 dz above the grid */
            s->map = (struct cml_map_def){5, 4, 20 * s->dr, 30 * s->dr, false, true, -1.5 * s->dz, 0};
        compare(&list.scenes[i], kind, photons / 4, false, TAIL);
    }
    cml_scene_list_clear(&list);
}

/* Returns the photons for a sample, fewer if its light is scattered hundreds of times. */
static int photons_of(const char *path)
{
    if (strstr(path, "thick")) return 1000;
    return strstr(path, "skin") ? 500 : 4000;
}

static void every_sample_has_the_same_tally(void **state)
{
    (void)state;
    static const char *const patterns[] = {"*.mci", "shapes/*.mci"};
    const size_t root = strlen(CML_SOURCE_DIR "/samples/");
    for (size_t i = 0; i < sizeof patterns / sizeof *patterns; i++) {
        char full[4096];
        glob_t found;
        snprintf(full, sizeof full, CML_SOURCE_DIR "/samples/%s", patterns[i]);
        assert_int_equal(glob(full, 0, NULL, &found), 0);
        for (size_t k = 0; k < found.gl_pathc; k++) {
            const char *path = found.gl_pathv[k] + root;
            compare_file(path, CML_SURFACE_AUTO, (uint64_t)repeats(2 * photons_of(path)));
        }
        globfree(&found);
    }
    compare_file("shapes/hinoise.mci", CML_SURFACE_MESH, (uint64_t)repeats(8000));
    compare_file("shapes/flat50.mci", CML_SURFACE_CONE, (uint64_t)repeats(8000));
    assert_true(entered > 20);
    assert_true(branched > (uint64_t)repeats(1000));
}

static void compare_text(const char *text, uint64_t photons)
{
    struct cml_scene_list list;
    read_scenes(text, &list);
    compare(&list.scenes[0], CML_SURFACE_AUTO, photons, true, NOTHING);
    compare(&list.scenes[0], CML_SURFACE_AUTO, photons / 8, true, TAIL | WINDOWS);
    compare_rows(&list.scenes[0], CML_SURFACE_AUTO, photons / 4 + 1);
    compare_scores(&list.scenes[0], CML_SURFACE_AUTO, photons / 16 + 1);
    cml_scene_list_clear(&list);
}

/* Tests maps with and without angles, smaller than the scene, and a volume that begins above it, on planes,
 * cones and meshes with facets. */
static void maps_and_facets_have_the_same_tally(void **state)
{
    (void)state;
    static const char *const samples[] = {"wedge.mci", "mixed.mci", "ridges.mci", "shapes/hihill.mci",
                                          "mcml_sample.mci"};
    for (size_t i = 0; i < sizeof samples / sizeof *samples; i++) {
        struct cml_error err;
        struct cml_scene_list list;
        char full[4096];
        snprintf(full, sizeof full, "%s/samples/%s", CML_SOURCE_DIR, samples[i]);
        require_ok(cml_mci_read(full, NULL, &list, &err), &err);
        struct cml_scene *scene = &list.scenes[0];
        scene->map = (struct cml_map_def){
            .nx = 17, .ny = 10, .dx = 0.03, .dy = 0.05, .angles = i % 2 == 0, .volume = true, .top = -0.05};
        scene->facets = true;
        compare(scene, CML_SURFACE_AUTO, 4000, true, NOTHING);
        compare(scene, CML_SURFACE_AUTO, 1000, false, TAIL);
        compare(scene, CML_SURFACE_MESH, 1000, true, NOTHING);
        cml_scene_list_clear(&list);
    }
}

/* Tests glass, pure absorbers, guided light, oblique and wide beams, g = +-1, infinitely deep layers, and 1
 * photon. */
static void odd_scenes_have_the_same_tally(void **state)
{
    (void)state;
#define HEAD "1.0\n1\nodd A\n1\n"
#define GRID "0.01 0.01\n20 20 7\n"
    compare_text(HEAD GRID "3\n1\n1.5 0 0 0 0.1\n1.37 0.5 20 0.8 0.3\n1.5 0 0 0 0.1\n1\n", 3000);
    compare_text(HEAD "beam pencil angle=60\n" GRID "2\n1\n1.5 0 0 0 0.1\n1.3 1 0 0 0.3\n1\n", 3000);
    compare_text(HEAD "beam disk 0.1\n" GRID "1\n1.4\n1.4 1 10 1 0.5\n1.4\n", 2000);
    compare_text(HEAD "beam gaussian 0.2 at=0.3,-0.1\n" GRID "1\n1\n1.4 1 10 -1 0.5\n1.6\n", 2000);
    /* spread and slanted light goes from the queue through the plane below: into denser, thinner and matched
     * media */
    compare_text(HEAD "beam disk 0.1 light=lambertian\n" GRID "1\n1\n1.4 1 10 0.8 0.5\n1\n", 2000);
    compare_text(HEAD "beam pencil light=lambertian\n" GRID "1\n1.6\n1.3 1 10 0.8 0.5\n1\n", 2000);
    compare_text(HEAD "beam gaussian 0.1 at=0.3,-0.1 angle=50\n" GRID "1\n1.5\n1.3 1 10 0.8 0.5\n1\n", 2000);
    compare_text(HEAD "beam rectangle 0.1 0.2 angle=20 light=na:0.5\n" GRID "1\n1.4\n1.4 1 10 0.8 0.5\n1\n",
                 2000);
    compare_text(HEAD GRID "1\n1\n1.4 1 9 0 1e8\n1\n", 1000);
    compare_text(HEAD GRID "1\n1\n1.4 1e-7 50 0.5 0.1\n1\n", 1000);
    compare_text(HEAD "beam disk 0.2\n" GRID
                      "2\n1\nb 3 0.1 0.1 -0.1 0.2 0 0\n1.5 0 0 0 0.5\nb 2 0.2 0.3 0 0\n1.3 0 5 0 0.2\n1\n",
                 2000);
    /* a pencil beam on rings: equal indices, total reflection, both with oblique light */
    compare_text(HEAD GRID "1\n1.4\nb 3 0.1 0.1 -0.1 0.2 0 0\n1.4 1 10 0.5 0.5\n1\n", 1000);
    compare_text(HEAD "beam pencil angle=60 at=0.03,0.01\n" GRID
                      "1\n1.5\nb 3 0.1 0.1 -0.1 0.2 0 0\n1 1 10 0.5 0.5\n1\n",
                 1000);
    compare_text(HEAD "beam pencil angle=75 at=0.03,0.01\n" GRID
                      "1\n1\nb 3 0.1 0.1 -0.1 0.2 0 0\n1.4 1 10 0.5 0.5\n1\n",
                 1000);
    /* light enters by the flank of a cone and is then guided for ever: its last event is at a plane */
    compare_text(HEAD "beam pencil at=0.05,0\n" GRID
                      "3\n1\nb 2 0.17320508075688773 0.1 0 0\n2 0 0 0 0.3\n2 0 0 0 0.1\n2 0 0 0 0.1\n1\n",
                 300);
    compare_text(HEAD GRID "1\n1\n1.4 1 9 0.5 0.2\n1\n", 1);
    compare_text(HEAD "0.01 0.3\n20 1 1\n1\n1\n1.4 1 50 0.5 0.2\n1\n", 1000); /* a single radial bin */
    /* an A_rz that all threads share */
    compare_text(HEAD "0.0001 0.0001\n2000 1000 7\n1\n1\n1.4 1 90 0.5 0.2\n1\n", 500);
    /* phase functions of all media, of some media, mirrored, and of a body */
    compare_text(HEAD GRID "1\n1\n1.4 1 50 0.62 0.2\nphase hg2 0.9 -0.5 0.8\n1\n", 1000);
    compare_text(HEAD "beam disk 0.1\n" GRID
                      "4\n1\n1.5 0 0 0 0.1\n1.4 1 50 0 0.1\nphase rayleigh\ni sphere 0 0 0.15 0.02 1.3 1 90 "
                      "-0.9\nphase gk -0.9 0.5\n1.3 1 0 0 0.02\n1.4 1 20 0.8 0.1\n1\n",
                 2000);
    compare_text(HEAD "map 5 5 0.1 0.1\nfacets\n" GRID "2\n1\n1.5 0 0 0 0.1\n1.37 0.5 20 0.8 0.3\n1\n", 2000);
}

/* Tests faces and ports on boundary 0: light from ports, from above and from inside, split off or not. */
static void touched_scenes_have_the_same_tally(void **state)
{
    (void)state;
#define TOP "port disk 0.1 n=1.5 name=p\nport ring 0.1 0.12 n=1\nface rectangle 0.05 0.3 0.4 at=0.2,0\n"
#define UNDER "1.4 1 20 0.8 0.3\n1\n"
    compare_text(HEAD "beam port p light=na:0.5\n" GRID "1\n1\nface 0.5\n" TOP UNDER, 3000);
    compare_text(HEAD "beam port p\n" GRID "2\n1\n" TOP "1.5 0 0 0 0.1\n" UNDER, 2000);
    compare_text(HEAD "beam port 2 angle=30 azimuth=70\n" GRID "1\n1\nface 0.5 lambertian\n" TOP UNDER, 2000);
    compare_text(HEAD "beam rectangle 0.5 0.4\n" GRID "2\n1\n" TOP "1.5 0 0 0 0.1\n" UNDER, 3000);
    compare_text(HEAD "beam disk 0.3 angle=20 light=na:0.3\n" GRID "1\n1\n" TOP UNDER, 3000);
    compare_text(HEAD "beam pencil at=0.3,0\n" GRID "1\n1\nface ring 0.4 0.6 metal 2 3\n" TOP UNDER, 2000);
    compare_text(HEAD "beam disk 0.3 z=-0.1 light=isotropic\nbeam port p share=0.3\nbeam pencil z=0.1\n"
                      "detector port p na=0.3\ndetector port 2 diffuse\n" GRID
                      "1\n1\nface 0.9 lambertian\nface disk 1 metal 0 5\nport disk 0.5 n=1\n" TOP
                      "1.4 1 20 0.8 0.3\ni sphere 0 0 0.15 0.1 1.3 1 20 0.5\nbacking 0.5\n1\n",
                 3000);
    compare_text(HEAD "beam disk 0.2\nmap 5 5 0.1 0.1\nfacets\n" GRID "1\n1\n" TOP
                      "1.4 1 20 0.8 0.3\nb 3 0.02 0.1 0 "
                      "0.1 0.01 0.1\n1\n",
                 2000);
}

/* Tests roughness of planes, rings, interpolated facets and bodies, in matched layers, with mirrors and
 * metals. */
static void rough_scenes_have_the_same_tally(void **state)
{
    (void)state;
    const uint64_t photons = (uint64_t)repeats(12000);
    compare_text(HEAD GRID "2\n1\nrough ggx 0.3\n1.5 0 0 0 0.1\nrough beckmann 0.5\n1.37 0.5 20 0.8 0.3\n"
                           "rough ggx 2\n1\n",
                 photons);
    compare_text(HEAD "beam disk 0.2 angle=40\nmap 5 5 0.1 0.1\nfacets\n" GRID
                      "2\n1\nrough ggx 0.1\nb 3 0.1 0.1 -0.1 0.2 0 0\n1.5 0 0 0 0.5\nrough ggx 0.1\n"
                      "1.5 0 5 0 0.2\nrough beckmann 0.05\n1.3\n",
                 photons);
    compare_text(HEAD "beam disk 0.2\n" GRID
                      "1\n1\n1.4 1 50 0.8 0.2\ni sphere 0 0 0.1 0.05 1 0 0 0 rough=ggx,0.5\n"
                      "i cylinder 0.1 0 0.05 0.1 0.1 0.15 0.03 1.6 1 10 0.5 rough=beckmann,1\n"
                      "rough ggx 0.3\nbacking 0.8 mirror\n1\n",
                 photons);
    compare_text(HEAD "beam rectangle 0.0128 0.0128\n" GRID
                      "1\n1\nm gaussian 0.4 0.002 tile points=64 normals=vertex\nrough beckmann 0.3\n"
                      "1.4 1 50 0.8 0.2\nrough beckmann 0.7\nbacking metal 0.2 3\n1\n",
                 photons);
}

/* Returns one of `count` values, and advances *seed (Marsaglia's xorshift). */
static double any_of(uint32_t *seed, const double *values, size_t count)
{
    *seed ^= *seed << 13;
    *seed ^= *seed >> 17;
    *seed ^= *seed << 5;
    return values[*seed % count];
}

#define ANY(...)                                                                                             \
    any_of(seed, (const double[]){__VA_ARGS__}, sizeof(const double[]){__VA_ARGS__} / sizeof(double))

/* Writes rings of up to 0.02 cm in place of a plane, two times in five. */
static int write_boundary(char *text, size_t size, uint32_t *seed)
{
    if (ANY(0, 0, 0, 1, 1) == 0) return 0;
    return snprintf(text, size, "b 4 %g %g %g %g %g %g %g 0\n", ANY(0, 0.01, 0.02, -0.02),
                    ANY(0.01, 0.1, 0.3), ANY(0, 0.02, -0.01), ANY(0.001, 0.05), ANY(0.015, -0.02),
                    ANY(0.02, 0.2), ANY(0, 0.01));
}

static void write_scene(char *text, size_t size, int number, uint32_t *seed)
{
    static const char *const beams[] = {"", "beam disk 0.1\n", "beam gaussian 0.05 angle=30\n",
                                        "beam pencil at=0.02,0.03 angle=50 azimuth=200\n",
                                        "map 4 4 0.1 0.1\nfacets\n"};
    const int layers = (int)ANY(1, 1, 2, 3, 4);
    int n = snprintf(text, size, "1.0\n1\nscene%d A\n1\n%s" GRID "%d\n%g\n", number,
                     beams[(int)ANY(0, 0, 0, 1, 2, 3, 4)], layers, ANY(1, 1, 1.33, 1.5));
    for (int i = 0; i < layers; i++) {
        n += write_boundary(text + n, size - (size_t)n, seed);
        n += snprintf(text + n, size - (size_t)n, "%g %g %g %g %g\n", ANY(1, 1.33, 1.4, 1.5),
                      ANY(0, 0.1, 1, 5), ANY(0, 1, 10, 100), ANY(-0.5, 0, 0.5, 0.9, 1), ANY(0.05, 0.2, 1));
    }
    n += write_boundary(text + n, size - (size_t)n, seed);
    snprintf(text + n, size - (size_t)n, "%g\n", ANY(1, 1, 1.33, 1.5));
}

/* Tests random scenes, for cases that no list contains. */
static void random_scenes_have_the_same_tally(void **state)
{
    (void)state;
    uint32_t seed = 20261121;
    for (int i = 0; i < 60; i++) {
        char text[2000];
        struct cml_scene_list list;
        write_scene(text, sizeof text, i, &seed);
        read_scenes(text, &list);
        compare(&list.scenes[0], i % 3 == 2 ? CML_SURFACE_MESH : CML_SURFACE_AUTO, 400, i % 2 == 0,
                i % 4 < 2);
        cml_scene_list_clear(&list);
    }
}

static int take_all(void *context, uint64_t *first, uint64_t *count)
{
    uint64_t *photons = context;
    *first = 0;
    *count = *photons;
    *photons = 0;
    return *count > 0;
}

static void ignore_batch(void *context, int batch, struct cml_tally *tally)
{
    (void)context;
    (void)batch;
    (void)tally;
}

static int give_nothing_up(void *context)
{
    (void)context;
    return 0;
}

/* A bundle of one layer whose inner state a test looks at. */
struct bundle_flight {
    struct flight flight;
    struct cml_owned_world scalar;
    struct cml_tally tally;
    struct cml_lane_medium media[3];
    struct cml_bundle bundle;
    uint64_t photons;
    struct cml_range_source source;
    struct cml_flight f;
};

static void bundle_flight_open(const char *text, enum cml_surface_kind kind, uint64_t photons,
                               struct bundle_flight *b)
{
    struct cml_error err;
    const struct cml_engine_options options = {.seed = 12, .threads = 1, .reentry = true};
    const struct flight_options with = {.engine = "cpu", .kind = kind};
    *b = (struct bundle_flight){.photons = photons,
                                .source = {take_all, ignore_batch, give_nothing_up, &b->photons}};
    flight_open(text, &with, &b->flight);
    const struct cml_scene *scene = &b->flight.list.scenes[0];
    const struct cml_tally_grid grid = cml_engine_grid(scene, &b->flight.surfaces, &options);
    require_ok(cml_tally_create(&grid, &b->tally, &err), &err);
    require_ok(cml_owned_world_create(scene, &b->flight.surfaces, &options, &b->scalar, &err), &err);
    for (int m = 0; m < 3; m++) b->media[m] = cml_lane_medium_of(&b->scalar.world, m);
    b->f = (struct cml_flight){.world = &b->scalar.world,
                               .b = &b->bundle,
                               .tally = &b->tally,
                               .media = b->media,
                               .source = &b->source};
    cml_flight_begin(&b->f);
}

static void bundle_flight_close(struct bundle_flight *b)
{
    cml_owned_world_free(&b->scalar);
    cml_tally_free(&b->tally);
    flight_close(&b->flight);
}

/* An empty lane ends nothing. It draws random numbers like the others, and one word in 2^32 puts its optical
 * depth into the tail. */
static void a_lane_without_a_packet_ends_nothing(void **state)
{
    (void)state;
    static struct bundle_flight b;
    bundle_flight_open(HEAD GRID "1\n1\n1.34 0.1 1 0.5 10\n1\n", CML_SURFACE_AUTO, CML_GROUP, &b);
    assert_int_equal(b.f.live, CML_GROUP_MASK);
    while (b.f.live == CML_GROUP_MASK) cml_flight_pass(&b.f);
    const int empty = __builtin_ctzll(~b.f.live);
    b.bundle.tau[empty] = CML_INFINITY;
    b.bundle.task[empty] = CML_LANE_TO_FLY;
    cml_flight_run(&b.f);
    assert_int_equal(b.tally.count[CML_COUNT_PHOTONS], CML_GROUP);
    bundle_flight_close(&b);
}

/* Tests thin media, which most packets leave without an interaction, so that they are only counted. */
static void ballistic_light_has_the_same_tally(void **state)
{
    (void)state;
    static struct bundle_flight b;
    bundle_flight_open(HEAD GRID "1\n1\n1.34 0.1 1 0.5 0.1\n1\n", CML_SURFACE_AUTO, 1000, &b);
    while (b.f.live) cml_flight_pass(&b.f);
    assert_in_range(b.f.ballistic.count, 820, 930); /* 0.98 exp(-0.11) of all packets */
    cml_flight_run(&b.f);
    assert_int_equal(b.tally.count[CML_COUNT_PHOTONS], 1000);
    bundle_flight_close(&b);
    compare_text(HEAD GRID "1\n1\n1.34 0.1 1 0.5 0.1\n1\n", 3000);
    compare_text(HEAD "beam pencil angle=70 azimuth=20\n" GRID "1\n1.2\n1.34 0.1 1 0.5 0.3\n1.34\n", 3000);
    compare_text(HEAD GRID "1\n1.6\n1.34 0 0 0 0.3\n3\n", 3000);
    compare_text(HEAD "beam pencil angle=75\n" GRID "1\n1\n1.34 0.1 1 0.5 0.1\n0.9\n", 3000);
    compare_text(HEAD GRID "2\n1\n1.34 0.1 1 0.5 0.1\n1.5 0.1 1 0.5 0.1\n1\n", 3000);
    compare_text(
        HEAD "beam pencil at=0.03,0.01\n" GRID "1\n1\nb 3 0.1 0.1 -0.1 0.2 0 0\n1.4 1 3 0.5 0.5\n1\n", 3000);
    compare_text(HEAD GRID "1\n1\n1.4 1 3 0.5 0.5\nb 3 0.1 0.1 -0.1 0.2 0 0\n1\n", 3000);
}

/* Tests pencils that enter on edges of an overhanging mesh. The next surface on their way is found once,
 * before launch: the mesh's lower side (i = 1), or none. */
static void paths_known_before_launch_have_the_same_tally(void **state)
{
    (void)state;
    static struct bundle_flight b;
    static const char *const at[] = {"0,0", "0.2,0"};
    for (int i = 0; i < 2; i++) {
        char text[1024];
        snprintf(text, sizeof text, HEAD "beam pencil at=%s\n" GRID "1\n1\nm \"%s\"\n1.34 0.1 1 0.5 0.5\n1\n",
                 at[i], CML_SOURCE_DIR "/meshes/overhang.obj");
        bundle_flight_open(text, CML_SURFACE_AUTO, CML_GROUP, &b);
        assert_non_null(b.f.world->known_path);
        assert_int_equal(b.f.known.from < INFINITY, i);
        bundle_flight_close(&b);
        compare_text(text, 3000);
    }
}

/* A lane knows the facets that it stands beside after an interaction, and only until the next one. */
static void a_lane_stands_beside_facets_for_one_flight(void **state)
{
    (void)state;
    static struct cml_bundle b;
    struct cml_packet packet = {.interactions = 3, .near_boundary = 2}, after;
    b.interactions[0] = b.interactions_at_hit[0] = 3;
    b.bounces[0] = 7;
    cml_store_near_boundary(&b, 0, &packet);
    b.interactions[0]++;
    cml_lane_packet(&b, 0, &after);
    assert_int_equal(after.on_boundary, 1);
    assert_int_equal(after.on_primitive, CML_NEAR_FACETS);
    assert_int_equal(after.bounces, 0);
    assert_int_equal(after.near_boundary, 0);
    b.interactions[0]++;
    cml_lane_packet(&b, 0, &after);
    assert_int_equal(after.on_boundary, -1);
}

/* Returns a packet below boundary 0 that stands on an edge of its first facet and interacts further along
 * the edge. */
static struct cml_packet packet_on_an_edge(const struct cml_owned_world *scalar,
                                           const struct cml_surface_set *surfaces)
{
    double middle[3], size = 0;
    const struct cml_mesh *mesh = cml_mesh_surface_mesh(surfaces->item[0].mesh, middle);
    const double *a = mesh->vertex[mesh->triangle[0][0]], *b = mesh->vertex[mesh->triangle[0][1]];
    real p[3], u[3];
    struct cml_packet packet;
    for (int k = 0; k < 3; k++) size = hypot(size, b[k] - a[k]);
    for (int k = 0; k < 3; k++) {
        p[k] = (real)(a[k] + 0.3 * (b[k] - a[k]) + middle[k]);
        u[k] = (real)((b[k] - a[k]) / size);
    }
    cml_launch(&scalar->world, 0, &packet);
    packet.medium = 1;
    packet.on_boundary = packet.on_primitive = 0;
    packet.p = (struct cml_vec){p[0], p[1], p[2]};
    packet.u = (struct cml_vec){u[0], u[1], u[2]};
    packet.tau = (real)(0.1 * size) * scalar->world.media[1].mut;
    return packet;
}

static void expect_beside(const struct cml_packet *packet)
{
    assert_int_equal(packet->interactions, 1);
    assert_int_equal(packet->on_boundary, 0);
    assert_int_equal(packet->on_primitive, CML_NEAR_FACETS);
}

/* Lanes and single packets both remember the facet beside them after an interaction within rounding of a
 * mesh. */
static void an_interaction_beside_a_facet_is_remembered(void **state)
{
    (void)state;
    static struct bundle_flight b;
    bundle_flight_open(HEAD GRID "1\n1\nb 3 0.1 0.1 -0.1 0.2 0 0\n1.4 1 10 0.5 0.5\n1\n", CML_SURFACE_MESH, 1,
                       &b);
    const struct cml_world *world = &b.scalar.world;
    struct cml_packet packet = packet_on_an_edge(&b.scalar, &b.flight.surfaces), after;
    cml_store_packet(&b.f, 0, &packet);
    cml_intersect_or_interact(&b.f, 0, cml_find_intervals(world, &packet, cml_free_path(world, &packet)));
    assert_int_equal(b.bundle.task[0], CML_LANE_INTERACT);
    b.bundle.interactions[0]++;
    cml_lane_packet(&b.bundle, 0, &after);
    expect_beside(&after);
    cml_step(world, &b.f.to, &packet);
    expect_beside(&packet);
    bundle_flight_close(&b);
}

/* Tests bodies of all forms, nested, clear and thick, below planes and below a hill, with a mesh and with
 * beams that strike bodies first. */
static void bodies_have_the_same_tally(void **state)
{
    (void)state;
    static const char bodies[] =
        "i sphere 0.02 0 0.3 0.12 1.33 5 200 0.9\ni sphere 0.02 0.01 0.32 0.08 1 0 0 0\n"
        "i sphere 0.02 0.02 0.32 0.03 1.5 1 10 0.5\n"
        "i cylinder -0.4 -0.3 0.6 0.3 0.4 0.62 0.05 1.4 30 0 0\n";
    char text[2048], mesh[] = "/tmp/cml_bundle_XXXXXX.obj";
    close(mkstemps(mesh, 4));
    write_sphere(mesh, 0.35, 0, 0.35, 0.15, 5);
    snprintf(text, sizeof text,
             HEAD "beam disk 0.3\n" GRID "1\n1\n1.37 0.5 20 0.8 0.8\n%si \"%s\" 1.6 0 5 0\n1\n", bodies,
             mesh);
    compare_text(text, 4000);
    remove(mesh);
    snprintf(text, sizeof text,
             HEAD "map 8 8 0.1 0.1 volume\nfacets\n" GRID
                  "2\n1\nb 3 0.1 0.1 -0.05 0.2 0 0\n1.37 0 0 0 0.8\n%s1.5 1 20 0.9 0.2\n1.2\n",
             bodies);
    compare_text(text, 4000);
}

/* Tests backings of every kind below planes, cones and a mesh, in a clear and a thick last layer, beside
 * bodies, with maps and facets. */
static void backings_have_the_same_tally(void **state)
{
    (void)state;
    static const char *const backings[] = {"backing 0", "backing 1 lambertian", "backing 0.7 mirror",
                                           "backing 0.4 lambertian", "backing metal 0.18 3.4"};
    static const char *const media[] = {"1.4 0.5 80 0.8 0.05", "1.5 0 0 0 0.1",
                                        "1.4 0.5 80 0.8 0.05\ni sphere 0 0 0.015 0.01 1.5 1 20 0.5"};
    static const char *const shapes[] = {"", "b 3 0.02 0.1 0.01 0.1 0 1\n"};
    char text[1024];
    for (int i = 0; i < 15; i++)
        for (int k = 0; k < 2; k++) {
            snprintf(text, sizeof text, HEAD "%s" GRID "1\n1\n%s\n%s%s\n1.2\n",
                     i % 4 == 3 && k ? "map 8 8 0.1 0.1 volume\nfacets\n" : "", media[i % 3], shapes[k],
                     backings[i / 3]);
            compare_text(text, 1000);
        }
    snprintf(text, sizeof text, HEAD "beam disk 0.002 z=0.015 light=isotropic\n" GRID "1\n1\n%s\n%s\n1\n",
             media[2], backings[3]); /* light that begins in a body */
    compare_text(text, 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_sample_has_the_same_tally),
        cmocka_unit_test(maps_and_facets_have_the_same_tally),
        cmocka_unit_test(odd_scenes_have_the_same_tally),
        cmocka_unit_test(touched_scenes_have_the_same_tally),
        cmocka_unit_test(rough_scenes_have_the_same_tally),
        cmocka_unit_test(random_scenes_have_the_same_tally),
        cmocka_unit_test(bodies_have_the_same_tally),
        cmocka_unit_test(backings_have_the_same_tally),
        cmocka_unit_test(a_lane_without_a_packet_ends_nothing),
        cmocka_unit_test(ballistic_light_has_the_same_tally),
        cmocka_unit_test(paths_known_before_launch_have_the_same_tally),
        cmocka_unit_test(a_lane_stands_beside_facets_for_one_flight),
        cmocka_unit_test(an_interaction_beside_a_facet_is_remembered),
    };
    num_levels = cml_cpu_levels(levels);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
