/* The grammar of .mci files: the order of the data lines of original MCML, and where keyword lines may stand
 * between them. A keyword line (beam, m, detector ...) is one that original MCML does not know.
 *
 *     1.0                                 version
 *     2                                   number of runs
 *     a.mco A                             STAGE_NAME   a run begins: name and format
 *     1000, dz dr, nz nr na, layers       STAGE_RUN    keyword lines of the run: beam, map, detector ...
 *     n above                             STAGE_ABOVE
 *     m "top.obj"                         STAGE_LAYERS keyword lines of boundaries, layers, bodies
 *     n mua mus g d                       one line per layer
 *     n below
 *
 * SPDX-License-Identifier: MIT */
#include "input/mci.h"

#include "base/array.h"
#include "input/mci_beam.h"
#include "input/mci_body.h"
#include "input/mci_boundary.h"
#include "input/mci_contact.h"
#include "input/mci_detector.h"
#include "input/mci_lines.h"
#include "input/mci_settings.h"
#include "input/mci_medium.h"
#include "input/mci_mesh.h"
#include "input/mci_options.h"
#include "scene/body/body_place.h"

#include <stdlib.h>
#include <string.h>

#define MAX_CELLS 2147483648.0
/* cm: a layer as thick as this counts as semi-infinite; 1e8 is usual in files */
#define SEMI_INFINITE 1e4

/* The place in the file, which decides the keyword lines that may come before the next data line. */
enum stage {
    STAGE_NAME, /* no keyword lines: a keyword is the name of the run */
    /* keyword lines of the run: beam, map, facets, time, directions, fluence, detector, photons */
    STAGE_RUN,
    STAGE_ABOVE, /* no keyword lines */
    /* b, m, rough; before the first layer face and port, too; behind it i and phase; behind the last one
     * backing, too */
    STAGE_LAYERS
};

/* True for the keyword of a line that concerns the whole run. */
static bool is_of_run(enum cml_mci_kind kind)
{
    return kind >= CML_MCI_BEAM && kind < CML_MCI_KEYWORDS;
}

/* Refuses a keyword line in the wrong place, or an unknown keyword; the message says where it may stand, or
 * which keywords there are. */
static cml_status fail_misplaced(const struct cml_mci_reader *reader, enum cml_mci_kind kind,
                                 const char *instead)
{
    char expected[200], *end = expected;
    if (kind < CML_MCI_KEYWORDS)
        snprintf(expected, sizeof expected, "%s; %s", instead, cml_mci_keywords[kind].place);
    for (int i = 0; kind == CML_MCI_UNKNOWN && i < CML_MCI_KEYWORDS; i++)
        end += sprintf(end, "%s%s",
                       i == 0                     ? ""
                       : i + 1 < CML_MCI_KEYWORDS ? ", "
                                                  : " or ",
                       cml_mci_keywords[i].word);
    if (kind == CML_MCI_UNKNOWN) strcpy(end, " behind #@");
    return cml_mci_fail(reader, "line", cml_mci_raw(reader), expected);
}

/* Refuses a data line of a run that begins with a misspelt keyword ("beem disk 1"): data lines begin with a
 * number. */
static cml_status check_keyword(const struct cml_mci_reader *reader, const char *field)
{
    const char *meant = cml_mci_meant_keyword(reader);
    if (!meant) return CML_OK;
    return cml_mci_fail(reader, "line", cml_mci_raw(reader), CML_TEXT("%s; did you mean %s?", field, meant));
}

/* Keyword lines of a run: the function that reads the line, or the keys that the line has. line: offset of
 * the line's number in the scene, for a line that may stand only once. */
static const struct {
    cml_status (*read)(struct cml_mci_reader *reader, struct cml_scene *scene);
    enum cml_key_group keys;
    size_t base, line;
} run_lines[CML_MCI_KEYWORDS] = {
    [CML_MCI_BEAM] = {.read = cml_mci_beam},
    [CML_MCI_DETECTOR] = {.read = cml_mci_detector},
    [CML_MCI_MAP] = {.read = cml_mci_map, .line = offsetof(struct cml_scene, map.line)},
    [CML_MCI_PHOTONS] = {.read = cml_mci_photons, .line = offsetof(struct cml_scene, saved.line)},
    [CML_MCI_FACETS] = {.line = offsetof(struct cml_scene, facets)},
    [CML_MCI_FLUENCE] = {.keys = CML_KEYS_FLUENCE,
                         .base = offsetof(struct cml_scene, fluence),
                         .line = offsetof(struct cml_scene, fluence.line)},
    [CML_MCI_TIME] = {.keys = CML_KEYS_TIME,
                      .base = offsetof(struct cml_scene, time),
                      .line = offsetof(struct cml_scene, time.line)},
    [CML_MCI_DIRECTIONS] = {.keys = CML_KEYS_DIRECTIONS,
                            .base = offsetof(struct cml_scene, directions),
                            .line = offsetof(struct cml_scene, directions.line)}};

/* Reads a keyword line that concerns the whole run, such as `map` or `time`, by the row of run_lines for its
 * kind. Most lines have only keys, which the table describes; a few have a reader. `line` in the row is the
 * scene's member that remembers the line, so that a second one is refused. */
static cml_status read_run_line(struct cml_mci_reader *reader, enum cml_mci_kind kind,
                                struct cml_scene *scene)
{
    const char *word = cml_mci_keywords[kind].word;
    if (run_lines[kind].line > 0) {
        int *line = (int *)((char *)scene + run_lines[kind].line);
        if (*line)
            return cml_mci_fail(reader, "line", cml_mci_raw(reader), CML_TEXT("one %s line per run", word));
        *line = reader->text.line;
    }
    cml_mci_cut_comment(reader->cursor);
    if (run_lines[kind].read) return run_lines[kind].read(reader, scene);
    if (run_lines[kind].keys == CML_KEYS_NONE)
        return cml_mci_end_line(reader, CML_TEXT("text after %s", word));
    struct cml_mci_line line = {
        .reader = reader,
        .owner = word,
        .parts = CML_KEY_PARTS({run_lines[kind].keys, (char *)scene + run_lines[kind].base})};
    CML_TRY(cml_mci_leading_numbers(reader, word, line.parts));
    return cml_mci_options(&line);
}

/* Goes to the next data line of a run, and reads the keyword lines before it. stage: which keywords may
 * stand here; field: the meaning of the data line, for messages; b: number of the boundary before that line,
 * and of the layer read last. */
static cml_status next_data_line(struct cml_mci_reader *reader, enum stage stage, struct cml_scene *scene,
                                 int b, const char *field)
{
    for (;;) {
        enum cml_mci_kind kind;
        CML_TRY(cml_mci_next(reader, stage != STAGE_NAME, &kind));
        if (kind == CML_MCI_DATA) return stage != STAGE_NAME ? check_keyword(reader, field) : CML_OK;
        if (kind == CML_MCI_END)
            return cml_mci_fail(reader, field, NULL, "a line for it, but the file ends here");
        if (is_of_run(kind) && stage == STAGE_RUN)
            CML_TRY(read_run_line(reader, kind, scene));
        else if ((kind == CML_MCI_B || kind == CML_MCI_M) && stage == STAGE_LAYERS)
            CML_TRY(cml_mci_boundary(reader, kind, b, &scene->boundaries[b]));
        else if (kind == CML_MCI_ROUGH && stage == STAGE_LAYERS)
            CML_TRY(cml_mci_rough_line(reader, b, &scene->boundaries[b].rough));
        else if ((kind == CML_MCI_FACE || kind == CML_MCI_PORT) && stage == STAGE_LAYERS && b == 0)
            CML_TRY(cml_mci_contact(reader, kind == CML_MCI_PORT, scene));
        else if (kind == CML_MCI_I && stage == STAGE_LAYERS && b > 0)
            CML_TRY(cml_mci_body(reader, b, scene));
        else if (kind == CML_MCI_PHASE && stage == STAGE_LAYERS && b > 0 && scene->boundaries[b].line == 0 &&
                 scene->boundaries[b].rough.line == 0)
            CML_TRY(cml_mci_phase(reader, b, scene));
        else if (kind == CML_MCI_BACKING && stage == STAGE_LAYERS && b == scene->num_layers)
            CML_TRY(cml_mci_backing(reader, &scene->backing));
        else
            return fail_misplaced(reader, kind, field);
    }
}

/* Refuses a name of an output that would fail hours later, when the result is written; and one that another
 * run of the file has, because the second run would overwrite the first. */
static cml_status check_output(const struct cml_mci_reader *reader, const struct cml_scene_list *list,
                               const char *name)
{
    const char *wrong = cml_mci_why_no_name(name);
    if (wrong) return cml_mci_fail(reader, "output name", name, wrong);
    for (int i = 0; i < list->count - 1; i++)
        if (strcmp(list->scenes[i].output, name) == 0)
            return cml_mci_fail(
                reader, "output name", name,
                CML_TEXT("another name than that of the run in line %d", list->scenes[i].line));
    return CML_OK;
}

/* Replaces the name of the output by that of --output, whose ending also sets the format. */
static cml_status rename_output(const struct cml_mci_reader *reader, struct cml_scene *scene)
{
    const char *name = reader->options->output, *expected = cml_mci_why_no_name(name);
    if (expected) return cml_fail(reader->err, CML_E_INPUT, "--output %.80s (expected %s)", name, expected);
    free(scene->output);
    scene->output = NULL;
    if (cml_file_ends_in(name, ".h5")) scene->format = 'B';
    if (cml_file_ends_in(name, ".mco")) scene->format = 'A';
    return cml_text_copy(name, &scene->output, reader->err);
}

/* Reads the first line of a run: name and format. The name may be any word, even a keyword (STAGE_NAME). */
static cml_status read_name(struct cml_mci_reader *reader, const struct cml_scene_list *list,
                            struct cml_scene *scene)
{
    CML_TRY(next_data_line(reader, STAGE_NAME, scene, 0, "output name"));
    scene->line = reader->text.line;
    CML_TRY(cml_text_copy(reader->text.path, &scene->file, reader->err));
    const char *name = cml_text_word(&reader->cursor);
    CML_TRY(check_output(reader, list, name));
    CML_TRY(cml_text_copy(name, &scene->output, reader->err));
    cml_mci_cut_comment(reader->cursor); /* not before the name, which may hold a '#' */
    const char *format = cml_text_word(&reader->cursor);
    if (!format || !strchr("AaBb", format[0]) || format[1])
        return cml_mci_fail(reader, "format", format, "A or B");
    scene->format = strchr("Aa", format[0]) ? 'A' : 'B';
    return reader->options->output ? rename_output(reader, scene) : CML_OK;
}

/* Refuses too many cells before any memory is allocated for them. */
static cml_status check_cells(const struct cml_mci_reader *reader, const struct cml_scene *scene)
{
    const double nz = scene->nz, nr = scene->nr, na = scene->na;
    const double cells = nr * nz + 2 * nr * na + nz + 2 * nr + 2 * na;
    if (cells <= MAX_CELLS) return CML_OK;
    return cml_mci_fail(reader, "nz nr na", CML_TEXT("%.0f %.0f %.0f", nz, nr, na),
                        CML_TEXT("at most 2^31 cells in all arrays together, not %.3g (%.3g GiB)", cells,
                                 cells * 8 / 1073741824.0));
}

/* Reads the first data lines of a run: number of photons, sizes of bins (dz dr) and numbers of bins (nz nr
 * na). */
static cml_status read_head(struct cml_mci_reader *reader, struct cml_scene *scene)
{
    CML_TRY(next_data_line(reader, STAGE_RUN, scene, 0, "photons"));
    CML_TRY(cml_mci_numbers(reader, NULL, CML_KEY_PARTS({CML_KEYS_PHOTONS, scene})));
    CML_TRY(next_data_line(reader, STAGE_RUN, scene, 0, "dz dr"));
    CML_TRY(cml_mci_numbers(reader, NULL, CML_KEY_PARTS({CML_KEYS_STEPS, scene})));
    CML_TRY(next_data_line(reader, STAGE_RUN, scene, 0, "nz nr na"));
    CML_TRY(cml_mci_numbers(reader, NULL, CML_KEY_PARTS({CML_KEYS_BINS, scene})));
    return check_cells(reader, scene);
}

/* Reads the number of layers and allocates them. At most 1e5 layers, so that a wrong number cannot ask for
 * all memory. */
static cml_status allocate_layers(struct cml_mci_reader *reader, struct cml_scene *scene)
{
    CML_TRY(next_data_line(reader, STAGE_RUN, scene, 0, "number of layers"));
    const char first = (char)(*reader->cursor | 0x20);
    if (first >= 'a' && first <= 'z')
        return cml_mci_fail(
            reader, "line", cml_mci_raw(reader),
            "number of layers, or a line that begins with a word of `clustermcml help input`");
    CML_TRY(cml_mci_numbers(reader, NULL, CML_KEY_PARTS({CML_KEYS_LAYERS, scene})));
    const size_t layers = (size_t)scene->num_layers;
    CML_TRY(cml_zeros(&scene->media, layers + 2, sizeof *scene->media, "the layers", reader->err));
    return cml_zeros(&scene->boundaries, layers + 1, sizeof *scene->boundaries, "the layers", reader->err);
}

/* Returns how many numbers a line holds; 0 if it holds anything else, too. */
static int numbers_alone(const char *text)
{
    int count = 0;
    for (char *end; strtod(text, &end), end != text; text = end) count++;
    text += strspn(text, " \t\r");
    return *text == '\0' || *text == '#' ? count : 0;
}

/* Reads the refractive index of the medium above or below; these media neither absorb nor scatter. */
static cml_status read_ambient(struct cml_mci_reader *reader, struct cml_scene *scene, bool above)
{
    const char *name = above ? "n above" : "n below";
    CML_TRY(next_data_line(reader, above ? STAGE_ABOVE : STAGE_LAYERS, scene, scene->num_layers, name));
    struct cml_medium_def *medium = &scene->media[above ? 0 : scene->num_layers + 1];
    if (!above && numbers_alone(reader->cursor) == 5)
        return cml_mci_fail(reader, name, cml_mci_raw(reader),
                            "one number; is the number of layers too small?");
    return cml_mci_numbers(reader, NULL,
                           CML_KEY_PARTS({above ? CML_KEYS_N_ABOVE : CML_KEYS_N_BELOW, medium}));
}

/* Reads the line of a layer. Keyword lines of the boundary above it, number layer - 1, may come first. */
static cml_status read_layer(struct cml_mci_reader *reader, struct cml_scene *scene, int layer)
{
    const char *owner = CML_TEXT("layer %d", layer);
    CML_TRY(next_data_line(reader, STAGE_LAYERS, scene, layer - 1, owner));
    if (numbers_alone(reader->cursor) == 1)
        return cml_mci_fail(reader, owner, cml_mci_raw(reader),
                            "n mua mus g d; is the number of layers too large?");
    CML_TRY(cml_mci_layer_name(reader, owner, layer, scene));
    /* read after the lines before: these may add bodies, which moves the array */
    struct cml_medium_def *medium = &scene->media[layer];
    medium->line = reader->text.line;
    return cml_mci_numbers(reader, owner, CML_KEY_PARTS({CML_KEYS_MEDIUM, medium}, {CML_KEYS_LAYER, medium}));
}

/* Reads the layers of a run from the top: the medium above, each layer with its boundary and bodies, the
 * medium below. */
static cml_status read_layers(struct cml_mci_reader *reader, struct cml_scene *scene)
{
    CML_TRY(allocate_layers(reader, scene));
    CML_TRY(read_ambient(reader, scene, true));
    for (int layer = 1; layer <= scene->num_layers; layer++) CML_TRY(read_layer(reader, scene, layer));
    return read_ambient(reader, scene, false);
}

/* mua / mus above which the two numbers may have been swapped: tissue, paint and paper scatter far more than
 * they absorb. Media with mus = 0 are meant so. */
#define SWAPPED 20

/* Notes media whose absorption is so much larger than their scattering that the user may have swapped the
 * two. */
static void note_swapped(const struct cml_mci_reader *reader, const struct cml_scene *scene)
{
    for (int m = 1; m < scene->num_layers + 2 + scene->num_bodies; m++) {
        const struct cml_medium_def *medium = &scene->media[m];
        const bool body = m > scene->num_layers + 1;
        if (medium->mus > 0 && medium->mua > SWAPPED * medium->mus)
            cml_mci_note(reader, medium->line, "%s %d: mua = %g and mus = %g 1/cm (were the two swapped?)",
                         body ? "body" : "layer", body ? m - scene->num_layers - 1 : m, medium->mua,
                         medium->mus);
    }
}

/* Notes layers thicker than 50 cm, which may have been given in mm. A layer without an end has a much larger
 * thickness and is left alone. */
static void note_thickness(const struct cml_mci_reader *reader, const struct cml_scene *scene)
{
    for (int layer = 1; layer <= scene->num_layers; layer++) {
        const double d = scene->media[layer].d;
        if (d > 50 && d < SEMI_INFINITE)
            cml_mci_note(reader, scene->media[layer].line,
                         "layer %d: d = %g cm (lengths are in cm: was it meant in mm?)", layer, d);
    }
}

/* Completes a run after all its lines: applies settings, then checks what concerns several lines. */
static cml_status complete(struct cml_mci_reader *reader, struct cml_scene *scene)
{
    CML_TRY(cml_mci_apply_settings(reader, scene));
    for (int layer = 1; layer <= scene->num_layers; layer++)
        scene->boundaries[layer].z = scene->boundaries[layer - 1].z + scene->media[layer].d;
    note_thickness(reader, scene);
    note_swapped(reader, scene);
    CML_TRY(cml_mci_check_media(reader, scene));
    CML_TRY(cml_mci_check_rough(reader, scene));
    CML_TRY(cml_mci_check_map(reader, scene));
    CML_TRY(cml_mci_end_contacts(reader, scene));
    CML_TRY(cml_mci_check_fluence(reader, scene));
    CML_TRY(cml_mci_check_beams(reader, scene));
    CML_TRY(cml_mci_end_detectors(reader, scene));
    CML_TRY(cml_mci_check_photons(reader, scene));
    free(scene->settings);
    scene->settings = NULL;
    if (!reader->options->settings) return CML_OK;
    return cml_settings_text(reader->options->settings, &scene->settings, reader->err);
}

/* Reads one run. The scene joins the list before it is complete, so that clearing the list frees an
 * incomplete scene. */
static cml_status read_run(struct cml_mci_reader *reader, struct cml_scene_list *list)
{
    CML_TRY(
        cml_array_grow(&list->scenes, (size_t)list->count, sizeof *list->scenes, "the runs", reader->err));
    struct cml_scene *scene = &list->scenes[list->count++];
    *scene = (struct cml_scene){0};
    cml_mci_forget(reader);
    CML_TRY(cml_mci_add_beam(reader, scene));
    CML_TRY(read_name(reader, list, scene));
    CML_TRY(read_head(reader, scene));
    CML_TRY(read_layers(reader, scene));
    CML_TRY(complete(reader, scene));
    CML_TRY(cml_scene_place_bodies(scene, reader->err));
    scene->text = cml_mci_take_kept(reader);
    return CML_OK;
}

/* True if the next word is a format (A or B), which stands behind the name of a run. */
static bool is_format(struct cml_mci_reader *reader)
{
    const char *format = cml_text_word(&reader->cursor);
    return format && strchr("AaBb", format[0]) && !format[1];
}

/* Notes a line behind the last run that could be the first line of a run. */
static void note_run(struct cml_mci_reader *reader, const struct cml_scene_list *list)
{
    const char *name = cml_text_word(&reader->cursor);
    if (!is_format(reader)) return;
    cml_mci_note(reader, reader->text.line,
                 "the run %.100s and what follows it is not read: the number of runs is %d", name,
                 list->count);
}

/* Reads the first line behind the last run. The rest of the file is ignored, as in original MCML: it may be a
 * run switched off by the number of runs, whose name may be a keyword. But a keyword line right behind n
 * below was meant for the last run, and is refused. */
static cml_status check_rest(struct cml_mci_reader *reader, const struct cml_scene_list *list)
{
    enum cml_mci_kind kind;
    CML_TRY(cml_mci_next(reader, true, &kind));
    if (kind == CML_MCI_DATA) note_run(reader, list);
    if (kind == CML_MCI_DATA || kind == CML_MCI_END || (is_of_run(kind) && is_format(reader))) return CML_OK;
    return fail_misplaced(reader, kind, "the end of the run");
}

/* Refuses an unknown version. Input of MCML 2 and 3 begins with mcmli2.0 or mcmli3.0, and describes media,
 * sources and grids differently. */
static cml_status refuse_version(const struct cml_mci_reader *reader, const char *version)
{
    static const char later[] = "mcmli";
    const size_t size = strlen(later);
    const bool is_later = strncmp(version, later, size) == 0 && version[size] >= '2' && version[size] <= '9';
    return cml_mci_fail(
        reader, "file version", version,
        is_later ? CML_TEXT("1.0, the format of MCML 1; this is input of MCML %c, which is not read",
                            version[size])
                 : "a number: 1.0");
}

/* Reads the version. Any number is accepted, because original MCML does not look at it. */
static cml_status read_version(struct cml_mci_reader *reader)
{
    double number;
    CML_TRY(next_data_line(reader, STAGE_NAME, NULL, 0, "file version"));
    cml_mci_cut_comment(reader->cursor);
    const char *version = cml_text_word(&reader->cursor);
    if (cml_parse_double(version, &number)) return CML_OK;
    if (strcmp(version, "A1") == 0)
        return cml_mci_fail(reader, "file version", version,
                            "1.0; this is a result, which plot, compare and merge read");
    if (cml_mesh_file_is_known(reader->text.path))
        return cml_mci_fail(reader, "file version", version,
                            "1.0; this is a mesh, which an m line of a scene names");
    return refuse_version(reader, version);
}

/* Reads a whole .mci file: version, number of runs, the runs, and nothing behind them. --output names one
 * result, so the file must have one run. */
static cml_status read_file(struct cml_mci_reader *reader, struct cml_scene_list *list)
{
    int runs = 0;
    CML_TRY(read_version(reader));
    CML_TRY(next_data_line(reader, STAGE_NAME, NULL, 0, "number of runs"));
    CML_TRY(cml_mci_numbers(reader, NULL, CML_KEY_PARTS({CML_KEYS_RUNS, &runs})));
    if (reader->options->output && runs > 1)
        return cml_fail(reader->err, CML_E_INPUT,
                        "--output %.80s (expected a file with one run; %.400s has %d)",
                        reader->options->output, reader->text.path, runs);
    while (list->count < runs) CML_TRY(read_run(reader, list));
    return check_rest(reader, list);
}

cml_status cml_mci_read(const char *path, const struct cml_input_options *options,
                        struct cml_scene_list *list, struct cml_error *err)
{
    static const struct cml_input_options none;
    CML_AT_END(cml_mci_close) struct cml_mci_reader reader = {0};
    *list = (struct cml_scene_list){0};
    cml_status status = cml_mci_open(path, options ? options : &none, &reader, err);
    if (status == CML_OK) status = read_file(&reader, list);
    if (status != CML_OK) cml_scene_list_clear(list);
    return status;
}

/* ---- a copy of a scene with other numbers ---- */

/* Reads the line of boundary b again, with the file of a mesh or heightmap that it may name. */
static cml_status read_shape(const struct cml_mci_reader *copying, const char *path, int line, int b,
                             struct cml_boundary *boundary)
{
    CML_AT_END(cml_mci_close) struct cml_mci_reader reader = {0};
    enum cml_mci_kind kind;
    cml_boundary_clear(boundary);
    CML_TRY(cml_mci_open(path, copying->options, &reader, copying->err));
    while (reader.text.line + 1 < line) cml_text_next(&reader.text);
    CML_TRY(cml_mci_next(&reader, true, &kind));
    return cml_mci_boundary(&reader, kind, b, boundary);
}

/* Reads those shapes again whose scale or height is set to another value than before. */
static cml_status read_shapes(const struct cml_mci_reader *copying, struct cml_scene *scene)
{
    for (int b = 0; b <= scene->num_layers; b++) {
        struct cml_boundary *boundary = &scene->boundaries[b];
        double scale = boundary->scale, height = boundary->height;
        if (boundary->line == 0) continue;
        CML_TRY(cml_mci_set_scaling(copying, b, &scale, &height));
        if (scale != boundary->scale || height != boundary->height)
            CML_TRY(read_shape(copying, scene->file, boundary->line, b, boundary));
    }
    return CML_OK;
}

cml_status cml_mci_copy(const struct cml_scene *from, const struct cml_input_options *options,
                        struct cml_scene *scene, struct cml_error *err)
{
    struct cml_mci_reader reader = {.options = options, .err = err};
    CML_TRY(cml_scene_copy(from, scene, err));
    cml_status status = options->output ? rename_output(&reader, scene) : CML_OK;
    if (status == CML_OK) status = read_shapes(&reader, scene);
    if (status == CML_OK) status = complete(&reader, scene);
    if (status != CML_OK) cml_scene_clear(scene);
    return status;
}
