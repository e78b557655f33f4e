/* SPDX-License-Identifier: MIT */
#include "tally/tally.h"

#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

/* Returns the term of the energy balance that belongs to a total such as the diffuse reflectance. */
enum cml_balance_term cml_balance_term_of_total(enum cml_total total)
{
    static const enum cml_balance_term terms[CML_NUM_TOTALS] = {
        [CML_TOTAL_SPECULAR] = CML_BALANCE_SPECULAR,       [CML_TOTAL_REFLECTED] = CML_BALANCE_REFLECTED,
        [CML_TOTAL_TRANSMITTED] = CML_BALANCE_TRANSMITTED, [CML_TOTAL_ABSORBED] = CML_BALANCE_ABSORBED,
        [CML_TOTAL_BACKING] = CML_BALANCE_BACKING,         [CML_TOTAL_FACE] = CML_BALANCE_FACE};
    return terms[total];
}

/* A thread has all of A_rz or none of it. With a part of it, each deposit would have to find out where its
 * cell is. */
struct cml_tally_grid cml_tally_grid_of_thread(const struct cml_tally_grid *grid)
{
    struct cml_tally_grid small = *grid;
    const struct cml_layout whole = cml_layout_of(grid, CML_OF_TALLY);
    small.of_thread = true;
    small.depths = cml_layout_cells(&whole, CML_ARRAY_A_rz) > CML_THREAD_CELLS;
    if (small.depths) small.absorption = false;
    if (cml_layout_cells(&whole, CML_ARRAY_phi_rz) > CML_THREAD_FLUENCE) small.marks = 0;
    return small;
}

bool cml_tally_grid_is_shared(const struct cml_tally_grid *grid)
{
    const struct cml_tally_grid small = cml_tally_grid_of_thread(grid);
    return small.depths || small.marks != grid->marks;
}

/* Returns the number of media of all packets that a thread has in flight. */
static size_t trail_cells(const struct cml_tally_grid *grid)
{
    const bool timed = grid->rows && grid->gates;
    return grid->detectors || grid->saved.limit || timed ? CML_TRAILS * cml_tally_media(grid) : 0;
}

size_t cml_tally_cells(const struct cml_tally_grid *grid)
{
    return cml_layout_of(grid, CML_OF_TALLY).cells;
}

size_t cml_tally_profile_bins(const struct cml_tally_grid *grid)
{
    return cml_layout_of(grid, CML_OF_PROFILES).cells;
}

double cml_tally_bytes(const struct cml_tally_grid *grid)
{
    /* Number of sets of profiles in a tally: the current sums, the sums before the current batch, and one row
     * of late packets per batch. */
    const double profiles = 2.0 + CML_NUM_BATCHES;
    const struct cml_layout at = cml_layout_of(grid, CML_OF_PROFILES);
    return ((double)cml_tally_cells(grid) + profiles * (double)(at.expected - at.detector)) *
               sizeof(uint64_t) +
           (double)trail_cells(grid) * sizeof(struct cml_stay);
}

/* Returns the number of bins of profiles that are sums of cells: Rd_r to A_z, which are neighbours. */
static size_t bins_of_cells(const struct cml_tally *tally)
{
    return tally->profile.A_l - tally->profile.Rd_r;
}

/* Returns the number of bins of all groups' profiles. */
static size_t grouped_bins(const struct cml_tally *tally)
{
    return (size_t)cml_cell_groups(&tally->grid) * bins_of_cells(tally);
}

/* Asks for large pages. Bins of all rows are scattered over more memory than a processor keeps addresses of,
 * and looking up addresses would take as long as adding. The system may ignore this request. */
static void prefer_large_pages(void *block, size_t bytes)
{
    const uintptr_t page = (uintptr_t)1 << 21, first = ((uintptr_t)block + page - 1) / page * page,
                    end = ((uintptr_t)block + bytes) / page * page;
#ifdef MADV_HUGEPAGE
    if (end > first) (void)madvise((void *)first, end - first, MADV_HUGEPAGE);
#else
    (void)first, (void)end;
#endif
}

/* All arrays lie in one block, so that adding and clearing are one loop. */
cml_status cml_tally_create(const struct cml_tally_grid *grid, struct cml_tally *tally, struct cml_error *err)
{
    *tally = (struct cml_tally){.grid = *grid,
                                .layout = cml_layout_of(grid, CML_OF_TALLY),
                                .profile = cml_layout_of(grid, CML_OF_PROFILES)};
    const size_t cells = tally->layout.cells, bins = tally->profile.cells;
    tally->cells = cml_arrays_add(&tally->arrays, cells, sizeof *tally->cells);
    if (tally->cells && grid->rows) prefer_large_pages(tally->cells, cells * sizeof *tally->cells);
    tally->grouped = cml_arrays_add(&tally->arrays, grouped_bins(tally), sizeof *tally->grouped);
    tally->last_sums = cml_arrays_add(&tally->arrays, bins, sizeof *tally->last_sums);
    tally->batch_sums = cml_arrays_add(&tally->arrays, bins, sizeof *tally->batch_sums);
    tally->late.rows = cml_arrays_add(&tally->arrays, CML_NUM_BATCHES * bins, sizeof *tally->late.rows);
    if (trail_cells(grid))
        tally->stay = cml_arrays_add(&tally->arrays, trail_cells(grid), sizeof *tally->stay);
    if (tally->arrays.failed) {
        cml_tally_free(tally);
        return cml_fail_memory(err, cml_tally_bytes(grid), "a tally");
    }
    for (int i = 0; i < CML_NUM_ARRAYS; i++)
        if (tally->layout.size[i]) tally->array[i] = tally->cells + tally->layout.at[i];
    const cml_status status = cml_saved_part_create(&grid->saved, &tally->saved, err);
    if (status != CML_OK) cml_tally_free(tally);
    return status;
}

/* A pointer stays NULL if the owner lacks the array, too. */
void cml_tally_borrow(struct cml_tally *tally, const struct cml_tally *owner)
{
    for (int i = 0; i < CML_NUM_ARRAYS; i++) {
        if (tally->layout.size[i]) continue;
        tally->array[i] = owner->array[i];
        tally->layout.once[i] = owner->layout.once[i];
    }
}

/* Other threads score into borrowed arrays meanwhile. */
void cml_tally_zero(struct cml_tally *tally)
{
    memset(tally->cells, 0, tally->layout.cells * sizeof *tally->cells);
    memset(tally->balance, 0, sizeof tally->balance);
    memset(tally->count, 0, sizeof tally->count);
    tally->lost.count = 0;
    memset(tally->grouped, 0, grouped_bins(tally) * sizeof *tally->grouped);
    memset(tally->last_sums, 0, tally->profile.cells * sizeof *tally->last_sums);
    cml_tally_drop_late(tally);
}

void cml_tally_free(struct cml_tally *tally)
{
    cml_arrays_free(&tally->arrays);
    free(tally->saved);
    *tally = (struct cml_tally){0};
}

/* Keeping the smallest indices makes the list independent of the order in which threads and ranks report. */
void cml_lost_list_add(struct cml_lost_list *list, uint64_t index)
{
    int k = list->count;
    while (k > 0 && list->index[k - 1] > index) k--;
    if (k == CML_LOST_LISTED) return;
    if (list->count < CML_LOST_LISTED) list->count++;
    for (int i = list->count - 1; i > k; i--) list->index[i] = list->index[i - 1];
    list->index[k] = index;
}

void cml_lost_list_merge(struct cml_lost_list *to, const struct cml_lost_list *from)
{
    for (int i = 0; i < from->count; i++) cml_lost_list_add(to, from->index[i]);
}

static void add_cells(uint64_t *to, const uint64_t *from, size_t n)
{
    for (size_t i = 0; i < n; i++) to[i] += from[i];
}

/* The tallies may differ in A_z and in arrays that only one has, so each array is added by its own place. */
void cml_tally_move(struct cml_tally *to, struct cml_tally *from)
{
    const struct cml_layout *own = &from->layout;
    /* Arrays before A_rz have the same places in both tallies. */
    add_cells(to->cells, from->cells, own->A_rz);
    for (int i = 0; i < CML_NUM_ARRAYS; i++)
        if (own->size[i] && own->at[i] >= own->A_rz && own->at[i] < own->Rd_xya && i != CML_ARRAY_A_z)
            add_cells(to->array[i], from->array[i], cml_layout_cells(own, (enum cml_array)i));
    add_cells(to->cells + to->layout.Rd_xya, from->cells + own->Rd_xya, own->cells - own->Rd_xya);
    for (int i = 0; i < CML_NUM_BALANCE_TERMS; i++) to->balance[i] += from->balance[i];
    for (int i = 0; i < CML_NUM_COUNTS; i++) to->count[i] += from->count[i];
    cml_lost_list_merge(&to->lost, &from->lost);
    cml_tally_zero(from);
}

/* A batch's first late packet gets a new row. */
uint64_t *cml_tally_late(struct cml_tally *tally, int batch)
{
    struct cml_late *late = &tally->late;
    const int known = late->row_of[batch];
    if (known >= late->count || late->batch[known] != batch) {
        late->row_of[batch] = late->count;
        late->batch[late->count++] = batch;
    }
    return late->rows + (size_t)late->row_of[batch] * tally->profile.cells;
}

/* Rows are taken from the first one on, so memory of rows that are never needed is never touched. */
void cml_tally_drop_late(struct cml_tally *tally)
{
    const size_t cells = (size_t)tally->late.count * tally->profile.cells;
    memset(tally->late.rows, 0, cells * sizeof *tally->late.rows);
    tally->late.count = 0;
}

/* Adds the rows of a table to a row of sums. */
static void add_columns(const uint64_t *cells, size_t rows, size_t columns, uint64_t *restrict sums)
{
    for (size_t i = 0; i < rows; i++)
        for (size_t j = 0; j < columns; j++) sums[j] += cells[i * columns + j];
}

/* Adds each row of a matrix to its own sum: sums[i] grows by the sum of row i. */
static void add_rows(const uint64_t *cells, size_t rows, size_t columns, uint64_t *restrict sums)
{
    for (size_t i = 0; i < rows; i++)
        for (size_t j = 0; j < columns; j++) sums[i] += cells[i * columns + j];
}

/* Adds Rd_ra or Tt_ra to its profiles. A single column is added as one row, in vectors. */
static void add_exits(const uint64_t *cells, size_t rows, size_t na, uint64_t *by_r, uint64_t *by_a)
{
    if (na > 1) {
        add_rows(cells, rows, na, by_r);
        add_columns(cells, rows, na, by_a);
    } else {
        add_columns(cells, 1, rows, by_r);
        add_rows(cells, 1, rows, by_a);
    }
}

/* Computes the profiles of one group's cells, at their places behind the totals. */
static void sum_group(const struct cml_tally *tally, size_t group, uint64_t *bins)
{
    const struct cml_layout *at = &tally->profile;
    const size_t rows = (size_t)tally->grid.nr + 1, na = (size_t)tally->grid.na;
    const size_t first = group * rows * na;
    memset(bins, 0, bins_of_cells(tally) * sizeof *bins);
    add_exits(tally->Rd_ra + first, rows, na, bins, bins + at->Rd_a - at->Rd_r);
    add_exits(tally->Tt_ra + first, rows, na, bins + at->Tt_r - at->Rd_r, bins + at->Tt_a - at->Rd_r);
    if (tally->grid.absorption)
        add_columns(tally->A_rz + group * tally->layout.size[CML_ARRAY_A_rz], rows,
                    (size_t)tally->grid.nz + 2, bins + at->A_z - at->Rd_r);
}

/* Updates the profiles of the groups. Late packets add their rows to the profiles of their groups, whose
 * cells are too many to sum anew. The current batch's group is summed anew, or all groups if batch is -1. */
static void sum_groups(const struct cml_tally *tally, int batch)
{
    const int groups = cml_cell_groups(&tally->grid);
    const size_t first = tally->profile.Rd_r, cells = bins_of_cells(tally);
    for (int row = 0; row < tally->late.count; row++) {
        const int g = tally->late.batch[row] % groups;
        if (g == batch % groups) continue;
        add_columns(tally->late.rows + (size_t)row * tally->profile.cells + first, 1, cells,
                    tally->grouped + (size_t)g * cells);
    }
    for (int g = 0; g < groups; g++)
        if (batch < 0 || g == batch % groups) sum_group(tally, (size_t)g, tally->grouped + (size_t)g * cells);
}

/* Computes the totals and profiles of all that a tally has scored itself. */
static void sum_profiles(const struct cml_tally *tally, uint64_t *sums)
{
    const struct cml_layout *at = &tally->profile;
    memset(sums, 0, at->cells * sizeof *sums);
    for (int i = 0; i < CML_NUM_TOTALS; i++)
        sums[i] = tally->balance[cml_balance_term_of_total((enum cml_total)i)];
    add_columns(tally->grouped, (size_t)cml_cell_groups(&tally->grid), bins_of_cells(tally), sums + at->Rd_r);
    if (tally->grid.depths) memcpy(sums + at->A_z, tally->A_z, ((size_t)tally->grid.nz + 2) * sizeof *sums);
    /* Gates, detectors and expected values follow A_l both in the tally and in the sums. */
    memcpy(sums + at->A_l, tally->A_l, (at->cells - at->A_l) * sizeof *sums);
}

/* A tally goes on from batch to batch, and is summed anew each time, because its profiles are much shorter
 * than its grids. */
void cml_tally_sum_batch(struct cml_tally *tally, int batch)
{
    const size_t bins = tally->profile.cells;
    sum_groups(tally, batch);
    sum_profiles(tally, tally->batch_sums);
    for (size_t i = 0; i < bins; i++) {
        const uint64_t sum = tally->batch_sums[i];
        tally->batch_sums[i] = sum - tally->last_sums[i];
        tally->last_sums[i] = sum;
    }
    for (int row = 0; row < tally->late.count; row++)
        for (size_t i = 0; i < bins; i++) tally->batch_sums[i] -= tally->late.rows[(size_t)row * bins + i];
}
