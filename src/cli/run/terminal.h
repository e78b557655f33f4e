/* Lines for the terminal that several commands print. SPDX-License-Identifier: MIT */
#pragma once

#include "simulation/scenes.h"

/* A cml_note_function: prints one line on standard error, on any rank and thread. context: unused. */
void cml_print_note(void *context, const char *text);

/* Prints in one line the most memory that the run will hold, with the shares of tallies and of writing. */
void cml_print_memory(const struct cml_options *options, const struct cml_scene *scene,
                      const struct cml_surface_set *surfaces);

/* Prints how the mesh of boundary b was changed: faces cut, border levelled, skirt added. Prints nothing if
 * it was not. */
void cml_print_mesh_repairs(const struct cml_scene *scene, int b);
