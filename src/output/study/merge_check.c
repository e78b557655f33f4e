/* Whether results belong together: one scene on one grid, and no packets in common.
 * SPDX-License-Identifier: MIT */
#include "output/study/merge_parts.h"

#include <inttypes.h>
#include <stdio.h>
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
    static const char *const fields[] = {"n", "mua", "mus", "g", "d"};
    for (int l = 0; l < first->mco->num_layers; l++)
        for (int i = 0; i < 5; i++) {
            char what[32];
            snprintf(what, sizeof what, "layer%d.%s", l + 1, fields[i]);
            CML_TRY(check_number(first, other, what, first->mco->layer[l][i], other->mco->layer[l][i], err));
        }
    return CML_OK;
}

static cml_status check_parameters(const struct cml_merge_input *first, const struct cml_merge_input *other,
                                   struct cml_error *err)
{
    const struct cml_mco *a = first->mco, *b = other->mco;
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

/* Comments of `extra` that say what the scene is; those of the input come last. */
static const char *const scene_lines[] = {"# set ", "# beam ", "# boundary ", "# body ", "# scene "};
enum { SCENE_LINES = sizeof scene_lines / sizeof *scene_lines };

static bool is_scene_line(const char *line, bool input)
{
    if (strncmp(line, "# set photons", strlen("# set photons")) == 0) return false;
    for (int i = 0; i < SCENE_LINES - !input; i++)
        if (strncmp(line, scene_lines[i], strlen(scene_lines[i])) == 0) return true;
    return false;
}

const char *cml_merge_scene_line(const char **text, bool input, char line[CML_MERGE_LINE])
{
    while (*text && **text) {
        const size_t length = strcspn(*text, "\n");
        snprintf(line, CML_MERGE_LINE, "%.*s", (int)length, *text);
        *text += length + ((*text)[length] == '\n');
        char *from = strstr(line, " from ");
        if (from) *from = '\0';
        if (is_scene_line(line, input)) return line;
    }
    return NULL;
}

/* Settings, beam, shapes and, of .h5 files, the lines of the input. */
static cml_status check_lines(const struct cml_merge_input *first, const struct cml_merge_input *other,
                              struct cml_error *err)
{
    const char *a = first->mco->extra, *b = other->mco->extra;
    const bool input = strstr(a, "\n# scene ") && strstr(b, "\n# scene ");
    char there[CML_MERGE_LINE], here[CML_MERGE_LINE];
    for (;;) {
        const char *one = cml_merge_scene_line(&a, input, there),
                   *two = cml_merge_scene_line(&b, input, here);
        if (!one && !two) return CML_OK;
        if (!one || !two || strcmp(one, two) != 0)
            return fail_scene(first, other, "scene", one ? one + 2 : "nothing", two ? two + 2 : "nothing",
                              err);
    }
}

bool cml_merge_first_exit(const char *extra)
{
    return strstr(extra, CML_MCO_FIRST_EXIT) != NULL;
}

int cml_merge_bodies(const char *extra)
{
    char line[CML_MERGE_LINE];
    int count = 0;
    for (const char *text = extra; cml_merge_scene_line(&text, false, line);)
        count += strncmp(line, "# body ", strlen("# body ")) == 0;
    return count;
}

bool cml_merge_next_seed(const char **text, uint64_t seed[2])
{
    while (*text) {
        *text = strstr(*text, "seed ");
        if (!*text) return false;
        const int found = sscanf(*text, "seed %" SCNu64 ", run %" SCNu64, &seed[0], &seed[1]);
        *text += strlen("seed ");
        if (found == 2) return true;
    }
    return false;
}

/* What options decide and no line of the scene says. */
static cml_status check_tallies(const struct cml_merge_input *first, const struct cml_merge_input *other,
                                struct cml_error *err)
{
    const bool one_exits = cml_merge_first_exit(first->mco->extra),
               other_exits = cml_merge_first_exit(other->mco->extra);
    double number;
    const bool one_depth = cml_mco_extra(first->mco, "se_A_z", &number, 1) > 0,
               other_depth = cml_mco_extra(other->mco, "se_A_z", &number, 1) > 0;
    if (one_exits != other_exits)
        return fail_scene(first, other, "re-entry", one_exits ? "off" : "on", other_exits ? "off" : "on",
                          err);
    if (one_depth == other_depth) return CML_OK;
    return fail_scene(first, other, "absorption by place", one_depth ? "on" : "off",
                      other_depth ? "on" : "off", err);
}

/* Packets with the same numbers are the same packets. */
static cml_status check_seeds(const struct cml_merge_input *first, const struct cml_merge_input *other,
                              struct cml_error *err)
{
    uint64_t one[2], two[2];
    for (const char *a = first->mco->extra; cml_merge_next_seed(&a, one);)
        for (const char *b = other->mco->extra; cml_merge_next_seed(&b, two);)
            if (one[0] == two[0] && one[1] == two[1])
                return cml_fail(err, CML_E_INPUT,
                                "%.200s: seed = %" PRIu64 ", run %" PRIu64
                                " (expected a seed that %.200s does not have)",
                                other->name, two[0], two[1], first->name);
    return CML_OK;
}

static cml_status check_errors(const struct cml_merge_input *input, struct cml_error *err)
{
    double errors[4];
    uint64_t seed[2];
    const char *extra = input->mco->extra;
    if (cml_mco_extra(input->mco, "se_RAT", errors, 4) == 4 && cml_merge_next_seed(&extra, seed))
        return CML_OK;
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
        CML_TRY(check_tallies(&inputs[0], &inputs[i], err));
        for (int k = 0; k < i; k++) CML_TRY(check_seeds(&inputs[k], &inputs[i], err));
    }
    return CML_OK;
}
