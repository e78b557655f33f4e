/* SPDX-License-Identifier: MIT */
#include "tally/result.h"

#include "tally/tally_cells.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* All arrays lie in one block, in the order Rd_ra, Tt_ra, A_rz, rows, maps, then totals and profiles batch by
 * batch: so a checkpoint or a sum over ranks is one loop over cells. */

static size_t cells_A(const struct cml_tally_grid *grid)
{
    return grid->absorption ? (size_t)cml_cell_groups(grid) * (size_t)grid->nr * (size_t)grid->nz : 0;
}

static size_t cells_ra(const struct cml_tally_grid *grid)
{
    return (size_t)cml_cell_groups(grid) * (size_t)grid->nr * (size_t)grid->na;
}

/* Rd_t, Tt_t and, where there is one, A_t, each with what is later. */
static size_t cells_t(const struct cml_tally_grid *grid)
{
    return grid->gates ? ((size_t)grid->gates + 1) * (cml_tally_has_A_t(grid) ? 3 : 2) : 0;
}

/* What each detector has seen, its gates with what is later, and moments. */
static size_t cells_detected(const struct cml_tally_grid *grid)
{
    return (size_t)grid->detectors *
           (1 + (grid->gates ? (size_t)grid->gates + 1 : 0) + cml_tally_moments(grid));
}

/* Cells of phi_rz, of which phi_z is made. */
static size_t cells_phi(const struct cml_tally_grid *grid)
{
    return grid->marks > 0 ? ((size_t)grid->nr + 1) * (size_t)grid->nz : 0;
}

/* What comes behind all else of batches: expected values, then fluence. */
static size_t cells_last(const struct cml_tally_grid *grid)
{
    return (size_t)grid->scores + cells_phi(grid);
}

static size_t cells_batched(const struct cml_tally_grid *grid)
{
    const size_t bins = CML_NUM_TOTALS + 2 * (size_t)grid->nr + 2 * (size_t)grid->na +
                        (grid->absorption ? (size_t)grid->nz : 0) + cml_tally_media(grid) + cells_t(grid) +
                        cells_detected(grid) + cells_last(grid);
    return CML_NUM_BATCHES * bins;
}

/* Cells of all arrays that are not kept apart by batch. */
static size_t cells_unbatched(const struct cml_tally_grid *grid)
{
    return cells_A(grid) + 2 * cells_ra(grid) + grid->row_cells + cml_cells_all_maps(grid);
}

/* The maps come last among the arrays without batches. */
static cml_u128 *result_maps(const struct cml_result *result)
{
    return result->Rd_ra + cells_unbatched(&result->grid) - cml_cells_all_maps(&result->grid);
}

double cml_result_bytes(const struct cml_tally_grid *grid)
{
    return (double)(cells_unbatched(grid) + cells_batched(grid)) * sizeof(cml_u128) +
           cml_saved_bytes(&grid->saved);
}

/* Where detectors' sums begin, which stand before expected values and fluence, the last. */
static void set_detectors(struct cml_result *result)
{
    const struct cml_tally_grid *grid = &result->grid;
    const size_t each = CML_NUM_BATCHES * (size_t)grid->detectors;
    if (!each) return;
    result->detector =
        result->totals + cells_batched(grid) - CML_NUM_BATCHES * (cells_detected(grid) + cells_last(grid));
    result->detector_path =
        result->detector + CML_NUM_BATCHES * cells_detected(grid) - each * cml_tally_moments(grid);
    result->detector_interactions = result->detector_path + each * cml_tally_media(grid);
    result->detector_deepest = result->detector_interactions + each * cml_tally_media(grid);
    if (!grid->gates) return;
    result->detector_t = result->detector + each;
    result->detector_t_later = result->detector_t + each * (size_t)grid->gates;
}

/* Where gates of time begin, which stand before what detectors have seen. */
static void set_gates(struct cml_result *result)
{
    const struct cml_tally_grid *grid = &result->grid;
    const size_t gates = CML_NUM_BATCHES * (size_t)grid->gates, both = gates + CML_NUM_BATCHES;
    if (!gates) return;
    result->Rd_t = result->totals + cells_batched(grid) -
                   CML_NUM_BATCHES * (cells_t(grid) + cells_detected(grid) + cells_last(grid));
    result->Rd_t_later = result->Rd_t + gates;
    result->Tt_t = result->Rd_t + both;
    result->Tt_t_later = result->Tt_t + gates;
    if (!cml_tally_has_A_t(grid)) return;
    result->A_t = result->Tt_t + both;
    result->A_t_later = result->A_t + gates;
}

cml_status cml_result_create(const struct cml_tally_grid *grid, uint64_t photons, struct cml_result *result,
                             struct cml_error *err)
{
    *result = (struct cml_result){.grid = *grid, .photons = photons};
    cml_u128 *block = calloc(cells_unbatched(grid) + cells_batched(grid), sizeof *block);
    if (!block) return cml_fail_memory(err, cml_result_bytes(grid), "the result");
    result->Rd_ra = block;
    result->Tt_ra = result->Rd_ra + cells_ra(grid);
    if (grid->absorption) result->A_rz = result->Tt_ra + cells_ra(grid);
    if (grid->rows) result->rows = result_maps(result) - grid->row_cells;
    CML_SET_MAPS(result, result_maps(result));
    result->totals = block + cells_unbatched(grid);
    result->Rd_r = result->totals + CML_NUM_BATCHES * CML_NUM_TOTALS;
    result->Tt_r = result->Rd_r + CML_NUM_BATCHES * (size_t)grid->nr;
    result->Rd_a = result->Tt_r + CML_NUM_BATCHES * (size_t)grid->nr;
    result->Tt_a = result->Rd_a + CML_NUM_BATCHES * (size_t)grid->na;
    result->A_l = result->Tt_a + CML_NUM_BATCHES * (size_t)grid->na;
    if (grid->absorption) result->A_z = result->A_l + CML_NUM_BATCHES * cml_tally_media(grid);
    set_gates(result);
    set_detectors(result);
    if (grid->scores)
        result->expected = result->totals + cells_batched(grid) - CML_NUM_BATCHES * cells_last(grid);
    if (grid->marks > 0)
        result->phi_rz = result->totals + cells_batched(grid) - CML_NUM_BATCHES * cells_phi(grid);
    if (grid->marks > 0)
        result->phi_z = result->phi_rz + CML_NUM_BATCHES * (size_t)grid->nr * (size_t)grid->nz;
    const cml_status status = cml_saved_create(&grid->saved, &result->saved, err);
    if (status != CML_OK) cml_result_free(result);
    return status;
}

void cml_result_free(struct cml_result *result)
{
    free(result->Rd_ra);
    cml_saved_free(result->saved);
    *result = (struct cml_result){0};
}

/* n bins of which the first `before` lie beyond the grid, into a batch's profile of `size` bins, whose first
 * and last take what lies beyond it. */
static void add_bins(cml_u128 *profile, size_t size, size_t before, const uint64_t *brought, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const size_t bin = i < before ? 0 : i - before;
        profile[bin < size ? bin : size - 1] += brought[i];
    }
}

/* Gates, and behind them what is later, to those of a batch; NULL: they are not tallied. */
static void add_gates(cml_u128 *profile, cml_u128 *later, size_t gates, size_t batch, const uint64_t *brought)
{
    if (!profile) return;
    add_bins(profile + batch * gates, gates, 0, brought, gates);
    later[batch] += brought[gates];
}

/* A moment from the parts of which tallies keep it (CML_MOMENT_CELLS). */
static cml_u128 moment_of(const uint64_t *parts)
{
    cml_u128 sum = 0;
    for (int i = CML_MOMENT_CELLS - 1; i >= 0; i--) sum = (sum << CML_MOMENT_BITS) + parts[i];
    return sum;
}

/* Adds the moments of detector k; brought: their parts, as tallies keep them. */
static void add_moments(struct cml_result *result, size_t batch, size_t k, const uint64_t *brought)
{
    const size_t media = cml_tally_media(&result->grid), at = batch * (size_t)result->grid.detectors + k;
    for (size_t m = 0; m < media; m++) {
        result->detector_path[at * media + m] += moment_of(brought + m * CML_MOMENT_CELLS);
        result->detector_interactions[at * media + m] += moment_of(brought + (media + m) * CML_MOMENT_CELLS);
    }
    result->detector_deepest[at] += moment_of(brought + 2 * media * CML_MOMENT_CELLS);
}

/* What detectors have seen, to that of a batch. */
static void add_detected(struct cml_result *result, size_t batch, const struct cml_profile_offsets *at,
                         const uint64_t *brought)
{
    const size_t n = (size_t)result->grid.detectors, gates = (size_t)result->grid.gates;
    if (!result->detector) return;
    add_bins(result->detector + batch * n, n, 0, brought + at->detector, n);
    for (size_t k = 0; k < n; k++)
        add_moments(result, batch, k,
                    brought + at->moments + k * cml_tally_moments(&result->grid) * CML_MOMENT_CELLS);
    for (size_t k = 0; result->detector_t && k < n; k++)
        add_gates(result->detector_t, result->detector_t_later, gates, batch * n + k,
                  brought + at->detector_t + k * (gates + 1));
}

/* Adds scores, which a tally has in units of 2^6 2^-exponent, to those of a batch. */
static void add_expected(struct cml_result *result, size_t batch, const uint64_t *brought)
{
    const size_t n = (size_t)result->grid.scores;
    for (size_t i = 0; i < n; i++)
        result->expected[batch * n + i] += (cml_u128)brought[i]
                                           << (CML_EXPECTED_SHIFT - result->grid.exponent[i]);
}

/* Totals and profiles of a tally with the same profiles, to those of a batch. */
static void add_to_batch(struct cml_result *result, int batch, const uint64_t *brought)
{
    const struct cml_profile_offsets at = cml_tally_profiles(&result->grid);
    const size_t nr = (size_t)result->grid.nr, na = (size_t)result->grid.na, nz = (size_t)result->grid.nz;
    const size_t b = (size_t)batch, media = cml_tally_media(&result->grid);
    add_bins(result->totals + b * CML_NUM_TOTALS, CML_NUM_TOTALS, 0, brought, CML_NUM_TOTALS);
    add_bins(result->Rd_r + b * nr, nr, 0, brought + at.Rd_r, nr + 1);
    add_bins(result->Tt_r + b * nr, nr, 0, brought + at.Tt_r, nr + 1);
    add_bins(result->Rd_a + b * na, na, 0, brought + at.Rd_a, na);
    add_bins(result->Tt_a + b * na, na, 0, brought + at.Tt_a, na);
    if (result->grid.absorption) add_bins(result->A_z + b * nz, nz, 1, brought + at.A_z, nz + 2);
    add_bins(result->A_l + b * media, media, 0, brought + at.A_l, media);
    const size_t gates = (size_t)result->grid.gates;
    add_gates(result->Rd_t, result->Rd_t_later, gates, b, brought + at.Rd_t);
    add_gates(result->Tt_t, result->Tt_t_later, gates, b, brought + at.Tt_t);
    add_gates(result->A_t, result->A_t_later, gates, b, brought + at.A_t);
    add_detected(result, b, &at, brought);
    add_expected(result, b, brought + at.expected);
}

void cml_result_add_brought(struct cml_result *result, int batch, const struct cml_tally *tally)
{
    const struct cml_late *late = &tally->late;
    const size_t bins = cml_tally_profile_bins(&tally->grid);
    add_to_batch(result, batch, tally->brought);
    for (int row = 0; row < late->count; row++)
        add_to_batch(result, late->batch[row], late->rows + (size_t)row * bins);
}

/* Rd_ra or Tt_ra: what left beyond the last radius goes into the last radial bin. */
static void add_exits(struct cml_result *result, cml_u128 *to, const uint64_t *from)
{
    const size_t nr = (size_t)result->grid.nr, na = (size_t)result->grid.na;
    for (size_t i = 0; i <= nr; i++) {
        const size_t ir = i < nr ? i : nr - 1;
        for (size_t ia = 0; ia < na; ia++) {
            const uint64_t cell = from[i * na + ia];
            if (!cell) continue; /* most groups get nothing in one range */
            to[ir * na + ia] += cell;
            if (i == nr) result->summary.balance[CML_BALANCE_OVERFLOW_R] += cell;
        }
    }
}

/* A_rz with its cells beyond the grid: depths above z = 0 go into the first depth bin, all others into the
 * last bins. */
static void add_absorption(struct cml_result *result, cml_u128 *to, const uint64_t *A_rz)
{
    const size_t nr = (size_t)result->grid.nr, nz = (size_t)result->grid.nz;
    for (size_t i = 0; i <= nr; i++) {
        const size_t ir = i < nr ? i : nr - 1;
        for (size_t j = 0; j < nz + 2; j++) {
            const uint64_t cell = A_rz[i * (nz + 2) + j];
            const size_t iz = cml_depth_of_cell(j, nz);
            if (!cell) continue;
            to[ir * nz + iz] += cell;
            if (i == nr) result->summary.balance[CML_BALANCE_OVERFLOW_R] += cell;
            if (j == 0) result->summary.balance[CML_BALANCE_ABOVE] += cell;
            if (j > nz) result->summary.balance[CML_BALANCE_OVERFLOW_Z] += cell;
        }
    }
}

/* Fluence without its cells beyond the grid, but that those beyond its radius count for phi_z. Few batches
 * are flown in one range. */
static void add_fluence(struct cml_result *result, const uint64_t *phi)
{
    const size_t nr = (size_t)result->grid.nr, nz = (size_t)result->grid.nz;
    for (size_t row = 0; row < CML_NUM_BATCHES * (nr + 1); row++, phi += nz + 2) {
        const size_t batch = row / (nr + 1), ir = row % (nr + 1);
        for (size_t iz = 0; iz < nz; iz++) {
            const uint64_t cell = phi[iz + 1];
            if (!cell) continue;
            result->phi_z[batch * nz + iz] += cell;
            if (ir < nr) result->phi_rz[(batch * nr + ir) * nz + iz] += cell;
        }
    }
}

/* Adds cells of a large map, or of rows. Few of them are hit in one range: reading zeros is cheaper than
 * adding them to 128 bits. Rows that are scores may be negative. */
static void add_rows(cml_u128 *to, const uint64_t *from, size_t cells)
{
    for (size_t i = 0; i < cells; i++) {
        if (from[i]) to[i] += from[i];
        if (from[i] >> 63) to[i] -= (cml_u128)1 << 64;
    }
}

static void add_sparse(cml_u128 *to, const uint64_t *from, size_t cells)
{
    for (size_t i = 0; i < cells; i++)
        if (from[i]) to[i] += from[i];
}

static void add_group(struct cml_result *result, size_t group, const struct cml_tally *tally)
{
    const size_t nr = (size_t)result->grid.nr, from = group * cml_ra_cells(&tally->grid),
                 to = group * nr * (size_t)result->grid.na;
    add_exits(result, result->Rd_ra + to, tally->Rd_ra + from);
    add_exits(result, result->Tt_ra + to, tally->Tt_ra + from);
    if (tally->grid.absorption)
        add_absorption(result, result->A_rz + group * nr * (size_t)result->grid.nz,
                       tally->A_rz + group * cml_rz_cells(&tally->grid));
}

void cml_result_add(struct cml_result *result, const struct cml_tally *tally)
{
    for (size_t g = 0; g < (size_t)cml_cell_groups(&tally->grid); g++) add_group(result, g, tally);
    if (tally->grid.marks > 0) add_fluence(result, tally->phi);
    add_sparse(result_maps(result), cml_tally_maps(tally), cml_cells_all_maps(&tally->grid));
    add_rows(result->rows, tally->rows, tally->grid.row_cells);
    for (int i = 0; i < CML_NUM_BALANCE_TERMS; i++) result->summary.balance[i] += tally->balance[i];
    for (int i = 0; i < CML_NUM_COUNTS; i++) result->summary.count[i] += tally->count[i];
    cml_lost_list_merge(&result->summary.lost, &tally->lost);
}

cml_u128 *cml_result_cells(struct cml_result *result, size_t *count)
{
    *count = cells_unbatched(&result->grid) + cells_batched(&result->grid);
    return result->Rd_ra;
}

void cml_summary_merge(struct cml_summary *to, const struct cml_summary *from)
{
    for (int i = 0; i < CML_NUM_BALANCE_TERMS; i++) to->balance[i] += from->balance[i];
    for (int i = 0; i < CML_NUM_COUNTS; i++) to->count[i] += from->count[i];
    cml_lost_list_merge(&to->lost, &from->lost);
}

static uint64_t group_size(uint64_t photons, int groups, int group)
{
    return photons / (uint64_t)groups + ((uint64_t)group < photons % (uint64_t)groups);
}

uint64_t cml_batch_size(uint64_t photons, int batch)
{
    return group_size(photons, CML_NUM_BATCHES, batch);
}

/* ---- weight balance ---- */

static cml_u128 sum_of(const cml_u128 *cells, size_t n)
{
    cml_u128 sum = 0;
    for (size_t i = 0; i < n; i++) sum += cells[i];
    return sum;
}

/* Unsigned sums: the smaller must be taken from the larger. */
static double difference(cml_u128 a, cml_u128 b)
{
    return a >= b ? (double)(a - b) : -(double)(b - a);
}

/* The imbalance of all facets, both sides together: what arrives minus what leaves, or a backing keeps. */
static double facet_imbalance(const struct cml_result *result)
{
    cml_u128 in = 0, out = result->grid.backed ? result->summary.balance[CML_BALANCE_BACKING] : 0;
    for (size_t i = 0; i < cml_cells_facets(&result->grid); i += CML_FACET_SCORES) {
        const cml_u128 *score = result->facets + i;
        in += score[CML_FACET_IRRADIANCE_ABOVE] + score[CML_FACET_IRRADIANCE_BELOW];
        out += score[CML_FACET_EXITANCE_ABOVE] + score[CML_FACET_EXITANCE_BELOW];
    }
    return difference(in, out);
}

/* An array of several, `of` cells each, that are kept alike: minus what all its cells come of; 0 where there
 * is none. */
static double once_imbalance(const cml_u128 *cells, size_t of, struct cml_once once, cml_u128 total)
{
    cml_u128 sum = 0;
    for (size_t g = 0; cells && g < cml_groups_of(once.step); g++) sum += sum_of(cells + g * once.step, of);
    return cells ? difference(sum, total) : 0;
}

/* Gates of all batches, what is later included, minus what they come of; 0 where there are none. */
static double gate_imbalance(const struct cml_result *result, const cml_u128 *gates, cml_u128 total)
{
    return gates ? difference(sum_of(gates, CML_NUM_BATCHES * ((size_t)result->grid.gates + 1)), total) : 0;
}

/* All of it is exact, in integers, so any difference at all is a fault; the first is enough to say so. */
double cml_result_imbalance(const struct cml_result *result)
{
    const struct cml_tally_grid *grid = &result->grid;
    const cml_u128 *balance = result->summary.balance;
    const cml_u128 in = balance[CML_BALANCE_LAUNCHED] + balance[CML_BALANCE_GAINED];
    cml_u128 out = balance[CML_BALANCE_BACKING];
    for (int i = CML_BALANCE_SPECULAR; i <= CML_BALANCE_LOST; i++) out += balance[i];
    const cml_u128 absorbed = balance[CML_BALANCE_ABSORBED], reflected = balance[CML_BALANCE_REFLECTED],
                   transmitted = balance[CML_BALANCE_TRANSMITTED];
    const size_t pixels = cml_cells_map(grid), directions = cml_cells_directions(grid);
    const double differences[] = {
        difference(in, out),
        difference(sum_of(result->A_l, CML_NUM_BATCHES * cml_tally_media(grid)), absorbed),
        grid->absorption && !grid->row_depths ? difference(sum_of(result->A_rz, cells_A(grid)), absorbed) : 0,
        difference(sum_of(result->Rd_ra, cells_ra(grid)), reflected),
        difference(sum_of(result->Tt_ra, cells_ra(grid)), transmitted),
        once_imbalance(result->Rd_xya, pixels, grid->map_once, reflected),
        once_imbalance(result->Tt_xya, pixels, grid->map_once, transmitted),
        grid->volume ? difference(sum_of(result->A_xyz, cml_cells_volume(grid)), absorbed) : 0,
        facet_imbalance(result),
        gate_imbalance(result, result->A_t, absorbed),
        gate_imbalance(result, result->Rd_t, reflected),
        gate_imbalance(result, result->Tt_t, transmitted),
        once_imbalance(result->Rd_dir, directions, grid->direction_once, reflected),
        once_imbalance(result->Tt_dir, directions, grid->direction_once, transmitted),
        once_imbalance(result->Rsp_dir, directions, grid->direction_once, balance[CML_BALANCE_SPECULAR]),
    };
    for (size_t i = 0; i < sizeof differences / sizeof *differences; i++)
        if (differences[i] != 0) return differences[i];
    return 0;
}

/* ---- means and their errors ---- */

/* Sums are far below 2^127, but those of scores may be negative (P17). */
static double as_number(cml_u128 sum)
{
    return (double)(cml_i128)sum;
}

double cml_result_share(const struct cml_result *result, enum cml_balance_term term)
{
    return as_number(result->summary.balance[term]) /
           as_number(result->summary.balance[CML_BALANCE_LAUNCHED]);
}

/* Standard error of a mean over n packets: sqrt((sum x^2 - (sum x)^2 / n) / (n - 1) / n), in the unit of x.
 */
static double error_of_mean(long double n, long double sum, long double squares)
{
    if (n < 2) return NAN;
    const long double variance = (squares - sum * sum / n) / (n - 1) / n;
    return variance > 0 ? (double)sqrtl(variance) : 0;
}

double cml_result_total(const struct cml_result *result, enum cml_total total)
{
    return cml_result_share(result, cml_balance_term_of_total(total));
}

double cml_result_error(const struct cml_result *result, enum cml_total total)
{
    return cml_result_bin_error(result, result->totals, CML_NUM_TOTALS, (int)total);
}

double cml_result_absorbed(const struct cml_result *result, int medium)
{
    const int media = (int)cml_tally_media(&result->grid);
    return cml_result_bin_sum(result->A_l, media, medium) * (CML_WEIGHT_UNIT / (double)result->photons);
}

double cml_result_absorbed_error(const struct cml_result *result, int medium)
{
    return cml_result_bin_error(result, result->A_l, (int)cml_tally_media(&result->grid), medium);
}

const enum cml_total cml_goals[CML_NUM_GOALS] = {CML_TOTAL_REFLECTED, CML_TOTAL_ABSORBED,
                                                 CML_TOTAL_TRANSMITTED};

double cml_result_relative_error(const struct cml_result *result, enum cml_total total)
{
    const double value = cml_result_total(result, total), error = cml_result_error(result, total);
    return value > 0 && error > 0 ? error / value : INFINITY;
}

double cml_result_times_to(const struct cml_result *result, enum cml_total total, double error)
{
    const double times = cml_result_relative_error(result, total) / error;
    return times * times;
}

/* The sum is turned into the unit of the squares, which was made coarser so that they fit. */
double cml_result_square_error(const struct cml_result *result, cml_u128 sum, cml_u128 squares)
{
    const long double n = (long double)result->summary.count[CML_COUNT_PHOTONS];
    const long double per_square_unit = CML_WEIGHT_UNIT / CML_SQUARE_UNIT;
    return error_of_mean(n, (long double)sum * per_square_unit, (long double)squares) * CML_SQUARE_UNIT;
}

double cml_result_bin_sum(const cml_u128 *profile, int n, int i)
{
    cml_u128 sum = 0;
    for (int b = 0; b < CML_NUM_BATCHES; b++) sum += profile[(size_t)b * (size_t)n + (size_t)i];
    return as_number(sum);
}

/* The means x_b of groups over n_b packets scatter about the mean x of all N with the variance of one packet
 * over n_b, so sum_b n_b (x_b - x)^2 / (B - 1) estimates the former, and over N it is the variance of x. The
 * B groups differ by at most one packet; their sums lie n cells apart. */
static double error_by_groups(const struct cml_result *result, int groups, const cml_u128 *sums, size_t n)
{
    double of[CML_NUM_BATCHES], sum = 0, squares = 0, found = 0;
    const double photons = (double)result->photons;
    for (int b = 0; b < groups; b++) sum += of[b] = as_number(sums[(size_t)b * n]);
    if (sum == 0) return photons > 1 ? 0 : NAN; /* most cells of a grid are dark */
    const double mean = sum / photons;
    for (int b = 0; b < groups; b++) {
        const double size = (double)group_size(result->photons, groups, b);
        if (!(size > 0)) continue;
        const double deviation = of[b] / size - mean;
        squares += size * deviation * deviation;
        found += 1;
    }
    return found > 1 ? sqrt(squares / (found - 1) / photons) * CML_WEIGHT_UNIT : NAN;
}

double cml_result_bin_error(const struct cml_result *result, const cml_u128 *profile, int n, int i)
{
    return error_by_groups(result, CML_NUM_BATCHES, profile + i, (size_t)n);
}

double cml_result_cell_sum(const cml_u128 *cell, int groups, size_t step)
{
    cml_u128 sum = 0;
    for (size_t g = 0; g < (size_t)groups; g++) sum += cell[g * step];
    return as_number(sum);
}

double cml_result_cell_error(const struct cml_result *result, const cml_u128 *cell, size_t step)
{
    return error_by_groups(result, CML_NUM_GROUPS, cell, step);
}

double cml_result_once_sum(const cml_u128 *cells, size_t count, struct cml_once once)
{
    cml_u128 sum = 0;
    for (size_t g = 0; g < cml_groups_of(once.step); g++) sum += sum_of(cells + g * once.step, count);
    return as_number(sum);
}

double cml_result_once_error(const struct cml_result *result, const cml_u128 *cells, size_t count,
                             struct cml_once once)
{
    cml_u128 group[CML_NUM_GROUPS];
    if (!once.step)
        return cml_result_square_error(result, sum_of(cells, count), sum_of(cells + once.squares, count));
    for (size_t g = 0; g < CML_NUM_GROUPS; g++) group[g] = sum_of(cells + g * once.step, count);
    return cml_result_cell_error(result, group, 1);
}

/* The causes of loss are neighbours in enum cml_count. */
uint64_t cml_result_lost(const struct cml_result *result)
{
    cml_u128 lost = 0;
    for (int i = CML_COUNT_LOST_NO_SURFACE; i <= CML_COUNT_LOST_ROUGH; i++) lost += result->summary.count[i];
    return (uint64_t)lost;
}

double cml_result_steps(const struct cml_result *result)
{
    const cml_u128 *count = result->summary.count;
    return (double)(count[CML_COUNT_INTERACTIONS] + count[CML_COUNT_BOUNDARY_EVENTS]);
}
