/* One run: flies photon indices through an engine into a result, on all ranks, with progress and checkpoints.
 * It knows no terminal. All ranks fly ranges (work_ranges.h) into results of their own. They synchronise when
 * no photon is left, when a checkpoint is due, on a signal and on an error; rank 0 then sums the results. A
 * result is a sum of integers over photon indices: it does not depend on the number of ranks and threads, nor
 * on stops. SPDX-License-Identifier: MIT */
#pragma once

#include "engine/engine.h"
#include "result/provenance.h"
#include "result/timing.h"
#include "run/intent.h"

struct cml_progress {
    uint64_t done, total; /* photons flown, and photons to fly in all */
    double seconds;       /* seconds of flight, over all starts of the run */
};
typedef void cml_progress_function(void *context, const struct cml_progress *progress);
/* one line for people; any rank may call */
typedef void cml_note_function(void *context, const char *text);

struct cml_run_setup {
    const struct cml_scene *scene;
    const struct cml_surface_set *surfaces;
    const struct cml_engine *engine;
    struct cml_engine_options options;
    uint64_t photons;
    /* Part of the last round to be flown, with a checkpoint of its own; count 0: the whole round. */
    struct cml_part part;
    /* For a part, the command line of the whole run, as cml_checkpoint_write takes it. */
    const char *call;
    /* 0: fly `photons`. Else fly rounds of N, N, 2N, 4N ... packets, N = `photons` rounded up to a multiple
     * of 64, until cml_target_met is true at the end of a round. The target is tested only there, so that the
     * end depends on the seed alone. A round has equally many photons in every batch. */
    double target_error;
    /* The quantity that target_error is about (target_error.h); 0: Rd, A and Tt. */
    int error_of;
    /* File of the checkpoint. NULL: none is written, and signals are not watched. */
    const char *checkpoint;
    /* Longest flight without a checkpoint, s: the run is given up after it. 0: no limit. */
    double most_seconds;
    /* Seconds between checkpoints; more where writing would take over 5 % of the time. */
    double interval;
    /* Identity of the run (identity.h); needed with a checkpoint. */
    const char *identity;
    /* For the code that publishes the result; cml_run does not read it. */
    const struct cml_provenance *provenance;
    /* Continue from the checkpoint, if there is one. */
    bool resume;
    /* File that the finished run wrote and that is no longer there; NULL: all are there. The tallies of the
     * checkpoint then become the result; without tallies the run begins anew. Only rank 0's value counts. */
    const char *gone;
    /* Reason for `gone`, for the message: "is gone", "is of another run". */
    const char *how_gone;
    /* Without a checkpoint: the result file that exists is of this run. Only rank 0's value counts. */
    bool result_stands;
    /* Photons of the finished run that this one extends; 0: none. Its checkpoint, with tallies, must exist.
     * Photons base to `photons` - 1 are flown, and the result is that of one run of all. A part does not read
     * the checkpoint of the finished run. Neither does a run without a checkpoint: its result lacks the first
     * `base` photons, until the caller adds them (cml_run_add). */
    uint64_t base;
    /* Identity of the finished run that is extended. */
    const char *base_identity;
    /* Called after every range of rank 0, some twice a second, from whichever thread ends the range. NULL: no
     * progress is shown. */
    cml_progress_function *on_progress;
    /* Without a checkpoint: true ends the run within a second. Any thread calls it. NULL: never. */
    bool (*cancelled)(void *context);
    /* NULL: no notes. */
    cml_note_function *on_note;
    void *context;
};

struct cml_run_result {
    struct cml_result result;
    struct cml_timing timing;
    /* The task that the run found (intent.h); with CML_RUN_NOTHING_LEFT the result is empty. */
    enum cml_run_intent intent;
    /* On rank 0: the record of a run that was found finished. */
    struct cml_record record;
    /* On rank 0: the state at the end; nothing is open. */
    struct cml_run_state state;
};

/* Flies all photons of the run. Collective. The result is rank 0's; on other ranks it is zero. The caller
 * frees *out (cml_run_result_free); after a failure it is cleared already. Lost packets and an imbalance are
 * no failures here: see cml_run_verdict. CML_E_STOPPED: a signal came and the checkpoint was written, or the
 * flight took longer than most_seconds, or was cancelled. */
CML_NODISCARD cml_status cml_run(const struct cml_run_setup *setup, struct cml_run_result *out,
                                 struct cml_error *err);
void cml_run_result_free(struct cml_run_result *out);

/* Adds the sums of other photons of the same run, whose grid is the same. Changes the order of `from`'s saved
 * packets. */
void cml_run_add(struct cml_result *to, struct cml_result *from);

/* Returns the grid of the run's tallies. */
struct cml_tally_grid cml_run_grid(const struct cml_run_setup *setup);

/* Reads the tallies of the finished run that is extended (setup->base photons) into an empty result.
 * CML_E_INPUT: the checkpoint is not of that run, or unusable. */
CML_NODISCARD cml_status cml_run_read_base(const struct cml_run_setup *setup, struct cml_run_state *state,
                                           struct cml_result *result, struct cml_error *err);

/* Rules P9, P10: fails with CML_E_NUMERIC when the weights do not balance, or when more than 1e-6 of the
 * packets were lost. */
CML_NODISCARD cml_status cml_run_verdict(const struct cml_scene *scene, const struct cml_result *result,
                                         struct cml_error *err);

/* Returns the bytes that cml_run will hold at its peak for this grid and number of threads. */
double cml_run_bytes(const struct cml_tally_grid *grid, int threads);
