/* Results: what the tallies of a run add up to, with standard errors.
 * 128 bits a cell, for up to 2^48 packets. What a tally has in cells beyond the grid is added to the last and
 * first bins here (P7). Totals and 1D profiles are kept apart for each batch of photons (balance.h): the
 * spread of the batches gives their standard errors, which therefore depend on the seed only, not on threads,
 * ranks or restarts.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "tally/tally.h"

/* The part of a result that does not grow with its grid. Checkpoints and ranks move it as it stands. */
struct cml_summary {
    cml_u128 balance[CML_NUM_BALANCE_TERMS]; /* units of weight */
    cml_u128 count[CML_NUM_COUNTS];
    struct cml_lost_list lost;
};

/* Arrays have no cells beyond their axes but for those of maps and volume. */
struct cml_result {
    struct cml_tally_grid grid;
    uint64_t photons; /* asked for */
    cml_u128 *cells;  /* of all arrays */
    union {
        cml_u128 *array[CML_NUM_ARRAYS];
        struct { /* NULL: it has none */
#define CML_POINTER(name, ...) cml_u128 *name;
            CML_ARRAYS(CML_POINTER)
#undef CML_POINTER
        };
    };
    struct cml_layout layout; /* of arrays in `cells` */
    struct cml_summary summary;
    struct cml_saved *saved; /* packets one by one, or NULL */
};

/* The unit of expected values in one of weight: 2^-48, so that a Tt of 1e-15 has digits. As no expectation is
 * above 1, 2^48 packets fit. */
#define CML_EXPECTED_UNIT 0x1p-48
#define CML_EXPECTED_SHIFT 54 /* of a score whose exponent is 0: 48, and 6 of its unit */

/* Bytes that a result of this grid takes. */
double cml_result_bytes(const struct cml_tally_grid *grid);

/* A zero result for this number of photons, 1..2^48. CML_E_INPUT when memory runs out. */
CML_NODISCARD cml_status cml_result_create(const struct cml_tally_grid *grid, uint64_t photons,
                                           struct cml_result *result, struct cml_error *err);
void cml_result_free(struct cml_result *result);

/* Adds what the last cml_tally_bring found to the totals and profiles of a batch, 0..63, which it belongs to,
 * and what late packets have brought to those of theirs. The tally has the grid of the result, or that of a
 * thread. */
void cml_result_add_brought(struct cml_result *result, int batch, const struct cml_tally *tally);

/* Adds all but the totals and profiles of a tally; what it borrowed is for its owner to add. */
void cml_result_add(struct cml_result *result, const struct cml_tally *tally);

/* Where cells of an array with its cells beyond the axes come from: a tally's (`narrow`), or a row's of a
 * flight (`wide`), which are `stride` apart, and so many units of weight each. */
struct cml_cell_source {
    const uint64_t *narrow;
    const cml_u128 *wide;
    size_t stride;
    cml_u128 unit;
};

/* Adds the cells of one array to part number `part` of that of a result, if it has one: what lies beyond an
 * axis goes into the outermost bins, and into the books where it is of a grid. What is later than all gates
 * goes into the array behind. */
void cml_result_add_cells(struct cml_result *result, enum cml_array array, size_t part,
                          const struct cml_cell_source *from);

/* All cells of a result as one block, for those who move or store it: *count of them, owned by the result. */
cml_u128 *cml_result_cells(struct cml_result *result, size_t *count);

/* to += from; any order gives the same. */
void cml_summary_merge(struct cml_summary *to, const struct cml_summary *from);

/* Photons 0 to photons - 1 that belong to a batch, 0..63. */
uint64_t cml_batch_size(uint64_t photons, int batch);

/* Number i of a moment of n per batch over the sum of detector k, and its standard error by batches (a ratio
 * of means); NaN where the detector has seen nothing. */
double cml_result_mean(const struct cml_result *result, const cml_u128 *moment, int n, int i, int k,
                       double *error);

/* By how much the weight does not balance (P10), units of weight: launched + gained minus everything that
 * came of it; then the sums of A_l, A_rz, A_xyz and A_t minus the absorbed weight, those of Rd_ra, Rd_xya,
 * Rd_dir and Rd_t minus the reflected, those of Tt_ra, Tt_xya, Tt_dir and Tt_t minus the transmitted, that of
 * Rsp_dir minus the specular, and what arrives at the facets minus what leaves them. The first difference
 * that is not 0, else 0; a fault of the program where it is not 0. */
double cml_result_imbalance(const struct cml_result *result);

/* A term of the balance as a share of the launched weight. */
double cml_result_share(const struct cml_result *result, enum cml_balance_term term);

/* A total as a share of the launched weight, and its standard error, as that of a bin below. */
double cml_result_total(const struct cml_result *result, enum cml_total total);
double cml_result_error(const struct cml_result *result, enum cml_total total);

/* The totals whose errors a run is judged by: what is diffusely reflected, absorbed, transmitted. */
#define CML_NUM_GOALS 3
extern const enum cml_total cml_goals[CML_NUM_GOALS];

/* What a medium absorbs, as a share of the launched weight, and its standard error likewise. */
double cml_result_absorbed(const struct cml_result *result, int medium);
double cml_result_absorbed_error(const struct cml_result *result, int medium);

/* Standard error over total; INFINITY where one of them is 0, as nothing is known then. */
double cml_result_relative_error(const struct cml_result *result, enum cml_total total);

/* What a run would have to last, in units of this run's time, for a relative standard error in (0, 1), on the
 * same machine, if errors fall with the root of the photons; INFINITY as above. With evenly spread draws
 * (lattice.h) they may fall faster: longer runs then take less, shorter ones more. */
double cml_result_times_to(const struct cml_result *result, enum cml_total total, double error);

/* Bin i of a profile [64][n]: the sum over its batches, units of weight; and the standard error of the weight
 * per photon, as a share of a packet, from the spread of the batches (method of batch means). One packet
 * alone has none: NaN. */
double cml_result_bin_sum(const cml_u128 *profile, int n, int i);
double cml_result_bin_error(const struct cml_result *result, const cml_u128 *profile, int n, int i);

/* Cell i of an array: the sum over its groups or batches, units of weight; and its standard error, as that of
 * a bin, by batches or groups or from squares. NaN where there is but one array. */
double cml_result_sum(const struct cml_result *result, enum cml_array array, size_t i);
double cml_result_sum_error(const struct cml_result *result, enum cml_array array, size_t i);

/* A cell that each group of photons has, `step` apart, of which this is the first: the sum of so many of
 * them; and the error by CML_NUM_GROUPS. */
double cml_result_cell_sum(const cml_u128 *cell, int groups, size_t step);
double cml_result_cell_error(const struct cml_result *result, const cml_u128 *cell, size_t step);

/* What detector k has seen, as a share of the launched weight, and its standard error. */
void cml_result_detected(const struct cml_result *result, int k, double *value, double *error);

/* Expected value number `score`, as a share of the launched weight, and its standard error. */
void cml_result_expected(const struct cml_result *result, int score, double *value, double *error);

/* What a layer absorbs, expected and its standard error: as counted where the layer has no score. */
void cml_result_expected_layer(const struct cml_result *result, int layer, double *value, double *error);

/* Standard error, as a share of a packet, of a mean weight that every packet adds to at most once, from its
 * sum in units of weight and the sum of its squares in CML_SQUARE_UNIT^2. NaN for one packet. */
double cml_result_square_error(const struct cml_result *result, cml_u128 sum, cml_u128 squares);

/* The sum of `count` neighbouring cells to which together a packet adds at most once, of all groups, and its
 * error: by groups where these are kept apart, else from squares. */
double cml_result_once_sum(const cml_u128 *cells, size_t count, struct cml_once once);
double cml_result_once_error(const struct cml_result *result, const cml_u128 *cells, size_t count,
                             struct cml_once once);

uint64_t cml_result_lost(const struct cml_result *result); /* packets, all causes */

/* Interactions and boundary events of all packets: what the time per step counts. */
double cml_result_steps(const struct cml_result *result);
