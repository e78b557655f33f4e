/* SPDX-License-Identifier: MIT */
#include "cli/options/help.h"

#include "base/text.h"
#include "cli/options/manual.h"
#include "options/option_table.h"
#include "input/keys/key.h"

#include <string.h>

/* Columns of the text, and column where the description of an item begins. */
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

/* Prints a text broken at blanks; it begins in column `column`, further lines at `indent`. */
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

/* Prints an item: the words to type, and the description beside them, or below if there is no room. */
static void print_item(FILE *stream, const char *typed, const char *text)
{
    fprintf(stream, "  %-*s", INDENT - 2, typed);
    if (strlen(typed) > INDENT - 4) fprintf(stream, "\n%*s", INDENT, "");
    print_wrapped(stream, text, INDENT, INDENT);
}

/* Prints one option: how it is typed, and its help. owners: adds the commands that it belongs to. */
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

/* Prints the options of one command; or all options, with the names of their commands. */
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

/* Prints the words of all pages of a folder of the manual on one line, for `help` without a topic. */
static void print_pages(FILE *stream, const char *folder)
{
    char names[640] = "";
    size_t length = 0;
    for (const struct cml_manual_page *page = cml_manual; page->name; page++) {
        const size_t own = strcspn(page->name, "/");
        const bool is_index = strstr(page->name, "/index");
        if (is_index || own != strlen(folder) || strncmp(page->name, folder, own) != 0) continue;
        length +=
            (size_t)snprintf(names + length, sizeof names - length, "%s%s", length ? ", " : "", page->word);
    }
    print_item(stream, folder, names);
}

/* Lists the topics of help: kinds of words first, then the pages of the manual. A folder of pages is one
 * entry. */
static void print_topics(FILE *stream)
{
    fprintf(stream, "\ntopics of help\n");
    print_item(stream, "COMMAND", "what it does, its options and an example");
    print_item(stream, "options", "all options");
    print_item(stream, "keys", "all keys of a scene's lines, with their ranges and names for --set");
    print_item(stream, "--OPTION", "one, and the section of the manual on it");
    print_item(stream, "WORD",
               "a line of the scene (beam) or a key (mua), a name that --set takes (layer1.mua), an array "
               "(Rd_r), or a word of the field (fibre, spectrum)");
    fprintf(stream, "\npages of the manual\n");
    for (const struct cml_manual_page *page = cml_manual; page->name; page++) {
        char folder[40], title[80];
        const char *begin = page->text + strspn(page->text, "# ");
        snprintf(folder, sizeof folder, "%.*s", (int)strcspn(page->name, "/"), page->name);
        snprintf(title, sizeof title, "%.*s", (int)strcspn(begin, "\n"), begin);
        if (strcmp(page->name, "index") == 0) continue;
        if (!strchr(page->name, '/'))
            print_item(stream, folder, title);
        else if (page == cml_manual || strncmp(page[-1].name, page->name, strlen(folder) + 1) != 0)
            print_pages(stream, folder);
    }
}

/* Prints a table of keys for each line of a scene. The pages of samples/manual/input have the same rows. */
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

/* Prints the overview: usage, commands, topics, exit codes and examples. */
static void print_list(FILE *stream)
{
    fprintf(stream, "%s\ncommands\n", usage);
    for (int i = 0; i < CML_NUM_COMMANDS; i++) {
        const struct cml_command_def *command = &cml_commands[i];
        print_item(stream,
                   CML_TEXT("%s%s%s%s%s", i == 0 ? "[" : "", command->name, i == 0 ? "]" : "",
                            command->operands[0] ? " " : "", command->operands),
                   command->summary);
    }
    print_topics(stream);
    fprintf(stream, "\nexit codes\n");
    for (size_t i = 0; i < sizeof exit_codes / sizeof *exit_codes; i++)
        print_item(stream, CML_TEXT("%d", exit_codes[i].code), exit_codes[i].text);
    fprintf(stream, "\nexamples\n  clustermcml samples/mcml_sample.mci\n"
                    "  clustermcml samples/shapes/hihill.mci --photons 1e7 -o results\n"
                    "  clustermcml plot results/hihill.mco -o hihill.svg\n");
}

/* Prints the help of a command: usage, text, options and examples. */
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

/* Prints an option with its commands, then what the manual says about it. */
static void print_one_option(FILE *stream, const struct cml_option *option)
{
    print_option(stream, option, true);
    cml_manual_print_word(stream, CML_TEXT("--%s", option->name));
}

/* Refuses an option --NAME that does not exist, and suggests the one with the most similar name. */
static cml_status refuse_option(const char *topic, struct cml_error *err)
{
    const char *name = topic + strlen("--"), *meant = cml_option_guess(name, strlen(name));
    if (meant) return cml_fail(err, CML_E_INPUT, "unknown option %s (did you mean --%s?)", topic, meant);
    return cml_fail(err, CML_E_INPUT, "unknown option %s (try clustermcml --help)", topic);
}

/* Refuses a topic that help does not know, and suggests the command or page with the most similar name. */
static cml_status refuse_topic(const char *topic, struct cml_error *err)
{
    if (strncmp(topic, "--", 2) == 0) return refuse_option(topic, err);
    struct cml_guess guess = {.word = topic, .length = strlen(topic)};
    for (int i = 0; i < CML_NUM_COMMANDS; i++) cml_guess_offer(&guess, cml_commands[i].name);
    for (const struct cml_manual_page *page = cml_manual; page->name; page++)
        cml_guess_offer(&guess, page->word);
    const char *meant = cml_guess_best(&guess), *shown = *topic ? topic : "\"\"";
    if (meant) return cml_fail(err, CML_E_INPUT, "help: no text on %s (did you mean %s?)", shown, meant);
    return cml_fail(err, CML_E_INPUT, "help: no text on %s (try clustermcml help)", shown);
}

/* Prints the help on a topic. Names are looked up in this order: lists, options, commands, pages of the
 * manual, and words that the manual explains. */
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
    const struct cml_manual_page *page = cml_manual_find(topic);
    if (page) {
        fputs(page->text, stream);
        return CML_OK;
    }
    option = cml_option_find(topic, strlen(topic));
    if (option) print_one_option(stream, option);
    found = cml_manual_print_word(stream, topic) > 0 || option ||
            cml_manual_print_word(stream, CML_TEXT("--%s", topic)) > 0;
    return found ? CML_OK : refuse_topic(topic, err);
}
