/* clustermcml check: prints all that is known about a scene without a run. SPDX-License-Identifier: MIT */
#include "api/api_parts.h"
#include "cli/command.h"

#include "flights/sweep.h"

#include <stdio.h>

/* Runs `check`: reads scenes and sweeps as a run would, reports what was understood, and flies nothing. */
cml_status cml_command_check(const struct cml_options *options, struct cml_error *err)
{
    CML_AT_END(cml_api_close) struct clm_scene *scene = NULL;
    CML_TRY(cml_api_open(options, &scene, err));
    const struct cml_text_source record = cml_inputs_recorder(&scene->inputs);
    const struct cml_sweep_size *sweep = &scene->sweep;
    CML_TRY(cml_read_sweep(options, &record, err));
    CML_TRY(cml_sweep_check(options, &scene->list, &scene->inputs, &scene->sweep, &scene->flown, err));
    for (int i = 0; i < clm_scene_runs(scene); i++) {
        const char *text;
        const int status = clm_scene_check(scene, i, options->json, &text);
        fputs(text, stdout);
        CML_TRY(cml_api_take(status, err));
    }
    if (sweep->rows > 0 && !options->json)
        printf("  %d row%s of %s: %d flight%s\n", sweep->rows, sweep->rows == 1 ? "" : "s", options->sweep,
               sweep->flights, sweep->flights == 1 ? "" : "s");
    return CML_OK;
}
