/* One run, from its surfaces to its files: the part that runs of a file and rows of a sweep share.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "options/options.h"
#include "flights/pending.h"
#include "output/report.h"
#include "run/run.h"

/* Takes the results of flights in place of files, and hears of their progress. */
struct cml_receiver {
    /* Reads a report, whose outcome it makes. CML_E_STOPPED: no more rows are wanted. */
    cml_status (*take)(void *context, struct cml_report *report, struct cml_error *err);
    /* members of cml_run_setup */
    cml_progress_function *on_progress;
    bool (*cancelled)(void *context);
    cml_note_function *on_note;
    void *context;
};

/* Rows of a sweep from one flight (P16); each row has its own result. */
struct cml_run_rows {
    int count;
    const int *number;                    /* [count] numbers of the rows, from 0 */
    const struct cml_scene *const *scene; /* [count] scenes of the rows */
    struct cml_record *record;            /* [count] on rank 0; each is filled like *record of cml_run_one */
};

struct cml_run_call {
    const struct cml_options *options;
    const struct cml_scene *scene;
    const char *inputs; /* lines of the identity for the input files (run/identity.h) */
    /* Surfaces of another scene with the same shapes, whose trees need not be built again; NULL: none. */
    const struct cml_surface_set *shared;
    uint64_t seed;
    uint32_t run; /* number of the run in the file, from 0 */
    int row;      /* row of a sweep, from 1, without a summary; 0: no sweep */
    /* Rows to publish in place of the scene, which is only flown, with the rows of the options; NULL: none.
     */
    const struct cml_run_rows *rows;
    /* Takes the checkpoints of finished runs without tallies; NULL: none. */
    struct cml_pending *pending;
    bool only;  /* no other run belongs to this call of the program */
    bool stays; /* a checkpoint stays which says that the run is finished */
};

/* Flies a run on all ranks, writes its files and prints a summary. *record is rank 0's, and the caller clears
 * it. It is filled unless the flight or a file failed, even if the run was finished before. Collective.
 * CML_E_NUMERIC: the result is written, but cannot be trusted. */
CML_NODISCARD cml_status cml_run_one(const struct cml_run_call *call, struct cml_record *record,
                                     struct cml_error *err);

/* True if checkpoints stay when all runs are done, so that a later call finds these runs finished. */
bool cml_run_leaves_checkpoints(const struct cml_options *options);

/* Returns in *path the file that keeps the tallies of a run with the result `output`: its checkpoint, or the
 * file of its part. The caller frees *path. */
CML_NODISCARD cml_status cml_checkpoint_of(const struct cml_options *options, const char *output, char **path,
                                           struct cml_error *err);

/* Returns in *path the checkpoint of a scene's run, beside its output. The caller frees *path. */
CML_NODISCARD cml_status cml_run_checkpoint(const struct cml_options *options, const struct cml_scene *scene,
                                            char **path, struct cml_error *err);
