/* SPDX-License-Identifier: MIT */
#include "plot/quantity.h"

#include "output/scaling.h"

#include <math.h>

const struct cml_quantity_info cml_quantities[CML_NUM_QUANTITIES] = {
    {"Rsp", "-", NULL},          {"Rd", "-", NULL},           {"A", "-", NULL},
    {"Tt", "-", NULL},           {"A_z", "1/cm", "z [cm]"},   {"Rd_r", "1/cm2", "r [cm]"},
    {"Rd_a", "1/sr", "a [rad]"}, {"Tt_r", "1/cm2", "r [cm]"}, {"Tt_a", "1/sr", "a [rad]"},
};

bool cml_quantity_is_total(enum cml_quantity which)
{
    return which < CML_QUANTITY_A_z;
}

bool cml_quantity_is_radial(enum cml_quantity which)
{
    return which == CML_QUANTITY_Rd_r || which == CML_QUANTITY_Tt_r;
}

/* In the order of enum cml_quantity. */
const double *cml_quantity_values(const struct cml_mco *mco, enum cml_quantity which)
{
    const double *const profiles[CML_NUM_QUANTITIES] = {&mco->Rsp, &mco->Rd,  &mco->A,   &mco->Tt, mco->A_z,
                                                        mco->Rd_r, mco->Rd_a, mco->Tt_r, mco->Tt_a};
    return profiles[which];
}

int cml_quantity_bins(const struct cml_mco *mco, enum cml_quantity which)
{
    if (cml_quantity_is_total(which)) return 1;
    if (which == CML_QUANTITY_A_z) return mco->nz;
    return cml_quantity_is_radial(which) ? mco->nr : mco->na;
}

double cml_quantity_width(const struct cml_mco *mco, enum cml_quantity which)
{
    if (cml_quantity_is_total(which)) return 0;
    if (which == CML_QUANTITY_A_z) return mco->dz;
    return cml_quantity_is_radial(which) ? mco->dr : cml_angle_width(mco->na);
}

bool cml_quantity_errors(const struct cml_mco *mco, enum cml_quantity which, double *errors)
{
    static const char *const keys[CML_NUM_QUANTITIES] = {[CML_QUANTITY_A_z] = "se_A_z",
                                                         [CML_QUANTITY_Rd_r] = "se_Rd_r",
                                                         [CML_QUANTITY_Rd_a] = "se_Rd_a",
                                                         [CML_QUANTITY_Tt_r] = "se_Tt_r",
                                                         [CML_QUANTITY_Tt_a] = "se_Tt_a"};
    const int bins = cml_quantity_bins(mco, which);
    if (!keys[which] || cml_mco_extra(mco, keys[which], errors, bins) < bins) return false;
    for (int i = 0; i < bins; i++)
        if (isnan(errors[i])) return false;
    return true;
}
