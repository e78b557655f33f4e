/* Options of a line, one at a time, in any order. SPDX-License-Identifier: MIT */
#include "input/mci_options.h"

#include <string.h>

cml_status cml_mci_fail_option(const struct cml_mci_line_options *options, const char *field,
                               const char *value, const char *expected)
{
    char name[80];
    snprintf(name, sizeof name, "%s: %s", options->owner, field);
    return cml_mci_fail(options->reader, name, value, expected);
}

cml_status cml_mci_fail_value(const struct cml_mci_line_options *options, const char *expected)
{
    return cml_mci_fail_option(options, options->keys[options->key], options->value, expected);
}

/* An option that comes twice is refused: one of the two was not meant. */
cml_status cml_mci_next_option(struct cml_mci_line_options *options, bool *more)
{
    char *word = cml_text_word(&options->reader->cursor);
    *more = word != NULL;
    if (!word) return CML_OK;
    char *equals = strchr(word, '=');
    const size_t end = equals ? (size_t)(equals - word) : strlen(word);
    options->alone = !equals && options->flag && strcmp(word, options->flag) == 0;
    for (int k = 0; (equals || options->alone) && k < CML_MCI_MAX_KEYS && options->keys[k]; k++) {
        const size_t length = strlen(options->keys[k]);
        if (length != end || memcmp(word, options->keys[k], length) != 0) continue;
        options->key = k;
        options->value = equals ? equals + 1 : word;
        if (options->seen[k]) return cml_mci_fail_value(options, "this option only once");
        options->seen[k] = true;
        return CML_OK;
    }
    return cml_mci_fail_option(options, "option", word, options->list);
}

/* Every number goes through the strict conversion by itself. */
bool cml_mci_parse_list(const char *text, int count, double *values)
{
    static const struct cml_mci_field length = {"", -CML_MCI_HUGE, CML_MCI_HUGE, false, ""};
    for (int i = 0; i < count; i++) {
        char word[64];
        const size_t size = strcspn(text, ",");
        if (size >= sizeof word) return false;
        memcpy(word, text, size);
        word[size] = '\0';
        if (!cml_mci_parse(&length, word, &values[i])) return false;
        text += size;
        if (*text != (i + 1 < count ? ',' : '\0')) return false;
        text++;
    }
    return true;
}

/* Names are compared exactly: in units the case matters. */
int cml_mci_choose(const char *word, const char *const *names, int count)
{
    for (int i = 0; i < count; i++)
        if (strcmp(word, names[i]) == 0) return i;
    return -1;
}
