/* SPDX-License-Identifier: MIT */
#include "cli/options/options_parse.h"

#include "options/option_read.h"
#include "options/option_table.h"
#include "options/option_values.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* ---- words ---- */

enum word_kind { WORD_END, WORD_OPERAND, WORD_OPTION };

/* State of going through argv. The last five members describe the word read last. */
struct words {
    int argc, at;
    char **argv;
    enum cml_command command; /* chooses among options that share a letter */
    const char *letters;      /* rest of a group of letters like -xh */
    bool ended;               /* -- was read: only operands follow */
    char *operand;
    const struct cml_option *option; /* option of the last word; NULL: unknown */
    char typed[64];                  /* name of the option with its dashes; cut off if longer */
    const char *value;               /* value of the option; NULL: none */
    bool surplus;                    /* a value stands behind an option that takes none */
};

/* Takes the value of an option: the text `behind` in the same word, or else the next word, whatever it is
 * (--seed -1). */
static void take_value(struct words *words, const char *behind)
{
    words->value = NULL;
    if (!words->option || !words->option->argument) return;
    words->value = behind ? behind : words->at < words->argc ? words->argv[words->at++] : NULL;
}

/* Takes the next option of a group of letters like -xh. An option with a value ends the group: the rest of
 * the word, or the next word, is its value. */
static enum word_kind take_letter(struct words *words)
{
    const char letter = *words->letters++;
    snprintf(words->typed, sizeof words->typed, "-%c", letter);
    words->option = cml_option_of_letter(letter, words->command);
    words->surplus = false;
    const bool takes = words->option && words->option->argument;
    const char *behind = takes && *words->letters ? words->letters : NULL;
    if (takes || !*words->letters) words->letters = NULL;
    take_value(words, behind);
    return WORD_OPTION;
}

/* Takes a long option, --name or --name=value. surplus: a value was given to an option that takes none. */
static enum word_kind take_name(struct words *words, const char *name)
{
    const size_t length = strcspn(name, "=");
    const char *behind = name[length] ? name + length + 1 : NULL;
    snprintf(words->typed, sizeof words->typed, "--%.*s", length < 60 ? (int)length : 60, name);
    words->option = cml_option_find(name, length);
    words->surplus = behind && words->option && !words->option->argument;
    take_value(words, behind);
    return WORD_OPTION;
}

/* Reads the next word of the command line: a long option, a letter of a group like -qo, or an operand. All
 * words behind `--` are operands. */
static enum word_kind next_word(struct words *words)
{
    if (words->letters) return take_letter(words);
    if (words->at >= words->argc) return WORD_END;
    char *word = words->argv[words->at++];
    const bool dashed = !words->ended && word[0] == '-' && word[1];
    if (dashed && strcmp(word, "--") == 0) {
        words->ended = true;
        return next_word(words);
    }
    words->operand = word;
    if (!dashed) return WORD_OPERAND;
    if (word[1] == '-') return take_name(words, word + 2);
    words->letters = word + 1;
    return take_letter(words);
}

/* ---- refusals ---- */

/* Refuses a word that looks like an option but is none, and suggests the nearest name: also for a long name
 * behind a single dash. */
static cml_status refuse_unknown(const struct words *words, struct cml_error *err)
{
    const char *name = words->typed + 2, *meant = NULL, *whole = words->operand + 1;
    const struct cml_option *written = cml_option_find(whole, strcspn(whole, "="));
    if (words->typed[1] == '-') meant = cml_option_guess(name, strlen(name));
    if (words->typed[1] != '-' && written) /* a long option with a single dash, like -photons */
        return cml_fail(err, CML_E_INPUT, "unknown option %s (did you mean --%s?)", words->operand,
                        written->name);
    if (!meant) return cml_fail(err, CML_E_INPUT, "unknown option %s (try clustermcml --help)", words->typed);
    return cml_fail(err, CML_E_INPUT, "unknown option %s (did you mean --%s?)", words->typed, meant);
}

/* Returns the command that the first operand was perhaps meant as; NULL: none. A single operand is a scene if
 * such a file exists. */
static const char *misspelt_command(const struct cml_options *options)
{
    if (options->named || options->num_operands == 0) return NULL;
    const char *word = options->operands[0];
    const bool is_scene = options->num_operands == 1 && (strpbrk(word, "./") || access(word, F_OK) == 0);
    return is_scene ? NULL : cml_command_guess(word);
}

/* Refuses a wrong number of operands. The usual mistakes, no scene or two scenes, get messages of their own;
 * others get the usage. */
static cml_status refuse_operands(const struct cml_options *options, struct cml_error *err)
{
    const struct cml_command_def *command = &cml_commands[options->which];
    char *const *operands = options->operands;
    if (!options->named && options->num_operands == 0)
        return cml_fail(err, CML_E_INPUT,
                        "no scene (expected clustermcml scene.mci; clustermcml help lists all commands)");
    if (options->num_operands > 1 && strcmp(command->operands, "scene.mci") == 0)
        return cml_fail(
            err, CML_E_INPUT,
            "%s takes one scene, not %s and %s (a file may hold several runs; for several files call it "
            "once for each)",
            command->name, operands[0], operands[1]);
    return cml_fail(err, CML_E_INPUT, "usage: clustermcml %s%s%s (try clustermcml help %s)", command->name,
                    command->operands[0] ? " " : "", command->operands, command->name);
}

/* Refuses `fit`: this program has no library for least squares, the Python package has. */
static cml_status refuse_fit(int argc, char **argv, const struct cml_options *options, struct cml_error *err)
{
    const bool fit = argc > 1 && strcmp(argv[1], "fit") == 0 && access(argv[1], F_OK) != 0;
    if (!fit || options->help || options->version) return CML_OK;
    return cml_fail(err, CML_E_INPUT,
                    "fit: a command of the Python package (expected python3 -m clustermcml fit; clustermcml "
                    "help fit says more)");
}

/* ---- reading ---- */

/* Keeps the command line as typed; call it before operands are moved to the front. */
static void keep_command(int argc, char **argv, struct cml_options *options)
{
    size_t used = 0;
    for (int i = 0; i < argc && used < sizeof options->command; i++)
        used += (size_t)snprintf(options->command + used, sizeof options->command - used, "%s%s",
                                 i > 0 ? " " : "", argv[i]);
}

/* Appends a word and a line feed to a text of `size` bytes; false if it does not fit, or has a line feed
 * itself. */
static bool append(char *text, size_t size, const char *word)
{
    const size_t used = strlen(text);
    if (used + strlen(word) + 2 > size || strchr(word, '\n')) return false;
    snprintf(text + used, size - used, "%s\n", word);
    return true;
}

/* Copies the command line of a part into options->call, without --part and --resume, because `merge` repeats
 * the call for the whole run. The copy is empty if the command line is too long. */
static void keep_call(int argc, char **argv, struct cml_options *options)
{
    struct words words = {.argc = argc, .at = 1, .argv = argv, .command = options->which};
    bool fits = argc > 0 && append(options->call, sizeof options->call, argv[0]);
    for (int from = 1; fits; from = words.at) {
        const enum word_kind kind = next_word(&words);
        if (kind == WORD_END) return;
        if (kind == WORD_OPTION && words.option &&
            (words.option->read == cml_read_part || strcmp(words.option->name, "resume") == 0))
            continue;
        for (int i = from; fits && i < words.at; i++)
            fits = append(options->call, sizeof options->call, argv[i]);
    }
    options->call[0] = '\0';
}

/* Reads in advance the words that decide which options are allowed, wherever they stand: the command, the
 * engine and --help. Mistakes are left to the second reading. */
static void look_ahead(int argc, char **argv, struct cml_options *options)
{
    struct words words = {.argc = argc, .at = 1, .argv = argv};
    bool first = true;
    for (enum word_kind kind = next_word(&words); kind != WORD_END; kind = next_word(&words)) {
        const struct cml_option *option = words.option;
        struct cml_error later;
        if (kind == WORD_OPERAND && first) {
            const enum cml_command command = cml_command_find(words.operand);
            options->named = command != CML_NUM_COMMANDS;
            if (options->named) options->which = command;
            first = false;
        } else if (kind == WORD_OPTION && option && (!option->argument || option->read == cml_read_engine)) {
            if (words.value || !option->argument) (void)option->read(option, words.value, options, &later);
        }
    }
}

/* True if the option is a topic of help (help --set, help -o). A topic has no value, so the next word is put
 * back. A long option that is not in the table may belong to the Python package. */
static bool is_topic(struct words *words, const struct cml_options *options)
{
    const bool name = words->typed[1] == '-';
    if (options->which != CML_COMMAND_HELP || (!name && (!words->option || words->operand[2])) ||
        (words->option && cml_option_belongs(words->option, CML_COMMAND_HELP)))
        return false;
    if (words->value && words->value == words->argv[words->at - 1]) words->at--;
    return true;
}

cml_status cml_options_parse(int argc, char **argv, struct cml_options *options, struct cml_error *err)
{
    cml_options_default(options);
    keep_command(argc, argv, options);
    look_ahead(argc, argv, options);
    keep_call(argc, argv, options);
    CML_TRY(refuse_fit(argc, argv, options, err));
    struct words words = {.argc = argc, .at = 1, .argv = argv, .command = options->which};
    int operands = 0;
    for (enum word_kind kind = next_word(&words); kind != WORD_END; kind = next_word(&words)) {
        if (kind == WORD_OPERAND || is_topic(&words, options)) {
            argv[1 + operands++] =
                words.operand; /* the operand moves to a place before `at`, so no word is lost */
            continue;
        }
        if (!words.option) return refuse_unknown(&words, err);
        CML_TRY(cml_option_read(words.option, words.typed, words.value, words.surplus, options, err));
    }
    options->operands = argv + 1 + options->named;
    options->num_operands = operands - options->named;
    if (options->help || options->version) return CML_OK;
    const char *meant = misspelt_command(options);
    if (meant)
        return cml_fail(err, CML_E_INPUT, "unknown command %s (did you mean %s?)", options->operands[0],
                        meant);
    const struct cml_command_def *command = &cml_commands[options->which];
    const bool fits = options->num_operands >= command->least && options->num_operands <= command->most;
    return fits ? CML_OK : refuse_operands(options, err);
}
