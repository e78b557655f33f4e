/* What the facets of boundaries have received and sent, as fields. SPDX-License-Identifier: MIT */
#include "output/report_parts.h"
#include "surface/surface_facets.h"

#include <stdio.h>

/* ---- where values come from ---- */

/* Of a triangle, a ring or a pixel of the map; per_facet successive faces of a drawing share one. */
static double facet_area(const struct cml_field_source *source, size_t facet)
{
    return cml_surface_facet_area(source->surface, &source->report->scene->map, facet);
}

static void facet_areas(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    for (size_t i = 0; i < count; i++) out[i] = facet_area(source, begin + i);
}

/* `cells` begins at the score in question of the first facet, and others follow at a distance of
 * CML_FACET_SCORES. Faces that are parts of one facet all get its value. */
static void facet_values(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    for (size_t i = 0; i < count; i++) {
        const size_t facet = (begin + i) / source->per_facet;
        out[i] = (double)source->cells[facet * CML_FACET_SCORES] * cml_field_per_photon(source) /
                 facet_area(source, facet);
    }
}

/* For escaped weight only: of irradiances, which a packet may add to many times, no squares are kept. */
static void facet_errors(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    for (size_t i = 0; i < count; i++) {
        const size_t facet = (begin + i) / source->per_facet, cell = facet * CML_FACET_SCORES;
        out[i] =
            cml_result_once_error(&source->report->run->result, source->cells[cell], source->squares[cell]) /
            facet_area(source, facet);
    }
}

/* ---- fields ---- */

/* With the last one, the plane around the boundary. */
static size_t num_facets(const struct cml_report *report, int b)
{
    return cml_surface_facets(&report->surfaces->item[b], &report->scene->map);
}

/* The scores of a boundary's first facet; NULL when none are kept. */
static const cml_u128 *facets_of(const struct cml_report *report, int b)
{
    size_t first = 0;
    if (!report->run->result.facets || num_facets(report, b) == 0) return NULL;
    for (int i = 0; i < b; i++) first += num_facets(report, i);
    return report->run->result.facets + first * CML_FACET_SCORES;
}

/* Facets of planes are the pixels of the map. */
static bool is_plane(const struct cml_report *report, int b)
{
    return report->surfaces->item[b].kind == CML_SURFACE_PLANE;
}

/* Irradiance and radiant exitance as in radiometry: power per area that arrives at, or leaves, a surface.
 * The last row is reflectance or transmittance and has its name from the boundary. */
static const struct {
    const char *name, *long_name;
    enum cml_facet_score score;
} scores[] = {
    {"irradiance_above", "irradiance from the medium above", CML_FACET_IRRADIANCE_ABOVE},
    {"irradiance_below", "irradiance from the medium below", CML_FACET_IRRADIANCE_BELOW},
    {"exitance_above", "radiant exitance into the medium above", CML_FACET_EXITANCE_ABOVE},
    {"exitance_below", "radiant exitance into the medium below", CML_FACET_EXITANCE_BELOW},
    {"", "", CML_FACET_ESCAPED},
};

/* Name of a score of boundary b; NULL where nothing can escape, or the map has it. */
static const char *score_name(const struct cml_report *report, int b, size_t i)
{
    if (scores[i].score != CML_FACET_ESCAPED) return scores[i].name;
    if (is_plane(report, b)) return NULL;
    return b == 0 ? "Rd" : (b == report->scene->num_layers ? "Tt" : NULL);
}

static const char *score_text(int b, size_t i)
{
    if (scores[i].score != CML_FACET_ESCAPED) return scores[i].long_name;
    return b == 0 ? "diffuse reflectance by what it touched last" : "transmittance by what it touched last";
}

/* Axes of the field added last. */
static void along_facets(struct cml_field_list *c, int b)
{
    if (is_plane(c->report, b))
        cml_field_along(c, &c->y, &c->x, NULL);
    else
        cml_field_along(c, &c->facet[b], NULL, NULL);
}

/* The axis is as long as the drawing has faces, in which tables and pictures differ. */
void cml_add_facet_fields(struct cml_field_list *c, int b, const char *prefix, size_t per_facet)
{
    const cml_u128 *first = facets_of(c->report, b);
    char name[64];
    if (!first) return;
    c->facet[b].n = (num_facets(c->report, b) - 1) * per_facet;
    for (size_t i = 0; i < sizeof scores / sizeof *scores; i++) {
        if (!score_name(c->report, b, i)) continue;
        snprintf(name, sizeof name, "%s%s", prefix, score_name(c->report, b, i));
        struct cml_field_source *source = cml_add_field(c, name, score_text(b, i), "1/cm2", facet_values);
        source->cells = first + scores[i].score;
        source->squares = first + CML_FACET_ESCAPED_SQUARES;
        source->surface = &c->report->surfaces->item[b];
        source->per_facet = per_facet;
        along_facets(c, b);
        c->fields[c->num_fields - 1].single = true;
        if (scores[i].score == CML_FACET_ESCAPED) cml_add_error_field(c, facet_errors);
    }
}

/* The plane around a boundary has no area to divide by, so it has shares of the launched weight. */
void cml_add_outer_plane_fields(struct cml_field_list *c, int b, const char *prefix)
{
    const struct cml_surface_def *surface = &c->report->surfaces->item[b];
    const cml_u128 *first = facets_of(c->report, b);
    char name[64];
    if (!first) return;
    const cml_u128 *outer = first + (num_facets(c->report, b) - 1) * CML_FACET_SCORES;
    for (size_t i = 0; i < sizeof scores / sizeof *scores; i++) {
        if (!score_name(c->report, b, i)) continue;
        snprintf(name, sizeof name, "%souter_%s", prefix, score_name(c->report, b, i));
        cml_add_number_field(c, name, score_text(b, i),
                             (double)outer[scores[i].score] * CML_WEIGHT_UNIT /
                                 (double)c->report->run->result.photons);
    }
    if (is_plane(c->report, b)) return;
    snprintf(name, sizeof name, "%sarea", prefix);
    cml_add_field(c, name, "area of the facet", "cm2", facet_areas)->surface = surface;
    cml_field_along(c, &c->facet[b], NULL, NULL);
}
