/* Rows of a sweep that are finished, and whose checkpoints do not say so yet. A row may take a millisecond,
 * and a file that is safe on the disk ten: so files of rows wait for each other. SPDX-License-Identifier: MIT
 */
#pragma once

#include "run/checkpoint.h"

struct cml_pending_row;

/* Zeroed: none. */
struct cml_pending {
    int count;
    struct cml_pending_row *row; /* [count] */
    double flushed, took;        /* s: when rows were written last, and how long that took */
};

/* From here on files are not synced one by one (base/atomic_file.h), until cml_pending_end. */
void cml_pending_begin(struct cml_pending *pending);

/* What cml_checkpoint_finish will be given, copied. */
CML_NODISCARD cml_status cml_pending_add(struct cml_pending *pending, const char *checkpoint,
                                         const char *identity, const struct cml_run_state *state,
                                         const struct cml_record *record, struct cml_error *err);

/* Syncs all results, then says in the checkpoints that they are finished; now, or where that was not done for
 * a second, nor for twenty times as long as it takes. CML_E_IO: a result that could not be synced, and is
 * gone; then no checkpoint says that. A row that cannot be marked is noted and will be flown again. */
CML_NODISCARD cml_status cml_pending_flush(struct cml_pending *pending, bool now, struct cml_error *err);

/* marks: a last flush. Syncs what is left, and forgets the rows. CML_E_IO as above. */
CML_NODISCARD cml_status cml_pending_end(struct cml_pending *pending, bool marks, struct cml_error *err);
