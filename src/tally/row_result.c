/* SPDX-License-Identifier: MIT */
#include "tally/row_result.h"

#include "tally/row_cells.h"

#include <math.h>

/* One row of a flight, on its way into a result of its own. */
struct row {
    const struct cml_result *flight;
    struct cml_layout at, grids;
    size_t stride, row;
    cml_u128 unit; /* unit of the row's cells in units of weight */
    struct cml_result *to;
};

/* Returns where the sums of row `number` lie in the sums of a flight, for copying them into a result of its
 * own. unit: the rows' unit of weight, counted in units of a result. */
static struct row row_of(const struct cml_result *flight, int number, struct cml_result *to)
{
    const struct cml_tally_grid *grid = &flight->grid;
    return (struct row){.flight = flight,
                        .at = cml_layout_of(grid, CML_OF_ROW_BINS),
                        .grids = cml_layout_of(grid, CML_OF_ROW_GRIDS),
                        .stride = cml_row_stride(grid),
                        .row = (size_t)number,
                        .unit = grid->derivatives ? 1 << 11 : 2,
                        .to = to};
}

/* Returns a cell in units of weight. Bins count from the first of batch 0. */
static cml_u128 cell(const struct row *row, size_t bin)
{
    return row->unit * row->flight->rows[bin * row->stride + row->row];
}

/* Adds an array of the row, whose first bin is given, to a part of the result's array. */
static void take(const struct row *row, enum cml_array array, size_t part, size_t first)
{
    cml_result_add_cells(row->to, array, part,
                         &(struct cml_cell_source){.wide = row->flight->rows + first * row->stride + row->row,
                                                   .stride = row->stride,
                                                   .unit = row->unit});
}

/* Returns moment m of detector k, in the units of flights (rule P13). */
static cml_u128 moment(const struct row *row, size_t batch, size_t k, size_t m)
{
    const size_t media = cml_tally_media(&row->to->grid),
                 bin = batch * row->at.cells + row->at.moments +
                       2 * (k * cml_tally_moments(&row->to->grid) + m);
    const cml_u128 whole = (cell(row, bin + 1) << CML_ROW_MOMENT_BITS) + cell(row, bin);
    return m / media == CML_MOMENT_INTERACTIONS
               ? whole
               : whole << CML_ROW_MOMENT_SHIFT; /* numbers of interactions have no unit to convert */
}

/* Copies the moments of all detectors of one batch (lengths of path, depths) from the flight's sums into the
 * row's result. */
static void take_means(const struct row *row, size_t batch)
{
    struct cml_result *to = row->to;
    const size_t n = (size_t)to->grid.detectors, media = cml_tally_media(&to->grid);
    for (size_t k = 0; to->detector_path && k < n; k++) {
        const size_t first = (batch * n + k) * media;
        for (size_t i = 0; i < CML_MEDIUM_MOMENTS * media; i++)
            to->array[CML_ARRAY_detector_path + i / media][first + i % media] = moment(row, batch, k, i);
        to->detector_deepest[batch * n + k] = moment(row, batch, k, CML_MEDIUM_MOMENTS * media);
    }
}

/* Copies the totals of one batch from the flight's sums into the row's result, and adds to the balance of
 * weight. */
static void take_totals(const struct row *row, size_t batch)
{
    const size_t media = cml_tally_media(&row->to->grid);
    cml_u128 *balance = row->to->summary.balance, *totals = row->to->totals + batch * CML_NUM_TOTALS;
    for (int t = 0; t < CML_NUM_TOTALS; t++)
        totals[t] = cell(row, batch * row->at.cells + (size_t)cml_balance_term_of_total((enum cml_total)t));
    totals[CML_TOTAL_SPECULAR] = row->flight->totals[batch * CML_NUM_TOTALS + CML_TOTAL_SPECULAR];
    for (size_t m = 0; m < media; m++) totals[CML_TOTAL_ABSORBED] += row->to->A_l[batch * media + m];
    for (size_t term = CML_BALANCE_GAINED; term < CML_NUM_BALANCE_TERMS; term++)
        balance[term] += cell(row, batch * row->at.cells + term);
    balance[CML_BALANCE_ABSORBED] += totals[CML_TOTAL_ABSORBED];
}

/* Copies one batch of a sweep's row from the flight's sums into the row's own result: binned arrays, means
 * and totals. */
static void take_batch(const struct row *row, size_t batch)
{
    const struct cml_array_order order = cml_order_of(CML_OF_ROW_BINS);
    for (int i = 0; i < order.count; i++)
        take(row, order.array[i], batch, batch * row->at.cells + row->at.at[order.array[i]]);
    take_means(row, batch);
    take_totals(row, batch);
}

/* Balances the launched weight. Weights of rows are coarser than those of packets, by at most 2^-24 of a
 * packet. The difference between the rows' weights and the launched weight counts as roulette. */
static void take_launch(const struct row *row)
{
    cml_u128 *balance = row->to->summary.balance, inside = 0;
    const cml_u128 exact = balance[CML_BALANCE_LAUNCHED] - balance[CML_BALANCE_SPECULAR];
    const struct row first = row_of(row->flight, 0, row->to);
    for (size_t b = 0; b < CML_NUM_BATCHES; b++)
        inside += cell(&first, b * row->at.cells + CML_BALANCE_LAUNCHED);
    if (exact > inside)
        balance[CML_BALANCE_ROULETTE] += exact - inside;
    else
        balance[CML_BALANCE_GAINED] += inside - exact;
}

/* Fills the result's directions, with their parts: groups, or sums and squares. Rd_dir and Tt_dir come from
 * the row, whose bin `first` is the first of Rd_dir. Rsp_dir comes from the flight, because it is equal for
 * all rows. */
static void take_directions(const struct row *row, size_t first)
{
    struct cml_result *to = row->to;
    const struct cml_once once = row->grids.once[CML_ARRAY_Rd_dir];
    const size_t both = once.squares, all = to->layout.once[CML_ARRAY_Rd_dir].squares;
    for (size_t part = 0; part < row->grids.parts[CML_ARRAY_Rd_dir]; part++) {
        const bool squares = part > 0 && !once.step;
        const size_t from = first + part * both, at = part * all;
        for (size_t i = 0; i < both; i++) /* Tt_dir lies behind Rd_dir */
            to->Rd_dir[at + i] =
                squares ? row->flight->rows[(from + i) * row->stride + row->row] : cell(row, from + i);
        for (size_t i = both; i < all; i++) to->Rd_dir[at + i] = row->flight->Rd_dir[at + i];
    }
}

/* Makes the result of a row with the flight's sizes, and copies all sums by batch. Detectors of rows have no
 * pixels. */
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
                                        .radii = flown->radii,
                                        .nt = flown->derivatives ? 0 : flown->nt,
                                        .np = flown->np,
                                        .direction_once = flown->direction_once,
                                        .detectors = flown->detectors,
                                        .path_unit = flown->path_unit,
                                        .path_top = flown->path_top};
    struct cml_result *to = row->to;
    CML_TRY(cml_result_create(&grid, row->flight->photons, to, err));
    for (int i = CML_ARRAY_detector_path; i <= CML_ARRAY_detector_deepest; i++)
        if (!flown->row_means) to->array[i] = NULL;
    to->summary = row->flight->summary;
    for (int t = 0; t < CML_NUM_BALANCE_TERMS; t++)
        if (t != CML_BALANCE_LAUNCHED && t != CML_BALANCE_SPECULAR) to->summary.balance[t] = 0;
    for (size_t b = 0; b < CML_NUM_BATCHES; b++) take_batch(row, b);
    return CML_OK;
}

/* In the memory of a row, arrays by batch stand first, and grids that are kept by group follow. */
cml_status cml_row_result(const struct cml_result *flight, int number, struct cml_result *to,
                          struct cml_error *err)
{
    const struct row row = row_of(flight, number, to);
    const size_t grids = CML_NUM_BATCHES * row.at.cells;
    CML_TRY(take_batches(&row, err));
    take_launch(&row);
    for (int i = 0; i < CML_NUM_ARRAYS; i++)
        if (cml_is_grid_of_groups((enum cml_array)i))
            take(&row, (enum cml_array)i, 0, grids + row.grids.at[i]);
    if (to->Rd_dir) take_directions(&row, grids + row.grids.Rd_dir);
    return CML_OK;
}

cml_status cml_score_result(const struct cml_result *flight, int score, struct cml_result *to,
                            struct cml_error *err)
{
    const struct row row = row_of(flight, score, to);
    return take_batches(&row, err);
}

/* Returns the number of packets of equal weight with this relative error. */
static double effective_packets(const struct cml_result *result, double relative_error)
{
    return 1 / (relative_error * relative_error + 1 / (double)result->photons);
}

double cml_effective_packets(const struct cml_result *result, enum cml_total total)
{
    return effective_packets(result, cml_result_relative_error(result, total));
}

/* Few effective packets warn that a few heavy packets carry the result. */
double cml_effective_packets_by_depth(const struct cml_result *result)
{
    const size_t nz = (size_t)result->grid.nz;
    cml_u128 sums[CML_NUM_BATCHES] = {0};
    for (size_t i = 0; i < CML_NUM_BATCHES * nz; i++) sums[i / nz] += result->A_z[i];
    const double value = cml_result_bin_sum(sums, 1, 0) * (CML_WEIGHT_UNIT / (double)result->photons),
                 error = cml_result_bin_error(result, sums, 1, 0);
    return effective_packets(result, value > 0 && error > 0 ? error / value : INFINITY);
}
