/* Reader of the options of a keyword line, in any order. SPDX-License-Identifier: MIT */
#include "input/mci_options.h"

#include "result/quantity.h"
#include "scene/scene.h"

#include <string.h>

cml_status cml_mci_fail_option(const struct cml_mci_line *line, const char *field, const char *value,
                               const char *expected)
{
    return cml_mci_fail(line->reader, CML_TEXT("%s: %s", line->owner, field), value, expected);
}

cml_status cml_mci_fail_value(const struct cml_mci_line *line, const char *expected)
{
    return cml_mci_fail_option(line, line->key->name, line->value, expected);
}

const char *cml_mci_saw(const struct cml_mci_line *line, const char *name)
{
    for (int i = 0; i < line->num_seen; i++)
        if (strcmp(line->seen[i].name, name) == 0) return line->seen[i].value;
    return NULL;
}

/* Refuses an unknown option; the message lists all options of the line, "at=, z= or diffuse". */
static cml_status fail_unknown(const struct cml_mci_line *line, const char *word)
{
    char list[200] = "the end of the line or a comment", *end = list, *last = list;
    for (const struct cml_key_part *part = line->parts; part->group != CML_KEYS_NONE; part++)
        for (const struct cml_key *key = cml_keys_of(part->group); key->group == part->group; key++) {
            if (!(key->use & CML_KEY_OPTION)) continue;
            const bool own = key->use & CML_KEY_ALONE;
            last = end;
            end += snprintf(end, (size_t)(list + sizeof list - end), "%s%s%s", end > list ? ", " : "",
                            own ? key->noun : key->name, own || key->type == CML_KEY_FLAG ? "" : "=");
        }
    if (last == list || strstr(last, " or ")) return cml_mci_fail_option(line, "option", word, list);
    return cml_mci_fail_option(line, "option", word,
                               CML_TEXT("%.*s or %s", (int)(last - list), list, last + 2));
}

/* Stores the value of the option that was read last in the struct member that its key names, by the key's
 * type. `base` is the struct. */
static cml_status take_value(struct cml_mci_line *line, void *base)
{
    const struct cml_key *key = line->key;
    void *member = (char *)base + key->member;
    char expected[CML_KEY_TEXT];
    double number;
    int word = 0;
    bool sound = true;
    if (key->type == CML_KEY_OWN) return line->own(line);
    if (key->type == CML_KEY_FLAG)
        *(bool *)member = sound = line->alone;
    else if (key->type == CML_KEY_XY || key->type == CML_KEY_XYZ)
        sound = cml_mci_parse_list(line->value, key->type == CML_KEY_XY ? 2 : 3, member);
    else if (key->type == CML_KEY_WORD)
        *(int *)member = word = cml_word_index(key->noun, line->value);
    else if ((sound = cml_key_parse(key, line->value, &number)))
        cml_key_store(key, base, number);
    return sound && word >= 0 ? CML_OK : cml_mci_fail_value(line, cml_key_expected(key, expected));
}

/* True if a word is an option of this key: "key=value", or the key alone where this is allowed. */
static bool is_of_key(const struct cml_key *key, const char *word)
{
    const size_t length = strcspn(word, "=");
    const bool may_stand_alone = key->type == CML_KEY_FLAG || key->use & CML_KEY_ALONE;
    return (key->use & CML_KEY_OPTION || key->type == CML_KEY_OWN) && (word[length] || may_stand_alone) &&
           strlen(key->name) == length && memcmp(key->name, word, length) == 0;
}

/* Reads one option. An option that comes twice is refused, because one of the two was not meant. */
static cml_status take_option(struct cml_mci_line *line, char *word)
{
    char *equals = strchr(word, '=');
    for (const struct cml_key_part *part = line->parts; part->group != CML_KEYS_NONE; part++)
        for (const struct cml_key *key = cml_keys_of(part->group); key->group == part->group; key++) {
            if (!is_of_key(key, word)) continue;
            line->key = key;
            line->value = equals ? equals + 1 : word;
            line->alone = !equals;
            if (cml_mci_saw(line, key->name)) return cml_mci_fail_value(line, "this option only once");
            line->seen[line->num_seen].name = key->name;
            line->seen[line->num_seen++].value = line->value;
            return take_value(line, part->base);
        }
    return fail_unknown(line, word);
}

cml_status cml_mci_options(struct cml_mci_line *line)
{
    for (char *word; (word = cml_text_word(&line->reader->cursor));) CML_TRY(take_option(line, word));
    return CML_OK;
}

bool cml_mci_parse_list(const char *text, int count, double *values)
{
    static const struct cml_key length = {.least = -CML_MCI_HUGE, .most = CML_MCI_HUGE};
    for (int i = 0; i < count; i++) {
        char word[64];
        const size_t size = strcspn(text, ",");
        if (size >= sizeof word) return false;
        memcpy(word, text, size);
        word[size] = '\0';
        if (!cml_key_parse(&length, word, &values[i])) return false;
        text += size;
        if (*text != (i + 1 < count ? ',' : '\0')) return false;
        text++;
    }
    return true;
}

/* Returns the position of a word in a list of names, or -1. Case matters, because it does in units. */
int cml_mci_choose(const char *word, const char *const *names, int count)
{
    for (int i = 0; i < count; i++)
        if (strcmp(word, names[i]) == 0) return i;
    return -1;
}

cml_status cml_mci_take_name(const struct cml_mci_line *line, char **name)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_";
    const char *word = line->value;
    const size_t size = strlen(word);
    if (size == 0 || size >= CML_DETECTOR_NAME || strspn(word, letters) < size)
        return cml_mci_fail_value(line, line->key->noun);
    const char *ending = cml_quantity_ending(word);
    if (!ending) return cml_text_copy(word, name, line->reader->err);
    return cml_mci_fail_value(line,
                              CML_TEXT("a name that does not end in %s, as names of results do", ending));
}

cml_status cml_mci_take_port(const struct cml_mci_line *line, char **name)
{
    const char *word = cml_text_word(&line->reader->cursor);
    if (!word || strchr(word, '=')) return cml_mci_fail_option(line, "port", word, "the name of a port line");
    return cml_text_copy(word, name, line->reader->err);
}
