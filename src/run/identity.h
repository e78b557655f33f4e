/* What the bits of a result depend on, as lines of text: program, options, photons, the bytes of all input
 * files. Two runs with the same identity give the same tallies, whatever their threads and ranks; where two
 * differ, the first line that does says why. SPDX-License-Identifier: MIT */
#pragma once

#include "base/input_files.h"
#include "result/provenance.h"
#include "run/run.h"

/* The lines for the input files: name without directories, size and checksum. *text is the caller's to free.
 */
CML_NODISCARD cml_status cml_identity_inputs(const struct cml_inputs *inputs, char **text,
                                             struct cml_error *err);

/* The provenance of a run as it is set up; flat: shapes are ignored. The one place that knows where the
 * options of the table stand. */
struct cml_provenance cml_run_provenance(const struct cml_run_setup *setup,
                                         const struct cml_surface_options *surface, bool flat);

/* settings: those of the scene, NULL: none; inputs: the lines of cml_identity_inputs. *identity is the
 * caller's to free. */
CML_NODISCARD cml_status cml_identity_of(const struct cml_provenance *provenance, const char *settings,
                                         const char *inputs, char **identity, struct cml_error *err);

/* Two checksums of it in 16 hexadecimal digits, by which a result says of which run it is. */
void cml_identity_sum(const char *identity, char sum[CML_IDENTITY_SUM]);
