/* The commands of the program; each takes the parsed options and returns what becomes the exit code.
 * options->operands[0] is the first word after the command's name.
 * SPDX-License-Identifier: MIT */
#ifndef CML_COMMAND_H
#define CML_COMMAND_H

#include "base/input_files.h"
#include "cli/options/options.h"
#include "exact/exact.h"
#include "run/run.h"
#include "tally/control.h"

CML_NODISCARD cml_status cml_command_run(const struct cml_options *options, struct cml_error *err);
CML_NODISCARD cml_status cml_command_plan(const struct cml_options *options, struct cml_error *err);
CML_NODISCARD cml_status cml_command_check(const struct cml_options *options, struct cml_error *err);
CML_NODISCARD cml_status cml_command_exact(const struct cml_options *options, struct cml_error *err);
CML_NODISCARD cml_status cml_command_mesh(const struct cml_options *options, struct cml_error *err);
CML_NODISCARD cml_status cml_command_trace(const struct cml_options *options, struct cml_error *err);
CML_NODISCARD cml_status cml_command_compare(const struct cml_options *options, struct cml_error *err);
CML_NODISCARD cml_status cml_command_crosscheck(const struct cml_options *options, struct cml_error *err);
CML_NODISCARD cml_status cml_command_devices(const struct cml_options *options, struct cml_error *err);
CML_NODISCARD cml_status cml_command_plot(const struct cml_options *options, struct cml_error *err);

/* Lets the options announce meshes that take longer than a second to make, on standard error, unless they are
 * quiet. They must stay where they are. */
void cml_announce_meshes(struct cml_options *options);

/* A cml_note_function: one line on standard error, from any rank. context is not looked at. */
void cml_show_note(void *context, const char *text);

/* What run, check, mesh and trace begin with: the one operand as a list of scenes, flattened when asked,
 * checked for overlap. CML_E_INPUT when there is not exactly one operand. */
CML_NODISCARD cml_status cml_load_scenes(const struct cml_options *options, struct cml_scene_list *list,
                                         struct cml_error *err);

/* The same on all ranks: rank 0 reads the files and sends their bytes to the others. *inputs are the bytes,
 * the caller's to clear. Collective. */
CML_NODISCARD cml_status cml_load_shared_scenes(const struct cml_options *options,
                                                struct cml_scene_list *list, struct cml_inputs *inputs,
                                                struct cml_error *err);

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

/* The same in one line. */
void cml_print_memory(const struct cml_options *options, const struct cml_scene *scene,
                      const struct cml_surface_set *surfaces);

/* Lines about what was done to the mesh of boundary b that changes its surface: faces cut, border levelled,
 * skirt added. None where nothing was. */
void cml_print_mesh_repairs(const struct cml_scene *scene, int b);

/* Draws the run of the file that --run names (1) as `check -o` is told; nothing without -o. */
CML_NODISCARD cml_status cml_draw_section(const struct cml_options *options,
                                          const struct cml_scene_list *list, enum cml_picture picture,
                                          struct cml_error *err);

/* Multiplications, some 0.15 s of them: what commands spend on totals by adding-doubling beside other work.
 */
#define CML_EXACT_LITTLE_WORK 1e9

/* A scene's flat twin: planes at the nominal depths in place of all shapes, and the totals of it that are
 * known. Zero: none. */
struct cml_twin {
    struct cml_scene scene; /* its boundaries are its own, the rest is borrowed */
    struct cml_surface_set surfaces;
    struct cml_known known[CML_NUM_TOTALS]; /* rank 0's */
    char *checkpoint, *identity;            /* of its flight; checkpoint NULL: none */
};

/* From the complete setup of the scene's run. CML_E_INPUT: no memory; CML_E_NUMERIC: adding-doubling has no
 * answer. *twin is zero before, and the caller's to clear, after a failure too. */
CML_NODISCARD cml_status cml_twin_create(const struct cml_options *options, const struct cml_run_setup *setup,
                                         struct cml_twin *twin, struct cml_error *err);
void cml_twin_clear(struct cml_twin *twin);

/* Flies the twin on the photons of the run that was flown as `setup` says, the same draws included. On rank 0
 * control[CML_NUM_TOTALS] are the run's totals with it. Collective. *flight is the caller's to free, empty
 * after a failure. */
CML_NODISCARD cml_status cml_twin_fly(const struct cml_twin *twin, const struct cml_run_setup *setup,
                                      const struct cml_result *result, struct cml_run_result *flight,
                                      struct cml_controlled *control, struct cml_error *err);

/* A run of so many photons, and the relative standard errors that it had; INFINITY where it saw nothing. */
struct cml_pilot_round {
    uint64_t photons;
    double error[CML_NUM_GOALS];
};

#define CML_PILOT_MOST_ROUNDS 48

/* Zeroed: none was flown. */
struct cml_pilot {
    int num_rounds;
    struct cml_pilot_round round[CML_PILOT_MOST_ROUNDS]; /* longer and longer */
    double photons_per_s;                                /* of the last, on all ranks */
    int threads;                                         /* of a rank */
};

/* Flies rounds of setup->engine from photon 0 on, each `growth` times as long as the one before, up to
 * setup->photons, or, where that is 0, as long as they fit into about so many seconds together, opening of
 * the engine included; two at least. Collective; rank 0's pilot counts. Fails as cml_run does. */
CML_NODISCARD cml_status cml_pilot_fly(const struct cml_run_setup *setup, double seconds, int growth,
                                       struct cml_pilot *pilot, struct cml_error *err);

/* Photons after which a goal (cml_goals) has a relative standard error, at least one for every batch: between
 * the rounds from which on all reach it by interpolation; else as if errors fell with the root of the
 * photons, which beyond the pilot is an upper estimate where draws are evenly spread. INFINITY where the last
 * round saw nothing. The errors of rounds are known to 9 % (64 batches), so the photons to some 20 %. */
double cml_pilot_photons(const struct cml_pilot *pilot, int goal, double error);

/* The output file of a scene: its name below the output directory. *path is the caller's to free. */
CML_NODISCARD cml_status cml_output_path(const struct cml_options *options, const char *name, char **path,
                                         struct cml_error *err);

#endif
