/* Beam lines. SPDX-License-Identifier: MIT */
#include "input/mci_beam.h"

#include "base/array.h"
#include "base/constants.h"
#include "base/shared.h"
#include "input/mesh/gsf.h"
#include "input/mci_options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* So many have a number in the index of a photon (kernels/balance.h). */
#define MOST_BEAMS 32767
#define MOST_ROWS 10000 /* of a table: adding-doubling takes seconds for ten times as many */

/* The order of the keys in cml_mci_beam. */
enum { BEAM_AT, BEAM_Z, BEAM_ANGLE, BEAM_AZIMUTH, BEAM_LIGHT, BEAM_SHARE, BEAM_RADIAL, BEAM_NA };

static const char coordinate[] = "a coordinate of -1e30..1e30 cm",
                  light_words[] = "parallel, na:N, lambertian, isotropic or a file in quotes";

static const struct cml_mci_field x_field = {"x", -CML_MCI_HUGE, CML_MCI_HUGE, false, coordinate},
                                  y_field = {"y", -CML_MCI_HUGE, CML_MCI_HUGE, false, coordinate},
                                  z_field = {"z", -CML_MCI_HUGE, CML_MCI_HUGE, false, coordinate},
                                  share = {"share", CML_MCI_TINY, CML_MCI_HUGE, false,
                                           "a share of 1e-30..1e30"},
                                  aperture = {"na", CML_MCI_TINY, 100, false,
                                              "a numerical aperture of 1e-30..100"},
                                  angle_above = {"angle", 0, 89.99999999999999, false,
                                                 "degrees, 0 <= angle < 90"},
                                  angle_inside = {"angle", 0, 180, false, "degrees, 0 <= angle <= 180"},
                                  azimuth = {"azimuth", -360, 360, false, "degrees, -360..360"};

/* Angles are degrees in the file, as people write them, and rad from here on. */
static const double degree = CML_PI / 180;

static bool parse_angle(const struct cml_mci_field *field, const char *text, double *angle)
{
    double degrees = 0;
    if (!cml_mci_parse(field, text, &degrees)) return false;
    *angle = degrees * degree;
    return true;
}

/* ---- files: tables of intensities, images ---- */

/* A table that is being read. */
struct table {
    struct cml_text text;
    struct cml_light *light;
    struct cml_error *err;
};

static cml_status fail_row(const struct table *table, const char *field, const char *value,
                           const char *expected)
{
    return cml_fail_field(table->err, table->text.path, table->text.line, field, value, expected);
}

static cml_status make_room(struct table *table)
{
    struct cml_light *light = table->light;
    if (light->rows == MOST_ROWS) return fail_row(table, "row", "10001", "at most 10000 rows");
    CML_TRY(cml_array_grow(&light->t, (size_t)light->rows, sizeof *light->t, "a table", table->err));
    CML_TRY(cml_array_grow(&light->intensity, (size_t)light->rows, sizeof *light->t, "a table", table->err));
    return CML_OK;
}

/* One row: an angle beyond the last one, and an intensity. */
static cml_status read_row(struct table *table, const char *angle, char *cursor)
{
    static const struct cml_mci_field degrees = {"angle", 0, 180, false, "degrees of 0..180"},
                                      shines = {"intensity", 0, CML_MCI_HUGE, false,
                                                "an intensity of 0..1e30"};
    struct cml_light *light = table->light;
    const double pi = CML_PI, least_step = 1e-6,
                 faintest = 1e-30; /* squares of both are no subnormal numbers */
    const double before = light->rows ? light->t[light->rows - 1] * 180 / pi : -1;
    const char *word = cml_text_word(&cursor), *rest = cml_text_word(&cursor);
    double t = 0, intensity = 0;
    if (!cml_mci_parse(&degrees, angle, &t)) return fail_row(table, degrees.name, angle, degrees.expected);
    if (light->rows == 0 && t != 0) return fail_row(table, degrees.name, angle, "0 in the first row");
    if (!(t > before * (1 + 1e-12)))
        return fail_row(table, degrees.name, angle, "more than in the row before");
    if (t < before + least_step)
        return fail_row(table, degrees.name, angle, "1e-6 degrees or more beyond the row before");
    if (!word || !cml_mci_parse(&shines, word, &intensity))
        return fail_row(table, shines.name, word, shines.expected);
    if (intensity > 0 && intensity < faintest)
        return fail_row(table, shines.name, word, "0, or an intensity of 1e-30..1e30");
    if (rest) return fail_row(table, "word behind the intensity", rest, "the end of the line or a # comment");
    CML_TRY(make_room(table));
    light->t[light->rows] = t * pi / 180;
    light->intensity[light->rows++] = intensity;
    return CML_OK;
}

static cml_status read_table(struct table *table)
{
    struct cml_light *light = table->light;
    char rows[16];
    double sum = 0;
    for (char *line = cml_text_next(&table->text); line; line = cml_text_next(&table->text)) {
        cml_mci_cut_comment(line);
        const char *word = cml_text_word(&line);
        if (word) CML_TRY(read_row(table, word, line));
    }
    snprintf(rows, sizeof rows, "%d", light->rows);
    if (light->rows < 2)
        return fail_row(table, "rows", rows, "2 at least, each of an angle and an intensity");
    for (int i = 0; i < light->rows; i++) sum += light->intensity[i];
    return sum > 0 ? CML_OK : fail_row(table, "intensity", "0 in all rows", "light in one row at least");
}

static cml_status read_light_table(struct cml_mci_reader *reader, const char *name, struct cml_light *light)
{
    struct table table = {.light = light, .err = reader->err};
    char *path = NULL;
    light->kind = CML_LIGHT_OF_TABLE;
    CML_TRY(cml_path_beside(reader->text.path, name, &path, reader->err));
    cml_status status = cml_text_read_table(reader->options->source, path, &table.text, reader->err);
    if (status == CML_OK) status = read_table(&table);
    status = cml_mci_name_line(reader, "beam", path, status);
    cml_text_clear(&table.text);
    free(path);
    return status;
}

/* Rows of a heightmap begin at the smallest y. */
static cml_status take_pixels(const char *path, const struct cml_heightmap *map, struct cml_beam *beam,
                              struct cml_error *err)
{
    const size_t nx = (size_t)map->nx, ny = (size_t)map->ny;
    char value[96];
    double sum = 0;
    beam->pixel = malloc(nx * ny * sizeof *beam->pixel);
    if (!beam->pixel) return cml_fail_memory(err, (double)(nx * ny) * 8, "an image");
    beam->columns = map->nx;
    beam->rows = map->ny;
    beam->size[0] = map->dx * map->nx;
    beam->size[1] = map->dy * map->ny;
    for (size_t i = 0; i < nx * ny; i++) {
        const double pixel = map->h[(ny - 1 - i / nx) * nx + i % nx];
        snprintf(value, sizeof value, "%g in row %zu, column %zu", pixel, i / nx + 1, i % nx + 1);
        if (!(pixel >= 0) || !isfinite(pixel))
            return cml_fail_field(err, path, 0, "pixel", value, "0 or more");
        beam->pixel[i] = pixel;
        sum += pixel;
    }
    return sum > 0 ? CML_OK
                   : cml_fail_field(err, path, 0, "pixels", "all 0", "light in one of them at least");
}

static cml_status read_image(struct cml_mci_reader *reader, const char *name, struct cml_beam *beam)
{
    struct cml_heightmap map = {0};
    char *path = NULL;
    CML_TRY(cml_path_beside(reader->text.path, name, &path, reader->err));
    cml_status status = cml_gsf_read_pixels(reader->options->source, path, &map, reader->err);
    if (status == CML_OK) status = take_pixels(path, &map, beam, reader->err);
    status = cml_mci_name_line(reader, "beam", path, status);
    cml_heightmap_clear(&map);
    free(path);
    return status;
}

/* ---- shapes ---- */

/* A shape's numbers have the same names in messages and in settings. */
struct shape {
    const char *name;
    enum cml_beam_shape shape;
    int numbers;
    struct cml_mci_field field[2];
};

static const char length[] = "a length of 1e-30..1e30 cm";
static const struct shape shapes[] = {
    {"pencil", CML_BEAM_PENCIL, 0, {{0}}},
    {"disk", CML_BEAM_DISK, 1, {{"radius", CML_MCI_TINY, CML_MCI_HUGE, false, length}}},
    {"gaussian", CML_BEAM_GAUSSIAN, 1, {{"radius", CML_MCI_TINY, CML_MCI_HUGE, false, length}}},
    {"ring",
     CML_BEAM_RING,
     2,
     {{"r1", 0, CML_MCI_HUGE, false, "a length of 0..1e30 cm"},
      {"r2", CML_MCI_TINY, CML_MCI_HUGE, false, length}}},
    {"rectangle",
     CML_BEAM_RECTANGLE,
     2,
     {{"w", CML_MCI_TINY, CML_MCI_HUGE, false, length}, {"h", CML_MCI_TINY, CML_MCI_HUGE, false, length}}},
    {"image", CML_BEAM_IMAGE, 0, {{0}}},
};

/* The shape comes first and is no option: without it nobody would know what the numbers are of. */
static cml_status read_beam_shape(const struct cml_mci_line_options *options, struct cml_beam *beam)
{
    const char *word = cml_text_word(&options->reader->cursor);
    const struct shape *shape = NULL;
    for (size_t i = 0; word && i < sizeof shapes / sizeof *shapes; i++)
        if (strcmp(shapes[i].name, word) == 0) shape = &shapes[i];
    if (!shape)
        return cml_mci_fail_option(
            options, "shape", word,
            "pencil, disk R, gaussian R, ring R1 R2, rectangle W H, rectangle tile or image \"FILE.gsf\"");
    beam->shape = shape->shape;
    for (int i = 0; i < shape->numbers; i++) {
        word = cml_text_word(&options->reader->cursor);
        beam->of_tile = beam->shape == CML_BEAM_RECTANGLE && i == 0 && word && strcmp(word, "tile") == 0;
        if (beam->of_tile) break;
        if (!word || !cml_mci_parse(&shape->field[i], word, &beam->size[i]))
            return cml_mci_fail_option(options, shape->field[i].name, word, shape->field[i].expected);
    }
    if (beam->shape != CML_BEAM_IMAGE) return CML_OK;
    word = cml_text_word(&options->reader->cursor);
    if (!word || *word == '"' || *word == '\0' || strchr(word, '='))
        return cml_mci_fail_option(options, "file", word, "a file name in a pair of quotes");
    return read_image(options->reader, word, beam);
}

/* ---- light ---- */

static cml_status set_light(const struct cml_mci_line_options *options, struct cml_light *light)
{
    static const char *const words[] = {"parallel", "lambertian", "isotropic"};
    static const enum cml_light_kind kinds[] = {CML_LIGHT_OF_PARALLEL, CML_LIGHT_OF_LAMBERTIAN,
                                                CML_LIGHT_OF_ISOTROPIC};
    char *value = options->value;
    const size_t size = strlen(value);
    const int which = cml_mci_choose(value, words, 3);
    if (which >= 0) {
        light->kind = kinds[which];
        return CML_OK;
    }
    if (strncmp(value, "na:", 3) == 0) {
        light->kind = CML_LIGHT_OF_NA;
        return cml_mci_parse(&aperture, value + 3, &light->na)
                   ? CML_OK
                   : cml_mci_fail_value(options, aperture.expected);
    }
    if (size < 3 || value[0] != '"' || value[size - 1] != '"')
        return cml_mci_fail_value(options, light_words);
    value[size - 1] = '\0';
    return read_light_table(options->reader, value + 1, light);
}

/* ---- the line ---- */

static cml_status set_beam_option(const struct cml_mci_line_options *options, struct cml_beam *beam,
                                  double *beam_share)
{
    double values[2] = {0, 0};
    switch (options->key) {
    case BEAM_AT:
        if (!cml_mci_parse_list(options->value, 2, values))
            return cml_mci_fail_value(options, "x,y in cm without blanks");
        beam->x = values[0];
        beam->y = values[1];
        return CML_OK;
    case BEAM_Z:
        beam->inside = true;
        return cml_mci_parse(&z_field, options->value, &beam->z) ? CML_OK
                                                                 : cml_mci_fail_value(options, coordinate);
    case BEAM_ANGLE: /* whether it may be so large is known behind the last option */
        return parse_angle(&angle_inside, options->value, &beam->angle)
                   ? CML_OK
                   : cml_mci_fail_value(options, beam->inside ? angle_inside.expected : angle_above.expected);
    case BEAM_AZIMUTH:
        return parse_angle(&azimuth, options->value, &beam->azimuth)
                   ? CML_OK
                   : cml_mci_fail_value(options, azimuth.expected);
    case BEAM_LIGHT:
        return set_light(options, &beam->light);
    case BEAM_SHARE:
        return cml_mci_parse(&share, options->value, beam_share)
                   ? CML_OK
                   : cml_mci_fail_value(options, share.expected);
    case BEAM_NA: /* as of detectors */
        return cml_mci_fail_value(options, "light=na:N");
    default:
        beam->radial = true;
        return strcmp(options->value, "beam") == 0 ? CML_OK : cml_mci_fail_value(options, "radial=beam");
    }
}

/* One more beam. The first line takes the place of the pencil that there is without one. */
cml_status cml_mci_add_beam(struct cml_mci_reader *reader, struct cml_scene *scene)
{
    const int count = scene->num_beams;
    if (count == 1 && !scene->beams[0].given) return CML_OK;
    if (count == MOST_BEAMS) return cml_mci_fail(reader, "line", cml_mci_raw(reader), "at most 32767 beams");
    CML_TRY(cml_array_grow(&scene->beams, (size_t)count, sizeof *scene->beams, "beams", reader->err));
    CML_TRY(cml_array_grow(&scene->shares, (size_t)count, sizeof *scene->shares, "beams", reader->err));
    scene->beams[count] = (struct cml_beam){0};
    scene->shares[count] = 1;
    scene->num_beams++;
    return CML_OK;
}

cml_status cml_mci_beam(struct cml_mci_reader *reader, struct cml_scene *scene)
{
    struct cml_mci_line_options options = {
        .reader = reader,
        .owner = "beam",
        .keys = {"at", "z", "angle", "azimuth", "light", "share", "radial", "na"},
        .list = "at=, z=, angle=, azimuth=, light=, share= or radial="};
    const char *angle = NULL;
    CML_TRY(cml_mci_add_beam(reader, scene));
    CML_TRY(cml_share_begin(&scene->beams[scene->num_beams - 1].users, reader->err));
    struct cml_beam *beam = &scene->beams[scene->num_beams - 1];
    double *beam_share = &scene->shares[scene->num_beams - 1];
    beam->given = true;
    beam->line = reader->text.line;
    cml_mci_cut_comment(reader->cursor);
    CML_TRY(read_beam_shape(&options, beam));
    for (bool more = true; more;) {
        CML_TRY(cml_mci_next_option(&options, &more));
        if (more) CML_TRY(set_beam_option(&options, beam, beam_share));
        if (more && options.key == BEAM_ANGLE) angle = options.value;
    }
    if (beam->inside || !angle || parse_angle(&angle_above, angle, &beam->angle)) return CML_OK;
    return cml_mci_fail_option(&options, "angle", angle, angle_above.expected);
}

/* ---- settings ---- */

struct cml_mci_number cml_mci_beam_number(struct cml_scene *scene, int k, const char *member)
{
    struct cml_beam *beam = &scene->beams[k];
    const struct shape *shape = &shapes[beam->shape];
    const struct {
        bool there;
        struct cml_mci_number number;
    } numbers[] = {{true, {&beam->x, &x_field, 1}},
                   {true, {&beam->y, &y_field, 1}},
                   {beam->inside, {&beam->z, &z_field, 1}},
                   {true, {&beam->angle, beam->inside ? &angle_inside : &angle_above, degree}},
                   {true, {&beam->azimuth, &azimuth, degree}},
                   {beam->light.kind == CML_LIGHT_OF_NA, {&beam->light.na, &aperture, 1}},
                   {scene->num_beams > 1, {&scene->shares[k], &share, 1}},
                   {shape->numbers > 0 && !beam->of_tile, {&beam->size[0], &shape->field[0], 1}},
                   {shape->numbers > 1 && !beam->of_tile, {&beam->size[1], &shape->field[1], 1}}};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        if (numbers[i].there && strcmp(numbers[i].number.field->name, member) == 0) return numbers[i].number;
    return (struct cml_mci_number){0};
}

/* ---- what belongs together ---- */

static cml_status fail_beam(const struct cml_mci_reader *reader, const struct cml_scene *scene, int k,
                            const char *field, const char *value, const char *expected)
{
    return cml_fail_field(reader->err, scene->file, scene->beams[k].line, field, value, expected);
}

/* Light from above all surfaces goes down. */
static cml_status check_light(const struct cml_mci_reader *reader, const struct cml_scene *scene, int k)
{
    const struct cml_beam *beam = &scene->beams[k];
    const double degrees = 180 / CML_PI, n = scene->media[0].n, widest = cml_light_widest(&beam->light, n);
    char value[120], expected[160];
    if (beam->light.kind == CML_LIGHT_OF_ISOTROPIC)
        return fail_beam(reader, scene, k, "beam: light", "isotropic", "z= beside it: it goes up, too");
    if (beam->light.kind == CML_LIGHT_OF_NA && beam->light.na > n) {
        snprintf(value, sizeof value, "na:%g", beam->light.na);
        snprintf(expected, sizeof expected, "at most n = %g of the medium that it starts in", n);
        return fail_beam(reader, scene, k, "beam: light", value, expected);
    }
    if (beam->light.kind == CML_LIGHT_OF_PARALLEL) return CML_OK;
    if (beam->light.kind == CML_LIGHT_OF_LAMBERTIAN ? beam->angle == 0 : beam->angle + widest < CML_PI / 2)
        return CML_OK;
    snprintf(value, sizeof value, "up to %g degrees from an axis of angle %g", widest * degrees,
             beam->angle * degrees);
    return fail_beam(reader, scene, k, "beam: light", value,
                     beam->light.kind == CML_LIGHT_OF_LAMBERTIAN
                         ? "angle 0: light from above all surfaces goes down; or z="
                         : "less than 90 degrees together: light from above all surfaces goes down; or z=");
}

/* The period of all tiles, cm. */
static cml_status find_period(const struct cml_mci_reader *reader, const struct cml_scene *scene, int k,
                              const double **period)
{
    char value[160];
    int first = -1;
    for (int b = 0; b <= scene->num_layers; b++) {
        const double *own = scene->boundaries[b].period;
        if (own[0] == 0) continue;
        if (first < 0) {
            first = b;
            *period = own;
        }
        if (fabs(own[0] / (*period)[0] - 1) < 1e-9 && fabs(own[1] / (*period)[1] - 1) < 1e-9) continue;
        snprintf(value, sizeof value, "tile, with %g x %g cm at boundary %d, %g x %g cm at boundary %d",
                 (*period)[0], (*period)[1], first, own[0], own[1], b);
        return fail_beam(reader, scene, k, "beam: rectangle", value, "tiles of one period, or W H");
    }
    if (first >= 0) return CML_OK;
    return fail_beam(reader, scene, k, "beam: rectangle", "tile",
                     "a boundary with `tile` in its line, or W H");
}

/* Seen along the axis a period is 1 / cos(angle) times as short. Directions other than the axis would light
 * another area, and so would packets that start at different depths. */
static cml_status fit_to_tile(const struct cml_mci_reader *reader, struct cml_scene *scene, int k)
{
    struct cml_beam *beam = &scene->beams[k];
    const double *period = NULL;
    char value[40];
    int axis[2];
    CML_TRY(find_period(reader, scene, k, &period));
    snprintf(value, sizeof value, "%g", beam->azimuth / degree);
    if (!cml_beam_axes(beam, axis))
        return fail_beam(reader, scene, k, "beam: azimuth", value,
                         "a multiple of 90 degrees beside rectangle tile, whose sides lie along x and y");
    snprintf(value, sizeof value, "%g", beam->angle / degree);
    if (beam->angle != 0 && (beam->inside || beam->light.kind != CML_LIGHT_OF_PARALLEL))
        return fail_beam(reader, scene, k, "beam: angle", value,
                         "0 beside rectangle tile with z= or light=: other light is not even over a period");
    beam->size[0] = period[axis[0]] * cos(beam->angle);
    beam->size[1] = period[axis[1]];
    return CML_OK;
}

static cml_status check_beam(const struct cml_mci_reader *reader, const struct cml_scene *scene, int k)
{
    const struct cml_beam *beam = &scene->beams[k];
    char value[80];
    if (beam->shape == CML_BEAM_RING && !(beam->size[0] < beam->size[1])) {
        snprintf(value, sizeof value, "%g %g", beam->size[0], beam->size[1]);
        return fail_beam(reader, scene, k, "beam: r1 r2", value, "r1 < r2");
    }
    if (beam->radial && scene->num_beams > 1)
        return fail_beam(reader, scene, k, "beam: radial", "beam",
                         "one beam only: with several r counts from the z axis");
    return beam->inside ? CML_OK : check_light(reader, scene, k);
}

cml_status cml_mci_check_beams(const struct cml_mci_reader *reader, struct cml_scene *scene)
{
    for (int k = 0; k < scene->num_beams; k++) {
        if (scene->beams[k].of_tile) CML_TRY(fit_to_tile(reader, scene, k));
        CML_TRY(check_beam(reader, scene, k));
    }
    return CML_OK;
}
