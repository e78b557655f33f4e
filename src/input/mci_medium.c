/* SPDX-License-Identifier: MIT */
#include "input/mci_medium.h"

#include "base/array.h"
#include "base/constants.h"
#include "base/shared.h"
#include "input/mci_options.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MIN_INDEX 0.01
#define MAX_INDEX 100

static const char coefficient[] = "a coefficient of 0..1e30 1/cm";

const struct cml_mci_field cml_mci_medium_fields[CML_MCI_MEDIUM_FIELDS] = {
    {"n", MIN_INDEX, MAX_INDEX, false, "a refractive index of 0.01..100"},
    {"mua", 0, CML_MCI_HUGE, false, coefficient},
    {"mus", 0, CML_MCI_HUGE, false, coefficient},
    {"g", -1, 1, false, "an anisotropy of -1..1"},
};

const struct cml_mci_field cml_mci_thickness = {"d", 0, CML_MCI_HUGE, false, "a thickness of 0..1e30 cm"};

struct cml_medium_def cml_mci_medium(const struct cml_mci_reader *reader,
                                     const double line[CML_MCI_MEDIUM_FIELDS])
{
    return (struct cml_medium_def){
        .n = line[0], .mua = line[1], .mus = line[2], .g = line[3], .line = reader->text.line};
}

/* ---- the name of a layer ---- */

/* Where a word of its own begins with `key`; NULL: nowhere. */
static char *find_word(char *line, const char *key)
{
    char *found = strstr(line, key);
    while (found && found > line && !strchr(" \t", found[-1])) found = strstr(found + 1, key);
    return found;
}

/* Roughness belongs to a boundary and has a line of its own. Original MCML passes over any word behind the
 * five numbers, so only words that can mean nothing else are refused. */
static cml_status refuse_rough(struct cml_mci_reader *reader, const char *owner)
{
    static const char *const keys[] = {"rough=", "rough ggx", "rough beckmann"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        const char *word = find_word(reader->cursor, keys[i]);
        if (word)
            return cml_mci_fail(reader, owner, word,
                                "a line `rough KIND ALPHA` before the layer whose top it is");
    }
    return CML_OK;
}

/* Words that `--set` and columns of a sweep have for something else: photons, above, layer2 ... */
static bool is_taken(const char *name)
{
    static const char *const single[] = {"photons", "seed", "above", "below", "backing", NULL},
                             *const counted[] = {"layer", "body", "boundary", "beam", "detector", NULL};
    for (int i = 0; single[i]; i++)
        if (strcmp(name, single[i]) == 0) return true;
    for (int i = 0; counted[i]; i++) {
        const size_t length = strlen(counted[i]);
        if (strncmp(name, counted[i], length) != 0) continue;
        if (name[length + strspn(name + length, "0123456789")] == '\0') return true;
    }
    return false;
}

/* What the name was expected to be; NULL: it is one. */
static const char *why_no_layer_name(const struct cml_scene *scene, int layer, const char *name)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789";
    const size_t length = strlen(name);
    if (length == 0 || length >= CML_LAYER_NAME || name[strspn(name, letters)] != '\0' ||
        strchr("0123456789", *name))
        return "1 to 24 letters, digits and underscores, the first of them no digit";
    if (is_taken(name)) return "a name that no other part of a scene has";
    for (int l = 1; l < layer; l++)
        if (strcmp(cml_layer_name(scene, l), name) == 0) return "a name that no layer before has";
    return NULL;
}

cml_status cml_mci_layer_name(struct cml_mci_reader *reader, const char *owner, int layer,
                              struct cml_scene *scene)
{
    char field[64];
    cml_mci_cut_comment(reader->cursor);
    CML_TRY(refuse_rough(reader, owner));
    char *word = find_word(reader->cursor, "name=");
    if (!word) return CML_OK;
    *word = '\0'; /* the numbers end here */
    const char *name = word += strlen("name=");
    word += strcspn(word, " \t\v\f\r");
    const bool again = *word && find_word(word + 1, "name=");
    *word = '\0';
    const char *expected = again ? "one name" : why_no_layer_name(scene, layer, name);
    snprintf(field, sizeof field, "%s: name", owner);
    if (expected) return cml_mci_fail(reader, field, name, expected);
    const size_t layers = (size_t)scene->num_layers + 1;
    if (!scene->layer_names) scene->layer_names = calloc(layers, sizeof *scene->layer_names);
    if (!scene->layer_names)
        return cml_fail_memory(reader->err, (double)(layers * sizeof *scene->layer_names), "the layers");
    strcpy(scene->layer_names[layer], name);
    return CML_OK;
}

/* ---- phase: how the medium scatters ---- */

#define MOST_ROWS 1000000

static const struct cml_mci_field *phase_field(const char *name)
{
    static const char cosine[] = "a number of -0.9999..0.9999", share[] = "a share of 0..1";
    static const struct cml_mci_field fields[] = {
        {"g1", -0.9999, 0.9999, false, cosine},
        {"g2", -0.9999, 0.9999, false, cosine},
        {"w", 0, 1, false, share},
        {"g", -0.9999, 0.9999, false, cosine},
        {"a", -0.49999999999999994, 100, false, "a number above -0.5 and up to 100"}};
    const struct cml_mci_field *field = fields;
    while (strcmp(field->name, name) != 0) field++;
    return field;
}

/* Reads the numbers of a phase function; owner: as in "layer 2: phase". */
static cml_status read_phase_numbers(struct cml_mci_reader *reader, const char *owner,
                                     struct cml_phase *phase)
{
    const char *const *names = cml_phase_numbers(phase->kind);
    for (int i = 0; names[i]; i++)
        CML_TRY(cml_mci_leading_numbers(reader, owner, phase_field(names[i]), 1, &phase->number[i]));
    return CML_OK;
}

static cml_status grow_table(const struct cml_mci_reader *reader, struct cml_phase *phase)
{
    double **const arrays[] = {&phase->deflection, &phase->density, &phase->below};
    for (int i = 0; i < 3; i++)
        CML_TRY(
            cml_array_grow(arrays[i], (size_t)phase->rows, sizeof(double), "a phase function", reader->err));
    return CML_OK;
}

/* One row: angle and density. The deflection is 1 - cos, without the difference. */
static cml_status read_row(struct cml_mci_reader *reader, const struct cml_text *file, char *line,
                           struct cml_phase *phase)
{
    static const struct cml_mci_field angle = {"angle", 0, 180, false, ""},
                                      density = {"p", 0, CML_MCI_HUGE, false, ""};
    static const char rises[] = "degrees up to 180 that rise from row to row, the first 0";
    const int i = phase->rows;
    double t = 0, p = 0;
    const char *word = cml_text_word(&line);
    const bool sound = word && cml_mci_parse(&angle, word, &t) && (i > 0 || t == 0);
    const double sine = sin(t * (CML_PI / 360)), x = t == 180 ? 2 : 2 * sine * sine;
    if (!sound || (i > 0 && !(x > phase->deflection[i - 1])))
        return cml_fail_field(reader->err, file->path, file->line, angle.name, word, rises);
    word = cml_text_word(&line);
    if (!word || !cml_mci_parse(&density, word, &p))
        return cml_fail_field(reader->err, file->path, file->line, density.name, word,
                              "a phase function of 0..1e30");
    word = cml_text_word(&line);
    if (word)
        return cml_fail_field(reader->err, file->path, file->line, "row", word, "two columns: angle and p");
    if (i == MOST_ROWS)
        return cml_fail_field(reader->err, file->path, file->line, "row", "1000001", "at most 1000000 rows");
    CML_TRY(grow_table(reader, phase));
    phase->deflection[i] = x;
    phase->density[i] = p;
    phase->rows++;
    return CML_OK;
}

static cml_status read_rows(struct cml_mci_reader *reader, struct cml_text *file, struct cml_phase *phase)
{
    for (char *line; (line = cml_text_next(file));) {
        cml_mci_cut_comment(line);
        if (line[strspn(line, " \t\v\f\r")] != '\0') CML_TRY(read_row(reader, file, line, phase));
    }
    if (phase->rows < 2 || phase->deflection[phase->rows - 1] < 2)
        return cml_fail_field(reader->err, file->path, file->line, "angle", NULL,
                              "a last row at 180 degrees");
    if (cml_phase_scale_table(phase)) return CML_OK;
    return cml_fail_field(reader->err, file->path, file->line, "p", "0 in all rows", "light somewhere");
}

static cml_status read_table(struct cml_mci_reader *reader, const char *owner, struct cml_phase *phase)
{
    struct cml_text file = {0};
    const char *name = cml_text_word(&reader->cursor);
    char field[64];
    snprintf(field, sizeof field, "%s: file", owner);
    if (!name || name[0] == '"' || name[0] == '\0')
        return cml_mci_fail(reader, field, name, "the name of a file of angles and densities");
    CML_TRY(cml_path_beside(reader->text.path, name, &phase->file, reader->err));
    cml_status status = cml_text_read_table(reader->options->source, phase->file, &file, reader->err);
    if (status == CML_OK) status = read_rows(reader, &file, phase);
    cml_text_clear(&file);
    return cml_mci_name_line(reader, owner, phase->file, status);
}

static cml_status read_phase(struct cml_mci_reader *reader, const char *kind, int number,
                             struct cml_phase *phase)
{
    char owner[48], field[64];
    snprintf(owner, sizeof owner, "%s %d: phase", kind, number);
    snprintf(field, sizeof field, "%s: kind", owner);
    cml_mci_cut_comment(reader->cursor);
    const char *word = cml_text_word(&reader->cursor);
    while (phase->kind < CML_PHASE_KINDS && (!word || strcmp(cml_phase_name(phase->kind), word) != 0))
        phase->kind++;
    if (phase->kind == CML_PHASE_KINDS)
        return cml_mci_fail(reader, field, word, "hg2, mhg, gk, rayleigh or table");
    CML_TRY(phase->kind == CML_PHASE_TABLE ? read_table(reader, owner, phase)
                                           : read_phase_numbers(reader, owner, phase));
    word = cml_text_word(&reader->cursor);
    return word ? cml_mci_fail(reader, owner, word, "the end of the line or a comment") : CML_OK;
}

/* Adds a phase function to those of the scene, as the medium's, or takes an equal one that is there. */
static cml_status add_phase(const struct cml_mci_reader *reader, struct cml_scene *scene,
                            struct cml_phase *phase, struct cml_medium_def *medium)
{
    phase->index = scene->phases ? scene->phases->index + 1 : 0;
    phase->next = scene->phases;
    medium->phase = scene->phases = phase;
    if (phase->index < CML_MOST_PHASES) return CML_OK;
    return cml_mci_fail(reader, "line", "phase", "at most 1000 different phase functions");
}

/* Joins the scene's, unless it has an equal one. */
static cml_status share_phase(const struct cml_mci_reader *reader, struct cml_scene *scene,
                              struct cml_phase *phase, struct cml_medium_def *medium)
{
    struct cml_phase *equal = scene->phases;
    while (equal && !cml_phase_equal(equal, phase)) equal = equal->next;
    if (!equal) return add_phase(reader, scene, phase, medium);
    cml_phases_free(phase);
    medium->phase = equal;
    return CML_OK;
}

cml_status cml_mci_phase(struct cml_mci_reader *reader, int layer, struct cml_scene *scene)
{
    const int k = scene->num_bodies - 1;
    const bool body = k >= 0 && scene->bodies[k].layer == layer;
    struct cml_medium_def *medium = &scene->media[body ? cml_body_medium(scene, k) : layer];
    if (medium->phase)
        return cml_mci_fail(reader, "line", cml_mci_raw(reader), "one phase line for each layer and body");
    struct cml_phase *phase = calloc(1, sizeof *phase);
    if (!phase) return cml_fail_memory(reader->err, sizeof *phase, "a phase function");
    phase->line = medium->phase_line = reader->text.line;
    cml_status status = cml_share_begin(&phase->users, reader->err);
    if (status == CML_OK) status = read_phase(reader, body ? "body" : "layer", body ? k + 1 : layer, phase);
    if (status == CML_OK) return share_phase(reader, scene, phase, medium);
    cml_phases_free(phase);
    return status;
}

/* ---- numbers from outside, and what belongs together ---- */

/* The medium's function in the scene's list, after a copy where other media have it, too. Tables, whose rows
 * would have to be copied, have no numbers that could be set. */
static cml_status own_phase(const struct cml_mci_reader *reader, struct cml_scene *scene,
                            struct cml_medium_def *medium, struct cml_phase **own)
{
    const int media = scene->num_layers + 2 + scene->num_bodies;
    int users = 0;
    for (*own = scene->phases; *own != medium->phase;) *own = (*own)->next;
    for (int m = 0; m < media; m++) users += scene->media[m].phase == *own;
    if (users == 1) return CML_OK;
    struct cml_phase *copy = malloc(sizeof *copy);
    if (!copy) return cml_fail_memory(reader->err, sizeof *copy, "a phase function");
    *copy = **own;
    *own = copy;
    cml_share(copy->users);
    return add_phase(reader, scene, copy, medium);
}

static cml_status phase_number(const struct cml_mci_reader *reader, struct cml_scene *scene,
                               struct cml_medium_def *medium, const char *name, struct cml_mci_number *number)
{
    if (!medium->phase) return CML_OK;
    struct cml_phase *own;
    const char *const *names = cml_phase_numbers(medium->phase->kind);
    int i = 0;
    while (names[i] && strcmp(names[i], name) != 0) i++;
    if (!names[i]) return CML_OK;
    CML_TRY(own_phase(reader, scene, medium, &own));
    *number = (struct cml_mci_number){&own->number[i], phase_field(name), 1};
    return CML_OK;
}

cml_status cml_mci_medium_number(struct cml_mci_reader *reader, struct cml_scene *scene, int m,
                                 const char *member, struct cml_mci_number *number)
{
    struct cml_medium_def *medium = &scene->media[m];
    double *const values[] = {&medium->n, &medium->mua, &medium->mus, &medium->g};
    const bool outer = m == 0 || m == scene->num_layers + 1, layer = !outer && m <= scene->num_layers;
    *number = (struct cml_mci_number){0};
    if (!outer && strncmp(member, "phase.", 6) == 0)
        return phase_number(reader, scene, medium, member + 6, number);
    for (int i = 0; i < (outer ? 1 : CML_MCI_MEDIUM_FIELDS); i++)
        if (strcmp(cml_mci_medium_fields[i].name, member) == 0)
            *number = (struct cml_mci_number){values[i], &cml_mci_medium_fields[i], 1};
    if (layer && strcmp(member, "d") == 0)
        *number = (struct cml_mci_number){&medium->d, &cml_mci_thickness, 1};
    return CML_OK;
}

static cml_status check_absorption(const struct cml_mci_reader *reader, const struct cml_scene *scene,
                                   const char *kind, int number, const struct cml_medium_def *medium)
{
    static const char expected[] = "0, or at least 1e-11 of mua + mus";
    char name[CML_SETTING_NAME], field[48], value[32];
    const struct cml_settings *settings = reader->options->settings;
    const double mut = cml_medium_mut(medium);
    if (!(medium->mua > 0 && medium->mua < CML_LEAST_ABSORPTION * mut)) return CML_OK;
    snprintf(name, sizeof name, "%s%d.mua", kind, number);
    snprintf(field, sizeof field, "%s %d: mua", kind, number);
    snprintf(value, sizeof value, "%g", medium->mua);
    const struct cml_setting *mua = settings ? cml_settings_find(settings, name) : NULL;
    if (settings && !mua && strcmp(kind, "layer") == 0) {
        snprintf(name, sizeof name, "%s.mua", cml_layer_name(scene, number));
        mua = cml_settings_find(settings, name);
    }
    return mua ? cml_setting_fail(mua, expected, reader->err)
               : cml_fail_field(reader->err, scene->file, medium->line, field, value, expected);
}

static cml_status check_mean(const struct cml_mci_reader *reader, const struct cml_scene *scene,
                             const char *kind, int number, const struct cml_medium_def *medium, double mean)
{
    char field[64], value[32], expected[80];
    if (fabs(mean - medium->g) <= 1.0000001e-3) return CML_OK;
    snprintf(field, sizeof field, "%s %d: phase: mean cosine", kind, number);
    snprintf(value, sizeof value, "%.6g", mean);
    snprintf(expected, sizeof expected, "the medium's g = %g to 1e-3", medium->g);
    return cml_fail_field(reader->err, scene->file, medium->phase_line, field, value, expected);
}

cml_status cml_mci_check_media(const struct cml_mci_reader *reader, const struct cml_scene *scene)
{
    double mean[CML_MOST_PHASES];
    for (const struct cml_phase *phase = scene->phases; phase; phase = phase->next)
        mean[phase->index] = cml_phase_mean(phase);
    for (int m = 1; m < scene->num_layers + 2 + scene->num_bodies; m++) {
        const struct cml_medium_def *medium = &scene->media[m];
        const bool body = m > scene->num_layers + 1;
        const int number = body ? m - scene->num_layers - 1 : m;
        const char *kind = body ? "body" : "layer";
        CML_TRY(check_absorption(reader, scene, kind, number, medium));
        if (medium->phase)
            CML_TRY(check_mean(reader, scene, kind, number, medium, mean[medium->phase->index]));
    }
    return CML_OK;
}

/* ---- backing: what lies under the last boundary ---- */

static const struct cml_mci_field backing_R = {"backing: R", 0, 1, false,
                                               "a reflectance of 0..1, or metal N K"},
                                  backing_n = {"backing: N", 0, MAX_INDEX, false,
                                               "the real part of an index, 0..100"},
                                  backing_k = {"backing: K", 0, MAX_INDEX, false,
                                               "the imaginary part of an index, 0..100"};

struct cml_mci_number cml_mci_backing_number(struct cml_backing_def *backing, const char *member)
{
    const bool metal = backing->kind == CML_BACKING_METAL;
    if (metal && strcmp(member, "n") == 0) return (struct cml_mci_number){&backing->n, &backing_n, 1};
    if (metal && strcmp(member, "k") == 0) return (struct cml_mci_number){&backing->k, &backing_k, 1};
    if (!metal && backing->kind != CML_BACKING_NONE && strcmp(member, "r") == 0)
        return (struct cml_mci_number){&backing->R, &backing_R, 1};
    return (struct cml_mci_number){0};
}

static cml_status backing_number(struct cml_mci_reader *reader, const char *word,
                                 const struct cml_mci_field *field, double *value)
{
    if (word && cml_mci_parse(field, word, value)) return CML_OK;
    return cml_mci_fail(reader, field->name, word, field->expected);
}

cml_status cml_mci_backing(struct cml_mci_reader *reader, struct cml_backing_def *backing)
{
    if (backing->kind != CML_BACKING_NONE)
        return cml_mci_fail(reader, "line", cml_mci_raw(reader), "one backing line");
    cml_mci_cut_comment(reader->cursor);
    const char *word = cml_text_word(&reader->cursor);
    backing->line = reader->text.line;
    if (word && strcmp(word, "metal") == 0) {
        backing->kind = CML_BACKING_METAL;
        CML_TRY(backing_number(reader, cml_text_word(&reader->cursor), &backing_n, &backing->n));
        CML_TRY(backing_number(reader, cml_text_word(&reader->cursor), &backing_k, &backing->k));
        word = cml_text_word(&reader->cursor);
    } else {
        CML_TRY(backing_number(reader, word, &backing_R, &backing->R));
        word = cml_text_word(&reader->cursor);
        const bool diffuse = word && strcmp(word, "lambertian") == 0;
        if (word && !diffuse && strcmp(word, "mirror") != 0)
            return cml_mci_fail(reader, "backing", word, "mirror, lambertian or the end of the line");
        backing->kind = diffuse ? CML_BACKING_LAMBERTIAN : CML_BACKING_MIRROR;
        if (word) word = cml_text_word(&reader->cursor);
    }
    if (word) return cml_mci_fail(reader, "backing", word, "the end of the line or a comment");
    return CML_OK;
}

/* ---- rough ---- */

static const char *const rough_names[] = {"ggx", "beckmann"};
static const struct cml_mci_field alpha_field = {"alpha", 0, 2, false, "0, or a number of 1e-4..2"};

const char cml_mci_rough_option[] = "ggx,ALPHA or beckmann,ALPHA, with ALPHA 0 or 1e-4..2";

static bool set_rough_kind(const char *name, struct cml_rough_def *rough)
{
    const int which = name ? cml_mci_choose(name, rough_names, 2) : -1;
    rough->kind = which == 1 ? CML_ROUGH_BECKMANN : CML_ROUGH_GGX;
    return which >= 0;
}

bool cml_mci_parse_rough(const char *text, struct cml_rough_def *rough)
{
    char name[16];
    const size_t length = strcspn(text, ",");
    if (text[length] != ',' || length >= sizeof name) return false;
    snprintf(name, sizeof name, "%.*s", (int)length, text);
    return set_rough_kind(name, rough) && cml_mci_parse(&alpha_field, text + length + 1, &rough->alpha);
}

cml_status cml_mci_rough_line(struct cml_mci_reader *reader, int index, struct cml_rough_def *rough)
{
    char field[48], expected[96];
    snprintf(field, sizeof field, "boundary %d: rough", index);
    snprintf(expected, sizeof expected, "one rough line for boundary %d, which already has line %d", index,
             rough->line);
    if (rough->line > 0) return cml_mci_fail(reader, "line", cml_mci_raw(reader), expected);
    cml_mci_cut_comment(reader->cursor);
    const char *name = cml_text_word(&reader->cursor);
    if (!set_rough_kind(name, rough)) return cml_mci_fail(reader, field, name, "ggx or beckmann");
    const char *alpha = cml_text_word(&reader->cursor), *rest = cml_text_word(&reader->cursor);
    snprintf(field, sizeof field, "boundary %d: rough alpha", index);
    if (!alpha || !cml_mci_parse(&alpha_field, alpha, &rough->alpha))
        return cml_mci_fail(reader, field, alpha, alpha_field.expected);
    if (rest) return cml_mci_fail(reader, field, rest, "the end of the line, or a comment behind #");
    rough->line = reader->text.line;
    return CML_OK;
}

struct cml_mci_number cml_mci_rough_number(struct cml_rough_def *rough, const char *member)
{
    const bool known = rough->line > 0 && strcmp(member, alpha_field.name) == 0;
    return (struct cml_mci_number){known ? &rough->alpha : NULL, &alpha_field, 1};
}

/* A facet that is hardly turned is lost in the rounding of single precision. */
static cml_status check_alpha(const struct cml_mci_reader *reader, const struct cml_scene *scene,
                              const char *owner, int number, const struct cml_rough_def *rough)
{
    char field[48], value[32];
    if (rough->alpha == 0 || rough->alpha >= 1e-4) return CML_OK;
    snprintf(field, sizeof field, "%s %d: rough alpha", owner, number);
    snprintf(value, sizeof value, "%g", rough->alpha);
    return cml_fail_field(reader->err, scene->file, rough->line, field, value, alpha_field.expected);
}

cml_status cml_mci_check_rough(const struct cml_mci_reader *reader, const struct cml_scene *scene)
{
    for (int b = 0; b <= scene->num_layers; b++)
        CML_TRY(check_alpha(reader, scene, "boundary", b, &scene->boundaries[b].rough));
    for (int k = 0; k < scene->num_bodies; k++)
        CML_TRY(check_alpha(reader, scene, "body", k + 1, &scene->media[cml_body_medium(scene, k)].rough));
    const struct cml_rough_def *last = &scene->boundaries[scene->num_layers].rough;
    if (scene->backing.kind != CML_BACKING_LAMBERTIAN || last->line == 0) return CML_OK;
    return cml_fail_field(
        reader->err, scene->file, scene->backing.line, "backing", "lambertian",
        "mirror or metal beside a rough line: light from a lambertian backing has no facets");
}
