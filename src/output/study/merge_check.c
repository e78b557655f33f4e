/* Whether results belong together: one scene on one grid, and no packets in common.
 * SPDX-License-Identifier: MIT */
#include "output/study/merge_parts.h"

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
    CML_TRY(check_number(first, other, "number of layers", a->num_layers, b->num_layers, err));
    CML_TRY(check_layers(first, other, err));
    if (!(a->n_above > 0 && b->n_above > 0)) return CML_OK; /* an .h5 has them in its input only */
    CML_TRY(check_number(first, other, "above.n", a->n_above, b->n_above, err));
    return check_number(first, other, "below.n", a->n_below, b->n_below, err);
}

/* ---- the scene in words ---- */

enum { LINE = 512, TEXTS = 4 };

/* The lines of the texts that say what the scene is, one text after the other. Zeroed but for the outcome:
 * none yet. */
struct lines {
    const struct cml_outcome *outcome;
    int text;
    const char *next;
};

static const char *text_of(const struct cml_outcome *o, int text)
{
    const char *const texts[TEXTS] = {o->settings, o->beam, o->shapes, o->scene};
    return texts[text] ? texts[text] : "";
}

/* A line without the folder of its file; *text moves behind it. */
static void cut_line(const char **text, char line[LINE])
{
    const size_t length = strcspn(*text, "\n");
    snprintf(line, LINE, "%.*s", (int)(length < LINE ? length : LINE - 1), *text);
    *text += length + ((*text)[length] == '\n');
    char *from = strstr(line, " from ");
    if (from) *from = '\0';
}

/* How many packets were flown, a scene may be asked in different numbers. */
static bool counts(int text, const char *line)
{
    return text != 0 || strncmp(line, "photons", strlen("photons")) != 0;
}

/* The next line of the first `texts` texts; NULL behind the last. */
static const char *next_line(struct lines *lines, int texts, char line[LINE])
{
    for (; lines->text < texts; lines->text++, lines->next = NULL) {
        if (!lines->next) lines->next = text_of(lines->outcome, lines->text);
        while (*lines->next) {
            cut_line(&lines->next, line);
            if (counts(lines->text, line)) return line;
        }
    }
    return NULL;
}

/* As it stands in the head of an .mco. */
static void name_line(const struct lines *lines, const char *line, char name[LINE + 8])
{
    static const char *const kinds[TEXTS + 1] = {"set ", "", "", "scene ", ""};
    snprintf(name, LINE + 8, "%s%s", kinds[lines->text], line ? line : "nothing");
}

/* Settings, beam, shapes and, of .h5 files, the lines of the input. */
static cml_status check_lines(const struct cml_merge_input *first, const struct cml_merge_input *other,
                              struct cml_error *err)
{
    struct lines a = {.outcome = first->outcome}, b = {.outcome = other->outcome};
    const int texts =
        text_of(a.outcome, TEXTS - 1)[0] && text_of(b.outcome, TEXTS - 1)[0] ? TEXTS : TEXTS - 1;
    char there[LINE], here[LINE], one_named[LINE + 8], other_named[LINE + 8];
    for (;;) {
        const char *one = next_line(&a, texts, there), *two = next_line(&b, texts, here);
        if (!one && !two) return CML_OK;
        if (one && two && a.text == b.text && strcmp(one, two) == 0) continue;
        if (!one) a.text = TEXTS;
        if (!two) b.text = TEXTS;
        name_line(&a, one, one_named);
        name_line(&b, two, other_named);
        return fail_scene(first, other, "scene", one_named, other_named, err);
    }
}

static cml_status copy_lines(const struct cml_outcome *from, int text, char **to, struct cml_error *err)
{
    struct lines lines = {.outcome = from, .text = text};
    char line[LINE], *end = *to = calloc(strlen(text_of(from, text)) + 2, 1);
    if (!*to) return cml_fail_memory(err, 1, "a merged result");
    while (next_line(&lines, text + 1, line)) end += sprintf(end, "%s\n", line);
    return CML_OK;
}

cml_status cml_merge_words(const struct cml_outcome *from, struct cml_outcome *merged, struct cml_error *err)
{
    char **const to[TEXTS] = {&merged->settings, &merged->beam, &merged->shapes, &merged->scene};
    for (int i = 0; i < TEXTS; i++) CML_TRY(copy_lines(from, i, to[i], err));
    return CML_OK;
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

static cml_status check_errors(const struct cml_merge_input *input, struct cml_error *err)
{
    if (input->outcome->error[CML_QUANTITY_Rsp] && input->outcome->num_streams > 0) return CML_OK;
    return cml_fail(err, CML_E_INPUT,
                    "%.200s: has no seed or no standard errors (expected a result of this program)",
                    input->name);
}

cml_status cml_merge_check(const struct cml_merge_input *inputs, int count, struct cml_error *err)
{
    for (int i = 0; i < count; i++) CML_TRY(check_errors(&inputs[i], err));
    for (int i = 1; i < count; i++) {
        CML_TRY(check_parameters(&inputs[0], &inputs[i], err));
        CML_TRY(check_lines(&inputs[0], &inputs[i], err));
        CML_TRY(check_options(&inputs[0], &inputs[i], err));
        for (int k = 0; k < i; k++) CML_TRY(check_seeds(&inputs[k], &inputs[i], err));
    }
    return CML_OK;
}
