/* Writes original MCML's result file.
 *
 *     A1 ... InParm ... RAT ... Tt_ra     byte for byte as MCML 1.2.2 writes it
 *     # ...                               the program, options that decided the bits, the scene in words
 *     se_..., lattice, books, residue,    standard errors of MCML's numbers, the balance of the weight
 *     lost                                and lost packets: keywords that no section of MCML begins with
 *
 * All other results of a run stand in its .h5 file (h5.h). Layout: MCML manual (Wang and Jacques 1992),
 * section 9.3, and version 1.2.2 itself; scaling.h explains how the numbers are computed.
 * SPDX-License-Identifier: MIT */
#pragma once

#include "result/outcome.h"

/* The first line of every .mco, of original MCML too. */
#define CML_MCO_FIRST_LINE "A1 \t# Version number of the file format.\n"

/* Writes an .mco file atomically (atomic_file.h). CML_E_IO on failure. The time is rounded to whole seconds,
 * as in the original. Sections beyond MCML's are written only if `program` is set; they do not depend on
 * time, threads, ranks or the machine. */
CML_NODISCARD cml_status cml_mco_write(const char *path, const struct cml_outcome *outcome,
                                       struct cml_error *err);
