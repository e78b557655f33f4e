/* The files that a call of `run` or `merge` will write: they are claimed before the first packet flies, and
 * held until the last is written. SPDX-License-Identifier: MIT */
#pragma once

#include "base/file_lock.h"
#include "base/input_files.h"
#include "options/options.h"

/* The kinds of files of a run: the main result, files beside it, and the checkpoint. */
enum cml_output_kind { CML_OUTPUT_MAIN, CML_OUTPUT_BESIDE, CML_OUTPUT_CHECKPOINT };

struct cml_output_file {
    char *name; /* without links and dots, so that equal names mean equal files */
    int run;    /* run of the file, from 0 */
    enum cml_output_kind kind;
};

/* All files that one call of the program has claimed. A struct of zeros claims nothing. */
struct cml_outputs {
    size_t count;
    struct cml_output_file *file; /* [count] all files of all runs */
    bool of_part;                 /* a part of a run: only its own file is written */
    const char *made;             /* folder of -o if it was made here, borrowed; NULL: it existed */
    size_t num_locks;
    struct cml_file_lock *lock; /* [num_locks] one for each stem, "STEM.lock" */
};

/* Claims the files of all runs in the folder of -o, and makes the folder if needed. Every file can then be
 * written, none is an input or a file of another run, and no other process writes files of the first
 * num_locks runs. inputs: the files that were read. CML_E_INPUT: a name is unusable,
 * or --no-clobber keeps a result. CML_E_IO: a file cannot be written, or is locked. On failure nothing is
 * claimed. */
CML_NODISCARD cml_status cml_outputs_claim(const struct cml_options *options,
                                           const struct cml_scene_list *list, int num_locks,
                                           const struct cml_inputs *inputs, struct cml_outputs *outputs,
                                           struct cml_error *err);

/* Releases all files, and removes the folder that was made here if it is still empty (rmdir refuses others).
 */
void cml_outputs_release(struct cml_outputs *outputs);
