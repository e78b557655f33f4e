/* Finished rows of a sweep whose checkpoints do not say so yet. A row may take a millisecond, but making a
 * file safe on the disk takes ten, so the files of several rows are synced together. SPDX-License-Identifier:
 * MIT */
#pragma once

#include "run/checkpoint.h"

struct cml_pending_row;

/* Finished rows whose results are not yet safe on the disk. A struct of zeros has none. */
struct cml_pending {
    int count;
    struct cml_pending_row *row; /* [count] the rows that wait */
    double flushed, took;        /* time of the last flush, and its duration, s */
};

/* Begins a sweep: until cml_pending_end, files are not synced one by one (base/atomic_file.h). */
void cml_pending_begin(struct cml_pending *pending);

/* Adds a finished row, with copies of the arguments for cml_checkpoint_finish. */
CML_NODISCARD cml_status cml_pending_add(struct cml_pending *pending, const char *checkpoint,
                                         const char *identity, const struct cml_run_state *state,
                                         const struct cml_record *record, struct cml_error *err);

/* Syncs all results, then marks their runs as finished in the checkpoints. now false: only if the last flush
 * was more than a second, and more than 20 times its duration, ago. CML_E_IO: a result could not be synced,
 * and is lost; no run is marked then. A row that cannot be marked is noted, and will be flown again. */
CML_NODISCARD cml_status cml_pending_flush(struct cml_pending *pending, bool now, struct cml_error *err);

/* Ends a sweep: syncs the remaining files and forgets the rows. marks: flushes first. CML_E_IO as
 * cml_pending_flush. */
CML_NODISCARD cml_status cml_pending_end(struct cml_pending *pending, bool marks, struct cml_error *err);
