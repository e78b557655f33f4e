/* SPDX-License-Identifier: MIT */
#include "result/h5.h"

#include "base/text.h"
#include "output/files/hdf5_head.h"
#include "result/scaling.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Sets the axes to the middles of bins. Layers and bodies are numbered from 1. */
static void set_axes(struct cml_h5_fields *f, const struct cml_outcome *o)
{
    const double da = cml_angle_width(o->na);
    const double width[CML_NUM_AXES] = {[CML_AXIS_r] = o->dr,
                                        [CML_AXIS_z] = o->dz,
                                        [CML_AXIS_alpha] = da,
                                        [CML_AXIS_theta] = o->nt > 0 ? cml_angle_width(o->nt) : 0,
                                        [CML_AXIS_phi] = o->np > 0 ? 4 * cml_angle_width(o->np) : 0,
                                        [CML_AXIS_gate] = o->num_gates > 0 ? o->time_end / o->num_gates : 0};
    for (int i = 1; i < CML_NUM_AXES; i++) {
        const enum cml_axis_kind kind = (enum cml_axis_kind)i;
        const size_t n = (size_t)cml_outcome_bins(o, kind);
        const double first = kind == CML_AXIS_medium || kind == CML_AXIS_boundary ? 0 : 1;
        f->axis[i] =
            cml_quantity_axis(kind, n, width[i] > 0 ? width[i] / 2 : first, width[i] > 0 ? width[i] : 1);
    }
}

/* True if the run did not tally absorption by place (--ignore-absorption). */
static bool lacks_absorption(const struct cml_outcome *o)
{
    return o->provenance.value[CML_DECIDES_absorption] == 0;
}

/* True if a quantity is written. With --ignore-absorption the arrays over depth exist and are zero, because
 * an .mco must contain them; an .h5 leaves them out. */
static bool is_written(const struct cml_outcome *o, enum cml_quantity quantity)
{
    const struct cml_quantity_info *info = &cml_quantities[quantity];
    const bool deep = info->axis[0] == CML_AXIS_z || info->axis[1] == CML_AXIS_z;
    return (info->where & CML_IN_H5) && o->value[quantity] &&
           !(deep && !cml_quantity_is_fluence(quantity) && lacks_absorption(o));
}

/* Adds the centres of the bins of depth as a field. A field without values has those of its axis. An .h5
 * without absorption has the field, too, so that it has the axes of the .mco. */
static void add_depths(struct cml_h5_fields *f)
{
    struct cml_field *depths = &f->field[f->count++];
    *depths = (struct cml_field){.num_axes = 1, .axis = {&f->axis[CML_AXIS_z]}};
    strcpy(depths->name, f->axis[CML_AXIS_z].name);
}

/* Adds one part of a quantity as a field, and its standard errors as another. */
static void add_part(struct cml_h5_fields *f, const struct cml_outcome *o, enum cml_quantity quantity,
                     int part)
{
    const enum cml_axis_kind *axis = cml_quantities[quantity].axis;
    const size_t first = (size_t)part * cml_outcome_part_size(o, quantity);
    struct cml_field *field = &f->field[f->count++];
    cml_quantity_name(field, quantity);
    cml_outcome_key(o, quantity, part, field->name);
    for (int i = cml_quantity_is_of_detector(quantity); i < CML_QUANTITY_AXES && axis[i] != CML_AXIS_NONE;
         i++)
        field->axis[field->num_axes++] = &f->axis[axis[i]];
    field->values = cml_field_array_values;
    field->context = o->value[quantity] + first;
    if (!o->error[quantity]) return;
    struct cml_field *errors = &f->field[f->count++];
    cml_quantity_name_errors(errors, field);
    errors->values = cml_field_array_values;
    errors->context = o->error[quantity] + first;
}

static bool has_field(const struct cml_h5_fields *f, const char *name)
{
    for (int i = 0; i < f->count; i++)
        if (strcmp(f->field[i].name, name) == 0) return true;
    return false;
}

/* Fills the attributes of an .h5, and returns their number. The attributes contain no times, and nothing
 * about how the program was called, so that equal runs give equal bytes. */
int cml_h5_attributes(const struct cml_outcome *o, const struct cml_h5_more *more,
                      struct cml_attribute *attributes)
{
    struct cml_attribute *a = attributes;
    *a++ = (struct cml_attribute){"title", o->output, 0};
    *a++ = (struct cml_attribute){"source",
                                  CML_HDF5_SOURCE "Monte Carlo light transport in layered turbid media", 0};
    *a++ = (struct cml_attribute){"version", o->program, 0};
    *a++ = (struct cml_attribute){"engine", o->provenance.engine, 0};
    *a++ = (struct cml_attribute){"input", more->input, 0};
    *a++ = (struct cml_attribute){"boundaries", o->shapes, 0};
    for (int i = 0; i < CML_NUM_OPTIONS_OF_BITS; i++) {
        const double value = o->provenance.value[i];
        if (!(cml_options_of_bits[i].where & CML_IN_H5) || isnan(value)) continue;
        const bool word = cml_options_of_bits[i].where & CML_AS_WORD;
        *a++ =
            (struct cml_attribute){cml_options_of_bits[i].name,
                                   word ? cml_option_word((enum cml_option_of_bits)i, value) : NULL, value};
    }
    *a++ = (struct cml_attribute){"photons", NULL, (double)o->photons};
    if (o->beam && o->beam[0]) *a++ = (struct cml_attribute){"beam", o->beam, 0};
    if (o->phases && o->phases[0]) *a++ = (struct cml_attribute){"phases", o->phases, 0};
    if (o->top && o->top[0]) *a++ = (struct cml_attribute){"top", o->top, 0};
    if (o->detectors && o->detectors[0]) *a++ = (struct cml_attribute){"detectors", o->detectors, 0};
    if (o->detector_names) *a++ = (struct cml_attribute){"detector_names", o->detector_names, 0};
    if (o->lost_indices[0]) *a++ = (struct cml_attribute){"lost_indices", o->lost_indices, 0};
    if (o->settings && o->settings[0]) *a++ = (struct cml_attribute){"settings", o->settings, 0};
    if (o->identity[0]) *a++ = (struct cml_attribute){"identity", o->identity, 0};
    return (int)(a - attributes);
}

cml_status cml_h5_fields_create(const struct cml_outcome *o, const struct cml_h5_more *more,
                                struct cml_h5_fields *f, struct cml_error *err)
{
    const size_t most =
        2 * (size_t)CML_NUM_QUANTITIES * (1 + (size_t)o->num_detectors) + (size_t)more->num_fields;
    *f = (struct cml_h5_fields){0};
    CML_TRY(cml_zeros(&f->field, most, sizeof *f->field, "a list of fields", err));
    set_axes(f, o);
    for (int i = 0; i < CML_NUM_QUANTITIES; i++)
        for (int part = 0;
             is_written(o, (enum cml_quantity)i) && part < cml_outcome_parts(o, (enum cml_quantity)i); part++)
            add_part(f, o, (enum cml_quantity)i, part);
    if (lacks_absorption(o)) add_depths(f);
    for (int i = 0; i < more->num_fields; i++)
        if (!has_field(f, more->field[i].name)) f->field[f->count++] = more->field[i];
    return CML_OK;
}

void cml_h5_fields_free(struct cml_h5_fields *f)
{
    free(f->field);
    *f = (struct cml_h5_fields){0};
}

cml_status cml_h5_write(const char *path, const struct cml_outcome *o, const struct cml_h5_more *more,
                        struct cml_error *err)
{
    CML_AT_END(cml_h5_fields_free) struct cml_h5_fields f = {.count = 0};
    CML_TRY(cml_h5_fields_create(o, more, &f, err));
    struct cml_attribute attributes[CML_H5_MOST_ATTRIBUTES];
    const int count = cml_h5_attributes(o, more, attributes);
    return cml_hdf5_write(path, attributes, count, &more->call, f.field, f.count, err);
}
