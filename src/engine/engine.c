/* SPDX-License-Identifier: MIT */
#include "engine/engine.h"

#include "base/clock.h"
#include "surface/surface_facets.h"
#include "tally/groups.h"
#include "tally/row_cells.h"
#include "types.h"

#include <math.h>
#include <pthread.h>

/* Returns the unit of path lengths, cm. A length of 48 bits then holds from 6e-8 to 1.7e7 times the extent of
 * the grid. The unit is a power of two, so that scaled scenes give the same bits. */
static double path_unit(const struct cml_scene *scene)
{
    int exponent;
    (void)frexp(fmax(scene->nr * scene->dr, scene->nz * scene->dz), &exponent);
    return ldexp(1, exponent - 24);
}

/* Returns the origin, cm, of the scale of packets' largest depths: a level at or above the largest depth of
 * every packet that was in the material. */
static double path_top(const struct cml_scene *scene, const struct cml_surface_set *surfaces)
{
    double top = surfaces && surfaces->count > 0 ? fmin(0, surfaces->item[0].lowest) : 0;
    for (int k = 0; k < scene->num_beams; k++)
        if (scene->beams[k].inside) top = fmin(top, scene->beams[k].z - cml_beam_height(&scene->beams[k]));
    return top;
}

/* Returns the distance between marks, cm: no longer than any bin of the fluence; 0 if no fluence is
 * wanted. */
static double spacing_of_marks(const struct cml_scene *scene)
{
    const double bin = fmin(scene->dr, scene->dz);
    if (!scene->fluence.line) return 0;
    return scene->map.volume ? fmin(bin, fmin(scene->map.dx, scene->map.dy)) : bin;
}

double cml_engine_row_share(const struct cml_medium_def *flown, double more)
{
    const double mua = flown->mua + more;
    return mua > 0 ? CML_ROW_SAMPLING * mua / (flown->mus > 0 ? flown->mus : flown->mua) : 0;
}

int cml_engine_rows_blind_in(const struct cml_scene *scene, const struct cml_engine_rows *rows)
{
    for (int m = 0; m < scene->num_layers + 2 + scene->num_bodies; m++)
        for (int i = 0; i < rows->count; i++)
            if (!(cml_engine_row_share(&scene->media[m], rows->more[m * rows->count + i]) <=
                  CML_ROW_MOST_SHARE))
                return m;
    return -1;
}

/* Facets are counted on the surfaces that are flown, because a boundary that is tessellated has other facets
 * than its cones. */
struct cml_tally_grid cml_engine_grid(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                                      const struct cml_engine_options *options)
{
    const struct cml_map_def *map = &scene->map;
    struct cml_tally_grid grid = {
        .nr = scene->nr,
        .nz = scene->nz,
        .na = scene->na,
        .num_layers = scene->num_layers,
        .num_bodies = scene->num_bodies,
        .absorption = options->absorption,
        .gates = scene->time.gates,
        .radii = scene->time.radii,
        .phi_volume = map->volume && scene->fluence.line,
        .phi_times = scene->fluence.times,
        .marks = spacing_of_marks(scene),
        .nt = scene->directions.nt,
        .np = scene->directions.np,
        .nx = map->nx,
        .ny = map->ny,
        .map_na = map->angles ? scene->na : 1,
        .volume = map->volume && options->absorption,
        .scores = options->tail ? options->tail->scores : 0,
        .exponent = options->tail ? options->tail->exponent : NULL,
        .detectors = scene->num_detectors,
        .path_unit = path_unit(scene),
        .path_top = path_top(scene, surfaces),
        .rows = options->derivatives ? 2 * (scene->num_layers + scene->num_bodies) : options->rows.count,
        .derivatives = options->derivatives,
        .row_depths = options->rows.depths,
        .row_times = options->rows.times && scene->time.gates > 0,
        .row_means = options->rows.means && scene->num_detectors > 0,
        .saved = {scene->saved.limit, scene->saved.detected,
                  (size_t)scene->num_layers + 2 + (size_t)scene->num_bodies, (uint64_t)scene->num_beams}};
    for (int k = 0; k < scene->num_detectors; k++) {
        const struct cml_detector_def *detector = &scene->detectors[k];
        if (detector->shape == CML_DETECTOR_MAP)
            grid.detector_pixels += (size_t)detector->nx * (size_t)detector->ny;
    }
    for (int b = 0; scene->facets && surfaces && b < surfaces->count; b++)
        grid.facets += cml_surface_facets(&surfaces->item[b], map);
    grid.backed = scene->facets && surfaces && scene->backing.kind != CML_BACKING_NONE &&
                  cml_surface_facets(&surfaces->item[scene->num_layers], map) > 0;
    grid.faced = scene->facets && scene->num_contacts > 0;
    for (int k = 0; scene->facets && surfaces && k < surfaces->bodies.count; k++)
        grid.facets += (size_t)surfaces->bodies.item[k].primitives;
    cml_tally_set_groups(&grid);
    grid.row_cells = cml_row_cells(&grid);
    return grid;
}

/* Pieces become smaller towards the end (guided scheduling), so that all threads end at about the same time.
 * */
uint64_t cml_piece_size(uint64_t most, int takers, uint64_t left)
{
    const uint64_t least = 16;
    uint64_t size = most;
    if (takers > 1 && most > least) {
        const uint64_t fair = left / (8 * (uint64_t)takers);
        size = fair < least ? least : fair < most ? fair : most;
    }
    return size < left ? size : left;
}

#define PATIENCE 0.3 /* seconds of a thread's own time */

/* The time is the thread's own, not the wall's, so that packets get their time to end on a machine that is
 * busy with other work. */
bool cml_engine_gives_up(const struct cml_work *work, struct cml_patience *patience)
{
    if (!work->stops || !work->stops(work->context)) return false;
    const double now = cml_thread_seconds();
    if (patience->since <= 0) patience->since = now;
    return now - patience->since > PATIENCE;
}

cml_status cml_engine_given_up(struct cml_error *err)
{
    return cml_fail(err, CML_E_STOPPED, "packets that do not end were given up");
}

/* A range of photons as the work of an engine. */
struct range_work {
    pthread_mutex_t lock; /* protects all members below */
    uint64_t begin, end;  /* first photon, and the one after the last */
    uint64_t turn;        /* next photon to fly */
    struct cml_tally *tally;
};

/* Gives a thread the next piece of a range of photons, at most `most` of them, and returns false when the
 * range is used up. takers: number of threads that share the rest. It is the function cml_work.next of
 * cml_engine_run_range. */
static bool next_of_range(void *context, uint64_t most, int takers, struct cml_piece *piece)
{
    struct range_work *range = context;
    pthread_mutex_lock(&range->lock);
    *piece = (struct cml_piece){0};
    if (range->turn < range->end) {
        const uint64_t size = cml_piece_size(most, takers, range->end - range->turn);
        *piece = cml_piece_at(range->begin, range->end, range->turn);
        if (piece->count > size) piece->count = size;
        range->turn += piece->count;
    }
    pthread_mutex_unlock(&range->lock);
    return piece->count > 0;
}

/* Does nothing when a batch ends, because a range of packets has one tally for all batches. */
static void ignore_batch(void *context, int batch, struct cml_tally *tally)
{
    (void)context;
    (void)batch;
    (void)tally;
}

/* Adds a thread's tally to the range's, for cml_work.add. */
static void add_to_range(void *context, struct cml_tally *tally)
{
    struct range_work *range = context;
    pthread_mutex_lock(&range->lock);
    cml_tally_move(range->tally, tally);
    pthread_mutex_unlock(&range->lock);
}

cml_status cml_engine_run_range(const struct cml_engine *engine, void *self, uint64_t first, uint64_t count,
                                struct cml_tally *tally, struct cml_error *err)
{
    struct range_work range = {.begin = first, .end = first + count, .turn = first, .tally = tally};
    const struct cml_work work = {&range, next_of_range, ignore_batch, add_to_range, NULL, NULL};
    pthread_mutex_init(&range.lock, NULL);
    const cml_status status = engine->run(self, &work, err);
    pthread_mutex_destroy(&range.lock);
    return status;
}

/* Returns words for how a packet has ended. */
const char *cml_fate_name(int fate)
{
    static const char *const names[CML_NUM_FATES] = {"alive",    "absorbed", "reflected", "transmitted",
                                                     "specular", "trapped",  "lost"};
    return names[fate];
}

/* Returns words for the cause for which a packet was given up, for messages. */
const char *cml_lost_cause_name(int cause)
{
    static const char *const names[CML_NUM_LOST_CAUSES] = {"not lost",
                                                           "no surface found",
                                                           "not a number",
                                                           "stuck",
                                                           "leaked through a boundary",
                                                           "flew too far over a tile",
                                                           "met 1000 facets of a rough boundary at once"};
    return names[cause];
}
