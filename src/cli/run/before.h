/* What a run finds on the disk before it flies. SPDX-License-Identifier: MIT */
#pragma once

#include "cli/options/options.h"
#include "output/report.h"
#include "run/run.h"

struct cml_before {
    char *there, *gone; /* the first of its files that is there, and the first that is not as a run left it;
                           NULL: none */
    const char *how;    /* the latter is not: "is gone" */
    bool stands;        /* without a checkpoint: the result that is there says to be of this run */
};

/* On rank 0, of a run with its identity and surfaces; row: of a sweep, from 1, or 0. *before is the caller's
 * to clear, also on failure. CML_E_INPUT: --no-clobber keeps what is there. */
CML_NODISCARD cml_status cml_before_look(const struct cml_options *options, const struct cml_run_setup *setup,
                                         int row, struct cml_before *before, struct cml_error *err);
void cml_before_clear(struct cml_before *before);

/* On rank 0, when the run begins to fly: a checkpoint that is overwritten or missing, a result that is
 * replaced, beams without photons. */
void cml_before_note(const struct cml_options *options, const struct cml_run_setup *setup, int row,
                     const struct cml_before *before);

/* What the options of a run ask of its files. */
struct cml_report_asks cml_report_asks_of(const struct cml_run_setup *setup);

/* Whether there is a checkpoint, or the one before it. */
bool cml_has_checkpoint(const char *path);

/* Refuses with --resume, unless --replace is given, to replace a result of another run that has more photons:
 * it took longer to fly. photons: of the new one. *found: of the old one; 0: there is none, or nothing of
 * ours. */
CML_NODISCARD cml_status cml_before_keep_better(const struct cml_options *options, const char *path,
                                                uint64_t photons, uint64_t *found, struct cml_error *err);

/* Refuses with --no-clobber a file that is there. */
CML_NODISCARD cml_status cml_keep(const char *path, struct cml_error *err);

/* Whether there is a file that will be replaced, and the text of a note: of a result with its number of
 * photons, as they cost time. */
enum { CML_REPLACED = 512 };
bool cml_describe_replaced(const char *path, char text[CML_REPLACED]);
