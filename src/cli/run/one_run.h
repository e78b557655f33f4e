/* One run, from its surfaces to its files: what a run of a file and a row of a sweep have in common.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "cli/options/options.h"
#include "cli/run/pending.h"
#include "run/run.h"

/* Rows of a sweep that come of one flight (P16), each with a result of its own. */
struct cml_run_rows {
    int count;
    const int *number;                    /* [count] from 0 */
    const struct cml_scene *const *scene; /* [count] */
    struct cml_record *record;            /* [count] rank 0's, filled as that of cml_run_one */
};

struct cml_run_call {
    const struct cml_options *options;
    const struct cml_scene *scene;
    const char *inputs; /* lines of the identity (run/identity.h) */
    const struct cml_surface_set
        *shared; /* of another scene, which shares its shapes with this one; NULL: none */
    uint64_t seed;
    uint32_t run;                    /* of the file, from 0 */
    int row;                         /* of a sweep, from 1: no summary; 0: of none */
    const struct cml_run_rows *rows; /* are published in place of the scene, which only flies, with the rows
                                      * of the options; NULL: none */
    struct cml_pending *pending;     /* takes the checkpoints of finished runs without tallies; NULL: none */
    bool only;                       /* the call of the program flies no other run */
    bool stays;                      /* a checkpoint stays that says that the run is finished */
};

/* Flies the run on all ranks, writes its files and prints a summary for people. *record is rank 0's, the
 * caller's to clear: filled unless the flight or a file failed, also by a run that was finished before.
 * Collective. CML_E_NUMERIC: the result is written, and not to be trusted. */
CML_NODISCARD cml_status cml_run_one(const struct cml_run_call *call, struct cml_record *record,
                                     struct cml_error *err);

/* Whether checkpoints stay when all runs are done: whoever asks then finds that they are. */
bool cml_run_leaves_checkpoints(const struct cml_options *options);

/* The file in which a run whose result is `output` keeps its tallies: its checkpoint, or that of its part.
 * *path is the caller's to free. */
CML_NODISCARD cml_status cml_checkpoint_of(const struct cml_options *options, const char *output, char **path,
                                           struct cml_error *err);

/* The checkpoint of a scene's run, beside its output; *path is the caller's to free. */
CML_NODISCARD cml_status cml_run_checkpoint(const struct cml_options *options, const struct cml_scene *scene,
                                            char **path, struct cml_error *err);
