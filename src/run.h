/* One run: batches of photon indices through an engine into a result, with progress.
 * Knows no files and no terminal.
 * SPDX-License-Identifier: MIT */
#ifndef CML_RUN_H
#define CML_RUN_H

#include "engine.h"

struct cml_progress {
    uint64_t done, total; /* photons */
    double seconds;       /* since the run began */
};
typedef void cml_progress_function(void *context, const struct cml_progress *progress);

struct cml_run_setup {
    const struct cml_scene *scene;
    const struct cml_surface_set *surfaces;
    const struct cml_engine *engine;
    struct cml_engine_options options;
    uint64_t photons;
    cml_progress_function *on_progress; /* about four times a second; NULL: silent */
    void *context;
};

struct cml_run_result {
    struct cml_result result;
    double seconds; /* wall time of the photons' flight */
    int threads;
};

/* Flies all photons. *out is owned by the caller (cml_run_result_free), cleared on failure. Lost packets and
 * residues are no failure here: see cml_run_verdict. */
CML_NODISCARD cml_status cml_run(const struct cml_run_setup *setup, struct cml_run_result *out,
                                 struct cml_error *err);
void cml_run_result_free(struct cml_run_result *out);

/* P9, P10: CML_E_NUMERIC when books do not balance or more than 1e-6 of the packets were lost. */
CML_NODISCARD cml_status cml_run_verdict(const struct cml_scene *scene, const struct cml_result *result,
                                         struct cml_error *err);

/* Bytes that cml_run will hold at its peak for this grid and number of threads. */
double cml_run_bytes(const struct cml_grid *grid, int threads);

struct cml_grid cml_run_grid(const struct cml_scene *scene, bool absorption);

#endif
