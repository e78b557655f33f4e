/* Parts that the tests of the .mci reader share.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "lib/case_files.h"
#include "input/mci.h"

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

/* Reads `text` as x.mci and fails the test with the message if the reader refuses it. */
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
