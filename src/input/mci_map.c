/* Lines map, facets, time, directions, fluence and photons. SPDX-License-Identifier: MIT */
#include "input/mci_map.h"

#include "boundary.h"
#include "input/mci_options.h"

#include <string.h>

/* The four numbers that every map has. */
static cml_status read_pixels(struct cml_mci_reader *reader, struct cml_map_def *map)
{
    static const char length[] = "a length of 1e-30..1e30 cm", count[] = "a whole number of 1..1e9";
    static const struct cml_mci_field fields[] = {{"map: nx", 1, 1e9, true, count},
                                                  {"map: ny", 1, 1e9, true, count},
                                                  {"map: dx", CML_MCI_TINY, CML_MCI_HUGE, false, length},
                                                  {"map: dy", CML_MCI_TINY, CML_MCI_HUGE, false, length}};
    double values[4];
    for (int i = 0; i < 4; i++) {
        const char *word = cml_text_word(&reader->cursor);
        if (!word || !cml_mci_parse(&fields[i], word, &values[i]))
            return cml_mci_fail(reader, fields[i].name, word, fields[i].expected);
    }
    map->nx = (int)values[0];
    map->ny = (int)values[1];
    map->dx = values[2];
    map->dy = values[3];
    return CML_OK;
}

/* `top` belongs to the volume; without it the option would have no effect, and its writer would not know. */
static cml_status read_word(struct cml_mci_reader *reader, const char *word, struct cml_map_def *map)
{
    static const struct cml_mci_field top = {"map: top", -CML_MCI_HUGE, CML_MCI_HUGE, false,
                                             "a depth of -1e30..1e30 cm"};
    if (strcmp(word, "angles") == 0) {
        map->angles = true;
        return CML_OK;
    }
    if (strcmp(word, "volume") == 0) {
        map->volume = true;
        return CML_OK;
    }
    if (strncmp(word, "top=", 4) != 0)
        return cml_mci_fail(reader, "map: option", word, "angles, volume or top=");
    if (!map->volume) return cml_mci_fail(reader, "map: option", word, "volume before it");
    return cml_mci_parse(&top, word + 4, &map->top) ? CML_OK
                                                    : cml_mci_fail(reader, top.name, word + 4, top.expected);
}

/* Options follow in any order, but top= only behind volume. */
cml_status cml_mci_map(struct cml_mci_reader *reader, struct cml_map_def *map)
{
    if (map->nx > 0) return cml_mci_fail(reader, "line", cml_mci_raw(reader), "one map line per run");
    map->line = reader->text.line;
    cml_mci_cut_comment(reader->cursor);
    CML_TRY(read_pixels(reader, map));
    for (;;) {
        const char *word = cml_text_word(&reader->cursor);
        if (!word) return CML_OK;
        CML_TRY(read_word(reader, word, map));
    }
}

/* A line that is nothing but its keyword. */
static cml_status end_line(struct cml_mci_reader *reader, const char *field)
{
    cml_mci_cut_comment(reader->cursor);
    const char *word = cml_text_word(&reader->cursor);
    return word ? cml_mci_fail(reader, field, word, "the end of the line or a # comment") : CML_OK;
}

cml_status cml_mci_facets(struct cml_mci_reader *reader, int *facets)
{
    if (*facets) return cml_mci_fail(reader, "line", cml_mci_raw(reader), "one facets line per run");
    *facets = reader->text.line;
    return end_line(reader, "text after facets");
}

cml_status cml_mci_fluence(struct cml_mci_reader *reader, struct cml_fluence_def *fluence)
{
    if (fluence->line) return cml_mci_fail(reader, "line", cml_mci_raw(reader), "one fluence line per run");
    fluence->line = reader->text.line;
    return end_line(reader, "text after fluence");
}

/* Every batch has a fluence of its own, and bins beyond the grid; all are counted in 32 bits
 * (kernels/marks.h). As many bins of radius and gate are enough, too. */
cml_status cml_mci_check_fluence(const struct cml_mci_reader *reader, const struct cml_scene *scene)
{
    const double bins = (scene->nr + 1.0) * (scene->nz + 2.0), most = 67108863;
    char value[64];
    if (scene->time.radii && (scene->nr + 1.0) * (scene->time.gates + 1.0) > most) {
        snprintf(value, sizeof value, "%d %d", scene->nr, scene->time.gates);
        return cml_fail_field(reader->err, scene->file, scene->time.line, "time: nr gates", value,
                              "at most 67108863 bins, (nr + 1) times (gates + 1)");
    }
    if (!scene->fluence.line || bins <= most) return CML_OK;
    snprintf(value, sizeof value, "%d %d", scene->nz, scene->nr);
    return cml_fail_field(reader->err, scene->file, scene->fluence.line, "fluence: nz nr", value,
                          "at most 67108863 bins, (nz + 2) times (nr + 1)");
}

/* As many gates as every batch can have without asking. */
cml_status cml_mci_time(struct cml_mci_reader *reader, struct cml_time_def *time)
{
    static const struct cml_mci_field fields[] = {
        {"T1", 1e-6, 1e12, false, "a time of 1e-6..1e12 ps"},
        {"number of gates", 1, 100000, true, "a whole number of 1..100000"}};
    double values[2];
    if (time->gates > 0) return cml_mci_fail(reader, "line", cml_mci_raw(reader), "one time line per run");
    time->line = reader->text.line;
    cml_mci_cut_comment(reader->cursor);
    CML_TRY(cml_mci_leading_numbers(reader, "time", fields, 2, values));
    time->end = values[0];
    time->gates = (int)values[1];
    const char *word = cml_text_word(&reader->cursor);
    time->radii = word && strcmp(word, "radii") == 0;
    if (time->radii) word = cml_text_word(&reader->cursor);
    return word ? cml_mci_fail(reader, "time: option", word, "radii, or the end of the line") : CML_OK;
}

cml_status cml_mci_directions(struct cml_mci_reader *reader, struct cml_directions_def *directions)
{
    static const struct cml_mci_field fields[] = {{"NT", 1, 3600, true, "a whole number of 1..3600"},
                                                  {"NP", 1, 3600, true, "a whole number of 1..3600"}};
    double values[2];
    if (directions->nt > 0)
        return cml_mci_fail(reader, "line", cml_mci_raw(reader), "one directions line per run");
    directions->line = reader->text.line;
    CML_TRY(cml_mci_numbers(reader, "directions", fields, 2, values));
    directions->nt = (int)values[0];
    directions->np = (int)values[1];
    return CML_OK;
}

/* The name of a file, as that of a run's output is. */
cml_status cml_mci_photons(struct cml_mci_reader *reader, struct cml_saved_def *saved)
{
    static const struct cml_mci_field limit = {"limit", 1, 1e9, true, "a whole number of 1..1e9"};
    struct cml_mci_line_options options = {.reader = reader,
                                           .owner = "photons",
                                           .keys = {"detected", "limit"},
                                           .flag = "detected",
                                           .list = "detected or limit="};
    double most = 1e6;
    if (saved->limit) return cml_mci_fail(reader, "line", cml_mci_raw(reader), "one photons line per run");
    saved->line = reader->text.line;
    cml_mci_cut_comment(reader->cursor);
    const char *name = cml_text_word(&reader->cursor);
    const char *wrong = name ? cml_mci_why_no_name(name) : "a file name in a pair of quotes";
    if (wrong) return cml_mci_fail_option(&options, "file", name, wrong);
    if (strchr(name, '/'))
        return cml_mci_fail_option(&options, "file", name,
                                   "a name without a folder: it lies beside the result");
    CML_TRY(cml_text_copy(name, &saved->name, reader->err));
    for (bool more = true; more;) {
        CML_TRY(cml_mci_next_option(&options, &more));
        if (!more) break;
        if (options.key == 1 && !cml_mci_parse(&limit, options.value, &most))
            return cml_mci_fail_value(&options, limit.expected);
        if (options.key == 0 && !options.alone)
            return cml_mci_fail_value(&options, "the word detected alone");
    }
    saved->detected = options.seen[0];
    saved->limit = (uint64_t)most;
    return CML_OK;
}

cml_status cml_mci_check_photons(const struct cml_mci_reader *reader, const struct cml_scene *scene)
{
    if (!scene->saved.detected || scene->num_detectors > 0) return CML_OK;
    return cml_fail_field(reader->err, scene->file, scene->saved.line, "photons: detected", "no detector",
                          "a detector line, too");
}

/* A map's cells are counted in double: their product may exceed 64 bits. Four per pixel: Rd and Tt, each with
 * squares. */
cml_status cml_mci_check_map(const struct cml_mci_reader *reader, const struct cml_scene *scene)
{
    const struct cml_map_def *map = &scene->map;
    const double pixels = (double)map->nx * map->ny, most = 2147483648.0;
    const double layers = (map->volume ? scene->nz * (scene->fluence.line ? 1.0 + CML_NUM_GROUPS : 1.0) : 0) +
                          (scene->facets ? CML_FACET_SCORES * (scene->num_layers + 1.0) : 0);
    const double cells = pixels * (4.0 * (map->angles ? scene->na : 1) + layers);
    if (cells <= most) return CML_OK;
    char value[64], expected[120];
    snprintf(value, sizeof value, "%d %d", map->nx, map->ny);
    snprintf(expected, sizeof expected,
             "at most 2^31 cells in maps and volume together; these are %.3g, %.3g GiB", cells,
             cells * 24 / 1073741824.0);
    return cml_fail_field(reader->err, scene->file, map->line, "map: nx ny", value, expected);
}
