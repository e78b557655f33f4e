/* What a run has to do, from what was asked for and what it finds. SPDX-License-Identifier: MIT */
#pragma once

#include "run/checkpoint.h"

enum cml_run_intent {
    CML_RUN_FRESH,        /* fly all photons */
    CML_RUN_RESUME,       /* fly those that a checkpoint leaves */
    CML_RUN_EXTEND,       /* fly those behind the last one of a finished run */
    CML_RUN_REPUBLISH,    /* fly none: a finished run's results are gone, but its tallies are there */
    CML_RUN_NOTHING_LEFT, /* the run is finished, and its results are there */
    CML_RUN_REFUSED,      /* none of these: it would replace what is to be kept */
};

struct cml_run_findings {
    bool extends;                  /* --more, and it has not begun yet */
    bool resumes;                  /* --resume */
    enum cml_checkpoint_kind kind; /* of the run's checkpoint, where one is looked for */
    bool tallies;                  /* it has them */
    bool result_gone;              /* a file that a finished run has written is no longer there */
    bool result_stands;            /* a result is there that says to be of this run */
    bool kept;                     /* --no-clobber, and a file that it would write is there */
};

enum cml_run_intent cml_run_intent_of(const struct cml_run_findings *found);
