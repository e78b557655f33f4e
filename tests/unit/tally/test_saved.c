/* SPDX-License-Identifier: MIT */
#include "tally/saved.h"
#include "lib/dice.h"

#include <stdlib.h>

static struct cml_error err;

enum { FOUND = 9000, MEDIA = 3 };

static void take(void *context, const void *rows, size_t count)
{
    cml_saved_add(context, rows, count);
}

/* Indices 0, 3, 6 ... as threads find them: in any order, each of several with a buffer of its own. */
static struct cml_saved *saved_of(uint32_t seed, uint64_t limit)
{
    enum { PARTS = 3 };
    const struct cml_saved_kind kind = {.limit = limit, .media = MEDIA};
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
        row->index = 3 * (uint64_t)order[i];
        row->weight = (uint32_t)order[i];
        ((uint32_t *)(row + 1))[2 * MEDIA - 1] = (uint32_t)order[i];
    }
    for (int i = 0; i < PARTS; i++) {
        cml_saved_hand_in(part[i]);
        free(part[i]);
    }
    return saved;
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
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        struct cml_saved *saved = saved_of((uint32_t)i, limits[i]);
        require_first(saved, limits[i] < FOUND ? limits[i] : FOUND);
        assert_int_equal(cml_saved_covers(saved, 3 * FOUND),
                         limits[i] < FOUND ? 3 * limits[i] - 2 : 3 * FOUND);
        cml_saved_free(saved);
    }
}

/* As a checkpoint or another rank has them: rows that stay, and the number of the others. */
static void what_is_added_again_is_the_same(void **state)
{
    (void)state;
    struct cml_saved *saved = saved_of(1, 500), *other = saved_of(2, 500);
    cml_saved_sort(saved);
    cml_saved_clear(other);
    cml_saved_add(other, cml_saved_row(saved, 200), 300);
    cml_saved_add(other, cml_saved_row(saved, 0), 200);
    cml_saved_find(other, FOUND - 500);
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
        cmocka_unit_test(what_is_added_again_is_the_same),
        cmocka_unit_test(nothing_is_saved_unless_asked_for),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
