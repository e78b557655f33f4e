/* Joins the parts of one run (run --part K/N). Tallies are integers, so the result has the same bytes as one
 * run. SPDX-License-Identifier: MIT */
#pragma once

#include "run/run.h"

/* The file of one part. */
struct cml_part_file {
    const char *path; /* path of the file; borrowed */
    struct cml_checkpoint_about about;
    char *identity, *call; /* identity and command line of the run; owned */
    bool joined;
};

struct cml_part_files {
    int count;
    struct cml_part_file *file; /* [count] the files; owned */
    bool looking;               /* parts are only read and checked; runs write nothing */
};

/* Reads the heads of the files of parts. Files that end in .lock, .old or .tmp are skipped. CML_E_INPUT, with
 * the name: no file is left, or one is not the file of a part. The caller clears *files, also on failure. */
CML_NODISCARD cml_status cml_part_files_read(char *const *path, int count, struct cml_part_files *files,
                                             struct cml_error *err);
void cml_part_files_clear(struct cml_part_files *files);

/* True while parts are only read and checked. files NULL: false, nothing is joined. */
static inline bool cml_part_files_looking(const struct cml_part_files *files)
{
    return files && files->looking;
}

/* Ends the check of the parts of all runs and returns `status`. CML_E_INPUT with the name of a file that
 * belongs to no run. */
CML_NODISCARD cml_status cml_part_files_looked(struct cml_part_files *files, cml_status status,
                                               struct cml_error *err);

/* Adds up the parts of a run, in place of cml_run. Where setup->base > 0, adds the finished run that the
 * parts extend, too. Not collective. alone: all files must be of this run. CML_E_INPUT: a part is missing,
 * doubled, not finished or of another run; the message names it. *out is as that of cml_run. */
CML_NODISCARD cml_status cml_run_join(const struct cml_run_setup *setup, struct cml_part_files *files,
                                      bool alone, struct cml_run_result *out, struct cml_error *err);
