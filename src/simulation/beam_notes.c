/* SPDX-License-Identifier: MIT */
#include "simulation/beam_notes.h"

#include "base/constants.h"
#include "base/text.h"
#include "simulation/scenes.h"
#include "engine/world.h"
#include "geometry/footprint.h"
#include "scene/contact.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Shows a note on a line of the .mci file, and on the line of a boundary. */
#define note_line(scene, line, ...) cml_note("%.500s:%d: %s", (scene)->file, line, CML_TEXT(__VA_ARGS__))
#define note(scene, b, ...) note_line(scene, (scene)->boundaries[b].line, __VA_ARGS__)

/* Notes beams and maps that reach beyond the mesh of boundary b, where light meets the plane in which the
 * boundary continues. The beam's axis is taken as straight, down to the depth of the mesh's border. */
static cml_status note_reach(const struct cml_scene *scene, int b, struct cml_error *err)
{
    const struct cml_boundary *boundary = &scene->boundaries[b];
    const struct cml_map_def *map = &scene->map;
    const double upper[2] = {map->nx * map->dx / 2, map->ny * map->dy / 2}, lower[2] = {-upper[0], -upper[1]};
    struct cml_footprint *footprint;
    CML_TRY(cml_footprint_create(&boundary->mesh, &footprint, err));
    for (int k = 0; k < scene->num_beams; k++) {
        const struct cml_beam *beam = &scene->beams[k];
        const double way = (boundary->z + boundary->mesh.z_border) * tan(beam->angle);
        const double x = beam->x + way * cos(beam->azimuth), y = beam->y + way * sin(beam->azimuth);
        if (!beam->inside && !cml_footprint_contains(footprint, x, y))
            note(scene, b, "the beam's axis passes boundary %d at x = %g, y = %g cm, beyond its mesh", b, x,
                 y);
    }
    if (map->nx > 0 && !cml_footprint_contains_box(footprint, lower, upper))
        note(scene, b, "the map, %g x %g cm, reaches beyond the mesh of boundary %d", 2 * upper[0],
             2 * upper[1], b);
    cml_footprint_free(footprint);
    return CML_OK;
}

/* Returns the first boundary with a shape that all light of a pencil meets on one straight line: no medium
 * above it scatters, and no plane above it refracts. -1: none. */
static int first_shape(const struct cml_scene *scene)
{
    for (int b = 0; b <= scene->num_layers; b++) {
        if (scene->boundaries[b].form != CML_FORM_PLANE) return b;
        if (scene->media[b + 1].mus > 0 || cml_layer_has_bodies(scene, b + 1) || scene->beams[0].angle > 0)
            break;
    }
    return -1;
}

/* Notes a pencil on a rough surface, because all results are of the one point that the pencil meets. Radial
 * heightfields get no note: a pencil on them is meant for their middle. */
static void note_pencil(const struct cml_scene *scene, const struct cml_surface_set *surfaces)
{
    const struct cml_beam *beam = &scene->beams[0];
    const int b = first_shape(scene);
    if (scene->num_beams > 1 || beam->inside || beam->light.kind != CML_LIGHT_OF_PARALLEL) return;
    if (beam->shape != CML_BEAM_PENCIL || b < 0 || scene->boundaries[b].form == CML_FORM_RADIAL) return;
    const struct cml_surface_def *def = &surfaces->item[b];
    if (def->kind != CML_SURFACE_MESH) return;
    const double room = 1 + def->highest - def->lowest, z = def->lowest - room;
    const double u[3] = {sin(beam->angle) * cos(beam->azimuth), sin(beam->angle) * sin(beam->azimuth),
                         cos(beam->angle)};
    const double way = (def->depth + z) / u[2], p[3] = {way * u[0], way * u[1], z};
    struct cml_mesh_crossing at;
    if (!cml_mesh_surface_hit(def->mesh, p, u, 0, 4 * room / u[2], -1, 0, 1, 0, &at)) return;
    if (at.primitive == CML_OUTER_PLANE) return;
    const bool tile = scene->boundaries[b].form == CML_FORM_TILE;
    const char *advice = tile ? "one period, beam rectangle tile" : "whole periods, beam rectangle W H";
    note(scene, b,
         "a pencil meets boundary %d at one point: height %.3g cm, slope %.3g (for what the whole surface "
         "does: a beam over %s)",
         b, scene->boundaries[b].z - def->depth - at.point[2],
         hypot(at.facet[0], at.facet[1]) / fabs(at.facet[2]), advice);
}

/* Notes a rectangle that does not light a whole number of periods of a tile along x and y: one part of the
 * tile then gets more light than the rest. On a level plane an oblique rectangle is longer by 1 / cos(angle).
 */
static void note_periods(const struct cml_scene *scene, int k, int b)
{
    const struct cml_beam *beam = &scene->beams[k];
    const double *period = scene->boundaries[b].period, to = 180 / CML_PI;
    int axis[2];
    const bool along = cml_beam_axes(beam, axis);
    const double lit[2] = {beam->size[0] / cos(beam->angle) / period[axis[0]],
                           beam->size[1] / period[axis[1]]};
    bool even = along;
    for (int i = 0; i < 2; i++) even = even && round(lit[i]) >= 1 && fabs(lit[i] / round(lit[i]) - 1) < 1e-6;
    if (even) return;
    if (along)
        note_line(scene, beam->line,
                  "beam %d lights %.4g x %.4g periods of the tile of boundary %d, not evenly (for whole "
                  "periods at any angle: beam rectangle tile)",
                  k + 1, lit[0], lit[1], b);
    else
        note_line(scene, beam->line,
                  "beam %d, a rectangle at azimuth %g degrees, lights the tile of boundary %d unevenly (for "
                  "whole periods: an azimuth of 0 or 90, and beam rectangle tile)",
                  k + 1, beam->azimuth * to, b);
}

/* Notes rectangles from above that light a tile unevenly. */
static void note_rectangles(const struct cml_scene *scene)
{
    int b = 0;
    while (b <= scene->num_layers && scene->boundaries[b].form != CML_FORM_TILE) b++;
    for (int k = 0; b <= scene->num_layers && k < scene->num_beams; k++)
        if (scene->beams[k].shape == CML_BEAM_RECTANGLE && !scene->beams[k].inside) note_periods(scene, k, b);
}

/* True if light about the axis has rays with an angle between t and pi - t to the vertical. */
static bool has_flat_rays(const struct cml_beam *beam, double n, double t)
{
    const double widest = cml_light_widest(&beam->light, n);
    return beam->angle + widest > t && beam->angle - widest < CML_PI - t;
}

/* Returns the index above a layer between planes: what light meets there that has left all ports behind. 0: a
 * mirror. INFINITY: a face that ends light in time, because it absorbs or gives light a new direction. */
static double index_above(const struct cml_scene *scene, int layer)
{
    const int whole = layer == 1 ? cml_contact_whole(scene) : 0;
    if (!whole) return scene->media[layer - 1].n;
    const struct cml_backing_def *face = &scene->contacts[whole - 1].face;
    return cml_reflects_all(face) && face->kind != CML_BACKING_LAMBERTIAN ? 0 : INFINITY;
}

/* Notes light that starts in a clear layer with total reflection at both neighbours: between planes this
 * light never leaves. A rough boundary changes its direction, so there is no note then. */
static void note_trapped(const struct cml_scene *scene, int k, int medium)
{
    const struct cml_beam *beam = &scene->beams[k];
    if (medium == scene->num_layers && scene->backing.kind != CML_BACKING_NONE) return;
    if (medium < 1 || medium > scene->num_layers || cml_layer_has_bodies(scene, medium)) return;
    for (int b = medium - 1; b <= medium; b++)
        if (cml_is_rough(&scene->boundaries[b].rough)) return;
    const struct cml_medium_def *own = &scene->media[medium];
    const double most = fmax(index_above(scene, medium), own[1].n);
    if (cml_medium_mut(own) > 0 || most >= own->n || !has_flat_rays(beam, own->n, asin(most / own->n)))
        return;
    note_line(
        scene, beam->line,
        "beam %d starts in layer %d, which is clear and has a larger n than %s: what planes reflect totally "
        "there, beyond %g degrees from the vertical, is trapped, and counted as such",
        k + 1, medium, index_above(scene, medium) > 0 ? "both its neighbours" : "what is below its mirror",
        asin(most / own->n) * 180 / CML_PI);
}

/* Notes a beam that starts beyond all heights of the first or last surface, and leads away from it with all
 * its light. */
static void note_lost(const struct cml_scene *scene, const struct cml_surface_set *surfaces, int k)
{
    const struct cml_beam *beam = &scene->beams[k];
    const struct cml_surface_def *first = &surfaces->item[0], *last = &surfaces->item[scene->num_layers];
    const double height = cml_beam_height(beam);
    const bool above =
        beam->z + height<first->depth + first->lowest, below = beam->z - height> last->depth + last->highest;
    const double widest = cml_light_widest(&beam->light, scene->media[above ? 0 : scene->num_layers + 1].n);
    if (!(above && beam->angle - widest >= CML_PI / 2) && !(below && beam->angle + widest <= CML_PI / 2))
        return;
    note_line(scene, beam->line, "beam %d starts %s all layers and shines %s: none of its light meets them",
              k + 1, above ? "above" : "below", above ? "up" : "down");
}

/* Notes beams that faces and ports stop in part. */
static void note_stopped(const struct cml_scene *scene, const double *stopped)
{
    for (int k = 0; k < scene->num_beams; k++)
        if (stopped[k] > 0)
            note_line(
                scene, scene->beams[k].line,
                "faces and ports stop %.3g %% of beam %d, and count it in A_face (for light of a fibre: "
                "beam port NAME)",
                100 * stopped[k], k + 1);
}

/* Notes light that faces stop from above, and a lambertian face over a clear layer that traps light: the face
 * sends it into directions that both planes reflect totally. */
static void note_faces(const struct cml_scene *scene, const double *stopped)
{
    const struct cml_medium_def *own = &scene->media[1];
    note_stopped(scene, stopped);
    if (cml_medium_mut(own) > 0 || cml_layer_has_bodies(scene, 1) ||
        own->n <= fmin(own[-1].n, index_above(scene, 1)) || own->n <= own[1].n ||
        cml_is_rough(&scene->boundaries[1].rough) ||
        (scene->num_layers == 1 && scene->backing.kind != CML_BACKING_NONE))
        return;
    for (int k = 0; k < scene->num_contacts; k++)
        if (scene->contacts[k].face.kind == CML_BACKING_LAMBERTIAN) {
            note_line(
                scene, scene->contacts[k].line,
                "a lambertian face over layer 1, which is clear and has a larger n than what is above and "
                "below: what planes reflect totally there is trapped, and counted as such");
            return;
        }
}

cml_status cml_check_starts(const struct cml_scene *scene, const struct cml_surface_options *options,
                            struct cml_error *err)
{
    CML_AT_END(cml_surfaces_free) struct cml_surface_set surfaces = {0};
    CML_FREED int *medium = NULL;
    if (!cml_scene_starts_inside(scene) && scene->num_contacts == 0) return CML_OK;
    CML_TRY(cml_surfaces_create(scene, options, &surfaces, err));
    return cml_source_media(scene, &surfaces, &medium, NULL, err);
}

cml_status cml_note_beam(const struct cml_scene *scene, const struct cml_surface_set *surfaces, int **starts,
                         struct cml_error *err)
{
    int *medium;
    for (int b = 0; b <= scene->num_layers; b++)
        if (scene->boundaries[b].form == CML_FORM_MESH) CML_TRY(note_reach(scene, b, err));
    note_pencil(scene, surfaces);
    note_rectangles(scene);
    CML_FREED double *stopped = calloc((size_t)scene->num_beams, sizeof *stopped);
    if (!stopped) return cml_fail_memory(err, scene->num_beams * 8.0, "the beams");
    CML_TRY(cml_source_media(scene, surfaces, &medium, stopped, err));
    note_faces(scene, stopped);
    for (int k = 0; k < scene->num_beams; k++) {
        if (!scene->beams[k].inside) continue;
        note_trapped(scene, k, medium[k]);
        note_lost(scene, surfaces, k);
    }
    if (starts) *starts = medium;
    if (!starts) free(medium);
    return CML_OK;
}
