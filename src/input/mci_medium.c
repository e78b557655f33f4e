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

/* ---- phase: the angles by which a medium scatters ---- */

#define MOST_ROWS 1000000

/* Makes room for one more row in the three arrays of a tabulated phase function. */
static cml_status grow_table(const struct cml_mci_reader *reader, struct cml_phase *phase)
{
    double **const arrays[] = {&phase->deflection, &phase->density, &phase->below};
    for (int i = 0; i < 3; i++)
        CML_TRY(
            cml_array_grow(arrays[i], (size_t)phase->rows, sizeof(double), "a phase function", reader->err));
    return CML_OK;
}

/* Reads a row: angle and density. The deflection 1 - cos is computed as 2 sin^2(angle / 2), which loses no
 * digits at small angles. */
static cml_status read_row(struct cml_mci_reader *rows, struct cml_phase *phase)
{
    static const struct cml_key angle = {.name = "angle", .most = 180},
                                density = {.name = "p", .noun = "a phase function", .most = CML_MCI_HUGE};
    static const char rises[] = "degrees up to 180 that rise from row to row, the first 0";
    const int i = phase->rows;
    double t = 0, p = 0;
    const char *word = cml_text_word(&rows->cursor);
    const bool sound = cml_key_parse(&angle, word, &t) && (i > 0 || t == 0);
    const double sine = sin(t * (CML_PI / 360)), x = t == 180 ? 2 : 2 * sine * sine;
    if (!sound || (i > 0 && !(x > phase->deflection[i - 1])))
        return cml_mci_fail(rows, angle.name, word, rises);
    CML_TRY(cml_mci_number(rows, NULL, &density, &p));
    word = cml_text_word(&rows->cursor);
    if (word) return cml_mci_fail(rows, "row", word, "two columns: angle and p");
    if (i == MOST_ROWS) return cml_mci_fail(rows, "row", "1000001", "at most 1000000 rows");
    CML_TRY(grow_table(rows, phase));
    phase->deflection[i] = x;
    phase->density[i] = p;
    phase->rows++;
    return CML_OK;
}

/* Reads the rows "angle density" of a phase function up to 180 degrees, where the deflection 1 - cos is 2,
 * and scales them to a probability. */
static cml_status read_rows(struct cml_mci_reader *rows, void *context)
{
    struct cml_phase *phase = context;
    while (cml_mci_next_row(rows)) CML_TRY(read_row(rows, phase));
    if (phase->rows < 2 || phase->deflection[phase->rows - 1] < 2)
        return cml_mci_fail(rows, "angle", NULL, "a last row at 180 degrees");
    if (!cml_phase_scale_table(phase)) return cml_mci_fail(rows, "p", "0 in all rows", "light somewhere");
    return cml_text_copy(rows->text.path, &phase->file, rows->err);
}

enum cml_key_group cml_mci_phase_keys(const struct cml_phase *phase)
{
    static const enum cml_key_group keys[CML_PHASE_KINDS] = {CML_KEYS_HG2, CML_KEYS_MHG, CML_KEYS_GK};
    return phase ? keys[phase->kind] : CML_KEYS_NONE;
}

/* Reads the rest of a line `phase`: the kind and its numbers, or the file of a table. owner_word and number
 * name the layer or body in messages, as in "layer 2". */
static cml_status read_phase(struct cml_mci_reader *reader, const char *owner_word, int number,
                             struct cml_phase *phase)
{
    const char *owner = CML_TEXT("%s %d: phase", owner_word, number);
    cml_mci_cut_comment(reader->cursor);
    const char *word = cml_text_word(&reader->cursor);
    while (phase->kind < CML_PHASE_KINDS && (!word || strcmp(cml_phase_name(phase->kind), word) != 0))
        phase->kind++;
    if (phase->kind == CML_PHASE_KINDS)
        return cml_mci_fail(reader, CML_TEXT("%s: kind", owner), word, "hg2, mhg, gk, rayleigh or table");
    CML_TRY(phase->kind == CML_PHASE_TABLE
                ? cml_mci_table(reader, owner, cml_text_word(&reader->cursor),
                                "the name of a file of angles and densities", read_rows, phase)
                : cml_mci_leading_numbers(reader, owner, CML_KEY_PARTS({cml_mci_phase_keys(phase), phase})));
    return cml_mci_end_line(reader, owner);
}

/* Adds a phase function to the scene's list, and gives it to the medium. */
static cml_status add_phase(const struct cml_mci_reader *reader, struct cml_scene *scene,
                            struct cml_phase *phase, struct cml_medium_def *medium)
{
    phase->index = scene->phases ? scene->phases->index + 1 : 0;
    phase->next = scene->phases;
    medium->phase = scene->phases = phase;
    if (phase->index < CML_MOST_PHASES) return CML_OK;
    return cml_mci_fail(reader, "line", "phase", "at most 1000 different phase functions");
}

/* Gives the medium an equal phase function of the scene if there is one, and frees the new one; else adds the
 * new one. */
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
    struct cml_phase *phase;
    CML_TRY(cml_zeros(&phase, 1, sizeof *phase, "a phase function", reader->err));
    phase->line = medium->phase_line = reader->text.line;
    cml_status status = cml_share_begin(&phase->users, reader->err);
    if (status == CML_OK) status = read_phase(reader, body ? "body" : "layer", body ? k + 1 : layer, phase);
    if (status == CML_OK) return share_phase(reader, scene, phase, medium);
    cml_phases_free(phase);
    return status;
}

/* ---- settings, and checks of several lines ---- */

/* Copies the phase function if other media use it, too. Tables are not copied: they have no numbers that
 * could be set. */
cml_status cml_mci_own_phase(const struct cml_mci_reader *reader, struct cml_scene *scene, int m,
                             struct cml_phase **own)
{
    struct cml_medium_def *medium = &scene->media[m];
    const int media = scene->num_layers + 2 + scene->num_bodies;
    int users = 0;
    for (*own = scene->phases; *own != medium->phase;) *own = (*own)->next;
    for (int i = 0; i < media; i++) users += scene->media[i].phase == *own;
    if (users == 1) return CML_OK;
    struct cml_phase *copy;
    CML_TRY(cml_zeros(&copy, 1, sizeof *copy, "a phase function", reader->err));
    *copy = **own;
    *own = copy;
    cml_share(copy->users);
    return add_phase(reader, scene, copy, medium);
}

/* Refuses an absorption so small beside the scattering that rounding would lose it. */
static cml_status check_absorption(const struct cml_mci_reader *reader, const struct cml_scene *scene,
                                   const char *owner_word, int number, const struct cml_medium_def *medium)
{
    static const char expected[] = "0, or at least 1e-11 of mua + mus";
    const struct cml_settings *settings = reader->options->settings;
    const double mut = cml_medium_mut(medium);
    if (!(medium->mua > 0 && medium->mua < CML_LEAST_ABSORPTION * mut)) return CML_OK;
    const struct cml_setting *mua =
        settings ? cml_settings_find(settings, CML_TEXT("%s%d.mua", owner_word, number)) : NULL;
    if (settings && !mua && strcmp(owner_word, "layer") == 0)
        mua = cml_settings_find(settings, CML_TEXT("%s.mua", cml_layer_name(scene, number)));
    if (mua) return cml_setting_fail(mua, expected, reader->err);
    return cml_fail_field(reader->err, scene->file, medium->line, CML_TEXT("%s %d: mua", owner_word, number),
                          CML_TEXT("%g", medium->mua), expected);
}

/* Refuses a phase function whose mean cosine is not the medium's g. */
static cml_status check_mean(const struct cml_mci_reader *reader, const struct cml_scene *scene,
                             const char *owner_word, int number, const struct cml_medium_def *medium,
                             double mean)
{
    if (fabs(mean - medium->g) <= 1.0000001e-3) return CML_OK;
    return cml_fail_field(reader->err, scene->file, medium->phase_line,
                          CML_TEXT("%s %d: phase: mean cosine", owner_word, number), CML_TEXT("%.6g", mean),
                          CML_TEXT("the medium's g = %g to 1e-3", medium->g));
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
        const char *owner_word = body ? "body" : "layer";
        CML_TRY(check_absorption(reader, scene, owner_word, number, medium));
        if (medium->phase)
            CML_TRY(check_mean(reader, scene, owner_word, number, medium, mean[medium->phase->index]));
    }
    return CML_OK;
}

/* ---- backing: the surface under the last boundary ---- */

cml_status cml_mci_backing(struct cml_mci_reader *reader, struct cml_backing_def *backing)
{
    char expected[CML_KEY_TEXT];
    const struct cml_key *R = cml_keys_of(CML_KEYS_BACKING);
    if (backing->kind != CML_BACKING_NONE)
        return cml_mci_fail(reader, "line", cml_mci_raw(reader), "one backing line");
    cml_mci_cut_comment(reader->cursor);
    const char *word = cml_text_word(&reader->cursor);
    backing->line = reader->text.line;
    if (word && strcmp(word, "metal") == 0) {
        backing->kind = CML_BACKING_METAL;
        CML_TRY(cml_mci_leading_numbers(reader, "backing", CML_KEY_PARTS({CML_KEYS_METAL, backing})));
        return cml_mci_end_line(reader, "backing");
    }
    if (!word || !cml_key_parse(R, word, &backing->R))
        return cml_mci_fail(reader, "backing: R", word,
                            CML_TEXT("%s, or metal N K", cml_key_expected(R, expected)));
    word = cml_text_word(&reader->cursor);
    const bool diffuse = word && strcmp(word, "lambertian") == 0;
    if (word && !diffuse && strcmp(word, "mirror") != 0)
        return cml_mci_fail(reader, "backing", word, "mirror, lambertian or the end of the line");
    backing->kind = diffuse ? CML_BACKING_LAMBERTIAN : CML_BACKING_MIRROR;
    return cml_mci_end_line(reader, "backing");
}

/* ---- rough ---- */

static const char *const rough_names[] = {"ggx", "beckmann"};

/* Sets the distribution of slopes by its name; false if the name is unknown. */
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
    return set_rough_kind(name, rough) &&
           cml_key_parse(cml_keys_of(CML_KEYS_ROUGH), text + length + 1, &rough->alpha);
}

cml_status cml_mci_rough_line(struct cml_mci_reader *reader, int index, struct cml_rough_def *rough)
{
    const char *owner = CML_TEXT("boundary %d", index);
    if (rough->line > 0)
        return cml_mci_fail(reader, "line", cml_mci_raw(reader),
                            CML_TEXT("one rough line for %s, which already has line %d", owner, rough->line));
    cml_mci_cut_comment(reader->cursor);
    const char *name = cml_text_word(&reader->cursor);
    if (!set_rough_kind(name, rough))
        return cml_mci_fail(reader, CML_TEXT("%s: rough", owner), name, "ggx or beckmann");
    CML_TRY(cml_mci_leading_numbers(reader, owner, CML_KEY_PARTS({CML_KEYS_ROUGH, rough})));
    CML_TRY(cml_mci_end_line(reader, CML_TEXT("%s: rough alpha", owner)));
    rough->line = reader->text.line;
    return CML_OK;
}

/* Refuses a rough last boundary over a Lambertian backing: light from the backing has no microfacet to
 * pass. */
cml_status cml_mci_check_rough(const struct cml_mci_reader *reader, const struct cml_scene *scene)
{
    const struct cml_rough_def *last = &scene->boundaries[scene->num_layers].rough;
    if (scene->backing.kind != CML_BACKING_LAMBERTIAN || last->line == 0) return CML_OK;
    return cml_fail_field(
        reader->err, scene->file, scene->backing.line, "backing", "lambertian",
        "mirror or metal beside a rough line: light from a lambertian backing has no facets");
}
