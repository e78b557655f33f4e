/* The flat twin of a run, for --control flat. SPDX-License-Identifier: MIT */
#pragma once

#include "cli/options/options.h"
#include "run/run.h"
#include "tally/control.h"

/* A scene's flat twin: planes at the nominal depths in place of all shapes, and the totals of it that are
 * known. Zero: none. */
struct cml_twin {
    struct cml_scene scene; /* its boundaries are its own, the rest is borrowed */
    struct cml_surface_set surfaces;
    struct cml_known known[CML_NUM_TOTALS]; /* rank 0's */
    char *checkpoint, *identity;            /* of its flight; checkpoint NULL: none */
};

/* From the complete setup of the scene's run. CML_E_INPUT: no memory; CML_E_NUMERIC: adding-doubling has no
 * answer. *twin is zero before, and the caller's to clear, after a failure too. */
CML_NODISCARD cml_status cml_twin_create(const struct cml_options *options, const struct cml_run_setup *setup,
                                         struct cml_twin *twin, struct cml_error *err);
void cml_twin_clear(struct cml_twin *twin);

/* Flies the twin on the photons of the run that was flown as `setup` says, the same draws included. On rank 0
 * control[CML_NUM_TOTALS] are the run's totals with it. Collective. *flight is the caller's to free, empty
 * after a failure. */
CML_NODISCARD cml_status cml_twin_fly(const struct cml_twin *twin, const struct cml_run_setup *setup,
                                      const struct cml_result *result, struct cml_run_result *flight,
                                      struct cml_controlled *control, struct cml_error *err);
