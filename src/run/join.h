/* Parts of one run (run --part), joined: sums of integers, so the result has the bytes of one run.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "run/run.h"

/* The file of a part. */
struct cml_part_file {
    const char *path; /* borrowed */
    struct cml_checkpoint_about about;
    char *identity, *call; /* of the run; owned */
    bool joined;
};

struct cml_part_files {
    int count;
    struct cml_part_file *file; /* [count] owned */
    bool looking;               /* runs read their parts, and write nothing */
};

/* Reads whose parts the files are. Files that end in .lock, .old or .tmp are passed over. CML_E_INPUT: no
 * file is left, or one of them is no part, with its name. The caller clears *files, also on failure. */
CML_NODISCARD cml_status cml_part_files_read(char *const *path, int count, struct cml_part_files *files,
                                             struct cml_error *err);
void cml_part_files_clear(struct cml_part_files *files);

/* files NULL: nothing is joined. */
static inline bool cml_part_files_looking(const struct cml_part_files *files)
{
    return files && files->looking;
}

/* Ends the look at the parts of all runs, which came to `status`. CML_E_INPUT with the name of a file that no
 * run has joined. */
CML_NODISCARD cml_status cml_part_files_looked(struct cml_part_files *files, cml_status status,
                                               struct cml_error *err);

/* Adds up the parts of a run in place of cml_run, with the run that setup->base is of where there is one. Not
 * collective. alone: the files are of this run only. CML_E_INPUT: a part is missing, there twice, not
 * finished or of another run; the message names it. *out is as that of cml_run. */
CML_NODISCARD cml_status cml_run_join(const struct cml_run_setup *setup, struct cml_part_files *files,
                                      bool alone, struct cml_run_result *out, struct cml_error *err);
