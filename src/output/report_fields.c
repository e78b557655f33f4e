/* Makes fields of tallies: rows of the table of quantities, whose values are computed while they are written.
 * Cells of maps, volumes and detectors, and scores of facets of boundaries and bodies, become densities here.
 * SPDX-License-Identifier: MIT */
#include "output/report_parts.h"
#include "result/scaling.h"
#include "surface/surface_facets.h"

#include <stdlib.h>
#include <string.h>

/* Source of the values of a field. Value i is the sum of `count` cells, from cell k * stride on, divided by
 * the measure of i. k is i, or the facet that value i stands for. */
struct cml_field_source {
    const struct cml_report *report;
    double number;
    const cml_u128 *cells;
    size_t stride, count;
    /* the way in which the array is kept; its squares count if a packet adds to a value once */
    struct cml_once once;
    double scale; /* factor from a share of the launched weight to the value written */
    /* area or solid angle of value i; NULL: 1 */
    double (*measure)(const struct cml_field_source *source, size_t i);
    const struct cml_surface_def *surface;
    size_t per_facet; /* number of successive values of one facet */
    const struct cml_body_face *face;
};

/* ---- values ---- */

/* Returns the only value of the field, whatever part is asked for. */
static void number_value(const void *context, size_t begin, size_t count, double *out)
{
    (void)begin, (void)count;
    *out = ((const struct cml_field_source *)context)->number;
}

/* Returns the first cell of value i of a field. */
static const cml_u128 *cells_of(const struct cml_field_source *source, size_t i)
{
    return source->cells + (source->face ? source->face[i].facet : i / source->per_facet) * source->stride;
}

/* Returns by what value i of a field is divided to become a density, such as an area; 1 if by nothing. */
static double measure_of(const struct cml_field_source *source, size_t i)
{
    return source->measure ? source->measure(source, i) : 1;
}

/* Computes values of a field from its sums, as densities. It is one of the functions cml_field_values that
 * writers call block by block. */
static void sums(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    const double k = CML_WEIGHT_UNIT / (double)source->report->sums->photons * source->scale;
    for (size_t i = begin; i < begin + count; i++)
        *out++ =
            cml_result_once_sum(cells_of(source, i), source->count, source->once) * k / measure_of(source, i);
}

/* Computes standard errors of a field of sums. It is one of the functions cml_field_values that writers call
 * block by block. */
static void errors(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    for (size_t i = begin; i < begin + count; i++)
        *out++ =
            cml_result_once_error(source->report->sums, cells_of(source, i), source->count, source->once) *
            source->scale / measure_of(source, i);
}

/* Returns the projected solid angle of the angle bin of value i; values are bins of pixel and angle. */
static double solid_angle(const struct cml_field_source *source, size_t i)
{
    const int n = source->report->sums->grid.map_na;
    return cml_projected_solid_angle(cml_angle_width(n), (int)(i % (size_t)n));
}

/* Returns the area of a facet: a triangle, a ring or a pixel of the map. */
static double facet_area(const struct cml_field_source *source, size_t i)
{
    return cml_surface_facet_area(source->surface, &source->report->scene->map, i / source->per_facet);
}

/* Returns the body that a facet belongs to; facets are numbered through all bodies. */
static int body_of(const struct cml_report *report, size_t facet)
{
    const struct cml_body_surfaces *bodies = &report->surfaces->bodies;
    int first = 0, last = bodies->count - 1;
    while (first < last) {
        const int middle = last - (last - first) / 2;
        if (bodies->item[middle].first <= facet)
            first = middle;
        else
            last = middle - 1;
    }
    return first;
}

/* Returns the area of a body's facet; a face of a drawing has the area of its whole facet. */
static double body_facet_area(const struct cml_field_source *source, size_t i)
{
    if (source->face) return source->face[i].area;
    const int k = body_of(source->report, i);
    const struct cml_body_surface *body = &source->report->surfaces->bodies.item[k];
    return cml_body_facet_area(body, &source->report->scene->bodies[k], i - body->first);
}

/* Gives the measure of each value as a field of its own, such as areas of facets. It is one of the functions
 * cml_field_values that writers call block by block. */
static void measures(const void *context, size_t begin, size_t count, double *out)
{
    for (size_t i = begin; i < begin + count; i++) *out++ = measure_of(context, i);
}

/* Gives the number of the body that each facet belongs to, from 1. It is one of the functions
 * cml_field_values that writers call block by block. */
static void body_numbers(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    for (size_t i = begin; i < begin + count; i++)
        *out++ = 1 + (source->face ? source->face[i].body : body_of(source->report, i));
}

/* ---- axes ---- */

/* Sets the axes of fields: the middles of bins. x and y are centred on the z axis, as the map is; angles
 * count from 0. */
static void set_axes(struct cml_field_list *c)
{
    const struct cml_scene *scene = c->report->scene;
    const struct cml_map_def *map = &scene->map;
    const double da = cml_angle_width(scene->na);
    const struct {
        enum cml_axis_kind kind;
        int n;
        double first, step;
    } axes[] = {{CML_AXIS_alpha, scene->na, da / 2, da},
                {CML_AXIS_x, map->nx, (0.5 - 0.5 * map->nx) * map->dx, map->dx},
                {CML_AXIS_y, map->ny, (0.5 - 0.5 * map->ny) * map->dy, map->dy},
                {CML_AXIS_z_volume, scene->nz, map->top + scene->dz / 2, scene->dz}};
    for (size_t i = 0; i < sizeof axes / sizeof *axes; i++)
        c->axis[axes[i].kind] =
            cml_quantity_axis(axes[i].kind, (size_t)axes[i].n, axes[i].first, axes[i].step);
}

/* Sets the axes of facets and radii of each boundary. The last facet, the plane around a boundary, is left
 * out. */
static void set_boundary_axes(struct cml_field_list *c)
{
    for (int b = 0; b < c->report->surfaces->count; b++) {
        const size_t facets = cml_surface_facets(&c->report->surfaces->item[b], &c->report->scene->map);
        const struct cml_radial *radial = &c->report->scene->boundaries[b].radial;
        struct cml_named_axis *facet = &c->facet[b], *radius = &c->radius[b];
        snprintf(facet->name, sizeof facet->name, "boundary%d_facet", b);
        facet->axis = cml_quantity_axis(CML_AXIS_facet, facets > 0 ? facets - 1 : 0, 0, 1);
        facet->axis.name = facet->name;
        snprintf(radius->name, sizeof radius->name, "boundary%d_radius", b);
        radius->axis = cml_quantity_axis(CML_AXIS_radius, (size_t)radial->n, 0, 0);
        radius->axis.values = radial->r;
        radius->axis.name = radius->name;
    }
}

/* Names and sets the x and y axes of each detector that is a map: middles of pixels around the detector's
 * middle. */
static void set_pixel_axes(struct cml_field_list *c)
{
    static const enum cml_axis_kind kinds[2] = {CML_AXIS_x, CML_AXIS_y};
    for (int k = 0; k < c->report->scene->num_detectors; k++) {
        const struct cml_detector_def *detector = &c->report->scene->detectors[k];
        const int n[2] = {detector->nx, detector->ny};
        const double middle[2] = {detector->x, detector->y};
        for (int i = 0; i < 2; i++) {
            struct cml_named_axis *axis = &c->pixel[2 * k + i];
            snprintf(axis->name, sizeof axis->name, "detector_%s_%c", detector->name, "xy"[i]);
            axis->axis =
                cml_quantity_axis(kinds[i], (size_t)n[i], middle[i] + (0.5 - 0.5 * n[i]) * detector->size[i],
                                  detector->size[i]);
            axis->axis.name = axis->name;
        }
    }
}

/* ---- the list ---- */

/* Makes room for all fields: every quantity, nineteen fields of each boundary, and two of each detector. */
cml_status cml_field_list_create(const struct cml_report *report, struct cml_field_list *c,
                                 struct cml_error *err)
{
    const size_t boundaries = (size_t)report->surfaces->count,
                 detectors = (size_t)report->scene->num_detectors,
                 capacity = CML_NUM_QUANTITIES + 19 * boundaries + 2 * detectors;
    *c = (struct cml_field_list){.report = report};
    CML_TRY(cml_zeros(&c->fields, capacity, sizeof *c->fields, "a list of fields", err));
    CML_TRY(cml_zeros(&c->sources, capacity, sizeof *c->sources, "a list of fields", err));
    CML_TRY(cml_zeros(&c->facet, boundaries, sizeof *c->facet, "a list of fields", err));
    CML_TRY(cml_zeros(&c->radius, boundaries, sizeof *c->radius, "a list of fields", err));
    CML_TRY(cml_zeros(&c->pixel, 2 * detectors, sizeof *c->pixel, "a list of fields", err));
    set_axes(c);
    set_boundary_axes(c);
    set_pixel_axes(c);
    return CML_OK;
}

/* Frees a list of fields and leaves it empty. */
void cml_field_list_free(struct cml_field_list *c)
{
    free(c->fields);
    free(c->sources);
    free(c->facet);
    free(c->radius);
    free(c->pixel);
    *c = (struct cml_field_list){0};
}

/* Returns the field that was added last. */
static struct cml_field *last_field(const struct cml_field_list *c)
{
    return &c->fields[c->num_fields - 1];
}

/* Adds a field with the name and the axes of a quantity, and returns its source to be filled in. No array
 * grows, so a field may point to its source. */
static struct cml_field_source *add_field(struct cml_field_list *c, enum cml_quantity quantity,
                                          cml_field_values *values)
{
    const enum cml_axis_kind *axis = cml_quantities[quantity].axis;
    struct cml_field *field = &c->fields[c->num_fields];
    struct cml_field_source *source = &c->sources[c->num_fields++];
    *source =
        (struct cml_field_source){.report = c->report, .scale = 1, .per_facet = 1, .stride = 1, .count = 1};
    cml_quantity_name(field, quantity);
    for (int i = 0; i < CML_QUANTITY_AXES && axis[i] != CML_AXIS_NONE; i++)
        field->axis[field->num_axes++] = &c->axis[axis[i]];
    field->values = values;
    field->context = source;
    return source;
}

/* Adds a field of sums of cells, as 32-bit floats: a cell of the largest maps has fewer packets than these
 * have digits. */
static struct cml_field_source *add_sums(struct cml_field_list *c, enum cml_quantity quantity,
                                         const cml_u128 *cells, struct cml_once once)
{
    struct cml_field_source *source = add_field(c, quantity, sums);
    source->cells = cells;
    source->once = once;
    last_field(c)->single = true;
    return source;
}

/* Adds the standard errors of the field of sums added last, NAME_se. */
static void add_errors(struct cml_field_list *c)
{
    struct cml_field *of = last_field(c), *field = of + 1;
    struct cml_field_source *source = &c->sources[c->num_fields++];
    *source = source[-1];
    cml_quantity_name_errors(field, of);
    field->single = of->single;
    field->values = errors;
    field->context = source;
}

/* Adds a share of the launched weight, a field without axes. */
static void add_share(struct cml_field_list *c, enum cml_quantity quantity, double share)
{
    add_field(c, quantity, number_value)->number = share;
    last_field(c)->num_axes = 0;
    last_field(c)->units = "1";
}

/* ---- maps and volume ---- */

/* Adds the last cell of an array, which holds the light outside the map or volume: a reader can check that
 * the sum of the array is the total. */
static void add_outside(struct cml_field_list *c, enum cml_quantity quantity, enum cml_array array)
{
    const struct cml_result *r = c->report->sums;
    const size_t na = array == CML_ARRAY_A_xyz ? 1 : (size_t)r->grid.map_na;
    const cml_u128 *last = r->array[array] + r->layout.size[array] - na;
    add_share(c, quantity,
              cml_result_once_sum(last, na, r->layout.once[array]) * (CML_WEIGHT_UNIT / (double)r->photons));
}

/* Adds a field of the map or of the volume. All pixels and all voxels have one size, by which source->scale
 * divides. A map without angles sums the angles of each pixel. Only phi_xyz has the groups of a voxel side by
 * side in memory. */
static void add_cells(struct cml_field_list *c, enum cml_quantity quantity, enum cml_array array)
{
    const struct cml_result *r = c->report->sums;
    const struct cml_map_def *map = &c->report->scene->map;
    const enum cml_axis_kind *axis = cml_quantities[quantity].axis;
    const bool volume = axis[0] == CML_AXIS_z_volume, angles = axis[2] == CML_AXIS_alpha,
               groups = cml_arrays[array].axis[1] == CML_CELLS_group;
    struct cml_field_source *source = add_sums(c, quantity, r->array[array], r->layout.once[array]);
    source->scale = (quantity == CML_QUANTITY_phi_xyz ? r->grid.marks : 1) /
                    (map->dx * map->dy * (volume ? c->report->scene->dz : 1));
    if (groups) source->stride = CML_NUM_GROUPS;
    if (groups) source->once.step = 1;
    if (angles) source->measure = solid_angle;
    if (!angles && !volume) source->stride = source->count = (size_t)r->grid.map_na;
    if (groups || r->layout.parts[array] > 1) add_errors(c);
}

void cml_add_fields(struct cml_field_list *c, enum cml_axis_kind first)
{
    for (int i = 0; i < CML_NUM_QUANTITIES; i++) {
        const struct cml_quantity_info *info = &cml_quantities[i];
        const enum cml_array array = (enum cml_array)info->sums;
        const bool angles = info->axis[2] == CML_AXIS_alpha;
        if (info->estimator != CML_FROM_FIELD || info->axis[0] != first || !c->report->sums->array[array] ||
            (angles && !c->report->scene->map.angles))
            continue;
        if (first == CML_AXIS_NONE)
            add_outside(c, (enum cml_quantity)i, array);
        else
            add_cells(c, (enum cml_quantity)i, array);
    }
}

void cml_add_detector_fields(struct cml_field_list *c, int only)
{
    const struct cml_scene *scene = c->report->scene;
    const struct cml_result *r = c->report->sums;
    const cml_u128 *next = r->detector_map;
    for (int k = 0; k < scene->num_detectors; k++) {
        const struct cml_detector_def *detector = &scene->detectors[k];
        if (detector->shape != CML_DETECTOR_MAP) continue;
        const cml_u128 *cells = next;
        next += (size_t)detector->nx * (size_t)detector->ny;
        if (only >= 0 && only != k) continue;
        add_sums(c, CML_QUANTITY_detector_map, cells, r->layout.once[CML_ARRAY_detector_map])->scale =
            1 / (detector->size[0] * detector->size[1]);
        struct cml_field *field = last_field(c);
        snprintf(field->name, sizeof field->name, "detector_%s_map", detector->name);
        field->num_axes = 2;
        for (int i = 0; i < 2; i++) field->axis[i] = &c->pixel[2 * k + 1 - i].axis;
        add_errors(c);
    }
}

/* ---- facets ---- */

/* Returns the number of facets of boundary b; the last one is the plane around it. */
static size_t num_facets(const struct cml_report *report, int b)
{
    return cml_surface_facets(&report->surfaces->item[b], &report->scene->map);
}

/* Returns the scores of the first facet of boundary b. If b is the number of boundaries, returns those of the
 * first body. */
static const cml_u128 *facets_of(const struct cml_report *report, int b)
{
    size_t first = 0;
    for (int i = 0; i < b; i++) first += num_facets(report, i);
    return report->sums->facets + first * CML_FACET_SCORES;
}

/* Adds a score of facets. first: the scores of the first facet. Light that escapes is kept once per packet.
 */
static struct cml_field_source *add_score(struct cml_field_list *c, enum cml_quantity quantity,
                                          const cml_u128 *first)
{
    struct cml_field_source *source =
        add_sums(c, quantity, first + cml_quantities[quantity].sums, cml_facet_once(&c->report->sums->grid));
    source->stride = CML_FACET_SCORES;
    return source;
}

/* True if a quantity is a score of facets along this axis. */
static bool is_score(int quantity, enum cml_axis_kind axis)
{
    return cml_quantities[quantity].estimator == CML_FROM_FACET && cml_quantities[quantity].axis[0] == axis;
}

/* True if the facets of a boundary are the pixels of the map. */
static bool is_plane(const struct cml_report *report, int b)
{
    return report->surfaces->item[b].kind == CML_SURFACE_PLANE;
}

/* True if boundary b has this score. Reflectance and transmittance exist only where light can escape and no
 * map holds it; a boundary has all other scores. */
static bool has_score(const struct cml_report *report, int b, int quantity)
{
    if (!is_score(quantity, CML_AXIS_facet)) return false;
    if (cml_quantities[quantity].sums != CML_FACET_ESCAPED) return true;
    if (is_plane(report, b)) return false;
    return quantity == CML_QUANTITY_Rd_facet ? b == 0 : b > 0 && b == report->scene->num_layers;
}

/* Names the field added last: PREFIX, OUTER, and the quantity without "_facet" (Rd_facet is the Rd of the
 * boundary). */
static void name_field(const struct cml_field_list *c, const char *prefix, const char *outer,
                       enum cml_quantity quantity)
{
    struct cml_field *field = last_field(c);
    const char *name = cml_quantities[quantity].name, *end = strstr(name, "_facet");
    snprintf(field->name, sizeof field->name, "%s%s%.*s", prefix, outer,
             (int)(end ? (size_t)(end - name) : strlen(name)), name);
}

/* Sets the axes of the field added last: the facets of boundary b, or the pixels of a plane. */
static void along_facets(struct cml_field_list *c, int b)
{
    struct cml_field *field = last_field(c);
    field->axis[0] = is_plane(c->report, b) ? &c->axis[CML_AXIS_y] : &c->facet[b].axis;
    field->axis[1] = &c->axis[CML_AXIS_x];
    field->num_axes = is_plane(c->report, b) ? 2 : 1;
}

/* Adds the fields of the facets of boundary b along one axis. A table has one value per facet. A picture
 * repeats each value per_facet times, once for every face that draws the facet. */
void cml_add_facet_fields(struct cml_field_list *c, int b, const char *prefix, size_t per_facet)
{
    const size_t facets = num_facets(c->report, b);
    if (!c->report->sums->facets || facets == 0) return;
    c->facet[b].axis.n = (facets - 1) * per_facet;
    for (int i = 0; i < CML_NUM_QUANTITIES; i++) {
        if (!has_score(c->report, b, i)) continue;
        struct cml_field_source *source = add_score(c, (enum cml_quantity)i, facets_of(c->report, b));
        source->measure = facet_area;
        source->surface = &c->report->surfaces->item[b];
        source->per_facet = per_facet;
        name_field(c, prefix, "", (enum cml_quantity)i);
        along_facets(c, b);
        if (cml_quantities[i].sums == CML_FACET_ESCAPED || source->once.step) add_errors(c);
    }
}

/* The plane has no area to divide by, so values are shares of the launched weight. */
void cml_add_outer_plane_fields(struct cml_field_list *c, int b, const char *prefix)
{
    const struct cml_result *r = c->report->sums;
    const size_t facets = num_facets(c->report, b);
    if (!r->facets || facets == 0) return;
    const cml_u128 *outer = facets_of(c->report, b) + (facets - 1) * CML_FACET_SCORES;
    for (int i = 0; i < CML_NUM_QUANTITIES; i++) {
        if (!has_score(c->report, b, i)) continue;
        add_share(c, (enum cml_quantity)i,
                  cml_result_once_sum(outer + cml_quantities[i].sums, 1, r->layout.once[CML_ARRAY_facets]) *
                      CML_WEIGHT_UNIT / (double)r->photons);
        name_field(c, prefix, "outer_", (enum cml_quantity)i);
    }
    if (is_plane(c->report, b)) return;
    struct cml_field_source *source = add_field(c, CML_QUANTITY_area, measures);
    source->measure = facet_area;
    source->surface = &c->report->surfaces->item[b];
    name_field(c, prefix, "", CML_QUANTITY_area);
    along_facets(c, b);
}

void cml_add_shape_field(struct cml_field_list *c, int b, const char *prefix)
{
    const struct cml_boundary *boundary = &c->report->scene->boundaries[b];
    const int most = 10000;
    if (boundary->form != CML_FORM_RADIAL || boundary->radial.n > most) return;
    add_field(c, CML_QUANTITY_height, cml_field_array_values);
    last_field(c)->context = boundary->radial.h;
    last_field(c)->axis[0] = &c->radius[b].axis;
    name_field(c, prefix, "", CML_QUANTITY_height);
}

/* ---- bodies ---- */

/* Adds the scores of all facets of bodies. With `face`, adds one value for each face of a drawing in place of
 * each facet, and leaves the word body out of the names. */
static void add_body_scores(struct cml_field_list *c, const struct cml_body_face *face)
{
    for (int i = 0; i < CML_NUM_QUANTITIES; i++) {
        if (!is_score(i, CML_AXIS_body_facet)) continue;
        struct cml_field_source *source =
            add_score(c, (enum cml_quantity)i, facets_of(c->report, c->report->surfaces->count));
        source->measure = body_facet_area;
        source->face = face;
        if (face)
            snprintf(last_field(c)->name, sizeof last_field(c)->name, "%s",
                     cml_quantities[i].name + strlen("body_"));
        if (source->once.step) add_errors(c);
    }
}

void cml_add_body_face_fields(struct cml_field_list *c, const struct cml_body_faces *drawn)
{
    c->axis[CML_AXIS_body_facet] = cml_quantity_axis(CML_AXIS_face, drawn->faces.num_faces, 0, 1);
    add_field(c, CML_QUANTITY_body_of_facet, body_numbers)->face = drawn->face;
    snprintf(last_field(c)->name, sizeof last_field(c)->name, "body");
    add_body_scores(c, drawn->face);
}

void cml_add_body_fields(struct cml_field_list *c)
{
    const struct cml_body_surfaces *bodies = &c->report->surfaces->bodies;
    if (c->report->scene->num_bodies == 0) return;
    const struct cml_body_surface *last = &bodies->item[bodies->count - 1];
    c->axis[CML_AXIS_body_facet] =
        cml_quantity_axis(CML_AXIS_body_facet, last->first + last->primitives, 0, 1);
    if (!c->report->sums->facets) return;
    add_field(c, CML_QUANTITY_body_of_facet, body_numbers);
    add_field(c, CML_QUANTITY_body_area, measures)->measure = body_facet_area;
    add_body_scores(c, NULL);
}

enum { SIDES = CML_FACET_EXITANCE_BELOW + 1 };

/* Computes one flux of a body (number `side` of its scores), summed over all its facets, and its standard
 * error from the groups if facets are kept by group. */
static void set_flux(const struct cml_report *report, const struct cml_body_surface *of, int side, size_t at,
                     struct cml_outcome *o)
{
    const cml_u128 *scores = facets_of(report, report->surfaces->count) + of->first * CML_FACET_SCORES + side;
    const struct cml_result *sums = report->sums;
    const size_t step = sums->grid.facet_step, groups = cml_groups_of(step);
    cml_u128 group[CML_NUM_GROUPS] = {0};
    for (size_t g = 0; g < groups; g++)
        for (uint64_t i = 0; i < of->primitives; i++) group[g] += scores[g * step + i * CML_FACET_SCORES];
    o->value[CML_QUANTITY_flux_body][at] =
        cml_result_cell_sum(group, (int)groups, 1) * CML_WEIGHT_UNIT / (double)sums->photons;
    if (step) o->error[CML_QUANTITY_flux_body][at] = cml_result_cell_error(sums, group, 1);
}

cml_status cml_report_body_fluxes(const struct cml_report *report, struct cml_outcome *o,
                                  struct cml_error *err)
{
    const struct cml_body_surfaces *bodies = &report->surfaces->bodies;
    if (!report->sums->facets || bodies->count == 0) return CML_OK;
    const size_t step = report->sums->grid.facet_step;
    CML_TRY(cml_outcome_add(o, CML_QUANTITY_flux_body, false, err));
    if (step) CML_TRY(cml_outcome_add(o, CML_QUANTITY_flux_body, true, err));
    for (int at = 0; at < bodies->count * SIDES; at++)
        set_flux(report, &bodies->item[at / SIDES], at % SIDES, (size_t)at, o);
    return CML_OK;
}
