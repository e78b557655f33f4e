/* The reader of .mco files. It takes the keys in the order in which every MCML writes them; blank lines,
 * comments and the number of values on a line do not matter.
 * SPDX-License-Identifier: MIT */
#include "result/mco_sections.h"
#include "base/text.h"

#include <ctype.h>
#include <float.h>
#include <stdlib.h>
#include <string.h>

struct reader {
    struct cml_text text;
    char *cursor; /* what is left of the current line, NULL where no line is */
    bool copied;  /* the parameters are a copy of an .mci file */
    bool has_end; /* it says that its last line is CML_MCO_END */
    struct cml_outcome *o;
    struct cml_error *err;
};

static cml_status fail(const struct reader *r, const char *field, const char *value, const char *expected)
{
    return cml_fail_field(r->err, r->text.path, r->text.line, field, value, expected);
}

static const char *first_of(const char *line)
{
    return line + strspn(line, " \t\v\f\r");
}

static bool is_blank(const char *line)
{
    return *first_of(line) == '\0';
}

/* A comment begins at the start of a word: "1.#INF" is what a Windows library prints for infinity. */
static void cut_comment(char *line)
{
    char *mark = strchr(line, '#');
    while (mark && mark > line && !strchr(" \t\v\f\r", mark[-1])) mark = strchr(mark + 1, '#');
    if (mark) *mark = '\0';
}

/* Moves to the next line that holds more than a comment, and cuts its comment off. */
static bool next_line(struct reader *r)
{
    while ((r->cursor = cml_text_next(&r->text)) != NULL) {
        cut_comment(r->cursor);
        if (!is_blank(r->cursor)) return true;
    }
    return false;
}

/* NULL at the end of a line: most fields must stand on the line where MCML writes them. */
static char *next_word(struct reader *r)
{
    return r->cursor ? cml_text_word(&r->cursor) : NULL;
}

/* A key is a whole word: A_z must not be found in A_zx. */
static bool begins_with(const char *line, const char *key)
{
    const size_t length = strlen(key);
    line = first_of(line);
    return strncmp(line, key, length) == 0 && strchr(" \t", line[length]) != NULL;
}

/* Moves to the next line of parameters. In a copied .mci file, lines of boundaries and beams and pieces of
 * comments stand in between; none of them begins like a number. A comment there may touch a number. */
static void next_parameters(struct reader *r)
{
    while (next_line(r)) {
        if (r->copied) r->cursor[strcspn(r->cursor, "#")] = '\0';
        if (!r->copied || strchr("+-.0123456789", *first_of(r->cursor))) return;
        if (begins_with(r->cursor, "RAT")) break;
    }
    r->cursor = NULL;
}

/* A number of the file: its name in messages, and what it may be. */
struct field {
    const char *name, *expected;
    double low, high;
};

#define POSITIVE "a number above 0", DBL_TRUE_MIN, DBL_MAX
#define NOT_NEGATIVE "a number of 0 or more", 0, DBL_MAX

static const struct field field_time = {"user time", "seconds", 0, DBL_MAX};
static const struct field field_dz = {"dz", POSITIVE};
static const struct field field_dr = {"dr", POSITIVE};
static const struct field field_above = {"n above", POSITIVE};
static const struct field field_below = {"n below", POSITIVE};
static const struct field layer_fields[CML_LAYER_NUMBERS] = {
    {"n", POSITIVE},     {"mua", NOT_NEGATIVE}, {"mus", NOT_NEGATIVE}, {"g", "a number from -1 to 1", -1, 1},
    {"d", NOT_NEGATIVE},
};

static cml_status read_double(struct reader *r, const struct field *field, double *value)
{
    const char *word = next_word(r);
    if (word && cml_parse_double(word, value) && *value >= field->low && *value <= field->high) return CML_OK;
    return fail(r, field->name, word, field->expected);
}

/* Sizes are ints; whether the file can hold so many numbers is checked when all three are known. */
static cml_status read_count(struct reader *r, const char *name, int *value)
{
    const char *word = next_word(r);
    if (word && cml_parse_int(word, value) && *value > 0) return CML_OK;
    return fail(r, name, word, "a whole number above 0");
}

/* Text behind the fields of a line is a comment even without '#', but a number is a mistake. */
static cml_status end_fields(struct reader *r)
{
    double number = 0;
    const char *word = next_word(r);
    if (!word || !cml_parse_double(word, &number)) return CML_OK;
    return fail(r, "number too many", word, "the end of the line");
}

/* Refuses sizes before memory is asked for: every number takes at least a digit and a blank. */
static cml_status check_numbers(const struct reader *r, const char *field, const char *value, double numbers)
{
    char expected[96];
    const double most = (double)(r->text.size / 2);
    if (numbers <= most) return CML_OK;
    snprintf(expected, sizeof expected, "sizes that ask for no more than the %.0f numbers the file can hold",
             most);
    return fail(r, field, value, expected);
}

/* A1 or B1: MCML writes text for both, and so does everyone else. */
static cml_status read_format(struct reader *r)
{
    next_line(r);
    const char *word = next_word(r);
    if (word && (strcmp(word, "A1") == 0 || strcmp(word, "B1") == 0)) return CML_OK;
    return fail(r, "format", word, "A1, the results of MCML 1");
}

/* Where there is none it is not known. */
static void read_identity(const struct reader *r)
{
    static const char mark[] = " Identity: ";
    const char *sum = strstr(r->cursor, mark);
    if (sum) snprintf(r->o->identity, sizeof r->o->identity, "%s", sum + sizeof mark - 1);
}

/* The time stands in a comment, which readers skip everywhere else; so this goes line by line until the
 * first key. */
static cml_status read_head(struct reader *r)
{
    static const char mark[] = "# User time:";
    while ((r->cursor = cml_text_next(&r->text)) != NULL) {
        if (strncmp(r->cursor, mark, sizeof mark - 1) == 0) {
            r->cursor += sizeof mark - 1;
            read_identity(r);
            r->has_end = strstr(r->cursor, CML_MCO_HAS_END);
            CML_TRY(read_double(r, &field_time, &r->o->user_time));
        } else if (!is_blank(r->cursor) && *r->cursor != '#') {
            break;
        }
    }
    const char *word = next_word(r);
    r->copied = word && strcmp(word, "InParam") == 0;
    if (r->copied || (word && strcmp(word, "InParm") == 0)) return CML_OK;
    return fail(r, "section", word, "InParm");
}

/* Finds the name in "NAME \tA\t\t# ...", where it may hold blanks, or in "NAME A ...". NULL when there is
 * none. */
static const char *name_in(char *line)
{
    char *written = strstr(line, " \tA\t\t#");
    if (written) {
        *written = '\0';
        return line;
    }
    const char *name = cml_text_word(&line);
    const char *format = name && *name != '#' ? cml_text_word(&line) : NULL;
    return format && isalpha((unsigned char)format[0]) && !format[1] ? name : NULL;
}

/* In a copied .mci file the name is the first line that can be one: some writers on Windows begin their copy
 * in the middle of the comments before it. */
static cml_status read_name(struct reader *r)
{
    static const char expected[] = "a file name and the letter A or B";
    char *line = NULL;
    while ((line = cml_text_next(&r->text)) != NULL) {
        if (begins_with(line, "RAT")) break;
        const char *name = name_in(line);
        if (name) return cml_text_copy(name, &r->o->output, r->err);
        if (!r->copied && !is_blank(line) && *first_of(line) != '#')
            return fail(r, "output name", line, expected);
    }
    return fail(r, "output name", NULL, expected);
}

/* A count like 1e5 is read, too: copied .mci files have it. */
static cml_status read_photons(struct reader *r)
{
    next_parameters(r);
    const char *word = next_word(r);
    if (!word || !cml_parse_count(word, &r->o->photons) || r->o->photons == 0)
        return fail(r, "photons", word, "a whole number above 0");
    return end_fields(r);
}

/* Sizes are checked against the length of the file here, before any memory is asked for. */
static cml_status read_grid(struct reader *r)
{
    struct cml_outcome *o = r->o;
    char value[48];
    next_parameters(r);
    CML_TRY(read_double(r, &field_dz, &o->dz));
    CML_TRY(read_double(r, &field_dr, &o->dr));
    CML_TRY(end_fields(r));
    next_parameters(r);
    CML_TRY(read_count(r, "nz", &o->nz));
    CML_TRY(read_count(r, "nr", &o->nr));
    CML_TRY(read_count(r, "na", &o->na));
    CML_TRY(end_fields(r));
    snprintf(value, sizeof value, "%d %d %d", o->nz, o->nr, o->na);
    return check_numbers(r, "nz nr na", value, cml_outcome_numbers(o));
}

/* Six numbers of the file belong to a layer: five parameters and A_l. */
static cml_status read_layer_count(struct reader *r)
{
    struct cml_outcome *o = r->o;
    char value[16];
    next_parameters(r);
    CML_TRY(read_count(r, "number of layers", &o->num_layers));
    CML_TRY(end_fields(r));
    snprintf(value, sizeof value, "%d", o->num_layers);
    return check_numbers(r, "number of layers", value, cml_outcome_numbers(o));
}

static cml_status read_outside(struct reader *r, const struct field *field, double *n)
{
    next_parameters(r);
    CML_TRY(read_double(r, field, n));
    return end_fields(r);
}

/* n, mua, mus, g and d as in the .mci. The last layer of a half space has d = 1E+08, which is a number
 * like any other. */
static cml_status read_media(struct reader *r)
{
    struct cml_outcome *o = r->o;
    CML_TRY(read_outside(r, &field_above, &o->n_above));
    for (int l = 0; l < o->num_layers; l++) {
        next_parameters(r);
        for (int i = 0; i < CML_LAYER_NUMBERS; i++)
            CML_TRY(read_double(r, &layer_fields[i], cml_outcome_layer(o, l, i)));
        CML_TRY(end_fields(r));
    }
    return read_outside(r, &field_below, &o->n_below);
}

/* Keys come in a fixed order, so any other one is an error that names both. */
static cml_status read_key(struct reader *r, const char *key)
{
    next_line(r);
    const char *word = next_word(r);
    r->cursor = NULL;
    return word && strcmp(word, key) == 0 ? CML_OK : fail(r, "section", word, key);
}

/* Cells are named as in the manual, Rd_ra[ir][ia], so that the place in the file can be counted. */
static cml_status fail_cell(const struct reader *r, const char *key, int columns, size_t cell,
                            const char *word, const char *expected)
{
    char name[64];
    if (columns > 0)
        snprintf(name, sizeof name, "%s[%zu][%zu]", key, cell / (size_t)columns, cell % (size_t)columns);
    else
        snprintf(name, sizeof name, "%s[%zu]", key, cell);
    return fail(r, name, word, expected);
}

/* Reads a section's key and its numbers. The last one must not touch the end of the file, which every writer
 * follows by a blank or a line end: it may have lost digits. */
static cml_status read_values(struct reader *r, const char *key, int columns, double *values, size_t cells)
{
    const char *word = NULL;
    CML_TRY(read_key(r, key));
    for (size_t i = 0; i < cells; i++) {
        while (!(word = next_word(r)) && next_line(r)) {
        }
        if (!word || !cml_parse_double(word, &values[i]))
            return fail_cell(r, key, columns, i, word, "a number");
    }
    if (word && word + strlen(word) == r->text.data + r->text.size)
        return fail_cell(r, key, columns, cells - 1, word, "a line end after it, the file is cut off");
    word = next_word(r);
    return word ? fail_cell(r, key, columns, cells, word, "the end of the section") : CML_OK;
}

static cml_status read_totals(struct reader *r)
{
    double totals[CML_TOTALS];
    CML_TRY(read_values(r, "RAT", 0, totals, CML_TOTALS));
    for (int i = 0; i < CML_TOTALS; i++) r->o->value[i][0] = totals[i];
    return CML_OK;
}

/* The table that the writer goes by (mco_sections.h): both cannot differ. */
static cml_status read_sections(struct reader *r)
{
    for (int i = 0; i < CML_MCO_SECTIONS; i++) {
        const enum cml_quantity quantity = cml_mco_sections[i].quantity;
        CML_TRY(read_values(r, cml_quantities[quantity].name, cml_mco_columns(r->o, &cml_mco_sections[i]),
                            r->o->value[quantity], cml_outcome_size(r->o, quantity)));
    }
    return CML_OK;
}

/* Arrays are allocated once the number of layers is known, before the media are read into one of them. */
static cml_status read_all(struct reader *r)
{
    CML_TRY(read_format(r));
    CML_TRY(read_head(r));
    CML_TRY(read_name(r));
    CML_TRY(read_photons(r));
    CML_TRY(read_grid(r));
    CML_TRY(read_layer_count(r));
    CML_TRY(cml_outcome_allocate(r->o, r->err));
    CML_TRY(read_media(r));
    CML_TRY(read_totals(r));
    CML_TRY(read_sections(r));
    return cml_mco_read_ours(r->text.cursor < r->text.size ? r->text.data + r->text.cursor : "", r->text.path,
                             r->has_end, r->o, r->err);
}

cml_status cml_mco_read(const char *path, struct cml_outcome *o, struct cml_error *err)
{
    struct reader reader = {.o = o, .err = err};
    *o = (struct cml_outcome){.provenance = cml_provenance_unknown()};
    CML_TRY(cml_text_read(NULL, path, &reader.text, err));
    const cml_status status = read_all(&reader);
    cml_text_clear(&reader.text);
    if (status != CML_OK) cml_outcome_clear(o);
    return status;
}
