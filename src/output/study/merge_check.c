/* Whether results belong together: one scene on one grid, and no packets in common.
 * SPDX-License-Identifier: MIT */
#include "output/study/merge_parts.h"

#include "base/text.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static cml_status fail_scene(const struct cml_merge_input *first, const struct cml_merge_input *other,
                             const char *what, const char *there, const char *here, struct cml_error *err)
{
    return cml_fail(err, CML_E_INPUT, "%.200s: %s = %.100s (expected %.100s, as in %.200s)", other->name,
                    what, here, there, first->name);
}

static cml_status check_number(const struct cml_merge_input *first, const struct cml_merge_input *other,
                               const char *what, double there, double here, struct cml_error *err)
{
    char one[32], two[32];
    if (there == here) return CML_OK;
    snprintf(one, sizeof one, "%g", there);
    snprintf(two, sizeof two, "%g", here);
    return fail_scene(first, other, what, one, two, err);
}

static cml_status check_layers(const struct cml_merge_input *first, const struct cml_merge_input *other,
                               struct cml_error *err)
{
    for (int l = 0; l < first->outcome->num_layers; l++)
        for (int i = 0; i < CML_LAYER_NUMBERS; i++) {
            char what[32];
            snprintf(what, sizeof what, "layer%d.%s", l + 1,
                     cml_quantities[CML_QUANTITY_layer_n + i].name + strlen("layer_"));
            CML_TRY(check_number(first, other, what, *cml_outcome_layer(first->outcome, l, i),
                                 *cml_outcome_layer(other->outcome, l, i), err));
        }
    return CML_OK;
}

static cml_status check_parameters(const struct cml_merge_input *first, const struct cml_merge_input *other,
                                   struct cml_error *err)
{
    const struct cml_outcome *a = first->outcome, *b = other->outcome;
    CML_TRY(check_number(first, other, "dz", a->dz, b->dz, err));
    CML_TRY(check_number(first, other, "dr", a->dr, b->dr, err));
    CML_TRY(check_number(first, other, "nz", a->nz, b->nz, err));
    CML_TRY(check_number(first, other, "nr", a->nr, b->nr, err));
    CML_TRY(check_number(first, other, "na", a->na, b->na, err));
    CML_TRY(check_number(first, other, "time: T1", a->time_end, b->time_end, err));
    CML_TRY(check_number(first, other, "time: number of gates", a->num_gates, b->num_gates, err));
    CML_TRY(check_number(first, other, "directions: NT", a->nt, b->nt, err));
    CML_TRY(check_number(first, other, "directions: NP", a->np, b->np, err));
    CML_TRY(check_number(first, other, "number of layers", a->num_layers, b->num_layers, err));
    CML_TRY(check_layers(first, other, err));
    if (!(a->n_above > 0 && b->n_above > 0)) return CML_OK; /* an .h5 has them in its input only */
    CML_TRY(check_number(first, other, "above.n", a->n_above, b->n_above, err));
    return check_number(first, other, "below.n", a->n_below, b->n_below, err);
}

/* ---- the scene in words ---- */

enum { LINE = 512, TEXTS = 6 };

/* Lines without the folders of their files, each behind the prefix. How many packets were flown, a scene may
 * be asked in different numbers. */
static void write_lines(FILE *out, const char *prefix, const char *text)
{
    char line[LINE];
    while (text && *text) {
        const size_t length = strcspn(text, "\n");
        snprintf(line, sizeof line, "%.*s", (int)(length < LINE ? length : LINE - 1), text);
        char *from = strstr(line, " from ");
        if (from) *from = '\0';
        if (strncmp(line, "photons", strlen("photons")) != 0) fprintf(out, "%s%s\n", prefix, line);
        text += length + (text[length] == '\n');
    }
}

/* Settings, beam, phase functions, shapes and lines of the input: those from `first` to `end` - 1, several as
 * they stand in the head of an .mco. *words is the caller's to free. */
static cml_status write_words(const struct cml_outcome *o, int first, int end, char **words,
                              struct cml_error *err)
{
    const char *const texts[TEXTS] = {o->settings, o->beam, o->phases, o->detectors, o->shapes, o->scene};
    static const char *const prefix[TEXTS] = {"set ", "", "", "", "", "scene "};
    size_t size = 0;
    *words = NULL;
    FILE *out = open_memstream(words, &size);
    for (int i = first; out && i < end; i++) write_lines(out, end > first + 1 ? prefix[i] : "", texts[i]);
    return cml_text_end(out, words, &size, "a scene in words", err);
}

cml_status cml_merge_words(const struct cml_outcome *from, struct cml_outcome *merged, struct cml_error *err)
{
    char **const to[TEXTS] = {&merged->settings,  &merged->beam,   &merged->phases,
                              &merged->detectors, &merged->shapes, &merged->scene};
    for (int i = 0; i < TEXTS; i++) CML_TRY(write_words(from, i, i + 1, to[i], err));
    return cml_outcome_name_detectors(merged, err);
}

/* The first line that differs. */
static cml_status compare_words(const struct cml_merge_input *first, const struct cml_merge_input *other,
                                const char *one, const char *two, struct cml_error *err)
{
    char there[LINE], here[LINE];
    if (strcmp(one, two) == 0) return CML_OK;
    while (*one && *two && strcspn(one, "\n") == strcspn(two, "\n") &&
           strncmp(one, two, strcspn(one, "\n")) == 0) {
        one += strcspn(one, "\n") + 1;
        two += strcspn(two, "\n") + 1;
    }
    snprintf(there, sizeof there, "%.*s", (int)strcspn(one, "\n"), *one ? one : "nothing");
    snprintf(here, sizeof here, "%.*s", (int)strcspn(two, "\n"), *two ? two : "nothing");
    return fail_scene(first, other, "scene", there, here, err);
}

/* Settings, beam, phase functions, shapes and, where both have them, the lines of the input. */
static cml_status check_words(const struct cml_merge_input *first, const struct cml_merge_input *other,
                              struct cml_error *err)
{
    const char *a = first->outcome->scene, *b = other->outcome->scene;
    const int texts = a && b && a[0] && b[0] ? TEXTS : TEXTS - 1;
    CML_FREED char *one = NULL, *two = NULL;
    CML_TRY(write_words(first->outcome, 0, texts, &one, err));
    CML_TRY(write_words(other->outcome, 0, texts, &two, err));
    return compare_words(first, other, one, two, err);
}

/* ---- packets ---- */

/* What options decide and no line of the scene says. */
static cml_status check_options(const struct cml_merge_input *first, const struct cml_merge_input *other,
                                struct cml_error *err)
{
    for (int i = 0; i < CML_NUM_OPTIONS_OF_BITS; i++) {
        const char *apart = cml_options_of_bits[i].apart;
        const bool one = first->outcome->provenance.value[i] != 0,
                   two = other->outcome->provenance.value[i] != 0;
        if (apart && one != two)
            return fail_scene(first, other, apart, one ? "on" : "off", two ? "on" : "off", err);
    }
    return CML_OK;
}

/* Packets with the same numbers are the same packets. */
static cml_status check_seeds(const struct cml_merge_input *first, const struct cml_merge_input *other,
                              struct cml_error *err)
{
    for (int i = 0; i < first->outcome->num_streams; i++)
        for (int k = 0; k < other->outcome->num_streams; k++) {
            const struct cml_seed *one = &first->outcome->stream[i], *two = &other->outcome->stream[k];
            if (one->seed == two->seed && one->run == two->run)
                return cml_fail(err, CML_E_INPUT,
                                "%.200s: seed = %" PRIu64 ", run %" PRIu64
                                " (expected a seed that %.200s does not have)",
                                other->name, two->seed, two->run, first->name);
        }
    return CML_OK;
}

/* A scene in words is no scene: of a run's .h5 its text must be there. */
static cml_status check_origin(const struct cml_merge_input *input, struct cml_error *err)
{
    const struct cml_outcome *o = input->outcome;
    if (o->merged || !cml_file_ends_in(input->name, ".h5") || (o->scene && o->scene[0])) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "%.200s: has no input (expected the text of its scene)", input->name);
}

cml_status cml_merge_check(const struct cml_merge_input *inputs, int count, struct cml_error *err)
{
    for (int i = 0; i < count; i++) CML_TRY(check_origin(&inputs[i], err));
    for (int i = 1; i < count; i++) {
        CML_TRY(check_parameters(&inputs[0], &inputs[i], err));
        CML_TRY(check_words(&inputs[0], &inputs[i], err));
        CML_TRY(check_options(&inputs[0], &inputs[i], err));
        for (int k = 0; k < i; k++) CML_TRY(check_seeds(&inputs[k], &inputs[i], err));
    }
    return CML_OK;
}
