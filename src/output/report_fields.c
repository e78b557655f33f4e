/* Tallies as fields: names, units, axes, and the arithmetic from weights to densities.
 * SPDX-License-Identifier: MIT */
#include "output/report_parts.h"
#include "result/scaling.h"
#include "surface/surface_facets.h"

#include <stdlib.h>
#include <string.h>

/* ---- where values come from ---- */

/* There is one value, whatever part is asked for. */
static void number_value(const void *context, size_t begin, size_t count, double *out)
{
    (void)begin, (void)count;
    *out = ((const struct cml_field_source *)context)->number;
}

static void sums(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    const double k = CML_WEIGHT_UNIT / (double)source->report->sums->photons * source->scale;
    for (size_t i = 0; i < count; i++) {
        const struct cml_field_cells at = source->where(source, begin + i);
        out[i] = cml_result_once_sum(source->cells + at.first, at.count, source->once) * k / at.per;
    }
}

static void errors(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    const struct cml_result *result = source->report->sums;
    for (size_t i = 0; i < count; i++) {
        const struct cml_field_cells at = source->where(source, begin + i);
        out[i] = cml_result_once_error(result, source->cells + at.first, at.count, source->once) *
                 source->scale / at.per;
    }
}

/* All angle bins of a pixel. Pixels and voxels are of one size, which is in the scale. */
static struct cml_field_cells at_pixel(const struct cml_field_source *source, size_t i)
{
    return (struct cml_field_cells){i * source->na, source->na, 1};
}

static struct cml_field_cells at_voxel(const struct cml_field_source *source, size_t i)
{
    return (struct cml_field_cells){i * source->na, 1, 1};
}

/* Bins of pixel and angle, per projected solid angle; they are those of the run. */
static struct cml_field_cells at_angle(const struct cml_field_source *source, size_t i)
{
    const int n = (int)source->na;
    return (struct cml_field_cells){i, 1,
                                    cml_projected_solid_angle(cml_angle_width(n), (int)(i % source->na))};
}

/* ---- the list ---- */

/* Middles of bins. x and y are centred on the axis of the beam, as the map is; angles count from 0. */
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

/* One for each boundary, because numbers of facets differ; without the last facet, the plane around it. */
static void set_facet_axes(struct cml_field_list *c)
{
    for (int b = 0; b < c->report->surfaces->count; b++) {
        const size_t facets = cml_surface_facets(&c->report->surfaces->item[b], &c->report->scene->map);
        struct cml_named_axis *axis = &c->facet[b];
        snprintf(axis->name, sizeof axis->name, "boundary%d_facet", b);
        axis->axis = cml_quantity_axis(CML_AXIS_facet, facets > 0 ? facets - 1 : 0, 0, 1);
        axis->axis.name = axis->name;
    }
}

/* One for each radial shape. */
static void set_radius_axes(struct cml_field_list *c)
{
    for (int b = 0; b <= c->report->scene->num_layers; b++) {
        const struct cml_radial *radial = &c->report->scene->boundaries[b].radial;
        struct cml_named_axis *axis = &c->radius[b];
        snprintf(axis->name, sizeof axis->name, "boundary%d_radius", b);
        axis->axis = cml_quantity_axis(CML_AXIS_radius, (size_t)radial->n, 0, 0);
        axis->axis.values = radial->r;
        axis->axis.name = axis->name;
    }
}

/* Two for each detector that is a map, about its middle. */
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

/* Room for the map's twelve fields, fourteen of bodies, nineteen for every boundary and two for every
 * detector. */
cml_status cml_field_list_create(const struct cml_report *report, struct cml_field_list *c,
                                 struct cml_error *err)
{
    const size_t boundaries = (size_t)report->surfaces->count,
                 detectors = (size_t)report->scene->num_detectors,
                 capacity = CML_NUM_QUANTITIES + 19 * boundaries + 2 * detectors;
    *c = (struct cml_field_list){.report = report};
    c->fields = calloc(capacity, sizeof *c->fields);
    c->sources = calloc(capacity, sizeof *c->sources);
    c->facet = calloc(boundaries, sizeof *c->facet);
    c->radius = calloc(boundaries, sizeof *c->radius);
    c->pixel = calloc(2 * detectors + 1, sizeof *c->pixel);
    if (!c->fields || !c->sources || !c->facet || !c->radius || !c->pixel) {
        cml_field_list_free(c);
        return cml_fail_memory(err, (double)(capacity * (sizeof *c->fields + sizeof *c->sources)),
                               "a list of fields");
    }
    set_axes(c);
    set_facet_axes(c);
    set_radius_axes(c);
    set_pixel_axes(c);
    return CML_OK;
}

void cml_field_list_free(struct cml_field_list *c)
{
    free(c->fields);
    free(c->sources);
    free(c->facet);
    free(c->radius);
    free(c->pixel);
    *c = (struct cml_field_list){0};
}

struct cml_field *cml_last_field(const struct cml_field_list *c)
{
    return &c->fields[c->num_fields - 1];
}

struct cml_field_source *cml_add_field(struct cml_field_list *c, enum cml_quantity quantity,
                                       cml_field_values *values)
{
    const enum cml_axis_kind *axis = cml_quantities[quantity].axis;
    struct cml_field *field = &c->fields[c->num_fields];
    struct cml_field_source *source = &c->sources[c->num_fields++];
    *source = (struct cml_field_source){.report = c->report, .scale = 1, .per_facet = 1, .na = 1};
    cml_quantity_name(field, quantity);
    for (int i = 0; i < CML_QUANTITY_AXES && axis[i] != CML_AXIS_NONE; i++)
        field->axis[field->num_axes++] = &c->axis[axis[i]];
    field->values = values;
    field->context = source;
    return source;
}

void cml_add_number_field(struct cml_field_list *c, enum cml_quantity quantity, double number)
{
    cml_add_field(c, quantity, number_value)->number = number;
}

/* 32-bit floats: a cell of the largest maps has fewer packets than these have digits. */
struct cml_field_source *cml_add_sums(struct cml_field_list *c, enum cml_quantity quantity,
                                      cml_field_where *where, const cml_u128 *cells)
{
    struct cml_field_source *source = cml_add_field(c, quantity, sums);
    source->where = where;
    source->cells = cells;
    cml_last_field(c)->single = true;
    return source;
}

void cml_add_error_field(struct cml_field_list *c)
{
    struct cml_field *of = cml_last_field(c), *field = of + 1;
    struct cml_field_source *source = &c->sources[c->num_fields++];
    *source = source[-1];
    cml_quantity_name_errors(field, of);
    field->single = of->single;
    field->values = errors;
    field->context = source;
}

/* ---- maps and volume ---- */

static void add_pixels(struct cml_field_list *c, enum cml_quantity quantity, const cml_u128 *cells)
{
    const struct cml_map_def *map = &c->report->scene->map;
    const bool angles = cml_quantities[quantity].axis[2] == CML_AXIS_alpha;
    struct cml_field_source *source = cml_add_sums(c, quantity, angles ? at_angle : at_pixel, cells);
    source->once = c->report->sums->grid.map_once;
    source->na = (size_t)c->report->sums->grid.map_na;
    source->scale = 1 / (map->dx * map->dy);
    cml_add_error_field(c);
}

/* Adds the fields of the map. With angles there is both, the sum and its parts: most users look at the sum.
 */
void cml_add_map_fields(struct cml_field_list *c)
{
    const struct cml_result *r = c->report->sums;
    if (!r->Rd_xya) return;
    add_pixels(c, CML_QUANTITY_Rd_xy, r->Rd_xya);
    add_pixels(c, CML_QUANTITY_Tt_xy, r->Tt_xya);
    if (!c->report->scene->map.angles) return;
    add_pixels(c, CML_QUANTITY_Rd_xya, r->Rd_xya);
    add_pixels(c, CML_QUANTITY_Tt_xya, r->Tt_xya);
}

/* apart: from a voxel to the next; step: to what the next group of photons has in it, 0: there is one for
 * all. Squares of what a packet leaves in a voxel would need a volume per packet. */
static void add_voxels(struct cml_field_list *c, enum cml_quantity quantity, const cml_u128 *cells,
                       size_t apart, size_t step, double scale)
{
    const struct cml_scene *scene = c->report->scene;
    struct cml_field_source *source = cml_add_sums(c, quantity, at_voxel, cells);
    source->na = apart;
    source->once.step = step;
    source->scale = scale / (scene->map.dx * scene->map.dy * scene->dz);
    if (step) cml_add_error_field(c);
}

void cml_add_volume_fields(struct cml_field_list *c)
{
    const struct cml_result *r = c->report->sums;
    if (r->A_xyz) add_voxels(c, CML_QUANTITY_A_xyz, r->A_xyz, 1, r->grid.voxel_step, 1);
    if (r->phi_xyz) add_voxels(c, CML_QUANTITY_phi_xyz, r->phi_xyz, CML_NUM_GROUPS, 1, r->grid.marks);
}

void cml_add_detector_fields(struct cml_field_list *c, int only)
{
    const struct cml_scene *scene = c->report->scene;
    const struct cml_result *r = c->report->sums;
    size_t first = 0, next = 0;
    for (int k = 0; k < scene->num_detectors; k++) {
        const struct cml_detector_def *detector = &scene->detectors[k];
        if (detector->shape != CML_DETECTOR_MAP) continue;
        first = next;
        next += (size_t)detector->nx * (size_t)detector->ny;
        if (only >= 0 && only != k) continue;
        struct cml_field_source *source =
            cml_add_sums(c, CML_QUANTITY_detector_map, at_pixel, r->detector_map + first);
        struct cml_field *field = cml_last_field(c);
        source->once = r->grid.pixel_once;
        source->scale = 1 / (detector->size[0] * detector->size[1]);
        snprintf(field->name, sizeof field->name, "detector_%s_map", detector->name);
        field->num_axes = 2;
        for (int i = 0; i < 2; i++) field->axis[i] = &c->pixel[2 * k + 1 - i].axis;
        cml_add_error_field(c);
    }
}

/* Adds what lies outside map and volume: with that their sums are the totals, which is how a reader can check
 * them. */
void cml_add_outside_fields(struct cml_field_list *c)
{
    const struct cml_result *r = c->report->sums;
    const struct cml_tally_grid *grid = &r->grid;
    const size_t pixels = (size_t)grid->nx * (size_t)grid->ny, na = (size_t)grid->map_na;
    const double per = CML_WEIGHT_UNIT / (double)r->photons;
    if (!r->Rd_xya) return;
    cml_add_number_field(c, CML_QUANTITY_Rd_outside,
                         cml_result_once_sum(r->Rd_xya + pixels * na, na, grid->map_once) * per);
    cml_add_number_field(c, CML_QUANTITY_Tt_outside,
                         cml_result_once_sum(r->Tt_xya + pixels * na, na, grid->map_once) * per);
    if (r->A_xyz)
        cml_add_number_field(c, CML_QUANTITY_A_outside,
                             cml_result_cell_sum(r->A_xyz + pixels * (size_t)grid->nz,
                                                 (int)cml_groups_of(grid->voxel_step), grid->voxel_step) *
                                 per);
}
