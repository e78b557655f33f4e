/* Checkpoints: what a run has tallied and which photons it has not flown, in one file.
 * The file is written beside its name, synced and renamed, and the one before it is kept as "PATH.old", so
 * that at any moment a whole one exists. It holds the run's identity (identity.h) and a checksum: what is
 * damaged or belongs to another run is refused. Numbers are in this machine's byte order.
 * SPDX-License-Identifier: MIT */
#ifndef CML_CHECKPOINT_H
#define CML_CHECKPOINT_H

#include "tally/ranges.h"
#include "tally/result.h"

struct cml_run_state {
    struct cml_ranges open; /* places (tally/places.h) of photons that are not flown yet */
    uint64_t begin, end;    /* the round that they belong to: photons begin to end - 1 */
    double seconds;         /* flown so far */
};

enum cml_checkpoint_kind { CML_CHECKPOINT_NONE, CML_CHECKPOINT_PARTIAL, CML_CHECKPOINT_FINISHED };

/* "PATH.checkpoint"; the caller's to free. */
CML_NODISCARD cml_status cml_checkpoint_path(const char *output, char **path, struct cml_error *err);

/* result NULL: the run is finished and its output written. CML_E_IO: what stood there before still does,
 * or stands under "PATH.old". */
CML_NODISCARD cml_status cml_checkpoint_write(const char *path, const char *identity,
                                              const struct cml_run_state *state, struct cml_result *result,
                                              struct cml_error *err);

/* Looks for a checkpoint under `path`, and under "PATH.old" where there is none or a damaged one; `note` (one
 * line, "" when there is nothing to say) tells of the latter. CML_CHECKPOINT_PARTIAL fills *state and the
 * result, which has been created for the run; state->open is the caller's to clear. CML_E_INPUT: damaged and
 * no older one, or of another run; then *state and the result are not to be used. */
CML_NODISCARD cml_status cml_checkpoint_read(const char *path, const char *identity,
                                             enum cml_checkpoint_kind *kind, struct cml_run_state *state,
                                             struct cml_result *result, struct cml_error *note,
                                             struct cml_error *err);

/* Deletes both files, if they are there. */
void cml_checkpoint_remove(const char *path);

#endif
