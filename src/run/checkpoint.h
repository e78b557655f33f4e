/* Checkpoints: one file that holds the tallies of a run and which photons are not flown yet, and for a
 * finished run its record. Each write goes to a temporary file, which is synced and renamed; the file before
 * stays as "PATH.old". A whole checkpoint is therefore on the disk at any moment. The file also holds the
 * run's identity (identity.h) and a checksum: a damaged checkpoint, or one of another run, is refused.
 * Numbers are in this machine's byte order. SPDX-License-Identifier: MIT */
#pragma once

#include "result/timing.h"
#include "tally/ranges.h"

/* Part `number` (from 1) of `count` parts of a round: a contiguous share of the round's turns. count 0: the
 * whole run. */
struct cml_part {
    uint64_t number, count;
};

/* Returns the turns (tally/piece.h) of a part in the round of photons begin to end - 1; all turns for a whole
 * run. */
struct cml_range cml_part_turns(struct cml_part part, uint64_t begin, uint64_t end);

/* Progress of a run. In the checkpoint of a part, `open` also has the turns of all other parts, and the
 * tallies hold nothing of the rounds before. */
struct cml_run_state {
    struct cml_ranges open; /* turns (tally/piece.h) whose photons are not flown yet */
    uint64_t begin, end;    /* the current round: photons begin to end - 1 */
    double seconds;         /* time spent flying so far, over all starts */
    struct cml_part part;   /* the part of the round that the tallies belong to */
};

enum cml_checkpoint_kind { CML_CHECKPOINT_NONE, CML_CHECKPOINT_PARTIAL, CML_CHECKPOINT_FINISHED };

/* The first line of every checkpoint and of every file of a part. */
#define CML_CHECKPOINT_MAGIC "clustermcml checkpoint\n"

/* Returns "PATH.checkpoint" in *path, which the caller frees. */
CML_NODISCARD cml_status cml_checkpoint_path(const char *output, char **path, struct cml_error *err);

/* Returns "PATH.part2of7" in *path, which the caller frees. */
CML_NODISCARD cml_status cml_part_path(const char *output, struct cml_part part, char **path,
                                       struct cml_error *err);

/* Writes the checkpoint of a run that goes on. call: for a part, the words of the whole run's command line,
 * each ended by a line feed; else NULL. CML_E_IO: the file before is untouched, or stands under "PATH.old".
 */
CML_NODISCARD cml_status cml_checkpoint_write(const char *path, const char *identity, const char *call,
                                              const struct cml_run_state *state, struct cml_result *result,
                                              struct cml_error *err);

/* Writes the checkpoint of a finished run: photons 0 to state->end - 1 are flown, the output is written, and
 * state->open is empty. result: its tallies, to which a later run can add photons; NULL: they are not kept.
 * Removes the older checkpoint. */
CML_NODISCARD cml_status cml_checkpoint_finish(const char *path, const char *identity,
                                               const struct cml_run_state *state,
                                               const struct cml_record *record, struct cml_result *result,
                                               struct cml_error *err);

/* The head of a checkpoint. Only the head is read; the checksum is not tested. */
struct cml_checkpoint_about {
    /* CML_CHECKPOINT_NONE: no such file, or not a checkpoint of this program */
    enum cml_checkpoint_kind kind;
    bool tallies;        /* the file holds tallies */
    uint64_t begin, end; /* the last round: photons begin to end - 1 */
    struct cml_part part;
};
struct cml_checkpoint_about cml_checkpoint_look(const char *path);

/* Reads the head, the identity and the call of the file of a part. CML_E_INPUT: the file cannot be read, or
 * is not the file of a part. The caller frees *identity and *call. */
CML_NODISCARD cml_status cml_part_look(const char *path, struct cml_checkpoint_about *about, char **identity,
                                       char **call, struct cml_error *err);

/* Reads the checkpoint under `path`, or under "PATH.old" where the first is missing or damaged. `note` is one
 * line about using the older file, else "". For CML_CHECKPOINT_PARTIAL fills *state (the caller clears
 * state->open) and `result`, which must have been created for the run. For CML_CHECKPOINT_FINISHED fills
 * *record, which the caller clears; *state and the result only where `tallies` is true. CML_E_INPUT: the
 * checkpoint is damaged and has no older one, belongs to another run, or lacks the tallies that were asked
 * for; *state and the result are unusable then. */
CML_NODISCARD cml_status cml_checkpoint_read(const char *path, const char *identity,
                                             enum cml_checkpoint_kind *kind, struct cml_run_state *state,
                                             struct cml_result *result, bool tallies,
                                             struct cml_record *record, struct cml_error *note,
                                             struct cml_error *err);

/* Fails with CML_E_INPUT: "PATH: the checkpoint is of another run", with the first line in which the two
 * identities differ. */
CML_NODISCARD cml_status cml_fail_other_run(const char *path, const char *theirs, const char *mine,
                                            const char *expected, struct cml_error *err);

/* Deletes "PATH.old" if it exists. */
void cml_checkpoint_remove_older(const char *path);

/* Deletes "PATH" and "PATH.old" where they exist. */
void cml_checkpoint_remove(const char *path);
