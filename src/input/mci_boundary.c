/* Lines b and m, and the files that they name. SPDX-License-Identifier: MIT */
#include "input/mci_boundary.h"

#include "base/array.h"
#include "base/shared.h"
#include "input/mesh/esri.h"
#include "input/mesh/gsf.h"
#include "input/mci_mesh.h"
#include "input/mci_settings.h"
#include "scene/heightmap/random_relief.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- b: a radial heightfield ---- */

/* Where the numbers of a heightfield stand: the rest of a line, or a whole file. */
struct samples {
    struct cml_mci_reader *reader;
    struct cml_text file; /* data NULL when the numbers stand in the .mci */
    char *cursor;
    char owner[32];
    double *values; /* h0 s0 h1 s1 ... as far as read */
    size_t num_values;
    double radius; /* of the sample read last */
};

/* Names the heights' own file and line when the numbers stand in one. */
static cml_status fail_sample(const struct samples *samples, const char *field, const char *value,
                              const char *expected)
{
    char name[80];
    snprintf(name, sizeof name, "%s: %s", samples->owner, field);
    if (!samples->file.data) return cml_mci_fail(samples->reader, name, value, expected);
    return cml_fail_field(samples->reader->err, samples->file.path, samples->file.line, field, value,
                          expected);
}

/* In a file numbers may be broken into lines anywhere; in the .mci they are one line. */
static char *next_word(struct samples *samples)
{
    for (;;) {
        char *word = samples->cursor ? cml_text_word(&samples->cursor) : NULL;
        if (word || !samples->file.data) return word;
        samples->cursor = cml_text_next(&samples->file);
        if (!samples->cursor) return NULL;
        cml_mci_cut_comment(samples->cursor);
    }
}

/* Grows with what was really read, so that a number n without its samples never asks for memory. */
static cml_status append(struct samples *samples, double value)
{
    CML_TRY(cml_array_grow(&samples->values, samples->num_values, sizeof value, "a heightfield",
                           samples->reader->err));
    samples->values[samples->num_values++] = value;
    return CML_OK;
}

/* Refuses number i of 2n: h for even i, s for odd i. */
static cml_status fail_number(const struct samples *samples, size_t i, int n, const char *word,
                              const char *expected)
{
    char name[32], total[96];
    snprintf(name, sizeof name, "%c%zu", i % 2 == 0 ? 'h' : 's', i / 2);
    snprintf(total, sizeof total, "2*n = %zu numbers after n, found %zu", 2 * (size_t)n, i);
    return fail_sample(samples, name, word, word ? expected : total);
}

/* A spacing so small that the radius stays the same in double would make a ring of no width. */
static cml_status read_number(struct samples *samples, size_t i, int n)
{
    static const struct cml_mci_field height = {"h", -CML_MCI_HUGE, CML_MCI_HUGE, false,
                                                "a height of -1e30..1e30 cm"};
    static const struct cml_mci_field spacing = {"s", CML_MCI_TINY, CML_MCI_HUGE, false,
                                                 "a spacing of 1e-30..1e30 cm"};
    static const struct cml_mci_field last_spacing = {"s", -HUGE_VAL, HUGE_VAL, false,
                                                      "a number, although the last spacing has no effect"};
    const struct cml_mci_field *field = i % 2 == 0 ? &height : &spacing;
    if (i + 1 == 2 * (size_t)n) field = &last_spacing;
    double value = 0;
    const char *word = next_word(samples);
    if (!word || !cml_mci_parse(field, word, &value))
        return fail_number(samples, i, n, word, field->expected);
    CML_TRY(append(samples, value));
    if (field != &spacing) return CML_OK;
    const double before = samples->radius;
    samples->radius += value;
    if (samples->radius > before && samples->radius <= CML_MCI_HUGE) return CML_OK;
    return fail_number(samples, i, n, word, "a spacing that takes the radius further, up to 1e30 cm");
}

/* Text behind the last number is a comment in the .mci, as behind all its fields; in a file of nothing but
 * numbers it is a mistake. */
static cml_status read_samples(struct samples *samples, int *n)
{
    const bool in_file = samples->file.data != NULL;
    const struct cml_mci_field field = {"n", 1, 1e7, true,
                                        in_file ? "a whole number of 1..1e7"
                                                : "a whole number of 1..1e7, or a file name in quotes"};
    double number = 0, surplus = 0;
    const char *word = next_word(samples);
    if (!word || !cml_mci_parse(&field, word, &number))
        return fail_sample(samples, field.name, word, field.expected);
    *n = (int)number;
    for (size_t i = 0; i < 2 * (size_t)*n; i++) CML_TRY(read_number(samples, i, *n));
    word = next_word(samples);
    if (!word || (!in_file && !cml_parse_double(word, &surplus))) return CML_OK;
    char expected[80];
    snprintf(expected, sizeof expected, "the end, because n = %d takes %zu numbers", *n, 2 * (size_t)*n);
    return fail_sample(samples, "number after the last spacing", word, expected);
}

/* Files give spacings; all else needs radii. */
static cml_status sum_radii(const struct samples *samples, struct cml_boundary *boundary)
{
    const size_t n = samples->num_values / 2;
    struct cml_radial *radial = &boundary->radial;
    radial->r = malloc(n * sizeof *radial->r);
    radial->h = malloc(n * sizeof *radial->h);
    if (!radial->r || !radial->h)
        return cml_fail_memory(samples->reader->err, (double)(2 * n * sizeof(double)), "a heightfield");
    radial->n = (int)n;
    double r = 0;
    for (size_t i = 0; i < n; i++) {
        radial->r[i] = r * boundary->scale;
        radial->h[i] = samples->values[2 * i] * boundary->scale * boundary->height;
        r += samples->values[2 * i + 1];
    }
    return CML_OK;
}

/* Numbers in the line, or the name of a file in quotes and nothing else. */
static cml_status open_samples(struct samples *samples, struct cml_boundary *boundary)
{
    struct cml_mci_reader *reader = samples->reader;
    samples->cursor = reader->cursor + strspn(reader->cursor, " \t");
    cml_mci_cut_comment(samples->cursor);
    if (*samples->cursor != '"') return CML_OK;
    const char *name = cml_text_word(&samples->cursor);
    const char *rest = cml_text_word(&samples->cursor);
    if (*name == '"' || *name == '\0')
        return fail_sample(samples, "file", name, "a file name in a pair of quotes");
    if (rest)
        return fail_sample(samples, "text after the file name", rest, "the end of the line or a # comment");
    CML_TRY(cml_path_beside(reader->text.path, name, &boundary->file, reader->err));
    CML_TRY(cml_text_read_table(reader->options->source, boundary->file, &samples->file, reader->err));
    samples->cursor = NULL;
    return CML_OK;
}

/* Numbers first, as many as there are; radii and heights when all are known to be right. */
static cml_status read_radial(struct cml_mci_reader *reader, int index, struct cml_boundary *boundary)
{
    struct samples samples = {.reader = reader};
    CML_TRY(cml_mci_set_scaling(reader, index, &boundary->scale, &boundary->height));
    snprintf(samples.owner, sizeof samples.owner, "boundary %d", index);
    boundary->form = CML_FORM_RADIAL;
    int n = 0;
    cml_status status = open_samples(&samples, boundary);
    if (status == CML_OK) status = read_samples(&samples, &n);
    if (status == CML_OK) status = sum_radii(&samples, boundary);
    free(samples.values);
    cml_text_clear(&samples.file);
    return status;
}

/* ---- m: a mesh or a heightmap ---- */

/* Whether a heightmap is repeated, and how. Two have names. */
enum tiling { TILE_MIRRORED, TILE_AS_IS, TILE_PERIODIC, TILE_NONE };
static const char *const tile_names[] = {"mirror", "as-is"};

static cml_status set_tiling(const struct cml_mci_line_options *options, enum tiling *tiling)
{
    const int which = options->alone ? TILE_PERIODIC : cml_mci_choose(options->value, tile_names, 2);
    *tiling = (enum tiling)which;
    return which >= 0 ? CML_OK : cml_mci_fail_value(options, "mirror, as-is, or the word tile alone");
}

/* A map whose ends do not fit would be a grating of cliffs. The largest of all steps may by chance be that of
 * the seam: what is up to three times as large is taken. Heights are single precision in many files: a
 * millionth of the relief is none. */
static cml_status check_seam(const struct cml_mci_line_options *options, const struct cml_boundary *boundary)
{
    const struct cml_tile_notes *notes = &boundary->tile_notes;
    const double err_height = 1e-6 * (notes->relief.highest - notes->relief.lowest);
    char value[120];
    for (int k = 0; k < 2; k++) {
        if (notes->seam[k] <= notes->inside[k] + err_height) continue;
        snprintf(value, sizeof value, "a step of %g cm across the seam along %c, %g cm inside",
                 notes->seam[k], "xy"[k], notes -> inside[k]);
        if (notes->seam[k] > 3 * notes->inside[k] + err_height)
            return cml_mci_fail_option(options, "tile", value,
                                       "at most three times the largest step inside; tile=mirror repeats any "
                                       "map, tile=as-is this one");
        cml_mci_note(options->reader, options->reader->text.line,
                     "%s: tile: %s (tile=as-is if that is meant, else tile=mirror)", options->owner, value);
    }
    return CML_OK;
}

/* The heights become the boundary's; triangles are made of them when it is represented. */
static cml_status make_tile(const struct cml_mci_line_options *options, enum tiling tiling,
                            const struct cml_obj_options *given, struct cml_heightmap *map,
                            struct cml_boundary *boundary)
{
    struct cml_error *err = options->reader->err;
    boundary->form = CML_FORM_TILE;
    boundary->tile_normals = given->normals;
    const cml_status status =
        cml_tile_make(boundary->file, tiling == TILE_MIRRORED, map, &boundary->tile_notes, err);
    boundary->tile = *map;
    *map = (struct cml_heightmap){0};
    CML_TRY(status);
    if (tiling != TILE_AS_IS) CML_TRY(check_seam(options, boundary));
    const struct cml_tile_cells cells = cml_tile_patch_cells(&boundary->tile);
    return cml_mesh_budget_check(&given->budget, 2.0 * cells.count[0] * cells.count[1],
                                 "a coarser map or a larger --mesh-budget", err);
}

/* A heightmap's grid runs along x and y, and has a skirt anyway. */
static cml_status check_heightmap_options(const struct cml_mci_line_options *options,
                                          const struct cml_obj_options *given)
{
    char value[32];
    if (given->up != CML_UP_Z && given->up != CML_UP_MINUS_Z)
        return cml_mci_fail_option(options, "up", cml_mci_up_names[given->up], "z or -z for a heightmap");
    snprintf(value, sizeof value, "%g", options->seen[CML_MCI_MESH_ROTATE] ? given->rotate : given->skirt);
    if (options->seen[CML_MCI_MESH_ROTATE])
        return cml_mci_fail_option(options, "rotate", value, "no rotate= for a heightmap");
    if (options->seen[CML_MCI_MESH_SKIRT])
        return cml_mci_fail_option(options, "skirt", value,
                                   "no skirt= for a heightmap, which has one, or needs none");
    return CML_OK;
}

/* The heights are needed no longer once the mesh is made. */
static cml_status read_heightmap(const struct cml_mci_line_options *options, enum cml_mci_mesh_file kind,
                                 enum tiling tiling, const struct cml_obj_options *given,
                                 struct cml_boundary *boundary)
{
    const struct cml_input_options *input = options->reader->options;
    struct cml_error *err = options->reader->err;
    const double unit = options->seen[CML_MCI_MESH_UNITS] ? given->unit : 0;
    struct cml_heightmap map;
    CML_TRY(check_heightmap_options(options, given));
    CML_TRY((kind == CML_MCI_FILE_GSF ? cml_gsf_read : cml_esri_read)(input->source, boundary->file, unit,
                                                                      &map, err));
    for (size_t i = 0; i < (size_t)map.nx * (size_t)map.ny; i++) map.h[i] *= given->height;
    cml_heightmap_place(&map, given->scale, given->shift, given->up == CML_UP_MINUS_Z);
    const cml_status status = tiling == TILE_NONE
                                  ? cml_heightmap_mesh(&map, input->tolerance, given->normals, &given->budget,
                                                       &boundary->mesh, &boundary->map_notes, err)
                                  : make_tile(options, tiling, given, &map, boundary);
    cml_heightmap_clear(&map);
    return status;
}

static void set_budget(const struct cml_mci_reader *reader, int index, struct cml_mesh_budget *budget)
{
    *budget = reader->options->budget;
    budget->file = reader->text.path;
    budget->line = reader->text.line;
    budget->boundary = index;
}

/* Options are read before the file, so that a mistake in the line is found before a long read. `name`: the
 * line's first word. */
static cml_status read_mesh(struct cml_mci_reader *reader, int index, const char *name,
                            struct cml_boundary *boundary)
{
    char owner[32];
    snprintf(owner, sizeof owner, "boundary %d", index);
    struct cml_mci_line_options options = {
        .reader = reader,
        .owner = owner,
        .keys = {"up", "rotate", "units", "scale", "shift", "normals", "skirt", "tile"},
        .flag = "tile",
        .list = "up=, rotate=, units=, scale=, shift=, normals=, skirt=, tile, tile=mirror or tile=as-is"};
    struct cml_obj_options obj = {.unit = 1, .scale = 1, .height = 1};
    enum cml_mci_mesh_file kind = CML_MCI_FILE_OBJ;
    enum tiling tiling = TILE_NONE;
    CML_TRY(cml_mci_mesh_name(&options, name, &kind));
    for (bool more = true; more;) {
        CML_TRY(cml_mci_next_option(&options, &more));
        if (!more) break;
        CML_TRY(options.key == CML_MCI_MESH_TILE ? set_tiling(&options, &tiling)
                                                 : cml_mci_mesh_option(&options, &obj));
    }
    CML_TRY(cml_mci_set_scaling(reader, index, &obj.scale, &obj.height));
    boundary->scale = obj.scale;
    boundary->height = obj.height;
    if (tiling != TILE_NONE && kind == CML_MCI_FILE_OBJ)
        return cml_mci_fail_option(&options, "tile", "an .obj file", "a .gsf or .asc heightmap");
    CML_TRY(cml_path_beside(reader->text.path, name, &boundary->file, reader->err));
    set_budget(reader, index, &obj.budget);
    if (kind == CML_MCI_FILE_OBJ)
        CML_TRY(cml_obj_read(reader->options->source, boundary->file, &obj, &boundary->mesh,
                             &boundary->mesh_notes, reader->err));
    else
        CML_TRY(read_heightmap(&options, kind, tiling, &obj, boundary));
    if (tiling == TILE_NONE) boundary->form = CML_FORM_MESH;
    return CML_OK;
}

/* ---- m gaussian: a relief that is drawn ---- */

enum { RELIEF_SEED, RELIEF_POINTS, RELIEF_SPECTRUM, RELIEF_SHIFT, RELIEF_NORMALS, RELIEF_TILE };

static cml_status set_spectrum(const struct cml_mci_line_options *options, double *hurst)
{
    static const char *const names[] = {"gaussian", "exponential"};
    static const double hursts[] = {0, 0.5};
    static const char fractal[] = "fractal:";
    const int which = cml_mci_choose(options->value, names, 2);
    if (which >= 0) {
        *hurst = hursts[which];
        return CML_OK;
    }
    if (strncmp(options->value, fractal, sizeof fractal - 1) == 0 &&
        cml_mci_parse_list(options->value + sizeof fractal - 1, 1, hurst) && *hurst >= 0.01 && *hurst <= 1)
        return CML_OK;
    return cml_mci_fail_value(options, "gaussian, exponential, or fractal:H with H of 0.01..1");
}

static cml_status set_relief_option(const struct cml_mci_line_options *options,
                                    struct cml_random_relief *relief, struct cml_obj_options *obj)
{
    static const char *const normals[] = {"face", "vertex"};
    uint64_t number = 0;
    int which = -1;
    switch (options->key) {
    case RELIEF_SEED:
        if (cml_parse_count(options->value, &relief->seed)) return CML_OK;
        return cml_mci_fail_value(options, "a whole number of 0..2^53");
    case RELIEF_POINTS:
        if (!cml_parse_count(options->value, &number) || number < 16 || number > 8192 ||
            (number & (number - 1)) != 0)
            return cml_mci_fail_value(options, "a power of two of 16..8192");
        relief->points = (int)number;
        return CML_OK;
    case RELIEF_SPECTRUM:
        return set_spectrum(options, &relief->hurst);
    case RELIEF_SHIFT:
        if (cml_mci_parse_list(options->value, 3, obj->shift)) return CML_OK;
        return cml_mci_fail_value(options, "x,y,z in cm without blanks");
    case RELIEF_NORMALS:
        which = cml_mci_choose(options->value, normals, 2);
        if (which < 0) return cml_mci_fail_value(options, "face or vertex");
        obj->normals = which == 0 ? CML_NORMALS_FACET : CML_NORMALS_VERTEX;
        return CML_OK;
    default:
        return options->alone ? CML_OK : cml_mci_fail_value(options, "the word tile alone");
    }
}

/* Slope and length stand in front of the options. */
static cml_status read_relief_numbers(const struct cml_mci_line_options *options,
                                      struct cml_random_relief *relief)
{
    static const struct cml_mci_field fields[] = {
        {"rms slope", 1e-4, 10, false, "a number of 1e-4..10"},
        {"length", CML_MCI_TINY, CML_MCI_HUGE, false, "a correlation length of 1e-30..1e30 cm"}};
    double *const values[] = {&relief->slope, &relief->length};
    for (int i = 0; i < 2; i++) {
        const char *word = cml_text_word(&options->reader->cursor);
        if (!word || !cml_mci_parse(&fields[i], word, values[i]))
            return cml_mci_fail_option(options, fields[i].name, word, fields[i].expected);
    }
    return CML_OK;
}

static cml_status make_relief(const struct cml_mci_line_options *options,
                              const struct cml_random_relief *relief, const struct cml_obj_options *obj,
                              struct cml_boundary *boundary)
{
    struct cml_heightmap map;
    CML_TRY(cml_random_relief_make(relief, &map, options->reader->err));
    for (size_t i = 0; i < (size_t)map.nx * (size_t)map.ny; i++) map.h[i] *= obj->height;
    cml_heightmap_place(&map, obj->scale, obj->shift, false);
    const cml_status status = make_tile(options, TILE_PERIODIC, obj, &map, boundary);
    if (status == CML_OK) cml_random_relief_measure(&boundary->tile, &boundary->tile_notes.drawn);
    cml_heightmap_clear(&map);
    return status;
}

/* The word gaussian has been read. */
static cml_status read_relief(struct cml_mci_reader *reader, int index, struct cml_boundary *boundary)
{
    char owner[32];
    snprintf(owner, sizeof owner, "boundary %d", index);
    struct cml_mci_line_options options = {.reader = reader,
                                           .owner = owner,
                                           .keys = {"seed", "points", "spectrum", "shift", "normals", "tile"},
                                           .flag = "tile",
                                           .list = "tile, seed=, points=, spectrum=, shift= or normals="};
    struct cml_random_relief relief = {.points = 512, .seed = 1};
    struct cml_obj_options obj = {.scale = 1, .height = 1};
    CML_TRY(read_relief_numbers(&options, &relief));
    for (bool more = true; more;) {
        CML_TRY(cml_mci_next_option(&options, &more));
        if (more) CML_TRY(set_relief_option(&options, &relief, &obj));
    }
    if (!options.seen[RELIEF_TILE])
        return cml_mci_fail_option(&options, "option", NULL, "the word tile: a drawn relief is repeated");
    CML_TRY(cml_mci_set_scaling(reader, index, &obj.scale, &obj.height));
    boundary->scale = obj.scale;
    boundary->height = obj.height;
    set_budget(reader, index, &obj.budget);
    return make_relief(&options, &relief, &obj, boundary);
}

static cml_status read_m(struct cml_mci_reader *reader, int index, struct cml_boundary *boundary)
{
    cml_mci_cut_comment(reader->cursor);
    const char *name = cml_text_word(&reader->cursor);
    if (name && strcmp(name, "gaussian") == 0) return read_relief(reader, index, boundary);
    return read_mesh(reader, index, name, boundary);
}

static cml_status read_boundary(struct cml_mci_reader *reader, enum cml_mci_kind kind, int index,
                                struct cml_boundary *boundary)
{
    char owner[32];
    snprintf(owner, sizeof owner, "boundary %d", index);
    const cml_status status =
        kind == CML_MCI_B ? read_radial(reader, index, boundary) : read_m(reader, index, boundary);
    return cml_mci_name_line(reader, owner, boundary->file, status);
}

cml_status cml_mci_boundary(struct cml_mci_reader *reader, enum cml_mci_kind kind, int index,
                            struct cml_boundary *boundary)
{
    if (boundary->line > 0) {
        char expected[96];
        snprintf(expected, sizeof expected, "one line for boundary %d, which already has line %d", index,
                 boundary->line);
        return cml_mci_fail(reader, "line", cml_mci_raw(reader), expected);
    }
    boundary->line = reader->text.line;
    boundary->scale = boundary->height = 1;
    CML_TRY(cml_share_begin(&boundary->users, reader->err));
    CML_TRY(read_boundary(reader, kind, index, boundary));
    for (int axis = 0; boundary->form == CML_FORM_TILE && axis < 2; axis++)
        boundary->period[axis] = cml_tile_period(&boundary->tile, axis);
    if (reader->options->flat) cml_boundary_flatten(boundary);
    return CML_OK;
}
