/* See result_names.h. The names after a section of an .mco file are part of the file format.
 * SPDX-License-Identifier: MIT */
#include "output/files/result_names.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

static const struct cml_result_name names[] = {
    {"Rsp", "specular reflectance", "1"},
    {"Rd", "diffuse reflectance", "1"},
    {"A", "absorbed fraction", "1"},
    {"Tt", "transmittance", "1"},
    {"residue", "launched + gained - all fates, in 2^-31 packets", "1"},
    {"lost", "packets lost to numerical failure", "1"},
    {"A_l", "absorption by layer", "1"},
    {"A_body", "absorption by body", "1"},
    {"A_z", "absorption by depth; what lies outside is in the outermost bins", "1/cm"},
    {"Rd_r", "diffuse reflectance by radius; the last bin holds what lies beyond", "1/cm2"},
    {"Rd_a", "diffuse reflectance by angle", "sr-1"},
    {"Tt_r", "transmittance by radius; the last bin holds what lies beyond", "1/cm2"},
    {"Tt_a", "transmittance by angle", "sr-1"},
    {"A_rz", "absorption by radius and depth", "1/cm3"},
    {"Rd_ra", "diffuse reflectance by radius and angle", "1/(cm2 sr)"},
    {"Tt_ra", "transmittance by radius and angle", "1/(cm2 sr)"},
    {"layer", "layer, from 1", "1"},
    {"body", "body, from 1, in the order of the file", "1"},
    {"r", "distance from the z axis, middle of the bin", "cm"},
    {"z", "depth, middle of the bin", "cm"},
    {"alpha", "angle from the outward vertical, middle of the bin", "rad"},
};

static const struct cml_result_name books[CML_RESULT_BOOKS] = {
    {"book_launched", "launched", "1"},
    {"book_gained", "gained in roulette", "1"},
    {"book_specular", "specular (Rsp)", "1"},
    {"book_reflected", "reflected (Rd)", "1"},
    {"book_transmitted", "transmitted (Tt)", "1"},
    {"book_absorbed", "absorbed (A)", "1"},
    {"book_roulette", "lost in roulette", "1"},
    {"book_trapped", "trapped", "1"},
    {"book_lost", "lost", "1"},
    {"book_overflow_r", "scored in the last r bin from beyond it", "1"},
    {"book_overflow_z", "absorbed below the last z bin", "1"},
    {"book_above", "absorbed above z = 0", "1"},
};

static const struct cml_result_name layer[CML_RESULT_LAYER] = {
    {"layer_n", "refractive index", "1"},
    {"layer_mua", "absorption coefficient", "1/cm"},
    {"layer_mus", "scattering coefficient", "1/cm"},
    {"layer_g", "anisotropy of scattering", "1"},
    {"layer_d", "thickness", "cm"},
};

const struct cml_result_name *cml_result_name(const char *name)
{
    const size_t count = sizeof names / sizeof *names;
    size_t i = 0;
    while (i < count && strcmp(names[i].name, name) != 0) i++;
    assert(i < count);
    return &names[i];
}

const struct cml_result_name *cml_result_book(int i)
{
    return &books[i];
}

const struct cml_result_name *cml_result_layer(int i)
{
    return &layer[i];
}

struct cml_axis cml_result_axis(const char *name, int n, double first, double step)
{
    const struct cml_result_name *of = cml_result_name(name);
    return (struct cml_axis){of->name, of->long_name, of->units, (size_t)n, first, step, NULL};
}

void cml_result_name_field(struct cml_field *field, const struct cml_result_name *name)
{
    snprintf(field->name, sizeof field->name, "%s", name->name);
    field->long_name = name->long_name;
    field->units = name->units;
}

void cml_result_name_errors(struct cml_field *errors, struct cml_field *of)
{
    snprintf(errors->name, sizeof errors->name, "%.50s_se", of->name);
    errors->long_name = "standard error";
    errors->units = of->units;
    memcpy(errors->axis, of->axis, sizeof of->axis);
    errors->num_axes = of->num_axes;
    of->errors = errors->name;
}

bool cml_result_is_errors(const char *name)
{
    const size_t length = strlen(name);
    return length > 3 && strcmp(name + length - 3, "_se") == 0;
}
