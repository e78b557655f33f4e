/* The files that a call of `run` or `merge` will write: claimed before the first packet flies, held until the
 * last is written. SPDX-License-Identifier: MIT */
#pragma once

#include "base/file_lock.h"
#include "base/input_files.h"
#include "cli/options/options.h"

/* What a run leaves: the file that the input file names, those beside it, and what it needs to go on. */
enum cml_output_kind { CML_OUTPUT_MAIN, CML_OUTPUT_BESIDE, CML_OUTPUT_CHECKPOINT };

struct cml_output_file {
    char *name; /* without links and dots, so that equal names are equal files */
    int run;    /* of the file, from 0 */
    enum cml_output_kind kind;
};

/* Zeroed: nothing is claimed. */
struct cml_outputs {
    size_t count;
    struct cml_output_file *file; /* [count] */
    bool of_part;                 /* of a part of a run: only its own file is written */
    const char *made;             /* the folder of -o where it was not there; borrowed; NULL: it was */
    size_t num_locks;
    struct cml_file_lock *lock; /* [num_locks] one for each stem, "STEM.lock" */
};

/* Claims all files of all runs, in the folder of -o, which is made where it is not there: they can be
 * written, none of them is an input or that of another run, and no other process writes those of the first
 * num_locks runs. `inputs`: what was read. CML_E_INPUT: a name that cannot be meant, a result that
 * --no-clobber keeps; CML_E_IO: a file that cannot be written or is locked. On failure nothing is held. Notes
 * go to `note`. */
CML_NODISCARD cml_status cml_outputs_claim(const struct cml_options *options,
                                           const struct cml_scene_list *list, int num_locks,
                                           const struct cml_inputs *inputs,
                                           void (*note)(void *context, const char *text),
                                           struct cml_outputs *outputs, struct cml_error *err);

/* A folder that was made here goes where it is still empty. */
void cml_outputs_release(struct cml_outputs *outputs);
