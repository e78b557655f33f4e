/* Tests of the readers of .stl and .ply: binary files with every type of number, every refusal of binary data
 * with its byte, and joining by distance. Refusals of text stand in tests/cli/bad_input.cases.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "input/mesh/mesh_file.h"

static const double tent[][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0.25}};
static const uint8_t faces[][3] = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};

/* The bytes of a file. */
struct bytes {
    char data[2048];
    size_t size;
    bool big;
};

static void put(struct bytes *bytes, const void *value, size_t size)
{
    for (size_t i = 0; i < size; i++) /* the machine has the lowest byte first */
        bytes->data[bytes->size++] = ((const char *)value)[bytes->big ? size - 1 - i : i];
}

static void put_float(struct bytes *bytes, double value)
{
    const float single = (float)value;
    put(bytes, &single, sizeof single);
}

static void put_text(struct bytes *bytes, const char *text)
{
    memcpy(bytes->data + bytes->size, text, strlen(text));
    bytes->size += strlen(text);
}

static cml_status give(void *context, const char *path, size_t most, char **data, size_t *size,
                       struct cml_error *err)
{
    const struct bytes *bytes = context;
    (void)path;
    (void)most;
    (void)err;
    *data = malloc(bytes->size + 1);
    assert_non_null(*data);
    memcpy(*data, bytes->data, bytes->size);
    (*data)[bytes->size] = '\0';
    *size = bytes->size;
    return CML_OK;
}

static cml_status read_weld(struct bytes *bytes, const char *name, double weld, struct cml_mesh *mesh,
                            struct cml_mesh_notes *notes, struct cml_error *err)
{
    const struct cml_text_source source = {give, bytes};
    const struct cml_mesh_file_options options = {.unit = 1, .scale = 1, .height = 1, .weld = weld};
    *err = (struct cml_error){0};
    return cml_mesh_file_read(&source, name, &options, mesh, notes, err);
}

static void expect_tent(struct bytes *bytes, const char *name)
{
    struct cml_mesh mesh;
    struct cml_mesh_notes notes;
    struct cml_error err;
    const cml_status status = read_weld(bytes, name, 0, &mesh, &notes, &err);
    assert_string_equal(err.text, "");
    assert_int_equal(status, CML_OK);
    assert_int_equal(mesh.num_vertices, 5);
    assert_int_equal(mesh.num_triangles, 4);
    for (int f = 0; f < 4; f++)
        for (int k = 0; k < 3; k++) {
            static const int turned[] = {0, 2, 1}; /* heights become depths */
            const double *p = mesh.vertex[mesh.triangle[f][k]], *q = tent[faces[f][turned[k]]];
            assert_true(p[0] == q[0] && p[1] == q[1] && p[2] == 0.0 - q[2]);
        }
    cml_mesh_clear(&mesh);
}

static void expect_refusal(struct bytes *bytes, const char *name, const char *message)
{
    struct cml_mesh mesh;
    struct cml_error err;
    assert_int_equal(read_weld(bytes, name, 0, &mesh, NULL, &err), CML_E_INPUT);
    assert_string_equal(err.text, message);
}

/* Makes a binary STL whose header begins like a text. */
static struct bytes make_stl(void)
{
    struct bytes bytes = {.size = 80};
    const uint32_t count = 4;
    memcpy(bytes.data, "solid", 5);
    put(&bytes, &count, 4);
    for (int f = 0; f < 4; f++) {
        for (int k = 0; k < 3; k++) put_float(&bytes, NAN); /* the normal */
        for (int k = 0; k < 9; k++) put_float(&bytes, tent[faces[f][k / 3]][k % 3]);
        put(&bytes, "\0\7", 2);
    }
    return bytes;
}

static void binary_stl_is_known_by_its_size(void **state)
{
    (void)state;
    struct bytes bytes = make_stl();
    expect_tent(&bytes, "a.STL");
    bytes.size--;
    expect_refusal(&bytes, "a.stl",
                   "a.stl: 283 bytes (expected 284 for a binary file of 4 facets, or text that begins with "
                   "solid)");
    bytes.size = 40;
    expect_refusal(&bytes, "a.stl",
                   "a.stl: 40 bytes (expected 84 for a binary file of 0 facets, or text that begins with "
                   "solid)");
}

static void numbers_of_a_binary_stl_must_be_finite(void **state)
{
    (void)state;
    struct bytes bytes = make_stl();
    memcpy(bytes.data + 84 + 50 + 12 + 16, "\0\0\x80\x7f", 4);
    expect_refusal(&bytes, "a.stl", "a.stl: byte 163: y of the vertex = inf (expected a finite number)");
}

/* Makes a binary PLY with coordinates and indices of the given types. */
static struct bytes make_ply(const char *coordinate, const char *length, const char *index, bool big)
{
    struct bytes bytes = {.size = 0};
    char head[512];
    snprintf(head, sizeof head,
             "ply\r\nformat binary_%s_endian 1.0\r\nelement vertex 5\r\nproperty %s x\r\nproperty float y\r\n"
             "property float z\r\nelement face 4\r\nproperty list %s %s vertex_indices\r\nend_header\r\n",
             big ? "big" : "little", coordinate, length, index);
    put_text(&bytes, head);
    bytes.big = big;
    for (int v = 0; v < 5; v++) {
        if (strcmp(coordinate, "double") == 0)
            put(&bytes, &tent[v][0], 8);
        else
            put_float(&bytes, tent[v][0]);
        put_float(&bytes, tent[v][1]);
        put_float(&bytes, tent[v][2]);
    }
    for (int f = 0; f < 4; f++)
        for (int k = -1; k < 3; k++) {
            const uint32_t value = k < 0 ? 3 : faces[f][k];
            const char *type = k < 0 ? length : index;
            put(&bytes, &value,
                strstr(type, "int") == type + 1 || strcmp(type, "int") == 0 ? 4
                : strstr(type, "short")                                     ? 2
                                                                            : 1);
        }
    return bytes;
}

static void ply_may_have_any_type_of_number(void **state)
{
    (void)state;
    static const char *const whole[] = {"char", "uchar", "short", "ushort", "int", "uint"};
    for (int i = 0; i < 24; i++) {
        struct bytes bytes = make_ply(i % 2 ? "double" : "float", whole[i % 6], whole[i / 4], i / 2 % 2);
        expect_tent(&bytes, "a.ply");
    }
}

static void binary_ply_is_refused_with_its_byte(void **state)
{
    (void)state;
    struct bytes bytes = make_ply("float", "uchar", "char", false);
    const size_t rows = bytes.size - 16 - 60; /* 4 faces of 4 bytes, 5 vertices of 12 */
    char message[200];
    bytes.size--;
    snprintf(message, sizeof message,
             "a.ply: byte %zu: corner of the face = the end of the file (expected a whole number of 0..4)",
             bytes.size + 1);
    expect_refusal(&bytes, "a.ply", message);
    bytes.data[bytes.size++] = -1;
    snprintf(message, sizeof message,
             "a.ply: byte %zu: corner of the face = -1 (expected a whole number of 0..4)", bytes.size);
    expect_refusal(&bytes, "a.ply", message);
    memcpy(bytes.data + rows + 4, "\0\0\xc0\x7f", 4);
    snprintf(message, sizeof message, "a.ply: byte %zu: y of the vertex = nan (expected a finite number)",
             rows + 5);
    expect_refusal(&bytes, "a.ply", message);
}

/* Makes an ascii PLY of the tent whose tip is three vertices: the first, one `far` away, and one between. */
static struct bytes make_torn_tent(double far)
{
    struct bytes bytes = {.size = 0};
    char line[200];
    put_text(&bytes, "ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\nproperty float y\nproperty "
                     "float z\nelement face 4\nproperty list uchar int vertex_index\nend_header\n"
                     "0 0 0\n1 0 0\n1 1 0\n0 1 0\n.5 .5 .25\n");
    snprintf(line, sizeof line, "%.17g .5 .25\n%.17g .5 .25\n3 0 1 4\n3 1 2 4\n3 2 3 5\n3 3 0 6\n", 0.5 + far,
             0.5 + far / 2);
    put_text(&bytes, line);
    return bytes;
}

/* A vertex that is nearer than the distance to two others joins all three, in a chain; farther ones stay. */
static void weld_joins_chains_and_nothing_farther(void **state)
{
    (void)state;
    static const struct {
        double gap, weld;
        bool joined;
    } rows[] = {{0.0005, 0.00055, true}, {0.0005, 0.00045, false}, {1e-7, 2e-7, true}, {0, 0, true}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct bytes bytes = make_torn_tent(2 * rows[i].gap);
        struct cml_mesh mesh;
        struct cml_mesh_notes notes;
        struct cml_error err;
        const cml_status status = read_weld(&bytes, "a.ply", rows[i].weld, &mesh, &notes, &err);
        assert_int_equal(status, rows[i].joined ? CML_OK : CML_E_INPUT);
        if (!rows[i].joined) {
            assert_non_null(strstr(err.text, "3 corners nearly meet others, up to 0.0005 cm away at"));
            assert_non_null(strstr(err.text, ": weld=0.00075 joins them"));
            continue;
        }
        assert_int_equal(mesh.num_vertices, 5);
        assert_int_equal(notes.joined, rows[i].gap > 0 ? 2 : 0);
        assert_int_equal(notes.welded, rows[i].gap > 0 ? 0 : 2);
        assert_int_equal(notes.unused, 0);
        assert_true(fabs(notes.join_distance - 2 * rows[i].gap) < 1e-12);
        for (int t = 0; t < 4; t++)
            for (int k = 0; k < 3; k++) /* the first vertex stays where it is */
                assert_true(mesh.vertex[mesh.triangle[t][k]][2] == 0.0 ||
                            mesh.vertex[mesh.triangle[t][k]][0] == 0.5);
        cml_mesh_clear(&mesh);
    }
}

/* A refusal names the weld= that makes the mesh whole, says that none does, or suspects the one given. */
static void refusals_speak_of_weld(void **state)
{
    (void)state;
    static const struct {
        double far, weld;
        const char *text;
    } rows[] = {
        {0.2, 0,
         "; 3 corners nearly meet others, up to 0.1 cm away at (0.5, 0.5, height 0.25) cm: weld=0.15 joins "
         "them"},
        {0.0002, 0.8,
         "every face of the mesh has zero area; weld=0.8 has joined 6 corners, up to 1.41 cm away: it may be "
         "too large"},
        {0.2, 0.15, ""},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct bytes bytes = make_torn_tent(rows[i].far);
        struct cml_mesh mesh;
        struct cml_error err;
        const cml_status status = read_weld(&bytes, "a.ply", rows[i].weld, &mesh, NULL, &err);
        const size_t length = strlen(err.text), wanted = strlen(rows[i].text);
        assert_int_equal(status, wanted > 0 ? CML_E_INPUT : CML_OK);
        assert_true(length >= wanted);
        assert_string_equal(err.text + length - wanted, rows[i].text);
        cml_mesh_clear(&mesh);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(binary_stl_is_known_by_its_size),
        cmocka_unit_test(numbers_of_a_binary_stl_must_be_finite),
        cmocka_unit_test(ply_may_have_any_type_of_number),
        cmocka_unit_test(binary_ply_is_refused_with_its_byte),
        cmocka_unit_test(weld_joins_chains_and_nothing_farther),
        cmocka_unit_test(refusals_speak_of_weld),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
