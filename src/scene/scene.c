/* What belongs to a scene is freed here, and a radial height is looked up. SPDX-License-Identifier: MIT */
#include "scene/scene.h"

#include "base/constants.h"

#include <math.h>
#include <stdlib.h>

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
    scene->facets = false;
    scene->time = (struct cml_time_def){0};
    scene->directions = (struct cml_directions_def){0};
    scene->fluence = (struct cml_fluence_def){0};
    scene->saved = (struct cml_saved_def){0};
    scene->num_detectors = 0;
}

static void clear_boundary(struct cml_boundary *boundary)
{
    if (boundary->borrowed) return;
    cml_boundary_flatten(boundary);
    free(boundary->file);
}

void cml_scene_clear(struct cml_scene *scene)
{
    /* A scene that was refused half way may know its number of layers before it has them. */
    for (int b = 0; scene->boundaries && b <= scene->num_layers; b++) clear_boundary(&scene->boundaries[b]);
    for (int k = 0; k < scene->num_bodies; k++) {
        free(scene->bodies[k].file);
        if (!scene->bodies[k].borrowed) cml_mesh_clear(&scene->bodies[k].mesh);
    }
    for (int k = 0; scene->beams && k < scene->num_beams; k++) {
        free(scene->beams[k].light.t);
        free(scene->beams[k].light.intensity);
        free(scene->beams[k].pixel);
    }
    for (int k = 0; k < scene->num_detectors; k++) free(scene->detectors[k].name);
    free(scene->detectors);
    free(scene->beams);
    free(scene->shares);
    free(scene->bodies);
    free(scene->boundaries);
    free(scene->media);
    cml_phases_free(scene->phases);
    free(scene->file);
    free(scene->output);
    free(scene->saved.name);
    free(scene->text);
    free(scene->settings);
    *scene = (struct cml_scene){0};
}

/* Of a table up to where the last part ends that is not dark. */
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

/* The first body of layer l or of one below it. */
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

double cml_beam_height(const struct cml_beam *beam)
{
    const double reach[] = {
        0, beam->size[0], 5 * beam->size[0], beam->size[1], beam->size[0] / 2, beam->size[0] / 2};
    return reach[beam->kind] * fabs(sin(beam->angle));
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

/* Bisection for the segment, then linear. */
double cml_radial_height(const struct cml_radial *radial, double r)
{
    const int last = radial->n - 1;
    if (r >= radial->r[last]) return radial->h[last];
    int low = 0, high = last; /* r[low] <= r < r[high] */
    while (high - low > 1) {
        const int middle = low + (high - low) / 2;
        if (r < radial->r[middle])
            high = middle;
        else
            low = middle;
    }
    const double t = (r - radial->r[low]) / (radial->r[high] - radial->r[low]);
    return radial->h[low] + t * (radial->h[high] - radial->h[low]);
}
