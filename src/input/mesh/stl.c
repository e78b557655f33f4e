/* SPDX-License-Identifier: MIT */
#include "input/mesh/stl.h"

#include "input/mesh/numbers.h"

#include <string.h>
#include <strings.h>

enum { HEADER = 80, START = 84, FACET = 50, NORMAL = 12 }; /* bytes of a binary file */

/* Adds a facet, whose corners are the last three vertices. */
static cml_status add_facet(const struct cml_numbers *in, struct cml_polygons *polygons)
{
    for (size_t i = polygons->num_vertices - 3; i < polygons->num_vertices; i++)
        CML_TRY(cml_polygons_add_corner(polygons, (uint32_t)i, in->err));
    return cml_polygons_add_face(polygons, 3, in->line, in->err);
}

static cml_status read_binary(struct cml_numbers *in, size_t facets, struct cml_polygons *polygons)
{
    for (size_t f = 0; f < facets; f++) {
        in->cursor = in->text->data + START + FACET * f + NORMAL;
        for (int k = 0; k < 3; k++) CML_TRY(cml_numbers_take_vertex(in, polygons));
        CML_TRY(add_facet(in, polygons));
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
static cml_status expect_words(struct cml_numbers *in, const char *const words[2])
{
    for (int i = 0; i < 2 && words[i]; i++) {
        const char *word = cml_numbers_word(in);
        if (!word || strcasecmp(word, words[i]) != 0) return cml_numbers_fail(in, "word", word, words[i]);
    }
    return CML_OK;
}

/* Reads a text file line by line. The lines of a facet come in the order of `lines`; `solid` and `endsolid`
 * stand around facets. */
static cml_status read_text(struct cml_numbers *in, struct cml_polygons *polygons)
{
    static const char *const lines[8][2] = {{"facet", "normal"}, {"outer", "loop"}, {"vertex"},   {"vertex"},
                                            {"vertex"},          {"endloop"},       {"endfacet"}, {"solid"}};
    int step = 7;
    while (cml_numbers_next_line(in)) {
        if (step == 0 && strncasecmp(in->cursor, "endsolid", 8) == 0) {
            step = 7;
            continue;
        }
        CML_TRY(expect_words(in, lines[step]));
        if (step >= 2 && step <= 4) {
            CML_TRY(cml_numbers_take_vertex(in, polygons));
            const char *more = cml_numbers_word(in);
            if (more) return cml_numbers_fail(in, "word behind z", more, "the end of the line");
        }
        if (step == 6) CML_TRY(add_facet(in, polygons));
        step = step < 6 ? step + 1 : 0;
    }
    if (step == 7) return CML_OK;
    return cml_numbers_fail(in, "line behind", "the end of the file",
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
    const bool has_count = text->size >= START;
    const size_t facets = has_count ? (size_t)cml_number_decode(text->data + HEADER, CML_UINT32, false) : 0;
    const size_t size = START + FACET * facets;
    struct cml_numbers in = {.text = text, .binary = text->size == size, .err = err};
    if (!in.binary && !is_text(text))
        return cml_fail(
            err, CML_E_INPUT,
            "%s: %zu bytes (expected %zu for a binary file of %zu facets, or text that begins with solid)",
            text->path, text->size, size, facets);
    const size_t count = in.binary ? facets : count_facets(text);
    CML_TRY(cml_mesh_budget_check(budget, (double)count, CML_POLYGONS_REMEDY, err));
    return in.binary ? read_binary(&in, facets, polygons) : read_text(&in, polygons);
}
