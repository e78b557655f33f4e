/* Fuzzes checkpoints whose checksum is right, with any content. The input is a checkpoint without its
 * checksum. SPDX-License-Identifier: MIT */
#include "fuzz/fuzz.h"

#include "run/checkpoint.h"

#include <math.h>
#include <stddef.h>
#include <zlib.h>

/* Sizes in bytes: of a file, and of its head, which ends with a record. */
enum { MOST = 1 << 16, HEAD = 136 + sizeof(struct cml_record) };
enum {
    IDENTITY_SIZE = 48,
    JSON_SIZE = 56,
    NUM_RANGES = 64,
    NUM_SAVED = 80,
    END = 104
}; /* offsets of these numbers in the head */

/* The grid of the checkpoints that tests/fuzz/corpus.sh makes. */
static const struct cml_tally_grid grid = {.nr = 1,
                                           .nz = 1,
                                           .na = 1,
                                           .num_layers = 1,
                                           .absorption = true,
                                           .saved = {.limit = 3, .media = 3, .beams = 1}};

/* A checkpoint under repair. */
struct file {
    uint8_t data[MOST + sizeof(uint64_t)];
    size_t size; /* bytes without the checksum */
};

static uint64_t number_at(const struct file *file, size_t place)
{
    uint64_t number = 0;
    memcpy(&number, file->data + place, sizeof number);
    return number;
}

/* Copies the identity that the file itself claims, so that most files pass the check of their run. */
static void claimed(const struct file *file, char identity[MOST])
{
    const uint64_t length = file->size >= HEAD ? number_at(file, IDENTITY_SIZE) : 0;
    identity[0] = '\0';
    if (length == 0 || length > file->size - HEAD || length >= MOST) return;
    memcpy(identity, file->data + HEAD, length);
    identity[length] = '\0';
}

/* Appends zeros up to the length that the head asks for, because few inputs have it by chance. In every
 * second file the number of packets flown is set to what the open ranges leave. */
static void repair(struct file *file, size_t cells)
{
    const size_t size = file->size;
    if (size < HEAD) return;
    const uint64_t identity = number_at(file, IDENTITY_SIZE), ranges = number_at(file, NUM_RANGES);
    const uint64_t json = number_at(file, JSON_SIZE), saved = number_at(file, NUM_SAVED);
    if (identity > MOST || json > MOST || saved > MOST || ranges > MOST / sizeof(struct cml_range)) return;
    const size_t place = HEAD + identity + json + ranges * sizeof(struct cml_range),
                 whole = place + sizeof(struct cml_summary) + cells * sizeof(cml_u128) +
                         saved * cml_saved_row_bytes(grid.saved.media);
    if (whole > MOST || size > whole) return;
    memset(file->data + size, 0, whole - size);
    file->size = whole;
    if (crc32_z(0, file->data, size) % 2 == 0) return;
    cml_u128 flown = number_at(file, END);
    for (size_t i = 0; i < ranges; i++)
        flown -= number_at(file, HEAD + identity + json + i * sizeof(struct cml_range) + sizeof(uint64_t));
    memcpy(file->data + place + offsetof(struct cml_summary, count[CML_COUNT_PHOTONS]), &flown, sizeof flown);
}

/* Checks that open and flown indices make up the round, each index once; run.c relies on it. No index need
 * be open: rows that are still to be written have flown all. */
static void check(const struct cml_run_state *state, const struct cml_result *result)
{
    const struct cml_ranges *open = &state->open;
    uint64_t total = 0;
    FUZZ_CHECK(state->begin < state->end && state->end <= (uint64_t)1 << 48);
    FUZZ_CHECK(isfinite(state->seconds) && state->seconds >= 0);
    for (size_t i = 0; i < open->count; i++) {
        const struct cml_range *range = &open->item[i];
        FUZZ_CHECK(range->count > 0 && range->first >= state->begin && range->first < state->end &&
                   range->count <= state->end - range->first);
        total += range->count;
        for (size_t j = 0; j < i; j++)
            FUZZ_CHECK(range->first >= open->item[j].first + open->item[j].count ||
                       open->item[j].first >= range->first + range->count);
    }
    FUZZ_CHECK(total == open->total);
    const uint64_t before = state->part.count > 0 ? state->begin : 0;
    FUZZ_CHECK(result->summary.count[CML_COUNT_PHOTONS] == state->end - before - total);
    FUZZ_CHECK(result->summary.lost.count >= 0 && result->summary.lost.count <= CML_LOST_LISTED);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct file file;
    static char identity[MOST];
    struct cml_error err = {CML_OK, ""}, note;
    struct cml_result result;
    struct cml_run_state state = {.begin = 0};
    struct cml_record record = {0};
    enum cml_checkpoint_kind kind;
    size_t cells = 0;
    if (size == 0 || size > MOST) return 0;
    FUZZ_CHECK(cml_result_create(&grid, 1000, &result, &err) == CML_OK);
    (void)cml_result_cells(&result, &cells);
    memcpy(file.data, data, size);
    file.size = size;
    repair(&file, cells);
    claimed(&file, identity);
    const uint64_t sum = crc32_z(crc32(0, NULL, 0), file.data, file.size);
    memcpy(file.data + file.size, &sum, sizeof sum);
    const cml_status status =
        cml_checkpoint_read(fuzz_file(file.data, file.size + sizeof sum), identity, &kind, &state, &result,
                            size % 2 == 0, &record, &note, &err);
    if (status != CML_OK) fuzz_refused(status, &err);
    if (status == CML_OK &&
        (kind == CML_CHECKPOINT_PARTIAL || (kind == CML_CHECKPOINT_FINISHED && size % 2 == 0)))
        check(&state, &result);
    cml_record_clear(&record);
    cml_ranges_clear(&state.open);
    cml_result_free(&result);
    return 0;
}
