/* Copies and frees scenes, and answers small questions about beams, bodies and boundaries.
 * SPDX-License-Identifier: MIT */
#include "scene/scene.h"

#include "base/array.h"
#include "base/constants.h"
#include "base/shared.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void cml_boundary_flatten(struct cml_boundary *boundary)
{
    free(boundary->radial.r);
    free(boundary->radial.h);
    boundary->radial = (struct cml_radial){0};
    if (boundary->form == CML_FORM_MESH) cml_mesh_clear(&boundary->mesh);
    boundary->mesh_notes = (struct cml_mesh_notes){0};
    boundary->map_notes = (struct cml_heightmap_notes){0};
    cml_heightmap_clear(&boundary->tile);
    boundary->tile_notes = (struct cml_tile_notes){0};
    boundary->form = CML_FORM_PLANE;
}

void cml_scene_ask_nothing(struct cml_scene *scene)
{
    scene->map = (struct cml_map_def){0};
    scene->facets = 0;
    scene->time = (struct cml_time_def){0};
    scene->directions = (struct cml_directions_def){0};
    scene->fluence = (struct cml_fluence_def){0};
    scene->saved = (struct cml_saved_def){0};
    scene->num_detectors = scene->num_groups = 0;
}

void cml_boundary_clear(struct cml_boundary *boundary)
{
    const struct cml_boundary kept = {.z = boundary->z, .rough = boundary->rough};
    if (cml_share_end(boundary->users)) {
        cml_boundary_flatten(boundary);
        free(boundary->file);
    }
    *boundary = kept;
}

/* Frees the bodies of a scene, unless another scene still shares them. */
static void clear_bodies(struct cml_scene *scene)
{
    if (!cml_share_end(scene->body_users)) return;
    for (int k = 0; k < scene->num_bodies; k++) {
        free(scene->bodies[k].file);
        cml_mesh_clear(&scene->bodies[k].mesh);
    }
    free(scene->bodies);
}

/* Frees a beam's table and image when their last user goes. */
static void clear_beam(struct cml_beam *beam)
{
    if (!cml_share_end(beam->users)) return;
    free(beam->light.t);
    free(beam->light.intensity);
    free(beam->pixel);
    free(beam->port);
}

void cml_scene_clear(struct cml_scene *scene)
{
    /* A scene that was refused while being read may have its number of layers set, but no boundaries yet. */
    for (int b = 0; scene->boundaries && b <= scene->num_layers; b++)
        cml_boundary_clear(&scene->boundaries[b]);
    clear_bodies(scene);
    for (int k = 0; scene->beams && k < scene->num_beams; k++) clear_beam(&scene->beams[k]);
    for (int k = 0; scene->detectors && k < scene->num_detectors; k++) {
        free(scene->detectors[k].name);
        free(scene->detectors[k].port);
        free(scene->detectors[k].table);
    }
    for (int k = 0; scene->contacts && k < scene->num_contacts; k++) free(scene->contacts[k].name);
    free(scene->contacts);
    free(scene->detectors);
    free(scene->beams);
    free(scene->shares);
    free(scene->boundaries);
    free(scene->media);
    free(scene->layer_names);
    cml_phases_free(scene->phases);
    free(scene->file);
    free(scene->output);
    free(scene->saved.name);
    free(scene->text);
    free(scene->settings);
    *scene = (struct cml_scene){0};
}

/* ---- copies ---- */

static char *copied_text(const char *from, bool *failed)
{
    return cml_array_copy(from, from ? strlen(from) + 1 : 0, 1, failed);
}

/* Copies the list of phase functions, and points the copied media to the copies with the same numbers. */
static void copy_phases(const struct cml_scene *from, struct cml_scene *to, bool *failed)
{
    const size_t media = (size_t)from->num_layers + 2 + (size_t)from->num_bodies;
    struct cml_phase *copy[CML_MOST_PHASES], **end = &to->phases;
    for (const struct cml_phase *phase = from->phases; phase && !*failed; phase = phase->next) {
        *end = cml_array_copy(phase, 1, sizeof *phase, failed);
        if (*failed) return;
        copy[phase->index] = *end;
        cml_share((*end)->users);
        end = &(*end)->next;
        *end = NULL;
    }
    for (size_t m = 0; to->phases && !*failed && m < media; m++)
        if (to->media[m].phase) to->media[m].phase = copy[to->media[m].phase->index];
}

/* Gives a copied scene its own texts, as each scene frees its texts. *failed becomes true if memory runs
 * out. */
static void copy_texts(const struct cml_scene *from, struct cml_scene *to, bool *failed)
{
    to->file = copied_text(from->file, failed);
    to->output = copied_text(from->output, failed);
    to->saved.name = copied_text(from->saved.name, failed);
    to->text = copied_text(from->text, failed);
    to->settings = copied_text(from->settings, failed);
    for (int k = 0; to->detectors && k < to->num_detectors; k++) {
        to->detectors[k].name = copied_text(from->detectors[k].name, failed);
        to->detectors[k].port = copied_text(from->detectors[k].port, failed);
        to->detectors[k].table = copied_text(from->detectors[k].table, failed);
    }
    for (int k = 0; to->contacts && k < to->num_contacts; k++)
        to->contacts[k].name = copied_text(from->contacts[k].name, failed);
}

cml_status cml_scene_copy(const struct cml_scene *from, struct cml_scene *to, struct cml_error *err)
{
    const size_t layers = (size_t)from->num_layers, bodies = (size_t)from->num_bodies,
                 beams = (size_t)from->num_beams, media = layers + 2 + bodies;
    bool failed = false;
    *to = *from;
    to->phases = NULL;
    cml_share(to->body_users);
    to->media = cml_array_copy(from->media, media, sizeof *to->media, &failed);
    to->layer_names = cml_array_copy(from->layer_names, from->layer_names ? layers + 1 : 0,
                                     sizeof *to->layer_names, &failed);
    to->boundaries = cml_array_copy(from->boundaries, layers + 1, sizeof *to->boundaries, &failed);
    to->beams = cml_array_copy(from->beams, beams, sizeof *to->beams, &failed);
    to->shares = cml_array_copy(from->shares, beams, sizeof *to->shares, &failed);
    to->detectors =
        cml_array_copy(from->detectors, (size_t)from->num_detectors, sizeof *to->detectors, &failed);
    to->contacts = cml_array_copy(from->contacts, (size_t)from->num_contacts, sizeof *to->contacts, &failed);
    for (size_t b = 0; to->boundaries && b <= layers; b++) cml_share(to->boundaries[b].users);
    for (size_t k = 0; to->beams && k < beams; k++) cml_share(to->beams[k].users);
    copy_texts(from, to, &failed);
    copy_phases(from, to, &failed);
    if (!failed) return CML_OK;
    cml_scene_clear(to);
    return cml_fail_memory(err, (double)(media * sizeof *to->media), "a scene");
}

/* The widest angle of a table is the end of its last interval that is not dark. */
double cml_light_widest(const struct cml_light *light, double medium_n)
{
    int last = light->rows - 1;
    switch (light->kind) {
    case CML_LIGHT_OF_PARALLEL:
        return 0;
    case CML_LIGHT_OF_NA:
        return asin(fmin(1, light->na / medium_n));
    case CML_LIGHT_OF_LAMBERTIAN:
        return CML_PI / 2;
    case CML_LIGHT_OF_ISOTROPIC:
        return CML_PI;
    default:
        while (last > 1 && light->intensity[last - 1] == 0 && light->intensity[last] == 0) last--;
        return light->t[last];
    }
}

/* Returns the number of the first body in layer l or in a layer below it. */
static int first_body_from(const struct cml_scene *scene, int l)
{
    int low = 0, high = scene->num_bodies;
    while (low < high) {
        const int middle = low + (high - low) / 2;
        if (scene->bodies[middle].layer < l)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

bool cml_scene_starts_inside(const struct cml_scene *scene)
{
    for (int k = 0; k < scene->num_beams; k++)
        if (scene->beams[k].inside) return true;
    return false;
}

/* The sine of a rounded pi is not 0. */
double cml_beam_sine(const struct cml_beam *beam)
{
    return beam->angle < CML_PI ? sin(beam->angle) : 0;
}

/* The cosine of a rounded pi / 2 is not 0. */
double cml_beam_descent(const struct cml_beam *beam)
{
    return beam->angle == CML_PI / 2 ? 0 : cos(beam->angle);
}

/* reach: the radius or half width of each shape; of a Gaussian five radii. */
double cml_beam_height(const struct cml_beam *beam)
{
    const double reach[] = {
        0, beam->size[0], 5 * beam->size[0], beam->size[1], beam->size[0] / 2, beam->size[0] / 2};
    return reach[beam->shape] * fabs(sin(beam->angle));
}

bool cml_beam_axes(const struct cml_beam *beam, int axis[2])
{
    const double quarters = beam->azimuth / (CML_PI / 2), whole = round(quarters);
    axis[0] = fmod(whole, 2) != 0;
    axis[1] = 1 - axis[0];
    return fabs(quarters - whole) < 1e-9;
}

struct cml_body_range cml_layer_bodies(const struct cml_scene *scene, int l)
{
    return (struct cml_body_range){first_body_from(scene, l), first_body_from(scene, l + 1)};
}

bool cml_layer_has_bodies(const struct cml_scene *scene, int l)
{
    const struct cml_body_range range = cml_layer_bodies(scene, l);
    return range.first < range.end;
}

void cml_scene_list_clear(struct cml_scene_list *list)
{
    for (int i = 0; i < list->count; i++) cml_scene_clear(&list->scenes[i]);
    free(list->scenes);
    *list = (struct cml_scene_list){0};
}

double cml_radial_height(const struct cml_radial *radial, double r)
{
    const int last = radial->n - 1;
    if (r >= radial->r[last]) return radial->h[last];
    const size_t i = cml_last_not_above(radial->r, (size_t)last, r);
    const double t = (r - radial->r[i]) / (radial->r[i + 1] - radial->r[i]);
    return radial->h[i] + t * (radial->h[i + 1] - radial->h[i]);
}

double cml_light_spread(const struct cml_light *light, double medium_n)
{
    const double *t = light->t, *intensity = light->intensity;
    double half = 0;
    int last = light->rows - 1;
    if (light->kind != CML_LIGHT_OF_TABLE) return cml_light_widest(light, medium_n);
    for (int i = 0; i < light->rows; i++) half = fmax(half, intensity[i] / 2);
    while (intensity[last] < half) last--;
    if (last == light->rows - 1) return t[last];
    return t[last] +
           (t[last + 1] - t[last]) * (intensity[last] - half) / (intensity[last] - intensity[last + 1]);
}

double cml_outer_height(const struct cml_boundary *boundary)
{
    if (boundary->form == CML_FORM_RADIAL) return boundary->radial.h[boundary->radial.n - 1];
    if (boundary->form == CML_FORM_TILE) return boundary->tile_notes.relief.mean;
    return boundary->form == CML_FORM_MESH ? -boundary->mesh.z_border : 0;
}
