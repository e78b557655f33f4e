/* Tests of checkpoints: saving, loading, finished runs, parts of a run, and every kind of damaged file.
 * SPDX-License-Identifier: MIT */
#include "run/checkpoint.h"
#include "lib/dice.h"

#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

static const struct cml_tally_grid grid = {.nr = 3,
                                           .nz = 4,
                                           .na = 2,
                                           .num_layers = 2,
                                           .absorption = true,
                                           .saved = {.limit = 3, .media = 4, .beams = 1}};
static const char identity[] = "program x\nseed 1\ninput a.mci of 3 bytes, crc32 00000001\n";
enum { BEGIN = 64, END = 128 }; /* photon indices of the round */
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
    result.summary.count[CML_COUNT_PHOTONS] = END - seed - 2; /* photons that save() does not leave open */
    if (seed) cml_lost_list_add(&result.summary.lost, seed);
    for (uint64_t i = 0; seed && i < 5; i++) {
        uint64_t row[13] = {seed + 90 - 20 * i, i};
        assert_int_equal(cml_saved_row_bytes(4), sizeof row);
        cml_saved_add(result.saved, row, 1);
    }
    return result;
}

static void assert_same(struct cml_result *a, struct cml_result *b)
{
    size_t cells = 0;
    const cml_u128 *cell = cml_result_cells(a, &cells);
    assert_memory_equal(cell, cml_result_cells(b, &cells), cells * sizeof *cell);
    assert_memory_equal(&a->summary, &b->summary, sizeof a->summary);
    const struct cml_saved_sums one = cml_saved_sort(a->saved), other = cml_saved_sort(b->saved);
    assert_int_equal(one.found, other.found);
    assert_int_equal(one.kept, other.kept);
    assert_memory_equal(cml_saved_row(a->saved, 0), cml_saved_row(b->saved, 0),
                        one.kept * cml_saved_row_bytes(4));
}

static void save(uint32_t seed)
{
    struct cml_result result = new_result(seed);
    struct cml_run_state state = {.begin = BEGIN, .end = END, .seconds = seed};
    assert_int_equal(cml_ranges_add(&state.open, (struct cml_range){100, seed}, &err), CML_OK);
    assert_int_equal(cml_ranges_add(&state.open, (struct cml_range){70, 2}, &err), CML_OK);
    assert_int_equal(cml_checkpoint_write(path, identity, NULL, &state, &result, &err), CML_OK);
    cml_ranges_clear(&state.open);
    cml_result_free(&result);
}

static cml_status read_as(const char *who, enum cml_checkpoint_kind *kind, uint32_t expected_seed)
{
    struct cml_result result = new_result(0), expected = new_result(expected_seed);
    struct cml_run_state state = {.begin = 0};
    struct cml_record record = {0};
    const cml_status status =
        cml_checkpoint_read(path, who, kind, &state, &result, false, &record, &note, &err);
    cml_record_clear(&record);
    if (status == CML_OK && *kind == CML_CHECKPOINT_PARTIAL) {
        assert_same(&result, &expected);
        assert_int_equal(state.begin, BEGIN);
        assert_int_equal(state.end, END);
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
    assert_int_equal(unlink(path), 0); /* the state after a crash between the two renames */
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

/* Offsets in the file of save(5): the numbers of the head, then the identity, two ranges, the summary. */
enum {
    AT_ORDER = 24,
    AT_VERSION = 32,
    AT_IDENTITY_SIZE = 48,
    AT_JSON_SIZE = 56,
    AT_NUM_RANGES = 64,
    AT_NUM_CELLS = 72,
    AT_NUM_SAVED = 80,
    AT_FOUND = 88,
    AT_BEGIN = 96,
    AT_END = 104,
    AT_SECONDS = 112,
    AT_PART = 120,
    AT_PARTS = 128,
    AT_RECORDED = 152, /* counts of each kind, 8 bytes each */
    AT_NUM_LAYERS = AT_RECORDED + 8 * CML_RECORDED_LAYERS,
    AT_NUM_EXPECTED = AT_RECORDED + 8 * CML_RECORDED_EXPECTED,
    AT_NUM_DETECTORS = AT_RECORDED + 8 * CML_RECORDED_DETECTORS,
    AT_NUM_FLUXES = AT_RECORDED + 8 * CML_RECORDED_FLUXES,
    AT_RANGES = 136 + sizeof(struct cml_record) + sizeof identity - 1,
    AT_SUMMARY = AT_RANGES + 2 * sizeof(struct cml_range),
    AT_PHOTONS = AT_SUMMARY + offsetof(struct cml_summary, count) + 16 * CML_COUNT_PHOTONS,
    AT_LOST_COUNT = AT_SUMMARY + offsetof(struct cml_summary, lost.count),
    AT_LOST = AT_SUMMARY + offsetof(struct cml_summary, lost.index)
};

/* Writes a value at an offset of the file and makes the checksum right again. */
static void forge(long place, const void *value, size_t size)
{
    static unsigned char bytes[1 << 16];
    FILE *file = fopen(path, "r+b");
    const size_t length = fread(bytes, 1, sizeof bytes, file) - 8;
    memcpy(bytes + place, value, size);
    const uint64_t sum = crc32_z(crc32(0, NULL, 0), bytes, length);
    memcpy(bytes + length, &sum, sizeof sum);
    rewind(file);
    assert_int_equal(fwrite(bytes, 1, length + 8, file), length + 8);
    fclose(file);
}

static void assert_forged_is_refused(long place, uint64_t value, size_t size)
{
    enum cml_checkpoint_kind kind;
    save(5);
    forge(place, &value, size);
    char old[80];
    name_of(".old", old);
    unlink(old);
    if (read_as(identity, &kind, 5) != CML_E_INPUT || !strstr(err.text, "damaged"))
        fail_msg("place %ld, value %#llx: '%s'", place, (unsigned long long)value, err.text);
}

static void forged_numbers_are_refused_though_the_checksum_is_right(void **state)
{
    (void)state;
    static const struct {
        long place;
        uint64_t value;
        size_t size;
    } cases[] = {
        {AT_IDENTITY_SIZE, UINT64_MAX, 8}, /* wraps to an empty buffer */
        {AT_IDENTITY_SIZE, UINT64_MAX - 1, 8},
        {AT_IDENTITY_SIZE, 1u << 20, 8}, /* longer than the file */
        {AT_JSON_SIZE, UINT64_MAX, 8},
        {AT_JSON_SIZE, 1u << 20, 8},
        {AT_NUM_RANGES, 1, 8}, /* an open range is missing */
        {AT_NUM_RANGES, UINT64_MAX, 8},
        {AT_NUM_CELLS, 0, 8},
        {AT_NUM_CELLS, UINT64_MAX, 8},
        {AT_NUM_SAVED, 2, 8}, /* one row is left over */
        {AT_NUM_SAVED, 4, 8},
        {AT_NUM_SAVED, UINT64_MAX, 8},
        {AT_FOUND, 2, 8}, /* fewer found than saved */
        {AT_FOUND, END + 1, 8},
        {AT_BEGIN, END, 8}, /* a round without photons */
        {AT_BEGIN, END + 1, 8},
        {AT_END, 0, 8},
        {AT_END, UINT64_MAX, 8},
        {AT_SECONDS, 0x7ff0000000000000u, 8}, /* infinite time */
        {AT_SECONDS, 0xbff0000000000000u, 8}, /* time of -1 s */
        {AT_NUM_LAYERS, CML_RECORD_MEDIA + 1, 8},
        {AT_NUM_LAYERS, UINT64_MAX, 8}, /* -1 layers */
        {AT_NUM_EXPECTED, CML_RECORD_MEDIA + 2, 8},
        {AT_NUM_EXPECTED, UINT64_MAX, 8}, /* -1 expected values */
        {AT_NUM_DETECTORS, CML_RECORD_MEDIA + 1, 8},
        {AT_NUM_DETECTORS, UINT64_MAX, 8}, /* -1 detectors */
        {AT_NUM_FLUXES, 1, 8},             /* not four fluxes per body */
        {AT_RANGES, 127, 8},               /* range {127, 5}: beyond the end */
        {AT_RANGES, UINT64_MAX - 2, 8},    /* range whose first + count wraps */
        {AT_RANGES, 63, 8},                /* range before the round */
        {AT_RANGES, 70, 8},                /* range that overlaps {70, 2} */
        {AT_RANGES + 8, 0, 8},             /* empty range */
        {AT_RANGES + 8, 4, 8},             /* one index is neither flown nor open */
        {AT_PHOTONS, END - 6, 8},
        {AT_LOST_COUNT, 1u << 20, 4},
        {AT_LOST_COUNT, 0xffffffffu, 4}, /* -1 lost packets */
        {AT_LOST, END, 8},               /* index outside the run */
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_forged_is_refused(cases[i].place, cases[i].value, cases[i].size);
    const long last = size_of(path) - 8 - (long)cml_saved_row_bytes(4);
    assert_forged_is_refused(last, END, 8);     /* index outside the run */
    assert_forged_is_refused(last, 90 - 65, 8); /* not above the row before */
}

/* A checkpoint of another program, machine or version is refused, though its checksum is right. */
static void what_cannot_be_understood_is_refused(void **state)
{
    (void)state;
    static const struct {
        long place;
        uint64_t value;
        const char *text;
    } cases[] = {
        {0, 0x6c63207265746f6eu, ": is no checkpoint"},
        {AT_ORDER, 0x0807060504030201u,
         ": another version of clustermcml or another kind of machine wrote the checkpoint (expected format "
         "17; "},
        {AT_VERSION, 1,
         ": another version of clustermcml or another kind of machine wrote the checkpoint (expected format "
         "17; "},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        enum cml_checkpoint_kind kind;
        char old[80];
        save(5);
        forge(cases[i].place, &cases[i].value, sizeof cases[i].value);
        name_of(".old", old);
        unlink(old);
        assert_int_equal(read_as(identity, &kind, 5), CML_E_INPUT);
        if (!strstr(err.text, cases[i].text)) fail_msg("'%s', not '%s'", err.text, cases[i].text);
    }
}

/* A checkpoint must be a regular file: opening a pipe for reading waits for a writer, and a device may
 * never end. */
static void what_is_no_regular_file_is_refused(void **state)
{
    (void)state;
    enum cml_checkpoint_kind kind;
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_int_equal(read_as(identity, &kind, 0), CML_E_INPUT);
    assert_non_null(strstr(err.text, "expected a regular file"));
    assert_int_equal(unlink(path), 0);
    assert_int_equal(symlink("/dev/zero", path), 0);
    assert_int_equal(read_as(identity, &kind, 0), CML_E_INPUT);
    assert_non_null(strstr(err.text, "expected a regular file"));
}

static void a_finished_run_says_so(void **state)
{
    (void)state;
    const struct cml_run_state nothing = {.begin = 0};
    const struct cml_record record = {.json = NULL};
    enum cml_checkpoint_kind kind;
    assert_int_equal(cml_checkpoint_finish(path, identity, &nothing, &record, NULL, &err), CML_OK);
    assert_int_equal(read_as(identity, &kind, 0), CML_OK);
    assert_int_equal(kind, CML_CHECKPOINT_FINISHED);
    assert_false(cml_checkpoint_look(path).tallies);
}

/* A finished run can be continued with its record, and with its tallies if they were kept and are asked
 * for. */
static void a_finished_run_can_be_gone_on_with(void **state)
{
    (void)state;
    struct cml_result result = new_result(7), again = new_result(0);
    struct cml_run_state done = {.begin = BEGIN, .end = END, .seconds = 3}, read = {.begin = 0};
    struct cml_record record = {.photons = END, .lost = 2, .value = {0.25}, .error = {0.5}, .json = "{}\n"},
                      back = {0};
    enum cml_checkpoint_kind kind;
    result.summary.count[CML_COUNT_PHOTONS] = END;
    assert_int_equal(cml_checkpoint_finish(path, identity, &done, &record, NULL, &err), CML_OK);
    assert_int_equal(cml_checkpoint_read(path, identity, &kind, &read, &again, true, &back, &note, &err),
                     CML_E_INPUT);
    assert_non_null(strstr(err.text, "has no tallies (expected those of a run with --keep)"));
    cml_record_clear(&back);
    save(5);
    assert_int_equal(cml_checkpoint_finish(path, identity, &done, &record, &result, &err), CML_OK);
    char old[80];
    name_of(".old", old);
    assert_int_equal(access(old, F_OK), -1);
    assert_int_equal(cml_checkpoint_read(path, identity, &kind, &read, &again, true, &back, &note, &err),
                     CML_OK);
    assert_int_equal(kind, CML_CHECKPOINT_FINISHED);
    assert_same(&result, &again);
    assert_int_equal(read.open.total, 0);
    assert_int_equal(read.end, END);
    assert_true(back.value[0] == 0.25 && back.error[0] == 0.5 && back.lost == 2 && back.photons == END);
    assert_string_equal(back.json, "{}\n");
    const struct cml_checkpoint_about about = cml_checkpoint_look(path);
    assert_true(about.kind == CML_CHECKPOINT_FINISHED && about.tallies && about.begin == BEGIN &&
                about.end == END);
    cml_record_clear(&back);
    cml_result_free(&result);
    cml_result_free(&again);
}

/* Limits the size of files (bytes), which then fail like on a full disk. */
static void limit_files(rlim_t bytes)
{
    struct rlimit limit;
    getrlimit(RLIMIT_FSIZE, &limit);
    limit.rlim_cur = bytes;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

static void a_failed_write_leaves_the_old_one(void **state)
{
    (void)state;
    save(5);
    const struct cml_run_state nothing = {.begin = 0};
    const struct cml_record record = {.json = NULL};
    signal(SIGXFSZ, SIG_IGN);
    limit_files(50);
    const cml_status status = cml_checkpoint_finish(path, identity, &nothing, &record, NULL, &err);
    limit_files(RLIM_INFINITY);
    assert_int_equal(status, CML_E_IO);
    assert_reads(5);
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

/* Parts of a run share the turns of photons: each turn is in one part, in order, even if there are more
 * parts than turns. */
static void parts_share_all_turns(void **state)
{
    (void)state;
    static const uint64_t ends[][2] = {{0, 1}, {0, 1000}, {7, 10}, {(uint64_t)1 << 47, (uint64_t)1 << 48}};
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++)
        for (uint64_t count = 1; count <= 7; count++) {
            uint64_t turn = ends[i][0];
            for (uint64_t k = 1; k <= count; k++) {
                const struct cml_range turns =
                    cml_part_turns((struct cml_part){k, count}, ends[i][0], ends[i][1]);
                assert_true(turns.first == turn && turns.count <= (ends[i][1] - ends[i][0]) / count + 1);
                turn += turns.count;
            }
            assert_true(turn == ends[i][1]);
        }
}

/* The checkpoint of a part says which part it is. It holds the settings of its call, and nothing of the
 * rounds before the part's own. */
static void a_part_says_whose_it_is(void **state)
{
    (void)state;
    struct cml_result result = new_result(5);
    struct cml_run_state own = {.begin = BEGIN, .end = END, .part = {2, 3}}, read = {.begin = 0};
    struct cml_checkpoint_about about;
    struct cml_record record = {0};
    enum cml_checkpoint_kind kind;
    char *who = NULL, *call = NULL;
    result.summary.count[CML_COUNT_PHOTONS] = END - BEGIN - 5;
    assert_int_equal(cml_ranges_add(&own.open, (struct cml_range){100, 5}, &err), CML_OK);
    assert_int_equal(cml_checkpoint_write(path, identity, "run\na b.mci\n", &own, &result, &err), CML_OK);
    assert_int_equal(cml_part_look(path, &about, &who, &call, &err), CML_OK);
    assert_string_equal(who, identity);
    assert_string_equal(call, "run\na b.mci\n");
    assert_true(about.part.number == 2 && about.part.count == 3 && about.begin == BEGIN && about.end == END);
    assert_int_equal(cml_checkpoint_read(path, identity, &kind, &read, &result, true, &record, &note, &err),
                     CML_OK);
    assert_true(kind == CML_CHECKPOINT_PARTIAL && read.part.number == 2 && read.part.count == 3);
    cml_record_clear(&record);
    cml_ranges_clear(&read.open);
    cml_ranges_clear(&own.open);
    cml_result_free(&result);
    free(who);
    free(call);
}

static void what_is_no_part_is_refused(void **state)
{
    (void)state;
    struct cml_checkpoint_about about;
    char *who, *call;
    save(5);
    assert_int_equal(cml_part_look(path, &about, &who, &call, &err), CML_E_INPUT);
    assert_non_null(strstr(err.text, ": is no part of a run"));
    forge(AT_PART, &(uint64_t){4}, 8);
    forge(AT_PARTS, &(uint64_t){3}, 8);
    assert_int_equal(cml_part_look(path, &about, &who, &call, &err), CML_E_INPUT);
    enum cml_checkpoint_kind kind;
    assert_int_equal(read_as(identity, &kind, 0), CML_E_INPUT);
    assert_non_null(strstr(err.text, "damaged (its head)"));
    cml_checkpoint_remove(path);
    assert_int_equal(cml_part_look(path, &about, &who, &call, &err), CML_E_INPUT);
    assert_non_null(strstr(err.text, ": cannot be read"));
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
        cmocka_unit_test_teardown(forged_numbers_are_refused_though_the_checksum_is_right, clean),
        cmocka_unit_test_teardown(what_cannot_be_understood_is_refused, clean),
        cmocka_unit_test_teardown(what_is_no_regular_file_is_refused, clean),
        cmocka_unit_test_teardown(a_finished_run_says_so, clean),
        cmocka_unit_test_teardown(a_finished_run_can_be_gone_on_with, clean),
        cmocka_unit_test_teardown(a_failed_write_leaves_the_old_one, clean),
        cmocka_unit_test(parts_share_all_turns),
        cmocka_unit_test_teardown(a_part_says_whose_it_is, clean),
        cmocka_unit_test_teardown(what_is_no_part_is_refused, clean),
    };
    return cmocka_run_group_tests(tests, choose_path, leave);
}
