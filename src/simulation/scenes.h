/* Scenes as the options want them, their surfaces, the memory that they need, and the notes on them.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "base/input_files.h"
#include "options/options.h"
#include "exact/exact.h"
#include "run/run.h"

/* The receiver of this thread's notes: lines on input that is valid, but perhaps not meant. Zeros: none. */
struct cml_note_receiver {
    cml_note_function *to;
    void *context;
};
extern _Thread_local struct cml_note_receiver cml_notes;

/* A cml_note_function: hands one line to cml_notes. context: unused. */
void cml_show_note(void *context, const char *text);

/* Prints one line and hands it to cml_notes. A line of more than 1399 bytes is cut off. */
CML_PRINTF(1, 2) void cml_note(const char *format, ...);

/* Reads the first operand as a list of scenes, flat if the options say so, and checks that shapes do not
 * overlap. source NULL: files are read. CML_E_INPUT: *list is empty. */
CML_NODISCARD cml_status cml_load_scenes(const struct cml_options *options,
                                         const struct cml_text_source *source, struct cml_scene_list *list,
                                         struct cml_error *err);

/* Copies a scene with other settings and another name of the result (cml_mci_copy). inputs: the bytes that it
 * was read from. Checks for overlap if anything has moved. CML_E_INPUT: *scene is empty. */
CML_NODISCARD cml_status cml_copy_scene(const struct cml_options *options,
                                        const struct cml_settings *settings, const char *output,
                                        struct cml_inputs *inputs, const struct cml_scene *from,
                                        struct cml_scene *scene, struct cml_error *err);

/* Makes the surfaces that a scene is flown with: those of cml_surfaces_create; with --tolerance, those that
 * may be planes become planes. All commands that fly or show surfaces use these. The caller frees *surfaces;
 * empty on failure. */
CML_NODISCARD cml_status cml_choose_surfaces(const struct cml_options *options, const struct cml_scene *scene,
                                             struct cml_surface_set *surfaces, struct cml_error *err);

/* Bytes on this machine: the most that a run will hold at any time, the tallies in flight, writing the
 * results. surfaces NULL: they are not made yet, and their memory and facets do not count. */
struct cml_memory {
    double most, tallies, output;
};
struct cml_memory cml_memory_of(const struct cml_options *options, const struct cml_scene *scene,
                                const struct cml_surface_set *surfaces);

/* Fails with CML_E_INPUT, and the figures, if the run needs more memory than the machine has. */
CML_NODISCARD cml_status cml_check_memory(const struct cml_options *options, const struct cml_scene *scene,
                                          const struct cml_surface_set *surfaces, struct cml_error *err);

/* Multiplications, some 0.15 s of them, that commands spend on totals by adding-doubling beside other work.
 */
#define CML_EXACT_LITTLE_WORK 1e9

/* Walks at each rough boundary, some 0.05 s of them, for totals by adding-doubling with errors of some 5e-4.
 */
#define CML_EXACT_FEW_WALKS 32768
