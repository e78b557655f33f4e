/* clustermcml exact: totals of a scene by adding-doubling, without photons. SPDX-License-Identifier: MIT */
#include "api/api_parts.h"
#include "cli/command.h"

#include <stdio.h>

/* Prints the exact totals of all runs of the file. Shapes are read, so that mistakes in them are reported,
 * but count as planes, which cannot cross. */
cml_status cml_command_exact(const struct cml_options *options, struct cml_error *err)
{
    struct cml_options flat = *options;
    CML_AT_END(cml_api_close) struct clm_scene *scene = NULL;
    flat.ignore_heightfields = true;
    CML_TRY(cml_api_open(&flat, &scene, err));
    for (int i = 0; i < clm_scene_runs(scene); i++) {
        const char *text;
        CML_TRY(cml_api_take(clm_scene_exact(scene, i, options->json, &text), err));
        fputs(text, stdout);
    }
    return CML_OK;
}
