/* A field: an array of numbers with a name, units and axes, and how to get its values. What the writers of
 * HDF5 and VTK files (hdf5_file.h, vtk.h) both read; they know nothing of what the numbers mean.
 * SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#define CML_FIELD_AXES 8

/* Bins of equal width; bin i has its middle at first + i * step. Or values one by one. */
struct cml_axis {
    const char *name, *long_name, *units;
    size_t n;
    double first, step;
    const double *values; /* [n] in place of these; NULL: none */
};

/* Fills out[count] with the values from number `begin` on, the last axis fastest. */
typedef void cml_field_values(const void *context, size_t begin, size_t count, double *out);

struct cml_field {
    char name[64];
    const char *long_name, *units;
    const char *errors; /* name of the field that holds the standard errors of this one, or NULL */
    int num_axes;       /* 0: one number */
    const struct cml_axis *axis[CML_FIELD_AXES]; /* slowest first */
    bool single;                                 /* written as 32-bit floats, else as 64-bit */
    bool plain;                                  /* not deflated: its digits are those of chance */
    cml_field_values *values;
    const void *context;
    const bool
        *broken; /* true: values could not be had, and the file is not written; NULL: they always can */
};

/* Number of values of a field: the product of its axes. */
static inline size_t cml_field_size(const struct cml_field *field)
{
    size_t size = 1;
    for (int i = 0; i < field->num_axes; i++) size *= field->axis[i]->n;
    return size;
}

/* For fields whose context is their numbers. */
static inline void cml_field_array_values(const void *context, size_t begin, size_t count, double *out)
{
    memcpy(out, (const double *)context + begin, count * sizeof *out);
}
