/* Checkpoints whose checksum is right, whatever they hold. The input is a checkpoint without its checksum.
 * SPDX-License-Identifier: MIT */
#include "fuzz/fuzz.h"

#include "run/checkpoint.h"

#include <math.h>
#include <zlib.h>

enum {
    MOST = 1 << 16,
    HEAD = 88,
    IDENTITY_SIZE = 48
}; /* bytes of the head, and where in it that number is */

/* That of the checkpoints which tests/fuzz/corpus.sh makes. */
static const struct cml_grid grid = {.nr = 1, .nz = 1, .na = 1, .num_layers = 1, .absorption = true};

/* The identity that the file itself claims, so that most files get beyond the question whose they are. */
static void claimed(const uint8_t *data, size_t size, char identity[MOST])
{
    uint64_t length = 0;
    identity[0] = '\0';
    if (size < HEAD) return;
    memcpy(&length, data + IDENTITY_SIZE, sizeof length);
    if (length > size - HEAD || length >= MOST) return;
    memcpy(identity, data + HEAD, length);
    identity[length] = '\0';
}

/* What is open and what was flown make up the round, each index once; run.c relies on it. */
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
    FUZZ_CHECK(total == open->total && total > 0);
    FUZZ_CHECK(result->summary.count[CML_COUNT_PHOTONS] == state->end - total);
    FUZZ_CHECK(result->summary.lost.count >= 0 && result->summary.lost.count <= CML_LOST_LISTED);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static uint8_t file[MOST + sizeof(uint64_t)];
    static char identity[MOST];
    struct cml_error err = {CML_OK, ""}, note;
    struct cml_result result;
    struct cml_run_state state = {.begin = 0};
    enum cml_checkpoint_kind kind;
    if (size > MOST) return 0;
    const uint64_t sum = size > 0 ? crc32_z(crc32(0, NULL, 0), data, size) : 0;
    if (size > 0) memcpy(file, data, size);
    memcpy(file + size, &sum, sizeof sum);
    claimed(data, size, identity);
    FUZZ_CHECK(cml_result_create(&grid, 1000, &result, &err) == CML_OK);
    const cml_status status = cml_checkpoint_read(fuzz_file(file, size + sizeof sum), identity, &kind, &state,
                                                  &result, &note, &err);
    if (status != CML_OK) fuzz_refused(status, &err);
    if (status == CML_OK && kind == CML_CHECKPOINT_PARTIAL) check(&state, &result);
    cml_ranges_clear(&state.open);
    cml_result_free(&result);
    return 0;
}
