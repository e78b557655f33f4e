/* SPDX-License-Identifier: MIT */
#include "input/mesh/ply.h"

#include "base/array.h"
#include "input/mesh/binary_inl.h"

#include <math.h>
#include <string.h>

/* Types of numbers, each with two names. */
static const struct type {
    const char *names[2];
    int size;
    bool is_real, is_signed;
} types[] = {{{"char", "int8"}, 1, false, true},    {{"uchar", "uint8"}, 1, false, false},
             {{"short", "int16"}, 2, false, true},  {{"ushort", "uint16"}, 2, false, false},
             {{"int", "int32"}, 4, false, true},    {{"uint", "uint32"}, 4, false, false},
             {{"float", "float32"}, 4, true, true}, {{"double", "float64"}, 8, true, true}};

enum role { X, Y, Z, CORNER, LENGTH, NONE }; /* of a number: a coordinate, a vertex of a face, or others */
static const char *const role_names[] = {"x of the vertex",    "y of the vertex",  "z of the vertex",
                                         "corner of the face", "length of a list", "number of the row"};

struct property {
    const struct type *type, *length; /* length: type of a list's length; NULL: no list */
    enum role role;
};

/* A table of the file, whose rows have properties first to end - 1. */
struct element {
    enum kind { VERTEX, FACE, OTHER } kind;
    uint64_t rows;
    size_t first, end;
};

struct ply {
    struct cml_text *text;
    struct cml_polygons *polygons;
    struct cml_error *err;
    char *cursor; /* in the line that is read */
    int format;   /* of `formats`; -1: not known yet */
    bool binary;  /* true when the header is read, if the rows are binary */
    struct element *element;
    struct property *property;
    size_t num_elements, num_properties;
    uint64_t num_rows[OTHER];
    bool has_element[OTHER], has_role[NONE];
};

static const char *const formats[] = {"ascii", "binary_little_endian", "binary_big_endian"};

/* Refuses a value. Names the line, or the byte of binary data. */
static cml_status fail(const struct ply *ply, const char *name, const char *value, const char *expected)
{
    char place[80];
    snprintf(place, sizeof place, "byte %zu: %s", ply->text->cursor + 1, name);
    return cml_fail_field(ply->err, ply->text->path, ply->binary ? 0 : ply->text->line,
                          ply->binary ? place : name, value, expected);
}

/* ---- the header ---- */

static cml_status read_format(struct ply *ply)
{
    const char *word = cml_text_word(&ply->cursor), *version = cml_text_word(&ply->cursor);
    for (int i = 0; word && i < 3; i++)
        if (strcmp(word, formats[i]) == 0) ply->format = i;
    if (ply->format < 0) return fail(ply, "format", word, "ascii, binary_little_endian or binary_big_endian");
    return version && strcmp(version, "1.0") == 0 ? CML_OK : fail(ply, "version", version, "1.0");
}

static cml_status read_element(struct ply *ply)
{
    const char *name = cml_text_word(&ply->cursor), *rows = cml_text_word(&ply->cursor);
    struct element element = {.kind = OTHER, .first = ply->num_properties, .end = ply->num_properties};
    if (!rows || !cml_parse_count(rows, &element.rows))
        return fail(ply, "number of rows", rows, "a whole number");
    if (strcmp(name, "vertex") == 0) element.kind = VERTEX;
    if (strcmp(name, "face") == 0) element.kind = FACE;
    if (element.kind != OTHER) {
        if (ply->has_element[element.kind]) return fail(ply, "element", name, "this element only once");
        ply->has_element[element.kind] = true;
        ply->num_rows[element.kind] = element.rows;
    }
    CML_TRY(cml_array_grow(&ply->element, ply->num_elements, sizeof element, "a mesh", ply->err));
    ply->element[ply->num_elements++] = element;
    return CML_OK;
}

static cml_status find_type(const struct ply *ply, const char *word, const struct type **type)
{
    for (size_t i = 0; word && i < sizeof types / sizeof *types; i++)
        for (int k = 0; k < 2; k++)
            if (strcmp(word, types[i].names[k]) == 0) *type = &types[i];
    if (*type) return CML_OK;
    return fail(ply, "type of the property", word, "char, uchar, short, ushort, int, uint, float or double");
}

/* Returns how a property is used. */
static enum role role_of(enum kind kind, const struct property *property, const char *name)
{
    static const char *const axes[] = {"x", "y", "z"};
    for (int k = 0; k < 3; k++)
        if (kind == VERTEX && !property->length && strcmp(name, axes[k]) == 0) return (enum role)k;
    const bool is_corners = strcmp(name, "vertex_indices") == 0 || strcmp(name, "vertex_index") == 0;
    return kind == FACE && property->length && !property->type->is_real && is_corners ? CORNER : NONE;
}

static cml_status read_property(struct ply *ply)
{
    struct property property = {0};
    if (ply->num_elements == 0) return fail(ply, "header line", "property", "an element before it");
    struct element *element = &ply->element[ply->num_elements - 1];
    const char *word = cml_text_word(&ply->cursor);
    if (word && strcmp(word, "list") == 0) {
        CML_TRY(find_type(ply, cml_text_word(&ply->cursor), &property.length));
        word = cml_text_word(&ply->cursor);
    }
    CML_TRY(find_type(ply, word, &property.type));
    const char *name = cml_text_word(&ply->cursor);
    if (!name) return fail(ply, "name of the property", NULL, "a name");
    property.role = role_of(element->kind, &property, name);
    if (property.role != NONE && ply->has_role[property.role])
        return fail(ply, "property", name, "this property only once");
    if (property.role != NONE) ply->has_role[property.role] = true;
    CML_TRY(cml_array_grow(&ply->property, ply->num_properties, sizeof property, "a mesh", ply->err));
    ply->property[ply->num_properties++] = property;
    element->end = ply->num_properties;
    return CML_OK;
}

/* Checks that the header has all that is needed. */
static cml_status check_header(struct ply *ply)
{
    static const char *const needed[] = {"property x of element vertex", "property y of element vertex",
                                         "property z of element vertex",
                                         "property list vertex_indices, of whole numbers, of element face"};
    if (ply->format < 0) return fail(ply, "line format", NULL, "one in the header");
    for (int role = X; role <= CORNER; role++)
        if (!ply->has_role[role]) return fail(ply, needed[role], NULL, "one in the header");
    for (size_t i = 0; i < ply->num_elements; i++)
        if (ply->element[i].rows > 0 && ply->element[i].first == ply->element[i].end)
            return fail(ply, "property of an element", NULL, "one or more for each");
    ply->binary = ply->format > 0;
    return CML_OK;
}

static cml_status read_header(struct ply *ply)
{
    char *line = cml_text_next(ply->text);
    if (!line || strcmp(line, "ply") != 0) return fail(ply, "first line", line, "ply");
    while ((ply->cursor = cml_text_next(ply->text))) {
        const char *word = cml_text_word(&ply->cursor);
        if (!word || strcmp(word, "comment") == 0 || strcmp(word, "obj_info") == 0) continue;
        if (strcmp(word, "end_header") == 0) return check_header(ply);
        if (strcmp(word, "format") == 0)
            CML_TRY(read_format(ply));
        else if (strcmp(word, "element") == 0)
            CML_TRY(read_element(ply));
        else if (strcmp(word, "property") == 0)
            CML_TRY(read_property(ply));
        else
            return fail(ply, "header line", word, "format, element, property, comment or end_header");
    }
    return fail(ply, "header line", "the end of the file", "end_header");
}

/* ---- the rows ---- */

/* Decodes a number of binary data. */
static double decode(const char *data, const struct type *type, bool big)
{
    if (type->is_real) return cml_binary_real(data, type->size, big);
    const uint64_t word = cml_binary_word(data, type->size, big), sign = (uint64_t)1 << (8 * type->size - 1);
    return (double)word - (type->is_signed && word & sign ? 2 * (double)sign : 0);
}

/* Reads the next number. most: the largest number of a corner or length. A number without a role may be
 * anything, but must be there. */
static cml_status read_number(struct ply *ply, const struct type *type, enum role role, double most,
                              double *value)
{
    char shown[40] = "the end of the file", expected[64] = "a finite number";
    const char *word = shown;
    bool good = false;
    if (!ply->binary) {
        word = cml_text_word(&ply->cursor);
        good = word && (role == NONE || cml_parse_double(word, value));
    } else if (ply->text->size - ply->text->cursor >= (size_t)type->size) {
        *value = decode(ply->text->data + ply->text->cursor, type, ply->format == 2);
        snprintf(shown, sizeof shown, "%.10g", *value);
        good = role == NONE || isfinite(*value);
    }
    if (role == CORNER || role == LENGTH) {
        snprintf(expected, sizeof expected, "a whole number of 0..%.0f", most);
        good = good && *value >= 0 && *value <= most && *value == floor(*value);
    }
    if (!good) return fail(ply, role_names[role], word, expected);
    if (ply->binary) ply->text->cursor += (size_t)type->size;
    return CML_OK;
}

/* Reads a property of a row: one number, or the length of a list and its numbers. */
static cml_status read_values(struct ply *ply, const struct property *property, int line, double place[3])
{
    double length = 1, value = 0;
    if (property->length) CML_TRY(read_number(ply, property->length, LENGTH, UINT32_MAX, &length));
    if (property->role == CORNER) {
        if (length < 3) return fail(ply, "corners of the face", length < 2 ? "below 2" : "2", "3 or more");
        CML_TRY(cml_polygons_add_face(ply->polygons, (uint32_t)length, line, ply->err));
    }
    for (double i = 0; i < length; i++) {
        const double most = (double)ply->num_rows[VERTEX] - 1;
        CML_TRY(read_number(ply, property->type, property->role, most, &value));
        if (property->role <= Z) place[property->role] = value;
        if (property->role == CORNER)
            CML_TRY(cml_polygons_add_corner(ply->polygons, (uint32_t)value, ply->err));
    }
    return CML_OK;
}

/* Reads a row: a line of an ascii file. */
static cml_status read_row(struct ply *ply, const struct element *element)
{
    double place[3] = {0};
    if (!ply->binary && !(ply->cursor = cml_text_next(ply->text)))
        return fail(ply, "next line", "the end of the file", "a row of an element");
    const int line = ply->binary ? 0 : ply->text->line;
    for (size_t i = element->first; i < element->end; i++)
        CML_TRY(read_values(ply, &ply->property[i], line, place));
    const char *more = ply->binary ? NULL : cml_text_word(&ply->cursor);
    if (more) return fail(ply, "word behind the row", more, "the end of the line");
    return element->kind == VERTEX ? cml_polygons_add_vertex(ply->polygons, place, line, ply->err) : CML_OK;
}

static cml_status read_rows(struct ply *ply)
{
    for (size_t i = 0; i < ply->num_elements; i++)
        for (uint64_t row = 0; row < ply->element[i].rows; row++) CML_TRY(read_row(ply, &ply->element[i]));
    while (!ply->binary && (ply->cursor = cml_text_next(ply->text))) {
        const char *word = cml_text_word(&ply->cursor);
        if (word) return fail(ply, "line behind the last row", word, "the end of the file");
    }
    if (ply->binary && ply->text->cursor < ply->text->size)
        return fail(ply, "data", "more bytes behind the last row", "the end of the file");
    return CML_OK;
}

/* Reads the file. Each face becomes a triangle or more: its polygons are counted when they have been read.
 * A large mesh is announced once, before its rows are read. */
static cml_status read_file(struct ply *ply, const struct cml_mesh_budget *budget)
{
    struct cml_mesh_budget quiet = *budget;
    quiet.on_large = NULL;
    CML_TRY(read_header(ply));
    if (ply->text->cursor > ply->text->size)
        ply->text->cursor = ply->text->size; /* no line end behind end_header */
    if (!ply->binary && strlen(ply->text->data + ply->text->cursor) + ply->text->cursor < ply->text->size)
        return fail(ply, "data", "a NUL byte", "text without one behind format ascii");
    CML_TRY(cml_mesh_budget_check(budget, (double)ply->num_rows[FACE], CML_POLYGONS_REMEDY, ply->err));
    CML_TRY(read_rows(ply));
    const size_t triangles = ply->polygons->num_corners - 2 * ply->polygons->num_faces;
    return cml_mesh_budget_check(&quiet, (double)triangles, CML_POLYGONS_REMEDY, ply->err);
}

cml_status cml_ply_read(struct cml_text *text, const struct cml_mesh_budget *budget,
                        struct cml_polygons *polygons, struct cml_error *err)
{
    struct ply ply = {.text = text, .polygons = polygons, .err = err, .format = -1};
    const cml_status status = read_file(&ply, budget);
    free(ply.element);
    free(ply.property);
    return status;
}
