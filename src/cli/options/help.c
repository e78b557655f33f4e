/* SPDX-License-Identifier: MIT */
#include "cli/options/help.h"

#include "base/text.h"
#include "cli/options/option_table.h"
#include "input/keys/key.h"

#include <ctype.h>
#include <string.h>

/* Columns: of the text, and of what an item does. */
enum { WIDTH = 80, INDENT = 26 };

static const char usage[] = "usage: clustermcml [COMMAND] OPERANDS [OPTIONS]\n";

static const struct {
    int code;
    const char *text;
} exit_codes[] = {
    {0, "done"},
    {1, "results differ (compare, crosscheck, furnace)"},
    {2, "usage or input, or a request that does not fit into memory"},
    {3, "no device, or one that failed"},
    {4, "numerical: lost packets, or a balance of weights that is not 0; the result is written all the same"},
    {5, "a file or standard output could not be written, a rank was lost, or Python or a module of it is "
        "missing"},
    {75, "stopped by a signal; --resume continues"},
    {141, "who read standard output went away; files are written all the same"},
};

/* Broken at blanks, from `column` on; further lines begin at `indent`. */
static void print_wrapped(FILE *stream, const char *text, size_t column, size_t indent)
{
    while (*text) {
        const size_t length = strcspn(text, " ");
        if (column > indent && column + 1 + length > WIDTH) {
            fprintf(stream, "\n%*s", (int)indent, "");
            column = indent;
        } else if (column > indent) {
            fputc(' ', stream);
            column++;
        }
        fwrite(text, 1, length, stream);
        column += length;
        text += length + (text[length] == ' ');
    }
    fputc('\n', stream);
}

/* What is typed, and what it does beside it, or below where there is no room. */
static void print_item(FILE *stream, const char *typed, const char *text)
{
    fprintf(stream, "  %-*s", INDENT - 2, typed);
    if (strlen(typed) > INDENT - 4) fprintf(stream, "\n%*s", INDENT, "");
    print_wrapped(stream, text, INDENT, INDENT);
}

static void print_option(FILE *stream, const struct cml_option *option, bool owners)
{
    char letter[8] = "", typed[80], commands[160] = "", text[640];
    if (option->letter) snprintf(letter, sizeof letter, "-%c, ", option->letter);
    snprintf(typed, sizeof typed, "%s--%s%s%s", letter, option->name, option->argument ? " " : "",
             option->argument ? option->argument : "");
    cml_option_commands(option, commands, sizeof commands);
    snprintf(text, sizeof text, owners ? "%s (%s)" : "%s", option->help, commands);
    print_item(stream, typed, text);
}

/* Prints the options of one command, or those of all with the names of their commands. */
static void print_options(FILE *stream, enum cml_command command)
{
    const bool all = command == CML_NUM_COMMANDS;
    const char *title = NULL;
    for (size_t i = 0; i < cml_option_count; i++) {
        const struct cml_option *option = &cml_option_table[i];
        if (option->title) title = option->title;
        if (!all && !cml_option_belongs(option, command)) continue;
        if (title) fprintf(stream, "\n%s\n", title);
        title = NULL;
        print_option(stream, option, all);
    }
}

/* The first lines of the texts, less the '#' of a heading, say what they are. */
static void print_topics(FILE *stream)
{
    fprintf(stream, "\ntopics of help\n");
    print_item(stream, "COMMAND", "what it does, its options and an example");
    print_item(stream, "options", "all options");
    print_item(stream, "keys", "all keys of a scene's lines, with their ranges and names for --set");
    print_item(stream, "--OPTION", "one, and what the texts say of it, as the names that --set takes");
    print_item(stream, "WORD",
               "a line of the scene (beam) or a word of one (mua), a name that --set takes (layer1.mua), an "
               "array (Rd_r)");
    for (const struct cml_help_text *text = cml_help_texts; text->name; text++) {
        char title[80];
        const char *begin = text->text + strspn(text->text, "# ");
        snprintf(title, sizeof title, "%.*s", (int)strcspn(begin, "\n"), begin);
        print_item(stream, text->name, title);
    }
}

/* A table for each line of a scene. The pages of the manual on these lines show the same rows. */
static void print_keys(FILE *stream)
{
    char range[CML_KEY_TEXT];
    const char *line = "";
    for (const struct cml_key *key = cml_key_table; key->group != CML_KEYS_NONE; key++) {
        const struct cml_key_owner *owner = &cml_key_owners[key->group];
        if (!key->meaning) continue;
        if (strcmp(line, owner->line) != 0)
            fprintf(stream, "%s**%s**\n\n| key | unit | range | default | meaning |\n|---|---|---|---|---|\n",
                    *line ? "\n" : "", owner->line);
        line = owner->line;
        fprintf(stream, "| `%s`", key->name);
        if (key->use & CML_KEY_SET && *owner->set) fprintf(stream, ", `%s.%s`", owner->set, key->name);
        fprintf(stream, " | %s | %s | %s | %s |\n", key->unit ? key->unit : "-", cml_key_range(key, range),
                cml_key_fallback(key), key->meaning);
    }
}

static void print_list(FILE *stream)
{
    fprintf(stream, "%s\ncommands\n", usage);
    for (int i = 0; i < CML_NUM_COMMANDS; i++) {
        const struct cml_command_def *command = &cml_commands[i];
        char typed[80];
        snprintf(typed, sizeof typed, "%s%s%s%s%s", i == 0 ? "[" : "", command->name, i == 0 ? "]" : "",
                 command->operands[0] ? " " : "", command->operands);
        print_item(stream, typed, command->summary);
    }
    print_topics(stream);
    fprintf(stream, "\nexit codes\n");
    for (size_t i = 0; i < sizeof exit_codes / sizeof *exit_codes; i++) {
        char code[8];
        snprintf(code, sizeof code, "%d", exit_codes[i].code);
        print_item(stream, code, exit_codes[i].text);
    }
    fprintf(stream, "\nexamples\n  clustermcml samples/mcml_sample.mci\n"
                    "  clustermcml samples/shapes/hihill.mci --photons 1e7 -o results\n"
                    "  clustermcml plot results/hihill.mco -o hihill.svg\n");
}

static void print_command(FILE *stream, enum cml_command which)
{
    const struct cml_command_def *command = &cml_commands[which];
    fprintf(stream, "usage: clustermcml %s%s%s [options]\n\n", command->name, command->operands[0] ? " " : "",
            command->operands);
    print_wrapped(stream, command->text, 0, 0);
    print_options(stream, which);
    fprintf(stream, "\nexamples\n");
    for (const char *line = command->example; *line; line += strcspn(line, "\n") + 1)
        fprintf(stream, "  %.*s\n", (int)strcspn(line, "\n"), line);
}

/* Whether the word, or it and what follows a blank, stands between grave accents somewhere in the text. */
static bool is_named(const char *text, size_t length, const char *word)
{
    for (const char *at = memchr(text, '`', length); at;
         at = memchr(at + 1, '`', length - (size_t)(at + 1 - text))) {
        const size_t left = length - (size_t)(at + 1 - text), own = strlen(word);
        if (own < left && strncmp(at + 1, word, own) == 0 && strchr("` ", at[1 + own])) return true;
    }
    return false;
}

/* Whether the text at a title begins like "`beam`" or "`i "vessel.obj"`". */
static bool is_headed(const char *title, const char *word)
{
    const size_t length = strlen(word);
    return title[0] == '`' && strncmp(title + 1, word, length) == 0 &&
           (title[1 + length] == '`' || title[1 + length] == ' ');
}

/* Indented lines that begin with a word of the scene's grammar, of which there is a passage. Returns how many
 * were printed, as those below do. */
static int print_grammar(FILE *stream, const char *text, const char *word)
{
    const size_t length = strlen(word);
    const char *passage = strstr(text, "\n\n**");
    int count = 0;
    while (passage && !is_headed(passage + 4, word)) passage = strstr(passage + 1, "\n\n**");
    if (!passage) return 0;
    for (const char *line = text; *line; line += strcspn(line, "\n"), line += *line == '\n') {
        if (strncmp(line, "    ", 4) != 0 || strncmp(line + 4, word, length) != 0) continue;
        if (line[4 + length] != ' ' && line[4 + length] != '\n') continue;
        fprintf(stream, "%.*s\n", (int)strcspn(line, "\n"), line);
        count++;
    }
    return count;
}

/* Rows of tables whose first cell names the word; of layer1.mua those that name `layer1.n`, `.mua`. */
static int print_rows(FILE *stream, const char *text, const char *word)
{
    const size_t group = strcspn(word, ".0123456789");
    const char *member = strrchr(word, '.');
    char first[40], last[40];
    int count = 0;
    snprintf(first, sizeof first, "`%.*s", (int)group, word);
    snprintf(last, sizeof last, "%s`", member ? member : "");
    for (const char *line = text; *line; line += strcspn(line, "\n"), line += *line == '\n') {
        const size_t cell = strcspn(line, "\n"), bar = cell > 2 ? 2 + strcspn(line + 2, "|\n") : 0;
        char names[200];
        if (line[0] != '|' || bar >= sizeof names) continue;
        snprintf(names, sizeof names, "%.*s", (int)bar, line);
        const bool swept = member && word[0] != '-' && strstr(names, first) && strstr(names, last);
        if (!swept && !is_named(names, bar, word)) continue;
        fprintf(stream, "%.*s\n", (int)cell, line);
        count++;
    }
    return count;
}

/* What begins like "**`--set`**" or "**`--sweep TABLE`**", or, if `elsewhere`, under another heading than an
 * option's and names it, up to the next heading. */
static int print_passages(FILE *stream, const char *text, const char *word, bool elsewhere)
{
    static const char mark[] = "\n\n**", heading[] = "\n\n## ";
    int count = 0;
    for (const char *at = strstr(text, mark); at; at = strstr(at + 1, mark)) {
        const char *title = at + strlen(mark), *next = strstr(at + 1, mark), *above = strstr(at + 1, heading);
        const char *end = next && (!above || next < above) ? next : above ? above : at + strlen(at);
        if (!is_headed(title, word) &&
            (!elsewhere || title[0] == '`' || !is_named(title, (size_t)(end - title), word)))
            continue;
        fprintf(stream, "%.*s\n", (int)(end - at - 1), at + 1);
        count++;
    }
    return count;
}

static bool is_letter(char c)
{
    return isalnum((unsigned char)c) || c == '_' || c == '-';
}

/* Whether the word, whole, stands in the line from its beginning on, below `length`. */
static bool has_word(const char *line, size_t length, const char *word)
{
    const size_t own = strlen(word);
    for (size_t i = 0; i + own <= length; i++)
        if (strncmp(line + i, word, own) == 0 && (i == 0 || !is_letter(line[i - 1])) &&
            !is_letter(line[i + own]))
            return true;
    return false;
}

/* Lines of a scene and rows of tables that have the word, as `mua` or `light`: in a row the first cell has
 * it, and where that is a table's head, all rows are printed. */
static int print_mentions(FILE *stream, const char *text, const char *word)
{
    int count = 0;
    bool whole = false, fenced = false;
    for (const char *line = text; *line; line += strcspn(line, "\n"), line += *line == '\n') {
        const size_t length = strcspn(line, "\n"), cell = 1 + strcspn(line + (length > 0), "|\n");
        const bool row = line[0] == '|', head = row && strncmp(line + length, "\n|--", 4) == 0;
        fenced ^= strncmp(line, "```", 3) == 0;
        whole = (whole && row) || (head && line[2] == '`' && has_word(line, cell, word));
        const bool found = row ? !head && has_word(line, cell, word)
                               : !fenced && strncmp(line, "    ", 4) == 0 && has_word(line, length, word);
        if (!whole && !found) continue;
        fprintf(stream, "%.*s\n", (int)length, line);
        count++;
    }
    return count;
}

/* Paragraphs in which it stands between grave accents, as `InParm` does. */
static int print_paragraphs(FILE *stream, const char *text, const char *word)
{
    int count = 0;
    for (const char *at = text, *end; at; at = end ? end + 2 : NULL) {
        end = strstr(at, "\n\n");
        const size_t length = end ? (size_t)(end - at) : strlen(at);
        if (!is_named(at, length, word)) continue;
        fprintf(stream, "%.*s\n", (int)length, at);
        count++;
    }
    return count;
}

/* What the texts say of a word of a scene, of a name that --set takes, of an array: where it has a place of
 * its own, else wherever it stands. */
static int print_word(FILE *stream, const char *word)
{
    int count = 0;
    for (const struct cml_help_text *text = cml_help_texts; text->name; text++) {
        count += print_grammar(stream, text->text, word);
        count += print_rows(stream, text->text, word);
        count += print_passages(stream, text->text, word, false);
    }
    for (const struct cml_help_text *text = cml_help_texts; count == 0 && text->name; text++)
        count = print_mentions(stream, text->text, word);
    for (const struct cml_help_text *text = cml_help_texts; count == 0 && text->name; text++)
        count = print_paragraphs(stream, text->text, word);
    return count;
}

static void print_one_option(FILE *stream, const struct cml_option *option)
{
    char typed[48];
    int found = 0;
    snprintf(typed, sizeof typed, "--%s", option->name);
    print_option(stream, option, true);
    for (const struct cml_help_text *text = cml_help_texts; text->name; text++)
        found += print_passages(stream, text->text, typed, false);
    if (found > 0) return;
    for (const struct cml_help_text *text = cml_help_texts; text->name; text++)
        print_rows(stream, text->text, typed);
    for (const struct cml_help_text *text = cml_help_texts; text->name; text++)
        print_passages(stream, text->text, typed, true);
}

static cml_status refuse(const char *topic, struct cml_error *err)
{
    struct cml_guess guess = {.word = topic, .length = strlen(topic)};
    for (int i = 0; i < CML_NUM_COMMANDS; i++) cml_guess_offer(&guess, cml_commands[i].name);
    for (const struct cml_help_text *text = cml_help_texts; text->name; text++)
        cml_guess_offer(&guess, text->name);
    const char *meant = cml_guess_best(&guess);
    if (strncmp(topic, "--", 2) == 0) {
        meant = cml_option_guess(topic + 2, strlen(topic + 2));
        return cml_fail(err, CML_E_INPUT, "unknown option %s (%s%s%s)", topic,
                        meant ? "did you mean --" : "try clustermcml --help", meant ? meant : "",
                        meant ? "?" : "");
    }
    return cml_fail(err, CML_E_INPUT, "help: no text on %s (%s%s%s)", *topic ? topic : "\"\"",
                    meant ? "did you mean " : "try clustermcml help", meant ? meant : "", meant ? "?" : "");
}

cml_status cml_help_print(FILE *stream, const char *topic, struct cml_error *err)
{
    if (!topic) {
        print_list(stream);
        return CML_OK;
    }
    if (strcmp(topic, "keys") == 0) {
        print_keys(stream);
        return CML_OK;
    }
    if (strcmp(topic, "options") == 0) {
        fputs(usage, stream);
        print_options(stream, CML_NUM_COMMANDS);
        return CML_OK;
    }
    bool found = false;
    const struct cml_option *option =
        strncmp(topic, "--", 2) == 0 ? cml_option_find(topic + 2, strlen(topic + 2)) : NULL;
    for (size_t i = 0; i < cml_option_count; i++) {
        const struct cml_option *one = &cml_option_table[i];
        const bool lettered = topic[0] == '-' && one->letter && one->letter == topic[1] && !topic[2];
        if (one == option || lettered) print_one_option(stream, one);
        found |= one == option || lettered;
    }
    if (found) return CML_OK;
    const enum cml_command command = cml_command_find(topic);
    if (command != CML_NUM_COMMANDS) {
        print_command(stream, command);
        return CML_OK;
    }
    const struct cml_help_text *text = cml_help_texts;
    while (text->name && strcmp(text->name, topic) != 0) text++;
    if (!text->name) {
        char dashed[64];
        snprintf(dashed, sizeof dashed, "--%s", topic);
        option = cml_option_find(topic, strlen(topic));
        if (option) print_one_option(stream, option);
        found = (*topic && print_word(stream, topic) > 0) || option || print_word(stream, dashed) > 0;
        return found ? CML_OK : refuse(topic, err);
    }
    fputs(text->text, stream);
    return CML_OK;
}
