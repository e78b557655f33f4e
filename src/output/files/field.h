/* A field: an array of numbers with a name, units and axes, and a function that returns its values. The
 * writers of HDF5 and VTK files (hdf5_file.h, vtk.h) read fields; they do not know the meaning of the
 * numbers. SPDX-License-Identifier: MIT */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#define CML_FIELD_AXES 8

/* An axis of a field: bins of equal width, the middle of bin i at first + i * step; or values one by one. */
struct cml_axis {
    const char *name, *long_name, *units;
    size_t n;
    double first, step;
    const double *values; /* [n] used in place of first and step; NULL: not used */
};

/* Fills out[count] with the values of a field from number `begin` on; the last axis varies fastest. */
typedef void cml_field_values(const void *context, size_t begin, size_t count, double *out);

struct cml_field {
    char name[64];
    const char *long_name, *units;
    const char *errors; /* name of the field with the standard errors of this one, or NULL */
    int num_axes;       /* number of axes; 0: the field is a single number */
    const struct cml_axis *axis[CML_FIELD_AXES]; /* [num_axes] the slowest axis first */
    bool single;                                 /* written as 32-bit floats; false: as 64-bit floats */
    bool plain;                                  /* not deflated, because its digits are random */
    cml_field_values *values;
    const void *context;
    /* True: a value could not be computed, and the file is not written. NULL: values can always be computed.
     */
    const bool *broken;
};

/* Returns the number of values of a field: the product of the lengths of its axes. */
static inline size_t cml_field_size(const struct cml_field *field)
{
    size_t size = 1;
    for (int i = 0; i < field->num_axes; i++) size *= field->axis[i]->n;
    return size;
}

/* Copies the values of a field whose context is an array of doubles. */
static inline void cml_field_array_values(const void *context, size_t begin, size_t count, double *out)
{
    memcpy(out, (const double *)context + begin, count * sizeof *out);
}
