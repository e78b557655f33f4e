/* Tests of ranges of photon indices: taking pieces, giving them back, and sharing them among processes.
 * SPDX-License-Identifier: MIT */
#include "tally/ranges.h"
#include "lib/dice.h"

static struct cml_error err;

static void add(struct cml_ranges *ranges, uint64_t first, uint64_t count)
{
    assert_int_equal(cml_ranges_add(ranges, (struct cml_range){first, count}, &err), CML_OK);
}

static void an_empty_set_gives_nothing(void **state)
{
    (void)state;
    struct cml_ranges ranges = {0};
    add(&ranges, 7, 0);
    assert_int_equal(ranges.count, 0);
    assert_int_equal(cml_ranges_take(&ranges, 5).count, 0);
    cml_ranges_clear(&ranges);
}

/* Takes pieces of random size and gives some of them back, like ranks that stop in the middle of a range. */
static void every_index_is_flown_once(void **state)
{
    (void)state;
    enum { PHOTONS = 5000 };
    static int flown[PHOTONS];
    struct dice dice = dice_new(1);
    struct cml_ranges ranges = {0};
    uint64_t left = PHOTONS;
    add(&ranges, 0, PHOTONS);
    while (ranges.total > 0) {
        struct cml_range piece = cml_ranges_take(&ranges, 1 + (uint64_t)dice_below(&dice, 40));
        uint64_t some = (uint64_t)dice_below(&dice, (int)piece.count + 1);
        left -= some;
        for (; some > 0; some--, piece.count--) flown[piece.first++]++;
        add(&ranges, piece.first, piece.count);
        assert_int_equal(ranges.total, left);
    }
    assert_int_equal(ranges.count, 0);
    for (int i = 0; i < PHOTONS; i++) assert_int_equal(flown[i], 1);
    cml_ranges_clear(&ranges);
}

static void many_ranges_fit(void **state)
{
    (void)state;
    struct cml_ranges ranges = {0};
    uint64_t sum = 0;
    for (uint64_t i = 0; i < 1000; i++) add(&ranges, 10 * i, 3);
    for (int i = 0; i < 1000; i++) sum += cml_ranges_take(&ranges, 100).first;
    assert_int_equal(sum, 10 * 999 * 1000 / 2);
    assert_int_equal(ranges.total, 0);
    cml_ranges_clear(&ranges);
}

/* Compares ranges of any size with marking indices one by one. */
static void what_is_not_mine_goes_to_others(void **state)
{
    (void)state;
    enum { PHOTONS = 200 };
    struct dice dice = dice_new(2);
    for (int i = 0; i < 100; i++) {
        struct cml_ranges ranges = {0}, others = {0};
        int place[PHOTONS] = {0};
        for (uint64_t at = 0; at < PHOTONS;) {
            uint64_t count = 1 + (uint64_t)dice_below(&dice, 60);
            if (at + count > PHOTONS) count = PHOTONS - at;
            if (dice_below(&dice, 3) > 0) add(&ranges, at, count);
            at += count;
        }
        for (size_t k = 0; k < ranges.count; k++)
            for (uint64_t j = 0; j < ranges.item[k].count; j++) place[ranges.item[k].first + j] = 1;
        const uint64_t all = ranges.total, first = (uint64_t)dice_below(&dice, PHOTONS),
                       count = (uint64_t)dice_below(&dice, PHOTONS);
        assert_int_equal(cml_ranges_keep(&ranges, (struct cml_range){first, count}, &others, &err), CML_OK);
        assert_int_equal(ranges.total + others.total, all);
        for (size_t k = 0; k < ranges.count; k++)
            for (uint64_t j = 0; j < ranges.item[k].count; j++) {
                const uint64_t index = ranges.item[k].first + j;
                assert_true(place[index]-- == 1 && index >= first && index < first + count);
            }
        for (size_t k = 0; k < others.count; k++)
            for (uint64_t j = 0; j < others.item[k].count; j++) {
                const uint64_t index = others.item[k].first + j;
                assert_true(place[index]-- == 1 && (index < first || index >= first + count));
            }
        cml_ranges_clear(&ranges);
        cml_ranges_clear(&others);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_empty_set_gives_nothing),
        cmocka_unit_test(every_index_is_flown_once),
        cmocka_unit_test(many_ranges_fit),
        cmocka_unit_test(what_is_not_mine_goes_to_others),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
