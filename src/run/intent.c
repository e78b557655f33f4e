/* SPDX-License-Identifier: MIT */
#include "run/intent.h"

/* Returns what a run does if nothing must be kept: begin anew, resume a checkpoint, write the result of a
 * finished run again, or nothing. */
static enum cml_run_intent intent_of(const struct cml_run_findings *found)
{
    if (!found->resumes) return CML_RUN_FRESH;
    if (found->kind == CML_CHECKPOINT_NONE)
        return found->result_stands ? CML_RUN_NOTHING_LEFT : CML_RUN_FRESH;
    if (found->kind == CML_CHECKPOINT_PARTIAL) return CML_RUN_RESUME;
    if (!found->result_gone) return CML_RUN_NOTHING_LEFT;
    return found->tallies ? CML_RUN_REPUBLISH : CML_RUN_FRESH;
}

/* Returns what a run does about the files it finds: extend, continue, begin anew, or refuse. */
enum cml_run_intent cml_run_intent_of(const struct cml_run_findings *found)
{
    if (found->extends) return CML_RUN_EXTEND;
    const enum cml_run_intent intent = intent_of(found);
    return found->kept && intent != CML_RUN_NOTHING_LEFT ? CML_RUN_REFUSED : intent;
}
