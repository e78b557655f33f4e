/* Lines, words, numbers, and files that appear only when complete. SPDX-License-Identifier: MIT */
#include "base/atomic_file.h"
#include "base/text.h"
#include "lib/case_files.h"

#include <sys/stat.h>

static char *in_directory(void **state, const char *name)
{
    static char path[256];
    case_path(state, name, path);
    return path;
}

static void assert_absent(void **state, const char *name)
{
    assert_int_equal(access(in_directory(state, name), F_OK), -1);
}

/* The message must be "PATH: ENDING". */
static void assert_fails_for(void **state, const struct cml_error *err, cml_status status, const char *name,
                             const char *ending)
{
    char expected[512];
    snprintf(expected, sizeof expected, "%s: %s", in_directory(state, name), ending);
    assert_string_equal(err->text, expected);
    assert_int_equal(err->status, status);
}

static void lines_lose_lf_and_crlf(void **state)
{
    struct cml_error err;
    struct cml_text text;
    static const char bytes[] = "one\ntwo\r\n\r\n\nfi\rve\r\n six";
    static const char *const lines[] = {"one", "two", "", "", "fi\rve", " six"};
    case_write_bytes(state, "in", bytes, sizeof bytes - 1);
    assert_int_equal(cml_text_read(NULL, in_directory(state, "in"), &text, &err), CML_OK);
    assert_int_equal(text.size, sizeof bytes - 1);
    assert_string_equal(text.path, in_directory(state, "in"));
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
    assert_int_equal(cml_text_read(NULL, in_directory(state, "in"), &text, &err), CML_OK);
    assert_null(cml_text_next(&text));
    cml_text_clear(&text);
    case_write_bytes(state, "in", "last\n", 5);
    assert_int_equal(cml_text_read(NULL, in_directory(state, "in"), &text, &err), CML_OK);
    assert_string_equal(cml_text_next(&text), "last");
    assert_null(cml_text_next(&text));
    cml_text_clear(&text);
    case_remove(state, "in");
}

/* Sizes at which the buffer is just full, and doubled twice. */
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
        assert_int_equal(cml_text_read(NULL, in_directory(state, "in"), &text, &err), CML_OK);
        assert_int_equal(text.size, sizes[i]);
        assert_int_equal(strlen(cml_text_next(&text)), sizes[i]);
        assert_null(cml_text_next(&text));
        cml_text_clear(&text);
    }
    free(bytes);
    case_remove(state, "in");
}

static void unreadable_files_are_refused(void **state)
{
    struct cml_error err;
    struct cml_text text;
    assert_int_equal(cml_text_read(NULL, in_directory(state, "none"), &text, &err), CML_E_INPUT);
    assert_fails_for(state, &err, CML_E_INPUT, "none", "cannot be read (No such file or directory)");
    assert_int_equal(mkdir(in_directory(state, "folder"), 0700), 0);
    assert_int_equal(cml_text_read(NULL, in_directory(state, "folder"), &text, &err), CML_E_INPUT);
    assert_fails_for(state, &err, CML_E_INPUT, "folder", "cannot be read (Is a directory)");
    assert_null(text.data);
    rmdir(in_directory(state, "folder"));
    case_write_bytes(state, "nul", "1\0002\n", 4);
    assert_int_equal(cml_text_read(NULL, in_directory(state, "nul"), &text, &err), CML_E_INPUT);
    assert_fails_for(state, &err, CML_E_INPUT, "nul",
                     "cannot be read (it holds a NUL byte, so it is not a text file)");
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
    static const char *const bad[] = {"", "-1", "0.5", "1e-1", "1e16", "1e300", "nan", "ten", "1 000"};
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

static void a_file_appears_at_commit(void **state)
{
    struct cml_error err;
    struct cml_file file;
    case_write_bytes(state, "out", "old", 3);
    assert_int_equal(cml_file_create(in_directory(state, "out"), &file, &err), CML_OK);
    fputs("new", file.stream);
    fflush(file.stream);
    case_assert_holds(state, "out", "old");
    case_assert_holds(state, "out.tmp", "new");
    assert_int_equal(cml_file_commit(&file, &err), CML_OK);
    case_assert_holds(state, "out", "new");
    assert_absent(state, "out.tmp");
    cml_file_abort(&file); /* does nothing after a commit */
    case_assert_holds(state, "out", "new");
    case_remove(state, "out");
}

static void an_aborted_file_leaves_the_old_one(void **state)
{
    struct cml_error err;
    struct cml_file file;
    case_write_bytes(state, "out", "old", 3);
    assert_int_equal(cml_file_create(in_directory(state, "out"), &file, &err), CML_OK);
    fputs("half", file.stream);
    cml_file_abort(&file);
    assert_null(file.stream);
    assert_absent(state, "out.tmp");
    case_assert_holds(state, "out", "old");
    cml_file_abort(&file);
    case_remove(state, "out");
    assert_int_equal(cml_file_create(in_directory(state, "out"), &file, &err), CML_OK);
    cml_file_abort(&file);
    assert_absent(state, "out");
}

static void places_that_cannot_be_written(void **state)
{
    struct cml_error err;
    struct cml_file file;
    assert_int_equal(cml_file_create(in_directory(state, "none/out"), &file, &err), CML_E_IO);
    assert_fails_for(state, &err, CML_E_IO, "none/out", "cannot be written (No such file or directory)");
    assert_null(file.path);
    assert_null(file.temporary);
    assert_int_equal(mkdir(in_directory(state, "taken"), 0700), 0);
    assert_int_equal(cml_file_create(in_directory(state, "taken"), &file, &err), CML_OK);
    assert_int_equal(cml_file_commit(&file, &err), CML_E_IO);
    assert_fails_for(state, &err, CML_E_IO, "taken", "cannot be written (Is a directory)");
    assert_absent(state, "taken.tmp");
    assert_int_equal(rmdir(in_directory(state, "taken")), 0);
}

/* Permissions do not stop root, so the test has nothing to say then. */
static void a_read_only_directory_is_reported(void **state)
{
    struct cml_error err;
    struct cml_file file;
    if (geteuid() == 0) skip();
    assert_int_equal(mkdir(in_directory(state, "locked"), 0500), 0);
    assert_int_equal(cml_file_create(in_directory(state, "locked/out"), &file, &err), CML_E_IO);
    assert_fails_for(state, &err, CML_E_IO, "locked/out", "cannot be written (Permission denied)");
    assert_int_equal(rmdir(in_directory(state, "locked")), 0);
}

/* A full disk shows at the latest in the commit; the earlier result must survive it. */
static void a_full_disk_keeps_the_old_file(void **state)
{
    struct cml_error err;
    struct cml_file file;
    case_write_bytes(state, "out", "old", 3);
    assert_int_equal(cml_file_create(in_directory(state, "out"), &file, &err), CML_OK);
    file.stream = freopen("/dev/full", "wb", file.stream);
    if (!file.stream) skip();
    fputs("new", file.stream);
    assert_int_equal(cml_file_commit(&file, &err), CML_E_IO);
    assert_fails_for(state, &err, CML_E_IO, "out", "cannot be written (No space left on device)");
    case_assert_holds(state, "out", "old");
    assert_absent(state, "out.tmp");
    case_remove(state, "out");
}

static void messages_are_one_line(void **state)
{
    (void)state;
    struct cml_error err;
    char longer[200];
    memset(longer, 'v', sizeof longer - 1);
    longer[sizeof longer - 1] = '\0';
    assert_int_equal(cml_fail(&err, CML_E_IO, "a\nb\x1b[31m%d", 7), CML_E_IO);
    assert_string_equal(err.text, "a?b?[31m7");
    assert_int_equal(cml_fail_field(&err, "f", 0, "x", NULL, "a number"), CML_E_INPUT);
    assert_string_equal(err.text, "f: x is missing (expected a number)");
    assert_int_equal(cml_fail_field(&err, "f", 3, "x", longer, "less"), CML_E_INPUT);
    assert_int_equal(strlen(err.text), strlen("f:3: x =  (expected less)") + 80);
    assert_int_equal(cml_fail_memory(&err, 3 << 20, "bins"), CML_E_INPUT);
    assert_string_equal(err.text, "out of memory: 3 MiB for bins");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_lose_lf_and_crlf),
        cmocka_unit_test(empty_and_unended_files),
        cmocka_unit_test(files_of_any_size_are_read_whole),
        cmocka_unit_test(unreadable_files_are_refused),
        cmocka_unit_test(words_are_cut_at_blanks_and_quotes),
        cmocka_unit_test(doubles_are_whole_words),
        cmocka_unit_test(counts_are_whole_and_exact),
        cmocka_unit_test(ints_stay_in_their_range),
        cmocka_unit_test(names_are_found_beside),
        cmocka_unit_test(a_file_appears_at_commit),
        cmocka_unit_test(an_aborted_file_leaves_the_old_one),
        cmocka_unit_test(places_that_cannot_be_written),
        cmocka_unit_test(a_read_only_directory_is_reported),
        cmocka_unit_test(a_full_disk_keeps_the_old_file),
        cmocka_unit_test(messages_are_one_line),
    };
    return cmocka_run_group_tests_name("text", tests, case_setup, case_teardown);
}
