/* Reader of `beam` lines. SPDX-License-Identifier: MIT */
#include "input/mci_beam.h"

#include "base/array.h"
#include "base/constants.h"
#include "base/shared.h"
#include "input/mesh/gsf.h"
#include "input/mci_contact.h"
#include "input/mci_options.h"
#include "scene/contact.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The number of a beam is part of a photon's index, which has room for this many (kernels/balance.h). */
#define MOST_BEAMS 32767
#define MOST_ROWS 10000 /* rows of a table of light: adding-doubling takes seconds for ten times as many */

/* ---- files: tables of intensities, images ---- */

/* Makes room for one more row of a table. */
static cml_status make_room(const struct cml_mci_reader *rows, struct cml_light *light)
{
    if (light->rows == MOST_ROWS) return cml_mci_fail(rows, "row", "10001", "at most 10000 rows");
    CML_TRY(cml_array_grow(&light->t, (size_t)light->rows, sizeof *light->t, "a table", rows->err));
    return cml_array_grow(&light->intensity, (size_t)light->rows, sizeof *light->t, "a table", rows->err);
}

/* Reads a row of a light's table: an angle larger than that of the row before, in degrees, and an intensity.
 * Intensities have bounds, because their squares must be normal numbers. */
static cml_status read_row(struct cml_mci_reader *rows, struct cml_light *light)
{
    static const struct cml_key degrees = {.name = "angle", .noun = "degrees", .most = 180},
                                shines = {.name = "intensity",
                                          .use = CML_KEY_OR_0,
                                          .noun = "an intensity",
                                          .least = CML_MCI_TINY,
                                          .most = CML_MCI_HUGE};
    const double before = light->rows ? light->t[light->rows - 1] * 180 / CML_PI : -1, least_step = 1e-6;
    const char *angle = cml_text_word(&rows->cursor);
    double t = 0, intensity = 0;
    if (!cml_key_parse(&degrees, angle, &t)) return cml_mci_fail_key(rows, NULL, &degrees, angle);
    if (light->rows == 0 && t != 0) return cml_mci_fail(rows, degrees.name, angle, "0 in the first row");
    if (!(t > before * (1 + 1e-12)))
        return cml_mci_fail(rows, degrees.name, angle, "more than in the row before");
    if (t < before + least_step)
        return cml_mci_fail(rows, degrees.name, angle, "1e-6 degrees or more beyond the row before");
    CML_TRY(cml_mci_number(rows, NULL, &shines, &intensity));
    CML_TRY(cml_mci_end_line(rows, "word behind the intensity"));
    CML_TRY(make_room(rows, light));
    light->t[light->rows] = t * CML_PI / 180;
    light->intensity[light->rows++] = intensity;
    return CML_OK;
}

/* Reads the rows "angle intensity" of a light's table; at least two rows, and some light. */
static cml_status read_light_table(struct cml_mci_reader *rows, void *context)
{
    struct cml_light *light = context;
    double sum = 0;
    while (cml_mci_next_row(rows)) CML_TRY(read_row(rows, light));
    if (light->rows < 2)
        return cml_mci_fail(rows, "rows", CML_TEXT("%d", light->rows),
                            "2 at least, each of an angle and an intensity");
    for (int i = 0; i < light->rows; i++) sum += light->intensity[i];
    return sum > 0 ? CML_OK : cml_mci_fail(rows, "intensity", "0 in all rows", "light in one row at least");
}

/* Copies the pixels of an image into a beam. Rows of a heightmap begin at the smallest y, those of the beam
 * at the largest. */
static cml_status take_pixels(const char *path, const struct cml_heightmap *map, struct cml_beam *beam,
                              struct cml_error *err)
{
    const size_t nx = (size_t)map->nx, ny = (size_t)map->ny;
    double sum = 0;
    CML_TRY(cml_zeros(&beam->pixel, nx * ny, sizeof *beam->pixel, "an image", err));
    beam->columns = map->nx;
    beam->rows = map->ny;
    beam->size[0] = map->dx * map->nx;
    beam->size[1] = map->dy * map->ny;
    for (size_t i = 0; i < nx * ny; i++) {
        const double pixel = map->h[(ny - 1 - i / nx) * nx + i % nx];
        if (!(pixel >= 0) || !isfinite(pixel))
            return cml_fail_field(err, path, 0, "pixel",
                                  CML_TEXT("%g in row %zu, column %zu", pixel, i / nx + 1, i % nx + 1),
                                  "0 or more");
        beam->pixel[i] = pixel;
        sum += pixel;
    }
    return sum > 0 ? CML_OK
                   : cml_fail_field(err, path, 0, "pixels", "all 0", "light in one of them at least");
}

/* Reads the image file of a beam, whose pixels say how much light starts where. */
static cml_status read_image(struct cml_mci_reader *reader, const char *name, struct cml_beam *beam)
{
    CML_AT_END(cml_heightmap_clear) struct cml_heightmap map = {0};
    CML_FREED char *path = NULL;
    CML_TRY(cml_path_beside(reader->text.path, name, &path, reader->err));
    cml_status status = cml_gsf_read_pixels(reader->options->source, path, &map, reader->err);
    if (status == CML_OK) status = take_pixels(path, &map, beam, reader->err);
    return cml_mci_name_line(reader, "beam", path, status);
}

/* ---- keys of a beam ---- */

static const struct {
    const char *name;
    enum cml_key_group keys;
} shapes[] = {[CML_BEAM_PENCIL] = {"pencil", CML_KEYS_NONE},
              [CML_BEAM_DISK] = {"disk", CML_KEYS_BEAM_DISK},
              [CML_BEAM_GAUSSIAN] = {"gaussian", CML_KEYS_BEAM_DISK},
              [CML_BEAM_RING] = {"ring", CML_KEYS_BEAM_RING},
              [CML_BEAM_RECTANGLE] = {"rectangle", CML_KEYS_BEAM_RECTANGLE},
              [CML_BEAM_IMAGE] = {"image", CML_KEYS_NONE},
              {"port", CML_KEYS_NONE}};
enum { NUM_SHAPES = sizeof shapes / sizeof *shapes };

/* Lists which groups of keys a beam has: it depends on its shape, its light and where it starts. in_line:
 * for reading its line; otherwise for --set, which cannot add keys. */
void cml_mci_beam_parts(struct cml_scene *scene, int k, bool in_line, struct cml_key_part *part)
{
    struct cml_beam *beam = &scene->beams[k];
    if (!beam->port) *part++ = (struct cml_key_part){CML_KEYS_BEAM, beam};
    if ((in_line && !beam->port) || beam->inside) *part++ = (struct cml_key_part){CML_KEYS_START, beam};
    *part++ = (struct cml_key_part){beam->inside ? CML_KEYS_INSIDE : CML_KEYS_ABOVE, beam};
    *part++ = (struct cml_key_part){CML_KEYS_AXIS, beam};
    if (!beam->of_tile && !beam->port && shapes[beam->shape].keys != CML_KEYS_NONE)
        *part++ = (struct cml_key_part){shapes[beam->shape].keys, beam};
    if (beam->light.kind == CML_LIGHT_OF_NA) *part++ = (struct cml_key_part){CML_KEYS_LIGHT, &beam->light};
    if (in_line || scene->num_beams > 1) *part++ = (struct cml_key_part){CML_KEYS_SHARE, &scene->shares[k]};
    *part = (struct cml_key_part){CML_KEYS_NONE, NULL};
}

/* ---- the line ---- */

/* Reads the shape, the first word of the line, without which the numbers behind it have no meaning. */
static cml_status read_beam_shape(const struct cml_mci_line *line, struct cml_beam *beam)
{
    char **cursor = &line->reader->cursor, *word = cml_text_word(cursor);
    int shape = 0;
    while (shape < NUM_SHAPES && !(word && strcmp(shapes[shape].name, word) == 0)) shape++;
    if (shape == NUM_SHAPES)
        return cml_mci_fail_option(
            line, "shape", word,
            "pencil, disk R, gaussian R, ring R1 R2, rectangle W H, rectangle tile, image \"FILE.gsf\" or "
            "port NAME");
    if (shape == NUM_SHAPES - 1) return cml_mci_take_port(line, &beam->port);
    beam->shape = (enum cml_beam_shape)shape;
    char *next = *cursor + strspn(*cursor, " \t");
    beam->of_tile =
        beam->shape == CML_BEAM_RECTANGLE && strcspn(next, " \t") == 4 && strncmp(next, "tile", 4) == 0;
    if (beam->of_tile) *cursor = next + 4;
    if (beam->shape != CML_BEAM_IMAGE) return CML_OK;
    word = cml_text_word(cursor);
    if (!word || *word == '"' || *word == '\0' || strchr(word, '='))
        return cml_mci_fail_option(line, "file", word, "a file name in a pair of quotes");
    return read_image(line->reader, word, beam);
}

/* Reads the angular distribution of a beam's light: a word, na:X with a numerical aperture, or the quoted
 * name of a file with a table. */
static cml_status set_light(struct cml_mci_line *line, struct cml_light *light)
{
    static const char *const words[] = {"parallel", "lambertian", "isotropic"};
    static const enum cml_light_kind kinds[] = {CML_LIGHT_OF_PARALLEL, CML_LIGHT_OF_LAMBERTIAN,
                                                CML_LIGHT_OF_ISOTROPIC};
    const struct cml_key *aperture = cml_keys_of(CML_KEYS_LIGHT);
    char *value = line->value, expected[CML_KEY_TEXT];
    const size_t size = strlen(value);
    const int which = cml_mci_choose(value, words, 3);
    if (which >= 0) {
        light->kind = kinds[which];
        return CML_OK;
    }
    if (strncmp(value, "na:", 3) == 0) {
        light->kind = CML_LIGHT_OF_NA;
        return cml_key_parse(aperture, value + 3, &light->na)
                   ? CML_OK
                   : cml_mci_fail_value(line, cml_key_expected(aperture, expected));
    }
    if (size < 3 || value[0] != '"' || value[size - 1] != '"')
        return cml_mci_fail_value(line, line->key->noun);
    value[size - 1] = '\0';
    light->kind = CML_LIGHT_OF_TABLE;
    return cml_mci_table(line->reader, "beam", value + 1, "a file name", read_light_table, light);
}

/* Sets a key of type CML_KEY_OWN: `light` or `radial`. `na` is a key of detectors only, so the message
 * advises light=na:N. */
static cml_status set_own(struct cml_mci_line *line)
{
    struct cml_beam *beam = line->context;
    if (strcmp(line->key->name, "light") == 0) return set_light(line, &beam->light);
    if (strcmp(line->key->name, "na") == 0) return cml_mci_fail_value(line, "light=na:N");
    beam->radial = true;
    return strcmp(line->value, "beam") == 0 ? CML_OK : cml_mci_fail_value(line, line->key->noun);
}

/* Adds a beam to the scene. The first line `beam` replaces the default pencil beam. */
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

/* The line's z= decides between a beam inside the scene and one from above. */
cml_status cml_mci_beam(struct cml_mci_reader *reader, struct cml_scene *scene)
{
    struct cml_key_part parts[CML_MOST_KEY_PARTS];
    CML_TRY(cml_mci_add_beam(reader, scene));
    const int k = scene->num_beams - 1;
    struct cml_beam *beam = &scene->beams[k];
    struct cml_mci_line line = {
        .reader = reader, .owner = "beam", .parts = parts, .own = set_own, .context = beam};
    CML_TRY(cml_share_begin(&beam->users, reader->err));
    beam->given = true;
    beam->line = reader->text.line;
    CML_TRY(read_beam_shape(&line, beam));
    beam->inside = !beam->port && cml_mci_find_word(reader->cursor, "z=") != NULL;
    cml_mci_beam_parts(scene, k, true, parts);
    CML_TRY(cml_mci_leading_numbers(reader, "beam", parts));
    return cml_mci_options(&line);
}

/* ---- checks of several lines ---- */

static const double degree = CML_PI / 180;

/* Refuses a value of beam k, with the line of the beam. */
static cml_status fail_beam(const struct cml_mci_reader *reader, const struct cml_scene *scene, int k,
                            const char *field, const char *value, const char *expected)
{
    return cml_fail_field(reader->err, scene->file, scene->beams[k].line, field, value, expected);
}

/* Refuses light of beam k that would go upwards although the beam starts above all surfaces, and an aperture
 * larger than the index of the medium allows. */
static cml_status check_light(const struct cml_mci_reader *reader, const struct cml_scene *scene, int k)
{
    const struct cml_beam *beam = &scene->beams[k];
    const double degrees = 180 / CML_PI, n = cml_beam_index(scene, beam),
                 widest = cml_light_widest(&beam->light, n);
    if (beam->light.kind == CML_LIGHT_OF_ISOTROPIC)
        return fail_beam(reader, scene, k, "beam: light", "isotropic",
                         beam->port ? "light that goes down" : "z= beside it: it goes up, too");
    if (beam->light.kind == CML_LIGHT_OF_NA && beam->light.na > n)
        return fail_beam(reader, scene, k, "beam: light", CML_TEXT("na:%g", beam->light.na),
                         CML_TEXT("at most n = %g of the medium that it starts in", n));
    if (beam->light.kind == CML_LIGHT_OF_PARALLEL) return CML_OK;
    const bool half_space =
        beam->light.kind == CML_LIGHT_OF_LAMBERTIAN || beam->light.kind == CML_LIGHT_OF_NA;
    if ((half_space && beam->angle == 0) || beam->angle + widest < CML_PI / 2) return CML_OK;
    return fail_beam(
        reader, scene, k, "beam: light",
        CML_TEXT("up to %g degrees from an axis of angle %g", widest * degrees, beam->angle * degrees),
        beam->light.kind == CML_LIGHT_OF_LAMBERTIAN
            ? "angle 0: light from above all surfaces goes down; or z="
            : "less than 90 degrees together: light from above all surfaces goes down; or z=");
}

/* Finds the period of all tiles, x and y in cm. Fails where there is no tile, or tiles differ. */
static cml_status find_period(const struct cml_mci_reader *reader, const struct cml_scene *scene, int k,
                              const double **period)
{
    int first = -1;
    for (int b = 0; b <= scene->num_layers; b++) {
        const double *own = scene->boundaries[b].period;
        if (own[0] == 0) continue;
        if (first < 0) {
            first = b;
            *period = own;
        }
        if (fabs(own[0] / (*period)[0] - 1) < 1e-9 && fabs(own[1] / (*period)[1] - 1) < 1e-9) continue;
        return fail_beam(reader, scene, k, "beam: rectangle",
                         CML_TEXT("tile, with %g x %g cm at boundary %d, %g x %g cm at boundary %d",
                                  (*period)[0], (*period)[1], first, own[0], own[1], b),
                         "tiles of one period, or W H");
    }
    if (first >= 0) return CML_OK;
    return fail_beam(reader, scene, k, "beam: rectangle", "tile",
                     "a boundary with `tile` in its line, or W H");
}

/* Sets the size of a beam `rectangle tile`, which lights exactly one period of the tiles. Across an oblique
 * axis the beam is narrower than the period:
 *
 *     w = period * cos(angle of the axis to the vertical)
 *
 * Light in other directions than the axis, or that starts at several depths, would light another area. */
static cml_status fit_to_tile(const struct cml_mci_reader *reader, struct cml_scene *scene, int k)
{
    struct cml_beam *beam = &scene->beams[k];
    const double *period = NULL;
    int axis[2];
    CML_TRY(find_period(reader, scene, k, &period));
    if (!cml_beam_axes(beam, axis))
        return fail_beam(reader, scene, k, "beam: azimuth", CML_TEXT("%g", beam->azimuth / degree),
                         "a multiple of 90 degrees beside rectangle tile, whose sides lie along x and y");
    if (beam->angle != 0 && (beam->inside || beam->light.kind != CML_LIGHT_OF_PARALLEL))
        return fail_beam(reader, scene, k, "beam: angle", CML_TEXT("%g", beam->angle / degree),
                         "0 beside rectangle tile with z= or light=: other light is not even over a period");
    beam->size[0] = period[axis[0]] * cos(beam->angle);
    beam->size[1] = period[axis[1]];
    return CML_OK;
}

/* Refuses a beam whose own numbers contradict each other, and `radial` if there are several beams. */
static cml_status check_beam(const struct cml_mci_reader *reader, const struct cml_scene *scene, int k)
{
    const struct cml_beam *beam = &scene->beams[k];
    if (beam->shape == CML_BEAM_RING && !(beam->size[0] < beam->size[1]))
        return fail_beam(reader, scene, k, "beam: r1 r2", CML_TEXT("%g %g", beam->size[0], beam->size[1]),
                         "r1 < r2");
    if (beam->radial && scene->num_beams > 1)
        return fail_beam(reader, scene, k, "beam: radial", "beam",
                         "one beam only: with several r counts from the z axis");
    return beam->inside ? CML_OK : check_light(reader, scene, k);
}

/* Gives a beam the place and the shape of the port that its light comes from. A later line over the port is
 * refused, because it would stop a part of this light. */
static cml_status start_in_port(const struct cml_mci_reader *reader, const struct cml_scene *scene,
                                struct cml_beam *beam)
{
    CML_TRY(cml_mci_find_port(reader, scene, beam->port, "beam", scene->file, beam->line, &beam->contact));
    if (!beam->contact) return CML_OK;
    const struct cml_contact_def *port = &scene->contacts[beam->contact - 1];
    const bool round = port->shape == CML_DETECTOR_RING, disk = round && port->size[0] == 0;
    const int above = cml_contact_above(scene, beam->contact);
    beam->shape = disk ? CML_BEAM_DISK : round ? CML_BEAM_RING : CML_BEAM_RECTANGLE;
    beam->size[0] = port->size[disk ? 1 : 0];
    beam->size[1] = disk ? 0 : port->size[1];
    beam->x = port->x;
    beam->y = port->y;
    if (!above) return CML_OK;
    return cml_fail_field(
        reader->err, scene->file, beam->line, "beam: port", beam->port,
        CML_TEXT("a port with no line on top of it; line %d lies on top", scene->contacts[above - 1].line));
}

cml_status cml_mci_check_beams(const struct cml_mci_reader *reader, struct cml_scene *scene)
{
    for (int k = 0; k < scene->num_beams; k++) {
        if (scene->beams[k].of_tile) CML_TRY(fit_to_tile(reader, scene, k));
        CML_TRY(start_in_port(reader, scene, &scene->beams[k]));
        CML_TRY(check_beam(reader, scene, k));
    }
    return CML_OK;
}
