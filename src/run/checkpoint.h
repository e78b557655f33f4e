/* Checkpoints: what a run has tallied and which photons it has not flown, in one file; and, when it is
 * finished, what came of it.
 * The file is written beside its name, synced and renamed, and the one before it is kept as "PATH.old", so
 * that at any moment a whole one exists. It holds the run's identity (identity.h) and a checksum: what is
 * damaged or belongs to another run is refused. Numbers are in this machine's byte order.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "result/timing.h"
#include "tally/ranges.h"

/* Part `number`, from 1, of the `count` parts of a round: a share of its turns. count 0: the whole run. */
struct cml_part {
    uint64_t number, count;
};

/* The turns of a part of the round begin to end - 1; of the whole run all of them. */
struct cml_range cml_part_turns(struct cml_part part, uint64_t begin, uint64_t end);

/* Of a part `open` has the turns of all other parts, too, and the tallies hold nothing of the rounds before.
 */
struct cml_run_state {
    struct cml_ranges open; /* turns (tally/piece.h) of photons that are not flown yet */
    uint64_t begin, end;    /* the round that they belong to: photons begin to end - 1 */
    double seconds;         /* flown so far */
    struct cml_part part;   /* which of the round's parts the tallies are of */
};

enum cml_checkpoint_kind { CML_CHECKPOINT_NONE, CML_CHECKPOINT_PARTIAL, CML_CHECKPOINT_FINISHED };

/* The first line of every checkpoint and part. */
#define CML_CHECKPOINT_MAGIC "clustermcml checkpoint\n"

/* "PATH.checkpoint"; the caller's to free. */
CML_NODISCARD cml_status cml_checkpoint_path(const char *output, char **path, struct cml_error *err);

/* "PATH.part2of7"; the caller's to free. */
CML_NODISCARD cml_status cml_part_path(const char *output, struct cml_part part, char **path,
                                       struct cml_error *err);

/* call: of a part, the words of the command line of the whole run, each ended by a line feed; else NULL.
 * CML_E_IO: what stood there before still does, or stands under "PATH.old". */
CML_NODISCARD cml_status cml_checkpoint_write(const char *path, const char *identity, const char *call,
                                              const struct cml_run_state *state, struct cml_result *result,
                                              struct cml_error *err);

/* The run of photons 0 to state->end - 1 is finished and its output written; state->open is empty. With its
 * tallies, result, more photons can be added to it later; NULL: they are not kept. No older checkpoint stays.
 */
CML_NODISCARD cml_status cml_checkpoint_finish(const char *path, const char *identity,
                                               const struct cml_run_state *state,
                                               const struct cml_record *record, struct cml_result *result,
                                               struct cml_error *err);

/* What a checkpoint is of, without looking whether it is sound. */
struct cml_checkpoint_about {
    enum cml_checkpoint_kind kind; /* CML_CHECKPOINT_NONE: there is no such file, or it is none of ours */
    bool tallies;                  /* the file has them */
    uint64_t begin, end;           /* its last round: photons begin to end - 1 */
    struct cml_part part;
};
struct cml_checkpoint_about cml_checkpoint_look(const char *path);

/* The same, with whose a part is, of what may be a part. CML_E_INPUT, CML_E_IO: the file cannot be read, or
 * is none. *identity and *call are the caller's to free. */
CML_NODISCARD cml_status cml_part_look(const char *path, struct cml_checkpoint_about *about, char **identity,
                                       char **call, struct cml_error *err);

/* Looks for a checkpoint under `path`, and under "PATH.old" where there is none or a damaged one; `note` (one
 * line, "" when there is nothing to say) tells of the latter. CML_CHECKPOINT_PARTIAL fills *state and the
 * result, which has been created for the run; state->open is the caller's to clear. CML_CHECKPOINT_FINISHED
 * fills *record, the caller's to clear, and where `tallies` asks for them *state and the result, too.
 * CML_E_INPUT: damaged and no older one, of another run, or without the tallies that were asked for; then
 * *state and the result are not to be used. */
CML_NODISCARD cml_status cml_checkpoint_read(const char *path, const char *identity,
                                             enum cml_checkpoint_kind *kind, struct cml_run_state *state,
                                             struct cml_result *result, bool tallies,
                                             struct cml_record *record, struct cml_error *note,
                                             struct cml_error *err);

/* CML_E_INPUT: "PATH: the checkpoint is of another run", with the first line in which two identities differ.
 */
CML_NODISCARD cml_status cml_fail_other_run(const char *path, const char *theirs, const char *mine,
                                            const char *expected, struct cml_error *err);

/* Deletes "PATH.old", if it is there. */
void cml_checkpoint_remove_older(const char *path);

/* Deletes both files, if they are there. */
void cml_checkpoint_remove(const char *path);
