/* All that is known about a scene without a run. SPDX-License-Identifier: MIT */
#pragma once

#include "output/report.h"
#include "simulation/scenes.h"

/* Prints all that is known, as text or with --json as one line. flown: the options of the largest flight of a
 * sweep, which decide memory; without a sweep those of the run. sweep: its size. */
CML_NODISCARD cml_status cml_check_scene(FILE *stream, const struct cml_options *options,
                                         const struct cml_options *flown, const struct cml_scene *scene,
                                         const struct cml_sweep_size *sweep, struct cml_error *err);

/* Prints in one line the most memory that the run will hold, with the shares of tallies and of writing. */
void cml_print_memory(FILE *stream, const struct cml_options *options, const struct cml_scene *scene,
                      const struct cml_surface_set *surfaces);

/* Prints how the meshes of all boundaries and bodies were changed: faces cut, corners joined, border
 * levelled, skirt added. Prints nothing of a mesh that was not. */
void cml_print_repairs(FILE *stream, const struct cml_scene *scene);
