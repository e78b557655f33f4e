/* SPDX-License-Identifier: MIT */
#include "tally/result.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

double cml_result_bytes(const struct cml_tally_grid *grid)
{
    return (double)cml_layout_of(grid, CML_OF_RESULT).cells * sizeof(cml_u128) +
           cml_saved_bytes(&grid->saved);
}

/* All arrays lie in one block, so that a checkpoint or a sum over ranks is one loop over cells. */
cml_status cml_result_create(const struct cml_tally_grid *grid, uint64_t photons, struct cml_result *result,
                             struct cml_error *err)
{
    *result =
        (struct cml_result){.grid = *grid, .photons = photons, .layout = cml_layout_of(grid, CML_OF_RESULT)};
    result->cells = calloc(result->layout.cells, sizeof *result->cells);
    if (!result->cells) return cml_fail_memory(err, cml_result_bytes(grid), "the result");
    for (int i = 0; i < CML_NUM_ARRAYS; i++)
        if (result->layout.size[i]) result->array[i] = result->cells + result->layout.at[i];
    const cml_status status = cml_saved_create(&grid->saved, &result->saved, err);
    if (status != CML_OK) cml_result_free(result);
    return status;
}

void cml_result_free(struct cml_result *result)
{
    free(result->cells);
    cml_saved_free(result->saved);
    *result = (struct cml_result){0};
}

/* Returns cell number i in units of weight. */
static cml_u128 cell_of(const struct cml_cell_source *from, size_t i)
{
    return from->narrow ? from->narrow[i] : from->unit * from->wide[i * from->stride];
}

/* Adds n cells, beginning at number `first`, to n bins of a result, and returns their sum. Skips four zeros
 * at a time: most cells are 0, because a batch has few packets. */
static cml_u128 add_line(const struct cml_cell_source *from, size_t first, size_t n, cml_u128 *to)
{
    const uint64_t *narrow = from->narrow ? from->narrow + first : NULL;
    const cml_u128 *wide = narrow ? NULL : from->wide + first * from->stride;
    const size_t stride = from->stride;
    cml_u128 sum = 0;
    for (size_t i = 0; narrow && i < n; i++) {
        while (i + 4 < n && !(narrow[i] | narrow[i + 1] | narrow[i + 2] | narrow[i + 3])) i += 4;
        if (!narrow[i]) continue;
        to[i] += narrow[i];
        sum += narrow[i];
    }
    for (size_t i = 0; wide && i < n; i++, wide += stride) {
        if (!*wide) continue;
        const cml_u128 cell = from->unit * *wide;
        to[i] += cell;
        sum += cell;
    }
    return sum;
}

/* Rows have no extra cell before the first bin, and rows and columns have at most one behind the last. The
 * only axis of a 1D array is that of columns. Arrays over radius alone are margins of grids. The grids' cells
 * beyond the bins already count in the balance, so those of margins do not. */
void cml_result_add_cells(struct cml_result *result, enum cml_array array, size_t part,
                          const struct cml_cell_source *from)
{
    const struct cml_array_info *info = &cml_arrays[array];
    const size_t *size = result->layout.size;
    if (!size[array]) return;
    const bool one = info->axis[1] == CML_CELLS_none, gates = info->axis[one ? 0 : 1] == CML_CELLS_gate,
               grid = info->spread == CML_KEPT_BY_GROUP && !gates;
    const struct cml_extent rows = cml_extent_of(&result->grid, info->axis[one ? 1 : 0], CML_OF_PROFILES),
                            columns = cml_extent_of(&result->grid, info->axis[one ? 0 : 1], CML_OF_PROFILES);
    const size_t num_rows = cml_extent_cells(rows), num_columns = cml_extent_cells(columns);
    cml_u128 *const to = result->array[array] + part * size[array], *const balance = result->summary.balance;
    for (size_t row = 0; row < num_rows; row++) {
        const size_t first = row * num_columns, inside = first + columns.before, end = inside + columns.bins,
                     bin = row < rows.bins ? row : rows.bins - 1;
        cml_u128 *const line = to + bin * columns.bins;
        const cml_u128 sum = add_line(from, inside, columns.bins, line),
                       above = columns.before ? cell_of(from, first) : 0,
                       behind = columns.behind ? cell_of(from, end) : 0;
        line[0] += above;
        *(gates ? &result->array[array + 1][part * size[array + 1] + bin] : &line[columns.bins - 1]) +=
            behind;
        if (!grid) continue;
        if (row == rows.bins) balance[CML_BALANCE_OVERFLOW_R] += sum + above + behind;
        balance[CML_BALANCE_ABOVE] += above;
        balance[CML_BALANCE_OVERFLOW_Z] += behind;
    }
}

/* Returns a moment, joined from the parts in which tallies keep it (CML_MOMENT_CELLS). */
static cml_u128 moment_of(const uint64_t *parts)
{
    cml_u128 sum = 0;
    for (int i = CML_MOMENT_CELLS - 1; i >= 0; i--) sum = (sum << CML_MOMENT_BITS) + parts[i];
    return sum;
}

/* Adds the moments of detector k to a batch of the result. sums: each moment in parts, as tallies keep
 * them. */
static void add_moments(struct cml_result *result, size_t batch, size_t k, const uint64_t *sums)
{
    const size_t media = cml_tally_media(&result->grid), at = batch * (size_t)result->grid.detectors + k;
    for (size_t i = 0; i < CML_MEDIUM_MOMENTS * media; i++)
        result->array[CML_ARRAY_detector_path + i / media][at * media + i % media] +=
            moment_of(sums + i * CML_MOMENT_CELLS);
    result->detector_deepest[at] += moment_of(sums + CML_MEDIUM_MOMENTS * media * CML_MOMENT_CELLS);
}

/* Adds expected values, which a tally has in units of 2^6 2^-exponent, to those of a batch. */
static void add_expected(struct cml_result *result, size_t batch, const uint64_t *sums)
{
    const size_t n = (size_t)result->grid.scores;
    for (size_t i = 0; i < n; i++)
        result->expected[batch * n + i] += (cml_u128)sums[i]
                                           << (CML_EXPECTED_SHIFT - result->grid.exponent[i]);
}

/* Adds totals and profiles of a tally to those of a batch. Moments and expected values are kept in other
 * units and are converted. */
static void add_to_batch(struct cml_result *result, int batch, const struct cml_tally *tally,
                         const uint64_t *sums)
{
    const struct cml_array_order order = cml_order_of(CML_OF_PROFILES);
    const struct cml_layout *at = &tally->profile;
    const size_t b = (size_t)batch, moments = cml_tally_moments(&result->grid) * CML_MOMENT_CELLS;
    for (int i = 0; i < order.count; i++) {
        const enum cml_array array = order.array[i];
        if (array == CML_ARRAY_moments || array == CML_ARRAY_expected) continue;
        cml_result_add_cells(result, array, b, &(struct cml_cell_source){.narrow = sums + at->at[array]});
    }
    for (size_t k = 0; k < (size_t)result->grid.detectors; k++)
        add_moments(result, b, k, sums + at->moments + k * moments);
    add_expected(result, b, sums + at->expected);
}

void cml_result_add_batch(struct cml_result *result, int batch, const struct cml_tally *tally)
{
    const struct cml_late *late = &tally->late;
    add_to_batch(result, batch, tally, tally->batch_sums);
    for (int row = 0; row < late->count; row++)
        add_to_batch(result, late->batch[row], tally, late->rows + (size_t)row * tally->profile.cells);
}

/* Adds fluence without its cells beyond the grid, except that cells beyond the last radius count for
 * phi_z. Most cells are 0, because few batches are flown in one range. */
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

/* Adds cells of rows, in which scores may be negative: the sign of the 64-bit cell is extended to 128
 * bits. In one range few cells are hit, and testing for 0 is cheaper than adding to 128 bits. */
static void add_rows(cml_u128 *to, const uint64_t *from, size_t cells)
{
    for (size_t i = 0; i < cells; i++) {
        if (from[i]) to[i] += from[i];
        if (from[i] >> 63) to[i] -= (cml_u128)1 << 64;
    }
}

/* Adds cells of large maps, in which few cells are hit, too. */
static void add_sparse(cml_u128 *to, const uint64_t *from, size_t cells)
{
    for (size_t i = 0; i < cells; i++)
        if (from[i]) to[i] += from[i];
}

/* Adds a grid over radius, for all groups. */
static void add_grid(struct cml_result *result, enum cml_array array, const struct cml_tally *tally)
{
    const size_t size = tally->layout.size[array];
    struct cml_cell_source from = {.narrow = tally->array[array]};
    for (size_t g = 0; size && g < tally->layout.parts[array]; g++, from.narrow += size)
        cml_result_add_cells(result, array, g, &from);
}

/* Large maps are mostly zero, so add_sparse adds only their nonzero cells. */
void cml_result_add(struct cml_result *result, const struct cml_tally *tally)
{
    const struct cml_layout *own = &tally->layout;
    for (int i = 0; i < CML_NUM_ARRAYS; i++)
        if (cml_is_grid_of_groups((enum cml_array)i)) add_grid(result, (enum cml_array)i, tally);
    if (own->size[CML_ARRAY_phi_rz]) add_fluence(result, tally->phi_rz);
    add_sparse(result->cells + result->layout.Rd_xya, tally->cells + own->Rd_xya, own->cells - own->Rd_xya);
    add_rows(result->rows, tally->rows, own->size[CML_ARRAY_rows]);
    for (int i = 0; i < CML_NUM_BALANCE_TERMS; i++) result->summary.balance[i] += tally->balance[i];
    for (int i = 0; i < CML_NUM_COUNTS; i++) result->summary.count[i] += tally->count[i];
    cml_lost_list_merge(&result->summary.lost, &tally->lost);
}

cml_u128 *cml_result_cells(struct cml_result *result, size_t *count)
{
    *count = result->layout.cells;
    return result->cells;
}

void cml_summary_merge(struct cml_summary *to, const struct cml_summary *from)
{
    for (int i = 0; i < CML_NUM_BALANCE_TERMS; i++) to->balance[i] += from->balance[i];
    for (int i = 0; i < CML_NUM_COUNTS; i++) to->count[i] += from->count[i];
    cml_lost_list_merge(&to->lost, &from->lost);
}

/* Returns the number of photons in group number `group`, if `photons` are dealt out in turn to `groups`
 * groups. */
static uint64_t group_size(uint64_t photons, int groups, int group)
{
    return photons / (uint64_t)groups + ((uint64_t)group < photons % (uint64_t)groups);
}

uint64_t cml_batch_size(uint64_t photons, int batch)
{
    return group_size(photons, CML_NUM_BATCHES, batch);
}

/* ---- weight balance ---- */

/* Returns the sum of n neighbouring cells. */
static cml_u128 sum_of(const cml_u128 *cells, size_t n)
{
    cml_u128 sum = 0;
    for (size_t i = 0; i < n; i++) sum += cells[i];
    return sum;
}

/* Returns a - b. The sums are unsigned, so the smaller must be subtracted from the larger. */
static double difference(cml_u128 a, cml_u128 b)
{
    return a >= b ? (double)(a - b) : -(double)(b - a);
}

/* Returns the imbalance of all facets, both sides together: light that arrives minus light that leaves or
 * that a backing or face keeps. Light from above that a face stops arrives at no facet, so faces may have
 * kept more than arrived. */
static double facet_imbalance(const struct cml_result *result)
{
    const cml_u128 *balance = result->summary.balance,
                   faced = result->grid.faced ? balance[CML_BALANCE_FACE] : 0;
    cml_u128 in = 0, out = result->grid.backed ? balance[CML_BALANCE_BACKING] : 0;
    for (size_t i = 0; i < cml_layout_cells(&result->layout, CML_ARRAY_facets); i += CML_FACET_SCORES) {
        const cml_u128 *score = result->facets + i;
        in += score[CML_FACET_IRRADIANCE_ABOVE] + score[CML_FACET_IRRADIANCE_BELOW];
        out += score[CML_FACET_EXITANCE_ABOVE] + score[CML_FACET_EXITANCE_BELOW];
    }
    if (in > out) out += in - out < faced ? in - out : faced;
    return difference(in, out);
}

/* Returns the sum of an array's cells, over all groups or batches, minus its term of the balance. Sums of
 * squares are left out, because they are not weights. Returns 0 if the array has no term, and for A_rz of
 * rows, which is only an estimate from samples (row_depths). */
static double array_imbalance(const struct cml_result *result, enum cml_array array)
{
    const struct cml_layout *layout = &result->layout;
    const struct cml_array_info *info = &cml_arrays[array];
    const bool gates = info->axis[0] == CML_CELLS_gate || info->axis[1] == CML_CELLS_gate,
               samples = array == CML_ARRAY_A_rz;
    const size_t size = layout->size[array], step = layout->once[array].step;
    cml_u128 sum = 0;
    if (info->term == CML_NO_TERM || !size || (samples && result->grid.row_depths)) return 0;
    for (size_t part = 0; part < (step ? layout->parts[array] : 1); part++)
        sum += sum_of(result->array[array] + part * step, size);
    if (gates)
        sum +=
            sum_of(result->array[array + 1], cml_layout_cells(&result->layout, (enum cml_array)(array + 1)));
    return difference(sum, result->summary.balance[info->term]);
}

double cml_result_imbalance(const struct cml_result *result)
{
    const cml_u128 *balance = result->summary.balance;
    const cml_u128 in = balance[CML_BALANCE_LAUNCHED] + balance[CML_BALANCE_GAINED];
    cml_u128 out = balance[CML_BALANCE_BACKING] + balance[CML_BALANCE_FACE];
    for (int i = CML_BALANCE_SPECULAR; i <= CML_BALANCE_LOST; i++) out += balance[i];
    double found = difference(in, out);
    for (int i = 0; i < CML_NUM_ARRAYS && found == 0; i++) found = array_imbalance(result, (enum cml_array)i);
    return found != 0 ? found : facet_imbalance(result);
}

/* ---- means and their errors ---- */

/* Converts a sum to a number. Sums are far below 2^127, but sums of scores may be negative (rule P17). */
static double as_number(cml_u128 sum)
{
    return (double)(cml_i128)sum;
}

double cml_result_share(const struct cml_result *result, enum cml_balance_term term)
{
    return as_number(result->summary.balance[term]) /
           as_number(result->summary.balance[CML_BALANCE_LAUNCHED]);
}

/* Returns the standard error of a mean over n packets: sqrt((sum x^2 - (sum x)^2 / n) / (n - 1) / n), in the
 * unit of x. */
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
    return cml_result_sum_error(result, CML_ARRAY_totals, (size_t)total);
}

double cml_result_absorbed(const struct cml_result *result, int medium)
{
    return cml_result_sum(result, CML_ARRAY_A_l, (size_t)medium) *
           (CML_WEIGHT_UNIT / (double)result->photons);
}

double cml_result_absorbed_error(const struct cml_result *result, int medium)
{
    return cml_result_sum_error(result, CML_ARRAY_A_l, (size_t)medium);
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

/* The sum is converted to the unit of the squares, which is coarser so that squares fit into 64 bits. */
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

/* Returns the standard error from groups whose sums lie n cells apart. The means x_b of groups of n_b packets
 * scatter about the mean x of all N with the variance of one packet over n_b. So sum_b n_b (x_b - x)^2 / (B -
 * 1) estimates the variance of one packet, and divided by N that of x. The B groups differ by at most one
 * packet. */
static double error_by_groups(const struct cml_result *result, int groups, const cml_u128 *sums, size_t n)
{
    double of[CML_NUM_BATCHES], sum = 0, squares = 0, found = 0;
    const double photons = (double)result->photons;
    for (int b = 0; b < groups; b++) sum += of[b] = sums[(size_t)b * n] ? as_number(sums[(size_t)b * n]) : 0;
    if (sum == 0) return photons > 1 ? 0 : NAN; /* most cells of a grid get no light */
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

double cml_result_sum(const struct cml_result *result, enum cml_array array, size_t i)
{
    const size_t step = result->layout.once[array].step;
    const int parts = step ? (int)result->layout.parts[array] : 1;
    return cml_result_cell_sum(result->array[array] + i, parts, step);
}

double cml_result_sum_error(const struct cml_result *result, enum cml_array array, size_t i)
{
    const struct cml_once once = result->layout.once[array];
    const cml_u128 *cell = result->array[array] + i;
    const int parts = (int)result->layout.parts[array];
    if (parts == 1) return NAN;
    if (!once.step) return cml_result_square_error(result, *cell, cell[once.squares]);
    return error_by_groups(result, parts, cell, once.step);
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

/* All causes of loss are neighbours in enum cml_count. */
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
