/* Curves: places and values with their errors, and the reader of those of others, from .csv files. Lines that
 * begin with '#' are comments; commas, blanks or tabs stand between columns. Two forms:
 * - two or three columns: place, value and, where there is a third, its standard error, in the units of what
 *   is shown (cm or rad); a line of names may come first;
 * - a line of names, among them r_mid_cm, z_mid_cm or alpha_mid_rad and the quantity: `Rd_r`, or with its
 * unit `Rd_r_per_cm2`; `Rd_r_se` are standard errors. Other columns are passed over. Places rise from row to
 * row. SPDX-License-Identifier: MIT */
#pragma once

#include "base/status.h"

#include <stdbool.h>

/* A value that is not a number is a gap. Zeroed: a curve without points. */
struct cml_curve {
    int n;
    double *x, *y, *error; /* [n], owned; error NULL: not known */
    double end;            /* where the last bin that is worth an axis ends */
    bool shared;           /* bins are gaps because two media share them */
};

/* Of n points at 0 with the value 0; with room for errors if asked for. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_curve_create(int n, bool errors, struct cml_curve *curve, struct cml_error *err);

void cml_curve_free(struct cml_curve *curve);

/* A quantity as the columns of a file are called: "Rd_r" over "r_mid_cm". */
struct cml_curve_columns {
    const char *value, *place;
};

/* One curve for each of `count` quantities, 1 or 2; that of one which the file does not name has no points. A
 * file without names has the first. CML_E_INPUT with file and line, also when it has none of them; then the
 * curves are freed. */
CML_NODISCARD cml_status cml_curve_read(const char *path, const struct cml_curve_columns *wanted, int count,
                                        struct cml_curve *curves, struct cml_error *err);
