/* Tallies: integer sums of weight and events over a range of photons. Sums of integers do not depend on their
 * order, so any number of threads, ranks and restarts gives the same bits. Weight is in units of 2^-31 of a
 * packet. A tally has 64 bits per cell and serves at most CML_TALLY_MAX_PHOTONS packets. Results (result.h)
 * collect tallies. SPDX-License-Identifier: MIT */
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
#define CML_WEIGHT_UNIT 4.656612873077393e-10 /* unit of weight as a share of a packet: 2^-31 */

#define CML_SQUARE_UNIT 1.52587890625e-5 /* unit of weights before they are squared (CML_SQUARE_SHIFT) */

/* A sorted list of the lost packets with the smallest indices. Each can be flown again alone (`clustermcml
 * trace`). */
#define CML_LOST_LISTED 8
struct cml_lost_list {
    int count;
    uint64_t index[CML_LOST_LISTED];
};

/* Late packets, and how totals and profiles reach a result. A thread scores the packets of one batch after
 * the other into one tally, which is not cleared in between. cml_tally_sum_batch finds the sums that a batch
 * has added:
 *
 *     Rd_ra, Tt_ra, A_rz --margins--> grouped --+
 *     A_l, Rd_t ... expected, balance ----------+--> sum now
 *                                                    - last_sums  the sum after the batch before
 *                                                    - late.rows  added by packets of earlier batches
 *                                                    = batch_sums added by the current batch
 *
 * - grouped: margins (Rd_r, Tt_r, Rd_a, Tt_a, A_z) of the grids of each group. Only those of the current
 *   batch's group are summed anew, because packets of the batch score into no other group; late packets add
 *   theirs.
 * - last_sums: becomes the sum now.
 * - late: packets that still fly while those of another batch are launched. Their additions to totals and
 *   profiles are noted here as well, in a row for each of their batches.
 *
 * The result adds `batch_sums` to the current batch, and each late row to the batch of the row
 * (cml_result_add_batch). cml_tally_drop_late empties the rows. Grids and maps are added once, at the end
 * of a range (cml_result_add). */
struct cml_late {
    int count;                  /* number of rows in use */
    int batch[CML_NUM_BATCHES]; /* batch of each row */
    /* Number of the row of each batch. An entry is valid only if it is below `count` and the row's batch
     * is this batch. */
    int row_of[CML_NUM_BATCHES];
    uint64_t *rows; /* [64][bins] sums of late packets; rows not in use are zero */
};

#define CML_TRAILS 64 /* number of packets that a thread has in flight */

/* The sums of one thread, or of several. Profiles and grids have extra cells beyond their bins
 * (array_table.h), which a result adds to the outermost bins: radial row nr, depth column 0 for z < 0, and
 * depth column nz + 1 for greater depths. */
struct cml_tally {
    struct cml_tally_grid grid;
    struct cml_arrays arrays; /* all memory that the tally owns, except saved */
    uint64_t *cells;          /* cells of its own arrays, A_l first */
    union {
        uint64_t *array[CML_NUM_ARRAYS];
        struct { /* pointers to arrays by name; NULL: neither owned nor borrowed */
#define CML_POINTER(name, ...) uint64_t *name;
            CML_ARRAYS(CML_POINTER)
#undef CML_POINTER
        };
    };
    struct cml_layout layout;  /* its own arrays in `cells`; `once` also those that it borrows */
    struct cml_layout profile; /* places of arrays among totals and profiles */
    struct cml_stay *stay;     /* [CML_TRAILS][cml_tally_media] scratch of walks (kernels/types.h), or NULL */
    struct cml_saved_part *saved; /* packets saved one by one, or NULL */
    uint64_t balance[CML_NUM_BALANCE_TERMS];
    uint64_t count[CML_NUM_COUNTS];
    struct cml_lost_list lost;
    /* The next members hold totals and profiles, with their places as in `profile`. */
    uint64_t *grouped;   /* [cml_cell_groups] profiles by group at the last cml_tally_sum_batch; private */
    uint64_t *last_sums; /* totals and profiles at the last cml_tally_sum_batch; private */
    /* Additions between the last two calls of cml_tally_sum_batch, without those of late packets. */
    uint64_t *batch_sums;
    struct cml_late late;
};

/* Returns the term of the balance that equals this total. */
enum cml_balance_term cml_balance_term_of_total(enum cml_total total);

/* Returns the number of cells of all arrays of a tally. */
size_t cml_tally_cells(const struct cml_tally_grid *grid);

/* Returns the size of a tally with this grid in bytes. Among profiles only those of detectors are counted,
 * because there may be many. */
double cml_tally_bytes(const struct cml_tally_grid *grid);

/* Makes a tally of zeros that owns its cells. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_tally_create(const struct cml_tally_grid *grid, struct cml_tally *tally,
                                          struct cml_error *err);

/* Largest arrays, in cells, that each thread has a copy of. cml_tally_grid_of_thread returns the grid of one
 * thread of several: without arrays that all threads share, with A_z instead of an A_rz beyond
 * CML_THREAD_CELLS, and without a phi_rz beyond CML_THREAD_FLUENCE. */
#define CML_THREAD_CELLS ((size_t)1 << 20)   /* 8 MiB: more than a core's own cache */
#define CML_THREAD_FLUENCE ((size_t)1 << 21) /* only the cells of one batch are in use at a time */
struct cml_tally_grid cml_tally_grid_of_thread(const struct cml_tally_grid *grid);

/* True if threads share one A_rz or one fluence array. */
bool cml_tally_grid_is_shared(const struct cml_tally_grid *grid);

/* Lets a thread's tally score into arrays that only `owner` has. Several tallies may do so at a time, so all
 * additions to shared arrays must be atomic. Additions to a shared A_rz also go into the thread's own A_z, so
 * that a batch of one thread can be told from those of others without waiting for them. */
void cml_tally_borrow(struct cml_tally *tally, const struct cml_tally *owner);

/* Sets all of the tally's own sums to zero; borrowed arrays stay. */
void cml_tally_zero(struct cml_tally *tally);
void cml_tally_free(struct cml_tally *tally);

/* Add an index, or a list, to a sorted list, which keeps the smallest indices when full. */
void cml_lost_list_add(struct cml_lost_list *list, uint64_t index);
void cml_lost_list_merge(struct cml_lost_list *to, const struct cml_lost_list *from);

/* Adds `from` to `to` and sets `from` to zero. Both have the same grid, or `from` has the grid of a thread;
 * arrays that it borrowed stay as they are. */
void cml_tally_move(struct cml_tally *to, struct cml_tally *from);

/* Returns the number of totals and bins of all profiles. */
size_t cml_tally_profile_bins(const struct cml_tally_grid *grid);

/* Returns the row for totals and profiles of late packets of batch 0..63. All additions to the row must also
 * go into the tally's arrays. Valid until cml_tally_drop_late. */
uint64_t *cml_tally_late(struct cml_tally *tally, int batch);

/* Empties the rows of late packets, when no packet is late or all rows have been subtracted
 * (cml_tally_sum_batch). */
void cml_tally_drop_late(struct cml_tally *tally);

/* Sets `batch_sums` to the tally's own additions to totals and profiles since the last call, or since the
 * tally was zero, without those in rows of late packets. All of them must belong to batch 0..63, or to any
 * batch if `batch` is -1. */
void cml_tally_sum_batch(struct cml_tally *tally, int batch);
