/* What commands begin with: scenes, as the options want them, their surfaces, and the memory that they take.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/input_files.h"
#include "cli/options/options.h"
#include "exact/exact.h"
#include "run/run.h"

/* Lets the options announce meshes that take longer than a second to make, on standard error, unless they are
 * quiet. They must stay where they are. */
void cml_announce_meshes(struct cml_options *options);

/* CML_E_INPUT where the system allows the main thread, which flies, too, less stack than it may need. Before
 * MPI begins, which needs some as well; other threads have stacks of a size of their own. */
CML_NODISCARD cml_status cml_check_stack(struct cml_error *err);

/* A cml_note_function: one line on standard error, from any rank. context is not looked at. */
void cml_show_note(void *context, const char *text);

/* What run, check, mesh and trace begin with: the one operand as a list of scenes, flattened when asked,
 * checked for overlap. CML_E_INPUT when there is not exactly one operand. */
CML_NODISCARD cml_status cml_load_scenes(const struct cml_options *options, struct cml_scene_list *list,
                                         struct cml_error *err);

/* cml_load_scenes with the bytes that were read, as a run holds them: they count in its memory. *inputs are
 * the caller's to clear. */
CML_NODISCARD cml_status cml_load_scenes_as_run(const struct cml_options *options,
                                                struct cml_scene_list *list, struct cml_inputs *inputs,
                                                struct cml_error *err);

/* cml_load_scenes on all ranks: rank 0 reads the files and sends their bytes to the others. *inputs are the
 * bytes, the caller's to clear. Collective. */
CML_NODISCARD cml_status cml_load_shared_scenes(const struct cml_options *options,
                                                struct cml_scene_list *list, struct cml_inputs *inputs,
                                                struct cml_error *err);

/* Loads so all runs of the file and hands each, with its number from 0, to `fly`, whose options know the
 * threads and the rank of this process; ends with the first failure. Collective. */
typedef cml_status cml_fly_scene(const struct cml_options *options, const struct cml_scene *scene, int index,
                                 struct cml_error *err);
CML_NODISCARD cml_status cml_fly_scenes(const struct cml_options *options, cml_fly_scene *fly,
                                        struct cml_error *err);

/* A scene that was loaded before, with other settings and another name of the result (cml_mci_copy); inputs:
 * the bytes that it was read from. Checked for overlap where anything has moved. CML_E_INPUT; then *scene is
 * empty. */
CML_NODISCARD cml_status cml_copy_scene(const struct cml_options *options,
                                        const struct cml_settings *settings, const char *output,
                                        struct cml_inputs *inputs, const struct cml_scene *from,
                                        struct cml_scene *scene, struct cml_error *err);

/* Threads of this rank, as asked for; 0 leaves it to OpenMP, that is OMP_NUM_THREADS or the affinity mask,
 * but ranks that share the cores of a machine share them evenly. More threads than cores get a note. */
int cml_choose_threads(const struct cml_options *options);

/* The surfaces that a scene is flown with: those of cml_surfaces_create, less those that --tolerance, where
 * it was given, lets be planes. All commands that fly or show surfaces take these. *surfaces is the caller's
 * to free; empty on failure. */
CML_NODISCARD cml_status cml_choose_surfaces(const struct cml_options *options, const struct cml_scene *scene,
                                             struct cml_surface_set *surfaces, struct cml_error *err);

/* CML_E_INPUT with the figure when the run would take more memory than the machine has. surfaces NULL: they
 * are not made yet, and facets do not count. */
CML_NODISCARD cml_status cml_check_memory(const struct cml_options *options, const struct cml_scene *scene,
                                          const struct cml_surface_set *surfaces, struct cml_error *err);

/* Bytes: the most memory that the run will hold. */
double cml_most_memory(const struct cml_options *options, const struct cml_scene *scene,
                       const struct cml_surface_set *surfaces);

/* Prints the most memory that the run will hold, in one line. */
void cml_print_memory(const struct cml_options *options, const struct cml_scene *scene,
                      const struct cml_surface_set *surfaces);

/* Lines about what was done to the mesh of boundary b that changes its surface: faces cut, border levelled,
 * skirt added. None where nothing was. */
void cml_print_mesh_repairs(const struct cml_scene *scene, int b);

/* Multiplications, some 0.15 s of them: what commands spend on totals by adding-doubling beside other work.
 */
#define CML_EXACT_LITTLE_WORK 1e9

/* Walks at each rough boundary, some 0.05 s of them: totals by adding-doubling are then good to some 5e-4. */
#define CML_EXACT_FEW_WALKS 32768

/* The output file of a scene: its name below the output directory. *path is the caller's to free. */
CML_NODISCARD cml_status cml_output_path(const struct cml_options *options, const char *name, char **path,
                                         struct cml_error *err);
