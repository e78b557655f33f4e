/* SPDX-License-Identifier: MIT */
#include "output/study/merge.h"

#include "base/json_name.h"
#include "base/version.h"
#include "output/mco_sections.h"

#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Numbers of our own sections that are merged, with their errors. */
static const char *const profile_errors[] = {"se_A_z", "se_Rd_r", "se_Rd_a", "se_Tt_r", "se_Tt_a"};
enum { PROFILES = sizeof profile_errors / sizeof *profile_errors, BOOKS = 12 };

static int profile_size(const struct cml_mco *mco, int profile)
{
    const int sizes[PROFILES] = {mco->nz, mco->nr, mco->na, mco->nr, mco->na};
    return sizes[profile];
}

/* ---- do they belong together? ---- */

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

/* The next line of the text that says what the scene is, but for the folder of files; NULL: none. input:
 * lines of the input, which only .h5 files have, count, too. */
static const char *scene_line(const char **text, bool input, char line[256])
{
    static const char *const begins[] = {"# boundary", "# set ", "# scene "};
    const size_t kinds = input ? 3 : 2;
    while (*text && **text) {
        const size_t length = strcspn(*text, "\n");
        snprintf(line, 256, "%.*s", (int)length, *text);
        *text += length + ((*text)[length] == '\n');
        char *from = strstr(line, " from ");
        if (from) *from = '\0';
        for (size_t i = 0; i < kinds; i++)
            if (strncmp(line, begins[i], strlen(begins[i])) == 0 && !strstr(line, "# set photons"))
                return line;
    }
    return NULL;
}

/* Shapes, settings and, of .h5 files, the lines of the input. */
static cml_status check_lines(const struct cml_merge_input *first, const struct cml_merge_input *other,
                              struct cml_error *err)
{
    const char *a = first->mco->extra, *b = other->mco->extra;
    const bool input = strstr(a, "\n# scene ") && strstr(b, "\n# scene ");
    char there[256], here[256];
    for (;;) {
        const char *one = scene_line(&a, input, there), *two = scene_line(&b, input, here);
        if (!one && !two) return CML_OK;
        if (!one || !two || strcmp(one, two) != 0)
            return fail_scene(first, other, "scene", one ? one + 2 : "nothing", two ? two + 2 : "nothing",
                              err);
    }
}

/* The next "seed S, run R" of a text, which it has of a run or of what it was merged from. */
static bool next_seed(const char **text, uint64_t seed[2])
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

/* Packets with the same numbers are the same packets. */
static cml_status check_seeds(const struct cml_merge_input *first, const struct cml_merge_input *other,
                              struct cml_error *err)
{
    uint64_t one[2], two[2];
    for (const char *a = first->mco->extra; next_seed(&a, one);)
        for (const char *b = other->mco->extra; next_seed(&b, two);)
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
    if (cml_mco_extra(input->mco, "se_RAT", errors, 4) == 4 && next_seed(&extra, seed)) return CML_OK;
    return cml_fail(err, CML_E_INPUT,
                    "%.200s: has no seed or no standard errors (expected a result of this program)",
                    input->name);
}

static cml_status check(const struct cml_merge_input *inputs, int count, struct cml_error *err)
{
    for (int i = 0; i < count; i++) CML_TRY(check_errors(&inputs[i], err));
    for (int i = 1; i < count; i++) {
        CML_TRY(check_parameters(&inputs[0], &inputs[i], err));
        CML_TRY(check_lines(&inputs[0], &inputs[i], err));
        for (int k = 0; k < i; k++) CML_TRY(check_seeds(&inputs[k], &inputs[i], err));
    }
    return CML_OK;
}

/* ---- means ---- */

static double weight_of(const struct cml_merge_input *input, const struct cml_mco *merged)
{
    return (double)input->mco->photons / (double)merged->photons;
}

static void add_weighted(double *to, const double *from, size_t count, double weight)
{
    for (size_t i = 0; i < count; i++) to[i] += weight * from[i];
}

static void add_values(const struct cml_merge_input *input, struct cml_mco *merged)
{
    const double weight = weight_of(input, merged);
    const struct cml_mco *mco = input->mco;
    merged->user_time += mco->user_time;
    merged->Rsp += weight * mco->Rsp;
    merged->Rd += weight * mco->Rd;
    merged->A += weight * mco->A;
    merged->Tt += weight * mco->Tt;
    for (int s = 0; s < CML_MCO_SECTIONS; s++)
        add_weighted(cml_mco_values(merged, &cml_mco_sections[s]), cml_mco_values(mco, &cml_mco_sections[s]),
                     cml_mco_cells(mco, &cml_mco_sections[s]), weight);
}

/* Of one of our sections with `count` numbers: errors as roots of sums of squares, others as means or sums.
 */
enum how { AS_ERRORS, AS_MEANS, AS_SUMS };

static bool merge_section(const struct cml_merge_input *inputs, int num_inputs, const struct cml_mco *merged,
                          const char *key, enum how how, double *out, double *room, int count)
{
    memset(out, 0, (size_t)count * sizeof *out);
    for (int k = 0; k < num_inputs; k++) {
        const double weight = how == AS_SUMS ? 1 : weight_of(&inputs[k], merged);
        if (cml_mco_extra(inputs[k].mco, key, room, count) < count) return false;
        for (int i = 0; i < count; i++)
            out[i] += how == AS_ERRORS ? weight * room[i] * weight * room[i] : weight * room[i];
    }
    for (int i = 0; how == AS_ERRORS && i < count; i++) out[i] = sqrt(out[i]);
    return true;
}

/* ---- our sections ---- */

static void write_seeds(FILE *out, const struct cml_merge_input *inputs, int count)
{
    for (int k = 0; k < count; k++) {
        uint64_t seed[2];
        for (const char *text = inputs[k].mco->extra; next_seed(&text, seed);)
            fprintf(out, "# merged %s: seed %" PRIu64 ", run %" PRIu64 "\n", inputs[k].name, seed[0],
                    seed[1]);
    }
}

/* What the first of them says of its scene, files included. */
static void write_scene(FILE *out, const char *extra)
{
    char line[256];
    for (const char *text = extra; scene_line(&text, true, line);) fprintf(out, "%s\n", line);
}

static void write_numbers(FILE *out, const char *key, const char *comment, const char *format,
                          const double *numbers, int count)
{
    fprintf(out, "\n%s # %s\n", key, comment);
    for (int i = 0; i < count; i++) fprintf(out, format, numbers[i]);
}

static void write_extra(FILE *out, const struct cml_merge_input *inputs, int count,
                        const struct cml_mco *merged, double *numbers, double *room)
{
    double lattice = 0;
    fprintf(out, "\n# clustermcml %s\n", cml_version());
    write_seeds(out, inputs, count);
    write_scene(out, inputs[0].mco->extra);
    for (int k = 0; k < count; k++) {
        double here = 0;
        (void)cml_mco_extra(inputs[k].mco, "lattice", &here, 1);
        lattice = fmax(lattice, here);
    }
    write_numbers(out, "lattice", "1: the packets of a batch depend on each other, 0: all are independent",
                  "%g\n", &lattice, 1);
    if (merge_section(inputs, count, merged, "se_RAT", AS_ERRORS, numbers, room, 4))
        write_numbers(out, "se_RAT", "Standard errors of Rsp, Rd, A, Tt [-]", "%.9G\n", numbers, 4);
    for (int p = 0; p < PROFILES; p++)
        if (merge_section(inputs, count, merged, profile_errors[p], AS_ERRORS, numbers, room,
                          profile_size(merged, p)))
            write_numbers(out, profile_errors[p], "standard errors", "%12.9E\n", numbers,
                          profile_size(merged, p));
    if (merge_section(inputs, count, merged, "books", AS_MEANS, numbers, room, BOOKS))
        write_numbers(out, "books", "weight per launched packet, in the order of a run", "%.17g\n", numbers,
                      BOOKS);
    if (merge_section(inputs, count, merged, "residue", AS_SUMS, numbers, room, 1))
        write_numbers(out, "residue", "of the books, in 2^-31 packets", "%.17g\n", numbers, 1);
    if (merge_section(inputs, count, merged, "lost", AS_SUMS, numbers, room, 1))
        write_numbers(out, "lost", "packets", "%.17g\n", numbers, 1);
}

static cml_status fill_extra(const struct cml_merge_input *inputs, int count, struct cml_mco *merged,
                             struct cml_error *err)
{
    size_t size = 0, most = BOOKS;
    for (int p = 0; p < PROFILES; p++)
        if ((size_t)profile_size(merged, p) > most) most = (size_t)profile_size(merged, p);
    double *numbers = calloc(2 * most, sizeof *numbers);
    FILE *out = numbers ? open_memstream(&merged->extra, &size) : NULL;
    int failed = 1;
    if (out) {
        write_extra(out, inputs, count, merged, numbers, numbers + most);
        failed = ferror(out);
        if (fclose(out) != 0) failed = 1;
    }
    free(numbers);
    return failed ? cml_fail_memory(err, (double)(2 * most) * sizeof *numbers, "a merged result") : CML_OK;
}

static cml_status fill(const struct cml_merge_input *inputs, int count, const char *title,
                       struct cml_mco *merged, struct cml_error *err)
{
    const struct cml_mco *first = inputs[0].mco;
    merged->dz = first->dz;
    merged->dr = first->dr;
    merged->nz = first->nz;
    merged->nr = first->nr;
    merged->na = first->na;
    merged->num_layers = first->num_layers;
    for (int k = 0; k < count && !(merged->n_above > 0); k++) {
        merged->n_above = inputs[k].mco->n_above;
        merged->n_below = inputs[k].mco->n_below;
    }
    CML_TRY(cml_mco_allocate(merged, err));
    memcpy(merged->layer, first->layer, (size_t)first->num_layers * sizeof *first->layer);
    merged->output = strdup(title);
    if (!merged->output) return cml_fail_memory(err, 1, "a name");
    for (int k = 0; k < count; k++) merged->photons += inputs[k].mco->photons;
    for (int k = 0; k < count; k++) add_values(&inputs[k], merged);
    return fill_extra(inputs, count, merged, err);
}

cml_status cml_merge(const struct cml_merge_input *inputs, int count, const char *title,
                     struct cml_mco *merged, struct cml_error *err)
{
    *merged = (struct cml_mco){0};
    CML_TRY(check(inputs, count, err));
    const cml_status status = fill(inputs, count, title, merged, err);
    if (status != CML_OK) cml_mco_clear(merged);
    return status;
}

/* ---- --json ---- */

cml_status cml_merge_json(FILE *stream, const char *path, const struct cml_merge_input *inputs, int count,
                          const struct cml_mco *merged, struct cml_error *err)
{
    double errors[4] = {0};
    (void)cml_mco_extra(merged, "se_RAT", errors, 4);
    json_t *names = json_array();
    for (int k = 0; k < count; k++) json_array_append_new(names, cml_json_name(inputs[k].name));
    json_t *object =
        json_pack("{s:o, s:o, s:I, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:s}", "output",
                  cml_json_name(path), "inputs", names, "photons", (json_int_t)merged->photons, "Rsp",
                  merged->Rsp, "Rd", merged->Rd, "A", merged->A, "Tt", merged->Tt, "Rsp_se", errors[0],
                  "Rd_se", errors[1], "A_se", errors[2], "Tt_se", errors[3], "version", cml_version());
    char *text = object ? json_dumps(object, JSON_COMPACT) : NULL;
    json_decref(object);
    if (!text) return cml_fail_memory(err, 1, "the JSON record");
    fprintf(stream, "%s\n", text);
    free(text);
    return CML_OK;
}
