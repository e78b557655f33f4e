/* Collects settings of --set and of tables, and reports wrong ones. SPDX-License-Identifier: MIT */
#include "base/settings.h"

#include "base/text.h"

#include <stdio.h>
#include <string.h>

const struct cml_setting *cml_settings_find(const struct cml_settings *settings, const char *name)
{
    for (int i = 0; i < settings->count; i++)
        if (strcmp(settings->item[i].name, name) == 0) return &settings->item[i];
    return NULL;
}

cml_status cml_setting_fail(const struct cml_setting *setting, const char *expected, struct cml_error *err)
{
    const char *field =
        setting->column > 0 ? CML_TEXT("column %d, %s", setting->column, setting->name) : setting->name;
    return cml_fail_field(err, setting->source, setting->line, field, setting->value, expected);
}

/* Adds a copy of a setting. Refuses a name that is set already, because one of its two values would be
 * ignored. */
cml_status cml_settings_copy(struct cml_settings *settings, const struct cml_setting *setting,
                             struct cml_error *err)
{
    const struct cml_setting *same = cml_settings_find(settings, setting->name);
    if (same)
        return cml_setting_fail(
            setting, CML_TEXT("one value, but %.80s has set it to %.40s", same->source, same->value), err);
    if (settings->count == CML_MOST_SETTINGS)
        return cml_setting_fail(setting, CML_TEXT("at most %d values", CML_MOST_SETTINGS), err);
    settings->item[settings->count++] = *setting;
    return CML_OK;
}

cml_status cml_settings_add(struct cml_settings *settings, const char *text, struct cml_error *err)
{
    struct cml_setting setting = {.source = "--set"};
    const size_t length = strcspn(text, "=");
    if (length == 0 || length >= sizeof setting.name || !text[length] || !text[length + 1])
        return cml_fail(err, CML_E_INPUT, "--set %.80s (expected NAME=VALUE, like layer1.mua=0.3)", text);
    memcpy(setting.name, text, length);
    setting.value = text + length + 1;
    return cml_settings_copy(settings, &setting, err);
}

cml_status cml_settings_text(const struct cml_settings *settings, char **text, struct cml_error *err)
{
    size_t size = 0;
    *text = NULL;
    if (settings->count == 0) return CML_OK;
    FILE *out = open_memstream(text, &size);
    for (int i = 0; out && i < settings->count; i++)
        fprintf(out, "%s%s = %s", i > 0 ? "\n" : "", settings->item[i].name, settings->item[i].value);
    return cml_text_end(out, text, &size, "the settings", err);
}
