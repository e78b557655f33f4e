/* Original MCML's result file: the writer.
 * Lines 1 to the end of Tt_ra are byte for byte what MCML 1.2.2 writes. Lines that begin with '#' follow (the
 * program, what decided the bits, the scene in words), then sections whose keywords no section of MCML begins
 * with: the standard errors of MCML's numbers, `lattice`, `books`, `residue` and `lost`. All other results of
 * a run stand in its .h5 file (h5.h). Layout: MCML manual (Wang and Jacques 1992), section 9.3, and observed
 * on version 1.2.2; scaling.h says how its numbers come about. SPDX-License-Identifier: MIT */
#pragma once

#include "result/outcome.h"

/* Begins every .mco, those of original MCML, too. */
#define CML_MCO_FIRST_LINE "A1 \t# Version number of the file format.\n"

/* Writes to `path` atomically (atomic_file.h). CML_E_IO on failure. The time is rounded to whole seconds, as
 * in the original. What is ours only where `program` is set; nothing in it depends on time, threads, ranks or
 * the machine. */
CML_NODISCARD cml_status cml_mco_write(const char *path, const struct cml_outcome *outcome,
                                       struct cml_error *err);
