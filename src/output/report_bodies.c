/* What bodies have absorbed, received and sent, as fields: all bodies along one axis, and all their facets
 * along another, whose `body_of_facet` says whose each is. SPDX-License-Identifier: MIT */
#include "output/report_parts.h"
#include "surface/surface_facets.h"

#include <string.h>

/* ---- where values come from ---- */

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

/* The scores of the first facet of the first body: they follow those of all boundaries. */
static const cml_u128 *first_scores(const struct cml_report *report)
{
    size_t facets = 0;
    for (int b = 0; b < report->surfaces->count; b++)
        facets += cml_surface_facets(&report->surfaces->item[b], &report->scene->map);
    return report->sums->facets + facets * CML_FACET_SCORES;
}

/* Of facets, or, without the word body in their names, of faces that stand for them. */
static void add_scores(struct cml_field_list *c, cml_field_values *values, const struct cml_body_face *face)
{
    static const enum cml_facet_score scores[] = {CML_FACET_IRRADIANCE_ABOVE, CML_FACET_IRRADIANCE_BELOW,
                                                  CML_FACET_EXITANCE_ABOVE, CML_FACET_EXITANCE_BELOW};
    for (int i = 0; i < (int)(sizeof scores / sizeof *scores); i++) {
        const enum cml_quantity quantity = (enum cml_quantity)(CML_QUANTITY_body_irradiance_outside + i);
        struct cml_field_source *source = cml_add_field(c, quantity, values);
        struct cml_field *field = cml_last_field(c);
        source->cells = first_scores(c->report) + scores[i];
        source->face = face;
        field->single = true;
        if (face)
            snprintf(field->name, sizeof field->name, "%s", cml_quantities[quantity].name + strlen("body_"));
    }
}

static void set_facets(struct cml_field_list *c, enum cml_axis_kind kind, size_t count)
{
    c->axis[CML_AXIS_body_facet] = cml_quantity_axis(kind, count, 0, 1);
}

void cml_add_body_face_fields(struct cml_field_list *c, const struct cml_body_faces *drawn)
{
    set_facets(c, CML_AXIS_face, drawn->faces.num_faces);
    cml_add_field(c, CML_QUANTITY_body_of_facet, face_numbers)->face = drawn->face;
    snprintf(cml_last_field(c)->name, sizeof cml_last_field(c)->name, "body");
    add_scores(c, face_densities, drawn->face);
}

void cml_add_body_fields(struct cml_field_list *c)
{
    const struct cml_body_surfaces *bodies = &c->report->surfaces->bodies;
    size_t facets = 0;
    if (c->report->scene->num_bodies == 0) return;
    for (int k = 0; k < bodies->count; k++) facets += bodies->item[k].primitives;
    set_facets(c, CML_AXIS_body_facet, facets);
    if (!c->report->sums->facets) return;
    cml_add_field(c, CML_QUANTITY_body_of_facet, numbers);
    cml_add_field(c, CML_QUANTITY_body_area, areas);
    add_scores(c, densities, NULL);
}

/* Facets of bodies follow those of all boundaries. */
cml_status cml_report_body_fluxes(const struct cml_report *report, struct cml_outcome *o,
                                  struct cml_error *err)
{
    const struct cml_body_surfaces *bodies = &report->surfaces->bodies;
    if (!report->sums->facets || bodies->count == 0) return CML_OK;
    CML_TRY(cml_outcome_add(o, CML_QUANTITY_flux_body, false, err));
    const cml_u128 *scores = first_scores(report);
    double *to = o->value[CML_QUANTITY_flux_body];
    for (int k = 0; k < bodies->count; k++, to += CML_FACET_EXITANCE_BELOW + 1) {
        for (uint64_t i = 0; i < bodies->item[k].primitives; i++, scores += CML_FACET_SCORES)
            for (int s = 0; s <= CML_FACET_EXITANCE_BELOW; s++) to[s] += (double)scores[s];
        for (int s = 0; s <= CML_FACET_EXITANCE_BELOW; s++)
            to[s] = to[s] * CML_WEIGHT_UNIT / (double)report->sums->photons;
    }
    return CML_OK;
}
