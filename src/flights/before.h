/* The files that a run finds on the disk before it flies. SPDX-License-Identifier: MIT */
#pragma once

#include "options/options.h"
#include "output/report.h"
#include "run/run.h"

/* Returns the path of a scene's output in *path: `name` below the folder of -o, unless it is absolute. The
 * caller frees *path.
 */
CML_NODISCARD cml_status cml_output_path(const struct cml_options *options, const char *name, char **path,
                                         struct cml_error *err);

struct cml_before {
    /* First file of the run that exists; first file that is not as a run left it. NULL: none. */
    char *there, *gone;
    const char *how; /* fault of the file `gone`: "is gone" ... */
    bool stands;     /* without a checkpoint: the existing result is that of this run */
};

/* Looks for the files of a run, whose identity and surfaces are known. On rank 0. row: row of a sweep, from
 * 1; 0: no sweep. The caller clears *before, also on failure. CML_E_INPUT: --no-clobber keeps a file. */
CML_NODISCARD cml_status cml_before_look(const struct cml_options *options, const struct cml_run_setup *setup,
                                         int row, struct cml_before *before, struct cml_error *err);
void cml_before_clear(struct cml_before *before);

/* Shows notes when the run begins to fly: a checkpoint that is overwritten or missing, a result that is
 * replaced, beams without photons. On rank 0. */
void cml_before_note(const struct cml_options *options, const struct cml_run_setup *setup, int row,
                     const struct cml_before *before);

/* Returns the options of a run that its files depend on. */
struct cml_report_asks cml_report_asks_of(const struct cml_run_setup *setup);

/* True if there is a checkpoint, or its older version. */
bool cml_has_checkpoint(const char *path);

/* Refuses with --resume but without --replace to replace a result of another run that has more photons,
 * because it took longer to fly. photons: of the new result. */
CML_NODISCARD cml_status cml_before_keep_better(const struct cml_options *options, const char *path,
                                                uint64_t photons, struct cml_error *err);

/* Refuses with --no-clobber to replace an existing file. */
CML_NODISCARD cml_status cml_keep(const char *path, struct cml_error *err);

/* True if a file exists and will be replaced; writes the text of a note. The note has the result's photons,
 * because they cost time. */
enum { CML_REPLACED = 512 };
bool cml_describe_replaced(const char *path, char text[CML_REPLACED]);
