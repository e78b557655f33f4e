/* Tests of the parser of the command line: order of words, values, one-letter options, and which command
 * may have which option. Expected values are written out. SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <string.h>

#include "options/option_table.h"
#include "cli/options/options_parse.h"

enum { MOST = 16 };

/* Parses a line whose words are separated by single blanks; two blanks stand for an empty word between
 * them. The words live until the next call. */
static cml_status parse(const char *line, struct cml_options *options, struct cml_error *err)
{
    static char text[512];
    static char *argv[MOST + 2];
    int argc = 0;
    argv[argc++] = "clustermcml";
    snprintf(text, sizeof text, "%s", line);
    for (char *word = text; *line && word && argc <= MOST;) {
        char *blank = strchr(word, ' ');
        if (blank) *blank = '\0';
        argv[argc++] = word;
        word = blank ? blank + 1 : NULL;
    }
    argv[argc] = NULL;
    *err = (struct cml_error){CML_OK, ""};
    return cml_options_parse(argc, argv, options, err);
}

static struct cml_options accepted(const char *line)
{
    struct cml_options options;
    struct cml_error err;
    if (parse(line, &options, &err) != CML_OK) fail_msg("%s: %s", line, err.text);
    return options;
}

static void refused(const char *line, const char *message)
{
    struct cml_options options;
    struct cml_error err;
    assert_int_equal(parse(line, &options, &err), CML_E_INPUT);
    assert_string_equal(err.text, message);
}

static void options_and_operands_mix(void **state)
{
    (void)state;
    const char *const lines[] = {"trace a.mci 7 --run 2", "--run 2 trace a.mci 7", "trace --run=2 a.mci 7",
                                 "trace a.mci --run 2 -- 7", "--run 1 trace a.mci 7 --run 2"};
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        const struct cml_options options = accepted(lines[i]);
        assert_int_equal(options.which, CML_COMMAND_TRACE);
        assert_int_equal(options.run, 2);
        assert_int_equal(options.num_operands, 2);
        assert_string_equal(options.operands[0], "a.mci");
        assert_string_equal(options.operands[1], "7");
        assert_non_null(strstr(options.command, lines[i]));
    }
}

static void a_word_that_is_no_command_is_a_scene(void **state)
{
    (void)state;
    assert_int_equal(accepted("a.mci").which, CML_COMMAND_RUN);
    assert_string_equal(accepted("-").operands[0], "-");
    assert_string_equal(accepted("-- --photons").operands[0], "--photons");
    assert_string_equal(accepted("run check").operands[0], "check");
    assert_false(accepted("a.mci").named);
    assert_true(accepted("run a.mci").named);
}

static void letters_take_the_rest_of_their_word_or_the_next(void **state)
{
    (void)state;
    assert_string_equal(accepted("a.mci -o out").directory, "out");
    assert_string_equal(accepted("a.mci -oout").directory, "out");
    assert_string_equal(accepted("a.mci -o -h").directory, "-h");
    assert_string_equal(accepted("merge a.mco b.mco -o c").directory, "c");
    assert_string_equal(accepted("-o c merge a.mco b.mco").directory, "c");
    assert_true(accepted("-h").help);
    assert_string_equal(accepted("a.mci -ho out").directory, "out");
    refused("a.mci -o", "-o is missing its value (try clustermcml --help)");
    refused("a.mci -hx", "unknown option -x (try clustermcml --help)");
}

static void a_value_may_look_like_anything(void **state)
{
    (void)state;
    assert_string_equal(accepted("crosscheck a.mci --dump --log").dump, "--log");
    assert_string_equal(accepted("crosscheck a.mci --dump=").dump, "");
    assert_string_equal(accepted("crosscheck a.mci --dump a=b").dump, "a=b");
    assert_string_equal(accepted("crosscheck a.mci --dump=a=b").dump, "a=b");
    assert_string_equal(accepted("crosscheck a.mci --dump ").dump, "");
    refused("a.mci --seed -1", "--seed -1 (expected a whole number from 0 to 9007199254740992)");
    refused("a.mci --seed", "--seed is missing its value (try clustermcml --help)");
    refused("a.mci --quiet=1", "--quiet takes no value (try clustermcml --help)");
}

static void names_are_written_out(void **state)
{
    (void)state;
    refused("a.mci --phot 1", "unknown option --phot (did you mean --photons?)");
    refused("a.mci --photns 1", "unknown option --photns (did you mean --photons?)");
    refused("a.mci --photonss", "unknown option --photonss (did you mean --photons?)");
    refused("a.mci --ignore-", "unknown option --ignore- (try clustermcml --help)");
    refused("a.mci --r", "unknown option --r (try clustermcml --help)");
    refused("a.mci --=", "unknown option -- (try clustermcml --help)");
    refused("a.mci --abcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyz",
            "unknown option --abcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyzabcdefgh (try clustermcml "
            "--help)");
}

/* Returns as many operands as the command needs at least. */
static const char *operands_of(int command)
{
    static const char *const operands[] = {" a", " a b", "", " a"};
    const int least = cml_commands[command].least;
    return least == 0 ? operands[2] : operands[least - 1];
}

/* Tries every pair of option and command. An option that the command does not have is refused by name; any
 * other pair must not give that message. */
static void an_option_belongs_to_the_commands_of_its_row(void **state)
{
    (void)state;
    for (size_t i = 0; i < cml_option_count; i++) {
        const struct cml_option *option = &cml_option_table[i];
        for (int command = 0; command < CML_NUM_COMMANDS; command++) {
            char line[128], start[128];
            struct cml_options options;
            struct cml_error err;
            snprintf(line, sizeof line, "%s%s --%s%s", cml_commands[command].name, operands_of(command),
                     option->name, option->argument ? " cpu" : "");
            snprintf(start, sizeof start,
                     "%s: --%s does not apply (it belongs to: ", cml_commands[command].name, option->name);
            const bool right =
                parse(line, &options, &err) == CML_OK || strncmp(err.text, start, strlen(start)) != 0;
            if (command == CML_COMMAND_HELP) continue;
            if (right != cml_option_belongs(option, (enum cml_command)command))
                fail_msg("%s: %s", line, err.text);
        }
    }
}

/* An option behind `help` is the topic of help, unless it is one of the options that every command has. */
static void an_option_is_a_topic_of_help(void **state)
{
    (void)state;
    for (size_t i = 0; i < cml_option_count; i++) {
        const struct cml_option *option = &cml_option_table[i];
        const bool own = cml_option_belongs(option, CML_COMMAND_HELP);
        char line[128];
        snprintf(line, sizeof line, "help --%s", option->name);
        const struct cml_options options = accepted(line);
        assert_int_equal(options.num_operands, !own);
        if (!own) assert_string_equal(options.operands[0] + 2, option->name);
    }
    refused("help --photons cpu", "usage: clustermcml help [TOPIC] (try clustermcml help help)");
}

static void an_option_may_belong_to_one_engine(void **state)
{
    (void)state;
    refused("a.mci --device 0", "run: --device does not apply to engine cpu (it belongs to: opencl)");
    refused("a.mci --engine reference --mesh-search auto",
            "run: --mesh-search does not apply to engine reference (it belongs to: cpu)");
    assert_string_equal(accepted("a.mci --device 0 --engine opencl").engine_options.device, "0");
    assert_string_equal(accepted("crosscheck a.mci --device 0").engine_options.device, "0");
    assert_string_equal(accepted("plan a.mci --device 0").engine_options.device, "0");
    assert_true(accepted("check --resume --help").help);
}

static void operands_are_counted(void **state)
{
    (void)state;
    refused("", "no scene (expected clustermcml scene.mci; clustermcml help lists all commands)");
    refused("trace a.mci", "usage: clustermcml trace scene.mci N (try clustermcml help trace)");
    refused("devices a", "usage: clustermcml devices (try clustermcml help devices)");
    refused("plann a.mci", "unknown command plann (did you mean plan?)");
    refused("plan a.mci b.mci",
            "plan takes one scene, not a.mci and b.mci (a file may hold several runs; for several "
            "files call it once for each)");
    assert_true(accepted("trace --help").help);
    assert_true(accepted("--version").version);
}

/* execve allows an empty argv, without even a program name. */
static void no_words_at_all(void **state)
{
    (void)state;
    char *argv[] = {NULL, NULL};
    struct cml_options options;
    struct cml_error err;
    assert_int_equal(cml_options_parse(0, argv, &options, &err), CML_E_INPUT);
    assert_int_equal(options.num_operands, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(options_and_operands_mix),
        cmocka_unit_test(a_word_that_is_no_command_is_a_scene),
        cmocka_unit_test(letters_take_the_rest_of_their_word_or_the_next),
        cmocka_unit_test(a_value_may_look_like_anything),
        cmocka_unit_test(names_are_written_out),
        cmocka_unit_test(an_option_belongs_to_the_commands_of_its_row),
        cmocka_unit_test(an_option_is_a_topic_of_help),
        cmocka_unit_test(an_option_may_belong_to_one_engine),
        cmocka_unit_test(operands_are_counted),
        cmocka_unit_test(no_words_at_all),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
