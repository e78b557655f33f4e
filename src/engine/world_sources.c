/* Beams as the kernels read them (struct cml_source), with the tables of their light and the sums of their
 * images. Beams that cannot start at their place are refused here.
 * SPDX-License-Identifier: MIT */
#include "engine/world_parts.h"

#include "base/constants.h"
#include "scene/specular.h"
#include "source.h"
#include "surface/surface.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define FINEST_CELL                                                                                          \
    0.005 /* rad: in a part this small, a density linear in the angle is also linear in its cosine */

/* Returns the lowest random word that belongs to the share from `below` of `all` on. */
static cml_u32 word_of(double below, double all)
{
    return (cml_u32)fmin(floor(below / all * 4294967296.0 + 0.5), 4294967295.0);
}

/* ---- images ---- */

/* Fills words[1 + count]: the number of parts in use, and the lowest word that leads to each. Parts after the
 * last one with light are out of use. A dark part before it begins at the same word as the next part, and is
 * never chosen. */
static void sum_parts(const double *part, int count, cml_u32 *words)
{
    double all = 0, below = 0;
    for (int i = 0; i < count; i++) {
        all += part[i];
        if (part[i] > 0) words[0] = (cml_u32)i + 1;
    }
    for (int i = 0; all > 0 && i < count; i++) {
        words[1 + i] = word_of(below, all);
        below += part[i];
    }
}

/* Returns the number of words that the image of a beam takes; 0 without one. */
static size_t image_words(const struct cml_beam *beam)
{
    return beam->shape == CML_BEAM_IMAGE
               ? 1 + (size_t)beam->rows + (size_t)beam->rows * (1 + (size_t)beam->columns)
               : 0;
}

/* Sums the pixels of a beam's image into words by which packets draw a row, then a column of the row: first
 * the sums over rows, then those of each row. */
static cml_status sum_image(const struct cml_beam *beam, cml_u32 *words, struct cml_error *err)
{
    const size_t columns = (size_t)beam->columns;
    CML_FREED double *row = calloc((size_t)beam->rows, sizeof *row);
    if (!row) return cml_fail_memory(err, beam->rows * 8.0, "an image");
    for (int i = 0; i < beam->rows; i++)
        for (size_t k = 0; k < columns; k++) row[i] += beam->pixel[(size_t)i * columns + k];
    sum_parts(row, beam->rows, words);
    words += 1 + beam->rows;
    for (int i = 0; i < beam->rows; i++, words += 1 + columns)
        sum_parts(beam->pixel + (size_t)i * columns, beam->columns, words);
    return CML_OK;
}

/* ---- tables ---- */

/* Returns the number of parts between rows i and i + 1 of a table. */
static int cells_of_row(const struct cml_light *light, int i)
{
    return (int)ceil((light->t[i + 1] - light->t[i]) / FINEST_CELL);
}

/* Returns the most cells that the table of a light takes; 0 without one. */
static size_t light_cells(const struct cml_light *light)
{
    size_t count = 0;
    for (int i = 0; i + 1 < light->rows; i++) count += (size_t)cells_of_row(light, i);
    return light->kind == CML_LIGHT_OF_TABLE ? count : 0;
}

/* Returns the integral of (a + b t) sin t from t0 to t1, which lie close together: by Simpson's rule, exact
 * to 1e-12 of it. */
static double light_between(double a, double b, double t0, double t1)
{
    const double middle = 0.5 * (t0 + t1);
    return (t1 - t0) / 6 *
           ((a + b * t0) * sin(t0) + 4 * (a + b * middle) * sin(middle) + (a + b * t1) * sin(t1));
}

/* Appends the cells of a light's table between two of its rows, from which packets draw their angle; dark
 * cells are left out. *below: the light of all cells before. Returns the number of cells. */
static int cut_row(const struct cml_light *light, int row, struct cml_light_cell *cell, double *sum,
                   double *below)
{
    const double t0 = light->t[row], t1 = light->t[row + 1], i0 = light->intensity[row],
                 i1 = light->intensity[row + 1], slope = (i1 - i0) / (t1 - t0);
    const int parts = cells_of_row(light, row);
    int count = 0;
    for (int k = 0; k < parts; k++) {
        const double from = t0 + (t1 - t0) * k / parts, to = t0 + (t1 - t0) * (k + 1) / parts;
        const double begin = i0 + slope * (from - t0), end = fmax(0, i0 + slope * (to - t0));
        const double shines = light_between(begin - slope * from, slope, from, to),
                     v0 = 2 * pow(sin(from / 2), 2), v1 = 2 * pow(sin(to / 2), 2), scale = fmax(begin, end);
        if (!(shines > 0)) continue;
        cell[count] =
            (struct cml_light_cell){0, (real)v0, (real)(v1 - v0), (real)(begin / scale), (real)(end / scale)};
        sum[count++] = *below;
        *below += shines;
    }
    return count;
}

/* Cuts a light's table into cells from which packets draw their angle, and leaves out cells that no random
 * word leads to. Returns the number of cells. */
static int cut_table(const struct cml_light *light, struct cml_light_cell *cell, double *sum)
{
    double all = 0;
    int count = 0, used = 0;
    for (int i = 0; i + 1 < light->rows; i++) count += cut_row(light, i, cell + count, sum + count, &all);
    sum[count] = all;
    for (int i = 0; i < count; i++) {
        const cml_u32 first = word_of(sum[i], all);
        if (i + 1 < count && first == word_of(sum[i + 1], all)) continue;
        cell[used] = cell[i];
        cell[used++].first = first;
    }
    return used;
}

/* ---- the start of packets ---- */

/* Finds the medium in which packets start below planes, and the weights that are split off before (P1). n:
 * index of the medium from which they come. */
static void split_specular(const struct cml_scene *scene, double n, const struct cml_surface_set *start_as,
                           struct cml_source *source)
{
    const bool planes = scene->num_layers > 1 && start_as->item[1].kind == CML_SURFACE_PLANE &&
                        !cml_is_rough(&start_as->item[1].rough) && !cml_layer_has_bodies(scene, 1);
    const struct cml_specular split = cml_specular_split(scene->media, n, scene->num_layers, planes);
    source->medium = split.glass ? 2 : 1;
    source->specular = (cml_u32)lrint(split.reflected * CML_WEIGHT_ONE);
    source->between = (cml_u32)lrint(split.between * CML_WEIGHT_ONE);
}

/* Sets the two sizes a and b of a source by its beam's shape, in the form the drawing of places needs: for a
 * ring the squared inner radius and the difference of squares, for a rectangle half widths, for an image the
 * size of a pixel. */
static void set_shape(const struct cml_beam *beam, struct cml_source *source)
{
    const double a = beam->size[0], b = beam->size[1];
    source->shape = (int)beam->shape;
    source->a = (real)a;
    if (beam->shape == CML_BEAM_RING) {
        source->a = (real)(a * a);
        source->b = (real)((b - a) * (b + a));
    } else if (beam->shape == CML_BEAM_RECTANGLE) {
        source->a = (real)(a / 2);
        source->b = (real)(b / 2);
    } else if (beam->shape == CML_BEAM_IMAGE) {
        source->nx = beam->columns;
        source->ny = beam->rows;
        source->a = (real)(a / beam->columns);
        source->b = (real)(b / beam->rows);
    }
}

/* Sets how the directions of a source's light are drawn: parallel, even in a cone, by cosine, or by a table.
 * Isotropic light is even in a cone of width 1 - cos = 2. */
static void set_light(const struct cml_light *light, struct cml_source *source)
{
    static const int lights[] = {CML_LIGHT_PARALLEL, CML_LIGHT_EVEN, CML_LIGHT_COSINE, CML_LIGHT_EVEN,
                                 CML_LIGHT_TABLE};
    source->light = lights[light->kind];
    source->aperture = (real)light->na;
    source->spread = (real)(light->kind == CML_LIGHT_OF_ISOTROPIC ? 2 : 0);
}

/* Sets the axis of a source, and two unit vectors across it, along which its shape lies. */
static void set_axis(const struct cml_beam *beam, struct cml_source *source)
{
    /* The azimuth of an upright axis turns no port. */
    const double azimuth = beam->contact && beam->angle == 0 ? 0 : beam->azimuth;
    const double st = cml_beam_sine(beam), ct = cml_beam_descent(beam), sp = sin(azimuth), cp = cos(azimuth);
    source->axis = cml_vec_of(st * cp, st * sp, ct);
    source->e1 = cml_vec_of(ct * cp, ct * sp, -st);
    source->e2 = cml_vec_of(-sp, cp, 0);
}

/* ---- inside ---- */

/* Returns the layer or outer medium at the beam's place plus `off`, by the depth. *at: this place in the
 * medium's frame. */
static int layer_at(const struct cml_world *world, const struct cml_beam *beam, const double off[3],
                    struct cml_vec *at)
{
    int medium = 0;
    while (medium <= world->setup.num_layers && beam->z + off[2] >= (double)world->media[medium + 1].depth)
        medium++;
    *at = cml_vec_of(beam->x + off[0] - (double)world->setup.x0, beam->y + off[1] - (double)world->setup.y0,
                     beam->z + off[2] - (double)world->media[medium].depth);
    return medium;
}

/* Returns the medium at a place near a beam's middle. off: difference from the middle, cm. */
static int medium_beside(const struct cml_world *world, const struct cml_beam *beam, const double off[3])
{
    struct cml_vec at;
    const int medium = layer_at(world, beam, off, &at);
    return cml_medium_at(world, medium, &at);
}

/* Returns the least allowed distance (cm) of a start from a surface. The first term is twice the distance
 * at which a mesh takes a packet to be on a facet (err_position of surface/tree/rounding.h). The second
 * term covers the rounding of a place whose numbers are nearly 0. Both terms are those of single
 * precision, also in the engine in double precision, so that all engines refuse the same beams. */
static double least_gap(const struct cml_scene *scene, const struct cml_world *world,
                        const struct cml_beam *beam)
{
    return 8 * (double)FLT_EPSILON *
               (fabs(beam->x - (double)world->setup.x0) + fabs(beam->y - (double)world->setup.y0) +
                fabs(beam->z)) +
           1e-9 * fmax(scene->nr * scene->dr, scene->nz * scene->dz);
}

/* Refuses a beam that starts on a surface, where its medium is uncertain. Tests the 3 x 3 x 3 points of a
 * cube with half side `gap` about the start: if one of them lies in another medium, a surface is near. */
static cml_status check_place(const struct cml_scene *scene, const struct cml_world *world,
                              const struct cml_beam *beam, int medium, struct cml_error *err)
{
    const double gap = least_gap(scene, world, beam);
    char value[120], expected[120];
    for (int k = 0; k < 27; k++) {
        const double off[3] = {gap * (k % 3 - 1), gap * (k / 3 % 3 - 1), gap * (k / 9 - 1)};
        if (medium_beside(world, beam, off) == medium) continue;
        snprintf(value, sizeof value, "(%g %g %g)", beam->x, beam->y, beam->z);
        snprintf(expected, sizeof expected,
                 "a place inside a medium, more than %.2g cm from its surface; it lies on one", gap);
        return cml_fail_field(err, scene->file, beam->line, "beam: at z", value, expected);
    }
    return CML_OK;
}

/* Refuses light that starts below a backing. If the shape of the beam has a height, all of the shape must
 * lie above the highest point of the boundary with the backing. Bodies lie in layers, so a start in a body
 * is above the backing. */
static cml_status check_backing(const struct cml_scene *scene, const struct cml_world *world,
                                const struct cml_beam *beam, int medium, struct cml_error *err)
{
    const int last = scene->num_layers;
    const double highest = (double)world->media[last + 1].depth + (double)world->surfaces[last].lowest;
    const double height = cml_beam_height(beam);
    char value[40];
    if (scene->backing.kind == CML_BACKING_NONE ||
        (medium != last + 1 && (height == 0 || beam->z + height < highest)))
        return CML_OK;
    snprintf(value, sizeof value, "%g", beam->z);
    return cml_fail_field(err, scene->file, beam->line, "beam: z", value,
                          "a source that lies above the backing with all its points");
}

/* Refuses a numerical aperture above the index of the medium at the start. */
static cml_status check_aperture(const struct cml_scene *scene, const struct cml_beam *beam, int medium,
                                 struct cml_error *err)
{
    const double n = scene->media[medium].n;
    char value[40], expected[120];
    if (beam->light.kind != CML_LIGHT_OF_NA || beam->light.na <= n) return CML_OK;
    snprintf(value, sizeof value, "na:%g", beam->light.na);
    snprintf(expected, sizeof expected, "at most n = %g of the medium that it starts in", n);
    return cml_fail_field(err, scene->file, beam->line, "beam: light", value, expected);
}

/* ---- far away ---- */

/* Finds the depths in the scene between which paths matter: all heights of the outer boundaries, as far again
 * beyond them, and all bins. */
static void find_levels(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                        double level[2])
{
    const struct cml_surface_def *top = &surfaces->item[0], *bottom = &surfaces->item[scene->num_layers];
    const double first = scene->map.volume ? scene->map.top : 0, bins = scene->nz * scene->dz;
    level[0] = fmin(top->depth + 2 * top->lowest - top->highest, fmin(first, 0));
    level[1] = fmax(bottom->depth + 2 * bottom->highest - bottom->lowest, fmax(first, 0) + bins);
}

/* Returns the distance (cm) along the axis from the middle of a beam's shape to the level where the scene
 * begins for it: level[0] if the shape lies above this depth and heads down, level[1] if it lies below
 * that depth and heads up; else 0. */
static double way_to_level(const struct cml_beam *beam, const double level[2])
{
    const double height = cml_beam_height(beam), down = cml_beam_descent(beam);
    if (down > 0 && level[0] > beam->z + height) return (level[0] - beam->z) / down;
    if (down < 0 && level[1] < beam->z - height) return (level[1] - beam->z) / down;
    return 0;
}

/* Places a source that is far from the scene: packets start where its axis comes to the level `level`, found
 * in double precision. Refuses a source so far that even double precision loses the place. */
static cml_status place_far(const struct cml_scene *scene, const struct cml_beam *beam,
                            const struct cml_surface_set *surfaces, const double level[2], double way,
                            struct cml_source *source, struct cml_error *err)
{
    const int below = beam->z > level[1], last = below ? scene->num_layers : 0;
    const double *origin = surfaces->origin.at, drop = fabs(level[below] - beam->z);
    const double side = way * cml_beam_sine(beam), slope = side / drop;
    const double step = side > 0 ? 2 * DBL_EPSILON * (fabs(beam->x) + fabs(beam->y) + side * (1 + slope)) : 0;
    char value[40], expected[160];
    source->is_far = 1;
    source->ahead = (real)way;
    source->medium = below ? last + 1 : 0;
    source->start = (real)(level[below] - surfaces->item[last].depth);
    source->middle = cml_vec_of(beam->x + side * cos(beam->azimuth) - origin[0],
                                beam->y + side * sin(beam->azimuth) - origin[1],
                                level[below] - surfaces->item[last].depth);
    if (step <= surfaces->origin.all * (double)FLT_EPSILON) return CML_OK;
    snprintf(value, sizeof value, "%g", beam->z);
    snprintf(expected, sizeof expected,
             "a nearer source: its axis must meet the scene at a place known to %.2g cm, which double "
             "precision knows to %.2g cm",
             surfaces->origin.all * (double)FLT_EPSILON, step);
    return cml_fail_field(err, scene->file, beam->line, "beam: z", value, expected);
}

/* Refuses light that may fly so far in one go that single precision tells shapes, bodies and detectors too
 * coarsely where it arrives. Light that has more than 20 free paths to fly is not refused, because few
 * packets fly that far in one go. */
static cml_status check_flight(const struct cml_scene *scene, const struct cml_beam *beam,
                               const struct cml_origin *origin, double distance, double mut,
                               struct cml_error *err)
{
    char value[120], expected[200];
    if (!(distance > origin->flight) || mut * distance > 20) return CML_OK;
    snprintf(value, sizeof value, "(%g %g %g)", beam->x, beam->y, beam->z);
    snprintf(
        expected, sizeof expected,
        "light that starts at most %.3g cm from (%g %g) and the top of its layer; it starts %.3g cm away, "
        "where single precision has steps of %.2g cm",
        origin->flight, origin->at[0], origin->at[1], distance, distance * (double)FLT_EPSILON);
    return cml_fail_field(err, scene->file, beam->line, "beam: place", value, expected);
}

/* ---- near ---- */

/* Fills in a beam that starts inside the scene, at a depth of its own: where it starts, in which medium, and
 * how it is drawn. */
static cml_status place_inside(const struct cml_scene *scene, const struct cml_beam *beam,
                               const struct cml_surface_set *surfaces, const struct cml_world *world,
                               struct cml_source *source, struct cml_error *err)
{
    static const double none[3] = {0, 0, 0};
    const struct cml_origin *origin = &surfaces->origin;
    double level[2];
    source->inside = 1;
    source->medium = layer_at(world, beam, none, &source->middle);
    const int medium = medium_beside(world, beam, none);
    const double away = fmax(fmax(fabs(beam->x - origin->at[0]), fabs(beam->y - origin->at[1])),
                             fabs(beam->z - (double)world->media[medium].depth));
    find_levels(scene, surfaces, level);
    const double way = away > origin->all ? way_to_level(beam, level) : 0;
    if (way == 0) CML_TRY(check_place(scene, world, beam, medium, err));
    CML_TRY(check_backing(scene, world, beam, medium, err));
    CML_TRY(check_aperture(scene, beam, medium, err));
    if (way > 0) return place_far(scene, beam, surfaces, level, way, source, err);
    CML_TRY(check_flight(scene, beam, origin, away, cml_medium_mut(&scene->media[medium]), err));
    source->is_pencil = beam->shape == CML_BEAM_PENCIL;
    if (!source->is_pencil) return CML_OK;
    source->medium = medium;
    source->middle.z = (real)(beam->z - (double)world->media[medium].depth);
    return CML_OK;
}

/* Places a beam from above. A packet that is traced to boundary 0 starts above all of it, by the height of
 * the boundary. */
static cml_status place_above(const struct cml_scene *scene, const struct cml_beam *beam,
                              const struct cml_surface_set *surfaces, const struct cml_surface_set *start_as,
                              struct cml_source *source, struct cml_error *err)
{
    const struct cml_surface_def *top = &surfaces->item[0];
    const double *origin = surfaces->origin.at, start = 2 * top->lowest - top->highest;
    source->middle = cml_vec_of(beam->x - origin[0], beam->y - origin[1], 0);
    source->start = (real)start;
    CML_TRY(check_flight(scene, beam, &surfaces->origin, fabs(start) * tan(beam->angle), 0, err));
    if (start_as->item[0].kind == CML_SURFACE_PLANE && !cml_is_rough(&start_as->item[0].rough) &&
        beam->angle == 0 && beam->light.kind == CML_LIGHT_OF_PARALLEL)
        split_specular(scene, cml_beam_index(scene, beam), start_as, source);
    return CML_OK;
}

/* Makes a beam from above start in its port. Places and angles lie in axes of their own, and the aperture
 * counts in the medium of the port, so the widest angle is found here. */
static void set_port(const struct cml_scene *scene, const struct cml_beam *beam, struct cml_source *source)
{
    const double sine = beam->light.na / cml_beam_index(scene, beam);
    source->port = beam->contact;
    if (beam->contact && source->light == CML_LIGHT_EVEN)
        source->spread = (real)(sine * sine / (1 + sqrt(1 - sine * sine)));
}

/* ---- all beams ---- */

double cml_source_bytes(const struct cml_scene *scene)
{
    double bytes = 0;
    for (int k = 0; k < scene->num_beams; k++)
        bytes +=
            (double)sizeof(struct cml_source) +
            (double)light_cells(&scene->beams[k].light) * (sizeof(struct cml_light_cell) + sizeof(double)) +
            (double)image_words(&scene->beams[k]) * sizeof(cml_u32);
    return bytes;
}

/* Allocates the arrays of beams that kernels read. Tables of light and images of all beams lie one behind
 * the other. */
static cml_status allocate_sources(const struct cml_scene *scene, struct cml_owned_world *to,
                                   struct cml_error *err)
{
    for (int k = 0; k < scene->num_beams; k++) {
        to->num_light_cells += light_cells(&scene->beams[k].light);
        to->num_image_words += image_words(&scene->beams[k]);
    }
    to->sources = cml_arrays_add(&to->arrays, (size_t)scene->num_beams, sizeof *to->sources);
    to->light_cells = cml_arrays_add(&to->arrays, to->num_light_cells, sizeof *to->light_cells);
    to->image_words = cml_arrays_add(&to->arrays, to->num_image_words, sizeof *to->image_words);
    return cml_arrays_check(&to->arrays, "the beams", err);
}

/* Makes the tables of light and the sums of images of all beams in the form that kernels read. All beams
 * share two arrays, and each source knows where its own part begins. */
static cml_status fill_tables(const struct cml_scene *scene, struct cml_owned_world *to,
                              struct cml_error *err)
{
    size_t cell = 0, word = 0;
    CML_FREED double *sum = calloc(to->num_light_cells + 1, sizeof *sum);
    if (!sum) return cml_fail_memory(err, (double)to->num_light_cells * 8, "a table");
    for (int k = 0; k < scene->num_beams; k++) {
        const struct cml_beam *beam = &scene->beams[k];
        struct cml_source *source = &to->sources[k];
        source->first_cell = (int)cell;
        source->first_word = (int)word;
        if (beam->light.kind == CML_LIGHT_OF_TABLE)
            source->num_cells = cut_table(&beam->light, to->light_cells + cell, sum);
        if (beam->shape == CML_BEAM_IMAGE) CML_TRY(sum_image(beam, to->image_words + word, err));
        cell += light_cells(&beam->light);
        word += image_words(beam);
    }
    return CML_OK;
}

int cml_source_medium(const struct cml_world *world, const struct cml_beam *beam)
{
    static const double no_offset[3] = {0, 0, 0};
    return beam->inside ? medium_beside(world, beam, no_offset) : 0;
}

/* Refuses a beam of which faces and ports stop all. */
static cml_status check_stops(const struct cml_scene *scene, const struct cml_world *world,
                              struct cml_error *err)
{
    for (int k = 0; k < scene->num_beams; k++) {
        const struct cml_beam *beam = &scene->beams[k];
        const int number = cml_contact_at(world, (real)beam->x, (real)beam->y);
        int passes;
        (void)cml_stopped_share(world, k, &passes);
        if (!passes) /* the default pencil has no line */
            return cml_fail_field(
                err, scene->file, beam->line || number == 0 ? beam->line : scene->contacts[number - 1].line,
                "beam", "nothing of it passes boundary 0",
                "light that the open plane lets in; light of a fibre starts in its port: write "
                "beam port NAME");
    }
    return CML_OK;
}

cml_status cml_set_sources(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                           const struct cml_surface_set *start_as, struct cml_owned_world *to,
                           struct cml_error *err)
{
    struct cml_setup *setup = &to->world.setup;
    CML_TRY(allocate_sources(scene, to, err));
    CML_TRY(fill_tables(scene, to, err));
    to->world.sources = to->sources;
    to->world.light_cells = to->light_cells;
    to->world.image_words = to->image_words;
    setup->num_sources = scene->num_beams;
    for (int k = 0; k < scene->num_beams; k++) {
        const struct cml_beam *beam = &scene->beams[k];
        struct cml_source *source = &to->sources[k];
        set_shape(beam, source);
        set_light(&beam->light, source);
        set_axis(beam, source);
        if (beam->inside)
            CML_TRY(place_inside(scene, beam, surfaces, &to->world, source, err));
        else
            CML_TRY(place_above(scene, beam, surfaces, start_as, source, err));
        source->is_common = !beam->inside && beam->light.kind == CML_LIGHT_OF_PARALLEL &&
                            beam->shape <= CML_BEAM_GAUSSIAN && !(beam->contact && beam->angle > 0);
        set_port(scene, beam, source);
    }
    const struct cml_source *first = to->sources;
    const bool may_stop = scene->num_contacts > 0 && first->medium > 0 && !first->inside && !first->port &&
                          first->shape != CML_BEAM_PENCIL;
    setup->apart = scene->num_beams > 1 || may_stop;
    if (!setup->apart) setup->specular = first->specular;
    return scene->num_contacts > 0 ? check_stops(scene, &to->world, err) : CML_OK;
}
