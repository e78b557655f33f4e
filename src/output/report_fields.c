/* Tallies as fields: names, units, axes, and the arithmetic from weights to densities.
 * SPDX-License-Identifier: MIT */
#include "output/report_parts.h"
#include "output/scaling.h"
#include "surface/surface_facets.h"

#include <stdlib.h>
#include <string.h>

/* ---- where values come from ---- */

double cml_field_per_photon(const struct cml_field_source *source)
{
    return CML_WEIGHT_UNIT / (double)source->report->run->result.photons;
}

void cml_field_array_values(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    for (size_t i = 0; i < count; i++) out[i] = source->array[(begin + i) * source->stride];
}

/* There is one value, whatever part is asked for. */
static void number_value(const void *context, size_t begin, size_t count, double *out)
{
    (void)begin, (void)count;
    *out = ((const struct cml_field_source *)context)->number;
}

/* Computed when they are written: each takes a loop over 64 batches. */
static void profile_errors(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    for (size_t i = 0; i < count; i++)
        out[i] = cml_profile_error(source->report, &source->profile, (int)(begin + i));
}

/* Over the angle bins of a pixel, as integers: so a map without angles is the exact sum. */
static cml_u128 sum_of_pixel(const cml_u128 *cells, size_t pixel, size_t na)
{
    cml_u128 sum = 0;
    for (size_t a = 0; a < na; a++) sum += cells[pixel * na + a];
    return sum;
}

/* Pixels of a map, or voxels with na = 1: per area or volume, which are equal for all. */
static void pixel_values(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    const double k = cml_field_per_photon(source) * source->scale;
    for (size_t i = 0; i < count; i++)
        out[i] = (double)sum_of_pixel(source->cells, begin + i, source->na) * k;
}

/* A packet ends in one angle bin of one pixel, so its squares add up like its weights, and the error of a
 * pixel is that of a weight which every packet adds to at most once. */
static void pixel_errors(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    const struct cml_result *result = &source->report->run->result;
    for (size_t i = 0; i < count; i++)
        out[i] =
            source->scale * cml_result_once_error(result, sum_of_pixel(source->cells, begin + i, source->na),
                                                  sum_of_pixel(source->squares, begin + i, source->na));
}

/* Of the cell of a map, whose angle bins are those of the run. */
static double projected_solid_angle(const struct cml_field_source *source, size_t cell)
{
    return cml_projected_solid_angle(cml_angle_width((int)source->na), (int)(cell % source->na));
}

/* Bins of pixel and angle, per projected solid angle. */
static void angle_values(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    const double k = cml_field_per_photon(source) * source->scale;
    for (size_t i = begin; i < begin + count; i++)
        *out++ = (double)source->cells[i] * k / projected_solid_angle(source, i);
}

static void angle_errors(const void *context, size_t begin, size_t count, double *out)
{
    const struct cml_field_source *source = context;
    for (size_t i = begin; i < begin + count; i++)
        *out++ = cml_result_once_error(&source->report->run->result, source->cells[i], source->squares[i]) *
                 source->scale / projected_solid_angle(source, i);
}

/* ---- the list ---- */

struct cml_axis cml_field_bins(const char *name, const char *what, const char *units, int n, double first,
                               double step)
{
    return (struct cml_axis){name, what, units, (size_t)n, first, step, NULL};
}

/* Middles of bins. x and y are centred on the axis of the beam, as the map is; r and alpha count from 0. */
static void set_axes(struct cml_field_list *c)
{
    const struct cml_scene *scene = c->report->scene;
    const struct cml_map_def *map = &scene->map;
    const int na = scene->na;
    const double da = cml_angle_width(na), dr = scene->dr, dz = scene->dz;
    c->layer = cml_result_axis("layer", scene->num_layers, 1, 1);
    c->r = cml_result_axis("r", scene->nr, dr / 2, dr);
    c->z = cml_result_axis("z", scene->nz, dz / 2, dz);
    c->alpha = cml_result_axis("alpha", na, da / 2, da);
    c->x = cml_field_bins("x", "x, middle of the pixel", "cm", map->nx, (0.5 - 0.5 * map->nx) * map->dx,
                          map->dx);
    c->y = cml_field_bins("y", "y, middle of the pixel", "cm", map->ny, (0.5 - 0.5 * map->ny) * map->dy,
                          map->dy);
    c->z_volume =
        cml_field_bins("z_volume", "depth, middle of the voxel", "cm", scene->nz, map->top + dz / 2, dz);
}

/* One for each boundary, because numbers of facets differ; without the last facet, the plane around it. */
static void set_facet_axes(struct cml_field_list *c)
{
    for (int b = 0; b < c->report->surfaces->count; b++) {
        const struct cml_surface_def *def = &c->report->surfaces->item[b];
        const int facets = (int)cml_surface_facets(def, &c->report->scene->map);
        snprintf(c->facet_names[b], sizeof *c->facet_names, "boundary%d_facet", b);
        const int n = facets > 0 ? facets - 1 : 0;
        c->facet[b] = cml_field_bins(c->facet_names[b], "triangle, or ring, from 0", "1", n, 0, 1);
    }
}

/* Room for the results, the map's eight fields, eleven of bodies, and fourteen for every boundary. */
cml_status cml_field_list_create(const struct cml_report *report, struct cml_field_list *c,
                                 struct cml_error *err)
{
    const size_t boundaries = (size_t)report->surfaces->count, capacity = 84 + 14 * boundaries;
    *c = (struct cml_field_list){.report = report, .capacity = (int)capacity};
    c->fields = calloc(capacity, sizeof *c->fields);
    c->sources = calloc(capacity, sizeof *c->sources);
    c->facet = calloc(boundaries, sizeof *c->facet);
    c->facet_names = calloc(boundaries, sizeof *c->facet_names);
    if (!c->fields || !c->sources || !c->facet || !c->facet_names) {
        cml_field_list_free(c);
        return cml_fail_memory(err, (double)(capacity * (sizeof *c->fields + sizeof *c->sources)),
                               "a list of fields");
    }
    set_axes(c);
    set_facet_axes(c);
    return CML_OK;
}

void cml_field_list_free(struct cml_field_list *c)
{
    free(c->fields);
    free(c->sources);
    free(c->facet);
    free(c->facet_names);
    *c = (struct cml_field_list){0};
}

static struct cml_field_source *add_named(struct cml_field_list *c, const struct cml_result_name *name,
                                          cml_field_values *values)
{
    struct cml_field *field = &c->fields[c->num_fields];
    struct cml_field_source *source = &c->sources[c->num_fields++];
    source->report = c->report;
    source->scale = 1;
    source->per_facet = 1;
    source->stride = 1;
    cml_result_name_field(field, name);
    field->values = values;
    field->context = source;
    return source;
}

struct cml_field_source *cml_add_field(struct cml_field_list *c, const char *name, const char *long_name,
                                       const char *units, cml_field_values *values)
{
    const struct cml_result_name named = {name, long_name, units};
    return add_named(c, &named, values);
}

struct cml_field_source *cml_add_result_field(struct cml_field_list *c, const char *name,
                                              cml_field_values *values)
{
    return add_named(c, cml_result_name(name), values);
}

void cml_field_along(struct cml_field_list *c, const struct cml_axis *a, const struct cml_axis *b,
                     const struct cml_axis *d)
{
    const struct cml_axis *axes[CML_FIELD_AXES] = {a, b, d};
    struct cml_field *field = &c->fields[c->num_fields - 1];
    for (int i = 0; i < CML_FIELD_AXES && axes[i]; i++) field->axis[field->num_axes++] = axes[i];
}

void cml_add_number_field(struct cml_field_list *c, const char *name, const char *long_name, double number)
{
    cml_add_field(c, name, long_name, "1", number_value)->number = number;
}

struct cml_field_source *cml_add_error_field(struct cml_field_list *c, cml_field_values *values)
{
    struct cml_field *of = &c->fields[c->num_fields - 1], *errors = of + 1;
    struct cml_field_source *source = &c->sources[c->num_fields++];
    *source = source[-1];
    cml_result_name_errors(errors, of);
    errors->single = of->single;
    errors->values = values;
    errors->context = source;
    return source;
}

/* ---- what an .mco file holds ---- */

/* A total with the flat twin as control variate. */
static void add_control(struct cml_field_list *c, const char *total, const struct cml_controlled *control)
{
    char name[32];
    snprintf(name, sizeof name, "%s_control", total);
    cml_add_number_field(c, name, "the same with the flat twin as control variate", control->value);
    cml_add_error_field(c, number_value)->number = control->error;
}

static void add_number(struct cml_field_list *c, const struct cml_result_name *name, double number)
{
    add_named(c, name, number_value)->number = number;
}

/* Totals in double, as in the JSON line; in the .mco they have six digits. */
static void add_totals(struct cml_field_list *c)
{
    static const struct {
        const char *name;
        enum cml_total total;
    } totals[] = {{"Rsp", CML_TOTAL_SPECULAR},
                  {"Rd", CML_TOTAL_REFLECTED},
                  {"A", CML_TOTAL_ABSORBED},
                  {"Tt", CML_TOTAL_TRANSMITTED}};
    const struct cml_result *result = &c->report->run->result;
    for (size_t i = 0; i < sizeof totals / sizeof *totals; i++) {
        add_number(c, cml_result_name(totals[i].name), cml_result_total(result, totals[i].total));
        cml_add_error_field(c, number_value)->number = cml_result_error(result, totals[i].total);
        if (c->report->control) add_control(c, totals[i].name, &c->report->control[totals[i].total]);
    }
}

static void add_balance(struct cml_field_list *c)
{
    _Static_assert((int)CML_RESULT_BOOKS == (int)CML_NUM_BALANCE_TERMS, "a name for every term");
    const struct cml_result *result = &c->report->run->result;
    for (int i = 0; i < CML_RESULT_BOOKS; i++)
        add_number(c, cml_result_book(i), cml_result_share(result, (enum cml_balance_term)i));
    add_number(c, cml_result_name("residue"), cml_result_imbalance(result));
    add_number(c, cml_result_name("lost"), (double)cml_result_lost(result));
}

/* fast may be NULL: a profile. */
static void add_array(struct cml_field_list *c, const char *name, const double *array,
                      const struct cml_axis *slow, const struct cml_axis *fast)
{
    cml_add_result_field(c, name, cml_field_array_values)->array = array;
    cml_field_along(c, slow, fast, NULL);
}

/* The numbers of the input, so that a file needs no .mci beside it. */
static void add_layers(struct cml_field_list *c, const struct cml_mco *mco)
{
    for (int i = 0; i < CML_RESULT_LAYER; i++) {
        struct cml_field_source *source = add_named(c, cml_result_layer(i), cml_field_array_values);
        source->array = &mco->layer[0][i];
        source->stride = CML_RESULT_LAYER;
        cml_field_along(c, &c->layer, NULL, NULL);
    }
}

/* A profile and its errors; nothing where it was not tallied. */
static void add_profile(struct cml_field_list *c, const struct cml_profile *profile, const double *array,
                        const struct cml_axis *axis)
{
    if (!profile->batches) return;
    add_array(c, profile->name, array, axis, NULL);
    cml_add_error_field(c, profile_errors)->profile = *profile;
}

/* In the order of an .mco. Of the grids over two variables no errors are known: they have no batches. */
void cml_add_result_fields(struct cml_field_list *c, const struct cml_mco *mco)
{
    struct cml_profile profiles[CML_PROFILES];
    cml_report_profiles(c->report, profiles);
    add_totals(c);
    add_balance(c);
    add_layers(c, mco);
    add_array(c, "A_l", mco->A_l, &c->layer, NULL);
    add_profile(c, &profiles[0], mco->A_z, &c->z);
    add_profile(c, &profiles[1], mco->Rd_r, &c->r);
    add_profile(c, &profiles[2], mco->Rd_a, &c->alpha);
    add_profile(c, &profiles[3], mco->Tt_r, &c->r);
    add_profile(c, &profiles[4], mco->Tt_a, &c->alpha);
    if (c->report->run->result.A_rz) add_array(c, "A_rz", mco->A_rz, &c->r, &c->z);
    add_array(c, "Rd_ra", mco->Rd_ra, &c->r, &c->alpha);
    add_array(c, "Tt_ra", mco->Tt_ra, &c->r, &c->alpha);
}

/* ---- maps and volume ---- */

/* 32-bit floats: a pixel of the largest maps has fewer packets than these have digits. */
static void add_pixels(struct cml_field_list *c, const char *name, const char *long_name,
                       const cml_u128 *cells, const cml_u128 *squares, bool angles)
{
    const struct cml_map_def *map = &c->report->scene->map;
    struct cml_field_source *source = cml_add_field(c, name, long_name, angles ? "1/(cm2 sr)" : "1/cm2",
                                                    angles ? angle_values : pixel_values);
    source->cells = cells;
    source->squares = squares;
    source->na = (size_t)c->report->run->result.grid.map_na;
    source->scale = 1 / (map->dx * map->dy);
    cml_field_along(c, &c->y, &c->x, angles ? &c->alpha : NULL);
    c->fields[c->num_fields - 1].single = true;
    cml_add_error_field(c, angles ? angle_errors : pixel_errors);
}

/* With angles there is both, the sum and its parts: most users look at the sum. */
void cml_add_map_fields(struct cml_field_list *c)
{
    const struct cml_result *r = &c->report->run->result;
    if (!r->Rd_xya) return;
    add_pixels(c, "Rd_xy", "diffuse reflectance", r->Rd_xya, r->Rd_xya2, false);
    add_pixels(c, "Tt_xy", "transmittance", r->Tt_xya, r->Tt_xya2, false);
    if (!c->report->scene->map.angles) return;
    add_pixels(c, "Rd_xya", "diffuse reflectance by angle", r->Rd_xya, r->Rd_xya2, true);
    add_pixels(c, "Tt_xya", "transmittance by angle", r->Tt_xya, r->Tt_xya2, true);
}

/* Without errors: squares of what a packet leaves in a voxel would need a volume per packet. */
void cml_add_volume_fields(struct cml_field_list *c)
{
    const struct cml_result *result = &c->report->run->result;
    const struct cml_scene *scene = c->report->scene;
    if (!result->A_xyz) return;
    struct cml_field_source *source = cml_add_field(c, "A_xyz", "absorption", "1/cm3", pixel_values);
    source->cells = result->A_xyz;
    source->na = 1;
    source->scale = 1 / (scene->map.dx * scene->map.dy * scene->dz);
    cml_field_along(c, &c->z_volume, &c->y, &c->x);
    c->fields[c->num_fields - 1].single = true;
}

/* With them the sums of map and volume are the totals, which is how a reader can check them. */
void cml_add_outside_fields(struct cml_field_list *c)
{
    const struct cml_result *r = &c->report->run->result;
    const struct cml_grid *grid = &r->grid;
    const size_t pixels = (size_t)grid->nx * (size_t)grid->ny, na = (size_t)grid->map_na;
    const double per = CML_WEIGHT_UNIT / (double)r->photons;
    if (!r->Rd_xya) return;
    cml_add_number_field(c, "Rd_outside", "diffuse reflectance outside the map",
                         (double)sum_of_pixel(r->Rd_xya, pixels, na) * per);
    cml_add_number_field(c, "Tt_outside", "transmittance outside the map",
                         (double)sum_of_pixel(r->Tt_xya, pixels, na) * per);
    if (r->A_xyz)
        cml_add_number_field(c, "A_outside", "absorbed fraction outside the volume",
                             (double)r->A_xyz[pixels * (size_t)grid->nz] * per);
}
