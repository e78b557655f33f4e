/* SPDX-License-Identifier: MIT */
#include "base/input_files.h"
#include "lib/dice.h"

#include <unistd.h>

static char directory[64], a[80], b[80];
static struct cml_error err;

static void put(const char *path, const char *text)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static void assert_reads(const char *path, const char *expected)
{
    struct cml_text text;
    assert_int_equal(cml_text_read(path, &text, &err), CML_OK);
    assert_string_equal(text.data, expected);
    assert_string_equal(text.path, path);
    cml_text_clear(&text);
}

/* What one process read from disk another reads from the block, although the files are gone or changed. */
static void files_travel_as_one_block(void **state)
{
    (void)state;
    struct cml_inputs read, received;
    struct cml_text text;
    char *block = NULL;
    size_t size = 0;
    put(a, "first\nfile\n");
    put(b, "");
    cml_inputs_record(&read);
    assert_reads(a, "first\nfile\n");
    assert_reads(b, "");
    assert_int_equal(read.count, 2);
    assert_int_equal(cml_inputs_pack(&read, &block, &size, &err), CML_OK);
    assert_int_equal(cml_inputs_unpack(block, size, &received, &err), CML_OK);
    assert_int_equal(unlink(a), 0);
    put(b, "changed");
    cml_inputs_replay(&received);
    assert_reads(b, "");
    assert_reads(a, "first\nfile\n");
    assert_int_equal(cml_text_read("elsewhere", &text, &err), CML_E_INPUT);
    cml_inputs_release();
    assert_reads(b, "changed");
    assert_int_equal(cml_text_read(a, &text, &err), CML_E_INPUT);
    free(block);
    cml_inputs_clear(&read);
    cml_inputs_clear(&received);
}

static int choose_directory(void **state)
{
    (void)state;
    strcpy(directory, "/tmp/cml_inputs_XXXXXX");
    if (!mkdtemp(directory)) return -1;
    snprintf(a, sizeof a, "%s/a", directory);
    snprintf(b, sizeof b, "%s/b", directory);
    return 0;
}

static int leave(void **state)
{
    (void)state;
    unlink(b);
    return rmdir(directory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_travel_as_one_block),
    };
    return cmocka_run_group_tests(tests, choose_directory, leave);
}
