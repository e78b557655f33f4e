/* Makes weight windows from importances: the cells, the weights, and the expected gain.
 * SPDX-License-Identifier: MIT */
#include "aim/windows.h"

#include "aim/gain.h"
#include "exact/detector_importance.h"
#include "exact/importance.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

cml_status cml_aim_refuse(const struct cml_scene *scene, const char *aim, int length, const char *expected,
                          struct cml_error *err)
{
    return cml_fail(err, CML_E_INPUT, "%s:%d: --aim %.*s (expected %s)", scene->file, scene->line, length,
                    aim, expected);
}

/* Returns the depth, cm, at which light that goes down from depth z has lost its direction: one transport
 * mean free path further down. */
static double diffuse_depth(const struct cml_medium_def *media, int layers, double z)
{
    double left = 1, top = 0;
    for (int l = 1; l <= layers; top += media[l++].d) {
        const double from = fmax(top, z), rest = top + media[l].d - from, mutr = cml_medium_mutr(&media[l]);
        if (rest > 0 && mutr * rest >= left) return from + left / mutr;
        left -= fmax(rest, 0) * mutr;
    }
    return top;
}

/* Returns the cell of `at`, a share of the whole, among `count` cells. */
static int place_in(double at, int count)
{
    return (int)fmax(0, fmin(at * count, count - 1));
}

/* Returns the importance of light where it starts: the largest over all beams, each taken at its middle.
 * importance[ring * cells + cell]: share of the light at a place that reaches the target. */
static double worth_of_light(const struct cml_scene *scene, const struct cml_medium_def *media,
                             const struct cml_window_table *windows, const double *importance)
{
    double most = 0;
    for (int k = 0; k < scene->num_beams; k++) {
        const struct cml_beam *beam = &scene->beams[k];
        const double z = beam->inside ? beam->z : diffuse_depth(media, windows->layers, 0),
                     r = hypot(beam->x - windows->x, beam->y - windows->y);
        const int ring = place_in(sqrt(r / windows->reach), windows->rings);
        most = fmax(most, importance[ring * windows->cells + place_in(z / windows->depth, windows->cells)]);
    }
    return most;
}

#define LEAST_WORTH 1e-20

/* Makes windows from the importance of light at each place. Refuses an aim that less than LEAST_WORTH of the
 * light reaches. Weights in windows for a detector are proportional to 1 / importance (power 1), because
 * little of the light reaches a detector. */
static cml_status fill_windows(const char *aim, const struct cml_scene *scene,
                               const struct cml_medium_def *media, const double *importance,
                               struct cml_window_table *windows, struct cml_error *err)
{
    char expected[80];
    windows->worth = worth_of_light(scene, media, windows, importance);
    snprintf(expected, sizeof expected, "an aim that at least %g of the light reaches, not %.1g", LEAST_WORTH,
             windows->worth);
    if (!(windows->worth > LEAST_WORTH && windows->worth < INFINITY))
        return cml_aim_refuse(scene, aim, (int)strlen(aim), expected, err);
    return cml_window_table_create(importance, windows->worth,
                                   windows->detector ? 1 : cml_windows_power(windows->worth), windows, err);
}

/* Returns the thickness of the first `layers` layers, cm. */
static double depth_of(const struct cml_medium_def *media, int layers)
{
    double depth = 0;
    for (int l = 1; l <= layers; l++) depth += media[l].d;
    return depth;
}

cml_status cml_windows_below(const char *aim, const struct cml_scene *scene,
                             const struct cml_medium_def *media, int layers, struct cml_window_table *windows,
                             struct cml_error *err)
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
    windows->gain = cml_gain_below(windows->worth);
    return CML_OK;
}

/* Rings and cells of depth of the windows of a detector. In all scenes tested, a cell is at most a third of a
 * diffusion length. */
enum { RINGS = 128, CELLS = 256 };

/* True if the light that leaves the scene is symmetric about the beam's axis. */
static bool is_symmetric(const struct cml_scene *scene, const struct cml_surface_set *surfaces)
{
    const struct cml_beam *beam = scene->beams;
    const bool central = beam->x == 0 && beam->y == 0;
    if (scene->num_beams > 1 || scene->num_bodies > 0 || scene->num_contacts > 0 || beam->angle > 0 ||
        beam->shape == CML_BEAM_RECTANGLE || beam->shape == CML_BEAM_IMAGE)
        return false;
    for (int b = 0; b < surfaces->count; b++)
        if (surfaces->item[b].kind != CML_SURFACE_PLANE &&
            !(central && surfaces->item[b].kind == CML_SURFACE_CONE))
            return false;
    return true;
}

/* Returns the distance between a beam and a detector in x and y, cm. */
static double distance_between(const struct cml_beam *beam, const struct cml_detector_def *detector)
{
    return hypot(beam->x - detector->x, beam->y - detector->y);
}

/* True if the detector can score light by arcs (P13): light that crosses a circle about the beam's axis
 * counts with the share of the circle that lies in the detector. */
static bool sees_arcs(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                      const struct cml_detector_def *detector)
{
    return detector->shape == CML_DETECTOR_RING && !(detector->aimed && detector->angle > 0) &&
           distance_between(scene->beams, detector) > 0 && is_symmetric(scene, surfaces);
}

/* Returns the ring about the middle of the windows that contains the detector. A rectangle counts as a disk
 * of the same area. away: distance of the detector from that middle, cm. */
static struct cml_seen_ring ring_of(const struct cml_detector_def *detector, double away)
{
    const double *size = detector->size;
    const bool ring = detector->round;
    const double inner = ring ? size[0] : 0, outer = ring ? size[1] : sqrt(size[0] * size[1] / M_PI);
    if (away == 0) return (struct cml_seen_ring){detector->below, inner, outer};
    return (struct cml_seen_ring){detector->below, fmax(0, away - outer), away + outer};
}

/* Returns the radius of the windows, cm: twice the largest distance between a beam and the detector's outer
 * edge. Light from farther away, or from deeper, hardly reaches the detector. */
static double reach_of(const struct cml_scene *scene, const struct cml_detector_def *detector, double outer)
{
    double farthest = outer;
    for (int k = 0; k < scene->num_beams; k++)
        farthest = fmax(farthest, distance_between(&scene->beams[k], detector));
    return 2 * (farthest + outer);
}

/* Returns the area of a ring divided by pi, cm2. */
static double area_of(double inner, double outer)
{
    return outer * outer - inner * inner;
}

/* Returns the layout of the windows for detector `number`, from 1: cells and size, without the weights. */
static struct cml_window_table lay_out(const struct cml_scene *scene, const struct cml_medium_def *media,
                                       int number, bool arcs, struct cml_seen_ring seen)
{
    const struct cml_detector_def *detector = &scene->detectors[number - 1];
    const double depth = depth_of(media, scene->num_layers), reach = reach_of(scene, detector, seen.outer);
    return (struct cml_window_table){
        .layers = scene->num_layers,
        .detector = number,
        .share = arcs ? area_of(detector->size[0], detector->size[1]) / area_of(seen.inner, seen.outer) : 1,
        .accepted = cml_accepted_by(scene, detector),
        .cells = CELLS,
        .rings = RINGS,
        .depth = detector->below ? depth : fmin(depth, reach),
        .x = arcs ? scene->beams->x : detector->x,
        .y = arcs ? scene->beams->y : detector->y,
        .reach = reach};
}

/* Returns the largest importance of all cells. */
static double largest(const double *importance)
{
    double most = 0;
    for (int i = 0; i < RINGS * CELLS; i++) most = fmax(most, importance[i]);
    return most;
}

/* Sets *weight to the mean weight, weighted by weight, of plain packets that reach the detector. A packet's
 * weight falls as its light is absorbed, so the mean is the share that arrives if every layer absorbs twice
 * as much, divided by the share that arrives. The roulette keeps the mean above 0.008. */
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

/* Makes the weight windows for light that one detector sees, and estimates their gain. */
cml_status cml_windows_at(const char *aim, const struct cml_scene *scene,
                          const struct cml_surface_set *surfaces, const struct cml_medium_def *media,
                          int number, struct cml_window_table *windows, struct cml_error *err)
{
    const struct cml_detector_def *detector = &scene->detectors[number - 1];
    const bool arcs = sees_arcs(scene, surfaces, detector);
    const struct cml_seen_ring seen = ring_of(detector, arcs ? distance_between(scene->beams, detector) : 0);
    double *importance = malloc(RINGS * CELLS * sizeof *importance);
    if (!importance) return cml_fail_memory(err, RINGS * CELLS * sizeof *importance, "weight windows");
    *windows = lay_out(scene, media, number, arcs, seen);
    cml_status status = cml_importance_of_place(media, scene->num_layers, seen, windows->reach,
                                                windows->depth, RINGS, CELLS, importance, err);
    if (status == CML_OK) status = fill_windows(aim, scene, media, importance, windows, err);
    const double most = largest(importance);
    double weight = 1;
    if (status == CML_OK) status = weigh_plain(scene, media, seen, windows, importance, &weight, err);
    windows->gain = cml_gain_at(detector, windows, weight, most);
    free(importance);
    return status;
}
