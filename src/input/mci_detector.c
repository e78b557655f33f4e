/* Reader of the lines that ask for results with words of their own: detector, map and photons.
 * SPDX-License-Identifier: MIT */
#include "input/mci_detector.h"

#include "base/array.h"
#include "boundary.h"
#include "input/mci_contact.h"
#include "input/mci_options.h"

#include <stdlib.h>
#include <string.h>

#define MOST_DETECTORS 32767

/* ---- keys of a detector ---- */

static const struct {
    const char *name;
    enum cml_detector_shape shape;
    enum cml_key_group keys;
} shapes[] = {{"disk", CML_DETECTOR_RING, CML_KEYS_DETECTOR_DISK},
              {"ring", CML_DETECTOR_RING, CML_KEYS_DETECTOR_RING},
              {"rectangle", CML_DETECTOR_RECTANGLE, CML_KEYS_DETECTOR_RECTANGLE},
              {"map", CML_DETECTOR_MAP, CML_KEYS_DETECTOR_MAP},
              {"port", CML_DETECTOR_PORT, CML_KEYS_NONE}};
enum { NUM_SHAPES = sizeof shapes / sizeof *shapes };

void cml_mci_detector_parts(struct cml_detector_def *detector, struct cml_key_part *part)
{
    int s = detector->ring ? 1 : 0;
    while (shapes[s].shape != detector->shape) s++;
    if (!detector->port) *part++ = (struct cml_key_part){CML_KEYS_DETECTOR, detector};
    if (!detector->port) *part++ = (struct cml_key_part){shapes[s].keys, detector};
    if (detector->aimed) *part++ = (struct cml_key_part){CML_KEYS_AIM, detector};
    *part = (struct cml_key_part){CML_KEYS_NONE, NULL};
}

/* ---- shapes ---- */

/* Refuses a ring whose inner radius is not smaller than its outer one. */
static cml_status check_radii(const struct cml_mci_line *line, const double *radius)
{
    if (radius[0] < radius[1]) return CML_OK;
    return cml_mci_fail_option(line, "r1 r2", CML_TEXT("%g %g", radius[0], radius[1]), "r1 < r2");
}

/* Reads the shape of a detector and its numbers. word: the name of the shape. */
static cml_status read_shape(const struct cml_mci_line *line, const char *word,
                             struct cml_detector_def *detector)
{
    int s = 0;
    while (s < NUM_SHAPES && !(word && strcmp(shapes[s].name, word) == 0)) s++;
    if (s == NUM_SHAPES)
        return cml_mci_fail_option(line, "shape", word,
                                   detector->table
                                       ? "disk R, ring R1 R2, rectangle W H, map NX NY DX DY or port NAME"
                                       : "disk R, ring R1 R2, rectangle W H, map NX NY DX DY, port NAME or "
                                         "table \"FILE\"");
    detector->shape = shapes[s].shape;
    detector->ring = s == 1;
    detector->nx = detector->ny = 1;
    if (detector->shape == CML_DETECTOR_PORT) return cml_mci_take_port(line, &detector->port);
    CML_TRY(cml_mci_leading_numbers(line->reader, line->owner, CML_KEY_PARTS({shapes[s].keys, detector})));
    return detector->shape == CML_DETECTOR_RING ? check_radii(line, detector->size) : CML_OK;
}

/* ---- options ---- */

/* Stores the value of a detector's keys that need their own code: names, and the side it lies on. */
static cml_status set_own(struct cml_mci_line *line)
{
    static const char *const sides[] = {"top", "bottom"};
    struct cml_detector_def *detector = line->context;
    if (strcmp(line->key->name, "name") == 0) return cml_mci_take_name(line, &detector->name);
    if (strcmp(line->key->name, "group") == 0) {
        CML_FREED char *group = NULL;
        CML_TRY(cml_mci_take_name(line, &group));
        strcpy(detector->group, group);
        return CML_OK;
    }
    const int side = cml_mci_choose(line->value, sides, 2);
    detector->below = side == 1;
    return side >= 0 ? CML_OK : cml_mci_fail_value(line, line->key->noun);
}

/* ---- the line ---- */

/* Appends an empty detector to the scene. */
static cml_status add_detector(struct cml_mci_reader *reader, struct cml_scene *scene)
{
    const int n = scene->num_detectors;
    if (n == MOST_DETECTORS) return cml_mci_fail(reader, "detector", "32768", "at most 32767 detectors");
    CML_TRY(cml_array_grow(&scene->detectors, (size_t)n, sizeof *scene->detectors, "detectors", reader->err));
    scene->detectors[scene->num_detectors++] = (struct cml_detector_def){.line = reader->text.line};
    return CML_OK;
}

/* Reads one detector, whose line begins with `word`. in: the .mci file, if `reader` reads a table of
 * detectors; else NULL. */
static cml_status read_one(struct cml_mci_reader *reader, char *word, const struct cml_mci_reader *in,
                           struct cml_scene *scene)
{
    CML_TRY(add_detector(reader, scene));
    struct cml_detector_def *detector = &scene->detectors[scene->num_detectors - 1];
    if (in) {
        detector->line = in->text.line;
        detector->row = reader->text.line;
        CML_TRY(cml_text_copy(reader->text.path, &detector->table, reader->err));
    }
    struct cml_mci_line line = {.reader = reader,
                                .owner = "detector",
                                .parts = CML_KEY_PARTS({CML_KEYS_DETECTOR, detector},
                                                       {CML_KEYS_AIM, detector}, {CML_KEYS_SIGHT, detector}),
                                .own = set_own,
                                .context = detector};
    CML_TRY(read_shape(&line, word, detector));
    const struct cml_key_part *of_port = CML_KEY_PARTS({CML_KEYS_AIM, detector}, {CML_KEYS_SIGHT, detector});
    if (detector->port) line.parts = of_port;
    CML_TRY(cml_mci_options(&line));
    detector->at_z = cml_mci_saw(&line, "z") != NULL;
    detector->aimed = cml_mci_saw(&line, "na") != NULL;
    if (!detector->aimed && (cml_mci_saw(&line, "angle") || cml_mci_saw(&line, "azimuth")))
        return cml_mci_fail_option(&line, cml_mci_saw(&line, "angle") ? "angle" : "azimuth", "without na",
                                   "na= beside it: else all directions are seen");
    return CML_OK;
}

/* Context of the reader of a table of detectors. */
struct table {
    const struct cml_mci_reader *in;
    struct cml_scene *scene;
};

/* Reads a file of detectors, one in each row. */
static cml_status read_rows(struct cml_mci_reader *rows, void *context)
{
    const struct table *table = context;
    const int before = table->scene->num_detectors;
    while (cml_mci_next_row(rows))
        CML_TRY(read_one(rows, cml_text_word(&rows->cursor), table->in, table->scene));
    return table->scene->num_detectors > before
               ? CML_OK
               : cml_mci_fail(rows, "rows", "0", "a detector in each, one at least");
}

cml_status cml_mci_detector(struct cml_mci_reader *reader, struct cml_scene *scene)
{
    struct table table = {reader, scene};
    char *word = cml_text_word(&reader->cursor);
    if (!word || strcmp(word, "table") != 0) return read_one(reader, word, NULL, scene);
    const char *name = cml_text_word(&reader->cursor);
    CML_TRY(cml_mci_end_line(reader, "detector: text after the file"));
    return cml_mci_table(reader, "detector", name, "the name of a file with a detector in each line",
                         read_rows, &table);
}

/* Returns the file that describes a detector: a table, or the scene's. */
static const char *file_of(const struct cml_scene *scene, const struct cml_detector_def *detector)
{
    return detector->table ? detector->table : scene->file;
}

/* Returns the line of this file. */
static int line_of(const struct cml_detector_def *detector)
{
    return detector->table ? detector->row : detector->line;
}

/* Refuses a value of detector k, with the line of the scene or the row of the table that it comes from. */
static cml_status fail_detector(const struct cml_mci_reader *reader, const struct cml_scene *scene, int k,
                                const char *field, const char *value, const char *expected)
{
    const struct cml_detector_def *d = &scene->detectors[k];
    return cml_fail_field(reader->err, file_of(scene, d), line_of(d), field, value, expected);
}

/* ---- checks of several lines ---- */

/* Fills in the plane and the name of a detector that has none: the surface that it looks at, and its number
 * from 1. */
static cml_status fill_in(const struct cml_mci_reader *reader, struct cml_scene *scene, int k)
{
    struct cml_detector_def *detector = &scene->detectors[k];
    if (!detector->at_z) detector->z = scene->boundaries[detector->below ? scene->num_layers : 0].z;
    if (detector->shape == CML_DETECTOR_RING && detector->size[0] >= detector->size[1])
        return fail_detector(reader, scene, k, "detector: r1 r2",
                             CML_TEXT("%g %g", detector->size[0], detector->size[1]), "r1 < r2");
    CML_TRY(cml_mci_find_port(reader, scene, detector->port, "detector", file_of(scene, detector),
                              line_of(detector), &detector->contact));
    if (detector->contact) {
        const struct cml_contact_def *port = &scene->contacts[detector->contact - 1];
        memcpy(detector->size, port->size, sizeof port->size);
        detector->round = port->shape == CML_DETECTOR_RING;
        detector->x = port->x;
        detector->y = port->y;
    }
    if (detector->name) return CML_OK;
    return cml_text_copy(detector->port ? detector->port : CML_TEXT("%d", k + 1), &detector->name,
                         reader->err);
}

/* Makes the group of detector k, behind all other detectors. */
static cml_status add_group(const struct cml_mci_reader *reader, struct cml_scene *scene, int k)
{
    const int n = scene->num_detectors;
    if (n == MOST_DETECTORS)
        return fail_detector(reader, scene, k, "detector: group", scene->detectors[k].group,
                             "at most 32767 detectors and groups");
    CML_TRY(cml_array_grow(&scene->detectors, (size_t)n, sizeof *scene->detectors, "detectors", reader->err));
    const struct cml_detector_def *member = &scene->detectors[k];
    struct cml_detector_def *group = &scene->detectors[n];
    *group = (struct cml_detector_def){
        .shape = CML_DETECTOR_GROUP, .below = member->below, .line = member->line, .row = member->row};
    scene->num_detectors++;
    scene->num_groups++;
    if (member->table) CML_TRY(cml_text_copy(member->table, &group->table, reader->err));
    return cml_text_copy(member->group, &group->name, reader->err);
}

/* Puts detector k into its group. A copy of a scene has its groups. */
static cml_status join_group(const struct cml_mci_reader *reader, struct cml_scene *scene, int k)
{
    const char *name = scene->detectors[k].group;
    int g = cml_num_areas(scene);
    if (!*name || scene->detectors[k].in_group) return CML_OK;
    while (g < scene->num_detectors && strcmp(scene->detectors[g].name, name) != 0) g++;
    if (g == scene->num_detectors) CML_TRY(add_group(reader, scene, k));
    struct cml_detector_def *detector = &scene->detectors[k];
    detector->in_group = g + 1;
    if (detector->below == scene->detectors[g].below) return CML_OK;
    return fail_detector(reader, scene, k, "detector: group", detector->group,
                         "a group whose detectors all lie on one side");
}

/* Orders detectors by name, then by line, for qsort. */
static int compare_names(const void *a, const void *b)
{
    const struct cml_detector_def *const *one = a, *const *other = b;
    const int order = strcmp((*one)->name, (*other)->name);
    /* pointers into one array: equal names stay in the order of lines */
    return order ? order : (*one > *other) - (*one < *other);
}

/* Refuses two detectors, or a detector and a group, of one name. */
static cml_status check_names(const struct cml_mci_reader *reader, const struct cml_scene *scene)
{
    if (scene->num_detectors < 2) return CML_OK;
    const size_t n = (size_t)scene->num_detectors;
    CML_FREED const struct cml_detector_def **sorted = NULL;
    CML_TRY(cml_zeros(&sorted, n, sizeof *sorted, "detectors", reader->err));
    for (size_t i = 0; i < n; i++) sorted[i] = &scene->detectors[i];
    qsort(sorted, n, sizeof *sorted, compare_names);
    for (size_t i = 1; i < n; i++) {
        const struct cml_detector_def *first = sorted[i - 1];
        if (strcmp(first->name, sorted[i]->name) != 0) continue;
        return fail_detector(
            reader, scene, (int)(sorted[i] - scene->detectors),
            sorted[i]->shape == CML_DETECTOR_GROUP ? "detector: group" : "detector: name", sorted[i]->name,
            CML_TEXT("another name than that of the detector in line %d%s%.300s", line_of(first),
                     first->table ? " of " : "", first->table ? first->table : ""));
    }
    return CML_OK;
}

/* Each pixel needs a sum and a sum of squares, hence 2^31 cells at most. */
cml_status cml_mci_end_detectors(const struct cml_mci_reader *reader, struct cml_scene *scene)
{
    const double most = 2147483648.0;
    double pixels = 0;
    if (scene->num_detectors == 0) return CML_OK;
    for (int k = 0; k < cml_num_areas(scene); k++) {
        CML_TRY(fill_in(reader, scene, k));
        CML_TRY(join_group(reader, scene, k));
        const struct cml_detector_def *detector = &scene->detectors[k];
        if (detector->shape == CML_DETECTOR_MAP) pixels += 2.0 * detector->nx * detector->ny;
        if (pixels > most)
            return fail_detector(reader, scene, k, "detector: nx ny",
                                 CML_TEXT("%d %d", detector->nx, detector->ny),
                                 "at most 2^30 pixels in all detectors together");
    }
    return check_names(reader, scene);
}

/* ---- map, photons and fluence ---- */

/* `top` has an effect only with `volume`; without it the line is refused, because its writer would not
 * notice. */
cml_status cml_mci_map(struct cml_mci_reader *reader, struct cml_scene *scene)
{
    struct cml_map_def *map = &scene->map;
    struct cml_mci_line line = {.reader = reader,
                                .owner = "map",
                                .parts = CML_KEY_PARTS({CML_KEYS_MAP, map}, {CML_KEYS_VOLUME, map})};
    CML_TRY(cml_mci_leading_numbers(reader, "map", line.parts));
    CML_TRY(cml_mci_options(&line));
    if (map->volume || !cml_mci_saw(&line, "top")) return CML_OK;
    return cml_mci_fail_option(&line, "top", cml_mci_saw(&line, "top"), "volume beside it");
}

/* Refuses a fluence or gates with too many bins. Each of the 64 batches has bins of its own, those beyond the
 * grid included, and the bins of all batches are counted in 32 bits (kernels/marks.h). The bins of radius and
 * time have the same limit. */
cml_status cml_mci_check_fluence(const struct cml_mci_reader *reader, const struct cml_scene *scene)
{
    const double bins = (scene->nr + 1.0) * (scene->nz + 2.0), most = 67108863;
    const double gated = (double)scene->nr * scene->nz * scene->time.gates, most_gated = 1048576;
    if (scene->fluence.times && scene->time.gates == 0)
        return cml_fail_field(reader->err, scene->file, scene->fluence.line, "fluence", "time",
                              "a time line in the same run");
    if (scene->fluence.times && gated > most_gated)
        return cml_fail_field(reader->err, scene->file, scene->fluence.line, "fluence time: nz nr gates",
                              CML_TEXT("%d %d %d", scene->nz, scene->nr, scene->time.gates),
                              "at most 1048576 bins of r, z and time, nz times nr times gates");
    if (scene->time.radii && (scene->nr + 1.0) * (scene->time.gates + 1.0) > most)
        return cml_fail_field(reader->err, scene->file, scene->time.line, "time: nr gates",
                              CML_TEXT("%d %d", scene->nr, scene->time.gates),
                              "at most 67108863 bins, (nr + 1) times (gates + 1)");
    if (!scene->fluence.line || bins <= most) return CML_OK;
    return cml_fail_field(reader->err, scene->file, scene->fluence.line, "fluence: nz nr",
                          CML_TEXT("%d %d", scene->nz, scene->nr),
                          "at most 67108863 bins, (nz + 2) times (nr + 1)");
}

/* Reads a `photons` line. The name must be one that an output may have, without a folder, because the file
 * lies beside the result. */
cml_status cml_mci_photons(struct cml_mci_reader *reader, struct cml_scene *scene)
{
    struct cml_saved_def *saved = &scene->saved;
    struct cml_mci_line line = {
        .reader = reader, .owner = "photons", .parts = CML_KEY_PARTS({CML_KEYS_SAVED, saved})};
    const char *name = cml_text_word(&reader->cursor);
    const char *wrong = name ? cml_mci_why_no_name(name) : "a file name in a pair of quotes";
    if (wrong) return cml_mci_fail_option(&line, "file", name, wrong);
    if (strchr(name, '/'))
        return cml_mci_fail_option(&line, "file", name, "a name without a folder: it lies beside the result");
    CML_TRY(cml_text_copy(name, &saved->name, reader->err));
    saved->limit = 1000000;
    return cml_mci_options(&line);
}

cml_status cml_mci_check_photons(const struct cml_mci_reader *reader, const struct cml_scene *scene)
{
    if (!scene->saved.detected || scene->num_detectors > 0) return CML_OK;
    return cml_fail_field(reader->err, scene->file, scene->saved.line, "photons: detected", "no detector",
                          "a detector line, too");
}

/* Counts cells in double, because the product may exceed 64 bits. A pixel has four: Rd and Tt, each with
 * squares. */
cml_status cml_mci_check_map(const struct cml_mci_reader *reader, const struct cml_scene *scene)
{
    const struct cml_map_def *map = &scene->map;
    const double pixels = (double)map->nx * map->ny, most = 2147483648.0;
    const double layers = (map->volume ? scene->nz * (scene->fluence.line ? 1.0 + CML_NUM_GROUPS : 1.0) : 0) +
                          (scene->facets ? CML_FACET_SCORES * (scene->num_layers + 1.0) : 0);
    const double cells = pixels * (4.0 * (map->angles ? scene->na : 1) + layers);
    if (cells <= most) return CML_OK;
    return cml_fail_field(reader->err, scene->file, map->line, "map: nx ny",
                          CML_TEXT("%d %d", map->nx, map->ny),
                          CML_TEXT("at most 2^31 cells in maps and volume together, not %.3g (%.3g GiB)",
                                   cells, cells * 24 / 1073741824.0));
}
