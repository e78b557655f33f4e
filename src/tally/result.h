/* Results: the sums over the tallies of a run, with standard errors. Cells have 128 bits, enough for 2^48
 * packets. A tally's cells beyond the grid are added to the outermost bins here (rule P7). Totals and 1D
 * profiles are kept separately for each batch of photons (balance.h). The spread over the batches gives
 * standard errors, so these depend on the seed only, not on threads, ranks or restarts.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "tally/tally.h"

/* The part of a result that does not grow with its grid. Checkpoints and ranks move it as a block of
 * bytes. */
struct cml_summary {
    cml_u128 balance[CML_NUM_BALANCE_TERMS]; /* terms of the weight balance, in units of weight */
    cml_u128 count[CML_NUM_COUNTS];
    struct cml_lost_list lost;
};

/* The sums of a run, and the arrays that hold them. Arrays have no cells beyond their axes; only maps and
 * volumes keep a cell for all outside. */
struct cml_result {
    struct cml_tally_grid grid;
    uint64_t photons; /* number of photons requested */
    cml_u128 *cells;  /* cells of all arrays */
    union {
        cml_u128 *array[CML_NUM_ARRAYS];
        struct { /* pointers to arrays by name; NULL: the array does not exist */
#define CML_POINTER(name, ...) cml_u128 *name;
            CML_ARRAYS(CML_POINTER)
#undef CML_POINTER
        };
    };
    struct cml_layout layout; /* places of arrays in `cells` */
    struct cml_summary summary;
    struct cml_saved *saved; /* packets saved one by one, or NULL */
};

/* The unit of expected values, relative to the unit of weight: 2^-48, so that a Tt of 1e-15 has digits.
 * Expected values are at most 1, so 2^48 packets fit. */
#define CML_EXPECTED_UNIT 0x1p-48
#define CML_EXPECTED_SHIFT 54 /* shift of a score whose exponent is 0: 48, and 6 for its unit */

/* Returns the size in bytes of a result with this grid. */
double cml_result_bytes(const struct cml_tally_grid *grid);

/* Makes a result of zeros for this number of photons, 1..2^48. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_result_create(const struct cml_tally_grid *grid, uint64_t photons,
                                           struct cml_result *result, struct cml_error *err);
void cml_result_free(struct cml_result *result);

/* Adds the sums of the last cml_tally_sum_batch to the totals and profiles of batch 0..63, and those of
 * late packets to their own batches. The tally has the grid of the result, or that of a thread. */
void cml_result_add_batch(struct cml_result *result, int batch, const struct cml_tally *tally);

/* Adds all of a tally except its totals and profiles. Borrowed arrays are left to the tally that owns
 * them. */
void cml_result_add(struct cml_result *result, const struct cml_tally *tally);

/* The source of an array's cells, with the cells beyond its axes: those of a tally (`narrow`), or those of a
 * row of a flight (`wide`), which lie `stride` apart and count `unit` units of weight each. */
struct cml_cell_source {
    const uint64_t *narrow;
    const cml_u128 *wide;
    size_t stride;
    cml_u128 unit;
};

/* Adds the cells of one array to one part (group or batch) of the result's array, if the result has it. Cells
 * beyond an axis go into the outermost bins and, for grids, into the balance as well. Times behind all gates
 * go into the next array. */
void cml_result_add_cells(struct cml_result *result, enum cml_array array, size_t part,
                          const struct cml_cell_source *from);

/* Returns all cells of a result as one block of *count cells, owned by the result. For code that moves or
 * stores results. */
cml_u128 *cml_result_cells(struct cml_result *result, size_t *count);

/* Adds `from` to `to`. The order of additions does not matter. */
void cml_summary_merge(struct cml_summary *to, const struct cml_summary *from);

/* Returns how many of the photons 0 to photons - 1 belong to batch 0..63. */
uint64_t cml_batch_size(uint64_t photons, int batch);

/* Returns a mean over the light of detector k, and its standard error by batches (a ratio of means). moment:
 * [64][n] sums by batch, of which number i counts. NaN if the detector has seen no light. */
double cml_result_mean(const struct cml_result *result, const cml_u128 *moment, int n, int i, int k,
                       double *error);

/* Returns the imbalance of the weight (rule P10) in units of weight: the first difference that is not 0, or 0
 * if there is none. These sums must be equal: launched + gained and all fates; A_l, A_rz, A_xyz and A_t and
 * the absorbed weight; Rd_ra, Rd_xya, Rd_dir and Rd_t and the reflected weight; Tt_ra, Tt_xya, Tt_dir and
 * Tt_t and the transmitted weight; Rsp_dir and the specular weight; the light that arrives at the facets and
 * the light that leaves them. Any difference is a fault of the program. */
double cml_result_imbalance(const struct cml_result *result);

/* Returns a term of the balance as a share of the launched weight. */
double cml_result_share(const struct cml_result *result, enum cml_balance_term term);

/* Return a total as a share of the launched weight, and its standard error (cml_result_bin_error). */
double cml_result_total(const struct cml_result *result, enum cml_total total);
double cml_result_error(const struct cml_result *result, enum cml_total total);

/* The totals whose errors judge a run: diffuse reflectance, absorption, transmittance. */
#define CML_NUM_GOALS 3
extern const enum cml_total cml_goals[CML_NUM_GOALS];

/* Return the absorption of a medium as a share of the launched weight, and its standard error. */
double cml_result_absorbed(const struct cml_result *result, int medium);
double cml_result_absorbed_error(const struct cml_result *result, int medium);

/* Returns standard error over total; INFINITY if either is 0, because nothing is known then. */
double cml_result_relative_error(const struct cml_result *result, enum cml_total total);

/* Returns the factor by which a run on the same machine would have to be longer to reach a relative standard
 * error in (0, 1). Assumes that errors fall with the square root of the photons. With evenly spread draws
 * (lattice.h) they may fall faster: longer runs then need less, shorter ones more. INFINITY if the total or
 * its error is 0. */
double cml_result_times_to(const struct cml_result *result, enum cml_total total, double error);

/* Return the sum of bin i of a profile [64][n] over its batches, in units of weight, and the standard error
 * of the weight per photon, as a share of a packet. The error comes from the spread of the batches (method of
 * batch means). For a single packet the error is NaN. */
double cml_result_bin_sum(const cml_u128 *profile, int n, int i);
double cml_result_bin_error(const struct cml_result *result, const cml_u128 *profile, int n, int i);

/* Return the sum of cell i of an array over its groups or batches, in units of weight, and its standard error
 * by batches, by groups, or from squares. The error is NaN if there is only one copy of the array. */
double cml_result_sum(const struct cml_result *result, enum cml_array array, size_t i);
double cml_result_sum_error(const struct cml_result *result, enum cml_array array, size_t i);

/* Return the sum over a cell's copies in `groups` groups, which lie `step` apart, and its standard error from
 * CML_NUM_GROUPS groups. cell: the first copy. */
double cml_result_cell_sum(const cml_u128 *cell, int groups, size_t step);
double cml_result_cell_error(const struct cml_result *result, const cml_u128 *cell, size_t step);

/* Computes the light seen by detector k, as a share of the launched weight, and its standard error. */
void cml_result_detected(const struct cml_result *result, int k, double *value, double *error);

/* Computes expected value number `score`, as a share of the launched weight, and its standard error. */
void cml_result_expected(const struct cml_result *result, int score, double *value, double *error);

/* Computes the expected absorption of a layer and its standard error; the counted absorption if the layer has
 * no score. */
void cml_result_expected_layer(const struct cml_result *result, int layer, double *value, double *error);

/* Returns the standard error, as a share of a packet, of a mean weight to which every packet adds at most
 * once. sum: in units of weight; squares: sum of squares in CML_SQUARE_UNIT^2. NaN for one packet. */
double cml_result_square_error(const struct cml_result *result, cml_u128 sum, cml_u128 squares);

/* Return the sum of `count` neighbouring cells over all groups, and its error, by groups if these are kept
 * apart, else from squares. A packet must add at most once to these cells together. */
double cml_result_once_sum(const cml_u128 *cells, size_t count, struct cml_once once);
double cml_result_once_error(const struct cml_result *result, const cml_u128 *cells, size_t count,
                             struct cml_once once);

uint64_t cml_result_lost(const struct cml_result *result); /* number of lost packets, of all causes */

/* Returns the number of interactions and boundary events of all packets, which the time per step refers
 * to. */
double cml_result_steps(const struct cml_result *result);
