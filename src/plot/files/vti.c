/* SPDX-License-Identifier: MIT */
#include "plot/files/vti.h"

#include "base/text.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ATTRIBUTES = 16 };

static const char blanks[] = " \t\r\n";

/* <name key="value" ...>; a closing tag has the name "/name". */
struct tag {
    int line, count;
    const char *name, *key[MOST_ATTRIBUTES], *value[MOST_ATTRIBUTES];
};

struct reader {
    struct cml_text text; /* its line is that of the cursor */
    const char *wanted;
    struct cml_pixels *pixels;
    bool big_end, found;
    uint64_t offset; /* of the wanted array behind the underscore */
    char names[512]; /* of all arrays, for a message */
    struct cml_error *err;
};

/* Lines count to the underscore; behind it are bytes. */
static cml_status fail(const struct reader *r, int line, const char *name, const char *value,
                       const char *expected)
{
    return cml_fail_field(r->err, r->text.path, line, name, value, expected);
}

/* ---- tags ---- */

/* What has not been read yet; a zero stands behind the last byte. */
static char *cursor_of(const struct reader *r)
{
    return r->text.data + r->text.cursor;
}

/* Lines are counted for messages only. */
static void advance(struct reader *r, size_t length)
{
    for (size_t i = 0; i < length; i++) r->text.line += cursor_of(r)[i] == '\n';
    r->text.cursor += length;
}

/* Cuts key="value" out of *rest; false when it is none. */
static bool cut_attribute(struct tag *tag, char **rest)
{
    char *key = *rest, *equals = strchr(key, '=');
    if (!equals || tag->count == MOST_ATTRIBUTES || strcspn(key, blanks) < (size_t)(equals - key))
        return false;
    const char quote = equals[1];
    char *end = quote == '"' || quote == '\'' ? strchr(equals + 2, quote) : NULL;
    if (!end) return false;
    *equals = *end = '\0';
    tag->key[tag->count] = key;
    tag->value[tag->count++] = equals + 2;
    *rest = end + 1;
    return true;
}

/* Attributes may come in any order and with blanks around them, as XML allows; a "/" or "?" before the end
 * is no attribute. */
static cml_status split_tag(const struct reader *r, char *text, struct tag *tag)
{
    const size_t length = strcspn(text, blanks);
    char *rest = text + length + (text[length] != '\0');
    text[length] = '\0';
    if (length > 1 && text[length - 1] == '/') text[length - 1] = '\0';
    tag->name = text;
    for (;;) {
        rest += strspn(rest, blanks);
        if (!*rest || strcmp(rest, "/") == 0 || strcmp(rest, "?") == 0) return CML_OK;
        if (!cut_attribute(tag, &rest)) return fail(r, tag->line, "attribute", rest, "name=\"value\"");
    }
}

/* The text between tags must be blank: the arrays' values are not here but behind the underscore. The tag
 * is cut out in place, its ">" becoming a zero. */
static cml_status next_tag(struct reader *r, const char *expected, struct tag *tag)
{
    advance(r, strspn(cursor_of(r), blanks));
    *tag = (struct tag){.line = r->text.line};
    char *begin = cursor_of(r), *end = *begin == '<' ? strchr(begin, '>') : NULL;
    if (!end) return fail(r, tag->line, "tag", NULL, expected);
    advance(r, (size_t)(end - begin) + 1);
    *end = '\0';
    return split_tag(r, begin + 1, tag);
}

/* The next tag must be this one. */
static cml_status expect(struct reader *r, const char *name, struct tag *tag)
{
    CML_TRY(next_tag(r, name, tag));
    return strcmp(tag->name, name) == 0 ? CML_OK : fail(r, tag->line, "tag", tag->name, name);
}

/* The value of a tag's attribute; NULL where it has none. */
static const char *attribute(const struct tag *tag, const char *key)
{
    for (int i = 0; i < tag->count; i++)
        if (strcmp(tag->key[i], key) == 0) return tag->value[i];
    return NULL;
}

/* The attribute must have this value. */
static cml_status demand(const struct reader *r, const struct tag *tag, const char *key, const char *expected)
{
    const char *value = attribute(tag, key);
    return value && strcmp(value, expected) == 0 ? CML_OK : fail(r, tag->line, key, value, expected);
}

/* Whether the value is exactly so many numbers. */
static bool parse_numbers(const char *value, double *number, int count)
{
    char copy[256], *rest = copy;
    if (!value || strlen(value) >= sizeof copy) return false;
    strcpy(copy, value);
    for (int i = 0; i < count; i++) {
        const char *word = cml_text_word(&rest);
        if (!word || !cml_parse_double(word, &number[i])) return false;
    }
    return cml_text_word(&rest) == NULL;
}

/* ---- the header ---- */

/* Raw 64-bit sizes and no compression are what our writer uses; other files of VTK are refused by the
 * attribute that says so. An XML declaration may come first. */
static cml_status read_kind(struct reader *r)
{
    struct tag tag;
    do CML_TRY(next_tag(r, "VTKFile", &tag));
    while (tag.name[0] == '?');
    if (strcmp(tag.name, "VTKFile") != 0) return fail(r, tag.line, "tag", tag.name, "VTKFile");
    CML_TRY(demand(r, &tag, "type", "ImageData"));
    CML_TRY(demand(r, &tag, "header_type", "UInt64"));
    if (attribute(&tag, "compressor"))
        return fail(r, tag.line, "compressor", attribute(&tag, "compressor"), "none");
    const char *order = attribute(&tag, "byte_order");
    r->big_end = order && strcmp(order, "BigEndian") == 0;
    return r->big_end || (order && strcmp(order, "LittleEndian") == 0)
               ? CML_OK
               : fail(r, tag.line, "byte_order", order, "LittleEndian or BigEndian");
}

/* Points, so that n cells are 0 to n. The third axis must be flat: volumes cannot be drawn as a map. */
static cml_status read_extent(const struct reader *r, const struct tag *tag, const char *key, size_t n[2])
{
    const char *value = attribute(tag, key);
    double extent[6];
    bool sound = parse_numbers(value, extent, 6) && extent[4] == 0 && extent[5] == 0;
    for (int axis = 0; axis < 2 && sound; axis++) {
        const double first = extent[2 * axis], end = extent[2 * axis + 1];
        sound = first == 0 && end >= 1 && end <= 1e9 && end == floor(end);
        n[axis] = sound ? (size_t)end : 0;
    }
    return sound ? CML_OK : fail(r, tag->line, key, value, "0 nx 0 ny 0 0, a map without layers");
}

/* A map whose pixels are no more than rounding beside its place cannot be drawn. */
static cml_status read_grid(const struct reader *r, const struct tag *tag)
{
    struct cml_pixels *pixels = r->pixels;
    const char *origin = attribute(tag, "Origin"), *spacing = attribute(tag, "Spacing");
    double number[3];
    CML_TRY(read_extent(r, tag, "WholeExtent", pixels->n));
    if (!parse_numbers(spacing, number, 3) ||
        !(number[0] >= 1e-12 && number[0] <= 1e12 && number[1] >= 1e-12 && number[1] <= 1e12))
        return fail(r, tag->line, "Spacing", spacing, "three numbers, dx and dy in 1e-12..1e12");
    memcpy(pixels->spacing, number, sizeof pixels->spacing);
    if (!parse_numbers(origin, number, 3) ||
        !(fabs(number[0]) <= 1e9 * pixels->spacing[0] && fabs(number[1]) <= 1e9 * pixels->spacing[1]))
        return fail(r, tag->line, "Origin", origin, "three numbers, x and y of at most 1e9 pixels");
    memcpy(pixels->origin, number, sizeof pixels->origin);
    return CML_OK;
}

/* Other arrays are passed over, but their names are kept for the message that the wanted one is missing. */
static cml_status read_array(struct reader *r, const struct tag *tag)
{
    const char *name = attribute(tag, "Name"), *components = attribute(tag, "NumberOfComponents");
    if (!name || !*name) return fail(r, tag->line, "Name", NULL, "the name of the array");
    const size_t used = strlen(r->names);
    snprintf(r->names + used, sizeof r->names - used, " %s", name);
    if (strcmp(name, r->wanted) != 0) return CML_OK;
    if (r->found) return fail(r, tag->line, "Name", name, "this array only once");
    r->found = true;
    CML_TRY(demand(r, tag, "type", "Float32"));
    CML_TRY(demand(r, tag, "format", "appended"));
    if (components) CML_TRY(demand(r, tag, "NumberOfComponents", "1"));
    const char *offset = attribute(tag, "offset");
    return offset && cml_parse_count(offset, &r->offset)
               ? CML_OK
               : fail(r, tag->line, "offset", offset, "a number of bytes");
}

/* Up to the closing tag, so that an array that is there twice is noticed. */
static cml_status read_arrays(struct reader *r)
{
    struct tag tag;
    CML_TRY(expect(r, "CellData", &tag));
    for (;;) {
        CML_TRY(next_tag(r, "DataArray or /CellData", &tag));
        if (strcmp(tag.name, "/CellData") == 0) break;
        if (strcmp(tag.name, "DataArray") != 0)
            return fail(r, tag.line, "tag", tag.name, "DataArray or /CellData");
        CML_TRY(read_array(r, &tag));
    }
    if (r->found) return CML_OK;
    return cml_fail(r->err, CML_E_INPUT, "%s: no array %.80s (expected one of%s)", r->text.path, r->wanted,
                    r->names[0] ? r->names : " none, the file has no arrays");
}

/* Step by step as the writer wrote it: VTKFile, ImageData, Piece, CellData, AppendedData. */
static cml_status read_header(struct reader *r)
{
    struct tag tag;
    size_t n[2];
    r->text.line = 1;
    CML_TRY(read_kind(r));
    CML_TRY(expect(r, "ImageData", &tag));
    CML_TRY(read_grid(r, &tag));
    CML_TRY(expect(r, "Piece", &tag));
    CML_TRY(read_extent(r, &tag, "Extent", n));
    if (n[0] != r->pixels->n[0] || n[1] != r->pixels->n[1])
        return fail(r, tag.line, "Extent", attribute(&tag, "Extent"), "the WholeExtent");
    CML_TRY(read_arrays(r));
    CML_TRY(expect(r, "/Piece", &tag));
    CML_TRY(expect(r, "/ImageData", &tag));
    CML_TRY(expect(r, "AppendedData", &tag));
    CML_TRY(demand(r, &tag, "encoding", "raw"));
    advance(r, strspn(cursor_of(r), blanks));
    if (*cursor_of(r) != '_') return fail(r, r->text.line, "_", NULL, "an underscore before the data");
    advance(r, 1);
    return CML_OK;
}

/* ---- the data ---- */

/* In the file's byte order, whatever that of this machine is. */
static uint64_t word_at(const struct reader *r, const char *data, int size)
{
    const unsigned char *byte = (const unsigned char *)data;
    uint64_t word = 0;
    for (int i = 0; i < size; i++) word = word << 8 | byte[r->big_end ? i : size - 1 - i];
    return word;
}

/* Where the wanted values begin. Sizes never overflow: n < 2^30 each, offset <= 2^53. */
static cml_status find_values(const struct reader *r, const char **values)
{
    const struct cml_pixels *pixels = r->pixels;
    const uint64_t behind = r->text.size - r->text.cursor, head = sizeof(uint64_t);
    const uint64_t bytes = (uint64_t)pixels->n[0] * pixels->n[1] * 4;
    const char *array = cursor_of(r) + (r->offset < behind ? r->offset : 0);
    if (r->offset + head + bytes > behind)
        return cml_fail(r->err, CML_E_INPUT,
                        "%s: %.0f bytes of data (expected %.0f: 8 + 4 x %zu x %zu at %.0f)", r->text.path,
                        (double)behind, (double)(r->offset + head + bytes), pixels->n[0], pixels->n[1],
                        (double)r->offset);
    if (word_at(r, array, sizeof head) != bytes)
        return cml_fail(r->err, CML_E_INPUT, "%s: %s has %.0f bytes (expected %.0f: 4 x %zu x %zu)",
                        r->text.path, r->wanted, (double)word_at(r, array, sizeof head), (double)bytes,
                        pixels->n[0], pixels->n[1]);
    *values = array + head;
    return CML_OK;
}

/* What is infinite, not a number or below 0 is no light, and would spoil the range of colours for all. */
static cml_status read_values(const struct reader *r)
{
    struct cml_pixels *pixels = r->pixels;
    const char *values = NULL;
    CML_TRY(find_values(r, &values));
    const size_t count = pixels->n[0] * pixels->n[1];
    pixels->value = malloc(count * sizeof *pixels->value);
    if (!pixels->value) return cml_fail_memory(r->err, (double)(count * sizeof *pixels->value), "a map");
    for (size_t i = 0; i < count; i++) {
        const uint32_t word = (uint32_t)word_at(r, values + 4 * i, 4);
        memcpy(&pixels->value[i], &word, sizeof word);
        if (!(pixels->value[i] >= 0 && isfinite(pixels->value[i])))
            return cml_fail(r->err, CML_E_INPUT,
                            "%s: %s of pixel %zu %zu = %g (expected a number of 0 or more)", r->text.path,
                            r->wanted, i % pixels->n[0], i / pixels->n[0], (double)pixels->value[i]);
    }
    return CML_OK;
}

/* Once read as bytes: a file of a map is a few MiB, and the header is text only up to the underscore. */
cml_status cml_vti_read(const char *path, const char *name, struct cml_pixels *pixels, struct cml_error *err)
{
    struct reader r = {.wanted = name, .pixels = pixels, .err = err};
    *pixels = (struct cml_pixels){0};
    CML_TRY(cml_text_read_bytes(NULL, path, &r.text, err));
    cml_status status = read_header(&r);
    if (status == CML_OK) status = read_values(&r);
    cml_text_clear(&r.text);
    if (status != CML_OK) cml_pixels_clear(pixels);
    return status;
}

void cml_pixels_clear(struct cml_pixels *pixels)
{
    free(pixels->value);
    *pixels = (struct cml_pixels){0};
}
