/* Tests of scene files (.mci) that the reader accepts. SPDX-License-Identifier: MIT */
#include "lib/mci_case.h"

#include <math.h>

#define HEAD "1.0\n1\n"
#define RUN "a.mco A\n100\n0.1 0.2\n3 4 5\n"

static void original_template_is_read(void **state)
{
    struct cml_scene_list list;
    case_read_ok(state,
                 "####\n# Template of the input file\n####\n"
                 "1.0\t\t\t\t\t\t# file version\n1\t\t\t# number of runs\n\n### S4\n"
                 "S4.mco\tA\t\t# output filename, ASCII/Binary\n1000000\t\t\t# No. of photons\n"
                 "0.01\t0.02\t\t# dz, dr\n40\t50\t1\t\t# No. of dz, dr & da.\n\n3\t\t\t# No. of layers\n"
                 "# n\tmua\tmus\tg\td\n1\t\t\t# n for medium above.\n"
                 "1.37\t1\t100\t0.9\t0.1\t# layer 1\n1.36\t1\t10\t0\t0.1\t# layer 2\n"
                 "1.35\t2\t10\t0.7\t0.2\t# layer 3\n1.2\t\t\t# n for medium below.\n",
                 &list);
    assert_int_equal(list.count, 1);
    const struct cml_scene *scene = &list.scenes[0];
    assert_string_equal(scene->output, "S4.mco");
    assert_int_equal(scene->format, 'A');
    assert_int_equal(scene->line, 8);
    assert_int_equal(scene->photons, 1000000);
    assert_true(scene->dz == 0.01 && scene->dr == 0.02);
    assert_true(scene->nz == 40 && scene->nr == 50 && scene->na == 1);
    assert_int_equal(scene->num_layers, 3);
    assert_true(scene->media[0].n == 1 && scene->media[4].n == 1.2 && scene->media[4].d == 0);
    assert_true(scene->media[3].n == 1.35 && scene->media[3].mua == 2 && scene->media[3].mus == 10);
    assert_true(scene->media[3].g == 0.7 && scene->media[3].d == 0.2);
    assert_true(scene->boundaries[0].z == 0 && scene->boundaries[1].z == 0.1);
    assert_true(scene->boundaries[3].z == 0.1 + 0.1 + 0.2);
    assert_int_equal(scene->boundaries[3].form, CML_FORM_PLANE);
    assert_int_equal(scene->boundaries[3].line, 0);
    assert_false(scene->beams[0].given);
    cml_scene_list_clear(&list);
    assert_null(list.scenes);
}

static void heightfields_become_radii_and_heights(void **state)
{
    struct cml_scene_list list;
    case_read_ok(state,
                 HEAD RUN "2\n1\n\n# top\nb 3 0.1 0.5 -0.2 0.25 0.3 0 a comment 7\n\n"
                          "1.4 1 2 0.9 1\n1.4 1 2 0.9 2\n  #@ b 1 0.5 -1 # bottom\n\n1\n",
                 &list);
    const struct cml_boundary *b = list.scenes[0].boundaries;
    assert_int_equal(b[0].form, CML_FORM_RADIAL);
    assert_int_equal(b[0].radial.n, 3);
    assert_true(b[0].radial.r[0] == 0 && b[0].radial.r[1] == 0.5 && b[0].radial.r[2] == 0.75);
    assert_true(b[0].radial.h[0] == 0.1 && b[0].radial.h[1] == -0.2 && b[0].radial.h[2] == 0.3);
    assert_int_equal(b[0].line, 11);
    assert_null(b[0].file);
    assert_int_equal(b[1].form, CML_FORM_PLANE);
    assert_int_equal(b[2].form, CML_FORM_RADIAL);
    assert_int_equal(b[2].radial.n, 1);
    assert_true(b[2].z == 3);
    assert_int_equal(b[2].line, 15);
    cml_scene_list_clear(&list);
}

static void radial_height_is_linear_between_samples(void **state)
{
    (void)state;
    double r[] = {0, 0.5, 0.75, 2}, h[] = {1, -1, 3, 7};
    const struct cml_radial radial = {4, r, h};
    const struct cml_radial single = {1, r, h};
    for (int i = 0; i < 4; i++) assert_true(cml_radial_height(&radial, r[i]) == h[i]);
    assert_true(cml_radial_height(&radial, 0.25) == 0);
    assert_true(cml_radial_height(&radial, 0.625) == 1);
    assert_true(cml_radial_height(&radial, 1.375) == 5);
    assert_true(cml_radial_height(&radial, nextafter(2, 0)) < 7);
    assert_true(cml_radial_height(&radial, 1e9) == 7);
    assert_true(cml_radial_height(&single, 0) == 1 && cml_radial_height(&single, 5) == 1);
}

static void heights_come_from_a_file_beside(void **state)
{
    struct cml_scene_list list;
    char path[256];
    case_path(state, "h 1.txt", path);
    case_write(state, "h 1.txt", "# measured\r\n2 # samples\r\n\r\n0.1\r\n0.5 0.2#end\r\n\t9\r\n# eof");
    case_read_ok(state, HEAD RUN "1\n1\n#@ b \"h 1.txt\" # top\n1.4 1 2 0.9 1\n1\n", &list);
    const struct cml_boundary *b = list.scenes[0].boundaries;
    assert_int_equal(b->form, CML_FORM_RADIAL);
    assert_int_equal(b->radial.n, 2);
    assert_true(b->radial.r[1] == 0.5 && b->radial.h[0] == 0.1 && b->radial.h[1] == 0.2);
    assert_string_equal(b->file, path);
    cml_scene_list_clear(&list);
    case_remove(state, "h 1.txt");
}

/* A mesh: a pyramid with its tip 1 unit above a square border. */
static const char pyramid[] = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 0 0 1\n"
                              "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";

static void mesh_options_are_applied(void **state)
{
    struct cml_scene_list list;
    case_write(state, "skin#1.obj", pyramid);
    case_read_ok(state,
                 HEAD RUN "1\n1\n1.4 1 2 0.9 1\n"
                          "m \"skin#1.obj\" units=mm scale=2 shift=1,-2,3e0 up=-z normals=vertex # skin\n1\n",
                 &list);
    const struct cml_boundary *b = &list.scenes[0].boundaries[1];
    assert_int_equal(b->form, CML_FORM_MESH);
    assert_int_equal(b->mesh.num_triangles, 4);
    assert_int_equal(b->mesh.normals, CML_NORMALS_VERTEX);
    assert_non_null(strstr(b->file, "skin#1.obj"));
    assert_int_equal(b->line, 10);
    cml_scene_list_clear(&list);
    case_remove(state, "skin#1.obj");
}

/* A mesh with its tip at (3, 0, 1) of the file, x up, turned by 180 degrees. Its border spans 0.4 in
 * height, so it gets a skirt. */
static void a_mesh_is_turned_and_gets_a_skirt(void **state)
{
    struct cml_scene_list list;
    case_write(state, "skin.obj",
               "v 0 -1 -1\nv 0 -1 1\nv 0.4 1 1\nv 0.4 1 -1\nv 3 0 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n");
    case_read_ok(state, HEAD RUN "1\n1\n1.4 1 2 0.9 1\nm \"skin.obj\" skirt=0.5 rotate=180 up=x # skin\n1\n",
                 &list);
    const struct cml_mesh *mesh = &list.scenes[0].boundaries[1].mesh;
    assert_int_equal(mesh->num_triangles, 12);
    assert_int_equal(list.scenes[0].boundaries[1].mesh_notes.skirt, 8);
    assert_true(mesh->vertex[4][0] == 1 && mesh->vertex[4][1] == 0 && mesh->vertex[4][2] == -3);
    assert_true(fabs(mesh->lower[0] + 1.5) < 1e-15 && fabs(mesh->upper[1] - 1.5) < 1e-15);
    assert_true(fabs(mesh->z_border + 0.2) < 1e-15);
    cml_scene_list_clear(&list);
    case_remove(state, "skin.obj");
}

static void flat_boundaries_keep_their_place_and_lose_their_shape(void **state)
{
    static const char text[] = HEAD RUN "2\n1\nb 2 0.1 0.5 -0.2 1\n1.4 1 2 0.9 3\n1.4 1 2 0.9 8\n"
                                        "m \"skin.obj\"\n1\n";
    const struct cml_input_options flat = {.flat = true};
    struct cml_scene_list list;
    struct cml_error err;
    case_write(state, "skin.obj", pyramid);
    case_read_ok_with(state, text, &flat, &list);
    const struct cml_boundary *b = list.scenes[0].boundaries;
    assert_int_equal(b[0].form, CML_FORM_PLANE);
    assert_null(b[0].radial.r);
    assert_int_equal(b[0].line, 9);
    assert_int_equal(b[2].form, CML_FORM_PLANE);
    assert_null(b[2].mesh.vertex);
    assert_true(b[2].z == 11);
    assert_non_null(b[2].file);
    cml_scene_list_clear(&list);
    case_remove(state, "skin.obj");
    assert_int_equal(case_read_with(state, text, &flat, &list, &err),
                     CML_E_INPUT); /* the mesh is read even if boundaries are flat */
}

/* A repeated heightmap of 3 columns and 2 rows has that period. The period of a mirrored one is 2 (n - 1)
 * for n columns or rows. */
static void heightmaps_are_repeated(void **state)
{
    static const char text[] = HEAD RUN "1\n1\nm \"map.asc\" units=cm shift=1,0,2 tile\n1.4 1 2 0.9 9\n1\n";
    static const char mirrored[] = HEAD RUN "1\n1\nm \"map.asc\" tile=mirror units=cm\n1.4 1 2 0.9 9\n1\n";
    static const char as_is[] = HEAD RUN "1\n1\nm \"map.asc\" tile=as-is units=cm\n1.4 1 2 0.9 9\n1\n";
    struct cml_scene_list list;
    struct cml_error err;
    case_write(state, "map.asc", "ncols 3 nrows 2 cellsize 1\n0 2 1\n0 1 2\n");
    case_read_ok(state, text, &list);
    const struct cml_boundary *b = list.scenes[0].boundaries;
    assert_int_equal(b->form, CML_FORM_TILE);
    assert_true(cml_tile_period(&b->tile, 0) == 3 && cml_tile_period(&b->tile, 1) == 2);
    assert_true(b->tile.x0 == 0 && b->tile.y0 == -0.5);
    assert_true(cml_tile_height(&b->tile, 4, 0) == 3 && cml_tile_height(&b->tile, -1, -1) == 3);
    assert_true(b->tile_notes.seam[0] == 2 && b->tile_notes.inside[0] == 2);
    cml_scene_list_clear(&list);
    case_read_ok(state, mirrored, &list);
    b = list.scenes[0].boundaries;
    assert_true(cml_tile_period(&b->tile, 0) == 4 && cml_tile_period(&b->tile, 1) == 2);
    cml_scene_list_clear(&list);
    case_write(state, "map.asc", "ncols 4 nrows 2 cellsize 1\n0 2 4 6\n0 1 2 3\n");
    case_read_ok(state, text, &list); /* the step at the seam is three times those inside */
    cml_scene_list_clear(&list);
    case_write(state, "map.asc", "ncols 5 nrows 2 cellsize 1\n0 2 4 6 8\n0 1 2 3 2\n");
    assert_int_equal(case_read(state, text, &list, &err), CML_E_INPUT);
    assert_string_equal(
        err.text,
        "x.mci:9: boundary 0: tile = a step of 8 cm across the seam along x, 2 cm inside (expected at most "
        "three times the largest step inside; tile=mirror repeats any map, tile=as-is this one)");
    case_read_ok(state, as_is, &list);
    assert_true(cml_tile_period(&list.scenes[0].boundaries->tile, 0) == 5);
    cml_scene_list_clear(&list);
    case_read_ok(state, mirrored, &list);
    cml_scene_list_clear(&list);
    case_remove(state, "map.asc");
}

/* A shallow bump of 0.05 on a ramp from 0 to 4 is flat within a tenth of the ramp, but not exactly. */
static void heightmaps_are_meshed_at_the_tolerance(void **state)
{
    static const char text[] = HEAD RUN "1\n1\nm \"map.asc\" units=cm\n1.4 1 2 0.9 9\n1\n";
    const struct cml_input_options coarse = {.tolerance = 0.1};
    struct cml_scene_list list;
    case_write(state, "map.asc",
               "ncols 5 nrows 5 cellsize 1\n0 1 2 3 4\n0 1 2 3 4\n0 1 2.05 3 4\n"
               "0 1 2 3 4\n0 1 2 3 4\n");
    case_read_ok(state, text, &list);
    const struct cml_boundary *b = list.scenes[0].boundaries;
    assert_int_equal(b->form, CML_FORM_MESH);
    assert_true(b->map_notes.tolerance == 0 && b->map_notes.height_error == 0);
    const size_t exact = b->map_notes.triangles;
    cml_scene_list_clear(&list);
    case_read_ok_with(state, text, &coarse, &list);
    b = list.scenes[0].boundaries;
    assert_true(fabs(b->map_notes.height_error - 0.05) < 1e-12 && b->map_notes.triangles < exact);
    assert_true(fabs(b->map_notes.tolerance - 0.4) < 1e-12);
    cml_scene_list_clear(&list);
    case_remove(state, "map.asc");
}

static void beams_are_read_anywhere_before_the_layers(void **state)
{
    const double rad = acos(-1.0) / 180;
    struct cml_scene_list list;
    case_read_ok(
        state,
        "1\n3\n"
        "a A\n#@ beam disk 0.5 at=1,-2 angle=30 azimuth=-90 # oblique\n1\n1 1\n1 1 1\n1\n1\n1 1 1 0 1\n1\n"
        "b A\n1\n1 1\n1 1 1\nbeam gaussian 1e-3\n1\n1\n1 1 1 0 1\n1\n"
        "c A\n1\n1 1\nbeam pencil angle=89.999\n1 1 1\n1\n1\n1 1 1 0 1\n1\n",
        &list);
    const struct cml_beam *a = list.scenes[0].beams, *b = list.scenes[1].beams, *c = list.scenes[2].beams;
    assert_true(a->given && a->shape == CML_BEAM_DISK && a->size[0] == 0.5 && a->x == 1 && a->y == -2);
    assert_true(fabs(a->angle - 30 * rad) < 1e-15 && fabs(a->azimuth + 90 * rad) < 1e-15);
    assert_true(b->shape == CML_BEAM_GAUSSIAN && b->size[0] == 1e-3 && b->x == 0 && b->angle == 0);
    assert_true(c->shape == CML_BEAM_PENCIL && c->size[0] == 0 && c->angle < 90 * rad);
    cml_scene_list_clear(&list);
}

/* The reader accepts text on which original MCML fails: a blank line with CRLF (read as data), a micro
 * sign (a crash), a line over 254 bytes (split). */
static void careless_text_is_read(void **state)
{
    char text[2048];
    struct cml_scene_list list;
    snprintf(text, sizeof text,
             "\xEF\xBB\xBF# \xC2\xB5m\r\n#@@@@@@\r\n#@\r\n1.0 any text\r\n\r\n 1 run only\r\n"
             "\"my out\" b binary\r\n1e7 photons\r\n \t\r\n# a note\r\n0.1 0.2# \xC2\xB5 %0400d\r\n"
             "2e0 3 4 bins\r\n1 layer\r\n1.0#above\r\n1.4 0 0 -1 1e8 glass, 1 %0400d\r\n1. below",
             0, 0);
    case_read_ok(state, text, &list);
    const struct cml_scene *scene = &list.scenes[0];
    assert_string_equal(scene->output, "my out");
    assert_int_equal(scene->format, 'B');
    assert_int_equal(scene->photons, 10000000);
    assert_true(scene->nz == 2 && scene->media[1].g == -1 && scene->media[1].d == 1e8);
    assert_true(scene->media[1].mua == 0 && scene->media[0].n == 1 && scene->media[2].n == 1);
    cml_scene_list_clear(&list);
}

static void lines_are_kept_as_written(void **state)
{
    struct cml_scene_list list;
    case_read_ok(state, HEAD "# note\n" RUN "1\r\n# note\n1 # above\n#@  b 1 0 0\n 1.4\t1 2 0.9 1\n\n1\n",
                 &list);
    assert_string_equal(list.scenes[0].text, "a.mco A\n100\n0.1 0.2\n3 4 5\n1\n1 # above\n#@  b 1 0 0\n"
                                             " 1.4\t1 2 0.9 1\n1");
    cml_scene_list_clear(&list);
}

static void several_runs_are_read_and_the_rest_ignored(void **state)
{
    struct cml_scene_list list;
    case_read_ok(state,
                 "1\n2\nb B\n281474976710656\n1 1\n1 1 1\n1\n1\n1 1 1 0 1\nb 1 0 0\n1\n"
                 "m a\n1\n1 1\n1 1 1\n1\n1\nb 2 0 1 1 1\n1 1 1 0 0\n1\n"
                 "run3 A\nb 1 switched off\n",
                 &list);
    assert_int_equal(list.count, 2);
    assert_true(list.scenes[0].photons == (uint64_t)1 << 48);
    assert_string_equal(list.scenes[0].output, "b");
    assert_string_equal(list.scenes[1].output, "m");
    assert_int_equal(list.scenes[1].line, 12);
    assert_int_equal(list.scenes[0].boundaries[1].form, CML_FORM_RADIAL);
    assert_int_equal(list.scenes[1].boundaries[0].form, CML_FORM_RADIAL);
    cml_scene_list_clear(&list);
    case_read_ok(state, "1\n1\nx A\n1\n1 1\n1 1 1\n1\n1\n1 1 1 0 1\n1\nbeam A\n",
                 &list); /* a run named `beam` */
    assert_int_equal(list.count, 1);
    cml_scene_list_clear(&list);
}

static void many_runs_of_many_layers(void **state)
{
    enum { RUNS = 33, LAYERS = 50 };
    static char text[RUNS * (LAYERS + 8) * 16];
    struct cml_scene_list list;
    int size = sprintf(text, "1\n%d\n", RUNS);
    for (int run = 0; run < RUNS; run++) {
        size += sprintf(text + size, "r%d A\n%d\n1 1\n1 1 1\n%d\n1\n", run, run + 1, LAYERS);
        for (int i = 0; i < LAYERS; i++) size += sprintf(text + size, "1 1 1 0 0.5\n");
        size += sprintf(text + size, "1\n");
    }
    case_read_ok(state, text, &list);
    assert_int_equal(list.count, RUNS);
    for (int run = 0; run < RUNS; run++) {
        assert_int_equal(list.scenes[run].photons, run + 1);
        assert_true(list.scenes[run].boundaries[LAYERS].z == 0.5 * LAYERS);
    }
    cml_scene_list_clear(&list);
}

static void maps_are_read_anywhere_before_the_layers(void **state)
{
    struct cml_scene_list list;
    struct cml_error err;
    const char *text =
        "1.0\n3\n"
        "a A\n#@ map 20 10 0.1 2e-3 # pixels\n1\n1 1\n2 2 2\ntime 2e3 50 # ps\nfluence time # rate\n1\n1\n1 "
        "1 1 0 1\n1\n"
        "b A\n1\n#@ facets\n1 1\nmap 1e3 1 1 1 volume top=-0.5 angles\n#@ directions 18 36\ndetector disk "
        "0.1\n#@ detector map 4 3 0.1 0.2 at=1,2 z=-0.5 side=bottom na=0.2 "
        "angle=90 azimuth=-90 diffuse name=c\ndetector ring 0 2 side=bottom\n2 2 2\n1\n1\n1 1 "
        "1 0 1\n1\n"
        "map A\n1\n1 1\n1 1 1\n1\n1\n1 1 1 0 1\n1\n";
    assert_int_equal(case_read(state, text, &list, &err), CML_OK);
    const struct cml_map_def *a = &list.scenes[0].map, *b = &list.scenes[1].map;
    assert_int_equal(a->nx, 20);
    assert_int_equal(a->ny, 10);
    assert_true(a->dx == 0.1 && a->dy == 2e-3 && a->top == 0);
    assert_false(a->angles || a->volume || list.scenes[0].facets);
    assert_int_equal(b->nx, 1000);
    assert_true(b->top == -0.5);
    assert_true(b->angles && b->volume && list.scenes[1].facets);
    assert_int_equal(list.scenes[0].time.gates, 50);
    assert_true(list.scenes[0].time.end == 2000);
    assert_int_equal(list.scenes[1].time.gates, 0);
    assert_true(list.scenes[0].fluence.times && list.scenes[0].fluence.line > 0 &&
                list.scenes[1].fluence.line == 0);
    assert_int_equal(list.scenes[0].directions.nt, 0);
    assert_int_equal(list.scenes[1].directions.nt, 18);
    assert_int_equal(list.scenes[1].directions.np, 36);
    const struct cml_detector_def *d = list.scenes[1].detectors;
    assert_int_equal(list.scenes[1].num_detectors, 3);
    assert_string_equal(d[0].name, "1");
    assert_true(d[0].shape == CML_DETECTOR_RING && d[0].size[0] == 0 && d[0].size[1] == 0.1 && d[0].nx == 1);
    assert_true(d[0].z == 0 && !d[0].below && !d[0].aimed && !d[0].diffuse);
    assert_string_equal(d[1].name, "c");
    assert_true(d[1].shape == CML_DETECTOR_MAP && d[1].nx == 4 && d[1].ny == 3 && d[1].size[1] == 0.2);
    assert_true(d[1].x == 1 && d[1].y == 2 && d[1].z == -0.5 && d[1].below && d[1].aimed && d[1].diffuse);
    assert_true(fabs(d[1].angle - 1.5707963267948966) < 1e-15 && d[1].azimuth < -1.57 && d[1].na == 0.2);
    assert_true(d[2].z == 1 && d[2].below);
    assert_int_equal(list.scenes[2].num_detectors, 0);
    assert_int_equal(list.scenes[2].map.nx, 0);
    assert_string_equal(list.scenes[2].output, "map");
    cml_scene_list_clear(&list);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(original_template_is_read),
        cmocka_unit_test(heightfields_become_radii_and_heights),
        cmocka_unit_test(radial_height_is_linear_between_samples),
        cmocka_unit_test(heights_come_from_a_file_beside),
        cmocka_unit_test(mesh_options_are_applied),
        cmocka_unit_test(a_mesh_is_turned_and_gets_a_skirt),
        cmocka_unit_test(flat_boundaries_keep_their_place_and_lose_their_shape),
        cmocka_unit_test(heightmaps_are_repeated),
        cmocka_unit_test(heightmaps_are_meshed_at_the_tolerance),
        cmocka_unit_test(beams_are_read_anywhere_before_the_layers),
        cmocka_unit_test(maps_are_read_anywhere_before_the_layers),
        cmocka_unit_test(careless_text_is_read),
        cmocka_unit_test(lines_are_kept_as_written),
        cmocka_unit_test(several_runs_are_read_and_the_rest_ignored),
        cmocka_unit_test(many_runs_of_many_layers),
    };
    return cmocka_run_group_tests_name("mci", tests, case_setup, case_teardown);
}
