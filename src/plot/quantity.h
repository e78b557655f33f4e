/* Totals and profiles of an .mco file by name, with their bins and standard errors.
 * SPDX-License-Identifier: MIT */
#ifndef CML_QUANTITY_H
#define CML_QUANTITY_H

#include "output/mco.h"

#include <stdbool.h>

enum cml_quantity {
    CML_QUANTITY_Rsp,
    CML_QUANTITY_Rd,
    CML_QUANTITY_A,
    CML_QUANTITY_Tt,
    CML_QUANTITY_A_z, /* from here on profiles */
    CML_QUANTITY_Rd_r,
    CML_QUANTITY_Rd_a,
    CML_QUANTITY_Tt_r,
    CML_QUANTITY_Tt_a,
    CML_NUM_QUANTITIES
};

struct cml_quantity_info {
    const char *name, *unit; /* of the values, as in the file */
    const char *axis;        /* of a profile: "z [cm]"; NULL for a total */
};
extern const struct cml_quantity_info cml_quantities[CML_NUM_QUANTITIES];

/* A total is a profile of one bin. Over r and z the last bin also holds what lies beyond. */
const double *cml_quantity_values(const struct cml_mco *mco, enum cml_quantity which);
int cml_quantity_bins(const struct cml_mco *mco, enum cml_quantity which);

/* Width of a bin on its axis, cm or rad; 0 for a total. */
double cml_quantity_width(const struct cml_mco *mco, enum cml_quantity which);

bool cml_quantity_is_total(enum cml_quantity which);
bool cml_quantity_is_radial(enum cml_quantity which); /* over r */

/* Standard errors of a profile's bins; false where the file has none. */
bool cml_quantity_errors(const struct cml_mco *mco, enum cml_quantity which, double *errors);

#endif
