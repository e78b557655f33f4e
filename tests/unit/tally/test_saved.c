/* Tests of saved packets: which rows are kept within a limit, their order, and merging of buffers.
 * SPDX-License-Identifier: MIT */
#include "tally/saved.h"
#include "lib/dice.h"

#include <stdlib.h>

static struct cml_error err;

enum { FOUND = 9000, MEDIA = 3 };

static void take(void *context, const void *rows, size_t count)
{
    cml_saved_add(context, rows, count);
}

/* Returns the photon index of row i, of beam i mod beams. Every third index of a beam is used. */
static uint64_t index_of(int i, int beams)
{
    return ((uint64_t)(i % beams) << CML_SOURCE_SHIFT) + 3 * (uint64_t)(i / beams);
}

/* Returns saved packets with every third index of each beam. Several threads find them in any order, each
 * with a buffer of its own. */
static struct cml_saved *saved_of_beams(uint32_t seed, uint64_t limit, int beams)
{
    enum { PARTS = 3 };
    const struct cml_saved_kind kind = {.limit = limit, .media = MEDIA, .beams = (uint64_t)beams};
    struct cml_saved *saved;
    struct cml_saved_part *part[PARTS];
    struct dice dice = dice_new(seed);
    int order[FOUND];
    assert_int_equal(cml_saved_create(&kind, &saved, &err), CML_OK);
    for (int i = 0; i < PARTS; i++) {
        assert_int_equal(cml_saved_part_create(&kind, &part[i], &err), CML_OK);
        part[i]->to = (struct cml_saved_taker){take, saved};
    }
    for (int i = 0; i < FOUND; i++) {
        const int k = dice_below(&dice, i + 1);
        order[i] = order[k];
        order[k] = i;
    }
    for (int i = 0; i < FOUND; i++) {
        struct cml_saved_row *row = cml_saved_next(part[dice_below(&dice, PARTS)]);
        row->index = index_of(order[i], beams);
        row->weight = (uint32_t)order[i];
        ((uint32_t *)(row + 1))[2 * MEDIA - 1] = (uint32_t)order[i];
    }
    for (int i = 0; i < PARTS; i++) {
        cml_saved_hand_in(part[i]);
        free(part[i]);
    }
    return saved;
}

static struct cml_saved *saved_of(uint32_t seed, uint64_t limit)
{
    return saved_of_beams(seed, limit, 1);
}

static void require_first(struct cml_saved *saved, size_t kept)
{
    const struct cml_saved_sums sums = cml_saved_sort(saved);
    assert_int_equal(sums.found, FOUND);
    assert_int_equal(sums.kept, kept);
    for (size_t i = 0; i < kept; i++) {
        const struct cml_saved_row *row = cml_saved_row(saved, i);
        assert_int_equal(row->index, 3 * i);
        assert_int_equal(row->weight, i);
        assert_int_equal(((const uint32_t *)(row + 1))[2 * MEDIA - 1], i);
    }
}

static void the_smallest_indices_stay_in_order(void **state)
{
    (void)state;
    const uint64_t limits[] = {1, 2, 100, 4000, FOUND - 1, FOUND, FOUND + 1, 100000};
    const struct cml_deal run = {.count = 1, .end = 3 * FOUND};
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        struct cml_saved *saved = saved_of((uint32_t)i, limits[i]);
        require_first(saved, limits[i] < FOUND ? limits[i] : FOUND);
        assert_int_equal(cml_saved_covers(saved, &run), limits[i] < FOUND ? 3 * limits[i] - 2 : 3 * FOUND);
        cml_saved_free(saved);
    }
}

/* The finaliser of splitmix64 as its authors write it. */
static uint64_t hash_of(uint64_t z)
{
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
}

/* Rows of the smallest hashes are kept, whatever the shares of beams. The kept rows say how many photons
 * they cover of all. */
static void of_several_beams_a_sample_stays(void **state)
{
    enum { BEAMS = 3 };
    (void)state;
    const double share[BEAMS] = {1, 4, 1};
    const uint64_t limits[] = {1, 60, 2000, 3400, FOUND - 1};
    for (size_t l = 0; l < sizeof limits / sizeof *limits; l++) {
        struct cml_saved *saved = saved_of_beams((uint32_t)l, limits[l], BEAMS);
        struct cml_deal run;
        const size_t kept = cml_saved_sort(saved).kept;
        uint64_t covers = 0, last = 0, smaller = 0;
        assert_int_equal(kept, limits[l]);
        for (size_t i = 0; i < kept; i++) {
            const uint64_t index = cml_saved_row(saved, i)->index;
            if (i > 0) assert_true(index > cml_saved_row(saved, i - 1)->index);
            if (hash_of(index) > last) last = hash_of(index);
        }
        for (int i = 0; i < FOUND; i++) smaller += hash_of(index_of(i, BEAMS)) <= last;
        assert_int_equal(smaller, kept);
        assert_int_equal(cml_deal_create(share, BEAMS, &run, &err), CML_OK);
        assert_int_equal(cml_deal_round(&run, 0, 6 * FOUND, &err), CML_OK);
        for (uint64_t k = 0; k < BEAMS; k++)
            for (uint64_t own = 0; own < 6 * FOUND; own++) {
                const uint64_t index = (k << CML_SOURCE_SHIFT) + own;
                covers += cml_deal_has(&run, index) && hash_of(index) <= last;
            }
        assert_int_equal(cml_saved_covers(saved, &run), covers);
        cml_deal_clear(&run);
        cml_saved_free(saved);
    }
}

/* Adding the rows that another rank or a checkpoint kept, and their number of dropped rows, gives the same
 * rows. */
static void what_is_added_again_is_the_same(void **state)
{
    (void)state;
    struct cml_saved *saved = saved_of(1, 500), *other = saved_of(2, 500);
    cml_saved_sort(saved);
    cml_saved_clear(other);
    cml_saved_add(other, cml_saved_row(saved, 200), 300);
    cml_saved_add(other, cml_saved_row(saved, 0), 200);
    cml_saved_add_found(other, FOUND - 500);
    require_first(other, 500);
    cml_saved_free(saved);
    cml_saved_free(other);
}

static void nothing_is_saved_unless_asked_for(void **state)
{
    (void)state;
    const struct cml_saved_kind none = {.media = MEDIA};
    struct cml_saved *saved;
    struct cml_saved_part *part;
    assert_int_equal(cml_saved_create(&none, &saved, &err), CML_OK);
    assert_int_equal(cml_saved_part_create(&none, &part, &err), CML_OK);
    assert_null(saved);
    assert_null(part);
    cml_saved_hand_in(part);
    cml_saved_free(saved);
    assert_true(cml_saved_bytes(&none) == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_smallest_indices_stay_in_order),
        cmocka_unit_test(of_several_beams_a_sample_stays),
        cmocka_unit_test(what_is_added_again_is_the_same),
        cmocka_unit_test(nothing_is_saved_unless_asked_for),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
