/* The first steps of commands: scenes as the options want them, their surfaces, their threads, and the memory
 * that they need. SPDX-License-Identifier: MIT */
#pragma once

#include "base/input_files.h"
#include "cli/options/options.h"
#include "exact/exact.h"
#include "run/run.h"

/* Makes the options announce meshes that take longer than a second to make, on standard error, unless --quiet
 * is given. *options must not move afterwards. */
void cml_announce_meshes(struct cml_options *options);

/* Fails with CML_E_INPUT if the system allows the main thread, which flies photons, too, less stack than it
 * may need. Call it before MPI begins, which also needs some. Other threads have stacks of their own size. */
CML_NODISCARD cml_status cml_check_stack(struct cml_error *err);

/* A cml_note_function: shows one line on standard error, on any rank. context: unused. */
void cml_show_note(void *context, const char *text);

/* Hands the notes that this thread would show to a receiver, and returns the receiver before. to NULL: they
 * are shown. */
struct cml_note_receiver {
    cml_note_function *to;
    void *context;
};
struct cml_note_receiver cml_notes_go_to(struct cml_note_receiver to);

/* Reads the first operand as a list of scenes, flat if the options say so, and checks that shapes do not
 * overlap. CML_E_INPUT. */
CML_NODISCARD cml_status cml_load_scenes(const struct cml_options *options, struct cml_scene_list *list,
                                         struct cml_error *err);

/* Like cml_load_scenes, and keeps the bytes of the files in *inputs, as a run does: they count in its memory.
 * Files that *inputs has already are not read. The caller clears *inputs. */
CML_NODISCARD cml_status cml_load_scenes_as_run(const struct cml_options *options,
                                                struct cml_scene_list *list, struct cml_inputs *inputs,
                                                struct cml_error *err);

/* Like cml_load_scenes, on all ranks: rank 0 reads the files and sends their bytes to the others. The caller
 * clears *inputs, the bytes. Collective. */
CML_NODISCARD cml_status cml_load_shared_scenes(const struct cml_options *options,
                                                struct cml_scene_list *list, struct cml_inputs *inputs,
                                                struct cml_error *err);

/* cml_fly_scenes loads all runs of the file on all ranks and calls `fly` for each, with its number from 0 and
 * with options that have the threads and the rank of this process. Ends at the first failure. Collective. */
typedef cml_status cml_fly_scene(const struct cml_options *options, const struct cml_scene *scene, int index,
                                 struct cml_error *err);
CML_NODISCARD cml_status cml_fly_scenes(const struct cml_options *options, cml_fly_scene *fly,
                                        struct cml_error *err);

/* Copies a scene with other settings and another name of the result (cml_mci_copy). inputs: the bytes that it
 * was read from. Checks for overlap if anything has moved. CML_E_INPUT: *scene is empty. */
CML_NODISCARD cml_status cml_copy_scene(const struct cml_options *options,
                                        const struct cml_settings *settings, const char *output,
                                        struct cml_inputs *inputs, const struct cml_scene *from,
                                        struct cml_scene *scene, struct cml_error *err);

/* Returns the threads of this rank, as asked for. 0 leaves the number to OpenMP (OMP_NUM_THREADS or the
 * affinity mask); ranks of one machine share its cores evenly. Notes more threads than cores. */
int cml_choose_threads(const struct cml_options *options);

/* Makes the surfaces that a scene is flown with: those of cml_surfaces_create; with --tolerance, those that
 * may be planes become planes. All commands that fly or show surfaces use these. The caller frees *surfaces;
 * empty on failure. */
CML_NODISCARD cml_status cml_choose_surfaces(const struct cml_options *options, const struct cml_scene *scene,
                                             struct cml_surface_set *surfaces, struct cml_error *err);

/* Fails with CML_E_INPUT, and the figures, if the run needs more memory than the machine has. surfaces NULL:
 * they are not made yet, and their memory and facets do not count. */
CML_NODISCARD cml_status cml_check_memory(const struct cml_options *options, const struct cml_scene *scene,
                                          const struct cml_surface_set *surfaces, struct cml_error *err);

/* Returns the most bytes that the run will hold. */
double cml_most_memory(const struct cml_options *options, const struct cml_scene *scene,
                       const struct cml_surface_set *surfaces);

/* Prints in one line the most memory that the run will hold. */
void cml_print_memory(const struct cml_options *options, const struct cml_scene *scene,
                      const struct cml_surface_set *surfaces);

/* Prints how a mesh was changed: faces cut, corners joined, border levelled, skirt added. Prints nothing if
 * it was not, as for a boundary or body that is no mesh. owner: "boundary" or "body". */
void cml_print_mesh_repairs(const char *owner, int number, const struct cml_mesh *mesh,
                            const struct cml_mesh_notes *notes);

/* Prints how the meshes of all boundaries and bodies were changed. */
void cml_print_repairs(const struct cml_scene *scene);

/* Multiplications, some 0.15 s of them, that commands spend on totals by adding-doubling beside other work.
 */
#define CML_EXACT_LITTLE_WORK 1e9

/* Walks at each rough boundary, some 0.05 s of them, for totals by adding-doubling with errors of some 5e-4.
 */
#define CML_EXACT_FEW_WALKS 32768

/* Returns the path of a scene's output in *path: `name` below the output directory. The caller frees *path.
 */
CML_NODISCARD cml_status cml_output_path(const struct cml_options *options, const char *name, char **path,
                                         struct cml_error *err);
