/* Reader of `b` and `m` lines, which give a boundary its shape, and of the files that they name.
 * SPDX-License-Identifier: MIT */
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

/* Source of the numbers of a heightfield: the rest of a line, or a whole file. */
struct samples {
    struct cml_mci_reader *reader;
    struct cml_text file; /* file.data NULL: the numbers stand in the .mci file */
    char *cursor;
    const char *owner;
    double *values; /* h0 s0 h1 s1 ... (height, spacing), as many as read */
    size_t num_values;
    double radius; /* radius of the last sample read, cm */
};

/* Refuses a value of a heightfield. The message names the file and line where the value stands, which is the
 * heightfield's own file or the .mci file. */
static cml_status fail_sample(const struct samples *samples, const char *field, const char *value,
                              const char *expected)
{
    if (!samples->file.data)
        return cml_mci_fail(samples->reader, CML_TEXT("%s: %s", samples->owner, field), value, expected);
    return cml_fail_field(samples->reader->err, samples->file.path, samples->file.line, field, value,
                          expected);
}

/* Returns the next word; NULL: none. Numbers in a file may be broken into lines anywhere; in the .mci file
 * they are one line. */
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

/* Appends a number to those read for a heightfield. Memory grows with the numbers really read, so that a
 * wrong n does not fill it. */
static cml_status append(struct samples *samples, double value)
{
    CML_TRY(cml_array_grow(&samples->values, samples->num_values, sizeof value, "a heightfield",
                           samples->reader->err));
    samples->values[samples->num_values++] = value;
    return CML_OK;
}

/* Refuses number i of 2n: a height for even i, a spacing for odd i. */
static cml_status fail_number(const struct samples *samples, size_t i, int n, const char *word,
                              const char *expected)
{
    return fail_sample(samples, CML_TEXT("%c%zu", i % 2 == 0 ? 'h' : 's', i / 2), word,
                       word ? expected : CML_TEXT("2*n = %zu numbers after n, found %zu", 2 * (size_t)n, i));
}

/* Reads number i of the 2n numbers of a radial heightfield: height and spacing in turn. A spacing too small
 * to change the radius in double precision is refused: the ring would have no width. The last spacing has no
 * effect and may be any number. */
static cml_status read_number(struct samples *samples, size_t i, int n)
{
    static const struct cml_key height = {.least = -CML_MCI_HUGE, .most = CML_MCI_HUGE},
                                spacing = {.least = CML_MCI_TINY, .most = CML_MCI_HUGE},
                                last_spacing = {.least = -HUGE_VAL, .most = HUGE_VAL};
    const bool last = i + 1 == 2 * (size_t)n;
    const struct cml_key *key = last ? &last_spacing : i % 2 == 0 ? &height : &spacing;
    double value = 0;
    const char *word = next_word(samples);
    if (!word || !cml_key_parse(key, word, &value))
        return fail_number(samples, i, n, word,
                           last         ? "a number, although the last spacing has no effect"
                           : i % 2 == 0 ? "a height of -1e30..1e30 cm"
                                        : "a spacing of 1e-30..1e30 cm");
    CML_TRY(append(samples, value));
    if (key != &spacing) return CML_OK;
    const double before = samples->radius;
    samples->radius += value;
    if (samples->radius > before && samples->radius <= CML_MCI_HUGE) return CML_OK;
    return fail_number(samples, i, n, word, "a spacing that takes the radius further, up to 1e30 cm");
}

/* Reads n and 2n numbers. Text behind the last number is a comment in the .mci file, as behind all its
 * fields; in a file of nothing but numbers it is a mistake. */
static cml_status read_samples(struct samples *samples, int *n)
{
    const bool in_file = samples->file.data != NULL;
    static const struct cml_key count = {.type = CML_KEY_INT, .least = 1, .most = 1e7};
    double number = 0, surplus = 0;
    const char *word = next_word(samples);
    if (!word || !cml_key_parse(&count, word, &number))
        return fail_sample(samples, "n", word,
                           in_file ? "a whole number of 1..1e7"
                                   : "a whole number of 1..1e7, or a file name in quotes");
    *n = (int)number;
    for (size_t i = 0; i < 2 * (size_t)*n; i++) CML_TRY(read_number(samples, i, *n));
    word = next_word(samples);
    if (!word || (!in_file && !cml_parse_double(word, &surplus))) return CML_OK;
    return fail_sample(samples, "number after the last spacing", word,
                       CML_TEXT("the end, because n = %d takes %zu numbers", *n, 2 * (size_t)*n));
}

/* Makes the radial heightfield of a boundary from the file's pairs "height, spacing": the radius of a sample
 * is the sum of the spacings before. Radii and heights are scaled to cm; `height` of the boundary is a
 * further factor of the heights alone. */
static cml_status sum_radii(const struct samples *samples, struct cml_boundary *boundary)
{
    const size_t n = samples->num_values / 2;
    struct cml_radial *radial = &boundary->radial;
    CML_TRY(cml_zeros(&radial->r, n, sizeof *radial->r, "a heightfield", samples->reader->err));
    CML_TRY(cml_zeros(&radial->h, n, sizeof *radial->h, "a heightfield", samples->reader->err));
    radial->n = (int)n;
    double r = 0;
    for (size_t i = 0; i < n; i++) {
        radial->r[i] = r * boundary->scale;
        radial->h[i] = samples->values[2 * i] * boundary->scale * boundary->height;
        r += samples->values[2 * i + 1];
    }
    return CML_OK;
}

/* Opens the source of the numbers: the line itself, or the file whose name in quotes is all that the line
 * has. */
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
        return fail_sample(samples, "text after the file name", rest, "the end of the line or a comment");
    CML_TRY(cml_path_beside(reader->text.path, name, &boundary->file, reader->err));
    CML_TRY(cml_text_read_table(reader->options->source, boundary->file, &samples->file, reader->err));
    samples->cursor = NULL;
    return CML_OK;
}

/* Reads a heightfield: first all numbers, then, once all are known to be right, its radii and heights. */
static cml_status read_radial(struct cml_mci_reader *reader, int index, struct cml_boundary *boundary)
{
    struct samples samples = {.reader = reader, .owner = CML_TEXT("boundary %d", index)};
    CML_TRY(cml_mci_set_scaling(reader, index, &boundary->scale, &boundary->height));
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

/* The way in which a heightmap is repeated over the plane. The first two have names in the file. */
enum tiling { TILE_MIRRORED, TILE_AS_IS, TILE_PERIODIC, TILE_NONE };
static const char *const tile_names[] = {"mirror", "as-is"};

/* Reads the option `tile` of a line `m`: how a heightmap repeats over the plane. */
static cml_status set_tiling(const struct cml_mci_line *line, enum tiling *tiling)
{
    const int which = line->alone ? TILE_PERIODIC : cml_mci_choose(line->value, tile_names, 2);
    *tiling = (enum tiling)which;
    return which >= 0 ? CML_OK : cml_mci_fail_value(line, "mirror, as-is, or the word tile alone");
}

/* Checks the step between opposite edges of a map: without this check, a map whose edges do not match would
 * be a grating of cliffs. The seam may have the largest of all steps by chance, so up to three times the
 * largest step inside is accepted. Heights are single precision in many files, so steps below a millionth of
 * the relief do not count. */
static cml_status check_seam(const struct cml_mci_line *line, const struct cml_boundary *boundary)
{
    const struct cml_tile_notes *notes = &boundary->tile_notes;
    const double err_height = 1e-6 * (notes->relief.highest - notes->relief.lowest);
    for (int k = 0; k < 2; k++) {
        const double step = notes->seam[k], inside = notes->inside[k];
        if (step <= inside + err_height) continue;
        const char *value =
            CML_TEXT("a step of %g cm across the seam along %c, %g cm inside", step, "xy"[k], inside);
        if (step > 3 * inside + err_height)
            return cml_mci_fail_option(line, "tile", value,
                                       "at most three times the largest step inside; tile=mirror repeats any "
                                       "map, tile=as-is this one");
        cml_mci_note(line->reader, line->reader->text.line,
                     "%s: tile: %s (tile=as-is if that is meant, else tile=mirror)", line->owner, value);
    }
    return CML_OK;
}

/* Makes a boundary of a repeated heightmap. The boundary takes over the heights; triangles are made of them
 * later, when its surface is built. */
static cml_status make_tile(const struct cml_mci_line *line, enum tiling tiling,
                            const struct cml_mesh_file_options *given, struct cml_heightmap *map,
                            struct cml_boundary *boundary)
{
    struct cml_error *err = line->reader->err;
    boundary->form = CML_FORM_TILE;
    boundary->tile_normals = given->normals;
    const cml_status status =
        cml_tile_make(boundary->file, tiling == TILE_MIRRORED, map, &boundary->tile_notes, err);
    boundary->tile = *map;
    *map = (struct cml_heightmap){0};
    CML_TRY(status);
    if (tiling != TILE_AS_IS) CML_TRY(check_seam(line, boundary));
    const struct cml_tile_cells cells = cml_tile_patch_cells(&boundary->tile);
    return cml_mesh_budget_check(&given->budget, 2.0 * cells.count[0] * cells.count[1],
                                 "a coarser map or a larger --mesh-budget", err);
}

/* Refuses options that a heightmap cannot have: its grid runs along x and y, and its mesh has a skirt
 * already. */
static cml_status check_heightmap_options(const struct cml_mci_line *line,
                                          const struct cml_mesh_file_options *given)
{
    static const char *const none[] = {"rotate", "weld", "skirt"},
                             *const expected[] = {"no rotate= for a heightmap",
                                                  "no weld= for a heightmap, whose corners meet",
                                                  "no skirt= for a heightmap, which has one, or needs none"};
    if (given->up != CML_UP_Z && given->up != CML_UP_MINUS_Z)
        return cml_mci_fail_option(line, "up", cml_mci_saw(line, "up"), "z or -z for a heightmap");
    for (int i = 0; i < 3; i++)
        if (cml_mci_saw(line, none[i]))
            return cml_mci_fail_option(line, none[i], cml_mci_saw(line, none[i]), expected[i]);
    return CML_OK;
}

/* Reads a heightmap and makes the boundary's mesh or tile. A tile keeps the heights; a mesh does not need
 * them, and they are freed. */
static cml_status read_heightmap(const struct cml_mci_line *line, enum cml_mci_mesh_file kind,
                                 enum tiling tiling, const struct cml_mesh_file_options *given,
                                 struct cml_boundary *boundary)
{
    const struct cml_input_options *input = line->reader->options;
    struct cml_error *err = line->reader->err;
    const double unit = cml_mci_saw(line, "units") ? given->unit : 0;
    CML_AT_END(cml_heightmap_clear) struct cml_heightmap map = {0};
    CML_TRY(check_heightmap_options(line, given));
    CML_TRY((kind == CML_MCI_FILE_GSF ? cml_gsf_read : cml_esri_read)(input->source, boundary->file, unit,
                                                                      &map, err));
    for (size_t i = 0; i < (size_t)map.nx * (size_t)map.ny; i++) map.h[i] *= given->height;
    cml_heightmap_place(&map, given->scale, given->shift, given->up == CML_UP_MINUS_Z);
    if (tiling != TILE_NONE) return make_tile(line, tiling, given, &map, boundary);
    return cml_heightmap_mesh(&map, input->tolerance, given->normals, &given->budget, &boundary->mesh,
                              &boundary->map_notes, err);
}

/* ---- the options of an m line ---- */

/* Values of the options of an `m` line. */
struct m_line {
    struct cml_mesh_file_options obj;
    struct cml_random_relief relief;
    enum tiling tiling;
};

/* Reads the option `spectrum`. *hurst: 0 for gaussian, else the Hurst exponent. */
static cml_status set_spectrum(const struct cml_mci_line *line, double *hurst)
{
    static const char *const names[] = {"gaussian", "exponential"};
    static const double hursts[] = {0, 0.5};
    static const char fractal[] = "fractal:";
    const int which = cml_mci_choose(line->value, names, 2);
    if (which >= 0) {
        *hurst = hursts[which];
        return CML_OK;
    }
    if (strncmp(line->value, fractal, sizeof fractal - 1) == 0 &&
        cml_mci_parse_list(line->value + sizeof fractal - 1, 1, hurst) && *hurst >= 0.01 && *hurst <= 1)
        return CML_OK;
    return cml_mci_fail_value(line, line->key->noun);
}

/* Reads the options of a line `m` that need their own code: units, spectrum, tile, and the number of points
 * of a random relief, a power of 2 from 16 to 8192. */
static cml_status set_m_option(struct cml_mci_line *line)
{
    struct m_line *m = line->context;
    const char *key = line->key->name;
    uint64_t points = 0;
    if (strcmp(key, "units") == 0) return cml_mci_mesh_units(line, &m->obj);
    if (strcmp(key, "spectrum") == 0) return set_spectrum(line, &m->relief.hurst);
    if (strcmp(key, "tile") == 0 && line->key->group == CML_KEYS_RELIEF && !line->alone)
        return cml_mci_fail_value(line, "the word tile alone");
    if (strcmp(key, "tile") == 0) return set_tiling(line, &m->tiling);
    if (!cml_parse_count(line->value, &points) || points < 16 || points > 8192 ||
        (points & (points - 1)) != 0)
        return cml_mci_fail_value(line, line->key->noun);
    m->relief.points = (int)points;
    return CML_OK;
}

/* Draws a random relief with the wanted statistics, scales it, and makes it a tile that repeats over the
 * plane. */
static cml_status make_relief(const struct cml_mci_line *line, const struct cml_random_relief *relief,
                              const struct cml_mesh_file_options *obj, struct cml_boundary *boundary)
{
    CML_AT_END(cml_heightmap_clear) struct cml_heightmap map = {0};
    CML_TRY(cml_random_relief_make(relief, &map, line->reader->err));
    for (size_t i = 0; i < (size_t)map.nx * (size_t)map.ny; i++) map.h[i] *= obj->height;
    cml_heightmap_place(&map, obj->scale, obj->shift, false);
    CML_TRY(make_tile(line, TILE_PERIODIC, obj, &map, boundary));
    cml_random_relief_measure(&boundary->tile, &boundary->tile_notes.drawn);
    return CML_OK;
}

/* Reads the rest of a line `m gaussian`: the numbers of a random relief, and the word tile. */
static cml_status read_relief(struct cml_mci_line *line, int index, struct m_line *m,
                              struct cml_boundary *boundary)
{
    struct cml_mci_reader *reader = line->reader;
    line->parts = CML_KEY_PARTS({CML_KEYS_RELIEF, &m->relief}, {CML_KEYS_PLACE, &m->obj});
    CML_TRY(cml_mci_leading_numbers(reader, line->owner, line->parts));
    CML_TRY(cml_mci_options(line));
    if (m->tiling == TILE_NONE)
        return cml_mci_fail_option(line, "option", NULL, "the word tile: a drawn relief is repeated");
    CML_TRY(cml_mci_set_scaling(reader, index, &m->obj.scale, &m->obj.height));
    return make_relief(line, &m->relief, &m->obj, boundary);
}

/* Reads a boundary from a file. name: the first word of the line. Options are read before the file, so that a
 * mistake in the line is found before a long read. */
static cml_status read_mesh(struct cml_mci_line *line, int index, const char *name, struct m_line *m,
                            struct cml_boundary *boundary)
{
    struct cml_mci_reader *reader = line->reader;
    struct cml_mesh_file_options *obj = &m->obj;
    enum cml_mci_mesh_file kind = CML_MCI_FILE_MESH;
    line->parts =
        CML_KEY_PARTS({CML_KEYS_MESH, obj}, {CML_KEYS_PLACE, obj}, {CML_KEYS_SHEET, obj}, {CML_KEYS_TILE, m});
    CML_TRY(cml_mci_mesh_name(line, name, &kind));
    CML_TRY(cml_mci_options(line));
    CML_TRY(cml_mci_set_scaling(reader, index, &obj->scale, &obj->height));
    if (m->tiling != TILE_NONE && kind == CML_MCI_FILE_MESH)
        return cml_mci_fail_option(line, "tile", "a mesh", "a .gsf or .asc heightmap");
    CML_TRY(cml_path_beside(reader->text.path, name, &boundary->file, reader->err));
    CML_TRY(kind == CML_MCI_FILE_MESH
                ? cml_mesh_file_read(reader->options->source, boundary->file, obj, &boundary->mesh,
                                     &boundary->mesh_notes, reader->err)
                : read_heightmap(line, kind, m->tiling, obj, boundary));
    if (m->tiling == TILE_NONE) boundary->form = CML_FORM_MESH;
    return CML_OK;
}

/* Reads an `m` line: a boundary that is a mesh, a heightmap or a random relief (`gaussian`). */
static cml_status read_m(struct cml_mci_reader *reader, int index, struct cml_boundary *boundary)
{
    struct m_line m = {.obj = {.unit = 1, .scale = 1, .height = 1, .budget = reader->options->budget},
                       .relief = {.points = 512, .seed = 1},
                       .tiling = TILE_NONE};
    struct cml_mci_line line = {
        .reader = reader, .owner = CML_TEXT("boundary %d", index), .own = set_m_option, .context = &m};
    m.obj.budget.file = reader->text.path;
    m.obj.budget.line = reader->text.line;
    m.obj.budget.boundary = index;
    cml_mci_cut_comment(reader->cursor);
    const char *name = cml_text_word(&reader->cursor);
    CML_TRY(name && strcmp(name, "gaussian") == 0 ? read_relief(&line, index, &m, boundary)
                                                  : read_mesh(&line, index, name, &m, boundary));
    boundary->scale = m.obj.scale;
    boundary->height = m.obj.height;
    return CML_OK;
}

/* Reads the shape of a boundary: of a line `b` (radial heightfield) or `m` (mesh or heightmap). */
static cml_status read_boundary(struct cml_mci_reader *reader, enum cml_mci_kind kind, int index,
                                struct cml_boundary *boundary)
{
    const cml_status status =
        kind == CML_MCI_B ? read_radial(reader, index, boundary) : read_m(reader, index, boundary);
    return cml_mci_name_line(reader, CML_TEXT("boundary %d", index), boundary->file, status);
}

/* A boundary has one shape. With options->flat the shape is checked and dropped. */
cml_status cml_mci_boundary(struct cml_mci_reader *reader, enum cml_mci_kind kind, int index,
                            struct cml_boundary *boundary)
{
    if (boundary->line > 0)
        return cml_mci_fail(
            reader, "line", cml_mci_raw(reader),
            CML_TEXT("one line for boundary %d, which already has line %d", index, boundary->line));
    boundary->line = reader->text.line;
    boundary->scale = boundary->height = 1;
    CML_TRY(cml_share_begin(&boundary->users, reader->err));
    CML_TRY(read_boundary(reader, kind, index, boundary));
    for (int axis = 0; boundary->form == CML_FORM_TILE && axis < 2; axis++)
        boundary->period[axis] = cml_tile_period(&boundary->tile, axis);
    if (reader->options->flat) cml_boundary_flatten(boundary);
    return CML_OK;
}
