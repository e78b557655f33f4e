/* Finds the origin of x and y from which single precision resolves the whole scene. SPDX-License-Identifier:
 * MIT */
#include "surface/surface_origin.h"

#include "scene/body/body_shape.h"

#include <float.h>
#include <math.h>

/* Number of steps of single precision that must fit into the smallest length of a part. RING: width of a
 * ring, which needs the most steps, because crossings with cones are roots found in single precision. FACET:
 * side of a facet. LENGTH: length of a body, a detector or a bin, or spacing of a tile's heights. */
enum { STEPS_OF_RING = 4096, STEPS_OF_FACET = 256, STEPS_OF_LENGTH = 32 };

/* Returns the largest allowed distance of a part from the origin, cm, for which `steps` steps of single
 * precision fit into `length` (cm). */
static double distance_for(double length, int steps)
{
    return length / (steps * (double)FLT_EPSILON);
}

/* The rectangle in which the origin may lie, cm. */
struct range {
    double low[2], high[2];
};

static const struct range anywhere = {{-INFINITY, -INFINITY}, {INFINITY, INFINITY}};

/* Returns the square around a place that reaches as far as `distance`, cm. */
static struct range range_about(const double at[2], double distance)
{
    return (struct range){{at[0] - distance, at[1] - distance}, {at[0] + distance, at[1] + distance}};
}

/* Returns the intersection of two ranges; it may be empty. */
static struct range intersection(struct range a, struct range b)
{
    for (int k = 0; k < 2; k++) {
        a.low[k] = fmax(a.low[k], b.low[k]);
        a.high[k] = fmin(a.high[k], b.high[k]);
    }
    return a;
}

/* True if the range contains no place. */
static bool is_empty(struct range range)
{
    return !(range.low[0] <= range.high[0] && range.low[1] <= range.high[1]);
}

/* True if the place lies in the range. */
static bool holds(struct range range, const double at[2])
{
    return at[0] >= range.low[0] && at[0] <= range.high[0] && at[1] >= range.low[1] && at[1] <= range.high[1];
}

/* Finds the place where the axis of a beam that starts outside the scene meets the first or the last nominal
 * plane. For any other beam it is the beam's own position. */
static void find_anchor(const struct cml_scene *scene, const struct cml_beam *beam, double at[2])
{
    const double bottom = scene->boundaries[scene->num_layers].z, down = cml_beam_descent(beam);
    const double rest = beam->z < 0 ? -beam->z : beam->z > bottom ? bottom - beam->z : 0;
    const double way = beam->inside && rest * down > 0 ? rest / down * cml_beam_sine(beam) : 0;
    at[0] = beam->x + way * cos(beam->azimuth);
    at[1] = beam->y + way * sin(beam->azimuth);
}

/* ---- required resolution ---- */

/* The requirements on the origin collected so far. */
struct requirements {
    const struct cml_scene *scene;
    struct range range;
    double distance; /* smallest allowed distance from the origin over all parts, cm */
    double flight;   /* like `distance`, but with rings counted as facets, because light from outside the
                        boundary meets rings as it meets facets */
};

/* A part of the scene: its position and its smallest length, cm. */
struct part {
    const char *file;
    int line;
    char name[64];
    const char *length_name;
    double at[2], length;
    int steps;
};

/* Narrows the range of the origin so that single precision resolves a part. Refuses the scene, with the
 * part's name, if the range would be empty. */
static cml_status require_part(struct requirements *all, const struct part *part, struct cml_error *err)
{
    const double distance = distance_for(part->length, part->steps);
    const struct range range = intersection(all->range, range_about(part->at, distance));
    double away = 0;
    if (!is_empty(range)) {
        all->range = range;
        all->distance = fmin(all->distance, distance);
        all->flight =
            fmin(all->flight,
                 distance_for(part->length, part->steps < STEPS_OF_FACET ? part->steps : STEPS_OF_FACET));
        return CML_OK;
    }
    for (int k = 0; k < 2; k++)
        away = fmax(away, fmax(all->range.low[k] - part->at[k], part->at[k] - all->range.high[k]));
    /* 1.005: %.3g must not round below the least length */
    return cml_fail(err, CML_E_INPUT,
                    "%s:%d: %s at (%g %g) cm: %s %g cm (expected at least %.3g cm, or a place %.3g cm nearer "
                    "to the rest of the scene: single precision has steps of %.2g cm there)",
                    part->file, part->line, part->name, part->at[0], part->at[1], part->length_name,
                    part->length, 1.005 * part->steps * (double)FLT_EPSILON * away, away, FLT_EPSILON * away);
}

/* Requires that single precision resolves the spacing of a tile's heights where each beam meets the tile.
 * Steps may be coarser than for a mesh, which lies in one place: light spreads over a tile away from any
 * origin, and meets the tile everywhere. */
static cml_status require_tile(struct requirements *all, int b, struct cml_error *err)
{
    const struct cml_scene *scene = all->scene;
    const struct cml_heightmap *tile = &scene->boundaries[b].tile;
    for (int k = 0; k < scene->num_beams; k++) {
        struct part part = {.file = scene->file,
                            .line = scene->beams[k].line,
                            .length_name = "the spacing of its heights is",
                            .length = fmin(tile->dx, tile->dy),
                            .steps = STEPS_OF_LENGTH};
        find_anchor(scene, &scene->beams[k], part.at);
        snprintf(part.name, sizeof part.name, "beam %d meets the tile of boundary %d", k + 1, b);
        CML_TRY(require_part(all, &part, err));
    }
    return CML_OK;
}

/* Requires that single precision resolves a boundary: the mean side of its facets, or the mean width of its
 * rings. */
static cml_status require_boundary(struct requirements *all, int b, struct cml_error *err)
{
    const struct cml_boundary *boundary = &all->scene->boundaries[b];
    const struct cml_mesh *mesh = &boundary->mesh;
    const struct cml_radial *radial = &boundary->radial;
    struct part part = {.file = all->scene->file, .line = boundary->line, .steps = STEPS_OF_FACET};
    if (boundary->form == CML_FORM_TILE) return require_tile(all, b, err);
    if (boundary->form == CML_FORM_PLANE || (boundary->form == CML_FORM_RADIAL && radial->n < 2))
        return CML_OK;
    if (boundary->form == CML_FORM_RADIAL) {
        part.length = radial->r[radial->n - 1] / (radial->n - 1);
        part.length_name = "the mean width of its rings is";
        part.steps = STEPS_OF_RING;
        snprintf(part.name, sizeof part.name, "boundary %d: heightfield", b);
    } else {
        const double wide = mesh->upper[0] - mesh->lower[0], deep = mesh->upper[1] - mesh->lower[1];
        part.length = sqrt(2 * wide * deep / (double)mesh->num_triangles);
        part.length_name = "the mean side of its facets is";
        snprintf(part.name, sizeof part.name, "boundary %d: mesh", b);
        for (int k = 0; k < 2; k++) part.at[k] = 0.5 * (mesh->lower[k] + mesh->upper[k]);
    }
    return require_part(all, &part, err);
}

/* Returns half the width of a ring, or of a rectangle's shorter side; the radius of a disk. */
static double half_width(bool round, const double size[2])
{
    if (round) return size[0] == 0 ? size[1] : 0.5 * (size[1] - size[0]);
    return 0.5 * fmin(size[0], size[1]);
}

/* Requires that single precision resolves a face or port with a shape. */
static cml_status require_contact(struct requirements *all, int k, struct cml_error *err)
{
    const struct cml_contact_def *def = &all->scene->contacts[k];
    struct part part = {.file = all->scene->file,
                        .line = def->line,
                        .length_name = "its half width is",
                        .at = {def->x, def->y},
                        .length = half_width(def->shape == CML_DETECTOR_RING, def->size),
                        .steps = STEPS_OF_LENGTH};
    if (def->whole) return CML_OK;
    snprintf(part.name, sizeof part.name, "%s%s", def->port ? "port " : "face", def->port ? def->name : "");
    return require_part(all, &part, err);
}

/* Requires that single precision resolves a detector: its half width, or half a pixel of its map. */
static cml_status require_detector(struct requirements *all, int k, struct cml_error *err)
{
    const struct cml_detector_def *def = &all->scene->detectors[k];
    struct part part = {.file = def->table ? def->table : all->scene->file,
                        .line = def->table ? def->row : def->line,
                        .length_name = "its half width is",
                        .at = {def->x, def->y},
                        .length = half_width(cml_detector_is_round(def), def->size),
                        .steps = STEPS_OF_LENGTH};
    if (def->shape == CML_DETECTOR_MAP) part.length_name = "half the width of its pixels is";
    snprintf(part.name, sizeof part.name, "detector %s", def->name);
    return require_part(all, &part, err);
}

/* Adds a body's requirement. A body too far from the rest is not refused here but when its surface is made,
 * since the steps of single precision at its place are known then. */
static void require_body(struct requirements *all, const struct cml_scene_body *body)
{
    double lower[3], upper[3], extent = 0, size = INFINITY;
    cml_body_box(body, lower, upper);
    for (int k = 0; k < 3; k++) size = fmin(size, 0.5 * (upper[k] - lower[k]));
    for (int k = 0; k < 2; k++) extent = fmax(extent, 0.5 * (upper[k] - lower[k]));
    if (body->form != CML_BODY_MESH) size = fmin(size, body->radius);
    const double middle[2] = {0.5 * (lower[0] + upper[0]), 0.5 * (lower[1] + upper[1])};
    const double distance = distance_for(size, STEPS_OF_LENGTH);
    const struct range range = intersection(all->range, range_about(middle, distance - extent));
    all->distance = fmin(all->distance, distance);
    all->flight = fmin(all->flight, distance);
    if (!is_empty(range)) all->range = range;
}

/* Collects the requirements of all boundaries, faces and ports, detectors and bodies. */
static cml_status require_all(struct requirements *all, struct cml_error *err)
{
    for (int b = 0; b <= all->scene->num_layers; b++) CML_TRY(require_boundary(all, b, err));
    for (int k = 0; k < all->scene->num_contacts; k++) CML_TRY(require_contact(all, k, err));
    for (int k = 0; k < cml_num_areas(all->scene); k++) CML_TRY(require_detector(all, k, err));
    for (int k = 0; k < all->scene->num_bodies; k++) require_body(all, &all->scene->bodies[k]);
    return CML_OK;
}

/* ---- bins, which may lie where there is no light ---- */

/* Returns the number, from 1, of a beam whose axis meets the scene inside the range; 0 if there is none. */
static int beam_in(const struct cml_scene *scene, struct range range)
{
    double at[2];
    for (int k = 0; k < scene->num_beams; k++) {
        find_anchor(scene, &scene->beams[k], at);
        if (holds(range, at)) return k + 1;
    }
    return 0;
}

/* Adds the requirement that single precision resolves result bins of size `length` about a place. If other
 * parts of the scene leave no origin for that, bins without light lose nothing and are accepted; bins on
 * which a beam shines are refused. */
static cml_status require_bins(const double at[2], double length, double extent, struct requirements *all,
                               struct cml_error *err)
{
    const struct cml_scene *scene = all->scene;
    const double distance = distance_for(length, STEPS_OF_LENGTH);
    const struct range own = range_about(at, distance - extent), range = intersection(all->range, own);
    double away = 0;
    all->distance = fmin(all->distance, distance);
    if (!is_empty(range)) {
        all->range = range;
        return CML_OK;
    }
    const int beam = is_empty(own) ? 0 : beam_in(scene, own);
    for (int k = 0; k < 2; k++)
        away = fmax(away, fmax(all->range.low[k] - at[k], at[k] - all->range.high[k]));
    if (beam == 0) return CML_OK;
    return cml_fail(
        err, CML_E_INPUT,
        "%s:%d: beam %d shines on bins of %g cm about (%g %g) cm, and a shape, body or detector is "
        "so far away that single precision has steps of %g cm here (expected at most %g cm: parts "
        "nearer to each other)",
        scene->file, scene->beams[beam - 1].given ? scene->beams[beam - 1].line : scene->line, beam, length,
        at[0], at[1], FLT_EPSILON * away, length / STEPS_OF_LENGTH);
}

/* Adds the requirements of the bins of results: the radial bins and the pixels of the map. */
static cml_status require_all_bins(struct requirements *all, struct cml_error *err)
{
    const struct cml_scene *scene = all->scene;
    const struct cml_map_def *map = &scene->map;
    const double zero[2] = {0, 0}, own[2] = {scene->beams[0].x, scene->beams[0].y};
    CML_TRY(require_bins(scene->beams[0].radial ? own : zero, scene->dr, scene->nr * scene->dr, all, err));
    if (map->nx == 0) return CML_OK;
    return require_bins(zero, fmin(map->dx, map->dy), 0.5 * fmax(map->nx * map->dx, map->ny * map->dy), all,
                        err);
}

/* ---- the origin ---- */

/* Sets `at` to the first beam's position if it lies in the range; else to the place where a beam meets the
 * scene, for the first beam for which that place lies in the range. Returns false if there is none. */
static bool find_beam(const struct cml_scene *scene, struct range range, double at[2])
{
    at[0] = scene->beams[0].x;
    at[1] = scene->beams[0].y;
    if (holds(range, at)) return true;
    for (int k = 0; k < scene->num_beams; k++) {
        find_anchor(scene, &scene->beams[k], at);
        if (holds(range, at)) return true;
    }
    return false;
}

/* Sets `at` to the point of the range that is nearest to the place where the first beam meets the scene. Used
 * if no beam meets the scene inside the range. */
static void find_nearest(const struct cml_scene *scene, struct range range, double at[2])
{
    find_anchor(scene, &scene->beams[0], at);
    for (int k = 0; k < 2; k++) at[k] = fmin(fmax(at[k], range.low[k]), range.high[k]);
}

/* An origin far from x = y = 0 is rounded to single precision, so that host and devices have the same number.
 * */
cml_status cml_surface_origin(const struct cml_scene *scene, struct cml_origin *origin, struct cml_error *err)
{
    struct requirements parts = {.scene = scene, .range = anywhere, .distance = INFINITY, .flight = INFINITY};
    CML_TRY(require_all(&parts, err));
    struct requirements all = parts;
    CML_TRY(require_all_bins(&all, err));
    origin->flight = parts.flight;
    origin->all = all.distance;
    if (!find_beam(scene, all.range, origin->at) && !find_beam(scene, parts.range, origin->at))
        find_nearest(scene, parts.range, origin->at);
    for (int k = 0; k < 2; k++)
        if (fabs(origin->at[k]) > all.distance) origin->at[k] = (double)(float)origin->at[k];
    return CML_OK;
}
