/* Decides what a run has to do (fly all photons, resume, extend, nothing) from its options and from the files
 * it finds. SPDX-License-Identifier: MIT */
#pragma once

#include "run/checkpoint.h"

enum cml_run_intent {
    CML_RUN_FRESH,  /* flies all photons */
    CML_RUN_RESUME, /* flies the photons that a checkpoint leaves */
    CML_RUN_EXTEND, /* flies the photons behind the last one of a finished run */
    /* flies none: the results of a finished run are gone, but its checkpoint still has the tallies */
    CML_RUN_REPUBLISH,
    CML_RUN_NOTHING_LEFT, /* flies none: the run is finished, and its results exist */
    CML_RUN_REFUSED,      /* flies none: the run would replace files that --no-clobber keeps */
};

struct cml_run_findings {
    bool extends;                  /* --more was given, and the extension has not begun yet */
    bool resumes;                  /* --resume was given */
    enum cml_checkpoint_kind kind; /* the checkpoint of the run, where one is looked for */
    bool tallies;                  /* the checkpoint holds tallies */
    bool result_gone;              /* a file that the finished run wrote is no longer there */
    bool result_stands;            /* a result with the identity of this run exists */
    bool kept;                     /* --no-clobber was given, and a file that the run would write exists */
};

enum cml_run_intent cml_run_intent_of(const struct cml_run_findings *found);
