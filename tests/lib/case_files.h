/* A directory of a test's own, files in it, and messages without its name.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

/* Makes the directory of a test. *state: its name. */
static inline int case_setup(void **state)
{
    char *directory = strdup("/tmp/cml_case_XXXXXX");
    *state = directory;
    return directory && mkdtemp(directory) ? 0 : -1;
}

static inline int case_teardown(void **state)
{
    const int failed = rmdir(*state); /* fails if a test left a file in the directory */
    free(*state);
    return failed;
}

static inline void case_path(void **state, const char *name, char path[256])
{
    snprintf(path, 256, "%s/%s", (const char *)*state, name);
}

/* Returns the path of `name` in the directory of the test, in a buffer that the next call reuses. */
static inline char *case_in_directory(void **state, const char *name)
{
    static char path[256];
    case_path(state, name, path);
    return path;
}

/* Checks the status, and that the message is "PATH: ENDING". */
static inline void case_assert_fails_for(void **state, const struct cml_error *err, cml_status status,
                                         const char *name, const char *ending)
{
    char expected[512];
    snprintf(expected, sizeof expected, "%s: %s", case_in_directory(state, name), ending);
    assert_string_equal(err->text, expected);
    assert_int_equal(err->status, status);
}

static inline void case_write_bytes(void **state, const char *name, const char *bytes, size_t size)
{
    char path[256];
    case_path(state, name, path);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static inline void case_write(void **state, const char *name, const char *text)
{
    case_write_bytes(state, name, text, strlen(text));
}

/* Checks that the whole file is the text `expected`. */
static inline void case_assert_holds(void **state, const char *name, const char *expected)
{
    static char bytes[1 << 18];
    char path[256];
    case_path(state, name, path);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    bytes[fread(bytes, 1, sizeof bytes - 1, file)] = '\0';
    assert_int_equal(fclose(file), 0);
    assert_string_equal(bytes, expected);
}

static inline void case_remove(void **state, const char *name)
{
    char path[256];
    case_path(state, name, path);
    assert_int_equal(remove(path), 0);
}

/* Removes every occurrence of "DIRECTORY/" from the message. */
static inline void case_normalise(void **state, char *text)
{
    char prefix[256];
    case_path(state, "", prefix);
    const size_t length = strlen(prefix);
    for (char *at = strstr(text, prefix); at; at = strstr(at, prefix))
        memmove(at, at + length, strlen(at + length) + 1);
}
