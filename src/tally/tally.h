/* Tallies: integer sums of weight and events over a range of photon indices.
 * Integers, so that the order of summation cannot show: any number of threads, ranks and restarts gives the
 * same bits. Weight is in units of 2^-31 of a packet. A tally has 64 bits a cell and serves at most
 * CML_TALLY_MAX_PHOTONS packets; results (result.h) collect tallies.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "balance.h"
#include "boundary.h"
#include "base/array.h"
#include "tally/saved.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

__extension__ typedef unsigned __int128 cml_u128;
__extension__ typedef __int128 cml_i128;

#define CML_TALLY_MAX_PHOTONS ((uint64_t)1 << 30)
#define CML_WEIGHT_UNIT 4.656612873077393e-10 /* one unit of weight as a share of a packet: 2^-31 */

struct cml_tally_grid {
    int nr, nz, na;
    int num_layers, num_bodies;
    bool absorption;               /* A_rz is tallied; false: its cells do not exist */
    bool depths;                   /* A_z is tallied, of a thread that scores into an A_rz of others */
    bool cell_errors;              /* each group of photons has an A_rz, an Rd_ra and a Tt_ra of its own */
    size_t voxel_step, facet_step; /* the same of A_xyz, and of facets: cells from those of a group to those
                                    * of the next; 0: groups share them */
    struct cml_once map_once, pixel_once, direction_once; /* of Rd_xya and Tt_xya, of detectors that are maps,
                                                           * of Rd_dir to Rsp_dir */
    int gates; /* of Rd_t, Tt_t and, with either of those, A_t; 0: they do not exist */
    /* What is tallied only when asked for; 0 and false: it does not exist. Maps have nx * ny pixels and one
     * more for whatever lies outside, so that their sums are the totals. */
    int nx, ny;             /* pixels of Rd_xya, Tt_xya and of a layer of A_xyz */
    int map_na;             /* angle bins of a pixel: na or 1 */
    bool volume;            /* A_xyz, nz deep */
    bool phi_volume;        /* phi_xyz, nz deep */
    double marks;           /* fluence is tallied, by marks so far apart on paths, cm (P14); 0: it is not */
    int nt, np;             /* bins of Rd_dir, Tt_dir and Rsp_dir */
    int detectors;          /* what each has seen, by gates, and means over that */
    double path_unit;       /* of what is summed of lengths and depths, cm */
    double path_top;        /* depth from which depths count, cm */
    size_t detector_pixels; /* of all of them that are maps */
    struct cml_saved_kind saved;
    size_t facets;       /* of all boundaries and bodies */
    int rows;            /* of a sweep, that come of one flight; or scores */
    bool derivatives;    /* they are scores */
    bool row_depths;     /* they have A_z and A_rz, by samples: these do not add up to A to the last bit */
    bool row_times;      /* they, or the row whose result it is, have A_t, where there are gates */
    bool row_means;      /* they have means of detectors */
    size_t row_cells;    /* of all of them together (row_cells.h) */
    bool backed;         /* some of them lie on a backing, which keeps what does not leave them */
    int scores;          /* of expected values below the last shape (P15); 0: they do not exist */
    const int *exponent; /* [scores]: in a tally they count in 2^-31 2^6 2^-exponent. Borrowed */
};

/* Whether there is A_t beside Rd_t and Tt_t. Rows of a flight have theirs in row_cells.h. */
static inline bool cml_tally_has_A_t(const struct cml_tally_grid *grid)
{
    return grid->absorption || grid->depths || (grid->row_times && !grid->rows);
}

/* Media of a grid: layers, the two outer ones, bodies. */
static inline size_t cml_tally_media(const struct cml_tally_grid *grid)
{
    return (size_t)grid->num_layers + 2 + (size_t)grid->num_bodies;
}

#define CML_SQUARE_UNIT 1.52587890625e-5 /* that of weights before they are squared (CML_SQUARE_SHIFT) */

/* The packets lost with the smallest indices, in order: each can be flown again alone (`clustermcml trace`).
 */
#define CML_LOST_LISTED 8
struct cml_lost_list {
    int count;
    uint64_t index[CML_LOST_LISTED];
};

/* Late packets fly on while those of another batch are launched, into the same tally. What they bring to
 * totals and profiles is kept here as well, in a row for each of their batches: so the rest, which is of the
 * batch under way, can be told from it. */
struct cml_late {
    int count;                   /* of rows in use */
    int batch[CML_NUM_BATCHES];  /* of a row */
    int row_of[CML_NUM_BATCHES]; /* of a batch, where row_of < count and batch[row_of] is that batch */
    uint64_t *rows;              /* [64][bins], those not in use zero */
};

/* A weight of 31 bits times a number of 48 in three parts of 27 bits, the lowest first, so that 2^30 of them
 * fit into 64 bits each. */
#define CML_MOMENT_CELLS 3
#define CML_MOMENT_BITS 27
#define CML_MOMENT_MOST 281474976710656.0 /* 2^48 */

/* The number of moments of a detector (struct cml_profile_offsets). */
static inline size_t cml_tally_moments(const struct cml_tally_grid *grid)
{
    return 2 * cml_tally_media(grid) + 1;
}

#define CML_TRAILS 64 /* packets that a thread has in flight */

/* The sums of one thread, or of several. Profiles and grids have cells of their own for what lies beyond them
 * (P7), which a result adds to the last and first bins: radial row nr, depth column 0 for z < 0 and nz + 1
 * for what lies too deep. */
struct cml_tally {
    struct cml_tally_grid grid;
    struct cml_arrays arrays;    /* all that it owns but saved */
    uint64_t *A_rz;              /* [cml_cell_groups][nr + 1][nz + 2] or NULL */
    uint64_t *rows;              /* row_cells.h; or NULL */
    uint64_t *A_z;               /* [nz + 2] or NULL: what this tally alone has scored into an A_rz that it
                                  * shares, over all radii */
    uint64_t *Rd_ra, *Tt_ra;     /* [cml_cell_groups][nr + 1][na] */
    uint64_t *A_l;               /* [cml_tally_media] by medium */
    uint64_t *expected;          /* [scores] or NULL */
    uint64_t *Rd_t, *Tt_t, *A_t; /* [gates + 1], the last for all that is later; or NULL */
    uint64_t *phi; /* [64][nr + 1][nz + 2] by batch, weight of the marks in a cell (P14); or NULL */
    uint64_t *Rd_xya, *Tt_xya; /* [ny nx + 1][map_na], the last pixel for what lies outside, one behind the
                                * other, of every group or with squares (map_once); or NULL */
    uint64_t *A_xyz;           /* [groups][nz ny nx + 1] or NULL */
    uint64_t *phi_xyz;         /* [nz ny nx][CML_NUM_GROUPS], by index, as phi; or NULL */
    uint64_t *Rd_dir, *Tt_dir, *Rsp_dir; /* [nt][np], one behind the other, likewise; or NULL */
    uint64_t *detected;    /* sums, gates and moments of detectors, as profiles have them; or NULL */
    double *trail_length;  /* [CML_TRAILS][cml_tally_media] scratch of walks (kernels/types.h); or NULL */
    uint32_t *trail_count; /* the same */
    struct cml_saved_part *saved; /* packets one by one; or NULL */
    uint64_t *detector_map;       /* [detector_pixels], likewise; or NULL */
    uint64_t *facets;             /* [groups][facets][CML_FACET_SCORES] or NULL; what escapes is in the first
                                   * group */
    uint64_t balance[CML_NUM_BALANCE_TERMS];
    uint64_t count[CML_NUM_COUNTS];
    struct cml_lost_list lost;
    /* Totals and profiles (struct cml_profile_offsets) */
    uint64_t *grouped; /* [cml_cell_groups] profiles, of cells, at the last cml_tally_bring; private */
    uint64_t *summed;  /* of all that was there then; private */
    uint64_t *brought; /* of what had come since the one before, but for late packets */
    struct cml_late late;
};

/* The term of the balance that is this total. */
enum cml_balance_term cml_balance_term_of_total(enum cml_total total);

/* Cells of a tally's arrays, A_l, Rd_t, Tt_t, A_t, detected, expected, Rd_ra, Tt_ra, rows, A_rz or A_z, phi,
 * and the maps in this order, which lie in one block from A_l on. */
size_t cml_tally_cells(const struct cml_tally_grid *grid);

/* Bytes that a tally of this grid takes; of profiles those of detectors count, which may be many. */
double cml_tally_bytes(const struct cml_tally_grid *grid);

/* All cells zero, owned by the tally. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_tally_create(const struct cml_tally_grid *grid, struct cml_tally *tally,
                                          struct cml_error *err);

/* Arrays with at most so many cells are kept by group, from whose spread their errors come: a thread's A_rz,
 * Rd_ra and Tt_ra are then its own, too (CML_THREAD_CELLS). Cells of rows that come of one flight count. Of
 * larger arrays those to whose cells a packet adds at most once have squares, and all others no errors. */
#define CML_CELLS_WITH_ERRORS 65536
#define CML_FACETS_WITH_ERRORS 16384

/* What escapes from facets. */
static inline struct cml_once cml_facet_once(const struct cml_tally_grid *grid)
{
    return (struct cml_once){grid->facet_step, CML_FACET_ESCAPED_SQUARES - CML_FACET_ESCAPED};
}

/* How many A_rz there are, one behind the other, and how many cells each has; so it is with Rd_ra and Tt_ra.
 */
static inline size_t cml_groups_of(size_t step)
{
    return step ? CML_NUM_GROUPS : 1;
}
static inline int cml_cell_groups(const struct cml_tally_grid *grid)
{
    return grid->cell_errors ? CML_NUM_GROUPS : 1;
}
static inline size_t cml_rz_cells(const struct cml_tally_grid *grid)
{
    return ((size_t)grid->nr + 1) * ((size_t)grid->nz + 2);
}
static inline size_t cml_ra_cells(const struct cml_tally_grid *grid)
{
    return ((size_t)grid->nr + 1) * (size_t)grid->na;
}

/* The depth bin, of nz, that has what is in a cell by depth, 0 to nz + 1: the first and the last one have
 * what lies beyond. */
static inline size_t cml_depth_of_cell(size_t cell, size_t nz)
{
    return cell == 0 ? 0 : (cell <= nz ? cell - 1 : nz - 1);
}

/* The grid of one thread of several: without maps, volume and facets, with A_z instead of an A_rz beyond
 * CML_THREAD_CELLS, and without a phi beyond CML_THREAD_FLUENCE. Those are too large for a copy per thread,
 * so threads share one. */
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

/* Where totals [CML_NUM_TOTALS] and profiles begin that lie one behind the other, with the bins beyond the
 * grid: Rd_r and Tt_r [nr + 1], Rd_a and Tt_a [na], A_z [nz + 2] unless there is no A_rz, A_l
 * [cml_tally_media], and where there are gates Rd_t, Tt_t and, with A_z, A_t [gates + 1]; then of every
 * detector its sum, its gates [gates + 1], and moments: sums of weight times length by medium, weight times
 * interactions by medium, and weight times largest depth, each in CML_MOMENT_CELLS cells;
 * expected [scores]. */
struct cml_profile_offsets {
    size_t Rd_r, Tt_r, Rd_a, Tt_a, A_z, A_l, Rd_t, Tt_t, A_t; /* totals begin at 0 */
    size_t detector, detector_t, moments, expected, bins;     /* bins: of all */
};
struct cml_profile_offsets cml_tally_profiles(const struct cml_tally_grid *grid);

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
