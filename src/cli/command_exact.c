/* clustermcml exact: totals without photons.
 * SPDX-License-Identifier: MIT */
#include "cli/command.h"

#include "exact/exact.h"
#include "output/report.h"

static cml_status solve(const struct cml_options *options, const struct cml_scene *scene,
                        struct cml_error *err)
{
    const struct cml_exact_options aim = {.tolerance = 1e-7, .most_work = 1e11};
    struct cml_exact exact;
    CML_TRY(cml_exact_scene(scene, NULL, &aim, &exact, err));
    cml_status status = CML_OK;
    if (options->json)
        status = cml_report_exact_json(stdout, scene, &exact, err);
    else
        cml_report_exact(stdout, scene, &exact);
    cml_exact_clear(&exact);
    return status;
}

/* Shapes are read, so that what is wrong with them is said, and then count as planes, which cannot cross. */
cml_status cml_command_exact(const struct cml_options *options, struct cml_error *err)
{
    struct cml_options flat = *options;
    struct cml_scene_list list;
    flat.ignore_heightfields = true;
    CML_TRY(cml_load_scenes(&flat, &list, err));
    cml_status status = CML_OK;
    for (int i = 0; status == CML_OK && i < list.count; i++) status = solve(options, &list.scenes[i], err);
    cml_scene_list_clear(&list);
    return status;
}
