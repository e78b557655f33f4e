/* SPDX-License-Identifier: MIT */
#include "tally/row_result.h"

#include "tally/row_cells.h"

#include <math.h>

/* One row of those that come of a flight. */
struct row {
    const struct cml_result *flight;
    struct cml_row_bins at;
    size_t stride, row;
    cml_u128 unit; /* of its cells, in units of weight */
    struct cml_result *to;
};

static struct row row_of(const struct cml_result *flight, int number, struct cml_result *to)
{
    const struct cml_tally_grid *grid = &flight->grid;
    return (struct row){.flight = flight,
                        .at = cml_row_bins(grid),
                        .stride = cml_row_stride(grid),
                        .row = (size_t)number,
                        .unit = grid->derivatives ? 1 << 11 : 2,
                        .to = to};
}

/* Cell of a bin, counted from the first of batch 0, in units of weight. */
static cml_u128 cell(const struct row *row, size_t bin)
{
    return row->unit * row->flight->rows[bin * row->stride + row->row];
}

/* Bins of a batch into its profile of n; those beyond it go into the last. */
static void take_bins(const struct row *row, size_t batch, size_t first, size_t bins, cml_u128 *profile,
                      size_t n)
{
    for (size_t i = 0; i < bins; i++)
        profile[batch * n + (i < n ? i : n - 1)] += cell(row, batch * row->at.all + first + i);
}

/* Gates, and behind them what is later. */
static void take_gates(const struct row *row, size_t first, cml_u128 *profile, cml_u128 *later)
{
    const size_t gates = (size_t)row->to->grid.gates;
    for (size_t i = 0; i < gates; i++) profile[i] += cell(row, first + i);
    *later += cell(row, first + gates);
}

static void take_times(const struct row *row, size_t batch)
{
    struct cml_result *to = row->to;
    const size_t first = batch * row->at.all, gates = (size_t)to->grid.gates;
    if (!gates) return;
    take_gates(row, first + row->at.Rd_t, to->Rd_t + batch * gates, &to->Rd_t_later[batch]);
    take_gates(row, first + row->at.Tt_t, to->Tt_t + batch * gates, &to->Tt_t_later[batch]);
    if (to->A_t) take_gates(row, first + row->at.A_t, to->A_t + batch * gates, &to->A_t_later[batch]);
}

/* Number m of detector k, in units of those of flights (P13). */
static cml_u128 moment(const struct row *row, size_t batch, size_t k, size_t m)
{
    const size_t media = cml_tally_media(&row->to->grid),
                 bin = batch * row->at.all + row->at.moment + 2 * (k * cml_tally_moments(&row->to->grid) + m);
    const cml_u128 whole = (cell(row, bin + 1) << CML_ROW_MOMENT_BITS) + cell(row, bin);
    return m / media == 1 ? whole : whole << CML_ROW_MOMENT_SHIFT; /* interactions are numbers as they are */
}

static void take_means(const struct row *row, size_t batch)
{
    struct cml_result *to = row->to;
    const size_t n = (size_t)to->grid.detectors, media = cml_tally_media(&to->grid);
    for (size_t k = 0; to->detector_path && k < n; k++) {
        const size_t first = (batch * n + k) * media;
        for (size_t m = 0; m < media; m++) {
            to->detector_path[first + m] = moment(row, batch, k, m);
            to->detector_interactions[first + m] = moment(row, batch, k, media + m);
        }
        to->detector_deepest[batch * n + k] = moment(row, batch, k, 2 * media);
    }
}

static void take_detected(const struct row *row, size_t batch)
{
    struct cml_result *to = row->to;
    const size_t first = batch * row->at.all, gates = (size_t)to->grid.gates, n = (size_t)to->grid.detectors;
    take_bins(row, batch, row->at.detector, n, to->detector, n);
    for (size_t k = batch * n; gates && k < (batch + 1) * n; k++)
        take_gates(row, first + row->at.detector_t + (k - batch * n) * (gates + 1),
                   to->detector_t + k * gates, &to->detector_t_later[k]);
}

/* Depths above the first bin go into that, those below the last into that. */
static void take_depths(const struct row *row, size_t batch)
{
    struct cml_result *to = row->to;
    const size_t nz = (size_t)to->grid.nz, first = batch * row->at.all + row->at.A_z;
    for (size_t j = 0; to->A_z && j < nz + 2; j++)
        to->A_z[batch * nz + cml_depth_of_cell(j, nz)] += cell(row, first + j);
}

static void take_totals(const struct row *row, size_t batch)
{
    const size_t media = cml_tally_media(&row->to->grid);
    cml_u128 *balance = row->to->summary.balance, *totals = row->to->totals + batch * CML_NUM_TOTALS;
    for (int t = 0; t < CML_NUM_TOTALS; t++)
        totals[t] = cell(row, batch * row->at.all + (size_t)cml_balance_term_of_total((enum cml_total)t));
    totals[CML_TOTAL_SPECULAR] = row->flight->totals[batch * CML_NUM_TOTALS + CML_TOTAL_SPECULAR];
    for (size_t m = 0; m < media; m++) totals[CML_TOTAL_ABSORBED] += row->to->A_l[batch * media + m];
    for (size_t term = CML_BALANCE_GAINED; term < CML_NUM_BALANCE_TERMS; term++)
        balance[term] += cell(row, batch * row->at.all + term);
    balance[CML_BALANCE_ABSORBED] += totals[CML_TOTAL_ABSORBED];
}

static void take_batch(const struct row *row, size_t batch)
{
    struct cml_result *to = row->to;
    const size_t nr = (size_t)to->grid.nr, na = (size_t)to->grid.na, media = cml_tally_media(&to->grid);
    take_bins(row, batch, row->at.Rd_r, nr + 1, to->Rd_r, nr);
    take_bins(row, batch, row->at.Tt_r, nr + 1, to->Tt_r, nr);
    take_bins(row, batch, row->at.Rd_a, na, to->Rd_a, na);
    take_bins(row, batch, row->at.Tt_a, na, to->Tt_a, na);
    take_bins(row, batch, row->at.A_l, media, to->A_l, media);
    take_times(row, batch);
    take_detected(row, batch);
    take_means(row, batch);
    take_depths(row, batch);
    take_totals(row, batch);
}

/* Rows' weights are coarser than packets'. By how much those of all launches differ from what was launched, a
 * packet's by no more than 2^-24, counts as roulette does. */
static void take_launch(const struct row *row)
{
    cml_u128 *balance = row->to->summary.balance, inside = 0;
    const cml_u128 exact = balance[CML_BALANCE_LAUNCHED] - balance[CML_BALANCE_SPECULAR];
    const struct row first = row_of(row->flight, 0, row->to);
    for (size_t b = 0; b < CML_NUM_BATCHES; b++)
        inside += cell(&first, b * row->at.all + CML_BALANCE_LAUNCHED);
    if (exact > inside)
        balance[CML_BALANCE_ROULETTE] += exact - inside;
    else
        balance[CML_BALANCE_GAINED] += inside - exact;
}

/* Rd_ra or Tt_ra: `first` is its first bin. What left beyond the last radius goes into the last radial bin.
 */
static void take_exits(const struct row *row, size_t first, cml_u128 *to)
{
    const size_t nr = (size_t)row->to->grid.nr, na = (size_t)row->to->grid.na;
    for (size_t i = 0; i <= nr; i++)
        for (size_t a = 0; a < na; a++) {
            const cml_u128 w = cell(row, first + i * na + a);
            to[(i < nr ? i : nr - 1) * na + a] += w;
            if (i == nr) row->to->summary.balance[CML_BALANCE_OVERFLOW_R] += w;
        }
}

/* A_rz, whose first bin is given. What lies beyond its bins is in the books as what flights of their own
 * have there. */
static void take_absorption(const struct row *row, size_t first)
{
    struct cml_result *to = row->to;
    const size_t nr = (size_t)to->grid.nr, nz = (size_t)to->grid.nz;
    cml_u128 *balance = to->summary.balance;
    for (size_t k = 0; k < cml_rz_cells(&to->grid); k++) {
        const size_t i = k / (nz + 2), j = k % (nz + 2);
        const cml_u128 w = cell(row, first + k);
        to->A_rz[(i < nr ? i : nr - 1) * nz + cml_depth_of_cell(j, nz)] += w;
        if (i == nr) balance[CML_BALANCE_OVERFLOW_R] += w;
        if (j == 0) balance[CML_BALANCE_ABOVE] += w;
        if (j > nz) balance[CML_BALANCE_OVERFLOW_Z] += w;
    }
}

/* Rd_dir and Tt_dir, whose first bin is given, by group or with squares behind them; Rsp_dir is that of the
 * flight. */
static void take_directions(const struct row *row, size_t first)
{
    struct cml_result *to = row->to;
    const struct cml_once once = cml_row_once(&row->flight->grid);
    const size_t both = once.squares, all = to->grid.direction_once.squares;
    for (size_t part = 0; part < cml_once_parts(once); part++) {
        const bool squares = part > 0 && !once.step;
        const size_t from = first + part * both, at = part * all;
        for (size_t i = 0; i < both; i++) /* Tt_dir is behind Rd_dir */
            to->Rd_dir[at + i] =
                squares ? row->flight->rows[(from + i) * row->stride + row->row] : cell(row, from + i);
        for (size_t i = both; i < all; i++) to->Rd_dir[at + i] = row->flight->Rd_dir[at + i];
    }
}

/* What of a row is summed by batch. Detectors have no pixels. */
static cml_status take_batches(const struct row *row, struct cml_error *err)
{
    const struct cml_tally_grid *flown = &row->flight->grid;
    const struct cml_tally_grid grid = {.nr = flown->nr,
                                        .nz = flown->nz,
                                        .na = flown->na,
                                        .num_layers = flown->num_layers,
                                        .num_bodies = flown->num_bodies,
                                        .absorption = flown->row_depths,
                                        .row_depths = flown->row_depths,
                                        .row_times = flown->row_times,
                                        .gates = flown->gates,
                                        .nt = flown->derivatives ? 0 : flown->nt,
                                        .np = flown->np,
                                        .direction_once = flown->direction_once,
                                        .detectors = flown->detectors,
                                        .path_unit = flown->path_unit,
                                        .path_top = flown->path_top};
    struct cml_result *to = row->to;
    CML_TRY(cml_result_create(&grid, row->flight->photons, to, err));
    if (!flown->row_means) to->detector_path = to->detector_interactions = to->detector_deepest = NULL;
    to->summary = row->flight->summary;
    for (int t = 0; t < CML_NUM_BALANCE_TERMS; t++)
        if (t != CML_BALANCE_LAUNCHED && t != CML_BALANCE_SPECULAR) to->summary.balance[t] = 0;
    for (size_t b = 0; b < CML_NUM_BATCHES; b++) take_batch(row, b);
    return CML_OK;
}

cml_status cml_row_result(const struct cml_result *flight, int number, struct cml_result *to,
                          struct cml_error *err)
{
    const struct row row = row_of(flight, number, to);
    const size_t exits = CML_NUM_BATCHES * row.at.all, ra = cml_row_cells_ra(&flight->grid) / row.stride;
    CML_TRY(take_batches(&row, err));
    take_launch(&row);
    take_exits(&row, exits, to->Rd_ra);
    take_exits(&row, exits + ra, to->Tt_ra);
    if (to->A_rz) take_absorption(&row, exits + 2 * ra);
    if (to->Rd_dir) take_directions(&row, exits + 2 * ra + cml_row_cells_rz(&flight->grid) / row.stride);
    return CML_OK;
}

cml_status cml_score_result(const struct cml_result *flight, int score, struct cml_result *to,
                            struct cml_error *err)
{
    const struct row row = row_of(flight, score, to);
    return take_batches(&row, err);
}

static double effective_packets(const struct cml_result *result, double relative_error)
{
    return 1 / (relative_error * relative_error + 1 / (double)result->photons);
}

double cml_effective_packets(const struct cml_result *result, enum cml_total total)
{
    return effective_packets(result, cml_result_relative_error(result, total));
}

double cml_effective_packets_by_depth(const struct cml_result *result)
{
    const size_t nz = (size_t)result->grid.nz;
    cml_u128 sums[CML_NUM_BATCHES] = {0};
    for (size_t i = 0; i < CML_NUM_BATCHES * nz; i++) sums[i / nz] += result->A_z[i];
    const double value = cml_result_bin_sum(sums, 1, 0) * (CML_WEIGHT_UNIT / (double)result->photons),
                 error = cml_result_bin_error(result, sums, 1, 0);
    return effective_packets(result, value > 0 && error > 0 ? error / value : INFINITY);
}
