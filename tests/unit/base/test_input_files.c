/* Tests of input files that one process reads and sends to the others as one block.
 * SPDX-License-Identifier: MIT */
#include "base/input_files.h"
#include "lib/case_files.h"

static struct cml_error err;

static void assert_reads(const struct cml_text_source *source, const char *path, const char *expected)
{
    struct cml_text text;
    assert_int_equal(cml_text_read(source, path, &text, &err), CML_OK);
    assert_string_equal(text.data, expected);
    assert_string_equal(text.path, path);
    cml_text_clear(&text);
}

/* One process reads files from disk. Another process reads them from the block, even if the files are gone
 * or changed. */
static void files_travel_as_one_block(void **state)
{
    char a[256], b[256];
    case_path(state, "a", a);
    case_path(state, "b", b);
    struct cml_inputs read = {0}, received = {0};
    const struct cml_text_source record = cml_inputs_recorder(&read), replay = cml_inputs_replayer(&received);
    struct cml_text text;
    char *block = NULL;
    size_t size = 0;
    case_write(state, "a", "first\nfile\n");
    case_write(state, "b", "");
    assert_reads(&record, a, "first\nfile\n");
    assert_reads(&record, b, "");
    assert_int_equal(read.count, 2);
    assert_int_equal(cml_inputs_pack(&read, &block, &size, &err), CML_OK);
    assert_int_equal(cml_inputs_unpack(block, size, &received, &err), CML_OK);
    case_remove(state, "a");
    case_write(state, "b", "changed");
    assert_reads(&replay, b, "");
    assert_reads(&replay, a, "first\nfile\n");
    assert_int_equal(cml_text_read(&replay, "elsewhere", &text, &err), CML_E_INPUT);
    assert_reads(NULL, b, "changed");
    assert_int_equal(cml_text_read(NULL, a, &text, &err), CML_E_INPUT);
    assert_int_equal(cml_text_read(&record, "elsewhere", &text, &err), CML_E_INPUT);
    assert_int_equal(read.count, 2); /* a file that cannot be read is not remembered */
    assert_reads(&record, a, "first\nfile\n");
    assert_int_equal(read.count, 2); /* a file read before is kept once, unchanged */
    case_remove(state, "b");
    free(block);
    cml_inputs_clear(&read);
    cml_inputs_clear(&received);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_travel_as_one_block),
    };
    return cmocka_run_group_tests(tests, case_setup, case_teardown);
}
