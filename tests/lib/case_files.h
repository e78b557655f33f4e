/* A directory of a test's own, and files in it. SPDX-License-Identifier: MIT */
#ifndef CASE_FILES_H
#define CASE_FILES_H

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

/* cmocka state: the directory's name. */
static inline int case_setup(void **state)
{
    char *directory = strdup("/tmp/cml_case_XXXXXX");
    *state = directory;
    return directory && mkdtemp(directory) ? 0 : -1;
}

static inline int case_teardown(void **state)
{
    const int failed = rmdir(*state); /* fails when a test left a file behind */
    free(*state);
    return failed;
}

static inline void case_path(void **state, const char *name, char path[256])
{
    snprintf(path, 256, "%s/%s", (const char *)*state, name);
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

#endif
