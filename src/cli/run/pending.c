/* SPDX-License-Identifier: MIT */
#include "cli/run/pending.h"

#include "base/atomic_file.h"
#include "base/clock.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct cml_pending_row {
    char *checkpoint, *identity;
    struct cml_run_state state;
    struct cml_record record;
};

static void clear_row(struct cml_pending_row *row)
{
    free(row->checkpoint);
    free(row->identity);
    cml_record_clear(&row->record);
}

static void clear_all(struct cml_pending *pending)
{
    for (int i = 0; i < pending->count; i++) clear_row(&pending->row[i]);
    pending->count = 0;
}

void cml_pending_begin(struct cml_pending *pending)
{
    pending->flushed = cml_now();
    cml_file_defer_sync(true);
}

static cml_status grow(struct cml_pending *pending, struct cml_error *err)
{
    if (pending->count < pending->capacity) return CML_OK;
    const int capacity = pending->capacity ? 2 * pending->capacity : 64;
    struct cml_pending_row *larger = realloc(pending->row, (size_t)capacity * sizeof *larger);
    if (!larger) return cml_fail_memory(err, capacity * (double)sizeof *larger, "finished rows");
    pending->row = larger;
    pending->capacity = capacity;
    return CML_OK;
}

cml_status cml_pending_add(struct cml_pending *pending, const char *checkpoint, const char *identity,
                           const struct cml_run_state *state, const struct cml_record *record,
                           struct cml_error *err)
{
    CML_TRY(grow(pending, err));
    struct cml_pending_row row = {strdup(checkpoint), strdup(identity), *state, *record};
    row.record.json = strdup(record->json);
    if (!row.checkpoint || !row.identity || !row.record.json) {
        clear_row(&row);
        return cml_fail_memory(err, 1, "finished rows");
    }
    pending->row[pending->count++] = row;
    return CML_OK;
}

/* The results are on the disk before anything says so. */
void cml_pending_flush(struct cml_pending *pending, bool now)
{
    struct cml_error ignored;
    const double begin = cml_now();
    if (pending->count == 0 || (!now && begin - pending->flushed < fmax(1, 20 * pending->took))) return;
    cml_file_sync_deferred();
    for (int i = 0; i < pending->count; i++) {
        const struct cml_pending_row *row = &pending->row[i];
        if (cml_checkpoint_finish(row->checkpoint, row->identity, &row->state, &row->record, NULL,
                                  &ignored) != CML_OK)
            cml_checkpoint_remove(row->checkpoint);
    }
    cml_file_sync_deferred();
    clear_all(pending);
    pending->flushed = cml_now();
    pending->took = pending->flushed - begin;
}

void cml_pending_end(struct cml_pending *pending)
{
    cml_file_sync_deferred();
    cml_file_defer_sync(false);
    clear_all(pending);
    free(pending->row);
    *pending = (struct cml_pending){0};
}
