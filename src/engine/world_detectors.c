/* Detectors, and faces and ports on boundary 0, as the kernels read them (struct cml_detection,
 * cml_contacts). A grid over the detectors of a level lets a packet test only the detectors that reach into
 * its cell, so hundreds of detectors cost little more than one. SPDX-License-Identifier: MIT */
#include "engine/world_parts.h"

#include "detector.h"
#include "source.h"

#include <math.h>
#include <stdlib.h>

/* ---- one detector ---- */

/* Returns the outline of a detector, of a map all its pixels. */
static struct cml_outline outline_of(const struct cml_scene *scene, const struct cml_detector_def *def)
{
    struct cml_outline outline = {def->shape, def->x, def->y, {def->size[0], def->size[1]}};
    if (def->contact) return cml_contact_outline(&scene->contacts[def->contact - 1]);
    if (def->shape == CML_DETECTOR_RING) return outline;
    outline.size[0] = def->nx * def->size[0];
    outline.size[1] = def->ny * def->size[1];
    return outline;
}

struct cml_area cml_area_of(const struct cml_outline *outline, const double origin[2])
{
    const double x = outline->x - origin[0], y = outline->y - origin[1], *size = outline->size,
                 half_w = size[0] / 2, half_h = size[1] / 2;
    return (struct cml_area){.shape = (int)outline->shape,
                             .middle = cml_vec_of(x, y, 0),
                             .inner2 = (real)(size[0] * size[0]),
                             .outer2 = (real)(size[1] * size[1]),
                             .low_x = (real)(x - half_w),
                             .high_x = (real)(x + half_w),
                             .low_y = (real)(y - half_h),
                             .high_y = (real)(y + half_h)};
}

/* Returns a detector as the walk reads it, counted from the scene's origin. */
static struct cml_detector detector_of(const struct cml_scene *scene, const double origin[2],
                                       const struct cml_detector_def *def)
{
    const struct cml_outline outline = outline_of(scene, def);
    const double n = scene->media[def->below ? scene->num_layers + 1 : 0].n;
    const double sine = sin(def->angle);
    struct cml_detector d = {.shape = (int)def->shape,
                             .group = def->in_group,
                             .aimed = def->aimed,
                             .diffuse = def->diffuse,
                             .port = def->contact,
                             .na = def->na};
    d.axis = cml_vec_of(sine * cos(def->azimuth), sine * sin(def->azimuth),
                        (def->below ? 1 : -1) * cos(def->angle));
    d.most_sine2 = cml_most_sine2(def->na, n);
    d.area = cml_area_of(&outline, origin);
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

/* Returns the rectangle around an outline, in coordinates of the scene. */
static struct rectangle rectangle_around(const struct cml_outline *outline)
{
    const bool ring = outline->shape == CML_DETECTOR_RING;
    const double w = ring ? outline->size[1] : outline->size[0] / 2,
                 h = ring ? outline->size[1] : outline->size[1] / 2;
    return (struct rectangle){{outline->x - w, outline->y - h}, {outline->x + w, outline->y + h}};
}

/* Detectors at one side and depth, or contacts of boundary 0, and a grid of n by n cells over the rectangle
 * around all of them. */
struct level {
    const struct cml_outline *outline; /* [count] */
    const int *number;                 /* [count] their numbers in lists, rising */
    const double *origin;              /* the scene's origin, cm */
    int count, n;
    struct rectangle all;
};

/* Finds the cells along an axis that a detector reaches into, widened by more than rounding moves a place. */
static void find_cells(const struct level *level, const struct rectangle *own, int axis, int *first,
                       int *last)
{
    const double per_cell = level->n / (level->all.high[axis] - level->all.low[axis]), most = level->n - 1;
    *first = (int)fmax(0, floor((own->low[axis] - level->all.low[axis]) * per_cell - 0.01));
    *last = (int)fmin(most, floor((own->high[axis] - level->all.low[axis]) * per_cell + 0.01));
}

/* True if the ring itself reaches into a cell, and not only its hole. */
static bool ring_reaches(const struct level *level, const struct cml_outline *def, int ix, int iy)
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
        const struct cml_outline *def = &level->outline[k];
        const struct rectangle own = rectangle_around(def);
        int first[2], last[2];
        for (int i = 0; i < 2; i++) find_cells(level, &own, i, &first[i], &last[i]);
        for (int iy = first[1]; iy <= last[1]; iy++)
            for (int ix = first[0]; ix <= last[0] && entries < most; ix++) {
                if (def->shape == CML_DETECTOR_RING && !ring_reaches(level, def, ix, iy)) continue;
                const int entry = next[iy * level->n + ix]++;
                if (list) list[entry] = level->number[k];
                entries++;
            }
    }
    return entries;
}

/* Finds the rectangle around all detectors of a level, enlarged by more than rounding. */
static void find_rectangle(struct level *level)
{
    struct rectangle *all = &level->all;
    *all = rectangle_around(&level->outline[0]);
    for (int k = 1; k < level->count; k++) {
        const struct rectangle own = rectangle_around(&level->outline[k]);
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

/* Enlarges lists by `starts` cells and `entries` entries. */
static cml_status make_room(struct cml_cell_lists *lists, int starts, int entries, struct cml_error *err)
{
    const size_t all_starts = (size_t)lists->num_starts + (size_t)starts,
                 all_entries = (size_t)lists->num_entries + (size_t)entries;
    int *start = realloc(lists->start, all_starts * sizeof *start);
    if (start) lists->start = start;
    int *list = realloc(lists->list, (all_entries + 1) * sizeof *list);
    if (list) lists->list = list;
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

cml_status cml_add_level(const struct cml_outline *outline, const int *number, int count,
                         const double origin[2], struct cml_cell_lists *lists,
                         struct cml_detector_level *made, struct cml_error *err)
{
    struct level of = {.outline = outline, .number = number, .origin = origin, .count = count}, *level = &of;
    CML_FREED int *next = NULL;
    int end = lists->num_entries;
    double entries = 0;
    find_rectangle(level);
    CML_TRY(choose_cells(level, &next, &entries, err));
    const int cells = level->n * level->n;
    CML_TRY(make_room(lists, cells + 1, (int)entries, err));
    for (int c = 0; c < cells; c++) {
        const int reach = next[c];
        lists->start[lists->num_starts + c] = next[c] = end;
        end += reach;
    }
    lists->start[lists->num_starts + cells] = end;
    (void)fill_cells(level, INFINITY, next, lists->list);
    *made = (struct cml_detector_level){
        .nx = level->n,
        .ny = level->n,
        .first = lists->num_starts,
        .corner_x = (real)(level->all.low[0] - level->origin[0]),
        .corner_y = (real)(level->all.low[1] - level->origin[1]),
        .per_cell_x = (real)(level->n / (level->all.high[0] - level->all.low[0])),
        .per_cell_y = (real)(level->n / (level->all.high[1] - level->all.low[1]))};
    lists->num_starts += cells + 1;
    lists->num_entries = end;
    return CML_OK;
}

/* ---- all detectors ---- */

/* The side and depth of a detector, by which detectors are sorted into levels. */
struct place {
    bool below;
    double z;
    int number; /* number of the detector */
};

/* Orders detectors by side, level and number, for qsort. */
static int compare_places(const void *a, const void *b)
{
    const struct place *one = a, *other = b;
    if (one->below != other->below) return one->below ? 1 : -1;
    if (one->z != other->z) return one->z < other->z ? -1 : 1;
    return (one->number > other->number) - (one->number < other->number);
}

/* Adds all levels. A level is a run of detectors with the same side and depth, because place[] is sorted
 * by both. outline, number: [num_detectors] scratch. */
static cml_status add_levels(const struct cml_scene *scene, const double origin[2], const struct place *place,
                             struct cml_outline *outline, int *number, struct cml_owned_world *to,
                             int *num_levels, struct cml_error *err)
{
    const int n = cml_num_areas(scene);
    for (int first = 0, end; first < n; first = end) {
        const struct place at = place[first];
        struct cml_detector_level *level = &to->detector_levels[(*num_levels)++];
        for (end = first; end < n && place[end].below == at.below && place[end].z == at.z; end++) {
            number[end] = place[end].number;
            outline[end] = outline_of(scene, &scene->detectors[number[end]]);
        }
        CML_TRY(cml_add_level(outline + first, number + first, end - first, origin, &to->detector_cells,
                              level, err));
        level->below = at.below;
        level->z = (real)(at.z - scene->boundaries[at.below ? scene->num_layers : 0].z);
    }
    return CML_OK;
}

/* Returns enum CML_SPLIT_... for the light that is split off at launches, which goes straight up. */
static int split_of(const struct cml_world *world, int num_detectors, const struct cml_detector *detectors,
                    const struct cml_detector_def *defs)
{
    const struct cml_ray_out up = {.u = {0, 0, -1}};
    const bool alike = world->setup.num_sources == 1 && world->sources->shape == CML_BEAM_PENCIL &&
                       world->sources->middle.x == 0 && world->sources->middle.y == 0;
    for (int k = 0; k < num_detectors; k++)
        if (!defs[k].below && !defs[k].diffuse && (!defs[k].aimed || cml_is_in_cone(&detectors[k], &up)))
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

cml_status cml_set_detectors(const struct cml_scene *scene, const struct cml_surface_set *surfaces,
                             const struct cml_window_table *windows, struct cml_owned_world *to,
                             struct cml_error *err)
{
    const struct cml_tally_grid grid = cml_engine_grid(scene, surfaces, &(struct cml_engine_options){0});
    const size_t n = (size_t)scene->num_detectors;
    cml_u64 pixels = 0;
    int num_levels = 0;
    if (n == 0) return CML_OK;
    CML_FREED struct place *place = malloc(n * sizeof *place);
    CML_FREED struct cml_outline *outline = malloc(n * sizeof *outline);
    CML_FREED int *number = malloc(n * sizeof *number);
    to->detectors = cml_arrays_add(&to->arrays, n, sizeof *to->detectors);
    to->detector_levels = cml_arrays_add(&to->arrays, n, sizeof *to->detector_levels);
    to->detector_arcs = cml_arrays_add(&to->arrays, n, sizeof *to->detector_arcs);
    if (!place || !outline || !number || to->arrays.failed)
        return cml_fail_memory(err, (double)(n * sizeof *to->detectors), "detectors");
    for (size_t k = 0; k < n; k++) {
        const struct cml_detector_def *def = &scene->detectors[k];
        place[k] = (struct place){def->below, def->z, (int)k};
        to->detectors[k] = detector_of(scene, surfaces->origin.at, def);
        to->detectors[k].first_pixel = pixels;
        if (def->shape == CML_DETECTOR_MAP) pixels += (cml_u64)def->nx * (cml_u64)def->ny;
    }
    qsort(place, (size_t)cml_num_areas(scene), sizeof *place, compare_places);
    CML_TRY(add_levels(scene, surfaces->origin.at, place, outline, number, to, &num_levels, err));
    to->world.detection = (struct cml_detection){
        .num_detectors = (int)n,
        .num_levels = num_levels,
        .num_arcs = set_arcs(scene, windows, num_levels, to),
        .arcs = to->detector_arcs,
        .split = split_of(&to->world, cml_num_areas(scene), to->detectors, scene->detectors),
        .detectors = to->detectors,
        .levels = to->detector_levels,
        .start = to->detector_cells.start,
        .list = to->detector_cells.list,
        .per_length = 1 / grid.path_unit,
        .top = grid.path_top};
    return CML_OK;
}

/* ---- faces and ports on boundary 0, and the light that they stop ---- */

/* Makes the grid over the contacts that have a shape and are not hidden by a face that covers all. */
static cml_status make_contact_grid(const struct cml_scene *scene, const double origin[2],
                                    struct cml_owned_world *to, struct cml_error *err)
{
    const int first = to->world.contacts.whole, count = scene->num_contacts - first;
    if (count == 0) return CML_OK;
    CML_FREED struct cml_outline *outline = malloc((size_t)count * sizeof *outline);
    CML_FREED int *number = malloc((size_t)count * sizeof *number);
    if (!outline || !number) return cml_fail_memory(err, count * (double)sizeof *outline, "faces and ports");
    for (int k = 0; k < count; k++) {
        number[k] = first + k;
        outline[k] = cml_contact_outline(&scene->contacts[first + k]);
    }
    CML_TRY(cml_add_level(outline, number, count, origin, &to->contact_cells, &to->world.contacts.grid, err));
    to->world.contacts.start = to->contact_cells.start;
    to->world.contacts.list = to->contact_cells.list;
    return CML_OK;
}

cml_status cml_set_contacts(const struct cml_scene *scene, const double origin[2], struct cml_owned_world *to,
                            struct cml_error *err)
{
    const int count = scene->num_contacts;
    if (count == 0) return CML_OK;
    to->contacts = cml_arrays_add(&to->arrays, (size_t)count, sizeof *to->contacts);
    CML_TRY(cml_arrays_check(&to->arrays, "faces and ports", err));
    for (int k = 0; k < count; k++) {
        const struct cml_contact_def *def = &scene->contacts[k];
        const struct cml_outline outline = cml_contact_outline(def);
        to->contacts[k] = (struct cml_contact){.area = cml_area_of(&outline, origin),
                                               .is_port = def->port,
                                               .stops = !(def->port && def->n == scene->media[0].n),
                                               .n = def->n,
                                               .face = cml_backing_of(&def->face, 0, scene->media[1].n)};
    }
    to->world.contacts.count = count;
    to->world.contacts.whole = cml_contact_whole(scene);
    to->world.contacts.item = to->contacts;
    return make_contact_grid(scene, origin, to, err);
}

/* Light that starts in layer 1 or deeper, in a port or upwards meets nothing that could stop it. */
double cml_stopped_share(const struct cml_world *world, int k, int *passes)
{
    const int places = 4096;
    const cml_u64 first = world->setup.num_sources > 1 ? (cml_u64)k << CML_SOURCE_SHIFT : 0;
    int stopped = 0, upwards = 0;
    *passes = 1;
    if (world->sources[k].port) return 0;
    for (int i = 0; i < places; i++) {
        struct cml_packet packet;
        cml_place(world, first + (cml_u64)i, &packet);
        upwards += packet.medium == 0 && !(packet.u.z > 0);
        if (packet.medium > 0 || !(packet.u.z > 0)) continue;
        const struct cml_vec at = cml_along(packet.p, -packet.p.z / packet.u.z, packet.u);
        const struct cml_contact *contact = cml_contact_of(world, cml_contact_at(world, at.x, at.y));
        stopped += contact && contact->stops;
    }
    *passes = stopped == 0 || stopped + upwards < places;
    return (double)stopped / places;
}
