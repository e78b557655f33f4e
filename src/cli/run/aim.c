/* SPDX-License-Identifier: MIT */
#include "cli/run/aim.h"

#include "cli/load/scenes.h"
#include "exact/detector_importance.h"
#include "exact/importance.h"
#include "exact/tail_response.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Whatever is not flat, and where light starts: the deepest point, and the first layer that may be flat below
 * it. */
struct floor {
    int layer;
    double depth;
};

static void sink(struct floor *floor, int layer, double depth)
{
    floor->layer = layer > floor->layer ? layer : floor->layer;
    floor->depth = fmax(floor->depth, depth);
}

/* Parallel light may start below a clear first layer (P1). */
static struct floor find_floor(const struct cml_scene *scene, const struct cml_surface_set *surfaces)
{
    struct floor floor = {1, surfaces->item[0].depth};
    for (int b = 0; b < surfaces->count; b++)
        if (surfaces->item[b].kind != CML_SURFACE_PLANE || cml_is_rough(&surfaces->item[b].rough))
            sink(&floor, b + 1, surfaces->item[b].depth + surfaces->item[b].highest);
    for (int k = 0; k < surfaces->bodies.count; k++)
        sink(&floor, 1, surfaces->bodies.item[k].depth + surfaces->bodies.item[k].upper[2]);
    for (int k = 0; k < scene->num_beams; k++)
        if (scene->beams[k].inside) sink(&floor, 1, scene->beams[k].z + cml_beam_height(&scene->beams[k]));
    if (cml_medium_mut(&scene->media[1]) == 0) sink(&floor, 2, surfaces->item[1].depth);
    return floor;
}

/* In the first layer that goes on below the floor, a sixteenth of a mean free path, or of what is left of it,
 * down: so that no rounding puts a packet beyond the level that has just come through a shape. */
struct cml_aim_level cml_aim_level_of(const struct cml_scene *scene, const struct cml_surface_set *surfaces)
{
    const struct floor floor = find_floor(scene, surfaces);
    if (scene->backing.kind != CML_BACKING_NONE) return (struct cml_aim_level){0};
    for (int l = floor.layer; l <= scene->num_layers; l++) {
        const double top = surfaces->item[l - 1].depth, from = fmax(top, floor.depth),
                     rest = surfaces->item[l].depth - from, mut = cml_medium_mut(&scene->media[l]);
        if (!(rest > 1e-4 * (surfaces->item[l].depth - top))) continue;
        const double z = from - top + fmin(rest, mut > 0 ? 1 / mut : rest) / 16;
        return (struct cml_aim_level){.layer = l, .z = z, .depth = top + z};
    }
    return (struct cml_aim_level){0};
}

/* A packet's counted Tt has the relative variance V; an expected one, 1 / share or less where that share of
 * the light comes down to the level: a third to a seventh of that, in four scenes that were flown both ways.
 */
double cml_aim_proposal(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                        const struct cml_result *result)
{
    const struct cml_aim_level level = cml_aim_level_of(scene, surfaces);
    if (level.layer == 0) return NAN;
    const double relative = cml_result_relative_error(result, CML_TOTAL_TRANSMITTED),
                 d = surfaces->item[level.layer].depth - surfaces->item[level.layer - 1].depth;
    double share = cml_result_total(result, CML_TOTAL_TRANSMITTED) +
                   (1 - level.z / d) * cml_result_absorbed(result, level.layer);
    for (int l = level.layer + 1; l <= scene->num_layers; l++) share += cml_result_absorbed(result, l);
    return share > 0 && relative * relative * (double)result->photons * share > 1 ? level.depth : NAN;
}

static cml_status refuse(const struct cml_scene *scene, const char *aim, int length, const char *expected,
                         struct cml_error *err)
{
    return cml_fail(err, CML_E_INPUT, "%s:%d: --aim %.*s (expected %s)", scene->file, scene->line, length,
                    aim, expected);
}

/* What names ask for: expected values, and windows for light that comes out of so many layers, or that a
 * detector sees. */
struct wanted {
    bool tail;
    int layers, detector, detectors; /* detector: the last one, from 1; detectors: how many */
};

static int find_detector(const struct cml_scene *scene, const char *name, int length)
{
    for (int k = 0; k < scene->num_detectors; k++)
        if ((int)strlen(scene->detectors[k].name) == length &&
            strncmp(scene->detectors[k].name, name, (size_t)length) == 0)
            return k + 1;
    return 0;
}

static cml_status add_detector(const char *name, int length, const struct cml_scene *scene,
                               struct wanted *wanted, struct cml_error *err)
{
    const int detector = find_detector(scene, name, length);
    if (detector == 0)
        return refuse(scene, name, length, "Tt, Tt_r, A_l:N of layer N or the name of a detector", err);
    wanted->detectors += detector != wanted->detector;
    wanted->detector = detector;
    return CML_OK;
}

/* What the tail does not reach is for windows. layer: above which, or whose, light is wanted. */
static void add_layer(int layer, bool reached, struct wanted *wanted)
{
    if (reached)
        wanted->tail = true;
    else if (layer - 1 > wanted->layers)
        wanted->layers = layer - 1;
}

static cml_status add_absorption(const char *name, int length, const struct cml_scene *scene, int level,
                                 struct wanted *wanted, struct cml_error *err)
{
    const int last = scene->num_layers, layer = atoi(name + strlen("A_l:"));
    char expected[64];
    snprintf(expected, sizeof expected,
             last > 2   ? "a layer from 2 to %d, with others above it"
             : last > 1 ? "layer 2, with another above it"
                        : "Tt: there is one layer",
             last);
    if (layer < 2 || layer > last) return refuse(scene, name, length, expected, err);
    add_layer(layer, level > 0 && layer > level, wanted);
    return CML_OK;
}

/* One of the names that the option's reader has let pass. */
static cml_status add_name(const char *name, const struct cml_scene *scene, int level, struct wanted *wanted,
                           struct cml_error *err)
{
    const int length = (int)strcspn(name, ",");
    if (strncmp(name, "A_l:", 4) == 0) return add_absorption(name, length, scene, level, wanted, err);
    if (!(length == 2 && strncmp(name, "Tt", 2) == 0) && !(length == 4 && strncmp(name, "Tt_r", 4) == 0))
        return add_detector(name, length, scene, wanted, err);
    if (find_detector(scene, name, length))
        return refuse(scene, name, length, "another name of the detector: this is the light below", err);
    add_layer(scene->num_layers + 1, length == 2 && level > 0, wanted);
    return CML_OK;
}

/* Squares of packets are no squares of families, and a part of a packet is not to be told from others by its
 * photon. */
static bool wants_packets(const struct cml_scene *scene)
{
    for (int k = 0; k < scene->num_detectors; k++)
        if (scene->detectors[k].shape == CML_DETECTOR_MAP) return true;
    return scene->map.nx > 0 || scene->facets || scene->directions.nt > 0 || scene->saved.limit > 0;
}

/* Where light that goes down from z has forgotten where it came from: after a transport mean free path. */
static double start_of(const struct cml_medium_def *media, int layers, double z)
{
    double left = 1, top = 0;
    for (int l = 1; l <= layers; top += media[l++].d) {
        const double from = fmax(top, z), rest = top + media[l].d - from, mutr = cml_medium_mutr(&media[l]);
        if (rest > 0 && mutr * rest >= left) return from + left / mutr;
        left -= fmax(rest, 0) * mutr;
    }
    return top;
}

static int place_in(double at, int count)
{
    return (int)fmax(0, fmin(at * count, count - 1));
}

/* What the light is worth that starts at the middle of a beam, of the beam whose light is worth most. */
static double worth_of_light(const struct cml_scene *scene, const struct cml_medium_def *media,
                             const struct cml_window_table *windows, const double *importance)
{
    double most = 0;
    for (int k = 0; k < scene->num_beams; k++) {
        const struct cml_beam *beam = &scene->beams[k];
        const double z = beam->inside ? beam->z : start_of(media, windows->layers, 0),
                     r = hypot(beam->x - windows->x, beam->y - windows->y);
        const int ring = place_in(sqrt(r / windows->reach), windows->rings);
        most = fmax(most, importance[ring * windows->cells + place_in(z / windows->depth, windows->cells)]);
    }
    return most;
}

/* Where much light arrives windows gain little, and what is reflected pays for them. */
static double power_of(double worth)
{
    return worth > 1e-2 ? 0.5 : worth > 1e-5 ? 0.75 : 0.9;
}

#define LEAST_WORTH 1e-20

/* power: of detectors, which see little of the light. */
static cml_status fill_windows(const char *aim, const struct cml_scene *scene,
                               const struct cml_medium_def *media, const double *importance,
                               struct cml_window_table *windows, struct cml_error *err)
{
    char expected[80];
    windows->worth = worth_of_light(scene, media, windows, importance);
    snprintf(expected, sizeof expected, "%g of the light or more that gets there, not %.1g", LEAST_WORTH,
             windows->worth);
    if (!(windows->worth > LEAST_WORTH && windows->worth < INFINITY))
        return refuse(scene, aim, (int)strlen(aim), expected, err);
    return cml_window_table_create(importance, windows->worth,
                                   windows->detector ? 1 : power_of(windows->worth), windows, err);
}

static double depth_of(const struct cml_medium_def *media, int layers)
{
    double depth = 0;
    for (int l = 1; l <= layers; l++) depth += media[l].d;
    return depth;
}

/* Of light that comes out below: V, the variance of one packet over the square of its mean, is 0.008 / worth,
 * as packets weigh little there, and becomes about log(V)^2. Nothing where more than 5e-3 of the light
 * arrives. */
static double gain_below(double worth)
{
    const double V = 0.008 / worth, least = 7.4; /* below that the rule turns */
    if (!(worth < 5e-3)) return 0;
    return V > least ? V / pow(log(V), 2) : 2;
}

static cml_status make_windows(const char *aim, const struct cml_scene *scene,
                               const struct cml_medium_def *media, int layers,
                               struct cml_window_table *windows, struct cml_error *err)
{
    double importance[CML_WINDOW_CELLS];
    *windows = (struct cml_window_table){.layers = layers,
                                         .cells = CML_WINDOW_CELLS,
                                         .rings = 1,
                                         .share = 1,
                                         .accepted = 1,
                                         .depth = depth_of(media, layers),
                                         .reach = 1};
    CML_TRY(cml_importance_of_depth(media, layers, CML_WINDOW_CELLS, importance, err));
    CML_TRY(fill_windows(aim, scene, media, importance, windows, err));
    windows->gain = gain_below(windows->worth);
    return CML_OK;
}

enum { RINGS = 128, CELLS = 256 }; /* a cell is a third of a diffusion length, or less, in what was flown */

/* Whether light leaves alike all about the beam's axis. */
static bool is_symmetric(const struct cml_scene *scene, const struct cml_surface_set *surfaces)
{
    const struct cml_beam *beam = scene->beams;
    const bool central = beam->x == 0 && beam->y == 0;
    if (scene->num_beams > 1 || scene->num_bodies > 0 || beam->angle > 0 ||
        beam->shape == CML_BEAM_RECTANGLE || beam->shape == CML_BEAM_IMAGE)
        return false;
    for (int b = 0; b < surfaces->count; b++)
        if (surfaces->item[b].kind != CML_SURFACE_PLANE &&
            !(central && surfaces->item[b].kind == CML_SURFACE_CONE))
            return false;
    return true;
}

static double way_between(const struct cml_beam *beam, const struct cml_detector_def *detector)
{
    return hypot(beam->x - detector->x, beam->y - detector->y);
}

/* Whether of light on a circle about that axis it sees the share that lies in it. */
static bool sees_arcs(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                      const struct cml_detector_def *detector)
{
    return detector->shape == CML_DETECTOR_RING && !(detector->aimed && detector->angle > 0) &&
           way_between(scene->beams, detector) > 0 && is_symmetric(scene, surfaces);
}

/* About the middle of the windows. Rectangles count as disks of their size. */
static struct cml_seen_ring ring_of(const struct cml_detector_def *detector, double away)
{
    const double *size = detector->size;
    const bool ring = detector->shape == CML_DETECTOR_RING;
    const double inner = ring ? size[0] : 0, outer = ring ? size[1] : sqrt(size[0] * size[1] / M_PI);
    if (away == 0) return (struct cml_seen_ring){detector->below, inner, outer};
    return (struct cml_seen_ring){detector->below, fmax(0, away - outer), away + outer};
}

/* From farther away than twice the way from the light, or deeper, hardly anything arrives. */
static double reach_of(const struct cml_scene *scene, const struct cml_detector_def *detector, double outer)
{
    double farthest = outer;
    for (int k = 0; k < scene->num_beams; k++)
        farthest = fmax(farthest, way_between(&scene->beams[k], detector));
    return 2 * (farthest + outer);
}

static double area_of(double inner, double outer)
{
    return outer * outer - inner * inner;
}

/* The share of a detector's gain that its spread about the aim leaves. Of a rectangle the middle is the aim,
 * so a narrow one gains less than a square of its area: at 1 cm on skin five of 1:1 to 1:1300 gained 4.5
 * times the root of that, within a factor of 1.6. */
static double spread_of(const struct cml_detector_def *detector)
{
    const double *size = detector->size, narrow = fmin(size[0], size[1]) / fmax(size[0], size[1]);
    return detector->shape == CML_DETECTOR_RING ? 1 : fmin(1, 4.5 * sqrt(narrow));
}

/* The part of its aperture in light that leaves evenly bright in all directions, as it does where it was
 * scattered: 1 to 1.15 times as much was counted on rough skin. */
static double accepted_by(const struct cml_scene *scene, const struct cml_detector_def *detector)
{
    const double n = scene->media[detector->below ? scene->num_layers + 1 : 0].n,
                 sine = fmin(1, detector->na / n);
    return detector->aimed ? sine * sine * fmax(cos(detector->angle), sine / 5) : 1;
}

/* Cells, but for what packets shall weigh in them. */
static struct cml_window_table lay_out(const struct cml_scene *scene, const struct cml_medium_def *media,
                                       int number, bool arcs, struct cml_seen_ring seen)
{
    const struct cml_detector_def *detector = &scene->detectors[number - 1];
    const double depth = depth_of(media, scene->num_layers), reach = reach_of(scene, detector, seen.outer);
    return (struct cml_window_table){
        .layers = scene->num_layers,
        .detector = number,
        .share = arcs ? area_of(detector->size[0], detector->size[1]) / area_of(seen.inner, seen.outer) : 1,
        .accepted = accepted_by(scene, detector),
        .cells = CELLS,
        .rings = RINGS,
        .depth = detector->below ? depth : fmin(depth, reach),
        .x = arcs ? scene->beams->x : detector->x,
        .y = arcs ? scene->beams->y : detector->y,
        .reach = reach};
}

static double largest(const double *importance)
{
    double most = 0;
    for (int i = 0; i < RINGS * CELLS; i++) most = fmax(most, importance[i]);
    return most;
}

/* A plain packet has V = weight / (worth accepted), `weight` what packets weigh that arrive, by weight. Of
 * one in windows `most` / 3 parts arrive, of families that part late, so that each goes into the aperture by
 * its own luck, in a time that grows with every decade. The numbers are fitted to six fibres of 0.01 to 0.05
 * cm at 0.15 to 1 cm on rough skin, each without an aperture and with 0.5 and 0.22, within a factor of 1.8;
 * with seven others it was within 2.4. */
static double gain_at(const struct cml_detector_def *detector, const struct cml_window_table *windows,
                      double weight, double most)
{
    const double plain = weight / (windows->worth * windows->accepted),
                 aimed = (3.5 + 3 / windows->accepted) / most, longer = fmax(0.8, -log(windows->worth) / 6),
                 gain = spread_of(detector) * plain / aimed / longer;
    if (windows->share < 1) return fmax(1, gain) / windows->share;
    return gain < 1 ? 0 : gain;
}

/* The mean weight, by weight, of plain packets that come to the detector, for weights fall as their light
 * does: what arrives where all absorbs twice as much, over what does. The roulette keeps it above 0.008. */
static cml_status weigh_plain(const struct cml_scene *scene, const struct cml_medium_def *media,
                              struct cml_seen_ring seen, const struct cml_window_table *windows,
                              double *importance, double *weight, struct cml_error *err)
{
    const size_t count = (size_t)scene->num_layers + 2;
    struct cml_medium_def *dark = malloc(count * sizeof *dark);
    if (!dark) return cml_fail_memory(err, (double)(count * sizeof *dark), "layers");
    memcpy(dark, media, count * sizeof *dark);
    for (size_t l = 0; l < count; l++) dark[l].mua *= 2;
    const cml_status status = cml_importance_of_place(dark, scene->num_layers, seen, windows->reach,
                                                      windows->depth, RINGS, CELLS, importance, err);
    *weight = fmax(0.008, worth_of_light(scene, media, windows, importance) / windows->worth);
    free(dark);
    return status;
}

static cml_status aim_at_detector(const char *aim, const struct cml_scene *scene,
                                  const struct cml_surface_set *surfaces, const struct cml_medium_def *media,
                                  int number, struct cml_window_table *windows, struct cml_error *err)
{
    const struct cml_detector_def *detector = &scene->detectors[number - 1];
    const bool arcs = sees_arcs(scene, surfaces, detector);
    const struct cml_seen_ring seen = ring_of(detector, arcs ? way_between(scene->beams, detector) : 0);
    double *importance = malloc(RINGS * CELLS * sizeof *importance);
    if (!importance) return cml_fail_memory(err, RINGS * CELLS * sizeof *importance, "weight windows");
    *windows = lay_out(scene, media, number, arcs, seen);
    cml_status status = cml_importance_of_place(media, scene->num_layers, seen, windows->reach,
                                                windows->depth, RINGS, CELLS, importance, err);
    if (status == CML_OK) status = fill_windows(aim, scene, media, importance, windows, err);
    const double most = largest(importance);
    double weight = 1;
    if (status == CML_OK) status = weigh_plain(scene, media, seen, windows, importance, &weight, err);
    windows->gain = gain_at(detector, windows, weight, most);
    free(importance);
    return status;
}

/* Makes the windows, which split packets, for the aim. */
static cml_status aim_windows(const char *aim, const struct cml_scene *scene,
                              const struct cml_surface_set *surfaces, const struct cml_medium_def *media,
                              struct wanted wanted, struct cml_window_table *windows, struct cml_error *err)
{
    const int length = (int)strlen(aim);
    if (wants_packets(scene))
        return refuse(scene, aim, length,
                      "no map, facets, directions, photons and maps of detectors beside what splits packets",
                      err);
    if (wanted.detectors > 1 || (wanted.detectors > 0 && wanted.layers > 0))
        return refuse(scene, aim, length,
                      "one detector, and beside it only what flat layers below all shapes give", err);
    return wanted.detectors > 0 ? aim_at_detector(aim, scene, surfaces, media, wanted.detector, windows, err)
                                : make_windows(aim, scene, media, wanted.layers, windows, err);
}

/* The next of names that commas part. */
static const char *after(const char *name)
{
    name += strcspn(name, ",");
    return name + (*name == ',');
}

static cml_status check_worth(const char *name, const struct cml_scene *scene, int level,
                              const struct cml_flat_tail *tail, struct cml_error *err)
{
    const int length = (int)strcspn(name, ","), layer = strncmp(name, "A_l:", 4) == 0 ? atoi(name + 4) : 0;
    const int score = layer ? layer - level : length == 2 && strncmp(name, "Tt", 2) == 0 ? 0 : -1;
    char expected[80];
    if (score < (layer ? 1 : 0) || cml_flat_tail_has(tail, score)) return CML_OK;
    snprintf(expected, sizeof expected, "%g of the light or more that gets there, not less", CML_TAIL_LEAST);
    return refuse(scene, name, length, expected, err);
}

/* media: of the flat scene. tail: it is wanted, too, which takes longest, and which no scene is refused for
 * but by its numbers. */
static cml_status create(const char *aim, const struct cml_scene *scene,
                         const struct cml_surface_set *surfaces, const struct cml_medium_def *media,
                         bool tail, struct cml_aim *to, struct cml_error *err)
{
    const struct cml_aim_level level = cml_aim_level_of(scene, surfaces);
    struct wanted wanted = {0};
    if (scene->backing.kind != CML_BACKING_NONE)
        return refuse(scene, aim, (int)strlen(aim), "no backing", err);
    for (const char *name = aim; *name; name = after(name))
        CML_TRY(add_name(name, scene, level.layer, &wanted, err));
    if (wanted.layers > 0 || wanted.detectors > 0)
        CML_TRY(aim_windows(aim, scene, surfaces, media, wanted, &to->windows, err));
    if (!(wanted.tail && tail)) return CML_OK;
    CML_TRY(cml_tail_create(media, scene->num_layers, level.layer, level.z, &to->tail, err));
    for (const char *name = aim; *name; name = after(name))
        CML_TRY(check_worth(name, scene, level.layer, &to->tail, err));
    return CML_OK;
}

static cml_status create_of(const char *aim, const struct cml_scene *scene,
                            const struct cml_surface_set *surfaces, bool tail, struct cml_aim *to,
                            struct cml_error *err)
{
    const size_t count = (size_t)scene->num_layers + 2;
    struct cml_medium_def *media = malloc(count * sizeof *media);
    *to = (struct cml_aim){0};
    if (!media) return cml_fail_memory(err, (double)(count * sizeof *media), "layers");
    memcpy(media, scene->media, count * sizeof *media);
    for (int l = 1; l <= scene->num_layers; l++)
        media[l].d = surfaces->item[l].depth - surfaces->item[l - 1].depth;
    const cml_status status = create(aim, scene, surfaces, media, tail, to, err);
    free(media);
    if (status != CML_OK) cml_aim_clear(to);
    return status;
}

cml_status cml_aim_create(const char *aim, const struct cml_scene *scene,
                          const struct cml_surface_set *surfaces, struct cml_aim *to, struct cml_error *err)
{
    return create_of(aim, scene, surfaces, true, to, err);
}

/* Makes the aim of a run. Without adding-doubling's answer nothing flies, so it is the scene that is refused.
 */
static cml_status create_for(const struct cml_options *options, const struct cml_scene *scene,
                             const struct cml_surface_set *surfaces, bool tail, struct cml_aim *to,
                             struct cml_error *err)
{
    *to = (struct cml_aim){0};
    const cml_status status = options->aim ? create_of(options->aim, scene, surfaces, tail, to, err) : CML_OK;
    if (status == CML_E_NUMERIC) {
        const struct cml_error why = *err;
        return cml_fail(err, CML_E_INPUT, "%s:%d: --aim %s: %.400s", scene->file, scene->line, options->aim,
                        why.text);
    }
    if (to->windows.cells == 0 || !options->engine_options.derivatives) return status;
    cml_aim_clear(to);
    return cml_fail(err, CML_E_INPUT, "--derivatives (expected no --aim beside it that splits packets)");
}

cml_status cml_aim_for_run(const struct cml_options *options, const struct cml_scene *scene,
                           const struct cml_surface_set *surfaces, struct cml_aim *to, struct cml_error *err)
{
    return create_for(options, scene, surfaces, true, to, err);
}

void cml_aim_use(const struct cml_aim *aim, struct cml_engine_options *options)
{
    if (aim->tail.scores > 0) options->tail = &aim->tail;
    if (aim->windows.cells > 0) options->windows = &aim->windows;
}

cml_status cml_find_error_of(const struct cml_options *options, const struct cml_scene *scene, int *of,
                             struct cml_error *err)
{
    const char *name = options->error_of;
    *of = 0;
    if (!name) return CML_OK;
    *of = strncmp(name, "A_l:", 4) == 0 ? atoi(name + 4) : -find_detector(scene, name, (int)strlen(name));
    if (*of != 0 && *of <= scene->num_layers) return CML_OK;
    return cml_fail(err, CML_E_INPUT,
                    "%s:%d: --error-of %s (expected A_l:N of layer 1 to %d, or the name of a detector)",
                    scene->file, scene->line, name, scene->num_layers);
}

cml_status cml_aim_check(const struct cml_options *options, const struct cml_scene *scene,
                         const struct cml_surface_set *shared, struct cml_error *err)
{
    struct cml_options mine = *options;
    struct cml_surface_set surfaces;
    struct cml_aim aim;
    if (!options->aim) return CML_OK;
    mine.surface.shared = shared;
    CML_TRY(cml_choose_surfaces(&mine, scene, &surfaces, err));
    const cml_status status = create_for(options, scene, &surfaces, false, &aim, err);
    cml_surfaces_free(&surfaces);
    if (status == CML_OK) cml_aim_clear(&aim);
    return status;
}

void cml_aim_clear(struct cml_aim *aim)
{
    cml_flat_tail_clear(&aim->tail);
    cml_window_table_clear(&aim->windows);
}

/* A refusal is the answer: no. */
static bool would_gain(const struct cml_scene *scene, const struct cml_surface_set *surfaces, int k)
{
    struct cml_error refusal;
    struct cml_aim aim;
    if (cml_aim_create(scene->detectors[k].name, scene, surfaces, &aim, &refusal) != CML_OK) return false;
    const bool gain = aim.windows.detector && aim.windows.gain > 0;
    cml_aim_clear(&aim);
    return gain;
}

int cml_aim_unseen(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                   const struct cml_result *result)
{
    const int detectors = scene->num_detectors;
    for (int k = 0; k < detectors; k++)
        if (cml_result_bin_sum(result->detector, detectors, k) == 0)
            return would_gain(scene, surfaces, k) ? k + 1 : 0;
    return 0;
}
