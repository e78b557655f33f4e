/* SPDX-License-Identifier: MIT */
#include "output/study/merge_parts.h"

#include "base/json_name.h"
#include "base/version.h"
#include "output/mco_sections.h"

#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* How the numbers of several results become one: errors as roots of sums of squares. */
enum how { AS_ERRORS, AS_MEANS, AS_SUMS };

/* One of our own sections, which is merged where all results have it. */
struct section {
    const char *key, *comment, *format;
    enum how how;
    int count; /* of its numbers */
};
enum { SECTIONS = 11, BOOKS = 12 };

static void list_sections(const struct cml_mco *mco, struct section sections[SECTIONS])
{
    const int bodies = cml_merge_bodies(mco->extra);
    const char *error = "%12.9E\n";
    const struct section all[SECTIONS] = {
        {"se_RAT", "Standard errors of Rsp, Rd, A, Tt [-]", "%.9G\n", AS_ERRORS, 4},
        {"se_A_z", "[1/cm]", error, AS_ERRORS, mco->nz},
        {"se_Rd_r", "[1/cm2]", error, AS_ERRORS, mco->nr},
        {"se_Rd_a", "[sr-1]", error, AS_ERRORS, mco->na},
        {"se_Tt_r", "[1/cm2]", error, AS_ERRORS, mco->nr},
        {"se_Tt_a", "[sr-1]", error, AS_ERRORS, mco->na},
        {"books", "weight per launched packet, in the order of a run", "%.17g\n", AS_MEANS, BOOKS},
        {"residue", "of the books, in 2^-31 packets", "%.17g\n", AS_SUMS, 1},
        {"lost", "packets", "%.17g\n", AS_SUMS, 1},
        {"A_body", "absorption in each body, in the order of the .mci [-]", "%.9G\n", AS_MEANS, bodies},
        {"flux_body", "weight at each body's surface: arrives outside, inside, leaves outside, inside [-]",
         "%.9G\n", AS_MEANS, 4 * bodies},
    };
    memcpy(sections, all, sizeof all);
}

/* ---- means ---- */

static double weight_of(const struct cml_merge_input *input, const struct cml_mco *merged)
{
    return (double)input->mco->photons / (double)merged->photons;
}

double cml_merge_error_weight(const struct cml_merge_input *inputs, int count, int k)
{
    double photons = 0, with_error = 0;
    for (int i = 0; i < count; i++) {
        photons += (double)inputs[i].mco->photons;
        if (inputs[i].mco->photons > 1) with_error += (double)inputs[i].mco->photons;
    }
    const double own = (double)inputs[k].mco->photons;
    return own > 1 ? own / photons * sqrt(photons / with_error) : 0;
}

void cml_merge_add_spread(double *squares, const double *value, const double *mean, size_t n, int count)
{
    for (size_t i = 0; i < n; i++) {
        const double deviation = value[i] - mean[i];
        squares[i] += deviation * deviation / (count - 1) / count;
    }
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

/* What the errors of a section belong to. */
static const double *values_of(const struct cml_mco *mco, const struct section *section, double totals[4])
{
    const double all[] = {mco->Rsp, mco->Rd, mco->A, mco->Tt};
    memcpy(totals, all, sizeof all);
    for (int s = 0; s < CML_MCO_SECTIONS; s++)
        if (strcmp(section->key + strlen("se_"), cml_mco_sections[s].key) == 0)
            return cml_mco_values(mco, &cml_mco_sections[s]);
    return totals;
}

static void add_spread(const struct cml_mco *mco, int num_inputs, const struct cml_mco *merged,
                       const struct section *section, double *out)
{
    double totals[2][4];
    cml_merge_add_spread(out, values_of(mco, section, totals[0]), values_of(merged, section, totals[1]),
                         (size_t)section->count, num_inputs);
}

static bool merge_section(const struct cml_merge_input *inputs, int num_inputs, const struct cml_mco *merged,
                          const struct section *section, double *out, double *room)
{
    const bool errors = section->how == AS_ERRORS, spread = errors && merged->photons == (uint64_t)num_inputs;
    const size_t count = (size_t)section->count;
    memset(out, 0, count * sizeof *out);
    for (int k = 0; k < num_inputs; k++) {
        const double error_weight = cml_merge_error_weight(inputs, num_inputs, k);
        if (cml_mco_extra(inputs[k].mco, section->key, room, section->count) < section->count) return false;
        for (size_t i = 0; error_weight > 0 && errors && i < count; i++)
            out[i] += error_weight * room[i] * error_weight * room[i];
        if (spread) add_spread(inputs[k].mco, num_inputs, merged, section, out);
        if (!errors)
            add_weighted(out, room, count, section->how == AS_SUMS ? 1 : weight_of(&inputs[k], merged));
    }
    for (size_t i = 0; errors && i < count; i++) out[i] = sqrt(out[i]);
    return section->count > 0;
}

/* ---- what no run writes ---- */

/* Squares of larger numbers would overflow. */
static cml_status check_numbers(const struct cml_merge_input *input, const char *name, const double *numbers,
                                size_t count, bool error, struct cml_error *err)
{
    const bool unknown = error && input->mco->photons == 1;
    const double most = CML_MERGE_MOST, least = strcmp(name, "residue") == 0 ? -most : 0;
    for (size_t i = 0; i < count; i++)
        if (!(numbers[i] >= least && numbers[i] <= most) && !(unknown && isnan(numbers[i])))
            return cml_fail(err, CML_E_INPUT, "%.200s: %s[%zu] = %g (expected a number from %g to %g)",
                            input->name, name, i, numbers[i], least, most);
    return CML_OK;
}

/* The word in place of number `found` of a section that begins at `text`. */
static cml_status fail_word(const struct cml_merge_input *input, const struct section *section,
                            const char *text, int found, struct cml_error *err)
{
    for (int i = 0; text && i <= found; i++) text = strchr(text + 1, '\n');
    if (text) text += 1 + strspn(text + 1, " \t");
    const int length = text ? (int)strcspn(text, " \t\r\n") : 0;
    return cml_fail(err, CML_E_INPUT, "%.200s: %s[%d] = %.*s (expected one of %d numbers)", input->name,
                    section->key, found, length ? length < 40 ? length : 40 : 7, length ? text : "nothing",
                    section->count);
}

/* A section is there whole or not at all. room: [section->count + 1] */
static cml_status check_section(const struct cml_merge_input *input, const struct section *section,
                                double *room, struct cml_error *err)
{
    char line[32];
    snprintf(line, sizeof line, "\n%s ", section->key);
    const char *text = strstr(input->mco->extra, line);
    if (section->count == 0 || !text) return CML_OK;
    const int found = cml_mco_extra(input->mco, section->key, room, section->count + 1);
    if (found < section->count) return fail_word(input, section, text, found, err);
    if (found > section->count)
        return cml_fail(err, CML_E_INPUT, "%.200s: %s has more numbers (expected %d)", input->name,
                        section->key, section->count);
    return check_numbers(input, section->key, room, (size_t)found, section->how == AS_ERRORS, err);
}

static cml_status check_input(const struct cml_merge_input *input, const struct section sections[SECTIONS],
                              double *room, struct cml_error *err)
{
    const struct cml_mco *mco = input->mco;
    const double totals[] = {mco->Rsp, mco->Rd, mco->A, mco->Tt};
    CML_TRY(check_numbers(input, "user time", &mco->user_time, 1, false, err));
    CML_TRY(check_numbers(input, "RAT", totals, 4, false, err));
    for (int s = 0; s < CML_MCO_SECTIONS; s++)
        CML_TRY(check_numbers(input, cml_mco_sections[s].key, cml_mco_values(mco, &cml_mco_sections[s]),
                              cml_mco_cells(mco, &cml_mco_sections[s]), false, err));
    for (int s = 0; s < SECTIONS; s++) CML_TRY(check_section(input, &sections[s], room, err));
    return CML_OK;
}

/* ---- our sections ---- */

static void write_seeds(FILE *out, const struct cml_merge_input *inputs, int count)
{
    for (int k = 0; k < count; k++) {
        uint64_t seed[2];
        for (const char *text = inputs[k].mco->extra; cml_merge_next_seed(&text, seed);)
            fprintf(out, "# merged %s: seed %" PRIu64 ", run %" PRIu64 "\n", inputs[k].name, seed[0],
                    seed[1]);
    }
}

/* What the first of them says of its scene. */
static void write_scene(FILE *out, const char *extra)
{
    char line[CML_MERGE_LINE];
    if (cml_merge_first_exit(extra)) fprintf(out, "# %s\n", CML_MCO_FIRST_EXIT);
    for (const char *text = extra; cml_merge_scene_line(&text, true, line);) fprintf(out, "%s\n", line);
}

static void write_numbers(FILE *out, const struct section *section, const double *numbers)
{
    fprintf(out, "\n%s # %s\n", section->key, section->comment);
    for (int i = 0; i < section->count; i++) fprintf(out, section->format, numbers[i]);
}

static void write_lattice(FILE *out, const struct cml_merge_input *inputs, int count)
{
    double lattice = 0;
    for (int k = 0; k < count; k++) {
        double here = 0;
        (void)cml_mco_extra(inputs[k].mco, "lattice", &here, 1);
        lattice = fmax(lattice, here);
    }
    fprintf(out, "\nlattice # 1: the packets of a batch depend on each other, 0: all are independent\n%g\n",
            lattice);
}

/* The shapes that plots dot; an .h5 file has none. */
static void write_heightfields(FILE *out, const char *extra)
{
    for (const char *begin = extra; (begin = strstr(begin, "\nheightfield"));) {
        const char *end = strstr(begin, "\n\n");
        const size_t length = end ? (size_t)(end - begin) + 1 : strlen(begin);
        fprintf(out, "%.*s", (int)length, begin);
        begin += length - (end != NULL);
    }
}

static void write_extra(FILE *out, const struct cml_merge_input *inputs, int count,
                        const struct cml_mco *merged, const struct section sections[SECTIONS],
                        double *numbers, double *room)
{
    fprintf(out, "\n# clustermcml %s\n", cml_version());
    write_seeds(out, inputs, count);
    write_scene(out, inputs[0].mco->extra);
    write_lattice(out, inputs, count);
    for (int s = 0; s < SECTIONS; s++)
        if (merge_section(inputs, count, merged, &sections[s], numbers, room))
            write_numbers(out, &sections[s], numbers);
    write_heightfields(out, inputs[0].mco->extra);
}

static cml_status fill_extra(const struct cml_merge_input *inputs, int count, struct cml_mco *merged,
                             struct cml_error *err)
{
    struct section sections[SECTIONS];
    size_t size = 0, most = 0;
    list_sections(inputs[0].mco, sections);
    for (int s = 0; s < SECTIONS; s++)
        if ((size_t)sections[s].count > most) most = (size_t)sections[s].count;
    double *numbers = calloc(2 * most + 1, sizeof *numbers);
    cml_status status = numbers ? CML_OK : cml_fail_memory(err, 16.0 * (double)most, "a merged result");
    for (int k = 0; status == CML_OK && k < count; k++)
        status = check_input(&inputs[k], sections, numbers, err);
    FILE *out = status == CML_OK ? open_memstream(&merged->extra, &size) : NULL;
    int failed = 1;
    if (out) {
        write_extra(out, inputs, count, merged, sections, numbers, numbers + most);
        failed = ferror(out);
        if (fclose(out) != 0) failed = 1;
    }
    free(numbers);
    return failed && status == CML_OK ? cml_fail_memory(err, (double)size, "a merged result") : status;
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
    CML_TRY(cml_merge_check(inputs, count, err));
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
