/* SPDX-License-Identifier: MIT */
#include "output/scaling.h"

#include "base/constants.h"
#include "output/mco.h"
#include "tally/result.h"

#include <math.h>

double cml_angle_width(int na)
{
    return CML_PI / 2 / na;
}

double cml_ring_area(double dr, int ir)
{
    return 2 * CML_PI * (ir + 0.5) * dr * dr;
}

double cml_solid_angle(double da, int ia)
{
    return 2 * CML_PI * sin((ia + 0.5) * da) * da;
}

double cml_projected_solid_angle(double da, int ia)
{
    return 2 * CML_PI * sin(da / 2) * sin(2 * (ia + 0.5) * da);
}

double cml_depth_width(double dz, int iz)
{
    (void)iz;
    return dz;
}

/* The order of the operations is part of the results: .h5 files hold every bit of the quotients. So A_z and
 * A_rz, which are divided last, do not share a function with the others. */

/* Rd_r, Tt_r, Rd_a or Tt_a: a profile [64][n] of bins of the given width. */
static void scale_profile(const cml_u128 *batches, int n, double width, double (*measure)(double, int),
                          double per_photon, double *to)
{
    for (int i = 0; i < n; i++) to[i] = cml_result_bin_sum(batches, n, i) * (per_photon / measure(width, i));
}

/* Rd_ra or Tt_ra. */
static void scale_exits(const cml_u128 *cells, const struct cml_mco *mco, double per_photon, double *to)
{
    const double da = cml_angle_width(mco->na);
    for (int ir = 0; ir < mco->nr; ir++)
        for (int ia = 0; ia < mco->na; ia++) {
            const double measure = cml_ring_area(mco->dr, ir) * cml_projected_solid_angle(da, ia);
            *to++ = (double)*cells++ * (per_photon / measure);
        }
}

static void scale_absorption(const struct cml_result *result, double per_photon, struct cml_mco *mco)
{
    const cml_u128 *cell = result->A_rz;
    double *to = mco->A_rz;
    for (int ir = 0; ir < mco->nr; ir++)
        for (int iz = 0; iz < mco->nz; iz++)
            *to++ = (double)*cell++ * per_photon / (cml_ring_area(mco->dr, ir) * mco->dz);
    for (int iz = 0; iz < mco->nz; iz++)
        mco->A_z[iz] = cml_result_bin_sum(result->A_z, mco->nz, iz) * per_photon / mco->dz;
}

/* A_l counts from the first layer; its sums begin with the medium above. Media outside absorb nothing. */
void cml_scale_result(const struct cml_result *result, struct cml_mco *mco)
{
    const double per_photon = CML_WEIGHT_UNIT / (double)result->photons, da = cml_angle_width(mco->na);
    mco->Rsp = cml_result_total(result, CML_TOTAL_SPECULAR);
    mco->Rd = cml_result_total(result, CML_TOTAL_REFLECTED);
    mco->A = cml_result_total(result, CML_TOTAL_ABSORBED);
    mco->Tt = cml_result_total(result, CML_TOTAL_TRANSMITTED);
    scale_profile(result->Rd_r, mco->nr, mco->dr, cml_ring_area, per_photon, mco->Rd_r);
    scale_profile(result->Tt_r, mco->nr, mco->dr, cml_ring_area, per_photon, mco->Tt_r);
    scale_profile(result->Rd_a, mco->na, da, cml_solid_angle, per_photon, mco->Rd_a);
    scale_profile(result->Tt_a, mco->na, da, cml_solid_angle, per_photon, mco->Tt_a);
    scale_exits(result->Rd_ra, mco, per_photon, mco->Rd_ra);
    scale_exits(result->Tt_ra, mco, per_photon, mco->Tt_ra);
    for (int l = 0; l < mco->num_layers; l++) mco->A_l[l] = (double)result->A_l[l + 1] * per_photon;
    if (result->grid.absorption) scale_absorption(result, per_photon, mco);
}
