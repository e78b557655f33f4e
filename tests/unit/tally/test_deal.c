/* Tests of dealing photons to several beams: whole numbers by largest remainder, every photon once. A run
 * that is extended flies the same photons as one long run. SPDX-License-Identifier: MIT */
#include "lib/dice.h"
#include "lib/require.h"

#include "tally/deal.h"

#include <stdlib.h>
#include <string.h>

enum { MOST = 6, SPAN = 4096 };

static void numbers_are_known(void **state)
{
    (void)state;
    static const struct {
        double share[4];
        int count;
        uint64_t photons, number[4];
    } cases[] = {
        {{1, 2, 3}, 3, 100003, {16667, 33334, 50002}},
        {{1, 1}, 2, 7, {4, 3}},
        {{1, 1, 1}, 3, 2, {1, 1, 0}},
        {{0.1, 0.7, 0.2}, 3, 10, {1, 7, 2}},
        {{3, 3, 1}, 3, 10, {4, 4, 2}},
        {{1, 1e-12}, 2, 1000000, {1000000, 0}},
    };
    struct cml_error err;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        uint64_t number[4] = {0};
        assert_int_equal(cml_deal_numbers(cases[i].share, cases[i].count, cases[i].photons, number, &err),
                         CML_OK);
        for (int k = 0; k < cases[i].count; k++) assert_int_equal(number[k], cases[i].number[k]);
    }
}

/* Flies a round. Marks each photon in seen[beam][index]; no photon may occur twice. */
static void fly(struct cml_deal *deal, uint64_t begin, uint64_t end, unsigned char seen[MOST][SPAN])
{
    struct cml_error err;
    assert_int_equal(cml_deal_round(deal, begin, end, &err), CML_OK);
    for (uint64_t place = 0; place < end - begin;) {
        const struct cml_piece piece = cml_deal_piece_at(deal, begin + place);
        assert_true(piece.count > 0 && place + piece.count <= end - begin);
        for (uint64_t i = 0; i < piece.count; i++) {
            const uint64_t index = piece.first + CML_NUM_BATCHES * i, beam = index >> CML_SOURCE_SHIFT,
                           number = index - (beam << CML_SOURCE_SHIFT);
            assert_true(beam < MOST && number < SPAN);
            assert_int_equal(number % CML_NUM_BATCHES, piece.batch);
            assert_int_equal(seen[beam][number]++, 0);
        }
        place += piece.count;
    }
}

/* A beam flies the first points of its lattice in each batch, without gaps. */
static void rounds_are_one_run(void **state)
{
    (void)state;
    static unsigned char whole[MOST][SPAN], parts[MOST][SPAN];
    struct dice dice = dice_new(7);
    struct cml_error err;
    for (int n = 0; n < 300; n++) {
        const int count = 1 + (int)(dice_word(&dice) % MOST);
        const uint64_t first = 1 + dice_word(&dice) % 1500, all = first + 700 + dice_word(&dice) % 800;
        double share[MOST];
        struct cml_deal deal;
        uint64_t number[MOST];
        for (int k = 0; k < count; k++) share[k] = 0.2 + dice_uniform(&dice);
        memset(whole, 0, sizeof whole);
        memset(parts, 0, sizeof parts);
        assert_int_equal(cml_deal_create(share, count, &deal, &err), CML_OK);
        fly(&deal, 0, all, whole);
        fly(&deal, 0, first, parts);
        fly(&deal, first, all, parts);
        assert_memory_equal(whole, parts, sizeof whole);
        assert_int_equal(cml_deal_numbers(share, count, all, number, &err), CML_OK);
        for (int k = 0; k < count; k++) {
            uint64_t flown = 0;
            for (int i = 0; i < SPAN; i++) {
                flown += whole[k][i];
                assert_int_equal(cml_deal_has(&deal, ((uint64_t)k << CML_SOURCE_SHIFT) + (uint64_t)i),
                                 whole[k][i]);
                if (i >= CML_NUM_BATCHES && whole[k][i]) assert_true(whole[k][i - CML_NUM_BATCHES]);
            }
            assert_int_equal(flown, number[k]);
        }
        cml_deal_clear(&deal);
    }
}

static void too_few_more_are_refused(void **state)
{
    (void)state;
    const double share[] = {1, 2, 3};
    struct cml_deal deal;
    struct cml_error err;
    assert_int_equal(cml_deal_create(share, 3, &deal, &err), CML_OK);
    assert_int_equal(cml_deal_round(&deal, 100003, 100006, &err), CML_E_INPUT);
    assert_non_null(strstr(err.text, "3 photons after 100003 (expected another number"));
    cml_deal_clear(&deal);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_known),
        cmocka_unit_test(rounds_are_one_run),
        cmocka_unit_test(too_few_more_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
