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

/* Returns the importance of light at a place, for all detectors about which the windows lie. importance[ring
 * * cells + cell]: share of the light at a place that reaches the target. */
static double importance_at(const struct cml_window_table *windows, const double *importance, double x,
                            double y, double z)
{
    const int cell = place_in(z / windows->depth, windows->cells);
    double sum = windows->places > 0 ? 0 : importance[cell];
    for (int k = 0; k < windows->places; k++) {
        const double r = hypot(x - windows->place[k][0], y - windows->place[k][1]);
        sum += importance[place_in(sqrt(r / windows->reach), windows->rings) * windows->cells + cell];
    }
    return sum;
}

/* Returns the importance of light where it starts: the largest over all beams, each taken at its middle. */
static double worth_of_light(const struct cml_scene *scene, const struct cml_medium_def *media,
                             const struct cml_window_table *windows, const double *importance)
{
    double most = 0;
    for (int k = 0; k < scene->num_beams; k++) {
        const struct cml_beam *beam = &scene->beams[k];
        const double z = beam->inside ? beam->z : diffuse_depth(media, windows->layers, 0);
        most = fmax(most, importance_at(windows, importance, beam->x, beam->y, z));
    }
    return most;
}

#define LEAST_WORTH 1e-20

/* Sets the worth of light where it starts. Refuses an aim that less than LEAST_WORTH of the light reaches. */
static cml_status set_worth(const char *aim, const struct cml_scene *scene,
                            const struct cml_medium_def *media, const double *importance,
                            struct cml_window_table *windows, struct cml_error *err)
{
    char expected[80];
    windows->worth = worth_of_light(scene, media, windows, importance);
    snprintf(expected, sizeof expected, "an aim that at least %g of the light reaches, not %.1g", LEAST_WORTH,
             windows->worth);
    return windows->worth > LEAST_WORTH && windows->worth < INFINITY
               ? CML_OK
               : cml_aim_refuse(scene, aim, (int)strlen(aim), expected, err);
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
    CML_TRY(set_worth(aim, scene, media, importance, windows, err));
    windows->gain = cml_gain_below(windows->worth);
    return cml_window_table_create(importance, windows->worth, cml_windows_power(windows->worth), windows,
                                   err);
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

/* A detector at which an aim looks: detector `number`, from 1, or the members of a group of this number. */
struct target {
    const struct cml_scene *scene;
    int number, members;
    bool arcs;                  /* the detectors score light by arcs (P13) */
    bool each;                  /* the windows lie about each member, not about one place for all */
    double x, y;                /* this place, cm */
    struct cml_seen_rings seen; /* rings about a place of the windows that contain the detectors there */
    double area;                /* area of all detectors divided by pi, cm2 */
};

/* Returns the next detector of the target from index k on; NULL: no more. */
static const struct cml_detector_def *member_from(const struct target *target, int *k)
{
    for (; *k < cml_num_areas(target->scene); ++*k) {
        const struct cml_detector_def *detector = &target->scene->detectors[*k];
        if (*k + 1 == target->number || detector->in_group == target->number) return detector;
    }
    return NULL;
}
#define EACH_MEMBER(target, detector) (int k_ = 0; ((detector) = member_from((target), &k_)) != NULL; k_++)

/* True if the detector can score light by arcs (P13): light that crosses a circle about the beam's axis
 * counts with the share of the circle that lies in the detector. */
static bool sees_arcs(const struct cml_detector_def *detector)
{
    return detector->shape == CML_DETECTOR_RING && !(detector->aimed && detector->angle > 0);
}

/* Returns the ring about the middle of the windows that contains the detector. A rectangle counts as a disk
 * of the same area. away: distance of the detector from that middle, cm. */
static struct cml_seen_ring ring_of(const struct cml_detector_def *detector, double away)
{
    const double *size = detector->size;
    const bool ring = cml_detector_is_round(detector);
    const double inner = ring ? size[0] : 0, outer = ring ? size[1] : sqrt(size[0] * size[1] / M_PI);
    if (away == 0) return (struct cml_seen_ring){detector->below, inner, outer};
    return (struct cml_seen_ring){detector->below, fmax(0, away - outer), away + outer};
}

/* Returns the area of a ring divided by pi, cm2. */
static double area_of(struct cml_seen_ring ring)
{
    return ring.outer * ring.outer - ring.inner * ring.inner;
}

/* Returns the area of all rings divided by pi, cm2. */
static double area_of_all(struct cml_seen_rings seen)
{
    double sum = 0;
    for (int i = 0; i < seen.count; i++) sum += area_of(seen.item[i]);
    return sum;
}

/* Sets the place that the windows of many detectors have in common: the beam's axis if the detectors score
 * arcs, else the middle of the rectangle around all detectors. */
static void find_middle(struct target *target)
{
    const struct cml_detector_def *detector;
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for
        EACH_MEMBER(target, detector)
        {
            const double at[2] = {detector->x, detector->y};
            for (int i = 0; i < 2; i++) {
                low[i] = fmin(low[i], at[i]);
                high[i] = fmax(high[i], at[i]);
            }
            target->members++;
            target->arcs = target->arcs && sees_arcs(detector);
        }
    target->each = !target->arcs && target->members <= CML_WINDOW_PLACES;
    target->x = target->arcs ? target->scene->beams->x : low[0] + 0.5 * (high[0] - low[0]);
    target->y = target->arcs ? target->scene->beams->y : low[1] + 0.5 * (high[1] - low[1]);
}

static int compare_rings(const void *a, const void *b)
{
    const struct cml_seen_ring *one = a, *other = b;
    return (one->inner > other->inner) - (one->inner < other->inner);
}

/* Fills target->seen[members] with the rings of all detectors about their places; rings that overlap become
 * one. */
static void find_rings(struct target *target)
{
    const struct cml_detector_def *detector;
    struct cml_seen_ring *item = target->seen.item;
    int count = 0, last = 0;
    for
        EACH_MEMBER(target, detector)
        {
            target->area += area_of(ring_of(detector, 0));
            item[count++] =
                ring_of(detector, target->each ? 0 : hypot(detector->x - target->x, detector->y - target->y));
        }
    qsort(item, (size_t)count, sizeof *item, compare_rings);
    for (int i = 1; i < count; i++)
        if (item[i].inner > item[last].outer)
            item[++last] = item[i];
        else
            item[last].outer = fmax(item[last].outer, item[i].outer);
    target->seen.count = last + 1;
}

/* Makes the target of an aim. The caller frees target->seen.item. */
static cml_status find_target(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                              int number, struct target *target, struct cml_error *err)
{
    *target = (struct target){.scene = scene, .number = number, .arcs = is_symmetric(scene, surfaces)};
    find_middle(target);
    target->seen.item = calloc((size_t)target->members, sizeof *target->seen.item);
    if (!target->seen.item)
        return cml_fail_memory(err, target->members * (double)sizeof *target->seen.item, "weight windows");
    find_rings(target);
    return CML_OK;
}

/* Returns the radius of the windows, cm: twice the largest distance between a beam and the outer edge of the
 * detectors. Light from farther away, or from deeper, hardly reaches them. */
static double reach_of(const struct target *target)
{
    const struct cml_detector_def *detector;
    const double outer = target->seen.item[target->seen.count - 1].outer;
    double farthest = outer;
    for (int k = 0; k < target->scene->num_beams; k++)
        for
            EACH_MEMBER(target, detector)
    farthest = fmax(farthest, distance_between(&target->scene->beams[k], detector));
    return 2 * (farthest + outer);
}

/* Returns the share of the light that the detectors' apertures take, in the mean. */
static double accepted_by(const struct target *target)
{
    const struct cml_detector_def *detector;
    double sum = 0;
    for
        EACH_MEMBER(target, detector) sum += cml_accepted_by(target->scene, detector);
    return sum / target->members;
}

/* Returns the layout of the windows for the target: cells, places and size, without the weights. */
static struct cml_window_table lay_out(const struct target *target, const struct cml_medium_def *media)
{
    const struct cml_scene *scene = target->scene;
    const struct cml_detector_def *detector;
    const double depth = depth_of(media, scene->num_layers), reach = reach_of(target),
                 share = fmin(1, target->area / area_of_all(target->seen));
    struct cml_window_table windows = {.layers = scene->num_layers,
                                       .detector = target->number,
                                       .share = target->arcs ? share : 1,
                                       .accepted = accepted_by(target) * (target->arcs ? 1 : share),
                                       .cells = CELLS,
                                       .rings = RINGS,
                                       .depth = target->seen.item->below ? depth : fmin(depth, reach),
                                       .reach = reach,
                                       .places = target->each ? 0 : 1,
                                       .place = {{target->x, target->y}}};
    if (!target->each) return windows;
    for
        EACH_MEMBER(target, detector)
        {
            windows.place[windows.places][0] = detector->x;
            windows.place[windows.places++][1] = detector->y;
        }
    return windows;
}

/* Returns the number of transport mean free paths between the detectors' face and depth z. */
static double optical_way(const struct cml_scene *scene, const struct cml_medium_def *media, bool below,
                          double z, double *mutr)
{
    double sum = 0, top = 0;
    for (int l = 1; l <= scene->num_layers; top += media[l++].d) {
        const double upper = fmax(0, fmin(media[l].d, z - top)), own = cml_medium_mutr(&media[l]);
        sum += own * (below ? media[l].d - upper : upper);
        if (z >= top) *mutr = own;
    }
    return sum;
}

/* Returns how much more importance a place near a detector has for all detectors than for this one, in the
 * mean over them: 1 for detectors that lie far apart. */
static double overlap_of(const struct target *target, const struct cml_medium_def *media,
                         const struct cml_window_table *windows, const double *importance)
{
    const double way = fmin(diffuse_depth(media, windows->layers, 0), windows->depth),
                 z = target->seen.item->below ? windows->depth - way : way;
    double sum = 0;
    for (int k = 0; k < windows->places; k++)
        sum += importance_at(windows, importance, windows->place[k][0], windows->place[k][1], z);
    return sum / windows->places / importance[place_in(z / windows->depth, windows->cells)];
}

/* Raises the importance near the detectors: I (1 + 10 / sqrt(f) exp(-s)), where f is the share that the
 * apertures accept. s is the distance in transport mean free paths, of which those along the face count three
 * times. There the next few scatterings decide if a packet comes to the detector and within its aperture, and
 * no later split can help. So the best weight falls with the root of the mean square of the importance over
 * directions, which is far larger than the mean. Factors of a half to
 * ten times this one, ranges of 0.5 to 2 and widths of 1 to 4 were flown, for fibres with apertures of 0.22,
 * 0.39 and none. */
static void raise_near(const struct target *target, const struct cml_medium_def *media,
                       const struct cml_window_table *windows, double *importance)
{
    const struct cml_seen_rings seen = target->seen;
    const double factor = 10 / sqrt(accepted_by(target)),
                 all = overlap_of(target, media, windows, importance);
    for (int c = 0; c < CELLS; c++) {
        double mutr = 0;
        const double way =
            optical_way(target->scene, media, seen.item->below, (c + 0.5) / CELLS * windows->depth, &mutr);
        for (int ring = 0; ring < RINGS; ring++) {
            const double r = windows->reach * pow((ring + 0.5) / RINGS, 2);
            double off = INFINITY;
            for (int i = 0; i < seen.count; i++)
                off = fmin(off, fmax(0, fmax(seen.item[i].inner - r, r - seen.item[i].outer)));
            importance[ring * CELLS + c] *= all * (1 + factor * exp(-hypot(way, 3 * mutr * off)));
        }
    }
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
                              struct cml_seen_rings seen, const struct cml_window_table *windows,
                              double *importance, double *weight, struct cml_error *err)
{
    const size_t count = (size_t)scene->num_layers + 2;
    CML_FREED struct cml_medium_def *dark = malloc(count * sizeof *dark);
    if (!dark) return cml_fail_memory(err, (double)(count * sizeof *dark), "layers");
    memcpy(dark, media, count * sizeof *dark);
    for (size_t l = 0; l < count; l++) dark[l].mua *= 2;
    CML_TRY(cml_importance_of_place(dark, scene->num_layers, seen, windows->reach, windows->depth, RINGS,
                                    CELLS, importance, err));
    *weight = fmax(0.008, worth_of_light(scene, media, windows, importance) / windows->worth);
    return CML_OK;
}

cml_status cml_windows_at(const char *aim, const struct cml_scene *scene,
                          const struct cml_surface_set *surfaces, const struct cml_medium_def *media,
                          int number, struct cml_window_table *windows, struct cml_error *err)
{
    struct target target;
    CML_TRY(find_target(scene, surfaces, number, &target, err));
    CML_FREED struct cml_seen_ring *rings = target.seen.item; /* freed at the end */
    (void)rings;
    CML_FREED double *importance = malloc(RINGS * CELLS * sizeof *importance);
    if (!importance) return cml_fail_memory(err, RINGS * CELLS * sizeof *importance, "weight windows");
    *windows = lay_out(&target, media);
    CML_TRY(cml_importance_of_place(media, scene->num_layers, target.seen, windows->reach, windows->depth,
                                    RINGS, CELLS, importance, err));
    CML_TRY(set_worth(aim, scene, media, importance, windows, err));
    const double most = largest(importance);
    raise_near(&target, media, windows, importance);
    CML_TRY(cml_window_table_create(importance, windows->worth, 1, windows, err));
    double weight = 1;
    CML_TRY(weigh_plain(scene, media, target.seen, windows, importance, &weight, err));
    windows->gain = cml_gain_at(&scene->detectors[number - 1], windows, weight, most);
    return CML_OK;
}
