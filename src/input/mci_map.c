/* Reader of the lines `map` and `photons`, and checks of map, photons and fluence against the rest of a run.
 * SPDX-License-Identifier: MIT */
#include "input/mci_map.h"

#include "boundary.h"
#include "input/mci_options.h"

#include <string.h>

/* Reads a line `map`. The option `top` has an effect only with `volume`; without it the line is refused,
 * because the user would not notice. */
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
    char value[64];
    if (scene->fluence.times && scene->time.gates == 0)
        return cml_fail_field(reader->err, scene->file, scene->fluence.line, "fluence", "time",
                              "a time line in the same run");
    if (scene->fluence.times && gated > most_gated) {
        snprintf(value, sizeof value, "%d %d %d", scene->nz, scene->nr, scene->time.gates);
        return cml_fail_field(reader->err, scene->file, scene->fluence.line, "fluence time: nz nr gates",
                              value, "at most 1048576 bins of r, z and time, nz times nr times gates");
    }
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

/* Refuses the option `detected` of the line `photons` if the scene has no detectors. */
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
    char value[64], expected[120];
    snprintf(value, sizeof value, "%d %d", map->nx, map->ny);
    snprintf(expected, sizeof expected, "at most 2^31 cells in maps and volume together, not %.3g (%.3g GiB)",
             cells, cells * 24 / 1073741824.0);
    return cml_fail_field(reader->err, scene->file, map->line, "map: nx ny", value, expected);
}
