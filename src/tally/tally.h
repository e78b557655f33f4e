/* Tallies: integer sums of weight and events over a range of photon indices.
 * Integers, so that the order of summation cannot show: any number of threads, ranks and restarts gives the
 * same bits. Weight is in units of 2^-31 of a packet. A tally has 64 bits a cell and serves at most
 * CML_TALLY_MAX_PHOTONS packets; results (result.h) collect tallies.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/array.h"
#include "tally/array_table.h"
#include "tally/saved.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

__extension__ typedef unsigned __int128 cml_u128;
__extension__ typedef __int128 cml_i128;

#define CML_TALLY_MAX_PHOTONS ((uint64_t)1 << 30)
#define CML_WEIGHT_UNIT 4.656612873077393e-10 /* one unit of weight as a share of a packet: 2^-31 */

#define CML_SQUARE_UNIT 1.52587890625e-5 /* that of weights before they are squared (CML_SQUARE_SHIFT) */

/* The packets lost with the smallest indices, in order: each can be flown again alone (`clustermcml trace`).
 */
#define CML_LOST_LISTED 8
struct cml_lost_list {
    int count;
    uint64_t index[CML_LOST_LISTED];
};

/* How totals and profiles reach a result. A thread scores packets of one batch after the other into one
 * tally, which is not cleared in between. `bring` finds what a batch has added:
 *
 *     Rd_ra, Tt_ra, A_rz --margins--> grouped --+
 *     A_l, Rd_t ... expected, balance ----------+--> sum now
 *                                                    - summed     what was there at the last bring
 *                                                    - late.rows  what packets of earlier batches have added
 *                                                    = brought    of the batch under way
 *
 * - grouped: margins (Rd_r, Tt_r, Rd_a, Tt_a, A_z) of the grids of each group. Only those of the batch's own
 *   group are summed anew, since packets of the batch score into no other; late packets add theirs.
 * - summed: becomes the sum now.
 * - late: packets that fly on while those of another batch are launched. What they add to totals and profiles
 *   is noted here as well, in a row for each of their batches.
 *
 * The result adds `brought` to the batch under way and each late row to the batch of that
 * (cml_result_add_brought); cml_tally_drop_late empties the rows. Grids and maps are added once, at the end
 * of a range (cml_result_add). */
struct cml_late {
    int count;                   /* of rows in use */
    int batch[CML_NUM_BATCHES];  /* of a row */
    int row_of[CML_NUM_BATCHES]; /* of a batch, where row_of < count and batch[row_of] is that batch */
    uint64_t *rows;              /* [64][bins], those not in use zero */
};

#define CML_TRAILS 64 /* packets that a thread has in flight */

/* The sums of one thread, or of several. Profiles and grids have cells of their own for what lies beyond them
 * (array_table.h), which a result adds to the last and first bins: radial row nr, depth column 0 for z < 0
 * and nz + 1 for what lies too deep. */
struct cml_tally {
    struct cml_tally_grid grid;
    struct cml_arrays arrays; /* all that it owns but saved */
    uint64_t *cells;          /* of its own arrays, A_l the first */
    union {
        uint64_t *array[CML_NUM_ARRAYS];
        struct { /* NULL: it has none, nor borrows one */
#define CML_POINTER(name, ...) uint64_t *name;
            CML_ARRAYS(CML_POINTER)
#undef CML_POINTER
        };
    };
    struct cml_layout layout;  /* of its own arrays in `cells`; `once` also of those that it borrows */
    struct cml_layout profile; /* of what it brings */
    struct cml_stay *stay;     /* [CML_TRAILS][cml_tally_media] scratch of walks (kernels/types.h); or NULL */
    struct cml_saved_part *saved; /* packets one by one; or NULL */
    uint64_t balance[CML_NUM_BALANCE_TERMS];
    uint64_t count[CML_NUM_COUNTS];
    struct cml_lost_list lost;
    /* Totals and profiles (`profile`) */
    uint64_t *grouped; /* [cml_cell_groups] profiles, of cells, at the last cml_tally_bring; private */
    uint64_t *summed;  /* of all that was there then; private */
    uint64_t *brought; /* of what had come since the one before, but for late packets */
    struct cml_late late;
};

/* The term of the balance that is this total. */
enum cml_balance_term cml_balance_term_of_total(enum cml_total total);

/* Cells of all its arrays. */
size_t cml_tally_cells(const struct cml_tally_grid *grid);

/* Bytes that a tally of this grid takes; of profiles those of detectors count, which may be many. */
double cml_tally_bytes(const struct cml_tally_grid *grid);

/* All cells zero, owned by the tally. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_tally_create(const struct cml_tally_grid *grid, struct cml_tally *tally,
                                          struct cml_error *err);

/* The grid of one thread of several: without arrays that all threads share, with A_z instead of an A_rz
 * beyond CML_THREAD_CELLS, and without a phi_rz beyond CML_THREAD_FLUENCE. Those are too large for a copy per
 * thread, so threads share one. */
#define CML_THREAD_CELLS ((size_t)1 << 20)   /* 8 MiB: more than a core's own cache */
#define CML_THREAD_FLUENCE ((size_t)1 << 21) /* of which those of one batch are in use at a time */
struct cml_tally_grid cml_tally_grid_of_thread(const struct cml_tally_grid *grid);

/* Whether threads score into an A_rz or a phi of none of them. */
bool cml_tally_grid_is_shared(const struct cml_tally_grid *grid);

/* A tally of a grid of one thread scores into what else `owner` has from now on. Several may do so at a time:
 * all their additions to what they share must be atomic. What they add to a shared A_rz they add to their own
 * A_z as well: so a batch of one thread can be told from those of others without waiting for them. */
void cml_tally_borrow(struct cml_tally *tally, const struct cml_tally *owner);

/* Makes all that the tally has itself zero; what it borrowed stays. */
void cml_tally_zero(struct cml_tally *tally);
void cml_tally_free(struct cml_tally *tally);

/* Keeps the list sorted and, when it is full, the smallest. */
void cml_lost_list_add(struct cml_lost_list *list, uint64_t index);
void cml_lost_list_merge(struct cml_lost_list *to, const struct cml_lost_list *from);

/* to += from, and from = 0. Same grid, or `from` has the grid of a thread, and what it borrowed stays as it
 * is.
 */
void cml_tally_move(struct cml_tally *to, struct cml_tally *from);

/* Totals and bins of all profiles together. */
size_t cml_tally_profile_bins(const struct cml_tally_grid *grid);

/* The row for the totals and profiles of late packets of a batch, 0..63: what is added to it must be in the
 * tally's arrays, too. Good until cml_tally_drop_late. */
uint64_t *cml_tally_late(struct cml_tally *tally, int batch);

/* No packet is late any more, or all rows have been brought (cml_tally_bring). */
void cml_tally_drop_late(struct cml_tally *tally);

/* Sets `brought` to the totals and profiles of all that the tally itself has got since the last call, or
 * since it was zero, without what is in rows of late packets. All of it is of this batch, 0..63, or of any
 * where batch is -1. */
void cml_tally_bring(struct cml_tally *tally, int batch);
