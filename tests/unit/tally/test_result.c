/* Tests of results: sums of tallies, their bins, and their standard errors. SPDX-License-Identifier: MIT */
#include "unit/tally/tally_cases.h"

#include "tally/groups.h"
#include "tally/piece.h"

/* Checks that one unit too many in any of these cells is noticed. */
static void assert_every_cell_counts(const struct cml_result *result, cml_u128 *const *cells, int count)
{
    assert_true(cml_result_imbalance(result) == 0);
    for (int i = 0; i < count; i++) {
        ++*cells[i];
        assert_true(cml_result_imbalance(result) != 0);
        --*cells[i];
        assert_true(cml_result_imbalance(result) == 0);
    }
}

static void a_broken_map_does_not_balance(void **state)
{
    (void)state;
    struct cml_tally_grid grid_of_all = map_grid;
    grid_of_all.nt = 2;
    grid_of_all.np = 3;
    grid_of_all.backed = true;
    cml_tally_set_groups(&grid_of_all);
    struct cml_result result = make_result(&grid_of_all, 100);
    const struct cml_once pixels = grid_of_all.map_once, directions = grid_of_all.direction_once;
    cml_u128 *const cells[] = {&result.Rd_xya[5],
                               &result.Tt_xya[0],
                               &result.Tt_xya[15 * pixels.step],
                               &result.Tt_dir[3 * directions.step],
                               &result.A_xyz[8],
                               &result.Rd_dir[1],
                               &result.Tt_dir[5],
                               &result.Rsp_dir[0],
                               &result.facets[CML_FACET_IRRADIANCE_BELOW],
                               &result.facets[CML_FACET_SCORES + CML_FACET_EXITANCE_ABOVE]};
    assert_every_cell_counts(&result, cells, COUNT(cells));
    /* light kept by a backing has arrived at its facets */
    result.summary.balance[CML_BALANCE_LAUNCHED] = result.summary.balance[CML_BALANCE_BACKING] = 1;
    assert_true(cml_result_imbalance(&result) != 0);
    result.facets[CML_FACET_IRRADIANCE_ABOVE] = 1;
    assert_true(cml_result_imbalance(&result) == 0);
    cml_result_free(&result);
}

/* 250 of 1000 packets end in a pixel with half their weight: mean 1/8, mean square 1/16. The error follows
 * from these. */
static void the_error_of_what_a_packet_adds_once(void **state)
{
    (void)state;
    struct cml_result result = {.summary.count[CML_COUNT_PHOTONS] = 1000};
    const cml_u128 sum = (cml_u128)250 << 30, square = (cml_u128)1 << 2 * (30 - CML_SQUARE_SHIFT);
    const double expected = sqrt((1.0 / 16 - 1.0 / 64) / 999);
    assert_true(fabs(cml_result_square_error(&result, sum, 250 * square) / expected - 1) < 1e-12);
    assert_true(cml_result_square_error(&result, 0, 0) == 0);
    const cml_u128 cells[2] = {sum, 250 * square};
    assert_true(cml_result_once_sum(cells, 1, (struct cml_once){0, 1}) == (double)sum);
    assert_true(fabs(cml_result_once_error(&result, cells, 1, (struct cml_once){0, 1}) / expected - 1) <
                1e-12);
}

/* Two cells of each group: a single packet has the error that it has alone, its weight over all packets;
 * equal weights in all groups have an error of 0. */
static void the_error_of_what_groups_add_once(void **state)
{
    (void)state;
    const struct cml_result result = {.photons = 1600, .summary.count[CML_COUNT_PHOTONS] = 1600};
    const struct cml_once once = {2, 2};
    cml_u128 cells[2 * CML_NUM_GROUPS] = {0};
    assert_true(cml_result_once_error(&result, cells, 2, once) == 0);
    cells[2 * 5 + 1] = (cml_u128)1 << 31;
    assert_true(cml_result_once_sum(cells, 2, once) == 0x1p31);
    assert_true(fabs(cml_result_once_error(&result, cells, 2, once) * 1600 - 1) < 1e-12);
    assert_true(cml_result_once_error(&result, cells, 1, once) == 0);
    for (int g = 0; g < CML_NUM_GROUPS; g++) cells[2 * g] = 7, cells[2 * g + 1] = 9;
    assert_true(cml_result_once_error(&result, cells, 2, once) == 0);
}

/* Sizes of batches differ by at most one packet and add up to all packets. */
static void every_photon_belongs_to_one_batch(void **state)
{
    (void)state;
    static const uint64_t photons[] = {
        1, 2, 63, 64, 65, 1000, 4095, 1000007, ((uint64_t)1 << 48) - 1, (uint64_t)1 << 48};
    for (int i = 0; i < COUNT(photons); i++) {
        uint64_t sum = 0;
        for (int b = 0; b < CML_NUM_BATCHES; b++) {
            const uint64_t size = cml_batch_size(photons[i], b);
            assert_true(size == photons[i] / 64 || size == photons[i] / 64 + 1);
            sum += size;
        }
        assert_int_equal(sum, photons[i]);
    }
}

/* The places of a round hold every photon once, batch after batch; photon i is point i / 64 of batch i mod
 * 64. */
static void places_hold_every_photon_once(void **state)
{
    (void)state;
    static const uint64_t rounds[][2] = {{0, 1}, {0, 63},   {0, 64},   {0, 1000},
                                         {5, 6}, {37, 300}, {64, 128}, {1000, 1777}};
    for (int k = 0; k < COUNT(rounds); k++) {
        const uint64_t begin = rounds[k][0], end = rounds[k][1];
        int times[1777] = {0}, batch = -1;
        for (uint64_t place = begin; place < end;) {
            const struct cml_piece piece = cml_piece_at(begin, end, place),
                                   next = cml_piece_at(begin, end, end - 1);
            assert_true(piece.batch > batch && piece.batch <= next.batch);
            batch = piece.batch;
            for (uint64_t i = 0; i < piece.count; i++, place++) {
                const struct cml_piece here = cml_piece_at(begin, end, place);
                const uint64_t photon = piece.first + CML_NUM_BATCHES * i;
                assert_true(here.first == photon && here.count == piece.count - i && here.batch == batch);
                assert_int_equal(photon % CML_NUM_BATCHES, batch);
                assert_true(photon >= begin && photon < end);
                times[photon]++;
            }
        }
        for (uint64_t photon = begin; photon < end; photon++) assert_int_equal(times[photon], 1);
    }
}

static void a_result_has_the_margins_of_its_batches(void **state)
{
    (void)state;
    struct dice dice = dice_new(81);
    struct cml_result result = make_result(&grid, 640);
    cml_u128 wanted[3][2] = {{0}};
    for (int b = 0; b < CML_NUM_BATCHES; b++) {
        struct cml_tally tally = make_tally(&grid);
        score_at_random(&dice, &tally, 10);
        add_to_batch(&result, b, &tally);
        for (int r = 0; r < 3; r++) {
            assert_true(result.Rd_r[b * 3 + r] == (cml_u128)tally.Rd_ra[2 * r] + tally.Rd_ra[2 * r + 1]);
            assert_true(result.Tt_r[b * 3 + r] == (cml_u128)tally.Tt_ra[2 * r] + tally.Tt_ra[2 * r + 1]);
            for (int a = 0; a < 2; a++) wanted[r][a] += tally.Rd_ra[2 * r + a];
        }
        for (int a = 0; a < 2; a++)
            assert_true(result.Rd_a[b * 2 + a] ==
                        (cml_u128)tally.Rd_ra[a] + tally.Rd_ra[2 + a] + tally.Rd_ra[4 + a]);
        for (int z = 0; z < 4; z++)
            assert_true(result.A_z[b * 4 + z] ==
                        (cml_u128)tally.A_rz[1 + z] + tally.A_rz[7 + z] + tally.A_rz[13 + z]);
        for (int m = 0; m < 4; m++) assert_true(result.A_l[b * 4 + m] == tally.A_l[m]);
        cml_tally_free(&tally);
    }
    for (int r = 0; r < 3; r++)
        for (int a = 0; a < 2; a++) assert_true(result.Rd_ra[2 * r + a] == wanted[r][a]);
    assert_true(cml_result_imbalance(&result) == 0);
    assert_true(cml_result_share(&result, CML_BALANCE_ABSORBED) == 0.5);
    assert_true(cml_result_absorbed(&result, 1) == 0.5 && cml_result_absorbed_error(&result, 1) == 0);
    cml_result_free(&result);
}

/* One tally that serves many batches, in any order and several times each, gives the same result as one
 * tally per batch. */
static void a_tally_may_serve_many_batches(void **state)
{
    (void)state;
    struct dice dice = dice_new(83);
    struct cml_result result = make_result(&grid, 640), apart = make_result(&grid, 640);
    struct cml_tally all = make_tally(&grid);
    for (int n = 0; n < 200; n++) {
        struct cml_tally piece = make_tally(&grid);
        const int batch = dice_below(&dice, CML_NUM_BATCHES);
        score_at_random(&dice, &piece, 10);
        piece.Rd_ra[3 * 2 + 1] = 5; /* a cell beyond the grid */
        piece.A_rz[3 * 6 + 5] = 7;
        add_to_batch(&apart, batch, &piece);
        cml_tally_move(&all, &piece);
        cml_tally_sum_batch(&all, batch);
        cml_result_add_batch(&result, batch, &all);
        if (n % 50 == 49) {
            cml_result_add(&result, &all);
            cml_tally_zero(&all);
        }
        cml_tally_free(&piece);
    }
    size_t cells, same;
    const cml_u128 *a = cml_result_cells(&result, &cells), *b = cml_result_cells(&apart, &same);
    assert_int_equal(cells, same);
    assert_memory_equal(a, b, cells * sizeof *a);
    assert_memory_equal(result.summary.balance, apart.summary.balance, sizeof result.summary.balance);
    cml_tally_free(&all);
    cml_result_free(&result);
    cml_result_free(&apart);
}

/* Rule P7: weight beyond the grid goes into the last or first bin, and is counted. */
static void cells_beyond_the_grid_go_into_its_rim(void **state)
{
    (void)state;
    struct cml_result result = make_result(&grid, 1);
    struct cml_tally tally = make_tally(&grid);
    tally.Rd_ra[3 * 2 + 1] = 1;
    tally.Tt_ra[3 * 2] = 2;
    tally.A_rz[1 * 6 + 0] = 4;  /* r bin 1, z < 0 */
    tally.A_rz[2 * 6 + 5] = 8;  /* r bin 2, below the grid */
    tally.A_rz[3 * 6 + 2] = 16; /* r beyond the grid, z bin 1 */
    tally.A_rz[3 * 6 + 5] = 32; /* r and z beyond the grid */
    add_to_batch(&result, 7, &tally);
    assert_true(result.Rd_ra[2 * 2 + 1] == 1 && result.Rd_r[7 * 3 + 2] == 1 && result.Rd_a[7 * 2 + 1] == 1);
    assert_true(result.Tt_ra[2 * 2] == 2 && result.Tt_r[7 * 3 + 2] == 2 && result.Tt_a[7 * 2] == 2);
    assert_true(result.A_rz[1 * 4 + 0] == 4 && result.A_rz[2 * 4 + 3] == 8 + 32 &&
                result.A_rz[2 * 4 + 1] == 16);
    assert_true(result.A_z[7 * 4] == 4 && result.A_z[7 * 4 + 1] == 16 && result.A_z[7 * 4 + 3] == 40);
    assert_true(result.summary.balance[CML_BALANCE_OVERFLOW_R] == 1 + 2 + 16 + 32);
    assert_true(result.summary.balance[CML_BALANCE_OVERFLOW_Z] == 8 + 32 &&
                result.summary.balance[CML_BALANCE_ABOVE] == 4);
    cml_tally_free(&tally);
    cml_result_free(&result);
}

/* Batch 7 has weight in gates 1 and 2 of Rd_t and after the last gate, and absorption in gate 0. */
static void gates_are_kept_by_batch_and_balance(void **state)
{
    (void)state;
    struct cml_tally_grid timed = grid;
    timed.gates = 3;
    struct cml_result result = make_result(&timed, 100);
    struct cml_tally tally = make_tally(&timed);
    tally.Rd_t[1] = 1;
    tally.Rd_t[3] = 2;
    tally.Tt_t[2] = 4;
    tally.A_t[0] = tally.A_lt[4] = 8; /* gate 0 of medium 1 */
    tally.balance[CML_BALANCE_LAUNCHED] = 15;
    tally.balance[CML_BALANCE_REFLECTED] = tally.Rd_ra[0] = 3;
    tally.balance[CML_BALANCE_TRANSMITTED] = tally.Tt_ra[0] = 4;
    tally.balance[CML_BALANCE_ABSORBED] = tally.A_rz[1] = tally.A_l[1] = 8;
    add_to_batch(&result, 7, &tally);
    assert_true(result.Rd_t[7 * 3 + 1] == 1 && result.Rd_t[7 * 3 + 2] == 0 && result.Rd_t_later[7] == 2);
    assert_true(result.Tt_t[7 * 3 + 2] == 4 && result.A_t[7 * 3] == 8 && result.A_t_later[7] == 0);
    assert_true(result.A_lt[7 * result.layout.size[CML_ARRAY_A_lt] + 3] == 8 && result.A_lt_later[7] == 0);
    cml_u128 *const cells[] = {&result.Rd_t[0],       &result.Rd_t_later[63], &result.Tt_t[7],
                               &result.Tt_t_later[0], &result.A_t[191],       &result.A_t_later[1],
                               &result.A_lt[0],       &result.A_lt_later[0]};
    assert_every_cell_counts(&result, cells, COUNT(cells));
    cml_tally_free(&tally);
    cml_result_free(&result);
}

static void a_broken_cell_does_not_balance(void **state)
{
    (void)state;
    struct dice dice = dice_new(82);
    struct cml_result result = make_result(&grid, 100);
    struct cml_tally tally = make_tally(&grid);
    score_at_random(&dice, &tally, 100);
    add_to_batch(&result, 0, &tally);
    cml_u128 *const cells[] = {&result.A_rz[5],
                               &result.Rd_ra[1],
                               &result.Tt_ra[4],
                               &result.A_l[2],
                               &result.summary.balance[CML_BALANCE_LAUNCHED],
                               &result.summary.balance[CML_BALANCE_GAINED],
                               &result.summary.balance[CML_BALANCE_SPECULAR],
                               &result.summary.balance[CML_BALANCE_REFLECTED],
                               &result.summary.balance[CML_BALANCE_ROULETTE],
                               &result.summary.balance[CML_BALANCE_TRAPPED],
                               &result.summary.balance[CML_BALANCE_LOST],
                               &result.summary.balance[CML_BALANCE_BACKING],
                               &result.summary.balance[CML_BALANCE_ABSORBED],
                               &result.summary.balance[CML_BALANCE_TRANSMITTED]};
    assert_every_cell_counts(&result, cells, COUNT(cells));
    cml_result_free(&result);
    cml_tally_free(&tally);
}

/* Errors equal their formula written out, with batches of unequal size. For independent packets they also
 * agree with the binomial error. */
static void errors_are_the_spread_of_batches(void **state)
{
    (void)state;
    struct dice dice = dice_new(84);
    const uint64_t photons = 10007;
    struct cml_result result = make_result(&grid, photons);
    double mean[CML_NUM_BATCHES], size[CML_NUM_BATCHES], all = 0, squares = 0;
    for (int b = 0; b < CML_NUM_BATCHES; b++) {
        struct cml_tally tally = make_tally(&grid);
        size[b] = (double)cml_batch_size(photons, b);
        for (int n = 0; n < (int)size[b]; n++) score(&tally, dice_below(&dice, 3), 0, 0, true);
        add_to_batch(&result, b, &tally);
        mean[b] = (double)(tally.Rd_ra[2] + tally.Rd_ra[3]) * CML_WEIGHT_UNIT / size[b];
        all += mean[b] * size[b] / (double)photons;
        cml_tally_free(&tally);
    }
    for (int b = 0; b < CML_NUM_BATCHES; b++) squares += size[b] * (mean[b] - all) * (mean[b] - all);
    const double error = cml_result_bin_error(&result, result.Rd_r, 3, 1);
    assert_near("error", error, sqrt(squares / 63 / (double)photons), 1e-15);
    assert_near("binomial error", error / (0.5 * sqrt(2.0 / 9 / (double)photons)), 1, 0.35);
    assert_true(cml_result_bin_error(&result, result.Tt_r, 3, 1) == 0);
    cml_result_free(&result);
}

/* A total has the error of a profile with one bin. */
static void the_error_of_a_total_is_that_of_its_bins(void **state)
{
    (void)state;
    const struct cml_tally_grid one = {.nr = 1, .nz = 1, .na = 1, .num_layers = 1, .absorption = true};
    struct dice dice = dice_new(83);
    struct cml_result result = make_result(&one, 1000);
    for (int b = 0; b < CML_NUM_BATCHES; b++) {
        struct cml_tally tally = make_tally(&one);
        for (uint64_t n = 0; n < cml_batch_size(1000, b); n++)
            score(&tally, 0, 0, 0, dice_below(&dice, 3) == 0);
        add_to_batch(&result, b, &tally);
        cml_tally_free(&tally);
    }
    const double error = cml_result_error(&result, CML_TOTAL_REFLECTED);
    assert_true(error == cml_result_bin_error(&result, result.Rd_r, 1, 0));
    assert_near("binomial error", error / (0.5 * sqrt(2.0 / 9 / 1000)), 1, 0.35);
    assert_true(cml_result_error(&result, CML_TOTAL_TRANSMITTED) ==
                cml_result_bin_error(&result, result.Tt_a, 1, 0));
    assert_true(cml_result_error(&result, CML_TOTAL_ABSORBED) == 0 && result.A_z[0] > 0);
    assert_true(cml_result_error(&result, CML_TOTAL_SPECULAR) == 0);
    cml_result_free(&result);
}

/* Each group has one photon. One of them leaves its weight in the cell: 1/16 +- sqrt(1/16 15/16 / 15). */
static void the_error_of_a_cell_comes_of_its_groups(void **state)
{
    (void)state;
    struct cml_result result = make_result(&grid, CML_NUM_GROUPS);
    cml_u128 cells[2 * CML_NUM_GROUPS] = {[2 * 3] = (cml_u128)1 << 31, [1] = 5};
    assert_near("error", cml_result_cell_error(&result, cells, 2), 1.0 / 16, 1e-15);
    result.photons = 1;
    assert_true(isnan(cml_result_cell_error(&result, cells, 2)));
    cml_result_free(&result);
}

static void one_photon_has_no_error(void **state)
{
    (void)state;
    struct cml_result result = make_result(&grid, 1);
    struct cml_tally tally = make_tally(&grid);
    score(&tally, 1, 1, 1, true);
    add_to_batch(&result, 63, &tally);
    assert_true(isnan(cml_result_error(&result, CML_TOTAL_REFLECTED)));
    assert_true(isnan(cml_result_bin_error(&result, result.Rd_r, 3, 1)));
    result.summary.count[CML_COUNT_PHOTONS] = 1;
    assert_true(isnan(cml_result_square_error(&result, 1, 1)));
    cml_result_free(&result);
    cml_tally_free(&tally);
}

/* A result holds 2^48 packets in one cell, and tallies as full as they may get, without overflow. */
static void a_result_does_not_overflow(void **state)
{
    (void)state;
    struct cml_result result = make_result(&grid, (uint64_t)1 << 48);
    struct cml_tally tally = make_tally(&grid);
    const uint64_t full = CML_TALLY_MAX_PHOTONS * ((uint64_t)1 << 31);
    tally.Rd_ra[0] = full;
    tally.balance[CML_BALANCE_LAUNCHED] = full;
    tally.balance[CML_BALANCE_REFLECTED] = full;
    tally.count[CML_COUNT_PHOTONS] = CML_TALLY_MAX_PHOTONS;
    for (int n = 0; n < 1 << 18; n++) add_to_batch(&result, n >> 12, &tally);
    assert_true(result.Rd_ra[0] == (cml_u128)1 << 79);
    assert_true(result.Rd_r[5 * 3] == (cml_u128)1 << 73);
    assert_true(result.summary.count[CML_COUNT_PHOTONS] == (cml_u128)1 << 48);
    assert_true(cml_result_imbalance(&result) == 0);
    assert_true(cml_result_share(&result, CML_BALANCE_REFLECTED) == 1);
    assert_true(cml_result_error(&result, CML_TOTAL_REFLECTED) == 0);
    assert_true(cml_result_bin_error(&result, result.Rd_r, 3, 0) == 0);
    cml_result_free(&result);
    cml_tally_free(&tally);
}

static struct cml_summary random_summary(struct dice *dice)
{
    struct cml_summary summary = {.lost = {0}};
    for (int i = 0; i < COUNT(summary.balance); i++) summary.balance[i] = (cml_u128)dice_word(dice) << 60;
    for (int i = 0; i < COUNT(summary.count); i++) summary.count[i] = dice_word(dice);
    for (int i = 0; i < 6; i++) cml_lost_list_add(&summary.lost, dice_word(dice));
    return summary;
}

/* Summaries of ranks can be added in any order, as MPI may choose any tree. */
static void summaries_merge_in_any_order(void **state)
{
    (void)state;
    struct dice dice = dice_new(3);
    const struct cml_summary a = random_summary(&dice), b = random_summary(&dice), c = random_summary(&dice);
    struct cml_summary left = a, right = c, inner = b;
    cml_summary_merge(&left, &b);
    cml_summary_merge(&left, &c);
    cml_summary_merge(&inner, &a);
    cml_summary_merge(&right, &inner);
    assert_memory_equal(&left, &right, sizeof left);
    assert_int_equal(left.lost.count, CML_LOST_LISTED);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_broken_map_does_not_balance),
        cmocka_unit_test(the_error_of_what_a_packet_adds_once),
        cmocka_unit_test(the_error_of_what_groups_add_once),
        cmocka_unit_test(every_photon_belongs_to_one_batch),
        cmocka_unit_test(places_hold_every_photon_once),
        cmocka_unit_test(a_result_has_the_margins_of_its_batches),
        cmocka_unit_test(a_tally_may_serve_many_batches),
        cmocka_unit_test(cells_beyond_the_grid_go_into_its_rim),
        cmocka_unit_test(gates_are_kept_by_batch_and_balance),
        cmocka_unit_test(a_broken_cell_does_not_balance),
        cmocka_unit_test(the_error_of_a_total_is_that_of_its_bins),
        cmocka_unit_test(errors_are_the_spread_of_batches),
        cmocka_unit_test(the_error_of_a_cell_comes_of_its_groups),
        cmocka_unit_test(one_photon_has_no_error),
        cmocka_unit_test(a_result_does_not_overflow),
        cmocka_unit_test(summaries_merge_in_any_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
