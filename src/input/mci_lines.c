/* Lines of .mci files: comments, keywords, numbers, messages. SPDX-License-Identifier: MIT */
#include "input/mci_lines.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

static const char blanks[] = " \t\v\f\r";

cml_status cml_mci_open(const char *path, const struct cml_input_options *options,
                        struct cml_mci_reader *reader, struct cml_error *err)
{
    *reader = (struct cml_mci_reader){.options = options, .err = err};
    return cml_text_read(options->source, path, &reader->text, err);
}

void cml_mci_close(struct cml_mci_reader *reader)
{
    cml_text_clear(&reader->text);
    free(reader->kept);
    *reader = (struct cml_mci_reader){0};
}

void cml_mci_forget(struct cml_mci_reader *reader)
{
    reader->kept_size = 0;
    reader->kept_last = 0;
}

/* Returns the kept lines, which the caller frees. The reader allocates new memory for the next run. */
char *cml_mci_take_kept(struct cml_mci_reader *reader)
{
    char *kept = reader->kept;
    reader->kept = NULL;
    reader->kept_capacity = 0;
    cml_mci_forget(reader);
    return kept;
}

char *cml_mci_find_word(char *line, const char *key)
{
    char *found = strstr(line, key);
    while (found && found > line && !strchr(blanks, found[-1])) found = strstr(found + 1, key);
    return found;
}

const char *cml_mci_raw(const struct cml_mci_reader *reader)
{
    return reader->kept + reader->kept_last;
}

/* Copies the current line as written, for messages, before words are cut out of it in place. */
static cml_status keep_line(struct cml_mci_reader *reader, const char *line)
{
    const size_t length = strlen(line);
    const size_t needed = reader->kept_size + length + 2;
    if (needed > reader->kept_capacity) {
        const size_t capacity = 2 * needed;
        char *larger = realloc(reader->kept, capacity);
        if (!larger) return cml_fail_memory(reader->err, (double)capacity, "the lines of a run");
        reader->kept = larger;
        reader->kept_capacity = capacity;
    }
    if (reader->kept_size > 0) reader->kept[reader->kept_size++] = '\n';
    reader->kept_last = reader->kept_size;
    memcpy(reader->kept + reader->kept_last, line, length + 1);
    reader->kept_size += length;
    return CML_OK;
}

/* True for a line marked as ours: "#@ beam", and "#@ baem" to report the error. A ruler like "#@@@@" or a
 * lone "#@" is an ornament. */
static bool is_marked(const char *text)
{
    if (text[0] != '#' || text[1] != '@') return false;
    const size_t gap = strspn(text + 2, blanks);
    const char first = text[2 + gap];
    return gap ? first != '\0' : first >= 'a' && first <= 'z';
}

#define BEFORE_LAYER "a boundary line stands before the layer, or the n below, whose top it is"
#define ON_TOP(name) "a " name " line stands between n above and the line of layer 1"
#define OF_RUN(name) "a " name " line stands between a run's first line and its number of layers"

const struct cml_mci_keyword cml_mci_keywords[CML_MCI_KEYWORDS] = {
    [CML_MCI_B] = {"b", BEFORE_LAYER, "0 \""},
    [CML_MCI_M] = {"m", BEFORE_LAYER, "\""},
    [CML_MCI_ROUGH] = {"rough", BEFORE_LAYER, "ggx beckmann"},
    [CML_MCI_FACE] = {"face", ON_TOP("face"), "0 disk ring rectangle metal"},
    [CML_MCI_PORT] = {"port", ON_TOP("port"), "disk ring rectangle"},
    [CML_MCI_I] = {"i", "an i line stands behind the line of the layer that it lies in",
                   "\" sphere cylinder"},
    [CML_MCI_PHASE] = {"phase", "a phase line stands behind the line of the layer or body whose it is",
                       "hg2 mhg gk rayleigh table"},
    [CML_MCI_BACKING] = {"backing",
                         "a backing line stands behind the last layer and its lines, before n below", "0"},
    [CML_MCI_BEAM] = {"beam", OF_RUN("beam"), "pencil disk gaussian ring rectangle image port"},
    [CML_MCI_MAP] = {"map", OF_RUN("map"), "0"},
    [CML_MCI_FACETS] = {"facets", OF_RUN("facets"), "$"},
    [CML_MCI_TIME] = {"time", OF_RUN("time"), "0"},
    [CML_MCI_DIRECTIONS] = {"directions", OF_RUN("directions"), "0"},
    [CML_MCI_FLUENCE] = {"fluence", OF_RUN("fluence"), "$"},
    [CML_MCI_DETECTOR] = {"detector", OF_RUN("detector"), "disk ring rectangle map port"},
    [CML_MCI_PHOTONS] = {"photons", OF_RUN("photons"), "\""}};

const char *cml_mci_meant_keyword(const struct cml_mci_reader *reader)
{
    struct cml_guess guess = {.word = reader->cursor, .length = strcspn(reader->cursor, blanks)};
    for (int i = 0; i < CML_MCI_KEYWORDS; i++) cml_guess_offer(&guess, cml_mci_keywords[i].word);
    return strchr("0123456789+-.", *guess.word) ? NULL : cml_guess_best(&guess);
}

/* Returns the kind of a keyword and moves *cursor behind it; CML_MCI_DATA if there is no keyword. */
static enum cml_mci_kind take_keyword(char **cursor)
{
    char *word = *cursor + strspn(*cursor, blanks);
    const size_t length = strcspn(word, blanks);
    for (int i = 0; i < CML_MCI_KEYWORDS; i++) {
        const char *keyword = cml_mci_keywords[i].word;
        if (strlen(keyword) != length || memcmp(word, keyword, length) != 0) continue;
        *cursor = word + length;
        return (enum cml_mci_kind)i;
    }
    return CML_MCI_DATA;
}

/* True if the text begins like one of the words in `looks` (struct cml_mci_keyword). */
static bool looks_like(const char *text, const char *looks)
{
    const size_t own = strcspn(text, blanks);
    for (; *looks; looks += strcspn(looks, " "), looks += *looks == ' ') {
        const size_t length = strcspn(looks, " ");
        if (*looks == '0'   ? *text >= '0' && *text <= '9'
            : *looks == '$' ? !*text
                            : *looks == '"' && *text == '"')
            return true;
        if (own == length && memcmp(text, looks, own) == 0) return true;
    }
    return false;
}

/* Notes a comment like "#b 3 0.1 ..." that was probably meant as the keyword line "#@ b". The text behind the
 * keyword must look like that line, because most comments are comments. */
static void hint_at_mark(const struct cml_mci_reader *reader)
{
    char *behind = reader->cursor + 1;
    if (*behind == '\0' || strchr(blanks, *behind)) return;
    const enum cml_mci_kind kind = take_keyword(&behind);
    behind += strspn(behind, blanks);
    if (kind < CML_MCI_KEYWORDS && looks_like(behind, cml_mci_keywords[kind].looks))
        cml_mci_note(reader, reader->text.line, "a comment: %.60s (did you mean #@ %.60s?)", reader->cursor,
                     reader->cursor + 1);
}

/* Lines marked with #@ are keyword lines that original MCML takes for comments. The text of the line is kept,
 * because it decides the result. */
cml_status cml_mci_next(struct cml_mci_reader *reader, bool keywords, enum cml_mci_kind *kind)
{
    char *line = NULL;
    bool marked = false;
    *kind = CML_MCI_END;
    do {
        line = cml_text_next(&reader->text);
        if (!line) return CML_OK;
        reader->cursor = line + strspn(line, blanks);
        marked = is_marked(reader->cursor);
        if (!marked && *reader->cursor == '#') hint_at_mark(reader);
    } while (!marked && (*reader->cursor == '#' || *reader->cursor == '\0'));
    CML_TRY(keep_line(reader, line));
    if (marked) reader->cursor += 2;
    *kind = marked || keywords ? take_keyword(&reader->cursor) : CML_MCI_DATA;
    if (marked && *kind == CML_MCI_DATA) *kind = CML_MCI_UNKNOWN;
    return CML_OK;
}

void cml_mci_cut_comment(char *text)
{
    bool quoted = false;
    for (; *text; text++) {
        if (*text == '"') quoted = !quoted;
        if (*text == '#' && !quoted) *text = '\0';
        if (!*text) return;
    }
}

cml_status cml_mci_fail(const struct cml_mci_reader *reader, const char *field, const char *value,
                        const char *expected)
{
    return cml_fail_field(reader->err, reader->text.path, reader->text.line, field, value, expected);
}

cml_status cml_mci_name_line(const struct cml_mci_reader *reader, const char *owner, const char *file,
                             cml_status status)
{
    const struct cml_error why = *reader->err;
    if (status == CML_OK || !file || strncmp(why.text, file, strlen(file)) != 0) return status;
    return cml_fail(reader->err, status, "%s:%d: %s: %.900s", reader->text.path, reader->text.line, owner,
                    why.text);
}

void cml_mci_note(const struct cml_mci_reader *reader, int line, const char *format, ...)
{
    const struct cml_input_options *options = reader->options;
    char text[1024];
    if (!options->on_note) return;
    const int used = snprintf(text, sizeof text, "%.500s:%d: ", reader->text.path, line);
    va_list values;
    va_start(values, format);
    vsnprintf(text + used, sizeof text - (size_t)used, format, values);
    va_end(values);
    options->on_note(options->context, text);
}

cml_status cml_mci_fail_key(const struct cml_mci_reader *reader, const char *owner, const struct cml_key *key,
                            const char *word)
{
    char expected[CML_KEY_TEXT];
    return cml_mci_fail(reader, CML_TEXT("%s%s%s", owner ? owner : "", owner ? ": " : "", cml_key_shown(key)),
                        word, cml_key_expected(key, expected));
}

cml_status cml_mci_number(struct cml_mci_reader *reader, const char *owner, const struct cml_key *key,
                          void *base)
{
    double value;
    const char *word = cml_text_word(&reader->cursor);
    if (!word || !cml_key_parse(key, word, &value)) return cml_mci_fail_key(reader, owner, key, word);
    cml_key_store(key, base, value);
    return CML_OK;
}

cml_status cml_mci_leading_numbers(struct cml_mci_reader *reader, const char *owner,
                                   const struct cml_key_part *parts)
{
    for (; parts->group != CML_KEYS_NONE; parts++)
        for (const struct cml_key *key = cml_keys_of(parts->group); key->group == parts->group; key++)
            if (key->use & CML_KEY_PLACED) CML_TRY(cml_mci_number(reader, owner, key, parts->base));
    return CML_OK;
}

/* True if a word is a unit of length other than cm, or of coefficients other than 1/cm: mm, [um], 1/mm, mm-1,
 * mm^-1. */
static bool is_other_unit(const char *word)
{
    static const char *const units[] = {"nm", "um", "\u00b5m", "\u03bcm", "micron", "microns", "mm",  "dm",
                                        "m",  "km", "metre",   "metres",  "meter",  "meters",  "inch"};
    word += strspn(word, "([");
    if (strncmp(word, "1/", 2) == 0) word++;
    word += strspn(word, "/");
    for (size_t i = 0; i < sizeof units / sizeof *units; i++) {
        const size_t length = strlen(units[i]);
        if (strncmp(word, units[i], length) != 0) continue;
        const char *behind = word + length;
        behind += strspn(behind, "^");
        if (strncmp(behind, "-1", 2) == 0) behind += 2;
        if (behind[strspn(behind, ")],.;:")] == '\0') return true;
    }
    return false;
}

/* Reads the numbers of a line. Behind the last one files of original MCML have comments without a '#', so
 * words are ignored there. A further number was probably meant as a value, and a unit for the numbers before
 * it, so both are refused. */
cml_status cml_mci_numbers(struct cml_mci_reader *reader, const char *owner, const struct cml_key_part *parts)
{
    cml_mci_cut_comment(reader->cursor);
    CML_TRY(cml_mci_leading_numbers(reader, owner, parts));
    double surplus = 0;
    const char *word = cml_text_word(&reader->cursor), *before = owner ? owner : "",
               *colon = owner ? ": " : "";
    if (word && is_other_unit(word))
        return cml_mci_fail(reader, CML_TEXT("%s%sunit", before, colon), word,
                            "none: lengths are in cm, coefficients in 1/cm");
    if (!word || !cml_parse_double(word, &surplus)) return CML_OK;
    while (parts[1].group != CML_KEYS_NONE) parts++;
    const struct cml_key *last = cml_keys_of(parts->group);
    while (last[1].group == last->group) last++;
    return cml_mci_fail(reader, CML_TEXT("%s%snumber after %s", before, colon, cml_key_shown(last)), word,
                        "the end of the line or a comment");
}

cml_status cml_mci_end_line(struct cml_mci_reader *reader, const char *owner)
{
    const char *word = cml_text_word(&reader->cursor);
    return word ? cml_mci_fail(reader, owner, word, "the end of the line or a comment") : CML_OK;
}

bool cml_mci_next_row(struct cml_mci_reader *rows)
{
    while ((rows->cursor = cml_text_next(&rows->text))) {
        cml_mci_cut_comment(rows->cursor);
        if (rows->cursor[strspn(rows->cursor, blanks)] != '\0') return true;
    }
    return false;
}

cml_status cml_mci_table(struct cml_mci_reader *reader, const char *owner, const char *name,
                         const char *expected, cml_status (*read)(struct cml_mci_reader *rows, void *context),
                         void *context)
{
    CML_AT_END(cml_mci_close)
    struct cml_mci_reader rows = {.options = reader->options, .err = reader->err};
    CML_FREED char *path = NULL;
    if (!name || *name == '"' || *name == '\0')
        return cml_mci_fail(reader, CML_TEXT("%s: file", owner), name, expected);
    CML_TRY(cml_path_beside(reader->text.path, name, &path, reader->err));
    cml_status status = cml_text_read_table(reader->options->source, path, &rows.text, reader->err);
    if (status == CML_OK) status = read(&rows, context);
    return cml_mci_name_line(reader, owner, path, status);
}

const char *cml_mci_why_no_name(const char *name)
{
    const char *slash = strrchr(name, '/');
    const char *last = slash ? slash + 1 : name;
    /* 250 bytes leave room for the endings of other outputs in a directory entry (255 bytes) */
    if (*last == '\0' || strcmp(last, ".") == 0 || strcmp(last, "..") == 0 || strlen(last) > 250 ||
        *name == '"')
        return "a file name of 1..250 bytes";
    for (const char *c = name; *c; c++)
        if ((unsigned char)*c < 0x20 || *c == 0x7f) return "a file name without control characters";
    return NULL;
}
