/* SPDX-License-Identifier: MIT */
#include "tally/tally.h"

#include "tally/tally_cells.h"

#include <stdlib.h>
#include <string.h>

/* A tally has cells of its own for what lies beyond the grid (P7), so that scoring needs no branch for it:
 * one more row of r, one more depth above and one below. */
static size_t tally_cells_A(const struct cml_grid *grid)
{
    return grid->absorption ? ((size_t)grid->nr + 1) * ((size_t)grid->nz + 2) : 0;
}

/* All of A_rz or nothing: half a grid would have to be looked up at every deposit. */
struct cml_grid cml_grid_of_thread(const struct cml_grid *grid)
{
    struct cml_grid small = *grid;
    small.nx = small.ny = small.map_na = 0;
    small.volume = false;
    small.facets = 0;
    if (tally_cells_A(grid) > CML_THREAD_CELLS) small.absorption = false;
    return small;
}

/* Angles have no cells beyond the grid: all directions are within it. */
static size_t tally_cells_ra(const struct cml_grid *grid)
{
    return ((size_t)grid->nr + 1) * (size_t)grid->na;
}

size_t cml_tally_cells(const struct cml_grid *grid)
{
    return tally_cells_A(grid) + 2 * tally_cells_ra(grid) + (size_t)grid->num_layers + 2 +
           cml_cells_maps(grid);
}

double cml_tally_bytes(const struct cml_grid *grid)
{
    return (double)cml_tally_cells(grid) * sizeof(uint64_t);
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
    CML_SET_MAPS(tally, cml_tally_maps(tally));
    return CML_OK;
}

/* Only what a thread has none of itself; NULL stays NULL where the owner has none either. */
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

/* Not what is borrowed: others score there meanwhile. */
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

/* Insertion into a short sorted list. Which packets are kept must not depend on the order in which threads
 * and ranks report them, so it is the smallest. */
void cml_lost_list_add(struct cml_lost_list *list, uint64_t index)
{
    int place = list->count;
    while (place > 0 && list->index[place - 1] > index) place--;
    if (place == CML_LOST_LISTED) return;
    if (list->count < CML_LOST_LISTED) list->count++;
    for (int i = list->count - 1; i > place; i--) list->index[i] = list->index[i - 1];
    list->index[place] = index;
}

void cml_lost_list_merge(struct cml_lost_list *to, const struct cml_lost_list *from)
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

/* Parts of the block of cells have equal sizes whatever arrays lie there. Part 0 takes the few sums that
 * are not in it. */
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
    cml_lost_list_merge(&to->lost, &from->lost);
    from->lost.count = 0;
}
