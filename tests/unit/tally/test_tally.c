/* Tests of tallies: their cells, and how tallies of threads are merged. SPDX-License-Identifier: MIT */
#include "tally/array_table.h"

#include "unit/tally/tally_cases.h"

#include "tally/groups.h"

static void a_new_tally_is_zero_and_has_all_its_cells(void **state)
{
    (void)state;
    struct cml_tally tally = make_tally(&grid);
    for (size_t i = 0; i < cml_tally_cells(&grid); i++) assert_int_equal(tally.A_l[i], 0);
    assert_true(tally.Rd_ra == tally.A_l + 4 && tally.Tt_ra == tally.Rd_ra + 4 * 2);
    assert_true(tally.A_rz == tally.Tt_ra + 4 * 2);
    assert_int_equal(cml_tally_cells(&grid), 4 + 2 * 4 * 2 + 4 * 6);
    assert_true(cml_tally_bytes(&grid) == 8 * (4 + 2 * 4 * 2 + 4 * 6));
    cml_tally_free(&tally);
    struct cml_tally_grid without = grid;
    without.absorption = false;
    tally = make_tally(&without);
    assert_null(tally.A_rz);
    assert_true(cml_tally_bytes(&without) == 8 * (4 + 2 * 4 * 2));
    cml_tally_free(&tally);
}

/* Fills every array of the tally with different numbers, because the arrays lie side by side. */
static void fill(struct cml_tally *tally, uint64_t from)
{
    for (size_t i = 0; i < cml_tally_cells(&grid); i++) tally->A_l[i] = from++;
    for (int i = 0; i < CML_NUM_BALANCE_TERMS; i++) tally->balance[i] = from++;
    for (int i = 0; i < CML_NUM_COUNTS; i++) tally->count[i] = from++;
}

static void assert_zero(const struct cml_tally *tally)
{
    struct cml_tally fresh = make_tally(&grid);
    assert_memory_equal(tally->A_l, fresh.A_l, (size_t)cml_tally_bytes(&grid));
    assert_memory_equal(tally->balance, fresh.balance, sizeof fresh.balance);
    assert_memory_equal(tally->count, fresh.count, sizeof fresh.count);
    assert_int_equal(tally->lost.count, 0);
    cml_tally_free(&fresh);
}

static void moving_takes_every_cell_once(void **state)
{
    (void)state;
    struct cml_tally a = make_tally(&grid), b = make_tally(&grid);
    fill(&a, 1000);
    fill(&b, 50000);
    cml_tally_move(&a, &b);
    uint64_t wanted = 51000;
    for (size_t i = 0; i < cml_tally_cells(&grid); i++, wanted += 2) assert_int_equal(a.A_l[i], wanted);
    for (int i = 0; i < CML_NUM_BALANCE_TERMS; i++, wanted += 2) assert_int_equal(a.balance[i], wanted);
    for (int i = 0; i < CML_NUM_COUNTS; i++, wanted += 2) assert_int_equal(a.count[i], wanted);
    assert_zero(&b);
    cml_tally_zero(&a);
    assert_zero(&a);
    cml_tally_free(&a);
    cml_tally_free(&b);
}

/* The maps of a tally: pointers to the arrays and their numbers of cells. */
#define MAPS 6
static int map_cells(const struct cml_tally *t, uint64_t **cells)
{
    const int parts = (int)t->layout.parts[CML_ARRAY_Rd_xya];
    uint64_t *const arrays[MAPS] = {t->Rd_xya, t->A_xyz, t->phi_xyz, t->facets, t->detector_map, t->Rd_dir};
    const int counts[MAPS] = {2 * 6 * parts,        9,         8 * CML_NUM_GROUPS,
                              2 * CML_FACET_SCORES, 5 * parts, 3 * 2 * parts};
    int n = 0;
    for (int a = 0; a < MAPS; a++)
        for (int i = 0; i < counts[a]; i++) cells[n++] = &arrays[a][i];
    return n;
}

/* Returns a grid in which each group has its own maps, directions and pixels, or in which they have
 * squares. */
static struct cml_tally_grid grid_of_maps(bool by_group)
{
    struct cml_tally_grid of = map_grid;
    of.nt = 1;
    of.np = 2;
    of.detector_pixels = 5;
    cml_tally_set_groups(&of);
    of.cell_errors = false;
    of.voxel_step = of.facet_step = 0;
    if (!by_group) of.map_once.step = of.pixel_once.step = of.direction_once.step = 0;
    return of;
}

static void assert_maps_have_cells_of_their_own(const struct cml_tally_grid *of)
{
    struct cml_tally a = make_tally(of);
    struct cml_result result = make_result(of, 64);
    uint64_t *cells[1024];
    const int n = map_cells(&a, cells), pixels = 12 * (int)a.layout.parts[CML_ARRAY_Rd_xya];
    assert_true(a.Tt_xya == a.Rd_xya + 6 && a.Tt_dir == a.Rd_dir + 2 && a.Rsp_dir == a.Tt_dir + 2);
    assert_int_equal(cml_tally_cells(of), cml_tally_cells(&grid) + (size_t)n);
    for (int i = 0; i < n; i++) *cells[i] = (uint64_t)i + 1;
    for (int i = 0; i < n; i++) assert_int_equal(*cells[i], i + 1);
    for (int i = 0; i < 24; i++)
        assert_int_equal(a.A_rz[i], 0); /* the arrays do not overlap with those before */
    add_to_batch(&result, 0, &a);
    add_to_batch(&result, 1, &a);
    for (int i = 0; i < pixels; i++) assert_true(result.Rd_xya[i] == 2 * a.Rd_xya[i]);
    for (int i = 0; i < 9; i++) assert_true(result.A_xyz[i] == 2 * a.A_xyz[i]);
    for (int i = 0; i < 8 * CML_NUM_GROUPS; i++) assert_true(result.phi_xyz[i] == 2 * a.phi_xyz[i]);
    for (int i = 0; i < 2 * CML_FACET_SCORES; i++) assert_true(result.facets[i] == 2 * a.facets[i]);
    for (int i = 0; i < 5; i++) assert_true(result.detector_map[i] == 2 * a.detector_map[i]);
    for (int i = 0; i < 6; i++) assert_true(result.Rd_dir[i] == 2 * a.Rd_dir[i]);
    for (int i = 0; i < 12; i++) assert_true(result.A_rz[i] == 0);
    for (int i = 0; i < CML_NUM_BATCHES * 3; i++)
        assert_true(result.Rd_r[i] == 0); /* nor with those behind */
    cml_result_free(&result);
    cml_tally_zero(&a);
    for (int i = 0; i < n; i++) assert_int_equal(*cells[i], 0);
    cml_tally_free(&a);
}

static void maps_have_cells_of_their_own(void **state)
{
    (void)state;
    for (int by_group = 0; by_group < 2; by_group++) {
        const struct cml_tally_grid of = grid_of_maps(by_group);
        assert_maps_have_cells_of_their_own(&of);
    }
}

/* Arrays of up to 65536 cells are kept by group, larger ones are not. Rows count with their cells, at
 * least 16. */
static void small_arrays_are_kept_by_group(void **state)
{
    (void)state;
    struct cml_tally_grid of = {
        .nx = 256, .ny = 256, .map_na = 1, .nt = 64, .np = 64, .detector_pixels = 65536};
    of.rows = 16;
    cml_tally_set_groups(&of);
    assert_int_equal(of.map_once.step, 2 * 65537);
    assert_int_equal(of.pixel_once.step, 65536);
    assert_int_equal(of.direction_once.step, 3 * 4096);
    of.map_na = 2;
    of.rows++;
    of.detector_pixels++;
    cml_tally_set_groups(&of);
    assert_true(!of.map_once.step && !of.pixel_once.step && !of.direction_once.step);
    assert_int_equal(of.map_once.squares, 4 * 65537);
    assert_int_equal(of.direction_once.squares, 3 * 4096);
}

/* Threads borrow the maps of the owner: merging their tallies leaves the maps unchanged. */
static void borrowed_maps_are_not_merged(void **state)
{
    (void)state;
    const struct cml_tally_grid small = cml_tally_grid_of_thread(&map_grid);
    struct cml_tally owner = make_tally(&map_grid), thread = make_tally(&small);
    assert_true(cml_tally_bytes(&small) == cml_tally_bytes(&grid));
    assert_null(thread.Rd_xya);
    assert_null(thread.facets);
    cml_tally_borrow(&thread, &owner);
    thread.Rd_xya[5] += 7;
    thread.A_xyz[8] += 8;
    thread.phi_xyz[127] += 8;
    thread.facets[1] += 9;
    thread.A_rz[11] += 10;
    thread.A_l[0] += 11;
    cml_tally_move(&owner, &thread);
    assert_int_equal(owner.Rd_xya[5], 7);
    assert_int_equal(owner.A_xyz[8], 8);
    assert_int_equal(owner.phi_xyz[127], 8);
    assert_int_equal(owner.facets[1], 9);
    assert_int_equal(owner.A_rz[11], 10);
    assert_int_equal(owner.A_l[0], 11);
    cml_tally_free(&thread);
    cml_tally_free(&owner);
}

/* Two threads score into one shared A_rz, each in its own batch. Its cells are told apart by each thread's
 * A_z, and come into the result once. */
static void threads_that_share_absorption_have_batches_of_their_own(void **state)
{
    (void)state;
    const struct cml_tally_grid large = {
        .nr = 1 << 10, .nz = 1 << 10, .na = 1, .num_layers = 1, .absorption = true};
    const struct cml_tally_grid small = cml_tally_grid_of_thread(&large);
    assert_true(small.depths && !small.absorption);
    struct cml_tally owner = make_tally(&large), thread[2] = {make_tally(&small), make_tally(&small)};
    struct cml_result result = make_result(&large, 1000);
    for (int t = 0; t < 2; t++) {
        cml_tally_borrow(&thread[t], &owner);
        thread[t].A_rz[7 * (large.nz + 2) + 3] += 5; /* r bin 7, z bin 2 */
        thread[t].A_z[3] += 5;
        thread[t].Rd_ra[4] += 3;
        cml_tally_sum_batch(&thread[t], 10 + t);
        cml_result_add_batch(&result, 10 + t, &thread[t]);
    }
    for (int t = 0; t < 2; t++) cml_result_add(&result, &thread[t]);
    cml_result_add(&result, &owner);
    for (int t = 0; t < 2; t++) {
        assert_true(result.A_z[(10 + t) * large.nz + 2] == 5);
        assert_true(result.Rd_r[(10 + t) * large.nr + 4] == 3);
        cml_tally_move(&owner, &thread[t]);
        assert_true(thread[t].A_z[3] == 0 && thread[t].Rd_ra[4] == 0);
    }
    assert_true(result.A_rz[7 * large.nz + 2] == 10 && result.Rd_ra[4] == 6);
    assert_true(owner.A_rz[7 * (large.nz + 2) + 3] == 10 && owner.Rd_ra[4] == 6);
    for (int t = 0; t < 2; t++) cml_tally_free(&thread[t]);
    cml_tally_free(&owner);
    cml_result_free(&result);
}

/* Late packets score into rows of their own batches, not of the batch under way. Rows start at 0 again
 * after they are cleared. */
static void late_packets_are_noted_in_their_own_batches(void **state)
{
    (void)state;
    const struct cml_layout at = cml_layout_of(&grid, CML_OF_PROFILES);
    struct cml_tally tally = make_tally(&grid);
    struct cml_result result = make_result(&grid, 1000);
    static const int late[] = {3, 63, 3, 0};
    for (int batch = 10; batch < 12; batch++) {
        tally.Rd_ra[1 * grid.na] += 100; /* r bin 1, angle 0; half of it from late packets */
        tally.A_rz[2] += 100;            /* z bin 1 */
        for (int i = 0; i < 4; i++) {
            uint64_t *row = cml_tally_late(&tally, late[i]);
            row[at.Rd_r + 1] += (uint64_t)(20 - 5 * i);
            row[at.A_z + 2] += (uint64_t)(20 - 5 * i);
        }
        assert_int_equal(tally.late.count, 3);
        cml_tally_sum_batch(&tally, batch);
        cml_result_add_batch(&result, batch, &tally);
        cml_tally_drop_late(&tally);
        assert_int_equal(tally.late.count, 0);
    }
    static const uint64_t noted[CML_NUM_BATCHES] = {[0] = 10, [3] = 60, [10] = 50, [11] = 50, [63] = 30};
    for (int b = 0; b < CML_NUM_BATCHES; b++) {
        assert_true(result.Rd_r[b * grid.nr + 1] == noted[b]);
        assert_true(result.A_z[b * grid.nz + 1] == noted[b]);
    }
    for (size_t i = 0; i < CML_NUM_BATCHES * at.cells; i++) assert_int_equal(tally.late.rows[i], 0);
    cml_tally_free(&tally);
    cml_result_free(&result);
}

/* Batches 5 and 21 belong to one group, batch 6 to another: profiles are kept by batch, cells by group. */
static void groups_have_cells_each(void **state)
{
    (void)state;
    struct cml_tally_grid apart = grid;
    apart.cell_errors = true;
    const struct cml_layout at = cml_layout_of(&apart, CML_OF_PROFILES);
    struct cml_tally tally = make_tally(&apart);
    const size_t cells = tally.layout.size[CML_ARRAY_A_rz], exits = tally.layout.size[CML_ARRAY_Rd_ra];
    struct cml_result result = make_result(&apart, 1000);
    tally.A_rz[5 * cells + 2] += 100;  /* z bin 1 */
    tally.Tt_ra[5 * exits + 3] += 100; /* r bin 1, angle 1 */
    tally.A_rz[6 * cells + 2] += 7;
    tally.Tt_ra[6 * exits + 3] += 7;
    for (int batch = 5; batch < 7; batch++) {
        uint64_t *const late = cml_tally_late(&tally, batch);
        late[at.A_z + 2] += late[at.Tt_r + 1] += late[at.Tt_a + 1] += batch == 5 ? 30 : 7;
    }
    for (int n = 0; n < 2; n++) { /* the second time nothing is new */
        cml_tally_sum_batch(&tally, 21);
        cml_result_add_batch(&result, 21, &tally);
        cml_tally_drop_late(&tally);
    }
    cml_result_add(&result, &tally);
    for (int b = 0; b < CML_NUM_BATCHES; b++) {
        const cml_u128 noted = b == 21 ? 70 : b == 5 ? 30 : b == 6 ? 7 : 0;
        assert_true(result.A_z[b * 4 + 1] == noted && result.Tt_r[b * 3 + 1] == noted);
        assert_true(result.Tt_a[b * 2 + 1] == noted && result.Rd_r[b * 3 + 1] == 0);
    }
    assert_true(result.A_rz[5 * 12 + 1] == 100 && result.A_rz[6 * 12 + 1] == 7);
    assert_true(result.Tt_ra[5 * 6 + 3] == 100 && result.Tt_ra[6 * 6 + 3] == 7);
    assert_true(cml_result_cell_sum(result.A_rz + 1, CML_NUM_GROUPS, 12) == 107);
    assert_true(cml_result_cell_sum(result.Tt_ra + 3, CML_NUM_GROUPS, 6) == 107);
    cml_tally_zero(&tally);
    cml_tally_sum_batch(&tally, 5);
    assert_int_equal(tally.batch_sums[at.A_z + 2], 0);
    cml_tally_free(&tally);
    cml_result_free(&result);
}

static void the_list_of_lost_packets_keeps_the_smallest_in_order(void **state)
{
    (void)state;
    struct cml_tally a = make_tally(&grid), b = make_tally(&grid);
    for (uint64_t i = 0; i < 20; i++) cml_lost_list_add(i & 1 ? &a.lost : &b.lost, 7 * i % 20 + 100);
    cml_tally_move(&a, &b);
    assert_int_equal(a.lost.count, CML_LOST_LISTED);
    for (int i = 0; i < CML_LOST_LISTED; i++) assert_int_equal(a.lost.index[i], 100 + i);
    assert_int_equal(b.lost.count, 0);
    cml_tally_zero(&a);
    assert_int_equal(a.lost.count, 0);
    cml_tally_free(&a);
    cml_tally_free(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_new_tally_is_zero_and_has_all_its_cells),
        cmocka_unit_test(moving_takes_every_cell_once),
        cmocka_unit_test(maps_have_cells_of_their_own),
        cmocka_unit_test(small_arrays_are_kept_by_group),
        cmocka_unit_test(borrowed_maps_are_not_merged),
        cmocka_unit_test(threads_that_share_absorption_have_batches_of_their_own),
        cmocka_unit_test(late_packets_are_noted_in_their_own_batches),
        cmocka_unit_test(groups_have_cells_each),
        cmocka_unit_test(the_list_of_lost_packets_keeps_the_smallest_in_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
