/* Options of the program that change how the files of a scene are read. SPDX-License-Identifier: MIT */
#pragma once

#include "base/settings.h"
#include "base/text.h"
#include "scene/heightmap/mesh_budget.h"

#include <stdbool.h>

struct cml_input_options {
    const struct cml_text_source *source; /* source of all files; NULL: the file system */
    /* Tolerance of the meshes of heightmaps [-] (scene/heightmap/heightmap.h). 0: only facets of one plane
     * are merged. */
    double tolerance;
    /* Budget of triangles for the mesh of each file; its members file, line and boundary are not used. */
    struct cml_mesh_budget budget;
    /* Receives one line about input that is valid but perhaps not meant; NULL: no notes. */
    void (*on_note)(void *context, const char *text);
    void *context;
    const struct cml_settings *settings; /* values that replace those of the file; NULL: none */
    /* name of the result, only for a file with one run; NULL: the name in the file */
    const char *output;
    /* Every boundary becomes its nominal plane. The files of shapes are still read and checked (the option
     * IGNORE_HEIGHTFIELDS of the program of 2019). */
    bool flat;
};
