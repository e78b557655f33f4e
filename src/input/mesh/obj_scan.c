/* The strict scan of an OBJ file. It works in place: text that is not needed becomes blanks, and the text
 * keeps its length for tinyobjloader. SPDX-License-Identifier: MIT */
#include "input/mesh/obj_scan.h"

#include "input/mesh/numbers.h"

#include <stdlib.h>
#include <string.h>

/* A logical line: a line with its continuations. */
struct line {
    char *text, *end;
};

/* Reads a vertex x y z. A weight or a colour may follow; both are checked, and not used. */
static cml_status scan_vertex(struct cml_numbers *in, struct cml_polygons *scan)
{
    CML_TRY(cml_numbers_take_vertex(in, scan));
    double ignored;
    for (const char *word = cml_numbers_word(in); word; word = cml_numbers_word(in))
        if (!cml_parse_double(word, &ignored))
            return cml_numbers_fail(in, "weight or colour of the vertex", word, "a finite number");
    return CML_OK;
}

/* True if the word is v, v/t, v//n or v/t/n with whole numbers; *number becomes v. */
static bool parse_corner(const char *word, int *number)
{
    char part[3][16] = {"", "", ""};
    int count = 0;
    for (;; word++) {
        const size_t length = strcspn(word, "/");
        if (count == 3 || length >= sizeof part[0]) return false;
        memcpy(part[count++], word, length);
        word += length;
        if (!*word) break;
    }
    int ignored;
    if (!cml_parse_int(part[0], number)) return false;
    if (count == 2 && !part[1][0]) return false;
    if (part[1][0] && !cml_parse_int(part[1], &ignored)) return false;
    return count < 3 || cml_parse_int(part[2], &ignored);
}

/* Checks the number of a corner. It may be relative to the vertices read so far (-1 is the last one); a
 * number beyond these is checked at the end, because its vertex may follow. */
static cml_status scan_corner(const struct cml_numbers *in, const char *word, size_t num_vertices)
{
    int number = 0;
    if (!parse_corner(word, &number))
        return cml_numbers_fail(in, "corner of the face", word,
                                "a vertex number, as in 3, 3/1, 3//2 or 3/1/2");
    if (number == 0) return cml_numbers_fail(in, "corner of the face", word, "a vertex number from 1 on");
    if (number < 0 && (size_t)(-(long)number) > num_vertices)
        return cml_fail(in->err, CML_E_INPUT,
                        "%s:%d: corner of the face = %s (only %zu vertices stand before it)", in->text->path,
                        in->line, word, num_vertices);
    return CML_OK;
}

/* Counts and checks the corners of a face; tinyobjloader returns their numbers later. */
static cml_status scan_face(struct cml_numbers *in, struct cml_polygons *scan)
{
    uint32_t corners = 0;
    for (const char *word = cml_numbers_word(in); word; word = cml_numbers_word(in), corners++)
        CML_TRY(scan_corner(in, word, scan->num_vertices));
    if (corners < 3)
        return cml_fail(in->err, CML_E_INPUT, "%s:%d: the face has %u corners (expected 3 or more)",
                        in->text->path, in->line, corners);
    scan->num_corners += corners;
    return cml_polygons_add_face(scan, corners, in->line, in->err);
}

/* Joins the next line to a vertex or face that ends in a backslash. The characters between become blanks, so
 * that the text is one line for the next reader, too. */
static void join_continuations(struct cml_text *text, struct line *line)
{
    while (line->end > line->text && line->end[-1] == '\\') {
        line->end[-1] = ' ';
        char *more = cml_text_next(text);
        if (!more) return;
        memset(line->end, ' ', (size_t)(more - line->end));
        line->end = more + strlen(more);
    }
}

/* Turns the comment and all kinds of blanks into spaces. */
static void make_plain(struct line *line)
{
    char *comment = strchr(line->text, '#');
    if (comment) memset(comment, ' ', (size_t)(line->end - comment));
    for (char *c = line->text; c < line->end; c++)
        if (strchr("\t\v\f\r", *c)) *c = ' ';
}

/* Undoes the cuts into lines and words in the text, for the next reader. */
static void restore_line(const struct cml_text *text, const struct line *line)
{
    char *stop = text->data + (text->cursor < text->size ? text->cursor : text->size);
    for (char *c = line->text; c < stop; c++)
        if (!*c) *c = ' ';
    if (text->cursor <= text->size) text->data[text->cursor - 1] = '\n';
}

/* Scans one line. Lines of vertices (`v`) and faces (`f`) stay in the text; all others (normals, groups,
 * materials) are overwritten with blanks. */
static cml_status scan_line(struct cml_text *text, struct line *line, struct cml_polygons *scan,
                            struct cml_error *err)
{
    struct cml_numbers in = {.text = text, .line = text->line, .err = err};
    if (strchr(line->text, '\r'))
        return cml_fail(err, CML_E_INPUT,
                        "%s:%d: a carriage return inside the line (expected line ends LF or CR LF)",
                        text->path, in.line);
    char *word = line->text + strspn(line->text, " \t\v\f");
    const size_t length = strcspn(word, " \t\v\f\\");
    const bool is_vertex = length == 1 && word[0] == 'v', is_face = length == 1 && word[0] == 'f';
    if (!is_vertex && !is_face) {
        memset(line->text, ' ', (size_t)(line->end - line->text));
    } else {
        if (!strchr(word, '#')) join_continuations(text, line);
        make_plain(line);
        in.cursor = word + 1;
        CML_TRY(is_vertex ? scan_vertex(&in, scan) : scan_face(&in, scan));
    }
    restore_line(text, line);
    return CML_OK;
}

/* Counts the words up to the end of the line or its comment, and leaves *at there. A backslash joins the next
 * line. */
static size_t count_words(const char **at, const char *end)
{
    size_t words = 0;
    bool inside = false, joined = false;
    for (; *at < end && (**at != '\n' || joined) && **at != '#'; (*at)++) {
        joined = **at == '\\' || (joined && **at == '\r');
        const bool blank = joined || strchr(" \t\v\f\r\n", **at) != NULL;
        words += !blank && !inside;
        inside = !blank;
    }
    return words;
}

/* Counts the triangles of an OBJ text in one quick pass, so that a mesh that is too large is refused before
 * it takes memory. A face with n corners becomes n - 2 triangles. */
size_t cml_obj_count(const struct cml_text *text)
{
    size_t triangles = 0;
    const char *end = text->data + text->size;
    for (const char *line = text->data; line && line < end;) {
        const char *at = line + strspn(line, " \t\v\f");
        if (at + 1 < end && *at == 'f' && strchr(" \t\v\f\\", at[1])) {
            at++;
            const size_t corners = count_words(&at, end);
            triangles += corners > 2 ? corners - 2 : 0;
        }
        line = memchr(at, '\n', (size_t)(end - at));
        if (line) line++;
    }
    return triangles;
}

cml_status cml_obj_scan_text(struct cml_text *text, struct cml_polygons *scan, struct cml_error *err)
{
    for (char *start = cml_text_next(text); start; start = cml_text_next(text)) {
        struct line line = {start, start + strlen(start)};
        CML_TRY(scan_line(text, &line, scan, err));
    }
    if (scan->num_faces > 0) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "%s: no faces (expected lines like `f 1 2 3`)", text->path);
}
