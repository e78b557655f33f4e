/* clustermcml exact: totals of a scene by adding-doubling, without photons. SPDX-License-Identifier: MIT */
#include "cli/command.h"

#include "exact/exact.h"
#include "output/report.h"

/* Computes the exact totals of one run's flat scene by adding-doubling, and prints them. */
static cml_status solve(const struct cml_options *options, const struct cml_scene *scene,
                        struct cml_error *err)
{
    /* about a second of walks at each rough boundary gives errors of some 1e-4 */
    const struct cml_exact_options aim = {.tolerance = 1e-7, .most_work = 1e11, .walks = 524288};
    CML_AT_END(cml_exact_clear) struct cml_exact exact = {0};
    CML_TRY(cml_exact_scene(scene, NULL, &aim, &exact, err));
    if (options->json) return cml_report_exact_json(stdout, scene, &exact, err);
    cml_report_exact(stdout, scene, &exact);
    return CML_OK;
}

/* Prints the exact totals of all runs of the file. Shapes are read, so that mistakes in them are reported,
 * but count as planes, which cannot cross. */
cml_status cml_command_exact(const struct cml_options *options, struct cml_error *err)
{
    struct cml_options flat = *options;
    CML_AT_END(cml_scene_list_clear) struct cml_scene_list list = {0};
    flat.ignore_heightfields = true;
    CML_TRY(cml_load_scenes(&flat, NULL, &list, err));
    for (int i = 0; i < list.count; i++) CML_TRY(solve(options, &list.scenes[i], err));
    return CML_OK;
}
