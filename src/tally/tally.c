/* SPDX-License-Identifier: MIT */
#include "tally/tally.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static size_t cells_A(const struct cml_grid *grid)
{
    return grid->absorption ? (size_t)grid->nr * (size_t)grid->nz : 0;
}

static size_t cells_ra(const struct cml_grid *grid)
{
    return (size_t)grid->nr * (size_t)grid->na;
}

static size_t cells_batched(const struct cml_grid *grid)
{
    const size_t bins =
        2 * (size_t)grid->nr + 2 * (size_t)grid->na + (grid->absorption ? (size_t)grid->nz : 0);
    return CML_NUM_BATCHES * bins;
}

/* Profiles of a tally, one behind the other and with the bins beyond the grid: Rd_r and Tt_r [nr + 1], Rd_a
 * and Tt_a [na], A_z [nz + 2] unless there is no A_rz. */
static size_t profile_bins(const struct cml_grid *grid)
{
    return 2 * ((size_t)grid->nr + 1 + (size_t)grid->na) + (grid->absorption ? (size_t)grid->nz + 2 : 0);
}

static size_t cells_map(const struct cml_grid *grid)
{
    return grid->nx > 0 ? ((size_t)grid->nx * (size_t)grid->ny + 1) * (size_t)grid->map_na : 0;
}

static size_t cells_volume(const struct cml_grid *grid)
{
    return grid->volume ? (size_t)grid->nx * (size_t)grid->ny * (size_t)grid->nz + 1 : 0;
}

static size_t cells_facets(const struct cml_grid *grid)
{
    return grid->facets * CML_FACET_SCORES;
}

static size_t cells_maps(const struct cml_grid *grid)
{
    return 4 * cells_map(grid) + cells_volume(grid) + cells_facets(grid);
}

static size_t cells_all(const struct cml_grid *grid)
{
    return cells_A(grid) + 2 * cells_ra(grid) + (size_t)grid->num_layers + 2 + cells_maps(grid);
}

/* The arrays of maps of a tally or a result, which begin at `block`; those that are not tallied stay NULL. */
#define SET_MAPS(to, grid, block)                                                                            \
    do {                                                                                                     \
        const size_t pixels_ = cells_map(grid);                                                              \
        if (pixels_) {                                                                                       \
            (to)->Rd_xya = (block);                                                                          \
            (to)->Tt_xya = (block) + pixels_;                                                                \
            (to)->Rd_xya2 = (block) + 2 * pixels_;                                                           \
            (to)->Tt_xya2 = (block) + 3 * pixels_;                                                           \
        }                                                                                                    \
        if ((grid)->volume) (to)->A_xyz = (block) + 4 * pixels_;                                             \
        if ((grid)->facets) (to)->facets = (block) + 4 * pixels_ + cells_volume(grid);                       \
    } while (0)

/* Of a tally, with the cells beyond the grid. */
static size_t tally_cells_A(const struct cml_grid *grid)
{
    return grid->absorption ? ((size_t)grid->nr + 1) * ((size_t)grid->nz + 2) : 0;
}

struct cml_grid cml_grid_of_thread(const struct cml_grid *grid)
{
    struct cml_grid small = *grid;
    small.nx = small.ny = small.map_na = 0;
    small.volume = false;
    small.facets = 0;
    if (tally_cells_A(grid) > CML_THREAD_CELLS) small.absorption = false;
    return small;
}

static size_t tally_cells_ra(const struct cml_grid *grid)
{
    return ((size_t)grid->nr + 1) * (size_t)grid->na;
}

size_t cml_tally_cells(const struct cml_grid *grid)
{
    return tally_cells_A(grid) + 2 * tally_cells_ra(grid) + (size_t)grid->num_layers + 2 + cells_maps(grid);
}

/* The maps come last. */
static uint64_t *tally_maps(const struct cml_tally *tally)
{
    return tally->A_l + cml_tally_cells(&tally->grid) - cells_maps(&tally->grid);
}

static cml_u128 *result_maps(const struct cml_result *result)
{
    return result->A_l + cells_all(&result->grid) - cells_maps(&result->grid);
}

double cml_tally_bytes(const struct cml_grid *grid)
{
    return (double)cml_tally_cells(grid) * sizeof(uint64_t);
}

double cml_result_bytes(const struct cml_grid *grid)
{
    return (double)(cells_all(grid) + cells_batched(grid)) * sizeof(cml_u128);
}

/* All arrays of a tally lie in one block, A_l first, so that merging and clearing are one loop. */
cml_status cml_tally_create(const struct cml_grid *grid, struct cml_tally *tally, struct cml_error *err)
{
    *tally = (struct cml_tally){.grid = *grid};
    uint64_t *block = calloc(cml_tally_cells(grid), sizeof *block);
    if (!block) return cml_fail_memory(err, cml_tally_bytes(grid), "a tally");
    tally->A_l = block;
    tally->Rd_ra = tally->A_l + grid->num_layers + 2;
    tally->Tt_ra = tally->Rd_ra + tally_cells_ra(grid);
    if (grid->absorption) tally->A_rz = tally->Tt_ra + tally_cells_ra(grid);
    SET_MAPS(tally, grid, tally_maps(tally));
    return CML_OK;
}

void cml_tally_borrow(struct cml_tally *tally, const struct cml_tally *owner)
{
    if (!tally->grid.absorption) tally->A_rz = owner->A_rz;
    tally->Rd_xya = owner->Rd_xya;
    tally->Tt_xya = owner->Tt_xya;
    tally->Rd_xya2 = owner->Rd_xya2;
    tally->Tt_xya2 = owner->Tt_xya2;
    tally->A_xyz = owner->A_xyz;
    tally->facets = owner->facets;
}

void cml_tally_zero(struct cml_tally *tally)
{
    memset(tally->A_l, 0, cml_tally_cells(&tally->grid) * sizeof *tally->A_l);
    memset(tally->balance, 0, sizeof tally->balance);
    memset(tally->count, 0, sizeof tally->count);
    memset(tally->square, 0, sizeof tally->square);
    tally->lost.count = 0;
}

void cml_tally_free(struct cml_tally *tally)
{
    free(tally->A_l);
    *tally = (struct cml_tally){0};
}

void cml_lost_list_add(struct cml_lost_list *list, uint64_t index)
{
    int place = list->count;
    while (place > 0 && list->index[place - 1] > index) place--;
    if (place == CML_LOST_LISTED) return;
    if (list->count < CML_LOST_LISTED) list->count++;
    for (int i = list->count - 1; i > place; i--) list->index[i] = list->index[i - 1];
    list->index[place] = index;
}

static void merge_lost(struct cml_lost_list *to, const struct cml_lost_list *from)
{
    for (int i = 0; i < from->count; i++) cml_lost_list_add(to, from->index[i]);
}

static void move_cells(uint64_t *restrict to, uint64_t *restrict from, size_t first, size_t end)
{
    for (size_t i = first; i < end; i++) {
        to[i] += from[i];
        from[i] = 0;
    }
}

void cml_tally_move(struct cml_tally *to, struct cml_tally *from, int part, int parts)
{
    const size_t cells = cml_tally_cells(&from->grid), n = (size_t)parts, i = (size_t)part;
    move_cells(to->A_l, from->A_l, cells * i / n, cells * (i + 1) / n);
    if (part > 0) return;
    move_cells(to->balance, from->balance, 0, CML_NUM_BALANCE_TERMS);
    move_cells(to->count, from->count, 0, CML_NUM_COUNTS);
    for (int k = 0; k < CML_NUM_TOTALS; k++) {
        to->square[k] += from->square[k];
        from->square[k] = 0;
    }
    merge_lost(&to->lost, &from->lost);
    from->lost.count = 0;
}

cml_status cml_result_create(const struct cml_grid *grid, uint64_t photons, struct cml_result *result,
                             struct cml_error *err)
{
    *result = (struct cml_result){.grid = *grid, .photons = photons};
    cml_u128 *block = calloc(cells_all(grid) + cells_batched(grid), sizeof *block);
    result->A_l = block;
    result->noted = calloc(profile_bins(grid), sizeof *result->noted);
    result->sums = calloc(profile_bins(grid), sizeof *result->sums);
    if (!block || !result->noted || !result->sums) {
        cml_result_free(result);
        return cml_fail_memory(err, cml_result_bytes(grid), "the result");
    }
    result->Rd_ra = result->A_l + grid->num_layers + 2;
    result->Tt_ra = result->Rd_ra + cells_ra(grid);
    if (grid->absorption) result->A_rz = result->Tt_ra + cells_ra(grid);
    SET_MAPS(result, grid, result_maps(result));
    result->Rd_r = block + cells_all(grid);
    result->Tt_r = result->Rd_r + CML_NUM_BATCHES * (size_t)grid->nr;
    result->Rd_a = result->Tt_r + CML_NUM_BATCHES * (size_t)grid->nr;
    result->Tt_a = result->Rd_a + CML_NUM_BATCHES * (size_t)grid->na;
    if (grid->absorption) result->A_z = result->Tt_a + CML_NUM_BATCHES * (size_t)grid->na;
    return CML_OK;
}

void cml_result_free(struct cml_result *result)
{
    free(result->A_l);
    free(result->noted);
    free(result->sums);
    *result = (struct cml_result){0};
}

/* Adds to the sums of rows and columns; by_row may be NULL. */
static void sum_table(const uint64_t *cells, size_t rows, size_t columns, uint64_t *by_row,
                      uint64_t *restrict by_column)
{
    for (size_t i = 0; i < rows; i++) {
        const uint64_t *row = cells + i * columns;
        for (size_t j = 0; j < columns; j++) by_column[j] += row[j];
        for (size_t j = 0; by_row && j < columns; j++) by_row[i] += row[j];
    }
}

static void sum_profiles(const struct cml_tally *tally, uint64_t *sums)
{
    const size_t rows = (size_t)tally->grid.nr + 1, na = (size_t)tally->grid.na;
    uint64_t *Rd_a = sums + 2 * rows, *Tt_a = Rd_a + na, *A_z = Tt_a + na;
    memset(sums, 0, profile_bins(&tally->grid) * sizeof *sums);
    sum_table(tally->Rd_ra, rows, na, sums, Rd_a);
    sum_table(tally->Tt_ra, rows, na, sums + rows, Tt_a);
    if (tally->grid.absorption) sum_table(tally->A_rz, rows, (size_t)tally->grid.nz + 2, NULL, A_z);
}

/* What has come to n bins since they were noted, after `before` bins beyond the grid, into a batch's profile
 * of `size` bins, whose first and last take what lies beyond it. */
static void note_bins(cml_u128 *profile, size_t size, size_t before, const uint64_t *sums,
                      const uint64_t *noted, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const size_t bin = i < before ? 0 : i - before;
        profile[bin < size ? bin : size - 1] += sums[i] - noted[i];
    }
}

void cml_result_note(struct cml_result *result, int batch, const struct cml_tally *tally)
{
    const size_t nr = (size_t)result->grid.nr, na = (size_t)result->grid.na, nz = (size_t)result->grid.nz;
    const size_t b = (size_t)batch, r = nr + 1, a = 2 * r, z = a + 2 * na;
    uint64_t *sums = result->sums, *noted = result->noted;
    sum_profiles(tally, sums);
    note_bins(result->Rd_r + b * nr, nr, 0, sums, noted, r);
    note_bins(result->Tt_r + b * nr, nr, 0, sums + r, noted + r, r);
    note_bins(result->Rd_a + b * na, na, 0, sums + a, noted + a, na);
    note_bins(result->Tt_a + b * na, na, 0, sums + a + na, noted + a + na, na);
    if (result->grid.absorption) note_bins(result->A_z + b * nz, nz, 1, sums + z, noted + z, nz + 2);
    result->sums = noted;
    result->noted = sums;
}

/* Rd_ra or Tt_ra: what left beyond the last radius goes into the last radial bin. */
static void add_exits(struct cml_result *result, cml_u128 *to, const uint64_t *from)
{
    const size_t nr = (size_t)result->grid.nr, na = (size_t)result->grid.na;
    for (size_t i = 0; i <= nr; i++) {
        const size_t ir = i < nr ? i : nr - 1;
        for (size_t ia = 0; ia < na; ia++) {
            const uint64_t cell = from[i * na + ia];
            to[ir * na + ia] += cell;
            if (i == nr) result->balance[CML_BALANCE_OVERFLOW_R] += cell;
        }
    }
}

static void add_absorption(struct cml_result *result, const uint64_t *A_rz)
{
    const size_t nr = (size_t)result->grid.nr, nz = (size_t)result->grid.nz;
    for (size_t i = 0; i <= nr; i++) {
        const size_t ir = i < nr ? i : nr - 1;
        for (size_t j = 0; j < nz + 2; j++) {
            const uint64_t cell = A_rz[i * (nz + 2) + j];
            const size_t iz = j == 0 ? 0 : (j <= nz ? j - 1 : nz - 1);
            result->A_rz[ir * nz + iz] += cell;
            if (i == nr) result->balance[CML_BALANCE_OVERFLOW_R] += cell;
            if (j == 0) result->balance[CML_BALANCE_ABOVE] += cell;
            if (j > nz) result->balance[CML_BALANCE_OVERFLOW_Z] += cell;
        }
    }
}

/* Of a large map few cells are hit in one range. */
static void add_maps(struct cml_result *result, const struct cml_tally *tally)
{
    cml_u128 *to = result_maps(result);
    const uint64_t *from = tally_maps(tally);
    for (size_t i = 0; i < cells_maps(&result->grid); i++)
        if (from[i]) to[i] += from[i];
}

void cml_result_add(struct cml_result *result, const struct cml_tally *tally)
{
    const struct cml_grid *grid = &result->grid;
    for (int m = 0; m < grid->num_layers + 2; m++) result->A_l[m] += tally->A_l[m];
    add_exits(result, result->Rd_ra, tally->Rd_ra);
    add_exits(result, result->Tt_ra, tally->Tt_ra);
    if (grid->absorption) add_absorption(result, tally->A_rz);
    add_maps(result, tally);
    for (int i = 0; i < CML_NUM_BALANCE_TERMS; i++) result->balance[i] += tally->balance[i];
    for (int i = 0; i < CML_NUM_COUNTS; i++) result->count[i] += tally->count[i];
    for (int i = 0; i < CML_NUM_TOTALS; i++) result->square[i] += tally->square[i];
    merge_lost(&result->lost, &tally->lost);
    memset(result->noted, 0, profile_bins(grid) * sizeof *result->noted);
}

cml_u128 *cml_result_cells(struct cml_result *result, size_t *count)
{
    *count = cells_all(&result->grid) + cells_batched(&result->grid);
    return result->A_l;
}

void cml_result_summary(const struct cml_result *result, struct cml_summary *summary)
{
    *summary = (struct cml_summary){.lost = result->lost};
    cml_u128 *sum = summary->sum;
    for (int i = 0; i < CML_NUM_BALANCE_TERMS; i++) *sum++ = result->balance[i];
    for (int i = 0; i < CML_NUM_COUNTS; i++) *sum++ = result->count[i];
    for (int i = 0; i < CML_NUM_TOTALS; i++) *sum++ = result->square[i];
}

void cml_result_set_summary(struct cml_result *result, const struct cml_summary *summary)
{
    const cml_u128 *sum = summary->sum;
    for (int i = 0; i < CML_NUM_BALANCE_TERMS; i++) result->balance[i] = *sum++;
    for (int i = 0; i < CML_NUM_COUNTS; i++) result->count[i] = *sum++;
    for (int i = 0; i < CML_NUM_TOTALS; i++) result->square[i] = *sum++;
    result->lost = summary->lost;
}

void cml_summary_merge(struct cml_summary *to, const struct cml_summary *from)
{
    for (size_t i = 0; i < sizeof to->sum / sizeof *to->sum; i++) to->sum[i] += from->sum[i];
    merge_lost(&to->lost, &from->lost);
}

/* The largest batch that begins at or before the index: floor(photons b / 64) < index + 1. */
int cml_batch_of(uint64_t photons, uint64_t index)
{
    return (int)((CML_NUM_BATCHES * ((cml_u128)index + 1) + photons - 1) / photons) - 1;
}

uint64_t cml_batch_first(uint64_t photons, int batch)
{
    return (uint64_t)((cml_u128)photons * (cml_u128)batch / CML_NUM_BATCHES);
}

static cml_u128 sum_of(const cml_u128 *cells, size_t n)
{
    cml_u128 sum = 0;
    for (size_t i = 0; i < n; i++) sum += cells[i];
    return sum;
}

static double difference(cml_u128 a, cml_u128 b)
{
    return a >= b ? (double)(a - b) : -(double)(b - a);
}

/* Both sides of all facets: what arrives minus what leaves. */
static double facet_imbalance(const struct cml_result *result)
{
    cml_u128 in = 0, out = 0;
    for (size_t i = 0; i < result->grid.facets; i++) {
        const cml_u128 *score = result->facets + i * CML_FACET_SCORES;
        in += score[CML_FACET_IRRADIANCE_ABOVE] + score[CML_FACET_IRRADIANCE_BELOW];
        out += score[CML_FACET_EXITANCE_ABOVE] + score[CML_FACET_EXITANCE_BELOW];
    }
    return difference(in, out);
}

double cml_result_imbalance(const struct cml_result *result)
{
    const struct cml_grid *grid = &result->grid;
    const cml_u128 *balance = result->balance;
    const cml_u128 in = balance[CML_BALANCE_LAUNCHED] + balance[CML_BALANCE_GAINED];
    cml_u128 out = 0;
    for (int i = CML_BALANCE_SPECULAR; i <= CML_BALANCE_LOST; i++) out += balance[i];
    const cml_u128 absorbed = balance[CML_BALANCE_ABSORBED];
    const double differences[] = {
        difference(in, out),
        difference(sum_of(result->A_l, (size_t)grid->num_layers + 2), absorbed),
        grid->absorption ? difference(sum_of(result->A_rz, cells_A(grid)), absorbed) : 0,
        difference(sum_of(result->Rd_ra, cells_ra(grid)), balance[CML_BALANCE_REFLECTED]),
        difference(sum_of(result->Tt_ra, cells_ra(grid)), balance[CML_BALANCE_TRANSMITTED]),
        grid->nx ? difference(sum_of(result->Rd_xya, cells_map(grid)), balance[CML_BALANCE_REFLECTED]) : 0,
        grid->nx ? difference(sum_of(result->Tt_xya, cells_map(grid)), balance[CML_BALANCE_TRANSMITTED]) : 0,
        grid->volume ? difference(sum_of(result->A_xyz, cells_volume(grid)), absorbed) : 0,
        facet_imbalance(result),
    };
    for (size_t i = 0; i < sizeof differences / sizeof *differences; i++)
        if (differences[i] != 0) return differences[i];
    return 0;
}

double cml_result_share(const struct cml_result *result, enum cml_balance_term term)
{
    return (double)result->balance[term] / (double)result->balance[CML_BALANCE_LAUNCHED];
}

/* Standard error of a mean over n packets: sqrt((sum x^2 - (sum x)^2 / n) / (n - 1) / n), in the unit of x.
 */
static double error_of_mean(long double n, long double sum, long double squares)
{
    if (n < 2) return 0;
    const long double variance = (squares - sum * sum / n) / (n - 1) / n;
    return variance > 0 ? (double)sqrtl(variance) : 0;
}

double cml_result_error(const struct cml_result *result, enum cml_total total)
{
    static const enum cml_balance_term term_of[CML_NUM_TOTALS] = {
        CML_BALANCE_SPECULAR, CML_BALANCE_REFLECTED, CML_BALANCE_TRANSMITTED, CML_BALANCE_ABSORBED};
    const long double n = (long double)result->count[CML_COUNT_PHOTONS];
    const long double sum = (long double)result->balance[term_of[total]];
    return error_of_mean(n, sum, (long double)result->square[total]) * CML_WEIGHT_UNIT;
}

double cml_result_once_error(const struct cml_result *result, cml_u128 sum, cml_u128 squares)
{
    const long double n = (long double)result->count[CML_COUNT_PHOTONS];
    const long double per_square_unit = CML_WEIGHT_UNIT / CML_SQUARE_UNIT;
    return error_of_mean(n, (long double)sum * per_square_unit, (long double)squares) * CML_SQUARE_UNIT;
}

/* Batches differ by at most one packet; each mean counts by its number of packets. */
double cml_result_bin_error(const struct cml_result *result, const cml_u128 *profile, int n, int i)
{
    double sum = 0, squares = 0, batches = 0;
    const double photons = (double)result->photons;
    for (int b = 0; b < CML_NUM_BATCHES; b++) sum += (double)profile[(size_t)b * (size_t)n + (size_t)i];
    const double mean = sum / photons;
    for (int b = 0; b < CML_NUM_BATCHES; b++) {
        const double size =
            (double)(cml_batch_first(result->photons, b + 1) - cml_batch_first(result->photons, b));
        if (!(size > 0)) continue;
        const double deviation = (double)profile[(size_t)b * (size_t)n + (size_t)i] / size - mean;
        squares += size * deviation * deviation;
        batches += 1;
    }
    return batches > 1 ? sqrt(squares / (batches - 1) / photons) * CML_WEIGHT_UNIT : 0;
}

uint64_t cml_result_lost(const struct cml_result *result)
{
    cml_u128 lost = 0;
    for (int i = CML_COUNT_LOST_NO_SURFACE; i <= CML_COUNT_LOST_LEAKED; i++) lost += result->count[i];
    return (uint64_t)lost;
}
