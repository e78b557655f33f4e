/* Values from outside a scene's file: NAME=VALUE of --set, or a cell of the table of --sweep. What names
 * there are, and which values they may have, the reader of scenes knows (input/mci_settings.h).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

enum { CML_MOST_SETTINGS = 256, CML_SETTING_NAME = 64 };

struct cml_setting {
    char name[CML_SETTING_NAME]; /* "layer2.mua" */
    const char *value;           /* as it was written; borrowed */
    const char *source;          /* what messages begin with: "--set", or the table's path; borrowed */
    int line, column;            /* of the table, from 1; 0: of none */
};

/* Zeroed: none. */
struct cml_settings {
    int count;
    struct cml_setting item[CML_MOST_SETTINGS];
};

/* Adds "NAME=VALUE"; its source is "--set". CML_E_INPUT: no name, no value, a name that is there already, or
 * one too many. */
CML_NODISCARD cml_status cml_settings_add(struct cml_settings *settings, const char *text,
                                          struct cml_error *err);

/* Adds a copy, with the same checks of name and number. */
CML_NODISCARD cml_status cml_settings_copy(struct cml_settings *settings, const struct cml_setting *setting,
                                           struct cml_error *err);

/* The setting of that name; NULL: there is none. */
const struct cml_setting *cml_settings_find(const struct cml_settings *settings, const char *name);

/* All of them as a text, a "NAME = VALUE" a line, the caller's to free; NULL where there are none. */
CML_NODISCARD cml_status cml_settings_text(const struct cml_settings *settings, char **text,
                                           struct cml_error *err);

/* "SOURCE: NAME = VALUE (expected EXPECTED)", with line and column of a table behind the source; CML_E_INPUT.
 */
CML_NODISCARD cml_status cml_setting_fail(const struct cml_setting *setting, const char *expected,
                                          struct cml_error *err);
