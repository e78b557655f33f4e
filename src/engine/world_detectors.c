/* Detectors as the kernels read them (struct cml_detection). A grid over the detectors of a level lets a
 * packet test only the detectors that reach into its cell, so hundreds of detectors cost little more than
 * one.
 * SPDX-License-Identifier: MIT */
#include "engine/world_parts.h"

#include "detector.h"

#include <math.h>
#include <stdlib.h>

/* ---- one detector ---- */

/* Returns a detector as the walk reads it, counted from the scene's origin. */
static struct cml_detector detector_of(const struct cml_scene *scene, const double origin[2],
                                       const struct cml_detector_def *def)
{
    const double x = def->x - origin[0], y = def->y - origin[1];
    const double n = scene->media[def->below ? scene->num_layers + 1 : 0].n;
    const double sine = sin(def->angle), half_w = def->nx * def->size[0] / 2,
                 half_h = def->ny * def->size[1] / 2;
    struct cml_detector d = {
        .shape = (int)def->shape, .group = def->in_group, .aimed = def->aimed, .diffuse = def->diffuse};
    d.axis = cml_vec_of(sine * cos(def->azimuth), sine * sin(def->azimuth),
                        (def->below ? 1 : -1) * cos(def->angle));
    d.most_sine2 = (real)(def->na < n ? (def->na / n) * (def->na / n) : 2);
    d.middle = cml_vec_of(x, y, 0);
    d.inner2 = (real)(def->size[0] * def->size[0]);
    d.outer2 = (real)(def->size[1] * def->size[1]);
    d.low_x = (real)(x - half_w);
    d.high_x = (real)(x + half_w);
    d.low_y = (real)(y - half_h);
    d.high_y = (real)(y + half_h);
    d.pixels = (struct cml_map){.nx = def->nx,
                                .ny = def->ny,
                                .per_dx = (real)(1 / def->size[0]),
                                .per_dy = (real)(1 / def->size[1]),
                                .half_x = (real)(0.5 * def->nx),
                                .half_y = (real)(0.5 * def->ny)};
    return d;
}

/* ---- cells over the detectors of one level ---- */

struct rectangle {
    double low[2], high[2];
};

/* Returns the rectangle around a detector, in coordinates of the scene. */
static struct rectangle rectangle_around(const struct cml_detector_def *def)
{
    const bool ring = def->shape == CML_DETECTOR_RING;
    const double w = ring ? def->size[1] : def->nx * def->size[0] / 2,
                 h = ring ? def->size[1] : def->ny * def->size[1] / 2;
    return (struct rectangle){{def->x - w, def->y - h}, {def->x + w, def->y + h}};
}

/* The side and depth of a detector, by which detectors are sorted into levels. */
struct place {
    bool below;
    double z;
    int number; /* number of the detector */
};
/* The detectors at one side and depth, place[count], and a grid of n by n cells over the rectangle around
 * all of them. */
struct level {
    const struct cml_scene *scene;
    const struct place *place;
    const double *origin; /* the scene's origin, cm */
    int count, n;
    struct rectangle all;
};

static const struct cml_detector_def *detector_at(const struct level *level, int k)
{
    return &level->scene->detectors[level->place[k].number];
}

/* Finds the cells along an axis that a detector reaches into, widened by more than rounding moves a place. */
static void find_cells(const struct level *level, const struct rectangle *own, int axis, int *first,
                       int *last)
{
    const double per_cell = level->n / (level->all.high[axis] - level->all.low[axis]), most = level->n - 1;
    *first = (int)fmax(0, floor((own->low[axis] - level->all.low[axis]) * per_cell - 0.01));
    *last = (int)fmin(most, floor((own->high[axis] - level->all.low[axis]) * per_cell + 0.01));
}

/* True if the ring of a detector itself reaches into cell (ix, iy), and not only its hole. */
static bool ring_reaches(const struct level *level, const struct cml_detector_def *def, int ix, int iy)
{
    const int at[2] = {ix, iy};
    const double middle[2] = {def->x, def->y};
    double closest[2], farthest[2];
    for (int i = 0; i < 2; i++) {
        const double width = (level->all.high[i] - level->all.low[i]) / level->n;
        const double low = level->all.low[i] + (at[i] - 0.01) * width - middle[i], high = low + 1.02 * width;
        closest[i] = fmax(0, fmax(low, -high));
        farthest[i] = fmax(high, -low);
    }
    return hypot(farthest[0], farthest[1]) >= def->size[0] && hypot(closest[0], closest[1]) <= def->size[1];
}

/* Enters the detectors of a level into the grid's cells that they reach. In the first call, list is NULL,
 * and next[n * n] counts the entries of each cell; in the second, next says where each cell's list goes on.
 * Returns the number of entries, or a number >= `most` if there are too many. */
static double fill_cells(const struct level *level, double most, int *next, int *list)
{
    double entries = 0;
    for (int k = 0; k < level->count; k++) {
        const struct cml_detector_def *def = detector_at(level, k);
        const struct rectangle own = rectangle_around(def);
        int first[2], last[2];
        for (int i = 0; i < 2; i++) find_cells(level, &own, i, &first[i], &last[i]);
        for (int iy = first[1]; iy <= last[1]; iy++)
            for (int ix = first[0]; ix <= last[0] && entries < most; ix++) {
                if (def->shape == CML_DETECTOR_RING && !ring_reaches(level, def, ix, iy)) continue;
                const int entry = next[iy * level->n + ix]++;
                if (list) list[entry] = level->place[k].number;
                entries++;
            }
    }
    return entries;
}

/* Finds the rectangle around all detectors of a level, enlarged by more than rounding. */
static void find_rectangle(struct level *level)
{
    struct rectangle *all = &level->all;
    *all = rectangle_around(detector_at(level, 0));
    for (int k = 1; k < level->count; k++) {
        const struct rectangle own = rectangle_around(detector_at(level, k));
        for (int i = 0; i < 2; i++) {
            all->low[i] = fmin(all->low[i], own.low[i]);
            all->high[i] = fmax(all->high[i], own.high[i]);
        }
    }
    for (int i = 0; i < 2; i++) {
        const double farthest =
            fmax(fabs(all->low[i] - level->origin[i]), fabs(all->high[i] - level->origin[i]));
        const double pad = 1e-3 * (all->high[i] - all->low[i]) + 1e-5 * farthest;
        all->low[i] -= pad;
        all->high[i] += pad;
    }
}

/* ---- all detectors ---- */

/* The detection of a world while it is made: lists grow level by level. */
struct detection {
    struct cml_owned_world *to;
    int num_starts, num_entries;
};

/* Enlarges the lists of a detection by `starts` cells and `entries` entries. */
static cml_status make_room(struct detection *d, int starts, int entries, struct cml_error *err)
{
    const size_t all_starts = (size_t)d->num_starts + (size_t)starts,
                 all_entries = (size_t)d->num_entries + (size_t)entries;
    int *start = realloc(d->to->detector_start, all_starts * sizeof *start);
    if (start) d->to->detector_start = start;
    int *list = realloc(d->to->detector_list, (all_entries + 1) * sizeof *list);
    if (list) d->to->detector_list = list;
    if (start && list) return CML_OK;
    return cml_fail_memory(err, (double)(all_starts + all_entries) * sizeof *list, "detectors");
}

/* Chooses a grid so fine that few detectors lie in a cell, or a grid of one cell if all detectors overlap.
 * *count: [n * n] number of detectors that reach into each cell; the caller frees it. */
static cml_status choose_cells(struct level *level, int **count, double *entries, struct cml_error *err)
{
    const double most = 16.0 * level->count;
    for (level->n = 1; level->n * level->n < level->count;) level->n *= 2;
    for (;; level->n /= 2) {
        const size_t cells = (size_t)level->n * (size_t)level->n;
        *count = calloc(cells, sizeof **count);
        if (!*count) return cml_fail_memory(err, (double)(cells * sizeof **count), "detectors");
        *entries = fill_cells(level, most, *count, NULL);
        if (*entries < most || level->n == 1) return CML_OK;
        free(*count);
    }
}

/* Adds the detectors at one depth, with a grid over them: each cell lists the detectors that reach into it,
 * so that a packet asks few. The lists lie one behind the other; next[c] first counts those of cell c, then
 * tells where the next entry goes. */
static cml_status add_level(struct detection *d, struct level *level, struct cml_detector_level *made,
                            struct cml_error *err)
{
    const struct cml_scene *scene = level->scene;
    int *next = NULL, end = d->num_entries;
    double entries = 0;
    find_rectangle(level);
    CML_TRY(choose_cells(level, &next, &entries, err));
    const int cells = level->n * level->n;
    const cml_status status = make_room(d, cells + 1, (int)entries, err);
    for (int c = 0; status == CML_OK && c < cells; c++) {
        const int count = next[c];
        d->to->detector_start[d->num_starts + c] = next[c] = end;
        end += count;
    }
    if (status == CML_OK) {
        d->to->detector_start[d->num_starts + cells] = end;
        (void)fill_cells(level, INFINITY, next, d->to->detector_list);
        const bool below = level->place->below;
        *made = (struct cml_detector_level){
            .below = below,
            .z = (real)(level->place->z - scene->boundaries[below ? scene->num_layers : 0].z),
            .nx = level->n,
            .ny = level->n,
            .first = d->num_starts,
            .corner_x = (real)(level->all.low[0] - level->origin[0]),
            .corner_y = (real)(level->all.low[1] - level->origin[1]),
            .per_cell_x = (real)(level->n / (level->all.high[0] - level->all.low[0])),
            .per_cell_y = (real)(level->n / (level->all.high[1] - level->all.low[1]))};
        d->num_starts += cells + 1;
        d->num_entries = end;
    }
    free(next);
    return status;
}

/* Orders detectors by side, level and number, for qsort. */
static int compare_places(const void *a, const void *b)
{
    const struct place *one = a, *other = b;
    if (one->below != other->below) return one->below ? 1 : -1;
    if (one->z != other->z) return one->z < other->z ? -1 : 1;
    return (one->number > other->number) - (one->number < other->number);
}

/* Adds all levels. A level is a run of detectors with the same side and depth, because place[] is sorted
 * by both. */
static cml_status add_levels(const struct cml_scene *scene, const double origin[2], const struct place *place,
                             struct detection *d, int *num_levels, struct cml_error *err)
{
    const int n = cml_num_areas(scene);
    for (int first = 0, end; first < n; first = end) {
        struct level level = {.scene = scene, .place = place + first, .origin = origin};
        for (end = first;
             end < n && place[end].below == place[first].below && place[end].z == place[first].z;)
            end++;
        level.count = end - first;
        CML_TRY(add_level(d, &level, &d->to->detector_levels[(*num_levels)++], err));
    }
    return CML_OK;
}

/* Returns enum CML_SPLIT_... for the light that is split off at launches, which goes straight up. */
static int split_of(const struct cml_world *world, int num_detectors, const struct cml_detector *detectors,
                    const struct cml_detector_def *defs)
{
    const struct cml_vec up = {0, 0, -1};
    const bool alike = world->setup.num_sources == 1 && world->sources->shape == CML_BEAM_PENCIL &&
                       world->sources->middle.x == 0 && world->sources->middle.y == 0;
    for (int k = 0; k < num_detectors; k++)
        if (!defs[k].below && !defs[k].diffuse && (!defs[k].aimed || cml_is_in_cone(&detectors[k], up)))
            return alike ? CML_SPLIT_ALIKE : CML_SPLIT_APART;
    return CML_SPLIT_UNSEEN;
}

/* Returns the arc of detector k. Distances count from the beam's axis. */
static struct cml_arc arc_of(const struct cml_scene *scene, int k, int num_levels,
                             const struct cml_owned_world *to)
{
    const struct cml_detector_def *def = &scene->detectors[k];
    const real z = (real)(def->z - scene->boundaries[def->below ? scene->num_layers : 0].z);
    struct cml_arc arc = {.detector = k,
                          .away = (real)hypot(def->x - scene->beams->x, def->y - scene->beams->y),
                          .inner = (real)def->size[0],
                          .outer = (real)def->size[1]};
    while (arc.level < num_levels - 1 &&
           (to->detector_levels[arc.level].below != def->below || to->detector_levels[arc.level].z != z))
        arc.level++;
    return arc;
}

/* Fills to->arcs[] with the detectors that count shares of circles, if the windows ask for them: the detector
 * of the aim, or the members of its group. A ring about the beam's axis needs no arc, because it sees whole
 * circles. Returns their number. */
static int set_arcs(const struct cml_scene *scene, const struct cml_window_table *windows, int num_levels,
                    struct cml_owned_world *to)
{
    int count = 0;
    if (!windows || !windows->detector || !(windows->share < 1)) return 0;
    for (int k = 0; k < cml_num_areas(scene); k++) {
        if (k + 1 != windows->detector && scene->detectors[k].in_group != windows->detector) continue;
        const struct cml_arc arc = arc_of(scene, k, num_levels, to);
        to->detectors[k].arc = arc.away > 0;
        if (arc.away > 0) to->detector_arcs[count++] = arc;
    }
    return count;
}

/* Fills the detectors in the order of the scene, and sorts their places into levels, each with a grid of
 * cells. */
cml_status cml_set_detectors(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                             const struct cml_window_table *windows, struct cml_owned_world *to,
                             struct cml_error *err)
{
    const struct cml_tally_grid grid = cml_engine_grid(scene, surfaces, &(struct cml_engine_options){0});
    struct detection d = {.to = to};
    const size_t n = (size_t)scene->num_detectors;
    cml_u64 pixels = 0;
    int num_levels = 0;
    if (n == 0) return CML_OK;
    struct place *place = malloc(n * sizeof *place);
    to->detectors = cml_arrays_add(&to->arrays, n, sizeof *to->detectors);
    to->detector_levels = cml_arrays_add(&to->arrays, n, sizeof *to->detector_levels);
    to->detector_arcs = cml_arrays_add(&to->arrays, n, sizeof *to->detector_arcs);
    if (!place || to->arrays.failed) {
        free(place);
        return cml_fail_memory(err, (double)(n * sizeof *to->detectors), "detectors");
    }
    for (size_t k = 0; k < n; k++) {
        const struct cml_detector_def *def = &scene->detectors[k];
        place[k] = (struct place){def->below, def->z, (int)k};
        to->detectors[k] = detector_of(scene, surfaces->origin.at, def);
        to->detectors[k].first_pixel = pixels;
        if (def->shape == CML_DETECTOR_MAP) pixels += (cml_u64)def->nx * (cml_u64)def->ny;
    }
    qsort(place, (size_t)cml_num_areas(scene), sizeof *place, compare_places);
    const cml_status status = add_levels(scene, surfaces->origin.at, place, &d, &num_levels, err);
    free(place);
    to->world.detection = (struct cml_detection){
        .num_detectors = (int)n,
        .num_levels = num_levels,
        .num_arcs = set_arcs(scene, windows, num_levels, to),
        .arcs = to->detector_arcs,
        .split = split_of(&to->world, cml_num_areas(scene), to->detectors, scene->detectors),
        .detectors = to->detectors,
        .levels = to->detector_levels,
        .start = to->detector_start,
        .list = to->detector_list,
        .per_length = 1 / grid.path_unit,
        .top = grid.path_top};
    return status;
}
