/* SPDX-License-Identifier: MIT */
#include "options/option_values.h"

#include "base/text.h"
#include "engine/engines.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Refuses the value of an option, with a hint if it looks like a number in another notation. */
static cml_status fail(struct cml_error *err, const struct cml_option *option, const char *value,
                       const char *expected)
{
    return cml_fail(err, CML_E_INPUT, "--%s %s (expected %s%s)", option->name, value, expected,
                    cml_number_hint(value, expected));
}

/* ---- functions that several options share ---- */

static void *member_of(const struct cml_option *option, struct cml_options *options)
{
    return (char *)options + option->member;
}

/* Stores a whole number in the member of the options that the option names: a bool, or an int or
 * enumerator. */
static cml_status set(const struct cml_option *option, int number, struct cml_options *options)
{
    if (option->size == sizeof(bool))
        *(bool *)member_of(option, options) = number != 0;
    else
        memcpy(member_of(option, options), &number, sizeof number);
    return CML_OK;
}

/* Sets an option that takes no value. */
cml_status cml_read_flag(const struct cml_option *option, const char *value, struct cml_options *options,
                         struct cml_error *err)
{
    (void)value, (void)err;
    return set(option, (int)option->least, options);
}

/* Keeps an option's value as text. The text lives in argv, so it need not be copied. */
cml_status cml_read_text(const struct cml_option *option, const char *value, struct cml_options *options,
                         struct cml_error *err)
{
    (void)err;
    *(const char **)member_of(option, options) = value;
    return CML_OK;
}

/* Reads a whole number within the range of the option's row in the table. */
static cml_status count(const struct cml_option *option, const char *value, uint64_t *number,
                        struct cml_error *err)
{
    uint64_t read = 0;
    if (!cml_parse_count(value, &read) || (double)read < option->least || (double)read > option->most)
        return fail(err, option, value,
                    CML_TEXT("a whole number from %.0f to %.0f", option->least, option->most));
    *number = read;
    return CML_OK;
}

cml_status cml_read_count(const struct cml_option *option, const char *value, struct cml_options *options,
                          struct cml_error *err)
{
    return count(option, value, member_of(option, options), err);
}

/* Reads the seed, and records that one was given, because a table of --sweep may have seeds, too. */
cml_status cml_read_seed(const struct cml_option *option, const char *value, struct cml_options *options,
                         struct cml_error *err)
{
    options->seed_given = true;
    return cml_read_count(option, value, options, err);
}

cml_status cml_read_int(const struct cml_option *option, const char *value, struct cml_options *options,
                        struct cml_error *err)
{
    uint64_t number = 0;
    CML_TRY(count(option, value, &number, err));
    return set(option, (int)number, options);
}

/* Reads a number in the option's range. option->words describes the range for the message. */
cml_status cml_read_number(const struct cml_option *option, const char *value, struct cml_options *options,
                           struct cml_error *err)
{
    double *number = member_of(option, options);
    if (cml_parse_double(value, number) && *number >= option->least && *number <= option->most) return CML_OK;
    return fail(err, option, value, option->words);
}

/* Reads the value of an option that takes one of several words. The option's number becomes its least value
 * plus the word's position in the list. */
cml_status cml_read_word(const struct cml_option *option, const char *value, struct cml_options *options,
                         struct cml_error *err)
{
    const int position = cml_word_index(option->words, value);
    if (position >= 0) return set(option, (int)option->least + position, options);
    return fail(err, option, value,
                CML_TEXT("%s%s", strchr(option->words, ' ') ? "one of " : "", option->words));
}

/* ---- photons, engine and end of a run ---- */

cml_status cml_read_set(const struct cml_option *option, const char *value, struct cml_options *options,
                        struct cml_error *err)
{
    (void)option;
    return cml_settings_add(&options->settings, value, err);
}

cml_status cml_read_engine(const struct cml_option *option, const char *value, struct cml_options *options,
                           struct cml_error *err)
{
    const struct cml_engine *engine = cml_engine_find(value);
    if (engine) options->engine = engine;
    return engine ? CML_OK : fail(err, option, value, "cpu, reference or opencl");
}

/* Reads two numbers, "A,B". */
static bool parse_pair(const char *value, double *a, double *b)
{
    char first[32];
    const char *comma = strchr(value, ',');
    const size_t length = comma ? (size_t)(comma - value) : sizeof first;
    if (length >= sizeof first) return false;
    memcpy(first, value, length);
    first[length] = '\0';
    return cml_parse_double(first, a) && cml_parse_double(comma + 1, b);
}

/* Reads --roulette: `mcml` for that of original MCML, or two weights: below the first, roulette is played,
 * and survivors get the second. */
cml_status cml_read_roulette(const struct cml_option *option, const char *value, struct cml_options *options,
                             struct cml_error *err)
{
    struct cml_roulette_options *roulette = &options->engine_options.roulette;
    *roulette = (struct cml_roulette_options){0, 0};
    if (strcmp(value, "mcml") == 0) return CML_OK;
    const bool sound = parse_pair(value, &roulette->below, &roulette->weight) && roulette->below >= 1e-6 &&
                       roulette->below <= roulette->weight && roulette->weight <= 1;
    return sound ? CML_OK : fail(err, option, value, "mcml, or WR,WS with 1e-6 <= WR <= WS <= 1");
}

/* True if a name, up to its end or a comma, may be an aim. Any name may be that of a detector; A_l: needs the
 * number of a layer behind it. */
static bool is_aim(const char *name)
{
    const size_t length = strcspn(name, ",");
    char number[16];
    int layer;
    if (strncmp(name, "A_l:", 4) != 0) return length > 0;
    if (length - 4 >= sizeof number) return false;
    snprintf(number, sizeof number, "%.*s", (int)length - 4, name + 4);
    return *number >= '1' && *number <= '9' && cml_parse_int(number, &layer);
}

/* Reads --aim: names of the quantities that packets are guided to. Whether the scene has them is checked
 * later. */
cml_status cml_read_aim(const struct cml_option *option, const char *value, struct cml_options *options,
                        struct cml_error *err)
{
    if (options->aim) return fail(err, option, value, "it once, several names with commas");
    for (const char *name = value; name; name = strchr(name, ',') ? strchr(name, ',') + 1 : NULL)
        if (!is_aim(name))
            return fail(err, option, value,
                        "Tt, Tt_r, A_l:N of layer N or the name of a detector, or several with commas");
    options->aim = value;
    return CML_OK;
}

/* Reads --error-of: the one layer or detector whose error ends a run. */
cml_status cml_read_error_of(const struct cml_option *option, const char *value, struct cml_options *options,
                             struct cml_error *err)
{
    if (options->error_of) return fail(err, option, value, "it once");
    if (strchr(value, ',') || !is_aim(value))
        return fail(err, option, value, "A_l:N of layer N or the name of a detector");
    options->error_of = value;
    return CML_OK;
}

/* Reads --checkpoint: an interval in seconds, or "off", which counts as 0. */
cml_status cml_read_checkpoint(const struct cml_option *option, const char *value,
                               struct cml_options *options, struct cml_error *err)
{
    if (strcmp(value, "off") != 0) return cml_read_number(option, value, options, err);
    options->checkpoint_interval = 0;
    return CML_OK;
}

/* Reads --part K/N: this process flies only part K of N. */
cml_status cml_read_part(const struct cml_option *option, const char *value, struct cml_options *options,
                         struct cml_error *err)
{
    char first[24] = "";
    const char *slash = strchr(value, '/');
    if (slash && (size_t)(slash - value) < sizeof first) memcpy(first, value, (size_t)(slash - value));
    if (cml_parse_count(first, &options->part) && cml_parse_count(slash + 1, &options->parts) &&
        options->part >= 1 && options->part <= options->parts && (double)options->parts <= option->most)
        return CML_OK;
    return fail(err, option, value, "K/N, part K of N, with 1 <= K <= N <= 4096");
}

/* ---- surfaces of boundaries ---- */

/* Records that a tolerance was given: a boundary may then become a plane, if this changes results by less. */
cml_status cml_read_tolerance(const struct cml_option *option, const char *value, struct cml_options *options,
                              struct cml_error *err)
{
    options->surface.may_flatten = true;
    return cml_read_number(option, value, options, err);
}

/* Reads the largest number of triangles that a heightmap's mesh may have. */
cml_status cml_read_mesh_budget(const struct cml_option *option, const char *value,
                                struct cml_options *options, struct cml_error *err)
{
    uint64_t most = 0;
    CML_TRY(count(option, value, &most, err));
    options->surface.budget.most = (double)most;
    return CML_OK;
}
