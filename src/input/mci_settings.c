/* SPDX-License-Identifier: MIT */
#include "input/mci_settings.h"

#include "input/mci_beam.h"
#include "input/mci_detector.h"
#include "input/mci_medium.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

const struct cml_mci_field cml_mci_photons_field = {"photons", 1, 281474976710656.0, true,
                                                    "a whole number of 1..2^48"};
static const struct cml_mci_field scale_field = {"scale", CML_MCI_TINY, CML_MCI_HUGE, false,
                                                 "a number of 1e-30..1e30"},
                                  height_field = {"height", 0, CML_MCI_HUGE, false, "a factor of 0..1e30"};

static cml_status set(const struct cml_mci_reader *reader, const struct cml_setting *setting,
                      const struct cml_mci_number *number)
{
    double value;
    if (!cml_mci_parse(number->field, setting->value, &value))
        return cml_setting_fail(setting, number->field->expected, reader->err);
    *number->value = value * number->unit;
    return CML_OK;
}

cml_status cml_mci_set_scaling(const struct cml_mci_reader *reader, int b, double *scale, double *height)
{
    const struct cml_mci_number numbers[] = {{scale, &scale_field, 1}, {height, &height_field, 1}};
    char name[CML_SETTING_NAME];
    for (int i = 0; reader->options->settings && i < 2; i++) {
        snprintf(name, sizeof name, "boundary%d.%s", b, numbers[i].field->name);
        const struct cml_setting *setting = cml_settings_find(reader->options->settings, name);
        if (setting) CML_TRY(set(reader, setting, &numbers[i]));
    }
    return CML_OK;
}

/* ---- names ---- */

/* "beam2.na" is "na" of number 2 of "beam"; number -1: without one. */
struct name {
    char whole[CML_LAYER_NAME]; /* "beam2", which may be the name of a layer; "" where it is too long */
    char owner[16];             /* "" where what stands before the dot is no word with a number */
    int number;
    const char *member;
};

/* False where the text has no dot; numbers are written as people write them, without a 0 before them. */
static bool split(const char *text, struct name *name)
{
    const char *dot = strchr(text, '.');
    if (!dot) return false;
    const size_t length = (size_t)(dot - text), letters = strcspn(text, "0123456789."),
                 digits = strspn(text + letters, "0123456789");
    *name = (struct name){.number = -1, .member = dot + 1};
    if (length < sizeof name->whole) snprintf(name->whole, sizeof name->whole, "%.*s", (int)length, text);
    if (letters >= sizeof name->owner || letters + digits != length || digits > 9 ||
        (digits > 1 && text[letters] == '0'))
        return true;
    snprintf(name->owner, sizeof name->owner, "%.*s", (int)letters, text);
    if (digits) name->number = (int)strtol(text + letters, NULL, 10);
    return true;
}

/* Which of `count` it is, from 0; a single one has no number. -1: none of them. */
static int which(const struct name *name, int count)
{
    if (count == 1) return name->number == -1 ? 0 : -1;
    return name->number >= 1 && name->number <= count ? name->number - 1 : -1;
}

/* The medium of a name's owner; -1: it is none. */
static int medium_of(const struct cml_scene *scene, const struct name *name)
{
    const int n = name->number;
    if (strcmp(name->owner, "above") == 0 && n == -1) return 0;
    if (strcmp(name->owner, "below") == 0 && n == -1) return scene->num_layers + 1;
    if (strcmp(name->owner, "layer") == 0 && n >= 1 && n <= scene->num_layers) return n;
    if (strcmp(name->owner, "body") == 0 && n >= 1 && n <= scene->num_bodies)
        return cml_body_medium(scene, n - 1);
    for (int l = 1; *name->whole && scene->layer_names && l <= scene->num_layers; l++)
        if (strcmp(scene->layer_names[l], name->whole) == 0) return l;
    return -1;
}

/* The roughness of a name's owner; NULL: it has no surface. */
static struct cml_rough_def *rough_of(const struct cml_scene *scene, const struct name *name)
{
    const int n = name->number;
    if (strcmp(name->owner, "boundary") == 0 && n >= 0 && n <= scene->num_layers)
        return &scene->boundaries[n].rough;
    if (strcmp(name->owner, "body") == 0 && n >= 1 && n <= scene->num_bodies)
        return &scene->media[cml_body_medium(scene, n - 1)].rough;
    return NULL;
}

static cml_status find_number(struct cml_mci_reader *reader, struct cml_scene *scene, const struct name *name,
                              struct cml_mci_number *number)
{
    struct cml_rough_def *rough = rough_of(scene, name);
    const int medium = medium_of(scene, name), beam = which(name, scene->num_beams),
              detector = which(name, scene->num_detectors);
    if (rough) *number = cml_mci_rough_number(rough, name->member);
    if (number->value) return CML_OK;
    if (medium >= 0) return cml_mci_medium_number(reader, scene, medium, name->member, number);
    if (strcmp(name->owner, "backing") == 0 && name->number == -1)
        *number = cml_mci_backing_number(&scene->backing, name->member);
    if (strcmp(name->owner, "beam") == 0 && beam >= 0)
        *number = cml_mci_beam_number(scene, beam, name->member);
    if (strcmp(name->owner, "detector") == 0 && detector >= 0)
        *number = cml_mci_detector_number(&scene->detectors[detector], name->member);
    return CML_OK;
}

/* Whether a setting is of a boundary that has a line of its own, whose reader has taken it
 * (cml_mci_set_scaling). */
static bool is_of_shape(const struct cml_scene *scene, const struct name *name)
{
    const bool has_shape = strcmp(name->owner, "boundary") == 0 && name->number >= 0 &&
                           name->number <= scene->num_layers && scene->boundaries[name->number].line > 0;
    return has_shape && (strcmp(name->member, "scale") == 0 || strcmp(name->member, "height") == 0);
}

/* ---- what to say of a name that there is not ---- */

/* "layer1", or "layer1..3". */
static void write_owners(FILE *out, const char *owner, int first, int last)
{
    fprintf(out, ", %s%d", owner, first);
    if (last > first) fprintf(out, "..%d", last);
}

static void write_media(FILE *out, const char *kind, int count, const char *fields)
{
    if (count == 0) return;
    write_owners(out, kind, 1, count);
    fprintf(out, " with %s", fields);
}

/* ", as gel and vessel": the layers that have a name. */
static void write_layer_names(FILE *out, const struct cml_scene *scene)
{
    const char *before = ", also named";
    for (int l = 1; l <= scene->num_layers; l++) {
        if (!*cml_layer_name(scene, l)) continue;
        fprintf(out, "%s %s", before, cml_layer_name(scene, l));
        before = "";
    }
}

static void write_phase(FILE *out, const char *kind, int number, const struct cml_phase *phase)
{
    if (!phase || !*cml_phase_numbers(phase->kind)) return;
    fprintf(out, ", %s%d.phase with", kind, number);
    for (const char *const *name = cml_phase_numbers(phase->kind); *name; name++) fprintf(out, " .%s", *name);
}

/* Writes which settings of shapes there are; planes have none. */
static void write_shapes(FILE *out, const struct cml_scene *scene)
{
    for (int b = 0; b <= scene->num_layers; b++)
        if (scene->boundaries[b].line > 0) fprintf(out, ", boundary%d.scale and .height", b);
    for (int b = 0; b <= scene->num_layers; b++)
        if (scene->boundaries[b].rough.line > 0) fprintf(out, ", boundary%d.alpha", b);
    for (int k = 0; k < scene->num_bodies; k++)
        if (scene->media[cml_body_medium(scene, k)].rough.line > 0) fprintf(out, ", body%d.alpha", k + 1);
}

/* A pencil has no numbers, other shapes have those that their names say. */
static void write_beams(FILE *out, const struct cml_scene *scene)
{
    static const char *const of_shape[] = {"", " .radius", " .radius", " .r1 .r2", " .w .h", ""};
    for (int k = 0; k < scene->num_beams && k < 9; k++) {
        const struct cml_beam *beam = &scene->beams[k];
        fputs(", beam", out);
        if (scene->num_beams > 1) fprintf(out, "%d", k + 1);
        fprintf(out, " with .x .y%s .angle .azimuth%s%s%s", beam->inside ? " .z" : "",
                beam->of_tile ? "" : of_shape[beam->shape], beam->light.kind == CML_LIGHT_OF_NA ? " .na" : "",
                scene->num_beams > 1 ? " .share" : "");
    }
}

static void write_detectors(FILE *out, const struct cml_scene *scene)
{
    const int n = scene->num_detectors;
    if (n == 1) fputs(", detector", out);
    if (n > 1) write_owners(out, "detector", 1, n);
    if (n > 0) fputs(" with .x .y .z, what its shape has, and with na= .na .angle .azimuth", out);
}

static void write_names(FILE *out, const struct cml_scene *scene)
{
    fputs("photons, above.n, below.n", out);
    write_media(out, "layer", scene->num_layers, ".n .mua .mus .g .d");
    write_layer_names(out, scene);
    write_media(out, "body", scene->num_bodies, ".n .mua .mus .g");
    for (int l = 1; l <= scene->num_layers; l++) write_phase(out, "layer", l, scene->media[l].phase);
    for (int k = 0; k < scene->num_bodies; k++)
        write_phase(out, "body", k + 1, scene->media[cml_body_medium(scene, k)].phase);
    if (scene->backing.kind == CML_BACKING_METAL)
        fputs(", backing.n, backing.k", out);
    else if (scene->backing.kind != CML_BACKING_NONE)
        fputs(", backing.r", out);
    write_shapes(out, scene);
    write_beams(out, scene);
    write_detectors(out, scene);
}

static cml_status fail_unknown(const struct cml_mci_reader *reader, const struct cml_setting *setting,
                               const struct cml_scene *scene)
{
    char names[600] = "", expected[750];
    FILE *out = fmemopen(names, sizeof names, "w");
    if (out) {
        write_names(out, scene);
        fclose(out);
    }
    snprintf(expected, sizeof expected, "a name that the run in line %d knows: %s%s", scene->line, names,
             setting->column > 0 ? "; a label stands in quotation marks" : "");
    return cml_setting_fail(setting, expected, reader->err);
}

static cml_status set_photons(const struct cml_mci_reader *reader, const struct cml_setting *setting,
                              struct cml_scene *scene)
{
    double photons = 0;
    CML_TRY(set(reader, setting, &(struct cml_mci_number){&photons, &cml_mci_photons_field, 1}));
    scene->photons = (uint64_t)photons;
    return CML_OK;
}

/* Layers may have two names for a number: layer1.mua and gel.mua. place: what the settings before have set.
 */
static cml_status check_once(const struct cml_mci_reader *reader, const struct cml_settings *settings, int i,
                             double *const *place)
{
    char expected[256];
    int k = 0;
    while (k < i && place[k] != place[i]) k++;
    if (k == i) return CML_OK;
    snprintf(expected, sizeof expected, "one value, but %.63s of %.80s has set it to %.30s",
             settings->item[k].name, settings->item[k].source, settings->item[k].value);
    return cml_setting_fail(&settings->item[i], expected, reader->err);
}

cml_status cml_mci_apply_settings(struct cml_mci_reader *reader, struct cml_scene *scene)
{
    const struct cml_settings *settings = reader->options->settings;
    double *place[CML_MOST_SETTINGS] = {NULL};
    for (int i = 0; settings && i < settings->count; i++) {
        const struct cml_setting *setting = &settings->item[i];
        struct cml_mci_number number = {0};
        struct name name;
        if (strcmp(setting->name, cml_mci_photons_field.name) == 0) {
            CML_TRY(set_photons(reader, setting, scene));
            continue;
        }
        const bool sound = split(setting->name, &name);
        if (sound && is_of_shape(scene, &name)) continue;
        if (sound) CML_TRY(find_number(reader, scene, &name, &number));
        if (!number.value) return fail_unknown(reader, setting, scene);
        place[i] = number.value;
        CML_TRY(check_once(reader, settings, i, place));
        CML_TRY(set(reader, setting, &number));
    }
    return CML_OK;
}

int cml_mci_layer_of(const struct cml_scene *scene, const char *text)
{
    struct name name;
    const int medium = split(text, &name) ? medium_of(scene, &name) : -1;
    return medium >= 1 && medium <= scene->num_layers ? medium : 0;
}

/* A copy is asked, as a medium that is asked for a number of its phase function gets a function of its own.
 */
cml_status cml_mci_is_setting(const struct cml_scene *scene, const char *text, bool *known,
                              struct cml_error *err)
{
    struct cml_mci_reader reader = {.err = err};
    struct cml_mci_number number = {0};
    struct cml_scene copy;
    struct name name;
    *known = strcmp(text, cml_mci_photons_field.name) == 0;
    if (*known || !split(text, &name)) return CML_OK;
    *known = is_of_shape(scene, &name);
    if (*known) return CML_OK;
    CML_TRY(cml_scene_copy(scene, &copy, err));
    const cml_status status = find_number(&reader, &copy, &name, &number);
    *known = number.value != NULL;
    cml_scene_clear(&copy);
    return status;
}

bool cml_mci_resembles_setting(const char *text)
{
    static const char *const begins[] = {"above",    "below",   "layer", "body",
                                         "boundary", "backing", "beam",  "detector"},
                             *const short_ones[] = {"n", "g", "d",  "x",  "y",  "z",  "r", "k",
                                                    "w", "h", "na", "r1", "r2", "dx", "dy"},
                             *const long_ones[] = {"photons", "seed",   "mua",   "mus",     "radius",
                                                   "scale",   "height", "angle", "azimuth", "share"};
    struct cml_guess guess = {.word = text, .length = strlen(text)};
    if (strchr(text, '.')) return true;
    for (size_t i = 0; i < sizeof begins / sizeof *begins; i++)
        if (strncasecmp(text, begins[i], strlen(begins[i])) == 0) return true;
    for (size_t i = 0; i < sizeof short_ones / sizeof *short_ones; i++)
        if (strcasecmp(text, short_ones[i]) == 0) return true;
    for (size_t i = 0; i < sizeof long_ones / sizeof *long_ones; i++) cml_guess_offer(&guess, long_ones[i]);
    return cml_guess_best(&guess) != NULL;
}
