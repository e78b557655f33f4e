/* SPDX-License-Identifier: MIT */
#include "run/checkpoint.h"
#include "lib/dice.h"

#include <sys/stat.h>
#include <unistd.h>

static const struct cml_grid grid = {.nr = 3, .nz = 4, .na = 2, .num_layers = 2, .absorption = true};
static const char identity[] = "program x\nseed 1\ninput a.mci of 3 bytes, crc32 00000001\n";
static char path[64];
static struct cml_error err, note;

static void name_of(const char *suffix, char *name)
{
    snprintf(name, 80, "%s%s", path, suffix);
}

static struct cml_result new_result(uint32_t seed)
{
    struct cml_result result;
    struct dice dice = dice_new(seed);
    size_t cells = 0;
    assert_int_equal(cml_result_create(&grid, 1000, &result, &err), CML_OK);
    cml_u128 *cell = cml_result_cells(&result, &cells);
    for (size_t i = 0; seed && i < cells; i++) cell[i] = (cml_u128)dice_word(&dice) << (i % 90);
    for (int i = 0; seed && i < CML_NUM_COUNTS; i++) result.summary.count[i] = dice_word(&dice);
    for (int i = 0; seed && i < CML_NUM_TOTALS; i++)
        result.summary.square[i] = (cml_u128)dice_word(&dice) << 70;
    if (seed) cml_lost_list_add(&result.summary.lost, seed);
    return result;
}

static void assert_same(struct cml_result *a, struct cml_result *b)
{
    size_t cells = 0;
    const cml_u128 *cell = cml_result_cells(a, &cells);
    assert_memory_equal(cell, cml_result_cells(b, &cells), cells * sizeof *cell);
    assert_memory_equal(&a->summary, &b->summary, sizeof a->summary);
}

static void save(uint32_t seed)
{
    struct cml_result result = new_result(seed);
    struct cml_run_state state = {.begin = 64, .end = 128, .seconds = seed};
    assert_int_equal(cml_ranges_add(&state.open, (struct cml_range){100, seed}, &err), CML_OK);
    assert_int_equal(cml_ranges_add(&state.open, (struct cml_range){70, 2}, &err), CML_OK);
    assert_int_equal(cml_checkpoint_write(path, identity, &state, &result, &err), CML_OK);
    cml_ranges_clear(&state.open);
    cml_result_free(&result);
}

static cml_status read_as(const char *who, enum cml_checkpoint_kind *kind, uint32_t expected_seed)
{
    struct cml_result result = new_result(0), expected = new_result(expected_seed);
    struct cml_run_state state = {.begin = 0};
    const cml_status status = cml_checkpoint_read(path, who, kind, &state, &result, &note, &err);
    if (status == CML_OK && *kind == CML_CHECKPOINT_PARTIAL) {
        assert_same(&result, &expected);
        assert_int_equal(state.begin, 64);
        assert_int_equal(state.end, 128);
        assert_true(state.seconds == expected_seed);
        assert_int_equal(state.open.total, expected_seed + 2);
        assert_int_equal(state.open.item[0].first, 100);
    }
    cml_ranges_clear(&state.open);
    cml_result_free(&result);
    cml_result_free(&expected);
    return status;
}

static void assert_reads(uint32_t seed)
{
    enum cml_checkpoint_kind kind;
    assert_int_equal(read_as(identity, &kind, seed), CML_OK);
    assert_int_equal(kind, CML_CHECKPOINT_PARTIAL);
}

static long size_of(const char *name)
{
    struct stat about;
    return stat(name, &about) == 0 ? (long)about.st_size : -1;
}

static void flip(const char *name, long place)
{
    FILE *file = fopen(name, "r+b");
    assert_non_null(file);
    assert_int_equal(fseek(file, place, SEEK_SET), 0);
    const int byte = fgetc(file);
    assert_int_equal(fseek(file, place, SEEK_SET), 0);
    fputc(byte ^ 0x10, file);
    fclose(file);
}

static void what_is_written_is_read(void **state)
{
    (void)state;
    enum cml_checkpoint_kind kind;
    assert_int_equal(read_as(identity, &kind, 0), CML_OK);
    assert_int_equal(kind, CML_CHECKPOINT_NONE);
    save(5);
    assert_reads(5);
    assert_string_equal(note.text, "");
}

static void one_older_is_kept_and_used_when_the_new_one_is_damaged(void **state)
{
    (void)state;
    char old[80];
    name_of(".old", old);
    save(5);
    save(6);
    assert_reads(6);
    for (long place = 0; place < size_of(path); place += 7) {
        flip(path, place);
        assert_reads(5);
        assert_non_null(strstr(note.text, "damaged"));
        assert_non_null(strstr(note.text, "continuing from"));
        flip(path, place);
    }
    for (long size = size_of(path) - 1; size >= 0; size -= 11) {
        assert_int_equal(truncate(path, size), 0);
        assert_reads(5);
    }
    assert_int_equal(unlink(path), 0); /* as a crash between the two renames leaves it */
    assert_reads(5);
    assert_string_not_equal(note.text, "");
    save(7);
    flip(path, 100);
    flip(old, 100);
    enum cml_checkpoint_kind kind;
    assert_int_equal(read_as(identity, &kind, 0), CML_E_INPUT);
}

static void a_damaged_one_without_an_older_is_refused(void **state)
{
    (void)state;
    enum cml_checkpoint_kind kind;
    save(5);
    flip(path, size_of(path) / 2);
    assert_int_equal(read_as(identity, &kind, 0), CML_E_INPUT);
    assert_non_null(strstr(err.text, "damaged (checksum), and there is no older one"));
    assert_int_equal(truncate(path, 3), 0);
    assert_int_equal(read_as(identity, &kind, 0), CML_E_INPUT);
    assert_non_null(strstr(err.text, "cut short"));
}

static void that_of_another_run_is_refused_with_the_reason(void **state)
{
    (void)state;
    enum cml_checkpoint_kind kind;
    save(4);
    save(5);
    const char *other = "program x\nseed 2\ninput a.mci of 3 bytes, crc32 00000001\n";
    assert_int_equal(read_as(other, &kind, 0), CML_E_INPUT);
    assert_non_null(strstr(err.text, "of another run: 'seed 1' there, 'seed 2' here"));
    const char *longer = "program x\nseed 1\ninput a.mci of 3 bytes, crc32 00000001\ninput b.obj\n";
    assert_int_equal(read_as(longer, &kind, 0), CML_E_INPUT);
    assert_non_null(strstr(err.text, "'' there, 'input b.obj' here"));
}

static void a_finished_run_says_so(void **state)
{
    (void)state;
    const struct cml_run_state nothing = {.begin = 0};
    enum cml_checkpoint_kind kind;
    assert_int_equal(cml_checkpoint_write(path, identity, &nothing, NULL, &err), CML_OK);
    assert_int_equal(read_as(identity, &kind, 0), CML_OK);
    assert_int_equal(kind, CML_CHECKPOINT_FINISHED);
}

static void a_failed_write_leaves_the_old_one(void **state)
{
    (void)state;
    char temporary[80];
    name_of(".tmp", temporary);
    save(5);
    assert_int_equal(mkdir(temporary, 0700), 0);
    const struct cml_run_state nothing = {.begin = 0};
    assert_int_equal(cml_checkpoint_write(path, identity, &nothing, NULL, &err), CML_E_IO);
    assert_reads(5);
    assert_int_equal(rmdir(temporary), 0);
}

static int clean(void **state)
{
    (void)state;
    char old[80];
    cml_checkpoint_remove(path);
    name_of(".old", old);
    return size_of(path) == -1 && size_of(old) == -1 ? 0 : -1;
}

static int choose_path(void **state)
{
    (void)state;
    strcpy(path, "/tmp/cml_checkpoint_XXXXXX");
    if (!mkdtemp(path)) return -1;
    strcat(path, "/c");
    return 0;
}

static int leave(void **state)
{
    (void)state;
    path[strlen(path) - 2] = '\0';
    return rmdir(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(what_is_written_is_read, clean),
        cmocka_unit_test_teardown(one_older_is_kept_and_used_when_the_new_one_is_damaged, clean),
        cmocka_unit_test_teardown(a_damaged_one_without_an_older_is_refused, clean),
        cmocka_unit_test_teardown(that_of_another_run_is_refused_with_the_reason, clean),
        cmocka_unit_test_teardown(a_finished_run_says_so, clean),
        cmocka_unit_test_teardown(a_failed_write_leaves_the_old_one, clean),
    };
    return cmocka_run_group_tests(tests, choose_path, leave);
}
