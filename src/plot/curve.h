/* Curves of others for a plot: a .csv file with a line of column names, of which `bin`, `r_mid_cm` and at
 * least one of `Rd_r_per_cm2` and `Tt_r_per_cm2` are read; lines that begin with '#' are comments. Bins count
 * from 0, r is the middle of a bin; missing bins have no light. SPDX-License-Identifier: MIT */
#ifndef CML_CURVE_H
#define CML_CURVE_H

#include "output/mco.h"

/* As a result that holds nothing but Rd_r, Tt_r and their grid; like every result it has one bin more, for
 * what lies beyond. CML_E_INPUT with file and line; then *mco is cleared. The caller clears it otherwise. */
CML_NODISCARD cml_status cml_curve_read(const char *path, struct cml_mco *mco, struct cml_error *err);

#endif
