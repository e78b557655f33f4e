/* SPDX-License-Identifier: MIT */
#include "cli/options/manual.h"

#include <ctype.h>
#include <stdbool.h>
#include <string.h>
#include <strings.h>

static const char *next_line(const char *line)
{
    line += strcspn(line, "\n");
    return line + (*line == '\n');
}

/* Returns the next line that is not a picture, nor the blank line behind one. */
static const char *next_text(const char *line)
{
    line = next_line(line);
    while (strncmp(line, "![", 2) == 0) {
        line = next_line(line);
        line += *line == '\n';
    }
    return line;
}

static void print_line(FILE *stream, const char *line)
{
    fprintf(stream, "%.*s\n", (int)strcspn(line, "\n"), line);
}

const struct cml_manual_page *cml_manual_find(const char *name)
{
    for (const struct cml_manual_page *page = cml_manual; page->name; page++)
        if (strcmp(page->name, name) == 0 || strcmp(page->word, name) == 0) return page;
    return NULL;
}

/* True if the word stands in backquotes within the first `length` letters of a text, alone or before a blank
 * or "=". */
static bool is_quoted(const char *text, size_t length, const char *word)
{
    const size_t own = strlen(word);
    for (const char *at = memchr(text, '`', length); at;
         at = memchr(at + 1, '`', length - (size_t)(at + 1 - text)))
        if (own + 1 < length - (size_t)(at - text) && strncmp(at + 1, word, own) == 0 &&
            strchr("` =", at[1 + own]))
            return true;
    return false;
}

/* Returns the number of '#' of a heading; 0: no heading. *fenced, kept from line to line: the line is inside
 * a block of code. */
static size_t heading_level(const char *line, bool *fenced)
{
    if (strncmp(line, "```", 3) == 0) *fenced = !*fenced;
    return *fenced ? 0 : strspn(line, "#");
}

/* Prints a section, up to the next heading that is not below its own, without pictures. Returns the line
 * behind. */
static const char *print_section(FILE *stream, const char *line)
{
    bool fenced = false;
    const size_t level = heading_level(line, &fenced);
    do {
        print_line(stream, line);
        line = next_text(line);
        const size_t next = heading_level(line, &fenced);
        if (next > 0 && next <= level) break;
    } while (*line);
    return line;
}

/* Prints all sections of a page whose heading has the word in backquotes. Returns how many there are. */
static int print_headed(FILE *stream, const char *text, const char *word)
{
    int count = 0;
    bool fenced = false;
    for (const char *line = text; *line;) {
        if (heading_level(line, &fenced) > 0 && is_quoted(line, strcspn(line, "\n"), word)) {
            line = print_section(stream, line);
            count++;
        } else {
            line = next_line(line);
        }
    }
    return count;
}

/* True if the first cell of a row names the word. Numbers of layers, boundaries, beams and detectors do not
 * count: a cell with `layer1.mua` names "layer12.mua". */
static bool is_row_of(const char *row, const char *word)
{
    const size_t group = strcspn(word, ".0123456789"), cell = 1 + strcspn(row + 1, "|\n");
    const char *member = strrchr(word, '.');
    if (is_quoted(row, cell, word)) return true;
    if (!member || word[0] == '-') return false;
    for (const char *at = row; (at = memchr(at, '`', cell - (size_t)(at - row))) != NULL; at++) {
        const char *end = strchr(at + 1, '`');
        if (end && strncmp(at + 1, word, group) == 0 && (size_t)(end - at) > strlen(member) &&
            strncmp(end - strlen(member), member, strlen(member)) == 0)
            return true;
    }
    return false;
}

/* True if two lines are equal. A line may be NULL. */
static bool is_same_line(const char *a, const char *b)
{
    const size_t length = a ? strcspn(a, "\n") : 0;
    return a && b && strcspn(b, "\n") == length && memcmp(a, b, length) == 0;
}

/* Prints the rows that name a word, under the heads of their tables. *printed: the last head that was
 * printed, which is not repeated. Returns how many rows there are. */
static int print_rows(FILE *stream, const char *text, const char *word, const char **printed)
{
    int count = 0;
    const char *head = NULL;
    for (const char *line = text; *line; line = next_line(line)) {
        if (line[0] != '|') {
            head = NULL;
            continue;
        }
        if (!head) head = line;
        if (line == head || !is_row_of(line, word)) continue;
        if (!is_same_line(*printed, head)) {
            print_line(stream, head);
            print_line(stream, next_line(head));
        }
        *printed = head;
        print_line(stream, line);
        count++;
    }
    return count;
}

/* True if a heading has the id `anchor`. The site makes ids of small letters, digits and "_", with "-" for
 * blanks. */
static bool has_id(const char *heading, const char *anchor, size_t length)
{
    size_t i = 0;
    for (const char *at = heading + strspn(heading, "# "); *at && *at != '\n'; at++) {
        const bool blank = *at == ' ' || *at == '-';
        if (!blank && !isalnum((unsigned char)*at) && *at != '_') continue;
        if (blank && i > 0 && anchor[i - 1] == '-') continue;
        if (i == length || anchor[i] != (blank ? '-' : tolower((unsigned char)*at))) return false;
        i++;
    }
    return i == length;
}

/* Prints the section that a link leads to; without "#" the page up to its first section. target:
 * "input/beams.md#beam)" and the rest of the row. */
static void print_target(FILE *stream, const char *target)
{
    char name[64];
    const size_t path = strcspn(target, ".)"), end = strcspn(target, ")");
    snprintf(name, sizeof name, "%.*s", (int)path, target);
    const struct cml_manual_page *page = cml_manual_find(name);
    const char *anchor = memchr(target, '#', end);
    bool fenced = false;
    if (!page) return;
    for (const char *line = page->text; *line; line = next_text(line)) {
        const size_t level = heading_level(line, &fenced);
        if (!anchor && level > 1) return;
        if (!anchor) print_line(stream, line);
        if (anchor && level > 0 && has_id(line, anchor + 1, (size_t)(target + end - anchor - 1))) {
            print_section(stream, line);
            return;
        }
    }
}

/* True if the word is one of those, separated by commas, in the first cell of a row "| fibre, probe | ...".
 */
static bool is_listed(const char *row, const char *word)
{
    const size_t own = strlen(word), cell = 1 + strcspn(row + 1, "|\n");
    for (size_t i = 1; i < cell; i += strcspn(row + i, ",|")) {
        i += strspn(row + i, ", |");
        const size_t length = strcspn(row + i, ",|");
        if (i < cell && length >= own && strncasecmp(row + i, word, own) == 0 &&
            strspn(row + i + own, " ") == length - own)
            return true;
    }
    return false;
}

/* Prints the rows of the glossary with the word, and the sections they lead to. Returns how many rows there
 * are. */
static int print_glossary(FILE *stream, const char *word)
{
    const struct cml_manual_page *page = cml_manual_find("glossary");
    int count = 0;
    for (const char *line = page ? page->text : ""; *line; line = next_line(line)) {
        if (line[0] != '|' || !is_listed(line, word)) continue;
        print_line(stream, line);
        const char *link = strstr(line, "](");
        if (link && link < next_line(line)) print_target(stream, link + 2);
        count++;
    }
    return count;
}

int cml_manual_print_word(FILE *stream, const char *word)
{
    int count = 0;
    const char *printed = NULL;
    for (const struct cml_manual_page *page = cml_manual; page->name && *word; page++) {
        const int sections = print_headed(stream, page->text, word);
        if (sections > 0) printed = NULL;
        count += sections + print_rows(stream, page->text, word, &printed);
    }
    return count > 0 ? count : print_glossary(stream, word);
}
