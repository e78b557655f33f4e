/* SPDX-License-Identifier: MIT */
#include "input/mesh/stl.h"

#include "input/mesh/binary_inl.h"

#include <math.h>
#include <string.h>
#include <strings.h>

enum { HEADER = 80, START = 84, FACET = 50, NORMAL = 12 }; /* bytes of a binary file */

static const char *const axis[] = {"x of the vertex", "y of the vertex", "z of the vertex"};

/* Adds a facet, whose corners are the last three vertices. */
static cml_status add_facet(struct cml_polygons *polygons, int line, struct cml_error *err)
{
    for (size_t i = polygons->num_vertices - 3; i < polygons->num_vertices; i++)
        CML_TRY(cml_polygons_add_corner(polygons, (uint32_t)i, err));
    return cml_polygons_add_face(polygons, 3, line, err);
}

/* Reads a vertex at a byte of a binary file. */
static cml_status read_floats(const struct cml_text *text, size_t at, double vertex[3], struct cml_error *err)
{
    char name[64], value[32];
    for (int k = 0; k < 3; k++, at += 4) {
        vertex[k] = cml_binary_real(text->data + at, 4, false);
        if (isfinite(vertex[k])) continue;
        snprintf(name, sizeof name, "byte %zu: %s", at + 1, axis[k]);
        snprintf(value, sizeof value, "%g", vertex[k]);
        return cml_fail_field(err, text->path, 0, name, value, "a finite number");
    }
    return CML_OK;
}

static cml_status read_binary(const struct cml_text *text, size_t facets,
                              const struct cml_mesh_budget *budget, struct cml_polygons *polygons,
                              struct cml_error *err)
{
    double vertex[3];
    CML_TRY(cml_mesh_budget_check(budget, (double)facets, CML_POLYGONS_REMEDY, err));
    for (size_t f = 0; f < facets; f++) {
        for (size_t k = 0; k < 3; k++) {
            CML_TRY(read_floats(text, START + FACET * f + NORMAL + 12 * k, vertex, err));
            CML_TRY(cml_polygons_add_vertex(polygons, vertex, 0, err));
        }
        CML_TRY(add_facet(polygons, 0, err));
    }
    return CML_OK;
}

/* Counts the lines that begin with the word facet. */
static size_t count_facets(const struct cml_text *text)
{
    size_t facets = 0;
    for (const char *line = text->data; line; line = strchr(line, '\n')) {
        line += strspn(line, " \t\r\n");
        facets += strncasecmp(line, "facet", 5) == 0;
    }
    return facets;
}

/* Compares the first words of a line with those that must stand there, whatever their case. */
static cml_status expect_words(const struct cml_text *text, char **cursor, const char *const words[2],
                               struct cml_error *err)
{
    for (int i = 0; i < 2 && words[i]; i++) {
        const char *word = cml_text_word(cursor);
        if (!word || strcasecmp(word, words[i]) != 0)
            return cml_fail_field(err, text->path, text->line, "word", word, words[i]);
    }
    return CML_OK;
}

static cml_status read_numbers(const struct cml_text *text, char *cursor, struct cml_polygons *polygons,
                               struct cml_error *err)
{
    double vertex[3];
    for (int k = 0; k < 3; k++) {
        const char *word = cml_text_word(&cursor);
        if (!word || !cml_parse_double(word, &vertex[k]))
            return cml_fail_field(err, text->path, text->line, axis[k], word, "a finite number");
    }
    const char *more = cml_text_word(&cursor);
    if (more)
        return cml_fail_field(err, text->path, text->line, "word behind z", more, "the end of the line");
    return cml_polygons_add_vertex(polygons, vertex, text->line, err);
}

/* Reads a text file line by line. The lines of a facet come in the order of `lines`; `solid` and `endsolid`
 * stand around facets. */
static cml_status read_text(struct cml_text *text, struct cml_polygons *polygons, struct cml_error *err)
{
    static const char *const lines[8][2] = {{"facet", "normal"}, {"outer", "loop"}, {"vertex"},   {"vertex"},
                                            {"vertex"},          {"endloop"},       {"endfacet"}, {"solid"}};
    int step = 7;
    for (char *cursor = cml_text_next(text); cursor; cursor = cml_text_next(text)) {
        cursor += strspn(cursor, " \t");
        if (!*cursor) continue;
        if (step == 0 && strncasecmp(cursor, "endsolid", 8) == 0) {
            step = 7;
            continue;
        }
        CML_TRY(expect_words(text, &cursor, lines[step], err));
        if (step >= 2 && step <= 4) CML_TRY(read_numbers(text, cursor, polygons, err));
        if (step == 6) CML_TRY(add_facet(polygons, text->line, err));
        step = step < 6 ? step + 1 : 0;
    }
    if (step == 7) return CML_OK;
    return cml_fail_field(err, text->path, text->line, "line behind", "the end of the file",
                          step == 0 ? "facet or endsolid" : lines[step][0]);
}

static bool is_text(const struct cml_text *text)
{
    const char *first = text->data + strspn(text->data, " \t\r\n");
    return strncasecmp(first, "solid", 5) == 0 && strlen(text->data) == text->size;
}

cml_status cml_stl_read(struct cml_text *text, const struct cml_mesh_budget *budget,
                        struct cml_polygons *polygons, struct cml_error *err)
{
    const size_t facets = text->size < START ? 0 : cml_binary_word(text->data + HEADER, 4, false);
    if (text->size == START + FACET * facets) return read_binary(text, facets, budget, polygons, err);
    if (!is_text(text))
        return cml_fail(
            err, CML_E_INPUT,
            "%s: %zu bytes (expected %zu for a binary file of %zu facets, or text that begins with solid)",
            text->path, text->size, START + FACET * facets, facets);
    CML_TRY(cml_mesh_budget_check(budget, (double)count_facets(text), CML_POLYGONS_REMEDY, err));
    return read_text(text, polygons, err);
}
