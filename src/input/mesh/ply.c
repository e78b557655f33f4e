/* SPDX-License-Identifier: MIT */
#include "input/mesh/ply.h"

#include "input/mesh/numbers.h"

#include <math.h>
#include <string.h>

/* Elements are tables of rows, and properties their columns of numbers or of lists of numbers. The first ones
 * are used, those called OTHER are not. */
enum element { VERTEX, FACE, OTHER_ELEMENT };
enum use { X, Y, Z, CORNERS, OTHER };

struct property {
    enum cml_number type, length; /* length: type of the lengths of lists */
    bool is_list;
    bool is_first; /* the first property of its element */
    enum use use;
    enum element element;
    uint64_t rows; /* of its element */
};

struct ply {
    struct cml_numbers in;
    struct cml_polygons *polygons;
    enum { ASCII, LITTLE, BIG, UNKNOWN } format;
    double rows[OTHER_ELEMENT + 1];
    bool has_element[OTHER_ELEMENT + 1], has_use[OTHER + 1];
    struct property next; /* as yet without type and use */
    int num_properties;
    struct property property[128];
};

/* Returns the index of a word among the names; `count`: not there. */
static unsigned find(const char *const *names, unsigned count, const char *word)
{
    unsigned i = 0;
    while (i < count && strcmp(word, names[i]) != 0) i++;
    return i;
}

static cml_status read_format(struct ply *ply, const char *name, const char *version)
{
    static const char *const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    ply->format = find(names, UNKNOWN, name);
    if (ply->format == UNKNOWN)
        return cml_numbers_fail(&ply->in, "format", name, "ascii, binary_little_endian or binary_big_endian");
    return strcmp(version, "1.0") == 0 ? CML_OK : cml_numbers_fail(&ply->in, "version", version, "1.0");
}

static cml_status read_element(struct ply *ply, const char *name, const char *rows)
{
    static const char *const names[] = {"vertex", "face"};
    const enum element element = find(names, OTHER_ELEMENT, name);
    ply->next = (struct property){.element = element, .is_first = true};
    if (!cml_parse_count(rows, &ply->next.rows))
        return cml_numbers_fail(&ply->in, "number of rows", rows, "a whole number");
    if (element != OTHER_ELEMENT && ply->has_element[element])
        return cml_numbers_fail(&ply->in, "element", name, "this element only once");
    ply->has_element[element] = true;
    ply->rows[element] = (double)ply->next.rows;
    return CML_OK;
}

static cml_status read_type(const struct ply *ply, const char *word, enum cml_number *type)
{
    static const char *const names[] = {"char",  "uchar",  "short",   "ushort", "int",   "uint",
                                        "float", "double", "int8",    "uint8",  "int16", "uint16",
                                        "int32", "uint32", "float32", "float64"};
    const unsigned i = find(names, 16, word);
    *type = i % 8; /* in the order of enum cml_number */
    return i < 16 ? CML_OK
                  : cml_numbers_fail(&ply->in, "type of the property", word,
                                     "char, uchar, short, ushort, int, uint, float or double");
}

/* length: type of the lengths of lists; "": no lists. */
static cml_status read_property(struct ply *ply, const char *length, const char *type, const char *name)
{
    static const char *const names[] = {"x", "y", "z", "vertex_indices"};
    struct property *new = &ply->property[ply->num_properties];
    if (!ply->has_element[ply->next.element])
        return cml_numbers_fail(&ply->in, "header line", "property", "an element before it");
    if (++ply->num_properties == sizeof ply->property / sizeof *new)
        return cml_numbers_fail(&ply->in, "property", name, "fewer than 128 of them");
    *new = ply->next;
    ply->next.is_first = false;
    new->is_list = *length;
    if (new->is_list) CML_TRY(read_type(ply, length, &new->length));
    CML_TRY(read_type(ply, type, &new->type));
    new->use = strcmp(name, "vertex_index") == 0 ? CORNERS : find(names, OTHER, name);
    const bool is_of_face = new->element == FACE &&new->is_list &&new->type < CML_FLOAT;
    const bool is_of_vertex = new->element == VERTEX && !new->is_list;
    if (new->use == CORNERS ? !is_of_face : !is_of_vertex) new->use = OTHER;
    if (new->use != OTHER && ply->has_use[new->use])
        return cml_numbers_fail(&ply->in, "property", name, "this property only once");
    ply->has_use[new->use] = true;
    return CML_OK;
}

/* Checks that the header has all that is needed. */
static cml_status check_header(const struct ply *ply)
{
    static const char *const needed[] = {"property x of element vertex", "property y of element vertex",
                                         "property z of element vertex",
                                         "property list vertex_indices, of whole numbers, of element face"};
    for (enum use use = X; use <= CORNERS; use++)
        if (!ply->has_use[use]) return cml_numbers_fail(&ply->in, needed[use], NULL, "one in the header");
    if (ply->format != UNKNOWN) return CML_OK;
    return cml_numbers_fail(&ply->in, "line format", NULL, "one in the header");
}

static cml_status read_header(struct ply *ply)
{
    char a[32], b[32], c[32];
    if (!cml_numbers_next_line(&ply->in) || strcmp(ply->in.cursor, "ply") != 0)
        return cml_numbers_fail(&ply->in, "first line", ply->in.cursor, "ply");
    while (cml_numbers_next_line(&ply->in)) {
        const char *line = ply->in.cursor;
        if (sscanf(line, "format %31s %31s", a, b) == 2)
            CML_TRY(read_format(ply, a, b));
        else if (sscanf(line, "element %31s %31s", a, b) == 2)
            CML_TRY(read_element(ply, a, b));
        else if (sscanf(line, "property list %31s %31s %31s", a, b, c) == 3)
            CML_TRY(read_property(ply, a, b, c));
        else if (sscanf(line, "property %31s %31s", a, b) == 2)
            CML_TRY(read_property(ply, "", a, b));
        else if (strncmp(line, "end_header", 10) == 0)
            return check_header(ply);
        else if (strncmp(line, "comment", 7) != 0 && strncmp(line, "obj_info", 8) != 0)
            return cml_numbers_fail(&ply->in, "header line", cml_numbers_word(&ply->in),
                                    "format, element, property, comment or end_header");
    }
    return cml_numbers_fail(&ply->in, "header line", "the end of the file", "end_header");
}

/* Reads a number of a row, or the length of a list and its numbers. */
static cml_status read_numbers(struct ply *ply, const struct property *property, double value[OTHER + 1])
{
    static const char *const names[] = {"x of the vertex", "y of the vertex", "z of the vertex",
                                        "corner of the face", "number of the row"};
    const double most[] = {INFINITY, INFINITY, INFINITY, fmin(ply->rows[VERTEX], UINT32_MAX) - 1, NAN};
    const enum use use = property->use;
    double length = 1;
    if (property->is_list)
        CML_TRY(cml_numbers_take(&ply->in, property->length, "length of a list", UINT32_MAX, &length));
    if (use == CORNERS && length < 3)
        return cml_numbers_fail(&ply->in, "corners of the face", length < 2 ? "below 2" : "2", "3 or more");
    if (use == CORNERS)
        CML_TRY(cml_polygons_add_face(ply->polygons, (uint32_t)length, ply->in.line, ply->in.err));
    for (double i = 0; i < length; i++) {
        CML_TRY(cml_numbers_take(&ply->in, property->type, names[use], most[use], &value[use]));
        if (use != CORNERS) continue;
        CML_TRY(cml_polygons_add_corner(ply->polygons, (uint32_t)value[use], ply->in.err));
    }
    return CML_OK;
}

/* Reads a row, a line of a text. Its properties stand from `begin` to before `end`. */
static cml_status read_row(struct ply *ply, const struct property *begin, const struct property *end)
{
    double value[OTHER + 1] = {0};
    if (!ply->in.binary && !cml_numbers_next_line(&ply->in))
        return cml_numbers_fail(&ply->in, "next line", "the end of the file", "a row of an element");
    for (const struct property *property = begin; property < end; property++)
        CML_TRY(read_numbers(ply, property, value));
    const char *more = ply->in.binary ? NULL : cml_numbers_word(&ply->in);
    if (more) return cml_numbers_fail(&ply->in, "word behind the row", more, "the end of the line");
    if (begin->element != VERTEX) return CML_OK;
    return cml_polygons_add_vertex(ply->polygons, value, ply->in.line, ply->in.err);
}

static cml_status read_rows(struct ply *ply)
{
    const struct property *last = ply->property + ply->num_properties;
    for (const struct property *begin = ply->property, *end; begin < last; begin = end) {
        for (end = begin + 1; end < last && !end->is_first;) end++;
        for (uint64_t row = 0; row < begin->rows; row++) CML_TRY(read_row(ply, begin, end));
    }
    if (ply->in.binary && ply->in.cursor < ply->in.text->data + ply->in.text->size)
        return cml_numbers_fail(&ply->in, "data", "more bytes behind the last row", "the end of the file");
    if (ply->in.binary || !cml_numbers_next_line(&ply->in)) return CML_OK;
    return cml_numbers_fail(&ply->in, "line behind the last row", cml_numbers_word(&ply->in),
                            "the end of the file");
}

/* Goes behind the header, whose last line may end the file. */
static cml_status begin_rows(struct ply *ply)
{
    struct cml_text *text = ply->in.text;
    if (text->cursor > text->size) text->cursor = text->size;
    ply->in.cursor = text->data + text->cursor;
    ply->in.binary = ply->format != ASCII;
    ply->in.big = ply->format == BIG;
    if (ply->in.binary) ply->in.line = 0;
    if (ply->in.binary || strlen(ply->in.cursor) + text->cursor == text->size) return CML_OK;
    return cml_numbers_fail(&ply->in, "data", "a NUL byte", "text without one behind format ascii");
}

/* Each face becomes a triangle or more, which are counted when the polygons have been read. A large mesh is
 * announced once, before its rows are read. */
cml_status cml_ply_read(struct cml_text *text, const struct cml_mesh_budget *budget,
                        struct cml_polygons *polygons, struct cml_error *err)
{
    struct ply ply = {.in = {.text = text, .err = err}, .polygons = polygons, .format = UNKNOWN};
    struct cml_mesh_budget quiet = *budget;
    quiet.on_large = NULL;
    CML_TRY(read_header(&ply));
    CML_TRY(begin_rows(&ply));
    CML_TRY(cml_mesh_budget_check(budget, ply.rows[FACE], CML_POLYGONS_REMEDY, err));
    CML_TRY(read_rows(&ply));
    return cml_mesh_budget_check(&quiet, (double)(polygons->num_corners - 2 * polygons->num_faces),
                                 CML_POLYGONS_REMEDY, err);
}
