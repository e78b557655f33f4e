/* Reads, stores and prints numbers of keys, and words their ranges. SPDX-License-Identifier: MIT */
#include "input/keys/key.h"

#include "base/constants.h"
#include "base/text.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const struct cml_key *cml_keys_of(enum cml_key_group group)
{
    const struct cml_key *key = cml_key_table;
    while (key->group != group && key->group != CML_KEYS_NONE) key++;
    return key;
}

static bool is_whole(const struct cml_key *key)
{
    return key->type == CML_KEY_INT || key->type == CML_KEY_COUNT;
}

/* Parses a value of a key and checks its range; false: it is not valid. A whole number is parsed twice: as a
 * count, which refuses decimals, and as a double, because ranges are doubles. */
bool cml_key_parse(const struct cml_key *key, const char *word, double *value)
{
    double number = 0;
    uint64_t count = 0;
    if (!cml_parse_double(word, &number) || (is_whole(key) && !cml_parse_count(word, &count))) return false;
    const bool low = key->use & CML_KEY_ABOVE ? number <= key->least : number < key->least;
    const bool high = key->use & CML_KEY_BELOW ? number >= key->most : number > key->most;
    if ((low || high) && !(key->use & CML_KEY_OR_0 && number == 0)) return false;
    *value = number;
    return true;
}

/* Stores a number in the struct member that the key names, converted to its type: degrees become radians. */
void cml_key_store(const struct cml_key *key, void *base, double value)
{
    void *member = (char *)base + key->member;
    if (key->type == CML_KEY_INT)
        *(int *)member = (int)value;
    else if (key->type == CML_KEY_COUNT)
        *(uint64_t *)member = (uint64_t)value;
    else
        *(double *)member = key->type == CML_KEY_ANGLE ? value * (CML_PI / 180) : value;
}

double cml_key_degrees(double angle)
{
    char digits[32];
    snprintf(digits, sizeof digits, "%.14g", angle * (180 / CML_PI));
    return strtod(digits, NULL);
}

double cml_key_load(const struct cml_key *key, const void *base)
{
    const void *member = (const char *)base + key->member;
    if (key->type == CML_KEY_INT) return *(const int *)member;
    if (key->type == CML_KEY_COUNT) return (double)*(const uint64_t *)member;
    return key->type == CML_KEY_ANGLE ? cml_key_degrees(*(const double *)member) : *(const double *)member;
}

/* Prints a bound as the manual has it: "1e30", "1e-4", "0.01", "2^48". */
static const char *print_bound(double bound, char text[24])
{
    int power = 0;
    snprintf(text, 24, bound != 0 && fabs(bound) < 1e-3 ? "%.0e" : "%.6g", bound);
    if (frexp(bound, &power) == 0.5 && power > 40) snprintf(text, 24, "2^%d", power - 1);
    char *e = strchr(text, 'e');
    if (e) snprintf(e + 1, 8, "%ld", strtol(e + 1, NULL, 10));
    return text;
}

/* Joins the words of a key with commas and "or": "top or bottom". */
static void print_words(const char *words, char text[CML_KEY_TEXT])
{
    char *end = text;
    for (const char *word = words; *word;) {
        const size_t length = strcspn(word, " ");
        const char *next = word + length + strspn(word + length, " ");
        const char *before = word == words ? "" : *next ? ", " : " or ";
        end += snprintf(end, (size_t)(text + CML_KEY_TEXT - end), "%s%.*s", before, (int)length, word);
        word = next;
    }
}

/* Writes what values a key takes, in words for "(expected ...)": list of words, form, or range with unit. */
const char *cml_key_expected(const struct cml_key *key, char text[CML_KEY_TEXT])
{
    char least[24], most[24];
    const bool degrees = key->unit && strcmp(key->unit, "degree") == 0;
    print_bound(key->least, least);
    print_bound(key->most, most);
    if (key->type == CML_KEY_WORD)
        print_words(key->noun, text);
    else if (key->type == CML_KEY_OWN)
        snprintf(text, CML_KEY_TEXT, "%s", key->noun ? key->noun : "");
    else if (key->type == CML_KEY_FLAG)
        snprintf(text, CML_KEY_TEXT, "the word %s alone", key->name);
    else if (key->type == CML_KEY_XY || key->type == CML_KEY_XYZ)
        snprintf(text, CML_KEY_TEXT, "x,y%s in cm without blanks", key->type == CML_KEY_XY ? "" : ",z");
    else if (key->use & (CML_KEY_ABOVE | CML_KEY_BELOW))
        snprintf(text, CML_KEY_TEXT, "%s, %s <%s %s <%s %s", key->noun, least,
                 key->use & CML_KEY_ABOVE ? "" : "=", key->name, key->use & CML_KEY_BELOW ? "" : "=", most);
    else
        snprintf(text, CML_KEY_TEXT, "%s%s of %s..%s%s%s", key->use & CML_KEY_OR_0 ? "0, or " : "", key->noun,
                 least, most, key->unit && !degrees ? " " : "", key->unit && !degrees ? key->unit : "");
    return text;
}

const char *cml_key_range(const struct cml_key *key, char text[CML_KEY_TEXT])
{
    char least[24], most[24];
    if (key->type > CML_KEY_COUNT) {
        cml_key_expected(key, text);
        return key->type == CML_KEY_XY    ? "x,y without blanks"
               : key->type == CML_KEY_XYZ ? "x,y,z without blanks"
                                          : text;
    }
    print_bound(key->least, least);
    print_bound(key->most, most);
    snprintf(text, CML_KEY_TEXT, "%s%s%s to %s%s%s", key->use & CML_KEY_OR_0 ? "0, or " : "",
             key->use & CML_KEY_ABOVE ? "above " : "", least, key->use & CML_KEY_BELOW ? "below " : "", most,
             is_whole(key) ? ", whole" : "");
    return text;
}

const char *cml_key_fallback(const struct cml_key *key)
{
    return key->fallback ? key->fallback : key->type == CML_KEY_FLAG ? "no" : "required";
}

/* Phase functions have names of their own. */
const char *cml_key_unit(const char *name)
{
    const char *dot = strrchr(name, '.');
    const char *last = dot ? dot + 1 : name;
    const bool of_phase = strstr(name, ".phase.") != NULL;
    for (const struct cml_key *key = cml_key_table; key->group != CML_KEYS_NONE; key++)
        if (key->use & CML_KEY_SET && strcmp(key->name, last) == 0 &&
            (strchr(cml_key_owners[key->group].set, '.') != NULL) == of_phase)
            return key->unit ? key->unit : "1";
    return "1";
}
