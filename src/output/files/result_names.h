/* What the arrays of a result are called in .h5 and VTK files, of a run and of merged results: one list of
 * names, meanings and units. SPDX-License-Identifier: MIT */
#ifndef CML_RESULT_NAMES_H
#define CML_RESULT_NAMES_H

#include "output/files/field.h"

struct cml_result_name {
    const char *name, *long_name, *units;
};

/* That of an array or axis; the name must be in the list. Lives as long as the program. */
const struct cml_result_name *cml_result_name(const char *name);

/* The terms of the weight balance (P10), in the order of the section `books` of an .mco file. */
enum { CML_RESULT_BOOKS = 12 };
const struct cml_result_name *cml_result_book(int i);

/* The numbers of a layer, in the order of a line of an .mci file: n, mua, mus, g, d. */
enum { CML_RESULT_LAYER = 5 };
const struct cml_result_name *cml_result_layer(int i);

/* An axis of the list: n places, the first at `first`, `step` apart. */
struct cml_axis cml_result_axis(const char *name, int n, double first, double step);

/* Gives a field its name, long name and units. */
void cml_result_name_field(struct cml_field *field, const struct cml_result_name *name);

/* Makes `errors` the field of the standard errors of `of`, NAME_se, along the same axes. `of` must stay where
 * it is. */
void cml_result_name_errors(struct cml_field *errors, struct cml_field *of);

/* Whether a field of this name holds standard errors. */
bool cml_result_is_errors(const char *name);

#endif
