/* What `plot` shows of the table of a sweep's results (NAME.sweep.csv): a column over another, one curve for
 * each value of a third, or in colours over two. A column's standard error is that of its name and _se.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "plot/files/curve.h"
#include "plot/files/map_h5.h"

/* Names of columns; NULL: chosen. */
struct cml_swept_names {
    const char *of; /* default Rd */
    const char
        *over;      /* default: the first label that is a number and differs, else the first that was swept */
    const char *by; /* default: none where one value of `over` has one row, else what tells its rows apart */
};

enum { CML_SWEPT_NAME = 160, CML_SWEPT_TICKS = 1200, CML_SWEPT_CURVES = 64 };

/* All curves of some tables, or a map of one. Zeroed: empty. */
struct cml_swept {
    char of[CML_SWEPT_NAME], over[CML_SWEPT_NAME]; /* as the columns are called */
    int count;
    struct cml_curve *curve;      /* [count] x rises, owned */
    char (*name)[CML_SWEPT_NAME]; /* [count] the value that the curve belongs to, "" where there is but one */
};

/* Adds the curves of a table. CML_E_INPUT with file, line and column. The caller clears *swept. */
CML_NODISCARD cml_status cml_swept_add(const char *path, const struct cml_swept_names *names,
                                       struct cml_swept *swept, struct cml_error *err);
void cml_swept_clear(struct cml_swept *swept);

/* `of` over two columns, whose different values lie one beside the other, rising; NAN where no row is. ticks:
 * for gnuplot, the values at the middles of pixels 0, 1, ... Pixels are as large as 1. CML_E_INPUT as above;
 * the caller clears *map. */
CML_NODISCARD cml_status cml_swept_map(const char *path, const struct cml_swept_names *names,
                                       const char *const over[2], struct cml_pixels *map,
                                       char ticks[2][CML_SWEPT_TICKS], struct cml_error *err);
