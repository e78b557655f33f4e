/* Comparison of the tallies that two walks of the same packets have left.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "flight.h"

#include "tally/row_cells.h"

static void expect_same_tally(const struct cml_tally *a, const struct cml_tally *b, const char *name)
{
    const size_t cells = cml_tally_cells(&a->grid);
    for (size_t i = 0; i < cells; i++)
        if (a->A_l[i] != b->A_l[i]) fail_msg("%s: cell %zu differs", name, i);
    for (int i = 0; i < CML_NUM_BALANCE_TERMS; i++)
        if (a->balance[i] != b->balance[i]) fail_msg("%s: term %d of the balance differs", name, i);
    for (int i = 0; i < CML_NUM_COUNTS; i++)
        if (i != CML_COUNT_QUERIES && a->count[i] != b->count[i]) fail_msg("%s: count %d differs", name, i);
}

/* Checks rule P17 in every batch: weight times score that ends equals the gains on the way, because packets
 * begin with a score of zero. */
static void expect_balanced_scores(const struct cml_tally *t)
{
    const struct cml_layout at = cml_layout_of(&t->grid, CML_OF_ROW_BINS);
    const size_t stride = cml_row_stride(&t->grid), media = cml_tally_media(&t->grid);
    for (int b = 0; b < CML_NUM_BATCHES; b++)
        for (int i = 0; i < t->grid.rows; i++) {
            const uint64_t *of = t->rows + cml_row_batch(&t->grid, b) + i;
            uint64_t ended = of[CML_BALANCE_REFLECTED * stride] + of[CML_BALANCE_TRANSMITTED * stride] +
                             of[CML_BALANCE_ROULETTE * stride] + of[CML_BALANCE_TRAPPED * stride] +
                             of[CML_BALANCE_LOST * stride] + of[CML_BALANCE_BACKING * stride] +
                             of[CML_BALANCE_FACE * stride];
            for (size_t m = 0; m < media; m++) ended += of[(at.A_l + m) * stride];
            assert_true(of[CML_BALANCE_GAINED * stride] == ended);
        }
}
