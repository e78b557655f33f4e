/* Scenes of the C library. SPDX-License-Identifier: MIT */
#include "api/api_parts.h"

#include "base/text.h"
#include "base/version.h"
#include "options/option_read.h"
#include "options/option_table.h"
#include "simulation/check.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

_Thread_local struct cml_error cml_api_error;

CML_API int clm_api(void)
{
    return CLM_API;
}

CML_API const char *clm_version(void)
{
    return cml_version();
}

CML_API const char *clm_error(void)
{
    for (char *c = cml_api_error.text; *c; c++)
        if (iscntrl((unsigned char)*c)) *c = '?';
    return cml_api_error.text;
}

CML_API void clm_on_note(clm_note *note, void *context)
{
    cml_notes = (struct cml_note_receiver){note, context};
}

/* ---- calls ---- */

/* glibc makes the "C" locale without memory, so that none is freed. */
locale_t cml_api_enter(void)
{
    return uselocale(newlocale(LC_ALL_MASK, "C", (locale_t)0));
}

void cml_api_leave(locale_t *before)
{
    uselocale(*before);
}

/* ---- options ---- */

/* Refuses options that are not the library's. */
static cml_status check_known(const char *word, bool reads, struct cml_error *err)
{
    const struct cml_option *option = cml_option_find(word, strcspn(word, "="));
    const unsigned taken = option ? option->commands & (CML_OPTION_OF_FLIGHT | CML_OPTION_OF_READING) : 0;
    if (!taken)
        return cml_fail(err, CML_E_INPUT, "%s (expected an option of a run that needs no files)", word);
    if (!reads && taken == CML_OPTION_OF_READING)
        return cml_fail(err, CML_E_INPUT, "%s (expected among the options with which the scene is read)",
                        word);
    return CML_OK;
}

static cml_status add_word(struct cml_api_words *words, const char *prefix, const char *text,
                           struct cml_error *err)
{
    CML_TRY(cml_text_format(&words->word[words->count], "an option", err, "%s%s", prefix, text));
    words->count++;
    return CML_OK;
}

cml_status cml_api_parse(const char *path, const struct cml_api_words *before, const char *const *options,
                         bool reads, struct cml_api_words *words, struct cml_options *parsed,
                         struct cml_error *err)
{
    int count = before ? before->count : 1;
    for (int i = 0; options && options[i]; i++) count++;
    *words = (struct cml_api_words){.word = calloc((size_t)count + 1, sizeof(char *))};
    if (!words->word) return cml_fail_memory(err, 8.0 * count, "options");
    CML_TRY(add_word(words, path[0] == '-' ? "./" : "", path, err));
    for (int i = 1; before && i < before->count; i++) CML_TRY(add_word(words, "", before->word[i], err));
    for (; options && *options; options++) {
        CML_TRY(check_known(*options, reads, err));
        CML_TRY(add_word(words, "", *options, err));
    }
    cml_options_default(parsed);
    parsed->operands = words->word;
    parsed->engine_options.on_note = cml_show_note;
    return cml_options_read((const char *const *)words->word + 1, parsed, err);
}

void cml_api_words_clear(struct cml_api_words *words)
{
    for (int i = 0; i < words->count; i++) free(words->word[i]);
    free(words->word);
    *words = (struct cml_api_words){0};
}

/* ---- settings ---- */

static void free_settings(struct cml_settings *settings)
{
    for (int i = 0; settings && i < settings->count; i++) free((char *)(uintptr_t)settings->item[i].value);
    free(settings);
}

/* Returns in *copy the settings with values of their own. */
static cml_status copy_settings(const struct cml_settings *from, struct cml_settings **copy,
                                struct cml_error *err)
{
    struct cml_settings *to = *copy = calloc(1, sizeof *to);
    if (!to) return cml_fail_memory(err, sizeof *to, "settings");
    for (int i = 0; i < from->count; i++) {
        char *value = NULL;
        CML_TRY(cml_text_copy(from->item[i].value, &value, err));
        to->item[i] = from->item[i];
        to->item[i].value = value;
        to->count++;
    }
    return CML_OK;
}

/* Sets one value of settings that own their values. */
static cml_status put(struct cml_settings *settings, const char *name, const char *value,
                      struct cml_error *err)
{
    struct cml_setting setting = {.source = "clm_scene_set"};
    struct cml_setting *item = (struct cml_setting *)(uintptr_t)cml_settings_find(settings, name);
    char *copy = NULL;
    CML_TRY(cml_text_copy(value, &copy, err));
    if (item) {
        free((char *)(uintptr_t)item->value);
        item->value = copy;
        item->source = setting.source;
        return CML_OK;
    }
    snprintf(setting.name, sizeof setting.name, "%s", name);
    setting.value = copy;
    const cml_status status = cml_settings_copy(settings, &setting, err);
    if (status != CML_OK) free(copy);
    return status;
}

const struct cml_settings *cml_api_settings(const struct clm_scene *scene, int run)
{
    return scene->settings[run] ? scene->settings[run] : &scene->options.settings;
}

cml_status cml_api_check_run(const struct clm_scene *scene, int run, struct cml_error *err)
{
    if (run >= 0 && run < scene->list.count) return CML_OK;
    return cml_fail(err, CML_E_INPUT, "run %d (expected 0 to %d)", run, scene->list.count - 1);
}

/* True if a scene still has the shapes that its surfaces were made for. */
static bool has_same_shapes(const struct cml_scene *one, const struct cml_scene *other)
{
    for (int b = 0; b <= one->num_layers; b++)
        if (one->boundaries[b].users != other->boundaries[b].users) return false;
    return one->bodies == other->bodies;
}

/* Sets the texts of `count` numbers at once. */
static cml_status set(struct clm_scene *scene, int run, int count, const char *const *name,
                      const char *const *value, struct cml_error *err)
{
    struct cml_settings *settings = NULL;
    struct cml_scene changed;
    CML_TRY(cml_api_check_run(scene, run, err));
    cml_status status = copy_settings(cml_api_settings(scene, run), &settings, err);
    for (int i = 0; status == CML_OK && i < count; i++) status = put(settings, name[i], value[i], err);
    if (status == CML_OK)
        status = cml_copy_scene(&scene->options, settings, NULL, &scene->inputs, &scene->list.scenes[run],
                                &changed, err);
    if (status != CML_OK) {
        free_settings(settings);
        return status;
    }
    if (!has_same_shapes(&scene->list.scenes[run], &changed)) cml_surfaces_free(&scene->surfaces[run]);
    cml_scene_clear(&scene->list.scenes[run]);
    free_settings(scene->settings[run]);
    scene->list.scenes[run] = changed;
    scene->settings[run] = settings;
    return CML_OK;
}

CML_API int clm_scene_set(struct clm_scene *scene, int run, const char *name, const char *value)
{
    CML_API_CALL();
    return set(scene, run, 1, &name, &value, &cml_api_error);
}

enum { DIGITS = 32 }; /* size of a number as text */

CML_API int clm_scene_set_numbers(struct clm_scene *scene, int run, int count, const char *const *name,
                                  const double *value)
{
    char digits[CML_MOST_SETTINGS][DIGITS];
    const char *text[CML_MOST_SETTINGS];
    CML_API_CALL();
    if (count < 0 || count > CML_MOST_SETTINGS)
        return cml_fail(&cml_api_error, CML_E_INPUT, "%d numbers (expected at most %d)", count,
                        CML_MOST_SETTINGS);
    for (int i = 0; i < count; i++) {
        snprintf(digits[i], DIGITS, "%.17g", value[i]);
        text[i] = digits[i];
    }
    return set(scene, run, count, name, text, &cml_api_error);
}

CML_API int clm_scene_set_number(struct clm_scene *scene, int run, const char *name, double value)
{
    return clm_scene_set_numbers(scene, run, 1, &name, &value);
}

/* ---- scenes ---- */

static cml_status load(struct clm_scene *scene, struct cml_error *err)
{
    const struct cml_text_source record = cml_inputs_recorder(&scene->inputs);
    CML_TRY(cml_load_scenes(&scene->options, &record, &scene->list, err));
    const size_t count = (size_t)scene->list.count;
    CML_TRY(cml_zeros(&scene->settings, count, sizeof *scene->settings, "runs", err));
    return cml_zeros(&scene->surfaces, count, sizeof *scene->surfaces, "runs", err);
}

/* Reads a scene. ready: its options; NULL: they are path and options. text: what the file would hold; NULL:
 * it is read. */
static cml_status open_scene(const struct cml_options *ready, const char *path, const char *text,
                             const char *const *options, struct clm_scene **out, struct cml_error *err)
{
    cml_status status = CML_OK;
    struct clm_scene *scene = *out = calloc(1, sizeof *scene);
    if (!scene) return cml_fail_memory(err, sizeof *scene, "a scene");
    if (ready)
        scene->options = *ready;
    else
        status = cml_api_parse(path, NULL, options, true, &scene->words, &scene->options, err);
    scene->flown = scene->options.engine_options;
    if (status == CML_OK && text) status = cml_inputs_add(&scene->inputs, path, text, strlen(text), err);
    if (status == CML_OK) status = load(scene, err);
    if (status == CML_OK) return CML_OK;
    clm_scene_free(scene);
    *out = NULL;
    return status;
}

cml_status cml_api_open(const struct cml_options *options, struct clm_scene **scene, struct cml_error *err)
{
    return open_scene(options, NULL, NULL, NULL, scene, err);
}

CML_API int clm_scene_open(const char *path, const char *const *options, struct clm_scene **scene)
{
    CML_API_CALL();
    return open_scene(NULL, path, NULL, options, scene, &cml_api_error);
}

CML_API int clm_scene_parse(const char *text, const char *beside, const char *const *options,
                            struct clm_scene **scene)
{
    CML_FREED char *path = NULL;
    CML_API_CALL();
    *scene = NULL;
    CML_TRY(cml_text_format(&path, "a path", &cml_api_error, "%s%sscene.mci", beside ? beside : "",
                            beside ? "/" : ""));
    return open_scene(NULL, path, text, options, scene, &cml_api_error);
}

CML_API void clm_scene_free(struct clm_scene *scene)
{
    if (!scene) return;
    for (int i = 0; scene->surfaces && i < scene->list.count; i++) {
        free_settings(scene->settings[i]);
        cml_surfaces_free(&scene->surfaces[i]);
    }
    free(scene->settings);
    free(scene->surfaces);
    cml_scene_list_clear(&scene->list);
    cml_inputs_clear(&scene->inputs);
    cml_api_words_clear(&scene->words);
    free(scene->text);
    free(scene);
}

void cml_api_close(struct clm_scene **scene)
{
    clm_scene_free(*scene);
}

cml_status cml_api_take(int status, struct cml_error *err)
{
    if (status != CLM_OK) *err = cml_api_error;
    return (cml_status)status;
}

CML_API int clm_scene_runs(const struct clm_scene *scene)
{
    return scene->list.count;
}

/* ---- a scene without a flight ---- */

/* Prints the exact totals of a run with planes in place of its shapes. */
static cml_status solve(FILE *stream, const struct cml_options *options, const struct cml_scene *scene,
                        struct cml_error *err)
{
    /* about a second of walks at each rough boundary gives errors of some 1e-4 */
    const struct cml_exact_options aim = {.tolerance = 1e-7, .most_work = 1e11, .walks = 524288};
    CML_AT_END(cml_exact_clear) struct cml_exact exact = {0};
    CML_TRY(cml_exact_scene(scene, NULL, &aim, &exact, err));
    if (options->json) return cml_report_exact_json(stream, scene, &exact, err);
    cml_report_exact(stream, scene, &exact);
    return CML_OK;
}

/* Makes the text of a run. On failure *text is what was printed before. */
static cml_status tell(struct clm_scene *scene, int run, bool exact, int json, const char **text,
                       struct cml_error *err)
{
    size_t size;
    struct cml_options options = scene->options, flown;
    *text = "";
    CML_TRY(cml_api_check_run(scene, run, err));
    free(scene->text);
    scene->text = NULL;
    FILE *stream = open_memstream(&scene->text, &size);
    if (!stream) return cml_fail_memory(err, 1, "a text");
    options.json = json;
    flown = options;
    flown.engine_options = scene->flown;
    const struct cml_scene *one = &scene->list.scenes[run];
    const cml_status status = exact ? solve(stream, &options, one, err)
                                    : cml_check_scene(stream, &options, &flown, one, &scene->sweep, err);
    if (fclose(stream) != 0) return cml_fail_memory(err, 1, "a text");
    *text = scene->text;
    return status;
}

CML_API int clm_scene_check(struct clm_scene *scene, int run, int json, const char **text)
{
    CML_API_CALL();
    return tell(scene, run, false, json, text, &cml_api_error);
}

CML_API int clm_scene_exact(struct clm_scene *scene, int run, int json, const char **text)
{
    CML_API_CALL();
    return tell(scene, run, true, json, text, &cml_api_error);
}
