/* One run: photon indices through an engine into a result, on all ranks, with progress and checkpoints.
 * Knows no terminal. All ranks fly ranges (work_ranges.h) into results of their own and synchronise when
 * nothing is left, when a checkpoint is due, on a signal and on an error; there the results are summed into
 * that of rank 0. A result is a sum of integers over indices: it depends neither on the number of ranks and
 * threads nor on stops. SPDX-License-Identifier: MIT */
#pragma once

#include "engine/engine.h"
#include "result/provenance.h"
#include "result/timing.h"
#include "run/intent.h"

struct cml_progress {
    uint64_t done, total; /* photons */
    double seconds;       /* since the run began */
};
typedef void cml_progress_function(void *context, const struct cml_progress *progress);
typedef void cml_note_function(void *context, const char *text); /* one line for people; from any rank */

struct cml_run_setup {
    const struct cml_scene *scene;
    const struct cml_surface_set *surfaces;
    const struct cml_engine *engine;
    struct cml_engine_options options;
    uint64_t photons;
    struct cml_part
        part;         /* what is flown of the last round, into a checkpoint of its own; count 0: all of it */
    const char *call; /* of a part, as cml_checkpoint_write takes it */
    double target_error; /* 0: fly `photons`. Else rounds of N, N, 2N, 4N ... packets, N = `photons` rounded
                          * up to 64, until one ends with cml_target_met: it is looked at nowhere else, so
                          * that the end depends on the seed only. A round has as many photons in every
                          * batch. */
    int error_of;        /* 0, or what that is the error of (target_error.h) */
    const char *checkpoint; /* file; NULL: none, and no signal is watched */
    double most_seconds; /* without a checkpoint: of a flight, which is given up then; 0: it ends by itself */
    double interval; /* seconds from one checkpoint to the next, more where writing takes over 5 % of it */
    const char *identity;                    /* of the run, see identity.h; with a checkpoint */
    const struct cml_provenance *provenance; /* for whom publishes it; cml_run does not read it */
    bool resume;                             /* continue from the checkpoint, if there is one */
    const char *gone;     /* a file that a finished run has written and that is no longer there: its tallies
                           * are the result, or where the checkpoint has none, the run begins anew. Rank 0's
                           * word counts; NULL: all are there */
    const char *how_gone; /* that is how: "is gone", "is of another run" */
    bool result_stands; /* without a checkpoint: the result that is there is of this run. Rank 0's word counts
                         */
    uint64_t base; /* photons of a finished run whose checkpoint, with tallies, is at hand: only those from
                    * there to `photons` are flown, and the result is that of one run of all; 0: none. A part
                    * does not read that checkpoint */
    const char *base_identity;          /* of that run */
    cml_progress_function *on_progress; /* after every range of rank 0, some twice a second, from whichever
                                           thread ends it; NULL: silent */
    cml_note_function *on_note;         /* NULL: silent */
    void *context;
};

struct cml_run_result {
    struct cml_result result;
    struct cml_timing timing;
    enum cml_run_intent intent; /* what it had to do; with CML_RUN_NOTHING_LEFT the result is empty */
    struct cml_record record;   /* rank 0's, of a run that was found finished */
    struct cml_run_state state; /* rank 0's at the end: nothing is open */
};

/* Flies all photons. Collective; the result is rank 0's, that of the others is zero. *out is owned by the
 * caller (cml_run_result_free), cleared on failure. Lost packets and an imbalance are no failure here: see
 * cml_run_verdict. CML_E_STOPPED: a signal came, and the checkpoint was written; or the flight took longer
 * than most_seconds. */
CML_NODISCARD cml_status cml_run(const struct cml_run_setup *setup, struct cml_run_result *out,
                                 struct cml_error *err);
void cml_run_result_free(struct cml_run_result *out);

/* The grid of the run's tallies. */
struct cml_tally_grid cml_run_grid(const struct cml_run_setup *setup);

/* The finished run that is extended, setup->base photons of it, into an empty result. CML_E_INPUT. */
CML_NODISCARD cml_status cml_run_read_base(const struct cml_run_setup *setup, struct cml_run_state *state,
                                           struct cml_result *result, struct cml_error *err);

/* P9, P10: CML_E_NUMERIC when the weight does not balance or more than 1e-6 of the packets were lost. */
CML_NODISCARD cml_status cml_run_verdict(const struct cml_scene *scene, const struct cml_result *result,
                                         struct cml_error *err);

/* Bytes that cml_run will hold at its peak for this grid and number of threads. */
double cml_run_bytes(const struct cml_tally_grid *grid, int threads);
