/* SPDX-License-Identifier: MIT */
#include "exact/light.h"

#include "base/constants.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define PANEL 0.02   /* rad; width of a panel of angles: rays at its nodes stand for its light to 1e-5 */
#define AZIMUTHS 256 /* number of rays about a slanted axis */

/* Returns the density of a light over the angle t to its axis, not normalised. */
static double density(const struct cml_light *light, double t)
{
    int row = 0;
    if (light->kind != CML_LIGHT_OF_TABLE) return sin(t);
    while (row + 2 < light->rows && t > light->t[row + 1]) row++;
    const double part = (t - light->t[row]) / (light->t[row + 1] - light->t[row]);
    return sin(t) * (light->intensity[row] + part * (light->intensity[row + 1] - light->intensity[row]));
}

/* Returns the number of intervals of angle in which the density of a beam's light is smooth: one between each
 * two rows of a table, else 1. */
static int pieces_of(const struct cml_light *light)
{
    return light->kind == CML_LIGHT_OF_TABLE ? light->rows - 1 : 1;
}

/* Sets the ends of an interval of angle in which the density is smooth. */
static void piece_of(const struct cml_light *light, double n, int piece, double ends[2])
{
    const bool table = light->kind == CML_LIGHT_OF_TABLE;
    ends[0] = table ? light->t[piece] : 0;
    ends[1] = table ? light->t[piece + 1] : cml_light_widest(light, n);
}

/* Returns into how many panels a piece of the angle is divided for Gauss's quadrature. */
static int panels_of(const double ends[2])
{
    return (int)ceil((ends[1] - ends[0]) / PANEL);
}

/* Returns how many azimuths stand for a cone of light: one for a vertical beam, around which all are
 * alike. */
static int azimuths_of(const struct cml_beam *beam)
{
    return beam->angle == 0 ? 1 : AZIMUTHS;
}

/* Returns the number of rays that stand for one beam: three Gauss-Legendre nodes in each panel, times the
 * number of azimuths. */
static int samples_of(const struct cml_beam *beam, double n)
{
    int panels = 0;
    for (int i = 0; i < pieces_of(&beam->light); i++) {
        double ends[2];
        piece_of(&beam->light, n, i, ends);
        panels += panels_of(ends);
    }
    return 3 * panels * azimuths_of(beam);
}

/* Adds rays at the angle t from a beam's axis, evenly around it; only their angle to the vertical counts.
 * Returns their number. */
static int add_cone(const struct cml_beam *beam, double t, double weight, struct cml_exact_ray *ray)
{
    const int count = azimuths_of(beam);
    for (int i = 0; i < count; i++) {
        const double azimuth = 2 * CML_PI * (i + 0.5) / count;
        ray[i].cosine = cos(beam->angle) * cos(t) + sin(beam->angle) * sin(t) * cos(azimuth);
        ray[i].share = weight / count;
    }
    return count;
}

/* Replaces the light of one beam by rays, whose shares add up to the beam's: Gauss's quadrature with three
 * nodes a panel over the angle, and directions evenly around the axis. Returns the number of rays. */
static int sample_beam(const struct cml_beam *beam, double n, double share, struct cml_exact_ray *ray)
{
    static const double node[] = {-0.7745966692414834, 0, 0.7745966692414834}, weight[] = {5, 8, 5};
    double sum = 0;
    int count = 0;
    for (int i = 0; i < pieces_of(&beam->light); i++) {
        double ends[2];
        piece_of(&beam->light, n, i, ends);
        const int panels = panels_of(ends);
        const double half = (ends[1] - ends[0]) / panels / 2;
        for (int k = 0; k < 3 * panels; k++) {
            const double t = ends[0] + half * (2 * (k / 3) + 1 + node[k % 3]),
                         light = half * weight[k % 3] * density(&beam->light, t);
            count += add_cone(beam, t, light, ray + count);
            sum += light;
        }
    }
    for (int i = 0; i < count; i++) ray[i].share *= share / sum;
    return count;
}

/* Orders rays by falling cosine, the steepest first. */
static int compare_rays(const void *a, const void *b)
{
    const double x = ((const struct cml_exact_ray *)a)->cosine, y = ((const struct cml_exact_ray *)b)->cosine;
    return (x < y) - (x > y);
}

/* True if the light of a beam is spread over a cone or given by a table. */
static bool is_spread(const struct cml_beam *beam)
{
    return beam->light.kind == CML_LIGHT_OF_NA || beam->light.kind == CML_LIGHT_OF_TABLE;
}

/* Returns the first beam whose light does not all come down onto the planes, the first of which is z = top;
 * num_beams: there is none. */
static int beam_not_from_above(const struct cml_scene *scene, double top)
{
    const double rounding = 1e-12;
    int k = 0;
    for (; k < scene->num_beams; k++) {
        const struct cml_beam *beam = &scene->beams[k];
        const double widest = cml_light_widest(&beam->light, scene->media[0].n);
        if (beam->inside && !(beam->z < top && beam->angle < CML_PI / 2 - rounding &&
                              beam->angle + widest <= CML_PI / 2 + rounding))
            break;
    }
    return k;
}

bool cml_exact_knows(const struct cml_scene *scene, double top)
{
    return scene->backing.kind != CML_BACKING_METAL && scene->num_contacts == 0 &&
           beam_not_from_above(scene, top) == scene->num_beams;
}

cml_status cml_exact_light_create(const struct cml_scene *scene, double top, struct cml_exact_light *light,
                                  struct cml_error *err)
{
    const double n = scene->media[0].n;
    const int refused = beam_not_from_above(scene, top);
    int samples = 0;
    double all = 0;
    char value[40];
    *light = (struct cml_exact_light){0};
    if (refused < scene->num_beams) {
        snprintf(value, sizeof value, "%g", scene->beams[refused].z);
        return cml_fail_field(err, scene->file, scene->beams[refused].line, "beam: z", value,
                              "light that comes down from above all layers: adding-doubling knows no other");
    }
    for (int k = 0; k < scene->num_beams; k++) {
        all += scene->shares[k];
        if (is_spread(&scene->beams[k])) samples += samples_of(&scene->beams[k], n);
    }
    light->beam = calloc((size_t)scene->num_beams, sizeof *light->beam);
    light->sample = calloc((size_t)samples + 1, sizeof *light->sample);
    if (!light->beam || !light->sample)
        return cml_fail_memory(err, samples * (double)sizeof *light->sample, "light");
    for (int k = 0; k < scene->num_beams; k++) {
        const struct cml_beam *beam = &scene->beams[k];
        const double share = scene->shares[k] / all;
        if (is_spread(beam))
            light->num_samples += sample_beam(beam, n, share, light->sample + light->num_samples);
        else if (beam->light.kind == CML_LIGHT_OF_LAMBERTIAN)
            light->diffuse += share;
        else
            light->beam[light->num_beams++] = (struct cml_exact_ray){cos(beam->angle), share};
    }
    qsort(light->beam, (size_t)light->num_beams, sizeof *light->beam, compare_rays);
    return CML_OK;
}

void cml_exact_light_clear(struct cml_exact_light *light)
{
    free(light->beam);
    free(light->sample);
    *light = (struct cml_exact_light){0};
}

/* Vertical beams stand first in the list. */
double cml_exact_light_normal(const struct cml_exact_light *light)
{
    double share = 0;
    for (int k = 0; k < light->num_beams && light->beam[k].cosine == 1; k++) share += light->beam[k].share;
    return share;
}

double cml_exact_node(double low, double high, int count, int i)
{
    return 0.5 * (low + high) + 0.5 * (high - low) * cos(CML_PI * (i + 0.5) / count);
}

/* Barycentric interpolation [Berrut, Trefethen, SIAM Review 46 (2004) 501]. */
void cml_exact_gather(const double *x, const struct cml_exact_ray *sample, int samples, double low,
                      double high, int count, double *share)
{
    double part[64];
    for (int k = 0; k < samples; k++) {
        double sum = 0;
        int on = -1;
        for (int i = 0; i < count; i++) {
            const double off = x[k] - cml_exact_node(low, high, count, i);
            if (off == 0) on = i;
            part[i] = (i % 2 ? -1 : 1) * sin(CML_PI * (i + 0.5) / count) / off;
            sum += part[i];
        }
        for (int i = 0; i < count; i++)
            share[i] += sample[k].share * (on < 0 ? part[i] / sum : (double)(i == on));
    }
}
