/* Reading .vti files: what vtk.h writes comes back, what is refused and in which words, and mangled bytes.
 * SPDX-License-Identifier: MIT */
#include "lib/dice.h"
#include "lib/mco_case.h"

#include <math.h>

#include "plot/files/vti.h"
#include "output/files/vtk.h"

#define IMAGE(kind, extent)                                                                                  \
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" " kind ">\n"                       \
    "  <ImageData WholeExtent=\"" extent "\" Origin=\"-1.5 -2 0\" Spacing=\"1 2 0.1\">\n"
#define KIND "byte_order=\"LittleEndian\" header_type=\"UInt64\""
#define START IMAGE(KIND, "0 3 0 2 0 0")
#define ARRAY(name, offset)                                                                                  \
    "<DataArray type=\"Float32\" Name=\"" name "\" NumberOfComponents=\"1\" format=\"appended\" "            \
    "offset=\"" offset "\"/>\n"
#define PIECE "    <Piece Extent=\"0 3 0 2 0 0\">\n      <CellData>\n"
#define DATA "      </CellData>\n    </Piece>\n  </ImageData>\n  <AppendedData encoding=\"raw\">\n   _"
#define WHOLE START PIECE ARRAY("Rd_xy", "0") ARRAY("Tt_xy", "32") DATA

static void put(char *bytes, uint64_t word, int size, bool big)
{
    for (int i = 0; i < size; i++) bytes[big ? size - 1 - i : i] = (char)(word >> 8 * i);
}

/* The header and two arrays of six values, 0 to 5 and 10 to 15; returns the size. */
static size_t image(const char *header, bool big, char *bytes)
{
    size_t size = strlen(header);
    memcpy(bytes, header, size);
    for (int a = 0; a < 2; a++) {
        put(bytes + size, 24, 8, big);
        size += 8;
        for (int i = 0; i < 6; i++, size += 4) {
            const float value = (float)(10 * a + i);
            uint32_t word;
            memcpy(&word, &value, sizeof word);
            put(bytes + size, word, 4, big);
        }
    }
    strcpy(bytes + size, "\n  </AppendedData>\n</VTKFile>\n");
    return size + strlen(bytes + size);
}

static cml_status read_bytes(void **state, const char *bytes, size_t size, const char *name,
                             struct cml_pixels *pixels, struct cml_error *err)
{
    char path[256];
    case_path(state, "x.vti", path);
    case_write_bytes(state, "x.vti", bytes, size);
    *err = (struct cml_error){0};
    const cml_status status = cml_vti_read(path, name, pixels, err);
    case_remove(state, "x.vti");
    case_normalise(state, err->text);
    assert_true(status == CML_OK || !pixels->value);
    return status;
}

static void assert_sound(void **state, const char *header, bool big, const char *name, double first)
{
    char bytes[2048];
    struct cml_pixels pixels;
    struct cml_error err;
    const size_t size = image(header, big, bytes);
    const cml_status status = read_bytes(state, bytes, size, name, &pixels, &err);
    assert_string_equal(err.text, "");
    assert_int_equal(status, CML_OK);
    assert_int_equal(pixels.n[0], 3);
    assert_int_equal(pixels.n[1], 2);
    assert_true(pixels.origin[0] == -1.5 && pixels.origin[1] == -2);
    assert_true(pixels.spacing[0] == 1 && pixels.spacing[1] == 2);
    for (int i = 0; i < 6; i++) assert_true((double)pixels.value[i] == first + i);
    cml_pixels_clear(&pixels);
}

static void arrays_are_found_by_name_in_either_byte_order(void **state)
{
    assert_sound(state, WHOLE, false, "Rd_xy", 0);
    assert_sound(state, WHOLE, false, "Tt_xy", 10);
    char *big = case_replace(WHOLE, "LittleEndian", "BigEndian");
    assert_sound(state, big, true, "Tt_xy", 10);
    free(big);
}

static void blanks_and_other_arrays_do_not_matter(void **state)
{
    assert_sound(state,
                 "\n<VTKFile\n\theader_type='UInt64' byte_order='LittleEndian'\r\n type='ImageData' >"
                 "<ImageData Spacing=' 1 2 1 ' WholeExtent='0 3  0 2 0 0' Origin='-1.5 -2 0' note='a b'>"
                 "<Piece Extent='0 3 0 2 0 0'><CellData Scalars='Tt'>"
                 "<DataArray Name='Rd_xya' type='Int8' NumberOfComponents='7' format='ascii'/>"
                 "<DataArray offset='32' format='appended' type='Float32' Name='Tt'/></CellData></Piece>"
                 "</ImageData><AppendedData encoding='raw'>_",
                 false, "Tt", 10);
}

static void count_up(const void *context, size_t begin, size_t count, double *out)
{
    for (size_t i = 0; i < count; i++) out[i] = *(const double *)context * (double)(begin + i);
}

static void what_is_written_is_read(void **state)
{
    const double steps[2] = {0.25, 3};
    const struct cml_axis x = {.n = 70}, y = {.n = 50};
    const struct cml_image flat = {{70, 50, 0}, {-0.7, -1.0 / 3, 0}, {0.02, 1.0 / 75, 1}};
    struct cml_field fields[2] = {{.name = "a"}, {.name = "b"}};
    for (int i = 0; i < 2; i++) {
        fields[i].num_axes = 2;
        fields[i].axis[0] = &y;
        fields[i].axis[1] = &x;
        fields[i].values = count_up;
        fields[i].context = &steps[i];
    }
    char path[256];
    struct cml_pixels pixels;
    struct cml_error err;
    case_path(state, "x.vti", path);
    assert_int_equal(cml_vti_write(path, &flat, fields, 2, &err), CML_OK);
    assert_int_equal(cml_vti_read(path, "b", &pixels, &err), CML_OK);
    case_remove(state, "x.vti");
    assert_true(pixels.n[0] == 70 && pixels.n[1] == 50);
    assert_memory_equal(pixels.origin, flat.origin, sizeof pixels.origin);
    assert_memory_equal(pixels.spacing, flat.spacing, sizeof pixels.spacing);
    for (size_t i = 0; i < 3500; i++) assert_true((double)pixels.value[i] == 3.0 * (double)i);
    cml_pixels_clear(&pixels);
}

#define EXTENT "(expected 0 nx 0 ny 0 0, a map without layers)"

static void headers_that_are_refused(void **state)
{
    static const struct {
        const char *text, *message;
    } table[] = {
        {"", "x.vti:1: tag is missing (expected VTKFile)"},
        {"<html>", "x.vti:1: tag = html (expected VTKFile)"},
        {"<VTKFile type=ImageData>", "x.vti:1: attribute = type=ImageData (expected name=\"value\")"},
        {"<VTKFile type=\"ImageData>", "x.vti:1: attribute = type=\"ImageData (expected name=\"value\")"},
        {"\n<VTKFile>", "x.vti:2: type is missing (expected ImageData)"},
        {"<VTKFile type=\"PolyData\">", "x.vti:1: type = PolyData (expected ImageData)"},
        {IMAGE("header_type=\"UInt32\"", ""), "x.vti:2: header_type = UInt32 (expected UInt64)"},
        {IMAGE(KIND " compressor=\"zlib\"", ""), "x.vti:2: compressor = zlib (expected none)"},
        {IMAGE("header_type=\"UInt64\" byte_order=\"Middle\"", ""),
         "x.vti:2: byte_order = Middle (expected LittleEndian or BigEndian)"},
        {IMAGE(KIND, "0 3 0 2 0 4"), "x.vti:3: WholeExtent = 0 3 0 2 0 4 " EXTENT},
        {IMAGE(KIND, "0 3 0 0 0 0"), "x.vti:3: WholeExtent = 0 3 0 0 0 0 " EXTENT},
        {IMAGE(KIND, "1 3 0 2 0 0"), "x.vti:3: WholeExtent = 1 3 0 2 0 0 " EXTENT},
        {IMAGE(KIND, "0 3 0 2 0"), "x.vti:3: WholeExtent = 0 3 0 2 0 " EXTENT},
        {IMAGE(KIND, "0 3 0 2 0 0 0"), "x.vti:3: WholeExtent = 0 3 0 2 0 0 0 " EXTENT},
        {IMAGE(KIND, "0 2.5 0 2 0 0"), "x.vti:3: WholeExtent = 0 2.5 0 2 0 0 " EXTENT},
        {IMAGE(KIND, "0 2e9 0 2 0 0"), "x.vti:3: WholeExtent = 0 2e9 0 2 0 0 " EXTENT},
        {START "<Piece Extent=\"0 3 0 1 0 0\">", "x.vti:4: Extent = 0 3 0 1 0 0 (expected the WholeExtent)"},
        {START "<CellData>", "x.vti:4: tag = CellData (expected Piece)"},
        {START PIECE "<DataArray type=\"Float32\"/>",
         "x.vti:6: Name is missing (expected the name of the array)"},
        {START PIECE ARRAY("Rd_xy", "0") ARRAY("Rd_xy", "0"),
         "x.vti:7: Name = Rd_xy (expected this array only once)"},
        {START PIECE ARRAY("Rd_xy", "-1"), "x.vti:6: offset = -1 (expected a number of bytes)"},
        {START PIECE "<DataArray Name=\"Rd_xy\" type=\"Float64\">",
         "x.vti:6: type = Float64 (expected Float32)"},
        {START PIECE
         "<DataArray Name=\"Rd_xy\" type=\"Float32\" format=\"appended\" NumberOfComponents=\"3\">",
         "x.vti:6: NumberOfComponents = 3 (expected 1)"},
        {START PIECE "<Points>", "x.vti:6: tag = Points (expected DataArray or /CellData)"},
        {START PIECE ARRAY("A", "0") ARRAY("B", "32") DATA, "x.vti: no array Rd_xy (expected one of A B)"},
        {START PIECE DATA, "x.vti: no array Rd_xy (expected one of none, the file has no arrays)"},
        {START PIECE ARRAY("Rd_xy", "0") "</CellData></ImageData>",
         "x.vti:7: tag = /ImageData (expected /Piece)"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        struct cml_pixels pixels;
        struct cml_error err;
        const cml_status status =
            read_bytes(state, table[i].text, strlen(table[i].text), "Rd_xy", &pixels, &err);
        assert_string_equal(err.text, table[i].message);
        assert_int_equal(status, CML_E_INPUT);
    }
}

/* `from` of the header replaced by `to`, before the data of two arrays. */
static void assert_refused(void **state, const char *from, const char *to, const char *message)
{
    char bytes[2048];
    struct cml_pixels pixels;
    struct cml_error err;
    char *header = case_replace(WHOLE, from, to);
    const size_t size = image(header, false, bytes);
    const cml_status status = read_bytes(state, bytes, size, "Tt_xy", &pixels, &err);
    free(header);
    assert_string_equal(err.text, message);
    assert_int_equal(status, CML_E_INPUT);
}

static void grids_and_sizes_that_are_refused(void **state)
{
    assert_refused(state, "1 2 0.1", "1 0 1",
                   "x.vti:3: Spacing = 1 0 1 (expected three numbers, dx and dy in 1e-12..1e12)");
    assert_refused(state, "1 2 0.1", "1 nan 1",
                   "x.vti:3: Spacing = 1 nan 1 (expected three numbers, dx and dy in 1e-12..1e12)");
    assert_refused(state, "-1.5 -2 0", "-1.5 1e300 0",
                   "x.vti:3: Origin = -1.5 1e300 0 (expected three numbers, x and y of at most 1e9 pixels)");
    assert_refused(state, "raw", "base64", "x.vti:11: encoding = base64 (expected raw)");
    assert_refused(state, "   _", "   ", "x.vti:12: _ is missing (expected an underscore before the data)");
    assert_refused(state, "0 3 0 2", "0 2 0 2", "x.vti: Tt_xy has 24 bytes (expected 16: 4 x 2 x 2)");
    assert_refused(state, "offset=\"32\"", "offset=\"64\"",
                   "x.vti: 94 bytes of data (expected 96: 8 + 4 x 3 x 2 at 64)");
    assert_refused(
        state, "0 3 0 2", "0 1e9 0 1e9",
        "x.vti: 94 bytes of data (expected 4000000000000000000: 8 + 4 x 1000000000 x 1000000000 at "
        "32)");
    assert_refused(state, "offset=\"32\"", "offset=\"9007199254740992\"",
                   "x.vti: 94 bytes of data (expected 9007199254741024: 8 + 4 x 3 x 2 at 9007199254740992)");
}

static void values_that_are_refused(void **state)
{
    static const struct {
        float value;
        const char *message;
    } table[] = {
        {-1, "x.vti: Rd_xy of pixel 1 1 = -1 (expected a number of 0 or more)"},
        {INFINITY, "x.vti: Rd_xy of pixel 1 1 = inf (expected a number of 0 or more)"},
        {NAN, "x.vti: Rd_xy of pixel 1 1 = nan (expected a number of 0 or more)"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        char bytes[2048];
        struct cml_pixels pixels;
        struct cml_error err;
        uint32_t word;
        const size_t size = image(WHOLE, false, bytes);
        memcpy(&word, &table[i].value, sizeof word);
        put(bytes + strlen(WHOLE) + 8 + 4 * 4, word, 4, false);
        assert_int_equal(read_bytes(state, bytes, size, "Rd_xy", &pixels, &err), CML_E_INPUT);
        assert_string_equal(err.text, table[i].message);
    }
}

/* Whatever bytes come: a sound map or one line, nothing else. The sanitizers look on. */
static void mangled_files_end_in_one_line(void **state)
{
    struct dice dice = dice_new(17);
    int sound = 0;
    for (int round = 0; round < 3000; round++) {
        char bytes[2048];
        struct cml_pixels pixels;
        struct cml_error err;
        size_t size = image(WHOLE, false, bytes);
        size = dice_damage(&dice, bytes, size, 3);
        const cml_status status = read_bytes(state, bytes, size, "Tt_xy", &pixels, &err);
        assert_true(status == CML_OK || (status == CML_E_INPUT && err.text[0] && !strchr(err.text, '\n')));
        for (size_t i = 0; status == CML_OK && i < pixels.n[0] * pixels.n[1]; i++)
            assert_true(isfinite(pixels.value[i]) && pixels.value[i] >= 0);
        sound += status == CML_OK;
        cml_pixels_clear(&pixels);
    }
    assert_true(sound > 500 && sound < 2500);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arrays_are_found_by_name_in_either_byte_order),
        cmocka_unit_test(blanks_and_other_arrays_do_not_matter),
        cmocka_unit_test(what_is_written_is_read),
        cmocka_unit_test(headers_that_are_refused),
        cmocka_unit_test(grids_and_sizes_that_are_refused),
        cmocka_unit_test(values_that_are_refused),
        cmocka_unit_test(mangled_files_end_in_one_line),
    };
    return cmocka_run_group_tests_name("vti", tests, case_setup, case_teardown);
}
