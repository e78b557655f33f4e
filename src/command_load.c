/* SPDX-License-Identifier: MIT */
#include "command.h"

#include "mci.h"
#include "text.h"

#include <stdlib.h>
#include <string.h>

static cml_status check_all(const struct cml_scene_list *list, struct cml_error *err)
{
    for (int i = 0; i < list->count; i++) CML_TRY(cml_scene_check_overlap(&list->scenes[i], err));
    return CML_OK;
}

cml_status cml_load_scenes(const struct cml_options *options, struct cml_scene_list *list,
                           struct cml_error *err)
{
    CML_TRY(cml_mci_read(options->operands[0], list, err));
    const bool flat = options->ignore_heightfields || options->surface.force == CML_AS_PLANE;
    for (int i = 0; flat && i < list->count; i++) cml_scene_flatten(&list->scenes[i]);
    const cml_status status = check_all(list, err);
    if (status != CML_OK) cml_scene_list_clear(list);
    return status;
}

cml_status cml_output_path(const struct cml_options *options, const char *name, char **path,
                           struct cml_error *err)
{
    if (!options->output || name[0] == '/') return cml_text_copy(name, path, err);
    const size_t size = strlen(options->output) + strlen(name) + 2;
    *path = malloc(size);
    if (!*path) return cml_fail_memory(err, (double)size, "a path");
    strcpy(*path, options->output);
    strcat(*path, "/");
    strcat(*path, name);
    return CML_OK;
}
