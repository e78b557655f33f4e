/* Tests of the table of arrays: the number of cells of each array, its place, and that no two arrays share
 * a cell. SPDX-License-Identifier: MIT */
#include "unit/tally/tally_cases.h"

#include "tally/groups.h"

/* A grid with every array: 3 radii, 4 depths, 2 angles, 5 media, 6 gates, 2 detectors with 5 pixels, 3
 * expected values, a map of 7 by 2 pixels with 2 angles, 56 voxels, 8 directions, 11 facets. */
static const struct cml_tally_grid of_all = {.nr = 3,
                                             .nz = 4,
                                             .na = 2,
                                             .num_layers = 2,
                                             .num_bodies = 1,
                                             .absorption = true,
                                             .gates = 6,
                                             .radii = true,
                                             .nx = 7,
                                             .ny = 2,
                                             .map_na = 2,
                                             .volume = true,
                                             .phi_volume = true,
                                             .phi_times = true,
                                             .marks = 0.1,
                                             .nt = 2,
                                             .np = 4,
                                             .detectors = 2,
                                             .detector_pixels = 5,
                                             .facets = 11,
                                             .scores = 3,
                                             .rows = 3,
                                             .row_depths = true,
                                             .row_times = true,
                                             .row_means = true,
                                             .row_cells = 77};

enum { T = CML_NUM_TOTALS, B = CML_NUM_BALANCE_TERMS, F = 11 * CML_FACET_SCORES };

/* Cells of each array, counted by hand, in a tally, a result, profiles, bins and grids of rows. */
static const size_t sizes[CML_NUM_ARRAYS][5] = {
    [CML_ARRAY_totals] = {0, T, T, 0, 0},
    [CML_ARRAY_terms] = {0, 0, 0, B, 0},
    [CML_ARRAY_A_l] = {5, 5, 5, 5, 0},
    [CML_ARRAY_A_z] = {0, 4, 6, 6, 0},
    [CML_ARRAY_Rd_r] = {0, 3, 4, 4, 0},
    [CML_ARRAY_Rd_a] = {0, 2, 2, 2, 0},
    [CML_ARRAY_Tt_r] = {0, 3, 4, 4, 0},
    [CML_ARRAY_Tt_a] = {0, 2, 2, 2, 0},
    [CML_ARRAY_A_rz] = {4 * 6, 3 * 4, 0, 0, 4 * 6},
    [CML_ARRAY_Rd_ra] = {4 * 2, 3 * 2, 0, 0, 4 * 2},
    [CML_ARRAY_Tt_ra] = {4 * 2, 3 * 2, 0, 0, 4 * 2},
    [CML_ARRAY_Rd_t] = {7, 6, 7, 7, 0},
    [CML_ARRAY_Rd_t_later] = {0, 1, 0, 0, 0},
    [CML_ARRAY_Tt_t] = {7, 6, 7, 7, 0},
    [CML_ARRAY_Tt_t_later] = {0, 1, 0, 0, 0},
    [CML_ARRAY_A_t] = {7, 6, 7, 7, 0},
    [CML_ARRAY_A_t_later] = {0, 1, 0, 0, 0},
    [CML_ARRAY_Rd_rt] = {4 * 7, 3 * 6, 0, 0, 4 * 7},
    [CML_ARRAY_Rd_rt_later] = {0, 3, 0, 0, 0},
    [CML_ARRAY_Tt_rt] = {4 * 7, 3 * 6, 0, 0, 4 * 7},
    [CML_ARRAY_Tt_rt_later] = {0, 3, 0, 0, 0},
    [CML_ARRAY_phi_z] = {0, 4, 0, 0, 0},
    [CML_ARRAY_phi_rz] = {4 * 6, 3 * 4, 0, 0, 0},
    [CML_ARRAY_phi_rzt] = {3 * 4 * 7, 3 * 4 * 6, 0, 0, 0},
    [CML_ARRAY_phi_rzt_later] = {0, 3 * 4, 0, 0, 0},
    [CML_ARRAY_Rd_dir] = {8, 8, 0, 0, 8},
    [CML_ARRAY_Tt_dir] = {8, 8, 0, 0, 8},
    [CML_ARRAY_Rsp_dir] = {8, 8, 0, 0, 0},
    [CML_ARRAY_detector] = {2, 2, 2, 2, 0},
    [CML_ARRAY_detector_t] = {2 * 7, 2 * 6, 2 * 7, 2 * 7, 0},
    [CML_ARRAY_detector_t_later] = {0, 2, 0, 0, 0},
    [CML_ARRAY_detector_path] = {0, 2 * 5, 0, 0, 0},
    [CML_ARRAY_detector_interactions] = {0, 2 * 5, 0, 0, 0},
    [CML_ARRAY_detector_momentum] = {0, 2 * 5, 0, 0, 0},
    [CML_ARRAY_detector_deepest] = {0, 2, 0, 0, 0},
    [CML_ARRAY_moments] = {2 * 16 * 3, 0, 2 * 16 * 3, 2 * 16 * 2, 0},
    [CML_ARRAY_expected] = {3, 3, 3, 0, 0},
    [CML_ARRAY_Rd_xya] = {15 * 2, 15 * 2, 0, 0, 0},
    [CML_ARRAY_Tt_xya] = {15 * 2, 15 * 2, 0, 0, 0},
    [CML_ARRAY_A_xyz] = {57, 57, 0, 0, 0},
    [CML_ARRAY_phi_xyz] = {56 * 16, 56 * 16, 0, 0, 0},
    [CML_ARRAY_facets] = {F, F, 0, 0, 0},
    [CML_ARRAY_detector_map] = {5, 5, 0, 0, 0},
    [CML_ARRAY_rows] = {77, 77, 0, 0, 0},
};

static void every_array_has_the_cells_of_its_axes(void **state)
{
    (void)state;
    for (int holder = 0; holder < 5; holder++) {
        const struct cml_layout layout = cml_layout_of(&of_all, (enum cml_holder)holder);
        for (int i = 0; i < CML_NUM_ARRAYS; i++)
            if (layout.size[i] != sizes[i][holder])
                fail_msg("%s of holder %d: %zu cells, not %zu", cml_arrays[i].name, holder, layout.size[i],
                         sizes[i][holder]);
    }
}

/* Checkpoints store results in this order of arrays, and devices have the first arrays of a tally; the
 * places must stay. */
static void places_are_those_of_checkpoints(void **state)
{
    (void)state;
    struct cml_tally_grid of = of_all;
    cml_tally_set_groups(&of);
    of.map_once.step = of.pixel_once.step = 0; /* these arrays have squares instead of groups */
    const struct cml_layout tally = cml_layout_of(&of, CML_OF_TALLY),
                            result = cml_layout_of(&of, CML_OF_RESULT);
    const size_t batched = 16 * 24 + 77 + 4 * 30 + 16 * 57 + 56 * 16 + 16 * F + 2 * 5 + 16 * 24;
    assert_int_equal(tally.A_l, 0);
    assert_int_equal(tally.expected, 5 + 3 * 7 + 2 + 14 + 96);
    assert_int_equal(tally.Rd_ra, tally.expected + 3);
    assert_int_equal(tally.A_rz, tally.Rd_ra + 2 * 16 * 8 + 77);
    assert_int_equal(tally.Rd_xya, tally.A_rz + 16 * 24 + 64 * 24 + 16 * 84 + 2 * 16 * 28);
    assert_int_equal(tally.cells - tally.Rd_xya, result.totals - result.Rd_xya);
    assert_int_equal(result.Rd_ra, 0);
    assert_int_equal(result.Tt_ra, 16 * 6);
    assert_int_equal(result.totals, batched);
    assert_int_equal(result.A_l, batched + 64 * (T + 3 + 3 + 2 + 2));
    assert_int_equal(result.A_t_later, result.A_l + 64 * (5 + 4 + 7 + 7 + 6));
    assert_int_equal(result.detector_path, result.A_t_later + 64 * (1 + 2 + 12 + 2));
    assert_int_equal(result.phi_z, result.detector_path + 64 * (32 + 3 + 12));
    assert_int_equal(result.cells, result.phi_z + 64 * 4 + 16 * (72 + 12) + 2 * 16 * (18 + 3));
    assert_int_equal(result.once[CML_ARRAY_Tt_xya].squares, 60);
    assert_int_equal(result.once[CML_ARRAY_Tt_xya].step, 0);
    assert_int_equal(result.once[CML_ARRAY_Tt_dir].step, 24);
    assert_int_equal(result.Tt_dir, result.Rd_dir + 8);
}

/* Absorption by medium and time exists only if it has few cells, and rows do not have it, unlike the grid
 * above. */
static void absorption_by_medium_and_time_is_of_few_cells(void **state)
{
    (void)state;
    struct cml_tally_grid of = of_all;
    of.row_depths = of.row_times = false;
    for (int gates = 13106; gates <= 13107; gates++) { /* with 5 media: 65535 and 65540 cells */
        of.gates = gates;
        const bool few = gates == 13106;
        const struct cml_layout tally = cml_layout_of(&of, CML_OF_TALLY),
                                result = cml_layout_of(&of, CML_OF_RESULT);
        assert_int_equal(tally.size[CML_ARRAY_A_lt], few ? 65535 : 0);
        assert_int_equal(result.size[CML_ARRAY_A_lt], few ? 65530 : 0);
        assert_int_equal(result.size[CML_ARRAY_A_lt_later], few ? 5 : 0);
        assert_int_equal(cml_layout_of(&of, CML_OF_ROW_BINS).size[CML_ARRAY_A_lt], 0);
    }
}

static struct cml_tally_grid random_grid(struct dice *dice)
{
    struct cml_tally_grid of = {.nr = 1 + dice_below(dice, 5),
                                .nz = 1 + dice_below(dice, 5),
                                .na = 1 + dice_below(dice, 4),
                                .num_layers = 1 + dice_below(dice, 3),
                                .num_bodies = dice_below(dice, 2),
                                .absorption = dice_below(dice, 2),
                                .gates = dice_below(dice, 2) * dice_below(dice, 5),
                                .radii = dice_below(dice, 2),
                                .nx = dice_below(dice, 3),
                                .ny = 1,
                                .map_na = 1 + dice_below(dice, 2),
                                .marks = dice_below(dice, 2),
                                .nt = dice_below(dice, 3),
                                .np = 1 + dice_below(dice, 3),
                                .detectors = dice_below(dice, 3),
                                .facets = (size_t)dice_below(dice, 3),
                                .scores = dice_below(dice, 3),
                                .rows = dice_below(dice, 2) * 17,
                                .derivatives = dice_below(dice, 2),
                                .row_times = dice_below(dice, 2)};
    of.volume = of.phi_volume = of.nx > 0;
    of.detector_pixels = (size_t)of.detectors;
    cml_tally_set_groups(&of);
    if (dice_below(dice, 2)) of.map_once.step = of.pixel_once.step = of.direction_once.step = 0;
    of.row_cells = (size_t)of.rows * 3;
    return dice_below(dice, 3) ? of : cml_tally_grid_of_thread(&of);
}

/* Marks the cells of an array, part by part; a cell must not be marked twice. */
static void mark(const struct cml_layout *layout, int array, unsigned char *seen)
{
    for (size_t part = 0; part < layout->parts[array]; part++)
        for (size_t i = 0; i < layout->size[array]; i++) {
            const size_t at = layout->at[array] + part * layout->once[array].squares + i;
            assert_true(at < layout->cells && !seen[at]);
            seen[at] = 1;
        }
}

static void arrays_fill_their_block_and_share_no_cell(void **state)
{
    (void)state;
    struct dice dice = dice_new(58);
    for (int n = 0; n < 500; n++) {
        const struct cml_tally_grid of = random_grid(&dice);
        for (int holder = 0; holder < 5; holder++) {
            const struct cml_layout layout = cml_layout_of(&of, (enum cml_holder)holder);
            unsigned char *seen = calloc(layout.cells + 1, 1);
            assert_non_null(seen);
            for (int i = 0; i < CML_NUM_ARRAYS; i++) mark(&layout, i, seen);
            assert_null(memchr(seen, 0, layout.cells));
            free(seen);
        }
    }
}

/* A thread has its own cells of most arrays. Arrays that all threads share are borrowed from the owner. */
static void threads_borrow_what_they_have_not(void **state)
{
    (void)state;
    const struct cml_tally_grid of = cml_tally_grid_of_thread(&of_all);
    struct cml_tally owner = make_tally(&of_all), thread = make_tally(&of);
    cml_tally_borrow(&thread, &owner);
    for (int i = 0; i < CML_NUM_ARRAYS; i++) {
        const bool shared = cml_arrays[i].when == CML_IF_OWNER || cml_arrays[i].when == CML_IF_RADII;
        assert_int_equal(thread.layout.size[i], shared ? 0 : owner.layout.size[i]);
        assert_int_equal(thread.array[i] == owner.array[i], shared || !owner.array[i]);
    }
    cml_tally_free(&thread);
    cml_tally_free(&owner);
}

/* Gates lie side by side: radius and gate choose the cell of a weight. Light beyond the last radius is in
 * the last bin, and light later than all gates is in the array behind. */
static void radii_have_gates_side_by_side(void **state)
{
    (void)state;
    const size_t nr = 3, gates = 6, group = 5;
    struct cml_result result;
    struct cml_error err;
    struct cml_tally_grid of = of_all;
    cml_tally_set_groups(&of);
    struct cml_tally tally = make_tally(&of);
    assert_int_equal(cml_result_create(&of, 64, &result, &err), CML_OK);
    uint64_t *cells = tally.Tt_rt + group * (nr + 1) * (gates + 1);
    for (size_t r = 0; r <= nr; r++)
        for (size_t t = 0; t <= gates; t++) cells[r * (gates + 1) + t] = 100 * r + t;
    cml_result_add(&result, &tally);
    for (size_t r = 0; r < nr; r++)
        for (size_t t = 0; t <= gates; t++) {
            const cml_u128 found =
                t < gates ? result.Tt_rt[(group * nr + r) * gates + t] : result.Tt_rt_later[group * nr + r];
            assert_true(found == 100 * r + t + (r + 1 == nr ? 100 * nr + t : 0));
        }
    assert_true(result.Rd_rt[group * nr * gates + 1] == 0 &&
                result.summary.balance[CML_BALANCE_OVERFLOW_R] == 0);
    cml_result_free(&result);
    cml_tally_free(&tally);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_array_has_the_cells_of_its_axes),
        cmocka_unit_test(absorption_by_medium_and_time_is_of_few_cells),
        cmocka_unit_test(places_are_those_of_checkpoints),
        cmocka_unit_test(arrays_fill_their_block_and_share_no_cell),
        cmocka_unit_test(threads_borrow_what_they_have_not),
        cmocka_unit_test(radii_have_gates_side_by_side),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
