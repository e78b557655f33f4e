/* Values that a run sets from outside the scene's file: NAME=VALUE of --set, or a cell of the table of
 * --sweep. The scene reader knows which names and values exist (input/mci_settings.h).
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

enum { CML_MOST_SETTINGS = 256, CML_SETTING_NAME = 64 };

struct cml_setting {
    char name[CML_SETTING_NAME]; /* such as "layer2.mua" */
    const char *value;           /* as written by the user; borrowed */
    const char *source; /* where the value comes from, for messages: "--set" or the table's path; borrowed */
    int line, column;   /* line and column of the value's cell in the table, from 1; 0 for --set */
};

/* All settings of a run. Zeroed: no settings. */
struct cml_settings {
    int count;
    struct cml_setting item[CML_MOST_SETTINGS];
};

/* Adds the setting "NAME=VALUE" of --set. Returns CML_E_INPUT without a name or value, for a name that is set
 * already, or beyond CML_MOST_SETTINGS. */
CML_NODISCARD cml_status cml_settings_add(struct cml_settings *settings, const char *text,
                                          struct cml_error *err);

/* Adds a copy of a setting. Returns CML_E_INPUT for a name that is set already, or beyond
 * CML_MOST_SETTINGS. */
CML_NODISCARD cml_status cml_settings_copy(struct cml_settings *settings, const struct cml_setting *setting,
                                           struct cml_error *err);

/* Returns the setting with that name, or NULL. */
const struct cml_setting *cml_settings_find(const struct cml_settings *settings, const char *name);

/* Writes all settings as a text, one "NAME = VALUE" per line. The caller frees the text; NULL if there are no
 * settings. */
CML_NODISCARD cml_status cml_settings_text(const struct cml_settings *settings, char **text,
                                           struct cml_error *err);

/* Refuses a setting: "SOURCE: NAME = VALUE (expected EXPECTED)", after SOURCE also line and column of a
 * table. Returns CML_E_INPUT. */
CML_NODISCARD cml_status cml_setting_fail(const struct cml_setting *setting, const char *expected,
                                          struct cml_error *err);
