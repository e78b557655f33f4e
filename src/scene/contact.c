/* SPDX-License-Identifier: MIT */
#include "scene/contact.h"

#include <math.h>

int cml_contact_whole(const struct cml_scene *scene)
{
    for (int k = scene->num_contacts; k > 0; k--)
        if (scene->contacts[k - 1].whole) return k;
    return 0;
}

/* Finds the least and the largest distance of an outline from a place. */
static void find_distances(const struct cml_outline *outline, double x, double y, double *least, double *most)
{
    const double dx = fabs(outline->x - x), dy = fabs(outline->y - y), *size = outline->size;
    if (outline->shape == CML_DETECTOR_RING) {
        const double away = hypot(dx, dy);
        *least = fmax(0, fmax(away - size[1], size[0] - away));
        *most = away + size[1];
    } else {
        *least = hypot(fmax(0, dx - size[0] / 2), fmax(0, dy - size[1] / 2));
        *most = hypot(dx + size[0] / 2, dy + size[1] / 2);
    }
}

/* True if two outlines have an area in common. An overlap by rounding alone does not count: places of
 * outlines that touch are often roots. */
static bool overlap(struct cml_outline one, struct cml_outline other)
{
    const double share = 1 - 1e-9;
    double least, most;
    if (one.shape != CML_DETECTOR_RING && other.shape != CML_DETECTOR_RING)
        return fabs(one.x - other.x) < share * (one.size[0] + other.size[0]) / 2 &&
               fabs(one.y - other.y) < share * (one.size[1] + other.size[1]) / 2;
    if (one.shape != CML_DETECTOR_RING) return overlap(other, one);
    find_distances(&other, one.x, one.y, &least, &most);
    return least < share * one.size[1] && share * most > one.size[0];
}

/* True if an outline holds all of another one. */
static bool covers(struct cml_outline outer, struct cml_outline inner)
{
    const bool round = inner.shape == CML_DETECTOR_RING;
    const double w = round ? inner.size[1] : inner.size[0] / 2, h = round ? inner.size[1] : inner.size[1] / 2;
    double least, most;
    find_distances(&inner, outer.x, outer.y, &least, &most);
    if (outer.shape == CML_DETECTOR_RING) return least >= outer.size[0] && most <= outer.size[1];
    return fabs(inner.x - outer.x) + w <= outer.size[0] / 2 &&
           fabs(inner.y - outer.y) + h <= outer.size[1] / 2;
}

bool cml_contact_is_hidden(const struct cml_scene *scene, int number)
{
    const struct cml_outline own = cml_contact_outline(&scene->contacts[number - 1]);
    for (int k = number; k < scene->num_contacts; k++)
        if (scene->contacts[k].whole || covers(cml_contact_outline(&scene->contacts[k]), own)) return true;
    return false;
}

int cml_contact_above(const struct cml_scene *scene, int number)
{
    const struct cml_outline own = cml_contact_outline(&scene->contacts[number - 1]);
    for (int k = number; k < scene->num_contacts; k++)
        if (scene->contacts[k].whole || overlap(own, cml_contact_outline(&scene->contacts[k]))) return k + 1;
    return 0;
}

double cml_beam_index(const struct cml_scene *scene, const struct cml_beam *beam)
{
    return beam->contact ? scene->contacts[beam->contact - 1].n : scene->media[0].n;
}
