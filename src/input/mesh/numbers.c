/* SPDX-License-Identifier: MIT */
#include "input/mesh/numbers.h"

#include <math.h>
#include <string.h>

static const int sizes[] = {1, 1, 2, 2, 4, 4, 4, 8}; /* bytes of each type */
static const char blanks[] = " \t\v\f\r";

double cml_number_decode(const char *data, enum cml_number type, bool big)
{
    const int size = sizes[type];
    uint64_t word = 0;
    double real;
    for (int i = 0; i < size; i++) word = word << 8 | (unsigned char)data[big ? i : size - 1 - i];
    const uint32_t half = (uint32_t)word;
    float single;
    memcpy(&single, &half, sizeof single);
    memcpy(&real, &word, sizeof real);
    if (type == CML_FLOAT) return (double)single;
    if (type == CML_DOUBLE) return real;
    const bool is_signed = type % 2 == 0;
    return (double)word - (is_signed && word >> (8 * size - 1) ? ldexp(1, 8 * size) : 0);
}

bool cml_numbers_next_line(struct cml_numbers *in)
{
    do {
        in->cursor = cml_text_next(in->text);
        if (in->cursor) in->cursor += strspn(in->cursor, blanks);
    } while (in->cursor && !*in->cursor);
    in->line = in->text->line;
    return in->cursor != NULL;
}

char *cml_numbers_word(struct cml_numbers *in)
{
    char *word = in->cursor + strspn(in->cursor, blanks);
    char *end = word + strcspn(word, blanks);
    in->cursor = *end ? end + 1 : end;
    *end = '\0';
    return *word ? word : NULL;
}

cml_status cml_numbers_fail(const struct cml_numbers *in, const char *name, const char *value,
                            const char *expected)
{
    if (!in->binary) return cml_fail_field(in->err, in->text->path, in->line, name, value, expected);
    const size_t byte = (size_t)(in->cursor - in->text->data) + 1;
    return cml_fail_field(in->err, in->text->path, 0, CML_TEXT("byte %zu: %s", byte, name), value, expected);
}

static bool is_allowed(double value, double most)
{
    if (!isfinite(most)) return isnan(most) || isfinite(value);
    return value >= 0 && value <= most && value == floor(value);
}

cml_status cml_numbers_take(struct cml_numbers *in, enum cml_number type, const char *name, double most,
                            double *value)
{
    const char *word = in->binary ? NULL : cml_numbers_word(in), *end = in->text->data + in->text->size;
    const bool is_there = in->binary ? end - in->cursor >= sizes[type] : word != NULL;
    if (is_there && in->binary) *value = cml_number_decode(in->cursor, type, in->big);
    const bool is_number = is_there && (in->binary || isnan(most) || cml_parse_double(word, value));
    if (is_number && is_allowed(*value, most)) {
        in->cursor += in->binary ? sizes[type] : 0;
        return CML_OK;
    }
    char shown[40] = "the end of the file", expected[64] = "a finite number";
    if (is_there && in->binary) snprintf(shown, sizeof shown, "%.10g", *value);
    if (isfinite(most)) snprintf(expected, sizeof expected, "a whole number of 0..%.0f", most);
    return cml_numbers_fail(in, name, in->binary ? shown : word, expected);
}

cml_status cml_numbers_take_vertex(struct cml_numbers *in, struct cml_polygons *polygons)
{
    static const char *const axis[] = {"x of the vertex", "y of the vertex", "z of the vertex"};
    double vertex[3];
    for (int k = 0; k < 3; k++) CML_TRY(cml_numbers_take(in, CML_FLOAT, axis[k], INFINITY, &vertex[k]));
    return cml_polygons_add_vertex(polygons, vertex, in->line, in->err);
}
