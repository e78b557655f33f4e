/* Tests of reading .gsf and .asc heightmaps: the heights read, the messages of refusals, and mangled
 * bytes. SPDX-License-Identifier: MIT */
#include "lib/dice.h"
#include "lib/case_files.h"

#include <math.h>

#include "input/mesh/esri.h"
#include "input/mesh/gsf.h"

#define MAGIC "Gwyddion Simple Field 1.0\n"
#define HEAD MAGIC "XRes = 3\nYRes = 2\nXReal = 6e-6\nYReal = 2e-6\nXYUnits = m\nZUnits = m\n"
#define GRID "ncols 3\nnrows 2\nxllcorner 1e6\nyllcorner -5\ncellsize 2\n"

/* Writes a .gsf file into `bytes`: the header, NUL bytes up to a multiple of four, and `count` heights 0,
 * 1, 2 ... Returns its size in bytes. */
static size_t field(const char *header, int count, char *bytes)
{
    const size_t length = strlen(header), begin = (length / 4 + 1) * 4;
    memset(bytes, 0, begin);
    memcpy(bytes, header, length);
    for (int i = 0; i < count; i++) {
        const float height = (float)i;
        /* .gsf files are little-endian, like all machines that run the tests */
        memcpy(bytes + begin + 4 * i, &height, 4);
    }
    return begin + 4 * (size_t)count;
}

static cml_status read_bytes(void **state, const char *name, const char *bytes, size_t size, double unit,
                             struct cml_heightmap *map, struct cml_error *err)
{
    char path[256];
    case_path(state, name, path);
    case_write_bytes(state, name, bytes, size);
    *err = (struct cml_error){0};
    const bool gsf = strcmp(name, "x.gsf") == 0;
    const cml_status status = (gsf ? cml_gsf_read : cml_esri_read)(NULL, path, unit, map, err);
    case_remove(state, name);
    case_normalise(state, err->text);
    assert_true(status == CML_OK || !map->h);
    return status;
}

static void assert_heights(const struct cml_heightmap *map, double dx, double dy, double height_of_one)
{
    static const double rows_from_below[6] = {3, 4, 5, 0, 1, 2};
    assert_int_equal(map->nx, 3);
    assert_int_equal(map->ny, 2);
    assert_near("dx", map->dx, dx, 1e-12 * dx);
    assert_near("dy", map->dy, dy, 1e-12 * dy);
    assert_near("x0", map->x0, -dx, 1e-12 * dx);
    assert_near("y0", map->y0, -dy / 2, 1e-12 * dy);
    for (int i = 0; i < 6; i++)
        assert_near("height", map->h[i], rows_from_below[i] * height_of_one, 1e-12 * height_of_one);
}

static void a_field_is_read_in_its_units(void **state)
{
    static const struct {
        const char *xy, *z;
        double cm_xy, cm_z;
    } units[] = {{"m", "m", 100, 100},
                 {"um", "nm", 1e-4, 1e-7},
                 {"mm", "cm", 0.1, 1},
                 {"\xc2\xb5m", "pm", 1e-4, 1e-10},
                 {"\xce\xbcm", "dm", 1e-4, 10}};
    for (size_t i = 0; i < sizeof units / sizeof *units; i++) {
        char header[512], bytes[1024];
        struct cml_heightmap map;
        struct cml_error err;
        snprintf(header, sizeof header,
                 MAGIC
                 "Title = a = b\nYRes=2\n\tXRes =\t3 \nXReal = 6\nYReal = 2\nXOffset = 7\nXYUnits = %s\n"
                 "ZUnits = %s\r\nSpeed = 1 um/s\n",
                 units[i].xy, units[i].z);
        for (int pad = 0; pad < 4; pad++) { /* every alignment of the heights */
            const size_t size = field(header, 6, bytes);
            assert_int_equal(read_bytes(state, "x.gsf", bytes, size, 0, &map, &err), CML_OK);
            assert_heights(&map, 2 * units[i].cm_xy, units[i].cm_xy, units[i].cm_z);
            cml_heightmap_clear(&map);
            header[strlen(header) - 1] = '+';
            strcat(header, "\n");
        }
    }
}

static void a_field_without_units_takes_those_of_the_line(void **state)
{
    char bytes[1024];
    struct cml_heightmap map;
    struct cml_error err;
    const size_t size = field(MAGIC "XRes = 3\nYRes = 2\nXReal = 6\nYReal = 2\n", 6, bytes);
    assert_int_equal(read_bytes(state, "x.gsf", bytes, size, 0.1, &map, &err), CML_OK);
    assert_heights(&map, 0.2, 0.1, 0.1);
    cml_heightmap_clear(&map);
}

static void a_grid_is_read_in_the_units_of_the_line(void **state)
{
    static const char *const grids[] = {
        GRID "NODATA_value -1\n0 1 2\n3 4 5\n",
        "NROWS 2\r\nNCOLS 3\r\nCELLSIZE 2\r\nXLLCENTER 0\r\nYLLCENTER 0\r\n0 1\r\n2 3 4\r\n5",
        "ncols 3 nrows 2 dx 2 dy 2 nodata_value nan 0 1 2 3 4 5",
        "ncols 3\nnrows 2\ncellsize 2.0\n\n  0.0 1e0 +2\n30e-1 4. 5\n\n",
        "# by a scanner\n\n#ncols 9\n" GRID "NODATA_value -9999 # none\n0 1 2\n3 4 5\n",
    };
    for (size_t i = 0; i < sizeof grids / sizeof *grids; i++) {
        struct cml_heightmap map;
        struct cml_error err;
        assert_int_equal(read_bytes(state, "x.asc", grids[i], strlen(grids[i]), 1e-4, &map, &err), CML_OK);
        assert_heights(&map, 2e-4, 2e-4, 1e-4);
        cml_heightmap_clear(&map);
    }
}

struct refusal {
    const char *text, *message;
    double unit;
};

static void assert_refused(void **state, const char *name, const char *bytes, size_t size,
                           const struct refusal *refusal)
{
    struct cml_heightmap map;
    struct cml_error err;
    const cml_status status = read_bytes(state, name, bytes, size, refusal->unit, &map, &err);
    assert_string_equal(err.text, refusal->message);
    assert_int_equal(status, CML_E_INPUT);
}

#define LENGTH "(expected a length of 1e-30..1e30)"
#define WHOLE "(expected a whole number of 2 or more)"

static void fields_that_are_refused(void **state)
{
    static const struct refusal table[] = {
        {"Gwyddion Simple Field 2.0\n",
         "x.gsf:1: no such file format (expected \"Gwyddion Simple Field 1.0\")", 0},
        {MAGIC "XRes\n", "x.gsf:2: header line = XRes (expected name = value)", 0},
        {MAGIC "\n", "x.gsf:2: header line is missing (expected name = value)", 0},
        {MAGIC "XRes = 1\n", "x.gsf:2: XRes = 1 " WHOLE, 0},
        {MAGIC "XRes = 1e3\n", "x.gsf:2: XRes = 1e3 " WHOLE, 0},
        {MAGIC "XRes = 99999999999\n", "x.gsf:2: XRes = 99999999999 " WHOLE, 0},
        {MAGIC "XRes = 3\nXRes = 3\n", "x.gsf:3: XRes = 3 (expected this line only once)", 0},
        {MAGIC "YRes = -2\n", "x.gsf:2: YRes = -2 " WHOLE, 0},
        {MAGIC "XReal = 0\n", "x.gsf:2: XReal = 0 " LENGTH, 0},
        {MAGIC "YReal = nan\n", "x.gsf:2: YReal = nan " LENGTH, 0},
        {MAGIC "YReal = 1 um\n", "x.gsf:2: YReal = 1 um " LENGTH, 0},
        {MAGIC "XYUnits = V\n",
         "x.gsf:2: XYUnits = V (expected a unit of length: m, dm, cm, mm, um, nm or pm)", 0},
        {MAGIC "YRes = 2\n", "x.gsf: XRes is missing (expected the number of columns)", 0},
        {MAGIC "XRes = 2\n", "x.gsf: YRes is missing (expected the number of rows)", 0},
        {MAGIC "XRes = 2\nYRes = 2\nYReal = 1\n",
         "x.gsf: XReal is missing (expected the width, without which slopes are unknown)", 0},
        {MAGIC "XRes = 2\nYRes = 2\nXReal = 1\n",
         "x.gsf: YReal is missing (expected the height, without which slopes are unknown)", 0},
        {MAGIC "XRes = 2\nYRes = 2\nXReal = 1\nYReal = 1\n",
         "x.gsf: XYUnits is missing (expected units in the file, or units= on the m line when it has none)",
         0},
        {MAGIC "XRes = 2\nYRes = 2\nXReal = 1\nYReal = 1\nXYUnits = m\n",
         "x.gsf: ZUnits is missing (expected units in the file, or units= on the m line when it has none)",
         0},
        {HEAD, "x.gsf: the file has its own units (expected no units= beside it)", 0.1},
        {HEAD, "x.gsf: 0 bytes of heights behind byte 96 (expected 24: 4 x 3 x 2)", 0},
        {MAGIC "XRes = 2000000000\nYRes = 2000000000\nXReal = 1\nYReal = 1\nXYUnits = m\nZUnits = m\n",
         "x.gsf: 0 bytes of heights behind byte 108 (expected 16000000000000000000: 4 x 2000000000 x "
         "2000000000)",
         0},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        char bytes[1024];
        const size_t size = field(table[i].text, 0, bytes);
        assert_refused(state, "x.gsf", bytes, size, &table[i]);
    }
}

static void heights_that_are_refused(void **state)
{
    static const struct refusal refusals[] = {
        {"", "x.gsf: 28 bytes of heights behind byte 96 (expected 24: 4 x 3 x 2)", 0},
        {"", "x.gsf: 20 bytes of heights behind byte 96 (expected 24: 4 x 3 x 2)", 0},
        {"", "x.gsf: byte 95 is not NUL (expected NUL bytes up to byte 96)", 0},
        {"", "x.gsf: no NUL byte ends the header (expected one, and then the heights)", 0},
        {"",
         "x.gsf: 2 of 6 heights are missing, the first in row 1, column 2 (expected a height in every cell: "
         "fill the holes first)",
         0},
    };
    char bytes[1024];
    assert_refused(state, "x.gsf", bytes, field(HEAD, 7, bytes), &refusals[0]);
    assert_refused(state, "x.gsf", bytes, field(HEAD, 5, bytes), &refusals[1]);
    size_t size = field(HEAD, 6, bytes);
    assert_int_equal(strlen(bytes), 93);
    bytes[94] = 'x';
    assert_refused(state, "x.gsf", bytes, size, &refusals[2]);
    assert_refused(state, "x.gsf", bytes, 93, &refusals[3]);
    size = field(HEAD, 6, bytes);
    const float holes[2] = {NAN, INFINITY};
    memcpy(bytes + 100, &holes[0], 4);
    memcpy(bytes + 112, &holes[1], 4);
    assert_refused(state, "x.gsf", bytes, size, &refusals[4]);
}

static void a_field_with_its_bytes_reversed_is_called_that(void **state)
{
    static const struct refusal reversed = {"",
                                            "x.gsf: row 1, column 2 = 4.601e-41, or 1 with its bytes "
                                            "reversed (expected floats with the lowest byte first; these "
                                            "look big-endian)",
                                            0},
                                high = {"",
                                        "x.gsf: height in row 2, column 2 = 1e+33 cm (expected -1e30..1e30 "
                                        "cm)",
                                        0};
    char bytes[1024];
    size_t size = field(HEAD, 6, bytes);
    for (size_t begin = size - 24; begin < size; begin += 4)
        for (size_t k = 0; k < 2; k++) {
            const char kept = bytes[begin + k];
            bytes[begin + k] = bytes[begin + 3 - k];
            bytes[begin + 3 - k] = kept;
        }
    assert_refused(state, "x.gsf", bytes, size, &reversed);
    size = field(HEAD, 6, bytes);
    const float huge = 1e31f;
    memcpy(bytes + size - 8, &huge, sizeof huge);
    assert_refused(state, "x.gsf", bytes, size, &high);
}

static void grids_that_are_refused(void **state)
{
    static const struct refusal table[] = {
        {"", "x.asc: ncols is missing (expected a whole number of 2 or more)", 1},
        {"ncols 3\n", "x.asc: nrows is missing (expected a whole number of 2 or more)", 1},
        {"ncols 1\n", "x.asc:1: ncols = 1 " WHOLE, 1},
        {"ncols\n", "x.asc:1: ncols is missing (expected a number)", 1},
        {"ncols 3\nnrows x\n", "x.asc:2: nrows = x (expected a number)", 1},
        {"ncols 3\nncols 3\n", "x.asc:2: ncols = 3 (expected this keyword only once)", 1},
        {"columns 3\n",
         "x.asc:1: keyword = columns (expected ncols, nrows, xllcorner, yllcorner, cellsize, "
         "NODATA_value or heights)",
         1},
        {"ncols 3\nnrows 2\n",
         "x.asc: cellsize is missing (expected either cellsize, or both dx and dy, once)", 1},
        {"ncols 3\nnrows 2\ndx 1\n",
         "x.asc: cellsize is missing (expected either cellsize, or both dx and dy, once)", 1},
        {"cellsize 0\n", "x.asc:1: cellsize = 0 " LENGTH, 1},
        {"cellsize 1e999\n", "x.asc:1: cellsize = 1e999 (expected a number)", 1},
        {GRID, "x.asc: an ESRI grid has no units (expected units=cm, mm, um or m on the m line)", 0},
        {"ncols 2000000000\nnrows 2000000000\ncellsize 1\n",
         "x.asc: 2000000000 x 2000000000 heights in 45 bytes (expected at least 2 for each)", 1},
        {GRID "0 1 2\n3 4\n",
         "x.asc:7: height in row 2, column 3 is missing (expected ncols x nrows numbers, the "
         "file ends before)",
         1},
        {GRID "0 1 2\n3 4 5\n\n6\n",
         "x.asc:9: word behind the last height = 6 (expected the end of the file)", 1},
        {GRID "0 1,5 2\n3 4 5\n",
         "x.asc:6: height in row 1, column 2 = 1,5 (expected a number, with a decimal point)", 1},
        {GRID "0 1 2\n3 inf 5\n", "x.asc:7: height in row 2, column 2 = inf (expected a number)", 1},
        {GRID "0 1 -9999\n3 nan 5\n",
         "x.asc: 2 of 6 heights are missing, the first in row 1, column 3 (expected a height in every cell: "
         "fill "
         "the holes first)",
         1},
        {GRID "nodata_value 4\n0 1 2\n3 4 5\n",
         "x.asc: 1 of 6 heights are missing, the first in row 2, column 2 (expected a height in every cell: "
         "fill "
         "the holes first)",
         1},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        assert_refused(state, "x.asc", table[i].text, strlen(table[i].text), &table[i]);
    const struct refusal binary = {"", "x.asc: cannot be read: it holds a NUL byte (expected a text file)",
                                   1};
    assert_refused(state, "x.asc", "ncols\0 3", 8, &binary);
}

static void missing_heights_of_other_digits_are_refused(void **state)
{
    static const struct refusal table[] = {
        {GRID "NODATA_value -3.402823466e+38\n0 1 2\n3 4 -3.402823e+38\n",
         "x.asc: 1 of 6 heights are missing, the first in row 2, column 3 (expected a height in every cell: "
         "fill the holes first)",
         1},
        {GRID "NODATA_value -3.40282e+38\n0 1 2\n3 4 -3.4028234663852886e+38\n",
         "x.asc: 1 of 6 heights are missing, the first in row 2, column 3 (expected a height in every cell: "
         "fill the holes first)",
         1},
        {GRID "0 1 2\n3 -3.402823e+38 5\n",
         "x.asc:7: height in row 2, column 2 = -3.402823e+38 (expected -1e30..1e30 cm, or NODATA_value)", 1},
        {GRID "NODATA_value nan\n0 1 2\n3 nan 5\n",
         "x.asc: 1 of 6 heights are missing, the first in row 2, column 2 (expected a height in every cell: "
         "fill the holes first)",
         1},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        assert_refused(state, "x.asc", table[i].text, strlen(table[i].text), &table[i]);
}

/* Arbitrary bytes give a sound map or a message of one line. Sanitizers watch for other faults. */
static void mangled_files_end_in_one_line(void **state)
{
    struct dice dice = dice_new(11);
    int sound = 0;
    for (int round = 0; round < 3000; round++) {
        char bytes[1024];
        const bool gsf = round % 2 == 0;
        size_t size =
            gsf ? field(HEAD, 6, bytes) : (size_t)sprintf(bytes, GRID "NODATA_value -1\n0 1 2\n3 4 5\n");
        size = dice_damage(&dice, bytes, size, 2);
        struct cml_heightmap map;
        struct cml_error err;
        const cml_status status =
            read_bytes(state, gsf ? "x.gsf" : "x.asc", bytes, size, gsf ? 0 : 1, &map, &err);
        assert_true(status == CML_OK || (status == CML_E_INPUT && err.text[0] && !strchr(err.text, '\n')));
        for (int i = 0; status == CML_OK && i < map.nx * map.ny; i++) assert_true(isfinite(map.h[i]));
        sound += status == CML_OK;
        cml_heightmap_clear(&map);
    }
    assert_true(sound > 500 && sound < 2500);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_field_is_read_in_its_units),
        cmocka_unit_test(a_field_without_units_takes_those_of_the_line),
        cmocka_unit_test(a_grid_is_read_in_the_units_of_the_line),
        cmocka_unit_test(fields_that_are_refused),
        cmocka_unit_test(heights_that_are_refused),
        cmocka_unit_test(a_field_with_its_bytes_reversed_is_called_that),
        cmocka_unit_test(grids_that_are_refused),
        cmocka_unit_test(missing_heights_of_other_digits_are_refused),
        cmocka_unit_test(mangled_files_end_in_one_line),
    };
    return cmocka_run_group_tests_name("heightmap_files", tests, case_setup, case_teardown);
}
