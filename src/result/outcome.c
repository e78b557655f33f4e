/* SPDX-License-Identifier: MIT */
#include "result/outcome.h"

#include "base/array.h"
#include "base/text.h"
#include "result/scaling.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- sizes ---- */

int cml_outcome_bins(const struct cml_outcome *o, enum cml_axis_kind axis)
{
    const int bins[CML_NUM_AXES] = {[CML_AXIS_layer] = o->num_layers,
                                    [CML_AXIS_boundary] = o->num_layers + 1,
                                    [CML_AXIS_body] = o->num_bodies,
                                    [CML_AXIS_r] = o->nr,
                                    [CML_AXIS_z] = o->nz,
                                    [CML_AXIS_alpha] = o->na,
                                    [CML_AXIS_gate] = o->num_gates,
                                    [CML_AXIS_detector] = o->num_detectors,
                                    [CML_AXIS_medium] = o->num_layers + 2 + o->num_bodies,
                                    [CML_AXIS_inside] = o->num_layers + o->num_bodies,
                                    [CML_AXIS_theta] = o->nt,
                                    [CML_AXIS_phi] = o->np,
                                    [CML_AXIS_side] = 4};
    return bins[axis];
}

size_t cml_outcome_size(const struct cml_outcome *o, enum cml_quantity quantity)
{
    const struct cml_quantity_info *info = &cml_quantities[quantity];
    size_t size = 1;
    for (int i = 0; i < CML_QUANTITY_AXES && info->axis[i] != CML_AXIS_NONE; i++)
        size *= (size_t)cml_outcome_bins(o, info->axis[i]);
    return size;
}

int cml_outcome_parts(const struct cml_outcome *o, enum cml_quantity quantity)
{
    return cml_quantity_is_of_detector(quantity) ? o->num_detectors : 1;
}

size_t cml_outcome_part_size(const struct cml_outcome *o, enum cml_quantity quantity)
{
    const int parts = cml_outcome_parts(o, quantity);
    return parts > 0 ? cml_outcome_size(o, quantity) / (size_t)parts : 0;
}

/* Returns the last of a quantity's axes. */
static enum cml_axis_kind last_axis(const struct cml_quantity_info *info)
{
    int last = 0;
    while (last + 1 < CML_QUANTITY_AXES && info->axis[last + 1] != CML_AXIS_NONE) last++;
    return info->axis[last];
}

/* Returns by what the sum in bin `number` of a quantity is divided to become a density: the bin's area,
 * depth, solid angle and length of time, as far as the quantity has these axes (scaling.h). Angles of arrays
 * over r count by projected solid angle, others by solid angle. */
static double measure_of(const struct cml_outcome *o, enum cml_quantity quantity, size_t number)
{
    const struct cml_quantity_info *info = &cml_quantities[quantity];
    const bool timed = last_axis(info) == CML_AXIS_gate;
    const size_t i = timed ? number / (size_t)o->num_gates : number;
    const double da = cml_angle_width(o->na), gate = timed ? o->time_end / o->num_gates : 1;
    const enum cml_axis_kind second = info->axis[1] == CML_AXIS_gate ? CML_AXIS_NONE : info->axis[1];
    switch (info->axis[0]) {
    case CML_AXIS_theta:
        return cml_direction_solid_angle(o->nt, o->np, (int)(i / (size_t)o->np));
    case CML_AXIS_alpha:
        return cml_solid_angle(da, (int)i);
    case CML_AXIS_z:
        return o->dz;
    case CML_AXIS_r:
        break;
    default:
        return gate;
    }
    const size_t n = second == CML_AXIS_NONE ? 1 : (size_t)cml_outcome_bins(o, second);
    const double ring = cml_ring_area(o->dr, (int)(i / n));
    if (second == CML_AXIS_NONE) return ring * gate;
    return ring * (second == CML_AXIS_z ? o->dz : cml_projected_solid_angle(da, (int)(i % n))) * gate;
}

/* ---- names ---- */

static const char *ending_of(enum cml_quantity quantity)
{
    return cml_quantities[quantity].name + strlen("detector");
}

void cml_outcome_key(const struct cml_outcome *o, enum cml_quantity quantity, int part,
                     char key[CML_OUTCOME_KEY])
{
    if (cml_quantity_is_of_detector(quantity))
        snprintf(key, CML_OUTCOME_KEY, "detector_%s%s", o->detector[part], ending_of(quantity));
    else
        snprintf(key, CML_OUTCOME_KEY, "%s", cml_quantities[quantity].name);
}

/* ---- memory ---- */

cml_status cml_outcome_add(struct cml_outcome *o, enum cml_quantity quantity, bool errors,
                           struct cml_error *err)
{
    double **array = errors ? &o->error[quantity] : &o->value[quantity];
    if (*array) return CML_OK;
    return cml_zeros(array, cml_outcome_size(o, quantity), sizeof **array, cml_quantities[quantity].name,
                     err);
}

/* True if original MCML's .mco contains the quantity. */
static bool is_of_mcml(enum cml_quantity quantity)
{
    return quantity <= CML_QUANTITY_Tt ||
           (quantity >= CML_QUANTITY_layer_n && quantity <= CML_QUANTITY_Tt_ra);
}

/* Frees the values and standard errors of all quantities. */
static void free_arrays(struct cml_outcome *o)
{
    for (int i = 0; i < CML_NUM_QUANTITIES; i++) {
        free(o->value[i]);
        free(o->error[i]);
        o->value[i] = o->error[i] = NULL;
    }
}

/* Returns how many numbers the arrays of an original .mco contain. It counts in double, because the
 * product of large sizes may overflow any integer. */
static double numbers_of(const struct cml_outcome *o)
{
    const double nz = o->nz, nr = o->nr, na = o->na;
    return nz + 2 * nr + 2 * na + nr * nz + 2 * nr * na + (1.0 + CML_LAYER_NUMBERS) * o->num_layers;
}

cml_status cml_outcome_allocate(struct cml_outcome *o, struct cml_error *err)
{
    const double bytes = (double)sizeof(double) * numbers_of(o);
    cml_status status = bytes < (double)PTRDIFF_MAX ? CML_OK : cml_fail_memory(err, bytes, "the results");
    for (int i = 0; status == CML_OK && i < CML_NUM_QUANTITIES; i++)
        if (is_of_mcml((enum cml_quantity)i)) status = cml_outcome_add(o, (enum cml_quantity)i, false, err);
    if (status == CML_OK) return CML_OK;
    free_arrays(o);
    return cml_fail_memory(err, bytes, "the results");
}

/* Frees all members of an outcome. A zeroed outcome may be cleared, too. */
void cml_outcome_clear(struct cml_outcome *o)
{
    free_arrays(o);
    for (int k = 0; k < o->num_detectors; k++) free(o->detector[k]);
    void *const owned[] = {o->output,    o->program, o->settings, o->beam,     o->phases,
                           o->detectors, o->shapes,  o->top,      o->detector, o->detector_names};
    for (size_t i = 0; i < sizeof owned / sizeof *owned; i++) free(owned[i]);
    *o = (struct cml_outcome){0};
}

double *cml_outcome_layer(const struct cml_outcome *o, int layer, int number)
{
    return &o->value[CML_QUANTITY_layer_n + number][layer];
}

/* ---- from sums ---- */

/* Returns a sum divided by photons and by the measure of the bin. Rounding depends on the order of the two
 * divisions, and .h5 files hold every bit of the quotients, so the order must not change. Quantities over
 * depth are divided by their measure last. */
static double density(const struct cml_outcome *o, enum cml_quantity quantity, double measure, double sum)
{
    const enum cml_axis_kind *axis = cml_quantities[quantity].axis;
    const double per_photon = CML_WEIGHT_UNIT / (double)o->photons;
    const bool over_depth = axis[0] == CML_AXIS_z || axis[1] == CML_AXIS_z;
    return over_depth ? sum * per_photon / measure : sum * (per_photon / measure);
}

/* Returns value i of a quantity, and its standard error in *error, from the sums of an array. An array over
 * media begins with the medium above, which absorbs nothing, hence `first` skips it for layers, and all
 * layers for bodies. Fluence is the sum of weight times length in units of `length` (P14), and densities are
 * divided by `measure`. */
static double of_cells(const struct cml_outcome *o, const struct cml_result *sums, enum cml_quantity quantity,
                       int i, double *error)
{
    const struct cml_quantity_info *info = &cml_quantities[quantity];
    const double measure = measure_of(o, quantity, (size_t)i),
                 length = cml_quantity_is_fluence(quantity) ? sums->grid.marks : 1;
    const int first = info->estimator == CML_FROM_LAYERS   ? 1
                      : info->estimator == CML_FROM_BODIES ? o->num_layers + 2
                                                           : 0,
              gates = last_axis(info) == CML_AXIS_gate ? o->num_gates : 1;
    const double sum = length * cml_result_sum(sums, (enum cml_array)info->sums, (size_t)(first * gates + i));
    *error = length * cml_result_sum_error(sums, (enum cml_array)info->sums, (size_t)(first * gates + i)) /
             measure;
    return density(o, quantity, measure, sum);
}

/* Returns the standard error that rounding leaves in a length, which was rounded to whole units and, in
 * engine cpu, to single precision (rule P13). An error spread evenly over a spacing has the variance
 * spacing^2 / 12. */
static double rounding_of(double length, double unit)
{
    return hypot(unit, length * 0x1p-23) / sqrt(12);
}

/* Computes a mean over detected light. Lengths and depths are sums of units, and depths count from a top. All
 * packets may be rounded alike, so that their spread hides the rounding error; the error is at least this. */
static double mean_of(const struct cml_outcome *o, const struct cml_result *sums, enum cml_quantity quantity,
                      int size, int i, double *error)
{
    const cml_u128 *moments = sums->array[cml_quantities[quantity].sums];
    const int detector = i / (int)cml_outcome_part_size(o, quantity);
    const bool counts = quantity == CML_QUANTITY_detector_interactions;
    const double unit = counts                                       ? 1
                        : quantity == CML_QUANTITY_detector_momentum ? CML_MOMENTUM_UNIT
                                                                     : sums->grid.path_unit,
                 top = quantity == CML_QUANTITY_detector_deepest ? sums->grid.path_top : 0,
                 units = cml_result_mean(sums, moments, size, i, detector, error), mean = top + unit * units,
                 least = !counts && units > 0 ? rounding_of(mean, unit) : 0;
    *error *= unit;
    if (*error < least) *error = least; /* false if the error is NaN */
    return mean;
}

/* Returns an expected value: Tt, which is score 0, or the absorption of a layer. */
static double expected_of(const struct cml_result *sums, enum cml_quantity quantity, int i, double *error)
{
    double value;
    if (cml_quantities[quantity].axis[0] == CML_AXIS_layer)
        cml_result_expected_layer(sums, i + 1, &value, error);
    else
        cml_result_expected(sums, 0, &value, error);
    return value;
}

/* Returns value i of a quantity, and sets *error to its standard error if it has one, from the sums that the
 * quantity is computed from. */
static double number_of(const struct cml_outcome *o, const struct cml_result *sums,
                        enum cml_quantity quantity, int size, int i, double *error)
{
    const struct cml_quantity_info *info = &cml_quantities[quantity];
    switch (info->estimator) {
    case CML_FROM_TOTAL:
        *error = cml_result_error(sums, (enum cml_total)info->sums);
        return cml_result_total(sums, (enum cml_total)info->sums);
    case CML_FROM_BALANCE:
        return cml_result_share(sums, (enum cml_balance_term)info->sums);
    case CML_FROM_COUNT:
        return (double)sums->summary.count[info->sums];
    case CML_FROM_RESIDUE:
        return cml_result_imbalance(sums);
    case CML_FROM_LOST:
        return (double)cml_result_lost(sums);
    case CML_FROM_MEANS:
        return mean_of(o, sums, quantity, size, i, error);
    case CML_FROM_EXPECTED:
        return expected_of(sums, quantity, i, error);
    default:
        return of_cells(o, sums, quantity, i, error);
    }
}

/* True if the sums contain all that the quantity is computed from. */
static bool is_tallied(const struct cml_outcome *o, const struct cml_result *sums, enum cml_quantity quantity)
{
    const struct cml_quantity_info *info = &cml_quantities[quantity];
    if (info->estimator == CML_FROM_TOTAL) return cml_has_total((int)info->sums, o->backed, o->faced);
    if (info->estimator <= CML_FROM_LOST) return true;
    if (info->estimator == CML_FROM_EXPECTED)
        return sums->grid.scores >= (info->axis[0] == CML_AXIS_layer ? 2 : 1);
    return sums->array[info->sums] != NULL;
}

/* Computes a quantity from the sums of a run, with its standard errors unless the sums cannot give them
 * (`alone`: one copy of the array). Nothing is done for a quantity that was not tallied. */
static cml_status take(struct cml_outcome *o, const struct cml_result *sums, enum cml_quantity quantity,
                       struct cml_error *err)
{
    const struct cml_quantity_info *info = &cml_quantities[quantity];
    const bool alone = info->estimator == CML_FROM_ARRAY && sums->layout.parts[info->sums] == 1,
               errors = info->estimator == CML_FROM_TOTAL || (info->estimator > CML_FROM_LOST && !alone);
    const int size = (int)cml_outcome_size(o, quantity);
    if (size == 0 || !is_tallied(o, sums, quantity)) return CML_OK;
    CML_TRY(cml_outcome_add(o, quantity, false, err));
    if (errors) CML_TRY(cml_outcome_add(o, quantity, true, err));
    for (int i = 0; i < size; i++) {
        double error;
        o->value[quantity][i] = number_of(o, sums, quantity, size, i, &error);
        if (errors) o->error[quantity][i] = error;
    }
    return CML_OK;
}

cml_status cml_outcome_take(struct cml_outcome *o, const struct cml_result *sums, struct cml_error *err)
{
    for (int i = 0; i < CML_NUM_QUANTITIES; i++)
        if (cml_quantities[i].estimator <= CML_FROM_EXPECTED)
            CML_TRY(take(o, sums, (enum cml_quantity)i, err));
    o->lost = sums->summary.lost;
    for (int i = 0, at = 0; i < o->lost.count; i++)
        at += snprintf(o->lost_indices + at, sizeof o->lost_indices - (size_t)at, "%s%" PRIu64, i ? " " : "",
                       o->lost.index[i]);
    return CML_OK;
}
