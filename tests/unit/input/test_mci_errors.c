/* Tests of scene files (.mci) that the reader refuses. Each text below must give exactly its message.
 * SPDX-License-Identifier: MIT */
#include "lib/mci_case.h"

#include <math.h>

/* Lines of the text: 3 is the output name, 4 photons, 5 dz dr, 6 nz nr na, 7 the number of layers, 8 n
 * above. */
#define HEAD "1.0\n1\n"
#define NAME HEAD "a.mco A\n"
#define BINS NAME "100\n0.1 0.2\n"
#define RUN BINS "3 4 5\n"
#define ONE RUN "1\n1\n"
#define LAYER "1.4 1 2 0.9 1\n"
#define GOOD ONE LAYER "1\n"

struct refusal {
    const char *text, *message;
};

static void check_all(void **state, const struct refusal *refusals, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        struct cml_scene_list list = {.count = 7};
        struct cml_error err;
        const cml_status status = case_read(state, refusals[i].text, &list, &err);
        if (strcmp(err.text, refusals[i].message) != 0) print_error("input:\n%s\n", refusals[i].text);
        assert_string_equal(err.text, refusals[i].message);
        assert_int_equal(status, CML_E_INPUT);
        assert_int_equal(err.status, CML_E_INPUT);
        assert_int_equal(list.count, 0);
        assert_null(list.scenes);
    }
}

#define CHECK_ALL(state, table) check_all(state, table, sizeof(table) / sizeof *(table))

static void files_that_end_early(void **state)
{
    static const struct refusal table[] = {
        {"", "x.mci: file version is missing (expected a line for it, but the file ends here)"},
        {"# only\n\n# comments\n",
         "x.mci:3: file version is missing (expected a line for it, but the file ends here)"},
        {"1.0\n", "x.mci:1: number of runs is missing (expected a line for it, but the file ends here)"},
        {HEAD, "x.mci:2: output name is missing (expected a line for it, but the file ends here)"},
        {HEAD "# no run\n",
         "x.mci:3: output name is missing (expected a line for it, but the file ends here)"},
        {NAME, "x.mci:3: photons is missing (expected a line for it, but the file ends here)"},
        {NAME "100\n", "x.mci:4: dz dr is missing (expected a line for it, but the file ends here)"},
        {BINS, "x.mci:5: nz nr na is missing (expected a line for it, but the file ends here)"},
        {RUN, "x.mci:6: number of layers is missing (expected a line for it, but the file ends here)"},
        {RUN "1\n", "x.mci:7: n above is missing (expected a line for it, but the file ends here)"},
        {ONE, "x.mci:8: layer 1 is missing (expected a line for it, but the file ends here)"},
        {ONE "b 1 0 0\n", "x.mci:9: layer 1 is missing (expected a line for it, but the file ends here)"},
        {ONE LAYER, "x.mci:9: n below is missing (expected a line for it, but the file ends here)"},
        {RUN "2\n1\n" LAYER "# layer 2 is not here",
         "x.mci:10: layer 2 is missing (expected a line for it, but the file ends here)"},
        {"1.0\n2\n"
         "a A\n1\n1 1\n1 1 1\n1\n1\n1 1 1 0 1\n1\n",
         "x.mci:10: output name is missing (expected a line for it, but the file ends here)"},
    };
    CHECK_ALL(state, table);
}

static void lines_too_short_or_too_long(void **state)
{
    static const struct refusal table[] = {
        {HEAD "a.mco\n", "x.mci:3: format is missing (expected A or B)"},
        {HEAD "a.mco # A\n", "x.mci:3: format is missing (expected A or B)"},
        {BINS "3 4\n", "x.mci:6: na is missing (expected a whole number of 1..1e9)"},
        {NAME "100\n0.1 # dz, dr\n", "x.mci:5: dr is missing (expected a length of 1e-30..1e30 cm)"},
        {NAME "100\n0.1 0.2 0.3\n",
         "x.mci:5: number after dr = 0.3 (expected the end of the line or a comment)"},
        {BINS "3 4 5 6\n", "x.mci:6: number after na = 6 (expected the end of the line or a comment)"},
        {NAME "100 1\n", "x.mci:4: number after photons = 1 (expected the end of the line or a comment)"},
        {"1.0\n1 1\n",
         "x.mci:2: number after number of runs = 1 (expected the end of the line or a comment)"},
        {RUN "1 1\n",
         "x.mci:7: number after number of layers = 1 (expected the end of the line or a comment)"},
        {RUN "1\n1 1.4\n", "x.mci:8: number after n above = 1.4 (expected the end of the line or a comment)"},
        {ONE "1.4 1 2 0.9\n", "x.mci:9: layer 1: d is missing (expected a thickness of 0..1e30 cm)"},
        {ONE "1.4 1 2 0.9 1 0\n",
         "x.mci:9: layer 1: number after d = 0 (expected the end of the line or a comment)"},
        {ONE LAYER "1 1\n", "x.mci:10: number after n below = 1 (expected the end of the line or a comment)"},
    };
    CHECK_ALL(state, table);
}

static void words_where_numbers_belong(void **state)
{
    static const struct refusal table[] = {
        {"1.0\none\n", "x.mci:2: number of runs = one (expected a whole number of 1..32767)"},
        {NAME "many\n", "x.mci:4: photons = many (expected a whole number of 1..2^48)"},
        {NAME "0x10\n", "x.mci:4: photons = 0x10 (expected a whole number of 1..2^48)"},
        {NAME "100\nnan 0.2\n", "x.mci:5: dz = nan (expected a length of 1e-30..1e30 cm)"},
        {NAME "100\n0.1 inf\n", "x.mci:5: dr = inf (expected a length of 1e-30..1e30 cm)"},
        {NAME "100\n0.1, 0.2\n", "x.mci:5: dz = 0.1, (expected a length of 1e-30..1e30 cm, without commas)"},
        {NAME "100\n1e999 1\n", "x.mci:5: dz = 1e999 (expected a length of 1e-30..1e30 cm)"},
        {BINS "3 4 5x\n", "x.mci:6: na = 5x (expected a whole number of 1..1e9)"},
        {RUN "1\nair\n", "x.mci:8: n above = air (expected a refractive index of 0.01..100)"},
        {ONE "1.4 1 1e 0.9 1\n", "x.mci:9: layer 1: mus = 1e (expected a coefficient of 0..1e30 1/cm)"},
        {ONE "1.4 1 2 0.9 1cm\n", "x.mci:9: layer 1: d = 1cm (expected a thickness of 0..1e30 cm)"},
        {ONE LAYER "below 1\n", "x.mci:10: n below = below (expected a refractive index of 0.01..100)"},
    };
    CHECK_ALL(state, table);
}

static void numbers_out_of_range(void **state)
{
    static const struct refusal table[] = {
        {"1.0\n0\n", "x.mci:2: number of runs = 0 (expected a whole number of 1..32767)"},
        {"1.0\n-1\n", "x.mci:2: number of runs = -1 (expected a whole number of 1..32767)"},
        {"1.0\n40000\n", "x.mci:2: number of runs = 40000 (expected a whole number of 1..32767)"},
        {NAME "0\n", "x.mci:4: photons = 0 (expected a whole number of 1..2^48)"},
        {NAME "-5\n", "x.mci:4: photons = -5 (expected a whole number of 1..2^48)"},
        {NAME "1.5\n", "x.mci:4: photons = 1.5 (expected a whole number of 1..2^48)"},
        {NAME "281474976710657\n", "x.mci:4: photons = 281474976710657 (expected a whole number of 1..2^48)"},
        {NAME "100\n0 0.2\n", "x.mci:5: dz = 0 (expected a length of 1e-30..1e30 cm)"},
        {NAME "100\n0.1 -0.2\n", "x.mci:5: dr = -0.2 (expected a length of 1e-30..1e30 cm)"},
        {NAME "100\n1e31 1\n", "x.mci:5: dz = 1e31 (expected a length of 1e-30..1e30 cm)"},
        {BINS "0 4 5\n", "x.mci:6: nz = 0 (expected a whole number of 1..1e9)"},
        {BINS "3 -4 5\n", "x.mci:6: nr = -4 (expected a whole number of 1..1e9)"},
        {BINS "3 4 0.5\n", "x.mci:6: na = 0.5 (expected a whole number of 1..1e9)"},
        {BINS "3 4 2e9\n", "x.mci:6: na = 2e9 (expected a whole number of 1..1e9)"},
        {BINS "100000 100000 1\n", "x.mci:6: nz nr na = 100000 100000 1 (expected at most 2^31 cells in all "
                                   "arrays together, not 1e+10 (74.5 GiB))"},
        {BINS "1 1e6 1e6\n", "x.mci:6: nz nr na = 1 1000000 1000000 (expected at most 2^31 cells in all "
                             "arrays together, not 2e+12 (1.49e+04 GiB))"},
        {RUN "0\n", "x.mci:7: number of layers = 0 (expected a whole number of 1..100000)"},
        {RUN "100001\n", "x.mci:7: number of layers = 100001 (expected a whole number of 1..100000)"},
        {RUN "1e300\n", "x.mci:7: number of layers = 1e300 (expected a whole number of 1..100000)"},
        {RUN "1\n0\n", "x.mci:8: n above = 0 (expected a refractive index of 0.01..100)"},
        {RUN "1\n-1.4\n", "x.mci:8: n above = -1.4 (expected a refractive index of 0.01..100)"},
        {ONE "0 1 2 0.9 1\n", "x.mci:9: layer 1: n = 0 (expected a refractive index of 0.01..100)"},
        {ONE "1000 1 2 0.9 1\n", "x.mci:9: layer 1: n = 1000 (expected a refractive index of 0.01..100)"},
        {ONE "1.4 -1 2 0.9 1\n", "x.mci:9: layer 1: mua = -1 (expected a coefficient of 0..1e30 1/cm)"},
        {ONE "1.4 1e-10 100 0.9 1\n1\n",
         "x.mci:9: layer 1: mua = 1e-10 (expected 0, or at least 1e-11 of mua + mus)"},
        {ONE "1.4 1 -2 0.9 1\n", "x.mci:9: layer 1: mus = -2 (expected a coefficient of 0..1e30 1/cm)"},
        {ONE "1.4 1 2 1.1 1\n", "x.mci:9: layer 1: g = 1.1 (expected an anisotropy of -1..1)"},
        {ONE "1.4 1 2 -1.0001 1\n", "x.mci:9: layer 1: g = -1.0001 (expected an anisotropy of -1..1)"},
        {RUN "2\n1\n" LAYER "1.4 1 2 0.9 -1e-9\n",
         "x.mci:10: layer 2: d = -1e-9 (expected a thickness of 0..1e30 cm)"},
        {ONE LAYER "0\n", "x.mci:10: n below = 0 (expected a refractive index of 0.01..100)"},
    };
    CHECK_ALL(state, table);
}

static void names_that_cannot_be_files(void **state)
{
    static const struct refusal table[] = {
        {HEAD "\"\" A\n", "x.mci:3: output name is missing (expected a file name of 1..250 bytes)"},
        {HEAD "\"a.mco A\n", "x.mci:3: output name = \"a.mco (expected a file name of 1..250 bytes)"},
        {HEAD "results/ A\n", "x.mci:3: output name = results/ (expected a file name of 1..250 bytes)"},
        {HEAD ".. A\n", "x.mci:3: output name = .. (expected a file name of 1..250 bytes)"},
        {HEAD "\"a\tb\" A\n",
         "x.mci:3: output name = a\tb (expected a file name without control characters)"},
        {HEAD "a.mco C\n", "x.mci:3: format = C (expected A or B)"},
        {HEAD "a.mco ASCII\n", "x.mci:3: format = ASCII (expected A or B)"},
        {HEAD "my file.mco A\n", "x.mci:3: format = file.mco (expected A or B)"},
        {"1.0\n3\na A\n1\n1 1\n1 1 1\n1\n1\n1 1 1 0 1\n1\nb A\n1\n1 1\n1 1 1\n1\n1\n1 1 1 0 1\n1\na B\n",
         "x.mci:19: output name = a (expected another name than that of the run in line 3)"},
    };
    CHECK_ALL(state, table);
}

static void heightfields_that_are_none(void **state)
{
    static const struct refusal table[] = {
        {ONE "b\n",
         "x.mci:9: boundary 0: n is missing (expected a whole number of 1..1e7, or a file name in quotes)"},
        {ONE "b # nothing\n",
         "x.mci:9: boundary 0: n is missing (expected a whole number of 1..1e7, or a file name in quotes)"},
        {ONE "b 0\n",
         "x.mci:9: boundary 0: n = 0 (expected a whole number of 1..1e7, or a file name in quotes)"},
        {ONE "b 2.5 0 1\n",
         "x.mci:9: boundary 0: n = 2.5 (expected a whole number of 1..1e7, or a file name in quotes)"},
        {ONE "b 100000000 0 1\n",
         "x.mci:9: boundary 0: n = 100000000 (expected a whole number of 1..1e7, or a file name in quotes)"},
        {ONE "b 10000000 0 1\n",
         "x.mci:9: boundary 0: h1 is missing (expected 2*n = 20000000 numbers after n, found 2)"},
        {ONE "b 2 0 1 0\n", "x.mci:9: boundary 0: s1 is missing (expected 2*n = 4 numbers after n, found 3)"},
        {ONE "b 2 0 1\n0 1\n",
         "x.mci:9: boundary 0: h1 is missing (expected 2*n = 4 numbers after n, found 2)"},
        {ONE "b 2 0 1 0 end\n",
         "x.mci:9: boundary 0: s1 = end (expected a number, although the last spacing has no effect)"},
        {ONE "b 2 0 1 0 1 0\n", "x.mci:9: boundary 0: number after the last spacing = 0 (expected the end, "
                                "because n = 2 takes 4 numbers)"},
        {ONE "b 2 0 0 0 1\n", "x.mci:9: boundary 0: s0 = 0 (expected a spacing of 1e-30..1e30 cm)"},
        {ONE "b 2 0 -1 0 1\n", "x.mci:9: boundary 0: s0 = -1 (expected a spacing of 1e-30..1e30 cm)"},
        {ONE "b 2 high 1 0 1\n", "x.mci:9: boundary 0: h0 = high (expected a height of -1e30..1e30 cm)"},
        {ONE "b 2 0 1 nan 1\n", "x.mci:9: boundary 0: h1 = nan (expected a height of -1e30..1e30 cm)"},
        {ONE "b 3 0 1 0 1e-17 0 1\n",
         "x.mci:9: boundary 0: s1 = 1e-17 (expected a spacing that takes the radius further, up to 1e30 cm)"},
        {ONE "b 3 0 1e30 0 1e30 0 1\n",
         "x.mci:9: boundary 0: s1 = 1e30 (expected a spacing that takes the radius further, up to 1e30 cm)"},
        {ONE LAYER "#@ b 1 0\n1\n",
         "x.mci:10: boundary 1: s0 is missing (expected 2*n = 2 numbers after n, found 1)"},
        {ONE "b heights.txt\n", "x.mci:9: boundary 0: n = heights.txt (expected a whole number of 1..1e7, or "
                                "a file name in quotes)"},
        {ONE "b \"heights.txt\n",
         "x.mci:9: boundary 0: file = \"heights.txt (expected a file name in a pair of quotes)"},
        {ONE "b \"\"\n", "x.mci:9: boundary 0: file is missing (expected a file name in a pair of quotes)"},
        {ONE "b \"heights.txt\" in mm\n",
         "x.mci:9: boundary 0: text after the file name = in (expected the end of the line or a comment)"},
        {ONE "b \"nowhere.txt\"\n",
         "x.mci:9: boundary 0: nowhere.txt: cannot be read: No such file or directory (expected a file)"},
    };
    CHECK_ALL(state, table);
}

static void height_files_that_are_wrong(void **state)
{
    static const struct refusal table[] = {
        {"", "x.mci:9: boundary 0: h.txt: n is missing (expected a whole number of 1..1e7)"},
        {"# n\nx\n", "x.mci:9: boundary 0: h.txt:2: n = x (expected a whole number of 1..1e7)"},
        {"2\n0 1\n0\n",
         "x.mci:9: boundary 0: h.txt:3: s1 is missing (expected 2*n = 4 numbers after n, found 3)"},
        {"2\n0 1\n# second\n0 end\n", "x.mci:9: boundary 0: h.txt:4: s1 = end (expected a number, although "
                                      "the last spacing has no effect)"},
        {"2\n0 1\n0 1\n\n9\n",
         "x.mci:9: boundary 0: h.txt:5: number after the last spacing = 9 (expected the end, "
         "because n = 2 takes 4 numbers)"},
        {"2\n0 1\n0 1 the end\n",
         "x.mci:9: boundary 0: h.txt:3: number after the last spacing = the (expected the "
         "end, because n = 2 takes 4 numbers)"},
        {"3\n0 1\n0\n0\n0 1\n",
         "x.mci:9: boundary 0: h.txt:4: s1 = 0 (expected a spacing of 1e-30..1e30 cm)"},
        {"3\n0 1\n0 1e-17\n\n0 1\n", "x.mci:9: boundary 0: h.txt:3: s1 = 1e-17 (expected a spacing that "
                                     "takes the radius further, up to 1e30 cm)"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        const struct refusal refusal = {ONE "b \"h.txt\"\n" LAYER "1\n", table[i].message};
        case_write(state, "h.txt", table[i].text);
        check_all(state, &refusal, 1);
    }
    case_remove(state, "h.txt");
}

static void meshes_that_cannot_be_read(void **state)
{
    static const struct refusal table[] = {
        {ONE "m\n", "x.mci:9: boundary 0: file is missing (expected a file name in a pair of quotes)"},
        {ONE "m \"\"\n", "x.mci:9: boundary 0: file is missing (expected a file name in a pair of quotes)"},
        {ONE "m \"skin.obj\n",
         "x.mci:9: boundary 0: file = \"skin.obj (expected a file name in a pair of quotes)"},
        {ONE "m \"skin.gsf\" up=y\n", "x.mci:9: boundary 0: up = y (expected z or -z for a heightmap)"},
        {ONE "m \"skin.gsf\"\n",
         "x.mci:9: boundary 0: skin.gsf: cannot be read: No such file or directory (expected a file)"},
        {ONE "m \"skin.asc\"\n",
         "x.mci:9: boundary 0: skin.asc: cannot be read: No such file or directory (expected a file)"},
        {ONE "m \"skin\"\n", "x.mci:9: boundary 0: file = skin (expected an .obj, .stl or .ply "
                             "mesh, a .gsf or .asc heightmap, or the word gaussian)"},
        {ONE "m \"a.obj\" units=inch\n", "x.mci:9: boundary 0: units = inch (expected cm, mm, um or m)"},
        {ONE "m \"a.obj\" unit=mm\n",
         "x.mci:9: boundary 0: option = unit=mm (expected up=, rotate=, units=, "
         "scale=, weld=, shift=, normals=, skirt=, tile, tile=mirror or tile=as-is)"},
        {ONE "m \"a.obj\" mm\n", "x.mci:9: boundary 0: option = mm (expected up=, rotate=, units=, scale=, "
                                 "weld=, shift=, normals=, skirt=, tile, tile=mirror or tile=as-is)"},
        {ONE "m \"a.obj\" scale=0\n", "x.mci:9: boundary 0: scale = 0 (expected a number of 1e-30..1e30)"},
        {ONE "m \"a.obj\" scale=-1\n", "x.mci:9: boundary 0: scale = -1 (expected a number of 1e-30..1e30)"},
        {ONE "m \"a.obj\" scale=\n",
         "x.mci:9: boundary 0: scale is missing (expected a number of 1e-30..1e30)"},
        {ONE "m \"a.obj\" scale=1 scale=2\n",
         "x.mci:9: boundary 0: scale = 2 (expected this option only once)"},
        {ONE "m \"a.obj\" shift=1,2\n",
         "x.mci:9: boundary 0: shift = 1,2 (expected x,y,z in cm without blanks)"},
        {ONE "m \"a.obj\" shift=1,2,3,4\n",
         "x.mci:9: boundary 0: shift = 1,2,3,4 (expected x,y,z in cm without blanks)"},
        {ONE "m \"a.obj\" shift=1, 2, 3\n",
         "x.mci:9: boundary 0: shift = 1, (expected x,y,z in cm without blanks)"},
        {ONE "m \"a.obj\" up=h\n", "x.mci:9: boundary 0: up = h (expected z, -z, y, -y, x or -x)"},
        {ONE "m \"a.obj\" rotate=east\n",
         "x.mci:9: boundary 0: rotate = east (expected degrees of -360..360)"},
        {ONE "m \"a.obj\" rotate=361\n", "x.mci:9: boundary 0: rotate = 361 (expected degrees of -360..360)"},
        {ONE "m \"a.obj\" skirt=0\n", "x.mci:9: boundary 0: skirt = 0 (expected a width of 1e-30..1e30 cm)"},
        {ONE "m \"skin.gsf\" rotate=90\n",
         "x.mci:9: boundary 0: rotate = 90 (expected no rotate= for a heightmap)"},
        {ONE "m \"skin.asc\" skirt=0.1\n", "x.mci:9: boundary 0: skirt = 0.1 (expected no skirt= for a "
                                           "heightmap, which has one, or needs none)"},
        {ONE "m \"skin.asc\" weld=0.1\n",
         "x.mci:9: boundary 0: weld = 0.1 (expected no weld= for a heightmap, whose corners meet)"},
        {ONE "m \"skin.PLY\"\n",
         "x.mci:9: boundary 0: skin.PLY: cannot be read: No such file or directory (expected a file)"},
        {ONE "m \"a.obj\" normals=smooth\n",
         "x.mci:9: boundary 0: normals = smooth (expected face or vertex)"},
        {ONE "m \"nowhere.obj\"\n",
         "x.mci:9: boundary 0: nowhere.obj: cannot be read: No such file or directory (expected a file)"},
    };
    CHECK_ALL(state, table);
}

static void beams_that_are_none(void **state)
{
    static const struct refusal table[] = {
        {NAME "beam\n", "x.mci:4: beam: shape is missing (expected pencil, disk R, gaussian R, ring R1 R2, "
                        "rectangle W H, rectangle tile, image \"FILE.gsf\" or port NAME)"},
        {NAME "beam square 1\n", "x.mci:4: beam: shape = square (expected pencil, disk R, gaussian R, ring "
                                 "R1 R2, rectangle W H, rectangle tile, image \"FILE.gsf\" or port NAME)"},
        {NAME "beam disk\n", "x.mci:4: beam: radius is missing (expected a length of 1e-30..1e30 cm)"},
        {NAME "beam disk 0\n", "x.mci:4: beam: radius = 0 (expected a length of 1e-30..1e30 cm)"},
        {NAME "beam gaussian angle=3\n",
         "x.mci:4: beam: radius = angle=3 (expected a length of 1e-30..1e30 cm)"},
        {NAME "beam pencil 1\n",
         "x.mci:4: beam: option = 1 (expected at=, z=, angle=, azimuth=, light=, radial= or share=)"},
        {NAME "beam pencil angle=90\n", "x.mci:4: beam: angle = 90 (expected degrees, 0 <= angle < 90)"},
        {NAME "beam pencil angle=-1\n", "x.mci:4: beam: angle = -1 (expected degrees, 0 <= angle < 90)"},
        {NAME "beam pencil azimuth=361\n", "x.mci:4: beam: azimuth = 361 (expected degrees of -360..360)"},
        {NAME "beam pencil at=1\n", "x.mci:4: beam: at = 1 (expected x,y in cm without blanks)"},
        {NAME "beam pencil tilt=1\n",
         "x.mci:4: beam: option = tilt=1 (expected at=, z=, angle=, azimuth=, light=, radial= or share=)"},
        {NAME "#@ beam pencil angle=1 angle=1\n",
         "x.mci:4: beam: angle = 1 (expected this option only once)"},
        {NAME "beam ring 1\n", "x.mci:4: beam: r2 is missing (expected a length of 1e-30..1e30 cm)"},
        {NAME "beam rectangle 0 1\n", "x.mci:4: beam: w = 0 (expected a length of 1e-30..1e30 cm)"},
        {NAME "beam image\n", "x.mci:4: beam: file is missing (expected a file name in a pair of quotes)"},
        {NAME "beam pencil z=deep\n", "x.mci:4: beam: z = deep (expected a coordinate of -1e30..1e30 cm)"},
        {NAME "beam pencil z=1 angle=181\n", "x.mci:4: beam: angle = 181 (expected degrees of 0..180)"},
        {NAME "beam pencil share=0\n", "x.mci:4: beam: share = 0 (expected a share of 1e-30..1e30)"},
        {NAME "beam pencil radial=axis\n", "x.mci:4: beam: radial = axis (expected radial=beam)"},
        {NAME "beam pencil light=laser\n",
         "x.mci:4: beam: light = laser (expected parallel, na:N, lambertian, "
         "isotropic or a file in quotes)"},
        {NAME "beam pencil light=na:0\n",
         "x.mci:4: beam: light = na:0 (expected a numerical aperture of 1e-30..100)"},
    };
    CHECK_ALL(state, table);
}

/* Header of a .gsf heightmap. NUL bytes up to a multiple of 4 and the pixels follow. */
#define FIELD "Gwyddion Simple Field 1.0\n"
#define SIZES "XRes = 2\nYRes = 2\n"
#define LENGTHS "XReal = 1\nYReal = 1\nXYUnits = cm\n"
static void write_image(void **state, const char *header, size_t bytes, const float pixels[4])
{
    char file[256] = {0};
    const size_t size = strlen(header), begin = (size / 4 + 1) * 4;
    memcpy(file, header, size);
    memcpy(file + begin, pixels, 16);
    case_write_bytes(state, "p.gsf", file, bytes ? begin + bytes : size);
}

static void images_that_are_wrong(void **state)
{
    static const struct {
        const char *header;
        size_t bytes; /* bytes of pixels; 0: no NUL bytes either */
        float pixels[4];
        const char *message;
    } table[] = {
        {"", 0, {0}, "p.gsf:1: no such file format (expected \"Gwyddion Simple Field 1.0\")"},
        {FIELD SIZES LENGTHS,
         0,
         {0},
         "p.gsf: no NUL byte ends the header (expected one, and then the pixels)"},
        {FIELD "XRes = 1\n", 16, {1}, "p.gsf:2: XRes = 1 (expected a whole number of 2 or more)"},
        {FIELD "XRes = 2\n" LENGTHS, 16, {1}, "p.gsf: YRes is missing (expected the number of rows)"},
        {FIELD SIZES, 16, {1}, "p.gsf: XReal is missing (expected the width)"},
        {FIELD SIZES "XReal = 1\n", 16, {1}, "p.gsf: YReal is missing (expected the height)"},
        {FIELD SIZES "XReal = 1\nYReal = 1\n",
         16,
         {1},
         "p.gsf: XYUnits is missing (expected the unit of XReal)"},
        {FIELD SIZES LENGTHS, 12, {1}, "p.gsf: 12 bytes of pixels behind byte 80 (expected 16: 4 x 2 x 2)"},
        {FIELD SIZES LENGTHS, 16, {1, 0, 2, -3}, "p.gsf: pixel = -3 in row 2, column 2 (expected 0 or more)"},
        {FIELD SIZES LENGTHS,
         16,
         {1, NAN, 2, 3},
         "p.gsf: pixel = nan in row 1, column 2 (expected 0 or more)"},
        {FIELD SIZES LENGTHS, 16, {INFINITY}, "p.gsf: pixel = inf in row 1, column 1 (expected 0 or more)"},
        {FIELD SIZES LENGTHS, 16, {0}, "p.gsf: pixels = all 0 (expected light in one of them at least)"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        struct cml_error err;
        struct cml_scene_list list;
        char expected[256];
        snprintf(expected, sizeof expected, "x.mci:4: beam: %s", table[i].message);
        write_image(state, table[i].header, table[i].bytes, table[i].pixels);
        assert_int_equal(case_read(state, NAME "beam image \"p.gsf\"\n", &list, &err), CML_E_INPUT);
        case_remove(state, "p.gsf");
        assert_string_equal(err.text, expected);
    }
}

static void maps_that_are_none(void **state)
{
    static const struct refusal table[] = {
        {NAME "map\n", "x.mci:4: map: nx is missing (expected a whole number of 1..1e9)"},
        {NAME "map 0 1 1 1\n", "x.mci:4: map: nx = 0 (expected a whole number of 1..1e9)"},
        {NAME "map 2 1.5 1 1\n", "x.mci:4: map: ny = 1.5 (expected a whole number of 1..1e9)"},
        {NAME "map 2 2 0 1\n", "x.mci:4: map: dx = 0 (expected a length of 1e-30..1e30 cm)"},
        {NAME "map 2 2 1 # 1\n", "x.mci:4: map: dy is missing (expected a length of 1e-30..1e30 cm)"},
        {NAME "map 2 2 1 -1\n", "x.mci:4: map: dy = -1 (expected a length of 1e-30..1e30 cm)"},
        {NAME "map 2 2 1 1 cube\n", "x.mci:4: map: option = cube (expected angles, volume or top=)"},
        {NAME "map 2 2 1 1 top=1\n", "x.mci:4: map: top = 1 (expected volume beside it)"},
        {NAME "map 2 2 1 1 volume top=\n",
         "x.mci:4: map: top is missing (expected a depth of -1e30..1e30 cm)"},
        {NAME "map 2 2 1 1\n100\n#@ map 2 2 1 1\n",
         "x.mci:6: line = #@ map 2 2 1 1 (expected one map line per run)"},
        {NAME "facets 1\n", "x.mci:4: text after facets = 1 (expected the end of the line or a comment)"},
        {NAME "facets\nfacets\n", "x.mci:5: line = facets (expected one facets line per run)"},
        {NAME "fluence 1\n", "x.mci:4: fluence: option = 1 (expected time)"},
        {NAME "fluence time x\n", "x.mci:4: fluence: option = x (expected time)"},
        {NAME "fluence time\n100\n1 1\n2 2 1\n1\n1\n1 1 1 0 1\n1\n",
         "x.mci:4: fluence = time (expected a time line in the same run)"},
        {NAME "time 1 1000\nfluence time\n100\n1 1\n32 33 1\n1\n1\n1 1 1 0 1\n1\n",
         "x.mci:5: fluence time: nz nr gates = 32 33 1000 (expected at most 1048576 bins of r, z and time, "
         "nz times nr times gates)"},
        {NAME "fluence # all of it\n#@ fluence\n",
         "x.mci:5: line = #@ fluence (expected one fluence line per run)"},
        {NAME "fluence\n100\n1 1\n8192 8192 1\n1\n1\n1 1 1 0 1\n1\n",
         "x.mci:4: fluence: nz nr = 8192 8192 (expected at most 67108863 bins, (nz + 2) times (nr + 1))"},
        {NAME "time\n", "x.mci:4: time: T1 is missing (expected a time of 1e-6..1e12 ps)"},
        {NAME "time 0 5\n", "x.mci:4: time: T1 = 0 (expected a time of 1e-6..1e12 ps)"},
        {NAME "time 1e13 5\n", "x.mci:4: time: T1 = 1e13 (expected a time of 1e-6..1e12 ps)"},
        {NAME "time nan 5\n", "x.mci:4: time: T1 = nan (expected a time of 1e-6..1e12 ps)"},
        {NAME "time 100 # 5\n",
         "x.mci:4: time: number of gates is missing (expected a whole number of 1..100000)"},
        {NAME "time 100 0\n", "x.mci:4: time: number of gates = 0 (expected a whole number of 1..100000)"},
        {NAME "time 100 100001\n",
         "x.mci:4: time: number of gates = 100001 (expected a whole number of 1..100000)"},
        {NAME "time 100 5 7\n", "x.mci:4: time: option = 7 (expected radii)"},
        {NAME "time 100 5\n#@ time 100 5\n",
         "x.mci:5: line = #@ time 100 5 (expected one time line per run)"},
        {NAME "directions\n", "x.mci:4: directions: NT is missing (expected a whole number of 1..3600)"},
        {NAME "directions 0 5\n", "x.mci:4: directions: NT = 0 (expected a whole number of 1..3600)"},
        {NAME "directions 5 3601\n", "x.mci:4: directions: NP = 3601 (expected a whole number of 1..3600)"},
        {NAME "directions 5 5\ndirections 5 5\n",
         "x.mci:5: line = directions 5 5 (expected one directions line per run)"},
        {NAME "map 30000 30000 1 1\n1\n1 1\n1 1 1\n1\n1\n" LAYER "1\n",
         "x.mci:4: map: nx ny = 30000 30000 (expected at most 2^31 cells in maps and volume together, not "
         "3.6e+09 (80.5 GiB))"},
        {NAME "map 20000 20000 1 1 angles volume\n1\n1 1\n10 1 10\n1\n1\n" LAYER "1\n",
         "x.mci:4: map: nx ny = 20000 20000 (expected at most 2^31 cells in maps and volume together, not "
         "2e+10 (447 GiB))"},
    };
    CHECK_ALL(state, table);
}

static void detectors_that_are_none(void **state)
{
    static const struct refusal table[] = {
        {NAME "detector\n", "x.mci:4: detector: shape is missing (expected disk R, ring R1 R2, rectangle W "
                            "H, map NX NY DX DY, port NAME or "
                            "table \"FILE\")"},
        {NAME "detector table\n",
         "x.mci:4: detector: file is missing (expected the name of a file with a detector in each line)"},
        {NAME "detector table \"none.txt\" na=1\n",
         "x.mci:4: detector: text after the file = na=1 (expected the "
         "end of the line or a comment)"},
        {NAME "detector disk 0\n", "x.mci:4: detector: radius = 0 (expected a length of 1e-30..1e18 cm)"},
        {NAME "detector ring 2 2\n", "x.mci:4: detector: r1 r2 = 2 2 (expected r1 < r2)"},
        {NAME "detector map 3 0 1 1\n", "x.mci:4: detector: ny = 0 (expected a whole number of 1..1e9)"},
        {NAME "detector disk 1 side=left\n", "x.mci:4: detector: side = left (expected top or bottom)"},
        {NAME "detector disk 1 na=0\n",
         "x.mci:4: detector: na = 0 (expected a numerical aperture of 1e-30..100)"},
        {NAME "detector disk 1 angle=20\n",
         "x.mci:4: detector: angle = without na (expected na= beside it: else all directions are seen)"},
        {NAME "detector disk 1 na=1 angle=91\n", "x.mci:4: detector: angle = 91 (expected degrees of 0..90)"},
        {NAME "detector disk 1 diffuse=1\n",
         "x.mci:4: detector: diffuse = 1 (expected the word diffuse alone)"},
        {NAME "detector disk 1 at=1\n", "x.mci:4: detector: at = 1 (expected x,y in cm without blanks)"},
        {NAME "detector disk 1 name=a-b\n",
         "x.mci:4: detector: name = a-b (expected 1 to 24 letters, digits and underscores)"},
        {NAME "detector disk 1 name=a_t\n",
         "x.mci:4: detector: name = a_t (expected a name that does not end in _t, as names of results do)"},
        {NAME "detector disk 1 name=a_momentum\n", "x.mci:4: detector: name = a_momentum (expected a name "
                                                   "that does not end in _momentum, as names of results do)"},
        {NAME "detector disk 1 name=a_dmus\n", "x.mci:4: detector: name = a_dmus (expected a name that does "
                                               "not end in _dmus, as names of results do)"},
        {NAME "detector disk 1 name=a_se\n",
         "x.mci:4: detector: name = a_se (expected a name that does not end in _se, as names of results do)"},
        {NAME "detector disk 1 2\n", "x.mci:4: detector: option = 2 (expected at=, z=, side=, na=, angle=, "
                                     "azimuth=, diffuse, name= or group=)"},
        {NAME "detector disk 1 name=2\ndetector disk 2\n1\n1 1\n1 1 1\n1\n1\n" LAYER "1\n",
         "x.mci:5: detector: name = 2 (expected another name than that of the detector in line 4)"},
        {NAME "detector map 20000 20000 1 1\ndetector map 20000 20000 1 1\ndetector map 20000 20000 1 1\n"
              "1\n1 1\n1 1 1\n1\n1\n" LAYER "1\n",
         "x.mci:6: detector: nx ny = 20000 20000 (expected at most 2^30 pixels in all detectors together)"},
    };
    CHECK_ALL(state, table);
}

static void lines_in_the_wrong_place(void **state)
{
    static const struct refusal table[] = {
        {"#@ b 1 0 0\n" HEAD, "x.mci:1: line = #@ b 1 0 0 (expected file version; a boundary line stands "
                              "before the layer, or the n below, whose top it is)"},
        {HEAD "#@ beam pencil\n", "x.mci:3: line = #@ beam pencil (expected output name; a beam line stands "
                                  "between a run's first line and its number of layers)"},
        {NAME "b 1 0 0\n", "x.mci:4: line = b 1 0 0 (expected photons; a boundary line stands before the "
                           "layer, or the n below, whose top it is)"},
        {BINS "m \"a.obj\"\n", "x.mci:6: line = m \"a.obj\" (expected nz nr na; a boundary line stands "
                               "before the layer, or the n below, whose top it is)"},
        {RUN "1\nb 1 0 0\n1\n", "x.mci:8: line = b 1 0 0 (expected n above; a boundary line stands before "
                                "the layer, or the n below, whose top it is)"},
        {RUN "1\nbeam pencil\n", "x.mci:8: line = beam pencil (expected n above; a beam line stands between "
                                 "a run's first line and its number of layers)"},
        {ONE "beam pencil\n", "x.mci:9: line = beam pencil (expected layer 1; a beam line stands between a "
                              "run's first line and its number of layers)"},
        {ONE "b 1 0 0\n#@ b 1 0 0\n",
         "x.mci:10: line = #@ b 1 0 0 (expected one line for boundary 0, which already has line 9)"},
        {ONE LAYER "b 1 0 0\nm \"a.obj\"\n",
         "x.mci:11: line = m \"a.obj\" (expected one line for boundary 1, which already has line 10)"},
        {GOOD "b 1 0 0\n", "x.mci:11: line = b 1 0 0 (expected the end of the run; a boundary line stands "
                           "before the layer, or the n below, whose top it is)"},
        {GOOD "beam pencil\n",
         "x.mci:11: line = beam pencil (expected the end of the run; a beam line stands "
         "between a run's first line and its number of layers)"},
        {HEAD "#@ map 10 10 1 1\n", "x.mci:3: line = #@ map 10 10 1 1 (expected output name; a map line "
                                    "stands between a run's first line and its number of layers)"},
        {ONE "facets\n", "x.mci:9: line = facets (expected layer 1; a facets line stands between a run's "
                         "first line and its number of layers)"},
        {ONE "time 1 1\n", "x.mci:9: line = time 1 1 (expected layer 1; a time line stands between a run's "
                           "first line and its number of layers)"},
        {ONE "fluence\n", "x.mci:9: line = fluence (expected layer 1; a fluence line stands between a run's "
                          "first line and its number of layers)"},
        {NAME "#@ baem disk 1\n",
         "x.mci:4: line = #@ baem disk 1 (expected b, m, rough, face, port, i, phase, backing, beam, map, "
         "facets, time, directions, fluence, detector or photons behind #@)"},
        {NAME "#@baem disk 1\n", "x.mci:4: line = #@baem disk 1 (expected b, m, rough, face, port, i, phase, "
                                 "backing, beam, map, facets, "
                                 "time, directions, fluence, detector or photons behind #@)"},
    };
    CHECK_ALL(state, table);
}

static void missing_input_file(void **state)
{
    struct cml_scene_list list = {.count = 7};
    struct cml_error err;
    char path[256];
    case_path(state, "none.mci", path);
    assert_int_equal(cml_mci_read(path, NULL, &list, &err), CML_E_INPUT);
    case_normalise(state, err.text);
    assert_string_equal(err.text, "none.mci: cannot be read: No such file or directory (expected a file)");
    assert_null(list.scenes);
    assert_int_equal(list.count, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_that_end_early),        cmocka_unit_test(lines_too_short_or_too_long),
        cmocka_unit_test(words_where_numbers_belong),  cmocka_unit_test(numbers_out_of_range),
        cmocka_unit_test(names_that_cannot_be_files),  cmocka_unit_test(heightfields_that_are_none),
        cmocka_unit_test(height_files_that_are_wrong), cmocka_unit_test(meshes_that_cannot_be_read),
        cmocka_unit_test(beams_that_are_none),         cmocka_unit_test(maps_that_are_none),
        cmocka_unit_test(detectors_that_are_none),     cmocka_unit_test(lines_in_the_wrong_place),
        cmocka_unit_test(images_that_are_wrong),       cmocka_unit_test(missing_input_file),
    };
    return cmocka_run_group_tests_name("mci_errors", tests, case_setup, case_teardown);
}
