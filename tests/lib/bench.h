/* One scene with its surfaces and options, the engines that simulate it, and the comparison of their
 * tallies.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "lib/require.h"

#include "engine/engine.h"
#include "input/mci.h"
#include "tally/result.h"

#include <string.h>

struct bench {
    struct cml_scene_list list; /* the first scene of the list is simulated */
    struct cml_surface_set surfaces;
    struct cml_engine_options options;
};

/* Returns options for one thread. Roulette begins at a higher weight than by default, so that it happens
 * with few photons. */
static inline struct cml_engine_options bench_options(uint64_t seed)
{
    return (struct cml_engine_options){.seed = seed,
                                       .threads = 1,
                                       .lattice = true,
                                       .roulette = {0.01, 0.03},
                                       .reentry = true,
                                       .absorption = true};
}

static inline void tear_down(struct bench *bench)
{
    cml_surfaces_free(&bench->surfaces);
    cml_scene_list_clear(&bench->list);
}

/* Opens an engine for the scene. The caller closes it with engine->close. */
static inline void *open_engine(const struct bench *bench, const struct cml_engine *engine)
{
    struct cml_error err;
    void *self = NULL;
    require_ok(engine->open(bench->list.scenes, &bench->surfaces, &bench->options, &self, &err), &err);
    return self;
}

static inline struct cml_tally empty_tally(const struct bench *bench)
{
    const struct cml_tally_grid grid = cml_engine_grid(bench->list.scenes, &bench->surfaces, &bench->options);
    struct cml_error err;
    struct cml_tally tally;
    require_ok(cml_tally_create(&grid, &tally, &err), &err);
    return tally;
}

/* Fails the test if two tallies differ. what: name of the pair in the message. */
static inline void expect_same(const struct cml_tally *a, const struct cml_tally *b, const char *what)
{
    if (memcmp(a->balance, b->balance, sizeof a->balance) != 0) fail_msg("%s: another weight balance", what);
    if (memcmp(a->count, b->count, sizeof a->count) != 0) fail_msg("%s: other counts", what);
    /* one block of memory holds all cells */
    if (memcmp(a->A_l, b->A_l, (size_t)cml_tally_bytes(&a->grid)) != 0) fail_msg("%s: other cells", what);
}

/* Checks the weight balance of a tally, through a result of one batch. */
static inline void assert_weight_balances(struct cml_tally *tally, uint64_t photons)
{
    struct cml_error err;
    struct cml_result result;
    require_ok(cml_result_create(&tally->grid, photons, &result, &err), &err);
    cml_tally_sum_batch(tally, 0);
    cml_result_add_batch(&result, 0, tally);
    cml_result_add(&result, tally);
    assert_true(cml_result_imbalance(&result) == 0);
    assert_true(result.summary.count[CML_COUNT_PHOTONS] == photons);
    assert_true(result.summary.balance[CML_BALANCE_LAUNCHED] == (cml_u128)photons << 31);
    assert_int_equal(cml_result_lost(&result), 0);
    cml_result_free(&result);
}
