/* What is made of the files that describe a scene while they are read. SPDX-License-Identifier: MIT */
#pragma once

#include "base/settings.h"
#include "base/text.h"
#include "scene/heightmap/mesh_budget.h"

#include <stdbool.h>

struct cml_input_options {
    const struct cml_text_source *source; /* of all files; NULL: the file system */
    double tolerance; /* [-] of the meshes of heightmaps (scene/heightmap/heightmap.h); 0: merge only what
                       * lies in one plane */
    struct cml_mesh_budget budget; /* of every file's mesh; its file, line and boundary are not read */
    void (*on_note)(void *context, const char *text); /* one line on what reads well and was perhaps not
                                                       * meant; NULL: silent */
    void *context;
    const struct cml_settings *settings; /* in place of what the file says; NULL: none */
    const char *output;                  /* the result's name, of a file with one run; NULL: the file's */
    bool flat; /* every boundary becomes its nominal plane; its file is read and checked all the same
                * (the 2019 program's IGNORE_HEIGHTFIELDS) */
};
