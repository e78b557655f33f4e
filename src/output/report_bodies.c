/* What bodies have absorbed, received and sent, as fields: all bodies along one axis, and all their facets
 * along another, whose `body_of_facet` says whose each is. SPDX-License-Identifier: MIT */
#include "output/report_parts.h"
#include "surface/surface_facets.h"

#include <string.h>

/* ---- where values come from ---- */

/* Shares of the launched weight. */
static void shares(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    for (size_t i = 0; i < count; i++)
        out[i] = (double)source->cells[begin + i] * cml_field_per_photon(source);
}

/* A facet among those of all bodies. */
struct place {
    int body;
    size_t facet;
};

static struct place place_of(const struct cml_report *report, size_t facet)
{
    const struct cml_body_surfaces *bodies = &report->surfaces->bodies;
    struct place place = {0, facet};
    while (place.facet >= bodies->item[place.body].primitives)
        place.facet -= bodies->item[place.body++].primitives;
    return place;
}

/* The next one: to search for each would take long with many bodies. */
static void move_on(const struct cml_report *report, struct place *place)
{
    if (++place->facet < report->surfaces->bodies.item[place->body].primitives) return;
    place->facet = 0;
    place->body++;
}

static double area_of(const struct cml_report *report, const struct place *place)
{
    return cml_body_facet_area(&report->surfaces->bodies.item[place->body],
                               &report->scene->bodies[place->body], place->facet);
}

static void numbers(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    struct place place = place_of(source->report, begin);
    for (size_t i = 0; i < count; i++, move_on(source->report, &place)) out[i] = place.body + 1;
}

static void areas(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    struct place place = place_of(source->report, begin);
    for (size_t i = 0; i < count; i++, move_on(source->report, &place))
        out[i] = area_of(source->report, &place);
}

/* `cells` begins at the score in question of the first facet. */
static void densities(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    struct place place = place_of(source->report, begin);
    for (size_t i = 0; i < count; i++, move_on(source->report, &place))
        out[i] = (double)source->cells[(begin + i) * CML_FACET_SCORES] * cml_field_per_photon(source) /
                 area_of(source->report, &place);
}

static void face_numbers(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    for (size_t i = 0; i < count; i++) out[i] = source->face[begin + i].body + 1;
}

/* `cells` as of densities. */
static void face_densities(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    for (size_t i = 0; i < count; i++) {
        const struct cml_body_face *face = &source->face[begin + i];
        out[i] =
            (double)source->cells[face->facet * CML_FACET_SCORES] * cml_field_per_photon(source) / face->area;
    }
}

/* ---- fields ---- */

static void add_media(struct cml_field_list *c)
{
    const struct cml_scene *scene = c->report->scene;
    const struct cml_medium_def *first = &scene->media[scene->num_layers + 2];
    const struct {
        const char *name, *long_name, *units;
        const double *value;
    } fields[] = {{"body_n", "refractive index", "1", &first->n},
                  {"body_mua", "absorption coefficient", "1/cm", &first->mua},
                  {"body_mus", "scattering coefficient", "1/cm", &first->mus},
                  {"body_g", "anisotropy of scattering", "1", &first->g}};
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++) {
        struct cml_field_source *source =
            cml_add_field(c, fields[i].name, fields[i].long_name, fields[i].units, cml_field_array_values);
        source->array = fields[i].value;
        source->stride = sizeof *first / sizeof(double);
        cml_field_along(c, &c->body, NULL, NULL);
    }
}

/* The scores of the first facet of the first body: they follow those of all boundaries. */
static const cml_u128 *first_scores(const struct cml_report *report)
{
    size_t facets = 0;
    for (int b = 0; b < report->surfaces->count; b++)
        facets += cml_surface_facets(&report->surfaces->item[b], &report->scene->map);
    return report->run->result.facets + facets * CML_FACET_SCORES;
}

static const struct {
    const char *name, *long_name;
    enum cml_facet_score score;
} scores[] = {
    {"body_irradiance_outside", "irradiance from outside the body", CML_FACET_IRRADIANCE_ABOVE},
    {"body_irradiance_inside", "irradiance from inside the body", CML_FACET_IRRADIANCE_BELOW},
    {"body_exitance_outside", "radiant exitance out of the body", CML_FACET_EXITANCE_ABOVE},
    {"body_exitance_inside", "radiant exitance into the body", CML_FACET_EXITANCE_BELOW},
};

/* Of facets, or of faces that stand for them. */
static struct cml_field_source *add_score(struct cml_field_list *c, size_t i, const char *name,
                                          cml_field_values *values)
{
    struct cml_field_source *source = cml_add_field(c, name, scores[i].long_name, "1/cm2", values);
    source->cells = first_scores(c->report) + scores[i].score;
    cml_field_along(c, &c->body_facet, NULL, NULL);
    c->fields[c->num_fields - 1].single = true;
    return source;
}

static void add_facets(struct cml_field_list *c)
{
    cml_add_field(c, "body_of_facet", "body, from 1", "1", numbers);
    cml_field_along(c, &c->body_facet, NULL, NULL);
    cml_add_field(c, "body_area", "area of the facet", "cm2", areas);
    cml_field_along(c, &c->body_facet, NULL, NULL);
    for (size_t i = 0; i < sizeof scores / sizeof *scores; i++) add_score(c, i, scores[i].name, densities);
}

void cml_add_body_face_fields(struct cml_field_list *c, const struct cml_body_faces *drawn)
{
    c->body_facet = cml_field_bins("face", "face", "1", (int)drawn->faces.num_faces, 0, 1);
    cml_add_field(c, "body", "body, from 1", "1", face_numbers)->face = drawn->face;
    cml_field_along(c, &c->body_facet, NULL, NULL);
    for (size_t i = 0; i < sizeof scores / sizeof *scores; i++)
        add_score(c, i, scores[i].name + strlen("body_"), face_densities)->face = drawn->face;
}

void cml_add_body_fields(struct cml_field_list *c)
{
    const struct cml_scene *scene = c->report->scene;
    const struct cml_body_surfaces *bodies = &c->report->surfaces->bodies;
    size_t facets = 0;
    if (scene->num_bodies == 0) return;
    for (int k = 0; k < bodies->count; k++) facets += bodies->item[k].primitives;
    c->body = cml_result_axis("body", scene->num_bodies, 1, 1);
    c->body_facet = cml_field_bins("body_facet", "facet of any body, from 0", "1", (int)facets, 0, 1);
    add_media(c);
    cml_add_result_field(c, "A_body", shares)->cells = c->report->run->result.A_l + scene->num_layers + 2;
    cml_field_along(c, &c->body, NULL, NULL);
    if (c->report->run->result.facets) add_facets(c);
}
