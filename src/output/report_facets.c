/* What the facets of boundaries have received and sent, as fields. SPDX-License-Identifier: MIT */
#include "output/report_parts.h"
#include "surface/surface_facets.h"

#include <stdio.h>
#include <string.h>

/* ---- where values come from ---- */

/* The area of a facet: a triangle, a ring or a pixel of the map; per_facet successive faces of a drawing
 * share one. */
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
static struct cml_field_cells at_facet(const struct cml_field_source *source, size_t i)
{
    const size_t facet = i / source->per_facet;
    return (struct cml_field_cells){facet * CML_FACET_SCORES, 1, facet_area(source, facet)};
}

/* ---- fields ---- */

/* How many facets boundary b has, with the last one, the plane around it. */
static size_t num_facets(const struct cml_report *report, int b)
{
    return cml_surface_facets(&report->surfaces->item[b], &report->scene->map);
}

/* The scores of a boundary's first facet; NULL when none are kept. */
static const cml_u128 *facets_of(const struct cml_report *report, int b)
{
    size_t first = 0;
    if (!report->sums->facets || num_facets(report, b) == 0) return NULL;
    for (int i = 0; i < b; i++) first += num_facets(report, i);
    return report->sums->facets + first * CML_FACET_SCORES;
}

/* Facets of planes are the pixels of the map. */
static bool is_plane(const struct cml_report *report, int b)
{
    return report->surfaces->item[b].kind == CML_SURFACE_PLANE;
}

/* Irradiance and radiant exitance as in radiometry: power per area that arrives at, or leaves, a surface.
 * The last row is reflectance or transmittance, where anything can escape and no map has it. */
static const struct {
    enum cml_quantity quantity;
    enum cml_facet_score score;
} scores[] = {
    {CML_QUANTITY_irradiance_above, CML_FACET_IRRADIANCE_ABOVE},
    {CML_QUANTITY_irradiance_below, CML_FACET_IRRADIANCE_BELOW},
    {CML_QUANTITY_exitance_above, CML_FACET_EXITANCE_ABOVE},
    {CML_QUANTITY_exitance_below, CML_FACET_EXITANCE_BELOW},
    {CML_QUANTITY_Rd_facet, CML_FACET_ESCAPED},
    {CML_QUANTITY_Tt_facet, CML_FACET_ESCAPED},
};
enum { SCORES = sizeof scores / sizeof *scores };

static bool has_score(const struct cml_report *report, int b, size_t i)
{
    if (scores[i].score != CML_FACET_ESCAPED) return true;
    if (is_plane(report, b)) return false;
    return scores[i].quantity == CML_QUANTITY_Rd_facet ? b == 0 : b > 0 && b == report->scene->num_layers;
}

/* Names the field added last; reflectance and transmittance by facet are Rd and Tt of the boundary. */
static void name_field(const struct cml_field_list *c, const char *prefix, const char *outer,
                       enum cml_quantity quantity)
{
    struct cml_field *field = cml_last_field(c);
    const char *name = cml_quantities[quantity].name, *end = strstr(name, "_facet");
    snprintf(field->name, sizeof field->name, "%s%s%.*s", prefix, outer,
             (int)(end ? (size_t)(end - name) : strlen(name)), name);
}

/* Axes of the field added last. */
static void along_facets(struct cml_field_list *c, int b)
{
    struct cml_field *field = cml_last_field(c);
    field->axis[0] = is_plane(c->report, b) ? &c->axis[CML_AXIS_y] : &c->facet[b].axis;
    field->axis[1] = &c->axis[CML_AXIS_x];
    field->num_axes = is_plane(c->report, b) ? 2 : 1;
}

/* The axis is as long as the drawing has faces, in which tables and pictures differ. */
void cml_add_facet_fields(struct cml_field_list *c, int b, const char *prefix, size_t per_facet)
{
    const cml_u128 *first = facets_of(c->report, b);
    if (!first) return;
    c->facet[b].axis.n = (num_facets(c->report, b) - 1) * per_facet;
    for (size_t i = 0; i < SCORES; i++) {
        if (!has_score(c->report, b, i)) continue;
        const bool once = scores[i].score == CML_FACET_ESCAPED;
        struct cml_field_source *source =
            cml_add_sums(c, scores[i].quantity, at_facet, first + scores[i].score);
        source->once = cml_facet_once(&c->report->sums->grid);
        source->surface = &c->report->surfaces->item[b];
        source->per_facet = per_facet;
        name_field(c, prefix, "", scores[i].quantity);
        along_facets(c, b);
        if (once || source->once.step) cml_add_error_field(c);
    }
}

/* The plane around a boundary has no area to divide by, so it has shares of the launched weight. */
void cml_add_outer_plane_fields(struct cml_field_list *c, int b, const char *prefix)
{
    const cml_u128 *first = facets_of(c->report, b);
    if (!first) return;
    const cml_u128 *outer = first + (num_facets(c->report, b) - 1) * CML_FACET_SCORES;
    const size_t step = c->report->sums->grid.facet_step;
    for (size_t i = 0; i < SCORES; i++) {
        if (!has_score(c->report, b, i)) continue;
        cml_add_number_field(c, scores[i].quantity,
                             cml_result_cell_sum(outer + scores[i].score, (int)cml_groups_of(step), step) *
                                 CML_WEIGHT_UNIT / (double)c->report->sums->photons);
        cml_last_field(c)->units = "1";
        cml_last_field(c)->num_axes = 0;
        name_field(c, prefix, "outer_", scores[i].quantity);
    }
    if (is_plane(c->report, b)) return;
    cml_add_field(c, CML_QUANTITY_area, facet_areas)->surface = &c->report->surfaces->item[b];
    name_field(c, prefix, "", CML_QUANTITY_area);
    along_facets(c, b);
}

void cml_add_shape_field(struct cml_field_list *c, int b, const char *prefix)
{
    const struct cml_boundary *boundary = &c->report->scene->boundaries[b];
    const int most = 10000;
    if (boundary->form != CML_FORM_RADIAL || boundary->radial.n > most) return;
    cml_add_field(c, CML_QUANTITY_height, cml_field_array_values);
    cml_last_field(c)->context = boundary->radial.h;
    cml_last_field(c)->axis[0] = &c->radius[b].axis;
    name_field(c, prefix, "", CML_QUANTITY_height);
}
