/* Reader and writer of Gwyddion Simple Field files: a text header, then floats. SPDX-License-Identifier: MIT
 */
#include "input/mesh/gsf.h"

#include "base/atomic_file.h"
#include "input/mesh/numbers.h"

#include <math.h>
#include <string.h>

static const char magic[] = "Gwyddion Simple Field 1.0\n";

struct field {
    struct cml_text text;
    size_t header; /* bytes before the first NUL byte */
    int xres, yres;
    double xreal, yreal;
    double xy_unit, z_unit; /* cm per unit; 0: not in the file */
    bool pixels;            /* the values are pixels: they have no unit, and the caller checks them */
    struct cml_error *err;
};

/* Refuses a word in the header of a Gwyddion map, with file and line. */
static cml_status fail(const struct field *f, const char *name, const char *value, const char *expected)
{
    return cml_fail_field(f->err, f->text.path, f->text.line, name, value, expected);
}

/* Returns the word for the values of the file, for messages. */
static const char *values_of(const struct field *f)
{
    return f->pixels ? "pixels" : "heights";
}

/* Removes the blanks around a name or a value, and returns where it begins. */
static char *trim(char *text)
{
    text += strspn(text, " \t");
    size_t length = strlen(text);
    while (length > 0 && strchr(" \t", text[length - 1])) text[--length] = '\0';
    return text;
}

/* Reads XRes or YRes. At least 2: a single row or column has no slope along the other axis. */
static cml_status read_resolution(const struct field *f, const char *name, const char *value, int *resolution)
{
    if (*resolution != 0) return fail(f, name, value, "this line only once");
    if (cml_parse_int(value, resolution) && *resolution >= 2) return CML_OK;
    return fail(f, name, value, "a whole number of 2 or more");
}

/* Reads the width or height of a Gwyddion map. *size is 0 until the line was seen, so that a second line is
 * refused. */
static cml_status read_size(const struct field *f, const char *name, const char *value, double *size)
{
    if (*size != 0) return fail(f, name, value, "this line only once");
    if (cml_parse_double(value, size) && *size >= 1e-30 && *size <= 1e30) return CML_OK;
    return fail(f, name, value, "a length of 1e-30..1e30");
}

/* Reads a unit of length. The two bytes before the m are the micro sign and the Greek letter mu, in UTF-8. */
static cml_status read_unit(const struct field *f, const char *name, const char *value, double *unit)
{
    static const struct {
        const char *name;
        double cm;
    } units[] = {{"m", 100},          {"dm", 10},          {"cm", 1},    {"mm", 0.1},  {"um", 1e-4},
                 {"\xc2\xb5m", 1e-4}, {"\xce\xbcm", 1e-4}, {"nm", 1e-7}, {"pm", 1e-10}};
    if (*unit != 0) return fail(f, name, value, "this line only once");
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (strcmp(value, units[i].name) == 0) *unit = units[i].cm;
    return *unit > 0 ? CML_OK : fail(f, name, value, "a unit of length: m, dm, cm, mm, um, nm or pm");
}

/* Reads a header line. Fields that are not needed here may have any name. */
static cml_status read_line(struct field *f, char *line)
{
    char *equals = strchr(line, '=');
    if (!equals) return fail(f, "header line", line, "name = value");
    *equals = '\0';
    const char *name = trim(line), *value = trim(equals + 1);
    if (strcmp(name, "XRes") == 0) return read_resolution(f, name, value, &f->xres);
    if (strcmp(name, "YRes") == 0) return read_resolution(f, name, value, &f->yres);
    if (strcmp(name, "XReal") == 0) return read_size(f, name, value, &f->xreal);
    if (strcmp(name, "YReal") == 0) return read_size(f, name, value, &f->yreal);
    if (strcmp(name, "XYUnits") == 0) return read_unit(f, name, value, &f->xy_unit);
    if (strcmp(name, "ZUnits") == 0 && !f->pixels) return read_unit(f, name, value, &f->z_unit);
    return CML_OK;
}

/* Reads the header, which ends at the first NUL byte; all before it is text. */
static cml_status read_header(struct field *f)
{
    const size_t size = sizeof magic - 1;
    struct cml_text *text = &f->text;
    f->header = strlen(text->data);
    if (text->size < size || memcmp(text->data, magic, size) != 0)
        return cml_fail(f->err, CML_E_INPUT,
                        "%s:1: no such file format (expected \"Gwyddion Simple Field 1.0\")", text->path);
    if (f->header == text->size)
        return cml_fail(f->err, CML_E_INPUT,
                        "%s: no NUL byte ends the header (expected one, and then the %s)", text->path,
                        values_of(f));
    (void)cml_text_next(text);
    while (text->cursor < f->header) CML_TRY(read_line(f, cml_text_next(text)));
    return CML_OK;
}

/* Checks that the header gives the size of the map. The format allows sizes to be missing, but slopes would
 * then be a guess. */
static cml_status check_header(const struct field *f)
{
    const char *path = f->text.path, *without = f->pixels ? "" : ", without which slopes are unknown";
    if (f->xres == 0) return cml_fail_field(f->err, path, 0, "XRes", NULL, "the number of columns");
    if (f->yres == 0) return cml_fail_field(f->err, path, 0, "YRes", NULL, "the number of rows");
    if (f->xreal == 0)
        return cml_fail_field(f->err, path, 0, "XReal", NULL, CML_TEXT("the width%s", without));
    if (f->yreal == 0)
        return cml_fail_field(f->err, path, 0, "YReal", NULL, CML_TEXT("the height%s", without));
    return CML_OK;
}

/* Takes the units of the file, or the given one for a file without units. */
static cml_status choose_units(struct field *f, double unit)
{
    const bool inside = f->xy_unit > 0 && f->z_unit > 0, none = f->xy_unit == 0 && f->z_unit == 0;
    const char *path = f->text.path;
    if (f->pixels) {
        f->z_unit = 1;
        return f->xy_unit > 0 ? CML_OK
                              : cml_fail_field(f->err, path, 0, "XYUnits", NULL, "the unit of XReal");
    }
    if (inside && unit == 0) return CML_OK;
    if (!none && unit > 0)
        return cml_fail(f->err, CML_E_INPUT, "%s: the file has its own units (expected no units= beside it)",
                        path);
    if (unit == 0)
        return cml_fail_field(f->err, path, 0, f->xy_unit == 0 ? "XYUnits" : "ZUnits", NULL,
                              "units in the file, or units= on the m line when it has none");
    f->xy_unit = f->z_unit = unit;
    return CML_OK;
}

/* Finds the byte where the heights begin: the next multiple of 4 behind the header; at least one NUL byte
 * lies between. */
static cml_status find_heights(const struct field *f, size_t *begin)
{
    const struct cml_text *text = &f->text;
    *begin = (f->header / 4 + 1) * 4;
    for (size_t i = f->header; i < *begin && i < text->size; i++)
        if (text->data[i] != '\0')
            return cml_fail(f->err, CML_E_INPUT,
                            "%s: byte %zu is not NUL (expected NUL bytes up to byte %zu)", text->path, i + 1,
                            *begin);
    const double expected = 4.0 * f->xres * f->yres;
    const double found = text->size > *begin ? (double)(text->size - *begin) : 0;
    if (found == expected) return CML_OK;
    return cml_fail(f->err, CML_E_INPUT, "%s: %.0f bytes of %s behind byte %zu (expected %.0f: 4 x %d x %d)",
                    text->path, found, values_of(f), *begin, expected, f->xres, f->yres);
}

/* True for a value that no length has in any unit: above 1e30, or below 1e-18 but not 0. */
static bool is_absurd(double value)
{
    return fabs(value) > 1e30 || (value != 0 && fabs(value) < 1e-18);
}

/* Refuses floats in big-endian order. Read in the wrong order, floats lie anywhere between 1e-45 and 1e38:
 * some values are absurd then, and none is with its bytes reversed. */
static cml_status check_order(const struct field *f, const char *data, size_t count)
{
    size_t first = count;
    for (size_t i = 0; i < count; i++) {
        if (is_absurd(cml_number_decode(data + 4 * i, CML_FLOAT, true))) return CML_OK;
        if (first == count && is_absurd(cml_number_decode(data + 4 * i, CML_FLOAT, false))) first = i;
    }
    if (first == count) return CML_OK;
    const char *at = data + 4 * first;
    return cml_fail_field(
        f->err, f->text.path, 0,
        CML_TEXT("row %zu, column %zu", first / (size_t)f->xres + 1, first % (size_t)f->xres + 1),
        CML_TEXT("%.4g, or %.4g with its bytes reversed", cml_number_decode(at, CML_FLOAT, false),
                 cml_number_decode(at, CML_FLOAT, true)),
        "floats with the lowest byte first; these look big-endian");
}

/* Refuses missing heights, and heights so large that later products would overflow. */
static cml_status check_heights(const struct field *f, const struct cml_heightmap *map)
{
    const size_t nx = (size_t)map->nx;
    CML_TRY(cml_heightmap_check(f->text.path, map, f->err));
    for (size_t i = 0; i < nx * (size_t)map->ny; i++) {
        if (fabs(map->h[i]) <= CML_HIGHEST_SAMPLE) continue;
        return cml_fail_field(f->err, f->text.path, 0,
                              CML_TEXT("height in row %zu, column %zu", i / nx + 1, i % nx + 1),
                              CML_TEXT("%.7g cm", map->h[i]), "-1e30..1e30 cm");
    }
    return CML_OK;
}

/* Reads the heights. XReal is the width of XRes pixels, each of which has one height. */
static cml_status read_heights(const struct field *f, struct cml_heightmap *map)
{
    const size_t count = (size_t)f->xres * (size_t)f->yres;
    size_t begin = 0;
    CML_TRY(find_heights(f, &begin));
    CML_TRY(check_order(f, f->text.data + begin, count));
    CML_TRY(cml_heightmap_allocate(f->text.path, f->xres, f->yres, map, f->err));
    map->dx = f->xreal / f->xres * f->xy_unit;
    map->dy = f->yreal / f->yres * f->xy_unit;
    for (size_t i = 0; i < count; i++)
        map->h[i] = cml_number_decode(f->text.data + begin + 4 * i, CML_FLOAT, false) * f->z_unit;
    return f->pixels ? CML_OK : check_heights(f, map);
}

/* Reads a .gsf file as a heightmap or, if `pixels`, as an image. On failure the map is empty. */
static cml_status read_file(const struct cml_text_source *source, const char *path, double unit, bool pixels,
                            struct cml_heightmap *map, struct cml_error *err)
{
    struct field f = {.pixels = pixels, .err = err};
    *map = (struct cml_heightmap){0};
    CML_TRY(cml_text_read_bytes(source, path, &f.text, err));
    cml_status status = read_header(&f);
    if (status == CML_OK) status = check_header(&f);
    if (status == CML_OK) status = choose_units(&f, unit);
    if (status == CML_OK) status = read_heights(&f, map);
    cml_text_clear(&f.text);
    if (status == CML_OK)
        cml_heightmap_centre(map);
    else
        cml_heightmap_clear(map);
    return status;
}

cml_status cml_gsf_read(const struct cml_text_source *source, const char *path, double unit,
                        struct cml_heightmap *map, struct cml_error *err)
{
    return read_file(source, path, unit, false, map, err);
}

cml_status cml_gsf_read_pixels(const struct cml_text_source *source, const char *path,
                               struct cml_heightmap *map, struct cml_error *err)
{
    return read_file(source, path, 0, true, map, err);
}

/* Writes a float with the lowest byte first, whatever the machine's order. */
static void write_float(FILE *stream, double value)
{
    const float number = (float)value;
    uint32_t word = 0;
    memcpy(&word, &number, sizeof word);
    for (int i = 0; i < 4; i++) fputc((int)(word >> 8 * i & 255), stream);
}

/* Writes a heightmap as a .gsf file. The format wants the row of the largest y first. */
cml_status cml_gsf_write(const char *path, const struct cml_heightmap *map, struct cml_error *err)
{
    struct cml_file file;
    CML_TRY(cml_file_create_alone(path, &file, err));
    const int header = fprintf(file.stream,
                               "%sXRes = %d\nYRes = %d\nXReal = %.17g\nYReal = %.17g\nXYUnits = cm\n"
                               "ZUnits = cm\n",
                               magic, map->nx, map->ny, map->nx * map->dx, map->ny * map->dy);
    for (int i = 0; i < 4 - header % 4; i++) fputc('\0', file.stream);
    for (int j = map->ny - 1; j >= 0; j--)
        for (int i = 0; i < map->nx; i++)
            write_float(file.stream, map->h[(size_t)j * (size_t)map->nx + (size_t)i]);
    return cml_file_commit(&file, err);
}
