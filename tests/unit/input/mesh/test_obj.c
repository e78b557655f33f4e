/* Tests of the OBJ reader and writer: all forms of a mesh in the format, every refusal with its message,
 * and writing followed by reading. SPDX-License-Identifier: MIT */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "input/mesh/mesh_file.h"
#include "input/mesh/obj.h"
#include "input/mesh/polygon_split.h"
#include "base/text.h"

static const struct cml_mesh_file_options centimetres = {.unit = 1, .scale = 1, .height = 1};

static int setup(void **state)
{
    char *directory = strdup("/tmp/cml_obj_XXXXXX");
    *state = directory;
    return directory && mkdtemp(directory) ? 0 : -1;
}

static int teardown(void **state)
{
    const int failed = rmdir(*state); /* fails if a test left a file behind */
    free(*state);
    return failed;
}

static cml_status read_text(void **state, const char *text, const struct cml_mesh_file_options *options,
                            struct cml_mesh *mesh, struct cml_mesh_notes *notes, struct cml_error *err)
{
    char path[128];
    snprintf(path, sizeof path, "%s/m.obj", (const char *)*state);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
    *err = (struct cml_error){0};
    const cml_status status = cml_mesh_file_read(NULL, path, options, mesh, notes, err);
    remove(path);
    char *name = strstr(err->text, path);
    if (name) memmove(name, name + strlen(path) - 5, strlen(name + strlen(path) - 5) + 1);
    return status;
}

static void read_good(void **state, const char *text, struct cml_mesh *mesh, struct cml_mesh_notes *notes)
{
    struct cml_error err;
    const cml_status status = read_text(state, text, &centimetres, mesh, notes, &err);
    assert_string_equal(err.text, "");
    assert_int_equal(status, CML_OK);
}

#define SQUARE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
#define PYRAMID SQUARE "v .5 .5 1\n"
#define PYRAMID_FACES "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"

struct refusal {
    const char *text, *message;
};

static const struct refusal bad_texts[] = {
    {"", "m.obj: no faces (expected lines like `f 1 2 3`)"},
    {SQUARE, "m.obj: no faces (expected lines like `f 1 2 3`)"},
    {"v nan 1 0\n", "m.obj:1: x of the vertex = nan (expected a finite number)"},
    {"v 0 1 0\nv 1 -inf 0\n", "m.obj:2: y of the vertex = -inf (expected a finite number)"},
    {"v 0,0 1 0\n", "m.obj:1: x of the vertex = 0,0 (expected a finite number, with a decimal point)"},
    {"v 1 2 0x10\n", "m.obj:1: z of the vertex = 0x10 (expected a finite number)"},
    {"v 1 2 1e999\n", "m.obj:1: z of the vertex = 1e999 (expected a finite number)"},
    {"v \"1\" 2 3\n", "m.obj:1: x of the vertex = \"1\" (expected a finite number)"},
    {"# two\nv 1 2\n", "m.obj:2: z of the vertex is missing (expected a finite number)"},
    {"v\n", "m.obj:1: x of the vertex is missing (expected a finite number)"},
    {"v 1 2 3 red\n", "m.obj:1: weight or colour of the vertex = red (expected a finite number)"},
    {"# a\rv 1 2 3\rf 1 2 3\r",
     "m.obj:1: a carriage return inside the line (expected line ends LF or CR LF)"},
    {SQUARE "f 1 2 0\n", "m.obj:5: corner of the face = 0 (expected a vertex number from 1 on)"},
    {SQUARE "f 1 2 5\n", "m.obj:5: corner of the face = 5 (expected 1 to 4)"},
    {SQUARE "f 1 2 -5\n", "m.obj:5: corner of the face = -5 (only 4 vertices stand before it)"},
    {SQUARE "f 1 2 x\n",
     "m.obj:5: corner of the face = x (expected a vertex number, as in 3, 3/1, 3//2 or 3/1/2)"},
    {SQUARE "f 1 2 3.5\n",
     "m.obj:5: corner of the face = 3.5 (expected a vertex number, as in 3, 3/1, 3//2 or 3/1/2)"},
    {SQUARE "f 1 2 3/1/1/1\n",
     "m.obj:5: corner of the face = 3/1/1/1 (expected a vertex number, as in 3, 3/1, 3//2 or 3/1/2)"},
    {SQUARE "f 1 2 3/\n",
     "m.obj:5: corner of the face = 3/ (expected a vertex number, as in 3, 3/1, 3//2 or 3/1/2)"},
    {SQUARE "f 1 2 99999999999\n",
     "m.obj:5: corner of the face = 99999999999 (expected a vertex number, as in 3, 3/1, 3//2 or 3/1/2)"},
    {SQUARE "f 1 2\n", "m.obj:5: the face has 2 corners (expected 3 or more)"},
    {SQUARE "f\n", "m.obj:5: the face has 0 corners (expected 3 or more)"},
    {SQUARE "f 1 2 2\n", "m.obj: every face of the mesh has zero area"},
    {SQUARE "v 2 0 0\nf 1 2 5\n", "m.obj: every face of the mesh has zero area"},
    {SQUARE "v .9 .5 0\nf 1 2 5 3 4\n", "m.obj:6: the face is not convex (expected a triangle or a "
                                        "convex polygon; triangulate it when exporting)"},
    {SQUARE "f 1 3 2 4\n", "m.obj:5: the face has no area (expected a triangle or a convex polygon; "
                           "triangulate it when exporting)"},
};

static const struct refusal bad_sheets[] = {
    {PYRAMID PYRAMID_FACES "f 1 3 2\nf 1 4 3\n",
     "m.obj: the mesh is a closed body (expected an open sheet with "
     "its border on one horizontal plane; a body inside a layer has a line i)"},
    {PYRAMID "f 1 2 5\nf 2 3 5\nf 3 4 5\n", "m.obj:8: the border is not horizontal: its height spans 1 cm, "
                                            "the highest point is (0.5, 0.5, height 1) "
                                            "cm (expected a border on one horizontal plane, or skirt=WIDTH)"},
    {SQUARE "v 0 2 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\nf 2 1 5\n",
     "m.obj:9: the edge from (0, 0, height 0) cm to (1, 0, height 0) cm belongs to 3 faces (expected 1 or 2: "
     "a "
     "sheet)"},
    {SQUARE "v 5 5 0\nv 6 5 0\nv 5 6 0\nf 1 2 3 4\nf 5 6 7\n",
     "m.obj:9: the mesh falls into 2 separate parts, the second from (5, 5, height 0) cm on (expected one "
     "connected sheet); its corners are 5.66 cm or more from those of others, too far for weld="},
    {SQUARE "v 2 1 0\nv 1 2 0\nf 1 2 3\nf 3 5 6\n",
     "m.obj:8: the mesh falls into 2 separate parts, the second from (1, 1, height 0) cm on (expected one "
     "connected sheet)"},
    /* a ring of four squares around a square hole */
    {SQUARE "v -1 -1 0\nv 2 -1 0\nv 2 2 0\nv -1 2 0\nf 5 6 2 1\nf 6 7 3 2\nf 7 8 4 3\nf 8 5 1 4\n",
     "m.obj:9: the mesh has a hole of 4 edges around (0.5, 0.5, height 0) cm (expected none besides its "
     "border: "
     "fill holes in a mesh editor)"},
    /* the same ring with a smaller hole in its lowest square: the largest is named */
    {SQUARE "v -1 -1 0\nv 2 -1 0\nv 2 2 0\nv -1 2 0\nf 6 7 3 2\nf 7 8 4 3\nf 8 5 1 4\n"
            "v .2 -.5 0\nv .8 -.5 0\nv .2 -.7 0\nv .8 -.7 0\nv .5 -.8 0\n"
            "f 5 1 9\nf 1 10 9\nf 1 2 10\nf 2 6 12 10\nf 6 13 12\nf 6 5 13\nf 5 11 13\nf 5 9 11\nf 9 10 11\n",
     "m.obj:19: the mesh has a hole of 4 edges around (0.5, 0.5, height 0) cm and 1 other (expected none "
     "besides "
     "its border: fill holes in a mesh editor)"},
    /* without the sliver 1 3 5 of zero area the two halves are not joined */
    {SQUARE "v 0.5 0.5 0\nf 1 2 3\nf 1 3 5\nf 5 3 4\nf 5 4 1\n",
     "m.obj:8: the mesh falls into 2 separate parts, the second from (0.5, 0.5, height 0) cm on (expected "
     "one "
     "connected sheet); 1 faces of zero area were dropped"},
    /* five triangles of a strip closed with a half turn */
    {"v 0 0 0\nv 1 0 0\nv 2 1 1\nv 1 2 0\nv 0 2 2\nf 1 2 3\nf 2 3 4\nf 3 4 5\nf 4 5 1\nf 5 1 2\n",
     "m.obj:8: the mesh has only one side, like a Moebius strip: it closes wrongly at (0, 2, height 2) cm "
     "(expected an orientable sheet)"},
    /* two triangles of a fan lie beyond the first edge: the border crosses over itself */
    {"v 0 0 0\nv 1 0 0\nv 1 1 0\nv .5 -.5 0\nf 1 2 3\nf 1 3 4\n",
     "m.obj:5: the border meets itself on the edge that begins at (1, 0, height 0) cm (expected a simple "
     "polygon "
     "seen from above)"},
    /* six triangles from (0, 0) over (1, 1) and back: the two ends touch in the vertex (1, 1) only */
    {"v 1 1 0\nv 0 0 0\nv 2 0 0\nv 1 -1 1\nv 0 2 0\nv 2 2 0\nv 1 3 1\nv 4 1 0\nf 1 2 3\nf 2 4 3\nf 3 4 8\n"
     "f 1 5 6\nf 5 7 6\nf 6 7 8\nf 4 7 8\n",
     "m.obj:12: the mesh touches itself at the vertex (1, 1, height 0) cm (expected one fan of faces around "
     "every vertex)"},
    {"v 0 0 0\nv 1e300 0 0\nv 1 1 0\nv 1e308 1e308 1e308\nf 1 2 3\n",
     "m.obj:2: vertex 2 is too large (expected coordinates up to 1e+30 cm)"},
    /* products overflow at this size, and vertex order once decided if the border was simple */
    {"v 0 0 0\nv 1e31 0 0\nv 1e302 1e31 0\nv 0 1 0\nf 1 3 4\nf 2 3 4\n",
     "m.obj:2: vertex 2 is too large (expected coordinates up to 1e+30 cm)"},
};

static void refuse(void **state, const struct refusal *cases, size_t count, double unit)
{
    const struct cml_mesh_file_options options = {.unit = unit, .scale = 1, .height = 1};
    for (size_t i = 0; i < count; i++) {
        struct cml_mesh mesh;
        struct cml_error err;
        assert_int_equal(read_text(state, cases[i].text, &options, &mesh, NULL, &err), CML_E_INPUT);
        assert_string_equal(err.text, cases[i].message);
        assert_null(mesh.vertex);
    }
}

static void refuses_bad_texts(void **state)
{
    refuse(state, bad_texts, sizeof bad_texts / sizeof bad_texts[0], 1);
}

static void refuses_bad_sheets(void **state)
{
    const size_t count = sizeof bad_sheets / sizeof bad_sheets[0];
    refuse(state, bad_sheets, count - 1, 1);
    refuse(state, bad_sheets + count - 1, 1, 1e10);
}

static void refuses_missing_file(void **state)
{
    (void)state;
    struct cml_mesh mesh;
    struct cml_error err;
    assert_int_equal(cml_mesh_file_read(NULL, "/nowhere/m.obj", &centimetres, &mesh, NULL, &err),
                     CML_E_INPUT);
    assert_string_equal(err.text,
                        "/nowhere/m.obj: cannot be read: No such file or directory (expected a file)");
}

/* Many ways to write one pyramid give equal meshes. */
static void reads_all_forms(void **state)
{
    static const char *const forms[] = {
        PYRAMID PYRAMID_FACES,
        "# c\r\nv 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\nv .5 .5 1\r\n\r\nf 1 2 5\r\nf 2 3 5\r\nf 3 4 "
        "5\r\n"
        "f 4 1 5",
        PYRAMID "f -5 -4 -1\nf -4 -3 -1\nf -3 -2 -1\nf -2 -5 -1\n",
        PYRAMID "vt 0 0\nvn 0 0 1\nf 1/1 2/1 5/1\nf 2//1 3//1 5//1\nf 3/1/1 4/1/1 5/1/1\nf 4/-1/-1 1 5\n",
        "f 1 2 5\nf 2 3 5\n" PYRAMID "f 3 4 5\nf 4 1 5\n",
        "mtllib a.mtl\no thing\ng part\nusemtl C:\\dir\\\n" PYRAMID "s off\nvp 1 2\nl 1 2\np 1\nvw 0 -1 1\n"
        "t x 1/2/3\nf 1 2 5\nusemtl b\nf 2 3 5\ng other\nf 3 4 5\no last\nf 4 1 5\n",
        ("v 0 0 0 1\nv 1 0 0 .5 .5 .5\nv 1 1 0 # corner\nv\t0\t1\t0\t\nv \\\n.5 .5 \\\r\n1\n"
         "f 1 2 \\\n   5 \nf 2 3 5 # side\n  f\t3 4\t5\v\nf 4 1 5 \\"),
    };
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; i++) {
        struct cml_mesh mesh;
        struct cml_mesh_notes notes;
        read_good(state, forms[i], &mesh, &notes);
        assert_int_equal(mesh.num_vertices, 5);
        assert_int_equal(mesh.num_triangles, 4);
        assert_int_equal(notes.flipped, 0);
        const double tip[3] = {0.5, 0.5, -1};
        const uint32_t first[3] = {0, 4, 1}, last[3] = {3, 4, 0};
        assert_memory_equal(mesh.vertex[4], tip, sizeof tip);
        assert_memory_equal(mesh.triangle[0], first, sizeof first);
        assert_memory_equal(mesh.triangle[3], last, sizeof last);
        cml_mesh_clear(&mesh);
    }
}

static void splits_polygons(void **state)
{
    struct cml_mesh mesh;
    struct cml_mesh_notes notes;
    /* a square whose lower side carries two more vertices, and its neighbour below with as many */
    read_good(state, SQUARE "v .25 0 0\nv .75 0 0\nv .5 -1 -0\nf 1 5 6 2 3 4\nf 7 6 5\nf 5 1 7\nf 7 2 6\n",
              &mesh, &notes);
    assert_int_equal(mesh.num_triangles, 7);
    assert_int_equal(notes.degenerate, 0);
    assert_int_equal(mesh.num_border, 5);
    cml_mesh_clear(&mesh);
    read_good(state,
              "v 0 0 0\nv 1 0 1\nv 1 1 1\nv 0 1 0\nv 2 0 0\nv 2 1 0\nv 0 -1 0\nv 2 -1 0\nv 2 2 0\nv 0 2 0\n"
              "f 1 2 3 4\nf 2 5 6 3\nf 7 8 5\nf 7 5 2\nf 7 2 1\nf 9 10 4\nf 9 4 3\nf 9 3 6\n",
              &mesh, &notes);
    assert_int_equal(mesh.num_triangles, 10);
    cml_mesh_clear(&mesh);
}

static void refuses_odd_polygons(void **state)
{
    (void)state;
    const double star[5][3] = {{0, 1, 0}, {-.6, -.8, 0}, {.95, .3, 0}, {-.95, .3, 0}, {.6, -.8, 0}};
    const double arrow[4][3] = {{0, 0, 0}, {1, -1, 0}, {0, 2, 0}, {-1, -1, 0}};
    const double middles[6][3] = {{0, 0, 1}, {1, 0, 1}, {2, 0, 1}, {1, 1, 1}, {0, 2, 1}, {0, 1, 1}};
    const uint32_t corner[6] = {0, 1, 2, 3, 4, 5};
    uint32_t triangle[4][3];
    double bend = 1;
    assert_string_equal(cml_polygon_split(star, corner, 5, triangle, &bend), "is not convex");
    assert_string_equal(cml_polygon_split(arrow, corner, 4, triangle, &bend), "is not convex");
    assert_null(cml_polygon_split(middles, corner, 6, triangle, &bend));
    const uint32_t expected[4][3] = {{1, 2, 3}, {1, 3, 4}, {1, 4, 5}, {1, 5, 0}};
    assert_memory_equal(triangle, expected, sizeof expected);
    assert_true(bend == 0);
}

/* Bent faces are cut into triangles and counted. The file has three bent quadrilaterals, whose corners lie
 * 0.5 / sqrt(6) off their mean planes, and two triangles. */
static void bent_faces_are_cut_and_counted(void **state)
{
    struct cml_mesh mesh;
    struct cml_mesh_notes notes;
    struct cml_error err;
    const struct cml_mesh_file_options half = {.unit = 0.5, .scale = 1, .height = 1};
    const char *text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\nv 1 0 0\nv 1 2 0\nv 0 1 0\nv 2 1 0\n"
                       "f 1 6 5 8\nf 6 2 9 5\nf 5 9 3 7\nf 4 8 5\nf 4 5 7\n";
    assert_int_equal(read_text(state, text, &half, &mesh, &notes, &err), CML_OK);
    assert_int_equal(mesh.num_triangles, 8);
    assert_int_equal(notes.bent, 3);
    /* corners 0 0 0, 1 0 0, 1 1 1, 0 1 0: normal (-1, -1, 2) / sqrt 6 by Newell, mean (1, 1, 0.5) / 2 */
    assert_true(fabs(notes.bend - 0.5 * 0.5 / sqrt(6)) < 1e-15);
    cml_mesh_clear(&mesh);
}

/* A pyramid over the horizontal triangle 0, x, y, with its tip at (1, 2, 3) in the file. */
static void turns_and_scales(void **state)
{
    const struct {
        enum cml_up_axis up;
        const char *x, *y;
        double tip[3]; /* by hand: twice the file's lengths, z down */
    } cases[] = {{CML_UP_Z, "1 0 0", "0 1 0", {2, 4, -6}},   {CML_UP_MINUS_Z, "1 0 0", "0 -1 0", {2, -4, 6}},
                 {CML_UP_Y, "1 0 0", "0 0 -1", {2, -6, -4}}, {CML_UP_MINUS_Y, "1 0 0", "0 0 1", {2, 6, 4}},
                 {CML_UP_X, "0 0 -1", "0 1 0", {-6, 4, -2}}, {CML_UP_MINUS_X, "0 0 1", "0 1 0", {6, 4, 2}}};
    for (int i = 0; i < 6; i++) {
        struct cml_mesh_file_options options = {
            .unit = 0.5, .scale = 4, .height = 1, .shift = {10, 20, 30}, .up = cases[i].up};
        struct cml_mesh mesh;
        struct cml_mesh_notes notes;
        struct cml_error err;
        char text[256];
        snprintf(text, sizeof text, "v 0 0 0\nv %s\nv %s\nv 1 2 3\nf 1 2 4\nf 2 3 4\nf 3 1 4\n", cases[i].x,
                 cases[i].y);
        options.normals = CML_NORMALS_VERTEX;
        assert_int_equal(read_text(state, text, &options, &mesh, &notes, &err), CML_OK);
        assert_true(mesh.vertex[3][0] == cases[i].tip[0] + 10);
        assert_true(mesh.vertex[3][1] == cases[i].tip[1] + 20);
        assert_true(mesh.vertex[3][2] == cases[i].tip[2] - 30);
        assert_int_equal(mesh.normals, CML_NORMALS_VERTEX);
        assert_true(mesh.z_border == -30);
        assert_int_equal(notes.flipped, 0); /* turning the mesh mirrors no facet */
        cml_mesh_clear(&mesh);
    }
}

/* Rotation comes after the choice of axes, before scale and shift. Quarter turns have no rounding. */
static void rotates_about_the_vertical(void **state)
{
    static const struct {
        double degrees, x, y; /* x, y: image of (1, 2) */
    } turns[] = {{0, 1, 2},   {90, -2, 1},  {-270, -2, 1}, {180, -1, -2},
                 {360, 1, 2}, {-90, 2, -1}, {270, 2, -1}};
    struct cml_mesh_file_options options = {
        .unit = 0.5, .scale = 4, .height = 1, .shift = {10, 20, 30}, .up = CML_UP_Y};
    const char *text = "v 0 0 0\nv 1 0 0\nv 0 0 -1\nv 1 3 -2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    struct cml_mesh mesh;
    struct cml_mesh_notes notes;
    struct cml_error err;
    for (size_t i = 0; i < sizeof turns / sizeof turns[0]; i++) {
        options.rotate = turns[i].degrees;
        assert_int_equal(read_text(state, text, &options, &mesh, &notes, &err), CML_OK);
        assert_true(mesh.vertex[3][0] == 2 * turns[i].x + 10);
        assert_true(mesh.vertex[3][1] == 2 * turns[i].y + 20);
        assert_true(mesh.vertex[3][2] == -36);
        assert_int_equal(notes.flipped, 0);
        cml_mesh_clear(&mesh);
    }
    options.rotate = 150; /* (1, 0) goes to (-sqrt(3) / 2, 1 / 2) */
    assert_int_equal(read_text(state, text, &options, &mesh, &notes, &err), CML_OK);
    assert_true(fabs(mesh.vertex[1][0] - (10 - sqrt(3))) < 1e-14 && fabs(mesh.vertex[1][1] - 21) < 1e-14);
    cml_mesh_clear(&mesh);
}

static void same_mesh(const struct cml_mesh *a, const struct cml_mesh *b)
{
    assert_int_equal(a->num_vertices, b->num_vertices);
    assert_int_equal(a->num_triangles, b->num_triangles);
    assert_int_equal(a->num_border, b->num_border);
    assert_memory_equal(a->vertex, b->vertex, a->num_vertices * sizeof *a->vertex);
    assert_memory_equal(a->triangle, b->triangle, a->num_triangles * sizeof *a->triangle);
    assert_memory_equal(a->border, b->border, a->num_border * sizeof *a->border);
    assert_memory_equal(a->vertex_normal, b->vertex_normal, a->num_vertices * sizeof *a->vertex_normal);
    assert_true(a->z_border == b->z_border);
}

static void round_trip(void **state)
{
    struct cml_mesh mesh, again;
    struct cml_error err;
    const struct cml_mesh_file_options odd = {
        .unit = 0.1, .scale = 1.0 / 3, .height = 1, .shift = {1e-3, 1.0 / 7, 0.2}};
    char path[128];
    snprintf(path, sizeof path, "%s/w.obj", (const char *)*state);
    assert_int_equal(cml_mesh_file_read(NULL, "../meshes/ridges.obj", &odd, &mesh, NULL, &err), CML_OK);
    assert_int_equal(cml_obj_write(path, &mesh, "two\nlines", &err), CML_OK);
    struct cml_mesh_notes notes;
    assert_int_equal(cml_mesh_file_read(NULL, path, &centimetres, &again, &notes, &err), CML_OK);
    same_mesh(&mesh, &again);
    assert_int_equal(notes.welded + notes.degenerate + notes.unused + notes.flipped, 0);
    struct cml_text text;
    assert_int_equal(cml_text_read(NULL, path, &text, &err), CML_OK);
    assert_string_equal(cml_text_next(&text), "# two");
    assert_string_equal(cml_text_next(&text), "# lines");
    cml_text_clear(&text);
    cml_mesh_clear(&mesh);
    cml_mesh_clear(&again);
    remove(path);
}

static void write_reports_failure(void **state)
{
    (void)state;
    const struct cml_mesh mesh = {0};
    struct cml_error err;
    assert_int_equal(cml_obj_write("/nowhere/m.obj", &mesh, NULL, &err), CML_E_IO);
    assert_string_equal(err.text, "/nowhere/m.obj: cannot be written (No such file or directory)");
}

static const char *const samples[] = {"wedge", "ridges", "prism", "pyramid", "overhang", "spikes"};

static void sample_meshes_load(void **state)
{
    (void)state;
    const size_t triangles[] = {14, 5000, 6, 4, 312, 400};
    for (int i = 0; i < 6; i++) {
        char path[64];
        struct cml_mesh mesh;
        struct cml_mesh_notes notes;
        struct cml_error err = {0};
        snprintf(path, sizeof path, "../meshes/%s.obj", samples[i]);
        assert_int_equal(cml_mesh_file_read(NULL, path, &centimetres, &mesh, &notes, &err), CML_OK);
        assert_int_equal(mesh.num_triangles, triangles[i]);
        assert_true(mesh.z_border == 0);
        assert_int_equal(notes.welded + notes.degenerate + notes.unused + notes.flipped, 0);
        cml_mesh_clear(&mesh);
    }
}

static void compare_files(const char *left, const char *right)
{
    struct cml_text a, b;
    struct cml_error err;
    assert_int_equal(cml_text_read_bytes(NULL, left, &a, &err), CML_OK);
    assert_int_equal(cml_text_read_bytes(NULL, right, &b, &err), CML_OK);
    assert_int_equal(a.size, b.size);
    assert_memory_equal(a.data, b.data, a.size);
    cml_text_clear(&a);
    cml_text_clear(&b);
}

static void generator_reproduces_samples(void **state)
{
    if (system("python3 -c '' 2>/dev/null") != 0) skip();
    static const char *const heightmaps[] = {"skin.gsf", "grooves.asc"};
    char command[128], made[128], kept[64];
    snprintf(command, sizeof command, "python3 ../meshes/generate.py %s", (const char *)*state);
    assert_int_equal(system(command), 0);
    for (int i = 0; i < 8; i++) {
        const char *name = i < 6 ? samples[i] : heightmaps[i - 6], *ending = i < 6 ? ".obj" : "";
        snprintf(made, sizeof made, "%s/%s%s", (const char *)*state, name, ending);
        snprintf(kept, sizeof kept, "../meshes/%s%s", name, ending);
        compare_files(made, kept);
        remove(made);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(refuses_bad_texts),
        cmocka_unit_test(refuses_bad_sheets),
        cmocka_unit_test(refuses_missing_file),
        cmocka_unit_test(reads_all_forms),
        cmocka_unit_test(splits_polygons),
        cmocka_unit_test(refuses_odd_polygons),
        cmocka_unit_test(bent_faces_are_cut_and_counted),
        cmocka_unit_test(turns_and_scales),
        cmocka_unit_test(rotates_about_the_vertical),
        cmocka_unit_test(round_trip),
        cmocka_unit_test(write_reports_failure),
        cmocka_unit_test(sample_meshes_load),
        cmocka_unit_test(generator_reproduces_samples),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
