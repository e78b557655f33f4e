/* Scenes and threads as commands of several ranks begin with them. SPDX-License-Identifier: MIT */
#pragma once

#include "simulation/scenes.h"

/* Checks that the table of --sweep can be read from the source. */
CML_NODISCARD cml_status cml_read_sweep(const struct cml_options *options,
                                        const struct cml_text_source *source, struct cml_error *err);

/* Reads the scenes and the table of --sweep on all ranks: rank 0 reads the files and sends their bytes to the
 * others. The caller clears *list and *inputs, which must be empty, also on failure. Collective. */
CML_NODISCARD cml_status cml_load_shared_scenes(const struct cml_options *options,
                                                struct cml_scene_list *list, struct cml_inputs *inputs,
                                                struct cml_error *err);

/* cml_fly_scenes loads all runs of the file on all ranks and calls `fly` for each, with its number from 0 and
 * with options that have the threads and the rank of this process. Ends at the first failure. Collective. */
typedef cml_status cml_fly_scene(const struct cml_options *options, const struct cml_scene *scene, int index,
                                 struct cml_error *err);
CML_NODISCARD cml_status cml_fly_scenes(const struct cml_options *options, cml_fly_scene *fly,
                                        struct cml_error *err);

/* Returns the threads of this rank, as asked for. 0 leaves the number to OpenMP (OMP_NUM_THREADS or the
 * affinity mask); ranks of one machine share its cores evenly. Notes more threads than cores. */
int cml_choose_threads(const struct cml_options *options);
