/* Tests of reading text files, lines, words and numbers. SPDX-License-Identifier: MIT */
#include "base/text.h"
#include "lib/case_files.h"

#include <sys/stat.h>

static void lines_lose_lf_and_crlf(void **state)
{
    struct cml_error err;
    struct cml_text text;
    static const char bytes[] = "one\ntwo\r\n\r\n\nfi\rve\r\n six";
    static const char *const lines[] = {"one", "two", "", "", "fi\rve", " six"};
    case_write_bytes(state, "in", bytes, sizeof bytes - 1);
    assert_int_equal(cml_text_read(NULL, case_in_directory(state, "in"), &text, &err), CML_OK);
    assert_int_equal(text.size, sizeof bytes - 1);
    assert_string_equal(text.path, case_in_directory(state, "in"));
    for (int i = 0; i < 6; i++) {
        const char *line = cml_text_next(&text);
        assert_non_null(line);
        assert_string_equal(line, lines[i]);
        assert_int_equal(text.line, i + 1);
    }
    assert_null(cml_text_next(&text));
    assert_null(cml_text_next(&text));
    assert_int_equal(text.line, 6);
    cml_text_clear(&text);
    assert_null(text.data);
    case_remove(state, "in");
}

static void empty_and_unended_files(void **state)
{
    struct cml_error err;
    struct cml_text text;
    case_write_bytes(state, "in", "", 0);
    assert_int_equal(cml_text_read(NULL, case_in_directory(state, "in"), &text, &err), CML_OK);
    assert_null(cml_text_next(&text));
    cml_text_clear(&text);
    case_write_bytes(state, "in", "last\n", 5);
    assert_int_equal(cml_text_read(NULL, case_in_directory(state, "in"), &text, &err), CML_OK);
    assert_string_equal(cml_text_next(&text), "last");
    assert_null(cml_text_next(&text));
    cml_text_clear(&text);
    case_remove(state, "in");
}

/* Reads files of sizes at which the read buffer is just full, one byte off, and doubled twice. */
static void files_of_any_size_are_read_whole(void **state)
{
    static const size_t sizes[] = {65534, 65535, 65536, 131071, 131072, 300001};
    char *bytes = malloc(300001);
    assert_non_null(bytes);
    memset(bytes, 'x', 300001);
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        struct cml_error err;
        struct cml_text text;
        case_write_bytes(state, "in", bytes, sizes[i]);
        assert_int_equal(cml_text_read(NULL, case_in_directory(state, "in"), &text, &err), CML_OK);
        assert_int_equal(text.size, sizes[i]);
        assert_int_equal(strlen(cml_text_next(&text)), sizes[i]);
        assert_null(cml_text_next(&text));
        cml_text_clear(&text);
    }
    free(bytes);
    case_remove(state, "in");
}

static void a_byte_order_mark_is_no_text(void **state)
{
    struct cml_error err;
    struct cml_text text;
    case_write_bytes(state, "in",
                     "\xEF\xBB\xBF"
                     "0 1\n",
                     7);
    assert_int_equal(cml_text_read(NULL, case_in_directory(state, "in"), &text, &err), CML_OK);
    assert_int_equal(text.size, 4);
    assert_string_equal(cml_text_next(&text), "0 1");
    cml_text_clear(&text);
    case_remove(state, "in");
}

static void unreadable_files_are_refused(void **state)
{
    struct cml_error err;
    struct cml_text text;
    assert_int_equal(cml_text_read(NULL, case_in_directory(state, "none"), &text, &err), CML_E_INPUT);
    case_assert_fails_for(state, &err, CML_E_INPUT, "none",
                          "cannot be read: No such file or directory (expected a file)");
    assert_int_equal(mkdir(case_in_directory(state, "folder"), 0700), 0);
    assert_int_equal(cml_text_read(NULL, case_in_directory(state, "folder"), &text, &err), CML_E_INPUT);
    case_assert_fails_for(state, &err, CML_E_INPUT, "folder",
                          "cannot be read: Is a directory (expected a file)");
    assert_null(text.data);
    rmdir(case_in_directory(state, "folder"));
    case_write_bytes(state, "nul", "1\0002\n", 4);
    assert_int_equal(cml_text_read(NULL, case_in_directory(state, "nul"), &text, &err), CML_E_INPUT);
    case_assert_fails_for(state, &err, CML_E_INPUT, "nul",
                          "cannot be read: it holds a NUL byte (expected a text file)");
    assert_null(text.path);
    case_remove(state, "nul");
}

static void words_are_cut_at_blanks_and_quotes(void **state)
{
    (void)state;
    char line[] = "  one\ttwo \"three four\"five \"\" six\"7\" \"open end \r";
    static const char *const words[] = {"one", "two", "three four", "five", "", "six\"7\"", "\"open", "end"};
    char *cursor = line;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        const char *word = cml_text_word(&cursor);
        assert_non_null(word);
        assert_string_equal(word, words[i]);
    }
    assert_null(cml_text_word(&cursor));
    assert_null(cml_text_word(&cursor));
    assert_int_equal(*cursor, '\0');
}

static void doubles_are_whole_words(void **state)
{
    (void)state;
    static const struct {
        const char *word;
        double value;
    } good[] = {{"0", 0},   {"-1.5", -1.5}, {"+.5", 0.5},
                {"1.", 1},  {"1e3", 1000},  {"1E-3", 1e-3},
                {"007", 7}, {"1e-400", 0},  {"1.7976931348623157e308", 1.7976931348623157e308}};
    static const char *const bad[] = {"",   ".",   "-",   "e5",   "1e",  "1e+",      "1.2.3", "1,5",
                                      "1 ", "nan", "inf", "-inf", "NaN", "0x10",     "1p3",   "1e999",
                                      "1f", "--1", "1-2", "1e5.", "\"1", "\xC2\xB5", "1_000"};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        double value = -7;
        assert_true(cml_parse_double(good[i].word, &value));
        assert_true(value == good[i].value);
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        double value = -7;
        if (cml_parse_double(bad[i], &value)) print_error("taken: %s\n", bad[i]);
        assert_true(value == -7);
    }
}

static void counts_are_whole_and_exact(void **state)
{
    (void)state;
    static const struct {
        const char *word;
        uint64_t value;
    } good[] = {{"0", 0},        {"1", 1},  {"1e7", 10000000},
                {"2.5e3", 2500}, {"+3", 3}, {"9007199254740992", 1ull << 53}};
    static const char *const bad[] = {"",
                                      "-1",
                                      "0.5",
                                      "1e-1",
                                      "1e16",
                                      "1e300",
                                      "nan",
                                      "ten",
                                      "1 000",
                                      "9007199254740993",
                                      "9007199254740991.5",
                                      "0.9007199254740993e16"};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        uint64_t value = 77;
        assert_true(cml_parse_count(good[i].word, &value));
        assert_true(value == good[i].value);
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        uint64_t value = 77;
        assert_false(cml_parse_count(bad[i], &value));
        assert_true(value == 77);
    }
}

static void ints_stay_in_their_range(void **state)
{
    (void)state;
    static const struct {
        const char *word;
        int value;
    } good[] = {
        {"0", 0}, {"-12", -12}, {"+5", 5}, {"2147483647", 2147483647}, {"-2147483648", -2147483647 - 1}};
    static const char *const bad[] = {"",   "-",    "1.0",        "1e3",         "0x1",
                                      "1-", "five", "2147483648", "-2147483649", "99999999999999999999"};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        int value = 77;
        assert_true(cml_parse_int(good[i].word, &value));
        assert_int_equal(value, good[i].value);
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        int value = 77;
        assert_false(cml_parse_int(bad[i], &value));
        assert_int_equal(value, 77);
    }
}

static void names_are_found_beside(void **state)
{
    (void)state;
    static const char *const cases[][3] = {
        {"a.mci", "h.txt", "h.txt"},       {"dir/a.mci", "h.txt", "dir/h.txt"},
        {"/a.mci", "h.txt", "/h.txt"},     {"x/y/a.mci", "../h.txt", "x/y/../h.txt"},
        {"dir/a.mci", "/h.txt", "/h.txt"}, {"standard input", "h.txt", "h.txt"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct cml_error err;
        char *path = NULL;
        assert_int_equal(cml_path_beside(cases[i][0], cases[i][1], &path, &err), CML_OK);
        assert_string_equal(path, cases[i][2]);
        free(path);
    }
}

static void messages_are_one_line(void **state)
{
    (void)state;
    struct cml_error err;
    char longer[200];
    memset(longer, 'v', sizeof longer - 1);
    longer[sizeof longer - 1] = '\0';
    assert_int_equal(cml_fail(&err, CML_E_IO, "a\nb\x1b[31m%d", 7), CML_E_IO);
    assert_string_equal(
        err.text, "a\nb\x1b[31m7"); /* raw control bytes stay in the error; cml_print_line escapes them */
    char path[3000];
    memset(path, 'p', sizeof path - 1);
    path[sizeof path - 1] = '\0';
    assert_int_equal(cml_fail_field(&err, path, 3, "x", "1", "a reason"), CML_E_INPUT);
    assert_int_equal(strlen(err.text), sizeof err.text - 1);
    assert_non_null(strstr(err.text, "pp ... pp"));
    assert_non_null(strstr(err.text, "p:3: x = 1 (expected a reason)"));
    assert_int_equal(cml_fail_field(&err, "f", 0, "x", NULL, "a number"), CML_E_INPUT);
    assert_string_equal(err.text, "f: x is missing (expected a number)");
    assert_int_equal(cml_fail_field(&err, "f", 3, "x", longer, "less"), CML_E_INPUT);
    assert_int_equal(strlen(err.text), strlen("f:3: x =  (expected less)") + 80);
    assert_int_equal(cml_fail_memory(&err, 3 << 20, "bins"), CML_E_INPUT);
    assert_string_equal(err.text, "out of memory: 3 MiB for bins");
}

/* /dev/full accepts buffered bytes and then reports that the disk is full. A text in memory must be
 * written whole or end as an error. */
static void a_text_in_memory_ends_whole_or_as_an_error(void **state)
{
    (void)state;
    struct cml_error err;
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    fputs("a text", out);
    assert_int_equal(cml_text_end(out, &text, &size, "a text", &err), CML_OK);
    assert_string_equal(text, "a text");
    assert_int_equal(size, 6);
    FILE *full = fopen("/dev/full", "w");
    fputs("a text", full);
    assert_int_equal(cml_text_end(full, &text, &size, "a text", &err), CML_E_INPUT);
    assert_null(text);
    assert_int_equal(cml_text_end(NULL, &text, &size, "a text", &err), CML_E_INPUT);
    assert_string_equal(err.text, "out of memory: 0 MiB for a text");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_lose_lf_and_crlf),
        cmocka_unit_test(empty_and_unended_files),
        cmocka_unit_test(files_of_any_size_are_read_whole),
        cmocka_unit_test(a_byte_order_mark_is_no_text),
        cmocka_unit_test(unreadable_files_are_refused),
        cmocka_unit_test(words_are_cut_at_blanks_and_quotes),
        cmocka_unit_test(doubles_are_whole_words),
        cmocka_unit_test(counts_are_whole_and_exact),
        cmocka_unit_test(ints_stay_in_their_range),
        cmocka_unit_test(names_are_found_beside),
        cmocka_unit_test(messages_are_one_line),
        cmocka_unit_test(a_text_in_memory_ends_whole_or_as_an_error),
    };
    return cmocka_run_group_tests_name("text", tests, case_setup, case_teardown);
}
