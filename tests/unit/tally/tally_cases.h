/* Helpers of the tests of tallies and results: small grids, and packets scored into them.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "lib/dice.h"
#include "tally/result.h"

#include <math.h>

static const struct cml_tally_grid grid = {.nr = 3, .nz = 4, .na = 2, .num_layers = 2, .absorption = true};

/* A grid with maps: two pixels and the one outside, eight voxels and the one outside, their fluence, and
 * two facets. */
static const struct cml_tally_grid map_grid = {.nr = 3,
                                               .nz = 4,
                                               .na = 2,
                                               .num_layers = 2,
                                               .absorption = true,
                                               .nx = 2,
                                               .ny = 1,
                                               .map_na = 2,
                                               .volume = true,
                                               .phi_volume = true,
                                               .facets = 2};

static inline struct cml_tally make_tally(const struct cml_tally_grid *of)
{
    struct cml_tally tally;
    struct cml_error err;
    assert_int_equal(cml_tally_create(of, &tally, &err), CML_OK);
    return tally;
}

static inline struct cml_result make_result(const struct cml_tally_grid *of, uint64_t photons)
{
    struct cml_result result;
    struct cml_error err;
    assert_int_equal(cml_result_create(of, photons, &result, &err), CML_OK);
    return result;
}

/* Scores one packet of weight 2^31: half is absorbed in cell (r, z), half leaves in cell (r, a), up or
 * down. */
static inline void score(struct cml_tally *tally, int r, int a, int z, bool up)
{
    const uint64_t half = (uint64_t)1 << 30;
    (up ? tally->Rd_ra : tally->Tt_ra)[r * tally->grid.na + a] += half;
    if (tally->A_rz) tally->A_rz[r * (tally->grid.nz + 2) + z + 1] += half;
    tally->A_l[1] += half;
    tally->balance[CML_BALANCE_LAUNCHED] += 2 * half;
    tally->balance[up ? CML_BALANCE_REFLECTED : CML_BALANCE_TRANSMITTED] += half;
    tally->balance[CML_BALANCE_ABSORBED] += half;
    tally->count[CML_COUNT_PHOTONS]++;
}

static inline void score_at_random(struct dice *dice, struct cml_tally *tally, int packets)
{
    for (int n = 0; n < packets; n++)
        score(tally, dice_below(dice, grid.nr), dice_below(dice, grid.na), dice_below(dice, grid.nz),
              dice_below(dice, 2));
}

/* Adds the whole tally to a batch of the result, including what was noted of the tally before. */
static inline void add_to_batch(struct cml_result *result, int batch, struct cml_tally *tally)
{
    memset(tally->last_sums, 0, cml_tally_profile_bins(&tally->grid) * sizeof *tally->last_sums);
    cml_tally_sum_batch(tally, batch);
    cml_result_add_batch(result, batch, tally);
    cml_result_add(result, tally);
}
