/* Compares tiles, packet by packet, with a patch of 9 x 9 copies whose rim no packet reaches, then with the
 * plane, and the engines with each other. The patch is an ordinary mesh, merged where it is flat, without
 * periods.
 * SPDX-License-Identifier: MIT */
#include "flight.h"

#include <math.h>

enum { CELLS = 24 };

static char folder[] = "/tmp/cml_tile_XXXXXX";
static char tile_path[64], patch_path[64], level_path[64];

/* Returns the height [cm] of waves along both axes and across; `height`: scale [cm]. */
static double height_at(int i, int j, double height)
{
    const double x = 6.283185307179586 * i / CELLS, y = 6.283185307179586 * j / CELLS;
    return height * (sin(x) + 0.7 * cos(2 * y + 1) + 0.5 * sin(3 * x - 2 * y));
}

static void write_map(const char *path, int copies, double height)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fprintf(file, "ncols %d nrows %d cellsize 0.01\n", copies * CELLS, copies * CELLS);
    for (int j = 0; j < copies * CELLS; j++)
        for (int i = 0; i < copies * CELLS; i++)
            fprintf(file, "%.17g%c", height_at(i % CELLS, j % CELLS, height),
                    i + 1 < copies * CELLS ? ' ' : '\n');
    fclose(file);
}

static int write_maps(void **state)
{
    (void)state;
    assert_non_null(mkdtemp(folder));
    snprintf(tile_path, sizeof tile_path, "%s/tile.asc", folder);
    snprintf(patch_path, sizeof patch_path, "%s/patch.asc", folder);
    snprintf(level_path, sizeof level_path, "%s/level.asc", folder);
    write_map(tile_path, 1, 0.01);
    write_map(patch_path, 9, 0.01);
    write_map(level_path, 1, 0);
    return 0;
}

static int remove_maps(void **state)
{
    (void)state;
    remove(tile_path);
    remove(patch_path);
    remove(level_path);
    return rmdir(folder);
}

/* Writes a scene that absorbs strongly, so that light dies long before a patch of 2.16 cm ends. Two
 * boundaries have the map. */
static void scene_of(const char *path, const char *option, char *text, size_t size)
{
    snprintf(text, size,
             "1.0\n1\ntile A\n1000\n0.01 0.01\n10 10 1\nbeam disk 0.3 angle=50 azimuth=20\n2\n1\nm \"%s\" "
             "units=cm %s\n1.4 10 100 0.8 0.05\nm \"%s\" units=cm %s\n1.5 20 200 0.8 1\n1\n",
             path, option, path, option);
}

/* Compares tile and patch. Heights of the tile count as they are, and the rim of the patch is led to its
 * mean: they differ only outside. */
static void expect_the_patch(const char *engine, uint64_t photons, uint64_t allowed)
{
    char tile[1024], patch[1024];
    struct flight a, b;
    const struct flight_options with = {.engine = engine, .kind = CML_SURFACE_AUTO};
    scene_of(tile_path, "tile", tile, sizeof tile);
    scene_of(patch_path, "", patch, sizeof patch);
    flight_open(tile, &with, &a);
    flight_open(patch, &with, &b);
    const uint64_t different = count_different(&a, &b, photons);
    print_message("%s: %llu of %llu packets differ\n", engine, (unsigned long long)different,
                  (unsigned long long)photons);
    assert_true(different <= allowed);
    flight_close(&a);
    flight_close(&b);
}

static void a_tile_is_a_patch_without_a_rim(void **state)
{
    (void)state;
    expect_the_patch("reference", 3000, 0);
    expect_the_patch("cpu", 20000, 2);
}

/* Compares the engines. One packet in 1e4 may end differently, because rounding moves it across an edge. */
static void the_engines_agree(void **state)
{
    (void)state;
    char text[1024];
    struct flight a, b;
    const uint64_t photons = 20000;
    const struct flight_options cpu = {.engine = "cpu", .kind = CML_SURFACE_AUTO},
                                reference = {.engine = "reference", .kind = CML_SURFACE_AUTO};
    scene_of(tile_path, "tile", text, sizeof text);
    flight_open(text, &cpu, &a);
    flight_open(text, &reference, &b);
    uint64_t different = 0;
    for (uint64_t i = 0; i < photons; i++) different += fly(&a, i).fate != fly(&b, i).fate;
    print_message("%llu of %llu fates differ\n", (unsigned long long)different, (unsigned long long)photons);
    assert_true(different <= photons / 10000);
    flight_close(&a);
    flight_close(&b);
}

static void a_level_tile_is_a_plane(void **state)
{
    (void)state;
    char text[1024];
    struct flight flight;
    const struct flight_options with = {.engine = "cpu", .kind = CML_SURFACE_AUTO};
    scene_of(level_path, "tile", text, sizeof text);
    flight_open(text, &with, &flight);
    for (int b = 0; b < 2; b++) {
        assert_int_equal(flight.surfaces.item[b].kind, CML_SURFACE_PLANE);
        assert_true(flight.surfaces.item[b].depth == flight.list.scenes[0].boundaries[b].z);
    }
    flight_close(&flight);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tile_is_a_patch_without_a_rim),
        cmocka_unit_test(the_engines_agree),
        cmocka_unit_test(a_level_tile_is_a_plane),
    };
    return cmocka_run_group_tests(tests, write_maps, remove_maps);
}
