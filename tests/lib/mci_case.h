/* What the tests of the .mci reader share: a directory of their own, files in it, and messages without its
 * name. SPDX-License-Identifier: MIT */
#ifndef MCI_CASE_H
#define MCI_CASE_H

#include "lib/case_files.h"
#include "input/mci.h"

static inline void case_write(void **state, const char *name, const char *text)
{
    case_write_bytes(state, name, text, strlen(text));
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

/* Reads `text` as x.mci. The caller clears *list when the status is CML_OK. */
static inline cml_status case_read_with(void **state, const char *text,
                                        const struct cml_input_options *options, struct cml_scene_list *list,
                                        struct cml_error *err)
{
    char path[256];
    case_path(state, "x.mci", path);
    case_write(state, "x.mci", text);
    *err = (struct cml_error){0};
    const cml_status status = cml_mci_read(path, options, list, err);
    case_remove(state, "x.mci");
    case_normalise(state, err->text);
    return status;
}

static inline cml_status case_read(void **state, const char *text, struct cml_scene_list *list,
                                   struct cml_error *err)
{
    return case_read_with(state, text, NULL, list, err);
}

/* The read must succeed; shows the message when it does not. */
static inline void case_read_ok_with(void **state, const char *text, const struct cml_input_options *options,
                                     struct cml_scene_list *list)
{
    struct cml_error err;
    const cml_status status = case_read_with(state, text, options, list, &err);
    assert_string_equal(err.text, "");
    assert_int_equal(status, CML_OK);
}

static inline void case_read_ok(void **state, const char *text, struct cml_scene_list *list)
{
    case_read_ok_with(state, text, NULL, list);
}

#endif
