/* SPDX-License-Identifier: MIT */
#include "flights/pending.h"

#include "base/array.h"
#include "base/atomic_file.h"
#include "base/clock.h"
#include "simulation/scenes.h"

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

/* Forgets all finished rows that wait to be marked. */
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

cml_status cml_pending_add(struct cml_pending *pending, const char *checkpoint, const char *identity,
                           const struct cml_run_state *state, const struct cml_record *record,
                           struct cml_error *err)
{
    CML_TRY(
        cml_array_grow(&pending->row, (size_t)pending->count, sizeof *pending->row, "finished rows", err));
    struct cml_pending_row row = {strdup(checkpoint), strdup(identity), *state, *record};
    row.record.json = strdup(record->json);
    if (!row.checkpoint || !row.identity || !row.record.json) {
        clear_row(&row);
        return cml_fail_memory(err, 1, "finished rows");
    }
    pending->row[pending->count++] = row;
    return CML_OK;
}

/* Marks the run of a row as finished in its checkpoint. A row that cannot be marked will be flown again. */
static void mark(const struct cml_pending_row *row)
{
    struct cml_error why;
    if (cml_checkpoint_finish(row->checkpoint, row->identity, &row->state, &row->record, NULL, &why) ==
        CML_OK)
        return;
    cml_show_note(NULL, why.text);
    cml_checkpoint_remove(row->checkpoint);
}

cml_status cml_pending_flush(struct cml_pending *pending, bool now, struct cml_error *err)
{
    struct cml_error why;
    const double begin = cml_now();
    if (pending->count == 0 || (!now && begin - pending->flushed < fmax(1, 20 * pending->took)))
        return CML_OK;
    const cml_status status = cml_file_sync_deferred(err);
    for (int i = 0; status == CML_OK && i < pending->count; i++) mark(&pending->row[i]);
    if (cml_file_sync_deferred(&why) != CML_OK) cml_show_note(NULL, why.text);
    clear_all(pending);
    pending->flushed = cml_now();
    pending->took = pending->flushed - begin;
    return status;
}

cml_status cml_pending_end(struct cml_pending *pending, bool marks, struct cml_error *err)
{
    cml_status status = marks ? cml_pending_flush(pending, true, err) : CML_OK;
    if (status == CML_OK) status = cml_file_sync_deferred(err);
    cml_file_defer_sync(false);
    clear_all(pending);
    free(pending->row);
    *pending = (struct cml_pending){0};
    return status;
}
